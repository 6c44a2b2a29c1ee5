//! Bodies that leave the domain.

use super::test_scenes::*;
use super::*;
use crate::model::*;
use crate::num::{Rotation, Vec3};

/// A small room with one sphere that is thrown out of it, one that stays, and a clump that leaves.
fn thrown(scheme: Scheme, lost: Lost) -> Model {
    let mut model = empty(scheme, contact(0.4 * KN, 6.0, 2.0, 0.4));
    model.domain = crate::geometry::Bounds { low: Vec3::repeat(-0.1), high: Vec3::repeat(0.1) };
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    let spin = Vec3::new(20.0, 0.0, 10.0);
    add_sphere(&mut model, Vec3::new(0.05, 0.0, 0.03), RADIUS, Vec3::new(0.8, 0.0, 1.0), spin);
    add_sphere(&mut model, Vec3::z() * 1.02 * RADIUS, RADIUS, Vec3::zeros(), spin);
    let up = Vec3::new(-0.9, 0.1, 0.8);
    add_clump(&mut model, Vec3::new(-0.06, 0.0, 0.03), Rotation::identity(), up, spin);
    add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    (model.plan.step, model.plan.steps, model.plan.series_every) = (2e-5, 12_800, 128);
    model.plan.guard.lost = lost;
    model
}

#[test]
fn bodies_outside_stop_the_run_are_taken_out_or_go_on() {
    for scheme in [Scheme::Leapfrog, Scheme::Yade, Scheme::PathAveraged] {
        let job = Job::quiet();
        let stopped = run(&thrown(scheme, Lost::Stop), &job).expect("a run");
        assert!(
            matches!(&stopped.outcome, Outcome::Stopped { reason, .. } if reason.contains("left"))
        );

        let model = thrown(scheme, Lost::Remove);
        let out = run(&model, &job).expect("a run");
        assert_eq!(out.outcome, Outcome::Finished, "{scheme:?}");
        assert!(out.notes[0].starts_with("2 bodies left the domain and were taken out: body "));
        let last = out.series.last().expect("a row");
        assert_eq!(last.lost, 2);
        for row in &out.series {
            assert!(row.missed().abs() < 1e-3 * out.series[0].kinetic, "{scheme:?} {row:?}");
        }
        let frame = out.frames.last().expect("a frame");
        for (body, limit) in [(0, 0.115), (2, 0.12)] {
            let state = &frame.bodies[body];
            assert!(model.is_outside(&state.position) && state.position.amax() < limit);
            assert_eq!((state.velocity, state.spin), (Vec3::zeros(), Vec3::zeros()));
        }
        assert!(frame.bodies[1].position.z > 0.0 && frame.bodies[1].position.z < 2.0 * RADIUS);
        assert!(last.lost_energy > 0.3 * out.series[0].kinetic);

        let on = run(&thrown(scheme, Lost::GoOn), &job).expect("a run");
        assert_eq!(on.outcome, Outcome::Finished);
        assert!(
            on.notes[0].contains("are outside the domain at the end: body 0"),
            "{:?}",
            on.notes
        );
        let (a, b) = (on.frames.last().expect("a frame"), frame);
        assert!(a.bodies[0].position.x > 0.2);
        assert!((a.bodies[1].position - b.bodies[1].position).norm() < 1e-12);
    }
}

#[test]
fn a_body_that_is_out_is_no_obstacle_and_stays_so_after_a_checkpoint() {
    struct Keep(Vec<Vec<u8>>, Option<Frame>);
    impl Observer for Keep {
        fn frame(&mut self, frame: &Frame) {
            self.1 = Some(frame.clone());
        }
        fn row(&mut self, _row: &SeriesRow) {}
        fn checkpoint(&mut self, bytes: &[u8]) {
            self.0.push(bytes.to_vec());
        }
    }
    let mut model = thrown(Scheme::Leapfrog, Lost::Remove);
    // Leaves while it still touches the body before it.
    let before = model.bodies[0].position + Vec3::new(-2.0 * RADIUS, 0.0, 0.0);
    let velocity = model.bodies[0].velocity;
    add_sphere(&mut model, before, RADIUS, velocity * 1.02, Vec3::zeros());
    model.plan.checkpoint_every = 6_400;
    let mut whole = Keep(Vec::new(), None);
    let summary = simulate(&model, None, &Job::quiet(), &mut whole).expect("it runs");
    assert_eq!(summary.outcome, Outcome::Finished);
    assert!(summary.notes[0].starts_with("3 bodies"), "{:?}", summary.notes);
    let mut rest = Keep(Vec::new(), None);
    simulate(&model, Some(&whole.0[0]), &Job::quiet(), &mut rest).expect("it goes on");
    assert_eq!(whole.1, rest.1);
}
