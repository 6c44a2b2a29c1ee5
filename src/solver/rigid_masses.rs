//! Masses for the spheres of a clump so that together they weigh what the body
//! weighs and balance about its centre of mass.
//!
//! LIGGGHTS sums gravity over the spheres of a `fix rigid` body with their own
//! masses. It is right only if Σ mᵢ = M and Σ mᵢ dᵢ = 0, dᵢ the sphere centres
//! from the centre of mass. Among all positive masses that do so, the ones
//! nearest to shares by sphere volume in relative entropy are
//! mᵢ ∝ Vᵢ exp(λ·dᵢ) (minimum discrimination information, Kullback & Leibler
//! 1951, Csiszár 1975); λ minimises the convex f(λ) = ln Σ Vᵢ exp(λ·dᵢ), found by
//! Newton's method with a pseudo-inverse (centres on a line or plane) and
//! step halving.
//!
//! Exact whenever the centre of mass lies inside the hull of the centres, but for about one in some
//! thousands of random clumps, to whose masses no step leads. If it lies outside,
//! no positive masses exist; what comes back balances as far as the hull
//! allows, and `arm` says how far it is off. Cost O(n) a step, about 10 steps.
//!
//! [`balance`] is exact for every clump: where the split is off, one more point
//! takes the share s of the mass and stands where the first moment vanishes,
//! d = −(1 − s)/s d̄, with d̄ the mean of the centres by volume. With s = 0.99 that
//! is a hundredth of d̄ from the centre of mass.

use crate::num::{Mat3, Vec3};

/// Masses of the spheres of one clump.
#[derive(Debug, Clone, PartialEq)]
pub struct Masses {
    /// Mass of each sphere, kg, all > 0, sum M.
    pub masses: Vec<f64>,
    /// Σ mᵢ dᵢ / M: where gravity acts, from the centre of mass, m. Rounding only
    /// where the problem has a solution.
    pub arm: Vec3,
}

/// Masses that balance, and the point that one clump may need for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    /// Mass of each sphere, kg, all > 0.
    pub masses: Vec<f64>,
    /// A point of mass besides the spheres.
    pub point: Option<Point>,
    /// What is left of Σ mᵢ dᵢ / M, m.
    pub arm: Vec3,
}

/// A point of mass that moves with a clump.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Mass, kg.
    pub mass: f64,
    /// Place from the centre of mass, m.
    pub offset: Vec3,
}

/// Share of the mass that a point takes.
const POINT_SHARE: f64 = 0.99;
/// Clumps off by less than this times their largest radius need no point.
const BALANCED: f64 = 1e-9;

/// Splits `mass` (kg) so that Σ mᵢ = M and Σ mᵢ dᵢ = 0, with a point where spheres alone cannot.
pub fn balance(mass: f64, offsets: &[Vec3], radii: &[f64]) -> Balance {
    let split = split(mass, offsets, radii);
    let largest = radii.iter().copied().fold(0.0, f64::max);
    if split.arm.norm() <= BALANCED * largest {
        return Balance { masses: split.masses, point: None, arm: split.arm };
    }
    let share = (1.0 - POINT_SHARE) * mass / radii.iter().map(|r| r.powi(3)).sum::<f64>();
    let masses: Vec<f64> = radii.iter().map(|r| share * r.powi(3)).collect();
    let point = mass - masses.iter().sum::<f64>();
    let offset = -moment(&masses, offsets) / point;
    let arm = (moment(&masses, offsets) + offset * point) / mass;
    Balance { masses, point: Some(Point { mass: point, offset }), arm }
}

/// No sphere gets less than this share of the body's mass relative to its
/// share by volume: beyond it the centre of mass lies on the hull or outside.
const LEAST_SHARE: f64 = 1e-6;
const STEPS: usize = 60;

