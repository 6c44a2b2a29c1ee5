//! Runs of several solvers on one model, set against each other.
//!
//! Two questions, kept apart because contact dynamics of many bodies is chaotic
//! (a difference of one rounding grows e-fold within some ten contact durations):
//! 1. *Is it the same computation?* Each solver is compared, sphere by sphere,
//!    with its twin: our DEM in that solver's own scheme and law. In the window
//!    that opens with the first contact and lasts
//!    [`Tolerances::contact_durations`], they must agree to
//!    [`Tolerances::trajectory`]. After it, parting is reported, not judged.
//! 2. *Is it the same bed?* Statistics ([`statistics`]) over the last part of the
//!    run ([`span`]), computed from sphere positions and velocities in the same way
//!    for every run, must agree with ours to their tolerances, or to what chance
//!    does to runs that have parted ([`rows`]).
//!
//! A solver passes when it finished and both answers are yes. When no frame lies
//! in the window, the first question counts as not answered and says so.
//! Cost O(frames × spheres).

pub mod region;
pub mod rows;
pub mod span;
pub mod statistics;
#[cfg(test)]
mod tests;
pub mod tolerances;
pub mod trajectory;
mod write;

pub use rows::Realisations;
pub use span::Statistics;
pub use statistics::Quantity;
pub use tolerances::Tolerances;
pub use trajectory::{Divergence, Trajectory};

use super::number::{significant, with_unit};
use crate::model::{Cost, Frame, Model, Outcome, Run};
use region::Region;
use serde::{Deserialize, Serialize};
use span::Span;

/// Our own DEM in the scheme and law of another solver.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Twin {
    /// Index of that solver's run in the list given to [`compare`].
    pub of: usize,
    /// Key of the scheme, for people: "liggghts", "yade".
    pub scheme: String,
    /// The run.
    pub run: Run,
}

/// How far the solvers agree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Title of the scene.
    pub title: String,
    /// What was asked for.
    pub tolerances: Tolerances,
    /// Unit of trajectory differences: radius of the smallest sphere, m.
    pub smallest_radius: f64,
    /// Shortest duration of an undamped contact, s: π √(m/kn) over all pairs' least
    /// reduced mass and largest stiffness.
    pub contact_duration: f64,
    /// Time of the first contact in our run, s.
    pub first_contact: f64,
    /// End of the window in which twins must agree, s.
    pub window_end: f64,
    /// What kinetic energies are compared with, J: the largest of our run's kinetic
    /// energies, the potential energy it released, and the work of moving walls.
    pub energy_scale: f64,
    /// What chance does to this bed.
    pub realisations: Realisations,
    /// Our run.
    pub ours: Side,
    /// Each other solver.
    pub others: Vec<Opponent>,
}

/// One run by itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Side {
    /// Who ran it.
    pub solver: String,
    /// How it ended.
    pub outcome: Outcome,
    /// The last part of the run; `None` if there is none that can be measured.
    pub statistics: Option<Statistics>,
    /// What it cost.
    pub cost: Cost,
    /// What this solver could not express or did differently.
    pub notes: Vec<String>,
}

/// Another solver against us.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Opponent {
    /// The run by itself.
    pub side: Side,
    /// Passed or not.
    pub passed: bool,
    /// Why, one sentence each, for people.
    pub reasons: Vec<String>,
    /// Sphere by sphere against our run in our own scheme; reported, not judged.
    pub against_ours: Trajectory,
    /// Sphere by sphere against the twin.
    pub twin: Option<TwinCheck>,
    /// The last part of the run against ours.
    pub rows: Vec<Row>,
}

/// A solver against our DEM in its own scheme.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TwinCheck {
    /// Key of the scheme.
    pub scheme: String,
    /// Sphere by sphere.
    pub trajectory: Trajectory,
    /// Largest difference within the window, smallest radii; `None`: no frame in the window.
    pub worst_in_window: Option<f64>,
    /// Frames within the window, the one at time 0 not counted.
    pub frames_in_window: usize,
    /// Within tolerance throughout the window; `None`: not answered.
    pub agrees: Option<bool>,
}

/// One quantity over the last part of the run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Which.
    pub quantity: Quantity,
    /// In our run.
    pub ours: f64,
    /// In the other solver's run.
    pub theirs: f64,
    /// (theirs − ours) / scale.
    pub relative: f64,
    /// What differences are divided by, in the unit of the quantity.
    pub scale: f64,
    /// Largest |relative| that passes without regard to chance.
    pub tolerance: f64,
    /// Largest |relative| that passes: the tolerance, or `chance` where that is larger, but
    /// no more than [`rows::MOST_CHANCE`] tolerances.
    pub allowed: f64,
    /// What chance makes of |relative| between two runs of the same bed; 0 where
    /// trajectories still agree at the end.
    pub chance: f64,
    /// |relative| ≤ allowed.
    pub passed: bool,
}

