//! Forces between spheres besides the linear contact: the pairs within reach of a law, what they
//! remember, and the pass over them. O(N log N) to build, O(pairs) a pass; cannot fail.

use super::Effect;
use super::memory::{Memory, normal_force, roll, wet};
use crate::dem::attraction::{self, Between, Central};
use crate::dem::law::Rule;
use crate::dem::rolling::Turn;
use crate::dem::setting::Setting;
use crate::dem::state::{Ball, State};
use crate::model::extra::PairForces;
use crate::num::Vec3;
use serde::{Deserialize, Serialize};

/// Pairs within reach, and what they remember.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Partners {
    /// Where the partners of each sphere of the model begin.
    start: Vec<u32>,
    /// Partners by rising number, all greater than the sphere's.
    partner: Vec<u32>,
    /// One a pair; empty if nothing is remembered.
    memory: Vec<Memory>,
}

impl Partners {
    /// Finds all pairs within reach; memories go over.
    pub fn rebuild(&mut self, setting: &Setting<'_>, state: &State) {
        let model = setting.model;
        let count = model.spheres.len();
        let slot = |number: usize| state.slot[number] as usize;
        let place = |number: usize| &state.balls[slot(number)];
        let remembers = setting.needs.rolling || setting.needs.bridges;
        let old = std::mem::take(self);
        let cells = Cells::new(setting, state);
        self.start.push(0);
        let mut near = Vec::new();
        for number in 0..count {
            near.clear();
            let me = place(number);
            cells.around(&me.place, |other| {
                let them = place(other as usize);
                let distance = (me.place - them.place).norm();
                let margin = state.margin_of(slot(number), slot(other as usize));
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
                self.memory.extend(near.iter().map(|other| {
                    let found = partners.binary_search(other);
                    found.map_or_else(|_| Memory::default(), |at| old.memory[mine.start + at])
                }));
            }
            self.partner.extend_from_slice(&near);
            self.start.push(self.partner.len() as u32);
        }
    }

    /// Potential energy of all pairs and energy in their rolling springs, J.
    pub fn stored(&self, setting: &Setting<'_>, state: &State) -> (f64, f64) {
        let mut energy = 0.0;
        for (k, number, other) in self.all() {
            let pair = Pair::of(setting, state, number, other);
            let bridged = self.memory.get(k).is_some_and(|memory| memory.bridged);
            energy += pair.energy(setting, (number, other), bridged);
        }
        (energy, self.memory.iter().map(|memory| memory.elastic).sum())
    }

    fn all(&self) -> impl Iterator<Item = (usize, usize, usize)> + '_ {
        (0..self.start.len().saturating_sub(1)).flat_map(move |number| {
            let range = self.start[number] as usize..self.start[number + 1] as usize;
            range.map(move |k| (k, number, self.partner[k] as usize))
        })
    }
}

/// Distance of the centres within which something acts, m.
fn range(setting: &Setting<'_>, number: usize, other: usize, me: &Ball, them: &Ball) -> f64 {
    let forces = setting.model.extra.between(me.material, them.material);
    let gap = attraction::reach(forces, me.radius, them.radius);
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
    fn new(setting: &Setting<'_>, state: &State) -> Self {
        let model = setting.model;
        let largest = model.spheres.iter().map(|s| s.radius).fold(0.0, f64::max);
        let smallest = model.spheres.iter().map(|s| s.radius).fold(f64::INFINITY, f64::min);
        let materials = model.contacts.size() as u16;
        let mut reach = 0.0f64;
        for (a, b) in (0..materials).flat_map(|a| (a..materials).map(move |b| (a, b))) {
            let forces = model.extra.between(a, b);
            if !forces.is_empty() {
                reach = reach.max(attraction::reach(forces, smallest, smallest) + 2.0 * largest);
            }
        }
        if let Some(charges) = &model.extra.charges {
            reach = reach.max(charges.field.cutoff.0);
        }
        let size = (reach + state.widest()).max(f64::MIN_POSITIVE);
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

/// Two spheres.
struct Pair<'a> {
    normal: Vec3,
    distance: f64,
    between: Between,
    forces: &'a PairForces,
}

impl<'a> Pair<'a> {
    fn of(setting: &Setting<'a>, state: &State, number: usize, other: usize) -> Self {
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

    /// Force, N, positive when pushing apart.
    fn push(&self, setting: &Setting<'_>, charges: (usize, usize), bridged: bool) -> f64 {
        attraction::push(self.forces, &self.between, bridged) + self.coulomb(setting, charges).push
    }

    /// Potential energy, J.
    fn energy(&self, setting: &Setting<'_>, charges: (usize, usize), bridged: bool) -> f64 {
        attraction::total(self.forces, &self.between, bridged).energy
            + self.coulomb(setting, charges).energy
    }

    /// Between the charges of two spheres.
    fn coulomb(&self, setting: &Setting<'_>, (number, other): (usize, usize)) -> Central {
        let Some(charges) = &setting.model.extra.charges else { return Central::default() };
        let product = setting.extra.charge[number] * setting.extra.charge[other];
        if product == 0.0 {
            return Central::default();
        }
        let (cutoff, cut) = (charges.field.cutoff.0, charges.field.cut);
        attraction::coulomb(product / charges.field.permittivity, self.distance, cutoff, cut)
    }
}

/// Adds the forces and moments between spheres.
pub fn pass(
    setting: &Setting<'_>,
    state: &State,
    rule: &Rule,
    links: &mut Partners,
    effect: &mut Effect<'_>,
) {
    let Effect { loads, tally, .. } = effect;
    let spin = |slot: usize| state.spins.get(slot).copied().unwrap_or_default();
    let bodies = &setting.model.bodies;
    for number in 0..links.start.len().saturating_sub(1) {
        for k in links.start[number] as usize..links.start[number + 1] as usize {
            let other = links.partner[k] as usize;
            let (slot, there) = (state.slot[number] as usize, state.slot[other] as usize);
            let pair = Pair::of(setting, state, number, other);
            let touches = pair.between.gap < 0.0;
            let bridged = match links.memory.get_mut(k) {
                Some(memory) => wet(memory, pair.forces, &pair.between, touches, rule, tally),
                None => false,
            };
            let force = pair.normal * pair.push(setting, (number, other), bridged);
            loads[slot].force += force;
            loads[there].force -= force;
            let (Some(law), Some(memory)) = (&pair.forces.rolling, links.memory.get_mut(k)) else {
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
