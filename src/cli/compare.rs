//! `riprap compare`: the same scene here and in the installed solvers.

use super::arguments::Compare;
use super::export::named;
use super::{Ending, Screen};
use crate::report::compare::Comparison;
use crate::scene::comparing::Compared;
use crate::scene::road::Road;
use crate::solver::{self, Solver};

pub fn compare(arguments: &Compare, screen: &Screen) -> Result<(), Ending> {
    let solvers = chosen(&arguments.with, screen)?;
    let scene = &arguments.scene;
    let mut road = Road::open(&scene.scene, scene.output.as_deref(), screen.job())?;
    let compared = road.compare(&solvers)?;
    screen.remarks(&mut road);
    let asked = !arguments.with.is_empty();
    for sentence in &compared.unable {
        screen.warn(sentence);
    }
    conclude(&road, &compared, screen)?;
    if let Some(sentence) = compared.unable.first().filter(|_| asked) {
        return Err(Ending::Solver(sentence.clone()));
    }
    if solvers.is_empty() {
        let message = "no outside solver is installed; everything else is done";
        return Err(Ending::Solver(message.to_owned()));
    }
    Ok(())
}

/// The solvers to compare with: those asked for, all of which must be installed, or all that are.
pub fn chosen(keys: &[String], screen: &Screen) -> Result<Vec<&'static dyn Solver>, Ending> {
    if !keys.is_empty() {
        let solvers = named(keys)?;
        let missing = solvers.iter().find(|solver| solver.find().is_none());
        return match missing {
            Some(solver) => Err(Ending::Solver(format!(
                "{} is not installed; {}",
                solver.name(),
                solver.how_to_install()
            ))),
            None => Ok(solvers),
        };
    }
    let (found, missing): (Vec<_>, Vec<_>) =
        solver::all().into_iter().partition(|s| s.find().is_some());
    for solver in missing {
        screen.warn(&format!(
            "{} was not found and is left out; {}",
            solver.name(),
            solver.how_to_install()
        ));
    }
    Ok(found)
}

/// Verdict, reasons and cost of each solver.
fn summary(comparison: &Comparison) -> String {
    let mut text = format!("{}\n", comparison.verdict());
    for other in &comparison.others {
        text.push_str(&format!("{}\n", other.side.solver));
        other.reasons.iter().for_each(|reason| text.push_str(&format!("  {reason}\n")));
    }
    text.push_str(&format!(
        "{:32} {:>10} {:>10} {:>22}\n",
        "", "CPU s", "wall s", "M sphere-steps/wall s"
    ));
    for side in
        std::iter::once(&comparison.ours).chain(comparison.others.iter().map(|other| &other.side))
    {
        let cost = &side.cost;
        let speed = cost.speed().map_or(String::new(), |speed| format!("{:.2}", speed * 1e-6));
        text.push_str(&format!(
            "{:32} {:>10.2} {:>10.2} {speed:>22}\n",
            side.solver, cost.cpu_seconds, cost.wall_seconds
        ));
    }
    text
}

/// Prints the result of a comparison.
pub fn conclude(road: &Road, compared: &Compared, screen: &Screen) -> Result<(), Ending> {
    let page = road.store.path("report/index.html");
    let text = format!("{}{}\n", summary(&compared.comparison), page.display());
    screen.result(&compared.comparison, &text)?;
    if let Some(failure) = compared.failures.first() {
        return Err(Ending::Solver(failure.clone()));
    }
    super::run::finished(&compared.ours)?;
    if compared.comparison.passed() || compared.others.is_empty() {
        return Ok(());
    }
    Err(Ending::Work(
        "the solvers differ by more than the stated tolerances; see the report".to_owned(),
    ))
}
