//! Lock-step: every code starts again from the same state every so many steps, so that
//! agreement is shown along a whole run and not only until chaos parts them.
//!
//! The states are those of riprap's own run of the scene (all of them, also where a segment
//! is shorter than the way to the next). At each of them contacts forget
//! their tangential springs, in all codes alike: riprap in the scene's scheme, each solver,
//! and riprap in the scheme and law of that solver run on for as many steps, and the places
//! they end at are compared. Cost: twice the run here, once in each solver, and a start of
//! each solver a segment.

use super::road::{Road, RoadError};
use crate::dem;
use crate::model::{Frame, Model, Motion, Outcome, Run, WallShape};
use crate::num::Rotation;
use crate::solver::{self, DeckOptions, Solver};
use serde::Serialize;

/// One solver over one segment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Segment {
    /// Key of the solver.
    pub solver: &'static str,
    /// Step at which the segment ends.
    pub step: u64,
    /// Time at which it ends, s.
    pub time: f64,
    /// Largest distance of a sphere from where riprap in the solver's scheme has it, in
    /// smallest radii.
    pub from_twin: f64,
    /// The same from riprap in the scheme of the scene: what the codes differ by.
    pub from_ours: f64,
    /// CPU seconds of the solver, start included.
    pub cpu_seconds: f64,
}

/// A whole run in lock-step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LockStep {
    /// Title of the scene.
    pub title: String,
    /// Steps from one start to the next.
    pub every: u64,
    /// Steps of a segment.
    pub length: u64,
    /// What `from_twin` may be.
    pub tolerance: f64,
    /// All segments, by time, then by solver.
    pub segments: Vec<Segment>,
    /// What solvers cannot express, and what went wrong.
    pub failures: Vec<String>,
}

impl LockStep {
    /// True if every solver stays within the tolerance of its twin in every segment.
    pub fn passed(&self) -> bool {
        self.failures.is_empty()
            && !self.segments.is_empty()
            && self.segments.iter().all(|segment| segment.from_twin <= self.tolerance)
    }

    /// The largest `from_twin` and `from_ours` of a solver.
    pub fn worst(&self, solver: &str) -> Option<[f64; 2]> {
        let of = self.segments.iter().filter(|segment| segment.solver == solver);
        of.map(|segment| [segment.from_twin, segment.from_ours])
            .reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])])
    }

    /// One row a segment and solver.
    pub fn csv(&self) -> String {
        let mut text =
            "solver,step,time [s],from twin [radii],from ours [radii],CPU [s]\n".to_owned();
        for s in &self.segments {
            let Segment { solver, step, time, from_twin, from_ours, cpu_seconds } = s;
            text.push_str(&format!(
                "{solver},{step},{time:?},{from_twin:?},{from_ours:?},{cpu_seconds:?}\n"
            ));
        }
        text
    }
}

