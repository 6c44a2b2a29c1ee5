//! Bodies one by one where the user wants them: collisions of two spheres,
//! a ball on a slope, small scenes for tests.
//!
//! Overlaps up to a tenth of the smaller radius are accepted (a scene may start in contact);
//! larger ones, between bodies or with walls, are refused. Sides without a wall
//! do not count. Cost O(spheres).

use super::measure::with_images;
use super::occupied::world_balls;
use super::{Grain, Laid, Placement, tally};
use crate::geometry::Region;
use crate::geometry::grid::near_pairs;
use crate::num::units::{Angle, Length, Speed, Spin};
use crate::num::{Fault, Rotation, Vec3};
use nalgebra::{Quaternion, Unit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bodies given one by one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Placed {
    /// The bodies.
    pub bodies: Vec<PlacedBody>,
}

/// One body: `grain` or `family`, and where it is.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PlacedBody {
    /// Number of a grain of the scene, from 0; several bodies may be copies of one grain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grain: Option<u32>,
    /// Name of a family, in place of `grain`: the next grain of it that no body has yet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub family: Option<String>,
    /// Centre of mass, m: 3 numbers, 2 in two dimensions; required.
    pub position: Vec<Length>,
    /// How the solid, as it lies in its own file, is turned into the world frame; default not at all.
    pub orientation: Orientation,
    /// Velocity, m/s: 3 numbers, or 2 in two dimensions; default 0.
    pub velocity: Vec<Speed>,
    /// Angular velocity, rad/s, in the world frame: 3 numbers, or 1 (about z) in two dimensions; default 0.
    pub spin: Vec<Spin>,
}

/// A rotation.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Orientation {
    /// Not turned.
    #[default]
    Identity,
    /// Turned about an axis.
    AxisAngle(AxisAngle),
    /// A quaternion w, x, y, z of any length but 0.
    Quaternion([f64; 4]),
}

/// A turn about an axis, right-handed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisAngle {
    /// Direction of the axis, any length but 0; z in two dimensions.
    #[serde(default = "along_z")]
    pub axis: [f64; 3],
    /// Angle, rad.
    pub angle: Angle,
}

fn along_z() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

/// Overlap over the smaller radius that is still accepted.
const ACCEPTED: f64 = 0.1;

impl Orientation {
    fn rotation(&self) -> Result<Rotation, Fault> {
        let wrong =
            |key, problem: String| Err(Fault::new(key, problem, "finite numbers, not all 0"));
        let usable = |length: f64| length.is_finite() && length > 0.0;
        match self {
            Self::Identity => Ok(Rotation::identity()),
            Self::AxisAngle(turn) => {
                let axis = Vec3::from(turn.axis);
                if !usable(axis.norm()) || !turn.angle.0.is_finite() {
                    return wrong("axis_angle", format!("is {axis:?} by {} rad", turn.angle.0));
                }
                Ok(Rotation::from_axis_angle(&Unit::new_normalize(axis), turn.angle.0))
            }
            Self::Quaternion([w, x, y, z]) => {
                let quaternion = Quaternion::new(*w, *x, *y, *z);
                if !usable(quaternion.norm()) {
                    return wrong("quaternion", format!("is {w}, {x}, {y}, {z}"));
                }
                Ok(Rotation::from_quaternion(quaternion))
            }
        }
    }
}

/// `values` as a vector in `dimension` dimensions; empty is 0.
fn vector(key: &str, values: &[f64], dimension: usize) -> Result<Vec3, Fault> {
    let right = values.is_empty() || values.len() == dimension || values.len() == 3;
    if !right || values.iter().any(|v| !v.is_finite()) {
        let problem = format!("is {values:?}");
        return Err(Fault::new(key, problem, format!("{dimension} finite numbers")));
    }
    let vector = Vec3::from_fn(|axis, _| values.get(axis).copied().unwrap_or(0.0));
    if dimension == 2 && vector.z != 0.0 {
        return Err(Fault::new(key, format!("has {} along z", vector.z), "0 in two dimensions"));
    }
    Ok(vector)
}

