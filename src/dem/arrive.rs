//! Bodies that come during a run.
//!
//! A body that comes at time t_N is at its place with its velocity and spin at t_N. Until then it
//! stands there without motion, and its radii are NaN, so that no list holds it and no kernel has to know of it
//! (as of bodies that were taken out, see [`super::lost`]). It comes
//! - in kick-drift-kick schemes and that of YADE just before the force pass at t_N, with the velocity half a step
//!   before, v − Δt/2 g: as LIGGGHTS (`fix insert`, before it exchanges atoms) and YADE (between two steps) do it;
//! - in that of LAMMPS after step N, followed by a second set-up pass at t_N as after a new `run` command;
//! - in `path_averaged` after step N.
//!
//! Its kinetic energy counts as there from the start. A body that overlaps another where it comes ends the run, as one in a wall does.
//! O(bodies) a body that comes, and new lists; nothing in other steps.

use super::setting::Setting;
use super::state::{Ball, Solid, State, is_alone};
use super::{ledger, neighbours, surface, turn};
use crate::model::Model;
use crate::num::Vec3;

/// Overlap over the smaller radius up to which a place counts as free: rounding.
const ROUNDING: f64 = 1e-6;

/// Takes the bodies that come later out of a state at time 0.
pub fn put_off(setting: &Setting<'_>, state: &mut State) {
    let model = setting.model;
    if model.arrivals.is_empty() {
        return;
    }
    let first = model.first_arrival();
    state.solids.retain(|solid| (solid.body as usize) < first);
    for (slot, ball) in state.balls.iter_mut().enumerate() {
        if ball.body as usize >= first {
            (ball.radius, ball.alone, ball.velocity) = (f64::NAN, false, Vec3::zeros());
            if let Some(spin) = state.spins.get_mut(slot) {
                *spin = Vec3::zeros();
            }
        }
    }
}

/// Whether some body comes at step `step`.
pub fn due(setting: &Setting<'_>, step: u64) -> bool {
    let model = setting.model;
    step > 0 && model.arrived_by(step) > model.arrived_by(step - 1)
}

/// Puts in the bodies that come at the present step, their velocities half a step of gravity early where `early` says
/// so; true if there is one.
pub fn now(setting: &Setting<'_>, state: &mut State, early: bool) -> bool {
    let model = setting.model;
    let first = model.first_arrival();
    let there = model.arrived_by(state.step);
    if there == state.come {
        return false;
    }
    let before = ledger::potential(setting, state);
    for at in state.come..there {
        put_in(setting, state, first + at, early);
    }
    state.come = there;
    state.ledger.start_potential += ledger::potential(setting, state) - before;
    true
}

fn put_in(setting: &Setting<'_>, state: &mut State, index: usize, early: bool) {
    let body = &setting.model.bodies[index];
    let shift = if early { setting.gravity * (-0.5 * setting.step) } else { Vec3::zeros() };
    let alone = is_alone(setting, index);
    for sphere in body.first_sphere..body.first_sphere + body.sphere_count {
        let slot = state.slot[sphere as usize] as usize;
        let ball = &mut state.balls[slot];
        (ball.radius, ball.alone) = (setting.model.spheres[sphere as usize].radius, alone);
        ball.velocity = body.velocity + shift;
        if let Some(spin) = state.spins.get_mut(slot) {
            *spin = body.spin;
        }
    }
    let own = body.state().kinetic_energy(body.mass, &body.inertia);
    state.ledger.start += own;
    if !alone {
        state.solids.push(Solid {
            body: index as u32,
            place: body.position,
            velocity: body.velocity + shift,
            turn: body.orientation,
            momentum: turn::momentum(&body.orientation, &body.inertia, &body.spin),
            spin: body.spin,
            load: Default::default(),
        });
        state.carry_members(setting, state.solids.len() - 1);
    }
}

/// Why the run cannot go on: a body that came in the present step overlaps another, or a wall.
pub fn blocked(setting: &Setting<'_>, state: &State) -> Option<String> {
    let model = setting.model;
    if !due(setting, state.step) {
        return None;
    }
    let first = model.first_arrival();
    let fresh = (first..first + state.come).filter(|b| model.arrival_step(*b) == state.step);
    let mut balls = fresh.flat_map(|body| {
        let own = &model.bodies[body];
        let spheres = own.first_sphere..own.first_sphere + own.sphere_count;
        spheres.map(|sphere| &state.balls[state.slot[sphere as usize] as usize])
    });
    balls.find_map(|ball| {
        let taken = other_body(setting, state, ball).or_else(|| wall(setting, state, ball))?;
        let (body, at) = (ball.body, ball.place);
        Some(format!(
            "body {body} comes at ({}, {}, {}) m where {taken} is; insert grains at a lower rate, faster, or \
             farther from those that lie and from walls",
            at.x, at.y, at.z
        ))
    })
}

/// Another body that a ball overlaps.
fn other_body(setting: &Setting<'_>, state: &State, ball: &Ball) -> Option<String> {
    let deep = state.balls.iter().find(|other| {
        let reach = ball.radius + other.radius;
        let overlap = reach - setting.way(ball.place - other.place).norm();
        other.body != ball.body && overlap > ROUNDING * ball.radius.min(other.radius)
    });
    deep.map(|other| format!("body {}", other.body))
}

/// A wall that a ball overlaps.
fn wall(setting: &Setting<'_>, state: &State, ball: &Ball) -> Option<String> {
    let time = state.step as f64 * setting.step;
    let far = (1.0 - ROUNDING) * ball.radius;
    let plane = setting
        .planes_at(time)
        .iter()
        .position(|plane| (ball.place - plane.point).dot(&plane.normal).abs() < far);
    let plane = plane.map(|index| setting.planes[index] as usize);
    let mut faces = Vec::new();
    neighbours::faces_at(setting, time, &mut faces);
    let face = || {
        let near =
            |face: &[Vec3; 3]| (ball.place - surface::closest(&ball.place, face).0).norm() < far;
        Some(setting.surfaces.wall[faces.iter().position(near)?] as usize)
    };
    let number = plane.or_else(face)?;
    Some(format!("wall `{}`", setting.model.walls[number].name))
}

/// What does not go with bodies that come during a run.
pub fn problem(model: &Model) -> Option<&'static str> {
    let needs = model.needs();
    let other = needs.bonds || needs.extra() || needs.mutual_gravity;
    (needs.arrivals && other).then_some(
        "grains cannot be inserted during a run in scenes with bonds, gravity between bodies, or forces besides the linear contact",
    )
}
