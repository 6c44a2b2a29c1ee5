//! Forces at a distance and liquid bridges at mesh walls against planes, closed forms and invariants.

use super::test_scenes::*;
use super::*;
use crate::geometry::Mesh;
use crate::model::extra::*;
use crate::model::*;
use crate::num::random::{self, RngExt};
use crate::num::units::{Angle, Energy, Force, Length, SurfaceTension, Volume};
use crate::num::{Rotation, Vec3};
use std::f64::consts::{PI, TAU};

/// Pull and range in the unit case: 0.05 N over 2 mm.
fn linear() -> PairForces {
    let law = Cohesion::Linear { pull: Force(0.05), range: Length(2e-3) };
    PairForces { cohesion: Some(law), ..Default::default() }
}

fn van_der_waals() -> PairForces {
    let law = VanDerWaals {
        hamaker: Energy(1e-6),
        least_gap: Length(2e-4),
        cutoff: Length(3e-3),
        cut: CutOff::ShiftedForce,
    };
    PairForces { van_der_waals: Some(law), ..Default::default() }
}

fn born_mayer() -> PairForces {
    let law = BornMayer {
        strength: Energy(1e-4),
        decay: Length(5e-4),
        cutoff: Length(3e-3),
        cut: CutOff::ShiftedForce,
    };
    PairForces { born_mayer: Some(law), ..Default::default() }
}

fn bridge() -> PairForces {
    let law =
        Bridge { surface_tension: SurfaceTension(0.072), volume: Volume(1e-9), angle: Angle(0.2) };
    PairForces { bridge: Some(law), ..Default::default() }
}

fn add_mesh(model: &mut Model, mesh: Mesh, motion: Motion) {
    let name = format!("wall{}", model.walls.len());
    model.walls.push(Wall { name, shape: WallShape::Mesh { mesh }, motion, material: 0 });
}