impl Comparison {
    /// True if our run finished, there is at least one other solver, and all of them pass.
    pub fn passed(&self) -> bool {
        self.ours.outcome == Outcome::Finished
            && !self.others.is_empty()
            && self.others.iter().all(|other| other.passed)
    }

    /// The outcome in one line for people.
    pub fn verdict(&self) -> String {
        let failed: Vec<&str> =
            self.others.iter().filter(|o| !o.passed).map(|o| o.side.solver.as_str()).collect();
        if self.others.is_empty() {
            "Nothing was compared: no other solver ran.".into()
        } else if self.ours.outcome != Outcome::Finished {
            "Our own run did not finish; there is nothing sound to compare with.".into()
        } else if failed.is_empty() {
            match self.others.len() {
                1 => "The other solver agrees within tolerance.".into(),
                2 => "Both other solvers agree within tolerance.".into(),
                number => format!("All {number} other solvers agree within tolerance."),
            }
        } else {
            format!("Outside tolerance: {}.", failed.join(", "))
        }
    }
}

/// Sets `others` (solvers' runs of `model`) against `ours`, and each against its twin.
///
/// Runs that failed, hold no frames, frames of another number of spheres or
/// numbers that are not finite do not pass; nothing of them reaches the result.
pub fn compare(
    model: &Model,
    ours: &Run,
    others: &[Run],
    twins: &[Twin],
    tolerances: &Tolerances,
) -> Comparison {
    let smallest = model.smallest_radius();
    let smallest_radius = if smallest.is_finite() { smallest } else { 1.0 };
    let contact_duration = contact_duration(model);
    let first_contact = first_contact(model, ours);
    let window_end = first_contact + tolerances.contact_durations * contact_duration;
    let last = usable(model, ours).and_then(|frames| frames.last());
    let region = Region::of(model, last);
    let measure = |run: &Run| Span::of(model, usable(model, run)?, &region);
    let our_span = measure(ours);
    let mut comparison = Comparison {
        title: model.title.clone(),
        tolerances: tolerances.clone(),
        smallest_radius,
        contact_duration,
        first_contact,
        window_end,
        energy_scale: energy_scale(model, ours),
        realisations: Realisations::of(model, ours, twins, measure, smallest_radius),
        ours: side(ours, our_span.as_ref()),
        others: Vec::new(),
    };
    for (index, other) in others.iter().enumerate() {
        let twin = twins.iter().find(|twin| twin.of == index);
        let their_span = measure(other);
        let spans = [our_span.as_ref(), their_span.as_ref()];
        let opponent = oppose(model, ours, other, twin, spans, &comparison);
        comparison.others.push(opponent);
    }
    comparison
}

/// The last part of one run by itself; `None` if there is nothing that can be measured.
pub fn measure(model: &Model, run: &Run) -> Option<Statistics> {
    let frames = usable(model, run)?;
    let region = Region::of(model, frames.last());
    Some(Span::of(model, frames, &region)?.statistics)
}

/// The frames of a run, if all of them fit the model and are finite.
fn usable<'a>(model: &Model, run: &'a Run) -> Option<&'a [Frame]> {
    let spheres = model.spheres.len();
    let sound = |frame: &Frame| {
        let vectors = frame.centres.iter().chain(&frame.velocities);
        frame.centres.len() == spheres
            && frame.velocities.len() == spheres
            && frame.bodies.len() == model.bodies.len()
            && frame.time.is_finite()
            && vectors.flat_map(|v| v.iter()).all(|v| v.is_finite())
            && frame.kinetic_energy(model).is_finite()
    };
    (!run.frames.is_empty() && run.frames.iter().all(sound)).then_some(run.frames.as_slice())
}

fn side(run: &Run, span: Option<&Span>) -> Side {
    Side {
        solver: run.solver.clone(),
        outcome: run.outcome.clone(),
        statistics: span.map(|span| span.statistics.clone()),
        cost: run.cost,
        notes: run.notes.clone(),
    }
}

