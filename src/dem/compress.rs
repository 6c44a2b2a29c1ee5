//! Packings made by compression in the DEM (see [`Compression`]).
//!
//! All grains grow by a small factor, then the DEM brings them to rest without gravity: 300 steps at a time, at half
//! the step limit, with local damping (Cundall), the contacts of the scene and the friction of the preparation.
//! Tangential springs go on while grains grow. Stress: p = Σ f·l / (d V) over all contacts, l from the centre of a
//! grain to the contact. If a step of growth passes the target, the state before is taken again, stopped, and the
//! step made smaller by interpolation, so that with friction nothing is ever unloaded; without it, where states do
//! not remember, grains shrink by what was too much, and steps that bring too little grow again: slow collective
//! motions go on long after a step and would leave a search that only narrows on one side of the target. At the end friction becomes that of the scene, and grains come
//! to rest again: with much less friction than that of the preparation they may come apart, and the outcome says so.
//!
//! Cost: some 10 000 steps of the DEM. What comes back when the steps are used up or the
//! target lies between two states that cannot be told apart: the state reached, and the outcome says so.

use super::rig::Rig;
use super::{DemError, zeroing};
use crate::model::{BodyState, Model};
use crate::num::{Job, Vec3};
use crate::pack::Bed;
use crate::pack::compression::{Compression, Until};

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
const CHUNK: u64 = 300;
/// Looks at most until a state is taken as it is; as many again at the end.
const LOOKS: usize = 20;
/// First and largest growth at once.
const GROWTH: f64 = 0.01;
/// Looks in a row at which forces balance until a state is at rest, and not only passing.
const QUIET: u32 = 3;
/// Growth that changes nothing any more.
const LEAST: f64 = 1e-9;
/// By how much a step of growth that brought too little becomes larger.
const FASTER: f64 = 2.0;

/// Compresses the bodies of `model`, which must not overlap, in `volume`, m³; `solid`, m³, is
/// what they fill. Gravity, motion of walls, forces between bodies and bonds of the model are put aside.
///
/// # Errors
/// As [`super::simulate`].
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
    let met = press.met(&reading);
    press.rig.set_friction(None);
    if press.rig.left > 0 {
        reading = press.settle(true)?;
    }
    Ok(press.ended(reading, met))
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
    rig: Rig<'a>,
    wanted: &'a Compression,
    volume: f64,
    solid: f64,
    scale: f64,
}

impl<'a> Press<'a> {
    fn new(
        original: &'a Model,
        volume: f64,
        solid: f64,
        wanted: &'a Compression,
        job: &'a Job,
    ) -> Self {
        let mut rig = Rig::new(original, Some(wanted.friction), wanted.steps, job);
        rig.model.gravity = Vec3::zeros();
        rig.set_damping(wanted.damping);
        Self { rig, wanted, volume, solid, scale: 1.0 }
    }

    fn grow(&mut self, factor: f64) {
        let dimension = self.rig.model.dimension.count() as i32;
        for sphere in &mut self.rig.model.spheres {
            sphere.radius *= factor;
            sphere.offset *= factor;
        }
        for body in &mut self.rig.model.bodies {
            body.mass *= factor.powi(dimension);
            body.inertia *= factor.powi(dimension + 2);
        }
        self.scale *= factor;
    }

    fn fraction(&self) -> f64 {
        self.solid * self.scale.powi(self.rig.model.dimension.count() as i32) / self.volume
    }

