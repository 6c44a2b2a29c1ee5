//! Three bulk scenes in every code over seeds: how far is the mean of each quantity from that of
//! a reference ensemble, with its confidence interval, at which CPU time, and is it equivalent?
//!
//! Reference: `path_averaged` at many steps a contact. Every code and step runs the same seeds from
//! the same places, so differences from the reference are taken seed by seed: the scatter of
//! the starts drops out of them. Mean difference with its 95 % interval, and two one-sided tests
//! at 5 % against the margin of the quantity. CPU seconds are those of the whole process, start
//! included, a run.
//! What is measured is taken from places of spheres in frames, alike for all codes.
//! Cost: seeds × (1 + settings) runs a scene.

mod scenes;

use super::equivalence::{Difference, Verdict, deviation};
use super::{Effort, StudyError, go_on};
use crate::dem;
use crate::model::{Model, Outcome, Run, Scheme};
use crate::num::Job;
use crate::num::statistics::mean;
use crate::report::chart::{Axis, Chart, Series};
use crate::report::findings::{Cell, Findings, Sheet};
use crate::solver::{self, DeckOptions, Solver};
use scenes::{Bulk, Extent, SCENES};

/// What an effort computes.
struct Size {
    /// Steps a contact of each code.
    steps: &'static [f64],
    reference: f64,
    seeds: u64,
    extents: [Extent; 3],
}

impl Size {
    fn of(effort: Effort) -> Self {
        let extent = |counts, time| Extent { counts, time };
        match effort {
            Effort::Quick => Self {
                steps: &[20.0],
                reference: 40.0,
                seeds: 4,
                extents: [extent([4, 3, 8], 0.4), extent([10, 3, 5], 0.5), extent([4, 4, 6], 0.4)],
            },
            Effort::Full => Self {
                steps: &[10.0, 20.0, 40.0],
                reference: 100.0,
                seeds: 12,
                extents: [
                    extent([5, 4, 10], 0.45),
                    extent([11, 3, 6], 0.6),
                    extent([5, 5, 7], 0.42),
                ],
            },
        }
    }
}

/// A code that runs scenes.
#[derive(Clone, Copy)]
enum Code {
    Ours(Scheme),
    Theirs(&'static dyn Solver),
}

impl Code {
    fn name(self) -> &'static str {
        match self {
            Self::Ours(scheme) => scheme.key(),
            Self::Theirs(solver) => solver.name(),
        }
    }

    fn run(
        self,
        bulk: &Bulk,
        extent: Extent,
        seed: u64,
        per_contact: f64,
    ) -> Result<(Model, Run), StudyError> {
        let scheme = match self {
            Self::Ours(scheme) => scheme,
            Self::Theirs(_) => Scheme::Leapfrog,
        };
        let model = scenes::model(bulk, extent, seed, scheme, per_contact);
        let failed = |what: String| {
            StudyError::Work(format!("{} in {}, seed {seed}: {what}", bulk.key, self.name()))
        };
        let run = match self {
            Self::Ours(_) => dem::run(&model, &Job::quiet()).map_err(|e| failed(e.to_string()))?,
            Self::Theirs(solver) => outside(solver, &model).map_err(|e| failed(e.to_string()))?,
        };
        match &run.outcome {
            Outcome::Finished => Ok((model, run)),
            other => Err(failed(format!("ended early: {other:?}"))),
        }
    }
}

/// Runs a deck in a temporary folder.
fn outside(solver: &dyn Solver, model: &Model) -> Result<Run, solver::SolverError> {
    let name = format!("riprap-ensembles-{}-{}", std::process::id(), solver.key());
    let folder = std::env::temp_dir().join(name);
    let run = solver
        .write(model, &folder, &DeckOptions::default())
        .and_then(|deck| solver.run(model, &deck, &Job::quiet()));
    // Nothing of the deck is needed any more; what cannot be removed does no harm.
    let _ = std::fs::remove_dir_all(&folder);
    run
}

/// Values of the quantities over seeds, and the mean CPU time of a run.
struct Sample {
    values: Vec<Vec<f64>>,
    cpu: f64,
}

