//! G9: rough surface from its autocorrelation (Whitehouse 1983).
//!
//! Pseudo-random heights by a linear recurrence of second order, along the rows
//! and then along the columns: z_k = a₁ z_(k−1) + a₂ z_(k−2) + b η_k, η standard
//! normal. With a double root r (a₁ = 2r, a₂ = −r²) the correlation is
//! ρ(k) = (1 + k (1−r²)/(1+r²)) r^k; r is chosen so that ρ falls to the given
//! level at the given length (bisection), and beyond it ρ goes on to zero.
//! R(x, y) = ρ_x(x) ρ_y(y). The first heights of each line are run in until the
//! start is forgotten. Cost O(points²).

use super::draw::{Draw, Drawn};
use super::field::Field;
use super::rough::{Asked, Bounded, Outline, body, validate_points};
use crate::geometry::GeometryError;
use crate::num::Fault;
use crate::num::random::{self, Stream};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rough surface from its autocorrelation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WhitehouseParameters {
    /// RMS height over the side (diameter of a ball), from 1e-5 to 0.2; default 0.02.
    pub rms: f64,
    /// Lengths along x and y at which the correlation has fallen to `level`, over the
    /// side, at least one step of the grid, at most 0.5; default [0.15, 0.15].
    pub correlation: [f64; 2],
    /// Correlation that counts as (near) zero, from 0.001 to 0.9; default 0.1.
    pub level: f64,
    /// Points along a side, from 8 to 512; default 40.
    pub points: u32,
    /// `ball` (default), `slab = { thickness = 0.3 }` or `sheet` (open, no grain).
    pub body: Bounded,
}

impl Default for WhitehouseParameters {
    fn default() -> Self {
        Self { rms: 0.02, correlation: [0.15, 0.15], level: 0.1, points: 40, body: Bounded::Ball }
    }
}

impl Draw for WhitehouseParameters {
    fn validate(&self) -> Result<(), Fault> {
        Fault::within("rms", self.rms, 1e-5, 0.2)?;
        validate_points(self.points)?;
        let step = 1.0 / f64::from(self.points - 1);
        for (axis, length) in self.correlation.iter().enumerate() {
            Fault::within(&format!("correlation[{axis}]"), *length, step, 0.5)?;
        }
        Fault::within("level", self.level, 1e-3, 0.9)?;
        self.body.validate().map_err(|fault| fault.under("body"))
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let asked = Asked {
            rms: Some(self.rms),
            skewness: Some(0.0),
            kurtosis: Some(3.0),
            correlation: Some((self.correlation, self.level)),
            dimension: None,
        };
        let recipe = format!("Whitehouse surface, {0} x {0} points", self.points);
        body(self.body, Outline::Square, &asked, recipe, || Ok(self.field(stream)))
    }
}

impl WhitehouseParameters {
    fn field(&self, stream: &mut Stream) -> Field {
        let n = self.points as usize;
        let steps = self.correlation.map(|length| length * (n - 1) as f64);
        let roots = steps.map(|length| root(length, self.level));
        // The start is forgotten to 1e-8 or so after this many steps.
        let lead = roots.map(|r| (20.0 / -r.ln()).ceil() as usize + 2);
        let [a, b] = [0, 1].map(|axis| Recurrence::new(roots[axis]));
        let width = n + lead[0];
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(n + lead[1]);
        for _ in 0..n + lead[1] {
            let noise: Vec<f64> = (0..width).map(|_| random::normal(stream)).collect();
            rows.push(a.run(&noise)[lead[0]..].to_vec());
        }
        let columns: Vec<Vec<f64>> = (0..n)
            .map(|i| {
                let column: Vec<f64> = rows.iter().map(|row| row[i]).collect();
                b.run(&column)[lead[1]..].to_vec()
            })
            .collect();
        Field::from_fn(n, |i, j| self.rms * columns[i][j])
    }
}

/// ρ(k) of the recurrence with the double root r.
fn correlation(r: f64, k: f64) -> f64 {
    (1.0 + k * (1.0 - r * r) / (1.0 + r * r)) * r.powf(k)
}

/// The double root for which the correlation is `level` after `steps`.
fn root(steps: f64, level: f64) -> f64 {
    let (mut low, mut high) = (1e-6, 1.0 - 1e-9);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if correlation(middle, steps) < level { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// z_k = 2r z_(k−1) − r² z_(k−2) + b η_k with unit variance.
struct Recurrence {
    r: f64,
    b: f64,
}

impl Recurrence {
    fn new(r: f64) -> Self {
        // Variance of an autoregression of second order with a double root, b = 1:
        // (1 + r²) / (1 − r²)³.
        let b = ((1.0 - r * r).powi(3) / (1.0 + r * r)).sqrt();
        Self { r, b }
    }

    fn run(&self, noise: &[f64]) -> Vec<f64> {
        let (mut before, mut last) = (0.0, 0.0);
        noise
            .iter()
            .map(|eta| {
                let next = 2.0 * self.r * last - self.r * self.r * before + self.b * eta;
                (before, last) = (last, next);
                next
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::field::{first_fall, moments};

    #[test]
    fn the_recurrence_has_unit_variance_and_the_wanted_correlation() {
        for (steps, level) in [(4.0, 0.1), (9.0, 0.3679), (2.0, 0.01)] {
            let r = root(steps, level);
            assert!((correlation(r, steps) - level).abs() < 1e-9);
            let mut stream = random::stream(1, "whitehouse", 0);
            let noise: Vec<f64> = (0..200_000).map(|_| random::normal(&mut stream)).collect();
            let line = Recurrence::new(r).run(&noise);
            let [mean, rms, ..] = moments(&line);
            assert!(mean.abs() < 0.05 && (rms - 1.0).abs() < 0.03, "{mean} {rms}");
            let k = steps as usize;
            let found = line.windows(k + 1).map(|w| w[0] * w[k]).sum::<f64>() / 200_000.0;
            assert!((found - level).abs() < 0.03, "{found} {level}");
        }
    }

    #[test]
    fn fields_have_what_was_asked() {
        let parameters = WhitehouseParameters {
            rms: 0.05,
            correlation: [0.06, 0.03],
            points: 256,
            body: Bounded::Sheet,
            ..Default::default()
        };
        let field = parameters.field(&mut random::stream(2, "whitehouse", 0));
        let [_, rms, skewness, kurtosis] = moments(&field.heights);
        assert!((rms / 0.05 - 1.0).abs() < 0.15, "{rms}");
        assert!(skewness.abs() < 0.3 && (kurtosis - 3.0).abs() < 0.5, "{skewness} {kurtosis}");
        for (axis, length) in [(0, 0.06), (1, 0.03)] {
            let curve = field.autocorrelation(axis, 60);
            let found = first_fall(&curve, 0.1).expect("falls") / 255.0;
            assert!((found / length - 1.0).abs() < 0.3, "{found} {length}");
        }
    }
}
