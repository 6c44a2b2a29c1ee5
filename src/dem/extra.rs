//! The pass for forces besides the linear contact: attraction, rolling resistance, drag.
//! It is not made in scenes that have none of them ([`crate::model::Needs::extra`]).
//!
//! It has a list of its own: pairs of spheres of different bodies nearer than the reach of
//! their laws and the skin, by the spheres' numbers, built when the contact lists are built.
//! So lists of contacts stay short, and whatever the laws remember (bridges, rolling springs)
//! stays with the pair however memory is ordered. Planes are looked at one by one; at meshes
//! contact laws act where the contact pass found a triangle touching, resistance to rolling at
//! the deepest of a mesh only.
//!
//! Energy: attraction is a potential; a bridge that forms frees its potential at once, which is
//! counted; resistance takes the mean of the moments at both ends of an interval times the angle
//! in between, less what its spring stores: of second order in the step, but for
//! `path_averaged`, where it is of first order.
//! One thread; O(N log N) to build, O(pairs) a pass, 100 bytes a pair that remembers, else 4. Cannot fail.

use super::attraction::{self, Between, Central};
use super::law::{Rule, Tally};
use super::neighbours;
use super::rolling::{self, Turn};
use super::setting::{Setting, wall_spin};
use super::state::{Ball, Load, State};
use super::surface;
use crate::model::extra::PairForces;
use crate::model::{Contact, Model, Scheme, WallShape};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};

/// What a pair remembers besides its contact.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
struct Memory {
    bridged: bool,
    /// Rolling spring, N m.
    spring: Vec3,
    /// Moment at the last pass, N m.
    last: Vec3,
    /// Energy in the rolling spring, J.
    elastic: f64,
}

/// Pairs within reach, and what they remember.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Links {
    /// `State::rebuilds` for which the list was built.
    built: u64,
    /// Where the partners of each sphere of the model begin.
    start: Vec<u32>,
    /// Partners by rising number, all greater than the sphere's.
    partner: Vec<u32>,
    /// One a pair; empty if nothing is remembered.
    pairs: Vec<Memory>,
    /// One a sphere and wall; empty if nothing is remembered.
    walls: Vec<Memory>,
}

/// Table of fixed values.
#[derive(Debug, Clone, Default)]
pub struct Fixed {
    /// Charge of each sphere, C; empty without charges.
    charge: Vec<f64>,
}

impl Fixed {
    /// Reads a model.
    pub fn new(model: &Model) -> Self {
        if model.extra.charges.is_none() {
            return Self::default();
        }
        let volume = |radius: f64| radius.powi(model.dimension.count() as i32);
        let mut charge = Vec::with_capacity(model.spheres.len());
        for (index, body) in model.bodies.iter().enumerate() {
            let spheres = model.spheres_of(index);
            let whole: f64 = spheres.iter().map(|sphere| volume(sphere.radius)).sum();
            let total = model.extra.charge(body.material);
            charge.extend(spheres.iter().map(|sphere| total * volume(sphere.radius) / whole));
        }
        Self { charge }
    }
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
                let walls = attraction::stiffness(&forces, first, f64::INFINITY);
                let pairs = attraction::stiffness(&forces, first, second);
                contact.kn += if model.walls.is_empty() { pairs } else { walls.max(pairs) };
            }
            if let Some(law) = &forces.rolling {
                contact.kt += rolling::stiffness(law, &contact);
            }
            contact
        })
        .collect()
}

