//! Volumes that a ball shares with a box, a half-space or another ball, and areas that a
//! disc shares with a rectangle or another disc, in closed form.
//!
//! A box is inclusion and exclusion over its corners: V = Σ ± O(corner), with O(a, b, c) the part of the
//! unit ball where x > a, y > b, z > c. For a, b, c ≥ 0 and a² + b² + c² < 1, by the divergence theorem,
//! 3 O = S − a F_a − b F_b − c F_c, with flat faces F and the spherical face by Gauss–Bonnet,
//! S = Σθ − π − aφ_a − bφ_b − cφ_c; θ_ab = acos(ab / √((1−a²)(1−b²))) are its angles and φ_a the turn of its
//! edge about the axis of a. Negative numbers by reflection: O(−a, b, c) = W(b, c) − O(a, b, c), W the
//! wedge y > b, z > c. Own derivation; after Strobl, Formella & Pöschel 2016 (J. Comput. Phys. 311,
//! 158), who treat tetrahedra. Lens of two balls: textbook.
//!
//! O(1); absolute error a few 1e-16 of the ball's volume. Cannot fail.

use super::Bounds;
use crate::num::Vec3;
use std::f64::consts::PI;

/// Volume of a ball, m³, or area of a disc, m².
pub fn ball(radius: f64, dimension: usize) -> f64 {
    if dimension == 2 { PI * radius * radius } else { 4.0 / 3.0 * PI * radius.powi(3) }
}

/// What a ball (disc in two dimensions) shares with a box, m³ (m²).
pub fn ball_and_box(centre: &Vec3, radius: f64, bounds: &Bounds, dimension: usize) -> f64 {
    if radius <= 0.0 {
        return 0.0;
    }
    let side = |axis: usize| {
        let scaled = |x: f64| ((x - centre[axis]) / radius).clamp(-1.0, 1.0);
        [scaled(bounds.low[axis]), scaled(bounds.high[axis])]
    };
    let (x, y) = (side(0), side(1));
    let mut share = 0.0;
    for (i, &a) in x.iter().enumerate() {
        for (j, &b) in y.iter().enumerate() {
            if dimension == 2 {
                share += sign(i + j) * quadrant(a, b);
                continue;
            }
            for (k, &c) in side(2).iter().enumerate() {
                share += sign(i + j + k) * octant([a, b, c]);
            }
        }
    }
    share.max(0.0) * radius.powi(dimension as i32)
}

