//! Periodic boxes: where the box is cut must not matter.

use super::neighbours;
use super::setting::{FIRST_SKIN, Setting};
use super::state::State;
use super::test_scenes::*;
use super::*;
use crate::geometry::{Bounds, Cell};
use crate::model::*;
use crate::num::random::{self, RngExt};
use crate::num::{Rotation, Vec3};
use proptest::prelude::*;

const ALL: [Scheme; 4] = [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Yade, Scheme::PathAveraged];

fn cell(size: Vec3, periodic: [bool; 3]) -> Cell {
    Cell {
        bounds: Bounds {
            low: Vec3::new(-0.03, 0.0, 0.01),
            high: Vec3::new(-0.03, 0.0, 0.01) + size,
        },
        periodic,
    }
}

/// Spheres and clumps with random motion in a box that repeats itself, everything moved by `shift`.
fn gas(scheme: Scheme, dimension: Dimension, seed: u64, shift: Vec3) -> Model {
    let mut model = empty(scheme, contact(0.4 * KN, 6.0, 2.0, 0.4));
    let flat = dimension == Dimension::Two;
    model.dimension = dimension;
    let cell = cell(Vec3::new(0.09, 0.08, 0.085), [true, true, !flat]);
    (model.periodic, model.domain) = (Some(cell), cell.bounds);
    if flat {
        (model.domain.low.z, model.domain.high.z) = (-0.5, 0.5);
    }
    model.plan.step = 2e-5;
    let mut source = random::stream(seed, "gas", 0);
    let mut places: Vec<Vec3> = Vec::new();
    for tried in 0..400 {
        let mut place = Vec3::from_fn(|a, _| {
            random::uniform(&mut source, cell.bounds.low[a], cell.bounds.high[a])
        });
        let mut draw = |size: f64| {
            let v = Vec3::from_fn(|_, _| random::uniform(&mut source, -size, size));
            if flat { Vec3::new(v.x, v.y, 0.0) } else { v }
        };
        if flat {
            place.z = 0.0;
        }
        let (velocity, turn) = (draw(1.0), draw(1.5));
        let spin = if flat { Vec3::z() * draw(40.0).x } else { draw(40.0) };
        if places.iter().any(|other| cell.way(&(place - other)).norm() < 2.2 * RADIUS) {
            continue;
        }
        places.push(place);
        let place = place + shift;
        if tried % 3 == 0 {
            let turn = if flat { Rotation::identity() } else { Rotation::from_scaled_axis(turn) };
            add_clump(&mut model, place, turn, velocity, spin);
        } else {
            add_sphere(&mut model, place, RADIUS, velocity, spin);
        }
    }
    assert!(model.bodies.len() > if flat { 5 } else { 12 });
    model
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]
    #[test]
    fn where_the_box_is_cut_does_not_matter(
        seed in 0_u64..100, which in 0_usize..4, flat in any::<bool>(),
        x in -0.3..0.3_f64, y in -0.3..0.3_f64, z in -0.3..0.3_f64,
    ) {
        let dimension = if flat { Dimension::Two } else { Dimension::Three };
        let shift = Vec3::new(x, y, if flat { 0.0 } else { z });
        let of = |shift| {
            let mut model = gas(ALL[which], dimension, seed, shift);
            model.plan.steps = 400;
            let run = finish(&model);
            (model, run)
        };
        let ((model, here), (_, there)) = (of(Vec3::zeros()), of(shift));
        let (a, b) = (here.frames.last().expect("a frame"), there.frames.last().expect("a frame"));
        prop_assert!(here.series.last().expect("a row").normal_dashpot > 0.0);
        for (first, second) in a.bodies.iter().zip(&b.bodies) {
            let way = model.way(second.position - first.position - shift);
            prop_assert!(way.norm() < 1e-9 * RADIUS, "{:e}", way.norm());
            prop_assert!((first.velocity - second.velocity).norm() < 1e-8);
            prop_assert!(first.orientation.angle_to(&second.orientation) < 1e-7);
        }
        for (centre, sphere) in b.centres.iter().zip(&model.spheres) {
            let body = &b.bodies[sphere.body as usize];
            prop_assert!((centre - body.position).norm() < 2.0 * RADIUS);
            prop_assert!(model.domain.contains(&body.position));
        }
    }
}

#[test]
fn momentum_is_kept_and_energy_accounted_for() {
    for scheme in ALL {
        let mut model = gas(scheme, Dimension::Three, 3, Vec3::zeros());
        (model.plan.steps, model.plan.series_every) = (600, 100);
        let run = finish(&model);
        let size: f64 = model.bodies.iter().map(|b| b.mass * b.velocity.norm()).sum();
        let start = run.series[0].momentum;
        for row in &run.series {
            assert!((row.momentum - start).abs() < 1e-14 * size, "{scheme:?} {row:?}");
            assert!(row.missed().abs() < 0.02 * run.series[0].kinetic, "{scheme:?} {row:?}");
        }
        assert!(run.series.iter().any(|row| row.contacts > 0));
    }
}

