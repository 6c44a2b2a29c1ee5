//! G8: rough surface with given statistics by linear transformation of a random
//! matrix (Patir 1977).
//!
//! Heights z_ij = Σ_kl α_kl η_(i+k)(j+l), η independent with unit variance; the
//! coefficients solve Σ_kl α_kl α_(k+p)(l+q) = R_pq for the given
//! autocorrelation R. Here α is even in both axes, as R is (Patir's own window
//! of one quadrant leaves R(p, −q) free), k, l = −m … m with m three correlation
//! lengths, at most 20 steps. The equations for lags up to m are solved by Newton
//! steps from the root of the spectrum (inverse cosine transform of √S, Hu &
//! Tonder 1992); steps that make things worse are not taken, and the largest
//! |R − R asked| is reported. Non-Gaussian heights: the filter turns the
//! skewness and the excess kurtosis of η into those of z by the factors
//! Σα³/(Σα²)^1.5 and Σα⁴/(Σα²)², so η gets what comes out as asked; η is a sum of a
//! normal, a two-valued and a three-valued part, which can have any skewness
//! and kurtosis that exist (kurtosis ≥ skewness² + 1). What cannot be done: a
//! pair for which η would have to violate that. Cost O(points²·m²) + O(m⁶).

use super::draw::{Draw, Drawn, Fact};
use super::field::{Field, first_fall};
use super::rough::{Asked, Bounded, Outline, body, validate_points};
use crate::geometry::GeometryError;
use crate::num::Fault;
use crate::num::random::{self, Stream};
use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{E, PI};

/// Autocorrelation R over the scaled lag ρ = √((x/l_x)² + (y/l_y)²).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Autocorrelation {
    /// exp(−ρ).
    #[default]
    Exponential,
    /// exp(−ρ²).
    Gaussian,
    /// The user's own.
    Table {
        /// Step of ρ between values, from 0.01 to 2.
        spacing: f64,
        /// R at ρ = 0 (which must be 1), spacing, 2 spacing, …; 0 beyond the last.
        values: Vec<f64>,
    },
}

/// Rough surface with given autocorrelation, skewness and kurtosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PatirParameters {
    /// RMS height over the side (diameter of a ball), from 1e-5 to 0.2; default 0.02.
    pub rms: f64,
    /// Autocorrelation: `exponential` (default), `gaussian`, or a `table`.
    pub autocorrelation: Autocorrelation,
    /// Correlation lengths l along x and y over the side: where exponential and
    /// Gaussian R fall to 1/e; at least half a step of the grid, at most 8 steps; default [0.1, 0.1].
    pub correlation: [f64; 2],
    /// Skewness of the heights, from -3 to 3; default 0.
    pub skewness: f64,
    /// Kurtosis of the heights, from 1 to 30; default 3 (Gaussian).
    pub kurtosis: f64,
    /// Points along a side, from 8 to 512; default 40.
    pub points: u32,
    /// `ball` (default), `slab = { thickness = 0.3 }` or `sheet` (open, no grain).
    pub body: Bounded,
}

impl Default for PatirParameters {
    fn default() -> Self {
        Self {
            rms: 0.02,
            autocorrelation: Autocorrelation::Exponential,
            correlation: [0.1, 0.1],
            skewness: 0.0,
            kurtosis: 3.0,
            points: 40,
            body: Bounded::Ball,
        }
    }
}

/// Steps of the grid that the half window has at most.
const WINDOW: usize = 20;

impl Autocorrelation {
    fn at(&self, rho: f64) -> f64 {
        match self {
            Self::Exponential => (-rho).exp(),
            Self::Gaussian => (-rho * rho).exp(),
            Self::Table { spacing, values } => {
                let place = rho / spacing;
                let k = place.floor() as usize;
                let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
                value(k) + (value(k + 1) - value(k)) * (place - k as f64)
            }
        }
    }

    /// Scaled lag at which R falls to 1/e, if it does.
    fn length(&self) -> Option<f64> {
        match self {
            Self::Exponential | Self::Gaussian => Some(1.0),
            Self::Table { spacing, values } => first_fall(values, 1.0 / E).map(|k| k * spacing),
        }
    }

    fn validate(&self) -> Result<(), Fault> {
        let Self::Table { spacing, values } = self else { return Ok(()) };
        Fault::within("table.spacing", *spacing, 0.01, 2.0)?;
        for (k, value) in values.iter().enumerate() {
            Fault::within(&format!("table.values[{k}]"), *value, -1.0, 1.0)?;
        }
        if values.first() != Some(&1.0) || values.len() < 2 {
            let allowed = "at least two values, the first of them 1";
            return Err(Fault::new("table.values", "does not start at R(0) = 1", allowed));
        }
        Ok(())
    }
}