impl Links {
    /// Finds all pairs within reach; memories go over.
    fn rebuild(&mut self, setting: &Setting<'_>, state: &State) {
        let model = setting.model;
        let count = model.spheres.len();
        let place = |number: usize| &state.balls[state.slot[number] as usize];
        let margin = state.widest();
        let remembers = setting.needs.rolling || setting.needs.bridges;
        let old = std::mem::take(self);
        let cells = Cells::new(setting, state, margin);
        self.start.push(0);
        let mut near = Vec::new();
        for number in 0..count {
            near.clear();
            let me = place(number);
            cells.around(&me.place, |other| {
                let them = place(other as usize);
                let distance = (me.place - them.place).norm();
                let within = distance <= range(setting, number, other as usize, me, them) + margin;
                if other as usize > number && me.body != them.body && within {
                    near.push(other);
                }
            });
            near.sort_unstable();
            if remembers {
                let mine = match old.start.len() > number + 1 {
                    true => old.start[number] as usize..old.start[number + 1] as usize,
                    false => 0..0,
                };
                let partners = &old.partner[mine.clone()];
                self.pairs.extend(near.iter().map(|other| {
                    let found = partners.binary_search(other);
                    found.map_or_else(|_| Memory::default(), |at| old.pairs[mine.start + at])
                }));
            }
            self.partner.extend_from_slice(&near);
            self.start.push(self.partner.len() as u32);
        }
        self.walls = old.walls;
        if remembers && self.walls.is_empty() {
            self.walls = vec![Memory::default(); count * model.walls.len()];
        }
        self.built = state.rebuilds;
    }

    fn pairs(&self) -> impl Iterator<Item = (usize, usize, usize)> + '_ {
        (0..self.start.len().saturating_sub(1)).flat_map(move |number| {
            let range = self.start[number] as usize..self.start[number + 1] as usize;
            range.map(move |k| (k, number, self.partner[k] as usize))
        })
    }
}

/// Distance of the centres within which something acts, m.
fn range(setting: &Setting<'_>, number: usize, other: usize, me: &Ball, them: &Ball) -> f64 {
    let forces = setting.model.extra.between(me.material, them.material);
    let gap = attraction::reach(&forces, me.radius, them.radius);
    let near = if forces.is_empty() { 0.0 } else { me.radius + them.radius + gap };
    near.max(match &setting.model.extra.charges {
        Some(charges) if setting.extra.charge[number] * setting.extra.charge[other] != 0.0 => {
            charges.field.cutoff.0
        }
        _ => 0.0,
    })
}

/// Spheres by cells as large as the longest reach.
struct Cells {
    size: f64,
    sorted: Vec<([i64; 3], u32)>,
}

impl Cells {
    fn new(setting: &Setting<'_>, state: &State, margin: f64) -> Self {
        let model = setting.model;
        let largest = model.spheres.iter().map(|s| s.radius).fold(0.0, f64::max);
        let smallest = model.spheres.iter().map(|s| s.radius).fold(f64::INFINITY, f64::min);
        let materials = model.contacts.size() as u16;
        let mut reach = 0.0f64;
        for (a, b) in (0..materials).flat_map(|a| (a..materials).map(move |b| (a, b))) {
            let forces = model.extra.between(a, b);
            if !forces.is_empty() {
                reach = reach.max(attraction::reach(&forces, smallest, smallest) + 2.0 * largest);
            }
        }
        if let Some(charges) = &model.extra.charges {
            reach = reach.max(charges.field.cutoff.0);
        }
        let size = (reach + margin).max(f64::MIN_POSITIVE);
        let mut all = Self { size, sorted: Vec::with_capacity(model.spheres.len()) };
        for (number, slot) in state.slot.iter().enumerate() {
            all.sorted.push((all.cell(&state.balls[*slot as usize].place), number as u32));
        }
        all.sorted.sort_unstable();
        all
    }

    fn cell(&self, place: &Vec3) -> [i64; 3] {
        // Places that are not finite land in some cell; the guard sees them.
        [0, 1, 2].map(|axis| ((place[axis] / self.size).floor() as i64).clamp(-1 << 40, 1 << 40))
    }

