//! Walls that seek a force, and where walls of any motion are now.
//!
//! A servo wall moves along a unit vector d with the velocity
//!     v = α (F₀ − F) / (K Δt), at most ±v₀,
//! F the force of the wall on the bodies along d, of the springs of its contacts and of attraction and
//! whatever else acts at a distance (wet grains that are pressed pull the wall towards them), F₀ the force asked for,
//! K = Σ (kn (n·d)² + kt (1 − (n·d)²)) over its contacts with normals n (kt with friction only)
//! plus Σ |F'| (n·d)² over the forces F of attraction, which change by F' with the gap,
//! α = 1/2: one step closes half of the gap if nothing else gives way (the gain of PFC's wall
//! servo; Itasca Consulting Group, PFC documentation, `wall servo`). Where nothing acts v = v₀.
//! It starts at rest; its travel is the sum of v Δt. In `path_averaged` the travel is that at the
//! middle of a step. O(wall contacts) a step, scenes without a servo do not run it. Cannot fail.
//!
//! Stability. With places of spheres x and of the wall w from pass to pass as zⁿ,
//! (z − 1) w = α (x − w), so that a sphere feels a spring k with dashpot c at the wall as
//! −(k + c (1 − 1/z)/Δt) u/(u + α) x with u = z − 1. On the unit circle its part out of phase
//! damps at every frequency but that of z = −1, where it is 2/(2 − α) = 4/3 of that of a still wall:
//! what bounds the step with still walls does so with servo walls if their contacts are taken
//! 4/3 as stiff (for many spheres by the Cauchy–Schwarz inequality in the norm of the contacts).
//! Attraction falls off with the gap, F' > 0 where springs have −kn, so that F changes with the wall by less
//! than K and the gain is at most α; the step limit counts |F'| as stiffness (see [`super::extra`]).
//! Dashpots must stay out of F: a wall that answers to them swings by α c/(kn Δt) a step, without
//! bound where that is above 1, which it is at usual steps.
//!
//! Work: the velocity changes at a pass, so the half step before it counts with the old and the
//! half after it with the new one; tangential dashpots are left out of the difference.

use super::law::Record;
use super::ledger::visit;
use super::setting::Setting;
use super::state::State;
use super::surface;
use crate::model::{Contact, Model, Motion, Scheme};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Share of the gap that one step closes if only the contacts give way.
const GAIN: f64 = 0.5;
/// How much stiffer than at a still wall contacts are at most.
const STIFFER: f64 = 2.0 / (2.0 - GAIN);

/// State of a servo wall.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Servo {
    /// How far it has moved along its direction, m.
    pub travel: f64,
    /// Its velocity along it, m/s.
    pub speed: f64,
    /// Force of its springs and of attraction on the bodies along it in the last pass, N.
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
    /// A wall at `time`, s; `servo` is its state `ahead` [s] before, zero for walls without one.
    pub fn of(motion: &Motion, servo: &Servo, time: f64, ahead: f64) -> Self {
        match motion {
            Motion::Oscillate { .. } => Self {
                shift: motion.place(&Vec3::zeros(), time),
                motion: Motion::Translate { velocity: motion.velocity_at(&Vec3::zeros(), time) },
            },
            Motion::Servo { direction, .. } => Self {
                shift: direction * (servo.travel + servo.speed * ahead),
                motion: Motion::Translate { velocity: direction * servo.speed },
            },
            _ => Self { shift: Vec3::zeros(), motion: *motion },
        }
    }
}

/// How much stiffer than still contacts those with a wall of this motion are to the step.
pub fn stiffer(motion: &Motion) -> f64 {
    if matches!(motion, Motion::Servo { .. }) { STIFFER } else { 1.0 }
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

impl WallNow {
    /// LIGGGHTS' `wiggle` adds up velocity times step of every step: Σ cos(kθ + φ) over k = 1 to
    /// `steps` is sin(nθ/2) cos((n + 1)θ/2 + φ)/sin(θ/2). Off the sine by half a step's change.
    pub fn add_velocities(&mut self, motion: &Motion, step: f64, steps: f64) {
        if let Motion::Oscillate { amplitude, frequency, phase } = motion {
            let angle = TAU * frequency * step;
            let half = 0.5 * angle;
            let sum = (steps * half).sin() * ((steps + 1.0) * half + phase).cos() / half.sin();
            self.shift = amplitude * (angle * sum);
        }
    }
}

/// What attraction and other forces besides the linear contact do along the direction of a wall.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Attraction {
    /// Force on the bodies, N.
    pub force: f64,
    /// How it changes with the place of the wall, at most, N/m.
    pub stiffness: f64,
}

