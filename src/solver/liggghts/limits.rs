//! What LIGGGHTS 3.8.0 cannot express or does in its own way.

use super::{arrivals, multisphere, values};
use crate::geometry::Mesh;
use crate::model::extra::{Cohesion, Rolling};
use crate::model::{Arm, Coulomb, History, Lost, Model, Motion, PairForces, Scheme, WallShape};
use crate::solver::mesh_check::{MeshFacts, inspect};
use crate::solver::{Limit, capability, finite, restart_springs, single};

/// Below this it ends whatever the setting, rad (0.0573 degrees).
const HARD_CURVATURE: f64 = 0.0573 / 180.0 * std::f64::consts::PI;
/// Most triangles that may share one edge.
const MOST_ON_AN_EDGE: usize = 6;

/// All limits of `model`.
pub fn of(model: &Model) -> Vec<Limit> {
    // Numbers that are not finite are refused by name elsewhere; comparing them here would mislead.
    if finite::check(model).is_err() {
        return Vec::new();
    }
    let mut limits = Vec::new();
    law(model, &mut limits);
    limits.extend(single::limits(model, "LIGGGHTS"));
    limits.extend(multisphere::limits(model));
    limits.extend(arrivals::limits(model));
    limits.extend(restart_springs::limits(model, "LIGGGHTS", values::is_primitive));
    walls(model, &mut limits);
    limits
}

fn law(model: &Model, limits: &mut Vec<Limit>) {
    let (needs, plan) = (model.needs(), &model.plan);
    if model.bodies.is_empty() {
        limits.push(Limit::refused("a deck needs at least one body"));
    }
    limits.extend(capability::refusals(0, &needs));
    match plan.guard.lost {
        Lost::Stop => {}
        Lost::Remove if needs.clumps => limits.push(Limit::refused(
            "clumps that are taken out where they leave the domain: fix rigid ends the run when it misses a sphere",
        )),
        Lost::Remove => limits.push(Limit::differs(
            "bodies are taken out where they leave the simulation box, which is two radii larger than the domain, when lists are built",
        )),
        Lost::GoOn => limits.push(Limit::refused(
            "bodies that go on outside the domain: LIGGGHTS deletes what leaves its box",
        )),
    }
    extra(model, limits);
    if needs.friction && needs.tangential_damping && plan.law.coulomb != Coulomb::SpringThenDashpot
    {
        limits.push(Limit::differs(
            "the Coulomb limit cuts the tangential spring only; the tangential dashpot acts on top while sticking and is off while slipping",
        ));
    }
    if needs.friction && plan.law.history != History::Projected {
        limits.push(Limit::differs(
            "the tangential spring is projected on the turning contact plane and not rescaled",
        ));
    }
    if needs.friction && (plan.law.arm, plan.law.plane_arm) != (Arm::Half, Arm::Half) {
        limits.push(Limit::differs("the lever arm is R - overlap/2 everywhere"));
    }
    if needs.clumps && !plan.scheme.is_richardson() {
        limits.push(Limit::differs(
            "clumps turn by LAMMPS' Richardson-corrected quaternion step (fix rigid, fix multisphere)",
        ));
    }
}

/// Forces besides the linear contact: one cohesion and one rolling model for the whole scene, of
/// those that LIGGGHTS shares with us.
fn extra(model: &Model, limits: &mut Vec<Limit>) {
    let needs = model.needs();
    let refused = [
        (
            needs.drag && needs.clumps && !values::points(model).is_empty(),
            "drag on clumps whose centre of mass lies outside the hull of their sphere centres: the point that carries their mass would be slowed too",
        ),
        (
            needs.clumps
                && model.extra.any(
                    |f| matches!(f.rolling, Some(Rolling::Epsd { damping, .. }) if damping > 0.0),
                ),
            "damped rolling (epsd) of clumps: LIGGGHTS takes the masses of single spheres of the clump",
        ),
    ];
    let moves = model.walls.iter().any(|wall| wall.motion.moves());
    let refused = refused.into_iter().chain([
        (
            needs.restarts && needs.clumps,
            "restarts of clumps: fix rigid and fix multisphere of LIGGGHTS take the momenta of clumps anew from their spheres; use YADE or `riprap run --resume`",
        ),
        (
            needs.restarts && moves,
            "restarts with walls that move: they would start from their files again; use YADE or `riprap run --resume`",
        ),
    ]);
    for (there, reason) in refused {
        if there {
            limits.push(Limit::refused(reason));
        }
    }
    let other = |f: &PairForces| {
        !matches!(f.cohesion, None | Some(Cohesion::Sjkr { .. } | Cohesion::Sjkr2 { .. }))
    };
    if model.extra.any(other) {
        limits.push(Limit::refused("cohesion other than sjkr and sjkr2: LIGGGHTS has none"));
    }
    if values::cohesion_model(model).is_none() {
        limits
            .push(Limit::refused("two kinds of cohesion: LIGGGHTS takes one for the whole scene"));
    }
    if values::rolling_model(model).is_none() {
        limits.push(Limit::refused(
            "two kinds of rolling resistance: LIGGGHTS takes one for the whole scene",
        ));
    }
    let spins = |body: &crate::model::Body| body.sphere_count > 1 && body.spin.norm() > 0.0;
    if !multisphere::is_used(model) && needs.normal_damping && model.bodies.iter().any(spins) {
        limits.push(Limit::differs(
            "clumps that spin and touch something at the start: dashpots see their spheres at other velocities in the set-up pass of fix rigid (decks.liggghts_clumps = \"multisphere\" does not)",
        ));
    }
    if needs.drag && !multisphere::is_used(model) && model.bodies.iter().any(spins) {
        limits.push(Limit::differs(
            "in the first half step drag sees the spheres of a spinning clump at the velocity of its centre",
        ));
    }
    if needs.rolling && needs.meshes {
        limits.push(Limit::differs(
            "rolling resistance acts at every face of a mesh that touches, not at the deepest only",
        ));
    }
}

