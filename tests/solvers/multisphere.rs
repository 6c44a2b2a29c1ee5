//! LIGGGHTS' second way with clumps, `fix multisphere`.

use super::bench::*;
use riprap::model::ClumpRoute;

/// Worst difference of sphere centres (largest radii) and spins (of the largest) from our own run.
/// Poses are not held against each other: two spheres do not tell their turn about their line.
fn differences(model: &Model) -> Option<[f64; 2]> {
    let theirs = finished(solver::all()[0], model)?;
    let ours = dem::run(model, &Job::quiet()).expect("a run");
    assert_eq!(ours.frames.len(), theirs.frames.len());
    let [mut place, mut spin] = [0.0_f64; 2];
    for (a, b) in ours.frames.iter().zip(&theirs.frames) {
        let apart = a.centres.iter().zip(&b.centres).map(|(x, y)| (x - y).norm() / 1e-3);
        place = apart.fold(place, f64::max);
        let fastest = a.spins.iter().map(|spin| spin.norm()).fold(1e-300, f64::max);
        let apart = a.spins.iter().zip(&b.spins).map(|(x, y)| (x - y).norm() / fastest);
        spin = apart.fold(spin, f64::max);
    }
    Some([place, spin])
}

fn by_multisphere(mut model: Model) -> Model {
    model.decks.liggghts_clumps = ClumpRoute::Multisphere;
    model
}

/// Clumps whose centre of mass lies outside the hull of their centres, and a sphere between them
/// in the order of the bodies.
#[test]
fn clumps_fall_and_bounce_like_our_own() {
    let model = by_multisphere(tumbling());
    let Some(worst) = differences(&model) else { return };
    assert!(worst.iter().all(|worst| *worst < 1e-10), "{worst:?}");
}

/// Both ways compute the same, contacts and their forces with it.
#[test]
fn both_ways_with_clumps_agree() {
    let liggghts = solver::all()[0];
    let mut rigid = tumbling();
    (rigid.plan.steps, rigid.plan.frame_every) = (50, 25);
    // A sphere that presses on a clump: contacts are told by the spheres of the scene.
    let clump = &rigid.bodies[1];
    let place = clump.position + clump.orientation * Vec3::new(2.88e-3, 0.0, -0.2e-3);
    add_sphere(&mut rigid, place, Vec3::zeros(), Vec3::zeros());
    // A clump that spins is right with fix multisphere only: the set-up pass of fix rigid sees
    // its spheres at other velocities.
    if let Some(worst) = differences(&by_multisphere(rigid.clone())) {
        assert!(worst.iter().all(|worst| *worst < 1e-12), "{worst:?}");
    }
    rigid.bodies[1].spin = Vec3::zeros();
    let multisphere = by_multisphere(rigid.clone());
    let Some(one) = finished(liggghts, &rigid) else { return };
    let two = finished(liggghts, &multisphere).expect("found before");
    for (a, b) in one.frames.iter().zip(&two.frames) {
        for (x, y) in a.centres.iter().zip(&b.centres) {
            assert!((x - y).norm() < 1e-13, "step {}: {x:?} {y:?}", a.step);
        }
    }
    let (one, two) = (one.touches.expect("contacts"), two.touches.expect("contacts"));
    assert!(!one.is_empty());
    assert_eq!(one.len(), two.len());
    for (a, b) in one.iter().zip(&two) {
        assert_eq!((a.first, a.second), (b.first, b.second));
        assert!((a.normal - b.normal).abs() < 1e-9 * a.normal.abs().max(1e-3), "{a:?} {b:?}");
    }
}

/// Walls that move begin to do so when the clumps are there.
#[test]
fn moving_walls_start_with_the_run() {
    let mut model = by_multisphere(tumbling());
    model.walls.clear();
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), slide(0.0, 0.0, 0.3));
    let side = Vec3::new(8e-3, 0.0, 0.0);
    add_plane(&mut model, "side", side, Vec3::new(-1.0, 0.0, 0.2), turn(Vec3::x()));
    model.plan.steps = 3000;
    let Some(worst) = differences(&model) else { return };
    assert!(worst.iter().all(|worst| *worst < 1e-10), "{worst:?}");
}

#[test]
fn ranks_do_not_change_the_answer() {
    if std::process::Command::new("mpirun").arg("--version").output().is_err() {
        println!("skipped: mpirun not found");
        return;
    }
    let liggghts = solver::all()[0];
    let mut model = by_multisphere(tumbling());
    model.plan.steps = 2000;
    let Some(one) = finished(liggghts, &model) else { return };
    let options = DeckOptions { ranks: 2, processors: Some([2, 1, 1]), queue_script: false };
    let two = run(liggghts, &model, &options).expect("found before");
    assert_eq!(two.outcome, Outcome::Finished);
    let (one, two) = (one.frames.last().expect("frames"), two.frames.last().expect("frames"));
    for (a, b) in one.centres.iter().zip(&two.centres) {
        assert!((a - b).norm() < 1e-13, "{a:?} {b:?}");
    }
}
