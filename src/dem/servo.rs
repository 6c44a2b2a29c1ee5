//! Walls that seek a force, and where walls of any motion are now.
//!
//! A servo wall moves along a unit vector d with the velocity
//!     v = α (F₀ − F) / (K Δt), at most ±v₀,
//! F the force of its contacts on the bodies along d, F₀ the force asked for,
//! K = Σ kn (n·d)² over its contacts with normals n, α = 1/2: one step closes half of the gap
//! if nothing else gives way, so the loop is stable for any packing (the gain of PFC's wall
//! servo; Itasca Consulting Group, PFC documentation, `wall servo`). Without contacts v = v₀.
//! It starts at rest; its travel is the sum of v Δt. Springs and the dashpots that the contacts keep
//! count; forces of the last pass. O(wall contacts) a step, scenes without a servo do not run it.
//! Cannot fail.

use super::ledger::visit;
use super::setting::Setting;
use super::state::State;
use super::surface;
use crate::model::{Model, Motion};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};

/// Share of the gap that one step closes if only the contacts give way.
const GAIN: f64 = 0.5;

/// State of a servo wall.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Servo {
    /// How far it has moved along its direction, m.
    pub travel: f64,
    /// Its velocity along it, m/s.
    pub speed: f64,
    /// Its force on the bodies along it in the last pass, N.
    pub force: f64,
}

/// Where a wall is, as its kernels see it.
#[derive(Debug, Clone, Copy)]
pub struct WallNow {
    /// Way from its place at time 0 that `motion` does not know of, m.
    pub shift: Vec3,
    /// Motion at this time: what oscillates or seeks a force translates.
    pub motion: Motion,
}

impl WallNow {
    /// A wall at `time`, s; `servo` is its state, zero for walls without one.
    pub fn of(motion: &Motion, servo: &Servo, time: f64) -> Self {
        match motion {
            Motion::Oscillate { .. } => Self {
                shift: motion.place(&Vec3::zeros(), time),
                motion: Motion::Translate { velocity: motion.velocity_at(&Vec3::zeros(), time) },
            },
            Motion::Servo { direction, .. } => Self {
                shift: direction * servo.travel,
                motion: Motion::Translate { velocity: direction * servo.speed },
            },
            _ => Self { shift: Vec3::zeros(), motion: *motion },
        }
    }
}

/// Where servo walls are and how hard they push, for people.
pub fn notes(model: &Model, servos: &[Servo]) -> Vec<String> {
    let walls = model.walls.iter().zip(servos);
    walls
        .filter_map(|(wall, servo)| match wall.motion {
            Motion::Servo { force, .. } => Some(format!(
                "wall `{}` pushes with {:.6e} N, asked for {force:.6e} N; it has moved {:.6e} m",
                wall.name, servo.force, servo.travel
            )),
            _ => None,
        })
        .collect()
}

/// Moves servo walls by one step.
pub fn advance(setting: &Setting<'_>, state: &mut State) {
    for servo in &mut state.servos {
        servo.travel += servo.speed * setting.step;
    }
}

/// Chooses the velocities of servo walls from the forces of the last pass.
pub fn respond(setting: &Setting<'_>, state: &mut State) {
    let walls = &setting.model.walls;
    // Force on the bodies and stiffness along each wall's direction.
    let mut sums = vec![(0.0, 0.0); walls.len()];
    let mut add = |wall: usize, normal: Vec3, kn: f64, push: f64, slide: Vec3| {
        if let Motion::Servo { direction, .. } = &walls[wall].motion {
            let along = normal.dot(direction);
            sums[wall].0 += push * along + slide.dot(direction);
            sums[wall].1 += kn * along * along;
        }
    };
    let time = setting.pass_time(state.step);
    let planes = setting.planes_at(time);
    visit(&state.planes, |slot, plane, k| {
        let (ball, now) = (&state.balls[slot], &planes[plane]);
        let height = (ball.place - now.point).dot(&now.normal);
        let law = setting.pair(ball.material, now.material);
        let record = state.planes.book.record(k);
        let push = law.kn * (ball.radius - height.abs()) + record.lag[0];
        let normal = now.normal * height.signum();
        add(setting.planes[plane] as usize, normal, law.kn, push, record.spring * -law.kt);
    });
    visit(&state.faces, |slot, face, k| {
        let (ball, wall) = (&state.balls[slot], setting.surfaces.wall[face] as usize);
        let corners = super::neighbours::face_at(setting, face, time);
        let (point, _) = surface::closest(&ball.place, &corners);
        let away = ball.place - point;
        let law = setting.pair(ball.material, walls[wall].material);
        let record = state.faces.book.record(k);
        let push = law.kn * (ball.radius - away.norm()) + record.lag[0];
        add(wall, away.normalize(), law.kn, push, record.spring * -law.kt);
    });
    for ((wall, servo), (force, stiffness)) in walls.iter().zip(&mut state.servos).zip(sums) {
        if let Motion::Servo { force: asked, speed, .. } = wall.motion {
            let wanted = GAIN * (asked - force) / (stiffness * setting.step);
            // No contact: stiffness 0, infinite; 0/0 only where no force is asked for.
            servo.speed = if wanted.is_nan() { 0.0 } else { wanted.clamp(-speed, speed) };
            servo.force = force;
        }
    }
}
