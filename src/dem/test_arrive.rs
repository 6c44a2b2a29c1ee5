//! Bodies that come during a run.

use super::test_scenes::{RADIUS, SCHEMES, add_plane, add_sphere, contact, empty};
use super::{DemError, run};
use crate::model::{Model, Motion, Outcome, Run, Scheme, WallShape};
use crate::num::{Job, Vec3};

/// Nothing but spheres that come one after another over a plane.
fn rain(scheme: Scheme, count: u32) -> Model {
    let mut model = empty(scheme, contact(2.0 / 7.0 * 1e5, 5.0, 0.0, 0.3));
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    (model.plan.step, model.plan.steps) = (2e-5, 4000);
    (model.plan.frame_every, model.plan.series_every) = (100, 100);
    for k in 0..count {
        let place = Vec3::new(2.5 * RADIUS * f64::from(k % 3), 0.0, 4.0 * RADIUS);
        let velocity = Vec3::new(0.02, 0.0, -1.0);
        add_sphere(&mut model, place, RADIUS, velocity, Vec3::new(0.0, 30.0, 0.0));
        model.arrivals.push((50.0 + 400.0 * f64::from(k)) * model.plan.step);
    }
    model
}

fn done(model: &Model) -> Run {
    run(model, &Job::quiet()).expect("runs")
}

/// A body that comes at step n is where a body thrown from there is n steps later.
#[test]
fn coming_late_is_being_thrown_late() {
    for scheme in SCHEMES {
        let late = rain(scheme, 1);
        let mut thrown = late.clone();
        thrown.arrivals.clear();
        // Frames 100, 200 ... of the one are 50, 150 ... of the other.
        (thrown.plan.frame_every, thrown.plan.steps) = (50, 3950);
        let (late, thrown) = (done(&late), done(&thrown));
        assert_eq!((&late.outcome, &thrown.outcome), (&Outcome::Finished, &Outcome::Finished));
        for (number, frame) in late.frames.iter().enumerate().skip(1) {
            let other = &thrown.frames[2 * number - 1];
            assert_eq!(frame.step, other.step + 50);
            let far = (frame.centres[0] - other.centres[0]).norm() / RADIUS;
            let fast = (frame.velocities[0] - other.velocities[0]).norm();
            let spin = (frame.spins[0] - other.spins[0]).norm();
            assert!(far < 1e-12 && fast < 1e-12 && spin < 1e-10, "{scheme:?} {far:e} {fast:e}");
        }
    }
}

#[test]
fn who_has_not_come_stands_still_and_touches_nothing() {
    let model = rain(Scheme::Leapfrog, 3);
    let run = done(&model);
    let third = |frame: usize| (run.frames[frame].centres[2], run.frames[frame].velocities[2]);
    // It comes at step 850.
    assert_eq!(third(8), (model.bodies[2].position, Vec3::zeros()));
    assert!(third(9).1.z < -1.0);
}

#[test]
fn the_ledger_counts_who_comes_as_there_from_the_start() {
    for scheme in SCHEMES {
        let run = done(&rain(scheme, 5));
        assert_eq!(run.outcome, Outcome::Finished, "{scheme:?}");
        let whole: f64 = run.series.iter().map(|row| row.kinetic).fold(0.0, f64::max);
        for row in &run.series {
            assert!(row.missed().abs() < 0.02 * whole, "{scheme:?} {row:?}");
        }
    }
}

#[test]
fn going_on_from_a_checkpoint_is_never_having_stopped() {
    #[derive(Default)]
    struct Keeper(Vec<Vec<u8>>, Option<crate::model::Frame>);
    impl super::Observer for Keeper {
        fn frame(&mut self, frame: &crate::model::Frame) {
            self.1 = Some(frame.clone());
        }
        fn row(&mut self, _row: &crate::model::SeriesRow) {}
        fn checkpoint(&mut self, bytes: &[u8]) {
            self.0.push(bytes.to_vec());
        }
    }
    let mut model = rain(Scheme::Leapfrog, 5);
    model.plan.checkpoint_every = 700;
    let mut whole = Keeper::default();
    super::simulate(&model, None, &Job::quiet(), &mut whole).expect("runs");
    let mut rest = Keeper::default();
    super::simulate(&model, Some(&whole.0[0]), &Job::quiet(), &mut rest).expect("goes on");
    assert_eq!(whole.1, rest.1);
}

#[test]
fn a_place_that_is_taken_ends_the_run() {
    let mut model = rain(Scheme::Leapfrog, 2);
    // The second comes where the first is one step after it came.
    model.bodies[1].position = model.bodies[0].position;
    model.arrivals[1] = model.arrivals[0] + model.plan.step;
    let run = done(&model);
    let Outcome::Stopped { step, reason, .. } = run.outcome else { panic!("{:?}", run.outcome) };
    assert_eq!(step, 51);
    assert!(reason.contains("body 1 comes at") && reason.contains("where body 0 is"), "{reason}");
}

#[test]
fn a_place_in_a_wall_ends_the_run() {
    let mut model = rain(Scheme::Leapfrog, 1);
    let place = model.bodies[0].position + Vec3::x() * 0.9 * RADIUS;
    add_plane(&mut model, place, Vec3::x(), Motion::Still);
    let Outcome::Stopped { step, reason, .. } = done(&model).outcome else { panic!("goes on") };
    assert_eq!(step, 50);
    let wall = format!("where wall `{}` is", model.walls[1].name);
    assert!(reason.contains("body 0 comes at") && reason.contains(&wall), "{reason}");
    // Close to it is no matter.
    let WallShape::Plane { point, .. } = &mut model.walls[1].shape else { unreachable!() };
    point.x += 0.2 * RADIUS;
    model.bodies[0].velocity = Vec3::zeros();
    model.plan.steps = 100;
    assert_eq!(done(&model).outcome, Outcome::Finished);
}

#[test]
fn it_does_not_go_with_bonds_or_attraction() {
    let mut model = rain(Scheme::Leapfrog, 2);
    model.mutual = toml::from_str("").ok();
    let refused = run(&model, &Job::quiet());
    assert!(matches!(refused, Err(DemError::Unusable(why)) if why.contains("inserted")));
}
