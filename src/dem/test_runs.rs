//! Runs as a whole: the plain twin, threads, checkpoints, guard.

use super::reference::Twin;
use super::test_scenes::*;
use super::*;
use crate::model::*;
use crate::num::Vec3;
use crate::num::job::Silent;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Largest difference of positions [radii] and velocities [m/s] between a run and its twin.
fn against_twin(mut model: Model, steps: u64) -> f64 {
    model.plan.steps = steps;
    let run = run(&model, &Job::quiet()).expect("a usable model");
    assert_eq!(run.outcome, Outcome::Finished);
    let mut twin = Twin::new(&model);
    for _ in 0..steps {
        twin.step();
    }
    let last = run.frames.last().expect("frames");
    assert!(run.series.last().expect("rows").contacts > 0);
    last.bodies
        .iter()
        .zip(&twin.states)
        .map(|(a, b)| {
            let turned = a.orientation.angle_to(&b.orientation);
            ((a.position - b.position).norm() / RADIUS)
                .max((a.velocity - b.velocity).norm())
                .max((a.spin - b.spin).norm() * RADIUS)
                .max(turned)
        })
        .fold(0.0, f64::max)
}

#[test]
fn spheres_and_planes_follow_the_twin() {
    for scheme in SCHEMES {
        let difference = against_twin(mixed(scheme, Dimension::Three, false, false, 1), 300);
        assert!(difference < 1e-12, "{scheme:?} {difference}");
    }
}

#[test]
fn clumps_and_meshes_follow_the_twin() {
    for scheme in SCHEMES {
        let difference = against_twin(mixed(scheme, Dimension::Three, true, true, 2), 150);
        assert!(difference < 1e-12, "{scheme:?} {difference}");
    }
}

#[test]
fn discs_follow_the_twin() {
    for scheme in SCHEMES {
        for clumps in [false, true] {
            let difference = against_twin(mixed(scheme, Dimension::Two, clumps, false, 3), 400);
            assert!(difference < 1e-12, "{scheme:?} {clumps} {difference}");
        }
    }
}

#[test]
fn law_variants_follow_the_twin() {
    for tension in [true, false] {
        for coulomb in [Coulomb::Sum, Coulomb::Spring, Coulomb::SpringThenDashpot] {
            for history in [History::Projected, History::Rescaled, History::Rotated] {
                let mut model = mixed(Scheme::Leapfrog, Dimension::Three, false, true, 4);
                let arm = if tension { Arm::Radius } else { Arm::Full };
                model.plan.law = Law { tension, coulomb, history, arm, plane_arm: Arm::Full };
                let difference = against_twin(model, 150);
                assert!(difference < 1e-12, "{tension} {coulomb:?} {history:?} {difference}");
            }
        }
    }
}

#[test]
fn split_arms_follow_the_twin() {
    for clumps in [false, true] {
        let mut model = mixed(Scheme::Lammps, Dimension::Three, clumps, true, 4);
        let law = Law { history: History::Rescaled, arm: Arm::Split, ..Scheme::Lammps.law() };
        model.plan.law = law;
        let difference = against_twin(model, 150);
        assert!(difference < 1e-12, "{clumps} {difference}");
    }
}

#[test]
fn path_averaged_tension_follows_the_twin() {
    for arm in [Arm::Full, Arm::Half, Arm::Radius] {
        let mut model = mixed(Scheme::PathAveraged, Dimension::Three, true, false, 4);
        model.plan.law = Law { tension: true, arm, plane_arm: arm, ..model.plan.law };
        let difference = against_twin(model, 150);
        assert!(difference < 1e-12, "{arm:?} {difference}");
    }
}

