//! What changes in time.

use super::Model;
use crate::num::{Rotation, Vec3};
use serde::{Deserialize, Serialize};

/// Position and motion of one body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyState {
    /// Centre of mass, m.
    pub position: Vec3,
    /// Turns body-frame vectors into world-frame vectors.
    pub orientation: Rotation,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vec3,
    /// Angular velocity in the world frame, rad/s.
    pub spin: Vec3,
}

/// A snapshot of a run, as any solver can give it: per sphere of the model, in
/// its order. Body states are exact where the solver gives them, else rebuilt.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Step number.
    pub step: u64,
    /// Time, s.
    pub time: f64,
    /// Centre of every sphere, m.
    pub centres: Vec<Vec3>,
    /// Velocity of every sphere centre, m/s (at half a step earlier in YADE's scheme).
    pub velocities: Vec<Vec3>,
    /// Angular velocity of every sphere (of its body), rad/s.
    pub spins: Vec<Vec3>,
    /// Force on every sphere, contacts only or with gravity as the solver has it, N.
    pub forces: Vec<Vec3>,
    /// State of every body.
    pub bodies: Vec<BodyState>,
}

impl Frame {
    /// The state of a model at time 0, without forces.
    pub fn initial(model: &Model) -> Self {
        let bodies = model.initial_states();
        let centres = model.sphere_centres(&bodies);
        let velocities = model
            .spheres
            .iter()
            .zip(&centres)
            .map(|(sphere, centre)| {
                let state = &bodies[sphere.body as usize];
                state.velocity + state.spin.cross(&(centre - state.position))
            })
            .collect();
        let spins = model.spheres.iter().map(|sphere| bodies[sphere.body as usize].spin).collect();
        let forces = vec![Vec3::zeros(); centres.len()];
        Self { step: 0, time: 0.0, centres, velocities, spins, forces, bodies }
    }

    /// Brings every body whose centre of mass lies outside a periodic box home, its spheres with it.
    pub fn bring_home(&mut self, model: &Model) {
        let Some(cell) = &model.periodic else { return };
        for (state, body) in self.bodies.iter_mut().zip(&model.bodies) {
            let way = cell.home(&state.position);
            if way != Vec3::zeros() {
                state.position += way;
                let range =
                    body.first_sphere as usize..(body.first_sphere + body.sphere_count) as usize;
                self.centres[range].iter_mut().for_each(|centre| *centre += way);
            }
        }
    }

    /// Kinetic energy of translation and rotation, J.
    pub fn kinetic_energy(&self, model: &Model) -> f64 {
        self.bodies
            .iter()
            .zip(&model.bodies)
            .map(|(state, body)| state.kinetic_energy(body.mass, &body.inertia))
            .sum()
    }
}

impl BodyState {
    /// Kinetic energy of a body with this mass (kg) and principal inertia (kg m²), J.
    pub fn kinetic_energy(&self, mass: f64, inertia: &Vec3) -> f64 {
        let spin = self.orientation.inverse_transform_vector(&self.spin);
        0.5 * mass * self.velocity.norm_squared() + 0.5 * inertia.component_mul(&spin).dot(&spin)
    }
}
