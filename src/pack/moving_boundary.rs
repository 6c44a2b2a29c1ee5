//! Moving boundary (P12): grains of final size without overlap in a larger box, whose walls
//! then move in until they are those of the container.
//!
//! Source: the packing note of the particle flow codes, which names three faults of the method. They are
//! measured and told: how far the walls had to move (the boundary is another one than at the start), how many
//! relaxation steps it took (slow), and the solid fraction beside the moved walls against that in the
//! middle (uneven). Walls move in steps of `strain` of the box, balls come to rest after each; without
//! friction, see [`super::soft`].
//!
//! Boxes and rectangles only. Cost O(near pairs) a relaxation step. If balls jam before the walls are
//! in place the walls go on, overlaps remain, and the outcome says where it jammed.

use super::radius_expansion::{balls_of, ending};
use super::soft::{Relaxed, Rest, Soft};
use super::space::Space;
use super::target::{Target, validate_porosity};
use super::{Grain, Laid, Turn, dress, scatter};
use crate::geometry::container::Side;
use crate::geometry::{BallGrid, Bounds, Region};
use crate::num::random::stream;
use crate::num::{Fault, Job, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of the moving boundary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MovingBoundary {
    /// Porosity of the container that sizes are multiplied for, 0.01 to 0.999; default: sizes as they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub porosity: Option<f64>,
    /// Walls that move; default all (sides that repeat are no walls).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sides: Vec<Side>,
    /// Solid fraction at the start, 0.01 to 0.5; default 0.25 (0.4 at most where all find a place).
    pub start: f64,
    /// Share of the box by which walls move a step, 1e-6 to 0.1; default 0.005.
    pub strain: f64,
    /// Overlap over the smaller radius that may remain, 1e-12 to 0.1; default 1e-4.
    pub overlap: f64,
    /// Most relaxation steps in all, 1 to 100 000 000; default 50 000.
    pub steps: u64,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
}

impl Default for MovingBoundary {
    fn default() -> Self {
        Self {
            porosity: None,
            sides: Vec::new(),
            start: 0.25,
            strain: 0.005,
            overlap: 1e-4,
            steps: 50_000,
            orientation: Turn::Random,
        }
    }
}

impl MovingBoundary {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        validate_porosity(self.porosity)?;
        Fault::within("start", self.start, 0.01, 0.5)?;
        Fault::within("strain", self.strain, 1e-6, 0.1)?;
        Fault::within("overlap", self.overlap, 1e-12, 0.1)?;
        Fault::within("steps", self.steps as f64, 1.0, 1e8)
    }

    /// `moves[axis][side]` for each wall.
    fn moves(&self, dimension: usize, periodic: [bool; 3]) -> Result<[[bool; 2]; 3], Fault> {
        let mut moves = periodic.map(|repeats| [self.sides.is_empty() && !repeats; 2]);
        if periodic[..dimension].iter().all(|&repeats| repeats) {
            return Err(Fault::new(
                "",
                "has no wall to move: all sides repeat",
                "a side that is a wall",
            ));
        }
        for (index, side) in self.sides.iter().enumerate() {
            let (axis, high) = side.face(dimension);
            if axis >= dimension {
                let key = format!("sides[{index}]");
                let problem = "is a side along z in two dimensions";
                return Err(Fault::new(key, problem, "x-, x+, y-, y+"));
            }
            if periodic[axis] {
                let key = format!("sides[{index}]");
                return Err(Fault::new(key, "is a side that repeats", "a side that is a wall"));
            }
            moves[axis][usize::from(high)] = true;
        }
        Ok(moves)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let here = |fault: Fault| fault.under("moving_boundary");
        let Region::Box(_) = region else {
            return Err(here(Fault::new("", "has walls that cannot move", "a box")));
        };
        let dimension = region.dimension();
        let space = Space::of(region);
        let moves = self.moves(dimension, space.periodic).map_err(here)?;
        let target = Target::of(grains, region, self.porosity).map_err(here)?;
        let Some(pressed) = self.press(&space, &moves, &target.radii, target.fraction, seed, job)
        else {
            return Err(here(scatter::no_inside()));
        };
        let mut why = ending(&pressed.soft, &pressed.relaxed, region, target.closest);
        if let Some(fraction) = pressed.jammed_at.filter(|_| pressed.relaxed.rest != Rest::Apart) {
            why.push_str(&format!("; forces first balanced at solid fraction {fraction:.4}"));
        }
        let way: Vec<String> =
            pressed.way.iter().take(dimension).map(|way| format!("{:.1}", 100.0 * way)).collect();
        let (beside, middle) = pressed.fractions;
        why.push_str(&format!(
            "; walls moved by {} % of the container; solid fraction {beside:.3} beside them, {middle:.3} in the middle",
            way.join(", ")
        ));
        let balls = balls_of(&pressed.soft);
        Ok(dress::laid(grains, &balls, dimension, self.orientation, seed, &why))
    }

    /// Balls of `radii` (m), which fill `fraction` of the box `space`, pressed into it by the walls
    /// `moves[axis][side]`; `None` if it has no inside.
    pub fn press<'a>(
        &self,
        space: &Space<'a>,
        moves: &[[bool; 2]; 3],
        radii: &[f64],
        fraction: f64,
        seed: u64,
        job: &Job,
    ) -> Option<Pressed<'a>> {
        let (last, dimension) = (space.bounds, space.dimension);
        let grown = (fraction / self.start).max(1.0);
        let first = widened(&last, moves, grown, dimension);
        let mut space = *space;
        space.bounds = first;
        let (centres, _) = scatter::apart(&space, radii, 1000, seed)?;
        let mut soft = Soft::new(space, centres, radii.to_vec());
        let stages = ((grown.ln() / self.strain).ceil() as u64).max(1);
        let (mut left, mut jammed_at) = (self.steps, None);
        for stage in 1..=stages {
            // Equal strain a step: most of the way is covered while balls are still loose.
            let volume = grown.powf(1.0 - stage as f64 / stages as f64);
            soft.space.bounds = widened(&last, moves, volume, dimension);
            soft.forget_pairs();
            let relaxed = soft.relax(10.0 * self.overlap, 1e-2, left.min(300), job);
            left -= relaxed.steps;
            if relaxed.rest == Rest::Jammed && jammed_at.is_none() {
                jammed_at = Some(fraction / volume);
            }
            job.report("wall steps", stage, stages);
            if job.is_cancelled() {
                break;
            }
        }
        let mut relaxed = soft.relax(self.overlap, 1e-5, left, job);
        relaxed.steps += self.steps - left;
        let fractions = evenness(&soft, moves, radii);
        let way = std::array::from_fn(|axis| match axis < dimension {
            true => first.size()[axis] / last.size()[axis] - 1.0,
            false => 0.0,
        });
        Some(Pressed { soft, relaxed, jammed_at, way, fractions })
    }
}

