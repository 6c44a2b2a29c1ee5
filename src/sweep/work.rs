//! Does the cases of a sweep, some at a time, and keeps what is finished.
//!
//! `cases/0001/scene.toml` is the scene of a case, `cases/0001/scene.out` its
//! results, as if it had been run by hand; `cases/0001/case.json` says that it
//! is finished and how. Every file is complete or absent, so a sweep that was
//! killed at any instant goes on where it was.

use super::cases::Case;
use super::{Stage, Sweep, SweepError};
use crate::format::{FormatError, atomic};
use crate::model::{Outcome, Run};
use crate::num::Job;
use crate::num::random::fnv1a;
use crate::report::compare::measure;
use crate::scene::road::{Road, RoadError};
use crate::scene::store::hex;
use crate::solver::{self, DeckOptions, Solver};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// How a case ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// As it should.
    Done,
    /// A solver is outside its tolerance; outputs are there.
    Outside,
    /// It failed or was stopped by the guard.
    Failed,
}

/// `case.json`: what is known of a finished case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Its number, as the name of its folder.
    pub case: String,
    /// How it ended.
    pub status: Status,
    /// Why, if not as it should.
    pub message: String,
    /// What it set.
    pub values: BTreeMap<String, toml::Value>,
    /// What came out: name, unit included, and number.
    pub outputs: BTreeMap<String, f64>,
    /// Wall-clock seconds.
    pub wall_seconds: f64,
    /// Hash of version, stage, solvers and scene file.
    pub key: String,
}

/// A sweep on its way.
pub struct Work<'a> {
    /// The sweep.
    pub sweep: &'a Sweep,
    /// Its cases.
    pub cases: &'a [Case],
    /// Output folder.
    pub root: &'a Path,
    /// Cases at a time.
    pub at_once: usize,
    /// Progress, threads, cancelling.
    pub job: &'a Job,
}