fn walls(model: &Model, limits: &mut Vec<Limit>) {
    if model.needs().periodic && !values::surfaces(model).is_empty() {
        limits.push(Limit::refused(
            "mesh walls, oblique planes and planes that move along their normal in a periodic box: LIGGGHTS takes no mesh that reaches over a periodic side",
        ));
    }
    for wall in &model.walls {
        match wall.motion {
            Motion::Oscillate { phase: 0.0, .. } if model.plan.scheme != Scheme::Liggghts => {
                limits.push(Limit::differs(format!(
                    "wall `{}` is where the sum of its velocities times the step takes it: half a step's change of velocity off the sine",
                    wall.name
                )));
            }
            Motion::Oscillate { phase, .. } if phase != 0.0 => limits.push(Limit::refused(format!(
                "wall `{}` oscillates from a phase that is not 0: fix move/mesh wiggle starts at 0",
                wall.name
            ))),
            _ => {}
        }
    }
    for wall in model.walls.iter().filter(|wall| wall.rests_at_set_up(Scheme::Liggghts)) {
        if model.plan.scheme != Scheme::Liggghts {
            limits.push(Limit::differs(format!(
                "wall `{}` has no velocity in the set-up pass: what touches it at the start feels its motion one step later",
                wall.name
            )));
        }
    }
    for wall in &model.walls {
        let WallShape::Mesh { mesh } = &wall.shape else { continue };
        let facts = inspect(mesh);
        mesh_faults(&wall.name, mesh, &facts, limits);
        if facts.crowd > 1 {
            limits.push(Limit::differs(format!(
                "wall `{}`: at an inner edge bent by more than its curvature angle LIGGGHTS counts one contact per face",
                wall.name
            )));
        }
    }
}

fn mesh_faults(name: &str, mesh: &Mesh, facts: &MeshFacts, limits: &mut Vec<Limit>) {
    match facts.sharpest {
        None => limits.push(Limit::refused(format!("wall `{name}` has no triangles"))),
        Some((angle, index)) if angle < HARD_CURVATURE => limits.push(Limit::refused(format!(
            "wall `{name}`: triangle {index} has an angle of {:.4} degrees; LIGGGHTS takes none below 0.0573",
            angle.to_degrees()
        ))),
        Some((angle, index)) if angle < values::DEFAULT_CURVATURE => limits.push(Limit::differs(format!(
            "wall `{name}`: triangle {index} has an angle of {:.4} degrees; the deck sets `curvature` below it, so that flatter bends than the default count as edges",
            angle.to_degrees()
        ))),
        Some(_) => {}
    }
    if let Some((first, second)) = facts.duplicate {
        limits.push(Limit::refused(format!(
            "wall `{name}`: triangles {first} and {second} are the same; contacts would count twice"
        )));
    }
    if facts.crowd > MOST_ON_AN_EDGE {
        limits.push(Limit::refused(format!(
            "wall `{name}`: {} triangles share one edge; LIGGGHTS takes at most {MOST_ON_AN_EDGE}",
            facts.crowd
        )));
    }
    let size = mesh.bounds().size().max();
    if size < 1e-4 {
        limits.push(Limit::refused(format!(
            "wall `{name}` is {size} m in size; LIGGGHTS takes no mesh that small in SI units"
        )));
    }
}
