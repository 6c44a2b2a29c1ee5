//! G1 and G2: the union of random base solids (Sajjadi & Khalili 2015, first
//! method; families by limits on kinds and dimensions).
//!
//! M base solids are drawn. Each has a random kind, random dimensions, and a
//! work plane through the origin at a random angle (uniform on SO(3)) on which
//! it stands: its axis runs through the origin, its centre is lifted above the
//! plane by `lift` half heights. With lift < 1 the origin lies inside every
//! base solid, so all overlap, and the union is one piece without handles
//! (star-shaped about the origin). Cost: M boolean operations, a few ms each.
//! What cannot be finished: a union that fails the gate after rounding to
//! single precision is drawn again by the caller.

use super::draw::{Draw, Drawn};
use crate::geometry::{GeometryError, Mesh, Posed, Primitive, union};
use crate::num::random::{self, Stream};
use crate::num::{Fault, Rotation, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kinds of base solids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Rectangular box, three dimensions.
    Box,
    /// Circular cylinder: diameter and height.
    Cylinder,
    /// Circular cone: diameter and height.
    Cone,
    /// Ellipsoid, three axes.
    Ellipsoid,
    /// Sphere.
    Sphere,
}

/// Families of base solids.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// All kinds.
    #[default]
    Any,
    /// Ellipsoids and spheres.
    Smooth,
    /// Boxes, cylinders and cones.
    Sharp,
}

impl Family {
    fn kinds(self) -> &'static [Kind] {
        match self {
            Self::Any => &[Kind::Box, Kind::Cylinder, Kind::Cone, Kind::Ellipsoid, Kind::Sphere],
            Self::Smooth => &[Kind::Ellipsoid, Kind::Sphere],
            Self::Sharp => &[Kind::Box, Kind::Cylinder, Kind::Cone],
        }
    }
}

/// How base solids are turned.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Turns {
    /// Uniform on all rotations.
    #[default]
    Any,
    /// Axes along x, y, z (one of the 24 rotations of a cube), then by 2e-4 rad at random.
    Quarter,
}

/// Union of random base solids.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnionParameters {
    /// Least and largest number of base solids, each from 1 to 50; default [3, 6].
    #[serde(default = "default_solids")]
    pub solids: [u32; 2],
    /// Kinds to draw from, each as often as it is listed; instead of `family`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kinds: Vec<Kind>,
    /// Kinds to draw from: any, smooth (ellipsoids, spheres) or sharp (boxes,
    /// cylinders, cones); default any.
    #[serde(default)]
    pub family: Family,
    /// Least and largest dimension (edge, diameter, height, full axis) of a base
    /// solid, relative to each other since the grain is scaled to its size; in
    /// metres where no size is asked for. From 1e-3 to 1e3, ratio at most 100;
    /// default [0.5, 1.5].
    #[serde(default = "default_dimensions")]
    pub dimensions: [f64; 2],
    /// Least and largest height of the middle of a base solid above its work
    /// plane, in half heights: 0 is centred on the plane. From 0 to 0.9;
    /// default [0, 0.8].
    #[serde(default = "default_lift")]
    pub lift: [f64; 2],
    /// `any` (default): random angles; `quarter`: axes along x, y, z. Faces that would
    /// then lie in one plane are parted by turning each solid by 2e-4 rad at random.
    #[serde(default)]
    pub turns: Turns,
    /// Step that dimensions are rounded to (at least one step), 0 for none; from 0 to
    /// the smallest dimension; default 0. With `quarter` turns it makes solids that share faces.
    #[serde(default)]
    pub step: f64,
    /// Pieces that round solids have in a turn, from 6 to 200; default 32.
    #[serde(default = "default_segments")]
    pub segments: u32,
}

fn default_solids() -> [u32; 2] {
    [3, 6]
}

fn default_dimensions() -> [f64; 2] {
    [0.5, 1.5]
}

