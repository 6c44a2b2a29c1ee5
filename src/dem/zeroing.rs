//! Relaxing by force: all velocities and spins become zero every so many steps.
//!
//! The note on P11 and P15 settles packings that begin with large overlaps so, and nothing
//! flies out through a wall. Momentum is not kept and the motion in between means
//! nothing; the kinetic energy taken is counted in the ledger. In YADE's scheme the
//! velocities that lag half a step become zero, as `PyRunner` before `NewtonIntegrator` does it. O(N).

use super::ledger;
use super::setting::Setting;
use super::state::State;
use crate::model::Plan;
use crate::num::Vec3;

/// Whether velocities become zero after step `step`.
pub fn due(plan: &Plan, step: u64) -> bool {
    plan.zero_every > 0 && step <= plan.zero_until && step.is_multiple_of(plan.zero_every)
}

/// Sets velocities to zero if the present step is due for it.
pub fn apply(setting: &Setting<'_>, state: &mut State) {
    if !due(&setting.model.plan, state.step) {
        return;
    }
    let before = ledger::kinetic(setting, state);
    calm(state);
    state.ledger.zeroed += before - ledger::kinetic(setting, state);
}

/// Sets all velocities and spins to zero.
pub fn calm(state: &mut State) {
    for ball in &mut state.balls {
        ball.velocity = Vec3::zeros();
    }
    state.spins.fill(Vec3::zeros());
    for solid in &mut state.solids {
        solid.velocity = Vec3::zeros();
        solid.momentum = Vec3::zeros();
        solid.spin = Vec3::zeros();
    }
}
