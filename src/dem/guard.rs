//! Stops a run that can no longer be trusted, in words that say what to do.
//!
//! Checked whenever lists are built (a body cannot go farther than half the
//! skin between two builds) and at the end. O(N + contacts).

use super::limit;
use super::setting::Setting;
use super::state::State;

/// Whether all places, motions and loads are finite numbers.
pub fn finite(state: &State) -> bool {
    let balls = state
        .balls
        .iter()
        .all(|ball| ball.place.iter().chain(ball.velocity.iter()).all(|x| x.is_finite()));
    balls
        && state.loads.iter().all(|load| load.force.iter().all(|x| x.is_finite()))
        && state.spins.iter().all(|spin| spin.iter().all(|x| x.is_finite()))
}

/// Why the run must stop now; `None` if all is well.
pub fn check(setting: &Setting<'_>, state: &State) -> Option<String> {
    for ball in &state.balls {
        let body = ball.body;
        let finite = ball.place.iter().chain(ball.velocity.iter()).all(|x| x.is_finite());
        if !finite {
            return Some(format!(
                "body {body} has a position or velocity that is not a finite number; reduce the \
                 time step ({} s) and look for bodies that overlap at the start",
                setting.step
            ));
        }
        if setting.model.is_outside(&ball.place) {
            return Some(format!(
                "body {body} left the domain at ({}, {}, {}) m; enlarge the domain, close the \
                 walls, or reduce the time step if it went through one",
                ball.place.x, ball.place.y, ball.place.z
            ));
        }
        if setting.model.plan.insist {
            continue;
        }
        let speed = ball.velocity.norm();
        if speed * setting.step > 0.5 * ball.radius {
            return Some(format!(
                "body {body} moves {:.2} of its radius in one step (speed {speed} m/s) and may \
                 pass through walls and other bodies; use a step below {:.3e} s",
                speed * setting.step / ball.radius,
                0.1 * ball.radius / speed
            ));
        }
    }
    if setting.model.plan.insist {
        return None;
    }
    let bound = limit::network_bound(setting, state, Some(setting.step))?;
    (setting.step > bound.step).then(|| {
        format!(
            "the step {} s is above the stability bound {:.4e} s of the contacts of body {}; \
             reduce the step or the stiffness, or insist on the step",
            setting.step, bound.step, bound.body
        )
    })
}