fn oppose(
    model: &Model,
    ours: &Run,
    other: &Run,
    twin: Option<&Twin>,
    spans: [Option<&Span>; 2],
    so_far: &Comparison,
) -> Opponent {
    let tolerances = &so_far.tolerances;
    let pair = |a: &Run, b: &Run| match (usable(model, a), usable(model, b)) {
        (Some(a), Some(b)) => {
            Trajectory::between(a, b, model, so_far.smallest_radius, tolerances.trajectory)
        }
        _ => Trajectory::default(),
    };
    let against_ours = pair(ours, other);
    let twin = twin.map(|twin| TwinCheck::new(twin, pair(&twin.run, other), so_far));
    let [our_span, their_span] = spans;
    let side = side(other, their_span);
    let parted = against_ours.worst.is_some_and(|worst| worst.largest > rows::APART);
    let rows = match (our_span, their_span) {
        (Some(a), Some(b)) => rows::rows(a, b, so_far, parted),
        _ => Vec::new(),
    };
    let mut opponent =
        Opponent { side, passed: false, reasons: Vec::new(), against_ours, twin, rows };
    opponent.judge(so_far, last_time(ours), last_time(other));
    opponent
}

fn last_time(run: &Run) -> f64 {
    run.frames.last().map_or(0.0, |frame| frame.time)
}

impl TwinCheck {
    fn new(twin: &Twin, trajectory: Trajectory, so_far: &Comparison) -> Self {
        let slack = 1.0 + 1e-9;
        let inside = trajectory
            .points
            .iter()
            .filter(|point| point.time > 0.0 && point.time <= so_far.window_end * slack);
        let frames_in_window = inside.clone().count();
        let worst_in_window = inside.map(|point| point.largest).reduce(f64::max);
        // A pair that agrees at frames after the window agrees in it, however sparse the frames are.
        let agrees_later = trajectory.agrees_until.is_some_and(|until| until > 0.0);
        let agrees = worst_in_window
            .map(|worst| worst <= so_far.tolerances.trajectory)
            .or(agrees_later.then_some(true));
        Self { scheme: twin.scheme.clone(), trajectory, worst_in_window, frames_in_window, agrees }
    }

    fn sentence(&self, so_far: &Comparison) -> String {
        let limit = so_far.tolerances.trajectory;
        let until = with_unit(so_far.window_end, "s");
        let scheme = &self.scheme;
        match (self.agrees, self.worst_in_window) {
            (Some(true), worst) => {
                let within = with_unit(self.trajectory.agrees_until.unwrap_or(0.0), "s");
                let early = worst.map_or(String::new(), |worst| {
                    format!(
                        ", by at most {worst:.1e} over the first {} frames",
                        self.frames_in_window
                    )
                });
                format!(
                    "Same computation: sphere by sphere within {limit:.0e} smallest radii of our DEM in the \
                     scheme {scheme} until t = {within}{early}."
                )
            }
            (Some(false), worst) => format!(
                "Not the same computation: {:.1e} smallest radii from our DEM in the scheme {scheme} \
                 before t = {until}, {limit:.0e} allowed.",
                worst.unwrap_or(0.0)
            ),
            (None, _) => format!(
                "Whether it is the same computation was not answered: no common frame after the start \
                 and before t = {until}. Write frames more often."
            ),
        }
    }
}

impl Row {
    /// True if it passes, but not within the tolerance alone.
    pub fn leans_on_chance(&self) -> bool {
        self.passed && self.allowed > self.tolerance && self.relative.abs() > self.tolerance
    }

    fn told(&self) -> String {
        let percent = |share: f64| significant(100.0 * share, 2);
        let name = self.quantity.name();
        format!("{name} {} % apart, {} % allowed", percent(self.relative), percent(self.allowed))
    }

    fn fault(&self) -> String {
        let percent = |share: f64| significant(100.0 * share, 3);
        let limit = if self.chance > self.allowed {
            format!(
                ", although chance was given {} times the tolerance; two runs of this bed may \
                 differ by {} %, so it takes more grains or more time to tell",
                significant(rows::MOST_CHANCE, 2),
                percent(self.chance)
            )
        } else if self.allowed > self.tolerance {
            " with chance".to_owned()
        } else {
            String::new()
        };
        format!(
            "{} differs by {} %, {} % allowed{limit}.",
            self.quantity.name(),
            percent(self.relative),
            percent(self.allowed)
        )
    }
}

impl Opponent {
    /// Decides, and says why: faults first.
    fn judge(&mut self, so_far: &Comparison, our_end: f64, their_end: f64) {
        let mut faults = self.faults_of_the_run(so_far, our_end, their_end);
        let mut remarks = Vec::new();
        match &self.twin {
            None => remarks.push("Not compared with our DEM in its own scheme.".to_owned()),
            Some(twin) if twin.trajectory.points.is_empty() => {}
            Some(twin) if twin.agrees == Some(false) => faults.push(twin.sentence(so_far)),
            Some(twin) => remarks.push(twin.sentence(so_far)),
        }
        for row in self.rows.iter().filter(|row| !row.passed) {
            faults.push(row.fault());
        }
        remarks.extend(self.statistics_that_pass());
        remarks.extend(self.against_ours.parting(so_far.window_end));
        self.passed = faults.is_empty();
        self.reasons = faults;
        self.reasons.append(&mut remarks);
    }

