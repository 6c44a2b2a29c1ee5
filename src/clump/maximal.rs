//! Maximal balls of a solid: the candidates of a fit, and the points inside that they tell of.
//!
//! A maximal ball touches a surface point from inside and is as large as the rest of the surface lets it be,
//! up to a length by which it may stick out ([`super::cover`]).

use super::cover;
use super::patches::Patches;
use super::target::Target;
use crate::geometry::{Ball, united};
use crate::num::Vec3;

/// How far a sphere may stick out where nothing else is said.
pub const FREE: f64 = 0.12;
/// What lies between two points of the coarse set sticks out by less than this.
const UNSEEN: f64 = 0.02;
/// Inner points over one equivalent diameter.
const GRID: f64 = 12.0;

/// How the maximal balls of one fit are found.
pub struct Maximal<'a> {
    /// What is fitted.
    pub target: &'a Target<'a>,
    /// As [`super::Fitted::protrusion`].
    pub protrusion: Option<f64>,
    /// Least radius, m.
    pub smallest: f64,
    /// Surface points from one candidate to the next.
    pub stride: usize,
}

impl Maximal<'_> {
    /// Largest radius about `centre`, m. Even free spheres are held back: far off the surface there are no points
    /// to see them.
    pub fn limit(&self, centre: &Vec3) -> f64 {
        self.protrusion.unwrap_or(FREE) * self.target.diameter - self.target.distance.at(centre)
    }

    /// Largest balls that touch the points of `coarse` and stick out by `allowed` [m].
    pub fn balls(&self, coarse: &Patches, allowed: f64) -> Vec<Ball> {
        let Target { solid, distance, diameter } = self.target;
        // Free spheres stick out by `allowed` and what lies between two points, which is
        // less; but where the solid is thinner than that nothing stopped them.
        let hold = |point: &Vec3, normal: &Vec3, radius: f64| {
            let out = |radius: f64| radius + distance.at(&(point - normal * radius));
            match self.protrusion {
                None if out(radius) > 2.0 * allowed + UNSEEN * diameter => {
                    largest_below(out, radius, allowed)
                }
                _ => radius,
            }
        };
        let widest = solid.mesh.bounds().diagonal() / 2.0;
        let mut balls =
            cover::candidates_held(coarse, self.stride, allowed, self.smallest, widest, &hold);
        if self.protrusion.is_some() {
            balls.iter_mut().for_each(|b| b.radius = b.radius.min(self.limit(&b.centre)));
        }
        balls.retain(|ball| ball.radius >= self.smallest);
        balls
    }
}

/// The largest radius below `radius` at which `out` is not above `allowed`, to a thousandth;
/// `out` rises, and is zero at a radius of zero.
fn largest_below(out: impl Fn(f64) -> f64, radius: f64, allowed: f64) -> f64 {
    let (mut low, mut high) = (0.0, radius);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if out(middle) <= allowed {
            low = middle
        } else {
            high = middle
        }
        if high - low < 1e-3 * low {
            break;
        }
    }
    low
}

/// Deeper inside than this a fit of `count` spheres leaves no gaps at edges, m.
pub fn depth_to_cover(candidates: &[Ball], count: usize) -> f64 {
    let widest = candidates.iter().map(|b| b.radius).fold(0.0, f64::max);
    widest * 0.35 * (20.0 / count as f64).sqrt().min(1.0)
}

/// Nodes of a grid deeper inside than `least`: a lower bound of the depth is what the maximal
/// balls around a node leave to their surface.
pub fn inner_points(candidates: &[Ball], diameter: f64, least: f64) -> Vec<Vec3> {
    let bounds = united::around(candidates);
    let spacing = diameter / GRID;
    let steps = (bounds.size() / spacing).map(|s| s.ceil().clamp(0.0, 200.0) as usize);
    let mut is_deep = vec![false; (steps.x + 1) * (steps.y + 1) * (steps.z + 1)];
    let place = |i: usize, j: usize, k: usize| {
        bounds.low + Vec3::new(i as f64, j as f64, k as f64) * spacing
    };
    for ball in candidates.iter().filter(|ball| ball.radius > least) {
        let reach = ball.radius - least;
        let range = |axis: usize| {
            let at = (ball.centre[axis] - bounds.low[axis]) / spacing;
            // A node more than needed on either side costs nothing and forgives rounding.
            (at - reach / spacing).floor().max(0.0) as usize
                ..=((at + reach / spacing).ceil().max(0.0) as usize).min(steps[axis])
        };
        for i in range(0) {
            for j in range(1) {
                for k in range(2) {
                    let offset = place(i, j, k) - ball.centre;
                    if offset.norm_squared() < reach * reach {
                        is_deep[(i * (steps.y + 1) + j) * (steps.z + 1) + k] = true;
                    }
                }
            }
        }
    }
    let mut points = Vec::new();
    for i in 0..=steps.x {
        for j in 0..=steps.y {
            for k in 0..=steps.z {
                if is_deep[(i * (steps.y + 1) + j) * (steps.z + 1) + k] {
                    points.push(place(i, j, k));
                }
            }
        }
    }
    points
}
