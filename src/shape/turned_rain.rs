//! G6: random rain of turned cubes (Sajjadi & Khalili 2015).
//!
//! Cubes of random size and orientation (uniform on SO(3)) fall, one after
//! another, at random places of a disc until they touch a cube that is there,
//! and sink into it by `sink` of their edge so that the two have a common
//! volume. The height of first contact is exact: cubes are disjoint where their
//! projections on one of 15 axes are (separating axes, Gottschalk, Lin &
//! Manocha 1996), on each axis the condition is linear in the height, so the
//! heights at which two cubes overlap are one interval. A cube that would miss
//! all others is thrown again, so that the volume is one piece. The cubes are
//! united by boolean operations; all are in general position.
//! Cost O(cubes²) for contacts, O(cubes log cubes) boolean operations.

use super::draw::{Draw, Drawn, Fact, ordered, ordered_whole};
use crate::geometry::{GeometryError, Posed, Primitive, union};
use crate::num::random::{self, Stream};
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rain of cubes that are turned at random.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TurnedRainParameters {
    /// Least and largest number of cubes, each from 1 to 500; default [10, 20].
    pub cubes: [u32; 2],
    /// Least and largest edge, relative to each other; from 1e-3 to 1e3, ratio at most 20; default [0.8, 1.2].
    pub edge: [f64; 2],
    /// Radius of the disc that they fall on, over the largest edge; from 0 to 20; default 1.
    pub spread: f64,
    /// Depth that a cube sinks in over its edge, from 0.01 to 0.9; default 0.15.
    pub sink: f64,
}

impl Default for TurnedRainParameters {
    fn default() -> Self {
        Self { cubes: [10, 20], edge: [0.8, 1.2], spread: 1.0, sink: 0.15 }
    }
}

/// Throws of one cube before it is dropped where it hits nothing.
const THROWS: u32 = 1000;

impl Draw for TurnedRainParameters {
    fn validate(&self) -> Result<(), Fault> {
        ordered_whole("cubes", self.cubes, 1, 500)?;
        let [small, _] = self.edge;
        ordered("edge", self.edge, 1e-3, 1e3f64.min(20.0 * small.max(1e-3)))?;
        Fault::within("spread", self.spread, 0.0, 20.0)?;
        Fault::within("sink", self.sink, 0.01, 0.9)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let count = random::whole(stream, u64::from(self.cubes[0]), u64::from(self.cubes[1]));
        let mut cubes: Vec<Posed> = Vec::new();
        let mut missed = 0;
        for _ in 0..count {
            for _ in 0..THROWS {
                let mut cube = self.thrown(stream);
                if !cubes.is_empty() {
                    let tops = cubes.iter().filter_map(|other| highest_contact(other, &cube));
                    let Some(top) = tops.reduce(f64::max) else {
                        missed += 1;
                        continue;
                    };
                    cube.centre.z = top - self.sink * edge(&cube);
                }
                cubes.push(cube);
                break;
            }
        }
        let parts: Vec<_> = cubes.iter().map(|cube| cube.mesh(4)).collect();
        let (mesh, cavities) = union::unite_filled(&parts)?;
        Ok(Drawn {
            mesh,
            recipe: format!(
                "rain of {} turned cubes, {missed} throws missed, {cavities} cavities filled",
                cubes.len()
            ),
            facts: vec![Fact::asked("cubes", count as f64, cubes.len() as f64)],
        })
    }
}

impl TurnedRainParameters {
    /// A cube above a random place of the disc.
    fn thrown(&self, stream: &mut Stream) -> Posed {
        let edge = random::uniform(stream, self.edge[0], self.edge[1]);
        let radius = self.spread * self.edge[1] * random::uniform(stream, 0.0, 1.0).sqrt();
        let angle = random::uniform(stream, 0.0, std::f64::consts::TAU);
        Posed {
            primitive: Primitive::Box { edges: Vec3::repeat(edge) },
            rotation: random::rotation(stream),
            centre: Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0),
        }
    }
}

