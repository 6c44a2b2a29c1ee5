//! Closed forms and invariants that every scheme has to meet.

use super::test_scenes::*;
use super::*;
use crate::model::*;
use crate::num::statistics::order_of_convergence;
use crate::num::{Rotation, Vec3};

const SCHEMES: [Scheme; 3] = [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Yade];
const ALL: [Scheme; 4] = [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Yade, Scheme::PathAveraged];

fn last(run: &Run) -> &Frame {
    run.frames.last().expect("a last frame")
}

/// A sphere thrown down at 1 m/s onto a plane at z = 0; arrives after `phase` of a step.
fn drop(scheme: Scheme, cn: f64, tension: bool, per_contact: f64, phase: f64) -> Model {
    let mut model = empty(scheme, contact(0.0, cn, 0.0, 0.0));
    let time = std::f64::consts::PI * (MASS / KN).sqrt();
    model.plan.step = time / per_contact;
    model.plan.law.tension = tension;
    model.plan.steps = (2.0 * per_contact) as u64;
    let height = RADIUS + model.plan.step * phase;
    add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    add_sphere(&mut model, Vec3::z() * height, RADIUS, -Vec3::z(), Vec3::zeros());
    model
}

/// Largest error of the restitution over phases of arrival.
fn restitution_error(scheme: Scheme, cn: f64, tension: bool, e: f64, per_contact: f64) -> f64 {
    (0..8)
        .map(|i| {
            let model = drop(scheme, cn, tension, per_contact, (f64::from(i) + 0.5) / 8.0);
            (last(&finish(&model)).velocities[0].z - e).abs()
        })
        .fold(0.0, f64::max)
}

#[test]
fn normal_impact_converges_to_the_closed_form() {
    // Restitution 0.5: c of the clipped and of the full law (closed forms, 50 digits).
    let cases = [(16.521_659_763_426_72, false), (13.944_353_573_042_41, true)];
    for scheme in SCHEMES {
        for (cn, tension) in cases {
            let steps = [50.0, 100.0, 200.0];
            let errors = steps.map(|n| restitution_error(scheme, cn, tension, 0.5, n));
            assert!(errors[1] < 8e-3, "{scheme:?} {tension} {errors:?}");
            let order =
                order_of_convergence(&steps.map(|n| 1.0 / n), &errors).expect("three points");
            assert!((0.8..1.4).contains(&order), "{scheme:?} {tension} {order} {errors:?}");
        }
        assert!(restitution_error(scheme, 0.0, false, 1.0, 100.0) < 2e-5);
    }
}

#[test]
fn dashpot_of_the_full_law_gives_more_under_clipping() {
    // e = 0.5 asked for with the formula of the full law: 0.55028317 (closed form).
    assert!(
        restitution_error(Scheme::Liggghts, 13.944_353_573_042_41, false, 0.550_283_17, 400.0)
            < 2e-3
    );
}

#[test]
fn contact_lasts_as_long_as_it_should() {
    let mut model = drop(Scheme::Leapfrog, 0.0, false, 1000.0, 0.0);
    model.plan.series_every = 1;
    let run = finish(&model);
    let touching = run.series.iter().filter(|row| row.contacts > 0).count() as f64;
    let time = touching * model.plan.step;
    assert!((time - 1.016_632_950_484_093_8e-3).abs() < 2.0 * model.plan.step, "{time}");
    let deepest = run.series.iter().map(|row| row.worst_overlap * RADIUS).fold(0.0, f64::max);
    assert!((deepest - 3.236_043_187_592_832e-4).abs() < 1e-8, "{deepest}");
}

/// Oblique impact on a wall at 1 m/s, `degrees` from the normal, μ = 0.3: outgoing v_t and ω.
fn oblique(scheme: Scheme, arm: Arm, kt: f64, degrees: f64, per_contact: f64) -> (f64, f64) {
    let mut model = empty(scheme, contact(kt * KN, 0.0, 0.0, 0.3));
    model.plan.law.plane_arm = arm;
    model.plan.step = std::f64::consts::PI * (MASS / KN).sqrt() / per_contact;
    model.plan.steps = (1.5 * per_contact) as u64;
    let angle = degrees.to_radians();
    let velocity = Vec3::new(angle.sin(), 0.0, -angle.cos());
    add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    add_sphere(&mut model, Vec3::z() * RADIUS, RADIUS, velocity, Vec3::zeros());
    let run = finish(&model);
    (last(&run).velocities[0].x, last(&run).spins[0].y)
}

