//! Greedy cover of a surface by maximal inner balls.
//!
//! Candidates: at a surface point p with outward normal n the largest ball p − r·n into
//! which no other surface point reaches deeper than t (see [`super::normals`]). The first
//! sphere is the largest candidate; next comes always the one that lowers the sum of squared
//! distances from the points to the union most (lazy greedy, Minoux 1978: gains hardly ever
//! rise, so that few are computed again).
//!
//! Cost O(C·G + pairs within reach) for C candidates and G groups of points.

use super::normals::stop;
use super::patches::Patches;
use super::pieces::joined;
use crate::geometry::Ball;
use crate::num::Vec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Maximal balls, at most one for every `stride`-th surface point, that stick out by at most
/// `allowed` and are no smaller than `smallest` nor larger than `widest`, m.
#[cfg(test)]
pub fn candidates(
    patches: &Patches,
    stride: usize,
    allowed: f64,
    smallest: f64,
    widest: f64,
) -> Vec<Ball> {
    candidates_held(patches, stride, allowed, smallest, widest, &|_, _, radius| radius)
}

/// As maximal balls, with radii that `hold(point, normal, radius)` may lower.
pub fn candidates_held(
    patches: &Patches,
    stride: usize,
    allowed: f64,
    smallest: f64,
    widest: f64,
    hold: &dyn Fn(&Vec3, &Vec3, f64) -> f64,
) -> Vec<Ball> {
    (0..patches.normals.len())
        .step_by(stride.max(1))
        .filter_map(|at| {
            let (point, normal) = (patches.points[at], patches.normals[at]);
            let mut radius = widest;
            for group in patches.groups.iter().filter(|group| group.inner.is_none()) {
                let centre = point - normal * radius;
                let reach = radius - allowed + group.radius;
                if (group.centre - centre).norm_squared() < reach * reach {
                    for other in &patches.points[group.first..group.end] {
                        radius = radius.min(stop(&(other - point), &normal, allowed));
                    }
                }
            }
            let radius = hold(&point, &normal, radius);
            (radius >= smallest).then(|| Ball { centre: point - normal * radius, radius })
        })
        .collect()
}

/// A candidate with the gain it had when last looked at.
struct Waiting {
    gain: f64,
    index: usize,
    /// Number of spheres at that time.
    round: usize,
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Waiting {}
impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.gain.total_cmp(&other.gain).then(other.index.cmp(&self.index))
    }
}

/// Distances from points to a union, with the largest of every group.
pub struct Gaps {
    gaps: Vec<f64>,
    largest: Vec<f64>,
}

impl Gaps {
    /// Distances that are known, m; infinite where there is no sphere yet.
    pub fn new(patches: &Patches, gaps: Vec<f64>) -> Self {
        let largest = patches
            .groups
            .iter()
            .map(|g| gaps[g.first..g.end].iter().copied().fold(f64::NEG_INFINITY, f64::max))
            .collect();
        Self { gaps, largest }
    }

    /// How much the sum of squared gaps would fall with one more ball, m².
    pub fn gain(&self, patches: &Patches, ball: &Ball) -> f64 {
        let mut sum = 0.0;
        for (group, &largest) in patches.groups.iter().zip(&self.largest) {
            let limit = ball.radius + largest + group.radius;
            let far = (group.centre - ball.centre).norm_squared() >= limit * limit;
            if limit <= 0.0 || far {
                continue;
            }
            for i in group.first..group.end {
                let old = self.gaps[i];
                let reach = ball.radius + old - group.inner.unwrap_or(0.0);
                let square = (patches.points[i] - ball.centre).norm_squared();
                if reach > 0.0 && square < reach * reach {
                    let new = group.gap(square.sqrt() - ball.radius);
                    sum += old * old - new * new;
                }
            }
        }
        sum
    }

