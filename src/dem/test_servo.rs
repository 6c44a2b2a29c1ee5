//! Walls that seek a force, and walls that oscillate.

use super::test_scenes::*;
use super::*;
use crate::model::extra::*;
use crate::model::*;
use crate::num::Vec3;
use crate::num::units::{Angle, Energy, Force, Length, SurfaceTension, Volume};

const DOWN: Vec3 = Vec3::new(0.0, 0.0, -1.0);

/// Layers of spheres in a box of planes under a lid that pushes down with `force`; as a mesh or a plane.
fn press(scheme: Scheme, force: f64, mesh: bool) -> Model {
    let mut model = empty(scheme, contact(0.3 * KN, 12.0, 4.0, 0.3));
    model.plan.step = 2e-5;
    let half = 2.1 * RADIUS;
    for layer in 0..3 {
        for place in 0..4 {
            let (i, j) = (f64::from(place % 2) - 0.5, f64::from(place / 2) - 0.5);
            let shift = 0.1 * f64::from(layer % 2);
            let centre = Vec3::new(
                (2.05 * i + shift) * RADIUS,
                (2.05 * j - shift) * RADIUS,
                (1.01 + 2.0 * f64::from(layer)) * RADIUS,
            );
            add_sphere(&mut model, centre, RADIUS, Vec3::zeros(), Vec3::zeros());
        }
    }
    add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    for normal in [Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y()] {
        add_plane(&mut model, normal * -half, normal, Motion::Still);
    }
    let motion = Motion::Servo { direction: DOWN, force, speed: 0.1 };
    let top = 6.2 * RADIUS;
    if mesh {
        add_sheet(&mut model, 3, 1.5 * half, top, 0.0, motion);
    } else {
        add_plane(&mut model, Vec3::z() * top, DOWN, motion);
    }
    model
}

/// Sum of what the spheres feel from above: the forces that floor and lid exchange.
fn floor_force(model: &Model, frame: &Frame) -> f64 {
    let low = model.spheres.iter().zip(&frame.centres).map(|(sphere, c)| sphere.radius - c.z);
    low.filter(|overlap| *overlap > 0.0).map(|overlap| KN * overlap).sum()
}

#[test]
fn a_lid_reaches_the_force_that_was_asked_for() {
    for (scheme, mesh) in
        [(Scheme::Leapfrog, false), (Scheme::Leapfrog, true), (Scheme::PathAveraged, false)]
    {
        let asked = 40.0;
        let mut model = press(scheme, asked, mesh);
        (model.plan.steps, model.plan.series_every) = (8_000, 200);
        let run = finish(&model);
        let end = run.series.last().expect("a row");
        assert!(end.kinetic < 1e-9, "{scheme:?} at rest {end:?}");
        let floor = floor_force(&model, run.frames.last().expect("a frame"));
        // Friction at the sides carries nothing that counts at rest in this regular stack.
        assert!((floor / asked - 1.0).abs() < 0.05, "{scheme:?} {mesh} {floor}");
        assert!(end.wall_work > 0.0);
        let note = &run.notes[0];
        let force: f64 = note.split(' ').nth(4).expect("a number").parse().expect("a number");
        assert!(note.starts_with("wall `wall5` pushes with "), "{note}");
        assert!((force / asked - 1.0).abs() < 1e-5, "{note}");
        for row in &run.series {
            assert!(row.missed().abs() < 0.03 * end.wall_work, "{scheme:?} {mesh} {row:?}");
        }
    }
}

#[test]
fn one_grain_between_floor_and_lid_carries_exactly_the_force() {
    let mut model = empty(Scheme::Leapfrog, contact(0.0, 10.0, 0.0, 0.0));
    add_sphere(&mut model, Vec3::z() * RADIUS, RADIUS, Vec3::zeros(), Vec3::zeros());
    add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    let motion = Motion::Servo { direction: DOWN, force: 15.0, speed: 0.05 };
    add_plane(&mut model, Vec3::z() * 2.1 * RADIUS, DOWN, motion);
    (model.plan.step, model.plan.steps) = (2e-5, 6_000);
    let run = finish(&model);
    let height = run.frames.last().expect("a frame").centres[0].z;
    assert!((KN * (RADIUS - height) / 15.0 - 1.0).abs() < 1e-9, "{}", KN * (RADIUS - height));
    // Work of the lid after it has met the grain: both springs; the rest went into dashpots.
    let end = run.series.last().expect("a row");
    assert!((end.elastic / (15.0f64.powi(2) / KN) - 1.0).abs() < 1e-8);
    assert!((end.wall_work - end.elastic - end.normal_dashpot).abs() < 1e-3 * end.wall_work);
}

/// Force of the first wall that says so in the notes, N.
fn noted(run: &Run) -> f64 {
    run.notes[0].split(' ').nth(4).expect("a number").parse().expect("a number")
}

