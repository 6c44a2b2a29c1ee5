//! Reads back what LIGGGHTS wrote: dumps of all spheres, the last contacts, the loop time.

use crate::model::{Model, Run};
use crate::num::Vec3;
use crate::solver::dump::{self, Points, offsets};
use crate::solver::liggghts::{multisphere, values};
use crate::solver::process::Ended;
use crate::solver::reading::{self, Read, vector};
use crate::solver::{Deck, SolverError, orientation};

/// Files that a run writes.
pub const OUTPUTS: &[&str] = &["spheres.dump", "last.dump", "contacts.dump", "log.liggghts"];

/// Everything of one run.
pub fn run(
    solver: &'static str,
    model: &Model,
    deck: &Deck,
    ended: &Ended,
) -> Result<Run, SolverError> {
    let points = values::points(model).into_iter().collect();
    let inserted = multisphere::is_used(model);
    let order = if inserted { multisphere::order(model) } else { Vec::new() };
    let names = ["spheres.dump", "last.dump"];
    let frames = dump::spheres(model, &points, &order, deck, ended, names)?;
    let touches = match frames.last() {
        Some(last) if last.step == model.plan.steps && ended.success => {
            Some(dump::contacts(model, last, &order, &deck.folder.join("contacts.dump"), force)?)
        }
        _ => None,
    };
    let read = Read {
        frames,
        touches,
        loop_seconds: dump::loop_seconds(ended),
        notes: notes(model, &points),
    };
    reading::run(solver, model, deck, ended, read)
}

fn notes(model: &Model, points: &Points) -> Vec<String> {
    let mut notes = Vec::new();
    if model.needs().gravity {
        let single = if multisphere::is_used(model) { " single" } else { "" };
        notes.push(format!("forces on{single} spheres include the weight of each sphere"));
        let points = points.len();
        if points > 0 {
            notes.push(format!(
                "of {points} clumps a point that is no sphere carries 99 % of the weight, so that it acts at the centre of mass"
            ));
        }
    }
    if !model.needs().clumps {
        return notes;
    }
    let clumps = || (0..model.bodies.len()).filter(|i| model.bodies[*i].sphere_count > 1);
    notes.push(
        "states of clumps are rebuilt from the places of their spheres by least squares".into(),
    );
    let fixed = |i: &usize| orientation::is_fixed_by(&offsets(model, points, *i));
    let lines = clumps().filter(|i| !fixed(i)).count();
    if lines > 0 {
        notes.push(format!(
            "the turn of {lines} clumps about the line of their sphere centres cannot be read back"
        ));
    }
    notes
}

/// id, id, periodic flag, normal force on the first (3), tangential force (3, with friction).
fn force(row: &[f64], away: &Vec3) -> Option<(f64, f64)> {
    if row.len() < 6 {
        return None;
    }
    let force = vector(row, 3);
    let normal = force.norm() * if force.dot(away) < 0.0 { -1.0 } else { 1.0 };
    Some((normal, if row.len() >= 9 { vector(row, 6).norm() } else { 0.0 }))
}
