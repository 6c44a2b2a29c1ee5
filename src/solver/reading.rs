//! From frames that a solver wrote to a `Run`: checks that are the same for all.

use super::process::Ended;
use super::{Deck, SolverError};
use crate::model::{Cost, Frame, Model, Outcome, Run, Touch};
use crate::num::Vec3;
use std::path::Path;

/// What was read from the files of one run.
pub struct Read {
    /// Frames in rising steps.
    pub frames: Vec<Frame>,
    /// Contacts in the last frame, where they could be read.
    pub touches: Option<Vec<Touch>>,
    /// Wall-clock seconds of the time loop, as the solver says.
    pub loop_seconds: Option<f64>,
    /// What to say about the reading.
    pub notes: Vec<String>,
}

/// Joins what was read with how the solver ended.
pub fn run(
    solver: &'static str,
    model: &Model,
    deck: &Deck,
    ended: &Ended,
    mut read: Read,
) -> Result<Run, SolverError> {
    if read.frames.is_empty() && !ended.cancelled {
        return Err(SolverError::Solver {
            solver,
            status: ended.status.clone(),
            tail: ended.last_lines(12),
        });
    }
    let mut notes: Vec<String> = deck.limits.iter().map(|limit| limit.what.clone()).collect();
    notes.append(&mut read.notes);
    read.frames.iter_mut().for_each(|frame| frame.bring_home(model));
    let broken = keep_finite(&mut read.frames);
    let last = read.frames.last().map_or(0, |frame| frame.step);
    let outcome = if let Some((step, sphere)) = broken {
        read.touches = None;
        Outcome::Stopped {
            step,
            time: step as f64 * model.plan.step,
            reason: format!("sphere {sphere} is no longer at a finite place; use a smaller step"),
        }
    } else if ended.cancelled {
        Outcome::Cancelled { step: last }
    } else if !ended.success || last != model.plan.steps {
        Outcome::Failed { reason: format!("{}\n{}", ended.status, ended.last_lines(12)) }
    } else {
        Outcome::Finished
    };
    notes.extend(outside(model, &read.frames));
    if ended.cpu_seconds.is_none() {
        notes.push("CPU time could not be read on this system; wall-clock time stands in".into());
    }
    let cost = Cost {
        cpu_seconds: ended.cpu_seconds.unwrap_or(ended.wall_seconds),
        wall_seconds: ended.wall_seconds,
        loop_seconds: read.loop_seconds,
        steps: last,
        sphere_steps: last * model.spheres.len() as u64,
        peak_bytes: ended.peak_bytes,
    };
    Ok(Run {
        solver: solver.to_owned(),
        outcome,
        frames: read.frames,
        breaks: None,
        springs: Vec::new(),
        touches: read.touches,
        series: Vec::new(),
        cost,
        notes,
    })
}

/// Cuts `frames` before the first one that holds a number that is not finite;
/// its step and sphere come back.
fn keep_finite(frames: &mut Vec<Frame>) -> Option<(u64, usize)> {
    let finite = |v: &Vec3| v.iter().all(|c| c.is_finite());
    let bad = frames.iter().enumerate().find_map(|(index, frame)| {
        let sphere = (0..frame.centres.len()).find(|&i| {
            !(finite(&frame.centres[i])
                && finite(&frame.velocities[i])
                && finite(&frame.spins[i])
                && finite(&frame.forces[i]))
        })?;
        Some((index, frame.step, sphere))
    });
    let (index, step, sphere) = bad?;
    frames.truncate(index);
    Some((step, sphere))
}

/// A note about spheres that are outside the domain in some frame.
fn outside(model: &Model, frames: &[Frame]) -> Option<String> {
    frames.iter().find_map(|frame| {
        let is_out = |c: &Vec3| model.is_outside(c);
        let out: Vec<usize> =
            (0..frame.centres.len()).filter(|&i| is_out(&frame.centres[i])).collect();
        let first = *out.first()?;
        Some(format!(
            "{} spheres are outside the domain at {} s, sphere {first} (body {}) first",
            out.len(),
            frame.time,
            model.spheres[first].body
        ))
    })
}