impl Draw for PatirParameters {
    fn validate(&self) -> Result<(), Fault> {
        Fault::within("rms", self.rms, 1e-5, 0.2)?;
        validate_points(self.points)?;
        let step = 1.0 / f64::from(self.points - 1);
        for (axis, length) in self.correlation.iter().enumerate() {
            Fault::within(&format!("correlation[{axis}]"), *length, 0.5 * step, 8.0 * step)?;
        }
        self.autocorrelation.validate().map_err(|fault| fault.under("autocorrelation"))?;
        Fault::within("skewness", self.skewness, -3.0, 3.0)?;
        Fault::within("kurtosis", self.kurtosis, self.skewness.powi(2) + 1.0, 30.0)?;
        self.body.validate().map_err(|fault| fault.under("body"))
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let steps = self.correlation.map(|length| length * f64::from(self.points - 1));
        let filter = Filter::new(&self.autocorrelation, steps);
        let source = filter.source(self.skewness, self.kurtosis)?;
        let asked = Asked {
            rms: Some(self.rms),
            skewness: Some(self.skewness),
            kurtosis: Some(self.kurtosis),
            correlation: self
                .autocorrelation
                .length()
                .map(|rho| (self.correlation.map(|length| length * rho), 1.0 / E)),
            dimension: None,
        };
        let recipe = format!("Patir surface, {0} x {0} points", self.points);
        let n = self.points as usize;
        let mut drawn = body(self.body, Outline::Square, &asked, recipe, || {
            Ok(filter.field(n, self.rms, &source, stream))
        })?;
        drawn.facts.push(Fact::asked("largest error of R of the filter", 0.0, filter.error));
        Ok(drawn)
    }
}

/// Even coefficients: the quadrant k, l = 0 … m.
struct Filter {
    m: usize,
    quadrant: Vec<f64>,
    error: f64,
}

impl Filter {
    fn new(autocorrelation: &Autocorrelation, steps: [f64; 2]) -> Self {
        let m = (3.0 * steps[0].max(steps[1])).ceil().clamp(2.0, WINDOW as f64) as usize;
        let wanted = |p: usize, q: usize| {
            autocorrelation.at((p as f64 / steps[0]).hypot(q as f64 / steps[1]))
        };
        let asked: Vec<f64> =
            (0..(m + 1) * (m + 1)).map(|k| wanted(k % (m + 1), k / (m + 1))).collect();
        let mut filter = Self { m, quadrant: spectral_root(&wanted, m), error: 0.0 };
        let (mut residual, mut error) = filter.residual(&asked);
        for _ in 0..12 {
            if error < 1e-10 {
                break;
            }
            let Some(step) = filter.jacobian().lu().solve(&residual) else { break };
            let mut share = 1.0;
            let improved = (0..6).any(|_| {
                let quadrant =
                    filter.quadrant.iter().zip(step.iter()).map(|(a, s)| a - share * s).collect();
                let next = Self { quadrant, ..Self { m, quadrant: Vec::new(), error: 0.0 } };
                let (next_residual, next_error) = next.residual(&asked);
                share *= 0.5;
                let better = next_error < error;
                if better {
                    (filter, residual, error) = (next, next_residual, next_error);
                }
                better
            });
            if !improved {
                break;
            }
        }
        filter.error = error;
        filter
    }

    fn at(&self, k: i64, l: i64) -> f64 {
        let (k, l) = (k.unsigned_abs() as usize, l.unsigned_abs() as usize);
        if k > self.m || l > self.m { 0.0 } else { self.quadrant[l * (self.m + 1) + k] }
    }

    /// All coefficients, (2m + 1)² of them.
    fn all(&self) -> Vec<f64> {
        let m = self.m as i64;
        (-m..=m).flat_map(|l| (-m..=m).map(move |k| self.at(k, l))).collect()
    }

    /// R of the filter less R asked, for the lags of a quadrant, and its largest entry.
    fn residual(&self, asked: &[f64]) -> (DVector<f64>, f64) {
        let m = self.m as i64;
        let side = self.m + 1;
        let residual = DVector::from_fn(side * side, |index, _| {
            let (p, q) = ((index % side) as i64, (index / side) as i64);
            let mut sum = 0.0;
            for l in -m..=m - q {
                for k in -m..=m - p {
                    sum += self.at(k, l) * self.at(k + p, l + q);
                }
            }
            sum - asked[index]
        });
        let error = residual.amax();
        (residual, if error.is_finite() { error } else { f64::INFINITY })
    }

