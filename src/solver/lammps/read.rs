//! Reads back what LAMMPS wrote: dumps of all spheres, the last contacts, the loop time.

use super::values;
use crate::model::{Frame, Model, Run};
use crate::num::Vec3;
use crate::solver::dump::{self, Points};
use crate::solver::process::Ended;
use crate::solver::reading::{self, Read};
use crate::solver::{Deck, SolverError};

/// Files that a run writes.
pub const OUTPUTS: &[&str] = &["spheres.dump", "last.dump", "contacts.dump", "log.lammps"];

/// Everything of one run.
pub fn run(
    solver: &'static str,
    model: &Model,
    deck: &Deck,
    ended: &Ended,
) -> Result<Run, SolverError> {
    let mut frames =
        dump::spheres(model, &Points::new(), &[], deck, ended, ["spheres.dump", "last.dump"])?;
    if let Some(first) = frames.first_mut().filter(|frame| frame.step == 0) {
        take_back(model, first);
    }
    let touches = match frames.last() {
        Some(last) if last.step == model.plan.steps && ended.success => {
            let path = deck.folder.join("contacts.dump");
            Some(dump::contacts(model, last, &[], &path, force)?)
        }
        _ => None,
    };
    // With arrivals there is a loop time for each part of the run.
    let whole = model.arrivals.is_empty();
    let loop_seconds = dump::loop_seconds(ended).filter(|_| whole);
    reading::run(
        solver,
        model,
        deck,
        ended,
        Read { frames, touches, loop_seconds, notes: notes(model) },
    )
}

/// The velocities of clumps at step 0 without what the deck adds to them.
fn take_back(model: &Model, frame: &mut Frame) {
    let kick = values::missed_kick(model);
    for (body, state) in model.bodies.iter().zip(&mut frame.bodies) {
        if body.sphere_count > 1 {
            state.velocity -= kick;
            let spheres =
                body.first_sphere as usize..(body.first_sphere + body.sphere_count) as usize;
            frame.velocities[spheres].iter_mut().for_each(|velocity| *velocity -= kick);
        }
    }
}

fn notes(model: &Model) -> Vec<String> {
    let needs = model.needs();
    let mut notes = Vec::new();
    if needs.gravity && needs.spheres {
        notes.push("forces on single spheres include their weight".into());
    }
    if needs.clumps {
        notes.push(
            "states of clumps are rebuilt from the places of their spheres by least squares".into(),
        );
    }
    notes
}

/// id, id, normal force, tangential force (with friction).
fn force(row: &[f64], _away: &Vec3) -> Option<(f64, f64)> {
    Some((*row.get(2)?, row.get(3).copied().unwrap_or(0.0)))
}
