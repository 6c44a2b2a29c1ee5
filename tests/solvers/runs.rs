//! What comes back from a run: contacts, lost spheres, ends, ranks, packings.

use super::bench::*;

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
