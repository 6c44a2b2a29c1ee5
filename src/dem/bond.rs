//! All bonds of a scene in one force pass.
//!
//! A bonded pair is not in the candidate lists. While the bond is intact, [`super::bond_law`]
//! acts between the two spheres and the contact law does not: no slip, no clipping of pull, no
//! force from an overlap that was there at time 0. A bond that breaks leaves a contact with
//! the law of its two materials, which takes over the shear force as far as friction holds
//! it; an overlap at time 0 stays without force there too, so that bonded overlapping spheres
//! do not fly apart. When the spheres have come apart the pair goes back to the lists and is
//! like any other. Its lever arms are R − δ/2 until then, whatever the law says.
//!
//! Strengths are compared with the elastic forces of the pass, without dashpots. The energy
//! that a break sets free is what the bond held less what the contact takes over, with the
//! change of power over half a step (each force acts as the mean of both ends of a step).
//!
//! Orientations of single spheres are kept here, for bonded ones alone, and turn by the
//! exponential of the spin that carried them since the last pass. Bonds go by sphere numbers, so
//! reordering of the lists does not touch them. O(bonds); cannot fail.

use super::bond_law::{self, Action, Pose};
use super::law::{self, Approach, Book, Rule, Tally, Variant, for_kind};
use super::setting::Setting;
use super::state::{State, is_alone};
use crate::model::{Bond, Break, BreakMode, Scheme, Section, Touch};
use crate::num::{Rotation, Vec3};
use serde::{Deserialize, Serialize};

/// Springs that turn with the contact as YADE's do.
type TurnedSpring = Variant<true, false, 1, 2, false>;

/// What does not change of the bonds during a run.
#[derive(Debug, Default)]
pub struct Table {
    joints: Vec<Joint>,
    /// Bonded bodies, rising, and the place of each in `State::solids` if it is no single sphere.
    bodies: Vec<(u32, Option<u32>)>,
    /// Bonds of sphere `i` are entries `start[i]..start[i + 1]` of `partners`.
    start: Vec<u32>,
    /// Other sphere and number of the bond.
    partners: Vec<(u32, u32)>,
    /// Whether orientations are needed.
    turning: bool,
}

/// A bond at time 0.
#[derive(Debug)]
struct Joint {
    bond: Bond,
    /// Indices into `Table::bodies`.
    bodies: [u32; 2],
    /// See [`Pose::arms`], in the frames of the bodies.
    arms: [Vec3; 2],
    /// Orientation of the first body seen from the second.
    rest: Rotation,
    length: f64,
    /// Overlap, m; negative for a gap.
    overlap: f64,
}

impl Table {
    /// Reads the bonds of a model.
    pub fn new(setting: &Setting<'_>) -> Self {
        let model = setting.model;
        if model.bonds.is_empty() {
            return Self::default();
        }
        let mut all: Vec<u32> = model
            .bonds
            .iter()
            .flat_map(|bond| [bond.first, bond.second])
            .map(|sphere| model.spheres[sphere as usize].body)
            .collect();
        all.sort_unstable();
        all.dedup();
        let (mut bodies, mut next, mut solids) = (Vec::with_capacity(all.len()), 0, 0);
        for body in all {
            solids += (next..body).filter(|b| !is_alone(setting, *b as usize)).count() as u32;
            next = body;
            bodies.push((body, (!is_alone(setting, body as usize)).then_some(solids)));
        }
        let place = |sphere: u32| {
            let sphere = &model.spheres[sphere as usize];
            let body = &model.bodies[sphere.body as usize];
            (body.position + body.orientation * sphere.offset, body.orientation, sphere)
        };
        let joints = model
            .bonds
            .iter()
            .map(|bond| {
                let ((from, turn, one), (to, other, two)) = (place(bond.first), place(bond.second));
                let between = to - from;
                let length = between.norm();
                let overlap = one.radius + two.radius - length;
                let middle = between * ((one.radius - 0.5 * overlap) / length);
                // Every bonded body is in `bodies`.
                let index = |body| bodies.partition_point(|known| known.0 < body) as u32;
                Joint {
                    bond: *bond,
                    bodies: [index(one.body), index(two.body)],
                    arms: [
                        turn.inverse_transform_vector(&middle),
                        other.inverse_transform_vector(&(between - middle)),
                    ],
                    rest: other.inverse() * turn,
                    length,
                    overlap,
                }
            })
            .collect();
        let (start, partners) = partners(model.spheres.len(), &model.bonds);
        let moments = model.bonds.iter().any(Bond::has_moments);
        let turning = moments || setting.scheme != Scheme::Yade;
        Self { joints, bodies, start, partners, turning }
    }
}