fn sign(highs: usize) -> f64 {
    if highs.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// What two balls (discs) of radii `r` and `s` share whose centres are `distance` apart, m³ (m²).
pub fn two_balls(distance: f64, r: f64, s: f64, dimension: usize) -> f64 {
    if distance >= r + s {
        return 0.0;
    }
    if distance <= (r - s).abs() {
        return ball(r.min(s), dimension);
    }
    let d = distance;
    if dimension == 3 {
        let depth = r + s - d;
        return PI * depth * depth * (d * d + 2.0 * d * (r + s) - 3.0 * (r - s) * (r - s))
            / (12.0 * d);
    }
    let part = |a: f64, b: f64| {
        let x = (d * d + a * a - b * b) / (2.0 * d);
        a * a * arc((x / a).clamp(-1.0, 1.0))
    };
    part(r, s) + part(s, r)
}

/// Circle and half-height of the lens of two balls that overlap: where its middle is along the
/// way from the first (m), and the radius of a ball about there that holds the lens, m.
pub fn lens(distance: f64, r: f64, s: f64) -> (f64, f64) {
    if distance <= (r - s).abs() {
        return (if r > s { distance } else { 0.0 }, r.min(s));
    }
    let x = (distance * distance + r * r - s * s) / (2.0 * distance);
    let rim = (r * r - x * x).max(0.0).sqrt();
    (x, rim.max((r - x).abs()).max((s - (distance - x)).abs()))
}

/// Area of the unit disc beyond a chord at height `x`, from −1 to 1.
fn arc(x: f64) -> f64 {
    x.acos() - x * (1.0 - x * x).max(0.0).sqrt()
}

/// Unit disc where x > a, y > b.
fn quadrant(a: f64, b: f64) -> f64 {
    if a < 0.0 {
        return arc(b) - quadrant(-a, b);
    }
    if b < 0.0 {
        return arc(a) - quadrant(a, -b);
    }
    if a * a + b * b >= 1.0 {
        return 0.0;
    }
    let (wide, high) = ((1.0 - b * b).sqrt() - a, (1.0 - a * a).sqrt() - b);
    0.5 * (a.acos() - b.asin() - a * high - b * wide)
}

/// Unit ball where x > a.
fn cap(a: f64) -> f64 {
    PI / 3.0 * (1.0 - a) * (1.0 - a) * (2.0 + a)
}

/// Unit ball where x > a, y > b.
fn wedge(a: f64, b: f64) -> f64 {
    if a < 0.0 {
        return cap(b) - wedge(-a, b);
    }
    if b < 0.0 {
        return cap(a) - wedge(a, -b);
    }
    if a * a + b * b >= 1.0 {
        return 0.0;
    }
    let (rho_a, rho_b) = (1.0 - a * a, 1.0 - b * b);
    let chord = |h: f64, rho: f64| (h / rho.sqrt()).clamp(-1.0, 1.0);
    let (turn_a, turn_b) = (2.0 * chord(b, rho_a).acos(), 2.0 * chord(a, rho_b).acos());
    let sphere = 2.0 * corner(a, b) - a * turn_a - b * turn_b;
    let face = |h: f64, rho: f64| rho * arc(chord(h, rho));
    (sphere - a * face(b, rho_a) - b * face(a, rho_b)) / 3.0
}

/// Angle of the spherical face where the circles x = a and y = b meet.
fn corner(a: f64, b: f64) -> f64 {
    (a * b / ((1.0 - a * a) * (1.0 - b * b)).sqrt()).clamp(-1.0, 1.0).acos()
}

/// Unit ball where x > p₀, y > p₁, z > p₂.
fn octant(p: [f64; 3]) -> f64 {
    if let Some(axis) = p.iter().position(|&h| h < 0.0) {
        let mut mirrored = p;
        mirrored[axis] = -p[axis];
        return wedge(p[(axis + 1) % 3], p[(axis + 2) % 3]) - octant(mirrored);
    }
    if p.iter().map(|h| h * h).sum::<f64>() >= 1.0 {
        return 0.0;
    }
    let mut sphere = -PI;
    let mut faces = 0.0;
    for axis in 0..3 {
        let (a, b, c) = (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]);
        sphere += corner(a, b);
        let rho = 1.0 - a * a;
        let (u, v) = (b / rho.sqrt(), c / rho.sqrt());
        let turn = u.min(1.0).acos() - v.min(1.0).asin();
        sphere -= a * turn;
        let (along_b, along_c) = ((rho - b * b).sqrt() - c, (rho - c * c).sqrt() - b);
        faces += a * 0.5 * (rho * turn - b * along_b - c * along_c);
    }
    (sphere - faces) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The same by thin discs, each in closed form.
    fn by_slices(centre: &Vec3, radius: f64, bounds: &Bounds) -> f64 {
        const SLICES: usize = 4000;
        let (low, high) =
            (bounds.low.z.max(centre.z - radius), bounds.high.z.min(centre.z + radius));
        if high <= low {
            return 0.0;
        }
        let step = (high - low) / SLICES as f64;
        (0..SLICES)
            .map(|i| {
                let z = low + (i as f64 + 0.5) * step - centre.z;
                ball_and_box(centre, (radius * radius - z * z).max(0.0).sqrt(), bounds, 2)
            })
            .sum::<f64>()
            * step
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn a_ball_in_a_box_is_the_sum_of_its_slices(
            x in -1.5..1.5_f64, y in -1.5..1.5_f64, z in -1.5..1.5_f64, radius in 0.1..2.0_f64,
        ) {
            let centre = Vec3::new(x, y, z);
            let bounds = Bounds { low: Vec3::new(-0.7, -0.4, -1.0), high: Vec3::new(0.6, 0.9, 0.5) };
            let found = ball_and_box(&centre, radius, &bounds, 3);
            prop_assert!((found - by_slices(&centre, radius, &bounds)).abs() < 2e-6, "{found}");
            prop_assert!(found <= ball(radius, 3).min(bounds.size().product()) + 1e-12);
        }

        #[test]
        fn parts_of_a_ball_add_up(x in -1.0..1.0_f64, y in -1.0..1.0_f64, z in -1.0..1.0_f64) {
            let centre = Vec3::new(0.1, -0.2, 0.05);
            for dimension in [2, 3] {
                let mut sum = 0.0;
                for code in 0..1_usize << dimension {
                    let mut bounds = Bounds { low: Vec3::repeat(-5.0), high: Vec3::repeat(5.0) };
                    for (axis, cut) in [x, y, z].into_iter().enumerate().take(dimension) {
                        if code >> axis & 1 == 1 { bounds.low[axis] = cut } else { bounds.high[axis] = cut }
                    }
                    sum += ball_and_box(&centre, 0.9, &bounds, dimension);
                }
                prop_assert!((sum - ball(0.9, dimension)).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn known_parts() {
        let corner = Bounds { low: Vec3::zeros(), high: Vec3::repeat(9.0) };
        let eighth = ball_and_box(&Vec3::zeros(), 2.0, &corner, 3);
        assert!((eighth - ball(2.0, 3) / 8.0).abs() < 1e-14);
        // A cube inside its circumscribed ball, and a ball inside its cube.
        let cube = Bounds { low: Vec3::repeat(-1.0), high: Vec3::repeat(1.0) };
        assert!((ball_and_box(&Vec3::zeros(), 3.0_f64.sqrt(), &cube, 3) - 8.0).abs() < 1e-13);
        assert!((ball_and_box(&Vec3::zeros(), 1.0, &cube, 3) - ball(1.0, 3)).abs() < 1e-14);
        // Six caps cut off a ball of radius 1.2 about a cube of edge 2.
        let caps = 6.0 * PI * 0.2_f64.powi(2) * (3.0 * 1.2 - 0.2) / 3.0;
        assert!(
            (ball_and_box(&Vec3::zeros(), 1.2, &cube, 3) - (ball(1.2, 3) - caps)).abs() < 1e-14
        );
        assert_eq!(ball_and_box(&Vec3::repeat(9.0), 1.0, &cube, 3), 0.0);
    }

    #[test]
    fn lenses_of_two_balls() {
        assert_eq!(two_balls(2.0, 1.0, 1.0, 3), 0.0);
        assert_eq!(two_balls(0.1, 1.0, 0.5, 3), ball(0.5, 3));
        // Unit balls one apart: 5π/12; unit discs one apart: 2π/3 − √3/2.
        assert!((two_balls(1.0, 1.0, 1.0, 3) - 5.0 * PI / 12.0).abs() < 1e-15);
        let discs = 2.0 * PI / 3.0 - 0.5 * 3.0_f64.sqrt();
        assert!((two_balls(1.0, 1.0, 1.0, 2) - discs).abs() < 1e-15);
        let (middle, radius) = lens(1.0, 1.0, 1.0);
        assert!((middle - 0.5).abs() < 1e-15 && (radius - 0.75_f64.sqrt()).abs() < 1e-15);
    }
}
