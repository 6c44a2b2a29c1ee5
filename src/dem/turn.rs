//! Rotation of rigid bodies over one step.
//!
//! - [`split`]: free rotation by five rotations about body axes (Dullweber,
//!   Leimkuhler & McLachlan 1997, eq. 2.12): symplectic, time-reversible, second
//!   order; the angular momentum in the world frame does not change at all.
//! - [`richardson`]: the quaternion step of LIGGGHTS `fix rigid` (Richardson
//!   extrapolation of one full and two half steps).
//! - [`yade`]: the leapfrog of YADE's `NewtonIntegrator` for aspherical bodies,
//!   first order (it gains energy; here to reproduce YADE).
//!
//! Symbols: q orientation (body to world), L angular momentum [kg m²/s] and ω
//! angular velocity [rad/s] in the world frame, I principal moments [kg m²].
//! O(1) a body; cannot fail.

use crate::num::{Rotation, Vec3};
use nalgebra::{Quaternion, Unit};

/// Angular velocity of a body with angular momentum `momentum`.
pub fn spin(turn: &Rotation, inertia: &Vec3, momentum: &Vec3) -> Vec3 {
    turn * turn.inverse_transform_vector(momentum).component_div(inertia)
}

/// Angular momentum of a body with angular velocity `spin`.
pub fn momentum(turn: &Rotation, inertia: &Vec3, spin: &Vec3) -> Vec3 {
    turn * turn.inverse_transform_vector(spin).component_mul(inertia)
}

/// Orientation after free rotation over `step`, s.
pub fn split(turn: &Rotation, inertia: &Vec3, world: &Vec3, step: f64) -> Rotation {
    let mut body: [f64; 3] = turn.inverse_transform_vector(world).into();
    let mut state = (&mut body, *turn.quaternion());
    let rate = inertia.map(|inertia| step / inertia);
    about::<0>(&mut state, 0.5 * rate.x);
    about::<1>(&mut state, 0.5 * rate.y);
    about::<2>(&mut state, rate.z);
    about::<1>(&mut state, 0.5 * rate.y);
    about::<0>(&mut state, 0.5 * rate.x);
    Unit::new_normalize(state.1)
}

/// Turns a body with the angular momentum `body` about its axis `AXIS`, by the angle `rate` times
/// that momentum.
#[inline(always)]
fn about<const AXIS: usize>((body, q): &mut (&mut [f64; 3], Quaternion<f64>), rate: f64) {
    let (a, b) = ((AXIS + 1) % 3, (AXIS + 2) % 3);
    let (sin, cos) = half_angle(rate * body[AXIS]);
    let (whole_sin, whole_cos) = (2.0 * sin * cos, 1.0 - 2.0 * sin * sin);
    let (first, second) = (body[a], body[b]);
    body[a] = whole_cos * first + whole_sin * second;
    body[b] = whole_cos * second - whole_sin * first;
    let (w, v) = (q.w, [q.i, q.j, q.k]);
    let mut turned = v;
    turned[AXIS] = cos * v[AXIS] + sin * w;
    turned[a] = cos * v[a] + sin * v[b];
    turned[b] = cos * v[b] - sin * v[a];
    *q = Quaternion::new(cos * w - sin * v[AXIS], turned[0], turned[1], turned[2]);
}

/// Sine and cosine of half of `angle`. Series to all digits where it is small, as it is in any
/// step that resolves contacts: a fifth of the time.
#[inline(always)]
fn half_angle(angle: f64) -> (f64, f64) {
    let x = 0.5 * angle;
    let y = x * x;
    if y >= 0.0025 {
        return x.sin_cos();
    }
    let sin = 1.0
        - y * (1.0 / 6.0)
            * (1.0 - y * (1.0 / 20.0) * (1.0 - y * (1.0 / 42.0) * (1.0 - y * (1.0 / 72.0))));
    let cos = 1.0
        - y * 0.5 * (1.0 - y * (1.0 / 12.0) * (1.0 - y * (1.0 / 30.0) * (1.0 - y * (1.0 / 56.0))));
    (x * sin, cos)
}

/// Orientation after `step` as LIGGGHTS `fix rigid`, and the angular velocity
/// at mid-step that it uses until the next force.
pub fn richardson(turn: &Rotation, inertia: &Vec3, world: &Vec3, step: f64) -> (Rotation, Vec3) {
    let q = *turn.quaternion();
    let half = 0.5 * step;
    let rate = pure(&spin(turn, inertia, world)) * q;
    let full = (q + rate * half).normalize();
    let middle = (q + rate * (0.5 * half)).normalize();
    let omega = spin(&Unit::new_unchecked(middle), inertia, world);
    let twice = (middle + pure(&omega) * middle * (0.5 * half)).normalize();
    (Unit::new_normalize(twice * 2.0 - full), omega)
}

