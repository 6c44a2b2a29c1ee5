//! Apollonian packing (P1): every gap between four discs (five balls) that
//! touch each other gets the disc (ball) that touches them all, again and again.
//!
//! Descartes 1643, Soddy 1936 (Nature 137, 1021): the bends k = 1/r of d + 2
//! balls that touch each other obey d Σk² = (Σk)². So w = (k, k c) with centre c has a
//! linear rule for the other ball that touches the same d + 1 (Boyd 1973, Canad. J. Math. 25, 303):
//! w' = 2/(d−1) Σ_others w − w. No root is taken after the start.
//!
//! Two dimensions: depth first, never undoing the last step; each disc is met once, O(depth) memory.
//! Three dimensions: a ball is reached on several ways ((S_i S_j)³ = 1), so sets
//! of five balls that are already known are not followed again.
//! Cost O(discs) and O(sets of five), about 5 a ball. The number of balls grows as
//! k^1.3057 (k^2.474 in three dimensions; Borkovec, De Paris, Peikert 1994).
//!
//! The outer disc (ball) is the largest that lies in the container about its middle;
//! what the container has beyond it stays empty. Ends when the grains are used up or the next ball is
//! smaller than `smallest`.

use super::{Grain, Laid, Turn, dress};
use crate::geometry::{Ball, Region};
use crate::num::units::Length;
use crate::num::{Fault, Job, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{HashMap, HashSet};

/// Parameters of an Apollonian packing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Apollonian {
    /// The discs that the packing starts from; default `symmetric`.
    pub start: Start,
    /// Smallest diameter, m, 0 or more; default 0 (as many balls as there are grains).
    pub smallest: Length,
    /// Share of its radius by which every ball is smaller than its place, 0 to 0.1, so that
    /// rounding makes no overlaps; default 1e-9.
    pub slack: f64,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
}

/// The largest discs of the packing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// Three equal discs (four equal balls) that touch each other and the outer one.
    #[default]
    Symmetric,
    /// Bends −1, 2, 2, 3 in two dimensions: all bends are whole numbers.
    Integer,
}

impl Default for Apollonian {
    fn default() -> Self {
        Self {
            start: Start::Symmetric,
            smallest: Length(0.0),
            slack: 1e-9,
            orientation: Turn::Random,
        }
    }
}

/// Bend and bend times centre.
type Bend = [f64; 4];

fn circle(radius: f64, centre: Vec3) -> Bend {
    let k = 1.0 / radius;
    [k, k * centre.x, k * centre.y, k * centre.z]
}

fn ball(w: &Bend) -> Ball {
    Ball { centre: Vec3::new(w[1], w[2], w[3]) / w[0], radius: 1.0 / w[0] }
}

/// The other ball that touches all of `all` but number `index`; `factor` = 2/(d−1).
fn reflected<const N: usize>(all: &[Bend; N], index: usize, factor: f64) -> Bend {
    std::array::from_fn(|axis| {
        let sum: f64 = all.iter().map(|w| w[axis]).sum();
        factor * (sum - all[index][axis]) - all[index][axis]
    })
}

/// The outer disc of radius 1 about the origin and the three it starts from.
fn flat_start(start: Start) -> [Bend; 4] {
    let outer = [-1.0, 0.0, 0.0, 0.0];
    match start {
        Start::Symmetric => {
            let r = 1.0 / (1.0 + 2.0 / 3.0_f64.sqrt());
            let at = |i: f64| {
                let angle = std::f64::consts::TAU * i / 3.0 + std::f64::consts::FRAC_PI_2;
                circle(r, Vec3::new(angle.cos(), angle.sin(), 0.0) * (1.0 - r))
            };
            [outer, at(0.0), at(1.0), at(2.0)]
        }
        Start::Integer => [
            outer,
            circle(0.5, Vec3::new(0.5, 0.0, 0.0)),
            circle(0.5, Vec3::new(-0.5, 0.0, 0.0)),
            circle(1.0 / 3.0, Vec3::new(0.0, 2.0 / 3.0, 0.0)),
        ],
    }
}

/// The outer ball of radius 1 about the origin and four equal ones.
fn solid_start() -> [Bend; 5] {
    let r = 1.0 / (1.0 + 0.5 * 6.0_f64.sqrt());
    let at = |x: f64, y: f64, z: f64| circle(r, Vec3::new(x, y, z) * ((1.0 - r) / 3.0_f64.sqrt()));
    [
        [-1.0, 0.0, 0.0, 0.0],
        at(1.0, 1.0, 1.0),
        at(1.0, -1.0, -1.0),
        at(-1.0, 1.0, -1.0),
        at(-1.0, -1.0, 1.0),
    ]
}

