//! Models, and how they are run in a solver and beside our own DEM.

pub use riprap::clump;
pub use riprap::dem;
pub use riprap::geometry::{Bounds, Cell, Container, Mesh};
pub use riprap::model::extra::{Bridge, Cohesion, PairForces, Rolling};
pub use riprap::model::{
    Body, BodyState, Contact, ContactTable, Dimension, Extra, Lost, Material, Model, Motion,
    Outcome, Plan, Run, Scheme, Sphere, Wall, WallShape,
};
pub use riprap::num::units::{EnergyDensity, Force, Length, SurfaceTension, Volume};
pub use riprap::num::{Job, Mat3, Rotation, Vec3};
pub use riprap::pack::{Grain, Method, contacts_of, pack};
pub use riprap::solver::{self, DeckOptions, LimitKind, Solver};

pub const CONTACT: Contact = Contact { kn: 1e4, kt: 5e3, cn: 0.3, ct: 0.0, friction: 0.4 };

pub fn model(dimension: Dimension, contact: Contact) -> Model {
    let material = Material { name: "stone".into(), density: 2500.0 };
    let plan = Plan {
        step: 1e-6,
        steps: 1000,
        frame_every: 400,
        series_every: 100,
        ..Plan::new(Scheme::Liggghts)
    };
    Model {
        title: "solver test".into(),
        seed: 1,
        domain: Bounds { low: Vec3::repeat(-0.02), high: Vec3::repeat(0.02) },
        ..Model::empty(dimension, material, contact, plan)
    }
}

pub fn add_sphere(model: &mut Model, at: Vec3, velocity: Vec3, spin: Vec3) {
    let body = model.add_sphere(at, 1e-3, 2500.0, 0);
    (body.velocity, body.spin) = (velocity, spin);
}

/// A clump whose mass, centre of mass and inertia are not those of its spheres.
pub fn add_clump(model: &mut Model, at: Vec3, velocity: Vec3, spin: Vec3, inertia: Vec3) {
    let flat = model.dimension == Dimension::Two;
    let mut offsets = vec![
        Vec3::new(1e-3, 0.0, 0.0),
        Vec3::new(-0.6e-3, 0.7e-3, 0.0),
        Vec3::new(-0.5e-3, -0.6e-3, 0.0),
    ];
    if !flat {
        offsets.iter_mut().for_each(|offset| offset.z = -0.2e-3);
        offsets.push(Vec3::new(0.1e-3, 0.0, 0.8e-3));
    }
    let turn = if flat { Vec3::z() * 0.4 } else { Vec3::new(0.3, -0.5, 0.8) };
    let index = model.bodies.len() as u32;
    model.bodies.push(Body {
        position: at,
        orientation: Rotation::from_scaled_axis(turn),
        velocity,
        spin,
        mass: 2e-5,
        inertia,
        first_sphere: model.spheres.len() as u32,
        sphere_count: offsets.len() as u32,
        material: 0,
        family: 0,
        grain: 0,
    });
    let balls = offsets.into_iter().map(|offset| Sphere { offset, radius: 0.9e-3, body: index });
    model.spheres.extend(balls);
}

pub fn add_plane(model: &mut Model, name: &str, point: Vec3, normal: Vec3, motion: Motion) {
    let shape = WallShape::Plane { point, normal: normal.normalize() };
    model.walls.push(Wall { name: name.into(), shape, motion, material: 0 });
}

/// Looks for each solver once.
pub fn installed(solver: &dyn Solver) -> bool {
    static FOUND: std::sync::OnceLock<Vec<&str>> = std::sync::OnceLock::new();
    let there = FOUND
        .get_or_init(|| {
            let found = solver::all().into_iter().filter(|solver| solver.find().is_some());
            found.map(|solver| solver.key()).collect()
        })
        .contains(&solver.key());
    if !there {
        println!("skipped: {} not found", solver.key());
    }
    there
}

/// Writes and runs the deck; `None` where the solver is not installed.
pub fn run(solver: &dyn Solver, model: &Model, options: &DeckOptions) -> Option<Run> {
    if !installed(solver) {
        return None;
    }
    let room = tempfile::tempdir().expect("temporary folder");
    let deck = solver.write(model, &room.path().join(solver.key()), options);
    let deck = deck.unwrap_or_else(|error| panic!("{}: {error}", solver.key()));
    let run = solver.run(model, &deck, &Job::quiet());
    Some(run.unwrap_or_else(|error| panic!("{}: {error}", solver.key())))
}

pub fn finished(solver: &dyn Solver, model: &Model) -> Option<Run> {
    let run = run(solver, model, &DeckOptions::default())?;
    assert_eq!(run.outcome, Outcome::Finished, "{}", solver.key());
    assert_eq!(run.frames[0].step, 0);
    assert_eq!(run.frames.last().map(|frame| frame.step), Some(model.plan.steps));
    Some(run)
}

/// All solvers that can run a model; the largest difference of sphere centres at the end, m.
pub fn worst_difference(model: &Model) -> Option<f64> {
    let able = solver::all().into_iter().filter(|solver| can(*solver, model));
    let runs: Vec<Run> = able.filter_map(|solver| finished(solver, model)).collect();
    let first = runs.first()?.frames.last()?;
    let others = runs[1..].iter().filter_map(|run| run.frames.last());
    let apart = others.flat_map(|other| first.centres.iter().zip(&other.centres));
    apart.map(|(a, b)| (a - b).norm()).reduce(f64::max)
}

