//! A model brought to rest in short runs of the DEM, between which it may be changed: what compression and deposition
//! share.
//!
//! Walls stand still and bonds and forces between bodies are put aside; contacts are those of the scene with the
//! friction of the preparation. The run goes on from its own state, tangential springs included, at half the step limit.

use super::drive::{self, Origin};
use super::state::State;
use super::{DemError, Observer, advise};
use crate::model::{Body, BodyState, Contact, Frame, Guard, Model, Motion, Outcome, SeriesRow};
use crate::num::{Job, Vec3};
use crate::pack::{Bed, Push, Spheres};

/// A model between two short runs.
pub struct Rig<'a> {
    /// As the DEM left it. Sizes may be changed between runs.
    pub model: Model,
    /// Contacts of the scene.
    original: &'a Model,
    pub job: &'a Job,
    steps: u64,
    /// Steps that may still be made.
    pub left: u64,
    /// Where the DEM is; none before its first step.
    pub state: Option<State>,
}

/// What is seen after a short run.
pub struct Seen {
    frame: Frame,
    pushes: Vec<Push>,
}

/// Keeps the last frame and its contact forces.
#[derive(Default)]
struct Last {
    frame: Option<Frame>,
    pushes: Vec<Push>,
}

impl Observer for Last {
    fn frame(&mut self, frame: &Frame) {
        self.frame = Some(frame.clone());
    }

    fn row(&mut self, _row: &SeriesRow) {}

    fn checkpoint(&mut self, _bytes: &[u8]) {}

    fn wants_pushes(&self, last: bool) -> bool {
        last
    }

    fn pushes(&mut self, _frame: &Frame, pushes: Vec<Push>) {
        self.pushes = pushes;
    }
}

impl<'a> Rig<'a> {
    /// The bodies of `original` without motion, with `friction` in all contacts (none: that of the scene), for `steps`
    /// steps at most.
    pub fn new(original: &'a Model, friction: Option<f64>, steps: u64, job: &'a Job) -> Self {
        let mut model = original.clone();
        model.mutual = None;
        model.bonds.clear();
        model.extra = Default::default();
        for wall in &mut model.walls {
            wall.motion = Motion::Still;
        }
        for body in &mut model.bodies {
            (body.velocity, body.spin) = (Vec3::zeros(), Vec3::zeros());
        }
        let plan = &mut model.plan;
        plan.guard =
            Guard { overlap: 0.0, travel: 0.0, gain: 0.0, shaking: 0.0, ..Guard::default() };
        plan.insist = true;
        (plan.zero_every, plan.checkpoint_every) = (0, 0);
        let mut rig = Self { model, original, job, steps, left: steps, state: None };
        rig.set_friction(friction);
        rig
    }

    /// Local damping from now on.
    pub fn set_damping(&mut self, damping: f64) {
        self.change(|rig| rig.model.local_damping = damping);
    }

    /// That of the preparation, or of the scene.
    pub fn set_friction(&mut self, friction: Option<f64>) {
        self.change(|rig| rig.put_friction(friction));
    }

    /// A change that may alter what the DEM has to remember; then it begins again from places and velocities.
    fn change(&mut self, make: impl FnOnce(&mut Self)) {
        let needs = self.model.needs();
        make(self);
        if self.model.needs() != needs {
            self.state = None;
        }
    }

    fn put_friction(&mut self, friction: Option<f64>) {
        let table = &mut self.model.contacts;
        for a in 0..table.size() as u16 {
            for b in a..table.size() as u16 {
                let scene = *self.original.contacts.between(a, b);
                let mut contact = Contact { friction: friction.unwrap_or(scene.friction), ..scene };
                if contact.friction > 0.0 && contact.kt <= 0.0 {
                    // A scene without friction has no tangential spring; that of spheres at rest.
                    contact.kt = 2.0 / 7.0 * contact.kn;
                }
                table.set(a, b, contact);
            }
        }
    }