/// Balls between walls that have moved, and the three faults of it as figures.
pub struct Pressed<'a> {
    /// Balls where they are now.
    pub soft: Soft<'a>,
    /// How they came to rest; its steps are all steps.
    pub relaxed: Relaxed,
    /// Solid fraction at which forces balanced first, if they did.
    pub jammed_at: Option<f64>,
    /// How far the walls moved along each axis over the edge of the container.
    pub way: [f64; 3],
    /// Solid fraction one to three mean radii off the walls that moved, and farther than three from all walls.
    pub fractions: (f64, f64),
}

/// The box with `volume` times the volume, wider on the sides that move.
fn widened(last: &Bounds, moves: &[[bool; 2]; 3], volume: f64, dimension: usize) -> Bounds {
    let axes = (0..dimension).filter(|&axis| moves[axis].contains(&true)).count();
    let factor = volume.powf(1.0 / axes.max(1) as f64);
    let mut bounds = *last;
    for (axis, sides) in moves.iter().enumerate().take(dimension) {
        let more = (factor - 1.0) * (last.high[axis] - last.low[axis]);
        match *sides {
            [true, true] => {
                bounds.low[axis] -= 0.5 * more;
                bounds.high[axis] += 0.5 * more;
            }
            [true, false] => bounds.low[axis] -= more,
            [false, true] => bounds.high[axis] += more,
            [false, false] => {}
        }
    }
    bounds
}

