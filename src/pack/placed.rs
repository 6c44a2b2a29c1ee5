//! Bodies one by one where the user wants them: collisions of two spheres,
//! a ball on a slope, small scenes for tests.
//!
//! Overlaps up to a tenth of the smaller radius are accepted (a scene may start in contact);
//! larger ones, between bodies or with walls, are refused. Sides without a wall
//! do not count. Cost O(spheres).

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
    /// How the body frame is turned into the world frame; default not at all.
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
    /// The body frame (centre of mass, principal axes) lies along the world axes.
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

    fn place(&self, grain: u32, dimension: usize) -> Result<Placement, Fault> {
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
            orientation,
            velocity: vector("velocity", &velocity, dimension)?,
            spin,
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
                .and_then(|grain| body.place(grain, region.dimension()))
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