/// Bonds sphere by sphere.
fn partners(spheres: usize, bonds: &[Bond]) -> (Vec<u32>, Vec<(u32, u32)>) {
    let mut ends: Vec<(u32, u32, u32)> = Vec::with_capacity(2 * bonds.len());
    for (index, bond) in bonds.iter().enumerate() {
        ends.push((bond.first, bond.second, index as u32));
        ends.push((bond.second, bond.first, index as u32));
    }
    ends.sort_unstable();
    let mut start = vec![0; spheres + 1];
    for (sphere, ..) in &ends {
        start[*sphere as usize + 1] += 1;
    }
    for sphere in 0..spheres {
        start[sphere + 1] += start[sphere];
    }
    (start, ends.into_iter().map(|(_, other, bond)| (other, bond)).collect())
}

/// How a bond is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// Holds.
    Intact,
    /// Broken, and its spheres have not been apart since.
    Broken,
    /// Broken, and its pair is in the lists like any other.
    Apart,
}

/// What changes of the bonds.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Bonds {
    /// One entry a bond.
    pub status: Vec<Status>,
    /// Orientation of each bonded body at the last pass.
    turns: Vec<Rotation>,
    /// Memory of the contacts that broken bonds leave, and of YADE's shear springs.
    book: Book,
    /// Force on the second sphere and torque on it by dashpots in the last pass; with damping only.
    drag: Vec<[Vec3; 2]>,
    /// Bonds that broke, in the order of time.
    pub broken: Vec<Break>,
    /// Dissipated by the dashpots of bonds, J.
    pub damped: f64,
    /// Set free by breaks, J.
    pub released: f64,
    /// A pair has gone back to the lists, which must be built again.
    changed: bool,
}

impl Bonds {
    /// All bonds intact.
    pub fn new(setting: &Setting<'_>) -> Self {
        let count = setting.model.bonds.len();
        if count == 0 {
            return Self::default();
        }
        let mut kept = setting.kept;
        // YADE's shear springs live in the book even where contacts are without friction.
        kept.friction |= setting.scheme == Scheme::Yade;
        kept.normals |= setting.scheme == Scheme::Yade;
        kept.pulls = false;
        let mut book = Book::open(count, kept);
        let kept_normals = 0..book.normal.len();
        for (k, joint) in kept_normals.zip(&setting.bonds.joints) {
            let turn = setting.model.bodies
                [setting.bonds.bodies[joint.bodies[0] as usize].0 as usize]
                .orientation;
            book.normal.put(k, (turn * joint.arms[0]).normalize());
        }
        let bodies = &setting.model.bodies;
        Self {
            status: vec![Status::Intact; count],
            turns: setting.bonds.bodies.iter().map(|b| bodies[b.0 as usize].orientation).collect(),
            book,
            drag: vec![[Vec3::zeros(); 2]; if setting.needs.bond_damping { count } else { 0 }],
            ..Self::default()
        }
    }

    /// True if the pair of spheres is kept out of the lists by a bond.
    pub fn holds(&self, table: &Table, one: u32, other: u32) -> bool {
        let range = table.start[one as usize] as usize..table.start[one as usize + 1] as usize;
        table.partners[range]
            .iter()
            .any(|(there, bond)| *there == other && self.status[*bond as usize] != Status::Apart)
    }

    /// Whether lists must be built again since the last call.
    pub fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    /// Number of intact bonds.
    pub fn intact(&self) -> u64 {
        self.status.iter().filter(|status| **status == Status::Intact).count() as u64
    }
}

/// A bonded pair as it is now.
struct Pair<'a> {
    index: usize,
    joint: &'a Joint,
    slots: [usize; 2],
    normal: Vec3,
    distance: f64,
    overlap: f64,
    /// Distances of the middle of the contact from both centres, m.
    reach: [f64; 2],
    /// Velocity of the second sphere's side against the first's there, m/s.
    velocity: Vec3,
    /// Angular velocities, rad/s.
    spins: [Vec3; 2],
}

impl<'a> Pair<'a> {
    fn of(setting: &'a Setting<'_>, state: &State, index: usize) -> Self {
        let joint = &setting.bonds.joints[index];
        let slots = [joint.bond.first, joint.bond.second].map(|s| state.slot[s as usize] as usize);
        let [one, two] = slots.map(|slot| &state.balls[slot]);
        let spins = slots.map(|slot| state.spins[slot]);
        let between = two.place - one.place;
        let distance = between.norm();
        let normal = between / distance;
        let overlap = one.radius + two.radius - distance;
        let reach = [one.radius - 0.5 * overlap, two.radius - 0.5 * overlap];
        let velocity = two.velocity - one.velocity
            + normal.cross(&(spins[0] * reach[0] + spins[1] * reach[1]));
        Self { index, joint, slots, normal, distance, overlap, reach, velocity, spins }
    }

