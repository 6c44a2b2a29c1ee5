//! Height fields on a square grid, and their statistics.
//!
//! RMS height (Sq), skewness (Ssk) and kurtosis (Sku, 3 for Gaussian heights)
//! about the mean: ISO 25178-2. Autocorrelation R(k) along x and y from all
//! pairs of points k steps apart; correlation length: where R first falls to a
//! level, by linear interpolation. Fractal dimension D = 3 − H from the
//! structure function S(k) = ⟨(z(x+k) − z(x))²⟩ ∝ k^(2H), slope between lags of 1
//! and an eighth of the side (Russ 1994). Cost O(points² · lags).

/// Heights z at points (i·spacing, j·spacing), row j after row.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Points along each side.
    pub points: usize,
    /// Heights, `points`² of them.
    pub heights: Vec<f64>,
}

impl Field {
    /// A field of the values that `at(i, j)` gives for column i of row j.
    pub fn from_fn(points: usize, mut at: impl FnMut(usize, usize) -> f64) -> Self {
        let heights = (0..points * points).map(|k| at(k % points, k / points)).collect();
        Self { points, heights }
    }

    /// Height at column i of row j.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.heights[j * self.points + i]
    }

    /// Height at the point (u, v) of the unit square, by bilinear interpolation.
    pub fn interpolated(&self, u: f64, v: f64) -> f64 {
        let last = self.points - 1;
        let cell = |t: f64| {
            let place = t.clamp(0.0, 1.0) * last as f64;
            let low = (place.floor() as usize).min(last - 1);
            (low, place - low as f64)
        };
        let ((i, a), (j, b)) = (cell(u), cell(v));
        let row = |j: usize| self.at(i, j) * (1.0 - a) + self.at(i + 1, j) * a;
        row(j) * (1.0 - b) + row(j + 1) * b
    }

    /// The same field with mean 0 and RMS height `rms`; unchanged where it is flat.
    pub fn scaled_to(mut self, rms: f64) -> Self {
        let [mean, found, ..] = moments(&self.heights);
        if found > 0.0 {
            self.heights.iter_mut().for_each(|z| *z = (*z - mean) * rms / found);
        }
        self
    }

    /// R at lags of 0, 1, … `lags` steps along x (axis 0) or y (axis 1).
    pub fn autocorrelation(&self, axis: usize, lags: usize) -> Vec<f64> {
        let [mean, rms, ..] = moments(&self.heights);
        let pairs = |lag: usize| {
            let mut sum = 0.0;
            for j in 0..self.points - if axis == 1 { lag } else { 0 } {
                for i in 0..self.points - if axis == 0 { lag } else { 0 } {
                    let (k, l) = if axis == 0 { (i + lag, j) } else { (i, j + lag) };
                    sum += (self.at(i, j) - mean) * (self.at(k, l) - mean);
                }
            }
            sum / (self.points * (self.points - lag)) as f64 / (rms * rms)
        };
        (0..=lags.min(self.points - 1)).map(pairs).collect()
    }

    /// Fractal dimension from the structure function, both axes.
    pub fn fractal_dimension(&self) -> f64 {
        let last = (self.points / 8).max(2);
        let (mut xs, mut ys) = (Vec::new(), Vec::new());
        let mut lag = 1;
        while lag <= last {
            let (mut sum, mut count) = (0.0, 0.0);
            for a in 0..self.points - lag {
                for b in 0..self.points {
                    sum += (self.at(a + lag, b) - self.at(a, b)).powi(2);
                    sum += (self.at(b, a + lag) - self.at(b, a)).powi(2);
                    count += 2.0;
                }
            }
            xs.push(lag as f64);
            ys.push(sum / count);
            lag *= 2;
        }
        crate::num::statistics::order_of_convergence(&xs, &ys)
            .map_or(2.0, |slope| 3.0 - 0.5 * slope)
    }
}

/// Mean, RMS about the mean, skewness and kurtosis.
pub fn moments(values: &[f64]) -> [f64; 4] {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let power = |k: i32| values.iter().map(|z| (z - mean).powi(k)).sum::<f64>() / n;
    let rms = power(2).sqrt();
    if rms == 0.0 {
        return [mean, 0.0, 0.0, 0.0];
    }
    [mean, rms, power(3) / rms.powi(3), power(4) / rms.powi(4)]
}

/// Where `curve` (values at 0, 1, 2, …) first falls to `level`; `None` if it does not.
pub fn first_fall(curve: &[f64], level: f64) -> Option<f64> {
    let k = curve.windows(2).position(|pair| pair[0] > level && pair[1] <= level)?;
    Some(k as f64 + (curve[k] - level) / (curve[k] - curve[k + 1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random;
    use std::f64::consts::TAU;

    #[test]
    fn a_wave_has_its_closed_forms() {
        let wave = Field::from_fn(128, |i, _| 3.0 * (TAU * i as f64 / 32.0).cos());
        let [mean, rms, skewness, kurtosis] = moments(&wave.heights);
        assert!(mean.abs() < 1e-12 && (rms - 4.5f64.sqrt()).abs() < 1e-12);
        assert!(skewness.abs() < 1e-12 && (kurtosis - 1.5).abs() < 1e-12);
        let along = wave.autocorrelation(0, 16);
        // The last lags miss some pairs of a whole wave.
        assert!((first_fall(&along, 0.0).expect("falls") - 8.0).abs() < 0.3);
        assert!(wave.autocorrelation(1, 8).iter().all(|r| (r - 1.0).abs() < 1e-12));
        let scaled = wave.scaled_to(0.1);
        assert!((moments(&scaled.heights)[1] - 0.1).abs() < 1e-12);
    }

    #[test]
    fn white_noise_has_no_memory_and_dimension_three() {
        let mut stream = random::stream(1, "field", 0);
        let noise = Field::from_fn(96, |_, _| random::normal(&mut stream));
        assert!(noise.autocorrelation(0, 3)[1].abs() < 0.04);
        assert!((noise.fractal_dimension() - 3.0).abs() < 0.05);
        let plane = Field::from_fn(64, |i, j| i as f64 + 2.0 * j as f64);
        assert!((plane.fractal_dimension() - 2.0).abs() < 1e-9);
        let flat = Field::from_fn(4, |_, _| 1.0).scaled_to(2.0);
        assert_eq!(moments(&flat.heights)[1], 0.0);
    }

    #[test]
    fn interpolation_is_exact_at_points_and_for_planes() {
        let plane = Field::from_fn(9, |i, j| 2.0 * i as f64 - j as f64);
        assert!((plane.interpolated(0.5, 0.25) - 6.0).abs() < 1e-12);
        assert!((plane.interpolated(1.0, 1.0) - 8.0).abs() < 1e-12);
        assert!((plane.interpolated(-3.0, 0.33) + 2.64).abs() < 1e-12);
    }
}