#[test]
fn a_wet_grain_between_floor_and_lid_carries_the_force_and_its_own_pull() {
    let (asked, pull) = (15.0, 6.0);
    let linear = Cohesion::Linear { pull: Force(pull), range: Length(1e-3) };
    let forces = PairForces { cohesion: Some(linear), ..Default::default() };
    for scheme in [Scheme::Leapfrog, Scheme::PathAveraged] {
        for mesh in [false, true] {
            let mut model = empty(scheme, contact(0.0, 10.0, 0.0, 0.0));
            model.extra = Extra::uniform(1, forces);
            let place = Vec3::z() * (RADIUS - pull / KN);
            add_sphere(&mut model, place, RADIUS, Vec3::zeros(), Vec3::zeros());
            add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
            let motion = Motion::Servo { direction: DOWN, force: asked, speed: 0.05 };
            match mesh {
                true => add_sheet(&mut model, 2, 0.05, 2.15 * RADIUS, 0.0, motion),
                false => add_plane(&mut model, Vec3::z() * 2.15 * RADIUS, DOWN, motion),
            }
            (model.plan.step, model.plan.steps, model.plan.series_every) = (1e-5, 12_000, 100);
            let run = finish(&model);
            // kn δ − P = F at the lid, and so at the floor.
            let depth = RADIUS - run.frames.last().expect("a frame").centres[0].z;
            assert!((KN * depth / (asked + pull) - 1.0).abs() < 1e-8, "{scheme:?} {mesh} {depth}");
            assert!((noted(&run) / asked - 1.0).abs() < 1e-8, "{scheme:?} {mesh} {:?}", run.notes);
            let end = run.series.last().expect("a row");
            let right = (asked + pull).powi(2) / KN;
            assert!((end.elastic / right - 1.0).abs() < 1e-7, "{scheme:?} {mesh} {end:?}");
            for row in &run.series {
                assert!(row.missed().abs() < 1e-2 * right, "{scheme:?} {mesh} {row:?}");
            }
        }
    }
}

#[test]
fn a_lid_that_pulls_up_holds_a_hanging_grain_by_its_bridge() {
    let law =
        Bridge { surface_tension: SurfaceTension(0.072), volume: Volume(1e-9), angle: Angle(0.0) };
    let forces = PairForces { bridge: Some(law), ..Default::default() };
    let pull = 4.0 * std::f64::consts::PI * RADIUS * 0.072;
    for mesh in [false, true] {
        // Half of what the bridge holds.
        let weight = 0.5 * pull;
        let mut model = empty(Scheme::Leapfrog, contact(0.0, 10.0, 0.0, 0.0));
        model.extra = Extra::uniform(1, forces);
        model.gravity = DOWN * (weight / MASS);
        let place = DOWN * (RADIUS - 0.9 * pull / KN);
        add_sphere(&mut model, place, RADIUS, Vec3::zeros(), Vec3::zeros());
        let motion = Motion::Servo { direction: -DOWN, force: weight, speed: 0.05 };
        match mesh {
            true => add_sheet(&mut model, 2, 0.05, 0.0, 0.0, motion),
            false => add_plane(&mut model, Vec3::zeros(), DOWN, motion),
        }
        (model.plan.step, model.plan.steps) = (1e-5, 6_000);
        let run = finish(&model);
        let travel: f64 = run.notes[0].rsplit(' ').nth(1).expect("m").parse().expect("a number");
        let depth = RADIUS - (travel - run.frames.last().expect("a frame").centres[0].z);
        assert!((noted(&run) / weight - 1.0).abs() < 1e-6, "{mesh} {:?}", run.notes);
        assert!((KN * depth / (pull - weight) - 1.0).abs() < 1e-5, "{mesh} {depth}");
    }
}

#[test]
fn a_lid_on_wet_grains_reaches_the_force_that_was_asked_for() {
    let bridge =
        Bridge { surface_tension: SurfaceTension(0.5), volume: Volume(1e-9), angle: Angle(0.1) };
    let repulsion = BornMayer {
        strength: Energy(2e-4),
        decay: Length(2e-4),
        cutoff: Length(2e-3),
        cut: CutOff::ShiftedForce,
    };
    let asked = 20.0;
    for mesh in [false, true] {
        let mut model = press(Scheme::Leapfrog, asked, mesh);
        let born_mayer = Some(repulsion);
        let forces = PairForces { bridge: Some(bridge), born_mayer, ..Default::default() };
        model.extra = Extra::uniform(1, forces);
        // Repulsion has no dashpots.
        model.local_damping = 0.4;
        (model.plan.steps, model.plan.series_every) = (10_000, 200);
        let run = finish(&model);
        assert!((noted(&run) / asked - 1.0).abs() < 1e-4, "{mesh} {:?}", run.notes);
        let end = run.series.last().expect("a row");
        assert!(end.kinetic < 1e-3 * end.wall_work && end.wetting > 0.0, "{mesh} {end:?}");
        for row in &run.series {
            assert!(row.missed().abs() < 0.03 * end.wall_work, "{mesh} {row:?}");
        }
    }
}

