//! Drift–kick–drift: places, velocities and orientations at t_n, forces in between.
//!
//! x_m = x_n + Δt/2 v_n; v_{n+1} = v_n + Δt F(x_m)/m; x_{n+1} = x_m + Δt/2 v_{n+1}
//! (position Verlet, Swope et al. 1982). Clumps turn freely for half a step before
//! and after the kick of their angular momentum (see [`super::turn::split`]).
//! O(N) a step; cannot fail.

use super::setting::Setting;
use super::state::State;
use super::turn;

/// First half of the step. True if the lists may miss a contact of the step.
pub fn first_half(setting: &Setting<'_>, state: &mut State) -> bool {
    state.step += 1;
    drift(setting, state);
    let half = 0.5 * setting.step;
    let span = (state.step - state.built_at) as f64 + 0.5;
    let travel = setting.wall_travel(0.0, span * setting.step);
    let room = (0.5 * state.skin).min(state.skin + state.sweep - travel) + state.sweep;
    let square = room * room;
    // Contacts are looked for along the whole step, so both of its ends count.
    let near = |way: &crate::num::Vec3| way.norm_squared() <= square;
    let valid = state.balls.iter().zip(&state.built).all(|(ball, built)| {
        let (way, reach) = (ball.place - built, ball.velocity * half);
        near(&(way + reach)) && near(&(way - reach))
    });
    !valid || room <= 0.0
}

/// Kick and second half of the step.
pub fn second_half(setting: &Setting<'_>, state: &mut State) {
    let (gravity, step) = (setting.gravity, setting.step);
    for (slot, (ball, load)) in state.balls.iter_mut().zip(&state.loads).enumerate() {
        if ball.alone {
            ball.velocity += (load.force * state.light.at(slot).mass + gravity) * step;
        }
    }
    if setting.needs.rotation {
        for (slot, (spin, load)) in state.spins.iter_mut().zip(&state.loads).enumerate() {
            *spin += load.torque * (state.light.at(slot).inertia * step);
        }
    }
    for solid in &mut state.solids {
        let body = &setting.model.bodies[solid.body as usize];
        solid.velocity += (solid.load.force / body.mass + gravity) * step;
        solid.momentum += solid.load.torque * step;
    }
    drift(setting, state);
}

fn drift(setting: &Setting<'_>, state: &mut State) {
    let half = 0.5 * setting.step;
    for ball in &mut state.balls {
        if ball.alone {
            ball.place += ball.velocity * half;
        }
    }
    for index in 0..state.solids.len() {
        let solid = &mut state.solids[index];
        let inertia = &setting.model.bodies[solid.body as usize].inertia;
        solid.place += solid.velocity * half;
        solid.turn = turn::split(&solid.turn, inertia, &solid.momentum, half);
        solid.spin = turn::spin(&solid.turn, inertia, &solid.momentum);
        state.carry_members(setting, index);
    }
}
