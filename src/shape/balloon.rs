//! G4: virtual ballooning (Sajjadi & Khalili 2015).
//!
//! The surface of a base volume is divided finely, then inflated from chosen or
//! random centres, step by step: a vertex x within the radius ρ of a centre c
//! moves along the ray from c by (a/steps)·w(|x−c|/ρ), w(s) = (1 − s²)². With a
//! zone, only vertices in a cone about its direction, seen from the centre,
//! move. After each step the surface is checked against itself; a step after
//! which it passes through itself is taken back and tried with half the length,
//! at most five times. Lengths are over the equivalent diameter of the base
//! volume. Cost O(steps · triangles · log triangles).

use super::base::Base;
use super::draw::{Draw, Drawn, Fact, ordered, ordered_whole};
use crate::geometry::{GeometryError, Mesh, intersection, refine};
use crate::num::random::{self, Stream};
use crate::num::units::Angle;
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Part of the surface that is inflated, seen from each centre.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Zone {
    /// Middle direction; any length but 0.
    pub direction: [f64; 3],
    /// Half angle of the cone about it, greater than 0, at most 180 deg.
    pub angle: Angle,
}

/// Inflation of a base volume.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BalloonParameters {
    /// Base volume; default a box.
    pub base: Base,
    /// Least and largest number of random centres, each from 0 to 50; default [2, 5].
    pub centres: [u32; 2],
    /// Chosen centres, over the equivalent diameter of the base volume; instead of random ones if given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub at: Vec<[f64; 3]>,
    /// Least and largest radius that a centre acts within, from 0.05 to 5; default [0.4, 0.8].
    pub radius: [f64; 2],
    /// Least and largest height of inflation at a centre, from -0.5 (dents) to 2; default [0.1, 0.3].
    pub height: [f64; 2],
    /// Part of the surface that is inflated; default all of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zone: Option<Zone>,
    /// Steps, from 1 to 100; default 8.
    pub steps: u32,
    /// Longest edge of the surface before it is inflated, from 0.02 to 0.5; default 0.1.
    pub fineness: f64,
}

impl Default for BalloonParameters {
    fn default() -> Self {
        Self {
            base: Base::Box([1.0, 0.8, 0.7]),
            centres: [2, 5],
            at: Vec::new(),
            radius: [0.4, 0.8],
            height: [0.1, 0.3],
            zone: None,
            steps: 8,
            fineness: 0.1,
        }
    }
}

/// Halvings of a step before the inflation stops there.
const HALVINGS: u32 = 5;
/// Depth over the diagonal from which on the surface passes through itself.
const DEPTH: f64 = 1e-6;

/// One inflation.
struct Centre {
    at: Vec3,
    radius: f64,
    height: f64,
}

impl Draw for BalloonParameters {
    fn validate(&self) -> Result<(), Fault> {
        self.base.validate().map_err(|fault| fault.under("base"))?;
        ordered_whole("centres", self.centres, 0, 50)?;
        for (index, centre) in self.at.iter().enumerate() {
            for (axis, x) in centre.iter().enumerate() {
                Fault::within(&format!("at[{index}][{axis}]"), *x, -10.0, 10.0)?;
            }
        }
        ordered("radius", self.radius, 0.05, 5.0)?;
        ordered("height", self.height, -0.5, 2.0)?;
        if let Some(zone) = &self.zone {
            let length = Vec3::from(zone.direction).norm();
            Fault::within("zone.direction", length, 1e-6, 1e6)?;
            Fault::within("zone.angle", zone.angle.0, 1e-3, std::f64::consts::PI)?;
        }
        Fault::within("steps", f64::from(self.steps), 1.0, 100.0)?;
        Fault::within("fineness", self.fineness, 0.02, 0.5)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let body = self.base.draw(stream)?;
        let own = body.mesh.mass_properties();
        let unit = own.equivalent_diameter();
        let mut mesh =
            refine::refined(&body.mesh.mapped(|p| (p - own.centroid) / unit), self.fineness);
        let before = mesh.mass_properties().volume;
        let centres = self.centres_of(&mesh, stream);
        let mut halved = 0;
        let mut done = 0.0;
        let full = 1.0 / f64::from(self.steps);
        'steps: for _ in 0..self.steps {
            let mut share = full;
            for halving in 0..=HALVINGS {
                let next = self.inflated(&mesh, &centres, share);
                let crossing =
                    intersection::self_intersections(&next, DEPTH * next.bounds().diagonal());
                if crossing.is_empty() {
                    mesh = next;
                    done += share;
                    break;
                }
                if halving == HALVINGS {
                    break 'steps;
                }
                halved += 1;
                share *= 0.5;
            }
        }
        let grown = mesh.mass_properties().volume / before;
        Ok(Drawn {
            mesh,
            recipe: format!(
                "{} inflated from {} centres; {halved} halved steps",
                self.base.name(),
                centres.len()
            ),
            facts: vec![
                Fact::asked("share of the inflation done", 1.0, done),
                Fact::found("volume over that of the base", grown),
            ],
        })
    }
}