#[test]
fn contacts_with_a_servo_wall_count_four_thirds_in_the_step_limit() {
    // Floor and lid, no dashpots: λ = (1 + 4/3) kn/m.
    let limit = 2.0 / (7.0 / 3.0 * KN / MASS).sqrt();
    let (overlap, nudge) = (1e-3 * RADIUS, 1e-6 * RADIUS);
    let off = |part: f64| {
        let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
        let place = RADIUS - overlap;
        add_sphere(&mut model, Vec3::z() * place, RADIUS, Vec3::zeros(), Vec3::zeros());
        add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
        let motion = Motion::Servo { direction: DOWN, force: KN * overlap, speed: 5.0 };
        add_plane(&mut model, Vec3::z() * (place + RADIUS - overlap - nudge), DOWN, motion);
        assert!((advise(&model).network.expect("contacts") / limit - 1.0).abs() < 1e-3);
        (model.plan.step, model.plan.steps, model.plan.insist) = (part * limit, 3_000, true);
        model.plan.guard =
            Guard { gain: 0.0, overlap: 0.0, travel: 0.0, shaking: 0.0, ..Guard::default() };
        let run = finish(&model);
        (run.frames.last().expect("a frame").centres[0].z - place).abs()
    };
    assert!(off(0.99) < 1e-6 * nudge, "{:e}", off(0.99));
    assert!(off(1.01) > 10.0 * nudge, "{:e}", off(1.01));
}

#[test]
fn dashpots_do_not_make_a_servo_wall_swing() {
    // A wall that answered to the dashpot would swing by c/(2 kn Δt) = 25 a step.
    let mut model = empty(Scheme::Leapfrog, contact(0.0, 25.0, 0.0, 0.0));
    add_sphere(&mut model, Vec3::z() * RADIUS, RADIUS, Vec3::zeros(), Vec3::zeros());
    add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    let motion = Motion::Servo { direction: DOWN, force: 15.0, speed: 0.05 };
    add_plane(&mut model, Vec3::z() * 2.01 * RADIUS, DOWN, motion);
    (model.plan.step, model.plan.steps, model.plan.series_every) = (5e-6, 20_000, 1);
    let run = finish(&model);
    let work: Vec<f64> = run.series.iter().map(|row| row.wall_work).collect();
    let falls = work.windows(2).filter(|w| w[1] < w[0] * (1.0 - 1e-6)).count();
    assert!(falls < 1_000, "{falls} steps of the lid away from the sphere");
    for row in &run.series {
        assert!(row.missed().abs() < 1e-2 * work[work.len() - 1], "{row:?}");
    }
}

#[test]
fn a_servo_goes_on_from_a_checkpoint_as_if_nothing_had_been() {
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
    let mut model = press(Scheme::Leapfrog, 40.0, true);
    (model.plan.steps, model.plan.checkpoint_every) = (600, 400);
    let mut whole = Keep(Vec::new(), None);
    simulate(&model, None, &Job::quiet(), &mut whole).expect("it runs");
    let mut rest = Keep(Vec::new(), None);
    simulate(&model, Some(&whole.0[0]), &Job::quiet(), &mut rest).expect("it goes on");
    assert_eq!(whole.1, rest.1);
}

#[test]
fn a_slow_oscillation_is_a_translation_and_a_fast_one_follows_its_sine() {
    for scheme in [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Yade, Scheme::PathAveraged] {
        for mesh in [false, true] {
            let hit = |motion: Motion| {
                let mut model = empty(scheme, contact(0.0, 2.0, 0.0, 0.0));
                model.plan.step = 1e-5;
                model.plan.steps = 300;
                add_sphere(
                    &mut model,
                    // They meet within a step, not at the end of one, where a rounding error decides.
                    Vec3::z() * 1.0203 * RADIUS,
                    RADIUS,
                    Vec3::zeros(),
                    Vec3::zeros(),
                );
                if mesh {
                    add_sheet(&mut model, 2, 0.05, 0.0, 0.0, motion);
                } else {
                    add_plane(&mut model, Vec3::zeros(), Vec3::z(), motion);
                }
                let frame = finish(&model).frames.pop().expect("a frame");
                frame.velocities[0].z
            };
            let steady = hit(Motion::Translate { velocity: Vec3::z() * 0.4 });
            let frequency = 1e-4;
            let amplitude = Vec3::z() * (0.4 / (std::f64::consts::TAU * frequency));
            let slow = hit(Motion::Oscillate { amplitude, frequency, phase: 0.0 });
            assert!(steady > 0.6 && (slow / steady - 1.0).abs() < 1e-9, "{scheme:?} {mesh} {slow}");
            // A quarter of a period in 3 ms: the wall is faster at first and slower at the end.
            let frequency = 1.0 / 12e-3;
            let amplitude = Vec3::z() * (0.4 / (std::f64::consts::TAU * frequency));
            let bent = hit(Motion::Oscillate { amplitude, frequency, phase: 0.0 });
            assert!(bent < steady * (1.0 - 1e-3), "{scheme:?} {mesh} {bent} {steady}");
        }
    }
}