/// One code at one step in one scene.
struct Found {
    code: &'static str,
    per_contact: f64,
    cpu: f64,
    differences: Vec<Difference>,
}

/// See [`super::STUDIES`].
pub fn study(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    let size = Size::of(effort);
    let mut remarks = Vec::new();
    let codes = codes(&mut remarks);
    let mut work = Work { job, size: &size, done: 0, total: 0 };
    work.total = SCENES.len() as u64 * size.seeds * (1 + codes.len() * size.steps.len()) as u64;
    let (mut rows, mut charts, mut all) = (Vec::new(), Vec::new(), Vec::new());
    for (bulk, extent) in SCENES.iter().zip(size.extents) {
        // What other scenes have found is kept where one cannot be finished.
        let found = match work.scene(bulk, extent, &codes, &mut rows, &mut remarks) {
            Ok(found) => found,
            Err(StudyError::Work(what)) => {
                remarks.push(format!("{}: not finished: {what}", bulk.key));
                all.push(Vec::new());
                continue;
            }
            Err(stopped) => return Err(stopped),
        };
        remarks.extend(summary(bulk, &found));
        charts.push((format!("ensembles-{}", bulk.key), scene_chart(bulk, &found)));
        all.push(found);
    }
    charts.insert(0, ("ensembles".into(), bounds_chart(&codes, &size, &all)));
    let spheres: Vec<String> = SCENES
        .iter()
        .zip(size.extents)
        .map(|(bulk, extent)| {
            let model = scenes::model(bulk, extent, 1, Scheme::Leapfrog, size.steps[0]);
            format!("{} {}", bulk.key, model.bodies.len())
        })
        .collect();
    Ok(Findings {
        title: "Bulk scenes over seeds: statistical error against run time".into(),
        question: format!(
            "Spheres of 5 mm ± 10 %, kn 10 kN/m, kt/kn 2/7, e 0.5, mu 0.5 ({}): how far is the mean \
             over {} seeds of each code and step from that of path_averaged at {} steps a contact, what \
             does a run cost, and does the difference lie within the margin?",
            spheres.join(", "),
            size.seeds,
            size.reference
        ),
        remarks,
        tables: vec![sheet(rows)],
        charts,
        pictures: Vec::new(),
    })
}

/// Our schemes, and the outside solvers that are installed.
fn codes(remarks: &mut Vec<String>) -> Vec<Code> {
    let mut codes = vec![Code::Ours(Scheme::Leapfrog), Code::Ours(Scheme::PathAveraged)];
    for solver in solver::all() {
        match solver.find() {
            Some(_) => codes.push(Code::Theirs(solver)),
            None => remarks.push(format!("{} is not installed: left out.", solver.name())),
        }
    }
    codes
}

/// What is being worked at.
struct Work<'a> {
    job: &'a Job,
    size: &'a Size,
    done: u64,
    total: u64,
}

impl Work<'_> {
    fn scene(
        &mut self,
        bulk: &Bulk,
        extent: Extent,
        codes: &[Code],
        rows: &mut Vec<Vec<Cell>>,
        remarks: &mut Vec<String>,
    ) -> Result<Vec<Found>, StudyError> {
        let ours = Code::Ours(Scheme::PathAveraged);
        let reference = self.sample(bulk, extent, ours, self.size.reference)?;
        rows.extend(reference_rows(bulk, self.size.reference, &reference));
        let mut all = Vec::new();
        for &code in codes {
            if let Some(why) = refusal(code, bulk, extent) {
                remarks.push(format!("{} leaves out the {}: {why}.", code.name(), bulk.key));
                self.done += self.size.steps.len() as u64 * self.size.seeds;
                continue;
            }
            for &per_contact in self.size.steps {
                let sample = self.sample(bulk, extent, code, per_contact)?;
                let differences = sample
                    .values
                    .iter()
                    .zip(&reference.values)
                    .map(|(values, reference)| Difference::of_pairs(values, reference))
                    .collect();
                let found = Found { code: code.name(), per_contact, cpu: sample.cpu, differences };
                rows.extend(found_rows(bulk, &found, &sample));
                all.push(found);
            }
        }
        Ok(all)
    }

    fn sample(
        &mut self,
        bulk: &Bulk,
        extent: Extent,
        code: Code,
        per_contact: f64,
    ) -> Result<Sample, StudyError> {
        let mut values = vec![Vec::new(); bulk.quantities.len()];
        let mut costs = Vec::new();
        for seed in 1..=self.size.seeds {
            go_on(self.job)?;
            let (model, run) = code.run(bulk, extent, seed, per_contact)?;
            for ((quantity, list), value) in
                bulk.quantities.iter().zip(&mut values).zip((bulk.measure)(&model, &run))
            {
                if !value.is_finite() {
                    let (key, name) = (bulk.key, quantity.name);
                    let what = format!("{key} in {}, seed {seed}: no {name}", code.name());
                    return Err(StudyError::Work(what));
                }
                list.push(value);
            }
            costs.push(run.cost.cpu_seconds);
            self.done += 1;
            self.job.report("runs", self.done, self.total);
        }
        Ok(Sample { values, cpu: mean(&costs).unwrap_or(f64::NAN) })
    }
}

