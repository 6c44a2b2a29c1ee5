//! The stage that runs a scene here and in outside solvers, and says how far they agree.

use super::build::Built;
use super::compared::Compared;
use super::lockstep::move_walls;
use super::paging;
use super::parameters::Start;
use super::road::{Packed, Road, RoadError};
use crate::dem;
use crate::model::{Model, Outcome, Run, Scheme};
use crate::num::Job;
use crate::report::compare::{Twin, compare};
use crate::solver::{self, Deck, DeckOptions, Solver};
use std::collections::BTreeSet;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

impl Road {
    /// Writes the deck of one solver into `decks/KEY/`.
    ///
    /// # Errors
    /// What the solver cannot express; a folder that cannot be written.
    pub fn export(
        &mut self,
        solver: &dyn Solver,
        model: &Model,
        options: &DeckOptions,
    ) -> Result<Deck, RoadError> {
        let stage = format!("export {}", solver.key());
        let inside = format!("decks/{}", solver.key());
        let mut running = self.store.begin(&stage, "")?;
        let deck = solver.write(model, &self.store.path(&inside), options)?;
        for file in &deck.files {
            self.store.prepare(&mut running, &format!("{inside}/{file}"))?;
        }
        running.count("bodies", model.bodies.len());
        running.count("spheres", model.spheres.len());
        self.close(running, &format!("wrote the {} deck", solver.name()))?;
        Ok(deck)
    }

