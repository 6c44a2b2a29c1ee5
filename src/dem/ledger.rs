//! Energy book-keeping.
//!
//! Dissipated energies grow in every force pass (see [`super::law`]). Powers
//! that act from half a step before a pass to half a step after it (moving
//! walls, local damping) are added in two halves, so that a row between them
//! stands at the time of the pass. The residual of the balance
//!     K + E + G + D − W − (its value at time 0)
//! is of second order in the step (each contact force acts as the mean of both
//! ends of an interval); it tests the book-keeping and the step, not the accuracy
//! of the motion. A face that hands a sphere to another across a bent mesh edge
//! drops its spring energy unseen: that residual does not shrink.
//! Cost: 4 to 12 % of a step (`benches/README.md`). Without it (`plan.ledger`) what contacts take is neither computed nor
//! remembered, and nobody knows the residual.

use super::bond;
use super::law::Tally;
use super::setting::{PlaneNow, Setting};
use super::state::State;
use super::surface;
use crate::model::{Scheme, SeriesRow, Touch};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};

/// Running sums, J.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// What contacts took.
    pub contacts: Tally,
    /// Work of moving walls on the bodies.
    pub wall_work: f64,
    /// Dissipated by local damping.
    pub local_damping: f64,
    /// Kinetic energy taken where velocities were set to zero.
    pub zeroed: f64,
    /// Energy of bodies that were taken out.
    pub lost: f64,
    /// Dissipated by drag.
    pub drag: f64,
    /// Half of the work of drag in the present pass.
    pub drag_half: f64,
    /// Half of the work of the present pass, to be added after the row.
    pub wall_half: f64,
    /// The same for local damping.
    pub damping_half: f64,
    /// Kinetic + elastic energy at time 0.
    pub start: f64,
    /// Σ m g·w over all ways w by which bodies were brought home into a periodic box.
    pub carried: f64,
    /// Potential energy at time 0.
    pub start_potential: f64,
}

impl Ledger {
    /// Adds a force pass and the power [W] of local damping in it.
    pub fn add(&mut self, pass: Tally, damping_power: f64, step: f64, first: bool) {
        self.wall_half = 0.5 * step * pass.wall_power;
        self.damping_half = 0.5 * step * damping_power;
        self.drag_half = 0.5 * step * pass.drag_power;
        let power = Tally { wall_power: 0.0, drag_power: 0.0, ..pass };
        self.contacts += power;
        if !first {
            self.add_half();
        }
    }

    /// Adds the half of the present pass that lies after it.
    pub fn add_half(&mut self) {
        self.wall_work += self.wall_half;
        self.local_damping += self.damping_half;
        self.drag += self.drag_half;
    }
}

/// What a sweep over all touching contacts finds.
#[derive(Debug, Default)]
pub struct Sweep {
    /// Energy in the springs of contacts, J.
    pub elastic: f64,
    /// Energy in intact bonds, J.
    pub bonds: f64,
    /// Potential energy of attraction, J.
    pub attraction: f64,
    /// Contacts, walls included.
    pub contacts: u64,
    /// Contacts between spheres.
    pub between: u64,
    /// Largest overlap over the smaller radius.
    pub worst_overlap: f64,
}

