//! Small models for the tests of this room.

use crate::geometry::{Bounds, Mesh};
use crate::model::{
    Body, Contact, Dimension, Material, Model, Motion, Plan, Scheme, Sphere, Wall, WallShape,
};
use crate::num::{Rotation, Vec3};

/// An ordinary contact with friction and both dashpots.
pub fn contact() -> Contact {
    Contact { kn: 1e4, kt: 5e3, cn: 0.3, ct: 0.1, friction: 0.5 }
}

/// A model without bodies or walls.
pub fn empty(dimension: Dimension, contact: Contact) -> Model {
    let material = Material { name: "stone".into(), density: 2500.0 };
    let plan = Plan {
        step: 1e-6,
        steps: 1000,
        frame_every: 500,
        series_every: 100,
        ..Plan::new(Scheme::Liggghts)
    };
    Model {
        title: "example".into(),
        seed: 7,
        domain: Bounds { low: Vec3::repeat(-0.02), high: Vec3::repeat(0.02) },
        ..Model::empty(dimension, material, contact, plan)
    }
}

/// Adds a body of one sphere of material `material`.
pub fn add_sphere(model: &mut Model, at: Vec3, radius: f64, velocity: Vec3, material: u16) {
    let density = model.materials[usize::from(material)].density;
    model.add_sphere(at, radius, density, material).velocity = velocity;
}

/// Adds a clump of four spheres (a bent row of three discs in two dimensions).
pub fn add_clump(model: &mut Model, at: Vec3) {
    let mut offsets = vec![
        Vec3::new(1e-3, 0.0, 0.0),
        Vec3::new(-0.6e-3, 0.7e-3, 0.0),
        Vec3::new(-0.5e-3, -0.6e-3, 0.0),
    ];
    let flat = model.dimension == Dimension::Two;
    if !flat {
        offsets.iter_mut().for_each(|offset| offset.z = -0.2e-3);
        offsets.push(Vec3::new(0.1e-3, 0.0, 0.8e-3));
    }
    let index = model.bodies.len() as u32;
    let first = model.spheres.len() as u32;
    model.bodies.push(Body {
        position: at,
        orientation: if flat {
            Rotation::from_scaled_axis(Vec3::z() * 0.4)
        } else {
            Rotation::from_scaled_axis(Vec3::new(0.3, -0.5, 0.8))
        },
        velocity: Vec3::new(0.1, 0.0, if flat { 0.0 } else { -0.2 }),
        spin: if flat { Vec3::z() * 30.0 } else { Vec3::new(100.0, -50.0, 150.0) },
        mass: 2e-5,
        inertia: Vec3::new(1.1e-11, 1.4e-11, 1.7e-11),
        first_sphere: first,
        sphere_count: offsets.len() as u32,
        material: 0,
        family: 0,
        grain: 0,
    });
    for offset in offsets {
        model.spheres.push(Sphere { offset, radius: 0.9e-3, body: index });
    }
}

/// Adds a plane wall.
pub fn add_plane(model: &mut Model, name: &str, point: Vec3, normal: Vec3, motion: Motion) {
    let shape = WallShape::Plane { point, normal: normal.normalize() };
    model.walls.push(Wall { name: name.into(), shape, motion, material: 0 });
}

/// A square of two triangles at height `z`, edges 10 mm.
pub fn plate(z: f64) -> Mesh {
    let corner = |x: f64, y: f64| Vec3::new(x * 5e-3, y * 5e-3, z);
    Mesh {
        vertices: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// Two spheres that meet off centre, no walls, no gravity.
pub fn two_spheres() -> Model {
    let mut model = empty(Dimension::Three, contact());
    add_sphere(&mut model, Vec3::zeros(), 1e-3, Vec3::new(0.5, 0.0, 0.0), 0);
    add_sphere(&mut model, Vec3::new(2.1e-3, 0.5e-3, 0.0), 1e-3, Vec3::zeros(), 0);
    model
}

/// Two clumps and a sphere that fall on a floor.
pub fn clumps() -> Model {
    let mut model = empty(Dimension::Three, contact());
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    add_clump(&mut model, Vec3::new(0.0, 0.0, 3e-3));
    add_clump(&mut model, Vec3::new(4e-3, 1e-3, 3.5e-3));
    add_sphere(&mut model, Vec3::new(0.0, 5e-3, 2e-3), 1e-3, Vec3::zeros(), 0);
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    model
}

/// Discs in a corner of an axis plane and an oblique one.
pub fn discs() -> Model {
    let mut model = empty(Dimension::Two, contact());
    model.gravity = Vec3::new(0.0, -9.81, 0.0);
    add_sphere(&mut model, Vec3::new(0.0, 1.5e-3, 0.0), 1e-3, Vec3::new(0.2, -0.5, 0.0), 0);
    add_sphere(&mut model, Vec3::new(2.5e-3, 1.5e-3, 0.0), 1.2e-3, Vec3::zeros(), 0);
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::y(), Motion::Still);
    let slope = Vec3::new(-1.0, 1.0, 0.0);
    add_plane(&mut model, "slope", Vec3::new(4e-3, 0.0, 0.0), slope, Motion::Still);
    model
}

/// One sphere on a plate that turns, beside a wall that slides.
pub fn moving_mesh() -> Model {
    let mut model = empty(Dimension::Three, contact());
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    add_sphere(&mut model, Vec3::new(1e-3, 2e-3, 1.01e-3), 1e-3, Vec3::new(0.0, 0.0, -0.1), 0);
    let turn = Motion::Rotate { origin: Vec3::zeros(), axis: Vec3::z(), rate: -5.0 };
    model.walls.push(Wall {
        name: "plate".into(),
        shape: WallShape::Mesh { mesh: plate(0.0) },
        motion: turn,
        material: 0,
    });
    let slide = Motion::Translate { velocity: Vec3::new(0.1, 0.0, 0.0) };
    add_plane(&mut model, "lid", Vec3::new(0.0, 0.0, 8e-3), -Vec3::z(), slide);
    model
}

/// Two spheres without friction on a floor.
pub fn frictionless() -> Model {
    let contact = Contact { kt: 0.0, ct: 0.0, friction: 0.0, ..contact() };
    let mut model = empty(Dimension::Three, contact);
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    add_sphere(&mut model, Vec3::new(0.0, 0.0, 1.1e-3), 1e-3, Vec3::zeros(), 0);
    add_sphere(&mut model, Vec3::new(0.3e-3, 0.0, 3.2e-3), 1e-3, Vec3::new(0.0, 0.0, -0.3), 0);
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    model
}
