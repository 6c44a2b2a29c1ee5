//! `riprap compare --all`: many small scenes in all solvers, each with a tolerance and its
//! reason, and two kinds of verdict.
//!
//! 1. *Same computation?* Every solver against riprap in that solver's scheme and law, sphere
//!    by sphere: over the whole run where few contacts happen, in lock-step where many do.
//! 2. *Same limit?* For single contacts: every solver against riprap's `path_averaged` as the
//!    step goes to zero. What is left is what the contact laws differ by.
//!
//! Cost: a few seconds a case; the page names each.

mod cases;
mod limit;

use super::{StudyError, go_on};
use crate::dem;
use crate::model::{Frame, Model};
use crate::num::Job;
use crate::report::findings::{Cell, Findings, Sheet};
use crate::report::gallery;
use crate::report::picture::Picture;
use crate::scene::compared::Compared;
use crate::scene::road::{Road, RoadError};
use crate::solver::{Deck, DeckOptions, Solver};
use cases::Case;
use std::path::Path;

/// What came out.
pub struct Matrix {
    /// True if no case is outside its tolerance without a known reason.
    pub passed: bool,
    /// Tables and charts.
    pub findings: Findings,
}

/// A verdict on one solver in one case.
struct Row {
    solver: String,
    from_twin: f64,
    from_ours: f64,
    cpu: f64,
    verdict: String,
    fails: bool,
}

impl Row {
    /// As a row of the sheet of verdicts.
    fn cells(self, case: &Case) -> Vec<Cell> {
        vec![
            case.key.as_str().into(),
            self.solver.into(),
            self.from_twin.into(),
            case.tolerance.into(),
            self.from_ours.into(),
            self.cpu.into(),
            self.verdict.into(),
        ]
    }
}

