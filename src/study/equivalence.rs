//! Mean differences of pairs with confidence intervals, and whether they show equivalence.
//!
//! Differences d of n pairs: their mean with ± t s/√n, t of n − 1 degrees of freedom (Student
//! 1908). Equivalence within a margin by two one-sided tests at 5 % (Schuirmann 1987): shown where
//! the 90 % interval of the difference lies within ± the margin. Cost: O(values).

use crate::num::statistics::{deviation, mean};

/// Quantiles of the normal distribution: of two-sided intervals of 90 and 95 %.
const NINETY: f64 = 1.644_853_627;
const NINETY_FIVE: f64 = 1.959_963_985;

/// Mean and half width of its two-sided 90 % confidence interval.
pub fn interval(values: &[f64]) -> (f64, f64) {
    interval_at(values, NINETY)
}

/// Mean and half width of its two-sided 95 % confidence interval.
pub fn interval_95(values: &[f64]) -> (f64, f64) {
    interval_at(values, NINETY_FIVE)
}

fn interval_at(values: &[f64], z: f64) -> (f64, f64) {
    let count = values.len() as f64;
    let half = student(count - 1.0, z) * deviation(values).unwrap_or(f64::NAN) / count.sqrt();
    (mean(values).unwrap_or(f64::NAN), half)
}

/// A mean difference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Mean of the differences.
    pub middle: f64,
    /// Half width of the 90 % confidence interval.
    pub half_90: f64,
    /// Half width of the 95 % confidence interval.
    pub half_95: f64,
}

/// What two one-sided tests at 5 % say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The 90 % interval lies within the margin.
    Equivalent,
    /// The 90 % interval lies outside the margin.
    Different,
    /// Neither: more seeds would tell.
    NotShown,
}

impl Verdict {
    /// For tables.
    pub fn text(self) -> &'static str {
        match self {
            Self::Equivalent => "equivalent",
            Self::Different => "different",
            Self::NotShown => "not shown",
        }
    }
}

impl Difference {
    /// Of `sample` from `reference`, pair by pair; at least two.
    pub fn of_pairs(sample: &[f64], reference: &[f64]) -> Self {
        let differences: Vec<f64> = sample.iter().zip(reference).map(|(a, b)| a - b).collect();
        let (middle, half_90) = interval(&differences);
        Self { middle, half_90, half_95: interval_95(&differences).1 }
    }

    /// Equivalence within ± `margin`.
    pub fn verdict(&self, margin: f64) -> Verdict {
        if self.middle.abs() + self.half_90 <= margin {
            Verdict::Equivalent
        } else if self.middle.abs() - self.half_90 > margin {
            Verdict::Different
        } else {
            Verdict::NotShown
        }
    }

    /// Largest difference that the 95 % interval allows.
    pub fn bound(&self) -> f64 {
        self.middle.abs() + self.half_95
    }
}

/// Quantile of Student's t where that of the normal distribution is `z` (Abramowitz & Stegun
/// 26.7.5; off by less than 1 % from 2 degrees of freedom on).
fn student(freedom: f64, z: f64) -> f64 {
    let sum = |terms: &[(f64, i32)], below: f64| -> f64 {
        terms.iter().map(|(factor, power)| factor * z.powi(*power)).sum::<f64>() / below
    };
    let powers = [
        sum(&[(1.0, 3), (1.0, 1)], 4.0),
        sum(&[(5.0, 5), (16.0, 3), (3.0, 1)], 96.0),
        sum(&[(3.0, 7), (19.0, 5), (17.0, 3), (-15.0, 1)], 384.0),
        sum(&[(79.0, 9), (776.0, 7), (1482.0, 5), (-1920.0, 3), (-945.0, 1)], 92_160.0),
    ];
    powers.iter().zip(1..).fold(z, |t, (power, n)| t + power / freedom.powi(n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random;

    #[test]
    fn quantiles_of_student() {
        for (freedom, known) in [(2.0, 2.920), (5.0, 2.015), (10.0, 1.8125), (23.0, 1.7139)] {
            assert!((student(freedom, NINETY) / known - 1.0).abs() < 5e-3, "{freedom}");
        }
        for (freedom, known) in [(2.0, 4.3027), (5.0, 2.5706), (29.0, 2.0452)] {
            assert!((student(freedom, NINETY_FIVE) / known - 1.0).abs() < 1e-2, "{freedom}");
        }
    }

    #[test]
    fn pairs_by_hand() {
        // Differences 1, 2, 3, 4, 5: mean 3, deviation 1.5811, t(4) = 2.1318 and 2.7764.
        let found = Difference::of_pairs(&[2.0, 4.0, 6.0, 8.0, 10.0], &[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(found.middle, 3.0);
        assert!((found.half_90 - 2.1318 * 0.5_f64.sqrt()).abs() < 2e-3, "{found:?}");
        assert!((found.half_95 - 2.7764 * 0.5_f64.sqrt()).abs() < 4e-3, "{found:?}");
        assert_eq!(found.verdict(5.0), Verdict::Equivalent);
        assert_eq!(found.verdict(3.5), Verdict::NotShown);
        assert_eq!(found.verdict(1.0), Verdict::Different);
    }

    #[test]
    fn intervals_hold_the_true_difference_as_often_as_they_say() {
        let mut source = random::stream(3, "equivalence", 0);
        let mut draw = |count: usize, wide: f64| -> Vec<f64> {
            (0..count)
                .map(|_| {
                    wide * (0..12).map(|_| random::uniform(&mut source, -0.5, 0.5)).sum::<f64>()
                })
                .collect()
        };
        let inside = (0..4000)
            .filter(|_| {
                let found = Difference::of_pairs(&draw(6, 1.0), &draw(6, 2.0));
                found.middle.abs() <= found.half_95
            })
            .count();
        assert!((3750..3850).contains(&inside), "{inside} of 4000");
    }
}
