//! Random Apollonian packing (P3, RAP): a ball at a random free place, as large as
//! fits there or as is allowed; then the next one.
//!
//! Source: S. S. Manna, Physica A 187 (1992) 373; Delaney, Hutzler & Aste 2008
//! (Phys. Rev. Lett. 101, 120602). The share of pores falls as N^−(d−D)/D with D near
//! 1.565 (discs) and 2.73 (spheres), measured with 8 million balls.
//!
//! Cost: one search for the nearest surface a try, O(levels of sizes); tries a
//! ball = 1 / share of pores. Memory O(balls). Ends when every grain has a ball
//! or when a ball finds no place in `tries` tries, and says which.

use super::space::Space;
use super::{Grain, Laid, Turn, dress};
use crate::geometry::{Ball, BallGrid, Region};
use crate::num::random::stream;
use crate::num::units::Length;
use crate::num::{Fault, Job};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of a random Apollonian packing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RandomApollonian {
    /// Largest diameter, m, greater than 0; default that of the largest grain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest: Option<Length>,
    /// Smallest diameter, m, 0 or more; default 0.
    pub smallest: Length,
    /// Places tried for a ball before the method ends, 1 to 1 000 000 000; default 100 000.
    pub tries: u32,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
}

impl Default for RandomApollonian {
    fn default() -> Self {
        Self { largest: None, smallest: Length(0.0), tries: 100_000, orientation: Turn::Random }
    }
}

/// Limits on the sizes that a growth method makes.
pub(super) fn validate_sizes(largest: Option<Length>, smallest: Length) -> Result<(), Fault> {
    Fault::not_negative("smallest", smallest.0)?;
    let Some(largest) = largest else { return Ok(()) };
    Fault::positive("largest", largest.0)?;
    if largest.0 <= smallest.0 {
        let problem = format!("is {} m, not above `smallest`", largest.0);
        return Err(Fault::new("largest", problem, format!("more than {} m", smallest.0)));
    }
    Ok(())
}

/// The largest radius that is allowed: as given, or that of the largest grain.
pub(super) fn cap(largest: Option<Length>, grains: &[Grain]) -> f64 {
    let wanted = || grains.iter().map(super::occupied::clump_radius).fold(0.0, f64::max);
    largest.map_or_else(wanted, |length| 0.5 * length.0)
}

impl RandomApollonian {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("tries", f64::from(self.tries), 1.0, 1e9)?;
        validate_sizes(self.largest, self.smallest)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let space = Space::of(region);
        let cap = cap(self.largest, grains);
        let (balls, ended) =
            grown(&space, grains.len(), cap, 0.5 * self.smallest.0, self.tries, seed, job);
        Ok(dress::by_rank(grains, &balls, space.dimension, self.orientation, seed, &ended))
    }
}

/// At most `count` balls with radii from `smallest` to `cap` m, in the order in
/// which they were placed, and how it ended.
pub fn grown(
    space: &Space,
    count: usize,
    cap: f64,
    smallest: f64,
    tries: u32,
    seed: u64,
    job: &Job,
) -> (Vec<Ball>, String) {
    let mut source = stream(seed, "pack.random_apollonian", 0);
    // The level of the smallest balls: a guess from the scaling N ~ r^-D, for speed only.
    let finest = smallest.max(cap * (1.0 + count as f64).powf(-1.0 / 1.5));
    let mut grid = BallGrid::new(finest);
    let mut balls = Vec::with_capacity(count);
    let (mut largest, mut typical) = (0.0_f64, cap);
    while balls.len() < count {
        let mut radius = 0.0;
        let mut centre = space.bounds.centre();
        for _ in 0..tries {
            let Some(point) = space.sample(&mut source) else { break };
            centre = point;
            let limit = space.clearance(&centre).min(cap);
            radius = space.gap(&grid, &centre, limit, typical, largest);
            if radius > smallest {
                break;
            }
        }
        if radius <= smallest {
            return (balls, format!("ended with no free place in {tries} tries"));
        }
        grid.insert(centre, radius);
        balls.push(Ball { centre, radius });
        largest = largest.max(radius);
        typical += 0.02 * (2.0 * radius - typical);
        if balls.len().is_multiple_of(1024) {
            job.report("balls placed", balls.len() as u64, count as u64);
            if job.is_cancelled() {
                return (balls, "stopped before all were placed".to_owned());
            }
        }
    }
    (balls, "one ball for every grain".to_owned())
}

#[cfg(test)]
mod tests {
    use super::super::samples::{brute_force, of, room, sphere};
    use super::super::{Method, pack};
    use super::*;
    use crate::num::Vec3;
    use std::f64::consts::PI;

    fn pores(balls: &[Ball], dimension: i32) -> f64 {
        let unit = if dimension == 2 { PI } else { 4.0 / 3.0 * PI };
        1.0 - unit * balls.iter().map(|ball| ball.radius.powi(dimension)).sum::<f64>()
    }

    /// Anchors: own measurement with a plain program of another make, 8.2 million balls.
    #[test]
    fn pores_are_those_of_the_reference() {
        let known = [
            (2, 0.05, [(1000, 0.2704), (8000, 0.1481)]),
            (3, 0.03, [(1000, 0.9115), (8000, 0.7136)]),
        ];
        for (dimension, cap, anchors) in known {
            let space = Space::repeating(dimension, Vec3::repeat(1.0));
            let (balls, _) = grown(&space, 8000, cap, 0.0, 100_000, 3, &Job::quiet());
            for (count, expected) in anchors {
                let found = pores(&balls[..count], dimension as i32);
                // One sample of 1000 discs scatters by 1 to 2 %.
                let tolerance = if count == 1000 { 0.04 } else { 0.015 };
                assert!((found / expected - 1.0).abs() < tolerance, "{dimension} {count} {found}");
            }
        }
    }

    #[test]
    fn nothing_overlaps_and_the_end_is_told() {
        for dimension in [2, 3] {
            let clumps = vec![sphere(0.1, dimension); 400];
            let grains = of(&clumps);
            let region = room(&vec![1.0; dimension]);
            let method = Method::RandomApollonian(RandomApollonian::default());
            let packing = pack(&grains, &[], &region, &method, 1, &Job::quiet()).expect("right");
            assert_eq!(packing.placements.len(), 400);
            let (gap, wall) = brute_force(&packing, &grains, &region);
            assert!(gap > -1e-12 && wall > -1e-12, "{gap} {wall}");
            let few = RandomApollonian {
                smallest: Length(0.15),
                tries: 100,
                ..RandomApollonian::default()
            };
            let packing =
                pack(&grains, &[], &region, &Method::RandomApollonian(few), 1, &Job::quiet())
                    .expect("right");
            assert!(packing.outcome.contains("100 tries"), "{}", packing.outcome);
            assert!(packing.placements.iter().all(|laid| laid.scale >= 0.75));
        }
    }

    #[test]
    fn wrong_sizes_are_refused() {
        let wrong = |largest: f64, smallest: f64| {
            let parameters = RandomApollonian {
                largest: Some(Length(largest)),
                smallest: Length(smallest),
                ..RandomApollonian::default()
            };
            parameters.validate().expect_err("is wrong").key
        };
        assert_eq!(wrong(0.0, 0.0), "largest");
        assert_eq!(wrong(1.0, 2.0), "largest");
        assert_eq!(wrong(1.0, -2.0), "smallest");
    }
}
