//! Random placement (P3): grains of the wanted sizes go one by one to random
//! places with random rotations and stay where they overlap nothing.
//!
//! Source: random sequential addition (Widom 1966, J. Chem. Phys. 44, 3888);
//! with the largest first, as in Manna (1992, Physica A 187, 373) and in
//! generators of mixtures. Equal spheres jam near a solid fraction of 0.384,
//! equal discs near 0.547, and the time to get there has no bound, so each
//! grain has a number of tries and is dropped after them; sizes never change.
//!
//! Cost: O(tries · spheres of the grain) a grain for clumps; for solids each
//! try meets the few neighbours whose bounding spheres overlap, surface against
//! surface. Memory O(spheres).

use super::occupied::{Occupied, placement};
use super::{Grain, Laid, Turn, common_velocity, finite_velocity, tally};
use crate::geometry::{Bounds, Region};
use crate::num::random::stream;
use crate::num::units::{Length, Speed};
use crate::num::{Fault, Job, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of random placement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Random {
    /// Places tried for a grain before it is dropped, 1 to 10 000 000; default 1000.
    pub tries: u32,
    /// What must not overlap; default `clump`.
    pub test: Test,
    /// Least distance between bodies and between bodies and the boundary, m, 0 or more; default 0.
    pub gap: Length,
    /// Which grains go first; default `largest_first`.
    pub order: Order,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
    /// Velocity of all bodies at the start, m/s; default 0.
    pub velocity: [Speed; 3],
}

impl Default for Random {
    fn default() -> Self {
        Self {
            tries: 1000,
            test: Test::Clump,
            gap: Length(0.0),
            order: Order::LargestFirst,
            orientation: Turn::Random,
            velocity: [Speed(0.0); 3],
        }
    }
}

/// What is tested for overlap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Test {
    /// The spheres of clumps: a run starts without overlap.
    Clump,
    /// The true shapes; spheres that stick out of their solid may then overlap (the measures say by how much).
    Solid,
}

/// Which grains are placed first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// By falling volume: packs denser.
    LargestFirst,
    /// In the order of the list of grains.
    AsGiven,
}

impl Random {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("tries", f64::from(self.tries), 1.0, 1e7)?;
        Fault::not_negative("gap", self.gap.0)?;
        finite_velocity(&self.velocity)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let dimension = region.dimension();
        let velocity = common_velocity(&self.velocity, dimension).map_err(|f| f.under("random"))?;
        let mut occupied = match self.test {
            Test::Clump => Occupied::of_clumps(grains, region, self.gap.0),
            Test::Solid => Occupied::of_solids(grains, region, self.gap.0),
        };
        let order = self.sequence(grains);
        let (mut placements, mut dropped) = (Vec::with_capacity(grains.len()), Vec::new());
        for (done, &grain) in order.iter().enumerate() {
            if job.is_cancelled() {
                dropped.extend(order[done..].iter().map(|&grain| grain as u32));
                break;
            }
            match self.find(grain, &grains[grain], region, &occupied, seed) {
                Some(at) => {
                    occupied.add(grain, at);
                    placements.push(placement(grain, at, velocity));
                }
                None => dropped.push(grain as u32),
            }
            if done % 64 == 0 {
                job.report("grains placed", done as u64, grains.len() as u64);
            }
        }
        job.report("grains placed", grains.len() as u64, grains.len() as u64);
        let why = match job.is_cancelled() {
            true => "stopped before all were tried".to_owned(),
            false => format!("no free place in {} tries each", self.tries),
        };
        let outcome = tally(grains, &placements, &dropped, &why);
        Ok(Laid { placements, dropped, outcome })
    }

    fn sequence(&self, grains: &[Grain]) -> Vec<usize> {
        let mut order: Vec<usize> = (0..grains.len()).collect();
        if self.order == Order::LargestFirst {
            let volume = |grain: usize| grains[grain].clump.volume;
            order.sort_by(|&a, &b| volume(b).total_cmp(&volume(a)).then(a.cmp(&b)));
        }
        order
    }

    /// A free place for `grain`, or `None` after all tries. A try draws a
    /// rotation, then a centre where the turned grain's bounds lie inside those
    /// of the region.
    fn find(
        &self,
        grain: usize,
        what: &Grain,
        region: &Region,
        occupied: &Occupied,
        seed: u64,
    ) -> Option<(Vec3, crate::num::Rotation)> {
        let mut source = stream(seed, "pack.random", grain as u64);
        let dimension = region.dimension();
        let room = region.bounds().grown(-self.gap.0);
        for _ in 0..self.tries {
            let turn = self.orientation.draw(what, dimension, &mut source);
            let extent = occupied.extent(grain, &turn);
            let bounds = Bounds { low: room.low - extent.low, high: room.high - extent.high };
            if (0..dimension).any(|axis| bounds.low[axis] > bounds.high[axis]) {
                continue;
            }
            let centre = region.sample_within(&bounds, &mut source)?;
            if occupied.fits(grain, &(centre, turn)) {
                return Some((centre, turn));
            }
        }
        None
    }
}
