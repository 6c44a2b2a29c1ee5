//! Small models that studies run.

use crate::geometry::{Bounds, Cell};
use crate::model::{
    Body, Contact, ContactTable, Dimension, Material, Model, Motion, Plan, Scheme, Sphere,
    StepReason, Wall, WallShape,
};
use crate::num::Vec3;
use crate::pack::scatter;
use crate::pack::space::Space;

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

/// Equal spheres that fill `share` of a cube of edge 1 m whose sides repeat, at random places without overlap.
pub fn loose_spheres(count: usize, share: f64) -> Model {
    let contact = Contact { kn: 1e5, kt: 2.0 / 7.0 * 1e5, cn: 0.0, ct: 0.0, friction: 0.0 };
    let mut model = empty(Scheme::Leapfrog, contact, 2500.0);
    let bounds = Bounds { low: Vec3::zeros(), high: Vec3::repeat(1.0) };
    model.domain = bounds;
    model.periodic = Some(Cell { bounds, periodic: [true; 3] });
    let radius = (share / (4.0 / 3.0 * std::f64::consts::PI) / count as f64).cbrt();
    let space = Space::repeating(3, Vec3::repeat(1.0));
    if let Some((centres, _)) = scatter::apart(&space, &vec![radius; count], 100_000, 1) {
        for centre in centres {
            sphere(&mut model, centre, radius, 2500.0, Vec3::zeros());
        }
    }
    model
}