    fn approach(&self) -> Approach {
        let overlap = self.overlap - self.joint.overlap.max(0.0);
        Approach::new(self.normal, overlap, self.velocity, self.spins[0] + self.spins[1])
    }

    fn pose(&self, turns: &[Rotation]) -> Pose {
        let [a, b] = self.joint.bodies.map(|body| &turns[body as usize]);
        let turn = if self.joint.bond.has_moments() {
            bond_law::relative_turn(a, b, &self.joint.rest)
        } else {
            Vec3::zeros()
        };
        Pose {
            between: self.normal * self.distance,
            stretch: self.distance - self.joint.length,
            arms: [a * self.joint.arms[0], b * self.joint.arms[1]],
            turn,
        }
    }

    /// Power of a force on the second sphere, and of torques about both centres, W.
    fn power(&self, state: &State, force: &Vec3, torques: &[Vec3; 2]) -> f64 {
        let [one, two] = self.slots.map(|slot| &state.balls[slot].velocity);
        force.dot(&(two - one)) + torques[0].dot(&self.spins[0]) + torques[1].dot(&self.spins[1])
    }

    fn apply(&self, state: &mut State, force: Vec3, torques: [Vec3; 2]) {
        let [one, two] = self.slots;
        state.loads[one].force -= force;
        state.loads[two].force += force;
        state.loads[one].torque += torques[0];
        state.loads[two].torque += torques[1];
    }
}

/// Adds the loads of all bonds; returns what the contacts of broken ones take.
pub fn pass(setting: &Setting<'_>, state: &mut State, rule: &Rule, first: bool) -> Tally {
    let mut tally = Tally::default();
    if !setting.needs.bonds {
        return tally;
    }
    let mut bonds = std::mem::take(&mut state.bonds);
    if setting.bonds.turning {
        turn_bodies(setting, state, &mut bonds, first);
    }
    for index in 0..bonds.status.len() {
        match bonds.status[index] {
            Status::Apart => {}
            Status::Intact => intact(setting, state, &mut bonds, index, rule),
            Status::Broken => {
                let pair = Pair::of(setting, state, index);
                if let Some((force, torques)) =
                    contact(setting, state, &mut bonds, &pair, rule, &mut tally)
                {
                    pair.apply(state, force, torques);
                } else if pair.overlap <= 0.0 {
                    bonds.status[index] = Status::Apart;
                    bonds.changed = true;
                }
            }
        }
    }
    state.bonds = bonds;
    tally
}

/// Turns bonded bodies by the spins that carried them since the last pass.
fn turn_bodies(setting: &Setting<'_>, state: &State, bonds: &mut Bonds, first: bool) {
    let span = match (first, setting.scheme) {
        (true, _) => 0.0,
        (_, Scheme::PathAveraged) if state.step == 1 => 0.5 * setting.step,
        _ => setting.step,
    };
    for (turn, (body, solid)) in bonds.turns.iter_mut().zip(&setting.bonds.bodies) {
        *turn = match solid {
            Some(solid) => state.solids[*solid as usize].turn,
            None => turned(setting, state, turn, *body, span),
        };
    }
}

/// A single sphere's orientation `span` seconds on, at its present spin.
fn turned(setting: &Setting<'_>, state: &State, turn: &Rotation, body: u32, span: f64) -> Rotation {
    let sphere = setting.model.bodies[body as usize].first_sphere;
    let spin = state.spins[state.slot[sphere as usize] as usize];
    let mut next = Rotation::from_scaled_axis(spin * span) * turn;
    // Keeps the length at 1 over millions of steps.
    next.renormalize_fast();
    next
}

