//! Packings made by compression in the DEM (see [`Compression`]).
//!
//! All grains grow by a small factor, then the DEM brings them to rest without gravity: 100 steps at a time, at half
//! the step limit, with local damping 0.7 (Cundall), the contacts of the scene and the friction of the preparation.
//! Tangential springs go on while grains grow. Stress: p = Σ f·l / (d V) over all contacts, l from the centre of a
//! grain to the contact. If a step of growth passes the target, the state before is taken again and the step made
//! smaller by interpolation, so that with friction nothing is ever unloaded; without it, where states do not
//! remember, grains shrink by what was too much. At the end friction becomes that of the scene, and grains come
//! to rest again.
//!
//! Cost: some 10 000 steps of the DEM. What comes back when the steps are used up or the
//! target lies between two states that cannot be told apart: the state reached, and the outcome says so.

use super::drive::{self, Origin};
use super::state::State;
use super::{DemError, Observer, advise};
use crate::model::{BodyState, Contact, Frame, Guard, Model, Motion, Outcome, SeriesRow};
use crate::num::{Job, Vec3};
use crate::pack::compression::{Compression, Until};
use crate::pack::{Bed, Push, Spheres};

/// A packing that the DEM has made.
#[derive(Debug, Clone, PartialEq)]
pub struct Compressed {
    /// Place and orientation of each body, at rest.
    pub states: Vec<BodyState>,
    /// Sizes over those of the model that was given.
    pub scale: f64,
    /// Mean stress, Pa.
    pub stress: f64,
    /// Mean number of bodies touched, as [`Until::Coordination`] counts.
    pub coordination: f64,
    /// Mean force left over on a grain over the mean contact force.
    pub unbalanced: f64,
    /// Steps of the DEM.
    pub steps: u64,
    /// True if the target is met within the tolerance and at rest.
    pub met: bool,
    /// How it ended, one clause.
    pub outcome: String,
}

/// Steps between looks.
const CHUNK: u64 = 100;
/// Looks at most until a state is taken as it is; as many again at the end.
const LOOKS: usize = 40;
/// First and largest growth at once.
const GROWTH: f64 = 0.01;
/// Growth that changes nothing any more.
const LEAST: f64 = 1e-9;
const DAMPING: f64 = 0.7;

/// Compresses the bodies of `model`, which must not overlap, in `volume` [m³]; `solid` [m³] is
/// what they fill. Gravity, motion of walls, forces between bodies and bonds of the model are put aside.
///
/// # Errors
/// As [`simulate`].
pub fn compress(
    model: &Model,
    volume: f64,
    solid: f64,
    wanted: &Compression,
    job: &Job,
) -> Result<Compressed, DemError> {
    let mut press = Press::new(model, volume, solid, wanted, job);
    let mut reading = match wanted.until {
        Until::Porosity(porosity) => press.reach_porosity(porosity)?,
        Until::Stress(stress) => press.reach_value(stress.0, |reading| reading.stress)?,
        Until::Coordination(number) => press.reach_value(number, |reading| reading.coordination)?,
    };
    press.set_friction(None);
    if press.left > 0 {
        reading = press.settle(true)?;
    }
    Ok(press.ended(model, reading))
}

/// What is read after a settling.
#[derive(Debug, Clone, Copy, Default)]
struct Look {
    stress: f64,
    coordination: f64,
    unbalanced: f64,
    /// Largest overlap over the smaller radius.
    worst: f64,
}

struct Press<'a> {
    model: Model,
    /// Contact of the scene, by pair, before the preparation.
    original: &'a Model,
    wanted: &'a Compression,
    job: &'a Job,
    volume: f64,
    solid: f64,
    scale: f64,
    left: u64,
    /// Where the DEM is; none before its first step.
    state: Option<State>,
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

impl<'a> Press<'a> {
    fn new(
        original: &'a Model,
        volume: f64,
        solid: f64,
        wanted: &'a Compression,
        job: &'a Job,
    ) -> Self {
        let mut model = original.clone();
        model.gravity = Vec3::zeros();
        model.mutual = None;
        model.local_damping = DAMPING;
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
        let left = wanted.steps;
        let (scale, state) = (1.0, None);
        let mut press = Self { model, original, wanted, job, volume, solid, scale, left, state };
        press.set_friction(Some(wanted.friction));
        press
    }