impl Work<'_> {
    /// Folder of a case.
    pub fn folder(&self, case: &Case) -> PathBuf {
        self.root.join("cases").join(&case.name)
    }

    /// What is known of a case that was finished earlier, with the same scene and stage.
    fn earlier(&self, case: &Case) -> Option<Record> {
        let bytes = std::fs::read(self.folder(case).join("case.json")).ok()?;
        let record: Record = serde_json::from_slice(&bytes).ok()?;
        (record.key == self.key(case)).then_some(record)
    }

    fn key(&self, case: &Case) -> String {
        let Sweep { stage, solvers, .. } = self.sweep;
        let text = format!("{} {} {solvers:?}\n{}", crate::VERSION, stage.verb(), case.text);
        hex(fnv1a(text.as_bytes()))
    }

    /// Does all cases; with `resume` those that are finished are taken as they are,
    /// and those that failed are tried again. Records come in the order of the cases.
    ///
    /// # Errors
    /// A folder that holds cases already without `resume`; a file that cannot be
    /// written; the user's wish to stop.
    pub fn all(&self, resume: bool) -> Result<Vec<Record>, SweepError> {
        if !resume && self.root.join("cases").exists() {
            return Err(SweepError::Folder(format!(
                "{} holds cases already; go on with --resume, or choose another folder with -o",
                self.root.display()
            )));
        }
        let records: Mutex<Vec<Option<Record>>> = Mutex::new(vec![None; self.cases.len()]);
        let (next, finished) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let failure: Mutex<Option<SweepError>> = Mutex::new(None);
        let threads = (self.job.threads / self.at_once).max(1);
        let worker = || {
            while !self.job.is_cancelled() && lock(&failure).is_none() {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(case) = self.cases.get(index) else { break };
                match self.one(case, resume, &self.job.silent(threads)) {
                    Ok(None) => break,
                    Ok(Some(record)) => lock(&records)[index] = Some(record),
                    Err(error) => {
                        lock(&failure).get_or_insert(error);
                    }
                }
                let done = finished.fetch_add(1, Ordering::Relaxed) + 1;
                self.job.report("cases", done as u64, self.cases.len() as u64);
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..self.at_once {
                scope.spawn(worker);
            }
        });
        if let Some(error) = lock(&failure).take() {
            return Err(error);
        }
        let records: Vec<Record> = lock(&records).iter_mut().filter_map(Option::take).collect();
        if records.len() < self.cases.len() {
            let (done, total) = (records.len(), self.cases.len());
            return Err(SweepError::Cancelled { done, total });
        }
        Ok(records)
    }

    /// Does one case; `None` if the user asked to stop on the way.
    fn one(&self, case: &Case, resume: bool, job: &Job) -> Result<Option<Record>, SweepError> {
        if let Some(record) = self.earlier(case).filter(|r| resume && r.status != Status::Failed) {
            return Ok(Some(record));
        }
        let folder = self.folder(case);
        std::fs::create_dir_all(&folder)
            .map_err(|source| FormatError::io(&folder, "write", source))?;
        let scene = folder.join("scene.toml");
        atomic::write(&scene, |out| out.write_all(case.text.as_bytes()))?;
        let begun = Instant::now();
        let (status, message, outputs) = match self.stage(&scene, job) {
            Ok(Ended { problem: None, outputs }) => (Status::Done, String::new(), outputs),
            Ok(Ended { problem: Some((status, message)), outputs }) => (status, message, outputs),
            Err(RoadError::Cancelled | RoadError::Paused { .. }) => return Ok(None),
            Err(error) => (Status::Failed, error.to_string(), BTreeMap::new()),
        };
        if job.is_cancelled() {
            return Ok(None);
        }
        let record = Record {
            case: case.name.clone(),
            status,
            message,
            values: case.values.iter().cloned().collect(),
            outputs,
            wall_seconds: begun.elapsed().as_secs_f64(),
            key: self.key(case),
        };
        atomic::write(&folder.join("case.json"), |out| {
            serde_json::to_writer_pretty(&mut *out, &record)?;
            writeln!(out)
        })?;
        Ok(Some(record))
    }

    fn stage(&self, scene: &Path, job: &Job) -> Result<Ended, RoadError> {
        let mut road = Road::open(scene, None, job.clone())?;
        let mut ended = Ended::default();
        match self.sweep.stage {
            Stage::Generate => {
                let shapes = road.solids()?;
                let volumes: Vec<f64> =
                    shapes.described.iter().flatten().map(|known| known.measures.volume).collect();
                ended.put("Shapes", volumes.len() as f64);
                ended.put("Volume of shapes [m³]", volumes.iter().sum());
            }
            Stage::Reproduce => {
                let grains = road.grains()?;
                let spheres = grains.distinct.iter().map(|grain| grain.clump.balls.len());
                ended.put("Spheres", spheres.sum::<usize>() as f64);
            }
            Stage::Pack => {
                let packed = road.packed()?;
                ended.packing(&packed.packing);
            }
            Stage::Export => {
                let (packed, built) = road.built()?;
                ended.packing(&packed.packing);
                ended.put("Step [s]", built.model.plan.step);
                for solver in self.solvers() {
                    road.export(solver, &built.model, &DeckOptions::default())?;
                }
            }
            Stage::Run => {
                // A case that was killed goes on from its last checkpoint.
                let (packed, built, run) = road.run(true)?;
                ended.packing(&packed.packing);
                ended.put("Step [s]", built.model.plan.step);
                ended.run(&run);
                // Means over the last quarter of the run, as comparisons have them.
                for mean in measure(&built.model, &run).iter().flat_map(|end| &end.means) {
                    let quantity = mean.quantity;
                    ended.put(&labelled(quantity.name(), quantity.unit()), mean.value);
                }
            }
            Stage::Compare => {
                let compared = road.compare(&self.solvers())?;
                ended.run(&compared.ours);
                for (run, other) in compared.others.iter().zip(&compared.comparison.others) {
                    ended.put(&format!("CPU of {} [s]", run.solver), run.cost.cpu_seconds);
                    if !other.passed {
                        let message = format!("{}: {}", run.solver, other.reasons.join("; "));
                        ended.problem.get_or_insert((Status::Outside, message));
                    }
                }
                // A solver that cannot express the scene matters only where it was asked for.
                let asked = !self.sweep.solvers.is_empty();
                let unable = compared.unable.iter().filter(|_| asked);
                if let Some(failure) = compared.failures.iter().chain(unable).next() {
                    ended.problem = Some((Status::Failed, failure.clone()));
                }
            }
        }
        Ok(ended)
    }

    fn solvers(&self) -> Vec<&'static dyn Solver> {
        let wanted = &self.sweep.solvers;
        solver::all()
            .into_iter()
            .filter(|solver| wanted.is_empty() || wanted.iter().any(|key| key == solver.key()))
            .collect()
    }
}

/// What came out of a case.
#[derive(Default)]
struct Ended {
    outputs: BTreeMap<String, f64>,
    problem: Option<(Status, String)>,
}

impl Ended {
    fn put(&mut self, name: &str, value: f64) {
        if value.is_finite() {
            self.outputs.insert(name.to_owned(), value);
        }
    }

    fn packing(&mut self, packing: &crate::pack::Packing) {
        self.put("Placed", packing.placements.len() as f64);
        self.put("Dropped", packing.dropped.len() as f64);
        self.put("Packed porosity", packing.measures.porosity);
        self.put("Packed coordination", packing.measures.coordination);
    }

    fn run(&mut self, run: &Run) {
        self.put("CPU [s]", run.cost.cpu_seconds);
        if let Some(last) = run.series.last() {
            if let Some(error) = last.energy_error {
                self.put("Energy error [J]", error);
            }
            self.put("Worst overlap [R]", last.worst_overlap);
            self.put("Contacts", last.contacts as f64);
        }
        match &run.outcome {
            Outcome::Stopped { reason, .. } | Outcome::Failed { reason } => {
                self.problem = Some((Status::Failed, reason.clone()));
            }
            Outcome::Finished | Outcome::Cancelled { .. } => {}
        }
    }
}

fn labelled(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// A lock that a panic elsewhere has not closed for good: all data behind it stay whole.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
