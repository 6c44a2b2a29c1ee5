//! What LAMMPS 29 Sep 2021 cannot express or does in its own way.

use super::values;
use crate::model::{Arm, Coulomb, History, Lost, Model, Motion, WallShape};
use crate::solver::{Limit, capability, finite};

/// Relative difference up to which a single sphere's inertia counts as its own.
const ROUNDING: f64 = 1e-9;

/// All limits of `model`.
pub fn of(model: &Model) -> Vec<Limit> {
    // Numbers that are not finite are refused by name elsewhere; comparing them here would mislead.
    if finite::check(model).is_err() {
        return Vec::new();
    }
    let mut limits = Vec::new();
    features(model, &mut limits);
    law(model, &mut limits);
    bodies(model, &mut limits);
    walls(model, &mut limits);
    limits
}

fn features(model: &Model, limits: &mut Vec<Limit>) {
    let needs = model.needs();
    if model.bodies.is_empty() {
        limits.push(Limit::refused("a deck needs at least one body"));
    }
    limits.extend(capability::refusals(2, &needs));
    if model.plan.guard.lost != Lost::Stop {
        limits.push(Limit::refused(
            "bodies that go on or are taken out where they leave the domain: riprap writes no such LAMMPS deck",
        ));
    }
    let refused = [
        (
            needs.oblique_planes && needs.friction,
            "friction at oblique planes: LAMMPS' region walls gave 0.2 % less tangential velocity than its own law in a sticking impact; use LIGGGHTS or YADE",
        ),
        (
            needs.drag && needs.clumps,
            "viscous drag on clumps: not checked with fix rigid/small, so riprap writes no such deck; use LIGGGHTS",
        ),
    ];
    limits.extend(
        refused.into_iter().filter(|(there, _)| *there).map(|(_, why)| Limit::refused(why)),
    );
}

fn law(model: &Model, limits: &mut Vec<Limit>) {
    let (needs, plan) = (model.needs(), &model.plan);
    for (a, b) in values::pairs(model) {
        let contact = model.contacts.between(a, b);
        let sticks = contact.friction > 0.0;
        let name = |index: u16| model.materials[usize::from(index)].name.as_str();
        if sticks && contact.ct > 0.0 && contact.cn == 0.0 {
            limits.push(Limit::refused(format!(
                "the tangential dashpot between `{}` and `{}`: LAMMPS takes it as a multiple of the normal one, which is 0",
                name(a),
                name(b)
            )));
        }
        if sticks && contact.ct > 0.0 && contact.kt == 0.0 {
            limits.push(Limit::refused(format!(
                "friction between `{}` and `{}` of a dashpot without a spring: LAMMPS divides by kt",
                name(a),
                name(b)
            )));
        }
    }
    if needs.tangential_damping && plan.law.coulomb != Coulomb::Sum {
        limits.push(Limit::differs(
            "the Coulomb limit cuts the sum of tangential spring and dashpot",
        ));
    }
    if needs.friction && plan.law.history != History::Rescaled {
        limits.push(Limit::differs(
            "the tangential spring is projected on the turning contact plane and keeps its length",
        ));
    }
    if needs.friction && plan.law.arm != Arm::Split {
        limits.push(Limit::differs(
            "between spheres the sliding velocity is taken at R and the torque at R - overlap/2, at walls both at R",
        ));
    }
    if needs.clumps && !plan.scheme.is_richardson() {
        limits.push(Limit::differs(
            "clumps turn by the Richardson-corrected quaternion step of fix rigid",
        ));
    }
    if needs.normal_damping || needs.tangential_damping {
        limits.push(Limit::differs(
            "contact forces that are written are those of full-step velocities; the motion uses half-step ones",
        ));
    }
}

fn bodies(model: &Model, limits: &mut Vec<Limit>) {
    let needs = model.needs();
    for (index, body) in model.bodies.iter().enumerate() {
        if body.sphere_count != 1 {
            continue;
        }
        let sphere = &model.spheres_of(index)[0];
        if sphere.offset.norm() > 0.0 {
            limits.push(Limit::refused(format!(
                "body {index} is one sphere whose centre is not its centre of mass"
            )));
        }
        let factor = if needs.discs { 0.5 } else { 0.4 };
        let own = factor * body.mass * sphere.radius.powi(2);
        let axes = if needs.discs { 2..3 } else { 0..3 };
        let wrong = axes.into_iter().any(|a| (body.inertia[a] - own).abs() > ROUNDING * own);
        if needs.rotation && wrong {
            limits.push(Limit::refused(format!(
                "body {index} is one sphere whose moment of inertia is not {factor} m R^2, which LAMMPS computes with"
            )));
        }
    }
}

fn walls(model: &Model, limits: &mut Vec<Limit>) {
    for wall in &model.walls {
        let plane = matches!(wall.shape, WallShape::Plane { .. });
        if matches!(wall.motion, Motion::Oscillate { .. }) {
            limits.push(Limit::refused(format!(
                "wall `{}` oscillates: riprap writes no such LAMMPS walls; use LIGGGHTS or YADE",
                wall.name
            )));
        }
        let pushes = matches!(wall.motion, Motion::Translate { velocity } if velocity.norm() > 0.0);
        if plane && pushes && !values::is_primitive(wall) {
            limits.push(Limit::differs(format!(
                "wall `{}`: in the set-up pass the moving region has no velocity yet",
                wall.name
            )));
        }
    }
}