#[test]
fn a_collision_across_the_side_is_the_collision_in_the_middle() {
    for scheme in ALL {
        let pair = |middle: f64, periodic: bool| {
            let mut model = empty(scheme, contact(0.4 * KN, 6.0, 2.0, 0.4));
            if periodic {
                model.periodic =
                    Some(Cell { bounds: model.domain, periodic: [true, false, false] });
            }
            model.plan.step = 2e-5;
            model.plan.steps = 150;
            for (side, spin) in [(-1.0, 30.0), (1.0, -10.0)] {
                let place = Vec3::new(middle + side * 1.01 * RADIUS, side * 0.002, 0.0);
                let velocity = Vec3::new(-side * 0.6, 0.1, 0.05);
                add_sphere(&mut model, place, RADIUS, velocity, Vec3::new(3.0, spin, 1.0));
            }
            finish(&model).frames.pop().expect("a frame")
        };
        let (here, there) = (pair(0.0, false), pair(1.0, true));
        for (a, b) in here.bodies.iter().zip(&there.bodies) {
            assert!((a.velocity - b.velocity).norm() < 1e-11, "{scheme:?}");
            assert!((a.spin - b.spin).norm() < 1e-9);
            assert!(b.position.x.abs() <= 1.0);
        }
        assert!(here.bodies[0].velocity.x < -0.1, "they have met");
    }
}

#[test]
fn falling_through_the_side_again_and_again_keeps_the_energy_balance() {
    let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
    model.periodic = Some(Cell { bounds: model.domain, periodic: [false, false, true] });
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    add_sphere(&mut model, Vec3::zeros(), RADIUS, Vec3::zeros(), Vec3::zeros());
    add_clump(&mut model, Vec3::x() * 0.5, Rotation::identity(), Vec3::zeros(), Vec3::x());
    (model.plan.step, model.plan.steps, model.plan.insist) = (1e-3, 1_500, true);
    let run = finish(&model);
    let row = run.series.last().expect("a row");
    // 11 m in a box of 2 m.
    let height = 0.5 * 9.81 * 1.5 * 1.5;
    let weight = 9.81 * (model.bodies[0].mass + model.bodies[1].mass);
    assert!((row.gravitational / (-weight * height) - 1.0).abs() < 1e-9, "{row:?}");
    assert!(row.missed().abs() < 1e-10, "{row:?}");
    let place = run.frames.last().expect("a frame").bodies[0].position.z;
    assert!((place - (12.0 - height)).abs() < 1e-9 || (place - (10.0 - height)).abs() < 1e-9);
}

#[test]
fn lists_hold_every_near_pair_once_across_the_sides() {
    for periodic in [[true, true, true], [false, true, false]] {
        let mut model = wide_sizes(250, 6.0);
        let cell = Cell {
            bounds: Bounds { low: Vec3::repeat(-0.03), high: Vec3::repeat(0.03) },
            periodic,
        };
        model.periodic = Some(cell);
        let mut source = random::stream(2, "out", 0);
        for body in &mut model.bodies {
            body.position.y += 0.06 * (source.random::<f64>() * 5.0 - 2.5).round();
        }
        let setting = Setting::new(&model);
        let mut state = State::new(&setting);
        neighbours::rebuild(&setting, &mut state, &crate::dem::crew::Crew::new(1));
        let mut listed = Vec::new();
        for slot in 0..state.balls.len() {
            for k in state.pairs.start[slot]..state.pairs.start[slot + 1] {
                let other = state.order[state.pairs.partner[k as usize] as usize];
                let me = state.order[slot];
                listed.push((me.min(other), me.max(other)));
            }
        }
        listed.sort_unstable();
        let mut expected = Vec::new();
        for (a, first) in model.spheres.iter().enumerate() {
            for (b, second) in model.spheres.iter().enumerate().skip(a + 1) {
                let way = cell.way(&(model.bodies[a].position - model.bodies[b].position));
                if way.norm() - first.radius - second.radius < FIRST_SKIN * setting.median_radius {
                    expected.push((a as u32, b as u32));
                }
            }
        }
        assert!(expected.len() > 50);
        assert_eq!(listed, expected);
    }
}

#[test]
fn what_does_not_go_with_a_periodic_box_is_refused() {
    let refused = |change: &dyn Fn(&mut Model)| {
        let mut model = gas(Scheme::Leapfrog, Dimension::Three, 1, Vec3::zeros());
        change(&mut model);
        run(&model, &Job::quiet()).expect_err("refused").to_string()
    };
    let slanted =
        refused(&|m| add_plane(m, Vec3::zeros(), Vec3::new(0.1, 0.0, 1.0), Motion::Still));
    assert!(slanted.contains("wall0"), "{slanted}");
    let mesh = refused(&|m| add_sheet(m, 2, 0.01, 0.0, 0.0, Motion::Still));
    assert!(mesh.contains("mesh"), "{mesh}");
    let small = refused(&|m| m.periodic.as_mut().expect("periodic").bounds.high.x = 0.0);
    assert!(small.contains("too short along x"), "{small}");
    let far = refused(&|m| {
        m.mutual = Some(MutualGravity {
            constant: 1.0,
            method: FarMethod::AllPairs,
            softening: crate::num::units::Length(0.0),
        });
    });
    assert!(far.contains("Ewald"), "{far}");
}
