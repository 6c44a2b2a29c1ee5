//! Decks run in the real solvers and held against closed forms and each other.
//! A solver that is not installed is skipped, and the test says so.

use riprap::clump;
use riprap::dem;
use riprap::geometry::{Bounds, Cell, Container, Mesh};
use riprap::model::extra::{Bridge, Cohesion, PairForces, Rolling};
use riprap::model::{
    Body, BodyState, Contact, ContactTable, Dimension, Extra, Lost, Material, Model, Motion,
    Outcome, Plan, Run, Scheme, Sphere, StepReason, Wall, WallShape,
};
use riprap::num::units::{EnergyDensity, SurfaceTension, Volume};
use riprap::num::{Job, Mat3, Rotation, Vec3};
use riprap::pack::{Grain, Method, contacts_of, pack};
use riprap::solver::{self, DeckOptions, LimitKind, Solver};

const CONTACT: Contact = Contact { kn: 1e4, kt: 5e3, cn: 0.3, ct: 0.0, friction: 0.4 };

fn model(dimension: Dimension, contact: Contact) -> Model {
    Model {
        title: "solver test".into(),
        dimension,
        seed: 1,
        bodies: Vec::new(),
        bonds: Vec::new(),
        spheres: Vec::new(),
        materials: vec![Material { name: "stone".into(), density: 2500.0 }],
        contacts: ContactTable::uniform(1, contact),
        extra: Extra::default(),
        walls: Vec::new(),
        gravity: Vec3::zeros(),
        mutual: None,
        local_damping: 0.0,
        domain: Bounds { low: Vec3::repeat(-0.02), high: Vec3::repeat(0.02) },
        periodic: None,
        plan: Plan {
            step: 1e-6,
            reason: StepReason::Given,
            steps: 1000,
            frame_every: 400,
            series_every: 100,
            checkpoint_every: 0,
            scheme: Scheme::Liggghts,
            law: Scheme::Liggghts.law(),
            zero_every: 0,
            zero_until: 0,
            insist: false,
            guard: Default::default(),
        },
    }
}

fn add_sphere(model: &mut Model, at: Vec3, velocity: Vec3, spin: Vec3) {
    let (index, first) = (model.bodies.len() as u32, model.spheres.len() as u32);
    let mut body = Body::sphere(model.dimension, at, 1e-3, 2500.0, 0, first);
    (body.velocity, body.spin) = (velocity, spin);
    model.bodies.push(body);
    model.spheres.push(Sphere { offset: Vec3::zeros(), radius: 1e-3, body: index });
}

