//! `riprap compare`: the same scene here and in the installed solvers.

use super::arguments::Compare;
use super::export::named;
use super::{Ending, Screen};
use crate::report::compare::Comparison;
use crate::scene::compared::Compared;
use crate::scene::road::Road;
use crate::solver::{self, Solver};
use crate::study;
use serde_json::json;

pub fn compare(arguments: &Compare, screen: &Screen) -> Result<(), Ending> {
    if arguments.only.is_some() && !arguments.all {
        return Err(Ending::Input("--only chooses cases of --all; give --all too".to_owned()));
    }
    let solvers = chosen(&arguments.with, screen)?;
    let Some(scene) = &arguments.scene else { return matrix(arguments, &solvers, screen) };
    let mut road = Road::open(scene, arguments.output.as_deref(), screen.job())?;
    if let Some(every) = arguments.lock_step {
        return lock_step(&mut road, &solvers, every, screen);
    }
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

/// The built-in comparison matrix.
fn matrix(
    arguments: &Compare,
    solvers: &[&'static dyn Solver],
    screen: &Screen,
) -> Result<(), Ending> {
    let folder = arguments.output.clone().unwrap_or_else(|| "riprap-matrix".into());
    std::fs::create_dir_all(&folder)
        .map_err(|error| Ending::Input(format!("{}: cannot write: {error}", folder.display())))?;
    let only = arguments.only.as_deref().unwrap_or("");
    let found = study::matrix::run(solvers, only, &folder, &screen.job())?;
    let files = found.findings.write(&folder, "riprap compare --all")?;
    screen.say(&format!("wrote {} files into {}", files.len(), folder.display()));
    let value = json!({ "passed": found.passed, "found": found.findings.json(), "files": files });
    screen.result(&value, &found.findings.text())?;
    if solvers.is_empty() {
        return Err(Ending::Solver("no outside solver is installed: nothing was compared".into()));
    }
    if found.passed {
        return Ok(());
    }
    Err(Ending::Work("some cases are outside their tolerance; see the table".to_owned()))
}

/// A scene in lock-step.
fn lock_step(
    road: &mut Road,
    solvers: &[&'static dyn Solver],
    every: u64,
    screen: &Screen,
) -> Result<(), Ending> {
    let found = road.lock_step(solvers, every, every)?;
    screen.remarks(road);
    let mut text = format!(
        "{}: all codes start again from the same state every {every} steps\n\
         largest distance at the end of a segment, in smallest radii\n\
         {:10} {:>9} {:>22} {:>22}\n",
        found.title, "", "segments", "from its own scheme", "from riprap's scheme"
    );
    for solver in solvers {
        let count = found.segments.iter().filter(|s| s.solver == solver.key()).count();
        if let Some([twin, ours]) = found.worst(solver.key()) {
            text.push_str(&format!("{:10} {count:>9} {twin:>22.1e} {ours:>22.1e}\n", solver.key()));
        }
    }
    found.failures.iter().for_each(|failure| text.push_str(&format!("{failure}\n")));
    screen.result(&found, &text)?;
    if let Some(failure) = found.failures.first() {
        return Err(Ending::Solver(failure.clone()));
    }
    if solvers.is_empty() {
        return Err(Ending::Solver("no outside solver is installed: nothing was compared".into()));
    }
    if found.passed() {
        return Ok(());
    }
    Err(Ending::Work(format!(
        "a solver is more than {:e} radii from riprap in its scheme at the end of a segment",
        found.tolerance
    )))
}

/// The solvers to compare with: those asked for, all of which must be installed, or all that are.
pub fn chosen(keys: &[String], screen: &Screen) -> Result<Vec<&'static dyn Solver>, Ending> {
    if !keys.is_empty() {
        let solvers = named(keys)?;
        let missing = solvers.iter().find(|solver| solver.find().is_none());
        return match missing {
            Some(solver) => Err(Ending::Solver(format!("{} {}", solver.name(), solver.absence()))),
            None => Ok(solvers),
        };
    }
    let (found, missing): (Vec<_>, Vec<_>) =
        solver::all().into_iter().partition(|s| s.find().is_some());
    for solver in missing {
        screen.warn(&format!("{} is left out: it {}", solver.name(), solver.absence()));
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