#[test]
fn scenes_without_friction_or_damping_follow_the_twin() {
    let cases = [(0.0, 0.0), (5.0, 0.0), (0.0, 0.5)];
    for (scheme, (cn, friction)) in [Scheme::Liggghts, Scheme::PathAveraged]
        .into_iter()
        .flat_map(|scheme| cases.map(|case| (scheme, case)))
    {
        let mut model = mixed(scheme, Dimension::Three, false, false, 5);
        model.contacts = ContactTable::uniform(1, contact(0.3 * KN, cn, 0.0, friction));
        let needs = model.needs();
        assert_eq!((needs.friction, needs.normal_damping), (friction > 0.0, cn > 0.0));
        assert!(against_twin(model, 300) < 1e-12);
    }
}

/// A box of loose spheres, enough for several threads.
fn crowd(scheme: Scheme) -> Model {
    let mut model = empty(scheme, contact(0.3 * KN, 6.0, 1.0, 0.4));
    model.gravity = Vec3::z() * -9.81;
    model.plan.step = 2e-5;
    let mut source = crate::num::random::stream(8, "crowd", 0);
    for i in 0..2400u32 {
        let cell = Vec3::new(f64::from(i % 14), f64::from(i / 14 % 14), f64::from(i / 196));
        let jitter = Vec3::from_fn(|_, _| crate::num::random::uniform(&mut source, -0.02, 0.02));
        let centre = (cell * 2.0 + Vec3::repeat(1.0) + jitter) * RADIUS;
        let velocity = jitter * 10.0;
        add_sphere(&mut model, centre, RADIUS, velocity, velocity * 100.0);
    }
    add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    add_sheet(&mut model, 6, 0.4, 0.001, 0.0, Motion::Translate { velocity: Vec3::z() * 0.1 });
    model
}

#[test]
fn threads_change_no_bit() {
    for scheme in [Scheme::Leapfrog, Scheme::PathAveraged] {
        let mut model = crowd(scheme);
        model.plan.steps = 30;
        model.plan.series_every = 10;
        let runs = [1, 2, 3].map(|threads| {
            run(&model, &Job::quiet().with_threads(threads)).expect("a usable model")
        });
        assert!(runs[0].series[3].contacts > 3000);
        for other in &runs[1..] {
            assert_eq!(runs[0].frames, other.frames);
            assert_eq!(runs[0].series, other.series);
            assert_eq!(runs[0].touches, other.touches);
        }
    }
}

#[test]
fn solvers_round_what_gravity_adds_and_leapfrog_does_not() {
    for scheme in [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Lammps] {
        let mut model = empty(scheme, contact(0.0, 0.0, 0.0, 0.0));
        (model.gravity, model.plan.steps) = (Vec3::new(3e5, -7e5, -1e6), 40);
        // Half a step adds about as much as there is, so that its rounding shows.
        let start = Vec3::new(0.1, 0.7, 1.3);
        add_sphere(&mut model, Vec3::zeros(), RADIUS, start, Vec3::zeros());
        let half = 0.5 * model.plan.step;
        let fall = |fused: bool| {
            start.zip_map(&model.gravity, |start, pull| {
                (0..80).fold(start, |speed, _| match fused {
                    true => pull.mul_add(half, speed),
                    false => speed + pull * half,
                })
            })
        };
        assert_ne!(fall(true), fall(false));
        for series_every in [0, 1, 7] {
            model.plan.series_every = series_every;
            let found = finish(&model).frames.last().expect("frames").bodies[0].velocity;
            assert_eq!(found, fall(scheme == Scheme::Leapfrog), "{scheme:?} {series_every}");
        }
    }
}

/// Spheres go on during the force passes that nobody looks at, and after the others.
#[test]
fn what_is_looked_at_changes_no_bit() {
    let grains = |scheme| mixed(scheme, Dimension::Three, false, true, 3);
    for scheme in SCHEMES {
        for (mut model, steps) in [(grains(scheme), 400), (crowd(scheme), 30)] {
            model.plan.steps = steps;
            let unseen = finish(&model);
            model.plan.series_every = 1;
            let seen = finish(&model);
            assert_eq!(unseen.frames.last(), seen.frames.last(), "{scheme:?}");
            assert_eq!(unseen.series.last(), seen.series.last(), "{scheme:?}");
            assert_eq!(unseen.touches, seen.touches, "{scheme:?}");
        }
    }
}

