//! Differences of means with confidence intervals, and whether they show equivalence.
//!
//! Welch (1947): the difference of the means of two independent samples has the variance
//! s1²/n1 + s2²/n2, and its Student's t has the degrees of freedom of Satterthwaite (1946).
//! Equivalence within a margin by two one-sided tests at 5 % (Schuirmann 1987): shown where the
//! 90 % interval of the difference lies within ± the margin. Cost: O(values).

use crate::num::statistics::mean;

/// Quantiles of the normal distribution: of two-sided intervals of 90 and 95 %.
const NINETY: f64 = 1.644_853_627;
const NINETY_FIVE: f64 = 1.959_963_985;

/// Standard deviation of a sample; NaN for less than two values.
pub fn deviation(values: &[f64]) -> f64 {
    let middle = mean(values).unwrap_or(f64::NAN);
    let squares: f64 = values.iter().map(|value| (value - middle).powi(2)).sum();
    (squares / (values.len() as f64 - 1.0)).sqrt()
}

/// Mean and half width of its two-sided 90 % confidence interval.
pub fn interval(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let half = student(count - 1.0, NINETY) * deviation(values) / count.sqrt();
    (mean(values).unwrap_or(f64::NAN), half)
}

/// A difference of two means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Mean of the sample less that of the reference.
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
    /// Of two independent samples of at least two values each.
    pub fn between(sample: &[f64], reference: &[f64]) -> Self {
        let part = |values: &[f64]| deviation(values).powi(2) / values.len() as f64;
        let (a, b) = (part(sample), part(reference));
        let freedom = (a + b).powi(2)
            / (a * a / (sample.len() as f64 - 1.0) + b * b / (reference.len() as f64 - 1.0));
        let middle = |values: &[f64]| mean(values).unwrap_or(f64::NAN);
        // Two samples without any scatter have an interval of no width.
        let half = |z| if a + b > 0.0 { student(freedom, z) * (a + b).sqrt() } else { 0.0 };
        Self {
            middle: middle(sample) - middle(reference),
            half_90: half(NINETY),
            half_95: half(NINETY_FIVE),
        }
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
    fn welch_by_hand() {
        // Means 3 and 5, variances 2.5 and 10: t over 1.5811 with 5.8824 degrees of freedom.
        let found = Difference::between(&[1.0, 2.0, 3.0, 4.0, 5.0], &[1.0, 3.0, 5.0, 7.0, 9.0]);
        assert_eq!(found.middle, -2.0);
        assert!((found.half_95 - 2.458_6 * 2.5_f64.sqrt()).abs() < 0.01, "{found:?}");
        assert_eq!(found.verdict(6.0), Verdict::Equivalent);
        assert_eq!(found.verdict(3.0), Verdict::NotShown);
        assert_eq!(Difference { half_90: 0.5, ..found }.verdict(1.0), Verdict::Different);
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
                let found = Difference::between(&draw(6, 1.0), &draw(15, 2.0));
                found.middle.abs() <= found.half_95
            })
            .count();
        assert!((3750..3850).contains(&inside), "{inside} of 4000");
    }
}
