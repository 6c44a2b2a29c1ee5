//! Clumps of equal volume and mass in the places of spheres (P16).
//!
//! Source: the PFC2D note on particle generation: spheres are packed to a porosity, each is replaced by a clump of the
//! same volume and mass, and the clumps relax with all velocities set to zero every
//! 5 steps. Here the spheres are packed by any other method, given in `spheres`; a sphere has the volume
//! of the grain that will replace it, and what the method does to its size is done to the grain. A material has one density,
//! so equal volume is equal mass. Clumps are turned at random and then pushed apart as rigid
//! bodies (see `rigid.rs`). Cost: that of the method for spheres and O(rounds · near pairs of spheres).

use super::rigid::calm;
use super::space::Space;
use super::{Grain, Laid, Method, PackError, RadiusExpansion, Turn, pack};
use crate::clump::{Clump, disc, sphere};
use crate::geometry::Region;
use crate::num::random::stream;
use crate::num::{Fault, Job};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of clumps in place of spheres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Replace {
    /// How the spheres are packed: any method but `replace` and `placed`; default `radius_expansion`.
    pub spheres: Box<Method>,
    /// Steps after which velocities are set to zero, 1 to 1000; default 5.
    pub zero_every: u32,
    /// Most rounds of so many steps, 1 to 10 000 000; default 2000.
    pub rounds: u32,
    /// Overlap over the smaller radius that may remain, 1e-9 to 0.1; default 1e-3.
    pub overlap: f64,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
}

impl Default for Replace {
    fn default() -> Self {
        Self {
            spheres: Box::new(Method::RadiusExpansion(RadiusExpansion::default())),
            zero_every: 5,
            rounds: 2000,
            overlap: 1e-3,
            orientation: Turn::Random,
        }
    }
}

impl Replace {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        if matches!(*self.spheres, Method::Replace(_) | Method::Placed(_)) {
            let problem = format!("is `{}`", self.spheres.key());
            return Err(Fault::new("spheres", problem, "a method that packs spheres by itself"));
        }
        self.spheres.validate().map_err(|fault| fault.under("spheres"))?;
        Fault::within("zero_every", f64::from(self.zero_every), 1.0, 1000.0)?;
        Fault::within("rounds", f64::from(self.rounds), 1.0, 1e7)?;
        Fault::within("overlap", self.overlap, 1e-9, 0.1)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        families: &[&str],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, PackError> {
        let dimension = region.dimension();
        let spheres: Vec<Clump> =
            grains.iter().map(|grain| of_same_volume(grain.clump, dimension)).collect();
        let stand_ins: Vec<Grain> = grains
            .iter()
            .zip(&spheres)
            .map(|(grain, clump)| Grain { clump, solid: None, family: grain.family })
            .collect();
        let first = pack(&stand_ins, families, region, &self.spheres, seed, job)?;
        let mut placements = first.placements;
        for laid in &mut placements {
            let mut source = stream(seed, "pack.replace", u64::from(laid.grain));
            laid.orientation =
                self.orientation.draw(&grains[laid.grain as usize], dimension, &mut source);
        }
        let space = Space::of(region);
        let (every, rounds) = (self.zero_every, self.rounds);
        let calmed = calm(&mut placements, grains, &space, every, rounds, self.overlap, job);
        let escaped = placements.iter().filter(|p| region.clearance(&p.position) < 0.0).count();
        let outcome = format!(
            "spheres of equal volume by {}: {}; each replaced by its grain of the same volume and mass; {} after {} rounds of {every} steps, velocities set to zero after each; worst overlap {:.3e} of the smaller radius; {escaped} escaped",
            self.spheres.key(),
            first.outcome,
            calmed.end,
            calmed.rounds,
            calmed.worst,
        );
        Ok(Laid { placements, dropped: first.dropped, outcome })
    }
}

/// The sphere (disc) that has the volume of a clump.
fn of_same_volume(clump: &Clump, dimension: usize) -> Clump {
    use std::f64::consts::PI;
    match dimension {
        2 => disc(&clump.name, (clump.volume / PI).sqrt()),
        _ => sphere(&clump.name, (0.75 * clump.volume / PI).cbrt()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Packing;
    use super::super::samples::{brute_force, clump, dumbbell, of, periodic_room, room};
    use super::*;
    use crate::geometry::Ball;
    use crate::num::Vec3;

    fn lay(grains: &[Grain], region: &Region, parameters: Replace) -> Packing {
        pack(grains, &[], region, &Method::Replace(parameters), 1, &Job::quiet()).expect("right")
    }

    #[test]
    fn clumps_take_the_places_of_spheres_and_come_apart() {
        for (dimension, repeats) in [(2, false), (3, false), (2, true), (3, true)] {
            let single = if dimension == 2 { 0.045 } else { 0.08 };
            let mut clumps = vec![dumbbell(single, 2.0 * single); 40];
            if dimension == 2 {
                let volume = 2.0 * std::f64::consts::PI * single * single;
                clumps.iter_mut().for_each(|clump| clump.volume = volume);
            }
            let grains = of(&clumps);
            let periodic = [repeats, repeats, repeats && dimension == 3];
            let region = if repeats {
                periodic_room(&vec![1.0; dimension], periodic)
            } else {
                room(&vec![1.0; dimension])
            };
            let spheres = RadiusExpansion {
                porosity: Some(if dimension == 2 { 0.4 } else { 0.6 }),
                ..RadiusExpansion::default()
            };
            let parameters = Replace {
                spheres: Box::new(Method::RadiusExpansion(spheres)),
                ..Replace::default()
            };
            let packing = lay(&grains, &region, parameters.clone());
            let target = if dimension == 2 { 0.4 } else { 0.6 };
            assert!((packing.measures.porosity - target).abs() < 0.01, "{}", packing.outcome);
            assert!(packing.outcome.contains("no overlap is above"), "{}", packing.outcome);
            assert!(packing.outcome.contains(" 0 escaped"), "{}", packing.outcome);
            let smallest =
                packing.placements.iter().map(|p| p.scale).fold(f64::INFINITY, f64::min) * single;
            let (gap, wall) = brute_force(&packing, &grains, &region);
            assert!(gap >= -1.001e-3 * smallest * 1.5 && wall >= -2e-3 * smallest, "{gap} {wall}");
            assert_eq!(packing, lay(&grains, &region, parameters));
        }
    }

    #[test]
    fn no_room_is_said() {
        let balls = [-0.3, 0.0, 0.3].map(|x| Ball { centre: Vec3::new(x, 0.0, 0.0), radius: 0.15 });
        let rods = vec![clump(balls.to_vec(), 0.0424); 22];
        let parameters = Replace { rounds: 20, ..Replace::default() };
        let packing = lay(&of(&rods), &room(&[1.2; 3]), parameters);
        assert!(!packing.outcome.contains("no overlap is above"), "{}", packing.outcome);
        assert!(packing.measures.worst_overlap > 1e-3);
    }

    #[test]
    fn wrong_parameters_name_their_key() {
        let fault = |p: Replace| Method::Replace(p).validate().expect_err("is wrong").key;
        let nested = Replace {
            spheres: Box::new(Method::Replace(Replace::default())),
            ..Replace::default()
        };
        assert_eq!(fault(nested), "replace.spheres");
        assert_eq!(fault(Replace { zero_every: 0, ..Replace::default() }), "replace.zero_every");
    }
}