/// Splits `mass` (kg) among spheres at `offsets` (m, from the centre of mass) with `radii` (m).
pub fn split(mass: f64, offsets: &[Vec3], radii: &[f64]) -> Masses {
    let size = offsets.iter().map(|d| d.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let volume: f64 = radii.iter().map(|r| r.powi(3)).sum();
    let volumes: Vec<f64> = radii.iter().map(|r| r.powi(3) / volume).collect();
    // Lengths in units of the clump, so that one tolerance fits all.
    let points: Vec<Vec3> = offsets.iter().map(|d| d / size).collect();
    let mut tilt = Vec3::zeros();
    let (mut shares, mut value) = tilted(&volumes, &points, &tilt);
    for _ in 0..STEPS {
        let mean = moment(&shares, &points);
        let direction = -(pseudo_inverse(&covariance(&shares, &points, &mean)) * mean);
        if direction.norm() * mean.norm() < 1e-32 {
            break;
        }
        let mut length = 1.0;
        let next = loop {
            let trial = tilt + direction * length;
            let (trial_shares, trial_value) = tilted(&volumes, &points, &trial);
            let allowed = trial_shares.iter().zip(&volumes).all(|(s, v)| *s >= LEAST_SHARE * v);
            if allowed && trial_value <= value + 1e-13 {
                break Some((trial, trial_shares, trial_value));
            }
            length *= 0.5;
            if length < 1e-6 {
                break None;
            }
        };
        let Some((trial, trial_shares, trial_value)) = next else { break };
        (tilt, shares, value) = (trial, trial_shares, trial_value);
    }
    let arm = moment(&shares, &points) * size;
    Masses { masses: shares.iter().map(|share| share * mass).collect(), arm }
}

/// Shares wᵢ exp(λ·pᵢ) / Σ and the logarithm of the sum.
fn tilted(weights: &[f64], points: &[Vec3], tilt: &Vec3) -> (Vec<f64>, f64) {
    let exponents: Vec<f64> = points.iter().map(|p| tilt.dot(p)).collect();
    let top = exponents.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let raw: Vec<f64> = weights.iter().zip(&exponents).map(|(w, e)| w * (e - top).exp()).collect();
    let sum: f64 = raw.iter().sum();
    (raw.iter().map(|share| share / sum).collect(), top + sum.ln())
}

fn moment(shares: &[f64], points: &[Vec3]) -> Vec3 {
    shares.iter().zip(points).map(|(share, point)| point * *share).sum()
}

fn covariance(shares: &[f64], points: &[Vec3], mean: &Vec3) -> Mat3 {
    shares
        .iter()
        .zip(points)
        .map(|(share, point)| {
            let d = point - mean;
            d * d.transpose() * *share
        })
        .sum()
}

/// Inverse on the directions in which the points extend, zero on the others.
fn pseudo_inverse(matrix: &Mat3) -> Mat3 {
    let eigen = matrix.symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    let mut inverse = Mat3::zeros();
    for axis in 0..3 {
        if eigen.eigenvalues[axis] > 1e-10 * largest {
            let direction = eigen.eigenvectors.column(axis);
            inverse += direction * direction.transpose() / eigen.eigenvalues[axis];
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_balanced_clump_keeps_its_volume_shares() {
        let offsets = [Vec3::new(1e-3, 0.0, 0.0), Vec3::new(-1e-3, 0.0, 0.0)];
        let split = split(4.0, &offsets, &[1e-3, 1e-3]);
        assert_eq!(split.masses, vec![2.0, 2.0]);
        assert_eq!(split.arm, Vec3::zeros());
    }

    #[test]
    fn two_spheres_with_the_centre_between_them_follow_the_lever() {
        let offsets = [Vec3::new(3e-3, 0.0, 0.0), Vec3::new(-1e-3, 0.0, 0.0)];
        let split = split(8.0, &offsets, &[1e-3, 1e-3]);
        assert!((split.masses[0] - 2.0).abs() < 1e-12, "{:?}", split.masses);
        assert!((split.masses[1] - 6.0).abs() < 1e-12);
    }

    #[test]
    fn a_centre_off_the_line_is_reported_as_an_arm() {
        let offsets = [Vec3::new(1e-3, 2e-4, 0.0), Vec3::new(-1e-3, 2e-4, 0.0)];
        let split = split(1.0, &offsets, &[1e-3, 1e-3]);
        assert!((split.arm - Vec3::new(0.0, 2e-4, 0.0)).norm() < 1e-15);
        assert!(split.masses.iter().all(|m| (m - 0.5).abs() < 1e-12));
    }

    #[test]
    fn a_centre_beyond_the_hull_keeps_masses_positive() {
        let offsets = [Vec3::new(1e-3, 0.0, 0.0), Vec3::new(2e-3, 0.0, 0.0)];
        let split = split(1.0, &offsets, &[1e-3, 1e-3]);
        assert!(split.masses.iter().all(|m| *m > 0.0));
        assert!((split.masses.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        assert!(split.arm.x > 0.9e-3 && split.arm.x < 1.1e-3, "{:?}", split.arm);
    }

    #[test]
    fn a_centre_beyond_the_hull_gets_a_point() {
        let offsets = [Vec3::new(1e-3, 3e-4, 0.0), Vec3::new(2e-3, 0.0, 0.0)];
        let Balance { masses, point, arm } = balance(1.0, &offsets, &[1e-3, 8e-4]);
        let point = point.expect("no masses of two spheres balance about a third place");
        assert!(masses.iter().all(|m| *m > 0.0));
        assert!((masses.iter().sum::<f64>() + point.mass - 1.0).abs() < 1e-15);
        let moment = moment(&masses, &offsets) + point.offset * point.mass;
        assert!(moment.norm() < 1e-19 && arm.norm() < 1e-19, "{moment:?} {arm:?}");
        assert!(point.offset.norm() < 3e-5, "{point:?}");
        let between = [Vec3::new(1e-3, 0.0, 0.0), Vec3::new(-3e-3, 0.0, 0.0)];
        let balanced = balance(1.0, &between, &[1e-3, 1e-3]);
        assert_eq!(balanced.point, None);
        assert_eq!(balanced.masses, split(1.0, &between, &[1e-3, 1e-3]).masses);
    }

    proptest! {
        /// Any clump whose centre of mass is a mixture of its sphere centres balances; nearly all without a point.
        #[test]
        fn mixtures_are_met(
            raw in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64, 0.3..1.0f64, 0.05..1.0f64), 2..12)
        ) {
            let total: f64 = raw.iter().map(|r| r.4).sum();
            let centre: Vec3 = raw.iter().map(|r| Vec3::new(r.0, r.1, r.2) * (r.4 / total)).sum();
            let offsets: Vec<Vec3> =
                raw.iter().map(|r| (Vec3::new(r.0, r.1, r.2) - centre) * 1e-3).collect();
            let radii: Vec<f64> = raw.iter().map(|r| r.3 * 1e-3).collect();
            let Balance { masses, point, arm } = balance(2.5, &offsets, &radii);
            prop_assert!(masses.iter().all(|m| *m > 0.0));
            let beside = point.map_or(0.0, |point| point.mass);
            prop_assert!((masses.iter().sum::<f64>() + beside - 2.5).abs() < 1e-14);
            prop_assert!(arm.norm() < 1e-3 * BALANCED, "arm {arm:?}");
        }
    }
}
