//! Bonds against closed forms and invariants.

use super::test_scenes::*;
use super::*;
use crate::model::*;
use crate::num::{Rotation, Vec3};
use nalgebra::{DMatrix, SymmetricEigen};

const ALL: [Scheme; 4] = [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Yade, Scheme::PathAveraged];
const HEAVY: f64 = 1e12;

/// Two heavy spheres that touch along x, the second moving; nothing slows them down.
fn pulled(scheme: Scheme, velocity: Vec3, spin: Vec3, bond: Bond) -> Model {
    let mut model = empty(scheme, contact(0.4 * KN, 0.0, 0.0, 0.5));
    add_sphere(&mut model, Vec3::zeros(), RADIUS, Vec3::zeros(), Vec3::zeros());
    add_sphere(&mut model, Vec3::x() * (2.0 * RADIUS), RADIUS, velocity, spin);
    for body in &mut model.bodies {
        (body.mass, body.inertia) = (HEAVY, Vec3::repeat(HEAVY));
    }
    model.bonds.push(bond);
    model.plan.step = 1e-5;
    model.plan.steps = 200;
    model
}

fn beam(strength: Strength) -> Bond {
    let section = Section::new(Dimension::Three, RADIUS);
    Bond::beam([0, 1], section, 2.0 * RADIUS, [1e9, 4e8], strength)
}

#[test]
fn a_single_bond_has_the_closed_form_in_each_of_its_ways() {
    // E 1e9, G 4e8, radius 0.01, length 0.02 (50 digits).
    let [kn, ks, kb, kt] = [
        15_707_963.267_948_966,
        6_283_185.307_179_587,
        392.699_081_698_724_15,
        314.159_265_358_979_3,
    ];
    let bond = beam(Strength::Unbreakable);
    assert!((bond.normal / kn - 1.0).abs() < 1e-14 && (bond.shear / ks - 1.0).abs() < 1e-14);
    assert!((bond.bending / kb - 1.0).abs() < 1e-14 && (bond.twisting / kt - 1.0).abs() < 1e-14);
    let rate = 1e-3;
    for scheme in ALL {
        let (x, y) = (Vec3::x() * rate, Vec3::y() * rate);
        let none = Vec3::zeros();
        // Spin about y at both ends of opposite sense bends without shear.
        let cases = [(x, none, kn), (y, none, ks), (none, x, kt)];
        for (velocity, spin, stiffness) in cases {
            let model = pulled(scheme, velocity, spin, bond);
            let run = finish(&model);
            let row = run.series.last().expect("a row");
            // YADE's first pass counts a step of shear already.
            let early = if scheme == Scheme::Yade && velocity.y > 0.0 { 1 } else { 0 };
            let way = rate * model.plan.step * (row.step + early) as f64;
            let wanted = 0.5 * stiffness * way * way;
            assert!(
                (row.bond_elastic / wanted - 1.0).abs() < 1e-8,
                "{scheme:?} {} {wanted}",
                row.bond_elastic
            );
        }
        let mut model = pulled(scheme, none, y, bond);
        model.bodies[0].spin = -y;
        let row = *finish(&model).series.last().expect("a row");
        let way = 2.0 * rate * model.plan.step * row.step as f64;
        assert!(
            (row.bond_elastic / (0.5 * kb * way * way) - 1.0).abs() < 1e-8,
            "{scheme:?} bending"
        );
    }
}