/// What the contacts of a wall do along its direction.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    /// Force of springs on the bodies, N.
    springs: f64,
    /// Force of normal dashpots, N.
    dashpots: f64,
    /// Stiffness, N/m.
    stiffness: f64,
}

/// A contact at a wall in the last pass.
struct Hold<'a> {
    normal: Vec3,
    overlap: f64,
    law: &'a Contact,
    record: Record,
}

impl Sum {
    fn add(&mut self, direction: &Vec3, hold: &Hold<'_>, averaged: bool) {
        let (law, along) = (hold.law, hold.normal.dot(direction));
        let kt = if law.friction > 0.0 { law.kt } else { 0.0 };
        let spring = law.kn * hold.overlap;
        let damped = hold.record.lag;
        self.springs += spring * along - law.kt * hold.record.spring.dot(direction);
        // Of path-averaged contacts the whole normal force is kept.
        self.dashpots += if averaged { damped - spring } else { damped } * along;
        self.stiffness += law.kn * along * along + kt * (1.0 - along * along);
    }
}

/// Chooses the velocities of servo walls from the forces of the last pass, those of attraction given wall by wall
/// (none if nothing attracts). What the change adds to the power on the bodies, W.
pub fn respond(setting: &Setting<'_>, state: &mut State, attraction: &[Attraction]) -> f64 {
    let sums = sums(setting, state);
    let mut power = 0.0;
    let walls = setting.model.walls.iter().zip(&mut state.servos).zip(sums);
    for (index, ((wall, servo), sum)) in walls.enumerate() {
        if let Motion::Servo { force: asked, speed, .. } = wall.motion {
            let besides = attraction.get(index).copied().unwrap_or_default();
            let force = sum.springs + besides.force;
            let stiffness = sum.stiffness + besides.stiffness;
            let wanted = GAIN * (asked - force) / (stiffness * setting.step);
            // Nothing acts: stiffness 0, infinite; 0/0 only where no force is asked for.
            let chosen = if wanted.is_nan() { 0.0 } else { wanted.clamp(-speed, speed) };
            power += (force + sum.dashpots) * (chosen - servo.speed);
            (servo.speed, servo.force) = (chosen, force);
        }
    }
    power
}

fn sums(setting: &Setting<'_>, state: &State) -> Vec<Sum> {
    let walls = &setting.model.walls;
    let averaged = setting.scheme == Scheme::PathAveraged && setting.kept.damping;
    let mut sums = vec![Sum::default(); walls.len()];
    let mut add = |wall: usize, hold: &Hold<'_>| {
        if let Motion::Servo { direction, .. } = &walls[wall].motion {
            sums[wall].add(direction, hold, averaged);
        }
    };
    let time = setting.pass_time(state.step);
    let planes = setting.planes_at(time);
    visit(&state.planes, |slot, plane, k| {
        let (ball, now) = (&state.balls[slot], &planes[plane]);
        let height = (ball.place - now.point).dot(&now.normal);
        let hold = Hold {
            normal: now.normal * height.signum(),
            overlap: ball.radius - height.abs(),
            law: setting.pair(ball.material, now.material),
            record: state.planes.book.record(k),
        };
        add(setting.planes[plane] as usize, &hold);
    });
    visit(&state.faces, |slot, face, k| {
        let (ball, wall) = (&state.balls[slot], setting.surfaces.wall[face] as usize);
        let corners = super::neighbours::face_at(setting, face, time);
        let away = ball.place - surface::closest(&ball.place, &corners).0;
        let hold = Hold {
            normal: away.normalize(),
            overlap: ball.radius - away.norm(),
            law: setting.pair(ball.material, walls[wall].material),
            record: state.faces.book.record(k),
        };
        add(wall, &hold);
    });
    sums
}