impl BalloonParameters {
    fn centres_of(&self, mesh: &Mesh, stream: &mut Stream) -> Vec<Centre> {
        let pick = |stream: &mut Stream, at: Option<Vec3>| {
            let radius = random::uniform(stream, self.radius[0], self.radius[1]);
            let height = random::uniform(stream, self.height[0], self.height[1]);
            let start = random::whole(stream, 0, mesh.vertices.len() as u64 - 1) as usize;
            // Half a radius beneath a random vertex, towards the centroid.
            let surface = mesh.vertices[start];
            let depth = (0.5 * radius).min(0.9 * surface.norm());
            let at = at.unwrap_or(surface - surface.normalize() * depth);
            Centre { at, radius, height }
        };
        if !self.at.is_empty() {
            return self.at.iter().map(|at| pick(stream, Some((*at).into()))).collect();
        }
        let [few, many] = self.centres.map(u64::from);
        let count = random::whole(stream, few, many);
        (0..count).map(|_| pick(stream, None)).collect()
    }

    /// `mesh` after `share` of the whole inflation.
    fn inflated(&self, mesh: &Mesh, centres: &[Centre], share: f64) -> Mesh {
        let zone = self
            .zone
            .as_ref()
            .map(|zone| (Vec3::from(zone.direction).normalize(), zone.angle.0.cos()));
        mesh.mapped(|point| {
            let moves = centres.iter().map(|centre| {
                let arm = point - centre.at;
                let length = arm.norm();
                let s = length / centre.radius;
                let outside = zone.is_some_and(|(along, least)| arm.dot(&along) < least * length);
                if s >= 1.0 || length < 1e-9 || outside {
                    return Vec3::zeros();
                }
                arm * (share * centre.height * (1.0 - s * s).powi(2) / length)
            });
            point + moves.sum::<Vec3>()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::topology::inspect;

    #[test]
    fn a_sphere_inflated_from_its_middle_is_a_larger_sphere() {
        let balloon = BalloonParameters {
            base: Base::Sphere(2.0),
            at: vec![[0.0; 3]],
            radius: [1.0, 1.0],
            height: [0.2, 0.2],
            steps: 1,
            ..Default::default()
        };
        balloon.validate().expect("in their ranges");
        let drawn = balloon.draw(&mut random::stream(1, "balloon", 0)).expect("inflated");
        // w(0.5) = 0.75² at radius 0.5 of the unit diameter.
        let expected = 0.5 + 0.2 * 0.75f64.powi(2);
        let reach = drawn.mesh.vertices.iter().map(|p| p.norm());
        let (low, high) = reach.fold((f64::MAX, 0.0f64), |(l, h), r| (l.min(r), h.max(r)));
        assert!((low - expected).abs() < 0.006 && (high - expected).abs() < 0.006, "{low} {high}");
    }

    #[test]
    fn a_zone_leaves_the_rest_alone() {
        let zone = Some(Zone { direction: [0.0, 0.0, 1.0], angle: Angle(0.6) });
        let balloon = BalloonParameters {
            base: Base::Sphere(1.0),
            at: vec![[0.0; 3]],
            radius: [1.0, 1.0],
            zone,
            ..Default::default()
        };
        let drawn = balloon.draw(&mut random::stream(1, "balloon", 0)).expect("inflated");
        let bounds = drawn.mesh.bounds();
        assert!(bounds.high.z > 0.55 && bounds.low.z > -0.51, "{bounds:?}");
    }

    #[test]
    fn inflated_boxes_are_closed() {
        for index in 0..3 {
            let balloon = BalloonParameters { fineness: 0.2, ..Default::default() };
            let drawn = balloon.draw(&mut random::stream(3, "balloon", index)).expect("inflated");
            let report = inspect(&drawn.mesh);
            assert!(report.is_closed() && report.euler_characteristic == 2);
            assert!(drawn.facts[1].measured > 1.0);
        }
    }
}
