//! Digital packing (P7): container and grains are cells of one lattice, and grains wander cell by cell.
//!
//! Source: Jia & Williams 2001, Powder Technology 120, 175. Each sweep every grain draws one of the
//! 26 (in two dimensions 8) neighbouring places, all equally likely. A step that
//! goes up is tried only with the rebounding probability p, which stands for gravity and
//! shaking at once; a step into a cell that is owned already is not made. Instead
//! of a step a grain that is not round turns by a small random angle with probability q: its cells are
//! found anew from its true form, so that angles are not those of a fixed set.
//!
//! Overlap is a cell owned twice, whatever the form: surfaces from a scanner cost
//! no more than spheres. A step costs O(rows of the grain), a turn
//! O(triangles + cells), memory one bit a cell. The cell is the resolution: true forms
//! overlap by up to about a cell where cells belong to the grain that holds their centre, and
//! never where they belong to all that touch them. Both are measured at the end on the
//! true forms. Grains without a place are dropped.

use super::forms::Forms;
use super::occupied::placement;
use super::penetration;
use super::random::Test;
use super::voxels::{Cells, Lattice, MOST_CELLS, Ownership};
use super::walk::{Insertion, Schedule, Wanderers, walk};
use super::{Grain, Laid, Turn, tally};
use crate::geometry::Region;
use crate::num::random::{Stream, direction, stream, uniform, whole};
use crate::num::units::Angle;
use crate::num::{Fault, Job, Rotation, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of digital packing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Digital {
    /// Cells across the smallest grain (its equivalent-volume diameter), 4 to 200; default 12.
    pub cells: u32,
    /// What is packed: `clump` (default) its spheres, `solid` the true shape.
    pub test: Test,
    /// Which cells a grain owns: those whose centre it holds (`centre`, default), or all that it touches
    /// (`touched`), which never overlap in truth.
    pub ownership: Ownership,
    /// Probability that a step up is tried, 0 to 1: how hard the bed is shaken; default 0.2.
    pub rebound: f64,
    /// Probability that a grain turns in place of a step, 0 to 1; round grains never do. Default 0.2.
    pub turning: f64,
    /// Largest angle of a turn, rad, above 0 up to 180 degrees; default 15 degrees.
    pub largest_turn: Angle,
    /// False: no down, all steps are tried, and the work is done when all grains are in; default true.
    pub gravity: bool,
    /// Where grains come in; default `anywhere`.
    pub insertion: Insertion,
    /// Grains that try to come in during a sweep, 1 or more; default 100.
    pub rate: u32,
    /// Sweeps at most, 1 to 100 000 000; default 5000.
    pub sweeps: u32,
    /// Fall of the mean height in 100 sweeps at which the bed counts as settled, in
    /// cells, 0 or more; default 0.05.
    pub settled: f64,
    /// How grains are turned when they come in; default `random`.
    pub orientation: Turn,
}

impl Default for Digital {
    fn default() -> Self {
        Self {
            cells: 12,
            test: Test::Clump,
            ownership: Ownership::Centre,
            rebound: 0.2,
            turning: 0.2,
            largest_turn: Angle(15.0_f64.to_radians()),
            gravity: true,
            insertion: Insertion::Anywhere,
            rate: 100,
            sweeps: 5000,
            settled: 0.05,
            orientation: Turn::Random,
        }
    }
}

impl Digital {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("cells", f64::from(self.cells), 4.0, 200.0)?;
        Fault::within("rebound", self.rebound, 0.0, 1.0)?;
        Fault::within("turning", self.turning, 0.0, 1.0)?;
        Fault::positive("largest_turn", self.largest_turn.0)?;
        Fault::within("largest_turn", self.largest_turn.0, 0.0, std::f64::consts::PI * 1.000001)?;
        Fault::within("rate", f64::from(self.rate), 1.0, f64::from(u32::MAX))?;
        Fault::within("sweeps", f64::from(self.sweeps), 1.0, 1e8)?;
        Fault::not_negative("settled", self.settled)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let dimension = region.dimension();
        let forms = Forms::fitting(grains, self.test, region, "digital")?;
        if grains.is_empty() {
            return Ok(Laid::nothing());
        }
        let edge = Lattice::edge(region, forms.smallest() / f64::from(self.cells));
        let needed = Lattice::cells_needed(region, edge);
        if needed > MOST_CELLS {
            let problem = format!("is {}, which needs {needed:.2e} cells", self.cells);
            let allowed = format!("fewer cells a grain: at most {MOST_CELLS:.1e} in the container");
            return Err(Fault::new("digital.cells", problem, allowed));
        }
        let mut bed = Bed {
            parameters: self,
            grains,
            forms: &forms,
            lattice: Lattice::new(region, edge, self.ownership),
            placed: (0..grains.len()).map(|_| None).collect(),
            layer: 2.0 * forms.distinct.iter().map(|f| 2.0 * f.radius).fold(0.0, f64::max) / edge,
        };
        let schedule = Schedule {
            sweeps: u64::from(self.sweeps),
            rate: u64::from(self.rate),
            settled: self.settled * edge,
            gravity: self.gravity,
        };
        let mut source = stream(seed, "pack.digital", 0);
        let walked = walk(&mut bed, grains.len(), &schedule, &mut source, job);
        let (mut owned, mut volume) = (0, 0.0);
        let mut placements = Vec::with_capacity(grains.len());
        for (grain, placed) in bed.placed.iter().enumerate() {
            let Some(placed) = placed else { continue };
            owned += placed.cells.count();
            volume += forms.shaped(grain).volume;
            let at = (bed.lattice.point(placed.at), placed.turn);
            placements.push(placement(grain, at, Vec3::zeros()));
        }
        let dropped: Vec<u32> = walked.outside.iter().map(|&grain| grain as u32).collect();
        let cell = edge.powi(dimension as i32);
        let report = penetration::check(&placements, grains, self.test, region, seed);
        let outcome = format!(
            "{} after {} sweeps; {}; sizes as wanted; cells of {edge:.4e} m, the owned ones hold {:.4} times the volume of the grains, {:.4} of the cells inside; {report}",
            walked.end,
            walked.sweeps,
            tally(grains, &placements, &dropped, "no free place came up"),
            if volume > 0.0 { owned as f64 * cell / volume } else { 1.0 },
            owned as f64 / bed.lattice.room.max(1) as f64,
        );
        Ok(Laid { placements, dropped, outcome })
    }
}