/// Loads of a bond that holds, and what happens if it breaks.
fn intact(setting: &Setting<'_>, state: &mut State, bonds: &mut Bonds, index: usize, rule: &Rule) {
    let pair = Pair::of(setting, state, index);
    let bond = &pair.joint.bond;
    let pose = pair.pose(&bonds.turns);
    let mut action = if setting.scheme == Scheme::Yade {
        let approach = pair.approach();
        let old = bonds.book.view().recall::<TurnedSpring>(index);
        let carried = Vec3::from(law::carry::<f64, TurnedSpring>(
            rule,
            approach.normal,
            approach.spins,
            &old,
        ));
        let across = pair.velocity - pair.normal * pair.velocity.dot(&pair.normal);
        let slip = carried + across * rule.advance;
        bonds.book.spring.put(index, slip);
        bonds.book.normal.put(index, pair.normal);
        bond_law::as_yade(bond, &pose, slip, pair.reach)
    } else {
        bond_law::elastic(bond, &pose)
    };
    let section = |radius| Section::new(setting.model.dimension, radius);
    if let Some(mode) = bond_law::breaks(bond, &action, section) {
        let energy = snap(setting, state, bonds, &pair, (&action, mode), rule);
        bonds.broken.push(Break {
            bond: index as u32,
            step: state.step,
            time: state.step as f64 * setting.step,
            mode,
            energy,
        });
        return;
    }
    if bond.viscosity > 0.0 {
        drag(bonds, &pair, rule, &mut action);
    }
    pair.apply(state, action.force, action.torques);
}

/// Adds the dashpots and counts what they take.
fn drag(bonds: &mut Bonds, pair: &Pair<'_>, rule: &Rule, action: &mut Action) {
    let (bond, n) = (&pair.joint.bond, &pair.normal);
    let along = n * pair.velocity.dot(n);
    let force = (along * bond.normal + (pair.velocity - along) * bond.shear) * -bond.viscosity;
    let spin = pair.spins[1] - pair.spins[0];
    let twist = n * spin.dot(n);
    let torque = (twist * bond.twisting + (spin - twist) * bond.bending) * -bond.viscosity;
    let couple = n.cross(&force);
    action.force += force;
    action.torques[0] -= couple * pair.reach[0] + torque;
    action.torques[1] -= couple * pair.reach[1] - torque;
    let last = std::mem::replace(&mut bonds.drag[pair.index], [force, torque]);
    let mean = |old: &Vec3, new: &Vec3, rate: &Vec3| -0.5 * (old + new).dot(rate);
    bonds.damped +=
        rule.interval * (mean(&last[0], &force, &pair.velocity) + mean(&last[1], &torque, &spin));
}

/// Breaks a bond: its contact takes over. Returns the energy set free, J.
fn snap(
    setting: &Setting<'_>,
    state: &mut State,
    bonds: &mut Bonds,
    pair: &Pair<'_>,
    (action, mode): (&Action, BreakMode),
    rule: &Rule,
) -> f64 {
    let k = pair.index;
    bonds.status[k] = Status::Broken;
    let law = contact_law(setting, state, pair);
    if !bonds.book.spring.is_empty() {
        let held = law.kt > 0.0 && setting.kept.friction;
        let mut part = if held { pair.joint.bond.shear / law.kt } else { 0.0 };
        if setting.scheme == Scheme::Yade && mode == BreakMode::Shear {
            // YADE sets the shear force to the limit of friction, where it was below it too.
            part *= (-law.friction * action.pull).max(0.0) / action.shear;
        }
        bonds.book.spring.put(k, action.slip * part);
    }
    if !bonds.book.normal.is_empty() {
        bonds.book.normal.put(k, pair.normal);
    }
    // The springs stand where they are: nothing advances twice in this pass.
    let still = Rule { advance: 0.0, interval: 0.0, ..*rule };
    let mut none = Tally::default();
    bonds.book.touching[k] = true;
    let contact = contact(setting, state, bonds, pair, &still, &mut none);
    let held = stored(setting, state, bonds, pair).0;
    let (force, torques) = contact.unwrap_or_default();
    pair.apply(state, force, torques);
    let before = pair.power(state, &action.force, &action.torques);
    let after = pair.power(state, &force, &torques);
    let mut free = action.energy - held + 0.5 * rule.interval * (before - after);
    if let Some(drag) = bonds.drag.get(k) {
        // The dashpots of the last pass act for half a step more.
        let spin = pair.spins[1] - pair.spins[0];
        free -= 0.5 * rule.interval * (drag[0].dot(&pair.velocity) + drag[1].dot(&spin));
    }
    bonds.released += free;
    free
}

fn contact_law<'a>(
    setting: &'a Setting<'_>,
    state: &State,
    pair: &Pair<'_>,
) -> &'a crate::model::Contact {
    let [one, two] = pair.slots.map(|slot| &state.balls[slot]);
    setting.pair(one.material, two.material)
}