/// A clump whose mass, centre of mass and inertia are not those of its spheres.
fn add_clump(model: &mut Model, at: Vec3, velocity: Vec3, spin: Vec3, inertia: Vec3) {
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

fn add_plane(model: &mut Model, name: &str, point: Vec3, normal: Vec3, motion: Motion) {
    let shape = WallShape::Plane { point, normal: normal.normalize() };
    model.walls.push(Wall { name: name.into(), shape, motion, material: 0 });
}

/// Looks for each solver once.
fn installed(solver: &dyn Solver) -> bool {
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
fn run(solver: &dyn Solver, model: &Model, options: &DeckOptions) -> Option<Run> {
    if !installed(solver) {
        return None;
    }
    let room = tempfile::tempdir().expect("temporary folder");
    let deck = solver.write(model, &room.path().join(solver.key()), options);
    let deck = deck.unwrap_or_else(|error| panic!("{}: {error}", solver.key()));
    let run = solver.run(model, &deck, &Job::quiet());
    Some(run.unwrap_or_else(|error| panic!("{}: {error}", solver.key())))
}

fn finished(solver: &dyn Solver, model: &Model) -> Option<Run> {
    let run = run(solver, model, &DeckOptions::default())?;
    assert_eq!(run.outcome, Outcome::Finished, "{}", solver.key());
    assert_eq!(run.frames[0].step, 0);
    assert_eq!(run.frames.last().map(|frame| frame.step), Some(model.plan.steps));
    Some(run)
}

/// All solvers that can run a model; the largest difference of sphere centres at the end, m.
fn worst_difference(model: &Model) -> Option<f64> {
    let able = solver::all().into_iter().filter(|solver| can(*solver, model));
    let runs: Vec<Run> = able.filter_map(|solver| finished(solver, model)).collect();
    let first = runs.first()?.frames.last()?;
    let others = runs[1..].iter().filter_map(|run| run.frames.last());
    let apart = others.flat_map(|other| first.centres.iter().zip(&other.centres));
    apart.map(|(a, b)| (a - b).norm()).reduce(f64::max)
}

/// Whether the solver takes the model.
fn can(solver: &dyn Solver, model: &Model) -> bool {
    solver.limits(model).iter().all(|limit| limit.kind != LimitKind::Refused)
}

fn last_state(run: &Run) -> BodyState {
    run.frames.last().expect("frames").bodies[0]
}

/// Restitution of a linear spring-dashpot contact that may not pull
/// (Schwager & Pöschel 2007, Granular Matter 9, 465, eq. 21).
#[test]
fn one_bounce_has_the_closed_form_restitution() {
    let mut model = model(Dimension::Three, Contact { kt: 0.0, friction: 0.0, ..CONTACT });
    let start = Vec3::new(0.0, 0.0, 1.01e-3);
    add_sphere(&mut model, start, Vec3::new(0.0, 0.0, -0.1), Vec3::zeros());
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    (model.plan.step, model.plan.steps) = (1e-7, 4000);
    let mass = model.bodies[0].mass;
    let decay = CONTACT.cn / (2.0 * mass);
    let rate = (CONTACT.kn / mass - decay * decay).sqrt();
    let angle = std::f64::consts::PI - (2.0 * decay * rate).atan2(rate * rate - decay * decay);
    let expected = (-decay / rate * angle).exp();
    for solver in solver::all() {
        let Some(run) = finished(solver, &model) else { continue };
        let got = last_state(&run).velocity.z / 0.1;
        let error = (got - expected).abs() / expected;
        assert!(error < 3e-3, "{}: {got} for {expected}", solver.key());
        assert!(run.cost.cpu_seconds > 0.0 && run.cost.loop_seconds.is_some(), "{:?}", run.cost);
    }
}

/// A symmetric top in free fall: the centre of mass follows the parabola, and
/// the angular velocity circles about the angular momentum at |L| / I₁ (Euler).
#[test]
fn a_spinning_clump_in_free_fall_follows_the_closed_forms() {
    let mut model = model(Dimension::Three, CONTACT);
    model.gravity = Vec3::new(0.5, 0.0, -9.81);
    let (inertia, spin) = (Vec3::new(1.2e-11, 1.2e-11, 1.9e-11), Vec3::new(300.0, -150.0, 450.0));
    let velocity = Vec3::new(0.1, 0.2, 0.3);
    add_clump(&mut model, Vec3::new(1e-3, 0.0, 2e-3), velocity, spin, inertia);
    model.plan.steps = 4000;
    let start = model.bodies[0].clone();
    let axes = start.orientation.to_rotation_matrix();
    let tensor = axes.matrix() * Mat3::from_diagonal(&inertia) * axes.matrix().transpose();
    let momentum = tensor * spin;
    let time = model.plan.duration();
    let circle = Rotation::from_scaled_axis(momentum / inertia.x * time);
    // YADE turns clumps to first order in the step, so its error is the step times the rate.
    for (solver, tolerance) in solver::all().into_iter().zip([1e-6, 5e-3, 1e-6]) {
        let Some(run) = finished(solver, &model) else { continue };
        let state = last_state(&run);
        let place = start.position + velocity * time + model.gravity * (0.5 * time * time);
        assert!((state.position - place).norm() < 1e-15, "{}: place", solver.key());
        let error = (state.spin - circle * spin).norm() / spin.norm();
        assert!(error < tolerance, "{}: spin off by {error:e}", solver.key());
        let turned = state.orientation.to_rotation_matrix();
        let tensor = turned.matrix() * Mat3::from_diagonal(&inertia) * turned.matrix().transpose();
        let error = (tensor * state.spin - momentum).norm() / momentum.norm();
        assert!(error < tolerance, "{}: angular momentum off by {error:e}", solver.key());
    }
}

/// What the solvers make of the mass properties that the deck gives them.
#[test]
fn clumps_weigh_what_the_model_says() {
    let mut model = model(Dimension::Three, CONTACT);
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    let spin = Vec3::new(300.0, -150.0, 450.0);
    add_clump(&mut model, Vec3::new(1e-3, 0.0, 2e-3), Vec3::new(1.0, 2.0, 3.0), spin, inertia);
    model.plan.steps = 10;
    let [liggghts, yade, _] = solver::all();
    if let Some(run) = finished(liggghts, &model) {
        // At step 0 forces are weights, and the spin is what fix rigid makes of L and I.
        let frame = &run.frames[0];
        let weight: Vec3 = frame.forces.iter().sum();
        assert!((weight - model.gravity * 2e-5).norm() < 1e-13 * 2e-4);
        let torque: Vec3 = frame
            .centres
            .iter()
            .zip(&frame.forces)
            .map(|(centre, force)| (centre - model.bodies[0].position).cross(force))
            .sum();
        assert!(torque.norm() < 1e-13 * 2e-4 * 1e-3, "{torque:?}");
        assert!((frame.bodies[0].spin - spin).norm() < 1e-11 * spin.norm());
        assert!((frame.bodies[0].velocity - model.bodies[0].velocity).norm() < 1e-12);
    }
    if !installed(yade) {
        return;
    }
    let room = tempfile::tempdir().expect("temporary folder");
    let folder = room.path().join("yade");
    yade.write(&model, &folder, &DeckOptions::default()).expect("written");
    let script = folder.join("run.py");
    let text = std::fs::read_to_string(&script).expect("there");
    let said =
        "s = O.bodies[clumps[0]].state\nprint('says', digits((s.mass,), s.inertia, s.pos))\n";
    std::fs::write(&script, text.replace("\nsteps = ", &format!("\n{said}steps = ")))
        .expect("written");
    let output = std::process::Command::new("sh").arg(folder.join("run.sh")).output().expect("sh");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = text.lines().find_map(|line| line.strip_prefix("says ")).expect("the line");
    let numbers: Vec<f64> = line.split(' ').map(|word| word.parse().expect("a number")).collect();
    let position = model.bodies[0].position;
    let expected = [2e-5, inertia.x, inertia.y, inertia.z, position.x, position.y, position.z];
    for (got, expected) in numbers.iter().zip(expected) {
        assert!((got - expected).abs() <= 1e-14 * expected.abs(), "{numbers:?}");
    }
}

/// The centre of mass lies outside the hull of the sphere centres: no masses of
/// the spheres balance, yet velocity and spin must start right.
#[test]
fn clumps_out_of_balance_start_right_and_fly_straight() {
    let mut model = model(Dimension::Three, CONTACT);
    let (velocity, spin) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(300.0, -150.0, 450.0));
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    add_clump(&mut model, Vec3::zeros(), velocity, spin, inertia);
    model.spheres.iter_mut().for_each(|sphere| sphere.offset.x += 3e-3);
    let liggghts = solver::all()[0];
    let Some(run) = finished(liggghts, &model) else { return };
    let start = run.frames[0].bodies[0];
    assert!((start.spin - spin).norm() < 1e-10 * spin.norm(), "{start:?}");
    assert!((start.velocity - velocity).norm() < 1e-12, "{start:?}");
    let end = last_state(&run);
    assert!((end.position - velocity * model.plan.duration()).norm() < 1e-14, "{end:?}");
}

/// Adds a clump of two spheres whose centre of mass lies off the line of their centres.
fn add_pair(model: &mut Model, at: Vec3, velocity: Vec3, spin: Vec3) {
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
fn twin_differences(solver: &dyn Solver, model: &Model) -> Option<[f64; 2]> {
    let theirs = finished(solver, model)?;
    let ours = dem::run(model, &Job::quiet()).expect("a run");
    assert_eq!(ours.frames.len(), theirs.frames.len());
    let largest = model.spheres.iter().map(|s| s.radius).fold(0.0, f64::max);
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
fn tumbling() -> Model {
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

/// Gravity must act at the centre of mass even where no masses of the spheres
/// balance about it.
#[test]
fn clumps_out_of_balance_fall_and_bounce_like_our_own() {
    let liggghts = solver::all()[0];
    if let Some(worst) = twin_differences(liggghts, &tumbling()) {
        assert!(worst.iter().all(|worst| *worst < 1e-10), "{worst:?}");
    }
    let mut flat = model(Dimension::Two, CONTACT);
    flat.gravity = Vec3::new(0.0, -9.81, 0.0);
    let spin = Vec3::z() * 300.0;
    add_pair(&mut flat, Vec3::new(0.0, 2.5e-3, 0.0), Vec3::new(0.1, -0.5, 0.0), spin);
    add_plane(&mut flat, "floor", Vec3::zeros(), Vec3::y(), Motion::Still);
    flat.plan.steps = 4000;
    if let Some(worst) = twin_differences(liggghts, &flat) {
        assert!(worst.iter().all(|worst| *worst < 1e-10), "in two dimensions: {worst:?}");
    }
}

/// YADE's clumps have our axes, so that even their spins are ours to rounding.
#[test]
fn clumps_tumble_in_yade_like_our_own() {
    let mut model = tumbling();
    // YADE may turn the axes of equal moments as it likes, and of falling ones it must.
    model.bodies[1].inertia = Vec3::new(1.4e-11, 1.1e-11, 1.1e-11);
    model.plan.scheme = Scheme::Yade;
    model.plan.law = Scheme::Yade.law();
    if let Some(worst) = twin_differences(solver::all()[1], &model) {
        assert!(worst.iter().all(|worst| *worst < 1e-10), "{worst:?}");
    }
}

/// LAMMPS against our own run of its scheme and of the law of `granular`.
fn lammps_differs(model: &Model) -> Option<f64> {
    let lammps = solver::all()[2];
    let mut model = model.clone();
    (model.plan.scheme, model.plan.law) = lammps.scheme(false);
    twin_differences(lammps, &model).map(|[place, spin]| place.max(spin))
}

#[test]
fn pairs_in_lammps_are_our_own() {
    let mut model = model(Dimension::Three, Contact { ct: 0.1, ..CONTACT });
    let spin = Vec3::new(200.0, -150.0, 300.0);
    add_sphere(&mut model, Vec3::zeros(), Vec3::new(0.5, 0.1, 0.0), spin);
    add_sphere(&mut model, Vec3::new(1.9e-3, 0.7e-3, 0.3e-3), Vec3::zeros(), -spin);
    model.spheres[1].radius = 0.7e-3;
    let body = &mut model.bodies[1];
    *body = Body::sphere(Dimension::Three, body.position, 0.7e-3, 2500.0, 0, 1);
    (body.velocity, body.spin) = (Vec3::new(-0.4, 0.0, 0.1), -spin);
    if let Some(worst) = lammps_differs(&model) {
        assert!(worst < 1e-10, "{worst:e}");
    }
}

#[test]
fn beds_in_lammps_are_our_own() {
    let mut model = model(Dimension::Three, Contact { ct: 0.1, ..CONTACT });
    model.gravity = Vec3::new(1.0, 0.0, -9.81);
    for i in 0..27_u32 {
        let [x, y, z] = [i % 3, i / 3 % 3, i / 9].map(f64::from);
        let at = Vec3::new(x + 0.07 * z, y - 0.05 * z, z + 0.52) * 2.02e-3;
        let spin = Vec3::new(20.0 * x, -30.0 * y, 10.0);
        add_sphere(&mut model, at, Vec3::new(0.05 * y, 0.0, -0.2), spin);
    }
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    add_plane(&mut model, "side", Vec3::new(5.5e-3, 0.0, 0.0), -Vec3::x(), Motion::Still);
    add_plane(&mut model, "belt", Vec3::new(-1.05e-3, 0.0, 0.0), Vec3::x(), slide(0.0, 0.1, 0.0));
    model.plan.steps = 2000;
    if let Some(worst) = lammps_differs(&model) {
        assert!(worst < 1e-10, "{worst:e}");
    }
}

#[test]
fn clumps_in_lammps_are_our_own() {
    // Two spheres do not tell how their clump has turned about their line.
    let mut model = tumbling();
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    let spin = Vec3::new(300.0, -150.0, 450.0);
    model.bodies.clear();
    model.spheres.clear();
    for x in [0.0, 3.5e-3] {
        let at = Vec3::new(x, 0.2 * x, 3e-3 + 0.3 * x);
        add_clump(&mut model, at, Vec3::new(0.1 - 100.0 * x, 0.0, -0.5), spin, inertia);
    }
    add_sphere(&mut model, Vec3::new(0.2e-3, 0.0, 1.0e-3), Vec3::zeros(), Vec3::zeros());
    if let Some(worst) = lammps_differs(&model) {
        assert!(worst < 1e-10, "{worst:e}");
    }
    let mut flat = flat_scene(Contact { kt: 0.0, friction: 0.0, ..CONTACT });
    let at = Vec3::new(-6e-3, 2.05e-3, 0.0);
    let inertia = Vec3::new(3e-9, 5e-9, 8e-9);
    add_clump(&mut flat, at, Vec3::new(0.1, -0.5, 0.0), Vec3::z() * 30.0, inertia);
    flat.bodies[2].mass = 0.02;
    if let Some(worst) = lammps_differs(&flat) {
        assert!(worst < 1e-10, "in two dimensions: {worst:e}");
    }
}

#[test]
fn pistons_and_discs_in_lammps_are_our_own() {
    let close = |what: &str, model: &Model| {
        if let Some(worst) = lammps_differs(model) {
            assert!(worst < 1e-10, "{what}: {worst:e}");
        }
    };
    let piston = |contact: Contact, normal: Vec3| {
        let (mut model, normal) = (model(Dimension::Three, contact), normal.normalize());
        add_sphere(&mut model, normal * 1.01e-3, normal * -0.2, Vec3::new(0.0, 20.0, 0.0));
        add_plane(&mut model, "piston", Vec3::zeros(), normal, slide(0.1, 0.0, 0.3));
        model
    };
    let smooth = Contact { kt: 0.0, friction: 0.0, ..CONTACT };
    let mut model = piston(CONTACT, Vec3::z());
    close("piston", &model);
    close("oblique piston", &piston(smooth, Vec3::new(0.3, 0.1, 1.0)));
    model.extra.drag = 1e-4;
    close("drag", &model);
    close("discs without friction", &flat_scene(smooth));
    let mut flat = flat_scene(CONTACT);
    flat.walls.truncate(1);
    close("discs", &flat);
}

/// A sphere on a table of triangles that turns, far from the axis.
#[test]
fn turning_facets_agree_with_our_own() {
    for (solver, scheme) in solver::all().into_iter().zip([Scheme::Liggghts, Scheme::Yade]) {
        let mut model = model(Dimension::Three, CONTACT);
        let corner = |x: f64, y: f64| Vec3::new(x * 15e-3, y * 15e-3, 0.0);
        let mesh = Mesh {
            vertices: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)],
            triangles: vec![[0, 1, 2]],
        };
        let axis = Vec3::new(0.1, 0.0, 1.0).normalize();
        let motion = Motion::Rotate { origin: Vec3::new(-6e-3, 0.0, 0.0), axis, rate: -40.0 };
        let shape = WallShape::Mesh { mesh };
        model.walls.push(Wall { name: "table".into(), shape, motion, material: 0 });
        let down = Vec3::new(0.0, 0.0, -0.2);
        add_sphere(&mut model, Vec3::new(0.0, -2e-3, 1.01e-3), down, Vec3::zeros());
        (model.plan.scheme, model.plan.law) = (scheme, scheme.law());
        model.gravity = Vec3::new(0.0, 0.0, -300.0);
        model.plan.steps = 3000;
        let Some(worst) = twin_differences(solver, &model) else { continue };
        assert!(worst.iter().all(|worst| *worst < 1e-10), "{}: {worst:?}", solver.key());
    }
}

#[test]
fn contacts_come_back_with_their_forces() {
    let mut model = model(Dimension::Three, Contact { cn: 0.0, ..CONTACT });
    for x in [0.0, 1.99e-3, 3.97e-3, 9e-3] {
        add_sphere(&mut model, Vec3::new(x, 0.0, 0.0), Vec3::zeros(), Vec3::zeros());
    }
    (model.plan.step, model.plan.steps) = (1e-12, 1);
    for solver in solver::all() {
        let Some(run) = finished(solver, &model) else { continue };
        let touches = run.touches.expect("contacts are read");
        let pairs: Vec<_> = touches.iter().map(|t| (t.first, t.second)).collect();
        assert_eq!(pairs, [(0, 1), (1, 2)], "{}", solver.key());
        for (touch, overlap) in touches.iter().zip([1e-5, 2e-5]) {
            assert!((touch.normal - 1e4 * overlap).abs() < 1e-8, "{}: {touch:?}", solver.key());
            assert!(touch.tangential < 1e-9);
        }
        let force = run.frames.last().expect("frames").forces[0];
        assert!((force.x + 0.1).abs() < 1e-8, "{}: {force:?}", solver.key());
    }
}

#[test]
fn without_friction_the_solvers_agree_to_rounding() {
    let mut model = model(Dimension::Three, Contact { kt: 0.0, friction: 0.0, ..CONTACT });
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    let still = Vec3::zeros();
    add_sphere(&mut model, Vec3::new(0.0, 0.0, 1.1e-3), still, still);
    add_sphere(&mut model, Vec3::new(0.3e-3, 0.0, 3.2e-3), Vec3::new(0.0, 0.0, -0.5), still);
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    model.plan.steps = 3000;
    if let Some(worst) = worst_difference(&model) {
        assert!(worst < 1e-15, "{worst:e} m");
    }
}

/// A sphere that meets a plane which a solver has to take in another form.
fn wall_agrees(name: &str, normal: Vec3, motion: Motion) {
    let mut model = model(Dimension::Three, CONTACT);
    let normal = normal.normalize();
    add_sphere(&mut model, normal * 1.01e-3, normal * -0.2, Vec3::new(0.0, 20.0, 0.0));
    add_plane(&mut model, name, Vec3::zeros(), normal, motion);
    model.plan.steps = 500;
    let Some(worst) = worst_difference(&model) else { return };
    // What is left is the lever arm at planes and how the spring turns: 0.3 % of
    // the tangential motion, some 0.02 m/s over 0.4 ms.
    assert!(worst < 5e-8, "{name}: {worst:e} m");
}

fn slide(x: f64, y: f64, z: f64) -> Motion {
    Motion::Translate { velocity: Vec3::new(x, y, z) }
}

fn turn(axis: Vec3) -> Motion {
    Motion::Rotate { origin: Vec3::new(-3e-3, 1e-3, 0.0), axis, rate: -8.0 }
}

#[test]
fn oblique_planes_agree() {
    wall_agrees("slope", Vec3::new(0.3, 0.1, 1.0), Motion::Still);
}

#[test]
fn sliding_planes_agree() {
    wall_agrees("belt", Vec3::z(), slide(0.2, 0.0, 0.0));
    wall_agrees("belt_two_ways", Vec3::z(), slide(0.2, 0.1, 0.0));
}

#[test]
fn pistons_agree() {
    wall_agrees("piston", Vec3::z(), slide(0.0, 0.0, 0.3));
}

#[test]
fn oblique_pistons_agree() {
    wall_agrees("oblique_piston", Vec3::new(0.3, 0.1, 1.0), slide(0.1, 0.0, 0.3));
}

#[test]
fn turning_planes_agree() {
    wall_agrees("table", Vec3::z(), turn(Vec3::z()));
}

#[test]
fn paddles_agree() {
    wall_agrees("paddle", Vec3::z(), turn(Vec3::y()));
}

/// Discs and a clump of discs between an axis plane and an oblique one.
fn flat_scene(contact: Contact) -> Model {
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

#[test]
fn discs_agree() {
    if let Some(worst) = worst_difference(&flat_scene(CONTACT)) {
        assert!(worst < 5e-7, "{worst:e} m");
    }
    let smooth = Contact { kt: 0.0, friction: 0.0, ..CONTACT };
    if let Some(worst) = worst_difference(&flat_scene(smooth)) {
        assert!(worst < 1e-14, "without friction: {worst:e} m");
    }
}

#[test]
fn clumps_of_discs_agree() {
    let mut model = flat_scene(Contact { kt: 0.0, friction: 0.0, ..CONTACT });
    let inertia = Vec3::new(3e-9, 5e-9, 8e-9);
    let at = Vec3::new(-6e-3, 2.05e-3, 0.0);
    add_clump(&mut model, at, Vec3::new(0.1, -0.5, 0.0), Vec3::z() * 30.0, inertia);
    model.bodies[2].mass = 0.02;
    if let Some(worst) = worst_difference(&model) {
        assert!(worst < 1e-11, "{worst:e} m");
    }
}

/// Two spheres that meet on a floor of another, softer material without dashpot.
fn rubber_floor(contact: Contact) -> Model {
    let mut model = model(Dimension::Three, contact);
    model.materials.push(Material { name: "rubber".into(), density: 1000.0 });
    model.contacts = ContactTable::uniform(2, contact);
    let soft = Contact {
        kn: 2e3,
        kt: 0.2 * contact.kt,
        cn: 0.0,
        ct: 0.0,
        friction: 2.0 * contact.friction,
    };
    model.contacts.set(0, 1, soft);
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    for x in [0.0, 2.05e-3] {
        let at = Vec3::new(x, 0.0, 1.01e-3);
        add_sphere(&mut model, at, Vec3::new(0.1 - 50.0 * x, 0.0, -0.2), Vec3::zeros());
    }
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    model.walls[0].material = 1;
    model
}

#[test]
fn walls_of_another_material_agree() {
    let smooth = Contact { kt: 0.0, friction: 0.0, ..CONTACT };
    if let Some(worst) = worst_difference(&rubber_floor(smooth)) {
        assert!(worst < 1e-14, "without friction: {worst:e} m");
    }
    // The lever arms differ by 0.7 % here (overlap 14 um), of 0.1 m/s over 1 ms.
    if let Some(worst) = worst_difference(&rubber_floor(CONTACT)) {
        assert!(worst < 7e-7, "{worst:e} m");
    }
}

/// A fan of triangles so sharp that LIGGGHTS refuses it with its own settings.
#[test]
fn needle_triangles_do_not_stop_liggghts() {
    let mut model = model(Dimension::Three, CONTACT);
    let corner = |x: f64, y: f64| Vec3::new(x * 5e-3, y * 5e-3, 0.0);
    let mesh = Mesh {
        vertices: vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
            corner(1.0, 0.994),
        ],
        triangles: vec![[0, 1, 4], [0, 4, 2], [0, 2, 3]],
    };
    add_sphere(
        &mut model,
        Vec3::new(2e-3, -2e-3, 1.01e-3),
        Vec3::new(0.0, 0.0, -0.2),
        Vec3::zeros(),
    );
    let shape = WallShape::Mesh { mesh };
    model.walls.push(Wall { name: "plate".into(), shape, motion: Motion::Still, material: 0 });
    let liggghts = solver::all()[0];
    let limits = liggghts.limits(&model);
    assert!(limits.iter().any(|l| l.kind == LimitKind::Differs && l.what.contains("curvature")));
    let Some(run) = finished(liggghts, &model) else { return };
    assert!(last_state(&run).velocity.z > 0.0);
}

#[test]
fn lost_spheres_are_an_outcome() {
    let mut model = model(Dimension::Three, CONTACT);
    let out = Vec3::new(0.0, 0.0, 100.0);
    add_sphere(&mut model, Vec3::zeros(), out, Vec3::zeros());
    let [liggghts, yade, _] = solver::all();
    if let Some(run) = run(liggghts, &model, &DeckOptions::default()) {
        let Outcome::Failed { reason } = &run.outcome else { panic!("{:?}", run.outcome) };
        assert!(reason.contains("Lost atoms") || reason.contains("lost"), "{reason}");
    }
    if let Some(run) = run(yade, &model, &DeckOptions::default()) {
        assert!(
            run.notes.iter().any(|note| note.contains("outside the domain")),
            "{:?}",
            run.notes
        );
    }
}

#[test]
fn cancelled_runs_stop() {
    use std::sync::{Arc, atomic::AtomicBool};
    let mut model = model(Dimension::Three, CONTACT);
    add_sphere(&mut model, Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
    model.plan.steps = 1_000_000_000;
    for solver in solver::all() {
        if !installed(solver) {
            continue;
        }
        let room = tempfile::tempdir().expect("temporary folder");
        let deck = solver.write(&model, &room.path().join("deck"), &DeckOptions::default());
        let silent = Arc::new(riprap::num::job::Silent);
        let job = Job::new(1, silent, Arc::new(AtomicBool::new(true)));
        let run = solver.run(&model, &deck.expect("written"), &job).expect("an outcome");
        assert!(matches!(run.outcome, Outcome::Cancelled { .. }), "{:?}", run.outcome);
    }
}

/// Two MPI ranks give what one gives.
#[test]
fn ranks_do_not_change_the_answer() {
    if std::process::Command::new("mpirun").arg("--version").output().is_err() {
        println!("skipped: mpirun not found");
        return;
    }
    let mut model = model(Dimension::Three, CONTACT);
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    for x in [-4e-3, 4e-3] {
        add_clump(
            &mut model,
            Vec3::new(x, 0.0, 2.2e-3),
            Vec3::new(-100.0 * x, 0.0, -0.5),
            Vec3::x() * 50.0,
            inertia,
        );
    }
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    model.plan.steps = 2000;
    for solver in solver::all().into_iter().filter(|solver| solver.takes_ranks()) {
        let Some(one) = finished(solver, &model) else { continue };
        let options = DeckOptions { ranks: 2, processors: Some([2, 1, 1]), queue_script: true };
        let two = run(solver, &model, &options).expect("found before");
        assert_eq!(two.outcome, Outcome::Finished);
        let (one, two) = (one.frames.last().expect("frames"), two.frames.last().expect("frames"));
        for (a, b) in one.centres.iter().zip(&two.centres) {
            assert!((a - b).norm() < 1e-14, "{}: {a:?} {b:?}", solver.key());
        }
    }
}

/// Two spheres and a clump that spin and meet each other and a floor, with forces besides the
/// linear contact.
fn clinging(forces: PairForces, drag: f64) -> Model {
    let mut model = model(Dimension::Three, Contact { ct: 0.1, ..CONTACT });
    model.extra = Extra::uniform(1, forces);
    model.extra.drag = drag;
    model.gravity = Vec3::new(1.0, 0.0, -9.81);
    let spin = Vec3::new(200.0, -150.0, 300.0);
    add_sphere(&mut model, Vec3::new(0.0, 0.0, 1.02e-3), Vec3::new(0.1, 0.0, -0.2), spin);
    add_sphere(&mut model, Vec3::new(1.2e-3, 0.3e-3, 2.8e-3), Vec3::new(0.0, 0.1, -0.4), -spin);
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    add_clump(&mut model, Vec3::new(6e-3, 0.0, 2.4e-3), Vec3::new(-0.3, 0.0, -0.3), spin, inertia);
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    model.plan.steps = 4000;
    model
}

/// Cohesion, resistance to rolling and drag as LIGGGHTS computes them, to rounding.
#[test]
fn cohesion_rolling_and_drag_agree_with_liggghts() {
    let liggghts = solver::all()[0];
    let energy_density = EnergyDensity(3e4);
    let cases = [
        (Some(Cohesion::Sjkr { energy_density }), Some(Rolling::Cdt { coefficient: 0.2 }), 0.0),
        (Some(Cohesion::Sjkr2 { energy_density }), Some(Rolling::Epsd2 { coefficient: 0.2 }), 0.0),
        (None, Some(Rolling::Epsd { coefficient: 0.3, damping: 0.0 }), 1e-3),
    ];
    for (cohesion, rolling, drag) in cases {
        let forces = PairForces { cohesion, rolling, ..PairForces::default() };
        let mut model = clinging(forces, drag);
        if drag > 0.0 {
            // LIGGGHTS' set-up pass does not know the spins of clumps yet.
            model.bodies[2].spin = Vec3::zeros();
        }
        if let Some(worst) = twin_differences(liggghts, &model) {
            assert!(worst.iter().all(|worst| *worst < 1e-9), "{forces:?} {drag}: {worst:?}");
        }
    }
    // The damped rolling spring, without the clump.
    let law = Rolling::Epsd { coefficient: 0.3, damping: 0.4 };
    let mut model = clinging(PairForces { rolling: Some(law), ..PairForces::default() }, 0.0);
    model.spheres.truncate(2);
    model.bodies.truncate(2);
    if let Some(worst) = twin_differences(liggghts, &model) {
        assert!(worst.iter().all(|worst| *worst < 1e-9), "{worst:?}");
    }
}

/// What the decks cannot say is refused, not dropped.
#[test]
fn forces_that_decks_cannot_say_are_refused() {
    let bridge = Bridge {
        surface_tension: SurfaceTension(0.07),
        volume: Volume(1e-13),
        angle: Default::default(),
    };
    let model = clinging(PairForces { bridge: Some(bridge), ..PairForces::default() }, 0.0);
    for solver in solver::all() {
        let limits = solver.limits(&model);
        let refused = |limit: &solver::Limit| {
            limit.kind == LimitKind::Refused && limit.what.contains("liquid bridges")
        };
        assert!(limits.iter().any(refused), "{}", solver.key());
    }
}

/// Spheres in a small box that meet across its sides; in LIGGGHTS on a floor, in YADE in a box
/// that repeats itself along all axes.
fn across_sides(scheme: Scheme) -> Model {
    let mut model = model(Dimension::Three, CONTACT);
    let bounds = Bounds { low: Vec3::zeros(), high: Vec3::new(5e-3, 5.5e-3, 6e-3) };
    let all = scheme == Scheme::Yade;
    model.periodic = Some(Cell { bounds, periodic: [true, true, all] });
    model.domain = bounds;
    (model.plan.scheme, model.plan.law) = (scheme, scheme.law());
    if !all {
        model.gravity = Vec3::new(3.0, 0.0, -9.81);
        add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    }
    let spin = Vec3::new(100.0, -200.0, 50.0);
    let spheres = [
        ([0.9, 1.0, 1.3], [-0.5, 0.0, -0.1]),
        ([3.5, 1.2, 1.5], [0.3, 0.1, 0.0]),
        ([2.2, 4.4, 3.6], [0.2, 0.9, -0.6]),
        ([4.6, 3.2, 1.2], [0.4, 0.3, 0.2]),
    ];
    for (place, velocity) in spheres {
        add_sphere(&mut model, Vec3::from(place) * 1e-3, Vec3::from(velocity), spin);
    }
    model.plan.steps = 5000;
    model
}

#[test]
fn pairs_that_meet_across_a_periodic_side_agree() {
    for (solver, scheme) in solver::all().into_iter().zip([Scheme::Liggghts, Scheme::Yade]) {
        let model = across_sides(scheme);
        let mut open = model.clone();
        (open.periodic, open.domain) =
            (None, Bounds { low: Vec3::repeat(-0.1), high: Vec3::repeat(0.1) });
        let end = |model: &Model| {
            let run = dem::run(model, &Job::quiet()).expect("a run");
            run.frames.last().expect("frames").bodies[0].velocity
        };
        assert!((end(&model) - end(&open)).norm() > 0.1, "they meet across the side");
        let Some(worst) = twin_differences(solver, &model) else { continue };
        assert!(worst.iter().all(|worst| *worst < 1e-9), "{}: {worst:?}", solver.key());
    }
}

/// LIGGGHTS keeps clumps whole across a side.
#[test]
fn clumps_cross_a_periodic_side_in_liggghts_like_our_own() {
    let mut model = across_sides(Scheme::Liggghts);
    model.bodies.clear();
    model.spheres.clear();
    let cell = model.periodic.as_mut().expect("periodic");
    cell.bounds.high = Vec3::new(10e-3, 9e-3, 9e-3);
    model.domain = cell.bounds;
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    let spin = Vec3::new(100.0, -200.0, 150.0);
    add_clump(&mut model, Vec3::new(1.5e-3, 4e-3, 3e-3), Vec3::new(-0.6, 0.0, -0.4), spin, inertia);
    add_sphere(&mut model, Vec3::new(7.5e-3, 4.3e-3, 1.5e-3), Vec3::new(0.3, 0.0, 0.0), -spin);
    if let Some(worst) = twin_differences(solver::all()[0], &model) {
        assert!(worst.iter().all(|worst| *worst < 1e-9), "{worst:?}");
    }
}

/// One large triangle that stands for a plane.
fn sheet(height: f64) -> WallShape {
    let corner = |x: f64, y: f64| Vec3::new(x * 18e-3, y * 18e-3, height);
    let vertices = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)];
    WallShape::Mesh { mesh: Mesh { vertices, triangles: vec![[0, 1, 2]] } }
}

#[test]
fn walls_that_oscillate_agree_with_our_own() {
    for (solver, scheme) in solver::all().into_iter().zip([Scheme::Liggghts, Scheme::Yade]) {
        for mesh in [false, true] {
            let mut model = model(Dimension::Three, CONTACT);
            let motion = Motion::Oscillate {
                amplitude: Vec3::new(0.3e-3, 0.1e-3, 0.2e-3),
                frequency: 180.0,
                // LIGGGHTS starts at 0.
                phase: if scheme == Scheme::Yade { 0.7 } else { 0.0 },
            };
            add_plane(&mut model, "shaker", Vec3::zeros(), Vec3::z(), motion);
            if mesh {
                model.walls[0].shape = sheet(0.0);
            }
            let down = Vec3::new(0.05, 0.0, -0.2);
            add_sphere(&mut model, Vec3::new(0.0, -1e-3, 1.01e-3), down, Vec3::y() * 40.0);
            (model.plan.scheme, model.plan.law) = (scheme, scheme.law());
            model.gravity = Vec3::new(0.0, 0.0, -80.0);
            model.plan.steps = 6000;
            let Some(worst) = twin_differences(solver, &model) else { continue };
            let both = (solver.key(), mesh);
            assert!(worst.iter().all(|worst| *worst < 1e-10), "{both:?}: {worst:?}");
        }
    }
}

#[test]
fn a_servo_lid_on_a_heap_agrees_with_our_own() {
    let [liggghts, yade, _] = solver::all();
    for mesh in [false, true] {
        let mut model = model(Dimension::Three, CONTACT);
        (model.plan.scheme, model.plan.law) = (Scheme::Yade, Scheme::Yade.law());
        let still = Vec3::zeros();
        for angle in [0.1_f64, 2.2, 4.3] {
            let at = Vec3::new(1.17e-3 * angle.cos(), 1.17e-3 * angle.sin(), 1.0e-3);
            add_sphere(&mut model, at, still, still);
        }
        add_sphere(&mut model, Vec3::new(0.0, 0.0, 2.66e-3), still, still);
        add_plane(&mut model, "floor", still, Vec3::z(), Motion::Still);
        // The lid meets the heap within a step, not at the end of one, where a rounding error decides.
        let height = 3.68037e-3;
        let motion = Motion::Servo { direction: -Vec3::z(), force: 0.2, speed: 0.1 };
        add_plane(&mut model, "lid", Vec3::z() * height, -Vec3::z(), motion);
        if mesh {
            model.walls[1].shape = sheet(height);
        }
        model.plan.steps = 6000;
        let limits = liggghts.limits(&model);
        let refused = |l: &solver::Limit| l.kind == LimitKind::Refused && l.what.contains("servo");
        assert!(limits.iter().any(refused), "{limits:?}");
        let ours = dem::run(&model, &Job::quiet()).expect("a run");
        let load = ours.frames.last().expect("frames").forces[3].norm();
        assert!(load < 0.1, "the heap carries the lid: {load} N are left");
        let Some(worst) = twin_differences(yade, &model) else { return };
        assert!(worst.iter().all(|worst| *worst < 1e-8), "{mesh}: {worst:?}");
    }
}

/// What each packing method has placed loads in both solvers at the places and with the overlaps
/// that riprap reported: step 0 of their dumps.
#[test]
fn packings_load_with_the_overlaps_that_were_reported() {
    let container: Container =
        toml::from_str("box = { size = [0.02, 0.02, 0.02] }").expect("a box");
    let region = container.region(3, None).expect("a region");
    let clumps: Vec<_> = (0..150)
        .map(|i| clump::sphere("ball", 1e-3 * (1.0 + 0.2 * f64::from(i % 5) / 4.0)))
        .collect();
    let grains: Vec<Grain> =
        clumps.iter().map(|clump| Grain { clump, solid: None, family: 0 }).collect();
    for text in [
        "random = {}",
        "array = {}",
        "apollonian = { smallest = 1e-3 }",
        "random_apollonian = { smallest = 5e-4 }",
        "simultaneous_growth = { births = { steady = 10 } }",
        "packing_limited_growth = {}",
        "drop_and_roll = {}",
        "radius_expansion = { porosity = 0.5 }",
        "explosive_repulsion = { porosity = 0.5 }",
        "moving_boundary = { porosity = 0.5 }",
        "force_biased = { porosity = 0.5, rate = 1e-3 }",
    ] {
        let method: Method = toml::from_str(text).expect("a method");
        let packing = pack(&grains, &["ball"], &region, &method, 1, &Job::quiet()).expect(text);
        assert!(packing.placements.len() > 20, "{text}: {}", packing.outcome);
        let mut model = model(Dimension::Three, CONTACT);
        model.domain = Bounds { low: Vec3::repeat(-0.01), high: Vec3::repeat(0.03) };
        for laid in &packing.placements {
            let radius = clumps[laid.grain as usize].balls[0].radius * laid.scale;
            let (index, first) = (model.bodies.len() as u32, model.spheres.len() as u32);
            let body = Body::sphere(model.dimension, laid.position, radius, 2500.0, 0, first);
            model.bodies.push(body);
            model.spheres.push(Sphere { offset: Vec3::zeros(), radius, body: index });
        }
        (model.plan.step, model.plan.steps, model.plan.frame_every) = (1e-9, 1, 1);
        let radii: Vec<f64> = model.spheres.iter().map(|sphere| sphere.radius).collect();
        let body: Vec<u32> = (0..radii.len() as u32).collect();
        for solver in solver::all() {
            let Some(run) = finished(solver, &model) else { continue };
            let centres = &run.frames[0].centres;
            for (centre, laid) in centres.iter().zip(&packing.placements) {
                assert!((centre - laid.position).norm() < 1e-15, "{text}: {}", solver.key());
            }
            let found = contacts_of(centres, &radii, &body, 0.0, None);
            let (told, worst) = (packing.measures.worst_overlap, found.worst_overlap);
            assert!((told - worst).abs() < 1e-10, "{text}: {}: {worst} for {told}", solver.key());
        }
    }
}

#[test]
fn spheres_that_leave_are_taken_out_in_both_solvers() {
    for (solver, scheme) in solver::all().into_iter().zip([Scheme::Liggghts, Scheme::Yade]) {
        let mut model = model(Dimension::Three, CONTACT);
        (model.plan.scheme, model.plan.law) = (scheme, scheme.law());
        model.plan.guard.lost = Lost::Remove;
        model.gravity = Vec3::new(0.0, 0.0, -9.81);
        let spin = Vec3::new(100.0, -50.0, 0.0);
        add_sphere(&mut model, Vec3::new(18e-3, 0.0, 5e-3), Vec3::new(2.0, 0.0, 0.5), spin);
        add_sphere(&mut model, Vec3::new(0.0, 0.0, 1.05e-3), Vec3::zeros(), spin);
        add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
        model.plan.steps = 5120;
        let ours = dem::run(&model, &Job::quiet()).expect("a run");
        assert!(
            ours.notes.iter().any(|note| note.contains("taken out: body 0")),
            "{:?}",
            ours.notes
        );
        let Some(run) = finished(solver, &model) else { continue };
        let (a, b) = (ours.frames.last().expect("frames"), run.frames.last().expect("frames"));
        let still = (a.centres[1] - b.centres[1]).norm();
        assert!(still < 1e-13, "{}: {still:e}", solver.key());
        assert_eq!(b.velocities[0], Vec3::zeros(), "{}", solver.key());
        assert!(model.is_outside(&a.centres[0]));
        if scheme == Scheme::Yade {
            assert!((a.centres[0] - b.centres[0]).norm() < 1e-15);
        }
    }
}
