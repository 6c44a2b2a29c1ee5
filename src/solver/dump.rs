//! Reads dumps of LAMMPS and LIGGGHTS: all spheres at some steps, contacts at the
//! last one, and what the log says of steps and times.
//!
//! Atoms beyond the spheres of the model are points of mass of clumps; states of clumps come
//! from the places of their spheres and points by least squares.

use super::process::Ended;
use super::reading::{self, vector};
use super::{Deck, SolverError, orientation};
use crate::model::{BodyState, Frame, Lost, Model, Touch};
use crate::num::Vec3;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::path::Path;

/// Step number of a thermo line: three numbers, the first two whole (step, atoms, another).
pub fn step_of(line: &str) -> Option<u64> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [step, atoms, energy] = words.as_slice() else { return None };
    atoms.parse::<u64>().ok()?;
    energy.parse::<f64>().ok()?;
    step.parse().ok()
}

/// Points of mass of the deck: body, place in its frame.
pub type Points = BTreeMap<usize, Vec3>;

/// Places in the body frame of the spheres of a clump, and of its point where it has one.
pub fn offsets(model: &Model, points: &Points, body: usize) -> Vec<Vec3> {
    let spheres = model.spheres_of(body).iter().map(|sphere| sphere.offset);
    spheres.chain(points.get(&body).copied()).collect()
}

/// Frames of the dumps `names` in the folder of a deck; those of the first name decide
/// where messages point. `order` is the sphere that every atom is, empty where they are in order.
pub fn spheres(
    model: &Model,
    points: &Points,
    order: &[u32],
    deck: &Deck,
    ended: &Ended,
    names: [&str; 2],
) -> Result<Vec<Frame>, SolverError> {
    let mut blocks = BTreeMap::new();
    for name in names {
        let path = deck.folder.join(name);
        if path.exists() {
            for mut block in parse(&reading::text(&path)?, &path, ended.success)? {
                block.renumber(order);
                blocks.insert(block.step, block);
            }
        }
    }
    frames(model, points, blocks, &deck.folder.join(names[0]))
}

/// "Loop time of 0.0123 on 1 procs for 100 steps with 2 atoms".
pub fn loop_seconds(ended: &Ended) -> Option<f64> {
    let line = ended.line_with("Loop time of")?;
    line.split_whitespace().nth(3)?.parse().ok()
}

/// One snapshot of a dump.
#[derive(Debug, PartialEq)]
struct Block {
    step: u64,
    rows: Vec<Vec<f64>>,
}

impl Block {
    /// Rows in the order of the spheres; a number that no atom of the deck has is left alone.
    fn renumber(&mut self, order: &[u32]) {
        if order.is_empty() {
            return;
        }
        for id in self.rows.iter_mut().filter_map(|row| row.first_mut()) {
            if let Some(sphere) = sphere_of(*id, order) {
                *id = f64::from(sphere) + 1.0;
            }
        }
        self.rows.sort_by(|a, b| a.first().partial_cmp(&b.first()).unwrap_or(Ordering::Equal));
    }
}

/// The sphere that the atom with this number is.
fn sphere_of(id: f64, order: &[u32]) -> Option<u32> {
    order.get((id as usize).checked_sub(1)?).copied()
}

/// The snapshots of a dump file. A last snapshot that is cut short is an error
/// after a run that ended well, and is left out after one that did not.
fn parse(text: &str, path: &Path, whole: bool) -> Result<Vec<Block>, SolverError> {
    let mut blocks = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line != "ITEM: TIMESTEP" {
            return Err(SolverError::output(
                path,
                format!("`{line}` where a snapshot should start"),
            ));
        }
        match block(&mut lines) {
            Ok(block) => blocks.push(block),
            Err(problem) if whole || lines.next().is_some() => {
                return Err(SolverError::output(path, problem));
            }
            Err(_) => break,
        }
    }
    Ok(blocks)
}

fn block<'a>(lines: &mut impl Iterator<Item = &'a str>) -> Result<Block, String> {
    let mut next = || lines.next().ok_or("the last snapshot is cut short");
    let step = next()?.trim().parse().map_err(|_| "a snapshot without a step number")?;
    next()?;
    let count: usize = next()?.trim().parse().map_err(|_| "a snapshot without a count")?;
    // Box: a heading and three lines.
    for _ in 0..4 {
        next()?;
    }
    let heading = next()?;
    let columns = heading.split_whitespace().count().saturating_sub(2);
    let mut rows = Vec::with_capacity(count);
    for _ in 0..count {
        let line = next()?;
        let row: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        let row =
            row.map_err(|_| format!("step {step}: `{line}` holds something that is no number"))?;
        if row.len() != columns {
            return Err(format!("step {step}: `{line}` has {} numbers, not {columns}", row.len()));
        }
        rows.push(row);
    }
    Ok(Block { step, rows })
}