#[test]
fn bonds_break_in_the_step_in_which_the_strength_is_passed() {
    let (x, y, none) = (Vec3::x() * 1e-3, Vec3::y() * 1e-3, Vec3::zeros());
    let section = Section::new(Dimension::Three, RADIUS);
    let [kn, ks] = [1e7, 4e6];
    let forces =
        |tension, shear| Bond::contact([0, 1], kn, ks, Strength::Forces { tension, shear });
    let stresses = |tension, shear| beam(Strength::Stresses { radius: RADIUS, tension, shear });
    let step = 1e-8; // way of one step, m or rad
    let beam_of = |stiffness: f64, over: f64| 100.25 * step * stiffness / over;
    let whole = beam(Strength::Unbreakable);
    let cases = [
        (x, none, none, forces(100.25 * step * kn, 1e9), BreakMode::Tension),
        (y, none, none, forces(1e9, 100.25 * step * ks), BreakMode::Shear),
        (x, none, none, stresses(beam_of(whole.normal, section.area), 1e20), BreakMode::Tension),
        (y, none, none, stresses(1e20, beam_of(whole.shear, section.area)), BreakMode::Shear),
        (
            none,
            x,
            none,
            stresses(1e20, beam_of(whole.twisting, section.twisting / RADIUS)),
            BreakMode::Twisting,
        ),
        (
            none,
            0.5 * y,
            -0.5 * y,
            stresses(beam_of(whole.bending, section.bending / RADIUS), 1e20),
            BreakMode::Bending,
        ),
    ];
    for scheme in ALL {
        for (velocity, spin, other, bond, mode) in cases {
            let mut model = pulled(scheme, velocity, spin, bond);
            model.bodies[0].spin = other;
            let run = finish(&model);
            let breaks = run.breaks.expect("ours tells");
            assert_eq!(breaks.len(), 1, "{scheme:?} {mode:?}");
            assert_eq!(breaks[0].mode, mode, "{scheme:?}");
            let early = u64::from(scheme == Scheme::Yade && mode == BreakMode::Shear);
            assert_eq!(breaks[0].step, 101 - early, "{scheme:?} {mode:?}");
            assert!(breaks[0].energy > 0.0);
            assert_eq!(run.series.last().expect("a row").bonds, 0);
        }
    }
}

#[test]
fn a_broken_bond_leaves_an_ordinary_contact() {
    // Pressed together and sheared: the bond breaks, friction holds the rest.
    let bond = Bond::contact([0, 1], KN, 0.4 * KN, Strength::Forces { tension: 1e9, shear: 0.2 });
    for scheme in ALL {
        let mut model = pulled(scheme, Vec3::new(-0.05, 0.2, 0.0), Vec3::zeros(), bond);
        model.plan.steps = 2000;
        let run = finish(&model);
        let touch = run.touches.as_ref().expect("ours tells")[0];
        let overlap = 2.0 * RADIUS - (run.frames[1].centres[1] - run.frames[1].centres[0]).norm();
        assert_eq!(run.breaks.expect("ours tells")[0].mode, BreakMode::Shear);
        assert!((touch.normal / (KN * overlap) - 1.0).abs() < 1e-9, "{scheme:?} {touch:?}");
        assert!(
            (touch.tangential / (0.5 * touch.normal) - 1.0).abs() < 1e-3,
            "{scheme:?} {touch:?}"
        );
    }
}

#[test]
fn an_overlap_under_a_bond_stays_without_force_when_the_bond_breaks() {
    let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
    add_sphere(&mut model, Vec3::zeros(), RADIUS, Vec3::zeros(), Vec3::zeros());
    add_sphere(&mut model, Vec3::x() * RADIUS, RADIUS, Vec3::x() * 0.1, Vec3::zeros());
    model.bonds.push(Bond::contact(
        [0, 1],
        KN,
        0.0,
        Strength::Forces { tension: 0.01, shear: 1.0 },
    ));
    model.plan.steps = 150_000;
    model.plan.step = 2e-6;
    let run = finish(&model);
    assert_eq!(run.breaks.expect("ours tells").len(), 1);
    // No more speed than they began with: the overlap of a radius stored nothing.
    let speed = run.frames.last().expect("a frame").velocities[1].x;
    assert!((speed - 0.1).abs() < 1e-4, "{speed}");
    assert!(run.series.last().expect("a row").missed().abs() < 1e-8);
}

/// Bonds of a chain of `bonds` along x whose first sphere is held, not the load.
fn chain(scheme: Scheme, bonds: u32) -> Model {
    let mut model = empty(scheme, contact(0.0, 0.0, 0.0, 0.0));
    for i in 0..=bonds {
        let place = Vec3::x() * (2.0 * RADIUS * f64::from(i));
        add_sphere(&mut model, place, RADIUS, Vec3::zeros(), Vec3::zeros());
        if i > 0 {
            let section = Section::new(Dimension::Three, RADIUS);
            model.bonds.push(Bond::beam(
                [i - 1, i],
                section,
                2.0 * RADIUS,
                [1e9, 4e8],
                Strength::Unbreakable,
            ));
        }
    }
    model.bodies[0].inertia = Vec3::repeat(HEAVY);
    model.domain = model.domain.grown(1.0);
    model
}

