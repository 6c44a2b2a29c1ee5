//! A sphere on a wall: the case of [`super::contact`], here and in the outside solvers.

use super::models;
use crate::model::{Contact, Model, Motion, Scheme, restitution};
use crate::num::Vec3;

/// Radius, m; density, kg/m³; stiffness, N/m; restitution; speed, m/s.
const RADIUS: f64 = 0.01;
const DENSITY: f64 = 2500.0;
const KN: f64 = 1e5;
pub const RESTITUTION: f64 = 0.5;
pub const SPEED: f64 = 1.0;

/// A sphere that meets a wall after `phase` of a step.
pub fn impact(scheme: Scheme, per_contact: f64, phase: f64) -> Model {
    let mass = DENSITY * std::f64::consts::PI * 4.0 / 3.0 * RADIUS.powi(3);
    // A restitution between 0 and 1 always has a dashpot.
    let cn = restitution::dashpot(RESTITUTION, KN, mass, false).unwrap_or(0.0);
    let contact = Contact { kn: KN, kt: 0.0, cn, ct: 0.0, friction: 0.0 };
    let mut model = models::empty(scheme, contact, DENSITY);
    model.plan.step = std::f64::consts::PI * (mass / KN).sqrt() / per_contact;
    model.plan.steps = (2.0 * per_contact) as u64;
    // The error of coarse steps is what is asked for.
    model.plan.insist = true;
    models::plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    let height = RADIUS + SPEED * model.plan.step * phase;
    models::sphere(&mut model, Vec3::z() * height, RADIUS, DENSITY, -Vec3::z() * SPEED);
    model
}
