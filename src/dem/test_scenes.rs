//! Small models for the tests of this room, and what runs and keeps them.

use super::{Observer, run};
use crate::geometry::Mesh;
use crate::model::*;
use crate::num::random::{self, RngExt};
use crate::num::{Job, Rotation, Vec3};

/// All schemes.
pub const SCHEMES: [Scheme; 5] =
    [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Yade, Scheme::Lammps, Scheme::PathAveraged];

/// A run to its end.
pub fn finish(model: &Model) -> Run {
    let run = run(model, &Job::quiet()).expect("a usable model");
    assert_eq!(run.outcome, Outcome::Finished);
    run
}

/// All that a run hands over.
#[derive(Default)]
pub struct Log {
    pub frames: Vec<Frame>,
    pub rows: Vec<SeriesRow>,
    pub checkpoints: Vec<Vec<u8>>,
}

impl Observer for Log {
    fn frame(&mut self, frame: &Frame) {
        self.frames.push(frame.clone());
    }
    fn row(&mut self, row: &SeriesRow) {
        self.rows.push(*row);
    }
    fn checkpoint(&mut self, bytes: &[u8]) {
        self.checkpoints.push(bytes.to_vec());
    }
}

/// Radius, density and stiffness of the unit case of the reference numbers.
pub const RADIUS: f64 = 0.01;
/// See [`RADIUS`].
pub const DENSITY: f64 = 2500.0;
/// See [`RADIUS`].
pub const KN: f64 = 1e5;
/// Mass of the unit sphere, kg.
pub const MASS: f64 = 0.010_471_975_511_965_977;

/// A model without bodies and walls.
pub fn empty(scheme: Scheme, contact: Contact) -> Model {
    let material = Material { name: "grain".to_owned(), density: DENSITY };
    let plan = Plan {
        step: 1e-6,
        // Grains are thrown together as deep as it comes.
        guard: Guard { overlap: 0.0, ..Guard::default() },
        ..Plan::new(scheme)
    };
    let title = "test".to_owned();
    Model { title, seed: 1, ..Model::empty(Dimension::Three, material, contact, plan) }
}

/// kn = [`KN`] and the rest as given.
pub fn contact(kt: f64, cn: f64, ct: f64, friction: f64) -> Contact {
    Contact { kn: KN, kt, cn, ct, friction }
}

/// Adds a sphere (or disc).
pub fn add_sphere(model: &mut Model, place: Vec3, radius: f64, velocity: Vec3, spin: Vec3) {
    let body = model.add_sphere(place, radius, DENSITY, 0);
    (body.velocity, body.spin) = (velocity, spin);
}

/// Adds a clump of three spheres with mass properties of its own.
pub fn add_clump(model: &mut Model, place: Vec3, turn: Rotation, velocity: Vec3, spin: Vec3) {
    let first = model.spheres.len() as u32;
    let body = model.bodies.len() as u32;
    let members = [
        (Vec3::new(-0.4, 0.1, 0.0), 0.8),
        (Vec3::new(0.5, -0.2, 0.1), 0.7),
        (Vec3::new(0.1, 0.6, -0.1), 0.6),
    ];
    for (offset, radius) in members {
        let mut offset = offset * RADIUS;
        if model.dimension == Dimension::Two {
            offset.z = 0.0;
        }
        model.spheres.push(Sphere { offset, radius: radius * RADIUS, body });
    }
    let mass = 1.6 * MASS;
    model.bodies.push(Body {
        position: place,
        orientation: turn,
        velocity,
        spin,
        mass,
        inertia: Vec3::new(0.45, 0.6, 0.8) * (mass * RADIUS * RADIUS),
        first_sphere: first,
        sphere_count: 3,
        material: 0,
        family: 0,
        grain: 0,
    });
}

/// Adds a plane.
pub fn add_plane(model: &mut Model, point: Vec3, normal: Vec3, motion: Motion) {
    let name = format!("wall{}", model.walls.len());
    let shape = WallShape::Plane { point, normal: normal.normalize() };
    model.walls.push(Wall { name, shape, motion, material: 0 });
}

