//! Where a settled bed becomes unstable, against the step bound of its contact network.
//!
//! Spheres of ±10 % radii settle in a box; then the bed runs on from rest at multiples of
//! the bound, with the plan insisting. Below the true limit the kinetic energy dies out or
//! stays; above it the fastest modes grow until contacts open, and the guard notes that
//! forces change sign in every step. The bound is at least 0.9 of the true limit and never above
//! it, so growth has to begin between 1.0 and 1.1. Cost O(spheres × steps) a run.

use super::{Effort, StudyError, go_on, models};
use crate::dem;
use crate::model::{Contact, ContactTable, Model, Motion, Outcome, Run, Scheme, restitution};
use crate::num::{Job, Vec3, random};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::findings::{Cell, Findings, Sheet};

/// Radius, m; density, kg/m³; stiffness, N/m.
const RADIUS: f64 = 0.01;
const DENSITY: f64 = 2500.0;
const KN: f64 = 1e5;
/// Multiples of the bound.
const FACTORS: [f64; 8] = [0.8, 0.9, 1.0, 1.05, 1.1, 1.2, 1.35, 1.5];

/// See [`super::STUDIES`].
pub fn study(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    let (side, layers, steps) = match effort {
        Effort::Quick => (4, 5, 1500),
        Effort::Full => (6, 12, 4000),
    };
    let bed = settled(side, layers)?;
    let mass = DENSITY * std::f64::consts::PI * 4.0 / 3.0 * RADIUS.powi(3);
    let unit = (mass / KN).sqrt();
    let dashpot = restitution::dashpot(0.5, KN, 0.5 * mass, false).unwrap_or(0.0);
    let (mut rows, mut series, mut remarks) = (Vec::new(), Vec::new(), Vec::new());
    for scheme in [Scheme::Leapfrog, Scheme::PathAveraged] {
        for (kt, cn) in [(2.0 / 7.0, 0.0), (2.0 / 7.0, dashpot), (1.0, 0.0), (1.0, dashpot)] {
            go_on(job)?;
            let mut model = bed.clone();
            let contact = Contact { kn: KN, kt: kt * KN, cn, ct: 0.0, friction: 0.5 };
            model.contacts = ContactTable::uniform(1, contact);
            (model.plan.scheme, model.plan.law) = (scheme, scheme.law());
            let bound = dem::advise(&model).network;
            let bound =
                bound.ok_or(StudyError::Work("nothing touches in the settled bed".into()))?;
            let found = over_the_bound(&model, bound, steps, job)?;
            for at in &found {
                rows.push(vec![
                    scheme.key().into(),
                    kt.into(),
                    cn.into(),
                    at.factor.into(),
                    (at.factor * bound / unit).into(),
                    at.late_energy.into(),
                    if at.told { "unstable" } else { "" }.into(),
                ]);
            }
            let dashpots = if cn > 0.0 { "e 0.5" } else { "no dashpot" };
            let name = format!("{}, kt/kn {kt:.2}, {dashpots}", scheme.key());
            remarks.push(match found.iter().find(|at| at.told) {
                Some(Onward { factor, .. }) => {
                    format!("{name}: the guard calls it unstable from {factor} times the bound on.")
                }
                None => format!("{name}: the guard finds nothing up to 1.5 times the bound."),
            });
            let points = found.iter().map(|at| (at.factor, at.late_energy)).collect();
            series.push(Series { name, points, dots: true });
        }
    }
    Ok(Findings {
        title: "Step limit of a settled bed".into(),
        question: format!(
            "{} spheres of ±10 % radii at rest in a box: at which multiple of the bound of their \
             contact network does the run become unstable, and does the guard see it?",
            bed.bodies.len()
        ),
        remarks,
        tables: vec![sheet(steps, rows)],
        charts: vec![("onset".into(), chart(series))],
        pictures: Vec::new(),
    })
}

fn sheet(steps: u64, rows: Vec<Vec<Cell>>) -> Sheet {
    let columns = [
        "scheme",
        "kt/kn",
        "cn [N s/m]",
        "step over bound",
        "step over √(m/kn)",
        "kinetic energy [J]",
        "guard",
    ];
    Sheet {
        key: "onset".into(),
        title: "Kinetic energy after many steps from rest".into(),
        caption: format!(
            "{steps} steps; largest kinetic energy of the last third. Steps in √(m/kn) of the mean mass."
        ),
        columns: columns.map(String::from).to_vec(),
        rows,
    }
}

