//! Bodies that leave the domain, where the plan says that they are taken out or let go.
//!
//! Every [`EVERY`](super::guard::EVERY) steps, bodies whose centre of mass is outside are taken
//! out: they stay where they are without motion, and their radii become NaN, so that no list
//! holds them any more (no comparison with NaN is true) and no kernel has to know of them. Their
//! kinetic energy and that of their contacts is counted in the ledger. O(spheres) a look,
//! O(bodies taken out) a step; runs that stop at a lost body do neither.

use super::guard::EVERY;
use super::law::Book;
use super::ledger;
use super::setting::Setting;
use super::state::{List, State};
use crate::model::{Lost, Model};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};

/// Bodies named in a note.
const NAMED: usize = 5;

/// A body that was taken out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gone {
    /// Index of the body.
    pub body: u32,
    /// Step after which it was taken out.
    pub step: u64,
    /// Its centre of mass since then, m.
    pub place: Vec3,
}

/// All of them, in the order of time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Leavers {
    /// Bodies that were taken out.
    pub all: Vec<Gone>,
    changed: bool,
}

impl Leavers {
    /// Has lists made anew before the next pass.
    pub fn change(&mut self) {
        self.changed = true;
    }

    /// Whether lists hold bodies that have been taken out since the last call.
    pub fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }
}

/// To be called at the end of each step: takes out what has left, and holds what is out.
pub fn apply(setting: &Setting<'_>, state: &mut State) {
    if setting.model.plan.guard.lost != Lost::Remove {
        return;
    }
    if state.step.is_multiple_of(EVERY) {
        take_out(setting, state);
    }
    for at in 0..state.gone.all.len() {
        hold(setting, state, at);
    }
}

fn take_out(setting: &Setting<'_>, state: &mut State) {
    let model = setting.model;
    let outside = |place: &Vec3| place.iter().all(|x| x.is_finite()) && model.is_outside(place);
    let singles = state.balls.iter().filter(|ball| ball.alone && !ball.radius.is_nan());
    let mut leaving: Vec<(u32, Vec3)> =
        singles.filter(|ball| outside(&ball.place)).map(|ball| (ball.body, ball.place)).collect();
    let there = |body: u32| {
        let first = model.bodies[body as usize].first_sphere as usize;
        !state.balls[state.slot[first] as usize].radius.is_nan()
    };
    let solids = state.solids.iter().filter(|solid| outside(&solid.place) && there(solid.body));
    leaving.extend(solids.map(|solid| (solid.body, solid.place)));
    if leaving.is_empty() {
        return;
    }
    leaving.sort_unstable_by_key(|(body, _)| *body);
    let energy = |state: &State| ledger::kinetic(setting, state) + ledger::stored(setting, state);
    let before = energy(state);
    for (body, place) in leaving {
        let of = &model.bodies[body as usize];
        for sphere in of.first_sphere..of.first_sphere + of.sphere_count {
            let slot = state.slot[sphere as usize] as usize;
            state.balls[slot].radius = f64::NAN;
            state.loads[slot] = Default::default();
        }
        state.gone.all.push(Gone { body, step: state.step, place });
        hold(setting, state, state.gone.all.len() - 1);
    }
    let gone: Vec<bool> = state.balls.iter().map(|ball| ball.radius.is_nan()).collect();
    forget(&mut state.pairs, |slot, other| gone[slot] || gone[other]);
    forget(&mut state.planes, |slot, _| gone[slot]);
    forget(&mut state.faces, |slot, _| gone[slot]);
    state.gone.changed = true;
    state.ledger.lost += before - energy(state);
}

/// Empties the entries of contacts that `is_gone`.
fn forget(list: &mut List, is_gone: impl Fn(usize, usize) -> bool) {
    let List { start, partner, book } = list;
    let mut entries = Vec::new();
    let touching: &Book = book;
    for slot in 0..start.len().saturating_sub(1) {
        let range = start[slot] as usize..start[slot + 1] as usize;
        entries
            .extend(range.filter(|k| touching.touching[*k] && is_gone(slot, partner[*k] as usize)));
    }
    let mut view = book.view();
    entries.into_iter().for_each(|k| view.clear(k));
}

/// Puts a body that is out back where it was taken out, without motion.
fn hold(setting: &Setting<'_>, state: &mut State, at: usize) {
    let Gone { body, place, .. } = state.gone.all[at];
    if let Ok(index) = state.solids.binary_search_by_key(&body, |solid| solid.body) {
        let solid = &mut state.solids[index];
        solid.place = place;
        (solid.velocity, solid.momentum, solid.spin) =
            (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
        state.carry_members(setting, index);
        return;
    }
    let sphere = setting.model.bodies[body as usize].first_sphere as usize;
    let slot = state.slot[sphere] as usize;
    (state.balls[slot].place, state.balls[slot].velocity) = (place, Vec3::zeros());
    if let Some(spin) = state.spins.get_mut(slot) {
        *spin = Vec3::zeros();
    }
}

/// What people should know of bodies outside the domain.
pub fn notes(setting: &Setting<'_>, state: &State) -> Vec<String> {
    let list = |named: Vec<String>, count: usize| {
        let rest = if count > NAMED { ", ..." } else { "" };
        format!("{}{rest}", named.join(", "))
    };
    match setting.model.plan.guard.lost {
        Lost::Stop => Vec::new(),
        Lost::Remove if state.gone.all.is_empty() => Vec::new(),
        Lost::Remove => {
            let count = state.gone.all.len();
            let named = state.gone.all.iter().take(NAMED).map(|gone| {
                format!("body {} at {:.6} s", gone.body, gone.step as f64 * setting.step)
            });
            let named = list(named.collect(), count);
            vec![format!("{count} bodies left the domain and were taken out: {named}")]
        }
        Lost::GoOn => {
            let places = state.paths(setting).enumerate();
            let outside: Vec<usize> = places
                .filter(|(_, (place, _))| setting.model.is_outside(place))
                .map(|(body, _)| body)
                .collect();
            if outside.is_empty() {
                return Vec::new();
            }
            let named = outside.iter().take(NAMED).map(|body| format!("body {body}"));
            let named = list(named.collect(), outside.len());
            vec![format!("{} bodies are outside the domain at the end: {named}", outside.len())]
        }
    }
}

/// What does not go with bodies that may leave.
pub fn problem(model: &Model) -> Option<&'static str> {
    let needs = model.needs();
    match model.plan.guard.lost {
        Lost::Stop => None,
        Lost::Remove if needs.bonds || needs.extra() || needs.mutual_gravity => Some(
            "bodies that leave the domain cannot be taken out of scenes with bonds, gravity between bodies, or forces besides the linear contact",
        ),
        Lost::GoOn if needs.turning_walls => Some(
            "bodies cannot go on outside the domain where walls turn: how fast a wall moves is known in the domain only",
        ),
        _ => None,
    }
}
