//! `riprap export`: decks that run as they are.

use super::arguments::Export;
use super::{Ending, Screen};
use crate::scene::road::Road;
use crate::solver::{self, Solver};
use serde_json::json;

pub fn export(arguments: &Export, screen: &Screen) -> Result<(), Ending> {
    let solvers = named(&arguments.to)?;
    let scene = &arguments.scene;
    let mut road = Road::open(&scene.scene, scene.output.as_deref(), screen.job())?;
    let (_, built) = road.built()?;
    let mut text = String::new();
    let mut written = Vec::new();
    let mut unable = Vec::new();
    for solver in solvers {
        if let Some(refusal) = solver.refusal(&built.model) {
            // The others get their decks all the same.
            unable.push(refusal.of(solver));
            continue;
        }
        let limits = solver.limits(&built.model);
        for limit in &limits {
            screen.say(&format!("note: {}: {}", solver.name(), limit.what));
        }
        let options = options(arguments, solver, screen);
        let deck = road.export(solver, &built.model, &options)?;
        text.push_str(&format!("{}\n", deck.folder.join("run.sh").display()));
        let notes: Vec<&str> = limits.iter().map(|limit| limit.what.as_str()).collect();
        written.push(json!({ "solver": solver.key(), "folder": deck.folder, "notes": notes }));
    }
    screen.result(&json!({ "decks": written, "unable": unable }), &text)?;
    if unable.is_empty() { Ok(()) } else { Err(Ending::Work(unable.join("\n"))) }
}

/// Ranks and processor grid for solvers that take them, one rank for the others.
fn options(arguments: &Export, solver: &dyn Solver, screen: &Screen) -> solver::DeckOptions {
    let one = solver::DeckOptions { queue_script: arguments.queue, ..Default::default() };
    if solver.takes_ranks() {
        let ranks = usize::from(arguments.ranks);
        return solver::DeckOptions { ranks, processors: arguments.processors, ..one };
    }
    if arguments.ranks > 1 {
        screen.say(&format!("note: {}: the deck runs on one rank", solver.name()));
    }
    one
}

/// The solvers with these keys, each once.
pub fn named(keys: &[String]) -> Result<Vec<&'static dyn Solver>, Ending> {
    let twice = |at: usize| keys[..at].contains(&keys[at]);
    keys.iter()
        .enumerate()
        .filter(|(at, _)| !twice(*at))
        .map(|(_, key)| key)
        .map(|key| {
            solver::all().into_iter().find(|solver| solver.key() == key).ok_or_else(|| {
                let known: Vec<&str> = solver::all().iter().map(|solver| solver.key()).collect();
                Ending::Input(format!("there is no solver \"{key}\"; known: {}", known.join(", ")))
            })
        })
        .collect()
}
