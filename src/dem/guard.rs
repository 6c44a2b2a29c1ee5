//! Stops a run that can no longer be trusted, in words that say what to do.
//!
//! After each step in which lists were built (a body cannot go farther than its leeway
//! between two builds), and every [`EVERY`] steps:
//! - numbers that are not finite, bodies outside the domain (unless [`super::lost`] is for them), bodies that move too large a
//!   part of a radius in a step (and may pass through walls and each other);
//! - a step above the bound of the contacts that are there now (see [`super::network`]);
//! - overlaps.
//!
//! Every [`EVERY`] steps only, since they cost about a force pass each:
//! - energy from nowhere in the ledger;
//! - shaking: in an unstable run the fastest mode changes sign in every step, which no
//!   contact that is resolved does. With Δ the changes of all contact forces from one step
//!   to the next, Σ Δ_n·Δ_{n+1}/m over √(Σ Δ_n²/m Σ Δ_{n+1}²/m) is cos ω Δt for a mode, so -1
//!   at the limit. Three times in a row below −[`Guard::shaking`](crate::model::Guard), with changes of
//!   at least [`NOISE`] of the forces that do not die out (by half between two looks), and the run stops. The ledger does not see this: an unstable
//!   bed compacts, and its dashpots take what gravity gives.
//!
//! If the plan insists, what concerns the step is noted instead. O(N + contacts) a look.

use super::ledger;
use super::network::Network;
use super::setting::Setting;
use super::state::State;
use crate::model::{Frame, Guard, Lost};
use crate::num::Vec3;
use nalgebra::Vector3;

/// Most steps between two looks.
pub const EVERY: u64 = crate::model::LOOK_EVERY;
/// Changes of contact forces below this part of the forces are not looked at.
const NOISE: f64 = 1e-3;
/// Nor those that so many units in the last place of the positions make: bodies between walls
/// that push with equal forces feel nothing else.
const UNITS: f64 = 1e3;
/// The last good frame is kept in scenes of at most so many spheres: it takes 200 bytes each, half
/// of what all else does.
const KEPT: usize = 20_000;

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

/// Looks after a run. Nothing of it changes a number of the run.
#[derive(Debug, Default)]
pub struct Watch {
    rebuilds: u64,
    /// Forces of the last two steps while they are compared, and the builds they belong to. Single
    /// precision: changes below [`NOISE`] do not count.
    loads: Vec<Vec<Vector3<f32>>>,
    loads_of: u64,
    /// Times in a row that the run was found shaking, and how much of the forces changed.
    shaking: (u32, f64),
    /// What has been noted.
    noted: Vec<&'static str>,
    /// The last frame of a look that found nothing.
    pub good: Option<Frame>,
    /// What was found and not acted on.
    pub notes: Vec<String>,
}

impl Watch {
    /// Whether [`Watch::after_step`] will look at the present step.
    pub fn looks_at(&self, state: &State) -> bool {
        // Three loads in a row are compared, once every `EVERY` steps.
        let compared = state.step % EVERY >= EVERY - 3;
        compared || state.step.is_multiple_of(EVERY) || state.rebuilds != self.rebuilds
    }

    /// To be called after each step, with places at `state.step` times the step. Why the run
    /// must stop; `None` if all is well.
    pub fn after_step(&mut self, setting: &Setting<'_>, state: &State) -> Option<String> {
        let due = state.step.is_multiple_of(EVERY);
        let rebuilt = state.rebuilds != self.rebuilds;
        let mut stop = None;
        if due || rebuilt {
            self.rebuilds = state.rebuilds;
            stop = self.look(setting, state, due);
        }
        if stop.is_none() && state.step % EVERY >= EVERY - 3 {
            stop = self.compare(setting, state);
        }
        stop
    }