    /// ∂R_pq / ∂α_kl, copies of α_kl in the other quadrants moving along.
    fn jacobian(&self) -> DMatrix<f64> {
        let side = self.m + 1;
        DMatrix::from_fn(side * side, side * side, |row, column| {
            let (p, q) = ((row % side) as i64, (row / side) as i64);
            let (k, l) = ((column % side) as i64, (column / side) as i64);
            let mut sum = 0.0;
            for (i, sign_k) in [k, -k].into_iter().enumerate() {
                for (j, sign_l) in [l, -l].into_iter().enumerate() {
                    // On an axis the copy is the coefficient itself.
                    if (i == 1 && k == 0) || (j == 1 && l == 0) {
                        continue;
                    }
                    sum += self.at(sign_k + p, sign_l + q) + self.at(sign_k - p, sign_l - q);
                }
            }
            sum
        })
    }

    /// The deviate that gives heights of the wanted skewness and kurtosis.
    fn source(&self, skewness: f64, kurtosis: f64) -> Result<Source, GeometryError> {
        let all = self.all();
        let power = |n: i32| all.iter().map(|a| a.powi(n)).sum::<f64>();
        let (two, three, four) = (power(2), power(3), power(4));
        let refused = |reason: String| GeometryError::Method { reason };
        if skewness != 0.0 && three.abs() < 1e-9 * two.powf(1.5) {
            return Err(refused("the filter lets no skewness through".to_owned()));
        }
        let s = if skewness == 0.0 { 0.0 } else { skewness * two.powf(1.5) / three };
        let e = (kurtosis - 3.0) * two * two / four;
        Source::new(s, e).ok_or_else(|| {
            refused(format!(
                "heights of skewness {skewness} and kurtosis {kurtosis} would need a source of \
                 skewness {s:.3} and kurtosis {:.3}, which is less than skewness² + 1: take a \
                 shorter correlation or values nearer to Gaussian ones",
                e + 3.0
            ))
        })
    }

    fn field(&self, points: usize, rms: f64, source: &Source, stream: &mut Stream) -> Field {
        let width = points + 2 * self.m;
        let noise: Vec<f64> = (0..width * width).map(|_| source.draw(stream)).collect();
        let all = self.all();
        let window = 2 * self.m + 1;
        Field::from_fn(points, |i, j| {
            let mut sum = 0.0;
            for l in 0..window {
                let row = &noise[(j + l) * width + i..][..window];
                let weights = &all[l * window..][..window];
                sum += row.iter().zip(weights).map(|(z, a)| z * a).sum::<f64>();
            }
            rms * sum
        })
    }
}

/// Quadrant of the inverse cosine transform of √S, S the cosine transform of R
/// (periodic in 4m steps, negative values set to 0).
fn spectral_root(wanted: &dyn Fn(usize, usize) -> f64, m: usize) -> Vec<f64> {
    let half = 2 * m;
    // cos(π k u / half) with the weights of the ends of an even period.
    let table = DMatrix::from_fn(half + 1, half + 1, |u, k| {
        let weight = if k == 0 || k == half { 1.0 } else { 2.0 };
        weight * (PI * (k * u) as f64 / half as f64).cos()
    });
    let lags = DMatrix::from_fn(half + 1, half + 1, wanted);
    let spectrum = &table * lags * table.transpose();
    let root = spectrum.map(|s| s.max(0.0).sqrt());
    let period = (2 * half) as f64;
    let filter = &table * root * table.transpose() / (period * period);
    let side = m + 1;
    (0..side * side).map(|index| filter[(index % side, index / side)]).collect()
}

/// A deviate of mean 0, variance 1 and given skewness and excess kurtosis: the
/// sum of a normal deviate, one with two values, one with three, in these shares.
struct Source {
    normal: f64,
    two: f64,
    /// Probability of the upper of two values.
    upper: f64,
    three: f64,
    /// Probability of the outer of three values.
    outer: f64,
}