/// Looks at all contacts as they are after the last force pass.
pub fn sweep(setting: &Setting<'_>, state: &State) -> Sweep {
    let mut found = Sweep::default();
    let time = state.step as f64 * setting.step;
    // Path-averaged contacts keep springs half a step back, and may have ended within it.
    let averaged = setting.scheme == Scheme::PathAveraged;
    let half = if averaged { 0.5 * setting.step } else { 0.0 };
    let share = setting.share;
    let spin = |slot: usize| state.spins.get(slot).copied().unwrap_or_default();
    let mut add = |law: &crate::model::Contact, overlap: f64, spring: Vec3, radius: f64| {
        let overlap = if averaged { overlap.max(0.0) } else { overlap };
        let stretch = 0.5 * law.kt * spring.norm_squared();
        found.elastic += 0.5 * law.kn * overlap * overlap + stretch;
        found.contacts += 1;
        found.worst_overlap = found.worst_overlap.max(overlap / radius);
    };
    let mut between = 0;
    visit(&state.pairs, |slot, other, k| {
        let (a, b) = (&state.balls[slot], &state.balls[other]);
        let overlap = a.radius + b.radius - setting.way(a.place - b.place).norm();
        let law = setting.pair(a.material, b.material);
        let mut spring = state.pairs.book.record(k).spring;
        if half > 0.0 && setting.needs.friction {
            let turning = spin(slot) * (a.radius - share * overlap)
                + spin(other) * (b.radius - share * overlap);
            let between = setting.way(a.place - b.place);
            spring += slide(between, a.velocity - b.velocity, turning) * half;
        }
        add(law, overlap, spring, a.radius.min(b.radius));
        between += 1;
    });
    let planes: Vec<PlaneNow> = setting.planes_at(time);
    visit(&state.planes, |slot, plane, k| {
        let (ball, plane) = (&state.balls[slot], &planes[plane]);
        let height = (ball.place - plane.point).dot(&plane.normal);
        let overlap = ball.radius - height.abs();
        let law = setting.pair(ball.material, plane.material);
        let mut spring = state.planes.book.record(k).spring;
        if half > 0.0 && setting.needs.friction {
            let away = plane.normal * height;
            let arm = ball.radius - overlap * plane.share;
            let velocity = ball.velocity - plane.motion.velocity(&(ball.place - away));
            spring += slide(away, velocity, spin(slot) * arm) * half;
        }
        add(law, overlap, spring, ball.radius);
    });
    visit(&state.faces, |slot, face, k| {
        let ball = &state.balls[slot];
        let wall = &setting.model.walls[setting.surfaces.wall[face] as usize];
        let corners = super::neighbours::face_at(setting, face, time);
        let (point, _) = surface::closest(&ball.place, &corners);
        let overlap = ball.radius - (ball.place - point).norm();
        let law = setting.pair(ball.material, wall.material);
        let mut spring = state.faces.book.record(k).spring;
        if half > 0.0 && setting.needs.friction {
            let arm = ball.radius - share * overlap;
            let motion = &setting.walls[setting.surfaces.wall[face] as usize].motion;
            let velocity = ball.velocity - motion.velocity(&point);
            spring += slide(ball.place - point, velocity, spin(slot) * arm) * half;
        }
        add(law, overlap, spring, ball.radius);
    });
    found.between = between;
    if setting.needs.bonds {
        let held = bond::held(setting, state);
        let (energy, count, overlap) = held.contacts;
        found.bonds = held.elastic;
        found.elastic += energy;
        found.contacts += count;
        found.between += count;
        found.worst_overlap = found.worst_overlap.max(overlap);
    }
    let (attraction, rolling) = super::extra::stored(setting, state);
    found.attraction = attraction;
    found.elastic += rolling;
    found
}

/// Energy in contacts and bonds, and of attraction, J.
pub fn stored(setting: &Setting<'_>, state: &State) -> f64 {
    let found = sweep(setting, state);
    found.elastic + found.bonds + found.attraction
}

/// Velocity in the contact plane: `away` from the partner to the sphere, `velocity`
/// of the centre against the partner, `turning` the sum of spins times arms.
fn slide(away: Vec3, velocity: Vec3, turning: Vec3) -> Vec3 {
    let normal = away.normalize();
    let whole = velocity + normal.cross(&turning);
    whole - normal * whole.dot(&normal)
}

/// Calls `each(slot, partner, k)` for every touching entry.
pub fn visit(list: &super::state::List, mut each: impl FnMut(usize, usize, usize)) {
    for slot in 0..list.start.len().saturating_sub(1) {
        for k in list.start[slot] as usize..list.start[slot + 1] as usize {
            if list.book.touching[k] {
                each(slot, list.partner[k] as usize, k);
            }
        }
    }
}

/// Kinetic energy at the time of the last force pass, J. YADE's velocities lag
/// half a step behind it and are carried forward with the present acceleration.
pub fn kinetic(setting: &Setting<'_>, state: &State) -> f64 {
    let model = setting.model;
    let ahead = if setting.scheme == Scheme::Yade { 0.5 * setting.step } else { 0.0 };
    let mut total = 0.0;
    for (slot, ball) in state.balls.iter().enumerate() {
        if !ball.alone {
            continue;
        }
        let (light, load) = (state.light.at(slot), &state.loads[slot]);
        let velocity = ball.velocity + (load.force * light.mass + setting.gravity) * ahead;
        total += 0.5 / light.mass * velocity.norm_squared();
        if let Some(spin) = state.spins.get(slot) {
            let spin = spin + load.torque * (light.inertia * ahead);
            total += 0.5 / light.inertia * spin.norm_squared();
        }
    }
    for solid in &state.solids {
        let body = &model.bodies[solid.body as usize];
        let velocity = solid.velocity + (solid.load.force / body.mass + setting.gravity) * ahead;
        let momentum = solid.momentum + solid.load.torque * ahead;
        let inner = solid.turn.inverse_transform_vector(&momentum);
        total += 0.5 * body.mass * velocity.norm_squared()
            + 0.5 * inner.component_div(&body.inertia).dot(&inner);
    }
    total
}