#[test]
fn a_cantilever_bends_as_the_closed_form_says() {
    for count in [1, 5] {
        let mut model = chain(Scheme::Leapfrog, count);
        // The held sphere rests on a small table that its neighbour does not reach.
        add_sheet(&mut model, 1, 0.4 * RADIUS, -RADIUS, 0.0, Motion::Still);
        model.contacts =
            ContactTable::uniform(1, Contact { kn: 1e6, ..contact(0.0, 0.0, 0.0, 0.0) });
        let load = 1e-3;
        model.gravity = Vec3::z() * (-load / MASS);
        model.local_damping = 0.6;
        model.plan.step = 1.2e-5;
        model.plan.steps = 15_000;
        let run = finish(&model);
        let centres = &run.frames.last().expect("a frame").centres;
        let deflection = centres[0].z - centres[count as usize].z;
        let Bond { shear, bending, .. } = model.bonds[0];
        // A9: hinges in the middle of each bond; the weights of all spheres one by one.
        let n = f64::from(count);
        let l = 2.0 * RADIUS;
        let wanted: f64 = (1..=count)
            .map(|at| {
                let j = f64::from(at);
                let hinges: f64 =
                    (1..=at).map(f64::from).map(|k| (j - k + 0.5) * (n - k + 0.5)).sum();
                load * (l * l / bending * hinges + j / shear)
            })
            .sum();
        assert!((deflection / wanted - 1.0).abs() < 1e-6, "{count}: {deflection:e} {wanted:e}");
        // The load at the tip alone is the formula of A9.
        let tip: f64 = (1..=count).map(|k| (n - f64::from(k) + 0.5).powi(2)).sum();
        assert!((tip / (n.powi(3) / 3.0 - n / 12.0) - 1.0).abs() < 1e-12);
    }
}

/// Square of the lowest circular frequency of a chain held at its first sphere, and the
/// deflections and turns of its free spheres in that mode.
fn lowest_mode(model: &Model) -> (f64, Vec<[f64; 2]>) {
    let count = model.bonds.len();
    let Bond { shear, bending, .. } = model.bonds[0];
    let mut stiffness = DMatrix::<f64>::zeros(2 * count, 2 * count);
    for k in 0..count {
        // Shear u_b − u_a − R (θ_a + θ_b), bending θ_b − θ_a; sphere 0 is held.
        for (parts, spring) in
            [([-1.0, -RADIUS, 1.0, -RADIUS], shear), ([0.0, -1.0, 0.0, 1.0], bending)]
        {
            let place = |i: usize| (2 * k + i).checked_sub(2);
            for (i, a) in parts.iter().enumerate() {
                for (j, b) in parts.iter().enumerate() {
                    if let (Some(row), Some(column)) = (place(i), place(j)) {
                        stiffness[(row, column)] += spring * a * b;
                    }
                }
            }
        }
    }
    let light: Vec<f64> = model.bodies[1..]
        .iter()
        .flat_map(|b| [b.mass.sqrt().recip(), b.inertia.x.sqrt().recip()])
        .collect();
    let scaled =
        DMatrix::from_fn(2 * count, 2 * count, |i, j| stiffness[(i, j)] * light[i] * light[j]);
    let modes = SymmetricEigen::new(scaled);
    let lowest = modes.eigenvalues.argmin().0;
    let shape = (0..count)
        .map(|k| [0, 1].map(|i| modes.eigenvectors[(2 * k + i, lowest)] * light[2 * k + i]))
        .collect();
    (modes.eigenvalues[lowest], shape)
}

#[test]
fn a_cantilever_swings_with_its_first_frequency() {
    for scheme in ALL {
        let mut model = chain(scheme, 5);
        model.bodies[0].mass = HEAVY;
        let (square, shape) = lowest_mode(&model);
        for (body, [way, turn]) in model.bodies[1..].iter_mut().zip(shape) {
            body.velocity = Vec3::y() * (1e-5 * way);
            body.spin = Vec3::z() * (1e-5 * turn);
        }
        let period = std::f64::consts::TAU / square.sqrt();
        model.plan.steps = 1500;
        model.plan.step = period / 1500.0;
        let speed = model.bodies[5].velocity.y;
        let run = finish(&model);
        let frame = run.frames.last().expect("a frame");
        // After one period it is where it was: the phase error is place over amplitude.
        let lag = if scheme == Scheme::Yade { 0.5 / 1500.0 * std::f64::consts::TAU } else { 0.0 };
        let phase = frame.centres[5].y * square.sqrt() / speed;
        assert!(phase.abs() < 1e-4 + lag, "{scheme:?} {phase:e}");
        assert!((frame.velocities[5].y / speed - 1.0).abs() < 1e-4 + lag * lag, "{scheme:?}");
    }
}

