//! Small models that studies run.

use crate::geometry::Bounds;
use crate::model::{
    Body, Contact, ContactTable, Dimension, Material, Model, Motion, Plan, Scheme, Sphere,
    StepReason, Wall, WallShape,
};
use crate::num::Vec3;

/// A model in three dimensions without bodies, walls and gravity, of one material
/// of `density` [kg/m³]; frames and rows at start and end only; steps to be set.
pub fn empty(scheme: Scheme, contact: Contact, density: f64) -> Model {
    Model {
        title: "study".to_owned(),
        dimension: Dimension::Three,
        seed: 0,
        bodies: Vec::new(),
        spheres: Vec::new(),
        bonds: Vec::new(),
        materials: vec![Material { name: "grain".to_owned(), density }],
        contacts: ContactTable::uniform(1, contact),
        extra: crate::model::Extra::default(),
        walls: Vec::new(),
        gravity: Vec3::zeros(),
        mutual: None,
        local_damping: 0.0,
        domain: Bounds { low: Vec3::repeat(-1.0), high: Vec3::repeat(1.0) },
        periodic: None,
        plan: Plan {
            step: 1e-6,
            reason: StepReason::Given,
            steps: 0,
            frame_every: u64::MAX,
            series_every: u64::MAX,
            checkpoint_every: 0,
            scheme,
            law: scheme.law(),
            zero_every: 0,
            zero_until: 0,
            insist: false,
            guard: Default::default(),
        },
    }
}

/// Adds a plane wall through `point` with the unit `normal` towards the bodies.
pub fn plane(model: &mut Model, point: Vec3, normal: Vec3, motion: Motion) {
    let name = format!("plane{}", model.walls.len());
    model.walls.push(Wall { name, shape: WallShape::Plane { point, normal }, motion, material: 0 });
}

/// Adds a sphere of `radius` [m] and `density` [kg/m³] at `place` [m] with `velocity` [m/s].
pub fn sphere(model: &mut Model, place: Vec3, radius: f64, density: f64, velocity: Vec3) {
    let first = model.spheres.len() as u32;
    let mut body = Body::sphere(model.dimension, place, radius, density, 0, first);
    body.velocity = velocity;
    model.spheres.push(Sphere { offset: Vec3::zeros(), radius, body: model.bodies.len() as u32 });
    model.bodies.push(body);
}
