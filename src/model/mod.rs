//! The hub: a scene as every solver sees it. Our own DEM and the deck writers
//! know this room and nothing of scene files; reports know `Run`, not who made it.

pub mod body;
pub mod bond;
pub mod contact;
pub mod decks;
pub mod extra;
pub mod far;
pub mod needs;
pub mod plan;
pub mod restitution;
pub mod run;
pub mod spring;
pub mod state;
pub mod wall;

pub use body::{Body, Material, Sphere};
pub use bond::{Bond, Break, BreakMode, Section, Strength};
pub use contact::{Contact, ContactTable};
pub use decks::{ClumpRoute, Decks};
pub use extra::{Extra, PairForces};
pub use far::{FarMethod, MutualGravity, TreeParameters};
pub use needs::Needs;
pub use plan::{Arm, Coulomb, Guard, History, LOOK_EVERY, Law, Lost, Plan, Scheme, StepReason};
pub use run::{Cost, Outcome, Run, SeriesRow, Touch};
pub use spring::{Partner, Spring};
pub use state::{BodyState, Frame};
pub use wall::{Motion, Wall, WallShape};

use crate::geometry::{Bounds, Cell};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};

/// Number of space dimensions. In two, bodies are discs of unit thickness (1 m)
/// in the x–y plane that spin about z.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Dimension {
    /// Discs of unit thickness in the x–y plane.
    Two,
    /// Spheres and rigid clumps of spheres.
    Three,
}

impl Dimension {
    /// 2 or 3.
    pub fn count(self) -> usize {
        match self {
            Self::Two => 2,
            Self::Three => 3,
        }
    }
}

/// Everything a solver has to know, in SI units.
///
/// Invariants (upheld by the scene room, relied on by all others): spheres are
/// stored body by body; every number is finite; masses, radii and moments of
/// inertia are greater than zero; there are no more arrivals than bodies; all material indices exist in `materials`
/// and `contacts`; `domain` holds every sphere and wall mesh at time 0; a bond joins spheres of
/// different bodies, first < second, at most one bond a pair.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// Name for people.
    pub title: String,
    /// Two or three dimensions.
    pub dimension: Dimension,
    /// Seed of the scene, for the record.
    pub seed: u64,
    /// Rigid bodies in their state at time 0.
    pub bodies: Vec<Body>,
    /// Spheres of all bodies, body by body.
    pub spheres: Vec<Sphere>,
    /// Bonds between spheres of different bodies; none in most scenes.
    pub bonds: Vec<Bond>,
    /// Materials of bodies and walls.
    pub materials: Vec<Material>,
    /// Contact parameters of every pair of materials.
    pub contacts: ContactTable,
    /// Attraction, rolling resistance and drag; empty in most scenes.
    pub extra: Extra,
    /// Walls, still or moving.
    pub walls: Vec<Wall>,
    /// Acceleration of gravity, m/s².
    pub gravity: Vec3,
    /// Gravity between bodies, if any.
    pub mutual: Option<MutualGravity>,
    /// Local (non-viscous) damping coefficient α of Cundall as YADE applies it,
    /// 0 for none: per axis, a ← a (1 − α sign(a (v + a Δt/2))).
    pub local_damping: f64,
    /// The room that the bodies must not leave; a body outside ends the run as an outcome.
    pub domain: Bounds,
    /// How space repeats itself, if it does; `domain` ends at its periodic sides.
    pub periodic: Option<Cell>,
    /// Scheme, step and duration.
    pub plan: Plan,
    /// Tangential springs that contacts have at time 0; none in most scenes.
    pub springs: Vec<Spring>,
    /// Times at which the last bodies come, s, in rising order, one a body; before that they touch nothing
    /// and stay where they will come. None in most scenes.
    pub arrivals: Vec<f64>,
    /// Choices for the decks of outside solvers.
    pub decks: Decks,
}

