//! Force-biased packings of mixtures of sizes against the theory of rods on a line (Farr & Groot 2009), which its
//! authors hold to be good to about 0.01.

use super::super::StudyError;
use super::methods::{sampled, samples, unit_ball, unit_box};
use super::{Case, Row};
use crate::num::Job;
use crate::pack::grading::normal_quantile;
use crate::pack::{force_biased, rods};

/// Share by which the outer radius shrinks in two rounds.
const RATE: f64 = 3e-5;

/// Radii by quantiles: the size that a share of the number is smaller than.
type Quantile = fn(f64) -> f64;

/// Number share of the small ones where a share `large` of the volume is in balls of twice the size.
fn small(large: f64) -> f64 {
    (1.0 - large) / (1.0 - large + large / 8.0)
}

fn binary(share: f64, large: f64) -> f64 {
    if share < small(large) { 1.0 } else { 2.0 }
}

const MIXTURES: [(&str, Quantile); 7] = [
    ("equal", |_| 1.0),
    ("uniform radii 0.5 to 1", |share| 0.5 + 0.5 * share),
    ("uniform radii 0.1 to 1", |share| 0.1 + 0.9 * share),
    ("lognormal radii of deviation 0.3", |share| (0.3 * normal_quantile(share)).exp()),
    ("lognormal radii of deviation 0.6", |share| (0.6 * normal_quantile(share)).exp()),
    ("radii 1 and 2; 0.3 of the volume large", |share| binary(share, 0.3)),
    ("radii 1 and 2; 0.7 of the volume large", |share| binary(share, 0.7)),
];

/// All mixtures.
pub fn mixtures(full: bool, job: &Job, rows: &mut Vec<Row>) -> Result<(), StudyError> {
    let count = if full { 4000 } else { 1000 };
    for (index, (name, quantile)) in MIXTURES.into_iter().enumerate() {
        // One narrow, one wide, one of two sizes when time is short.
        if !full && ![1, 3, 6].contains(&index) {
            continue;
        }
        let radii: Vec<f64> =
            (0..count).map(|i| quantile((i as f64 + 0.5) / count as f64)).collect();
        let even: Vec<(f64, f64)> = radii.iter().map(|&radius| (2.0 * radius, 1.0)).collect();
        let theory = rods::closest(&even).unwrap_or(f64::NAN);
        let volume: f64 = radii.iter().map(|radius| unit_ball(3) * radius.powi(3)).sum();
        let (found, seconds) = sampled(samples(full), job, |seed| {
            force_biased::densest(&unit_box(3), &radii, RATE, f64::INFINITY, seed, job)
                .map(|found| volume * found.factor.powi(3))
        })?;
        let shares: Vec<f64> = found.into_iter().flatten().collect();
        let case = Case {
            method: "force_biased",
            dimension: 3,
            balls: count,
            setting: format!("{name}; rate {RATE:.0e}"),
            seconds,
        };
        let known = (theory, "rods on a line: Farr & Groot 2009");
        rows.push(case.row("solid fraction of a mixture", &shares, known));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixtures_are_what_their_names_say() {
        let radii = |index: usize| -> Vec<f64> {
            (0..4000).map(|i| MIXTURES[index].1((f64::from(i) + 0.5) / 4000.0)).collect()
        };
        let volume = |radii: &[f64]| radii.iter().map(|r| r.powi(3)).sum::<f64>();
        for (index, large) in [(5, 0.3), (6, 0.7)] {
            let all = radii(index);
            let big: Vec<f64> = all.iter().copied().filter(|r| *r > 1.5).collect();
            assert!((volume(&big) / volume(&all) - large).abs() < 2e-3, "{large}");
        }
        let logs: Vec<f64> = radii(4).iter().map(|r| r.ln().powi(2)).collect();
        assert!((logs.iter().sum::<f64>() / 4000.0 - 0.36).abs() < 2e-3);
        let uniform = radii(2);
        assert!(uniform[0] > 0.1 && uniform[3999] < 1.0 && (uniform[1999] - 0.55).abs() < 1e-3);
    }
}
