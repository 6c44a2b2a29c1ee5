//! Packings that our own DEM prepares: a loose random start, the DEM, and back to placements.

use super::build::{self, Built};
use super::grains::Grain;
use super::road::{Grains, Road, RoadError};
use super::walls::Room;
use crate::dem::deposit;
use crate::geometry::Region;
use crate::model::BodyState;
use crate::num::{Fault, Vec3};
use crate::pack::random::Random;
use crate::pack::{self, Deposition, Method, Packing, Placement};

/// Solid fraction up to which a cloud of grains finds places without overlap in any container.
const CLOUD: f64 = 0.3;

/// Grains without overlap at random places, and the model of them.
pub(super) struct Start {
    pub packing: Packing,
    pub built: Built,
}

impl Road {
    /// Packs by deposition in the DEM.
    ///
    /// # Errors
    /// No gravity; a container too low for a loose start; a DEM that cannot run.
    pub(super) fn deposited(
        &self,
        grains: &Grains,
        room: &Room,
        region: &Region,
        wanted: &Deposition,
    ) -> Result<Packing, RoadError> {
        let here = |fault: Fault| self.wrong(fault.under("deposition").under("packing"));
        wanted.validate().map_err(here)?;
        let list = super::packing::listed(grains);
        let solid: f64 = list.iter().map(|grain| grain.clump.volume).sum();
        let fraction = solid / region.volume();
        if fraction > CLOUD {
            let problem = format!(
                "starts from grains without overlap all over the container, which would fill {fraction:.3} of it"
            );
            let times = fraction / CLOUD;
            let allowed = format!("at most {CLOUD}: a container {times:.2} times as tall");
            return Err(here(Fault::new("", problem, allowed)));
        }
        let start = self.loose(grains, room, region).map_err(|lost| match lost {
            Lost::Places(problem) => here(Fault::new("", problem, "a taller container")),
            Lost::Otherwise(error) => error,
        })?;
        if start.built.model.gravity.norm() <= 0.0 {
            return Err(here(Fault::new("", "has no gravity to fall by", "`plan.gravity`")));
        }
        let done = deposit(&start.built.model, wanted, &self.job).map_err(RoadError::Dem)?;
        let placements = laid(&start.packing, &done.states, &list, 1.0);
        let measures = pack::measure::measure(&placements, &list, region);
        if !done.rest {
            self.job.finished(&done.outcome);
        }
        Ok(Packing { placements, dropped: Vec::new(), outcome: done.outcome, measures })
    }

    /// All `grains` at random places without overlap.
    pub(super) fn loose(
        &self,
        grains: &Grains,
        room: &Room,
        region: &Region,
    ) -> Result<Start, Lost> {
        let scene = &self.loaded.scene;
        let names: Vec<&str> = scene.grains.iter().map(|family| family.name.as_str()).collect();
        let random = Method::Random(Random { tries: 10_000, ..Random::default() });
        let list = super::packing::listed(grains);
        let packing = pack::pack(&list, &names, region, &random, scene.seed, &self.job)
            .map_err(|error| Lost::Otherwise(self.refused(error)))?;
        if !packing.dropped.is_empty() {
            return Err(Lost::Places(format!(
                "{} of {} grains find no place without overlap",
                packing.dropped.len(),
                list.len()
            )));
        }
        let built = build::build(
            &self.loaded,
            Some(region),
            &room.walls,
            &grains.distinct,
            &grains.copies,
            &packing,
            &[],
        )
        .map_err(|fault| Lost::Otherwise(self.wrong(fault)))?;
        Ok(Start { packing, built })
    }
}

/// Why there is no start.
pub(super) enum Lost {
    /// Grains without a place, said in one clause.
    Places(String),
    /// Anything else.
    Otherwise(RoadError),
}

/// Where the grains `list` lie at `scale` times their size, from the states of the bodies that stood for them.
pub(super) fn laid(
    start: &Packing,
    states: &[BodyState],
    list: &[pack::Grain],
    scale: f64,
) -> Vec<Placement> {
    let one = |(before, state): (&Placement, &BodyState)| {
        // A body of one sphere is that sphere: it keeps the orientation of its grain.
        let (position, orientation) = match &list[before.grain as usize].clump.balls[..] {
            [ball] => {
                let turn = before.orientation;
                (state.position - turn * (ball.centre * scale), turn)
            }
            _ => (state.position, state.orientation),
        };
        let (velocity, spin) = (Vec3::zeros(), Vec3::zeros());
        Placement { position, orientation, velocity, spin, scale, ..*before }
    };
    start.placements.iter().zip(states).map(one).collect()
}

/// A grain `scale` times as large, without its solid: spheres are what the DEM knows.
pub(super) fn shrunk(grain: &Grain, scale: f64, dimension: u32) -> Grain {
    Grain { family: grain.family, solid: None, clump: grain.clump.scaled(scale, dimension) }
}