/// Force on the second sphere and torques of the contact that a broken bond leaves;
/// `None` if the spheres do not press on each other.
fn contact(
    setting: &Setting<'_>,
    state: &State,
    bonds: &mut Bonds,
    pair: &Pair<'_>,
    rule: &Rule,
    tally: &mut Tally,
) -> Option<(Vec3, [Vec3; 2])> {
    let (k, approach) = (pair.index, pair.approach());
    let touches = approach.overlap > 0.0;
    if !touches && !bonds.book.touching[k] {
        return None;
    }
    let law = contact_law(setting, state, pair);
    let mut view = bonds.book.view();
    let reply = for_kind!(setting.kept, setting.law, K => law::advance::<K>(
        rule, law, &approach, touches, (&mut view, k), tally,
    ));
    if !touches {
        return None;
    }
    let couple = pair.normal.cross(&reply.tangent);
    let torques = pair.reach.map(|arm| -couple * arm);
    Some((pair.normal * reply.normal + reply.tangent, torques))
}

/// Elastic energy of the contact of a broken bond, J, and its overlap, m.
fn stored(setting: &Setting<'_>, state: &State, bonds: &Bonds, pair: &Pair<'_>) -> (f64, f64) {
    let overlap = pair.approach().overlap;
    if !bonds.book.touching[pair.index] {
        return (0.0, overlap);
    }
    let law = contact_law(setting, state, pair);
    let spring = bonds.book.record(pair.index).spring.norm_squared();
    (0.5 * (law.kn * overlap.max(0.0).powi(2) + law.kt * spring), overlap)
}

/// What the bonds hold after a pass.
#[derive(Debug, Default)]
pub struct Held {
    /// Elastic energy in intact bonds, J.
    pub elastic: f64,
    /// Elastic energy, number and largest overlap (over the smaller radius) of contacts left by broken ones.
    pub contacts: (f64, u64, f64),
}

/// Looks at all bonds at the time of the last step.
pub fn held(setting: &Setting<'_>, state: &State) -> Held {
    let mut held = Held::default();
    each(setting, state, |pair, status, action| {
        if status == Status::Intact {
            held.elastic += action.energy;
        } else if state.bonds.book.touching[pair.index] {
            let (energy, overlap) = stored(setting, state, &state.bonds, pair);
            let radius =
                pair.slots.map(|s| state.balls[s].radius).iter().fold(f64::MAX, |a, b| a.min(*b));
            held.contacts.0 += energy;
            held.contacts.1 += 1;
            held.contacts.2 = held.contacts.2.max(overlap / radius);
        }
    });
    held
}

/// Bonded pairs as contacts: pull counts negative.
pub fn touches(setting: &Setting<'_>, state: &State) -> Vec<Touch> {
    let mut all = Vec::new();
    each(setting, state, |pair, status, action| {
        let bond = &pair.joint.bond;
        let (first, second) = (bond.first, bond.second);
        if status == Status::Intact {
            all.push(Touch { first, second, normal: -action.pull, tangential: action.shear });
        } else if state.bonds.book.touching[pair.index] {
            let law = contact_law(setting, state, pair);
            let record = state.bonds.book.record(pair.index);
            let normal = law.kn * pair.approach().overlap + record.lag;
            all.push(Touch { first, second, normal, tangential: law.kt * record.spring.norm() });
        }
    });
    all
}

/// Calls `visit` for every bonded pair that the lists do not hold.
fn each(setting: &Setting<'_>, state: &State, mut visit: impl FnMut(&Pair<'_>, Status, Action)) {
    let bonds = &state.bonds;
    // Path-averaged passes stand half a step back.
    let half = if setting.scheme == Scheme::PathAveraged && state.step > 0 {
        0.5 * setting.step
    } else {
        0.0
    };
    let turns: Vec<Rotation> = if half > 0.0 {
        let ahead = setting.bonds.bodies.iter().zip(&bonds.turns);
        ahead
            .map(|((body, solid), turn)| match solid {
                Some(solid) => state.solids[*solid as usize].turn,
                None => turned(setting, state, turn, *body, half),
            })
            .collect()
    } else {
        bonds.turns.clone()
    };
    for (index, status) in bonds.status.iter().enumerate() {
        if *status == Status::Apart {
            continue;
        }
        let pair = Pair::of(setting, state, index);
        let (bond, pose) = (&pair.joint.bond, pair.pose(&turns));
        let action = match setting.scheme {
            Scheme::Yade => bond_law::as_yade(bond, &pose, bonds.book.spring.at(index), pair.reach),
            _ => bond_law::elastic(bond, &pose),
        };
        visit(&pair, *status, action);
    }
}
