//! Restitution of the linear spring-dashpot contact, and the dashpot that gives it (D2).
//!
//! With k the stiffness, m the effective mass, ζ = c / (2 √(k m)):
//! - tension kept (contact ends at overlap 0): e = exp(−π ζ / √(1 − ζ²)), ζ < 1;
//! - tension clipped (contact ends where the force would pull):
//!   e = exp(−2 ζ acos ζ / √(1 − ζ²)) for ζ < 1, exp(−2) at ζ = 1,
//!   exp(−2 ζ acosh ζ / √(ζ² − 1)) for ζ > 1
//!   (Schwager & Pöschel 2007, Granular Matter 9, 465, eq. 17–21, with
//!   π − atan2(2ζ√(1−ζ²), 1−2ζ²) = 2 acos ζ).

use std::f64::consts::PI;

/// Coefficient of restitution of a normal impact at damping ratio `zeta` ≥ 0.
/// With `tension` kept there is no rebound for `zeta` ≥ 1: 0.
pub fn restitution(zeta: f64, tension: bool) -> f64 {
    if tension {
        return if zeta < 1.0 { (-PI * zeta / (1.0 - zeta * zeta).sqrt()).exp() } else { 0.0 };
    }
    let gap = (1.0 - zeta * zeta).abs().sqrt();
    // Near ζ = 1 both branches tend to exp(−2 ζ).
    if gap < 1e-6 {
        return (-2.0 * zeta).exp();
    }
    let angle = if zeta < 1.0 { zeta.acos() } else { zeta.acosh() };
    (-2.0 * zeta * angle / gap).exp()
}

/// Damping ratio ζ that gives `wanted` restitution, 0 < `wanted` ≤ 1; `None` outside.
///
/// Bisection on the formula of the variant: it falls monotonically with ζ.
pub fn damping_ratio(wanted: f64, tension: bool) -> Option<f64> {
    if !(wanted > 0.0 && wanted <= 1.0) {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while restitution(high, tension) > wanted {
        high *= 2.0;
        if high > 1e150 {
            return None;
        }
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if restitution(middle, tension) > wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

/// Dashpot c (N s/m) for `wanted` restitution at stiffness (N/m) and effective mass (kg).
pub fn dashpot(wanted: f64, stiffness: f64, effective_mass: f64, tension: bool) -> Option<f64> {
    if wanted == 1.0 {
        return Some(0.0);
    }
    damping_ratio(wanted, tension).map(|zeta| 2.0 * zeta * (stiffness * effective_mass).sqrt())
}

/// Damping ratio ζ of a dashpot (N s/m) at stiffness (N/m) and effective mass (kg).
pub fn ratio_of(dashpot: f64, stiffness: f64, effective_mass: f64) -> f64 {
    dashpot / (2.0 * (stiffness * effective_mass).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    // Sphere on wall, m = 0.010471975511965977 kg, k = 1e5 N/m (closed form, 50 digits).
    const MASS: f64 = 0.010471975511965977;

    #[test]
    fn published_roots() {
        let clipped = damping_ratio(0.5, false).expect("0.5 can be reached");
        assert!((clipped - 0.2552756376486518).abs() < 1e-14, "{clipped}");
        let kept = damping_ratio(0.5, true).expect("0.5 can be reached");
        assert!((kept - 0.21545376196624678).abs() < 1e-14, "{kept}");
        let c = dashpot(0.5, 1e5, MASS, false).expect("0.5 can be reached");
        assert!((c - 16.52165976342672).abs() < 1e-11, "{c}");
    }

    #[test]
    fn dashpot_of_the_other_law_gives_the_published_error() {
        for (asked, got) in
            [(0.9, 0.90202607), (0.5, 0.55028317), (0.2, 0.32486285), (0.1, 0.25272938)]
        {
            let zeta = damping_ratio(asked, true).expect("can be reached");
            assert!((restitution(zeta, false) - got).abs() < 5e-9, "{asked}");
        }
        assert!((restitution(1.0, false) - (-2.0f64).exp()).abs() < 1e-15);
    }

    #[test]
    fn there_and_back() {
        for tension in [false, true] {
            for e in [1.0, 0.999, 0.9, 0.5, 0.1, 1e-3, 1e-6] {
                let zeta = damping_ratio(e, tension).expect("can be reached");
                assert!((restitution(zeta, tension) / e - 1.0).abs() < 1e-9, "{e} {tension}");
            }
        }
        assert_eq!(damping_ratio(0.0, false), None);
        assert_eq!(damping_ratio(1.2, false), None);
        assert_eq!(damping_ratio(f64::NAN, false), None);
    }
}
