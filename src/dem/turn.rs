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
    let mut body = turn.inverse_transform_vector(world);
    let mut q = *turn.quaternion();
    for (axis, part) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
        let angle = part * step * body[axis] / inertia[axis];
        let (sin, cos) = angle.sin_cos();
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        (body[a], body[b]) = (cos * body[a] + sin * body[b], cos * body[b] - sin * body[a]);
        let (half_sin, half_cos) = (0.5 * angle).sin_cos();
        let mut vector = Vec3::zeros();
        vector[axis] = half_sin;
        q *= Quaternion::from_parts(half_cos, vector);
    }
    Unit::new_normalize(q)
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
