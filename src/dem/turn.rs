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

use super::lanes::{Triple, Wide};
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

/// Four bodies at once: orientations after [`split`] and the angular velocities then.
#[inline(always)]
pub fn split_four<L: Wide<4>>(
    turns: [&Rotation; 4],
    inertias: [&Vec3; 4],
    worlds: [&Vec3; 4],
    step: f64,
) -> ([Rotation; 4], [Vec3; 4]) {
    let part = |k: usize| L::load(&turns.map(|turn| turn.coords[k]));
    let (mut v, mut w) = ([part(0), part(1), part(2)], part(3));
    let (inertia, world) = (L::triples(inertias), L::triples(worlds));
    let (one, half) = (L::splat(1.0), L::splat(0.5));
    let light = inertia.map(|inertia| one / inertia);
    let rate = light * L::splat(step);
    let Triple { x, y, z } = turned(v, -w, world);
    let mut body = [x, y, z];
    let axes = [
        (0, rate.x * half),
        (1, rate.y * half),
        (2, rate.z),
        (1, rate.y * half),
        (0, rate.x * half),
    ];
    for (axis, rate) in axes {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let (sin, cos) = half_angles(rate * body[axis]);
        let (whole_sin, whole_cos) = ((sin + sin) * cos, one - (sin + sin) * sin);
        (body[a], body[b]) =
            (whole_cos * body[a] + whole_sin * body[b], whole_cos * body[b] - whole_sin * body[a]);
        let old = (v, w);
        w = cos * old.1 - sin * old.0[axis];
        v[axis] = cos * old.0[axis] + sin * old.1;
        v[a] = cos * old.0[a] + sin * old.0[b];
        v[b] = cos * old.0[b] - sin * old.0[a];
    }
    let shrink = one / (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + w * w).sqrt();
    (v, w) = (v.map(|x| x * shrink), w * shrink);
    let inner = turned(v, -w, world);
    let inner = Triple { x: inner.x * light.x, y: inner.y * light.y, z: inner.z * light.z };
    let spin = turned(v, w, inner);
    let mut parts = [[0.0; 4]; 7];
    for (numbers, part) in parts.iter_mut().zip([v[0], v[1], v[2], w, spin.x, spin.y, spin.z]) {
        part.store(numbers);
    }
    let [i, j, k, w, x, y, z] = parts;
    let (mut after, mut spins) = ([Rotation::identity(); 4], [Vec3::zeros(); 4]);
    for l in 0..4 {
        after[l] = Unit::new_unchecked(Quaternion::new(w[l], i[l], j[l], k[l]));
        spins[l] = Vec3::new(x[l], y[l], z[l]);
    }
    (after, spins)
}

/// Vectors turned by unit quaternions with the vector part `v` and scalar part `w`; with −w the other way.
#[inline(always)]
fn turned<L: Wide<4>>(v: [L; 3], w: L, vector: Triple<L>) -> Triple<L> {
    let q = Triple { x: v[0], y: v[1], z: v[2] };
    let twice = q.cross(vector) * L::splat(2.0);
    vector + twice * w + q.cross(twice)
}

/// [`half_angle`] of four angles.
#[inline(always)]
fn half_angles<L: Wide<4>>(angle: L) -> (L, L) {
    let n = |value: f64| L::splat(value);
    let (one, x) = (n(1.0), angle * n(0.5));
    let y = x * x;
    let sin = one - y * n(1.0 / 20.0) * (one - y * n(1.0 / 42.0) * (one - y * n(1.0 / 72.0)));
    let sin = (one - y * n(1.0 / 6.0) * sin) * x;
    let cos = one - y * n(1.0 / 12.0) * (one - y * n(1.0 / 30.0) * (one - y * n(1.0 / 56.0)));
    let cos = one - y * n(0.5) * cos;
    let large = L::not(y.below(n(0.0025)));
    if !L::any(large) {
        return (sin, cos);
    }
    let mut angles = [0.0; 4];
    x.store(&mut angles);
    let exact = angles.map(f64::sin_cos);
    let (sines, cosines) = (exact.map(|pair| pair.0), exact.map(|pair| pair.1));
    (L::pick(large, L::load(&sines), sin), L::pick(large, L::load(&cosines), cos))
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
    fn four_at_once_turn_as_one_by_one() {
        use crate::dem::lanes::Plain;
        let turns = [0.1, 0.9, 2.0, 3.0]
            .map(|angle| Rotation::from_scaled_axis(Vec3::new(angle, 0.3 - angle, 0.5)));
        let inertias = [1.0, 2.0, 0.5, 3.0].map(|size| Vec3::new(1.0, 2.0, 3.0) * size);
        let worlds = [0.3, 1.0, 5.0, 0.0].map(|size| Vec3::new(1.0, -0.4, 2.0) * size);
        for step in [1e-3, 0.2] {
            let (after, spins) =
                split_four::<Plain>(turns.each_ref(), inertias.each_ref(), worlds.each_ref(), step);
            for l in 0..4 {
                let one = split(&turns[l], &inertias[l], &worlds[l], step);
                assert!((one.coords - after[l].coords).norm() < 4e-16 * 4.0, "{step} {l}");
                let turning = spin(&one, &inertias[l], &worlds[l]);
                assert!((turning - spins[l]).norm() <= 1e-14 * turning.norm(), "{step} {l}");
            }
            #[cfg(target_arch = "x86_64")]
            if is_x86_feature_detected!("avx2") {
                #[target_feature(enable = "avx2")]
                fn with_avx2(
                    turns: [&Rotation; 4],
                    inertias: [&Vec3; 4],
                    worlds: [&Vec3; 4],
                    step: f64,
                ) -> ([Rotation; 4], [Vec3; 4]) {
                    split_four::<crate::dem::lanes::Four>(turns, inertias, worlds, step)
                }
                let refs = (turns.each_ref(), inertias.each_ref(), worlds.each_ref());
                // SAFETY: the processor has what the function asks for.
                let four = unsafe { with_avx2(refs.0, refs.1, refs.2, step) };
                assert_eq!(four, (after, spins));
            }
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
