//! Drift–kick–drift: places, velocities and orientations at t_n, forces in between.
//!
//! x_m = x_n + Δt/2 v_n; v_{n+1} = v_n + Δt F(x_m)/m; x_{n+1} = x_m + Δt/2 v_{n+1}
//! (position Verlet, Swope et al. 1982). Clumps turn freely for half a step before
//! and after the kick of their angular momentum (see [`super::turn::split`]).
//! O(N) a step; cannot fail.

#[cfg(target_arch = "x86_64")]
use super::lanes::Four;
use super::lanes::{Plain, Wide};
use super::setting::Setting;
use super::state::State;
use super::turn;
use crate::num::Vec3;

/// First half of the step. True if the lists may miss a contact of the step.
pub fn first_half(setting: &Setting<'_>, state: &mut State) -> bool {
    state.step += 1;
    let half = 0.5 * setting.step;
    let span = (state.step - state.built_at) as f64 + 0.5;
    let travel = setting.wall_travel(0.0, span * setting.step);
    let walls_far = travel > state.wall_leeway + state.sweep;
    let inside = drift_alone(setting, state);
    drift_solids(setting, state);
    if inside && state.solids.is_empty() {
        return walls_far;
    }
    // Contacts are looked for along the whole step, so both of its ends count.
    let built = state.built.iter().zip(&state.leeway);
    let valid = state.balls.iter().zip(built).all(|(ball, (built, leeway))| {
        let room = f64::from(*leeway) + state.sweep;
        let near = |way: &Vec3| way.norm_squared() <= room * room;
        let (way, reach) = (ball.place - built, ball.velocity * half);
        near(&(way + reach)) && near(&(way - reach))
    });
    !valid || walls_far
}

/// Kick and second half of the step.
pub fn second_half(setting: &Setting<'_>, state: &mut State) {
    kick_alone(setting, state);
    for solid in &mut state.solids {
        let body = &setting.model.bodies[solid.body as usize];
        solid.velocity += (solid.load.force / body.mass + setting.gravity) * setting.step;
        solid.momentum += solid.load.torque * setting.step;
    }
    drift_solids(setting, state);
}

/// Moves the balls that are bodies by themselves for half a step. True if they stay, half a
/// step before and after, in a cube inside the ball of their leeway about where lists were built.
fn drift_alone(setting: &Setting<'_>, state: &mut State) -> bool {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        #[target_feature(enable = "avx2")]
        fn with_avx2(setting: &Setting<'_>, state: &mut State) -> bool {
            drift_by::<Four>(setting, state)
        }
        // SAFETY: the processor has what the function asks for.
        return unsafe { with_avx2(setting, state) };
    }
    drift_by::<Plain>(setting, state)
}

/// [`drift_alone`], the three numbers of a vector side by side.
#[inline(always)]
fn drift_by<L: Wide<4>>(setting: &Setting<'_>, state: &mut State) -> bool {
    let half = L::splat(0.5 * setting.step);
    let mut inside = L::all(true);
    let built = state.built.iter().zip(&state.leeway);
    for (ball, (built, leeway)) in state.balls.iter_mut().zip(built) {
        if !ball.alone {
            continue;
        }
        let reach = L::three(&ball.velocity) * half;
        let place = L::three(&ball.place) + reach;
        place.keep_three(&mut ball.place);
        let way = (place - L::three(built)).abs() + reach.abs();
        // A little less than 1/√3 of it.
        let edge = 0.577 * (f64::from(*leeway) + state.sweep);
        inside = L::both(inside, way.at_most(L::splat(edge)));
    }
    L::bits(inside) == 0b1111
}

/// Kicks the balls that are bodies by themselves, and moves them for half a step.
fn kick_alone(setting: &Setting<'_>, state: &mut State) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        #[target_feature(enable = "avx2")]
        fn with_avx2(setting: &Setting<'_>, state: &mut State) {
            kick_by::<Four>(setting, state);
        }
        // SAFETY: the processor has what the function asks for.
        return unsafe { with_avx2(setting, state) };
    }
    kick_by::<Plain>(setting, state);
}

/// [`kick_alone`], the three numbers of a vector side by side.
#[inline(always)]
fn kick_by<L: Wide<4>>(setting: &Setting<'_>, state: &mut State) {
    let (gravity, step) = (L::three(&setting.gravity), L::splat(setting.step));
    let half = L::splat(0.5 * setting.step);
    let lights = &state.light;
    for (slot, (ball, load)) in state.balls.iter_mut().zip(&state.loads).enumerate() {
        if !ball.alone {
            continue;
        }
        let pull = L::three(&load.force) * L::splat(lights.at(slot).mass) + gravity;
        let velocity = L::three(&ball.velocity) + pull * step;
        velocity.keep_three(&mut ball.velocity);
        (L::three(&ball.place) + velocity * half).keep_three(&mut ball.place);
    }
    for (slot, (spin, load)) in state.spins.iter_mut().zip(&state.loads).enumerate() {
        let gain = L::three(&load.torque) * L::splat(lights.at(slot).inertia * setting.step);
        (L::three(spin) + gain).keep_three(spin);
    }
}

/// Moves and turns clumps for half a step.
fn drift_solids(setting: &Setting<'_>, state: &mut State) {
    let half = 0.5 * setting.step;
    for index in 0..state.solids.len() {
        let solid = &mut state.solids[index];
        let inertia = &setting.model.bodies[solid.body as usize].inertia;
        solid.place += solid.velocity * half;
        solid.turn = turn::split(&solid.turn, inertia, &solid.momentum, half);
        solid.spin = turn::spin(&solid.turn, inertia, &solid.momentum);
        state.carry_members(setting, index);
    }
}
