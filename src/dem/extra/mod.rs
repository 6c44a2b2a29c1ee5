//! The pass for forces besides the linear contact: attraction, rolling resistance, drag.
//! It is not made in scenes that have none of them ([`crate::model::Needs::extra`]).
//!
//! It has lists of its own: pairs of spheres of different bodies nearer than the reach of
//! their laws and their leeways ([`pairs`]), and parts of meshes near a sphere ([`meshes`]), by the spheres'
//! numbers, built when the contact lists are built. So lists of contacts stay short, and whatever the
//! laws remember (bridges, rolling springs) stays with the spheres however memory is ordered. Planes are
//! looked at one by one ([`walls`]).
//!
//! Energy: attraction is a potential; a bridge that forms frees its potential at once, which is
//! counted; resistance takes the mean of the moments at both ends of an interval times the angle
//! in between, less what its spring stores: of second order in the step, but for
//! `path_averaged`, where it is of first order.
//! One thread; O(N log N) to build, O(pairs) a pass, 100 bytes a pair that remembers, else 4. Cannot fail.

mod complex;
mod memory;
mod meshes;
mod pairs;
mod walls;

use super::attraction;
use super::law::{Rule, Tally};
use super::rolling;
use super::servo::Attraction;
use super::setting::Setting;
use super::state::{Load, State};
use crate::model::extra::PairForces;
use crate::model::{Contact, Model, Motion, Scheme};
use crate::num::Vec3;
use complex::Complex;
use memory::Memory;
use serde::{Deserialize, Serialize};

/// What is near each sphere, and what is remembered of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Links {
    /// `State::rebuilds` for which the lists were built.
    built: u64,
    pairs: pairs::Partners,
    meshes: meshes::Shores,
    /// One a sphere and wall; empty if nothing is remembered.
    walls: Vec<Memory>,
}

impl Links {
    /// Finds all that is within reach; memories go over.
    fn rebuild(&mut self, setting: &Setting<'_>, state: &State) {
        self.pairs.rebuild(setting, state);
        self.meshes.rebuild(setting, state);
        if (setting.needs.rolling || setting.needs.bridges) && self.walls.is_empty() {
            let model = setting.model;
            self.walls = vec![Memory::default(); model.spheres.len() * model.walls.len()];
        }
        self.built = state.rebuilds;
    }

    /// The lists are built anew before the next pass.
    pub fn outdate(&mut self) {
        self.built = 0;
    }
}

/// What the pass does.
struct Effect<'a> {
    loads: &'a mut [Load],
    tally: Tally,
    /// One a wall where some wall seeks a force.
    servos: Vec<Attraction>,
}

impl Effect<'_> {
    /// A wall pushes a sphere along `normal` by `push` [N], which changes with the gap by `slope` [N/m];
    /// `velocity` is that of the wall there, m/s.
    fn at_wall(
        &mut self,
        setting: &Setting<'_>,
        (slot, wall): (usize, usize),
        normal: &Vec3,
        (push, slope): (f64, impl Fn() -> f64),
        velocity: &Vec3,
    ) {
        let force = normal * push;
        self.loads[slot].force += force;
        self.tally.wall_power += force.dot(velocity);
        let Some(servo) = self.servos.get_mut(wall) else { return };
        if let Motion::Servo { direction, .. } = &setting.model.walls[wall].motion {
            let along = normal.dot(direction);
            servo.force += push * along;
            servo.stiffness += slope().abs() * along * along;
        }
    }
}

/// Table of fixed values.
#[derive(Debug, Clone, Default)]
pub struct Fixed {
    /// Charge of each sphere, C; empty without charges.
    charge: Vec<f64>,
    /// Meshes that act at a distance.
    complex: Complex,
    /// Forces of meshes at a distance, and those in contact only: materials × walls.
    at_meshes: Vec<[PairForces; 2]>,
    walls: usize,
}

impl Fixed {
    /// Reads a model.
    pub fn new(model: &Model) -> Self {
        let complex = Complex::new(model);
        let needs = model.needs();
        let materials =
            if needs.meshes && needs.extra() { model.contacts.size() as u16 } else { 0 };
        let mut at_meshes = Vec::new();
        for material in 0..materials {
            at_meshes.extend(model.walls.iter().map(|wall| {
                let forces = model.extra.between(material, wall.material);
                [forces.at_a_distance(), forces.in_contact()]
            }));
        }
        Self { charge: charges(model), complex, at_meshes, walls: model.walls.len() }
    }

    /// Forces of a mesh at a distance on spheres of a material.
    fn at_mesh(&self, material: u16, wall: usize) -> &PairForces {
        &self.at_meshes[material as usize * self.walls + wall][0]
    }

    /// Forces of a mesh on spheres of a material that it touches.
    fn at_touched_mesh(&self, material: u16, wall: usize) -> &PairForces {
        &self.at_meshes[material as usize * self.walls + wall][1]
    }
}

fn charges(model: &Model) -> Vec<f64> {
    let mut charge = Vec::new();
    if model.extra.charges.is_none() {
        return charge;
    }
    let volume = |radius: f64| radius.powi(model.dimension.count() as i32);
    charge.reserve(model.spheres.len());
    for (index, body) in model.bodies.iter().enumerate() {
        let spheres = model.spheres_of(index);
        let whole: f64 = spheres.iter().map(|sphere| volume(sphere.radius)).sum();
        let total = model.extra.charge(body.material);
        charge.extend(spheres.iter().map(|sphere| total * volume(sphere.radius) / whole));
    }
    charge
}

