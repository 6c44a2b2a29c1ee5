//! Spheres along the long axis (Favier et al. 1999).
//!
//! Source: Favier, Abbaspour-Fard, Kremmer & Raji 1999, Engineering Computations 16, 467–480,
//! for bodies of revolution: centres evenly spaced on the axis, each sphere as large as the
//! surface allows. Here the axis is the principal axis of least inertia through the centroid;
//! the first and the last sphere are the largest that touch the ends of the axis. A place
//! outside the solid gets none.
//!
//! `inscribed`: radius = distance of the centre from the surface (source's rule, nothing
//! sticks out). `section`: radius of the circle with the area of the cross-section, which
//! gives the right girth and sticks out where the section shrinks along the axis (how the
//! CLUMP program of 2021 does it, from the sections' vertices).
//!
//! Only for solids that are nearly bodies of revolution about their long axis: elsewhere the
//! error stays however many spheres there are. Cost O(spheres · log triangles), plus
//! O(triangles) a sphere for sections.

use super::ClumpError;
use super::pieces::largest_piece;
use super::target::{Found, Target};
use crate::geometry::Ball;
use crate::num::{Fault, Job, MethodEntry, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// What `riprap list clumps` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "axial",
    id: "",
    summary: "spheres along the long axis, for bodies of revolution",
    source: "Favier et al. 1999",
    example: r#"clump.axial = { spheres = 9 }"#,
};

/// Spheres along the long axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Axial {
    /// Spheres; 1 to 1000, default 9; more, up to 1000, where so many would not hang together.
    #[serde(default = "default_spheres")]
    pub spheres: usize,
    /// Where the radii come from; default `inscribed`.
    #[serde(default)]
    pub radius: Girth,
}

/// Where the radii come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Girth {
    /// The distance of the centre from the surface.
    #[default]
    Inscribed,
    /// The circle with the area of the cross-section.
    Section,
}

fn default_spheres() -> usize {
    9
}

impl Default for Axial {
    fn default() -> Self {
        Self { spheres: default_spheres(), radius: Girth::default() }
    }
}

/// Most spheres.
const MOST: usize = 1000;
/// Steps along the axis when its inner part is looked for.
const STEPS: usize = 400;

impl Axial {
    /// # Errors
    /// [`Fault`] for a value out of its range.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("spheres", self.spheres as f64, 1.0, MOST as f64)
    }

    pub(super) fn find(&self, target: &Target, job: &Job) -> Result<Found, ClumpError> {
        let origin = target.solid.mass.centroid;
        let axis = target.solid.mass.principal().1 * Vec3::x();
        let along = |v: &Vec3| (v - origin).dot(&axis);
        let (low, high) = target
            .solid
            .mesh
            .vertices
            .iter()
            .map(along)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let depth = |x: f64| -target.distance.at(&(origin + axis * x));
        let (first, last) = ends(&depth, low, high);
        let row = |count: usize| -> Vec<Ball> {
            let mut balls = Vec::new();
            for at in 0..count {
                let share = if count == 1 { 0.5 } else { at as f64 / (count - 1) as f64 };
                let x = first + (last - first) * share;
                let inscribed = depth(x);
                let centre = origin + axis * x;
                let radius = match self.radius {
                    Girth::Inscribed => inscribed,
                    Girth::Section if inscribed > 0.0 => self.girth(target, &centre, &axis),
                    Girth::Section => 0.0,
                };
                if radius > 1e-6 * target.diameter {
                    balls.push(Ball { centre, radius });
                }
            }
            balls
        };
        let mut count = self.spheres;
        let (mut balls, mut dropped) = largest_piece(row(count));
        // On a long bar most may lie apart: more, until they hang together.
        while dropped > balls.len() && count < MOST {
            if job.is_cancelled() {
                return Err(ClumpError::Cancelled);
            }
            count = (count + count.div_ceil(8)).min(MOST);
            let (more, left) = largest_piece(row(count));
            if left == 0 {
                (balls, dropped) = (more, left);
            }
        }
        if balls.is_empty() {
            return Err(ClumpError::NoSphere {
                name: target.solid.name.clone(),
                advice: "its long axis lies outside it: choose another method",
            });
        }
        let left = match dropped {
            0 => String::new(),
            count => format!("; {count} spheres apart from the largest piece left out"),
        };
        let left = match balls.len() > self.spheres {
            true => format!("{left}; {} would not have hung together", self.spheres),
            false => left,
        };
        let radius = match self.radius {
            Girth::Inscribed => "inscribed",
            Girth::Section => "sections",
        };
        let note = format!("axial (Favier et al. 1999): {} spheres, {radius}{left}", balls.len());
        Ok(Found { balls, note })
    }

    /// Radius of the circle with the area of the cross-section through `centre`: Green's
    /// theorem over the segments in which the plane cuts the triangles.
    fn girth(&self, target: &Target, centre: &Vec3, axis: &Vec3) -> f64 {
        let mut double = 0.0;
        for corners in target.solid.mesh.facets() {
            let heights = corners.map(|c| (c - centre).dot(axis));
            let mut up = None;
            let mut down = None;
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                let (a, b) = (heights[i], heights[j]);
                if (a >= 0.0) != (b >= 0.0) {
                    let point = corners[i] + (corners[j] - corners[i]) * (a / (a - b)) - centre;
                    *(if a < b { &mut up } else { &mut down }) = Some(point);
                }
            }
            if let (Some(from), Some(to)) = (up, down) {
                double += to.cross(&from).dot(axis);
            }
        }
        (double.abs() / (2.0 * PI)).sqrt()
    }
}