fn default_lift() -> [f64; 2] {
    [0.0, 0.8]
}

fn default_segments() -> u32 {
    32
}

impl Default for UnionParameters {
    fn default() -> Self {
        Self {
            solids: default_solids(),
            kinds: Vec::new(),
            family: Family::Any,
            dimensions: default_dimensions(),
            lift: default_lift(),
            turns: Turns::Any,
            step: 0.0,
            segments: default_segments(),
        }
    }
}

impl Draw for UnionParameters {
    fn validate(&self) -> Result<(), Fault> {
        let [few, many] = self.solids.map(f64::from);
        Fault::within("solids[0]", few, 1.0, 50.0)?;
        Fault::within("solids[1]", many, few, 50.0)?;
        if !self.kinds.is_empty() && self.family != Family::Any {
            return Err(Fault::new("kinds", "is given together with `family`", "one of the two"));
        }
        let [small, large] = self.dimensions;
        Fault::within("dimensions[0]", small, 1e-3, 1e3)?;
        Fault::within("dimensions[1]", large, small, 1e3f64.min(100.0 * small))?;
        let [low, high] = self.lift;
        Fault::within("lift[0]", low, 0.0, 0.9)?;
        Fault::within("lift[1]", high, low, 0.9)?;
        Fault::within("step", self.step, 0.0, small)?;
        Fault::within("segments", f64::from(self.segments), 6.0, 200.0)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let solids = draw(self, stream);
        let mesh = unite(&solids, self.segments)?;
        Ok(Drawn { mesh, recipe: describe(&solids), facts: Vec::new() })
    }
}

/// Draws the base solids of one grain.
pub fn draw(parameters: &UnionParameters, stream: &mut Stream) -> Vec<Posed> {
    let [few, many] = parameters.solids;
    let kinds = match parameters.kinds[..] {
        [] => parameters.family.kinds(),
        ref kinds => kinds,
    };
    (0..random::whole(stream, u64::from(few), u64::from(many)))
        .map(|_| {
            let kind = kinds[random::whole(stream, 0, kinds.len() as u64 - 1) as usize];
            let [small, large] = parameters.dimensions;
            // Three numbers are drawn for every kind, so that the stream stays in step.
            let sides = Vec3::from_fn(|_, _| {
                let side = random::uniform(stream, small, large);
                if parameters.step > 0.0 {
                    (side / parameters.step).round().max(1.0) * parameters.step
                } else {
                    side
                }
            });
            let primitive = match kind {
                Kind::Box => Primitive::Box { edges: sides },
                Kind::Cylinder => Primitive::Cylinder { diameter: sides.x, height: sides.z },
                Kind::Cone => Primitive::Cone { diameter: sides.x, height: sides.z },
                Kind::Ellipsoid => Primitive::Ellipsoid { axes: sides },
                Kind::Sphere => Primitive::Sphere { diameter: sides.z },
            };
            let lift = random::uniform(stream, parameters.lift[0], parameters.lift[1]);
            let rotation = match parameters.turns {
                Turns::Any => random::rotation(stream),
                Turns::Quarter => quarter(stream),
            };
            let centre = rotation * Vec3::new(0.0, 0.0, 0.5 * sides.z * lift);
            Posed { primitive, rotation, centre }
        })
        .collect()
}

/// Angle that parts faces in one plane, rad.
const PARTED: f64 = 2e-4;

/// One of the 24 rotations of a cube, then a turn of 2e-4 rad about a random axis: the
/// boolean kernel has no sure order for faces that lie exactly in one plane,
/// and solids turned a little have none. The union is off by that much.
fn quarter(stream: &mut Stream) -> Rotation {
    let turn = |axis: nalgebra::Unit<Vec3>, quarters: u64| {
        Rotation::from_axis_angle(&axis, std::f64::consts::FRAC_PI_2 * quarters as f64)
    };
    let spin = turn(Vec3::z_axis(), random::whole(stream, 0, 3));
    let up = match random::whole(stream, 0, 5) {
        4 => turn(Vec3::y_axis(), 1),
        5 => turn(Vec3::y_axis(), 3),
        quarters => turn(Vec3::x_axis(), quarters),
    };
    Rotation::from_scaled_axis(random::direction(stream) * PARTED) * up * spin
}

