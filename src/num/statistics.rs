//! Small statistics used by measures, comparisons and reports.

/// Arithmetic mean; `None` for no values.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Standard deviation of a sample: √(Σ(v − mean)² / (n − 1)); `None` for fewer than two values.
pub fn deviation(values: &[f64]) -> Option<f64> {
    let middle = mean(values).filter(|_| values.len() > 1)?;
    let squares: f64 = values.iter().map(|v| (v - middle).powi(2)).sum();
    Some((squares / (values.len() as f64 - 1.0)).sqrt())
}

/// Standard error of the mean of independent values: √(Σ(v − mean)² / (n (n − 1))); `None` for fewer than two.
pub fn standard_error(values: &[f64]) -> Option<f64> {
    let middle = mean(values).filter(|_| values.len() > 1)?;
    let count = values.len() as f64;
    let squares: f64 = values.iter().map(|v| (v - middle).powi(2)).sum();
    Some((squares / (count * (count - 1.0))).sqrt())
}

/// Root of the mean square; `None` for no values.
pub fn root_mean_square(values: &[f64]) -> Option<f64> {
    (!values.is_empty())
        .then(|| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt())
}

/// Quantile by linear interpolation between order statistics, `fraction` in 0..=1;
/// `None` for no values.
pub fn quantile(values: &[f64], fraction: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let place = fraction.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    Some(sorted[below] + (sorted[above] - sorted[below]) * (place - below as f64))
}

/// Median; `None` for no values.
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// Order of convergence: the least-squares slope of ln(error) over ln(step);
/// `None` with fewer than two points or values that have no logarithm.
pub fn order_of_convergence(steps: &[f64], errors: &[f64]) -> Option<f64> {
    if steps.len() != errors.len() || steps.len() < 2 {
        return None;
    }
    let x: Vec<f64> = steps.iter().map(|v| v.ln()).collect();
    let y: Vec<f64> = errors.iter().map(|v| v.ln()).collect();
    let (mx, my) = (mean(&x)?, mean(&y)?);
    let covariance: f64 = x.iter().zip(&y).map(|(a, b)| (a - mx) * (b - my)).sum();
    let variance: f64 = x.iter().map(|a| (a - mx).powi(2)).sum();
    let slope = covariance / variance;
    slope.is_finite().then_some(slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_of_a_power_law() {
        let steps = [0.1, 0.05, 0.025];
        let errors: Vec<f64> = steps.iter().map(|h: &f64| 3.0 * h.powi(2)).collect();
        let order = order_of_convergence(&steps, &errors).expect("two or more points");
        assert!((order - 2.0).abs() < 1e-12);
    }

    #[test]
    fn the_error_of_a_mean_needs_two_values() {
        assert_eq!((standard_error(&[]), standard_error(&[3.0])), (None, None));
        // Deviations ±1 of four values: variance 4/3, over 4 values a third.
        let error = standard_error(&[1.0, 3.0, 1.0, 3.0]).expect("four");
        assert!((error - (1.0_f64 / 3.0).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn quantiles_interpolate() {
        assert_eq!(median(&[3.0, 1.0, 2.0, 4.0]), Some(2.5));
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(quantile(&[5.0], 0.9), Some(5.0));
    }
}