impl Model {
    /// No bodies, walls or gravity; one material in the cube from −1 m to 1 m.
    pub fn empty(dimension: Dimension, material: Material, contact: Contact, plan: Plan) -> Self {
        Self {
            title: String::new(),
            dimension,
            seed: 0,
            bodies: Vec::new(),
            spheres: Vec::new(),
            bonds: Vec::new(),
            materials: vec![material],
            contacts: ContactTable::uniform(1, contact),
            extra: Extra::default(),
            walls: Vec::new(),
            gravity: Vec3::zeros(),
            mutual: None,
            local_damping: 0.0,
            domain: Bounds { low: Vec3::repeat(-1.0), high: Vec3::repeat(1.0) },
            periodic: None,
            plan,
            springs: Vec::new(),
            arrivals: Vec::new(),
            decks: Decks::default(),
        }
    }

    /// Adds a body that is one sphere (a disc in two dimensions) of `radius` (m) and `density`
    /// (kg/m³) at `place` (m), at rest; its velocities can be set on what is given back.
    pub fn add_sphere(
        &mut self,
        place: Vec3,
        radius: f64,
        density: f64,
        material: u16,
    ) -> &mut Body {
        let (index, first) = (self.bodies.len(), self.spheres.len() as u32);
        self.spheres.push(Sphere { offset: Vec3::zeros(), radius, body: index as u32 });
        self.bodies.push(Body::sphere(self.dimension, place, radius, density, material, first));
        &mut self.bodies[index]
    }

    /// What this scene needs; the only place that decides it.
    pub fn needs(&self) -> Needs {
        Needs::of(self)
    }

    /// The spheres of body `index`.
    pub fn spheres_of(&self, index: usize) -> &[Sphere] {
        let body = &self.bodies[index];
        &self.spheres[body.first_sphere as usize..][..body.sphere_count as usize]
    }

    /// Radius of the smallest sphere, m; infinite without spheres.
    pub fn smallest_radius(&self) -> f64 {
        self.spheres.iter().map(|sphere| sphere.radius).fold(f64::INFINITY, f64::min)
    }

    /// Radius of the largest sphere, m; 0 without spheres.
    pub fn largest_radius(&self) -> f64 {
        self.spheres.iter().map(|sphere| sphere.radius).fold(0.0, f64::max)
    }

    /// Index of the first body that is not there from the start.
    pub fn first_arrival(&self) -> usize {
        self.bodies.len() - self.arrivals.len()
    }

    /// Step after which body `index` is there; 0 for one that is there from the start.
    pub fn arrival_step(&self, index: usize) -> u64 {
        match index.checked_sub(self.first_arrival()) {
            None => 0,
            Some(at) => self.step_at(self.arrivals[at]),
        }
    }

    /// How many of the bodies that come during the run are there after step `step`.
    pub fn arrived_by(&self, step: u64) -> usize {
        self.arrivals.partition_point(|time| self.step_at(*time) <= step)
    }

    /// The bodies that come within the steps of the plan, with their indices.
    pub fn coming(&self) -> impl Iterator<Item = (usize, &Body)> {
        let (first, count) = (self.first_arrival(), self.arrived_by(self.plan.steps));
        self.bodies.iter().enumerate().skip(first).take(count)
    }

    /// The step nearest to a time [s] after the start.
    fn step_at(&self, time: f64) -> u64 {
        (time / self.plan.step).round().max(1.0) as u64
    }

    /// Position of the centre of every sphere for the given body states
    /// (`states[body]`), metres.
    pub fn sphere_centres(&self, states: &[BodyState]) -> Vec<Vec3> {
        self.spheres
            .iter()
            .map(|sphere| {
                let state = &states[sphere.body as usize];
                state.position + state.orientation * sphere.offset
            })
            .collect()
    }

    /// The way `way` between two places, in a periodic box that to the nearest image.
    pub fn way(&self, way: Vec3) -> Vec3 {
        self.periodic.map_or(way, |cell| cell.way(&way))
    }

    /// Whether `place` is outside the domain; along periodic axes nothing is.
    pub fn is_outside(&self, place: &Vec3) -> bool {
        (0..self.dimension.count()).any(|axis| {
            let wraps = self.periodic.is_some_and(|cell| cell.periodic[axis]);
            let inside = (self.domain.low[axis]..=self.domain.high[axis]).contains(&place[axis]);
            !wraps && !inside
        })
    }

    /// State of every body at time 0.
    pub fn initial_states(&self) -> Vec<BodyState> {
        self.bodies.iter().map(Body::state).collect()
    }
}