/// Adds a square of `cells` × `cells` × 2 triangles in the plane z = `height`, bent down by
/// `slope` for x > 0.
pub fn add_sheet(
    model: &mut Model,
    cells: u32,
    half: f64,
    height: f64,
    slope: f64,
    motion: Motion,
) {
    let mut mesh = Mesh::default();
    for j in 0..=cells {
        for i in 0..=cells {
            let at = |k: u32| -half + 2.0 * half * f64::from(k) / f64::from(cells);
            let x = at(i);
            mesh.vertices.push(Vec3::new(x, at(j), height - slope * x.max(0.0)));
        }
    }
    let index = |i: u32, j: u32| i + j * (cells + 1);
    for j in 0..cells {
        for i in 0..cells {
            let (a, b) = (index(i, j), index(i + 1, j));
            let (c, d) = (index(i + 1, j + 1), index(i, j + 1));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let name = format!("wall{}", model.walls.len());
    model.walls.push(Wall { name, shape: WallShape::Mesh { mesh }, motion, material: 0 });
}

/// Spheres of widely different radii at random places, overlaps allowed.
pub fn wide_sizes(count: usize, ratio: f64) -> Model {
    let mut model = empty(Scheme::Leapfrog, contact(0.3 * KN, 1.0, 0.0, 0.4));
    let mut source = random::stream(5, "test", 0);
    for _ in 0..count {
        let radius = 1e-3 * ratio.powf(source.random::<f64>());
        let place = Vec3::from_fn(|_, _| random::uniform(&mut source, -0.03, 0.03));
        add_sphere(&mut model, place, radius, Vec3::zeros(), Vec3::zeros());
    }
    model
}

/// Grains thrown together in a box of planes, with clumps, a mesh floor and
/// a slanted plane as asked for; random velocities and spins.
pub fn mixed(scheme: Scheme, dimension: Dimension, clumps: bool, mesh: bool, seed: u64) -> Model {
    let mut model = empty(scheme, contact(0.4 * KN, 6.0, 2.0, 0.4));
    model.dimension = dimension;
    let flat = dimension == Dimension::Two;
    model.gravity = if flat { Vec3::new(0.3, -9.81, 0.0) } else { Vec3::new(0.3, 0.0, -9.81) };
    model.plan.step = 2e-5;
    let up = if flat { Vec3::y() } else { Vec3::z() };
    let mut source = random::stream(seed, "mixed", 0);
    let mut draw = |size: f64| {
        let v = Vec3::from_fn(|_, _| random::uniform(&mut source, -size, size));
        if flat { Vec3::new(v.x, v.y, 0.0) } else { v }
    };
    for layer in 0..3 {
        for place in 0..9 {
            let (i, j) = (f64::from(place % 3) - 1.0, f64::from(place / 3) - 1.0);
            let mut centre =
                (Vec3::x() * i * 2.03 + up * (f64::from(layer) * 2.02 + 1.01)) * RADIUS;
            if flat {
                if place >= 3 {
                    continue;
                }
            } else {
                centre.y += j * 2.03 * RADIUS;
            }
            let (centre, velocity) = (centre + draw(0.01 * RADIUS), draw(0.3));
            let spin = if flat { Vec3::z() * draw(30.0).x } else { draw(30.0) };
            if clumps && place % 2 == 0 {
                let turn =
                    Rotation::from_scaled_axis(if flat { Vec3::z() * 0.7 } else { draw(2.0) });
                add_clump(&mut model, centre, turn, velocity, spin);
            } else {
                add_sphere(&mut model, centre, RADIUS * (1.0 + draw(0.1).x), velocity, spin);
            }
        }
    }
    if mesh {
        add_sheet(
            &mut model,
            5,
            0.08,
            0.0,
            0.1,
            Motion::Translate { velocity: Vec3::new(0.05, 0.02, 0.01) },
        );
        let motion =
            Motion::Rotate { origin: Vec3::new(0.0, 0.0, 0.01), axis: Vec3::y(), rate: 2.0 };
        add_sheet(&mut model, 2, 0.05, -0.002, -0.3, motion);
    } else {
        add_plane(&mut model, Vec3::zeros(), up, Motion::Translate { velocity: Vec3::x() * 0.1 });
    }
    let side = 3.1 * RADIUS;
    add_plane(&mut model, Vec3::x() * side, -Vec3::x(), Motion::Still);
    add_plane(&mut model, -Vec3::x() * side, Vec3::x() + up * 0.2, Motion::Still);
    if !flat {
        add_plane(&mut model, Vec3::y() * side, -Vec3::y(), Motion::Still);
        add_plane(&mut model, -Vec3::y() * side, Vec3::y(), Motion::Still);
    }
    model
}
