//! What LAMMPS 29 Sep 2021 cannot express or does in its own way.

use super::values;
use crate::model::{Arm, Coulomb, History, Lost, Model, Motion, Scheme, Wall};
use crate::solver::{Limit, capability, finite, restart_springs, single};

/// All limits of `model`.
pub fn of(model: &Model) -> Vec<Limit> {
    // Numbers that are not finite are refused by name elsewhere; comparing them here would mislead.
    if finite::check(model).is_err() {
        return Vec::new();
    }
    let mut limits = Vec::new();
    features(model, &mut limits);
    law(model, &mut limits);
    limits.extend(single::limits(model, "LAMMPS"));
    limits.extend(restart_springs::limits(model, "LAMMPS", Wall::is_primitive));
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
            needs.periodic && model.walls.iter().any(|wall| !wall.is_primitive()),
            "oblique planes and planes that move along their normal in a periodic box: LAMMPS' regions do not repeat themselves",
        ),
        (
            needs.springs
                && (values::kinds(model) > 1
                    || model.walls.iter().any(|wall| !wall.is_primitive())),
            "tangential springs at the start with bodies of several materials, oblique planes or planes that move along their normal: riprap writes no such LAMMPS deck",
        ),
        (
            needs.arrivals && (needs.clumps || needs.periodic),
            "grains inserted over time with rigid clumps or in a periodic box: riprap writes no such LAMMPS deck; use spheres that come into an ordinary run",
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
    let dashpots = needs.normal_damping || needs.tangential_damping;
    if needs.arrivals && dashpots && plan.scheme != Scheme::Lammps {
        limits.push(Limit::differs(
            "where a grain comes dashpots see the full-step velocities once (a new run command makes the set-up pass again)",
        ));
    }
    if dashpots {
        limits.push(Limit::differs(
            "contact forces that are written are those of full-step velocities; the motion uses half-step ones",
        ));
    }
}

fn walls(model: &Model, limits: &mut Vec<Limit>) {
    for wall in &model.walls {
        if matches!(wall.motion, Motion::Oscillate { .. }) {
            limits.push(Limit::refused(format!(
                "wall `{}` oscillates: riprap writes no such LAMMPS walls; use LIGGGHTS or YADE",
                wall.name
            )));
        }
        let region = wall.motion.moves() && !wall.is_primitive();
        if region && model.plan.scheme != Scheme::Lammps {
            limits.push(Limit::differs(format!(
                "wall `{}` has no velocity in the set-up pass: what touches it at the start feels its motion one step later",
                wall.name
            )));
        }
    }
}