/// Where a grain is.
struct Placed {
    cells: Cells,
    at: [i32; 3],
    turn: Rotation,
}

struct Bed<'a> {
    parameters: &'a Digital,
    grains: &'a [Grain<'a>],
    forms: &'a Forms,
    lattice: Lattice,
    placed: Vec<Option<Placed>>,
    /// Depth of the layer that rain comes in through, in cells.
    layer: f64,
}

impl Bed<'_> {
    fn cells(&self, grain: usize, turn: &Rotation) -> Cells {
        let Lattice { edge, dimension, .. } = self.lattice;
        Cells::of(self.forms.shaped(grain), turn, edge, dimension, self.parameters.ownership)
    }

    /// The step number 0 to 25 (7), without the one that stays.
    fn step(&self, source: &mut Stream) -> [i32; 3] {
        let ways = if self.lattice.dimension == 2 { 8 } else { 26 };
        let drawn = whole(source, 0, ways - 1) as i32;
        let number = drawn + i32::from(drawn >= ways as i32 / 2);
        [number % 3 - 1, number / 3 % 3 - 1, if ways == 8 { 0 } else { number / 9 - 1 }]
    }

    fn move_on(&mut self, grain: usize, cold: bool, source: &mut Stream) {
        let step = self.step(source);
        let rebound = if cold { 0.0 } else { self.parameters.rebound };
        let up = step[self.lattice.dimension - 1] > 0;
        if up && self.parameters.gravity && uniform(source, 0.0, 1.0) >= rebound {
            return;
        }
        let Some(placed) = &mut self.placed[grain] else { return };
        let to = self.lattice.home([0, 1, 2].map(|axis| placed.at[axis] + step[axis]));
        self.lattice.give(&placed.cells, placed.at);
        if self.lattice.is_free(&placed.cells, to) {
            placed.at = to;
        }
        self.lattice.take(&placed.cells, placed.at);
    }

    fn turn(&mut self, grain: usize, source: &mut Stream) {
        let largest = self.parameters.largest_turn.0;
        let (axis, angle) = match self.lattice.dimension {
            2 => (Vec3::z(), uniform(source, -largest, largest)),
            _ => (direction(source), uniform(source, 0.0, largest)),
        };
        let Some(placed) = &self.placed[grain] else { return };
        let mut turn = Rotation::from_scaled_axis(axis * angle) * placed.turn;
        turn.renormalize();
        let cells = self.cells(grain, &turn);
        let Some(placed) = &mut self.placed[grain] else { return };
        self.lattice.give(&placed.cells, placed.at);
        if self.lattice.is_free(&cells, placed.at) {
            (placed.cells, placed.turn) = (cells, turn);
        }
        self.lattice.take(&placed.cells, placed.at);
    }
}