    /// Calls `visit` for all spheres in the cell of `place` and those around it.
    fn around(&self, place: &Vec3, mut visit: impl FnMut(u32)) {
        let [x, y, z] = self.cell(place);
        for (i, j) in (-1..=1).flat_map(|i| (-1..=1).map(move |j| (i, j))) {
            // Three cells in a row along z are next to each other in the order.
            let (low, high) = ([x + i, y + j, z - 1], [x + i, y + j, z + 1]);
            let first = self.sorted.partition_point(|entry| entry.0 < low);
            let inside = self.sorted[first..].iter().take_while(|entry| entry.0 <= high);
            inside.for_each(|entry| visit(entry.1));
        }
    }
}

/// Potential energy of attraction and energy in rolling springs, J.
pub fn stored(setting: &Setting<'_>, state: &State) -> (f64, f64) {
    if !setting.needs.extra() {
        return (0.0, 0.0);
    }
    let links = &state.links;
    let mut energy = 0.0;
    for (k, number, other) in links.pairs() {
        let pair = Pair::of(setting, state, number, other);
        let bridged = links.pairs.get(k).is_some_and(|memory| memory.bridged);
        energy += pair.central(setting, number, other, bridged).energy;
    }
    let time = state.step as f64 * setting.step;
    each_wall(setting, state, time, |spot| {
        let bridged = links.walls.get(spot.key).is_some_and(|memory| memory.bridged);
        energy += attraction::total(&spot.forces, &spot.between, bridged).energy;
    });
    let elastic = links.pairs.iter().chain(&links.walls).map(|memory| memory.elastic).sum();
    (energy, elastic)
}

/// Two spheres.
struct Pair {
    normal: Vec3,
    distance: f64,
    between: Between,
    forces: PairForces,
}

impl Pair {
    fn of(setting: &Setting<'_>, state: &State, number: usize, other: usize) -> Self {
        let (me, them) =
            (&state.balls[state.slot[number] as usize], &state.balls[state.slot[other] as usize]);
        let way = me.place - them.place;
        let distance = way.norm();
        Self {
            normal: way / distance,
            distance,
            between: Between {
                first: me.radius,
                second: them.radius,
                gap: distance - (me.radius + them.radius),
            },
            forces: setting.model.extra.between(me.material, them.material),
        }
    }

    fn central(
        &self,
        setting: &Setting<'_>,
        number: usize,
        other: usize,
        bridged: bool,
    ) -> Central {
        let mut sum = attraction::total(&self.forces, &self.between, bridged);
        if let Some(charges) = &setting.model.extra.charges {
            let product = setting.extra.charge[number] * setting.extra.charge[other];
            if product != 0.0 {
                let (cutoff, cut) = (charges.field.cutoff.0, charges.field.cut);
                let scaled = product / charges.field.permittivity;
                sum += attraction::coulomb(scaled, self.distance, cutoff, cut);
            }
        }
        sum
    }
}

/// A sphere near a wall.
struct Spot {
    slot: usize,
    /// Place of its memory.
    key: usize,
    normal: Vec3,
    between: Between,
    forces: PairForces,
    material: u16,
    velocity: Vec3,
    spin: Vec3,
    /// Part of the overlap taken from the radius to give the lever arm.
    share: f64,
    /// False for faces of a mesh that is not at its deepest here.
    rolls: bool,
}

