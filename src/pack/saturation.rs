//! How dense random sequential addition of equal balls gets: the limit of infinite time, extrapolated.
//!
//! Balls go one by one to random places and stay where they overlap nothing. The solid fraction nears its
//! limit as t^(−1/d) (Feder 1980, J. Theor. Biol. 87, 237), with t tries times the volume of
//! a ball over that of the box: so the fraction at the end of an endless trial is the intercept of a straight line.
//! Known limits: discs 0.5471, spheres 0.3841.
//!
//! Cost one search a try. Memory O(balls).

use super::space::Space;
use super::target::ball_volume;
use crate::geometry::BallGrid;
use crate::num::Job;
use crate::num::random::stream;

/// Solid fractions after so many tries (as t), twelve a decade, from `tries` tries with balls of `radius` m.
pub fn history(space: &Space, radius: f64, tries: u64, seed: u64, job: &Job) -> Vec<(f64, f64)> {
    let mut source = stream(seed, "pack.saturation", 0);
    let mut grid = BallGrid::new(radius);
    let share = ball_volume(&[radius], space.dimension) / space.volume();
    let (mut points, mut next) = (Vec::new(), 1000.0_f64.min(tries as f64));
    for tried in 1..=tries {
        let Some(centre) = space.sample(&mut source) else { break };
        if space.clearance(&centre) >= radius && !space.overlaps(&grid, &centre, radius, radius) {
            grid.insert(centre, radius);
        }
        if tried as f64 >= next || tried == tries {
            points.push((tried as f64 * share, grid.len() as f64 * share));
            next *= 10.0_f64.powf(1.0 / 12.0);
            job.report("tries", tried, tries);
            if job.is_cancelled() {
                break;
            }
        }
    }
    points
}

/// The fraction at infinite t: a straight line in t^(−1/d) through the last decade of `points`.
pub fn limit(points: &[(f64, f64)], dimension: usize) -> Option<f64> {
    let last = points.last()?.0;
    let line: Vec<(f64, f64)> = points
        .iter()
        .filter(|(t, _)| *t >= 0.1 * last)
        .map(|(t, share)| (t.powf(-1.0 / dimension as f64), *share))
        .collect();
    let count = line.len() as f64;
    let (x, y) = line.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / count, y + p.1 / count));
    let slope_over = line.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>();
    let slope_under = line.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>();
    (slope_under > 0.0).then(|| y - slope_over / slope_under * x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Vec3;

    #[test]
    fn limits_are_those_known() {
        for (dimension, radius, expected) in [(2, 0.012, 0.5471), (3, 0.06, 0.3841)] {
            let space = Space::repeating(dimension, Vec3::repeat(1.0));
            let points = history(&space, radius, 200_000, 1, &Job::quiet());
            let found = limit(&points, dimension).expect("points");
            // Some hundred balls scatter by a few per cent; the study has many.
            assert!((found / expected - 1.0).abs() < 0.04, "{dimension} {found}");
        }
    }
}