/// Whether the solver takes the model.
pub fn can(solver: &dyn Solver, model: &Model) -> bool {
    solver.limits(model).iter().all(|limit| limit.kind != LimitKind::Refused)
}

pub fn last_state(run: &Run) -> BodyState {
    run.frames.last().expect("frames").bodies[0]
}

/// Adds a clump of two spheres whose centre of mass lies off the line of their centres.
pub fn add_pair(model: &mut Model, at: Vec3, velocity: Vec3, spin: Vec3) {
    let flat = model.dimension == Dimension::Two;
    add_clump(model, at, velocity, spin, Vec3::new(0.8e-11, 1.2e-11, 1.3e-11));
    model.spheres.truncate(model.spheres.len() - if flat { 1 } else { 2 });
    let body = model.bodies.last_mut().expect("a clump");
    body.sphere_count = 2;
    let pair = &mut model.spheres[body.first_sphere as usize..];
    let depth = if flat { 0.0 } else { 0.2e-3 };
    pair[0].offset = Vec3::new(-0.9e-3, 0.1e-3, 0.5 * depth);
    pair[1].offset = Vec3::new(0.7e-3, 0.3e-3, -depth);
    pair[1].radius = 0.8e-3;
}

/// A solver against our own run of its scheme: the worst difference of sphere
/// centres, body positions (both in largest radii) and turns (rad) in all frames,
/// and of the spins of clumps (of the largest).
pub fn twin_differences(solver: &dyn Solver, model: &Model) -> Option<[f64; 2]> {
    let theirs = finished(solver, model)?;
    let ours = dem::run(model, &Job::quiet()).expect("a run");
    assert_eq!(ours.outcome, Outcome::Finished, "our own of scheme {}", solver.key());
    assert_eq!(ours.frames.len(), theirs.frames.len());
    let largest = model.largest_radius();
    let [mut place, mut spin] = [0.0_f64; 2];
    for (a, b) in ours.frames.iter().zip(&theirs.frames) {
        for (x, y) in a.centres.iter().zip(&b.centres) {
            place = place.max(model.way(x - y).norm() / largest);
        }
        let fastest = a.bodies.iter().map(|body| body.spin.norm()).fold(1e-300, f64::max);
        for (index, (x, y)) in a.bodies.iter().zip(&b.bodies).enumerate() {
            place = place.max(model.way(x.position - y.position).norm() / largest);
            spin = spin.max((x.spin - y.spin).norm() / fastest);
            if model.bodies[index].sphere_count > 1 {
                place = place.max(x.orientation.angle_to(&y.orientation));
            }
        }
    }
    Some([place, spin])
}

/// Clumps out of balance, a balanced one and a sphere that meet each other and the floor.
pub fn tumbling() -> Model {
    let mut model = model(Dimension::Three, CONTACT);
    model.gravity = Vec3::new(2.0, 0.0, -9.81);
    let spin = Vec3::new(300.0, -150.0, 450.0);
    add_pair(&mut model, Vec3::new(0.0, 0.0, 3.5e-3), Vec3::new(0.1, 0.0, -0.5), spin);
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    add_clump(&mut model, Vec3::new(5e-3, 0.0, 2.5e-3), Vec3::zeros(), spin, inertia);
    add_sphere(&mut model, Vec3::new(0.2e-3, 0.0, 1.0e-3), Vec3::zeros(), Vec3::zeros());
    add_pair(&mut model, Vec3::new(-5e-3, 0.0, 3.5e-3), Vec3::new(0.1, 0.0, -0.5), -spin);
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    model.plan.steps = 6000;
    model
}

pub fn slide(x: f64, y: f64, z: f64) -> Motion {
    Motion::Translate { velocity: Vec3::new(x, y, z) }
}

pub fn turn(axis: Vec3) -> Motion {
    Motion::Rotate { origin: Vec3::new(-3e-3, 1e-3, 0.0), axis, rate: -8.0 }
}

/// Discs and a clump of discs between an axis plane and an oblique one.
pub fn flat_scene(contact: Contact) -> Model {
    // Masses of discs of unit thickness are large: stiffnesses to match.
    let contact = Contact { kn: 1e8, kt: contact.kt * 1e4, cn: 200.0, ..contact };
    let mut model = model(Dimension::Two, contact);
    model.gravity = Vec3::new(0.0, -9.81, 0.0);
    add_sphere(&mut model, Vec3::new(0.0, 1.01e-3, 0.0), Vec3::new(0.2, -0.5, 0.0), Vec3::zeros());
    add_sphere(&mut model, Vec3::new(2.1e-3, 1.5e-3, 0.0), Vec3::zeros(), Vec3::zeros());
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::y(), Motion::Still);
    let slope = Vec3::new(-1.0, 1.0, 0.0);
    add_plane(&mut model, "slope", Vec3::new(4e-3, 0.0, 0.0), slope, Motion::Still);
    model
}
