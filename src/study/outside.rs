//! The impacts of [`super::contact`] in the outside solvers that are installed: all phases
//! of arrival as spheres side by side in one run. CPU time is that of the whole process,
//! start included, over the number of phases.

use super::impact::{RESTITUTION, SPEED, impact};
use super::{Effort, StudyError, go_on};
use crate::model::{Model, Scheme};
use crate::num::Job;
use crate::num::statistics::root_mean_square;
use crate::report::findings::{Findings, Sheet};
use crate::solver::{self, DeckOptions};

/// Adds a table and the solvers' curves to the charts of the restitution; nothing where no
/// solver is installed.
pub fn add(findings: &mut Findings, effort: Effort, job: &Job) -> Result<(), StudyError> {
    let steps: &[f64] = match effort {
        Effort::Quick => &[10.0, 100.0],
        Effort::Full => &[10.0, 20.0, 50.0, 100.0, 200.0, 500.0],
    };
    let mut rows = Vec::new();
    for solver in solver::all() {
        let Some(found) = solver.find() else {
            findings.remarks.push(format!("{} is not installed: left out.", solver.name()));
            continue;
        };
        let mut points = Vec::new();
        for &per_contact in steps {
            go_on(job)?;
            let model = side_by_side(per_contact, 16);
            let name =
                format!("riprap-study-{}-{}-{per_contact}", std::process::id(), solver.key());
            let folder = std::env::temp_dir().join(name);
            let done = solver
                .write(&model, &folder, &DeckOptions::default())
                .and_then(|deck| solver.run(&model, &deck, &Job::quiet()));
            // Nothing of the deck is needed any more; what cannot be removed does no harm.
            let _ = std::fs::remove_dir_all(&folder);
            let run = done.map_err(|error| StudyError::Work(error.to_string()))?;
            let Some(frame) = run.frames.last() else {
                return Err(StudyError::Work(format!("{} gave no frame", solver.name())));
            };
            let errors: Vec<f64> =
                frame.velocities.iter().map(|v| v.z / SPEED - RESTITUTION).collect();
            let error = root_mean_square(&errors).unwrap_or(f64::NAN);
            let seconds = run.cost.cpu_seconds / errors.len() as f64;
            points.push((seconds, error));
            rows.push(vec![
                found.version.as_str().into(),
                per_contact.into(),
                error.into(),
                seconds.into(),
            ]);
        }
        for (name, chart) in &mut findings.charts {
            let over_steps = name == "restitution-steps";
            if over_steps || name == "restitution-time" {
                chart.series.push(crate::report::chart::Series {
                    name: solver.name().into(),
                    points: match over_steps {
                        true => steps.iter().zip(&points).map(|(n, point)| (*n, point.1)).collect(),
                        false => points.clone(),
                    },
                    dots: true,
                });
            }
        }
    }
    if !rows.is_empty() {
        findings.tables.push(Sheet {
            key: "restitution-outside".into(),
            title: "The same impacts in the outside solvers".into(),
            caption: "16 phases in one run; CPU time of the whole process, start included.".into(),
            columns: ["solver", "steps a contact", "error of restitution", "CPU a contact [s]"]
                .map(String::from)
                .to_vec(),
            rows,
        });
    }
    Ok(())
}

/// Impacts at many phases of arrival, five diameters apart.
fn side_by_side(per_contact: f64, phases: u32) -> Model {
    let mut all = impact(Scheme::Leapfrog, per_contact, 0.5 / f64::from(phases));
    for phase in 1..phases {
        let one =
            impact(Scheme::Leapfrog, per_contact, (f64::from(phase) + 0.5) / f64::from(phases));
        let index = all.bodies.len() as u32;
        let (mut body, mut sphere) = (one.bodies[0].clone(), one.spheres[0]);
        let across = 10.0 * sphere.radius;
        body.position.x = across * f64::from(phase % 4);
        body.position.y = across * f64::from(phase / 4);
        (body.first_sphere, sphere.body) = (index, index);
        all.bodies.push(body);
        all.spheres.push(sphere);
    }
    all.plan.frame_every = all.plan.steps;
    all.plan.series_every = all.plan.steps;
    all
}
