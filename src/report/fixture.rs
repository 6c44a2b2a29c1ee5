//! Made-up scenes and runs for the tests of this room.

use crate::geometry::{Ball, Bounds, Mesh};
use crate::model::{
    Body, BodyState, Contact, Cost, Dimension, Frame, Material, Model, Motion, Outcome, Plan, Run,
    Scheme, SeriesRow, Sphere, StepReason, Wall, WallShape,
};
use crate::num::{Rotation, Vec3};

/// A rounded box: a subdivided cube pushed out to a superellipsoid.
pub fn pebble(size: Vec3, rounds: usize) -> Mesh {
    let mut mesh = Mesh {
        vertices: vec![Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()],
        triangles: vec![
            [0, 2, 4],
            [2, 1, 4],
            [1, 3, 4],
            [3, 0, 4],
            [2, 0, 5],
            [1, 2, 5],
            [3, 1, 5],
            [0, 3, 5],
        ],
    };
    for _ in 0..rounds {
        let mut middles = std::collections::BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in mesh.triangles.clone() {
            let mut middle = |p: u32, q: u32| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    let point = mesh.vertices[p as usize] + mesh.vertices[q as usize];
                    mesh.vertices.push(point.normalize());
                    mesh.vertices.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        mesh.triangles = finer;
    }
    mesh.mapped(|v| {
        let norm = v.iter().map(|x| x.abs().powi(4)).sum::<f64>().powf(0.25);
        (v / norm).component_mul(&size)
    })
}

/// `side`³ spheres of radius 5 mm (slightly varied) at rest on a grid in a box
/// with a floor and four walls; neighbours overlap by 1 % of the radius.
pub fn model(side: usize) -> Model {
    let (radius, density) = (0.005, 2500.0);
    let pitch = 2.0 * radius * 0.99;
    let material = Material { name: "stone".into(), density };
    let contact = Contact { kn: 1e5, kt: 2e4, cn: 2.0, ct: 0.0, friction: 0.5 };
    let plan = Plan {
        step: 1e-5,
        reason: StepReason::Auto("a fiftieth of the shortest contact".into()),
        steps: 1000,
        frame_every: 100,
        series_every: 100,
        ..Plan::new(Scheme::Leapfrog)
    };
    let mut model = Model {
        title: "box of spheres".into(),
        seed: 7,
        gravity: Vec3::new(0.0, 0.0, -9.81),
        domain: Bounds { low: Vec3::zeros(), high: Vec3::repeat(pitch * (side + 4) as f64) },
        ..Model::empty(Dimension::Three, material, contact, plan)
    };
    let wide = pitch * side as f64;
    let planes = [
        ("floor", Vec3::zeros(), Vec3::z()),
        ("left", Vec3::zeros(), Vec3::x()),
        ("right", Vec3::repeat(wide), -Vec3::x()),
        ("front", Vec3::zeros(), Vec3::y()),
        ("back", Vec3::repeat(wide), -Vec3::y()),
    ];
    for (name, point, normal) in planes {
        let shape = WallShape::Plane { point, normal };
        model.walls.push(Wall { name: name.into(), shape, motion: Motion::Still, material: 0 });
    }
    for index in 0..side.pow(3) {
        let cell = [index % side, index / side % side, index / side / side];
        let position = Vec3::from_iterator(cell.iter().map(|c| (*c as f64 + 0.5) * pitch));
        let body = Body::sphere(Dimension::Three, position, radius, density, 0, index as u32);
        model.bodies.push(body);
        let offset = Vec3::zeros();
        model.spheres.push(Sphere { offset, radius, body: index as u32 });
    }
    model
}

/// The model at `step` with every body moved by `shift`.
pub fn frame(model: &Model, step: u64, shift: Vec3) -> Frame {
    let bodies: Vec<BodyState> = model
        .initial_states()
        .into_iter()
        .map(|state| BodyState { position: state.position + shift, ..state })
        .collect();
    Frame {
        step,
        time: step as f64 * model.plan.step,
        centres: model.sphere_centres(&bodies),
        velocities: vec![Vec3::zeros(); model.spheres.len()],
        spins: vec![Vec3::zeros(); model.spheres.len()],
        forces: vec![Vec3::zeros(); model.spheres.len()],
        bodies,
    }
}

/// A run of eleven frames; at step n everything is shifted by `shift(n)`.
pub fn run(model: &Model, solver: &str, shift: impl Fn(u64) -> Vec3) -> Run {
    let plan = &model.plan;
    let steps = (0..=plan.steps).step_by(plan.frame_every as usize);
    let count = model.spheres.len() as u64;
    Run {
        solver: solver.into(),
        outcome: Outcome::Finished,
        frames: steps.clone().map(|step| frame(model, step, shift(step))).collect(),
        touches: None,
        breaks: None,
        springs: Vec::new(),
        series: steps
            .map(|step| SeriesRow {
                time: step as f64 * plan.step,
                step,
                kinetic: 1e-3 * (-(step as f64) / 300.0).exp(),
                elastic: 2e-4,
                gravitational: -1e-3 * step as f64 / 1000.0,
                normal_dashpot: 1e-3 * step as f64 / 1000.0,
                energy_error: Some(1e-9 * step as f64),
                contacts: count,
                coordination: 5.0,
                ..SeriesRow::default()
            })
            .collect(),
        cost: Cost {
            cpu_seconds: 2.0,
            wall_seconds: 1.0,
            loop_seconds: Some(0.8),
            steps: plan.steps,
            sphere_steps: plan.steps * count,
            peak_bytes: Some(20_000_000),
        },
        notes: Vec::new(),
    }
}

/// Three balls along x that stand for a pebble.
pub fn clump(name: &str) -> crate::clump::Clump {
    let ball = |x: f64, radius: f64| Ball { centre: Vec3::new(x, 0.0, 0.0), radius };
    crate::clump::Clump {
        name: name.into(),
        method: "three by hand".into(),
        balls: vec![ball(-0.6, 0.55), ball(0.0, 0.65), ball(0.6, 0.55)],
        volume: 2.0,
        inertia: Vec3::new(0.3, 0.5, 0.5),
        centroid: Vec3::zeros(),
        axes: Rotation::identity(),
        fidelity: Some(crate::clump::Fidelity {
            equivalent_diameter: 1.6,
            volume_error: -0.03,
            mean_distance: 0.02,
            rms_distance: 0.03,
            largest_distance: 0.11,
            centroid_error: 0.001,
            inertia_error: 0.04,
        }),
    }
}

/// A solid that the clump stands for.
pub fn solid(name: &str) -> crate::shape::Solid {
    let mesh = pebble(Vec3::new(1.1, 0.6, 0.55), 3);
    let mass = mesh.mass_properties();
    crate::shape::Solid { name: name.into(), mesh, mass, recipe: "superellipsoid".into() }
}