/// Calls `visit(w)` for every disc of bend `limit` or less in the unit disc,
/// until it returns false.
pub fn discs(start: Start, limit: f64, mut visit: impl FnMut(&Bend) -> bool) {
    let first = flat_start(start);
    if !first[1..].iter().filter(|w| w[0] <= limit * (1.0 + 1e-12)).all(&mut visit) {
        return;
    }
    // Four discs, and which of them is the newest (4: none).
    let mut stack = vec![(first, 4)];
    while let Some((all, newest)) = stack.pop() {
        for index in (0..4).filter(|&index| index != newest) {
            let w = reflected(&all, index, 2.0);
            // The first four may have a mirror image of the same bend.
            if w[0] > limit * (1.0 + 1e-12) || w[0] < all[index][0] {
                continue;
            }
            if !visit(&w) {
                return;
            }
            let mut next = all;
            next[index] = w;
            stack.push((next, index));
        }
    }
}

/// Numbers that name a ball: distinct balls of one bend are at least 2/√3 apart in k·c, and
/// a bend that differs by less than the quantum does not change that.
fn name_of(w: &Bend) -> [i64; 4] {
    const QUANTUM: f64 = 0.125;
    // The shift keeps the round numbers of symmetric packings off the edges of the quanta.
    w.map(|value| (value / QUANTUM + 0.271_828).floor() as i64)
}

/// Every ball of bend `limit` or less in the unit ball, in the order of discovery, at most about `most`.
pub fn balls(limit: f64, most: usize) -> Vec<Bend> {
    let first = solid_start();
    // The outer ball is number 0.
    let mut known = first.to_vec();
    if first[1][0] > limit {
        return Vec::new();
    }
    let mut names: HashMap<[i64; 4], u32> =
        known.iter().enumerate().map(|(i, w)| (name_of(w), i as u32)).collect();
    let mut seen: HashSet<[u32; 5]> = HashSet::from([[0, 1, 2, 3, 4]]);
    let mut stack = vec![[0_u32, 1, 2, 3, 4]];
    while let Some(five) = stack.pop() {
        let all = five.map(|i| known[i as usize]);
        for index in 0..5 {
            let w = reflected(&all, index, 1.0);
            if w[0] > limit * (1.0 + 1e-12) || w[0] <= all[index][0] * (1.0 + 1e-9) {
                continue;
            }
            let number = *names.entry(name_of(&w)).or_insert_with(|| {
                known.push(w);
                known.len() as u32 - 1
            });
            let mut next = five;
            next[index] = number;
            next.sort_unstable();
            if seen.insert(next) {
                stack.push(next);
            }
        }
        if known.len() > most {
            break;
        }
    }
    known.remove(0);
    known
}

