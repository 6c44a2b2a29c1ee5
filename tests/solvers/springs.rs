//! A settled state that goes on with the tangential springs of its contacts.

use super::bench::*;
use riprap::model::{Partner, Spring};

/// Spheres and clumps that have settled with friction in a box, at the end of a run in YADE's scheme.
fn settled() -> (Model, Run) {
    let mut model = model(Dimension::Three, Contact { cn: 0.05, ..CONTACT });
    (model.plan.scheme, model.plan.law) = (Scheme::Yade, Scheme::Yade.law());
    model.gravity = Vec3::new(1.5, 0.5, -9.81);
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    for i in 0..24 {
        let [x, y, z] = [i % 3, i / 3 % 2, i / 6].map(f64::from);
        let lean = 0.3e-3 * (z % 2.0);
        let place =
            Vec3::new(-3e-3 + 3e-3 * x + lean, -1.5e-3 + 3e-3 * y + lean, 2e-3 + 3.6e-3 * z);
        if i % 4 == 1 {
            add_clump(&mut model, place, Vec3::zeros(), Vec3::zeros(), inertia);
        } else {
            add_sphere(&mut model, place, Vec3::zeros(), Vec3::zeros());
        }
    }
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    for (axis, half) in [(Vec3::x(), 4.8e-3), (Vec3::y(), 3.2e-3)] {
        for side in [1.0, -1.0] {
            let name = format!("side{}", model.walls.len());
            add_plane(&mut model, &name, axis * (-half * side), axis * side, Motion::Still);
        }
    }
    (model.plan.step, model.plan.steps) = (4e-6, 40_000);
    model.plan.frame_every = model.plan.steps;
    let run = dem::run(&model, &Job::quiet()).expect("a run");
    assert_eq!(run.outcome, Outcome::Finished);
    (model, run)
}

/// The state at the end of `run` with its springs, and 500 steps to go.
fn going_on(mut model: Model, run: &Run) -> Model {
    let last = run.frames.last().expect("frames");
    for (body, state) in model.bodies.iter_mut().zip(&last.bodies) {
        (body.position, body.orientation) = (state.position, state.orientation);
        (body.velocity, body.spin) = (state.velocity, state.spin);
    }
    model.springs = run.springs.clone();
    (model.plan.steps, model.plan.frame_every) = (500, 500);
    model
}

fn apart(a: &Run, b: &Run) -> f64 {
    let (a, b) = (a.frames.last().expect("frames"), b.frames.last().expect("frames"));
    let far = a.centres.iter().zip(&b.centres).map(|(x, y)| (x - y).norm() / 1e-3);
    far.fold(0.0, f64::max)
}

#[test]
fn a_settled_bed_goes_on_with_its_springs() {
    let (start, run) = settled();
    let with = going_on(start, &run);
    let pairs = with.springs.iter().filter(|s| matches!(s.other, Partner::Sphere(_))).count();
    assert!(pairs >= 20 && with.springs.len() > pairs + 5, "{pairs} of {}", with.springs.len());
    let ours = dem::run(&with, &Job::quiet()).expect("a run");
    let without = Model { springs: Vec::new(), ..with.clone() };
    let moved = apart(&dem::run(&without, &Job::quiet()).expect("a run"), &ours);
    assert!(moved > 1e-5, "springs must matter: {moved:e} radii");
    let [liggghts, yade, lammps] = solver::all();
    // Here there are clumps.
    for other in [liggghts, lammps] {
        assert!(!can(other, &with) && can(other, &without), "{}", other.key());
    }
    let Some(theirs) = finished(yade, &with) else { return };
    let far = apart(&theirs, &ours);
    assert!(far < 1e-9, "{far:e} radii; without springs {moved:e}");
}

