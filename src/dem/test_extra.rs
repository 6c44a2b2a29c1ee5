//! Attraction, rolling resistance and drag against closed forms and invariants.

use super::test_scenes::*;
use super::*;
use crate::model::extra::*;
use crate::model::*;
use crate::num::Vec3;
use crate::num::statistics::order_of_convergence;
use crate::num::units::{Angle, Energy, EnergyDensity, Force, Length, SurfaceTension, Volume};
use std::f64::consts::{PI, TAU};

fn last(run: &Run) -> &Frame {
    run.frames.last().expect("a frame")
}

fn with(forces: PairForces) -> Extra {
    Extra::uniform(1, forces)
}

/// Two spheres of the unit case on the x axis, `distance` apart, moving at ±`velocity`.
fn two(scheme: Scheme, forces: PairForces, distance: f64, velocity: Vec3) -> Model {
    let mut model = empty(scheme, contact(0.0, 0.0, 0.0, 0.0));
    model.extra = with(forces);
    let place = Vec3::x() * (0.5 * distance);
    add_sphere(&mut model, place, RADIUS, velocity, Vec3::zeros());
    add_sphere(&mut model, -place, RADIUS, -velocity, Vec3::zeros());
    model
}

#[test]
fn lennard_jones_pairs_swing_at_their_frequency() {
    let law = LennardJones {
        depth: Energy(1e-2),
        size: Length(0.05),
        cutoff: Length(0.3),
        cut: CutOff::ShiftedPotential,
    };
    let forces = PairForces { lennard_jones: Some(law), ..Default::default() };
    // U'' = 72 ε/(2^(1/3) σ²) at 2^(1/6) σ, reduced mass m/2.
    let bottom = 2f64.powf(1.0 / 6.0) * 0.05;
    let stiffness = 72.0 * 1e-2 / (2f64.powf(1.0 / 3.0) * 0.05 * 0.05);
    let period = TAU / (2.0 * stiffness / MASS).sqrt();
    for scheme in [Scheme::Leapfrog, Scheme::PathAveraged] {
        let mut model = two(scheme, forces, bottom + 1e-7, Vec3::zeros());
        // A quarter period: at the bottom, if the frequency is right.
        let steps = [50u64, 100, 200];
        let errors = steps.map(|count| {
            model.plan.steps = count;
            model.plan.step = 0.25 * period / count as f64;
            let end = last(&finish(&model)).centres.clone();
            ((end[0] - end[1]).norm() - bottom).abs() / 1e-7
        });
        // The well is not quite a parabola: some 1e-5 of the amplitude.
        assert!(errors[0] < 1e-4 && errors[2] < 2e-5, "{scheme:?} {errors:?}");
    }
}

#[test]
fn opposite_charges_circle_each_other() {
    let (charge, distance) = (1e-6f64, 0.2f64);
    for scheme in [Scheme::Leapfrog, Scheme::PathAveraged] {
        let steps = [400u64, 800, 1600];
        let errors = steps.map(|count| {
            let force = attraction::COULOMB * charge * charge / distance.powi(2);
            let speed = (force * 0.5 * distance / MASS).sqrt();
            let mut model = two(scheme, PairForces::default(), distance, Vec3::y() * speed);
            model.materials.push(Material { name: "other".to_owned(), density: DENSITY });
            model.contacts = ContactTable::uniform(2, *model.contacts.between(0, 0));
            model.bodies[1].material = 1;
            let field = Electrostatics {
                cutoff: Length(1.0),
                permittivity: 1.0,
                cut: CutOff::ShiftedPotential,
            };
            model.extra.charges = Some(Charges { of_material: vec![charge, -charge], field });
            // They never touch.
            model.plan.insist = true;
            model.plan.steps = count;
            model.plan.step = TAU * 0.5 * distance / speed / count as f64;
            let run = finish(&model);
            (last(&run).centres[0] - run.frames[0].centres[0]).norm() / distance
        });
        let spans = steps.map(|count| 1.0 / count as f64);
        let order = order_of_convergence(&spans, &errors).expect("three points");
        assert!(order > 1.9 && errors[2] < 1e-4, "{scheme:?} {errors:?} {order}");
    }
}

