//! What porosity the grains shall have, whether that can be, and the sizes that give it.
//!
//! Sizes are multiplied by one factor m so that the solids fill 1 − n of the container:
//! m = ((1 − n) V / ΣV_i)^(1/d). Before any long work the solid fraction is held against
//! what is possible: spheres against random close packing of their sizes (see [`super::rods`]), discs
//! of nearly one size against the hexagonal array, which nothing exceeds (Fejes Tóth; Blind 1969: up to
//! a size ratio of 1.34). For discs of other sizes no sharp bound is known; the method then says itself that it jammed.

use super::occupied::clump_radius;
use super::rods;
use super::{Grain, Region};
use crate::num::Fault;

/// How much above the estimate of random close packing a target may be: the error of the estimate.
const ERROR: f64 = 0.01;

/// Sizes to reach, and how full the container is with them.
pub struct Target {
    /// Final radius of each grain's bounding sphere, m.
    pub radii: Vec<f64>,
    /// Solid fraction of the bounding spheres at the final radii.
    pub fraction: f64,
    /// Most that is possible at random, where known.
    pub closest: Option<f64>,
}

/// A fault for a porosity that no packing has.
pub fn validate_porosity(porosity: Option<f64>) -> Result<(), Fault> {
    match porosity {
        Some(n) => Fault::within("porosity", n, 0.01, 0.999),
        None => Ok(()),
    }
}

/// Volume (area in two dimensions) of balls.
pub fn ball_volume(radii: &[f64], dimension: usize) -> f64 {
    let unit = if dimension == 2 { 1.0 } else { 4.0 / 3.0 } * std::f64::consts::PI;
    unit * radii.iter().map(|r| r.powi(dimension as i32)).sum::<f64>()
}

impl Target {
    /// Sizes for a porosity of the container, or as they are.
    ///
    /// Errors: a solid fraction that grains of these sizes cannot have, a grain larger than the container.
    pub fn of(grains: &[Grain], region: &Region, porosity: Option<f64>) -> Result<Self, Fault> {
        let dimension = region.dimension();
        let solid: f64 = grains.iter().map(|grain| grain.clump.volume).sum();
        let factor = match porosity {
            Some(n) if solid > 0.0 => {
                ((1.0 - n) * region.volume() / solid).powf(1.0 / dimension as f64)
            }
            _ => 1.0,
        };
        let radii: Vec<f64> = grains.iter().map(|grain| clump_radius(grain) * factor).collect();
        let fraction = ball_volume(&radii, dimension) / region.volume();
        let key = if porosity.is_some() { "porosity" } else { "" };
        let closest = most(&radii, dimension);
        if let Some((most, why)) = closest.filter(|(most, _)| fraction > most + ERROR) {
            let problem = format!(
                "asks for a solid fraction of {fraction:.3}, which is above {why}, about {most:.3}"
            );
            let allowed = match porosity {
                Some(_) => format!("a porosity of {:.3} or more", 1.0 - most),
                None => "fewer or smaller grains, a larger container, or a `porosity`".to_owned(),
            };
            return Err(Fault::new(key, problem, allowed));
        }
        let size = region.bounds().size();
        let room = (0..dimension).map(|axis| size[axis]).fold(f64::INFINITY, f64::min);
        let largest = radii.iter().copied().fold(0.0, f64::max);
        if 2.0 * largest > room * (1.0 + 1e-9) {
            let problem = format!(
                "has a grain {:.4e} m across in a container {room:.4e} m wide",
                2.0 * largest
            );
            return Err(Fault::new("", problem, "grains smaller than the container"));
        }
        Ok(Self { radii, fraction, closest: closest.map(|(most, _)| most) })
    }
}

/// The most that balls of these radii can fill, and what that is.
fn most(radii: &[f64], dimension: usize) -> Option<(f64, &'static str)> {
    if dimension == 3 {
        let diameters: Vec<f64> = radii.iter().map(|radius| 2.0 * radius).collect();
        return rods::closest_of(&diameters).map(|most| (most, "random close packing of this mix"));
    }
    let low = radii.iter().copied().fold(f64::INFINITY, f64::min);
    let high = radii.iter().copied().fold(0.0, f64::max);
    let hexagonal = std::f64::consts::PI / 12.0_f64.sqrt();
    (low > 0.743 * high)
        .then_some((hexagonal, "the hexagonal array, which no discs of nearly one size exceed"))
}

#[cfg(test)]
mod tests {
    use super::super::samples::{of, room, sphere};
    use super::*;

    #[test]
    fn sizes_are_multiplied_to_the_porosity() {
        for dimension in [2, 3] {
            let clumps = vec![sphere(0.05, dimension); 100];
            let region = room(&vec![1.0; dimension]);
            let target = Target::of(&of(&clumps), &region, Some(0.4)).expect("possible");
            assert!((target.fraction - 0.6).abs() < 1e-12);
            assert!((ball_volume(&target.radii, dimension) - 0.6).abs() < 1e-12);
        }
    }

    #[test]
    fn the_impossible_is_refused_with_the_reason() {
        let clumps: Vec<_> =
            (0..500).map(|i| sphere(0.05 + 0.05 * f64::from(i) / 500.0, 3)).collect();
        let Err(fault) = Target::of(&of(&clumps), &room(&[2.0; 3]), Some(0.30)) else { panic!() };
        assert_eq!(fault.key, "porosity");
        assert!(fault.problem.contains("random close packing of this mix, about 0.65"), "{fault}");
        let flat = vec![sphere(0.05, 2); 100];
        let Err(fault) = Target::of(&of(&flat), &room(&[1.0; 2]), Some(0.08)) else { panic!() };
        assert!(fault.problem.contains("hexagonal"), "{fault}");
        let Err(fault) = Target::of(&of(&flat), &room(&[9.0, 0.09]), None) else { panic!() };
        assert!(fault.problem.contains("wide") || fault.problem.contains("hexagonal"), "{fault}");
        assert!(validate_porosity(Some(-0.1)).is_err() && validate_porosity(Some(1.5)).is_err());
    }
}
