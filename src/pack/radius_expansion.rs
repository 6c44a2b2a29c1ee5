//! Radius expansion (P10): grains start small without overlap and grow to the target porosity.
//!
//! Source: the generation procedure of particle flow codes (Itasca, PFC, GENERATE). Final radii
//! R_i = m r_i with m from the porosity n: in two dimensions Σ π R_i² = (1 − n) A. They start as R_i / s
//! with s = 1.6, that is at the porosity n0 = 1 − (1 − n)/s² (s³ in three dimensions), at random places
//! without overlap. Then in `stages`: all radii times s^(1/stages), balls to rest. After each stage the
//! porosity is measured and the factor mended: R = r ((1 − n)/(1 − n_measured))^(1/d).
//!
//! Rest is found by a frictionless relaxation of overlaps (see [`super::soft`]), not by the DEM of a
//! run: this room stands before it. Friction, which takes energy out but hinders rearrangement,
//! is so set only in the run that follows. Cost O(near pairs) a step, some thousand steps.

use super::soft::{Relaxed, Rest, Soft};
use super::space::Space;
use super::target::{Target, ball_volume, validate_porosity};
use super::{Grain, Laid, Turn, dress, scatter};
use crate::geometry::{Ball, Region};
use crate::num::{Fault, Job};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of radius expansion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RadiusExpansion {
    /// Porosity of the container that sizes are multiplied for, 0.01 to 0.999; default: sizes as they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub porosity: Option<f64>,
    /// Final radius over the radius at the start, 1 to 10; default 1.6.
    pub start: f64,
    /// Stages of growth, 1 to 1000; default 10.
    pub stages: u32,
    /// Overlap over the smaller radius that may remain, 1e-12 to 0.1; default 1e-4.
    pub overlap: f64,
    /// Most relaxation steps in all, 1 to 100 000 000; default 20 000.
    pub steps: u64,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
}

impl Default for RadiusExpansion {
    fn default() -> Self {
        Self {
            porosity: None,
            start: 1.6,
            stages: 10,
            overlap: 1e-4,
            steps: 20_000,
            orientation: Turn::Random,
        }
    }
}

impl RadiusExpansion {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        validate_porosity(self.porosity)?;
        Fault::within("start", self.start, 1.0, 10.0)?;
        Fault::within("stages", f64::from(self.stages), 1.0, 1000.0)?;
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
        let target = Target::of(grains, region, self.porosity)
            .map_err(|fault| fault.under("radius_expansion"))?;
        let space = Space::of(region);
        let Some((soft, relaxed)) = self.expand(&space, &target.radii, seed, job) else {
            return Err(scatter::no_inside().under("radius_expansion"));
        };
        let why = ending(&soft, &relaxed, region, target.closest);
        let balls = balls_of(&soft);
        Ok(dress::laid(grains, &balls, space.dimension, self.orientation, seed, &why))
    }

    /// Balls of `radii` (m) in `space`, grown from small ones; `None` if it has no inside.
    pub fn expand<'a>(
        &self,
        space: &Space<'a>,
        radii: &[f64],
        seed: u64,
        job: &Job,
    ) -> Option<(Soft<'a>, Relaxed)> {
        let small: Vec<f64> = radii.iter().map(|radius| radius / self.start).collect();
        let (centres, _) = scatter::apart(space, &small, 1000, seed)?;
        let mut soft = Soft::new(*space, centres, small);
        let wanted = ball_volume(radii, space.dimension);
        let mut left = self.steps;
        for stage in 1..self.stages {
            soft.grow(self.start.powf(1.0 / f64::from(self.stages)));
            // What lies between stages need not be quite at rest.
            let most = left.min(self.steps / u64::from(2 * self.stages));
            left -= soft.relax(10.0 * self.overlap, 1e-2, most, job).steps;
            job.report("stages", u64::from(stage), u64::from(self.stages));
        }
        // The last stage mends what rounding has left of the porosity.
        let measured = ball_volume(&soft.radii, space.dimension);
        soft.grow((wanted / measured.max(f64::MIN_POSITIVE)).powf(1.0 / space.dimension as f64));
        let mut relaxed = soft.relax(self.overlap, 1e-5, left, job);
        relaxed.steps += self.steps - left;
        Some((soft, relaxed))
    }
}

/// Each grain's ball.
pub(super) fn balls_of(soft: &Soft) -> Vec<(usize, Ball)> {
    let ball =
        |(centre, radius): (&crate::num::Vec3, &f64)| Ball { centre: *centre, radius: *radius };
    soft.centres.iter().zip(&soft.radii).map(ball).enumerate().collect()
}

/// How a relaxation to a target ended, in one clause.
pub(super) fn ending(
    soft: &Soft,
    relaxed: &Relaxed,
    region: &Region,
    closest: Option<f64>,
) -> String {
    let fraction = ball_volume(&soft.radii, region.dimension()) / region.volume();
    let ended = match relaxed.rest {
        Rest::Apart => "target met".to_owned(),
        Rest::Jammed => {
            format!("jammed: overlaps up to {:.2e} of the smaller radius remain", relaxed.worst)
        }
        Rest::Steps => format!(
            "steps used up: overlaps up to {:.2e} of the smaller radius remain",
            relaxed.worst
        ),
        Rest::Cancelled => "stopped before the end".to_owned(),
    };
    let most = match closest {
        Some(most) if relaxed.rest != Rest::Apart => format!(" (estimate of the most: {most:.3})"),
        _ => String::new(),
    };
    format!("{ended} after {} steps at solid fraction {fraction:.4}{most}", relaxed.steps)
}

#[cfg(test)]
mod tests {
    use super::super::samples::{ball, brute_force, cylinder, of, room, sphere};
    use super::super::{Method, pack};
    use super::*;

    #[test]
    fn the_porosity_is_met_in_containers_of_all_kinds() {
        for (region, count) in
            [(room(&[1.0; 3]), 150), (room(&[1.0; 2]), 150), (cylinder(), 150), (ball(), 60)]
        {
            let clumps: Vec<_> = (0..count)
                .map(|i| sphere(0.05 + 0.0003 * f64::from(i), region.dimension()))
                .collect();
            let grains = of(&clumps);
            let porosity = if region.dimension() == 2 { 0.3 } else { 0.52 };
            let method = Method::RadiusExpansion(RadiusExpansion {
                porosity: Some(porosity),
                ..RadiusExpansion::default()
            });
            let packing = pack(&grains, &[], &region, &method, 1, &Job::quiet()).expect("right");
            assert!(packing.outcome.starts_with("target met"), "{}", packing.outcome);
            assert!(packing.outcome.contains("all sizes times"), "{}", packing.outcome);
            let (gap, wall) = brute_force(&packing, &grains, &region);
            assert!(gap > -2e-4 * 0.2 && wall > -2e-4 * 0.2, "{gap} {wall}");
            let m = packing.measures;
            assert!((m.porosity - porosity).abs() < 5.0 * m.porosity_error + 1e-3, "{m:?}");
        }
    }

    #[test]
    fn what_jams_says_so() {
        let clumps = vec![sphere(0.07, 3); 120];
        let method = Method::RadiusExpansion(RadiusExpansion {
            porosity: Some(0.36),
            steps: 1500,
            ..RadiusExpansion::default()
        });
        let packing =
            pack(&of(&clumps), &[], &room(&[1.0; 3]), &method, 1, &Job::quiet()).expect("right");
        assert!(
            packing.outcome.contains("remain") && packing.measures.worst_overlap > 1e-3,
            "{}",
            packing.outcome
        );
    }
}