impl Source {
    fn new(skewness: f64, excess: f64) -> Option<Self> {
        // Excess kurtosis that the two-valued part leaves with variance share v.
        let left = |v: f64| excess - (skewness * skewness / v - 2.0 * v * v);
        let share = if skewness == 0.0 {
            if excess >= 0.0 { 0.0 } else { (-0.5 * excess).sqrt() }
        } else if left(0.5) >= 0.0 {
            0.5
        } else {
            // left grows with v; at 1 it must not be negative.
            if left(1.0) < 0.0 {
                return None;
            }
            let (mut low, mut high) = (0.5, 1.0);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if left(middle) < 0.0 { low = middle } else { high = middle }
            }
            high
        };
        if share > 1.0 {
            return None;
        }
        let s = if share > 0.0 { skewness / share.powf(1.5) } else { 0.0 };
        let rest = if share > 0.0 { left(share) } else { excess };
        let three = if rest > 1e-12 && share <= 0.5 { 0.4 } else { 0.0 };
        let outer = if three > 0.0 { 1.0 / (rest / (three * three) + 3.0) } else { 0.0 };
        Some(Self {
            normal: (1.0 - share - three).max(0.0).sqrt(),
            two: share.sqrt(),
            upper: 0.5 * (1.0 - s / (4.0 + s * s).sqrt()),
            three: three.sqrt(),
            outer,
        })
    }

    fn draw(&self, stream: &mut Stream) -> f64 {
        let mut sum = self.normal * random::normal(stream);
        if self.two > 0.0 {
            let odds = ((1.0 - self.upper) / self.upper).sqrt();
            let up = random::uniform(stream, 0.0, 1.0) < self.upper;
            sum += self.two * if up { odds } else { -1.0 / odds };
        }
        if self.three > 0.0 {
            let u = random::uniform(stream, 0.0, 1.0);
            if u < self.outer {
                let sign = if u < 0.5 * self.outer { 1.0 } else { -1.0 };
                sum += self.three * sign / self.outer.sqrt();
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::field::moments;

    #[test]
    fn the_source_has_any_skewness_and_kurtosis_that_exist() {
        for (s, e) in [(0.0, 0.0), (0.0, -1.5), (0.0, 6.0), (1.0, 0.5), (-2.0, 8.0), (3.0, 7.2)] {
            let source = Source::new(s, e).expect("exists");
            let mut stream = random::stream(1, "source", 0);
            let values: Vec<f64> = (0..400_000).map(|_| source.draw(&mut stream)).collect();
            let [mean, rms, skewness, kurtosis] = moments(&values);
            assert!(mean.abs() < 0.01 && (rms - 1.0).abs() < 0.02, "{s} {e}: {mean} {rms}");
            assert!((skewness - s).abs() < 0.1, "{s} {e}: {skewness}");
            assert!((kurtosis - 3.0 - e).abs() < 0.1 * e.abs() + 0.3, "{s} {e}: {kurtosis}");
        }
        assert!(Source::new(3.0, 6.9).is_none(), "kurtosis below skewness² + 1");
        assert!(Source::new(0.0, -2.1).is_none());
    }

    #[test]
    fn the_filter_has_the_autocorrelation_asked_for() {
        let table = Autocorrelation::Table { spacing: 1.0, values: vec![1.0, 0.4, 0.1] };
        for (autocorrelation, steps) in [
            (Autocorrelation::Gaussian, [2.0, 2.0]),
            (Autocorrelation::Exponential, [2.0, 3.0]),
            (table, [1.0, 1.0]),
        ] {
            let filter = Filter::new(&autocorrelation, steps);
            assert!(filter.error < 0.02, "{autocorrelation:?}: {}", filter.error);
        }
    }

    #[test]
    fn heights_have_what_was_asked() {
        let parameters = PatirParameters {
            rms: 0.1,
            correlation: [2.0 / 255.0, 3.0 / 255.0],
            skewness: -0.6,
            kurtosis: 4.0,
            points: 256,
            body: Bounded::Sheet,
            ..Default::default()
        };
        parameters.validate().expect("in their ranges");
        let drawn = parameters.draw(&mut random::stream(2, "patir", 0)).expect("a sheet");
        for (quantity, tolerance) in [
            ("rms height", 0.004),
            ("skewness", 0.12),
            ("kurtosis", 0.5),
            ("length along", 1.2 / 255.0),
        ] {
            for fact in drawn.facts.iter().filter(|f| f.quantity.starts_with(quantity)) {
                let asked = fact.asked.expect("asked");
                assert!((fact.measured - asked).abs() < tolerance, "{fact:?}");
            }
        }
        let refused = PatirParameters { skewness: 2.9, kurtosis: 9.5, ..parameters };
        assert!(refused.draw(&mut random::stream(2, "patir", 0)).is_err());
    }
}