impl Road {
    /// Runs the scene in lock-step with `solvers`: from its state at every `every` steps for
    /// `length` steps; writes `lockstep.csv` and `lockstep.json`.
    ///
    /// # Errors
    /// As [`Road::run`]; scenes with bonds (their springs would start anew); a scene of fewer
    /// than `every` steps.
    pub fn lock_step(
        &mut self,
        solvers: &[&'static dyn Solver],
        every: u64,
        length: u64,
    ) -> Result<LockStep, RoadError> {
        let (_, built) = self.built()?;
        let model = in_segments(built.model, every, length)?;
        let whole = dem::run(&model, &self.job)?;
        if whole.outcome != Outcome::Finished {
            return Err(RoadError::Work(format!("riprap's own run: {:?}", whole.outcome)));
        }
        let mut running = self.store.begin("lock-step", "")?;
        let (able, failures) = solver::able(solvers, &model);
        let mut found = LockStep {
            title: model.title.clone(),
            every,
            length,
            tolerance: self.loaded.scene.compare.tolerance.trajectory,
            segments: Vec::new(),
            failures,
        };
        for start in &whole.frames {
            // Whole segments cover the run; shorter ones leave out its start, where little happens.
            let last = start.step == model.plan.steps;
            if (length >= every && last) || (length < every && start.step == 0) {
                continue;
            }
            let from = started_at(&model, start, length);
            let ours = dem::run(&from, &self.job)?;
            for solver in &able {
                match self.segment(*solver, start, &from, &ours)? {
                    Ok(segment) => found.segments.push(segment),
                    Err(failure) => found.failures.push(failure),
                }
            }
            if self.job.is_cancelled() {
                return Err(RoadError::Cancelled);
            }
            self.job.report("lock-step", start.step, model.plan.steps);
        }
        let json = serde_json::to_vec_pretty(&found)
            .map_err(|error| RoadError::Work(error.to_string()))?;
        for (name, bytes) in
            [("lockstep.csv", found.csv().as_bytes()), ("lockstep.json", json.as_slice())]
        {
            let path = self.store.prepare(&mut running, name)?;
            crate::report::write_whole(&path, bytes)
                .map_err(|error| RoadError::Work(error.to_string()))?;
        }
        running.count("segments", found.segments.len());
        self.close(running, "ran in lock-step")?;
        Ok(found)
    }

    /// `solver` over the segment that `from` is, which begins at `start` and which our own run
    /// `ours` went through; inside, what went wrong in the solver.
    fn segment(
        &mut self,
        solver: &dyn Solver,
        start: &Frame,
        from: &Model,
        ours: &Run,
    ) -> Result<Result<Segment, String>, RoadError> {
        let deck = self.export(solver, from, &DeckOptions::default())?;
        let theirs = match solver.run(from, &deck, &self.job) {
            Ok(run) if run.outcome == Outcome::Finished => run,
            Ok(run) => return Ok(Err(format!("{}: {:?}", solver.name(), run.outcome))),
            Err(error) => return Ok(Err(format!("{}: {error}", solver.name()))),
        };
        let twin = dem::run(&solver.twin(from), &self.job)?;
        Ok(Ok(Segment {
            solver: solver.key(),
            step: start.step + from.plan.steps,
            time: start.time + from.plan.duration(),
            from_twin: apart(from, &twin, &theirs),
            from_ours: apart(from, ours, &theirs),
            cpu_seconds: theirs.cost.cpu_seconds,
        }))
    }
}

/// `model` over a whole number of segments of `every` steps, with a frame at the end of each.
fn in_segments(mut model: Model, every: u64, length: u64) -> Result<Model, RoadError> {
    if model.needs().bonds || model.needs().servo_walls {
        let message = "lock-step does not do bonds, which would start again without force, nor \
                       walls that seek a force, whose place a frame does not tell";
        return Err(RoadError::Work(message.to_owned()));
    }
    if every == 0 || length == 0 || every > model.plan.steps {
        let steps = model.plan.steps;
        let message = format!(
            "lock-step takes 1 to {steps} steps a segment (the steps of the scene), not {every}"
        );
        return Err(super::SceneError::Wrong { messages: vec![message] }.into());
    }
    model.plan.steps -= model.plan.steps % every;
    model.plan.frame_every = every;
    Ok(model)
}

/// The model as it is at `frame`, with `steps` to go and no memory of contacts.
fn started_at(model: &Model, frame: &Frame, steps: u64) -> Model {
    let mut model = model.clone();
    // Who comes later comes as it would.
    let here = model.first_arrival() + model.arrived_by(frame.step);
    model.arrivals.drain(..model.arrived_by(frame.step));
    model.arrivals.iter_mut().for_each(|time| *time -= frame.time);
    for (body, state) in model.bodies[..here].iter_mut().zip(&frame.bodies) {
        body.position = state.position;
        body.orientation = state.orientation;
        body.velocity = state.velocity;
        body.spin = state.spin;
    }
    move_walls(&mut model, frame.time);
    (model.plan.steps, model.plan.frame_every, model.plan.series_every) = (steps, steps, steps);
    model.plan.checkpoint_every = 0;
    model
}

/// Walls of `model` to where they are at `time`, s.
pub(super) fn move_walls(model: &mut Model, time: f64) {
    for wall in &mut model.walls {
        let motion = wall.motion;
        if let Motion::Oscillate { frequency, phase, .. } = &mut wall.motion {
            *phase += std::f64::consts::TAU * *frequency * time;
        }
        match &mut wall.shape {
            WallShape::Plane { point, normal } => {
                *point = motion.place(point, time);
                if let Motion::Rotate { axis, rate, .. } = motion {
                    *normal = Rotation::from_scaled_axis(axis * (rate * time)) * *normal;
                }
            }
            WallShape::Mesh { mesh } => {
                for vertex in &mut mesh.vertices {
                    *vertex = motion.place(vertex, time);
                }
            }
        }
    }
}

/// Largest distance of a sphere between the ends of two runs, in smallest radii.
fn apart(model: &Model, a: &Run, b: &Run) -> f64 {
    let radius = model.smallest_radius();
    let (Some(a), Some(b)) = (a.frames.last(), b.frames.last()) else { return f64::INFINITY };
    if a.step != b.step {
        return f64::INFINITY;
    }
    let far = a.centres.iter().zip(&b.centres).map(|(a, b)| model.way(a - b).norm() / radius);
    far.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Contact, ContactTable};
    use crate::num::{Job, Vec3};