/// Runs all cases whose key holds `only` in `solvers`; scenes and reports go into
/// `folder/cases`.
///
/// # Errors
/// A scene that riprap itself cannot run; a folder that cannot be written.
pub fn run(
    solvers: &[&'static dyn Solver],
    only: &str,
    folder: &Path,
    job: &Job,
) -> Result<Matrix, StudyError> {
    let chosen: Vec<Case> =
        cases::all().into_iter().filter(|case| case.key.contains(only)).collect();
    if chosen.is_empty() {
        let keys: Vec<String> = cases::all().into_iter().map(|case| case.key).collect();
        let keys = keys.join(", ");
        return Err(StudyError::Input(format!("no case holds \"{only}\"; there are: {keys}")));
    }
    let (mut rows, mut limits, mut charts) = (Vec::new(), Vec::new(), Vec::new());
    let (mut passed, mut verdicts, mut outside) = (true, 0_usize, Vec::new());
    let (mut overview, mut pictures) = (Vec::new(), Vec::new());
    for (number, case) in chosen.iter().enumerate() {
        go_on(job)?;
        job.report("matrix", number as u64, chosen.len() as u64);
        let mut road = open(case, folder, job)?;
        let mut found = match case.lock_step {
            _ if case.resumes => resumed(&mut road, case, solvers)?,
            Some(_) => lock_step(&mut road, case, solvers)?,
            None => whole(&mut road, case, solvers)?,
        };
        if case.ranks {
            found.extend(on_two_ranks(&mut road, case, solvers)?);
        }
        pictures.push(picture(&mut road, case)?);
        if case.limit {
            let (sheet_rows, chart) = limit::small_steps(&mut road, case, solvers, job)?;
            limits.extend(sheet_rows);
            charts.push((format!("limit-{}", case.key), chart));
        }
        overview.push(case_row(case, solvers, &found));
        for row in found {
            verdicts += 1;
            if row.fails {
                passed = false;
                outside.push(format!("{} in {}", case.key, row.solver));
            }
            rows.push(row.cells(case));
        }
    }
    let said = if passed {
        let count = chosen.len();
        format!(
            "No case of {count} ({verdicts} verdicts) is outside its tolerance without a known reason."
        )
    } else {
        format!("Outside their tolerance: {}.", outside.join(", "))
    };
    let where_all_is =
        "Scenes, decks and the report of each case (pictures, charts, energies) are in cases/.";
    Ok(Matrix {
        passed,
        findings: Findings {
            title: "Comparison matrix".into(),
            question: "Does riprap in each solver's own scheme compute what the solver computes, \
                       and do all solvers have riprap's limit as the step goes to zero?"
                .into(),
            remarks: vec![said, where_all_is.into()],
            tables: tables(solvers, overview, rows, limits),
            charts,
            pictures,
        },
    })
}

/// Width and height of a picture of a case at its start and at its end.
const HALF: [usize; 2] = [240, 200];

/// A case at its start and at its end, in riprap.
fn picture(road: &mut Road, case: &Case) -> Result<(String, String, String, Picture), StudyError> {
    let (_, built) = road.built().map_err(work)?;
    let model = built.model;
    let run = dem::run(&model, &road.job).map_err(|error| StudyError::Work(error.to_string()))?;
    let frames: Vec<&Frame> = run.frames.first().into_iter().chain(run.frames.last()).collect();
    let halves = gallery::states(&model, &frames, HALF[0], HALF[1]);
    let name = format!("case-{}", case.key);
    Ok((name, case.key.clone(), case.what.clone(), Picture::beside(&halves)))
}

/// What each solver does in a case, in one row.
fn case_row(case: &Case, solvers: &[&'static dyn Solver], found: &[Row]) -> Vec<Cell> {
    let mut row: Vec<Cell> = vec![case.key.as_str().into(), case.tolerance.into()];
    for solver in solvers {
        let own = found.iter().find(|row| row.solver.starts_with(solver.name()));
        let text = match own {
            None => String::new(),
            Some(row) if row.from_twin.is_nan() => {
                row.verdict.split(':').next().unwrap_or_default().to_owned()
            }
            Some(row) => {
                let kind = row.verdict.split(':').next().unwrap_or_default();
                let size = crate::report::number::significant(row.from_twin, 2);
                format!("{size} {}", kind.replace("differs, known", "(known)"))
            }
        };
        row.push(text.into());
    }
    row.extend([case.what.as_str().into(), case.reason.into()]);
    row
}

fn tables(
    solvers: &[&'static dyn Solver],
    overview: Vec<Vec<Cell>>,
    rows: Vec<Vec<Cell>>,
    limits: Vec<Vec<Cell>>,
) -> Vec<Sheet> {
    let versions = solvers.iter().filter_map(|solver| {
        let found = solver.find()?;
        let program = found.program.display().to_string();
        Some(vec![solver.name().into(), found.version.into(), program.into()])
    });
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let mut heads = vec!["case".to_owned(), "tolerance".to_owned()];
    heads.extend(solvers.iter().map(|solver| solver.name().to_owned()));
    heads.extend(["what".to_owned(), "reason of the tolerance".to_owned()]);
    let mut sheets = vec![
        Sheet {
            key: "cases".into(),
            title: "Same computation?".into(),
            caption: "Largest distance of any sphere from riprap in the solver's own scheme, in \
                      smallest radii, and the verdict; why solvers differ or refuse stands in the \
                      verdicts below."
                .into(),
            columns: heads,
            rows: overview,
        },
        Sheet {
            key: "verdicts".into(),
            title: "Verdicts".into(),
            caption: "Largest distance of any sphere, in smallest radii: from riprap in the \
                      solver's own scheme (judged), and from riprap in its default scheme (what \
                      schemes and laws differ by). CPU time of the solver, start included."
                .into(),
            columns: names(&[
                "case",
                "solver",
                "from its scheme",
                "tolerance",
                "from riprap",
                "CPU [s]",
                "verdict",
            ]),
            rows,
        },
        Sheet {
            key: "versions".into(),
            title: "Solvers".into(),
            caption: String::new(),
            columns: names(&["decks for", "found", "program"]),
            rows: versions.collect(),
        },
    ];
    if !limits.is_empty() {
        sheets.insert(2, limit::sheet(limits));
    }
    sheets
}

fn work(error: RoadError) -> StudyError {
    match error {
        RoadError::Cancelled | RoadError::Paused { .. } => StudyError::Cancelled,
        other => StudyError::Work(other.to_string()),
    }
}

/// Writes the scene of a case into a folder of its own.
fn open(case: &Case, folder: &Path, job: &Job) -> Result<Road, StudyError> {
    let own = folder.join("cases").join(&case.key);
    let path = own.join("scene.toml");
    let files = case.files.iter().map(|(name, text)| (own.join(name), text));
    std::fs::create_dir_all(&own)
        .map_err(|error| StudyError::Work(format!("{}: {error}", own.display())))?;
    for (path, text) in std::iter::once((path.clone(), &case.scene)).chain(files) {
        crate::report::write_whole(&path, text.as_bytes())
            .map_err(|error| StudyError::Work(error.to_string()))?;
    }
    Road::open(&path, None, job.clone())
        .map_err(|error| StudyError::Work(format!("{}: {error}", case.key)))
}

/// One run from start to end.
fn whole(
    road: &mut Road,
    case: &Case,
    solvers: &[&'static dyn Solver],
) -> Result<Vec<Row>, StudyError> {
    let compared = road.compare(solvers).map_err(work)?;
    let mut rows = Vec::new();
    let Compared { comparison, failures, unable, .. } = compared;
    for other in &comparison.others {
        let name = other.side.solver.clone();
        let twin = other.twin.as_ref().and_then(|twin| twin.trajectory.worst);
        let from_twin = twin.map_or(f64::NAN, |worst| worst.largest);
        let ours = other.against_ours.worst.map_or(f64::NAN, |worst| worst.largest);
        let key = solvers.iter().find(|solver| solver.name() == name).map_or("", |s| s.key());
        rows.push(judged(case, key, name, from_twin, ours, other.side.cost.cpu_seconds));
    }
    rows.extend(failures.into_iter().map(failed));
    rows.extend(unable.into_iter().map(|why| cannot(&why)));
    Ok(rows)
}

/// Segments that all start from riprap's states.
fn lock_step(
    road: &mut Road,
    case: &Case,
    solvers: &[&'static dyn Solver],
) -> Result<Vec<Row>, StudyError> {
    let (every, length) = case.lock_step.unwrap_or((1, 1));
    let found = match road.lock_step(solvers, every, length) {
        Ok(found) => found,
        Err(RoadError::Cancelled) => return Err(StudyError::Cancelled),
        Err(error) => return Ok(vec![failed(format!("riprap: {error}"))]),
    };
    let mut rows = Vec::new();
    for solver in solvers {
        let Some([twin, ours]) = found.worst(solver.key()) else { continue };
        let own = found.segments.iter().filter(|segment| segment.solver == solver.key());
        let cpu = own.map(|segment| segment.cpu_seconds).sum();
        rows.push(judged(case, solver.key(), solver.name().into(), twin, ours, cpu));
    }
    for failure in found.failures {
        let refused = failure.contains(" cannot run this scene");
        rows.push(if refused { cannot(&failure) } else { failed(failure) });
    }
    Ok(rows)
}

fn judged(case: &Case, key: &str, solver: String, from_twin: f64, from_ours: f64, cpu: f64) -> Row {
    let agrees = from_twin <= case.tolerance;
    let known = case.known.iter().find(|(of, _)| *of == key);
    let verdict = match (agrees, known) {
        (true, _) => "agrees".to_owned(),
        (false, Some((_, why))) => format!("differs, known: {why}"),
        (false, None) => "DIFFERS".to_owned(),
    };
    Row { solver, from_twin, from_ours, cpu, verdict, fails: !agrees && known.is_none() }
}

fn failed(message: String) -> Row {
    let (solver, what) = message.split_once(": ").unwrap_or(("", &message));
    let what = what.lines().next().unwrap_or_default();
    Row {
        solver: solver.to_owned(),
        from_twin: f64::NAN,
        from_ours: f64::NAN,
        cpu: f64::NAN,
        verdict: format!("FAILED: {what}"),
        fails: true,
    }
}

fn cannot(message: &str) -> Row {
    let (solver, why) = message.split_once(" cannot run this scene: ").unwrap_or(("", message));
    Row {
        solver: solver.to_owned(),
        from_twin: f64::NAN,
        from_ours: f64::NAN,
        cpu: f64::NAN,
        verdict: format!("refused: {why}"),
        fails: false,
    }
}

/// The model of a case over its first segment, or as a whole where it has none; a frame at the end.
fn first_steps(road: &mut Road, case: &Case) -> Result<Model, StudyError> {
    let (_, built) = road.built().map_err(work)?;
    let mut model = built.model;
    model.plan.steps = case.lock_step.map_or(model.plan.steps, |(every, _)| every);
    model.plan.frame_every = model.plan.steps;
    Ok(model)
}

/// Largest distance of a sphere between two frames, in smallest radii; infinite for frames of different steps.
fn apart(model: &Model, a: &Frame, b: &Frame) -> f64 {
    if a.step != b.step {
        return f64::INFINITY;
    }
    let far = a.centres.iter().zip(&b.centres).map(|(a, b)| (a - b).norm());
    far.fold(0.0, f64::max) / model.smallest_radius()
}

/// Solvers that write restart files: a run that is taken back to the one in its middle and goes on, against
/// the run in one piece.
fn resumed(
    road: &mut Road,
    case: &Case,
    solvers: &[&'static dyn Solver],
) -> Result<Vec<Row>, StudyError> {
    let model = first_steps(road, case)?;
    let mut rows = Vec::new();
    for solver in solvers {
        if let Some(refusal) = solver.refusal(&model) {
            rows.push(cannot(&refusal.of(*solver)));
            continue;
        }
        let done = road.export(*solver, &model, &DeckOptions::default()).and_then(|deck| {
            let whole = solver.run(&model, &deck, &road.job)?;
            take_back(&deck, model.plan.steps)
                .map_err(|error| RoadError::Work(format!("{}: {error}", deck.folder.display())))?;
            Ok((whole, solver.run(&model, &deck, &road.job)?))
        });
        match done {
            Ok((whole, rest)) => {
                let (Some(a), Some(b)) = (whole.frames.last(), rest.frames.last()) else {
                    continue;
                };
                let far = apart(&model, a, b);
                let name = format!("{}, resumed", solver.name());
                rows.push(judged(case, solver.key(), name, far, f64::NAN, rest.cost.cpu_seconds));
            }
            Err(error) => rows.push(failed(format!("{}: {error}", solver.name()))),
        }
    }
    Ok(rows)
}

/// Takes away the last restart file and has `run.sh` go on from the one before.
fn take_back(deck: &Deck, steps: u64) -> std::io::Result<()> {
    for name in [format!("restart.{steps}"), format!("restart.{steps}.xml.gz")] {
        match std::fs::remove_file(deck.folder.join(name)) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    std::fs::rename(deck.folder.join("run.sh"), deck.folder.join("whole.sh"))?;
    let script = "#!/bin/sh\n# Goes on from the newest restart file.\ncd \"$(dirname \"$0\")\" || exit 1\nexec sh ./whole.sh --resume \"$@\"\n";
    std::fs::write(deck.folder.join("run.sh"), script)
}

/// Solvers that take MPI ranks: two ranks against one, over the first steps of the case.
fn on_two_ranks(
    road: &mut Road,
    case: &Case,
    solvers: &[&'static dyn Solver],
) -> Result<Vec<Row>, StudyError> {
    let model = first_steps(road, case)?;
    let mut rows = Vec::new();
    for solver in solvers.iter().filter(|solver| solver.takes_ranks()) {
        let mut ends = Vec::new();
        let mut cpu = 0.0;
        for ranks in [1, 2] {
            let options = DeckOptions { ranks, ..DeckOptions::default() };
            let done = road
                .export(*solver, &model, &options)
                .and_then(|deck| Ok(solver.run(&model, &deck, &road.job)?));
            match done {
                Ok(run) => {
                    cpu += run.cost.cpu_seconds;
                    ends.extend(run.frames.into_iter().last());
                }
                Err(error) => rows.push(failed(format!("{}: {error}", solver.name()))),
            }
        }
        let [one, two] = ends.as_slice() else { continue };
        let far = apart(&model, one, two);
        let name = format!("{}, 2 ranks against 1", solver.name());
        rows.push(judged(case, solver.key(), name, far, f64::NAN, cpu));
    }
    Ok(rows)
}
