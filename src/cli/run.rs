//! `riprap run`: all stages up to our own DEM.

use super::arguments;
use super::{Ending, Screen};
use crate::model::{Outcome, Run};
use crate::scene::road::Road;
use serde_json::json;

pub fn run(arguments: &arguments::Run, screen: &Screen) -> Result<(), Ending> {
    let scene = &arguments.scene;
    let mut road = Road::open(&scene.scene, scene.output.as_deref(), screen.job())?;
    let (packed, built, run) = road.run(arguments.resume)?;
    road.page(&packed, &built, &run)?;
    screen.remarks(&mut road);
    let text = format!("{}{}\n", summary(&run), road.store.path("report/index.html").display());
    let json = json!({
        "output": road.store.root(),
        "outcome": run.outcome,
        "steps": run.cost.steps,
        "step_seconds": built.model.plan.step,
        "cost": run.cost,
        "last": run.series.last(),
    });
    screen.result(&json, &text)?;
    finished(&run)
}

/// An ending of its own for runs that the guard stopped.
pub fn finished(run: &Run) -> Result<(), Ending> {
    match &run.outcome {
        Outcome::Stopped { step, time, reason } => Err(Ending::Work(format!(
            "{} stopped at step {step} (t = {time:.6e} s): {reason}",
            run.solver
        ))),
        Outcome::Failed { reason } => Err(Ending::Work(reason.clone())),
        Outcome::Cancelled { .. } => Err(Ending::Cancelled("stopped".to_owned())),
        Outcome::Finished => Ok(()),
    }
}

/// One paragraph on a run.
pub fn summary(run: &Run) -> String {
    let mut text =
        format!("{}: {} steps, {:.2} CPU s", run.solver, run.cost.steps, run.cost.cpu_seconds);
    if let Some(speed) = run.cost.speed() {
        text.push_str(&format!(", {:.2} M sphere-steps/s", speed * 1e-6));
    }
    if let Some(last) = run.series.last() {
        text.push_str(&format!(
            "\nat t = {:.4} s: kinetic energy {:.3e} J, coordination {:.2}, worst overlap {:.2e} R",
            last.time, last.kinetic, last.coordination, last.worst_overlap
        ));
        if let Some(error) = last.energy_error {
            text.push_str(&format!(", energy error {error:.1e} J"));
        }
    }
    for note in &run.notes {
        text.push_str(&format!("\n{note}"));
    }
    text.push('\n');
    text
}