/// All that moves, and what is asked of contacts at the end.
#[test]
fn a_ledger_changes_no_bit_of_the_motion() {
    let grains = |scheme| mixed(scheme, Dimension::Three, false, true, 3);
    for scheme in SCHEMES {
        for (mut model, steps, threads) in [(grains(scheme), 400, 1), (crowd(scheme), 150, 2)] {
            model.plan.steps = steps;
            model.plan.series_every = 50;
            let job = Job::quiet().with_threads(threads);
            let whole = run(&model, &job).expect("a usable model");
            model.plan.ledger = false;
            let bare = run(&model, &job).expect("a usable model");
            assert_eq!(whole.frames, bare.frames, "{scheme:?}");
            assert_eq!(whole.touches, bare.touches, "{scheme:?}");
            assert!(whole.touches.is_some_and(|touches| !touches.is_empty()));
            for (whole, bare) in whole.series.iter().zip(&bare.series) {
                let states = |row: &SeriesRow| (row.kinetic, row.elastic, row.gravitational);
                assert_eq!(states(whole), states(bare), "{scheme:?}");
                assert!(whole.energy_error.is_some() && bare.energy_error.is_none());
                assert_eq!(
                    (bare.normal_dashpot, bare.tangential_dashpot, bare.slip),
                    (0.0, 0.0, 0.0)
                );
            }
            let end = whole.series.last().expect("a row");
            assert!(end.normal_dashpot > 0.0 && end.slip != 0.0, "{scheme:?} {end:?}");
        }
    }
}

#[test]
fn a_run_that_is_cancelled_goes_on_as_if_it_had_not_been() {
    for scheme in SCHEMES {
        let mut model = mixed(scheme, Dimension::Three, false, false, 3);
        (model.plan.steps, model.plan.guard.lost) = (20_000, Lost::GoOn);
        let whole = finish(&model);
        let cancelled = Arc::new(AtomicBool::new(false));
        let job = Job::new(1, Arc::new(Silent), Arc::clone(&cancelled));
        let mut log = Log::default();
        let outcome = std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(Duration::from_millis(10));
                cancelled.store(true, Ordering::Relaxed);
            });
            simulate(&model, None, &job, &mut log).expect("usable").outcome
        });
        assert!(matches!(outcome, Outcome::Cancelled { step: 1.. }), "{outcome:?}");
        let checkpoint = log.checkpoints.last().expect("a checkpoint");
        let mut log = Log::default();
        let rest = simulate(&model, Some(checkpoint), &Job::quiet(), &mut log).expect("usable");
        assert_eq!(whole.frames.last(), log.frames.last(), "{scheme:?}");
        assert_eq!(whole.touches, Some(rest.touches), "{scheme:?}");
    }
}

#[test]
fn resuming_changes_no_bit() {
    for scheme in SCHEMES {
        let mut model = mixed(scheme, Dimension::Three, true, true, 6);
        model.local_damping = 0.1;
        let plan = &mut model.plan;
        (plan.steps, plan.frame_every, plan.series_every) = (300, 50, 50);
        plan.checkpoint_every = 130;
        let mut whole = Log::default();
        let end = simulate(&model, None, &Job::quiet(), &mut whole).expect("usable");
        assert_eq!(whole.checkpoints.len(), 2);
        let mut part = Log::default();
        let resumed = simulate(&model, Some(&whole.checkpoints[0]), &Job::quiet(), &mut part)
            .expect("a good checkpoint");
        assert_eq!(whole.frames[3..], part.frames[..]);
        assert_eq!(whole.rows[3..], part.rows[..]);
        assert_eq!(whole.checkpoints[1], part.checkpoints[0]);
        assert_eq!(end.touches, resumed.touches);
    }
}