/// A run that is cut in two with its springs is nearly the run; one that forgets them is not.
#[test]
fn a_run_cut_in_two_goes_on() {
    let (mut whole, _) = settled();
    (whole.plan.scheme, whole.plan.law) = (Scheme::Leapfrog, Scheme::Leapfrog.law());
    whole.plan.steps = 30_000;
    whole.plan.frame_every = 30_000;
    let first = dem::run(&whole, &Job::quiet()).expect("a run");
    let rest = dem::run(&going_on(whole.clone(), &first), &Job::quiet()).expect("a run");
    let forgotten = Run { springs: Vec::new(), ..first };
    let bare = dem::run(&going_on(whole.clone(), &forgotten), &Job::quiet()).expect("a run");
    (whole.plan.steps, whole.plan.frame_every) = (30_500, 30_500);
    let whole = dem::run(&whole, &Job::quiet()).expect("a run");
    let (far, off) = (apart(&rest, &whole), apart(&bare, &whole));
    // The set-up pass sees velocities of the full step, other passes those half a step before.
    assert!(far < 1e-4 && off > 20.0 * far, "{far:e}, without springs {off:e} radii");
}

/// The sign of a spring: a sphere at rest on a plane is pushed against its stretch.
#[test]
fn a_spring_pushes_back() {
    let mut model = model(Dimension::Three, Contact { cn: 0.0, ..CONTACT });
    (model.plan.scheme, model.plan.law) = (Scheme::Yade, Scheme::Yade.law());
    add_sphere(&mut model, Vec3::new(0.0, 0.0, 0.99e-3), Vec3::zeros(), Vec3::zeros());
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    let stretch = Vec3::new(2e-6, 0.0, 0.0);
    model.springs.push(Spring { sphere: 0, other: Partner::Plane(0), stretch });
    (model.plan.step, model.plan.steps, model.plan.frame_every) = (1e-9, 1, 1);
    let mass = model.bodies[0].mass;
    let expected = -CONTACT.kt * stretch.x / mass * model.plan.step;
    let ours = dem::run(&model, &Job::quiet()).expect("a run");
    let yade = finished(solver::all()[1], &model);
    for run in std::iter::once(ours).chain(yade) {
        let got = last_state(&run).velocity.x;
        assert!((got - expected).abs() < 1e-3 * expected.abs(), "{}: {got:e}", run.solver);
    }
}

/// The same in LIGGGHTS and LAMMPS, which have them from a restart file: spheres only.
#[test]
fn a_settled_bed_goes_on_with_its_springs_from_a_restart_file() {
    let [liggghts, _, lammps] = solver::all();
    for solver in [liggghts, lammps] {
        goes_on_in(solver);
    }
}

fn goes_on_in(solver: &dyn Solver) {
    let (mut start, _) = settled();
    (start.plan.scheme, start.plan.law) = solver.scheme(false);
    let mut spheres = model(Dimension::Three, Contact { cn: 0.05, ct: 0.02, ..CONTACT });
    for body in &start.bodies {
        add_sphere(&mut spheres, body.position, Vec3::zeros(), Vec3::zeros());
    }
    (spheres.walls, spheres.gravity) = (start.walls, start.gravity);
    spheres.plan = start.plan;
    let run = dem::run(&spheres, &Job::quiet()).expect("a run");
    assert_eq!(run.outcome, Outcome::Finished);
    let with = going_on(spheres, &run);
    let planes = with.springs.iter().filter(|s| matches!(s.other, Partner::Plane(_))).count();
    assert!(planes >= 5 && with.springs.len() > planes + 10, "{planes} of {}", with.springs.len());
    let ours = dem::run(&with, &Job::quiet()).expect("a run");
    let without = Model { springs: Vec::new(), ..with.clone() };
    let moved = apart(&dem::run(&without, &Job::quiet()).expect("a run"), &ours);
    assert!(moved > 1e-5, "springs must matter: {moved:e} radii");
    let Some(theirs) = finished(solver, &with) else { return };
    let far = apart(&theirs, &ours);
    println!("{}: {far:e} radii; without springs {moved:e}", solver.key());
    assert!(far < 1e-7, "{}: {far:e} radii; without springs {moved:e}", solver.key());
}
