//! Forces at walls besides the linear contact, but for those at a distance at meshes (see
//! [`super::meshes`]): planes are looked at one by one; laws of contact act at triangles that the
//! contact pass found touching, resistance to rolling at the deepest of a mesh only.
//! O(spheres × planes + listed triangles); cannot fail.

use super::Effect;
use super::memory::{Memory, normal_force, roll, wet};
use crate::dem::attraction::{self, Between};
use crate::dem::law::Rule;
use crate::dem::neighbours;
use crate::dem::rolling::Turn;
use crate::dem::setting::{Setting, wall_spin};
use crate::dem::state::State;
use crate::dem::surface;
use crate::model::Scheme;
use crate::model::extra::PairForces;
use crate::num::Vec3;

/// A sphere near a wall.
struct Spot<'a> {
    slot: usize,
    wall: usize,
    /// Place of its memory.
    key: usize,
    normal: Vec3,
    between: Between,
    forces: &'a PairForces,
    material: u16,
    velocity: Vec3,
    spin: Vec3,
    /// Part of the overlap taken from the radius to give the lever arm.
    share: f64,
    /// False for faces of a mesh that is not at its deepest here.
    rolls: bool,
}

/// Calls `visit` for every sphere and wall with a law besides the linear contact.
fn each_wall<'a>(
    setting: &'a Setting<'_>,
    state: &State,
    time: f64,
    mut visit: impl FnMut(Spot<'a>),
) {
    let model = setting.model;
    let walls = model.walls.len();
    for (index, plane) in setting.planes_at(time).iter().enumerate() {
        let wall = setting.planes[index] as usize;
        for (slot, ball) in state.balls.iter().enumerate() {
            let forces = model.extra.between(ball.material, plane.material);
            if forces.is_empty() {
                continue;
            }
            let height = (ball.place - plane.point).dot(&plane.normal);
            let away = plane.normal * height;
            visit(Spot {
                slot,
                wall,
                key: state.order[slot] as usize * walls + wall,
                normal: away / height.abs(),
                between: Between {
                    first: ball.radius,
                    second: f64::INFINITY,
                    gap: height.abs() - ball.radius,
                },
                forces,
                material: plane.material,
                velocity: plane.motion.velocity(&(ball.place - away)),
                spin: wall_spin(&plane.motion),
                share: plane.share,
                rolls: true,
            });
        }
    }
    let mut found: Vec<Spot<'_>> = Vec::new();
    for slot in 0..state.faces.start.len().saturating_sub(1) {
        let ball = &state.balls[slot];
        found.clear();
        for k in state.faces.start[slot] as usize..state.faces.start[slot + 1] as usize {
            if !state.faces.book.touching[k] {
                continue;
            }
            let face = state.faces.partner[k] as usize;
            let index = setting.surfaces.wall[face] as usize;
            let wall = &model.walls[index];
            let forces = setting.extra.at_touched_mesh(ball.material, index);
            if forces.is_empty() {
                continue;
            }
            let corners = neighbours::face_at(setting, face, time);
            let (point, _) = surface::closest(&ball.place, &corners);
            let away = ball.place - point;
            let distance = away.norm();
            found.push(Spot {
                slot,
                wall: index,
                key: state.order[slot] as usize * walls + index,
                normal: away / distance,
                between: Between {
                    first: ball.radius,
                    second: f64::INFINITY,
                    gap: distance - ball.radius,
                },
                forces,
                material: wall.material,
                velocity: setting.walls[index].motion.velocity(&point),
                spin: wall_spin(&setting.walls[index].motion),
                share: setting.share,
                rolls: false,
            });
        }
        for at in 0..found.len() {
            let (key, gap) = (found[at].key, found[at].between.gap);
            let deeper = |(other, spot): (usize, &Spot<'_>)| {
                spot.key == key && (spot.between.gap, other) < (gap, at)
            };
            found[at].rolls = !found.iter().enumerate().any(deeper);
        }
        found.drain(..).for_each(&mut visit);
    }
}

/// Potential energy at planes and of contacts with meshes, J.
pub fn energy(setting: &Setting<'_>, state: &State, memory: &[Memory], time: f64) -> f64 {
    let mut energy = 0.0;
    each_wall(setting, state, time, |spot| {
        let bridged = memory.get(spot.key).is_some_and(|memory| memory.bridged);
        energy += attraction::total(spot.forces, &spot.between, bridged).energy;
    });
    energy
}

/// Adds the forces and moments of planes, and of meshes in contact.
pub fn pass(
    setting: &Setting<'_>,
    state: &State,
    rule: &Rule,
    memories: &mut [Memory],
    effect: &mut Effect<'_>,
) {
    // A mesh that is no longer touched has no spot: its springs end here.
    let mut met = vec![false; if setting.needs.rolling { memories.len() } else { 0 }];
    each_wall(setting, state, setting.pass_time(state.step), |spot| {
        let ball = &state.balls[spot.slot];
        let touches = spot.between.gap <= 0.0;
        let bridged = match memories.get_mut(spot.key) {
            Some(memory) => {
                wet(memory, spot.forces, &spot.between, touches, rule, &mut effect.tally)
            }
            None => false,
        };
        let push = attraction::push(spot.forces, &spot.between, bridged);
        let slope = || attraction::slope(spot.forces, &spot.between, bridged);
        effect.at_wall(
            setting,
            (spot.slot, spot.wall),
            &spot.normal,
            (push, slope),
            &spot.velocity,
        );
        let (Some(law), true) = (&spot.forces.rolling, spot.rolls) else { return };
        let Some(memory) = memories.get_mut(spot.key) else { return };
        met[spot.key] = true;
        let contact = setting.pair(ball.material, spot.material);
        let mine = state.spins.get(spot.slot).copied().unwrap_or_default();
        let distance = ball.radius + spot.between.gap;
        let arm = ball.radius + spot.share * spot.between.gap;
        // LIGGGHTS takes the speed of the contact point over the distance for the spin.
        let spin = match setting.scheme {
            Scheme::Liggghts => mine * (arm / distance),
            _ => mine - spot.spin,
        };
        let factor = if setting.planar { 1.5 } else { 1.4 };
        let mass = setting.model.bodies[ball.body as usize].mass;
        let rate = (ball.velocity - spot.velocity).dot(&spot.normal);
        let turn = Turn {
            normal: spot.normal,
            spin,
            overlap: -spot.between.gap,
            radius: ball.radius,
            force: normal_force(setting, contact, -spot.between.gap, rate),
            inertia: factor * mass * ball.radius * ball.radius,
        };
        let moment =
            roll((setting, rule), (law, contact), touches, &turn, memory, &mut effect.tally);
        effect.loads[spot.slot].torque -= moment;
        effect.tally.wall_power -= moment.dot(&spot.spin);
    });
    for (memory, met) in memories.iter_mut().zip(met) {
        if !met && memory.last != Vec3::zeros() {
            effect.tally.rolling += if rule.interval > 0.0 { memory.elastic } else { 0.0 };
            *memory = Memory { bridged: memory.bridged, ..Memory::default() };
        }
    }
}
