//! Bodies of one sphere, as LIGGGHTS and LAMMPS have them: the sphere is centred on the centre of
//! mass and has the moment of inertia that follows from its mass and radius.

use super::Limit;
use crate::model::Model;

/// Relative difference up to which a sphere's moment of inertia counts as its own.
const ROUNDING: f64 = 1e-9;

/// Bodies of one sphere that the solver of this name would take for others.
pub fn limits(model: &Model, solver: &str) -> Vec<Limit> {
    let needs = model.needs();
    let factor = if needs.discs { 0.5 } else { 0.4 };
    let axes = if needs.discs { 2..3 } else { 0..3 };
    let mut limits = Vec::new();
    for (index, body) in model.bodies.iter().enumerate().filter(|(_, b)| b.sphere_count == 1) {
        let sphere = &model.spheres_of(index)[0];
        if sphere.offset.norm() > 0.0 {
            limits.push(Limit::refused(format!(
                "body {index} is one sphere whose centre is not its centre of mass"
            )));
        }
        let own = factor * body.mass * sphere.radius.powi(2);
        let wrong = axes.clone().any(|a| (body.inertia[a] - own).abs() > ROUNDING * own);
        if needs.rotation && wrong {
            limits.push(Limit::refused(format!(
                "body {index} is one sphere whose moment of inertia is not {factor} m R^2, which {solver} computes with"
            )));
        }
    }
    limits
}
