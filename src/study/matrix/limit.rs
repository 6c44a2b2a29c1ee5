//! Single contacts as the step goes to zero: every solver against riprap's `path_averaged`.
//!
//! u(h) are the velocities of all spheres after the impact with step h, and r those of
//! `path_averaged` at an eighth of the smallest step. Shown is max |u(h) − r| / max |r| for
//! four steps, each half of the one before, and the order p of the solver's own convergence
//! from its three smallest steps, 2^p = |u(4h) − u(2h)| / |u(2h) − u(h)|.

use super::cases::Case;
use super::{StudyError, work};
use crate::dem;
use crate::model::{Model, Run, Scheme};
use crate::num::{Job, Vec3};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::findings::{Cell, Sheet};
use crate::scene::road::Road;
use crate::solver::{DeckOptions, Solver};

/// Steps, of the step of the scene.
const STEPS: [f64; 4] = [4.0, 2.0, 1.0, 0.5];

/// Rows of the table and the chart of one case.
pub fn small_steps(
    road: &mut Road,
    case: &Case,
    solvers: &[&'static dyn Solver],
    job: &Job,
) -> Result<(Vec<Vec<Cell>>, Chart), StudyError> {
    let (_, built) = road.built().map_err(work)?;
    let model = built.model;
    let fine = STEPS[STEPS.len() - 1] / 8.0;
    let reference = velocities(&own(&model, fine, job)?);
    let scale = reference.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let mut rows = Vec::new();
    let mut series = Vec::new();
    let ours: Result<Vec<(Vec<Vec3>, f64)>, StudyError> = STEPS
        .iter()
        .map(|part| {
            let run = own(&model, *part, job)?;
            Ok((velocities(&run), run.cost.cpu_seconds))
        })
        .collect();
    let mut add = |name: &str, found: Vec<(Vec<Vec3>, f64)>| {
        let errors: Vec<f64> =
            found.iter().map(|(ends, _)| largest(ends, &reference) / scale).collect();
        let mut row: Vec<Cell> = vec![case.key.as_str().into(), name.into()];
        row.extend(errors.iter().map(|error| Cell::from(*error)));
        let moves: Vec<f64> =
            found.windows(2).map(|pair| largest(&pair[0].0, &pair[1].0)).collect();
        let order = match moves.as_slice() {
            [.., before, last] if *last > 1e-12 * scale => (before / last).log2(),
            _ => f64::NAN,
        };
        row.push(order.into());
        row.push(found.iter().map(|(_, cpu)| cpu).sum::<f64>().into());
        rows.push(row);
        let steps = STEPS.iter().map(|part| part * model.plan.step);
        series.push(Series { name: name.into(), points: steps.zip(errors).collect(), dots: true });
    };
    add("riprap path_averaged", ours?);
    for solver in solvers.iter().filter(|solver| solver.refusal(&model).is_none()) {
        let mut found = Vec::new();
        for part in STEPS {
            let stepped = with_step(&model, part);
            let run = road
                .export(*solver, &stepped, &DeckOptions::default())
                .and_then(|deck| Ok(solver.run(&stepped, &deck, &road.job)?))
                .map_err(work)?;
            found.push((velocities(&run), run.cost.cpu_seconds));
        }
        add(solver.name(), found);
    }
    let chart = Chart {
        title: format!("{}: difference from riprap's limit over the step", case.what),
        caption: "Velocities after the impact; flat ends are differences of the contact laws."
            .into(),
        x: Axis::log("step", "s"),
        y: Axis::log("difference of velocities", ""),
        series,
        mark: None,
    };
    Ok((rows, chart))
}

/// The rows of all cases as a table.
pub fn sheet(rows: Vec<Vec<Cell>>) -> Sheet {
    let columns = ["case", "solver", "4 us", "2 us", "1 us", "0.5 us", "order", "CPU [s]"];
    Sheet {
        key: "limits".into(),
        title: "Same limit as the step goes to zero?".into(),
        caption: "Largest difference of the velocities after the impact from riprap's \
                  path_averaged at an eighth of the smallest step, over the largest \
                  velocity. The order is that of the solver's own convergence, from its \
                  last three steps; what is left is the difference of the contact laws."
            .into(),
        columns: columns.map(String::from).to_vec(),
        rows,
    }
}

/// The model over the same time with another step.
fn with_step(model: &Model, part: f64) -> Model {
    let mut model = model.clone();
    model.plan.step *= part;
    model.plan.steps = (model.plan.steps as f64 / part).round() as u64;
    model.plan.frame_every = model.plan.steps;
    model.plan.series_every = model.plan.steps;
    model
}

fn own(model: &Model, part: f64, job: &Job) -> Result<Run, StudyError> {
    let mut model = with_step(model, part);
    (model.plan.scheme, model.plan.law) = (Scheme::PathAveraged, Scheme::PathAveraged.law());
    dem::run(&model, job).map_err(|error| StudyError::Work(error.to_string()))
}

fn velocities(run: &Run) -> Vec<Vec3> {
    run.frames.last().map_or_else(Vec::new, |frame| frame.velocities.clone())
}

/// Largest difference; infinite if there is nothing to compare.
fn largest(a: &[Vec3], b: &[Vec3]) -> f64 {
    if a.len() != b.len() || a.is_empty() {
        return f64::INFINITY;
    }
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}