#[test]
fn checkpoint_of_another_scene_is_refused() {
    let mut model = mixed(Scheme::Yade, Dimension::Three, false, false, 6);
    (model.plan.steps, model.plan.checkpoint_every) = (10, 10);
    let mut log = Log::default();
    simulate(&model, None, &Job::quiet(), &mut log).expect("usable");
    let bytes = &log.checkpoints[0];
    model.plan.step *= 0.5;
    let refused = |bytes: &[u8]| {
        matches!(
            simulate(&model, Some(bytes), &Job::quiet(), &mut log_nothing()),
            Err(DemError::Checkpoint(_))
        )
    };
    assert!(refused(bytes));
    assert!(refused(&bytes[..bytes.len() / 2]));
    assert!(refused(&[]));
}

fn log_nothing() -> Log {
    Log::default()
}

#[test]
fn too_large_a_step_is_refused_unless_insisted_on() {
    let mut model = mixed(Scheme::Leapfrog, Dimension::Three, false, false, 1);
    let advice = advise(&model);
    assert!(advice.step < advice.limit, "{advice:?}");
    model.plan.step = advice.limit * 1.01;
    model.plan.steps = 3;
    let refused = run(&model, &Job::quiet());
    assert!(matches!(refused, Err(DemError::StepTooLarge { .. })), "{refused:?}");
    model.plan.insist = true;
    assert!(run(&model, &Job::quiet()).is_ok());
}

