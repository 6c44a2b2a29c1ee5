//! Restitution of one sphere on a wall, every scheme over steps from tc/5 to
//! tc/500, against the closed form of the clipped law (Schwager & Pöschel 2007).
//!
//! The error is the root mean square over phases of arrival: how far into a step
//! the contact begins. Cost O(phases × steps) a point.

use super::impact::{RESTITUTION, SPEED, impact};
use super::{Effort, StudyError, go_on, oblique, outside};
use crate::dem;
use crate::model::{Outcome, Scheme};
use crate::num::Job;
use crate::num::statistics::{median, order_of_convergence, root_mean_square};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::curves::work_precision;
use crate::report::findings::{Findings, Sheet};

const SCHEMES: [Scheme; 4] =
    [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Yade, Scheme::PathAveraged];
/// See [`super::STUDIES`].
pub fn study(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    let (phases, steps): (u32, &[f64]) = match effort {
        Effort::Quick => (16, &[5.0, 10.0, 20.0, 50.0, 100.0]),
        Effort::Full => (64, &[5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0]),
    };
    let mut sheet = Sheet {
        key: "restitution".into(),
        title: "Restitution of one sphere on a wall".into(),
        caption: format!(
            "Root mean square over {phases} phases of arrival; asked for {RESTITUTION}."
        ),
        columns: ["scheme", "steps a contact", "error of restitution", "CPU a step [s]"]
            .map(String::from)
            .to_vec(),
        rows: Vec::new(),
    };
    let (mut over_steps, mut over_time, mut remarks) = (Vec::new(), Vec::new(), Vec::new());
    for scheme in SCHEMES {
        let (mut errors, mut points) = (Vec::new(), Vec::new());
        for &per_contact in steps {
            go_on(job)?;
            let (error, seconds) = impacts(scheme, per_contact, phases)?;
            errors.push(error);
            points.push((seconds * per_contact, error));
            sheet.rows.push(vec![
                scheme.key().into(),
                per_contact.into(),
                error.into(),
                seconds.into(),
            ]);
        }
        let inverse: Vec<f64> = steps.iter().map(|n| 1.0 / n).collect();
        let order = order_of_convergence(&inverse, &errors).unwrap_or(f64::NAN);
        remarks.push(format!("{}: order {order:.2} of the error in the step.", scheme.key()));
        over_steps.push(Series {
            name: scheme.key().into(),
            points: steps.iter().copied().zip(errors).collect(),
            dots: true,
        });
        over_time.push((scheme.key().to_owned(), points));
    }
    let chart = Chart {
        title: "Error of restitution over the step".into(),
        caption:
            "One sphere on a wall, clipped law, e = 0.5; closed form of Schwager & Pöschel 2007."
                .into(),
        x: Axis::log("steps a contact", ""),
        y: Axis::log("error of restitution (rms)", ""),
        series: over_steps,
        mark: None,
    };
    let time = work_precision(
        "Error of restitution over CPU time of a contact",
        &over_time,
        "error of restitution (rms)",
        "",
        None,
    );
    let mut findings = Findings {
        title: "Contact: error against run time".into(),
        question: "How far is the rebound of a sphere from the closed form, for every scheme, at which step and cost?".into(),
        remarks,
        tables: vec![sheet],
        charts: vec![("restitution-steps".into(), chart), ("restitution-time".into(), time)],
        pictures: Vec::new(),
    };
    outside::add(&mut findings, effort, job)?;
    oblique::add(&mut findings, effort, job)?;
    Ok(findings)
}

/// Error of restitution (rms over phases) and CPU seconds a step.
fn impacts(scheme: Scheme, per_contact: f64, phases: u32) -> Result<(f64, f64), StudyError> {
    let (mut errors, mut seconds) = (Vec::new(), Vec::new());
    for phase in 0..phases {
        let model = impact(scheme, per_contact, (f64::from(phase) + 0.5) / f64::from(phases));
        let run =
            dem::run(&model, &Job::quiet()).map_err(|error| StudyError::Work(error.to_string()))?;
        let last = run.frames.last().filter(|_| run.outcome == Outcome::Finished);
        let Some(frame) = last else {
            return Err(StudyError::Work(format!("an impact ended early: {:?}", run.outcome)));
        };
        errors.push(frame.velocities[0].z / SPEED - RESTITUTION);
        let looped = run.cost.loop_seconds.unwrap_or(run.cost.wall_seconds);
        seconds.push(looped / run.cost.steps as f64);
    }
    // Neither list is empty: every study has phases.
    Ok((root_mean_square(&errors).unwrap_or(f64::NAN), median(&seconds).unwrap_or(f64::NAN)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_averaged_scheme_is_better_at_ten_steps_than_leapfrog_at_a_hundred() {
        let error = |scheme, n| impacts(scheme, n, 4).expect("it runs").0;
        assert!(error(Scheme::PathAveraged, 10.0) < error(Scheme::Leapfrog, 100.0));
    }
}