#[test]
fn oblique_impact_converges_to_the_reference() {
    // Lever arm R − δ/2, elastic (Runge–Kutta with bisected events): kt/kn, angle, v_t, ω.
    let rows = [
        (2.0 / 7.0, 15.0, 0.108_334_917_516_876_74, 37.161_057_359_684_06),
        (2.0 / 7.0, 45.0, 0.298_523_059_430_626, 101.229_504_846_104_79),
        (0.8, 30.0, 0.307_671_652_509_001, 47.464_178_641_256_8),
        (2.0 / 7.0, 75.0, 0.810_634_399_227_557_6, 38.695_166_463_152_45),
    ];
    for scheme in ALL {
        for (kt, angle, slide, spin) in rows {
            let (v, w) = oblique(scheme, Arm::Half, kt, angle, 2000.0);
            assert!((v - slide).abs() < 3e-4, "{scheme:?} {angle} {v} {slide}");
            assert!((w - spin).abs() < 0.05, "{scheme:?} {angle} {w} {spin}");
        }
    }
    // Lever arm R − δ.
    let (v, w) = oblique(Scheme::Yade, Arm::Full, 2.0 / 7.0, 30.0, 2000.0);
    assert!((v - 0.205_448_129_194_573_64).abs() < 3e-4, "{v}");
    assert!((w - 72.027_817_217_445_63).abs() < 0.05, "{w}");
}

#[test]
fn sliding_turns_into_rolling() {
    for scheme in ALL {
        let mut model = empty(scheme, contact(0.3 * KN, 10.0, 6.0, 0.3));
        model.gravity = Vec3::z() * -9.81;
        model.plan.step = 1e-5;
        model.plan.steps = 15_000;
        let depth = MASS * 9.81 / KN;
        add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
        add_sphere(&mut model, Vec3::z() * (RADIUS - depth), RADIUS, Vec3::x(), Vec3::zeros());
        model.domain.high.x = 2.0;
        let run = finish(&model);
        let (v, w) = (last(&run).velocities[0].x, last(&run).spins[0].y);
        let arm = RADIUS - if model.plan.law.plane_arm == Arm::Half { 0.5 } else { 1.0 } * depth;
        let invariant = v + 0.4 * RADIUS * RADIUS / arm * w;
        assert!((invariant - 1.0).abs() < 1e-8, "{scheme:?} {invariant}");
        assert!((v - 5.0 / 7.0).abs() < 1e-3, "{scheme:?} {v}");
        assert!((v - w * arm).abs() < 1e-3, "{scheme:?}");
    }
}

#[test]
fn clump_keeps_its_angular_momentum_exactly_in_free_flight() {
    let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
    let spin = Vec3::new(300.0, 100.0, -200.0);
    add_clump(&mut model, Vec3::zeros(), Rotation::identity(), Vec3::zeros(), spin);
    model.plan.step = 1e-4;
    model.plan.steps = 1000;
    let run = finish(&model);
    let momentum = |state: &BodyState| {
        turn::momentum(&state.orientation, &model.bodies[0].inertia, &state.spin)
    };
    let (first, end) = (momentum(&run.frames[0].bodies[0]), momentum(&last(&run).bodies[0]));
    assert!((first - end).norm() < 1e-13 * first.norm());
    let (before, after) = (run.frames[0].kinetic_energy(&model), last(&run).kinetic_energy(&model));
    assert!((after / before - 1.0).abs() < 1e-3);
}

#[test]
fn momentum_is_conserved() {
    for scheme in ALL {
        let mut model = mixed(scheme, Dimension::Three, true, false, 3);
        model.walls.clear();
        model.gravity = Vec3::zeros();
        model.plan.steps = 800;
        let run = finish(&model);
        let total = |frame: &Frame| -> Vec3 {
            frame.bodies.iter().zip(&model.bodies).map(|(s, b)| s.velocity * b.mass).sum()
        };
        let angular = |frame: &Frame| -> Vec3 {
            frame
                .bodies
                .iter()
                .zip(&model.bodies)
                .map(|(s, b)| {
                    s.position.cross(&(s.velocity * b.mass))
                        + turn::momentum(&s.orientation, &b.inertia, &s.spin)
                })
                .sum()
        };
        let scale: f64 = model.bodies.iter().map(|b| b.mass * b.velocity.norm()).sum();
        let change = total(&run.frames[0]) - total(last(&run));
        assert!(change.norm() < 1e-13 * scale, "{scheme:?} {change}");
        if matches!(scheme, Scheme::Leapfrog | Scheme::PathAveraged) {
            let change = angular(&run.frames[0]) - angular(last(&run));
            assert!(change.norm() < 1e-12 * scale * RADIUS, "{change}");
        }
    }
}

/// Largest energy residual over the energy at the start, at `per` steps a contact.
fn residual(scheme: Scheme, clumps: bool, mesh: bool, per: f64) -> f64 {
    let mut model = mixed(scheme, Dimension::Three, clumps, mesh, 7);
    let time = std::f64::consts::PI * (0.5 * MASS / KN).sqrt();
    model.plan.step = time / per;
    model.plan.steps = (0.02 / model.plan.step) as u64;
    model.plan.series_every = (model.plan.steps / 40).max(1);
    let run = finish(&model);
    let energy = run.series[0].kinetic + run.series[0].elastic;
    let end = run.series.last().expect("rows");
    assert!(end.slip > 0.005 * energy && end.normal_dashpot > 0.05 * energy, "{end:?}");
    run.series.iter().map(|row| row.missed().abs()).fold(0.0, f64::max) / energy
}

