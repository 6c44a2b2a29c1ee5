//! Gravity between bodies and free rotation in the whole solver: orbits and tops with known
//! solutions, a cloud that falls together.

use super::test_scenes::*;
use super::*;
use crate::model::*;
use crate::num::random;
use crate::num::units::Length;
use crate::num::{Rotation, Vec3};
use nalgebra::{Quaternion, Unit};
use std::f64::consts::PI;

fn law(constant: f64, method: FarMethod) -> Option<MutualGravity> {
    Some(MutualGravity { constant, method, softening: Length(0.0) })
}

/// Masses 1 and 3 kg, G = 1, semi-major axis 1, period π, from pericentre.
fn orbit(scheme: Scheme, eccentricity: f64, steps: u64, duration: f64) -> Model {
    let mut model = empty(scheme, contact(0.0, 0.0, 0.0, 0.0));
    model.domain = crate::geometry::Bounds { low: Vec3::repeat(-5.0), high: Vec3::repeat(5.0) };
    model.mutual = law(1.0, FarMethod::AllPairs);
    (model.plan.step, model.plan.steps, model.plan.insist) = (duration / steps as f64, steps, true);
    let place = Vec3::x() * (1.0 - eccentricity);
    let velocity = Vec3::y() * (4.0 * (1.0 + eccentricity) / (1.0 - eccentricity)).sqrt();
    for (mass, part) in [(1.0, 0.75), (3.0, -0.25)] {
        add_sphere(&mut model, place * part, 1e-3, velocity * part, Vec3::zeros());
        model.bodies.last_mut().expect("just added").mass = mass;
    }
    model
}

/// Place of the first body seen from the second.
fn relative(frame: &Frame) -> Vec3 {
    frame.centres[0] - frame.centres[1]
}

#[test]
fn orbits_are_those_of_kepler() {
    // Place at a tenth of the period (Kepler's equation, 50 digits).
    let known = [
        (0.0, Vec3::new(0.809_016_994_374_947_4, 0.587_785_252_292_473_1, 0.0), 1e-4),
        (0.5, Vec3::new(-0.016_318_902_361_279_414, 0.757_983_803_811_303, 0.0), 1e-4),
        (0.9, Vec3::new(-0.856_691_318_975_017_5, 0.435_480_915_825_362_5, 0.0), 3e-3),
    ];
    for scheme in [Scheme::Leapfrog, Scheme::Liggghts, Scheme::PathAveraged] {
        for (eccentricity, place, bound) in known {
            let error = |steps: u64| {
                let run = finish(&orbit(scheme, eccentricity, steps, 0.1 * PI));
                (relative(run.frames.last().expect("a last frame")) - place).norm()
            };
            let (coarse, fine) = (error(400), error(800));
            assert!(coarse < bound, "{scheme:?} {eccentricity} {coarse:e}");
            assert!((coarse / fine - 4.0).abs() < 0.3, "{scheme:?} {coarse:e} {fine:e}");
        }
    }
}

#[test]
fn ten_periods_of_a_thousand_steps() {
    // Error of the place after ten periods and largest relative error of the energy, of
    // independent implementations of kick-drift-kick and drift-kick-drift.
    let known = [
        (Scheme::Leapfrog, 1.769_4e-2, 1.073_0e-4),
        (Scheme::PathAveraged, 4.801_1e-3, 2.534_1e-5),
    ];
    for (scheme, place, energy) in known {
        let mut model = orbit(scheme, 0.5, 10_000, 10.0 * PI);
        model.plan.series_every = 5;
        let run = finish(&model);
        let error = (relative(run.frames.last().expect("a last frame")) - Vec3::x() * 0.5).norm();
        assert!((error / place - 1.0).abs() < 1e-3, "{scheme:?} {error:e}");
        let worst = run.series.iter().map(|row| row.missed().abs() / 1.5).fold(0.0, f64::max);
        assert!((worst / energy - 1.0).abs() < 1e-3, "{scheme:?} {worst:e}");
        let momentum = run.series.iter().map(|row| row.momentum).fold(0.0, f64::max);
        assert!(momentum < 1e-12, "{momentum:e}");
    }
}

/// A body of two spheres with these moments of inertia, turning freely.
fn top(scheme: Scheme, inertia: Vec3, spin: Vec3, steps: u64, duration: f64) -> Run {
    let mut model = empty(scheme, contact(0.0, 0.0, 0.0, 0.0));
    for side in [-1.0, 1.0] {
        let offset = Vec3::x() * side * RADIUS;
        model.spheres.push(Sphere { offset, radius: RADIUS, body: 0 });
    }
    let body = Body::sphere(Dimension::Three, Vec3::zeros(), RADIUS, DENSITY, 0, 0);
    model.bodies.push(Body { inertia, spin, mass: 1.0, sphere_count: 2, ..body });
    (model.plan.step, model.plan.steps, model.plan.insist) = (duration / steps as f64, steps, true);
    model.plan.frame_every = steps / 20;
    finish(&model)
}