    /// That of the preparation, or of the scene.
    fn set_friction(&mut self, friction: Option<f64>) {
        let needs = self.model.needs();
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
        if self.model.needs() != needs {
            // Without friction there are neither spins nor memories, with it there are.
            self.state = None;
        }
    }

    fn grow(&mut self, factor: f64) {
        let dimension = self.model.dimension.count() as i32;
        for sphere in &mut self.model.spheres {
            sphere.radius *= factor;
            sphere.offset *= factor;
        }
        for body in &mut self.model.bodies {
            body.mass *= factor.powi(dimension);
            body.inertia *= factor.powi(dimension + 2);
        }
        self.scale *= factor;
    }

    fn fraction(&self) -> f64 {
        self.solid * self.scale.powi(self.model.dimension.count() as i32) / self.volume
    }

    /// Runs 100 steps at a time until forces balance. Unless `patient`, it ends sooner where hardly anything
    /// carries load yet, and where the target is far behind.
    fn settle(&mut self, patient: bool) -> Result<Look, DemError> {
        let mut look = Look::default();
        for round in 0..LOOKS {
            if self.left == 0 || self.job.is_cancelled() {
                break;
            }
            look = self.steps()?;
            let (loose, beyond) = match self.wanted.until {
                Until::Stress(stress) => {
                    (look.stress < 0.1 * stress.0, look.stress > 5.0 * stress.0)
                }
                Until::Porosity(_) => (true, false),
                Until::Coordination(_) => (look.worst < 1e-5, false),
            };
            let hasty = !patient && ((loose && round > 0) || (beyond && round > 3));
            if look.unbalanced <= self.wanted.balance || hasty {
                break;
            }
        }
        Ok(look)
    }

    /// One chunk of the DEM.
    fn steps(&mut self) -> Result<Look, DemError> {
        let count = CHUNK.min(self.left);
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
        self.job.report("steps", self.wanted.steps - self.left, self.wanted.steps);
        let Some(frame) = last.frame else {
            return Err(DemError::Unusable("the compression gave no state".to_owned()));
        };
        if let Outcome::Stopped { reason, .. } = summary.outcome {
            return Err(DemError::Unusable(format!("the compression stopped: {reason}")));
        }
        for (body, state) in self.model.bodies.iter_mut().zip(&frame.bodies) {
            (body.position, body.orientation) = (state.position, state.orientation);
            (body.velocity, body.spin) = (state.velocity, state.spin);
        }
        Ok(self.look(&frame, last.pushes))
    }

    fn look(&self, frame: &Frame, pushes: Vec<Push>) -> Look {
        let model = &self.model;
        let dimension = model.dimension.count();
        let mut net = vec![Vec3::zeros(); model.bodies.len()];
        let (mut virial, mut sizes) = (0.0, 0.0);
        for push in &pushes {
            sizes += push.force.norm();
            let sides = [(Some(push.first), push.force), (push.second, -push.force)];
            for (sphere, force) in sides {
                let Some(sphere) = sphere else { continue };
                let body = model.spheres[sphere as usize].body as usize;
                net[body] += force;
                virial += force.dot(&model.way(frame.bodies[body].position - push.point));
            }
        }
        let left: f64 = net.iter().map(|force| force.norm()).sum();
        let mean = sizes / pushes.len().max(1) as f64;
        let count = net.len().max(1) as f64;
        let bed = Bed::new(
            Spheres {
                centres: frame.centres.clone(),
                radii: model.spheres.iter().map(|sphere| sphere.radius).collect(),
                body: model.spheres.iter().map(|sphere| sphere.body).collect(),
                dimension,
                // The domain ends at the sides that repeat.
                room: Some(model.domain),
                periodic: model.periodic.map_or([false; 3], |cell| cell.periodic),
                pushes,
            },
            0.0,
        );
        let worst = bed.contacts.iter().fold(0.0_f64, |worst, contact| {
            let (i, j) = (contact.first as usize, contact.second as usize);
            worst.max(-contact.gap / bed.spheres.radii[i].min(bed.spheres.radii[j]))
        });
        Look {
            stress: virial / (dimension as f64 * self.volume),
            coordination: if self.wanted.friction > 0.0 { mechanical(&bed) } else { held(&bed) },
            unbalanced: if mean > 0.0 { left / count / mean } else { 0.0 },
            worst,
        }
    }