    /// Without friction and dashpots contacts remember nothing: a run that starts again is the run.
    #[test]
    fn bodies_and_walls_start_where_they_are() {
        let mut model = crate::report::fixture::model(2);
        let elastic =
            Contact { kt: 0.0, ct: 0.0, cn: 0.0, friction: 0.0, ..*model.contacts.between(0, 0) };
        model.contacts = ContactTable::uniform(model.contacts.size(), elastic);
        model.gravity = Vec3::new(0.0, 0.0, -9.81);
        for wall in &mut model.walls {
            wall.motion = Motion::Translate { velocity: Vec3::new(0.0, 0.0, 0.02) };
        }
        (model.plan.steps, model.plan.frame_every) = (400, 200);
        let whole = dem::run(&model, &Job::quiet()).expect("runs");
        let from = started_at(&model, &whole.frames[1], 200);
        assert_ne!(from.walls, model.walls);
        let rest = dem::run(&from, &Job::quiet()).expect("runs");
        let rest = Run { frames: shifted(&rest, 200), ..rest };
        let far = apart(&model, &whole, &rest);
        assert!(far < 1e-11, "{far:e}");
    }

    fn shifted(run: &Run, steps: u64) -> Vec<Frame> {
        let mut frames = run.frames.clone();
        frames.iter_mut().for_each(|frame| frame.step += steps);
        frames
    }

    #[test]
    fn a_segment_out_of_tolerance_fails() {
        let segment = Segment {
            solver: "yade",
            step: 10,
            time: 1e-3,
            from_twin: 1e-9,
            from_ours: 1e-3,
            cpu_seconds: 1.0,
        };
        let mut found = LockStep {
            title: "x".into(),
            every: 10,
            length: 10,
            tolerance: 1e-8,
            segments: vec![segment.clone(), Segment { from_twin: 1e-10, step: 20, ..segment }],
            failures: Vec::new(),
        };
        assert!(found.passed());
        assert_eq!(found.worst("yade"), Some([1e-9, 1e-3]));
        assert_eq!(found.csv().lines().count(), 3);
        found.segments[1].from_twin = 1e-7;
        assert!(!found.passed());
        found.segments.clear();
        assert!(!found.passed(), "nothing compared is no agreement");
    }
}