    /// Looks now; `whole` at what costs a force pass too.
    pub fn look(&mut self, setting: &Setting<'_>, state: &State, whole: bool) -> Option<String> {
        let guard = &setting.model.plan.guard;
        if let Some(reason) = places(setting, state) {
            return Some(reason);
        }
        let network = Network::new(setting, state, state.step as f64 * setting.step);
        let fast = self.once("travel", setting, state, || travel(setting, state, guard));
        if fast.is_some() {
            return fast;
        }
        let bound = self.once("bound", setting, state, || {
            network.exceeded_by(setting.step).map(|bound| {
                format!(
                    "the step {} s is above the stability bound {:.4e} s of the contacts that are \
                     there now, that of body {} first; use a step below the bound, or lower the \
                     stiffness",
                    setting.step, bound.step, bound.body
                )
            })
        });
        if bound.is_some() {
            return bound;
        }
        // A crowded packing that relaxes is deep in itself.
        let watched = guard.overlap > 0.0 && setting.model.plan.zero_every == 0;
        let deepest = network.deepest().filter(|worst| watched && worst.depth > guard.overlap);
        if let Some(worst) = deepest {
            return Some(format!(
                "{worst}; use a stiffer contact, a smaller step or slower walls, or raise \
                 plan.guard.overlap ({})",
                guard.overlap
            ));
        }
        if !whole {
            return None;
        }
        if let Some(reason) = gain(setting, state, guard) {
            return Some(reason);
        }
        if state.balls.len() <= KEPT {
            self.good = None;
            self.good = Some(state.frame(setting));
        }
        None
    }

    /// Compares the loads of this step with those of the two before.
    fn compare(&mut self, setting: &Setting<'_>, state: &State) -> Option<String> {
        let most = setting.model.plan.guard.shaking;
        if most == 0.0 {
            return None;
        }
        if self.loads_of != state.rebuilds || state.step % EVERY == EVERY - 3 {
            // Spheres may have changed places in memory; what is left of the last look is old.
            self.loads.clear();
            self.loads_of = state.rebuilds;
        }
        if self.loads.len() < 2 {
            self.loads.push(state.loads.iter().map(|load| load.force.map(|f| f as f32)).collect());
            return None;
        }
        let (opposed, change, body) = shaking(setting, state, &std::mem::take(&mut self.loads));
        let (times, before) = self.shaking;
        self.shaking = match (opposed > most, change > 0.5 * before) {
            (true, true) => (times + 1, change),
            (true, false) => (1, change),
            _ => (0, 0.0),
        };
        if self.shaking.0 < 3 {
            return None;
        }
        self.once("shaking", setting, state, || {
            Some(format!(
                "contact forces change sign from step to step (body {body} most): the run is \
                 unstable at the step {} s; use half of it, or lower the stiffness",
                setting.step
            ))
        })
    }

    /// The reason that `find` finds, unless the plan insists on its step; then it is noted,
    /// the first time of its `kind`, and not looked for again.
    fn once(
        &mut self,
        kind: &'static str,
        setting: &Setting<'_>,
        state: &State,
        find: impl FnOnce() -> Option<String>,
    ) -> Option<String> {
        if !setting.model.plan.insist {
            return find();
        }
        if !self.noted.contains(&kind)
            && let Some(reason) = find()
        {
            let time = state.step as f64 * setting.step;
            self.noted.push(kind);
            self.notes.push(format!("at t = {time:.6} s, gone on as insisted: {reason}"));
        }
        None
    }
}

/// Numbers that are not finite, and bodies outside the domain.
fn places(setting: &Setting<'_>, state: &State) -> Option<String> {
    let stops = setting.model.plan.guard.lost == Lost::Stop;
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
        if stops && setting.model.is_outside(&ball.place) {
            return Some(format!(
                "body {body} left the domain at ({}, {}, {}) m; enlarge the domain, close the \
                 walls, or reduce the time step if it went through one",
                ball.place.x, ball.place.y, ball.place.z
            ));
        }
    }
    None
}

/// Bodies that move too far in a step.
fn travel(setting: &Setting<'_>, state: &State, guard: &Guard) -> Option<String> {
    let most = guard.travel;
    let fast =
        |velocity: &Vec3, radius: f64| most > 0.0 && velocity.norm() * setting.step > most * radius;
    let ball = state.balls.iter().find(|ball| fast(&ball.velocity, ball.radius))?;
    let speed = ball.velocity.norm();
    Some(format!(
        "body {} moves {:.2} of its radius in one step (speed {speed} m/s) and may pass through \
         walls and other bodies; use a step below {:.3e} s",
        ball.body,
        speed * setting.step / ball.radius,
        0.1 * ball.radius / speed
    ))
}