impl Wanderers for Bed<'_> {
    fn enter(&mut self, grain: usize, source: &mut Stream) -> bool {
        let dimension = self.lattice.dimension;
        let turn = self.parameters.orientation.draw(&self.grains[grain], dimension, source);
        let cells = self.cells(grain, &turn);
        let mut at = [0; 3];
        for (axis, place) in at.iter_mut().enumerate().take(dimension) {
            let (low, high) = cells.extent(axis);
            let size = self.lattice.size[axis];
            let (mut first, last) = match self.lattice.periodic[axis] {
                true => (0, size - 1),
                false => (1 - low, size - 1 - high),
            };
            if axis == dimension - 1 && self.parameters.insertion == Insertion::Top {
                let deep = (self.layer.ceil() as i32 - (high - low)).max(0);
                first = first.max(last - deep);
            }
            if first > last {
                return false;
            }
            *place = first + whole(source, 0, (last - first) as u64) as i32;
        }
        if !self.lattice.is_free(&cells, at) {
            return false;
        }
        self.lattice.take(&cells, at);
        self.placed[grain] = Some(Placed { cells, at, turn });
        true
    }

    fn stir(&mut self, grain: usize, cold: bool, source: &mut Stream) {
        let turns = self.parameters.turning > 0.0
            && !self.forms.shaped(grain).is_round()
            && uniform(source, 0.0, 1.0) < self.parameters.turning;
        if turns {
            self.turn(grain, source);
        } else {
            self.move_on(grain, cold, source);
        }
    }

    fn height(&self, grain: usize) -> f64 {
        let up = self.lattice.dimension - 1;
        self.placed[grain].as_ref().map_or(0.0, |placed| self.lattice.point(placed.at)[up])
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{
        brute_force, crossing_solids, dumbbell, of, periodic_room, room, solid, sphere,
    };
    use super::super::{Method, Packing, pack};
    use super::*;
    use crate::clump::Clump;
    use crate::geometry::region::MeshRegion;
    use crate::geometry::samples::{icosphere, l_mesh};

    fn lay(grains: &[Grain], region: &Region, parameters: Digital, seed: u64) -> Packing {
        pack(grains, &[], region, &Method::Digital(parameters), seed, &Job::quiet())
            .expect("right parameters")
    }

    fn touched(sweeps: u32) -> Digital {
        Digital { ownership: Ownership::Touched, sweeps, ..Digital::default() }
    }

    #[test]
    fn touched_cells_never_overlap_in_truth() {
        for (region, size) in [(room(&[1.0; 3]), 0.1), (room(&[1.0, 1.0]), 0.05)] {
            let dimension = region.dimension();
            let mut clumps: Vec<Clump> = vec![sphere(size, dimension); 20];
            clumps.extend(vec![dumbbell(0.7 * size, size); 20]);
            let grains = of(&clumps);
            let parameters = Digital { cells: 8, ..touched(150) };
            let packing = lay(&grains, &region, parameters.clone(), 3);
            assert!(packing.placements.len() > 30, "{}", packing.outcome);
            let (gap, wall) = brute_force(&packing, &grains, &region);
            assert!(gap >= 0.0 && wall >= -1e-12, "{gap} {wall}");
            assert_eq!(packing, lay(&grains, &region, parameters, 3));
            assert!(packing.outcome.contains("sizes as wanted"), "{}", packing.outcome);
        }
    }

    #[test]
    fn spheres_settle_to_a_loose_bed() {
        let clumps = vec![sphere(0.1, 3); 60];
        let grains = of(&clumps);
        let region = room(&[0.8, 0.8, 1.6]);
        let parameters = Digital { cells: 10, sweeps: 1500, ..Digital::default() };
        let packing = lay(&grains, &region, parameters, 1);
        assert_eq!(packing.placements.len(), 60, "{}", packing.outcome);
        let mut heights: Vec<f64> = packing.placements.iter().map(|p| p.position.z).collect();
        heights.sort_by(f64::total_cmp);
        // 60 spheres fill 0.25 m³; at a solid fraction of a half they stand 0.79 m high.
        assert!(heights[59] < 0.95, "{heights:?} {}", packing.outcome);
        // Centres own cells: overlaps stay below about a cell of 0.02 m.
        let (gap, wall) = brute_force(&packing, &grains, &region);
        assert!(gap > -0.03 && wall > -0.011, "{gap} {wall}");
    }

    #[test]
    fn true_shapes_fill_a_closed_surface() {
        let (clump, solid) = solid(l_mesh().mapped(|v| v * 0.1));
        let size = solid.mesh.bounds().diagonal();
        let grains = vec![Grain { clump: &clump, solid: Some(&solid), family: 0 }; 12];
        let ball = icosphere(2).mapped(|v| v * (1.2 * size));
        let region = Region::Mesh(Box::new(MeshRegion::new(ball).expect("closed")));
        let parameters = Digital { test: Test::Solid, cells: 8, ..touched(60) };
        let packing = lay(&grains, &region, parameters, 2);
        assert!(packing.placements.len() > 2, "{}", packing.outcome);
        assert!(packing.outcome.contains("no two bodies overlap"), "{}", packing.outcome);
    }

    #[test]
    fn true_shapes_lie_across_sides_that_repeat() {
        let (clump, solid) = solid(l_mesh().mapped(|v| v * 0.1));
        let edge = 4.05
            * solid.mesh.vertices.iter().map(|v| (v - clump.centroid).norm()).fold(0.0, f64::max);
        let grains = vec![Grain { clump: &clump, solid: Some(&solid), family: 0 }; 24];
        // Sides of which no whole number of cells fits both.
        let region = periodic_room(&[edge, 1.137 * edge, 2.0 * edge], [true, true, false]);
        let packing =
            lay(&grains, &region, Digital { test: Test::Solid, cells: 8, ..touched(60) }, 2);
        assert!(packing.placements.len() > 12, "{}", packing.outcome);
        assert!(packing.outcome.contains("no two bodies overlap"), "{}", packing.outcome);
        assert_eq!(crossing_solids(&packing, &solid, &clump, &region), 0, "{}", packing.outcome);
        let high =
            |axis: usize| packing.placements.iter().map(|p| p.position[axis]).fold(0.0, f64::max);
        assert!(high(0) > 0.9 * edge && high(1) > 0.9 * 1.137 * edge && high(2) < 1.9 * edge);
        let tight = periodic_room(&[0.9 * edge, edge, edge], [true, false, false]);
        let method = Method::Digital(Digital { test: Test::Solid, cells: 8, ..touched(60) });
        let refused =
            pack(&grains, &[], &tight, &method, 1, &Job::quiet()).expect_err("meets itself");
        assert!(refused.to_string().contains("too short along x"), "{refused}");
    }

    #[test]
    fn all_at_once_without_gravity_and_rain_from_the_top() {
        let clumps = vec![sphere(0.05, 2); 60];
        let grains = of(&clumps);
        let region = room(&[1.0, 1.0]);
        let still = Digital { gravity: false, ..Digital::default() };
        let packing = lay(&grains, &region, still, 4);
        assert!(packing.outcome.starts_with("all grains are in"), "{}", packing.outcome);
        let rain =
            Digital { insertion: Insertion::Top, rate: 1, sweeps: 2000, ..Digital::default() };
        let packing = lay(&grains, &region, rain, 4);
        assert_eq!(packing.placements.len(), 60, "{}", packing.outcome);
        assert!(packing.placements.iter().all(|p| p.position.y < 0.85), "{}", packing.outcome);
    }

    #[test]
    fn wrong_input_is_refused_before_work() {
        let fault = |p: Digital| Method::Digital(p).validate().expect_err("is wrong").key;
        assert_eq!(fault(Digital { rebound: 1.2, ..Digital::default() }), "digital.rebound");
        assert_eq!(fault(Digital { turning: -0.1, ..Digital::default() }), "digital.turning");
        assert_eq!(fault(Digital { cells: 2, ..Digital::default() }), "digital.cells");
        assert_eq!(fault(Digital { rate: 0, ..Digital::default() }), "digital.rate");
        let (big, small) = ([sphere(0.6, 3)], [sphere(1e-4, 3)]);
        let refused = |clumps: &[Clump]| {
            let method = Method::Digital(Digital::default());
            pack(&of(clumps), &[], &room(&[1.0; 3]), &method, 1, &Job::quiet())
                .expect_err("cannot be")
                .to_string()
        };
        assert!(refused(&big).contains("fits in no orientation"));
        assert!(refused(&small).contains("digital.cells"));
    }
}