fn chart(series: Vec<Series>) -> Chart {
    Chart {
        title: "Kinetic energy of a bed that should rest".into(),
        caption: "Largest of the last third of the run.".into(),
        x: Axis::linear("step over the bound of the network", ""),
        y: Axis::log("kinetic energy", "J"),
        series,
        mark: None,
    }
}

/// The bed at one multiple of the bound.
struct Onward {
    factor: f64,
    /// Largest kinetic energy of the last third, J.
    late_energy: f64,
    /// The guard calls it unstable.
    told: bool,
}

/// The bed run on at every multiple of `bound` [s].
fn over_the_bound(
    model: &Model,
    bound: f64,
    steps: u64,
    job: &Job,
) -> Result<Vec<Onward>, StudyError> {
    let at = |factor: f64| {
        go_on(job)?;
        let run = onward(model, factor * bound, steps)?;
        let told = run.notes.iter().any(|note| note.contains("change sign"));
        Ok(Onward { factor, late_energy: late_energy(&run), told })
    };
    FACTORS.into_iter().map(at).collect()
}

fn late_energy(run: &Run) -> f64 {
    let from = run.series.len() * 2 / 3;
    run.series[from..].iter().map(|row| row.kinetic).fold(1e-30, f64::max)
}

fn onward(model: &Model, step: f64, steps: u64) -> Result<Run, StudyError> {
    let mut model = model.clone();
    (model.plan.step, model.plan.steps, model.plan.insist) = (step, steps, true);
    model.plan.series_every = (steps / 60).max(1);
    (model.plan.guard.gain, model.plan.guard.overlap) = (0.0, 0.0);
    dem::run(&model, &Job::quiet()).map_err(|error| StudyError::Work(error.to_string()))
}

/// A bed at rest in a box.
fn settled(side: u32, layers: u32) -> Result<Model, StudyError> {
    let mass = DENSITY * std::f64::consts::PI * 4.0 / 3.0 * RADIUS.powi(3);
    let cn = restitution::dashpot(0.3, KN, 0.5 * mass, false).unwrap_or(0.0);
    let contact = Contact { kn: KN, kt: 2.0 / 7.0 * KN, cn, ct: 0.0, friction: 0.3 };
    let mut model = models::empty(Scheme::Leapfrog, contact, DENSITY);
    model.gravity = Vec3::z() * -9.81;
    let width = 2.25 * RADIUS * f64::from(side);
    models::plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    for axis in [Vec3::x(), Vec3::y()] {
        models::plane(&mut model, Vec3::zeros(), axis, Motion::Still);
        models::plane(&mut model, axis * width, -axis, Motion::Still);
    }
    let mut source = random::stream(1, "bed", 0);
    for i in 0..side * side * layers {
        let [x, y, z] = [i % side, i / side % side, i / side / side].map(f64::from);
        let jitter = Vec3::from_fn(|_, _| random::uniform(&mut source, -0.02, 0.02));
        let radius = RADIUS * random::uniform(&mut source, 0.9, 1.1);
        let place = ((Vec3::new(x, y, z) + Vec3::repeat(0.5)) * 2.25 + jitter) * RADIUS;
        models::sphere(&mut model, place, radius, DENSITY, jitter * 10.0);
    }
    model.local_damping = 0.1;
    model.plan.step = std::f64::consts::PI * (0.5 * mass / KN).sqrt() / 15.0;
    model.plan.steps = (0.6 / model.plan.step) as u64;
    let run =
        dem::run(&model, &Job::quiet()).map_err(|error| StudyError::Work(error.to_string()))?;
    let (Outcome::Finished, Some(frame)) = (&run.outcome, run.frames.last()) else {
        return Err(StudyError::Work(format!("the bed did not settle: {:?}", run.outcome)));
    };
    for (body, state) in model.bodies.iter_mut().zip(&frame.bodies) {
        body.position = state.position;
        (body.velocity, body.spin) = (Vec3::zeros(), Vec3::zeros());
    }
    model.local_damping = 0.0;
    Ok(model)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_bed_is_quiet_at_its_bound_and_wild_well_above() {
        let bed = settled(2, 3).expect("it settles");
        let bound = dem::advise(&bed).network.expect("contacts");
        let quiet = onward(&bed, bound, 600).expect("runs");
        let wild = onward(&bed, 1.4 * bound, 600).expect("runs");
        assert!(!quiet.notes.iter().any(|note| note.contains("change sign")), "{:?}", quiet.notes);
        assert!(late_energy(&wild) > 100.0 * late_energy(&quiet));
    }
}
