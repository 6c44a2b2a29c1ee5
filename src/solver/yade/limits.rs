//! What YADE 2023.02a cannot express or does in its own way.

use super::{bonds, springs, values};
use crate::model::{Arm, Coulomb, History, Lost, Model, Scheme, WallShape};
use crate::solver::{Limit, capability, finite};

/// Relative difference up to which moments of inertia count as equal.
const ROUNDING: f64 = 1e-9;

/// All limits of `model`.
pub fn of(model: &Model) -> Vec<Limit> {
    // Numbers that are not finite are refused by name elsewhere; comparing them here would mislead.
    if finite::check(model).is_err() {
        return Vec::new();
    }
    let mut limits = Vec::new();
    run(model, &mut limits);
    law(model, &mut limits);
    bodies(model, &mut limits);
    materials(model, &mut limits);
    walls(model, &mut limits);
    limits
}

/// What the deck cannot do in the course of a run.
fn run(model: &Model, limits: &mut Vec<Limit>) {
    let (needs, plan) = (model.needs(), &model.plan);
    if model.bodies.is_empty() {
        limits.push(Limit::refused("a deck needs at least one body"));
    }
    if needs.zeroing && needs.clumps {
        limits
            .push(Limit::refused("velocities set to zero every so many steps, with rigid clumps"));
    }
    if plan.guard.lost == Lost::Remove && (needs.clumps || needs.zeroing) {
        limits.push(Limit::refused(
            "bodies that are taken out where they leave the domain, with rigid clumps or velocities set to zero: riprap writes no such YADE deck",
        ));
    }
    if needs.restarts && (needs.bonds || plan.guard.lost == Lost::Remove) {
        limits.push(Limit::refused(
            "restarts with bonds, or of spheres that are taken out: what broke and what left is kept by the script, not by O.save; use `riprap run --resume`",
        ));
    }
    let refused = [
        (needs.clumps, "with rigid clumps"),
        (needs.periodic, "in a periodic box"),
        (needs.restarts, "with restarts"),
        (
            needs.zeroing || plan.guard.lost == Lost::Remove,
            "with velocities set to zero or spheres taken out",
        ),
    ];
    for (_, what) in refused.iter().filter(|(there, _)| needs.arrivals && *there) {
        limits.push(Limit::refused(format!(
            "grains inserted over time {what}: riprap writes no such YADE deck; use spheres that come into an ordinary run"
        )));
    }
    limits.extend(bonds::limits(model));
    limits.extend(springs::limits(model));
    limits.extend(capability::refusals(1, &needs));
    if let Some(cell) = &model.periodic {
        if needs.discs || cell.periodic != [true; 3] {
            limits.push(Limit::refused(
                "a box that is periodic along some axes only (or in two dimensions): YADE's cells repeat along all three",
            ));
        } else if !model.walls.is_empty() {
            limits.push(Limit::refused(
                "walls in a box that is periodic along all axes: in YADE they would meet their own images",
            ));
        }
    }
}

/// In what contacts and motion differ.
fn law(model: &Model, limits: &mut Vec<Limit>) {
    let (needs, plan) = (model.needs(), &model.plan);
    if plan.law.tension && needs.normal_damping {
        limits.push(Limit::differs("the normal force never pulls: it is cut at 0 (ViscEl law)"));
    }
    if needs.tangential_damping && plan.law.coulomb != Coulomb::SpringThenDashpot {
        limits.push(Limit::differs(
            "the Coulomb limit cuts the tangential spring only; the tangential dashpot acts on top while sticking and is off while slipping",
        ));
    }
    if needs.friction && plan.law.history != History::Rotated {
        limits.push(Limit::differs(
            "the tangential spring is turned with the contact to first order and not projected",
        ));
    }
    if needs.friction && needs.planes && plan.law.plane_arm != Arm::Full {
        limits.push(Limit::differs("the lever arm at axis-aligned planes is R - overlap"));
    }
    if needs.friction && plan.law.arm != Arm::Half {
        limits.push(Limit::differs("the lever arm is R - overlap/2 but at axis-aligned planes"));
    }
    if plan.scheme != Scheme::Yade {
        limits.push(Limit::differs(
            "velocities are given and written half a step before positions (leapfrog)",
        ));
        if needs.clumps && !needs.discs {
            limits.push(Limit::differs(
                "clumps turn by a scheme of first order in the time step, which gains energy",
            ));
        }
    }
    if needs.tangential_damping {
        limits.push(Limit::differs(
            "tangential contact forces that are written are those of the springs, without dashpots",
        ));
    }
}

fn bodies(model: &Model, limits: &mut Vec<Limit>) {
    let needs = model.needs();
    for (index, body) in model.bodies.iter().enumerate() {
        if body.sphere_count != 1 {
            continue;
        }
        if model.spheres_of(index)[0].offset.norm() > 0.0 {
            limits.push(Limit::refused(format!(
                "body {index} is one sphere whose centre is not its centre of mass"
            )));
        }
        let (least, most) = (body.inertia.min(), body.inertia.max());
        if needs.rotation && !needs.discs && most - least > ROUNDING * most {
            limits.push(Limit::refused(format!(
                "body {index} is one sphere with three different moments of inertia"
            )));
        }
    }
}

/// Pairs of materials that no per-material values can give.
fn materials(model: &Model, limits: &mut Vec<Limit>) {
    if let Err(faults) = values::materials(model) {
        limits.extend(faults.into_iter().map(Limit::refused));
    }
}

fn walls(model: &Model, limits: &mut Vec<Limit>) {
    for wall in &model.walls {
        match &wall.shape {
            WallShape::Mesh { mesh } if mesh.triangles.is_empty() => {
                limits.push(Limit::refused(format!("wall `{}` has no triangles", wall.name)));
            }
            WallShape::Mesh { mesh } if mesh.triangles.len() > 1 => {
                limits.push(Limit::differs(format!(
                    "wall `{}`: a sphere near an edge or corner shared by facets touches each of them (two facets: twice the force)",
                    wall.name
                )));
            }
            _ => {}
        }
    }
}