fn bridge(volume: f64) -> Bridge {
    Bridge { surface_tension: SurfaceTension(0.072), volume: Volume(volume), angle: Angle(0.2) }
}

/// Work to pull a bridge apart from contact, J.
fn bridge_work(law: &Bridge, second: f64) -> f64 {
    let reduced = if second.is_finite() { 0.5 * RADIUS } else { RADIUS };
    let (steps, end) = (200_000, law.rupture());
    let force = |gap: f64| {
        let s = 0.5 * gap * (2.0 * reduced / law.volume.0).sqrt();
        4.0 * PI * reduced * 0.072 * law.angle.0.cos() / (1.0 + 2.1 * s + 10.0 * s * s)
    };
    let mid = |i: u32| force((f64::from(i) + 0.5) / f64::from(steps) * end);
    (0..steps).map(mid).sum::<f64>() * end / f64::from(steps)
}

#[test]
fn bridges_hold_below_their_work_and_break_above_it() {
    let law = bridge(1e-9);
    let forces = PairForces { bridge: Some(law), ..Default::default() };
    for second in [RADIUS, f64::INFINITY] {
        let work = bridge_work(&law, second);
        let mass = if second.is_finite() { 0.5 * MASS } else { MASS };
        for (factor, breaks) in [(0.8, false), (1.5, true)] {
            let relative = (2.0 * factor * work / mass).sqrt();
            let mut model = if second.is_finite() {
                two(Scheme::Leapfrog, forces, 2.0 * RADIUS - 1e-12, Vec3::x() * (0.5 * relative))
            } else {
                let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
                model.extra = with(forces);
                add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
                let place = Vec3::z() * (RADIUS - 1e-12);
                add_sphere(&mut model, place, RADIUS, Vec3::z() * relative, Vec3::zeros());
                model
            };
            model.plan.step = 2e-5;
            model.plan.steps = if breaks { 10_000 } else { 2000 };
            let run = finish(&model);
            let end = last(&run);
            let moved = if second.is_finite() {
                (end.centres[0] - end.centres[1]).norm() - 2.0 * RADIUS
            } else {
                end.centres[0].z - RADIUS
            };
            assert_eq!(moved > law.rupture(), breaks, "{second} {factor} {moved}");
            if breaks {
                let speed = if second.is_finite() {
                    (end.velocities[0] - end.velocities[1]).norm()
                } else {
                    end.velocities[0].z
                };
                let right = (relative * relative - 2.0 * work / mass).sqrt();
                assert!((speed / right - 1.0).abs() < 2e-3, "{second} {speed} {right}");
            }
        }
    }
}

#[test]
fn no_bridge_before_the_first_touch() {
    let forces = PairForces { bridge: Some(bridge(1e-9)), ..Default::default() };
    let mut model = two(Scheme::Leapfrog, forces, 2.0 * RADIUS + 1e-5, Vec3::zeros());
    (model.plan.step, model.plan.steps) = (1e-5, 100);
    let run = finish(&model);
    assert_eq!(last(&run).velocities[0], Vec3::zeros());
    assert_eq!(run.series.last().expect("rows").attraction, 0.0);
}

#[test]
fn adhesion_carries_up_to_its_pull_off_force() {
    let laws = [
        (Cohesion::Dmt { work: SurfaceTension(2.0) }, 2.0 * PI * 2.0 * RADIUS),
        (Cohesion::Jkr { work: SurfaceTension(2.0) }, 1.5 * PI * 2.0 * RADIUS),
        (Cohesion::Linear { pull: Force(0.2), range: Length(1e-5) }, 0.2),
    ];
    for (law, pull) in laws {
        for (factor, holds) in [(0.95, true), (1.05, false)] {
            let mut model = empty(Scheme::Leapfrog, contact(0.0, 5.0, 0.0, 0.0));
            model.extra = with(PairForces { cohesion: Some(law), ..Default::default() });
            // Hanging from a ceiling.
            model.gravity = Vec3::z() * -(factor * pull / MASS);
            add_plane(&mut model, Vec3::zeros(), -Vec3::z(), Motion::Still);
            let depth = (pull * (1.0 - factor) / KN).max(1e-9);
            let place = -Vec3::z() * (RADIUS - depth);
            add_sphere(&mut model, place, RADIUS, Vec3::zeros(), Vec3::zeros());
            (model.plan.step, model.plan.steps) = (1e-5, 3000);
            let end = last(&finish(&model)).centres[0].z;
            assert_eq!(end > -RADIUS - 1e-4, holds, "{law:?} {factor} {end}");
        }
    }
}

