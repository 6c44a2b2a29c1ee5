//! Gravity between bodies (D6): a pass of its own, which scenes without it do not run.
//!
//! a_i = −G Σ_j m_j (x_i − x_j) / (r² + ε²)^{3/2} over all other bodies j, taken as point masses
//! at their centres of mass; U = −G Σ_{i<j} m_i m_j / (r² + ε²)^{1/2}. Softening ε: Plummer (1911).
//! Either every pair, O(n²), or far groups as one by an octree (see [`super::far_tree`]), O(n log n).
//!
//! Each body sums what pulls it in an order that depends on the bodies only, so numbers are
//! equal to the bit at any number of threads. Summing every pair keeps momentum to rounding;
//! the tree does not quite (its forces on groups have no exact counterpart).
//! Forces go on top of those of contacts: on the sphere of a body that is one, on the centre
//! of mass of a clump. Cannot fail; two bodies at one place do not attract each other.

use super::far_tree::{LEAF, Pull, Tree};
use super::setting::Setting;
use super::state::State;
use crate::model::{FarMethod, MutualGravity};
use crate::num::Vec3;
use rayon::prelude::*;

/// Bodies a block of work.
const BLOCK: usize = 64;
/// Below this number of bodies a pass is shorter than waking a second thread.
const WORTH_THREADS: usize = 256;

/// Scratch memory and threads.
#[derive(Debug, Default)]
pub struct Far {
    threads: usize,
    pool: Option<rayon::ThreadPool>,
    places: Vec<Vec3>,
    masses: Vec<f64>,
    pulls: Vec<Pull>,
    tree: Tree,
}

impl Far {
    /// Scratch for `threads` threads; takes nothing before it is used.
    pub fn new(threads: usize) -> Self {
        Self { threads, ..Self::default() }
    }

    /// Adds the attraction of the bodies, where they are now, to the loads; returns the
    /// number of terms summed.
    pub fn add(&mut self, setting: &Setting<'_>, state: &mut State, law: &MutualGravity) -> u64 {
        self.look(setting, state);
        self.sum(law);
        let pull = |body: u32| {
            let body = body as usize;
            self.pulls[body].field * (law.constant * self.masses[body])
        };
        for (ball, load) in state.balls.iter().zip(&mut state.loads) {
            if ball.alone {
                load.force += pull(ball.body);
            }
        }
        for solid in &mut state.solids {
            solid.load.force += pull(solid.body);
        }
        self.pulls.iter().map(|pull| pull.terms).sum()
    }

    /// Potential energy of the bodies where they are now, J.
    pub fn energy(&mut self, setting: &Setting<'_>, state: &State, law: &MutualGravity) -> f64 {
        self.look(setting, state);
        self.sum(law);
        let each = self.pulls.iter().zip(&self.masses).map(|(pull, mass)| pull.potential * mass);
        0.5 * law.constant * each.sum::<f64>()
    }

    fn look(&mut self, setting: &Setting<'_>, state: &State) {
        let bodies = &setting.model.bodies;
        if self.masses.len() != bodies.len() {
            self.masses = bodies.iter().map(|body| body.mass).collect();
            self.places = vec![Vec3::zeros(); bodies.len()];
            self.pulls = vec![Pull::default(); bodies.len()];
            self.pool = (self.threads > 1 && bodies.len() >= WORTH_THREADS)
                .then(|| rayon::ThreadPoolBuilder::new().num_threads(self.threads).build().ok())
                .flatten();
        }
        for ball in state.balls.iter().filter(|ball| ball.alone) {
            self.places[ball.body as usize] = ball.place;
        }
        for solid in &state.solids {
            self.places[solid.body as usize] = solid.place;
        }
    }

    fn sum(&mut self, law: &MutualGravity) {
        let soft = law.softening.0 * law.softening.0;
        let (places, masses, pulls) = (&self.places, &self.masses, &mut self.pulls);
        match law.method {
            FarMethod::AllPairs => each(&self.pool, pulls, |own| pairs(places, masses, own, soft)),
            FarMethod::Tree(tree) => {
                self.tree.build(places, masses, tree.theta, LEAF);
                let (walked, tree_of) = (tree.quadrupole, &self.tree);
                let mut sorted = vec![Pull::default(); pulls.len()];
                each(&self.pool, &mut sorted, |own| match walked {
                    true => tree_of.walk::<true>(own, soft),
                    false => tree_of.walk::<false>(own, soft),
                });
                for (pull, body) in sorted.iter().zip(&tree_of.order) {
                    pulls[*body as usize] = *pull;
                }
            }
        }
    }
}

/// What all others do to each of these point masses, over the gravitational constant
/// (`law.constant` does not enter): `places` in m and `masses` in kg, arrays of one length.
pub fn attraction(
    places: &[Vec3],
    masses: &[f64],
    law: &MutualGravity,
    threads: usize,
) -> Vec<Pull> {
    let mut far = Far::new(threads);
    far.masses = masses.to_vec();
    far.places = places.to_vec();
    far.pulls = vec![Pull::default(); places.len()];
    far.sum(law);
    far.pulls
}

/// Fills `pulls` with `of` its index, by blocks.
fn each(pool: &Option<rayon::ThreadPool>, pulls: &mut [Pull], of: impl Fn(usize) -> Pull + Sync) {
    let block = |(number, part): (usize, &mut [Pull])| {
        for (offset, pull) in part.iter_mut().enumerate() {
            *pull = of(number * BLOCK + offset);
        }
    };
    match pool {
        None => pulls.chunks_mut(BLOCK).enumerate().for_each(block),
        Some(pool) => {
            pool.install(|| pulls.par_chunks_mut(BLOCK).enumerate().for_each(block));
        }
    }
}

/// What all others do to body `own`.
fn pairs(places: &[Vec3], masses: &[f64], own: usize, soft: f64) -> Pull {
    let mut pull = Pull::default();
    let at = places[own];
    for range in [0..own, own + 1..places.len()] {
        for (place, mass) in places[range.clone()].iter().zip(&masses[range]) {
            let way = at - place;
            pull.add_point(&way, way.norm_squared() + soft, *mass);
        }
    }
    pull
}