/// The text of a file.
pub fn text(path: &Path) -> Result<String, SolverError> {
    std::fs::read_to_string(path).map_err(SolverError::io(path))
}

/// A vector from three neighbouring numbers.
pub fn vector(row: &[f64], at: usize) -> Vec3 {
    Vec3::new(row[at], row[at + 1], row[at + 2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::deck::examples;

    fn frame(model: &Model, step: u64) -> Frame {
        let states = model.initial_states();
        let count = model.spheres.len();
        Frame {
            step,
            time: step as f64 * model.plan.step,
            centres: model.sphere_centres(&states),
            velocities: vec![Vec3::zeros(); count],
            spins: vec![Vec3::zeros(); count],
            forces: vec![Vec3::zeros(); count],
            bodies: states,
        }
    }

    fn ended(success: bool, cancelled: bool) -> Ended {
        Ended {
            success,
            cancelled,
            status: "exit status: 1".into(),
            tail: vec!["ERROR: Lost atoms".into()],
            cpu_seconds: Some(1.5),
            wall_seconds: 2.0,
            peak_bytes: None,
        }
    }

    fn joined(frames: Vec<Frame>, ended: &Ended) -> Result<Run, SolverError> {
        let model = examples::two_spheres();
        let deck =
            Deck { folder: "nowhere".into(), files: Vec::new(), ranks: 1, limits: Vec::new() };
        let read =
            Read { frames, touches: Some(Vec::new()), loop_seconds: Some(1.0), notes: Vec::new() };
        run("test", &model, &deck, ended, read)
    }

    #[test]
    fn outcomes_follow_the_frames_and_the_exit() {
        let model = examples::two_spheres();
        let (first, last) = (frame(&model, 0), frame(&model, model.plan.steps));
        let outcome = |frames: &[&Frame], ended: &Ended| {
            joined(frames.iter().map(|f| (*f).clone()).collect(), ended).map(|run| run.outcome)
        };
        let good = ended(true, false);
        assert!(matches!(outcome(&[&first, &last], &good), Ok(Outcome::Finished)));
        // A solver that says all is well and stopped early did not finish.
        assert!(matches!(outcome(&[&first], &good), Ok(Outcome::Failed { .. })));
        let lost = outcome(&[&first], &ended(false, false));
        assert!(matches!(lost, Ok(Outcome::Failed { reason }) if reason.contains("Lost atoms")));
        let stopped = outcome(&[&first], &ended(false, true));
        assert!(matches!(stopped, Ok(Outcome::Cancelled { step: 0 })));
        assert!(matches!(outcome(&[], &ended(false, false)), Err(SolverError::Solver { .. })));
    }

    #[test]
    fn nothing_that_is_not_finite_comes_through() {
        let model = examples::two_spheres();
        let (first, mut last) = (frame(&model, 0), frame(&model, model.plan.steps));
        last.velocities[1].y = f64::NAN;
        let run = joined(vec![first, last], &ended(true, false)).expect("an outcome");
        let Outcome::Stopped { step, reason, .. } = run.outcome else {
            panic!("{:?}", run.outcome)
        };
        assert_eq!(step, model.plan.steps);
        assert!(reason.contains("sphere 1"), "{reason}");
        assert_eq!(run.frames.len(), 1);
        assert_eq!(run.touches, None);
    }

    #[test]
    fn spheres_outside_the_domain_are_told() {
        let model = examples::two_spheres();
        let mut last = frame(&model, model.plan.steps);
        last.centres[1].z = 1.0;
        let run = joined(vec![last], &ended(true, false)).expect("an outcome");
        assert!(run.notes.iter().any(|note| note.contains("sphere 1 (body 1)")), "{:?}", run.notes);
    }
}
