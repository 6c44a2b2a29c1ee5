//! Packings made by deposition in the DEM (see [`Deposition`]).
//!
//! The DEM runs 500 steps at a time under the gravity of the model with the friction of the preparation, until at three
//! looks in a row every body touches another or a wall and forces, weights included, balance; then the same with the
//! friction of the scene. Once the fall is over (forces balance to a twentieth), local damping is at least 0.4, so that beds with
//! little friction do not slosh without end.
//!
//! Cost: the time of the fall, some 10 000 to 100 000 steps. What comes back when the steps are used up: the state
//! reached, and the outcome says so.

use super::DemError;
use super::rig::{Rig, Seen};
use crate::geometry::Bounds;
use crate::model::{BodyState, Model};
use crate::num::Job;
use crate::pack::probe::Probe;
use crate::pack::{Bed, Deposition, survey};

/// A packing that has fallen into place.
#[derive(Debug, Clone, PartialEq)]
pub struct Deposited {
    /// Place and orientation of each body, at rest.
    pub states: Vec<BodyState>,
    /// Porosity of the middle of the bed, a fifth of its extent off every side.
    pub porosity: f64,
    /// Mean number of other bodies that each touches.
    pub coordination: f64,
    /// Mean force left over on a body over the mean contact force.
    pub unbalanced: f64,
    /// Steps of the DEM.
    pub steps: u64,
    /// True if all came to rest, with the friction of the scene too.
    pub rest: bool,
    /// How it ended, one clause.
    pub outcome: String,
}

/// Steps between looks.
const CHUNK: u64 = 500;
/// Looks in a row at which forces balance until a state is at rest, and not only passing.
const QUIET: u32 = 3;

/// Balance at which all that is left of the fall is to and fro, and local damping from then on.
const LANDED: (f64, f64) = (0.05, 0.4);

/// Lets the bodies of `model` fall, which must not overlap. Motion of walls, forces between bodies and bonds of the
/// model are put aside.
///
/// # Errors
/// As [`super::simulate`].
pub fn deposit(model: &Model, wanted: &Deposition, job: &Job) -> Result<Deposited, DemError> {
    let mut rig = Rig::new(model, wanted.friction, wanted.steps, job);
    rig.set_damping(wanted.damping);
    let (mut rest, mut seen) = settle(&mut rig, wanted.balance)?;
    let first = wanted.steps - rig.left;
    if rest && wanted.friction.is_some() {
        rig.set_friction(None);
        (rest, seen) = settle(&mut rig, wanted.balance)?;
    }
    let unbalanced = seen.unbalanced(&rig.model);
    let bed = seen.bed(&rig.model);
    let porosity = core(&bed);
    let touched: u32 = bed.partners.iter().sum();
    let coordination = f64::from(touched) / bed.partners.len().max(1) as f64;
    let steps = wanted.steps - rig.left;
    let ended = match rest {
        true => "at rest",
        false if job.is_cancelled() => "stopped before the end",
        false => "steps used up before rest",
    };
    let friction =
        wanted.friction.map_or("that of the scene".to_owned(), |friction| friction.to_string());
    Ok(Deposited {
        states: rig.states(),
        porosity,
        coordination,
        unbalanced,
        steps,
        rest,
        outcome: format!(
            "{ended}: porosity {porosity:.4} in the middle of the bed, coordination number {coordination:.3}, unbalanced {unbalanced:.1e}; {} grains fell in {first} steps \
             of the DEM with friction {friction}, {} more with that of the scene",
            rig.model.bodies.len(),
            steps - first
        ),
    })
}

/// Runs until rest; false where the steps are used up before.
fn settle(rig: &mut Rig<'_>, balance: f64) -> Result<(bool, Seen), DemError> {
    let mut quiet = 0;
    loop {
        let seen = rig.advance(CHUNK)?;
        let lying = seen.floating(&rig.model) == 0;
        let unbalanced = seen.unbalanced(&rig.model);
        if lying && unbalanced <= LANDED.0 && rig.model.local_damping < LANDED.1 {
            rig.set_damping(LANDED.1);
        }
        quiet = if lying && unbalanced <= balance { quiet + 1 } else { 0 };
        if quiet == QUIET || rig.left == 0 || rig.job.is_cancelled() {
            return Ok((quiet == QUIET, seen));
        }
    }
}

/// Porosity of the middle of the bed.
fn core(bed: &Bed) -> f64 {
    let spheres = &bed.spheres;
    let mut around = spheres
        .centres
        .iter()
        .zip(&spheres.radii)
        .fold(Bounds::EMPTY, |bounds, (centre, radius)| {
            bounds.union(&Bounds::of([centre]).grown(*radius))
        });
    let margin = 0.2 * around.size();
    (around.low, around.high) = (around.low + margin, around.high - margin);
    survey::measure(bed, &Probe::Box(around)).porosity
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dem::test_scenes::{RADIUS, add_plane, add_sphere, contact, empty};
    use crate::model::{Motion, Scheme};
    use crate::num::Vec3;

    fn falling() -> Model {
        let mut model = empty(Scheme::Leapfrog, contact(2.0 / 7.0 * 1e5, 5.0, 0.0, 0.6));
        model.gravity = Vec3::new(0.0, 0.0, -9.81);
        add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
        // A pyramid that stands with friction above tan 22.5°, and one ball far off.
        let half = RADIUS * 1.01;
        for (x, y) in [(-half, -half), (half, -half), (half, half), (-half, half), (0.2, 0.0)] {
            add_sphere(
                &mut model,
                Vec3::new(x, y, 1.01 * RADIUS),
                RADIUS,
                Vec3::zeros(),
                Vec3::zeros(),
            );
        }
        add_sphere(
            &mut model,
            Vec3::new(0.0, 0.0, 2.5 * RADIUS),
            RADIUS,
            Vec3::zeros(),
            Vec3::zeros(),
        );
        model
    }

    #[test]
    fn what_falls_comes_to_rest_and_bears_its_weight() {
        let model = falling();
        let done = deposit(&model, &Deposition::default(), &Job::quiet()).expect("runs");
        assert!(done.rest && done.unbalanced <= 1e-3, "{}", done.outcome);
        let weight = model.bodies[4].mass * 9.81;
        let alone = done.states[4].position.z;
        assert!((RADIUS - alone - weight / 1e5).abs() < 1e-3 * weight / 1e5, "{alone}");
        // The one on top lies in the hollow.
        assert!(done.states[5].position.z > 2.0 * RADIUS, "{:?}", done.states[5].position);
    }

    #[test]
    fn without_friction_the_pyramid_falls_apart_and_few_steps_are_said() {
        let model = falling();
        let smooth = Deposition { friction: Some(0.0), ..Deposition::default() };
        let done = deposit(&model, &smooth, &Job::quiet()).expect("runs");
        assert!(done.outcome.contains("friction 0,"), "{}", done.outcome);
        let few = Deposition { steps: 500, ..Deposition::default() };
        let done = deposit(&model, &few, &Job::quiet()).expect("runs");
        assert!(!done.rest && done.outcome.starts_with("steps used up"), "{}", done.outcome);
    }
}