    /// Runs `count` steps, or those that are left.
    ///
    /// # Errors
    /// As [`super::simulate`]; a run that stops.
    pub fn advance(&mut self, count: u64) -> Result<Seen, DemError> {
        let count = count.min(self.left);
        self.left -= count;
        let plan = &mut self.model.plan;
        (plan.steps, plan.frame_every, plan.series_every) = (count, u64::MAX, u64::MAX);
        // A first step, so that the model is whole when it is judged.
        if plan.step <= 0.0 {
            plan.step = 1e-12;
        }
        self.model.plan.step = 0.5 * advise(&self.model).limit;
        let mut last = Last::default();
        let origin =
            self.state.take().map_or(Origin::Model, |state| Origin::State(Box::new(state)));
        let job = self.job.silent(self.job.threads);
        let (summary, state) = drive::simulate(&self.model, origin, (&job, true), &mut last)?;
        self.state = Some(state);
        self.job.report("steps", self.steps - self.left, self.steps);
        let Some(frame) = last.frame else {
            return Err(DemError::Unusable("the preparation gave no state".to_owned()));
        };
        if let Outcome::Stopped { reason, .. } = summary.outcome {
            return Err(DemError::Unusable(format!("the preparation stopped: {reason}")));
        }
        for (body, state) in self.model.bodies.iter_mut().zip(&frame.bodies) {
            (body.position, body.orientation) = (state.position, state.orientation);
            (body.velocity, body.spin) = (state.velocity, state.spin);
        }
        Ok(Seen { frame, pushes: last.pushes })
    }

    /// Places and orientations, without motion.
    pub fn states(&self) -> Vec<BodyState> {
        let still = |body: &Body| BodyState {
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            ..body.state()
        };
        self.model.bodies.iter().map(still).collect()
    }
}

impl Seen {
    /// Mean force left over on a body, its weight included, over the mean contact force; 0 without contacts.
    pub fn unbalanced(&self, model: &Model) -> f64 {
        let mut net: Vec<Vec3> =
            model.bodies.iter().map(|body| model.gravity * body.mass).collect();
        for (body, force, _) in self.sides(model) {
            net[body] += force;
        }
        let sizes: f64 = self.pushes.iter().map(|push| push.force.norm()).sum();
        let mean = sizes / self.pushes.len().max(1) as f64;
        let left: f64 = net.iter().map(|force| force.norm()).sum();
        if mean > 0.0 { left / net.len().max(1) as f64 / mean } else { 0.0 }
    }

    /// Number of bodies that touch nothing.
    pub fn floating(&self, model: &Model) -> usize {
        let mut touched = vec![false; model.bodies.len()];
        for (body, ..) in self.sides(model) {
            touched[body] = true;
        }
        touched.iter().filter(|touched| !**touched).count()
    }

    /// Σ f·l over all contacts [J], l from the centre of a body to the contact.
    pub fn virial(&self, model: &Model) -> f64 {
        self.sides(model)
            .map(|(body, force, point)| {
                force.dot(&model.way(self.frame.bodies[body].position - point))
            })
            .sum()
    }

    /// Body, force on it and point, for each side of each contact that is a body.
    fn sides<'b>(&'b self, model: &'b Model) -> impl Iterator<Item = (usize, Vec3, Vec3)> + 'b {
        let body = |sphere: u32| model.spheres[sphere as usize].body as usize;
        self.pushes.iter().flat_map(move |push| {
            let first = (body(push.first), push.force, push.point);
            let second = push.second.map(|sphere| (body(sphere), -push.force, push.point));
            std::iter::once(first).chain(second)
        })
    }

    /// The spheres with their contacts.
    pub fn bed(self, model: &Model) -> Bed {
        let spheres = Spheres {
            centres: self.frame.centres,
            radii: model.spheres.iter().map(|sphere| sphere.radius).collect(),
            body: model.spheres.iter().map(|sphere| sphere.body).collect(),
            dimension: model.dimension.count(),
            // The domain ends at the sides that repeat.
            room: Some(model.domain),
            periodic: model.periodic.map_or([false; 3], |cell| cell.periodic),
            pushes: self.pushes,
        };
        Bed::new(spheres, 0.0)
    }
}