    /// Runs 300 steps at a time until forces balance. Unless `patient`, it ends sooner where hardly anything
    /// carries load yet, and where the target is far behind.
    fn settle(&mut self, patient: bool) -> Result<Look, DemError> {
        let mut look = Look::default();
        for round in 0..LOOKS {
            if self.rig.left == 0 || self.rig.job.is_cancelled() {
                break;
            }
            look = self.look()?;
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

    fn look(&mut self) -> Result<Look, DemError> {
        let seen = self.rig.advance(CHUNK)?;
        let unbalanced = seen.unbalanced(&self.rig.model);
        let virial = seen.virial(&self.rig.model);
        let bed = seen.bed(&self.rig.model);
        let worst = bed.contacts.iter().fold(0.0_f64, |worst, contact| {
            let (i, j) = (contact.first as usize, contact.second as usize);
            worst.max(-contact.gap / bed.spheres.radii[i].min(bed.spheres.radii[j]))
        });
        Ok(Look {
            stress: virial / (self.rig.model.dimension.count() as f64 * self.volume),
            coordination: if self.wanted.friction > 0.0 { mechanical(&bed) } else { held(&bed) },
            unbalanced,
            worst,
        })
    }

    /// To a porosity: the growth is known beforehand.
    fn reach_porosity(&mut self, porosity: f64) -> Result<Look, DemError> {
        let dimension = self.rig.model.dimension.count() as f64;
        let way = ((1.0 - porosity) / self.fraction()).ln() / dimension;
        let parts = (way.abs() / GROWTH).ceil().max(1.0);
        let mut look = Look::default();
        for _ in 0..parts as usize {
            self.grow((way / parts).exp());
            look = self.settle(false)?;
            if self.rig.left == 0 || self.rig.job.is_cancelled() {
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
        while self.rig.left > 0 && growth.abs() > LEAST && !self.rig.job.is_cancelled() {
            let near = |look: &Look| of(look) >= low && of(look) <= high;
            let mut quiet = 0;
            while near(&look) && quiet < QUIET && self.rig.left > 0 {
                look = self.settle(true)?;
                quiet = if look.unbalanced <= self.wanted.balance { quiet + 1 } else { 0 };
            }
            if near(&look) {
                return Ok(look);
            }
            let before = (self.rig.model.clone(), self.rig.state.clone(), self.scale, look);
            self.grow(1.0 + growth);
            look = self.settle(false)?;
            // Where the target lies between the two states, or beyond both, as a share of the step.
            let share = (target - of(&before.3)) / (of(&look) - of(&before.3));
            let passed = (of(&look) - target) * growth > 0.0;
            if self.wanted.friction > 0.0 {
                if of(&look) > high {
                    growth *= share.clamp(0.1, 0.7);
                    (self.rig.model, self.rig.state, self.scale, look) = before;
                    // The push of larger steps is in their motion, and would jam them by itself.
                    self.rig.state.iter_mut().for_each(zeroing::calm);
                } else {
                    growth = (FASTER * growth).min(GROWTH);
                }
            } else if !near(&look) {
                // Without friction there is no memory: back by what was too much.
                let back = -(1.0 - share.clamp(0.1, 0.9)) * growth;
                growth = if passed { back } else { (FASTER * growth).clamp(-GROWTH, GROWTH) };
            }
        }
        Ok(look)
    }

    /// What was asked for: its name, the number asked for and the one found.
    fn target(&self, look: &Look) -> (&'static str, f64, f64) {
        match self.wanted.until {
            Until::Stress(stress) => ("stress [Pa]", stress.0, look.stress),
            Until::Porosity(asked) => ("porosity", asked, 1.0 - self.fraction()),
            Until::Coordination(number) => ("coordination number", number, look.coordination),
        }
    }

    fn met(&self, look: &Look) -> bool {
        let (_, asked, found) = self.target(look);
        (found / asked - 1.0).abs() <= self.wanted.tolerance * (1.0 + 1e-9)
    }

    /// `before`: whether the target was met before friction became that of the scene.
    fn ended(&self, look: Look, before: bool) -> Compressed {
        let porosity = 1.0 - self.fraction();
        let (what, asked, found) = self.target(&look);
        let near = self.met(&look);
        // Without load there is nothing to balance.
        let rest = look.unbalanced <= self.wanted.balance || look.stress <= 0.0;
        let ended = match (near, rest, self.rig.left) {
            _ if self.rig.job.is_cancelled() => "stopped before the end",
            (true, true, _) => "target met",
            (true, false, _) => "target met, forces not yet in balance",
            (false, ..) if before => {
                "target met while compressed, lost with the friction of the scene"
            }
            (false, _, 0) => "steps used up before the target",
            (false, ..) => "target not met: no state nearer to it was found",
        };
        let steps = self.wanted.steps - self.rig.left;
        Compressed {
            states: self.rig.states(),
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
                self.rig.model.bodies.len(),
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
    use crate::model::{Body, Contact, ContactTable, Dimension, Material, Scheme, Sphere};
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
    fn less_friction_than_that_of_the_preparation_may_undo_it() {
        let (mut model, solid) = discs(30);
        let wanted = Compression {
            until: Until::Stress(crate::num::units::Pressure(50.0)),
            friction: 1.0,
            tolerance: 0.1,
            balance: 0.005,
            steps: 60_000,
            ..Compression::default()
        };
        let done = compress(&model, 1.0, solid, &wanted, &Job::quiet()).expect("runs");
        assert!(!done.met && done.outcome.starts_with("target met while"), "{}", done.outcome);
        let same = Contact { friction: 1.0, ..*model.contacts.between(0, 0) };
        model.contacts = ContactTable::uniform(1, same);
        let done = compress(&model, 1.0, solid, &wanted, &Job::quiet()).expect("runs");
        assert!(done.met && (done.stress / 50.0 - 1.0).abs() < 0.1, "{}", done.outcome);
        assert!((2.5..4.0).contains(&done.coordination), "{}", done.outcome);
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