/// Calls `visit` for every sphere and wall with a law besides the linear contact.
fn each_wall(setting: &Setting<'_>, state: &State, time: f64, mut visit: impl FnMut(Spot)) {
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
    let mut found: Vec<Spot> = Vec::new();
    for slot in 0..state.faces.start.len().saturating_sub(1) {
        let ball = &state.balls[slot];
        found.clear();
        for k in state.faces.start[slot] as usize..state.faces.start[slot + 1] as usize {
            let face = state.faces.partner[k] as usize;
            let index = setting.surfaces.wall[face] as usize;
            let wall = &model.walls[index];
            let forces = model.extra.between(ball.material, wall.material);
            if forces.is_empty() || !state.faces.book.touching[k] {
                continue;
            }
            let corners = neighbours::face_at(setting, face, time);
            let (point, _) = surface::closest(&ball.place, &corners);
            let away = ball.place - point;
            let distance = away.norm();
            found.push(Spot {
                slot,
                key: state.order[slot] as usize * walls + index,
                normal: away / distance,
                between: Between {
                    first: ball.radius,
                    second: f64::INFINITY,
                    gap: distance - ball.radius,
                },
                forces,
                material: wall.material,
                velocity: wall.motion.velocity(&point),
                spin: wall_spin(&wall.motion),
                share: setting.share,
                rolls: false,
            });
        }
        for at in 0..found.len() {
            let (key, gap) = (found[at].key, found[at].between.gap);
            let deeper = |(other, spot): (usize, &Spot)| {
                spot.key == key && (spot.between.gap, other) < (gap, at)
            };
            found[at].rolls = !found.iter().enumerate().any(deeper);
        }
        found.drain(..).for_each(&mut visit);
    }
}

/// Adds all forces and moments to the loads; returns the energies.
pub fn pass(setting: &Setting<'_>, state: &mut State, rule: &Rule) -> Tally {
    let mut tally = Tally::default();
    if !setting.needs.extra() {
        return tally;
    }
    // Taken out, so that the rest of the state can be read meanwhile.
    let mut links = std::mem::take(&mut state.links);
    if links.built != state.rebuilds {
        links.rebuild(setting, state);
    }
    let mut loads = std::mem::take(&mut state.loads);
    on_pairs(setting, state, rule, &mut links, &mut loads, &mut tally);
    on_walls(setting, state, rule, &mut links, &mut loads, &mut tally);
    (state.links, state.loads) = (links, loads);
    tally
}

fn on_pairs(
    setting: &Setting<'_>,
    state: &State,
    rule: &Rule,
    links: &mut Links,
    loads: &mut [Load],
    tally: &mut Tally,
) {
    let spin = |slot: usize| state.spins.get(slot).copied().unwrap_or_default();
    let bodies = &setting.model.bodies;
    for number in 0..links.start.len().saturating_sub(1) {
        for k in links.start[number] as usize..links.start[number + 1] as usize {
            let other = links.partner[k] as usize;
            let (slot, there) = (state.slot[number] as usize, state.slot[other] as usize);
            let pair = Pair::of(setting, state, number, other);
            let touches = pair.between.gap < 0.0;
            let bridged = match links.pairs.get_mut(k) {
                Some(memory) => wet(memory, &pair.forces, &pair.between, touches, rule, tally),
                None => false,
            };
            let force = pair.normal * pair.central(setting, number, other, bridged).push;
            loads[slot].force += force;
            loads[there].force -= force;
            let (Some(law), Some(memory)) = (&pair.forces.rolling, links.pairs.get_mut(k)) else {
                continue;
            };
            let (me, them) = (&state.balls[slot], &state.balls[there]);
            let contact = setting.pair(me.material, them.material);
            let factor = if setting.planar { 1.5 } else { 1.4 };
            let (a, b) = (
                bodies[me.body as usize].mass * me.radius * me.radius,
                bodies[them.body as usize].mass * them.radius * them.radius,
            );
            let rate = (me.velocity - them.velocity).dot(&pair.normal);
            let turn = Turn {
                normal: pair.normal,
                spin: spin(slot) - spin(there),
                overlap: -pair.between.gap,
                radius: pair.between.reduced(),
                force: normal_force(setting, contact, -pair.between.gap, rate),
                inertia: factor * a * b / (a + b),
            };
            let moment = roll((setting, rule), (law, contact), touches, &turn, memory, tally);
            loads[slot].torque -= moment;
            loads[there].torque += moment;
        }
    }
}