    /// Runs the scene here and in `solvers`, compares, writes `compare.json` and the report.
    ///
    /// # Errors
    /// As [`Road::run`]. A solver that fails is an entry of `failures`, not an error.
    pub fn compare(&mut self, solvers: &[&'static dyn Solver]) -> Result<Compared, RoadError> {
        let (packed, built, run) = self.run(false)?;
        let model = self.start(&built.model, &run)?;
        let ours = if model == built.model { run.clone() } else { dem::run(&model, &self.job)? };
        let (able, unable) = solver::able(solvers, &model);
        let mut failures = Vec::new();
        let mut running = self.store.begin("compare", "")?;
        let mut others = Vec::new();
        let mut twins = Vec::new();
        for outcome in self.run_outside(&able, &model)? {
            match outcome {
                Ok((run, twin)) => {
                    twins.push(Twin { of: others.len(), ..twin });
                    others.push(run);
                }
                Err(message) => failures.push(message),
            }
        }
        let tolerance = &self.loaded.scene.compare.tolerance;
        let comparison = compare(&model, &ours, &others, &twins, tolerance);
        for name in ["compare.json", "compare.csv"] {
            self.store.prepare(&mut running, name)?;
        }
        comparison.write(self.store.root()).map_err(|error| RoadError::Work(error.to_string()))?;
        running.count("solvers", others.len());
        running.count("failures", failures.len());
        running.count("steps", model.plan.steps as usize);
        running.count("spheres", model.spheres.len());
        let names: Vec<&str> = others.iter().map(|run| run.solver.as_str()).collect();
        let names = if names.is_empty() { "no solver".to_owned() } else { names.join(" and ") };
        self.close(running, &format!("compared with {names}"))?;
        let mut missing: Vec<String> = solver::all()
            .into_iter()
            .filter(|solver| solver.find().is_none())
            .map(|solver| format!("{} {}", solver.name(), solver.absence()))
            .collect();
        missing.extend(failures.iter().chain(&unable).cloned());
        let compared = Compared { comparison, ours, others, failures, unable, missing };
        paging::write(self, &packed, &built, &run, Some(&compared))?;
        Ok(compared)
    }

    /// The model that the comparison starts from.
    fn start(&self, model: &Model, run: &Run) -> Result<Model, RoadError> {
        let parameters = &self.loaded.scene.compare;
        let mut model = model.clone();
        if parameters.start == Start::FinalWithSprings {
            let needs = model.needs();
            if needs.bonds || needs.servo_walls || model.plan.scheme == Scheme::PathAveraged {
                let message = "compare.start = \"final_with_springs\" does not do bonds, walls that \
                               seek a force, nor the scheme `path_averaged`, whose springs lag half a step";
                return Err(RoadError::Work(message.to_owned()));
            }
            model.springs = run.springs.clone();
        }
        if let (Start::Final | Start::FinalWithSprings, Some(last)) =
            (parameters.start, run.frames.last())
        {
            move_walls(&mut model, last.time);
            // All grains have come by the end.
            model.arrivals.clear();
            for (body, state) in model.bodies.iter_mut().zip(&last.bodies) {
                body.position = state.position;
                body.orientation = state.orientation;
                body.velocity = state.velocity;
                body.spin = state.spin;
            }
            // Bonds that broke stay broken; those that hold start without force again.
            let broken: BTreeSet<u32> = run.breaks.iter().flatten().map(|b| b.bond).collect();
            let mut number = 0..;
            model.bonds.retain(|_| number.next().is_none_or(|bond| !broken.contains(&bond)));
        }
        if let Some(steps) = parameters.steps {
            model.plan.steps = steps;
            model.plan.frame_every = (steps / u64::from(self.loaded.scene.output.frames)).max(1);
            model.plan.series_every = (steps / u64::from(self.loaded.scene.output.rows)).max(1);
        }
        Ok(model)
    }

    /// Runs each solver, and our DEM in that solver's scheme; as many at a time as the job has threads, solvers first,
    /// since they last longest.
    fn run_outside(
        &mut self,
        solvers: &[&'static dyn Solver],
        model: &Model,
    ) -> Result<Vec<Outside>, RoadError> {
        let mut decks = Vec::new();
        for solver in solvers {
            decks.push((*solver, self.export(*solver, model, &DeckOptions::default())?));
        }
        let alone = self.job.with_threads(1);
        let runs: Vec<OnceLock<Result<Run, String>>> =
            decks.iter().map(|_| OnceLock::new()).collect();
        let twins: Vec<OnceLock<Result<Twin, String>>> =
            decks.iter().map(|_| OnceLock::new()).collect();
        let next = AtomicUsize::new(0);
        let work = || {
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                // Each number comes once, so nothing is set twice.
                if let Some((solver, deck)) = decks.get(number) {
                    let _ = runs[number].set(outside(*solver, model, deck, &alone));
                } else if let Some((solver, _)) = decks.get(number - decks.len()) {
                    // Nothing is compared with a solver that has failed.
                    if !runs[number - decks.len()].get().is_some_and(Result::is_err) {
                        let twin = twin(*solver, model, &alone).map_err(named(*solver));
                        let _ = twins[number - decks.len()].set(twin);
                    }
                } else {
                    break;
                }
            }
        };
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..self.job.threads).map(|_| scope.spawn(work)).collect();
            // What a thread that ended early leaves undone is missed below.
            threads.into_iter().for_each(|thread| drop(thread.join()));
        });
        if self.job.is_cancelled() {
            return Err(RoadError::Cancelled);
        }
        fn done<T>(result: OnceLock<Result<T, String>>) -> Result<T, String> {
            result.into_inner().unwrap_or_else(|| Err("a solver's reader ended early".to_owned()))
        }
        let both = runs.into_iter().zip(twins);
        Ok(both.map(|(run, twin)| Ok((done(run)?, done(twin)?))).collect())
    }

    /// Writes the report of a run without comparison, `report/index.html`, from what [`Road::run`] gave.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn page(&mut self, packed: &Packed, built: &Built, run: &Run) -> Result<(), RoadError> {
        paging::write(self, packed, built, run, None)
    }
}

/// A solver's run with our own in its scheme, or what went wrong.
type Outside = Result<(Run, Twin), String>;

/// The message of an error, with the name of the solver that it is of.
fn named<E: std::fmt::Display>(solver: &dyn Solver) -> impl Fn(E) -> String {
    move |error| {
        let text = error.to_string();
        if text.starts_with(solver.name()) { text } else { format!("{}: {text}", solver.name()) }
    }
}

/// A solver's run to its end, or why there is none.
fn outside(solver: &dyn Solver, model: &Model, deck: &Deck, job: &Job) -> Result<Run, String> {
    let run = solver.run(model, deck, job).map_err(named(solver))?;
    match &run.outcome {
        Outcome::Failed { reason } => Err(named(solver)(reason)),
        _ => Ok(run),
    }
}

/// Our own DEM with the solver's own scheme: what the solver should give to round-off.
fn twin(solver: &dyn Solver, model: &Model, job: &Job) -> Result<Twin, dem::DemError> {
    let twin = solver.twin(model);
    let run = dem::run(&twin, job)?;
    Ok(Twin { of: 0, scheme: twin.plan.scheme.key().to_owned(), run })
}