    /// Takes one more ball in.
    pub fn add(&mut self, patches: &Patches, ball: &Ball) {
        for (group, largest) in patches.groups.iter().zip(&mut self.largest) {
            let limit = ball.radius + *largest + group.radius;
            if limit <= 0.0 || (group.centre - ball.centre).norm_squared() >= limit * limit {
                continue;
            }
            *largest = f64::NEG_INFINITY;
            for i in group.first..group.end {
                let new = group.gap((patches.points[i] - ball.centre).norm() - ball.radius);
                self.gaps[i] = self.gaps[i].min(new);
                *largest = largest.max(self.gaps[i]);
            }
        }
    }
}

/// `balls` with candidates added until there are `count` or none is of use; each new one
/// overlaps an earlier one.
pub fn greedy(
    patches: &Patches,
    candidates: &[Ball],
    mut balls: Vec<Ball>,
    count: usize,
) -> Vec<Ball> {
    let mut gaps = Gaps::new(patches, vec![f64::INFINITY; patches.points.len()]);
    if balls.is_empty() {
        let first = candidates
            .iter()
            .fold(None, |best: Option<&Ball>, ball| match best {
                Some(best) if best.radius >= ball.radius => Some(best),
                _ => Some(ball),
            })
            .copied();
        balls.extend(first);
    }
    balls.iter().for_each(|ball| gaps.add(patches, ball));
    let mut queue: BinaryHeap<Waiting> = (0..candidates.len())
        .map(|index| Waiting { gain: f64::INFINITY, index, round: usize::MAX })
        .collect();
    let mut apart = Vec::new();
    while balls.len() < count {
        let Some(mut next) = queue.pop() else { break };
        let ball = &candidates[next.index];
        if next.round != balls.len() {
            next.gain = gaps.gain(patches, ball);
            next.round = balls.len();
            if next.gain > 0.0 {
                queue.push(next);
            }
        } else if balls.iter().any(|other| joined(ball, other)) {
            gaps.add(patches, ball);
            balls.push(*ball);
            // What did not hang together may do so now.
            queue.extend(apart.drain(..));
        } else {
            apart.push(next);
        }
    }
    balls
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::SignedDistance;
    use crate::geometry::samples::{box_mesh, random_star};

    #[test]
    fn candidates_lie_inside_and_the_first_of_a_cube_is_its_inscribed_ball() {
        let cube = box_mesh(Vec3::repeat(2.0));
        let patches = Patches::new(&cube, 2000);
        let found = candidates(&patches, 2, 0.0, 0.01, 2.0);
        assert!(found.len() > 900);
        let distance = SignedDistance::new(&cube).expect("closed");
        // What lies between points of this spacing is not seen.
        let spacing = (24.0_f64 / 2000.0).sqrt();
        assert!(found.iter().all(|b| b.radius + distance.at(&b.centre) < spacing));
        let balls = greedy(&patches, &found, Vec::new(), 30);
        assert_eq!(balls.len(), 30);
        assert!((balls[0].radius - 1.0).abs() < 0.06, "{:?}", balls[0]);
    }

    #[test]
    fn gains_are_what_adding_does_and_fall() {
        let patches = Patches::new(&random_star(5, 0.5), 1500);
        let found = candidates(&patches, 1, 0.01, 0.01, 2.0);
        let cost = |balls: &[Ball]| -> f64 {
            let gap = |p: &Vec3| {
                balls.iter().map(|b| (p - b.centre).norm() - b.radius).fold(f64::INFINITY, f64::min)
            };
            patches.points.iter().map(|p| gap(p).powi(2)).sum()
        };
        let balls = greedy(&patches, &found, Vec::new(), 12);
        let mut gaps = Gaps::new(&patches, vec![f64::INFINITY; patches.points.len()]);
        gaps.add(&patches, &balls[0]);
        let mut last = f64::INFINITY;
        for at in 1..balls.len() {
            let gain = gaps.gain(&patches, &balls[at]);
            let change = cost(&balls[..at]) - cost(&balls[..=at]);
            assert!((gain - change).abs() < 1e-9, "{gain} {change}");
            assert!(gain <= last * 1.05);
            gaps.add(&patches, &balls[at]);
            last = gain;
        }
    }
}