/// Energy that came from nowhere.
fn gain(setting: &Setting<'_>, state: &State, guard: &Guard) -> Option<String> {
    if guard.gain == 0.0 {
        return None;
    }
    let row = ledger::row(setting, state);
    let error = row.energy_error?;
    let taken = row.normal_dashpot + row.tangential_dashpot + row.slip + row.local_damping;
    let there = row.kinetic
        + row.elastic
        + taken
        + row.rolling.abs()
        + row.drag
        + row.attraction.abs()
        + row.wall_work.abs()
        + row.gravitational.abs();
    (error > guard.gain * there).then(|| {
        format!(
            "the energy ledger has {:.3e} J too much, {:.2} of all energy: the step {} s is too \
             large for what happens; reduce it, or raise plan.guard.gain ({})",
            error,
            error / there,
            setting.step,
            guard.gain
        )
    })
}

/// Largest force that a contact answers to a jump with, N/m.
fn stiffest(setting: &Setting<'_>) -> f64 {
    let size = setting.model.contacts.size() as u16;
    let laws = (0..size).flat_map(|a| (a..size).map(move |b| (a, b)));
    laws.map(|(a, b)| {
        let law = setting.stiff_pair(a, b);
        law.kn.max(law.kt) + 2.0 * law.cn.max(law.ct) / setting.step
    })
    .fold(0.0, f64::max)
}

/// How far the last change of the forces is opposed to the one before, its size over that of
/// the forces, and the body whose forces change most; `loads` are those of the two steps before.
fn shaking(setting: &Setting<'_>, state: &State, loads: &[Vec<Vector3<f32>>]) -> (f64, f64, u32) {
    let (mut product, mut squares, mut whole, mut rounding) = (0.0, [0.0; 2], 0.0, 0.0);
    let stiffest = stiffest(setting);
    let mut most = (0.0, 0);
    for (slot, ball) in state.balls.iter().enumerate() {
        let light = 1.0 / setting.model.bodies[ball.body as usize].mass;
        let now = state.loads[slot].force;
        let [before, last] = [0, 1].map(|at: usize| loads[at][slot].cast::<f64>());
        let (early, late) = (last - before, now - last);
        product += early.dot(&late) * light;
        squares[0] += early.norm_squared() * light;
        squares[1] += late.norm_squared() * light;
        whole += now.norm_squared() * light;
        let unit = f64::EPSILON * ball.place.amax();
        rounding += (UNITS * unit * stiffest).powi(2) * light;
        let change = late.norm_squared() * light;
        if change > most.0 {
            most = (change, ball.body);
        }
    }
    let noise = NOISE * NOISE * whole + rounding;
    if squares[0] <= noise || squares[1] <= noise {
        return (0.0, 0.0, most.1);
    }
    let change = (squares[1] / whole).sqrt();
    (-product / (squares[0].sqrt() * squares[1].sqrt()), change, most.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dem::crew::Crew;
    use crate::dem::neighbours;
    use crate::dem::test_scenes::{RADIUS, add_sphere, contact, empty};
    use crate::model::Scheme;

    #[test]
    fn only_steps_in_a_row_are_compared_whenever_lists_are_built() {
        let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
        add_sphere(&mut model, Vec3::zeros(), RADIUS, Vec3::zeros(), Vec3::zeros());
        let setting = Setting::new(&model);
        let mut state = State::new(&setting);
        neighbours::rebuild(&setting, &mut state, &Crew::new(1));
        let mut stops = |load: fn(u64) -> f64, built_at: u64| {
            let mut watch = Watch::default();
            (1..=6).flat_map(|look| [3, 2, 1].map(|left| look * EVERY - left)).any(|step| {
                state.step = step;
                state.rebuilds += u64::from(step == built_at);
                state.loads[0].force = Vec3::z() * load(step);
                watch.after_step(&setting, &state).is_some()
            })
        };
        let shaking = |step: u64| 1.0 + 0.1 * f64::from(u8::from(step.is_multiple_of(2)));
        // Falls from look to look, but rises steadily in each.
        let rising = |step: u64| 10.0 - (step / EVERY) as f64 + 0.01 * (step % EVERY) as f64;
        for left in [3, 2, 1] {
            assert!(stops(shaking, 2 * EVERY - left));
            assert!(!stops(rising, 2 * EVERY - left));
        }
    }
}
