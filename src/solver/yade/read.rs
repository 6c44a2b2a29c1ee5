//! Reads back what the YADE deck wrote: frames, the last contacts, the loop time.

use crate::model::{BodyState, Frame, Model, Run, Touch};
use crate::num::{Rotation, Vec3};
use crate::solver::process::Ended;
use crate::solver::reading::{self, Read, vector};
use crate::solver::{Deck, SolverError};
use nalgebra::Quaternion;

/// Files that a run writes.
pub const OUTPUTS: &[&str] = &["frames.txt", "contacts.txt"];

/// Step number of a line "riprap step N".
pub fn step_of(line: &str) -> Option<u64> {
    line.strip_prefix("riprap step ")?.trim().parse().ok()
}

/// Everything of one run.
pub fn run(
    solver: &'static str,
    model: &Model,
    deck: &Deck,
    ended: &Ended,
) -> Result<Run, SolverError> {
    let path = deck.folder.join("frames.txt");
    let frames = if path.exists() {
        frames(model, &reading::text(&path)?, ended.success)
            .map_err(|problem| SolverError::output(&path, problem))?
    } else {
        Vec::new()
    };
    let touches = match frames.last() {
        Some(last) if last.step == model.plan.steps && ended.success => {
            let path = deck.folder.join("contacts.txt");
            Some(
                contacts(model.spheres.len(), &reading::text(&path)?)
                    .map_err(|problem| SolverError::output(&path, problem))?,
            )
        }
        _ => None,
    };
    let notes =
        vec!["forces on spheres are contact forces, of the positions one step before".to_owned()];
    let read = Read { frames, touches, loop_seconds: loop_seconds(ended), notes };
    reading::run(solver, model, deck, ended, read)
}

/// "riprap loop wall 0.5 s cpu 0.5 s peak 123 KiB".
fn loop_seconds(ended: &Ended) -> Option<f64> {
    ended.line_with("riprap loop wall")?.split_whitespace().nth(3)?.parse().ok()
}

/// All frames; one that is cut short at the end is an error only after a run that ended well.
fn frames(model: &Model, text: &str, whole: bool) -> Result<Vec<Frame>, String> {
    let mut frames: Vec<Frame> = Vec::new();
    // Turns YADE's axes of a clump (its own choice) into the body frame.
    let mut to_body: Vec<Rotation> = Vec::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        let step = line.strip_prefix("frame ").and_then(|s| s.trim().parse().ok());
        let step = step.ok_or_else(|| format!("`{line}` where a frame should start"))?;
        match frame(model, step, &mut lines, &mut to_body) {
            Ok(frame) => frames.push(frame),
            Err(_) if !whole && lines.peek().is_none() => break,
            Err(problem) => return Err(format!("step {step}: {problem}")),
        }
    }
    Ok(frames)
}

fn frame<'a>(
    model: &Model,
    step: u64,
    lines: &mut impl Iterator<Item = &'a str>,
    to_body: &mut Vec<Rotation>,
) -> Result<Frame, String> {
    let count = model.spheres.len();
    let spins = model.needs().rotation;
    let mut frame = Frame {
        step,
        time: step as f64 * model.plan.step,
        centres: Vec::with_capacity(count),
        velocities: Vec::with_capacity(count),
        spins: Vec::with_capacity(count),
        forces: Vec::with_capacity(count),
        bodies: Vec::with_capacity(model.bodies.len()),
    };
    let width = if spins { 12 } else { 9 };
    for _ in 0..count {
        let row = numbers(lines, width)?;
        frame.centres.push(vector(&row, 0));
        frame.velocities.push(vector(&row, 3));
        frame.spins.push(if spins { vector(&row, 6) } else { Vec3::zeros() });
        frame.forces.push(vector(&row, width - 3));
    }
    let mut clump = 0;
    for body in &model.bodies {
        let first = body.first_sphere as usize;
        if body.sphere_count == 1 {
            frame.bodies.push(BodyState {
                position: frame.centres[first],
                orientation: body.orientation,
                velocity: frame.velocities[first],
                spin: frame.spins[first],
            });
            continue;
        }
        let row = numbers(lines, 13)?;
        let turn = Rotation::new_normalize(Quaternion::new(row[3], row[4], row[5], row[6]));
        if to_body.len() == clump {
            to_body.push(turn.inverse() * body.orientation);
        }
        frame.bodies.push(BodyState {
            position: vector(&row, 0),
            orientation: turn * to_body[clump],
            velocity: vector(&row, 7),
            spin: vector(&row, 10),
        });
        clump += 1;
    }
    Ok(frame)
}

fn numbers<'a>(
    lines: &mut impl Iterator<Item = &'a str>,
    width: usize,
) -> Result<Vec<f64>, String> {
    let line = lines.next().ok_or("the last frame is cut short")?;
    let row: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
    let row = row.map_err(|_| format!("`{line}` holds something that is no number"))?;
    if row.len() != width {
        return Err(format!("`{line}` has {} numbers, not {width}", row.len()));
    }
    Ok(row)
}

/// Rows "index index normal tangential".
fn contacts(spheres: usize, text: &str) -> Result<Vec<Touch>, String> {
    let mut touches = Vec::new();
    for line in text.lines() {
        let row = numbers(&mut std::iter::once(line), 4)?;
        let (a, b) = (row[0] as usize, row[1] as usize);
        if a >= spheres || b >= spheres || a == b {
            return Err(format!("`{line}` is no contact of two of {spheres} spheres"));
        }
        touches.push(Touch {
            first: a.min(b) as u32,
            second: a.max(b) as u32,
            normal: row[2],
            tangential: row[3],
        });
    }
    touches.sort_by_key(|touch| (touch.first, touch.second));
    Ok(touches)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::deck::examples;

    fn row(width: usize) -> String {
        vec!["0.25"; width].join(" ")
    }

    #[test]
    fn frames_are_read_and_counted() {
        let model = examples::two_spheres();
        let width = if model.needs().rotation { 12 } else { 9 };
        let whole = format!("frame 0\n{0}\n{0}\nframe 7\n{0}\n{0}\n", row(width));
        let read = frames(&model, &whole, true).expect("whole");
        assert_eq!(read.iter().map(|f| f.step).collect::<Vec<_>>(), [0, 7]);
        let cut = format!("frame 0\n{0}\n{0}\nframe 7\n{0}\n", row(width));
        assert!(frames(&model, &cut, true).is_err());
        assert_eq!(frames(&model, &cut, false).expect("first is whole").len(), 1);
        let wide = format!("frame 0\n{0}\n{0}\n", row(width + 1));
        assert!(frames(&model, &wide, true).is_err());
    }

    #[test]
    fn contacts_are_put_in_order() {
        let read = contacts(3, "2 1 3.5 0.5\n0 1 1 0\n").expect("two contacts");
        assert_eq!(read[0], Touch { first: 0, second: 1, normal: 1.0, tangential: 0.0 });
        assert_eq!((read[1].first, read[1].second), (1, 2));
        assert!(contacts(2, "2 1 3.5 0.5\n").is_err());
        assert!(contacts(3, "1 2 x 0.5\n").is_err());
    }
}