    /// The row of `quantity`, if it could be measured.
    pub fn row(&self, quantity: Quantity) -> Option<&Row> {
        self.rows.iter().find(|row| row.quantity == quantity)
    }

    fn statistics_that_pass(&self) -> Option<String> {
        if self.rows.is_empty() || self.rows.iter().any(|row| !row.passed) {
            return None;
        }
        let names: Vec<String> =
            self.rows.iter().filter(|row| row.leans_on_chance()).map(Row::told).collect();
        Some(if names.is_empty() {
            "All statistics of the last part of the run are within tolerance.".into()
        } else {
            format!(
                "All statistics of the last part of the run agree, some of them only within what \
                 chance does to two runs of this bed: {}.",
                names.join("; ")
            )
        })
    }

    fn faults_of_the_run(&self, so_far: &Comparison, our_end: f64, their_end: f64) -> Vec<String> {
        let mut faults = Vec::new();
        match &self.side.outcome {
            Outcome::Finished => {}
            Outcome::Cancelled { step } => faults.push(format!("It was stopped at step {step}.")),
            Outcome::Stopped { time, reason, .. } => {
                faults.push(format!("It stopped at t = {}: {reason}", with_unit(*time, "s")));
            }
            Outcome::Failed { reason } => faults.push(format!("It failed: {reason}")),
        }
        if self.side.statistics.is_none() {
            faults.push("It gave no complete set of finite positions and velocities.".into());
        } else if so_far.ours.statistics.is_none() {
            faults.push("Our own run has no final state to compare with.".into());
        } else if (our_end - their_end).abs() > 1e-6 * our_end.abs().max(1e-300) {
            faults.push(format!("It ended at t = {their_end:.6e} s, ours at {our_end:.6e} s."));
        }
        faults
    }
}

/// Shortest undamped contact, s; the largest stiffness with the least reduced mass.
fn contact_duration(model: &Model) -> f64 {
    let mass = model.bodies.iter().map(|body| body.mass).fold(f64::INFINITY, f64::min);
    let size = model.contacts.size() as u16;
    let pairs = (0..size).flat_map(|a| (0..size).map(move |b| (a, b)));
    let stiffness = pairs.map(|(a, b)| model.contacts.between(a, b).kn).fold(0.0, f64::max);
    let duration = std::f64::consts::PI * (0.5 * mass / stiffness).sqrt();
    if duration.is_finite() { duration } else { model.plan.step }
}

/// Time of the first row of our series (else frame) with a contact, s; the end
/// of the run if there is none.
fn first_contact(model: &Model, ours: &Run) -> f64 {
    if !ours.series.is_empty() {
        // The contact may be as old as the row before.
        let touched = ours.series.iter().position(|row| row.contacts > 0);
        return match touched {
            Some(0) => 0.0,
            Some(at) => ours.series[at - 1].time,
            None => last_time(ours),
        };
    }
    let frames = usable(model, ours).unwrap_or(&[]);
    let touches = |frame: &&Frame| !statistics::touching(model, &frame.centres).is_empty();
    frames.iter().find(touches).map_or(0.0, |frame| frame.time)
}

/// What kinetic energies are compared with, J: the largest of our run's kinetic
/// energies, the potential energy it released, and the work of moving walls. A
/// bed at rest keeps a kinetic energy near 0, relative to which every difference
/// would be large.
fn energy_scale(model: &Model, ours: &Run) -> f64 {
    let frames = usable(model, ours).unwrap_or(&[]);
    let weight = |frame: &Frame| -> f64 {
        let bodies = frame.bodies.iter().zip(&model.bodies);
        bodies.map(|(state, body)| -body.mass * model.gravity.dot(&state.position)).sum()
    };
    let kinetic = frames.iter().map(|frame| frame.kinetic_energy(model));
    let released = match (frames.first(), frames.last()) {
        (Some(first), Some(last)) => weight(first) - weight(last),
        _ => 0.0,
    };
    let rows = ours.series.iter().flat_map(|row| [row.kinetic, row.wall_work.abs()]);
    kinetic.chain([released]).chain(rows).filter(|v| v.is_finite()).fold(0.0, f64::max)
}