/// A close-packed cluster of seven, tumbling.
fn cluster(scheme: Scheme, bond: impl Fn([u32; 2]) -> Bond) -> Model {
    let mut model = empty(scheme, contact(0.4 * KN, 0.0, 0.0, 0.4));
    let spin = Vec3::new(30.0, -20.0, 50.0);
    for i in 0..7 {
        let angle = std::f64::consts::FRAC_PI_3 * f64::from(i);
        let place = if i == 6 { Vec3::zeros() } else { Vec3::new(angle.cos(), angle.sin(), 0.0) };
        let place = place * (2.0 * RADIUS) + Vec3::z() * 0.05;
        add_sphere(&mut model, place, RADIUS, spin.cross(&place), spin);
    }
    for a in 0..7_u32 {
        for b in a + 1..7 {
            let gap =
                (model.bodies[a as usize].position - model.bodies[b as usize].position).norm();
            if gap < 2.01 * RADIUS {
                model.bonds.push(bond([a, b]));
            }
        }
    }
    model.plan.step = 1e-5;
    model
}

fn tough(spheres: [u32; 2]) -> Bond {
    let section = Section::new(Dimension::Three, 0.5 * RADIUS);
    Bond::beam(spheres, section, 2.0 * RADIUS, [2e6, 8e5], Strength::Unbreakable)
}

fn brittle(spheres: [u32; 2]) -> Bond {
    let strength = Strength::Forces { tension: 5.0, shear: 2.0 };
    Bond { viscosity: 1e-6, ..Bond::contact(spheres, KN, 0.4 * KN, strength) }
}

#[test]
fn a_tumbling_cluster_keeps_energy_and_both_momenta() {
    for scheme in ALL {
        let mut model = cluster(scheme, tough);
        for body in &mut model.bodies {
            body.velocity += Vec3::new(body.position.y, -body.position.x, 0.0) * 10.0;
        }
        model.plan.steps = 4000;
        model.plan.series_every = 40;
        let run = finish(&model);
        let angular = |frame: &Frame| {
            let parts = frame.bodies.iter().zip(&model.bodies);
            parts
                .map(|(s, b)| s.position.cross(&s.velocity) * b.mass + s.spin * b.inertia.x)
                .sum::<Vec3>()
        };
        let (first, last) = (&run.frames[0], run.frames.last().expect("a frame"));
        // YADE's shear by increments turns to first order: it keeps angular momentum as contacts do.
        let (way, size) = ((angular(last) - angular(first)).norm(), angular(first).norm());
        let loose = if scheme == Scheme::Yade { 2e-3 } else { 1e-10 };
        assert!(way < loose * size, "{scheme:?} {way:e} {size:e}");
        let scale = run.series[0].kinetic;
        let worst = run.series.iter().map(|row| row.missed().abs()).fold(0.0, f64::max);
        let loose = if scheme == Scheme::Yade { 3e-3 } else { 3e-5 };
        assert!(worst < loose * scale, "{scheme:?} {worst:e} {scale:e}");
        assert!(run.series.iter().any(|row| row.bond_elastic > 1e-3 * scale));
    }
}

/// The cluster falls on a floor and breaks.
fn impact(scheme: Scheme) -> Model {
    let mut model = cluster(scheme, brittle);
    for body in &mut model.bodies {
        body.velocity.z -= 2.0;
    }
    add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    model.gravity = Vec3::z() * -9.81;
    model.plan.steps = 4000;
    model.plan.series_every = 1;
    model
}

#[test]
fn the_ledger_closes_when_a_cluster_breaks() {
    for scheme in ALL {
        let mut model = impact(scheme);
        let mut errors = [0.0; 2];
        for (k, refined) in [1, 4].into_iter().enumerate() {
            model.plan.step = 1e-5 / f64::from(refined);
            model.plan.steps = 4000 * u64::from(refined as u32);
            let run = finish(&model);
            let breaks = run.breaks.expect("ours tells").len() as u64;
            let row = run.series.last().expect("a row");
            assert!(breaks >= 4, "{scheme:?} {breaks}");
            assert_eq!(row.bonds + breaks, 12);
            assert!(row.bond_released > 0.0 && row.bond_damping > 0.0);
            let scale = run.series[0].kinetic;
            errors[k] = run.series.iter().map(|r| r.missed().abs()).fold(0.0, f64::max) / scale;
        }
        assert!(errors[0] < 5e-3 && errors[1] < 0.6 * errors[0], "{scheme:?} {errors:?}");
    }
}