/// Orientation, angular momentum and angular velocity after `step` under `torque` [N m] as YADE.
pub fn yade(
    turn: &Rotation,
    inertia: &Vec3,
    world: &Vec3,
    torque: &Vec3,
    step: f64,
) -> (Rotation, Vec3, Vec3) {
    let q = *turn.quaternion();
    let early = turn.inverse_transform_vector(&(world + torque * (0.5 * step)));
    let middle = q + q * pure(&early.component_div(inertia)) * (0.25 * step);
    let late = world + torque * step;
    let body = turn.inverse_transform_vector(&late).component_div(inertia);
    let raw = q + middle * pure(&body) * (0.5 * step);
    // YADE turns the spin with the quaternion before it is normalised.
    let vector = raw.vector().into_owned();
    let twice = vector.cross(&body) * 2.0;
    let omega = body + twice * raw.w + vector.cross(&twice);
    (Unit::new_normalize(raw), late, omega)
}

fn pure(vector: &Vec3) -> Quaternion<f64> {
    Quaternion::from_parts(0.0, *vector)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Torque-free top, I = (1, 2, 3), from the identity: q at t = 20 (mpmath Taylor series, 25 digits).
    const AT_20: [f64; 4] = [
        -0.593_371_402_375_948_5,
        0.037_617_559_756_284_13,
        -0.454_108_719_737_076_9,
        0.663_536_410_982_197_4,
    ];

    fn top() -> (Vec3, Vec3) {
        (Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 1.0, -2.1))
    }

    fn distance(turn: &Rotation) -> f64 {
        let [w, x, y, z] = AT_20;
        turn.angle_to(&Unit::new_normalize(Quaternion::new(w, x, y, z)))
    }

    #[test]
    fn half_angles_have_all_digits() {
        for k in -200..=200 {
            let angle = f64::from(k) * 0.001;
            let (sin, cos) = half_angle(angle);
            let (s, c) = (0.5 * angle).sin_cos();
            assert!((sin - s).abs() <= 2.0 * f64::EPSILON * s.abs(), "{angle}");
            assert!((cos - c).abs() <= f64::EPSILON, "{angle}");
        }
    }

    #[test]
    fn splitting_follows_the_free_top_at_second_order() {
        let (inertia, world) = top();
        let error = |steps: u32| {
            let h = 20.0 / f64::from(steps);
            let mut turn = Rotation::identity();
            for _ in 0..steps {
                turn = split(&turn, &inertia, &world, h);
            }
            distance(&turn)
        };
        let (coarse, fine) = (error(1000), error(2000));
        assert!(coarse < 6e-4, "{coarse}");
        assert!((coarse / fine - 4.0).abs() < 0.1, "{coarse} {fine}");
    }

    #[test]
    fn richardson_is_second_order_too() {
        let (inertia, world) = top();
        let mut turn = Rotation::identity();
        for _ in 0..10_000 {
            turn = richardson(&turn, &inertia, &world, 20.0 / 10_000.0).0;
        }
        assert!(distance(&turn) < 1e-4, "{}", distance(&turn));
    }

    #[test]
    fn yade_gains_energy_as_yade_does() {
        let (inertia, start) = top();
        let (mut turn, mut world, mut omega) = (Rotation::identity(), start, Vec3::zeros());
        for _ in 0..1000 {
            (turn, world, omega) = yade(&turn, &inertia, &world, &Vec3::zeros(), 0.02);
        }
        let body = turn.inverse_transform_vector(&omega);
        let energy = 0.5 * inertia.component_mul(&body).dot(&body);
        assert_eq!(world, start);
        // YADE 2023.02a gains 8.0 % here.
        assert!((energy / 1.485 - 1.08).abs() < 0.003, "{}", energy / 1.485);
    }

    #[test]
    fn spin_and_momentum_are_inverse() {
        let (inertia, world) = top();
        let turn = Rotation::from_scaled_axis(Vec3::new(0.3, -0.7, 0.2));
        let back = momentum(&turn, &inertia, &spin(&turn, &inertia, &world));
        assert!((back - world).norm() < 1e-14);
    }
}