fn stopped(model: &Model) -> String {
    match run(model, &Job::quiet()).expect("a run").outcome {
        Outcome::Stopped { reason, .. } => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn guard_says_who_left_and_why() {
    let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
    add_sphere(&mut model, Vec3::zeros(), RADIUS, Vec3::x() * 2.0, Vec3::zeros());
    model.plan.step = 1e-4;
    model.plan.steps = 20_000;
    assert!(stopped(&model).contains("body 0 left the domain"));

    // Thrown at a wall faster than the guard lets through, with the step insisted on only by speed forecast.
    model.plan.insist = true;
    model.bodies[0].velocity = Vec3::x() * 1e300;
    assert!(stopped(&model).contains("body 0"));

    // Two spheres at the same place have no normal: refused and named, or NaN is found.
    let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
    for _ in 0..2 {
        add_sphere(&mut model, Vec3::zeros(), RADIUS, Vec3::zeros(), Vec3::zeros());
    }
    (model.plan.steps, model.plan.guard.overlap) = (10, 0.5);
    let refused = run(&model, &Job::quiet()).expect_err("too deep").to_string();
    assert!(refused.contains("body 0 overlaps body 1 by 2.000"), "{refused}");
    model.plan.guard.overlap = 0.0;
    assert!(stopped(&model).contains("not a finite number"));
}

#[test]
fn guard_watches_overlaps_and_energy_and_keeps_the_last_state() {
    // Thrown together far too fast for their stiffness.
    let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
    for side in [-1.0, 1.0] {
        let place = Vec3::x() * (side * 1.01 * RADIUS);
        add_sphere(&mut model, place, RADIUS, Vec3::x() * (side * -25.0), Vec3::zeros());
    }
    (model.plan.step, model.plan.steps) = (1e-6, 1000);
    model.plan.guard.overlap = 0.5;
    let mut log = Log::default();
    let end = simulate(&model, None, &Job::quiet(), &mut log).expect("usable");
    let Outcome::Stopped { reason, step, .. } = end.outcome else { panic!("{:?}", end.outcome) };
    assert!(reason.contains("body 0 overlaps body 1 by"), "{reason}");
    assert_eq!(log.frames.last().map(|frame| frame.step), Some(step));
    assert_eq!(log.checkpoints.len(), 1);
    model.plan.guard.overlap = 2.5;
    assert_eq!(run(&model, &Job::quiet()).expect("usable").outcome, Outcome::Finished);
}

#[test]
fn insisting_on_a_step_turns_stops_into_notes() {
    let mut model = mixed(Scheme::Leapfrog, Dimension::Three, false, false, 1);
    model.walls.clear();
    model.gravity = Vec3::zeros();
    model.bodies.truncate(2);
    model.spheres.truncate(2);
    for (i, body) in model.bodies.iter_mut().enumerate() {
        let side = if i == 0 { -1.0 } else { 1.0 };
        body.position = Vec3::x() * (side * 0.95 * RADIUS);
        (body.velocity, body.spin) = (Vec3::x() * (side * -0.5), Vec3::zeros());
    }
    let limit = advise(&model).limit;
    (model.plan.step, model.plan.steps, model.plan.insist) = (1.5 * limit, 200, true);
    model.plan.guard.gain = 0.0;
    let noted = run(&model, &Job::quiet()).expect("usable");
    assert_eq!(noted.outcome, Outcome::Finished);
    assert!(noted.notes[0].contains("gone on as insisted"), "{:?}", noted.notes);
}

#[test]
fn guard_stops_bodies_that_would_tunnel() {
    // Squeezed far into a wall, the sphere is thrown out faster than half a radius a step.
    let mut model =
        empty(Scheme::Leapfrog, Contact { kn: 1e9, kt: 0.0, cn: 0.0, ct: 0.0, friction: 0.0 });
    for i in 0..2 {
        let place = Vec3::x() * (f64::from(i) * 1e-6);
        add_sphere(&mut model, place, RADIUS, Vec3::zeros(), Vec3::zeros());
    }
    model.plan.step = advise(&model).limit * 0.99;
    (model.plan.steps, model.plan.guard.overlap) = (1000, 0.0);
    assert!(stopped(&model).contains("of its radius in one step"));
}

#[test]
fn cancelling_is_an_outcome() {
    let mut model = mixed(Scheme::Leapfrog, Dimension::Three, false, false, 1);
    model.plan.steps = 1000;
    let job = Job::new(1, Arc::new(Silent), Arc::new(AtomicBool::new(true)));
    let run = run(&model, &job).expect("a usable model");
    assert_eq!(run.outcome, Outcome::Cancelled { step: 0 });
}

#[test]
fn memory_stays_below_400_bytes_a_sphere() {
    let model = crowd(Scheme::Leapfrog);
    let setting = setting::Setting::new(&model);
    let mut state = crate::dem::state::State::new(&setting);
    neighbours::rebuild(&setting, &mut state, &crate::dem::crew::Crew::new(1));
    let mut work = forces::Workspace::new(2, model.spheres.len());
    drive::force_pass(&setting, &mut state, &mut work, true);
    let list = |list: &crate::dem::state::List| {
        list.partner.capacity() * 4
            + list.start.capacity() * 4
            + list.book.touching.len()
            + (list.book.spring.len() + list.book.normal.len() + list.book.pull.len()) * 24
            + list.book.lag.len() * 8
            + list.book.power.len() * 4
    };
    let spheres = state.balls.capacity() * size_of::<crate::dem::state::Ball>()
        + state.loads.capacity() * size_of::<crate::dem::state::Load>()
        + state.light.0.capacity() * size_of::<crate::dem::state::Lightness>()
        + (state.spins.capacity() + state.built.capacity()) * 24
        + (state.order.capacity() + state.slot.capacity() + state.leeway.capacity()) * 4;
    let lists = list(&state.pairs) + list(&state.planes) + list(&state.faces);
    // Scratch of two threads for one of at most 64 blocks each: in large scenes a byte a sphere and thread.
    let fixed = 2 * (30_000 + 64 * 1200);
    let bytes = spheres + lists + work.bytes().saturating_sub(fixed);
    assert!(bytes < 400 * state.balls.len(), "{}", bytes / state.balls.len());
}

#[test]
fn an_empty_scene_runs() {
    let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
    model.plan.steps = 3;
    let run = run(&model, &Job::quiet()).expect("usable");
    assert_eq!(run.outcome, Outcome::Finished);
    assert!(run.series.iter().all(|row| row.missed() == 0.0 && row.coordination == 0.0));
}