impl PlacedBody {
    /// A fault for values that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        if self.grain.is_some() == self.family.is_some() {
            let problem =
                if self.grain.is_some() { "stands beside `family`" } else { "is missing" };
            return Err(Fault::new("grain", problem, "one of `grain` and `family`"));
        }
        if !(2..=3).contains(&self.position.len()) {
            let problem = format!("has {} numbers", self.position.len());
            return Err(Fault::new("position", problem, "3 numbers, 2 in two dimensions"));
        }
        self.orientation.rotation().map(drop).map_err(|fault| fault.under("orientation"))
    }

    fn place(&self, grain: u32, what: &Grain, dimension: usize) -> Result<Placement, Fault> {
        let position: Vec<f64> = self.position.iter().map(|v| v.0).collect();
        let velocity: Vec<f64> = self.velocity.iter().map(|v| v.0).collect();
        let mut spin: Vec<f64> = self.spin.iter().map(|v| v.0).collect();
        if dimension == 2 && spin.len() == 1 {
            spin = vec![0.0, 0.0, spin[0]];
        }
        if !(spin.is_empty() || spin.len() == 3) {
            let allowed = "3 numbers, or 1 in two dimensions";
            return Err(Fault::new("spin", format!("has {} numbers", spin.len()), allowed));
        }
        let (spin, orientation) = (vector("spin", &spin, 3)?, self.orientation.rotation()?);
        let axis = orientation.imag();
        if dimension == 2 && (spin.x != 0.0 || spin.y != 0.0) {
            return Err(Fault::new("spin", "is not about z", "about z in two dimensions"));
        }
        if dimension == 2 && (axis.x != 0.0 || axis.y != 0.0) {
            return Err(Fault::new("orientation", "is not about z", "about z in two dimensions"));
        }
        Ok(Placement {
            grain,
            position: vector("position", &position, dimension)?,
            orientation: orientation * what.clump.axes,
            velocity: vector("velocity", &velocity, dimension)?,
            spin,
            scale: 1.0,
        })
    }
}

impl Placed {
    /// A fault for values that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        for (index, body) in self.bodies.iter().enumerate() {
            body.validate().map_err(|fault| fault.under(format!("bodies[{index}]")))?;
        }
        Ok(())
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        families: &[&str],
        region: &Region,
    ) -> Result<Laid, Fault> {
        let mut placements = Vec::with_capacity(self.bodies.len());
        let mut used = vec![false; grains.len()];
        for (index, body) in self.bodies.iter().enumerate() {
            let laid = choose(body, grains, families, &used)
                .and_then(|at| body.place(at, &grains[at as usize], region.dimension()))
                .map_err(|fault| fault.under(format!("placed.bodies[{index}]")))?;
            used[laid.grain as usize] = true;
            placements.push(laid);
        }
        accept(&placements, grains, region)?;
        let dropped: Vec<u32> = (0..grains.len() as u32).filter(|&g| !used[g as usize]).collect();
        let outcome = tally(grains, &placements, &dropped, "no body of the list takes them");
        Ok(Laid { placements, dropped, outcome })
    }
}

/// The grain that a body is made of.
fn choose(
    body: &PlacedBody,
    grains: &[Grain],
    families: &[&str],
    used: &[bool],
) -> Result<u32, Fault> {
    if let Some(grain) = body.grain {
        if (grain as usize) < grains.len() {
            return Ok(grain);
        }
        let allowed = format!("0 to {}", grains.len().saturating_sub(1));
        return Err(Fault::new("grain", format!("is {grain}"), allowed));
    }
    let name = body.family.as_deref().unwrap_or_default();
    let Some(family) = families.iter().position(|known| *known == name) else {
        let allowed = families.join(", ");
        return Err(Fault::new("family", format!("is `{name}`"), allowed));
    };
    let of_family = |index: &usize| usize::from(grains[*index].family) == family;
    let mut members = (0..grains.len()).filter(of_family);
    members.find(|&index| !used[index]).map(|index| index as u32).ok_or_else(|| {
        let count = (0..grains.len()).filter(of_family).count();
        let problem = format!("is `{name}`, whose {count} grains are all placed already");
        Fault::new("family", problem, "more grains in the family, or `grain` to place copies")
    })
}