/// The union of `solids`, round ones in `segments` pieces a turn.
pub fn unite(solids: &[Posed], segments: u32) -> Result<Mesh, GeometryError> {
    let meshes: Vec<Mesh> = solids.iter().map(|solid| solid.mesh(segments)).collect();
    union::unite(&meshes)
}

/// Kinds and dimensions in one line for people.
pub fn describe(solids: &[Posed]) -> String {
    let said: Vec<String> = solids
        .iter()
        .map(|solid| match solid.primitive {
            Primitive::Box { edges: e } => format!("box {:.3} x {:.3} x {:.3}", e.x, e.y, e.z),
            Primitive::Cylinder { diameter, height } => {
                format!("cylinder {diameter:.3} x {height:.3}")
            }
            Primitive::Cone { diameter, height } => format!("cone {diameter:.3} x {height:.3}"),
            Primitive::Ellipsoid { axes: a } => {
                format!("ellipsoid {:.3} x {:.3} x {:.3}", a.x, a.y, a.z)
            }
            Primitive::Sphere { diameter } => format!("sphere {diameter:.3}"),
        })
        .collect();
    format!("union of {}", said.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::topology::inspect;

    /// Volume of the union of boxes about the origin with edges along the axes,
    /// cell by cell between all their faces.
    fn exact(boxes: &[Vec3]) -> f64 {
        let cuts: Vec<Vec<f64>> = (0..3)
            .map(|axis| {
                let mut cuts: Vec<f64> =
                    boxes.iter().flat_map(|b| [-0.5 * b[axis], 0.5 * b[axis]]).collect();
                cuts.sort_by(f64::total_cmp);
                cuts.dedup();
                cuts
            })
            .collect();
        let mut sum = 0.0;
        for x in cuts[0].windows(2) {
            for y in cuts[1].windows(2) {
                for z in cuts[2].windows(2) {
                    let middle = Vec3::new(x[0] + x[1], y[0] + y[1], z[0] + z[1]) * 0.5;
                    if boxes.iter().any(|b| (0..3).all(|k| 2.0 * middle[k].abs() < b[k])) {
                        sum += (x[1] - x[0]) * (y[1] - y[0]) * (z[1] - z[0]);
                    }
                }
            }
        }
        sum
    }

    #[test]
    fn boxes_that_share_faces_have_the_exact_volume_and_the_same_bytes() {
        let parameters = UnionParameters {
            kinds: vec![Kind::Box],
            solids: [2, 8],
            dimensions: [0.5, 1.5],
            lift: [0.0, 0.0],
            turns: Turns::Quarter,
            step: 0.25,
            ..Default::default()
        };
        parameters.validate().expect("in their ranges");
        for index in 0..25 {
            let mut stream = random::stream(3, "shared faces", index);
            let solids = draw(&parameters, &mut stream);
            let boxes: Vec<Vec3> = solids
                .iter()
                .map(|solid| {
                    let Primitive::Box { edges } = solid.primitive else { panic!("boxes only") };
                    let turned = solid.rotation.to_rotation_matrix().matrix().abs() * edges;
                    turned.map(|x| (x / 0.25).round() * 0.25)
                })
                .collect();
            let mesh = unite(&solids, 8).expect("a union");
            let report = inspect(&mesh);
            assert!(report.is_closed() && report.pieces == 1, "{index}: {report:?}");
            let expected = exact(&boxes);
            assert!((report.volume / expected - 1.0).abs() < 1e-3, "{index}: {}", report.volume);
            assert_eq!(mesh, unite(&solids, 8).expect("as before"), "{index}");
        }
    }
}