#[test]
fn free_tops_follow_their_solutions_at_second_order() {
    // Orientations at the end (Taylor series, 25 digits).
    let cases = [
        (
            Vec3::new(1.0, 2.0, 3.0),
            Vec3::new(1.0, 0.5, -0.7),
            20.0,
            [
                -0.593_371_402_375_948_5,
                0.037_617_559_756_284_13,
                -0.454_108_719_737_076_9,
                0.663_536_410_982_197_3,
            ],
            2000,
            4e-4,
        ),
        (
            Vec3::new(0.01, 1.0, 1.005),
            Vec3::new(5.0, 0.3, 0.2),
            10.0,
            [
                -0.178_983_951_692_425_28,
                0.213_692_417_772_817_67,
                0.545_794_423_342_901_7,
                0.790_195_383_149_369_8,
            ],
            2000,
            5e-3,
        ),
    ];
    for (inertia, spin, duration, [w, x, y, z], steps, bound) in cases {
        let exact = Unit::new_normalize(Quaternion::new(w, x, y, z));
        for scheme in [Scheme::Leapfrog, Scheme::Liggghts, Scheme::PathAveraged] {
            let error = |steps: u64| {
                let run = top(scheme, inertia, spin, steps, duration);
                let momentum = |frame: &Frame| {
                    turn::momentum(&frame.bodies[0].orientation, &inertia, &frame.bodies[0].spin)
                };
                let start = momentum(&run.frames[0]);
                for frame in &run.frames {
                    let change = (momentum(frame) - start).norm() / start.norm();
                    assert!(change < 1e-12, "{scheme:?} {change:e}");
                }
                run.frames.last().expect("a last frame").bodies[0].orientation.angle_to(&exact)
            };
            let (coarse, fine) = (error(steps), error(2 * steps));
            assert!(coarse < bound, "{scheme:?} {coarse:e}");
            assert!((coarse / fine - 4.0).abs() < 0.7, "{scheme:?} {coarse:e} {fine:e}");
        }
    }
}

/// Grains at random in a ball, at rest.
fn cloud(count: usize, radius: f64, constant: f64, method: FarMethod) -> Model {
    let mut model = empty(Scheme::Leapfrog, contact(0.0, 25.0, 0.0, 0.0));
    model.mutual = law(constant, method);
    model.plan.step = 2e-5;
    let mut source = random::stream(8, "cloud", 0);
    while model.bodies.len() < count {
        let place = Vec3::from_fn(|_, _| random::uniform(&mut source, -radius, radius));
        let free = model.bodies.iter().all(|body| (body.position - place).norm() > 2.0 * RADIUS);
        if place.norm() < radius && free {
            add_sphere(&mut model, place, RADIUS, Vec3::zeros(), Vec3::zeros());
        }
    }
    model
}

#[test]
fn a_cloud_falls_together_and_its_energy_is_accounted_for() {
    let mut model = cloud(40, 0.08, 0.2, FarMethod::AllPairs);
    (model.plan.steps, model.plan.series_every) = (15_000, 500);
    let run = finish(&model);
    let end = run.series.last().expect("a last row");
    let released = -end.gravitational;
    assert!(released > 0.0 && end.contacts > 10, "{end:?}");
    assert!(end.kinetic < 0.05 * released && end.normal_dashpot > 0.9 * released, "{end:?}");
    for row in &run.series {
        assert!(row.missed().abs() < 3e-3 * released, "{row:?}");
        assert!(row.momentum < 1e-14, "{row:?}");
    }
}

#[test]
fn the_tree_at_any_number_of_threads_and_close_to_all_pairs() {
    let tree = FarMethod::Tree(TreeParameters { theta: 0.5, quadrupole: true });
    let ends: Vec<Run> = [(tree, 1), (tree, 3), (FarMethod::AllPairs, 1), (FarMethod::AllPairs, 2)]
        .into_iter()
        .map(|(method, threads)| {
            let mut model = cloud(300, 0.15, 0.05, method);
            add_clump(&mut model, Vec3::x() * 0.3, Rotation::identity(), Vec3::zeros(), Vec3::z());
            model.plan.steps = 20;
            let mut job = Job::quiet();
            job.threads = threads;
            super::run(&model, &job).expect("a usable model")
        })
        .collect();
    assert_eq!((&ends[0].frames, &ends[0].series), (&ends[1].frames, &ends[1].series));
    assert_eq!((&ends[2].frames, &ends[2].series), (&ends[3].frames, &ends[3].series));
    let speeds = |run: &Run| run.frames[1].bodies.iter().map(|b| b.velocity).collect::<Vec<_>>();
    let (near, exact) = (speeds(&ends[0]), speeds(&ends[2]));
    let wrong: f64 = near.iter().zip(&exact).map(|(a, b)| (a - b).norm_squared()).sum();
    let whole: f64 = exact.iter().map(|v| v.norm_squared()).sum();
    assert!((wrong / whole).sqrt() < 1e-3 && wrong > 0.0, "{}", (wrong / whole).sqrt());
    // The clump is pulled as one body and not turned.
    let clump = ends[2].frames[1].bodies.last().expect("the clump");
    assert!(clump.velocity.x < 0.0 && (clump.spin - Vec3::z()).norm() < 1e-3);
}

#[test]
fn two_dimensions_stay_in_their_plane_and_local_damping_acts_on_the_pull() {
    let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
    model.dimension = Dimension::Two;
    model.mutual = law(0.01, FarMethod::default());
    model.local_damping = 0.2;
    for x in [-0.1, 0.1] {
        add_sphere(&mut model, Vec3::x() * x, RADIUS, Vec3::zeros(), Vec3::zeros());
    }
    model.plan.steps = 1;
    let run = finish(&model);
    let pull = 0.01 * model.bodies[0].mass / 0.04;
    let velocity = run.frames[1].bodies[0].velocity;
    // The first force pass kicks half a step, the second the other half.
    assert!((velocity.x / (0.8 * pull * 1e-6) - 1.0).abs() < 1e-9 && velocity.z == 0.0);
}