/// Frames with all spheres, in order of their numbers.
fn frames(
    model: &Model,
    points: &Points,
    blocks: BTreeMap<u64, Block>,
    path: &Path,
) -> Result<Vec<Frame>, SolverError> {
    let mut earlier = model.initial_states();
    let mut frames = Vec::with_capacity(blocks.len());
    for (step, block) in blocks {
        let frame = frame(model, points, &block, &earlier)
            .map_err(|problem| SolverError::output(path, format!("step {step}: {problem}")))?;
        earlier.clone_from(&frame.bodies);
        frames.push(frame);
    }
    Ok(frames)
}

fn frame(
    model: &Model,
    points: &Points,
    block: &Block,
    earlier: &[BodyState],
) -> Result<Frame, String> {
    let count = model.spheres.len();
    let spins = model.needs().rotation;
    // id, place, velocity, spin if anything turns, force, radius.
    let columns = if spins { 14 } else { 11 };
    let all = count + points.len();
    let whole;
    let rows = match block.rows.len() {
        there if there == all => &block.rows,
        there if may_lack(model) && points.is_empty() => {
            whole = with_lost(model, block, columns, earlier)?;
            if whole.len() != all {
                return Err(format!("{there} atoms are not some of {all}"));
            }
            &whole
        }
        there => return Err(format!("{there} atoms of {all} are there: some were lost")),
    };
    let mut frame = Frame {
        step: block.step,
        time: block.step as f64 * model.plan.step,
        centres: Vec::with_capacity(count),
        velocities: Vec::with_capacity(count),
        spins: Vec::with_capacity(count),
        forces: Vec::with_capacity(count),
        bodies: Vec::with_capacity(model.bodies.len()),
    };
    for (index, row) in rows.iter().enumerate() {
        if row.len() != columns {
            return Err(format!("{} columns instead of {columns}", row.len()));
        }
        if row[0] != (index + 1) as f64 {
            return Err(format!("sphere {} stands where {} should", row[0], index + 1));
        }
        if index >= count {
            continue;
        }
        frame.centres.push(vector(row, 1));
        frame.velocities.push(vector(row, 4));
        frame.spins.push(if spins { vector(row, 7) } else { Vec3::zeros() });
        frame.forces.push(vector(row, columns - 4));
    }
    let places = rows[count..].iter().map(|row| vector(row, 1));
    let places: Points = points.keys().copied().zip(places).collect();
    frame.bodies = (0..model.bodies.len())
        .map(|i| body(model, &frame, i, &offsets(model, points, i), places.get(&i), &earlier[i]))
        .collect();
    Ok(frame)
}

/// Whether snapshots may lack spheres: some are deleted where they leave, or come later.
fn may_lack(model: &Model) -> bool {
    model.plan.guard.lost == Lost::Remove || !model.arrivals.is_empty()
}

/// Rows of all spheres: those that were deleted are where they were seen last and those that come
/// later where they will come, at rest. One that comes with the step of the snapshot moves as it comes.
fn with_lost(
    model: &Model,
    block: &Block,
    columns: usize,
    earlier: &[BodyState],
) -> Result<Vec<Vec<f64>>, String> {
    let mut rows = block.rows.iter().peekable();
    let one = |index: usize| {
        let id = (index + 1) as f64;
        if let Some(row) = rows.next_if(|row| row.first() == Some(&id)) {
            return Ok(row.clone());
        }
        let body = model.spheres[index].body as usize;
        let comes = model.arrival_step(body);
        if model.plan.guard.lost != Lost::Remove && comes < block.step.max(1) {
            return Err(format!("sphere {} is not there: some were lost", index + 1));
        }
        let mut row = vec![0.0; columns];
        row[0] = id;
        row[1..4].copy_from_slice(earlier[body].position.as_slice());
        if comes == block.step {
            row[4..7].copy_from_slice(model.bodies[body].velocity.as_slice());
            if columns == 14 {
                row[7..10].copy_from_slice(model.bodies[body].spin.as_slice());
            }
        }
        Ok(row)
    };
    let mut all: Vec<Vec<f64>> = (0..model.spheres.len()).map(one).collect::<Result<_, _>>()?;
    // What is left over belongs to no sphere.
    all.extend(rows.cloned());
    Ok(all)
}