#[test]
fn energy_balance_closes_with_the_step() {
    for scheme in ALL {
        let (coarse, fine) =
            (residual(scheme, false, false, 25.0), residual(scheme, false, false, 200.0));
        assert!(coarse < 4e-2 && fine < coarse / 20.0, "{scheme:?} {coarse} {fine}");
    }
    for scheme in [Scheme::Leapfrog, Scheme::PathAveraged] {
        let (coarse, fine) =
            (residual(scheme, true, true, 25.0), residual(scheme, true, true, 200.0));
        assert!(coarse < 4e-2 && fine < coarse / 20.0, "{scheme:?} {coarse} {fine}");
    }
}

#[test]
fn local_damping_is_accounted_for() {
    for scheme in ALL {
        let mut model = mixed(scheme, Dimension::Three, true, false, 9);
        model.local_damping = 0.3;
        model.plan.step = 5e-6;
        model.plan.steps = 3000;
        let run = finish(&model);
        let row = run.series.last().expect("rows");
        let energy = run.series[0].kinetic + run.series[0].elastic;
        assert!(row.local_damping > 0.1 * energy);
        assert!(row.missed().abs() < 2e-3 * energy, "{scheme:?} {row:?}");
    }
}

#[test]
fn mesh_plane_equals_plane() {
    for scheme in ALL {
        let make = |mesh: bool| {
            let mut model = empty(scheme, contact(0.3 * KN, 8.0, 3.0, 0.4));
            model.plan.law.plane_arm = Arm::Half;
            model.gravity = Vec3::z() * -9.81;
            model.plan.step = 1e-5;
            model.plan.steps = 6000;
            if mesh {
                add_sheet(&mut model, 7, 0.2, 0.0, 0.0, Motion::Still);
            } else {
                add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
            }
            let velocity = Vec3::new(0.7, 0.4, -0.3);
            add_sphere(
                &mut model,
                Vec3::new(-0.08, -0.05, 0.0101),
                RADIUS,
                velocity,
                Vec3::y() * 20.0,
            );
            model
        };
        let (plane, mesh) = (finish(&make(false)), finish(&make(true)));
        let difference = (last(&plane).centres[0] - last(&mesh).centres[0]).norm();
        assert!(last(&plane).centres[0].x > -0.05);
        assert!(difference < 1e-11, "{scheme:?} {difference}");
    }
}

/// Spheres of a lattice in contact, for the stability bound.
fn lattice(kt: f64, places: &[Vec3]) -> Model {
    let mut model = empty(Scheme::Leapfrog, contact(kt * KN, 0.0, 0.0, 1.0));
    for place in places {
        add_sphere(&mut model, place * RADIUS, RADIUS, Vec3::zeros(), Vec3::zeros());
    }
    model.domain = crate::geometry::Bounds { low: Vec3::repeat(-9.0), high: Vec3::repeat(9.0) };
    model
}

#[test]
fn stability_bound_is_never_above_the_true_limit() {
    let unit = (MASS / KN).sqrt();
    let kts = [0.0, 2.0 / 7.0, 0.5, 0.8, 1.0, 2.0];
    let grid = |n: i32| {
        (0..n * n * n).map(move |i| {
            2.0 * Vec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n))
        })
    };
    let cubic: Vec<Vec3> = grid(4).collect();
    let root = std::f64::consts::SQRT_2;
    let fcc: Vec<Vec3> = grid(3)
        .flat_map(|p| {
            [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 0.0, 1.0), (0.0, 1.0, 1.0)]
                .map(|(x, y, z)| (p / 2.0 * 2.0 + Vec3::new(x, y, z)) * root)
        })
        .collect();
    // Limits in units of √(m/kn) of infinite lattices and of a pair (eigenvalues).
    let cases: [(&str, Vec<Vec3>, [f64; 6], f64); 3] = [
        (
            "pair",
            vec![Vec3::zeros(), Vec3::x() * 2.0],
            [1.414, 1.414, 1.069, 0.845, 0.756, 0.535],
            0.70,
        ),
        ("cubic", cubic, [1.052, 0.831, 0.654, 0.517, 0.463, 0.327], 0.8),
        ("face-centred", fcc, [0.732, 0.610, 0.461, 0.364, 0.326, 0.230], 0.8),
    ];
    for (name, places, limits, least) in cases {
        for (kt, limit) in kts.iter().zip(limits) {
            let advice = advise(&lattice(*kt, &places));
            let bound = advice.network.expect("contacts") / unit;
            assert!(bound < limit * 1.002, "{name} {kt} {bound} {limit}");
            assert!(bound > least * limit, "{name} {kt} {bound} {limit}");
            if places.len() > 20 {
                let packed = advice.packed / unit;
                assert!(packed < limit * 1.002, "{name} {kt} {packed} {limit}");
            }
        }
    }
}