/// A loose heap of spheres with every law that acts on pairs and planes.
fn sticky(scheme: Scheme, rolling: Option<Rolling>) -> Model {
    let mut model = mixed(scheme, Dimension::Three, true, false, 6);
    let field =
        Electrostatics { cutoff: Length(0.05), permittivity: 2.0, cut: CutOff::ShiftedForce };
    model.extra = with(PairForces {
        cohesion: Some(Cohesion::Linear { pull: Force(0.05), range: Length(1e-3) }),
        rolling,
        van_der_waals: Some(VanDerWaals {
            hamaker: Energy(1e-6),
            least_gap: Length(5e-4),
            cutoff: Length(5e-3),
            cut: CutOff::ShiftedForce,
        }),
        born_mayer: Some(BornMayer {
            strength: Energy(1e-5),
            decay: Length(5e-4),
            cutoff: Length(4e-3),
            cut: CutOff::ShiftedForce,
        }),
        lennard_jones: Some(LennardJones {
            depth: Energy(1e-5),
            size: Length(0.018),
            cutoff: Length(0.04),
            cut: CutOff::ShiftedForce,
        }),
        ..Default::default()
    });
    model.extra.charges = Some(Charges { of_material: vec![1e-8], field });
    model
}

/// Largest energy residual over the energy at the start, at `per` steps a contact.
fn residual(mut model: Model, per: f64) -> f64 {
    model.plan.step = PI * (0.5 * MASS / KN).sqrt() / per;
    model.plan.steps = (0.01 / model.plan.step) as u64;
    model.plan.series_every = (model.plan.steps / 20).max(1);
    let run = finish(&model);
    let energy = run.series[0].kinetic + run.series[0].elastic;
    assert!(run.series.iter().any(|row| row.attraction.abs() > 1e-3 * energy));
    run.series.iter().map(|row| row.missed().abs()).fold(0.0, f64::max) / energy
}

#[test]
fn the_ledger_closes_at_second_order_with_attraction() {
    for scheme in [Scheme::Leapfrog, Scheme::Yade, Scheme::PathAveraged] {
        let (coarse, fine) =
            (residual(sticky(scheme, None), 25.0), residual(sticky(scheme, None), 100.0));
        assert!(coarse < 5e-2 && fine < coarse / 7.0, "{scheme:?} {coarse} {fine}");
    }
    // With resistance to rolling: second order too, first order along paths.
    let law = Some(Rolling::Epsd2 { coefficient: 0.1 });
    for (scheme, gain) in [(Scheme::Leapfrog, 7.0), (Scheme::PathAveraged, 2.5)] {
        let (coarse, fine) =
            (residual(sticky(scheme, law), 25.0), residual(sticky(scheme, law), 100.0));
        assert!(coarse < 5e-2 && fine < coarse / gain, "{scheme:?} {coarse} {fine}");
    }
}

#[test]
fn momentum_stays_with_every_force_between_bodies() {
    for scheme in SCHEMES {
        let mut model = sticky(scheme, Some(Rolling::Epsd { coefficient: 0.1, damping: 0.2 }));
        model.walls.clear();
        model.gravity = Vec3::zeros();
        model.plan.steps = 300;
        let run = finish(&model);
        let total = |frame: &Frame| -> Vec3 {
            frame.bodies.iter().zip(&model.bodies).map(|(s, b)| s.velocity * b.mass).sum()
        };
        let angular = |frame: &Frame| -> Vec3 {
            let each = frame.bodies.iter().zip(&model.bodies);
            each.map(|(s, b)| {
                s.position.cross(&(s.velocity * b.mass))
                    + turn::momentum(&s.orientation, &b.inertia, &s.spin)
            })
            .sum()
        };
        let scale: f64 = model.bodies.iter().map(|b| b.mass * b.velocity.norm()).sum();
        let change = total(&run.frames[0]) - total(last(&run));
        assert!(change.norm() < 1e-12 * scale, "{scheme:?} {change}");
        if matches!(scheme, Scheme::Leapfrog | Scheme::PathAveraged) {
            let change = angular(&run.frames[0]) - angular(last(&run));
            assert!(change.norm() < 1e-11 * scale * RADIUS, "{scheme:?} {change}");
        }
    }
}