/// Why a solver takes no deck of a scene.
fn refusal(code: Code, bulk: &Bulk, extent: Extent) -> Option<String> {
    let Code::Theirs(solver) = code else { return None };
    let model = scenes::model(bulk, extent, 1, Scheme::Leapfrog, 20.0);
    solver.refusal(&model).map(|limit| limit.what)
}

fn reference_rows(bulk: &Bulk, per_contact: f64, sample: &Sample) -> Vec<Vec<Cell>> {
    let rows = bulk.quantities.iter().zip(&sample.values).map(|(quantity, values)| {
        let mut row = named(bulk, quantity, "reference (path_averaged)", per_contact);
        row.push(values.len().to_string().into());
        row.push(mean(values).unwrap_or(f64::NAN).into());
        row.push(deviation(values).into());
        row.extend([f64::NAN; 2].map(Cell::from));
        row.push(quantity.margin.into());
        row.push("".into());
        row.push(sample.cpu.into());
        row
    });
    rows.collect()
}

fn found_rows(bulk: &Bulk, found: &Found, sample: &Sample) -> Vec<Vec<Cell>> {
    let all = bulk.quantities.iter().zip(&sample.values).zip(&found.differences);
    all.map(|((quantity, values), difference)| {
        let mut row = named(bulk, quantity, found.code, found.per_contact);
        row.push(values.len().to_string().into());
        row.push(mean(values).unwrap_or(f64::NAN).into());
        row.push(deviation(values).into());
        row.push(difference.middle.into());
        row.push(difference.half_95.into());
        row.push(quantity.margin.into());
        row.push(difference.verdict(quantity.margin).text().into());
        row.push(found.cpu.into());
        row
    })
    .collect()
}

fn named(bulk: &Bulk, quantity: &scenes::Quantity, code: &str, per_contact: f64) -> Vec<Cell> {
    let name = match quantity.unit {
        "" => quantity.name.to_owned(),
        unit => format!("{} [{unit}]", quantity.name),
    };
    vec![bulk.key.into(), name.into(), code.into(), per_contact.into()]
}

fn sheet(rows: Vec<Vec<Cell>>) -> Sheet {
    Sheet {
        key: "ensembles".into(),
        title: "Means over seeds and their differences from the reference".into(),
        caption: "Mean difference from the reference, seed by seed, with the half width of its 95 % \
                  confidence interval. Equivalent: the 90 % interval lies within the margin (two one-sided \
                  tests at 5 %); different: it lies outside; not shown: neither. CPU time of a \
                  run, start of the process included."
            .into(),
        columns: [
            "scene",
            "quantity",
            "code",
            "steps a contact",
            "seeds",
            "mean",
            "standard deviation",
            "difference",
            "half of 95 %",
            "margin",
            "verdict",
            "CPU a run [s]",
        ]
        .map(String::from)
        .to_vec(),
        rows,
    }
}