/// Contact parameters with the stiffness of attraction and rolling added, for the step limit:
/// kn + the largest slope of the central laws, kt + the rotational stiffness over R*².
/// Row by row, materials × materials; radii are the largest of each material, and for molecular
/// laws, which are stiffer the smaller the gap, that makes the bound safe.
pub fn stiffened(model: &Model) -> Vec<Contact> {
    let size = model.contacts.size() as u16;
    let largest = |material: u16| {
        let mine =
            model.spheres.iter().filter(|s| model.bodies[s.body as usize].material == material);
        mine.map(|s| s.radius).fold(0.0, f64::max)
    };
    let radii: Vec<f64> = match model.needs().extra() {
        true => (0..size).map(largest).collect(),
        false => vec![0.0; size as usize],
    };
    (0..size)
        .flat_map(|a| (0..size).map(move |b| (a, b)))
        .map(|(a, b)| {
            let mut contact = *model.contacts.between(a, b);
            let forces = model.extra.between(a, b);
            if forces.is_empty() {
                return contact;
            }
            let (first, second) = (radii[a as usize], radii[b as usize]);
            // A material of walls only has no radius: it is a plane.
            let plane = |radius: f64| if radius > 0.0 { radius } else { f64::INFINITY };
            let (first, second) = (first.max(second), plane(first.min(second)));
            if first > 0.0 {
                let walls = attraction::stiffness(forces, first, f64::INFINITY);
                let pairs = attraction::stiffness(forces, first, second);
                contact.kn += if model.walls.is_empty() { pairs } else { walls.max(pairs) };
            }
            if let Some(law) = &forces.rolling {
                contact.kt += rolling::stiffness(law, &contact);
            }
            contact
        })
        .collect()
}

/// Potential energy of attraction and energy in rolling springs, J.
pub fn stored(setting: &Setting<'_>, state: &State) -> (f64, f64) {
    if !setting.needs.extra() {
        return (0.0, 0.0);
    }
    let links = &state.links;
    let time = state.step as f64 * setting.step;
    let (pairs, rolling) = links.pairs.stored(setting, state);
    let planes = walls::energy(setting, state, &links.walls, time);
    let meshes = meshes::energy(setting, state, &links.meshes, time);
    let elastic: f64 = links.walls.iter().map(|memory| memory.elastic).sum();
    (pairs + planes + meshes, rolling + elastic)
}

/// Adds all forces and moments to the loads; returns the energies, and what walls do where some
/// seek a force.
pub fn pass(setting: &Setting<'_>, state: &mut State, rule: &Rule) -> (Tally, Vec<Attraction>) {
    if !setting.needs.extra() {
        return Default::default();
    }
    // Taken out, so that the rest of the state can be read meanwhile.
    let mut links = std::mem::take(&mut state.links);
    if links.built != state.rebuilds {
        links.rebuild(setting, state);
    }
    let mut loads = std::mem::take(&mut state.loads);
    let servos = if setting.needs.servo_walls { setting.model.walls.len() } else { 0 };
    let mut effect = Effect {
        loads: &mut loads,
        tally: Tally::default(),
        servos: vec![Attraction::default(); servos],
    };
    pairs::pass(setting, state, rule, &mut links.pairs, &mut effect);
    walls::pass(setting, state, rule, &mut links.walls, &mut effect);
    meshes::pass(setting, state, rule, &mut links.meshes, &mut effect);
    let Effect { tally, servos, .. } = effect;
    (state.links, state.loads) = (links, loads);
    (tally, servos)
}

/// Drag on every sphere; returns its power, W. The velocities are those at the time of the
/// pass for single spheres, half a step earlier for members of clumps (first order).
pub fn drag(setting: &Setting<'_>, state: &mut State, first: bool) -> f64 {
    let drag = setting.model.extra.drag;
    if drag == 0.0 {
        return 0.0;
    }
    let ahead = if first && setting.scheme != Scheme::Yade { 0.0 } else { 0.5 * setting.step };
    let mut power = 0.0;
    for (slot, (ball, load)) in state.balls.iter().zip(&mut state.loads).enumerate() {
        let pull = ball.velocity * drag;
        load.force -= pull;
        let mut velocity = ball.velocity;
        if ball.alone {
            velocity += (load.force * state.light.at(slot).mass + setting.gravity) * ahead;
        }
        power += pull.dot(&velocity);
    }
    power
}

/// What cannot be computed as the model asks for, in words.
pub fn problem(model: &Model) -> Option<String> {
    let size = model.contacts.size() as u16;
    for (a, b) in (0..size).flat_map(|a| (a..size).map(move |b| (a, b))) {
        let forces = model.extra.between(a, b);
        if let Err(fault) = forces.validate() {
            return Some(format!("the forces between materials {a} and {b}: {fault}"));
        }
        let law = model.contacts.between(a, b);
        if forces.rolling.is_some() && !(law.friction > 0.0 && law.kt > 0.0) {
            return Some(format!(
                "materials {a} and {b} resist rolling but have no friction with kt > 0, so that nothing rolls"
            ));
        }
    }
    None
}