/// A fault for the first body that overlaps a wall or an earlier body too much.
fn accept(placements: &[Placement], grains: &[Grain], region: &Region) -> Result<(), Fault> {
    let (mut centres, mut radii, mut body) = (Vec::new(), Vec::new(), Vec::new());
    let refused = |body: u32, what: String| {
        let allowed = "overlaps up to 10 % of the smaller radius";
        Fault::new(format!("placed.bodies[{body}].position"), what, allowed)
    };
    for (index, laid) in placements.iter().enumerate() {
        let at = (laid.position, laid.orientation);
        for ball in world_balls(&grains[laid.grain as usize].clump.balls, &at) {
            let depth = (ball.radius - region.wall_clearance(&ball.centre)) / ball.radius;
            if depth > ACCEPTED {
                let what = format!("overlaps a wall by {:.0} % of the radius", 100.0 * depth);
                return Err(refused(index as u32, what));
            }
            centres.push(ball.centre);
            radii.push(ball.radius);
            body.push(index as u32);
        }
    }
    if let Some(cell) = region.cell() {
        (centres, radii, body) = with_images(&centres, &radii, &body, &cell, 0.0);
    }
    let mut worst: Option<(u32, u32, f64)> = None;
    near_pairs(
        &centres,
        &radii,
        &body,
        || 0.0,
        |i, j, gap| {
            let depth = -gap / radii[i as usize].min(radii[j as usize]);
            let (i, j) = (body[i as usize], body[j as usize]);
            if depth > ACCEPTED && worst.is_none_or(|(_, _, worst)| depth > worst) {
                worst = Some((i.max(j), i.min(j), depth));
            }
        },
    );
    worst.map_or(Ok(()), |(later, earlier, depth)| {
        let percent = 100.0 * depth;
        Err(refused(
            later,
            format!("overlaps bodies[{earlier}] by {percent:.0} % of the smaller radius"),
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::super::samples::{clump, of, room, sphere};
    use super::super::{Method, PackError, Packing, pack};
    use super::*;
    use crate::clump::Clump;
    use crate::num::Job;

    fn lay(text: &str, grains: &[Grain], region: &Region) -> Result<Packing, PackError> {
        let method: Method = toml::from_str(text).expect("well formed");
        pack(grains, &["big", "small"], region, &method, 1, &Job::quiet())
    }

    fn key(text: &str, grains: &[Grain], region: &Region) -> String {
        match lay(text, grains, region) {
            Err(PackError::Wrong(fault)) => fault.key,
            other => panic!("{other:?}"),
        }
    }

    fn clumps() -> Vec<Clump> {
        vec![sphere(0.2, 3), sphere(0.1, 3), sphere(0.1, 3)]
    }

    fn families(clumps: &[Clump]) -> Vec<Grain<'_>> {
        let mut grains = of(clumps);
        grains.iter_mut().skip(1).for_each(|grain| grain.family = 1);
        grains
    }

    #[test]
    fn bodies_go_where_they_are_told() {
        let clumps = clumps();
        let text = r#"[placed]
            bodies = [
                { family = "small", position = ["50 cm", 0.5, 0.89], velocity = [0, 0, -1] },
                { grain = 0, position = [0.5, 0.5, 0.595], orientation = { axis_angle = { axis = [0, 0, 2], angle = "90 deg" } } },
                { family = "small", position = [0.2, 0.2, 0.2], orientation = { quaternion = [0, 2, 0, 0] }, spin = ["60 rpm", 0, 0] },
            ]"#;
        let packing = lay(text, &families(&clumps), &room(&[1.0; 3])).expect("accepted");
        let order: Vec<u32> = packing.placements.iter().map(|p| p.grain).collect();
        assert_eq!(order, [0, 1, 2]);
        assert!((packing.placements[0].orientation * Vec3::x() - Vec3::y()).norm() < 1e-15);
        assert_eq!(packing.placements[1].velocity, Vec3::new(0.0, 0.0, -1.0));
        assert!((packing.placements[2].spin.x - std::f64::consts::TAU).abs() < 1e-12);
        assert!((packing.placements[2].orientation * Vec3::y() + Vec3::y()).norm() < 1e-15);
        // Overlap 0.005 of 0.1: accepted, measured, and the porosity says it is sampled.
        assert!((packing.measures.worst_overlap - 0.05).abs() < 1e-12);
        assert!(packing.measures.porosity_error > 0.0);
        let exact = 1.0 - 4.0 / 3.0 * std::f64::consts::PI * (0.008 + 2.0 * 0.001);
        assert!((packing.measures.porosity - exact).abs() < 5.0 * packing.measures.porosity_error);
    }

    #[test]
    fn the_solid_is_turned_from_its_own_frame() {
        let mut turned =
            clump(vec![crate::geometry::Ball { centre: Vec3::zeros(), radius: 0.1 }], 1e-3);
        turned.axes = Rotation::from_axis_angle(&Vec3::z_axis(), 0.7);
        let packing = lay(
            "placed = { bodies = [{ grain = 0, position = [0.5, 0.5, 0.5] }] }",
            &of(&[turned.clone()]),
            &room(&[1.0; 3]),
        )
        .expect("accepted");
        assert_eq!(packing.placements[0].orientation, turned.axes);
    }

    #[test]
    fn deep_overlaps_are_refused() {
        let clumps = clumps();
        let grains = families(&clumps);
        let region = room(&[1.0; 3]);
        let pair = |x: f64| {
            format!(
                "placed = {{ bodies = [{{ grain = 0, position = [0.5, 0.5, 0.5] }}, {{ grain = 1, position = [{x}, 0.5, 0.5] }}] }}"
            )
        };
        assert_eq!(key(&pair(0.785), &grains, &region), "placed.bodies[1].position");
        assert!(lay(&pair(0.795), &grains, &region).is_ok());
        let wall = |z: f64| {
            format!("placed = {{ bodies = [{{ grain = 0, position = [0.5, 0.5, {z}] }}] }}")
        };
        assert_eq!(key(&wall(0.17), &grains, &region), "placed.bodies[0].position");
        assert_eq!(key(&wall(1.3), &grains, &region), "placed.bodies[0].position");
        assert!(lay(&wall(0.19), &grains, &region).is_ok());
        let Region::Box(mut lidless) = region else { panic!("a box") };
        lidless.open[2][1] = true;
        assert!(lay(&wall(1.3), &grains, &Region::Box(lidless)).is_ok());
    }

    #[test]
    fn wrong_bodies_name_their_key() {
        let clumps = clumps();
        let grains = families(&clumps);
        let (space, plane) = (room(&[1.0; 3]), room(&[1.0; 2]));
        let one = |body: &str| format!("placed = {{ bodies = [{{ {body} }}] }}");
        let cases = [
            ("position = [0, 0, 0]", "grain"),
            ("grain = 0, family = 'big', position = [0, 0, 0]", "grain"),
            ("grain = 3, position = [0, 0, 0]", "grain"),
            ("family = 'tiny', position = [0, 0, 0]", "family"),
            ("grain = 0", "position"),
            ("grain = 0, position = [0.5, 0.5]", "position"),
            ("grain = 0, position = [0.5, 0.5, 0.5], velocity = [1]", "velocity"),
            ("grain = 0, position = [0.5, 0.5, 0.5], spin = [1]", "spin"),
            (
                "grain = 0, position = [0.5, 0.5, 0.5], orientation = { quaternion = [0, 0, 0, 0] }",
                "orientation.quaternion",
            ),
        ];
        for (body, expected) in cases {
            assert_eq!(key(&one(body), &grains, &space), format!("placed.bodies[0].{expected}"));
        }
        let flat = [
            ("grain = 1, position = [0.5, 0.5, 0.1]", "position"),
            ("grain = 1, position = [0.5, 0.5], spin = [1, 0, 0]", "spin"),
            ("grain = 1, position = [0.5, 0.5], velocity = [1, 0, 2]", "velocity"),
            (
                "grain = 1, position = [0.5, 0.5], orientation = { axis_angle = { axis = [1, 0, 0], angle = 1 } }",
                "orientation",
            ),
        ];
        for (body, expected) in flat {
            assert_eq!(key(&one(body), &grains, &plane), format!("placed.bodies[0].{expected}"));
        }
        let spinning = one("grain = 1, position = [0.5, 0.5], spin = [3], velocity = [1, 2]");
        let packing = lay(&spinning, &grains, &plane).expect("accepted");
        assert_eq!(packing.placements[0].spin.z, 3.0);
        let too_many = "placed = { bodies = [{ family = 'big', position = [0.3, 0.3, 0.3] }, { family = 'big', position = [0.7, 0.7, 0.7] }] }";
        assert_eq!(key(too_many, &grains, &space), "placed.bodies[1].family");
    }
}
