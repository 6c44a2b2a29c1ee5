//! Every closed form and high-precision solution of single contacts, chains and stacks, with the
//! order at which `leapfrog` and `path_averaged` come to it.

use super::test_scenes::*;
use super::*;
use crate::model::*;
use crate::num::Vec3;
use crate::num::statistics::order_of_convergence;

const BOTH: [Scheme; 2] = [Scheme::Leapfrog, Scheme::PathAveraged];

fn rows<const N: usize>(text: &str) -> Vec<[f64; N]> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines
        .map(|line| {
            let numbers: Vec<f64> =
                line.split(',').map(|word| word.parse().expect("a number")).collect();
            numbers.try_into().expect("as many columns as asked for")
        })
        .collect()
}

fn order(steps: &[f64], errors: &[f64]) -> f64 {
    let spans: Vec<f64> = steps.iter().map(|n| 1.0 / n).collect();
    order_of_convergence(&spans, errors).expect("three points")
}

fn rms(errors: impl Iterator<Item = f64>) -> f64 {
    let squares: Vec<f64> = errors.map(|error| error * error).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// Speed after a normal impact at 1 m/s, and the largest overlap, m.
fn impact(scheme: Scheme, row: &[f64; 6], per: f64, phase: f64) -> (f64, f64) {
    let [other, tension, _, cn, time, _] = *row;
    let mut model = empty(scheme, contact(0.0, cn, 0.0, 0.0));
    model.plan.law.tension = tension == 1.0;
    let heavy = MASS * other.powi(3);
    let mass = if other > 0.0 { MASS * heavy / (MASS + heavy) } else { MASS };
    let span = std::f64::consts::PI * (mass / KN).sqrt();
    let span = if cn > 0.0 { span.min(4.0 * mass / cn) } else { span };
    model.plan.step = span / per;
    model.plan.steps = (time / model.plan.step * 1.05) as u64 + 3;
    model.plan.series_every = 1;
    let start = model.plan.step * phase;
    if other > 0.0 {
        let distance = RADIUS * (1.0 + other) + start;
        add_sphere(&mut model, Vec3::zeros(), RADIUS, Vec3::z(), Vec3::zeros());
        add_sphere(&mut model, Vec3::z() * distance, RADIUS * other, Vec3::zeros(), Vec3::zeros());
    } else {
        add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
        add_sphere(&mut model, Vec3::z() * (RADIUS + start), RADIUS, -Vec3::z(), Vec3::zeros());
    }
    let run = finish(&model);
    let end = &run.frames.last().expect("a frame").velocities;
    let speed = if other > 0.0 { end[1].z - end[0].z } else { end[0].z };
    (speed, run.series.iter().map(|row| row.worst_overlap * RADIUS).fold(0.0, f64::max))
}

#[test]
fn normal_impacts_have_their_restitution() {
    let steps = [25.0, 50.0, 100.0];
    for row in rows::<6>(include_str!("oracles/impact.csv")) {
        for scheme in BOTH {
            let found: Vec<Vec<(f64, f64)>> = steps
                .iter()
                // What is left of a step at the end of the contact must vary too.
                .map(|per| {
                    let phases = [0.08, 0.25, 0.42, 0.58, 0.75, 0.92];
                    phases.map(|p| impact(scheme, &row, per * (1.0 + 0.06 * p), p)).into()
                })
                .collect();
            let errors: Vec<f64> =
                found.iter().map(|all| rms(all.iter().map(|(e, _)| e - row[2]))).collect();
            let order = order(&steps, &errors);
            let averaged = scheme == Scheme::PathAveraged;
            // With tension the force jumps at both ends of the contact, and orders are noisy.
            let (first, second) = if row[1] == 1.0 { (0.4, 1.3) } else { (0.7, 1.7) };
            let (least, most) = if averaged { (second, 1e-3) } else { (first, 1.5e-2) };
            assert!(order > least || errors[2] < 1e-6, "{scheme:?} {row:?} {errors:?} {order}");
            assert!(errors[2] < most, "{scheme:?} {row:?} {errors:?}");
            // Samples at steps miss the deepest place by up to a step.
            let deepest = rms(found[2].iter().map(|(_, depth)| depth / row[5] - 1.0));
            assert!(deepest < 3e-2, "{scheme:?} {row:?} {deepest}");
        }
    }
}

#[test]
fn the_other_laws_dashpot_gives_the_published_restitution() {
    // Asked for with the formula of the full law, computed with the clipped one; equal spheres.
    let cases = [
        (0.016_324_986_916_656_453, 0.950_506_584_879_584_14),
        (0.070_850_300_195_368_056, 0.808_099_335_254_008_34),
        (0.215_453_761_966_246_78, 0.550_283_169_627_115_74),
        (0.455_949_810_769_126_13, 0.324_862_847_954_418_9),
        (0.826_085_054_613_957_1, 0.172_881_238_013_826_76),
    ];
    for (zeta, obtained) in cases {
        assert!((restitution::restitution(zeta, false) - obtained).abs() < 1e-15);
        let dashpot = 2.0 * zeta * (KN * 0.5 * MASS).sqrt();
        let row = [1.0, 0.0, obtained, dashpot, 1e-3, 0.0];
        let (e, _) = impact(Scheme::PathAveraged, &row, 200.0, 0.3);
        assert!((e - obtained).abs() < 1e-5, "{zeta} {e}");
    }
}

/// Outgoing normal and tangential speed and rim speed of an oblique impact on a plane.
fn oblique(scheme: Scheme, row: &[f64; 8], per: f64, phase: f64) -> Vec3 {
    let [degrees, e, tension, kt, arm, ..] = *row;
    let tension = tension == 1.0;
    let cn = restitution::dashpot(e, KN, MASS, tension).expect("a dashpot");
    let mut model = empty(scheme, contact(kt * KN, cn, 0.0, 0.3));
    let arm = [Arm::Radius, Arm::Half, Arm::Full][(2.0 * arm) as usize];
    model.plan.law = Law { tension, plane_arm: arm, ..model.plan.law };
    model.plan.step = std::f64::consts::PI * (MASS / KN).sqrt() / per;
    model.plan.steps = (1.2 * per) as u64;
    let (sin, cos) = degrees.to_radians().sin_cos();
    let height = RADIUS + phase * model.plan.step * cos;
    add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    add_sphere(&mut model, Vec3::z() * height, RADIUS, Vec3::new(sin, 0.0, -cos), Vec3::zeros());
    let run = finish(&model);
    let end = run.frames.last().expect("a frame");
    Vec3::new(end.velocities[0].z, end.velocities[0].x, end.spins[0].y * RADIUS)
}

#[test]
fn oblique_impacts_come_to_the_reference_for_every_arm() {
    let steps = [40.0, 80.0, 160.0];
    let all = rows::<8>(include_str!("oracles/oblique.csv"));
    assert!(all.len() > 80);
    for tension in [0.0, 1.0] {
        let mine: Vec<&[f64; 8]> = all.iter().filter(|row| row[2] == tension).collect();
        for scheme in BOTH {
            let error = |row: &[f64; 8], per: f64| {
                let right = Vec3::new(row[5], row[6], row[7] * RADIUS);
                rms([0.3, 0.8].iter().map(|p| (oblique(scheme, row, per, *p) - right).norm()))
            };
            let errors: Vec<f64> =
                steps.iter().map(|per| rms(mine.iter().map(|row| error(row, *per)))).collect();
            let order = order(&steps, &errors);
            let averaged = scheme == Scheme::PathAveraged && tension == 0.0;
            let (least, most) = if averaged { (1.75, 2e-4) } else { (0.75, 8e-3) };
            assert!(order > least, "{scheme:?} {tension} {errors:?} {order}");
            assert!(errors[2] < most, "{scheme:?} {tension} {errors:?}");
        }
    }
}

#[test]
fn sliding_ends_in_rolling_for_every_arm() {
    // Lever arms R, R − δ/2, R − δ: speed of rolling after 1 m/s of sliding.
    let cases = [
        (Arm::Radius, 0.714_285_714_285_714_29),
        (Arm::Half, 0.714_264_747_963_313_6),
        (Arm::Full, 0.714_243_779_640_781_13),
    ];
    for scheme in BOTH {
        for (arm, rolling) in cases {
            let mut model = empty(scheme, contact(0.3 * KN, 10.0, 8.0, 0.3));
            model.plan.law.plane_arm = arm;
            model.gravity = Vec3::z() * -9.81;
            (model.plan.step, model.plan.steps) = (2e-5, 6000);
            let height = RADIUS - 1.027_300_797_723_862_4e-6;
            add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
            add_sphere(&mut model, Vec3::z() * height, RADIUS, Vec3::x(), Vec3::zeros());
            model.plan.series_every = 6000;
            let run = finish(&model);
            let speed = run.frames.last().expect("a frame").velocities[0].x;
            assert!((speed - rolling).abs() < 1e-7, "{scheme:?} {arm:?} {speed}");
            // Two sevenths of the kinetic energy go.
            let lost = 1.0 - run.series.last().expect("rows").kinetic / (0.5 * MASS);
            assert!((lost - 2.0 / 7.0).abs() < 1e-4, "{scheme:?} {lost}");
        }
    }
}

#[test]
fn spheres_roll_or_slip_down_inclines() {
    // Degrees, acceleration, angular acceleration; μ = 0.3, lever arm R.
    let cases = [
        (5.0, 0.610_712_740_253_233_34, 61.071_274_025_323_334),
        (20.0, 2.396_584_004_303_435_9, 239.658_400_430_343_59),
        (40.0, 4.504_104_607_874_964_9, 450.410_460_787_496_49),
        (50.0, 5.623_172_051_689_689_3, 472.930_983_826_871_31),
        (80.0, 9.149_917_470_175_985, 127.761_646_718_444),
    ];
    for scheme in BOTH {
        for (degrees, along, turning) in cases {
            let mut model = empty(scheme, contact(0.3 * KN, 10.0, 8.0, 0.3));
            model.plan.law.plane_arm = Arm::Radius;
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            model.gravity = Vec3::new(sin, 0.0, -cos) * 9.81;
            (model.plan.step, model.plan.steps) = (2e-5, 5000);
            let depth = MASS * 9.81 * cos / KN;
            add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
            add_sphere(
                &mut model,
                Vec3::z() * (RADIUS - depth),
                RADIUS,
                Vec3::zeros(),
                Vec3::zeros(),
            );
            let run = finish(&model);
            let (end, time) = (run.frames.last().expect("a frame"), 0.1);
            let (speed, spin) = (end.velocities[0].x, end.spins[0].y);
            // The spring takes some steps to load.
            assert!((speed / (along * time) - 1.0).abs() < 2e-3, "{scheme:?} {degrees} {speed}");
            assert!((spin / (turning * time) - 1.0).abs() < 2e-3, "{scheme:?} {degrees} {spin}");
        }
    }
}

#[test]
fn bouncing_ball_reaches_its_heights() {
    // Tension kept, dropped from a gap of 0.1 m: restitution, then time and gap of three apexes.
    let cases = [
        (
            0.9,
            [
                (0.272_267_651_412_034_63, 0.080_947_950_094_870_762),
                (0.517_327_986_938_638_14, 0.065_521_000_746_171_88),
                (0.737_901_756_481_020_33, 0.053_029_861_741_912_937),
            ],
        ),
        (
            0.5,
            [
                (0.215_010_038_724_391_54, 0.024_853_338_961_749_006),
                (0.322_618_932_534_068_92, 0.006_140_134_061_903_442_1),
                (0.376_528_953_374_211_62, 0.001_498_563_595_533_847_4),
            ],
        ),
    ];
    for (e, apexes) in cases {
        for (time, gap) in apexes {
            let dashpot = restitution::dashpot(e, KN, MASS, true).expect("a dashpot");
            let mut model = empty(Scheme::PathAveraged, contact(0.0, dashpot, 0.0, 0.0));
            model.plan.law.tension = true;
            model.gravity = Vec3::z() * -9.81;
            model.plan.steps = (time / 2e-5) as u64;
            model.plan.step = time / model.plan.steps as f64;
            add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
            add_sphere(
                &mut model,
                Vec3::z() * (RADIUS + 0.1),
                RADIUS,
                Vec3::zeros(),
                Vec3::zeros(),
            );
            let run = finish(&model);
            let height = run.frames.last().expect("a frame").centres[0].z - RADIUS;
            assert!((height / gap - 1.0).abs() < 1e-3, "{e} {time} {height} {gap}");
        }
    }
}

/// Speeds after the first of `count` spheres in a row, `gap` apart, was hit with 1 m/s.
fn cradle(scheme: Scheme, count: usize, gap: f64, time: f64, per: f64) -> Vec<f64> {
    let mut model = empty(scheme, contact(0.0, 0.0, 0.0, 0.0));
    let step = std::f64::consts::PI * (0.5 * MASS / KN).sqrt() / per;
    model.plan.steps = (time / step).ceil() as u64;
    model.plan.step = time / model.plan.steps as f64;
    for i in 0..count {
        let place = Vec3::x() * ((2.0 * RADIUS + gap) * i as f64);
        let velocity = if i == 0 { Vec3::x() } else { Vec3::zeros() };
        add_sphere(&mut model, place, RADIUS, velocity, Vec3::zeros());
    }
    finish(&model).frames.last().expect("a frame").velocities.iter().map(|v| v.x).collect()
}

#[test]
fn cradles_end_as_they_should() {
    let five = [
        -0.132_279_484_709_707_69,
        -0.075_329_169_802_566_406,
        -0.031_010_829_014_029_06,
        0.296_217_750_141_438_68,
        0.942_401_733_384_864_48,
    ];
    let apart = [0.0, 0.0, 0.0, 0.0, 1.0];
    let cases: [(&[f64], f64, f64); 3] = [
        (&[0.0, 1.0], 0.0, 0.000_735_811_935_773_058_58 * 1.02),
        (&five, 0.0, 0.001_855_913_007_000_714_6 * 1.02),
        (&apart, 1e-3, 0.008),
    ];
    for (speeds, gap, time) in cases {
        for scheme in BOTH {
            let steps = [25.0, 50.0, 100.0];
            let errors = steps.map(|per| {
                let found = cradle(scheme, speeds.len(), gap, time, per);
                rms(found.iter().zip(speeds).map(|(a, b)| a - b))
            });
            assert!(errors[2] < 5e-4, "{scheme:?} {speeds:?} {errors:?}");
            assert!(order(&steps, &errors) > 1.3 || errors[2] < 1e-6, "{scheme:?} {errors:?}");
        }
    }
}

#[test]
fn stacks_stand_still_and_swing_at_their_frequency() {
    // Spheres on a floor of the same stiffness: number, height of the top, slowest frequency, √4/ω_max.
    let cases = [
        (2, 0.029_996_918_097_606_828, 1_909.844_686_620_596_5, 0.000_399_996_935_798_984_45),
        (10, 0.189_943_498_456_125_19, 461.860_916_275_428_9, 0.000_327_259_537_402_010_31),
    ];
    for (count, top, frequency, critical) in cases {
        let weight = MASS * 9.81 / KN;
        let mut heights = vec![RADIUS - count as f64 * weight];
        for i in 1..count {
            heights.push(heights[i - 1] + 2.0 * RADIUS - (count - i) as f64 * weight);
        }
        assert!((heights[count - 1] - top).abs() < 1e-15);
        for scheme in BOTH {
            let mut model = empty(scheme, contact(0.0, 0.0, 0.0, 0.0));
            model.gravity = Vec3::z() * -9.81;
            add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
            for height in &heights {
                add_sphere(&mut model, Vec3::z() * *height, RADIUS, Vec3::zeros(), Vec3::zeros());
            }
            let advice = advise(&model);
            let network = advice.network.expect("contacts");
            assert!(network <= critical * 1.000_1 && network > 0.8 * critical, "{network}");
            (model.plan.step, model.plan.steps) = (1e-5, 200);
            let rest = finish(&model);
            let moved = rest.frames[1].centres.iter().zip(&heights).map(|(c, z)| (c.z - z).abs());
            assert!(moved.fold(0.0, f64::max) < 1e-16 * 100.0);
            // The slowest mode, for a quarter of its period.
            let time = 0.5 * std::f64::consts::PI / frequency;
            model.plan.steps = 200;
            model.plan.step = time / 200.0;
            let shape =
                |i: usize| ((i + 1) as f64 * std::f64::consts::PI / (2 * count + 1) as f64).sin();
            for (i, body) in model.bodies.iter_mut().enumerate() {
                body.velocity.z = 1e-4 * shape(i);
            }
            let swung = finish(&model);
            for (i, centre) in swung.frames.last().expect("a frame").centres.iter().enumerate() {
                let right = 1e-4 * shape(i) / frequency;
                assert!((centre.z - heights[i] - right).abs() < 2e-4 * 1e-4 / frequency, "{i}");
            }
        }
    }
}

#[test]
fn a_kick_travels_along_a_chain() {
    // v_n = J_2n(2 ω₀ t) after a kick of the middle bead: bead, ω₀ t, v.
    let cases = [
        (0, 1.0, 0.223_890_779_141_235_67),
        (0, 10.0, 0.167_024_664_340_583_15),
        (1, 1.0, 0.352_834_028_615_637_72),
        (1, 10.0, -0.160_341_351_922_998_15),
        (2, 1.0, 0.033_995_719_807_568_434),
        (2, 10.0, 0.130_670_933_554_863_25),
        (5, 1.0, 2.515_386_282_716_736_7e-7),
        (5, 10.0, 0.186_482_558_023_945_08),
        (10, 1.0, 3.918_972_805_090_753_8e-19),
        (10, 10.0, 0.164_747_773_775_326_53),
        (20, 1.0, 1.196_077_458_113_680_1e-48),
        (20, 10.0, 9.902_389_413_744_686_1e-10),
    ];
    let (frequency, kick, half) = ((KN / MASS).sqrt(), 1e-3, 25usize);
    for scheme in BOTH {
        let run_to = |time: f64, per: u64| {
            let mut model = empty(scheme, contact(0.0, 0.0, 0.0, 0.0));
            let (count, depth) = (2 * half + 1, 1e-5);
            let spacing = 2.0 * RADIUS - depth;
            for i in 0..count {
                let velocity = if i == half { Vec3::x() * kick } else { Vec3::zeros() };
                add_sphere(
                    &mut model,
                    Vec3::x() * (spacing * i as f64),
                    RADIUS,
                    velocity,
                    Vec3::zeros(),
                );
            }
            let end = RADIUS - depth;
            add_plane(&mut model, -Vec3::x() * end, Vec3::x(), Motion::Still);
            let last = spacing * (count - 1) as f64 + end;
            add_plane(&mut model, Vec3::x() * last, -Vec3::x(), Motion::Still);
            model.domain.high.x = 3.0;
            model.plan.steps = per;
            model.plan.step = time / frequency / per as f64;
            finish(&model).frames.last().expect("a frame").velocities.clone()
        };
        for time in [1.0, 10.0] {
            let steps = [100.0, 200.0, 400.0];
            let errors = steps.map(|per| {
                let speeds = run_to(time, per as u64);
                let mine = cases.iter().filter(|case| case.1 == time);
                rms(mine.map(|(bead, _, v)| speeds[half + bead].x / kick - v))
            });
            assert!(errors[2] < 3e-4, "{scheme:?} {time} {errors:?}");
            assert!(order(&steps, &errors) > 1.8, "{scheme:?} {time} {errors:?}");
        }
    }
}