/// Box with edges of twice `half` about the origin, each side cut into `cells`² squares of two triangles.
fn boxed(half: f64, cells: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let mut known = std::collections::BTreeMap::new();
    let mut corner = |mesh: &mut Mesh, place: [u32; 3]| {
        *known.entry(place).or_insert_with(|| {
            let at = |k: u32| -half + 2.0 * half * f64::from(k) / f64::from(cells);
            mesh.vertices.push(Vec3::from(place.map(at)));
            mesh.vertices.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, cells] {
            for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
                let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(k, l)| {
                    let mut place = [side; 3];
                    (place[next], place[last]) = (i + k, j + l);
                    corner(&mut mesh, place)
                });
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

/// Force [N] and potential energy [J] of the meshes on the only sphere of a model at `place`.
fn felt(model: &mut Model, place: Vec3) -> (Vec3, f64) {
    model.bodies[0].position = place;
    let setting = setting::Setting::new(model);
    let mut state = crate::dem::state::State::new(&setting);
    let mut work = forces::Workspace::new(1, 1);
    neighbours::rebuild(&setting, &mut state, &crate::dem::crew::Crew::new(1));
    drive::force_pass(&setting, &mut state, &mut work, true);
    (state.loads[0].force, super::extra::stored(&setting, &state).0)
}

/// A model of one sphere with these forces.
fn one(scheme: Scheme, forces: PairForces, place: Vec3, velocity: Vec3) -> Model {
    let mut model = empty(scheme, contact(0.0, 0.0, 0.0, 0.0));
    model.extra = Extra::uniform(1, forces);
    add_sphere(&mut model, place, RADIUS, velocity, Vec3::zeros());
    model
}

#[test]
fn two_triangles_pull_as_a_plane_does_while_they_are_crossed_and_touched() {
    let spin = Motion::Rotate { origin: Vec3::new(0.01, 0.02, 0.0), axis: Vec3::z(), rate: 20.0 };
    let shake = Motion::Oscillate { amplitude: Vec3::z() * 2e-4, frequency: 60.0, phase: 0.3 };
    let lift = Motion::Translate { velocity: Vec3::new(0.05, -0.02, 0.03) };
    let seek = Motion::Servo { direction: Vec3::z(), force: 2.0, speed: 0.02 };
    let still = SCHEMES.map(|scheme| (scheme, Motion::Still));
    let moving = [spin, shake, lift, seek]
        .map(|motion| [Scheme::Leapfrog, Scheme::PathAveraged].map(|scheme| (scheme, motion)));
    let forces = [linear(), van_der_waals(), born_mayer(), bridge()];
    for (scheme, motion) in still.into_iter().chain(moving.into_iter().flatten()) {
        for forces in forces {
            let path = |mesh: bool| {
                // Down over the diagonal x = y, into contact and away again.
                let place = Vec3::new(0.004, -0.003, RADIUS + 2.5e-3);
                let velocity = Vec3::new(-0.08, 0.11, -0.3);
                let mut model = one(scheme, forces, place, velocity);
                match mesh {
                    true => add_sheet(&mut model, 1, 0.08, 0.0, 0.0, motion),
                    false => add_plane(&mut model, Vec3::zeros(), Vec3::z(), motion),
                }
                model.gravity = Vec3::z() * -0.1;
                (model.plan.step, model.plan.steps) = (1e-5, 4000);
                (model.plan.frame_every, model.plan.series_every) = (50, 50);
                finish(&model)
            };
            let (mesh, plane) = (path(true), path(false));
            // A wall that answers to the force answers to its rounding.
            let rounding = if matches!(motion, Motion::Servo { .. }) { 1e-6 } else { 1e-9 };
            for (one, other) in mesh.frames.iter().zip(&plane.frames) {
                let off = (one.centres[0] - other.centres[0]).norm() / RADIUS;
                assert!(off < rounding, "{scheme:?} {motion:?} {forces:?} {} {off:e}", one.step);
            }
            assert!(mesh.frames.iter().any(|frame| frame.velocities[0].z > 0.1));
            for (one, other) in mesh.series.iter().zip(&plane.series) {
                let off = |a: f64, b: f64| (a - b).abs() / plane.series[0].kinetic;
                let all = off(one.attraction, other.attraction)
                    + off(one.wetting, other.wetting)
                    + off(one.missed(), other.missed());
                assert!(all < 1e-6, "{scheme:?} {motion:?} {forces:?} {one:?} {other:?}");
            }
            let least = mesh.series.iter().map(|row| row.attraction.abs()).fold(0.0, f64::max);
            assert!(least > 0.0);
            if forces.bridge.is_some() {
                let end = mesh.series.last().expect("a row");
                assert!(end.wetting > 0.0 && end.attraction == 0.0, "formed and broken: {end:?}");
            }
        }
    }
}

#[test]
fn the_force_is_minus_the_slope_of_the_potential_over_every_feature() {
    let mut source = random::stream(3, "slope", 0);
    for (forces, inside) in [(linear(), 1.0), (van_der_waals(), 1.0), (linear(), -1.0)] {
        let mut model = one(Scheme::Leapfrog, forces, Vec3::zeros(), Vec3::zeros());
        let half = 0.03;
        add_mesh(&mut model, boxed(half, 2), Motion::Still);
        add_sheet(&mut model, 3, 0.05, 0.1, (5f64).to_radians().tan(), Motion::Still);
        let mut felt_something = 0;
        for _ in 0..300 {
            // Gaps up to the reach at corners, edges and sides, from inside or outside.
            let near = half - inside * (RADIUS + 1.5e-3);
            let mut place = Vec3::from_fn(|_, _| near + 1.5e-3 * (source.random::<f64>() - 0.5));
            for axis in 0..3 {
                place[axis] *= if source.random() { 1.0 } else { -1.0 };
                place[axis] *= if source.random::<f64>() < 0.3 { 0.3 } else { 1.0 };
            }
            if source.random::<f64>() < 0.3 {
                let x = 2e-3 * (source.random::<f64>() - 0.5);
                place = Vec3::new(x, place.y, 0.1 + inside * (RADIUS + 1e-3));
            }
            let (force, _) = felt(&mut model, place);
            let step = 1e-8;
            let slope = Vec3::from_fn(|axis, _| {
                let mut way = Vec3::zeros();
                way[axis] = step;
                let (ahead, behind) =
                    (felt(&mut model, place + way), felt(&mut model, place - way));
                (ahead.1 - behind.1) / (2.0 * step)
            });
            felt_something += u32::from(force.norm() > 1e-3);
            assert!(
                (force + slope).norm() < 1e-5 * (force.norm() + 1e-2),
                "{place} {force} {slope}"
            );
        }
        assert!(felt_something > 100, "{felt_something}");
    }
}

#[test]
fn a_hollow_corner_pulls_from_all_sides_however_it_is_cut() {
    // Reach far enough for the edges and the corner to count.
    let law = Cohesion::Linear { pull: Force(0.05), range: Length(0.02) };
    let forces = PairForces { cohesion: Some(law), ..Default::default() };
    let potential = |distance: f64| {
        let left = (RADIUS + 0.02 - distance).max(0.0);
        -0.5 * 0.05 * left * left / 0.02
    };
    let half = 0.04;
    let mut source = random::stream(4, "corner", 0);
    let [mut coarse, mut fine] = [1, 3].map(|cells| {
        let mut model = one(Scheme::Leapfrog, forces, Vec3::zeros(), Vec3::zeros());
        add_mesh(&mut model, boxed(half, cells), Motion::Still);
        model
    });
    for _ in 0..100 {
        let gaps = Vec3::from_fn(|_, _| RADIUS * (1.0 + 1.2 * source.random::<f64>()));
        let place = Vec3::repeat(half) - gaps;
        let [a, b, c] = [gaps.x, gaps.y, gaps.z];
        let pairs = potential(a.hypot(b)) + potential(b.hypot(c)) + potential(c.hypot(a));
        let right = potential(a) + potential(b) + potential(c) - pairs + potential(gaps.norm());
        let (ours, cut) = (felt(&mut coarse, place), felt(&mut fine, place));
        assert!((ours.1 / right - 1.0).abs() < 1e-12, "{gaps} {} {right}", ours.1);
        assert!((cut.1 / right - 1.0).abs() < 1e-12, "{gaps} {} {right}", cut.1);
        assert!((ours.0 - cut.0).norm() < 1e-12 * ours.0.norm(), "{gaps}");
        // From outside the nearest point alone.
        let outside = Vec3::repeat(half) + (gaps - Vec3::repeat(1.6 * RADIUS));
        let beyond = Vec3::from_fn(|axis, _| (outside[axis] - half).max(0.0)).norm();
        if beyond > RADIUS {
            let (force, energy) = felt(&mut fine, outside);
            assert!((energy - potential(beyond)).abs() < 1e-12 * potential(RADIUS).abs());
            assert!((force.norm() - 0.05 * (1.0 - (beyond - RADIUS) / 0.02)).abs() < 1e-12);
        }
    }
}

#[test]
fn gliding_over_folds_keeps_energy_at_second_order() {
    for scheme in [Scheme::Leapfrog, Scheme::PathAveraged] {
        for degrees in [5.0f64, -5.0, 50.0] {
            for forces in [linear(), van_der_waals()] {
                let error = |step: f64| {
                    let place = Vec3::new(-3e-3, 0.001, RADIUS + 8e-4);
                    let velocity = Vec3::new(1.0, 0.2, 0.0);
                    let mut model = one(scheme, forces, place, velocity);
                    add_sheet(&mut model, 2, 0.05, 0.0, degrees.to_radians().tan(), Motion::Still);
                    (model.plan.step, model.plan.steps) = (step, (6e-3 / step).round() as u64);
                    model.plan.series_every = 1;
                    let run = finish(&model);
                    let deepest = run.series.iter().map(|row| row.contacts).max();
                    assert_eq!(deepest, Some(0), "{degrees} {forces:?}");
                    let scale =
                        run.series.iter().map(|row| row.attraction.abs()).fold(0.0, f64::max);
                    let worst = run.series.iter().map(|row| row.missed().abs());
                    worst.fold(0.0, f64::max) / scale
                };
                let (coarse, fine) = (error(1e-4), error(1e-5));
                assert!(
                    fine < coarse / 30.0 || fine < 1e-9,
                    "{scheme:?} {degrees} {coarse:e} {fine:e}"
                );
                assert!(fine < 1e-4, "{scheme:?} {degrees} {coarse:e} {fine:e}");
            }
        }
    }
}

#[test]
fn a_bridge_goes_with_its_sphere_round_the_edge_of_a_box() {
    let forces = bridge();
    let pull = 4.0 * PI * RADIUS * 0.072 * 0.2f64.cos();
    for scheme in [Scheme::Leapfrog, Scheme::PathAveraged] {
        let half = 0.02;
        let depth = pull / KN;
        let start = Vec3::new(half - 5e-3, 1e-3, half + RADIUS - depth);
        let mut model = one(scheme, forces, start, Vec3::x() * 0.04);
        add_mesh(&mut model, boxed(half, 2), Motion::Still);
        // Five millimetres on top, a quarter circle, and down the side.
        let way = 5e-3 + 0.5 * PI * RADIUS + 5e-3;
        model.plan.step = 2e-5;
        model.plan.steps = (way / 0.04 / model.plan.step) as u64;
        model.plan.series_every = 100;
        let run = finish(&model);
        let end = run.frames.last().expect("a frame");
        assert!((end.centres[0].x - half - RADIUS).abs() < 1e-4, "{scheme:?} {}", end.centres[0]);
        assert!((end.centres[0].z - half + 5e-3).abs() < 1e-3, "{scheme:?} {}", end.centres[0]);
        let whole = run.series[0].attraction;
        for row in &run.series {
            assert!((row.attraction / whole - 1.0).abs() < 0.05, "{scheme:?} {row:?}");
            assert_eq!(row.wetting, 0.0);
            assert!(row.missed().abs() < 1e-3 * run.series[0].kinetic, "{scheme:?} {row:?}");
        }
    }
}

#[test]
fn a_bridge_forms_on_each_side_of_a_corner_at_its_own_touch() {
    // Slides along the floor of a box into its wall, and back: two bridges, one after the other.
    let half = 0.03;
    let place = Vec3::new(half - RADIUS - 3e-3, 0.002, -half + RADIUS - 1e-9);
    let mut model = one(Scheme::Leapfrog, bridge(), place, Vec3::x() * 0.2);
    add_mesh(&mut model, boxed(half, 1), Motion::Still);
    (model.plan.step, model.plan.steps, model.plan.series_every) = (1e-5, 2500, 1);
    let run = finish(&model);
    let whole = run.series[0].attraction;
    let formed = run.series.iter().find(|row| row.wetting > 0.5 * whole.abs());
    let touched = formed.expect("the wall is touched");
    assert!((touched.attraction / whole - 2.0).abs() < 0.02, "{touched:?}");
    assert!((touched.wetting / whole + 1.0).abs() < 0.02, "{touched:?}");
    let end = run.series.last().expect("a row");
    assert!((end.attraction / whole - 1.0).abs() < 0.02, "the second has broken: {end:?}");
    for row in &run.series {
        assert!(row.missed().abs() < 2e-3 * run.series[0].kinetic, "{row:?}");
    }
}

#[test]
fn liquid_gets_across_a_hollow_edge_and_what_it_frees_is_counted() {
    // Along the left of a fold that rises by 40 degrees: the edge comes within reach before the right side is touched.
    let rise = 40f64.to_radians();
    let law = bridge().bridge.expect("a bridge");
    let error = |step: f64| {
        let place = Vec3::new(-8e-3, 0.001, RADIUS - 1e-9);
        let mut model = one(Scheme::Leapfrog, bridge(), place, Vec3::new(0.1, 0.0, 0.0));
        add_sheet(&mut model, 2, 0.05, 0.0, -rise.tan(), Motion::Still);
        (model.plan.step, model.plan.steps) = (step, (0.06 / step) as u64);
        model.plan.series_every = 1;
        let run = finish(&model);
        let whole = -run.series[0].attraction;
        let joined = run.series.iter().position(|row| row.wetting > 0.0).expect("it joins");
        // Across the edge, before the touch: the edge is just within reach.
        let (before, after) = (&run.series[joined - 1], &run.series[joined]);
        assert_eq!((before.contacts, after.contacts), (1, 1));
        let x = place.x + 0.1 * after.time;
        let reach = RADIUS + law.rupture();
        assert!((x.hypot(RADIUS) / reach - 1.0).abs() < 1e-3, "{x}");
        let gained = before.attraction - after.attraction;
        assert!((gained / after.wetting - 1.0).abs() < 1e-2, "{gained} {}", after.wetting);
        let worst = run.series.iter().map(|row| row.missed().abs()).fold(0.0, f64::max);
        worst / whole
    };
    let (coarse, fine) = (error(1e-5), error(1e-6));
    assert!(coarse < 2e-2 && fine < coarse / 4.0, "{coarse:e} {fine:e}");
}

/// A box that turns about y, with spheres that cling and bounce in it.
fn tumbler(scheme: Scheme, forces: PairForces) -> Model {
    let mut model = empty(scheme, contact(0.0, 0.0, 0.0, 0.0));
    model.extra = Extra::uniform(1, forces);
    model.gravity = Vec3::z() * -9.81;
    let mut source = random::stream(8, "tumbler", 0);
    for i in 0..8 {
        let corner = |bit: u32| if i >> bit & 1 == 1 { 1.15 } else { -1.15 };
        let place = Vec3::new(corner(0), corner(1), corner(2)) * RADIUS;
        let velocity = Vec3::from_fn(|_, _| random::uniform(&mut source, -0.3, 0.3));
        add_sphere(&mut model, place, RADIUS, velocity, Vec3::zeros());
    }
    let axis = Vec3::y();
    let motion = Motion::Rotate { origin: Vec3::new(0.002, 0.0, 0.001), axis, rate: 6.0 };
    add_mesh(&mut model, boxed(0.024, 2), motion);
    model
}

#[test]
fn the_ledger_closes_at_second_order_in_a_turning_box() {
    let all = PairForces {
        cohesion: linear().cohesion,
        van_der_waals: van_der_waals().van_der_waals,
        ..Default::default()
    };
    for scheme in [Scheme::Leapfrog, Scheme::Yade, Scheme::PathAveraged] {
        for (forces, gain) in [(all, 7.0), (bridge(), 2.5)] {
            let residual = |step: f64| {
                let mut model = tumbler(scheme, forces);
                (model.plan.step, model.plan.steps) = (step, (0.08 / step) as u64);
                model.plan.series_every = (model.plan.steps / 40).max(1);
                let run = finish(&model);
                let end = run.series.last().expect("a row");
                assert!(end.wall_work.abs() > 1e-4, "{end:?}");
                let worst = run.series.iter().map(|row| row.missed().abs());
                worst.fold(0.0, f64::max) / run.series[0].kinetic
            };
            let (coarse, fine) = (residual(2e-5), residual(5e-6));
            assert!(
                coarse < 2e-2 && fine < coarse / gain,
                "{scheme:?} {forces:?} {coarse:e} {fine:e}"
            );
        }
    }
}

/// A closed drum of `sides` facets about y.
fn drum(radius: f64, half: f64, sides: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..sides {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
        let ring = [-half, half].map(|y| Vec3::new(radius * cos, y, radius * sin));
        mesh.vertices.extend(ring);
    }
    mesh.vertices.extend([Vec3::y() * -half, Vec3::y() * half]);
    for i in 0..sides {
        let (a, b) = (2 * i, 2 * ((i + 1) % sides));
        mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        mesh.triangles.extend([[a, b, 2 * sides], [a + 1, b + 1, 2 * sides + 1]]);
    }
    mesh
}

/// Wet grains with friction and dashpots in a drum; enough for two threads if `many`.
fn wet_drum(scheme: Scheme, many: bool) -> Model {
    let mut model = empty(scheme, contact(0.3 * KN, 6.0, 2.0, 0.4));
    // Bridges hold two and a half grains.
    let strong = bridge().bridge.map(|law| Bridge { surface_tension: SurfaceTension(2.0), ..law });
    model.extra = Extra::uniform(1, PairForces { bridge: strong, ..Default::default() });
    model.gravity = Vec3::z() * -9.81;
    let (across, along) = if many { (9, 11) } else { (2, 1) };
    let space = 2.06 * RADIUS;
    let radius = space * f64::from(across) * 1.45 + RADIUS;
    for i in -across..=across {
        for j in -along..=along {
            for k in -across..across / 3 {
                let place = Vec3::new(f64::from(i), f64::from(j), f64::from(k)) * space;
                if place.x.hypot(place.z) < radius - 1.05 * RADIUS {
                    // Neighbours meet.
                    let velocity = Vec3::x() * if (i + j + k) % 2 == 0 { 0.2 } else { -0.2 };
                    add_sphere(&mut model, place, RADIUS, velocity, Vec3::zeros());
                }
            }
        }
    }
    let half = (f64::from(along) + 0.5) * space;
    let motion = Motion::Rotate { origin: Vec3::zeros(), axis: Vec3::y(), rate: 4.0 };
    add_mesh(&mut model, drum(radius, half, 48), motion);
    model.plan.step = 2e-5;
    model
}

#[test]
fn the_ledger_closes_in_a_wet_drum() {
    for scheme in [Scheme::Leapfrog, Scheme::PathAveraged] {
        let mut model = wet_drum(scheme, false);
        (model.plan.steps, model.plan.series_every) = (15_000, 500);
        let run = finish(&model);
        let end = run.series.last().expect("a row");
        // What bridges hold and have freed is more than what may be missing.
        let missing = 0.005 * (end.gravitational.abs() + end.wall_work.abs());
        assert!(end.attraction < -missing && end.wetting > 2.0 * missing, "{end:?} {missing}");
        for row in &run.series {
            assert!(row.missed().abs() < missing, "{scheme:?} {row:?}");
        }
    }
}

#[test]
fn threads_and_checkpoints_change_no_bit_of_a_wet_drum() {
    let mut model = wet_drum(Scheme::Leapfrog, true);
    assert!(model.bodies.len() > 2400, "{} bodies are too few for threads", model.bodies.len());
    (model.plan.steps, model.plan.checkpoint_every) = (240, 120);
    let go = |threads: usize, from: Option<&[u8]>| {
        let mut log = Log::default();
        let job = Job::quiet().with_threads(threads);
        simulate(&model, from, &job, &mut log).expect("a usable model");
        log
    };
    let (one, two) = (go(1, None), go(2, None));
    assert!(one.frames == two.frames && one.rows == two.rows);
    assert!(one.rows.last().is_some_and(|row| row.wetting > 0.0));
    let again = go(2, Some(&one.checkpoints[0]));
    assert!(one.frames.last() == again.frames.last() && one.rows.last() == again.rows.last());
}

#[test]
fn the_step_limit_knows_attraction_of_meshes() {
    let law = VanDerWaals {
        hamaker: Energy(1e-5),
        least_gap: Length(1e-6),
        cutoff: Length(1e-3),
        cut: CutOff::ShiftedForce,
    };
    let forces = PairForces { van_der_waals: Some(law), ..Default::default() };
    let limit = |forces: PairForces| {
        let place = Vec3::z() * (RADIUS - 1e-6);
        let mut model = one(Scheme::Leapfrog, forces, place, Vec3::zeros());
        add_sheet(&mut model, 1, 0.05, 0.0, 0.0, Motion::Still);
        advise(&model).limit
    };
    // dF/dh = A R/(3 h³) at the least gap.
    let slope = 1e-5 * RADIUS / (3.0 * 1e-18);
    let right = (KN / (KN + slope)).sqrt() * limit(PairForces::default());
    assert!((limit(forces) / right - 1.0).abs() < 0.01, "{} {right}", limit(forces));
}

#[test]
fn a_turned_mesh_pulls_as_one_that_stands_so() {
    let turn = Rotation::from_scaled_axis(Vec3::new(0.3, -0.8, 0.4));
    let axis = Vec3::new(0.3, -0.8, 0.4);
    let mut model = one(Scheme::Leapfrog, linear(), Vec3::zeros(), Vec3::zeros());
    add_mesh(&mut model, boxed(0.03, 1), Motion::Still);
    let inner = Vec3::new(0.019, 0.018, -0.002);
    let (force, energy) = felt(&mut model, inner);
    let mut turned = boxed(0.03, 1);
    turned.vertices.iter_mut().for_each(|v| *v = turn.inverse_transform_vector(v));
    let mut model = one(Scheme::Leapfrog, linear(), Vec3::zeros(), Vec3::zeros());
    let motion =
        Motion::Rotate { origin: Vec3::zeros(), axis: axis.normalize(), rate: axis.norm() };
    add_mesh(&mut model, turned, motion);
    model.bodies[0].position = inner;
    // One step of one second on.
    model.plan.step = 1.0;
    let setting = setting::Setting::new(&model);
    let mut state = crate::dem::state::State::new(&setting);
    state.step = 1;
    let mut work = forces::Workspace::new(1, 1);
    neighbours::rebuild(&setting, &mut state, &crate::dem::crew::Crew::new(1));
    drive::force_pass(&setting, &mut state, &mut work, true);
    assert!((state.loads[0].force - force).norm() < 1e-12 * force.norm());
    assert!((super::extra::stored(&setting, &state).0 / energy - 1.0).abs() < 1e-12);
}
