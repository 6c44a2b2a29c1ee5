//! Explosive repulsion (P11): grains of final size at random places, however they
//! overlap, pushed apart by the overlaps.
//!
//! Source: the packing note of the particle flow codes ("calm"). Overlaps of a whole diameter would throw grains
//! through the walls; so velocities are set to zero every `calm` steps and no grain moves by more than a
//! tenth of the smallest radius a step; then a relaxation to rest. Grains whose centre ends outside are
//! dropped and counted. Springs without friction, see [`super::soft`].
//!
//! Cost O(near pairs) a step, `rounds · calm` steps and the relaxation.

use super::radius_expansion::{balls_of, ending};
use super::soft::Soft;
use super::space::Space;
use super::target::{Target, validate_porosity};
use super::{Grain, Laid, Turn, dress, scatter};
use crate::geometry::Region;
use crate::num::{Fault, Job};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of explosive repulsion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ExplosiveRepulsion {
    /// Porosity of the container that sizes are multiplied for, 0.01 to 0.999; default: sizes as they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub porosity: Option<f64>,
    /// Steps between two settings of all velocities to zero, 1 to 1000; default 5.
    pub calm: u64,
    /// How often velocities are set to zero, 0 to 1 000 000; default 100.
    pub rounds: u64,
    /// Overlap over the smaller radius that may remain, 1e-12 to 0.1; default 1e-4.
    pub overlap: f64,
    /// Most relaxation steps at the end, 1 to 100 000 000; default 20 000.
    pub steps: u64,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
}

impl Default for ExplosiveRepulsion {
    fn default() -> Self {
        Self {
            porosity: None,
            calm: 5,
            rounds: 100,
            overlap: 1e-4,
            steps: 20_000,
            orientation: Turn::Random,
        }
    }
}

impl ExplosiveRepulsion {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        validate_porosity(self.porosity)?;
        Fault::within("calm", self.calm as f64, 1.0, 1000.0)?;
        Fault::within("rounds", self.rounds as f64, 0.0, 1e6)?;
        Fault::within("overlap", self.overlap, 1e-12, 0.1)?;
        Fault::within("steps", self.steps as f64, 1.0, 1e8)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let here = |fault: Fault| fault.under("explosive_repulsion");
        let target = Target::of(grains, region, self.porosity).map_err(here)?;
        let space = Space::of(region);
        let Some(centres) = scatter::anywhere(&space, &target.radii, seed) else {
            return Err(here(scatter::no_inside()));
        };
        let smallest = target.radii.iter().copied().fold(f64::INFINITY, f64::min);
        let mut soft = Soft::new(space, centres, target.radii.clone());
        let calmed = soft.calm(self.rounds, self.calm, 0.1 * smallest, job);
        let mut relaxed = soft.relax(self.overlap, 1e-5, self.steps, job);
        relaxed.steps += calmed;
        let mut kept = balls_of(&soft);
        kept.retain(|(_, ball)| space.clearance(&ball.centre) >= 0.0);
        let why = format!(
            "{}; {} escaped",
            ending(&soft, &relaxed, region, target.closest),
            grains.len() - kept.len()
        );
        Ok(dress::laid(grains, &kept, space.dimension, self.orientation, seed, &why))
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{brute_force, of, room, sphere};
    use super::super::{Method, pack};
    use super::*;

    #[test]
    fn random_overlaps_are_pushed_apart_and_nothing_escapes() {
        for dimension in [2, 3] {
            let clumps: Vec<_> =
                (0..150).map(|i| sphere(0.04 + 0.0004 * f64::from(i), dimension)).collect();
            let grains = of(&clumps);
            let porosity = if dimension == 2 { 0.3 } else { 0.52 };
            let method = Method::ExplosiveRepulsion(ExplosiveRepulsion {
                porosity: Some(porosity),
                ..ExplosiveRepulsion::default()
            });
            let region = room(&vec![1.0; dimension]);
            let packing = pack(&grains, &[], &region, &method, 1, &Job::quiet()).expect("right");
            assert!(packing.outcome.starts_with("target met"), "{}", packing.outcome);
            assert!(packing.outcome.contains("; 0 escaped"), "{}", packing.outcome);
            let (gap, wall) = brute_force(&packing, &grains, &region);
            assert!(gap > -1e-4 && wall > -1e-4, "{gap} {wall}");
        }
    }
}