fn edge(cube: &Posed) -> f64 {
    match cube.primitive {
        Primitive::Box { edges } => edges.x,
        _ => 0.0,
    }
}

/// The largest height of the centre of `falling` at which it meets `lying`; `None` if at no height.
fn highest_contact(lying: &Posed, falling: &Posed) -> Option<f64> {
    let axes = |cube: &Posed| [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| cube.rotation * axis);
    let (a, b) = (axes(lying), axes(falling));
    let crosses = a.iter().flat_map(|u| b.iter().map(move |v| u.cross(v)));
    let reach = |axes: &[Vec3; 3], half: f64, along: &Vec3| -> f64 {
        axes.iter().map(|axis| half * axis.dot(along).abs()).sum()
    };
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in a.into_iter().chain(b).chain(crosses) {
        // Nearly parallel edges give no axis of their own.
        if axis.norm_squared() < 1e-12 {
            continue;
        }
        let reach = reach(&a, 0.5 * edge(lying), &axis) + reach(&b, 0.5 * edge(falling), &axis);
        let across = falling.centre - lying.centre;
        let level = axis.x * across.x + axis.y * across.y;
        // |level + axis.z · (height − lying.z)| ≤ reach.
        if axis.z.abs() < 1e-12 {
            if level.abs() > reach {
                return None;
            }
            continue;
        }
        let ends = [(-reach - level) / axis.z, (reach - level) / axis.z];
        low = low.max(ends[0].min(ends[1]));
        high = high.min(ends[0].max(ends[1]));
    }
    (low <= high).then_some(high + lying.centre.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::topology::inspect;
    use crate::num::Rotation;

    fn cube(rotation: Rotation, centre: Vec3) -> Posed {
        Posed { primitive: Primitive::Box { edges: Vec3::repeat(1.0) }, rotation, centre }
    }

    #[test]
    fn contact_heights_have_their_closed_forms() {
        let flat = cube(Rotation::identity(), Vec3::new(0.0, 0.0, 3.0));
        let above = cube(Rotation::identity(), Vec3::new(0.4, 0.2, 0.0));
        assert!((highest_contact(&flat, &above).expect("beneath") - 4.0).abs() < 1e-12);
        assert!(highest_contact(&flat, &cube(Rotation::identity(), Vec3::x() * 1.1)).is_none());
        // On its edge above a face: half a diagonal.
        let eighth = Rotation::from_axis_angle(&Vec3::y_axis(), std::f64::consts::FRAC_PI_4);
        let standing = cube(eighth, Vec3::zeros());
        let height = highest_contact(&flat, &standing).expect("beneath");
        assert!((height - (3.5 + 0.5f64.sqrt())).abs() < 1e-12, "{height}");
    }

    #[test]
    fn above_the_contact_cubes_are_apart_and_below_they_overlap() {
        let mut stream = random::stream(7, "turned", 0);
        for _ in 0..50 {
            let lying = cube(random::rotation(&mut stream), Vec3::zeros());
            let mut falling =
                cube(random::rotation(&mut stream), random::direction(&mut stream) * 0.5);
            let Some(height) = highest_contact(&lying, &falling) else { continue };
            let volume = |z: f64, cube: &mut Posed| {
                cube.centre.z = z;
                union::unite(&[lying.mesh(4), cube.mesh(4)]).map(|m| m.mass_properties().volume)
            };
            assert!(volume(height + 1e-6, &mut falling).is_err(), "apart");
            let sunk = volume(height - 0.1, &mut falling).expect("overlap");
            assert!(sunk < 2.0 - 1e-9, "{sunk}");
        }
    }

    #[test]
    fn rain_is_one_piece() {
        for index in 0..4 {
            let drawn = TurnedRainParameters::default()
                .draw(&mut random::stream(2, "turned", index))
                .expect("a union");
            let report = inspect(&drawn.mesh);
            assert!(report.is_closed() && report.pieces == 1, "{report:?}");
            assert_eq!(drawn.facts[0].asked, Some(drawn.facts[0].measured));
        }
    }
}