#[test]
fn going_on_from_a_checkpoint_between_breaks_gives_the_same_bits() {
    for scheme in ALL {
        let mut model = impact(scheme);
        model.plan.steps = 3000;
        model.plan.checkpoint_every = 250;
        let mut whole = Log::default();
        let summary = simulate(&model, None, &Job::quiet(), &mut whole).expect("a usable model");
        let intact =
            |saved: &Vec<u8>| checkpoint::read(&model, saved).expect("readable").bonds.intact();
        let between = whole.checkpoints.iter().position(|saved| (1..12).contains(&intact(saved)));
        let start = between.unwrap_or(whole.checkpoints.len() / 2);
        let mut rest = Log::default();
        let again = simulate(&model, Some(&whole.checkpoints[start]), &Job::quiet(), &mut rest)
            .expect("a usable checkpoint");
        assert_eq!(again.breaks, summary.breaks);
        assert_eq!(rest.frames.last(), whole.frames.last());
        assert_eq!(rest.rows[..], whole.rows[whole.rows.len() - rest.rows.len()..]);
    }
}

#[test]
fn the_limit_knows_bonds() {
    let model = chain(Scheme::Leapfrog, 8);
    let advice = advise(&model);
    // True onset for the chain: 2/ω of its highest mode, here found by power iteration in runs.
    let blows = |step: f64| {
        let mut model = model.clone();
        for (i, body) in model.bodies.iter_mut().enumerate() {
            body.velocity = Vec3::new(if i % 2 == 0 { 1e-7 } else { -1e-7 }, 0.0, 0.0);
        }
        model.bodies[0].inertia = model.bodies[1].inertia;
        model.plan.insist = true;
        // All energy is in the stiffest mode, whose energy a leapfrog sees only to (ω Δt)².
        model.plan.guard.gain = 1e12;
        model.plan.step = step;
        model.plan.steps = 4000;
        let run = run(&model, &Job::quiet()).expect("insisted");
        run.outcome != Outcome::Finished
            || run.series.last().expect("a row").kinetic > 1e6 * run.series[0].kinetic
    };
    assert!(!blows(0.999 * advice.limit), "{advice:?}");
    // Below the limit a mode may swell by the nearness to it, above it grows without end.
    assert!(blows(1.6 * advice.limit), "{advice:?}");
}

#[test]
fn zeroing_takes_all_motion_and_counts_it() {
    for scheme in ALL {
        let mut model = impact(scheme);
        (model.plan.zero_every, model.plan.zero_until) = (10, 1000);
        model.plan.steps = 1010;
        let run = finish(&model);
        assert!(run.series[999].kinetic > 0.0 && run.series[1010].kinetic > 0.0);
        let row = &run.series[1000];
        // YADE's rows carry its lagging velocities half a step forward.
        let left = if scheme == Scheme::Yade { 1e-9 } else { 0.0 };
        assert!(row.kinetic <= left, "{scheme:?} {row:?}");
        assert!(row.zeroed > 0.9 * run.series[0].kinetic);
        assert!(row.missed().abs() < 1e-4 * row.zeroed, "{scheme:?} {row:?}");
    }
}

#[test]
fn wrong_bonds_are_refused_by_name() {
    let model = cluster(Scheme::Leapfrog, tough);
    let says = |change: &dyn Fn(&mut Model), words: &str| {
        let mut model = model.clone();
        change(&mut model);
        let error = run(&model, &Job::quiet()).expect_err("a fault").to_string();
        assert!(error.contains(words), "{error}");
    };
    says(&|m| m.bonds[3].second = 99, "bond 3 joins a sphere that does not exist");
    says(&|m| m.bonds[3].second = m.bonds[3].first, "two bodies");
    says(&|m| m.bonds[2] = m.bonds[1], "have two bonds");
    says(&|m| m.bonds[2].normal = f64::NAN, "normal stiffness greater than 0");
    says(&|m| m.bonds[2].viscosity = -1.0, "at least 0");
    let turn = Rotation::from_scaled_axis(Vec3::x());
    says(
        &|m| {
            m.bodies[0].orientation = turn;
            m.bonds[0].strength = Strength::Forces { tension: -1.0, shear: 0.0 }
        },
        "strengths",
    );
}