#[test]
fn rolling_spheres_slow_down_as_they_should() {
    // a = 5/7 μr g for a sphere that rolls without slipping under the moment μr m g R.
    let laws = [
        Rolling::Cdt { coefficient: 0.02 },
        Rolling::Epsd { coefficient: 0.02, damping: 0.0 },
        Rolling::Epsd2 { coefficient: 0.02 },
    ];
    for scheme in SCHEMES {
        for law in laws {
            let mut model = empty(scheme, contact(0.3 * KN, 10.0, 8.0, 0.5));
            model.extra = with(PairForces { rolling: Some(law), ..Default::default() });
            model.gravity = Vec3::z() * -9.81;
            (model.plan.step, model.plan.steps) = (2e-5, 5000);
            model.plan.series_every = 5000;
            add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
            let place = Vec3::z() * (RADIUS - MASS * 9.81 / KN);
            let spin = Vec3::y() * (0.5 / RADIUS);
            add_sphere(&mut model, place, RADIUS, Vec3::x() * 0.5, spin);
            let run = finish(&model);
            let right = 0.5 - 5.0 / 7.0 * 0.02 * 9.81 * 0.1;
            let speed = last(&run).velocities[0].x;
            assert!((speed - right).abs() < 2e-4, "{scheme:?} {law:?} {speed} {right}");
            let lost = 0.7 * MASS * (0.25 - speed * speed);
            let row = run.series.last().expect("rows");
            assert!((row.rolling / lost - 1.0).abs() < 0.02, "{scheme:?} {law:?} {row:?} {lost}");
            assert!(row.missed().abs() < 1e-3 * lost, "{scheme:?} {law:?} {row:?}");
        }
    }
}

#[test]
fn rolling_springs_hold_on_a_slope_below_their_coefficient() {
    // tan of the slope against μr.
    for (slope, holds) in [(0.08, true), (0.12, false)] {
        let mut model = empty(Scheme::Leapfrog, contact(0.3 * KN, 10.0, 8.0, 0.5));
        let law = Rolling::Epsd { coefficient: 0.1, damping: 0.3 };
        model.extra = with(PairForces { rolling: Some(law), ..Default::default() });
        model.gravity = Vec3::new(slope, 0.0, -1.0) * 9.81;
        (model.plan.step, model.plan.steps) = (2e-5, 8000);
        add_sheet(&mut model, 4, 0.2, 0.0, 0.0, Motion::Still);
        let place = Vec3::new(0.003, 0.007, RADIUS - MASS * 9.81 / KN);
        add_sphere(&mut model, place, RADIUS, Vec3::zeros(), Vec3::zeros());
        let moved = last(&finish(&model)).centres[0].x - 0.003;
        assert_eq!(moved < 2e-4, holds, "{slope} {moved}");
    }
}

#[test]
fn drag_slows_exponentially_and_is_counted() {
    for scheme in SCHEMES {
        let mut model = empty(scheme, contact(0.0, 0.0, 0.0, 0.0));
        model.extra.drag = 0.2;
        model.gravity = Vec3::z() * -9.81;
        (model.plan.step, model.plan.steps) = (1e-5, 10_000);
        model.plan.series_every = 10_000;
        model.domain.high = Vec3::repeat(3.0);
        add_sphere(&mut model, Vec3::zeros(), RADIUS, Vec3::x(), Vec3::zeros());
        let run = finish(&model);
        let (rate, time) = (0.2 / MASS, 0.1);
        let right = Vec3::new(1.0, 0.0, 0.0) * (-rate * time).exp()
            - Vec3::z() * (9.81 / rate * (1.0 - (-rate * time).exp()));
        assert!((last(&run).velocities[0] - right).norm() < 1e-3, "{scheme:?}");
        let row = run.series.last().expect("rows");
        assert!(row.drag > 0.5 * MASS * 0.5, "{row:?}");
        assert!(row.missed().abs() < 1e-4 * run.series[0].kinetic, "{scheme:?} {row:?}");
    }
    let mut model = two(Scheme::Leapfrog, PairForces::default(), 0.05, Vec3::zeros());
    model.extra.drag = 100.0;
    let limit = advise(&model).damping.expect("a bound from the drag");
    assert!((limit - 2.0 * MASS / 100.0).abs() < 1e-12, "{limit}");
}