    /// To a porosity: the growth is known beforehand.
    fn reach_porosity(&mut self, porosity: f64) -> Result<Look, DemError> {
        let dimension = self.model.dimension.count() as f64;
        let way = ((1.0 - porosity) / self.fraction()).ln() / dimension;
        let parts = (way.abs() / GROWTH).ceil().max(1.0);
        let mut look = Look::default();
        for _ in 0..parts as usize {
            self.grow((way / parts).exp());
            look = self.settle(false)?;
            if self.left == 0 || self.job.is_cancelled() {
                break;
            }
        }
        Ok(look)
    }

    /// Until what `of` reads is the target.
    fn reach_value(&mut self, target: f64, of: fn(&Look) -> f64) -> Result<Look, DemError> {
        let (low, high) =
            (target * (1.0 - self.wanted.tolerance), target * (1.0 + self.wanted.tolerance));
        let mut growth = GROWTH;
        let mut look = self.settle(false)?;
        while self.left > 0 && growth.abs() > LEAST && !self.job.is_cancelled() {
            let near = |look: &Look| of(look) >= low && of(look) <= high;
            while near(&look) && look.unbalanced > self.wanted.balance && self.left > 0 {
                look = self.settle(true)?;
            }
            if near(&look) {
                return Ok(look);
            }
            let before = (self.model.clone(), self.state.clone(), self.scale, look);
            self.grow(1.0 + growth);
            look = self.settle(false)?;
            // Where the target lies between the two states, or beyond both, as a share of the step.
            let share = (target - of(&before.3)) / (of(&look) - of(&before.3));
            let passed = (of(&look) - target) * growth > 0.0;
            if self.wanted.friction > 0.0 {
                if of(&look) > high {
                    growth *= share.clamp(0.1, 0.7);
                    (self.model, self.state, self.scale, look) = before;
                }
            } else if passed && !near(&look) {
                // Without friction there is no memory: back by what was too much.
                growth *= -(1.0 - share.clamp(0.1, 0.9));
            }
        }
        Ok(look)
    }

    fn ended(&self, given: &Model, look: Look) -> Compressed {
        let porosity = 1.0 - self.fraction();
        let (what, asked, found) = match self.wanted.until {
            Until::Stress(stress) => ("stress [Pa]", stress.0, look.stress),
            Until::Porosity(asked) => ("porosity", asked, porosity),
            Until::Coordination(number) => ("coordination number", number, look.coordination),
        };
        let near = (found / asked - 1.0).abs() <= self.wanted.tolerance * (1.0 + 1e-9);
        // Without load there is nothing to balance.
        let rest = look.unbalanced <= self.wanted.balance || look.stress <= 0.0;
        let ended = match (near, rest, self.left) {
            _ if self.job.is_cancelled() => "stopped before the end",
            (true, true, _) => "target met",
            (true, false, _) => "target met, forces not yet in balance",
            (false, _, 0) => "steps used up before the target",
            (false, ..) => "target not met: no state nearer to it was found",
        };
        let steps = self.wanted.steps - self.left;
        Compressed {
            states: self
                .model
                .bodies
                .iter()
                .map(|body| BodyState {
                    velocity: Vec3::zeros(),
                    spin: Vec3::zeros(),
                    ..body.state()
                })
                .collect(),
            scale: self.scale,
            stress: look.stress,
            coordination: look.coordination,
            unbalanced: look.unbalanced,
            steps,
            met: near && rest,
            outcome: format!(
                "{ended}: {what} {found:.5e} of {asked:.5e}; porosity {porosity:.5}, stress {:.4e} Pa, coordination number \
                 {:.3} {}, overlaps up to {:.2e} of the radius, unbalanced {:.1e}; {} grains, {steps} steps of the DEM, \
                 friction {} while compressed",
                look.stress,
                look.coordination,
                if self.wanted.friction > 0.0 { "(mechanical)" } else { "(without rattlers)" },
                look.worst,
                look.unbalanced,
                given.bodies.len(),
                self.wanted.friction
            ),
        }
    }
}