/// What the verdicts of a scene say in one sentence.
fn summary(bulk: &Bulk, found: &[Found]) -> Option<String> {
    let verdicts = |found: &Found| -> Vec<Verdict> {
        let both = found.differences.iter().zip(bulk.quantities);
        both.map(|(difference, quantity)| difference.verdict(quantity.margin)).collect()
    };
    let equal: Vec<&Found> = found
        .iter()
        .filter(|found| verdicts(found).iter().all(|v| *v == Verdict::Equivalent))
        .collect();
    let name = |found: &Found| format!("{} at {}", found.code, found.per_contact);
    let different: Vec<String> = found
        .iter()
        .filter(|found| verdicts(found).contains(&Verdict::Different))
        .map(name)
        .collect();
    let mut text = format!(
        "{}: {} of {} settings are equivalent to the reference in every quantity",
        bulk.key,
        equal.len(),
        found.len()
    );
    if let Some(best) = equal.into_iter().min_by(|a, b| a.cpu.total_cmp(&b.cpu)) {
        text += &format!("; the cheapest is {} steps a contact, {:.2} s CPU", name(best), best.cpu);
    }
    text += &match different.is_empty() {
        true => "; none is shown to differ.".to_owned(),
        false => format!("; shown to differ: {}.", different.join(", ")),
    };
    Some(text)
}

/// The first quantity of a scene with its 95 % interval over CPU time, all codes.
fn scene_chart(bulk: &Bulk, found: &[Found]) -> Chart {
    let quantity = &bulk.quantities[0];
    let mut names: Vec<&str> = found.iter().map(|found| found.code).collect();
    names.dedup();
    let series = names.into_iter().map(|code| {
        let own = found.iter().filter(|found| found.code == code);
        let points = own.map(|found| {
            let Difference { middle, half_95, .. } = found.differences[0];
            (found.cpu, middle, half_95)
        });
        Series::intervals(code, points)
    });
    Chart {
        title: format!("{}: {} minus reference", bulk.what, quantity.name),
        caption: format!(
            "Mean difference over seeds with its 95 % interval; margin of equivalence ± {}. \
             One point a step; steps a contact rise from left to right.",
            format!("{} {}", quantity.margin, quantity.unit).trim_end()
        ),
        x: Axis::log("CPU time of a run, s", ""),
        y: Axis::linear(&unit(quantity), ""),
        series: series.collect(),
        mark: Some((quantity.margin, format!("margin {}", quantity.margin))),
    }
}

fn unit(quantity: &scenes::Quantity) -> String {
    match quantity.unit {
        "" => "difference".to_owned(),
        unit => format!("difference, {unit}"),
    }
}

/// Worst error over its margin of all quantities and scenes that a code runs, with the largest one
/// that the 95 % intervals allow, over the CPU time of its runs.
fn bounds_chart(codes: &[Code], size: &Size, all: &[Vec<Found>]) -> Chart {
    let series = codes.iter().map(|code| {
        let points = size.steps.iter().filter_map(|&per_contact| {
            let (mut error, mut bound, mut costs) = (0.0_f64, 0.0_f64, Vec::new());
            for (bulk, found) in SCENES.iter().zip(all) {
                let own = |f: &&Found| f.code == code.name() && f.per_contact == per_contact;
                let Some(found) = found.iter().find(own) else { continue };
                costs.push(found.cpu);
                for (difference, quantity) in found.differences.iter().zip(bulk.quantities) {
                    error = error.max(difference.middle.abs() / quantity.margin);
                    bound = bound.max(difference.bound() / quantity.margin);
                }
            }
            Some((mean(&costs)?, error, bound))
        });
        Series::up_to(code.name(), points)
    });
    Chart {
        title: "Error of the mean against CPU time, all codes, all scenes".into(),
        caption:
            "Worst difference from the reference ensemble over its margin, of all quantities of \
                  the scenes that a code runs; bars reach to the largest one that the 95 % \
                  intervals allow. CPU time: mean of a run over the scenes, start included."
                .into(),
        x: Axis::log("CPU time of a run, s", ""),
        y: Axis::log("error over the margin", ""),
        series: series.collect(),
        mark: Some((1.0, "margin".into())),
    }
}