/// Σ m g·x over all bodies, J.
fn height(setting: &Setting<'_>, state: &State) -> f64 {
    let bodies = state.paths(setting).zip(&setting.model.bodies);
    bodies.map(|((place, _), body)| body.mass * setting.gravity.dot(&place)).sum()
}

/// Potential energy in uniform gravity and between the bodies, J.
pub fn potential(setting: &Setting<'_>, state: &State) -> f64 {
    let between = match &setting.model.mutual {
        Some(law) => super::far::Far::new(1).energy(setting, state, law),
        None => 0.0,
    };
    between + state.ledger.carried - height(setting, state)
}

/// The row of the series for the present step.
pub fn row(setting: &Setting<'_>, state: &State) -> SeriesRow {
    let ledger = &state.ledger;
    let found = sweep(setting, state);
    let kinetic = kinetic(setting, state);
    let gravitational = potential(setting, state) - ledger.start_potential;
    let lost = ledger.contacts.normal_dashpot
        + ledger.contacts.tangential_dashpot
        + ledger.contacts.slip
        + ledger.local_damping
        + state.bonds.damped
        + state.bonds.released
        + ledger.zeroed
        + ledger.lost
        + ledger.contacts.rolling
        + ledger.contacts.wetting
        + ledger.drag;
    let momentum: Vec3 = state
        .paths(setting)
        .zip(&setting.model.bodies)
        .map(|((_, velocity), body)| velocity * body.mass)
        .sum();
    let energy_error =
        kinetic + found.elastic + found.bonds + found.attraction + gravitational + lost
            - ledger.wall_work
            - ledger.start;
    SeriesRow {
        time: state.step as f64 * setting.step,
        step: state.step,
        kinetic,
        elastic: found.elastic,
        gravitational,
        normal_dashpot: ledger.contacts.normal_dashpot,
        tangential_dashpot: ledger.contacts.tangential_dashpot,
        slip: ledger.contacts.slip,
        local_damping: ledger.local_damping,
        attraction: found.attraction,
        rolling: ledger.contacts.rolling,
        wetting: ledger.contacts.wetting,
        drag: ledger.drag,
        wall_work: ledger.wall_work,
        bond_elastic: found.bonds,
        bond_damping: state.bonds.damped,
        bond_released: state.bonds.released,
        bonds: state.bonds.intact(),
        zeroed: ledger.zeroed,
        lost: state.gone.all.len() as u64,
        lost_energy: ledger.lost,
        energy_error: setting.model.plan.ledger.then_some(energy_error),
        contacts: found.contacts,
        coordination: 2.0 * found.between as f64 / setting.model.bodies.len().max(1) as f64,
        worst_overlap: found.worst_overlap,
        momentum: momentum.norm(),
    }
}

/// Sphere–sphere contacts after the last force pass, by sphere numbers. Forces
/// are those of the pass: elastic part from the overlap, the rest from the book.
/// Of path-averaged contacts with dashpots it is the mean over the last step.
pub fn touches(setting: &Setting<'_>, state: &State) -> Vec<Touch> {
    let count = state.pairs.book.touching.iter().filter(|touching| **touching).count();
    let mut all = Vec::with_capacity(count);
    visit(&state.pairs, |slot, other, k| {
        let (a, b) = (&state.balls[slot], &state.balls[other]);
        let overlap = a.radius + b.radius - setting.way(a.place - b.place).norm();
        let law = setting.pair(a.material, b.material);
        let record = state.pairs.book.record(k);
        let (first, second) = (state.order[slot], state.order[other]);
        all.push(Touch {
            first: first.min(second),
            second: first.max(second),
            normal: match setting.scheme {
                Scheme::PathAveraged if setting.kept.damping => record.lag,
                _ => law.kn * overlap + record.lag,
            },
            tangential: law.kt * record.spring.norm(),
        });
    });
    if setting.needs.bonds {
        all.extend(bond::touches(setting, state));
    }
    all.retain(|touch| touch.normal.is_finite() && touch.tangential.is_finite());
    all.sort_unstable_by_key(|touch| (touch.first, touch.second));
    all
}