/// Mean number of bodies touched among those that are no rattlers.
fn held(bed: &Bed) -> f64 {
    let holding = bed.held.iter().filter(|count| **count > 0).count();
    f64::from(bed.held.iter().sum::<u32>()) / holding.max(1) as f64
}

/// The same without bodies of no contact or one (Thornton 2000).
fn mechanical(bed: &Bed) -> f64 {
    let single = bed.partners.iter().filter(|count| **count == 1).count();
    let more = bed.partners.iter().filter(|count| **count > 1).count();
    let all = f64::from(bed.partners.iter().sum::<u32>()) - single as f64;
    all / more.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Bounds, Cell};
    use crate::model::{Body, ContactTable, Dimension, Material, Scheme, Sphere};
    use crate::pack::scatter;
    use crate::pack::space::Space;

    /// Discs of two sizes at random places in a periodic box of edge 1, and the area that they fill.
    fn discs(count: usize) -> (Model, f64) {
        let contact = Contact { kn: 1e6, kt: 5e5, cn: 0.0, ct: 0.0, friction: 0.3 };
        let mut model = crate::dem::test_scenes::empty(Scheme::Leapfrog, contact);
        model.dimension = Dimension::Two;
        let bounds = Bounds { low: Vec3::new(0.0, 0.0, -0.5), high: Vec3::new(1.0, 1.0, 0.5) };
        model.domain = bounds;
        model.periodic = Some(Cell { bounds, periodic: [true, true, false] });
        model.materials = vec![Material { name: "stone".into(), density: 2500.0 }];
        model.contacts = ContactTable::uniform(1, contact);
        let unit = (0.4 / (count as f64 * std::f64::consts::PI * 1.48)).sqrt();
        let radii: Vec<f64> =
            (0..count).map(|i| if i % 2 == 0 { unit } else { 1.4 * unit }).collect();
        let space = Space::boxed(2, bounds, [true, true, false]);
        let (centres, failed) = scatter::apart(&space, &radii, 10_000, 2).expect("a box");
        assert_eq!(failed, 0);
        for (i, (centre, &radius)) in centres.iter().zip(&radii).enumerate() {
            model.bodies.push(Body::sphere(Dimension::Two, *centre, radius, 2500.0, 0, i as u32));
            model.spheres.push(Sphere { offset: Vec3::zeros(), radius, body: i as u32 });
        }
        (model, radii.iter().map(|r| std::f64::consts::PI * r * r).sum())
    }

    #[test]
    fn discs_are_compressed_to_a_stress_and_just_hold_each_other() {
        let (model, solid) = discs(40);
        let wanted = Compression {
            until: Until::Stress(crate::num::units::Pressure(1e3)),
            tolerance: 0.2,
            balance: 0.02,
            steps: 30_000,
            ..Compression::default()
        };
        let done = compress(&model, 1.0, solid, &wanted, &Job::quiet()).expect("runs");
        assert!(done.met && (done.stress / 1e3 - 1.0).abs() < 0.2, "{}", done.outcome);
        let fraction = solid * done.scale * done.scale;
        assert!((0.78..0.88).contains(&fraction), "{}", done.outcome);
        assert!((3.6..4.7).contains(&done.coordination), "{}", done.outcome);
    }

    #[test]
    fn a_porosity_is_met_to_rounding() {
        let (model, solid) = discs(20);
        let wanted =
            Compression { until: Until::Porosity(0.3), friction: 0.5, ..Compression::default() };
        let done = compress(&model, 1.0, solid, &wanted, &Job::quiet()).expect("runs");
        assert!(done.met && done.outcome.starts_with("target met"), "{}", done.outcome);
        assert!((solid * done.scale * done.scale - 0.7).abs() < 1e-12);
        let few = Compression { steps: 100, ..wanted };
        let cut = compress(&model, 1.0, solid, &few, &Job::quiet()).expect("runs");
        assert!(!cut.met && cut.outcome.starts_with("steps used up"), "{}", cut.outcome);
    }
}
