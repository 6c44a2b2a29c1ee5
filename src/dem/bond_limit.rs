//! How large a step bonds allow: their part of the block bound of [`super::limit`].
//!
//! A bond's energy is a sum of squares of (first body's part + second body's part), each at
//! most twice the sum of their squares. So a bond adds 2 k u uᵀ to the 6 × 6 block of each of
//! its bodies for each of its springs: along the line of centres and two across it,
//! u = (d/√m, (r × d)/√I), with r from the centre of mass to the middle of the contact; and for
//! bending and twisting u = (0, d/√I). Rigorous for small displacements; terms of the size of
//! the force over the length, which come with large ones, are left out.
//! Dashpots of viscous time β give a mode of frequency ω the damping ratio β ω/2.

use super::bond::{Bonds, Status};
use super::setting::Setting;
use super::state::State;
use crate::model::{Body, Model};
use crate::num::{Rotation, Vec3};
use nalgebra::{Matrix6, SymmetricEigen, Vector6};

/// A spring of a bond as one of its bodies feels it: adds `stiffness · way · wayᵀ` to its block.
pub struct Part {
    /// Index of the body.
    pub body: u32,
    /// Mass-scaled direction.
    pub way: Vector6<f64>,
    /// Twice the stiffness.
    pub stiffness: f64,
    /// β, s.
    pub viscosity: f64,
}

/// Calls `visit` for every body of every spring of every intact bond.
pub fn each_part(setting: &Setting<'_>, state: &State, mut visit: impl FnMut(Part)) {
    let intact = |bonds: &Bonds, index: usize| bonds.status[index] == Status::Intact;
    for (index, bond) in setting.model.bonds.iter().enumerate() {
        if !intact(&state.bonds, index) {
            continue;
        }
        let slots = [bond.first, bond.second].map(|s| state.slot[s as usize] as usize);
        let [one, two] = slots.map(|slot| &state.balls[slot]);
        let between = two.place - one.place;
        let normal = between.normalize();
        let overlap = one.radius + two.radius - between.norm();
        let point = one.place + normal * (one.radius - 0.5 * overlap);
        let side = normal.cross(&if normal.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() });
        let side = side.normalize();
        let other = normal.cross(&side);
        let springs = [
            (normal, bond.normal, bond.twisting),
            (side, bond.shear, bond.bending),
            (other, bond.shear, bond.bending),
        ];
        for ball in [one, two] {
            let body = &setting.model.bodies[ball.body as usize];
            let (centre, turn) = stance(state, ball, body);
            for (direction, push, turning) in springs {
                let lever = (point - centre).cross(&direction);
                for (force, torque, stiffness) in
                    [(direction, lever, push), (Vec3::zeros(), direction, turning)]
                {
                    if stiffness > 0.0 {
                        let way = scaled(setting, body, &turn, force, torque);
                        let stiffness = 2.0 * stiffness;
                        visit(Part { body: ball.body, way, stiffness, viscosity: bond.viscosity });
                    }
                }
            }
        }
    }
}

/// Centre of mass and orientation of a ball's body.
fn stance(state: &State, ball: &super::state::Ball, body: &Body) -> (Vec3, Rotation) {
    let found = state.solids.binary_search_by_key(&ball.body, |solid| solid.body);
    match found {
        Ok(at) => (state.solids[at].place, state.solids[at].turn),
        Err(_) => (ball.place, body.orientation),
    }
}

fn scaled(
    setting: &Setting<'_>,
    body: &Body,
    turn: &Rotation,
    force: Vec3,
    torque: Vec3,
) -> Vector6<f64> {
    let mut push = force / body.mass.sqrt();
    let mut twist =
        turn.inverse_transform_vector(&torque).component_div(&body.inertia.map(f64::sqrt));
    if setting.planar {
        push.z = 0.0;
        twist = Vec3::z() * (torque.z / body.inertia.z.sqrt());
    }
    Vector6::new(push.x, push.y, push.z, twist.x, twist.y, twist.z)
}

/// Largest stable step for the bonds at time 0 if every bonded body, as far as its bonds leave
/// room, is also packed by contacts with the bound `packed`, s; `None` without bonds.
pub fn packed(setting: &Setting<'_>, state: &State, packed: f64) -> Option<f64> {
    if !setting.needs.bonds {
        return None;
    }
    let bodies = setting.model.bodies.len();
    let mut blocks = vec![Matrix6::<f64>::zeros(); bodies];
    let (mut count, mut viscosity) = (vec![0.0f64; bodies], vec![0.0f64; bodies]);
    each_part(setting, state, |part| {
        let body = part.body as usize;
        blocks[body] += part.way * part.way.transpose() * part.stiffness;
        viscosity[body] = viscosity[body].max(part.viscosity);
    });
    for bond in &setting.model.bonds {
        for sphere in [bond.first, bond.second] {
            count[setting.model.spheres[sphere as usize].body as usize] += 1.0;
        }
    }
    let most = if setting.planar { 6.0 } else { 12.0 };
    let dense = 4.0 / (packed * packed);
    (0..bodies)
        .filter(|body| count[*body] > 0.0)
        .map(|body| {
            let own = SymmetricEigen::new(blocks[body]).eigenvalues.max();
            let free = (1.0 - count[body] / most).max(0.0);
            let zeta = 0.5 * viscosity[body] * own.sqrt();
            super::limit::shrink(zeta) * 2.0 / (own + dense * free).sqrt()
        })
        .min_by(f64::total_cmp)
}

/// Shortest half period π√(m_eff/kn) of a bond pulled along its line of centres, s.
pub fn shortest(model: &Model) -> f64 {
    let mass = |sphere: u32| model.bodies[model.spheres[sphere as usize].body as usize].mass;
    let time = |bond: &crate::model::Bond| {
        let (a, b) = (mass(bond.first), mass(bond.second));
        std::f64::consts::PI * (a * b / (a + b) / bond.normal).sqrt()
    };
    model.bonds.iter().map(time).fold(f64::INFINITY, f64::min)
}