#[test]
fn resuming_changes_no_bit_of_what_pairs_remember() {
    let mut model = sticky(Scheme::Leapfrog, Some(Rolling::Epsd2 { coefficient: 0.2 }));
    let mut forces = *model.extra.between(0, 0);
    forces.bridge = Some(bridge(1e-10));
    model.extra.set(1, 0, 0, forces);
    (model.plan.steps, model.plan.checkpoint_every) = (400, 200);
    let mut whole = Log::default();
    simulate(&model, None, &Job::quiet(), &mut whole).expect("a usable model");
    let mut again = Log::default();
    simulate(&model, Some(&whole.checkpoints[0]), &Job::quiet(), &mut again).expect("resumes");
    assert_eq!(whole.frames.last(), again.frames.last());
}

#[test]
fn pairs_keep_their_memory_when_lists_are_built_anew() {
    // The same scene with lists built at other times: longer leeways through large spheres far away.
    let law = Some(Rolling::Epsd2 { coefficient: 0.3 });
    let run_with = |odd: usize| {
        let mut model = sticky(Scheme::Leapfrog, law);
        model.extra.charges = None;
        model.domain =
            crate::geometry::Bounds { low: Vec3::repeat(-9.0), high: Vec3::repeat(99.0) };
        model.gravity = Vec3::zeros();
        for i in 0..odd {
            let place = Vec3::new(3.0 + i as f64, 5.0, 5.0);
            add_sphere(&mut model, place, 0.04, Vec3::zeros(), Vec3::zeros());
        }
        model.walls.clear();
        (model.plan.step, model.plan.steps) = (1e-5, 1000);
        last(&finish(&model)).bodies[..10].to_vec()
    };
    let (few, many) = (run_with(0), run_with(60));
    for (a, b) in few.iter().zip(&many) {
        assert!((a.position - b.position).norm() < 1e-9 * RADIUS);
    }
}

#[test]
fn scenes_without_such_forces_make_no_pass() {
    let model = mixed(Scheme::Leapfrog, Dimension::Three, false, false, 1);
    assert!(!model.needs().extra() && !model.needs().drag);
    assert!(sticky(Scheme::Leapfrog, None).needs().extra());
}

#[test]
fn what_cannot_be_computed_is_refused_in_words() {
    let refused = |model: &Model| match run(model, &Job::quiet()) {
        Err(DemError::Unusable(text)) => text,
        other => panic!("{other:?}"),
    };
    let mut model = mixed(Scheme::Leapfrog, Dimension::Three, false, false, 1);
    model.contacts = ContactTable::uniform(1, contact(0.0, 0.0, 0.0, 0.0));
    model.extra =
        with(PairForces { rolling: Some(Rolling::Cdt { coefficient: 0.1 }), ..Default::default() });
    assert!(refused(&model).contains("no friction"));
    model.extra = with(PairForces {
        cohesion: Some(Cohesion::Sjkr { energy_density: EnergyDensity(-1.0) }),
        ..Default::default()
    });
    assert!(refused(&model).contains("sjkr.energy_density"));
}

#[test]
fn the_step_limit_knows_attraction_and_rolling() {
    let plain = mixed(Scheme::Leapfrog, Dimension::Three, false, false, 1);
    let limit = advise(&plain).packed;
    let mut stiff = plain.clone();
    let law = VanDerWaals {
        hamaker: Energy(1e-5),
        least_gap: Length(1e-6),
        cutoff: Length(1e-3),
        cut: CutOff::ShiftedForce,
    };
    stiff.extra = with(PairForces { van_der_waals: Some(law), ..Default::default() });
    assert!(advise(&stiff).packed < 0.5 * limit);
    let mut rolling = plain.clone();
    let law = Rolling::Epsd2 { coefficient: 0.1 };
    rolling.extra = with(PairForces { rolling: Some(law), ..Default::default() });
    assert!(advise(&rolling).packed < 0.999 * limit);
}