impl Apollonian {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::not_negative("smallest", self.smallest.0)?;
        Fault::within("slack", self.slack, 0.0, 0.1)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let dimension = region.dimension();
        if dimension == 3 && self.start == Start::Integer {
            let allowed = "`symmetric` in three dimensions";
            return Err(Fault::new("apollonian.start", "is for two dimensions", allowed));
        }
        let middle = region.bounds().centre();
        let outer = region.clearance(&middle);
        if outer <= 0.0 {
            let problem = "needs the middle of the container inside it";
            return Err(Fault::new("apollonian", problem, "a container without a hole there"));
        }
        let finest =
            if self.smallest.0 > 0.0 { 2.0 * outer / self.smallest.0 } else { f64::INFINITY };
        let (found, limit) = self.largest(dimension, grains.len(), finest, job);
        let discs: Vec<Ball> = found
            .iter()
            .map(|w| {
                let Ball { centre, radius } = ball(w);
                Ball {
                    centre: middle + centre * outer,
                    radius: radius * outer * (1.0 - self.slack),
                }
            })
            .collect();
        let why = if discs.len() < grains.len() {
            format!("no more balls of {:.4e} m or more", 2.0 * outer / limit)
        } else {
            "one ball for every grain".to_owned()
        };
        let why = format!("{why}; inside the ball of radius {outer:.4e} m about the middle");
        Ok(dress::by_rank(grains, &discs, dimension, self.orientation, seed, &why))
    }

    /// The `count` largest balls of bend up to `finest`, and the bend that was looked at.
    fn largest(&self, dimension: usize, count: usize, finest: f64, job: &Job) -> (Vec<Bend>, f64) {
        let mut limit = 8.0_f64.min(finest);
        loop {
            let mut found = Vec::new();
            match dimension {
                2 => discs(self.start, limit, |w| {
                    found.push(*w);
                    true
                }),
                _ => found = balls(limit, usize::MAX),
            }
            job.report("balls", found.len().min(count) as u64, count as u64);
            if found.len() >= count || limit >= finest || job.is_cancelled() {
                let key = |w: &Bend| w.map(|value| (value * 1e6).round() as i64);
                found.sort_by_key(key);
                found.truncate(count);
                return (found, limit);
            }
            limit = (1.5 * limit).min(finest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{brute_force, of, room, sphere};
    use super::super::{Method, pack};
    use super::*;

    fn count_and_cover(start: Start, limit: f64) -> (usize, f64) {
        let (mut count, mut covered) = (0, 0.0);
        discs(start, limit, |w| {
            count += 1;
            covered += w[0].powi(-2);
            true
        });
        (count, covered)
    }

    #[test]
    fn integer_packing_has_the_known_counts() {
        for (limit, count) in [(10.0, 8), (100.0, 168), (1e3, 3328), (1e4, 67_166)] {
            assert_eq!(count_and_cover(Start::Integer, limit).0, count, "{limit}");
        }
        discs(Start::Integer, 1e3, |w| {
            assert_eq!(w[0], w[0].round());
            true
        });
    }

    #[test]
    fn symmetric_packing_has_the_known_counts_and_covers() {
        let known = [(10.0, 12, 0.8694394), (100.0, 166, 0.9690823), (1e3, 3304, 0.9937114)];
        for (limit, count, cover) in known {
            let found = count_and_cover(Start::Symmetric, limit);
            assert_eq!(found.0, count, "{limit}");
            assert!((found.1 - cover).abs() < 1e-7, "{found:?}");
        }
    }

    #[test]
    fn balls_have_the_known_counts_and_covers() {
        let known = [
            (5.0, 20, 0.578218),
            (10.0, 81, 0.693615),
            (20.0, 407, 0.783250),
            (40.0, 2069, 0.846908),
            (80.0, 11_537, 0.893848),
        ];
        for (limit, count, cover) in known {
            let found = balls(limit, usize::MAX);
            assert_eq!(found.len(), count, "{limit}");
            let covered: f64 = found.iter().map(|w| w[0].powi(-3)).sum();
            assert!((covered - cover).abs() < 1e-6, "{covered}");
        }
    }

    #[test]
    fn nothing_overlaps_and_sizes_are_the_method_s() {
        for dimension in [2, 3] {
            let clumps = vec![sphere(0.1, dimension); 300];
            let grains = of(&clumps);
            let region = room(&vec![1.0; dimension]);
            let method = Method::Apollonian(Apollonian::default());
            let packing = pack(&grains, &[], &region, &method, 1, &Job::quiet()).expect("right");
            assert_eq!(packing.placements.len(), 300);
            let (gap, wall) = brute_force(&packing, &grains, &region);
            assert!((0.0..1e-6).contains(&gap) && wall >= 0.0, "{gap} {wall}");
            assert!(packing.outcome.contains("times those wanted"), "{}", packing.outcome);
        }
    }

    #[test]
    fn a_smallest_size_ends_it_and_wrong_input_is_refused() {
        let clumps = vec![sphere(0.1, 2); 5000];
        let method =
            Method::Apollonian(Apollonian { smallest: Length(0.01), ..Apollonian::default() });
        let packing =
            pack(&of(&clumps), &[], &room(&[1.0, 1.0]), &method, 1, &Job::quiet()).expect("right");
        // Bends up to 100 in a disc of radius 0.5.
        assert_eq!(packing.placements.len(), 166);
        assert!(packing.outcome.contains("no more balls"), "{}", packing.outcome);
        assert!(Apollonian { slack: -1.0, ..Apollonian::default() }.validate().is_err());
        let integer =
            Method::Apollonian(Apollonian { start: Start::Integer, ..Apollonian::default() });
        let refused = pack(&of(&clumps), &[], &room(&[1.0; 3]), &integer, 1, &Job::quiet());
        assert!(refused.expect_err("three dimensions").to_string().contains("start"));
    }
}