/// State of one body; clumps from the places of their spheres and of their `point`.
fn body(
    model: &Model,
    frame: &Frame,
    index: usize,
    offsets: &[Vec3],
    point: Option<&Vec3>,
    earlier: &BodyState,
) -> BodyState {
    let body = &model.bodies[index];
    let range = body.first_sphere as usize..(body.first_sphere + body.sphere_count) as usize;
    let spin = frame.spins[range.start];
    if body.sphere_count == 1 {
        return BodyState {
            position: frame.centres[range.start],
            velocity: frame.velocities[range.start],
            spin,
            ..*earlier
        };
    }
    let spheres = &frame.centres[range.clone()];
    let centres: Vec<Vec3> = spheres.iter().chain(point).copied().collect();
    if centres.iter().any(|c| c.iter().any(|x| !x.is_finite())) {
        return *earlier;
    }
    let (orientation, position) = orientation::pose(offsets, &centres, &earlier.orientation);
    let count = f64::from(body.sphere_count);
    let mean_velocity = frame.velocities[range].iter().sum::<Vec3>() / count;
    let mean_arm = spheres.iter().sum::<Vec3>() / count - position;
    BodyState { position, orientation, velocity: mean_velocity - spin.cross(&mean_arm), spin }
}

/// Contacts of the last snapshot of `path`, which must be that of `frame`. `read` takes a
/// row: id, id, and what else the deck writes; it gives normal and tangential force.
pub fn contacts(
    model: &Model,
    frame: &Frame,
    order: &[u32],
    path: &Path,
    read: impl Fn(&[f64], &Vec3) -> Option<(f64, f64)>,
) -> Result<Vec<Touch>, SolverError> {
    let blocks = parse(&reading::text(path)?, path, true)?;
    let Some(block) = blocks.last().filter(|block| block.step == frame.step) else {
        return Err(SolverError::output(path, format!("no contacts of step {}", frame.step)));
    };
    let mut touches = Vec::with_capacity(block.rows.len());
    for row in &block.rows {
        let touch = touch(model, frame, order, row, &read)
            .ok_or_else(|| SolverError::output(path, format!("{row:?} is no contact")))?;
        touches.push(touch);
    }
    touches.sort_by_key(|touch| (touch.first, touch.second));
    Ok(touches)
}

fn touch(
    model: &Model,
    frame: &Frame,
    order: &[u32],
    row: &[f64],
    read: &impl Fn(&[f64], &Vec3) -> Option<(f64, f64)>,
) -> Option<Touch> {
    let index = |id: f64| {
        let id = sphere_of(id, order).map_or(id, |sphere| f64::from(sphere) + 1.0);
        let index = id as usize;
        (id >= 1.0 && index <= model.spheres.len()).then(|| index - 1)
    };
    let (a, b) = (index(*row.first()?)?, index(*row.get(1)?)?);
    let (normal, tangential) = read(row, &model.way(frame.centres[a] - frame.centres[b]))?;
    Some(Touch { first: a.min(b) as u32, second: a.max(b) as u32, normal, tangential })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: &str = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id x\n1 0.5\n2 1e-3\n";

    #[test]
    fn snapshots_are_read() {
        let path = Path::new("spheres.dump");
        let text = format!("{ONE}{}", ONE.replace("TIMESTEP\n0", "TIMESTEP\n20"));
        let blocks = parse(&text, path, true).expect("whole");
        assert_eq!(blocks.iter().map(|b| b.step).collect::<Vec<_>>(), [0, 20]);
        assert_eq!(blocks[1].rows, vec![vec![1.0, 0.5], vec![2.0, 1e-3]]);
    }

    #[test]
    fn cut_and_wrong_snapshots_are_told_apart() {
        let path = Path::new("spheres.dump");
        let cut = format!("{ONE}{}", &ONE[..ONE.len() - 7]);
        assert!(parse(&cut, path, true).is_err());
        assert_eq!(parse(&cut, path, false).expect("first is whole").len(), 1);
        let words = ONE.replace("0.5", "half");
        assert!(parse(&words, path, true).is_err());
        let long = ONE.replace("1 0.5", "1 0.5 7");
        assert!(parse(&long, path, true).is_err());
        let more = ONE.replace("ATOMS\n2", "ATOMS\n1");
        assert!(parse(&more, path, true).is_err());
    }

    #[test]
    fn lost_and_shuffled_spheres_are_noticed() {
        let model = crate::solver::deck::examples::two_spheres();
        let states = model.initial_states();
        let row = |id: f64| {
            let mut row = vec![0.0; if model.needs().rotation { 14 } else { 11 }];
            row[0] = id;
            row
        };
        let of = |ids: &[f64]| Block { step: 5, rows: ids.iter().map(|id| row(*id)).collect() };
        assert!(frame(&model, &Points::new(), &of(&[1.0, 2.0]), &states).is_ok());
        assert!(
            frame(&model, &Points::new(), &of(&[1.0]), &states).is_err_and(|e| e.contains("lost"))
        );
        assert!(frame(&model, &Points::new(), &of(&[2.0, 1.0]), &states).is_err());
    }

    #[test]
    fn thermo_lines_tell_the_step() {
        assert_eq!(step_of("     200        2  1.5e-05 "), Some(200));
        assert_eq!(step_of("Step Atoms KinEng"), None);
        assert_eq!(step_of("1 by 1 by 1 MPI processor grid"), None);
    }
}
