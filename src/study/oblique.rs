//! Oblique impact of one sphere on a wall, μ = 0.3, e = 0.5, lever arm R − δ/2: error of the
//! outgoing sliding velocity and spin of every scheme over the step, against Runge–Kutta with
//! bisected changes of mode (9 digits). Cost O(angles × phases × steps) a point.

use super::{Effort, StudyError, go_on, models};
use crate::dem;
use crate::model::{Arm, Contact, Model, Motion, Outcome, Scheme, restitution};
use crate::num::statistics::{median, order_of_convergence, root_mean_square};
use crate::num::{Job, Vec3};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::curves::work_precision;
use crate::report::findings::{Findings, Sheet};

const SCHEMES: [Scheme; 4] =
    [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Yade, Scheme::PathAveraged];
/// Radius, m; density, kg/m³; stiffness, N/m.
const RADIUS: f64 = 0.01;
const DENSITY: f64 = 2500.0;
const KN: f64 = 1e5;
/// kt/kn, angle from the normal [degrees], outgoing sliding velocity [m/s] and spin [rad/s] at 1 m/s.
const ROWS: [[f64; 4]; 6] = [
    [2.0 / 7.0, 15.0, 0.121_916_579_362_296_3, 33.914_271_112_695_2],
    [2.0 / 7.0, 45.0, 0.450_508_256_059_977_3, 63.716_700_194_829_414],
    [2.0 / 7.0, 75.0, 0.852_996_862_026_937_7, 28.167_560_183_081_98],
    [0.8, 5.0, 0.052_104_119_629_709_94, 8.672_085_348_835_894],
    [0.8, 30.0, 0.262_227_706_829_757_1, 58.956_663_962_746_02],
    [0.8, 60.0, 0.646_037_942_859_247_5, 54.755_106_386_121_575],
];

/// Adds a table and two charts.
pub fn add(findings: &mut Findings, effort: Effort, job: &Job) -> Result<(), StudyError> {
    let (phases, steps): (u32, &[f64]) = match effort {
        Effort::Quick => (4, &[10.0, 20.0, 50.0, 100.0]),
        Effort::Full => (16, &[5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0]),
    };
    let (mut over_steps, mut over_time, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for scheme in SCHEMES {
        let (mut errors, mut points) = (Vec::new(), Vec::new());
        for &per_contact in steps {
            go_on(job)?;
            let [slide, spin, seconds] = impacts(scheme, per_contact, phases)?;
            errors.push(slide);
            points.push((seconds * per_contact, slide));
            rows.push(vec![
                scheme.key().into(),
                per_contact.into(),
                slide.into(),
                spin.into(),
                seconds.into(),
            ]);
        }
        let inverse: Vec<f64> = steps.iter().map(|n| 1.0 / n).collect();
        let order = order_of_convergence(&inverse, &errors).unwrap_or(f64::NAN);
        findings
            .remarks
            .push(format!("{}, oblique: order {order:.2} of the error in the step.", scheme.key()));
        over_steps.push(Series {
            name: scheme.key().into(),
            points: steps.iter().copied().zip(errors).collect(),
            dots: true,
        });
        over_time.push((scheme.key().to_owned(), points));
    }
    findings.tables.push(Sheet {
        key: "oblique".into(),
        title: "Oblique impact on a wall".into(),
        caption: format!(
            "Root mean square over six impacts (kt/kn 2/7 and 0.8) and {phases} phases."
        ),
        columns: [
            "scheme",
            "steps a contact",
            "error of sliding velocity [m/s]",
            "error of spin times radius [m/s]",
            "CPU a step [s]",
        ]
        .map(String::from)
        .to_vec(),
        rows,
    });
    let chart = Chart {
        title: "Error of the outgoing sliding velocity over the step".into(),
        caption: "Oblique impacts at 1 m/s on a wall, μ = 0.3, e = 0.5.".into(),
        x: Axis::log("steps a contact", ""),
        y: Axis::log("error of sliding velocity (rms)", "m/s"),
        series: over_steps,
        mark: None,
    };
    let time = work_precision(
        "Error of the outgoing sliding velocity over CPU time of a contact",
        &over_time,
        "error of sliding velocity (rms)",
        "m/s",
        None,
    );
    findings.charts.push(("oblique-steps".into(), chart));
    findings.charts.push(("oblique-time".into(), time));
    Ok(())
}

/// Errors of sliding velocity and of spin times radius, and CPU seconds a step.
fn impacts(scheme: Scheme, per_contact: f64, phases: u32) -> Result<[f64; 3], StudyError> {
    let (mut slides, mut spins, mut seconds) = (Vec::new(), Vec::new(), Vec::new());
    for [kt, degrees, slide, spin] in ROWS {
        for phase in 0..phases {
            let phase = (f64::from(phase) + 0.5) / f64::from(phases);
            let model = impact(scheme, kt, degrees, per_contact, phase);
            let run = dem::run(&model, &Job::quiet())
                .map_err(|error| StudyError::Work(error.to_string()))?;
            let last = run.frames.last().filter(|_| run.outcome == Outcome::Finished);
            let Some(frame) = last else {
                return Err(StudyError::Work(format!("an impact ended early: {:?}", run.outcome)));
            };
            slides.push(frame.velocities[0].x - slide);
            spins.push((frame.spins[0].y - spin) * RADIUS);
            let looped = run.cost.loop_seconds.unwrap_or(run.cost.wall_seconds);
            seconds.push(looped / run.cost.steps as f64);
        }
    }
    // No list is empty: every study has phases.
    Ok([root_mean_square(&slides), root_mean_square(&spins), median(&seconds)]
        .map(|value| value.unwrap_or(f64::NAN)))
}

fn impact(scheme: Scheme, kt: f64, degrees: f64, per_contact: f64, phase: f64) -> Model {
    let mass = DENSITY * std::f64::consts::PI * 4.0 / 3.0 * RADIUS.powi(3);
    // A restitution between 0 and 1 always has a dashpot.
    let cn = restitution::dashpot(0.5, KN, mass, false).unwrap_or(0.0);
    let contact = Contact { kn: KN, kt: kt * KN, cn, ct: 0.0, friction: 0.3 };
    let mut model = models::empty(scheme, contact, DENSITY);
    model.plan.law.plane_arm = Arm::Half;
    model.plan.step = std::f64::consts::PI * (mass / KN).sqrt() / per_contact;
    model.plan.steps = (2.0 * per_contact) as u64;
    // The error of coarse steps is what is asked for.
    model.plan.insist = true;
    let angle = degrees.to_radians();
    let velocity = Vec3::new(angle.sin(), 0.0, -angle.cos());
    models::plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    let height = RADIUS + model.plan.step * phase * angle.cos();
    models::sphere(&mut model, Vec3::z() * height, RADIUS, DENSITY, velocity);
    model
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scheme_comes_to_the_reference() {
        for scheme in SCHEMES {
            let [slide, spin, _] = impacts(scheme, 500.0, 1).expect("it runs");
            assert!(slide < 1e-3 && spin < 2e-3, "{scheme:?} {slide} {spin}");
        }
    }
}