/// Solid fractions one to three mean radii off the walls that moved, and farther than three from all walls;
/// by random points. Layers next to walls are thin for any method, so the first radius does not count.
fn evenness(soft: &Soft, moves: &[[bool; 2]; 3], radii: &[f64]) -> (f64, f64) {
    let space = &soft.space;
    let mean = radii.iter().sum::<f64>() / radii.len().max(1) as f64;
    let mut grid = BallGrid::new(radii.iter().copied().fold(f64::INFINITY, f64::min));
    for (centre, radius) in soft.centres.iter().zip(&soft.radii) {
        grid.insert(*centre, *radius);
    }
    let largest = soft.radii.iter().copied().fold(0.0, f64::max);
    let mut source = stream(0, "pack.evenness", 0);
    let (mut beside, mut middle) = ([0_u32; 2], [0_u32; 2]);
    let nearest_moved = |p: &Vec3| {
        let walls = (0..space.dimension).flat_map(|axis| {
            let low = moves[axis][0].then_some(p[axis] - space.bounds.low[axis]);
            let high = moves[axis][1].then_some(space.bounds.high[axis] - p[axis]);
            [low, high]
        });
        walls.flatten().fold(f64::INFINITY, f64::min)
    };
    for _ in 0..40_000 {
        let Some(point) = space.sample(&mut source) else { break };
        let solid = u32::from(space.overlaps(&grid, &point, 0.0, largest));
        if (mean..3.0 * mean).contains(&nearest_moved(&point)) {
            beside = [beside[0] + solid, beside[1] + 1];
        } else if space.clearance(&point) > 3.0 * mean {
            middle = [middle[0] + solid, middle[1] + 1];
        }
    }
    let share = |[solid, all]: [u32; 2]| f64::from(solid) / f64::from(all.max(1));
    (share(beside), share(middle))
}

#[cfg(test)]
mod tests {
    use super::super::samples::{brute_force, cylinder, of, room, sphere};
    use super::super::{Method, pack};
    use super::*;

    #[test]
    fn walls_come_in_to_the_container_and_the_faults_are_told() {
        for (dimension, sides) in [(2, vec![]), (3, vec![Side::Top])] {
            let clumps = vec![sphere(0.07, dimension); 150];
            let grains = of(&clumps);
            let porosity = if dimension == 2 { 0.3 } else { 0.52 };
            let method = Method::MovingBoundary(MovingBoundary {
                porosity: Some(porosity),
                strain: 0.02,
                sides,
                ..MovingBoundary::default()
            });
            let region = room(&vec![1.0; dimension]);
            let packing = pack(&grains, &[], &region, &method, 1, &Job::quiet()).expect("right");
            assert!(packing.outcome.starts_with("target met"), "{}", packing.outcome);
            assert!(packing.outcome.contains("beside them"), "{}", packing.outcome);
            let (gap, wall) = brute_force(&packing, &grains, &region);
            assert!(gap > -1e-4 && wall > -1e-4, "{gap} {wall}");
        }
    }

    #[test]
    fn only_boxes_have_walls_that_move() {
        let clumps = vec![sphere(0.07, 3); 5];
        let method = Method::MovingBoundary(MovingBoundary::default());
        let refused = pack(&of(&clumps), &[], &cylinder(), &method, 1, &Job::quiet());
        assert!(refused.expect_err("no box").to_string().contains("cannot move"));
    }
}