/// Centres of the end spheres: where, coming from either end of the axis, the nearest surface
/// is no longer that end.
fn ends(depth: &dyn Fn(f64) -> f64, low: f64, high: f64) -> (f64, f64) {
    let step = (high - low) / STEPS as f64;
    let places: Vec<f64> = (0..=STEPS).map(|i| low + step * i as f64).collect();
    let inside: Vec<bool> = places.iter().map(|&x| depth(x) > 0.0).collect();
    let (Some(a), Some(b)) = (inside.iter().position(|&i| i), inside.iter().rposition(|&i| i))
    else {
        return (low, low);
    };
    let end = |from: usize, mut range: Box<dyn Iterator<Item = usize>>| {
        // As long as the depth grows as fast as the way from the end, the end is nearest.
        range
            .find(|&i| depth(places[i]) < 0.98 * ((places[i] - places[from]).abs() + step) - step)
            .map_or(places[from], |i| places[i])
    };
    let (first, last) = (end(a, Box::new(a..=b)), end(b, Box::new((a..=b).rev())));
    if first <= last { (first, last) } else { (0.5 * (first + last), 0.5 * (first + last)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clump::reproduce::tests::solid;
    use crate::clump::{MassSource, Method, reproduce};
    use crate::geometry::samples::{box_mesh, ellipsoid_mesh};

    #[test]
    fn an_ellipsoid_of_revolution_and_its_closed_forms() {
        // Half axes 2, 1, 1: curvature radius at the tip b²/a = 1/2, inscribed at x:
        // b √(1 − x²/(a² − b²)) while x ≤ (a² − b²)/a = 1.5.
        let egg = solid("egg", ellipsoid_mesh(Vec3::new(2.0, 1.0, 1.0)));
        for radius in [Girth::Inscribed, Girth::Section] {
            let method = Method::Axial(Axial { spheres: 7, radius });
            let clump =
                reproduce(&egg, &method, MassSource::Solid, 1, 0, &Job::quiet()).expect("a clump");
            assert_eq!(clump.balls.len(), 7);
            for ball in clump.in_solid_frame() {
                let x = ball.centre.x;
                let expected = match radius {
                    Girth::Inscribed => (1.0 - x * x / 3.0).max(0.25).sqrt(),
                    Girth::Section => (1.0 - x * x / 4.0).sqrt(),
                };
                assert!((ball.radius - expected).abs() < 0.02, "{x} {} {expected}", ball.radius);
                assert!(x.abs() < 1.6 && ball.centre.yz().norm() < 1e-6);
            }
            let widest = clump.balls.iter().map(|b| b.centre.norm()).fold(0.0, f64::max);
            assert!((widest - 1.5).abs() < 0.12, "{widest}");
        }
    }

    #[test]
    fn a_long_square_bar_gets_a_row_that_hangs_together() {
        for (length, asked) in [(11.0, 11), (12.0, 11), (40.0, 9)] {
            let bar = solid("bar", box_mesh(Vec3::new(length, 1.0, 1.0)));
            let method = Method::Axial(Axial { spheres: asked, ..Axial::default() });
            let clump =
                reproduce(&bar, &method, MassSource::Solid, 1, 0, &Job::quiet()).expect("a clump");
            let reach = clump.bounding_radius();
            assert!(clump.balls.len() >= asked && clump.balls.len() < 60, "{}", clump.balls.len());
            assert!(reach > 0.5 * length - 0.3 && reach < 0.5 * length + 0.1, "{length} {reach}");
            assert!(super::super::refine::one_piece(&clump.balls));
        }
    }

    #[test]
    fn a_bar_keeps_within_its_sides() {
        let bar = solid("bar", box_mesh(Vec3::new(5.0, 1.0, 1.2)));
        let method = Method::Axial(Axial { spheres: 9, ..Axial::default() });
        let clump =
            reproduce(&bar, &method, MassSource::Solid, 1, 0, &Job::quiet()).expect("a clump");
        assert!(clump.balls.iter().all(|b| (b.radius - 0.5).abs() < 0.02));
        assert!(clump.bounding_radius() < 2.52);
        assert!(Axial { spheres: 0, ..Axial::default() }.validate().is_err());
    }
}