fn on_walls(
    setting: &Setting<'_>,
    state: &State,
    rule: &Rule,
    links: &mut Links,
    loads: &mut [Load],
    tally: &mut Tally,
) {
    // A mesh that is no longer touched has no spot: its springs end here.
    let mut met = vec![false; if setting.needs.rolling { links.walls.len() } else { 0 }];
    each_wall(setting, state, setting.pass_time(state.step), |spot| {
        let ball = &state.balls[spot.slot];
        let touches = spot.between.gap <= 0.0;
        let bridged = match links.walls.get_mut(spot.key) {
            Some(memory) => wet(memory, &spot.forces, &spot.between, touches, rule, tally),
            None => false,
        };
        let push = attraction::total(&spot.forces, &spot.between, bridged).push;
        let force = spot.normal * push;
        loads[spot.slot].force += force;
        tally.wall_power += force.dot(&spot.velocity);
        let (Some(law), true) = (&spot.forces.rolling, spot.rolls) else { return };
        let Some(memory) = links.walls.get_mut(spot.key) else { return };
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
        let moment = roll((setting, rule), (law, contact), touches, &turn, memory, tally);
        loads[spot.slot].torque -= moment;
        tally.wall_power -= moment.dot(&spot.spin);
    });
    for (memory, met) in links.walls.iter_mut().zip(met) {
        if !met && memory.last != Vec3::zeros() {
            tally.rolling += if rule.interval > 0.0 { memory.elastic } else { 0.0 };
            *memory = Memory { bridged: memory.bridged, ..Memory::default() };
        }
    }
}

/// Normal force of the linear contact, N.
fn normal_force(setting: &Setting<'_>, contact: &Contact, overlap: f64, rate: f64) -> f64 {
    let force = contact.kn * overlap - contact.cn * rate;
    if setting.law.tension { force } else { force.max(0.0) }
}

/// Forms or breaks the bridge of a pair; says whether there is one.
fn wet(
    memory: &mut Memory,
    forces: &PairForces,
    between: &Between,
    touches: bool,
    rule: &Rule,
    tally: &mut Tally,
) -> bool {
    let Some(bridge) = &forces.bridge else { return false };
    if touches && !memory.bridged {
        memory.bridged = true;
        let alone = PairForces { bridge: forces.bridge, ..PairForces::default() };
        if rule.interval > 0.0 {
            tally.wetting -= attraction::total(&alone, between, true).energy;
        }
    } else if between.gap >= bridge.rupture() {
        memory.bridged = false;
    }
    memory.bridged
}

/// Moment of one contact, or the end of its spring.
fn roll(
    (setting, rule): (&Setting<'_>, &Rule),
    (law, contact): (&crate::model::extra::Rolling, &Contact),
    touches: bool,
    turn: &Turn,
    memory: &mut Memory,
    tally: &mut Tally,
) -> Vec3 {
    let mut found = rolling::Resistance::default();
    if touches {
        // LIGGGHTS lets the spring grow in its set-up pass, and forgets it.
        let setup = setting.scheme == Scheme::Liggghts && rule.advance == 0.0;
        let advance = if setup { setting.step } else { rule.advance };
        found = rolling::resist(law, contact, turn, memory.spring, advance);
        if setup {
            found.spring = memory.spring;
        }
    }
    if rule.interval > 0.0 {
        let mean = (memory.last + found.moment) * 0.5;
        tally.rolling += rule.interval * mean.dot(&turn.spin) - (found.elastic - memory.elastic);
    }
    (memory.spring, memory.last, memory.elastic) = (found.spring, found.moment, found.elastic);
    found.moment
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
    let walls = model.walls.iter().filter(|wall| matches!(wall.shape, WallShape::Mesh { .. }));
    for wall in walls {
        let far = |body: &crate::model::Body| {
            let forces = model.extra.between(body.material, wall.material);
            PairForces { lennard_jones: None, ..forces }.reaches()
        };
        if model.bodies.iter().any(far) {
            return Some(format!(
                "wall `{}` is a mesh; forces at a distance and liquid bridges act at planes only",
                wall.name
            ));
        }
    }
    None
}
