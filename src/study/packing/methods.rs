//! What each method makes of equal balls (or one mixture): means over seeds beside what is known.

use super::super::{StudyError, go_on, models, timed};
use super::{Case, Row};
use crate::dem;
use crate::geometry::{Ball, BallGrid};
use crate::num::random::{stream, uniform};
use crate::num::units::Pressure;
use crate::num::{Job, Vec3};
use crate::pack::compression::{Compression, Until};
use crate::pack::drop_and_roll::DropAndRoll;
use crate::pack::radius_expansion::RadiusExpansion;
use crate::pack::soft::{Rest, Soft};
use crate::pack::space::Space;
use crate::pack::touch_and_stop::{Rule, grow};
use crate::pack::{apollonian, force_biased, random_apollonian, saturation};
use crate::report::chart::Series;
use std::f64::consts::PI;

/// Samples of other seeds that figures are means of.
pub fn samples(full: bool) -> u64 {
    if full { 5 } else { 1 }
}

/// All methods; shares of pores for the chart.
pub fn all(full: bool, job: &Job, rows: &mut Vec<Row>) -> Result<Vec<Series>, StudyError> {
    let mut pores = Vec::new();
    apollonian_counts(full, rows);
    for dimension in [2, 3] {
        pores.push(random_apollonian_pores(dimension, full, job, rows)?);
        saturated(dimension, full, job, rows)?;
        together(dimension, full, job, rows)?;
        grown(dimension, full, job, rows)?;
    }
    dense(full, job, rows)?;
    isostatic(full, job, rows)?;
    for dimension in [2, 3] {
        rolled(dimension, full, job, rows)?;
    }
    compressed(full, job, rows)?;
    Ok(pores)
}

/// What `one` finds with seeds 1 to `samples`, and the CPU seconds of each.
pub fn sampled<T>(
    samples: u64,
    job: &Job,
    mut one: impl FnMut(u64) -> T,
) -> Result<(Vec<T>, Vec<f64>), StudyError> {
    let (mut found, mut seconds) = (Vec::new(), Vec::new());
    for seed in 1..=samples {
        go_on(job)?;
        let (value, spent) = timed(|| one(seed));
        found.push(value);
        seconds.push(spent);
    }
    Ok((found, seconds))
}

/// Volume (area) of a ball of radius 1.
pub fn unit_ball(dimension: usize) -> f64 {
    if dimension == 2 { PI } else { 4.0 / 3.0 * PI }
}

fn ball_share(balls: &[Ball], dimension: usize) -> f64 {
    unit_ball(dimension) * balls.iter().map(|ball| ball.radius.powi(dimension as i32)).sum::<f64>()
}

/// A box of edge 1 whose sides repeat.
pub fn unit_box(dimension: usize) -> Space<'static> {
    Space::repeating(dimension, Vec3::repeat(1.0))
}

/// Spheres that our own DEM compresses at some frictions.
fn compressed(full: bool, job: &Job, rows: &mut Vec<Row>) -> Result<(), StudyError> {
    // Agnolin & Roux 2007 (Phys. Rev. E 76, 061302): isotropic compression of 4000 spheres at small stress, the very
    // protocol. How loose friction leaves a packing depends on it, so no other source is a reference here.
    let cases: &[(f64, f64, f64)] = if full {
        &[
            (0.0, 0.639, 6.0),
            (0.1, f64::NAN, f64::NAN),
            (0.3, 0.593, 4.5),
            (1.0, f64::NAN, f64::NAN),
        ]
    } else {
        &[(0.0, 0.639, 6.0), (0.3, 0.593, 4.5)]
    };
    let count = if full { 1000 } else { 300 };
    for &(friction, fraction, contacts) in cases {
        let wanted = Compression {
            // Overlaps of about 1e-4 of the radius.
            until: Until::Stress(Pressure(25.0)),
            friction,
            tolerance: 0.05,
            ..Compression::default()
        };
        let (done, seconds) = sampled(samples(full), job, |seed| {
            let model = models::loose_spheres(count, 0.3, friction, seed);
            dem::compress(&model, 1.0, 0.3, &wanted, job)
        })?;
        let done = done.into_iter().collect::<Result<Vec<_>, _>>();
        let done = done.map_err(|error| StudyError::Work(error.to_string()))?;
        let case = Case {
            method: "compression",
            dimension: 3,
            balls: count,
            setting: format!("friction {friction}"),
            seconds,
        };
        let solid: Vec<f64> = done.iter().map(|done| 0.3 * done.scale.powi(3)).collect();
        let touching: Vec<f64> = done.iter().map(|done| done.coordination).collect();
        let without = "Agnolin & Roux 2007, without rattlers";
        rows.push(case.row("solid fraction", &solid, (fraction, "Agnolin & Roux 2007")));
        rows.push(case.row("contacts a ball", &touching, (contacts, without)));
    }
    Ok(())
}

/// Counts up to a bend, exact, and the slope of the last octave or decade.
fn apollonian_counts(full: bool, rows: &mut Vec<Row>) {
    let flat: &[(f64, f64)] = if full {
        &[(1e3, 3328.0), (1e4, 67_166.0), (1e5, 1_359_170.0), (1e6, 27_463_394.0)]
    } else {
        &[(1e3, 3328.0), (1e4, 67_166.0), (1e5, 1_359_170.0)]
    };
    let solid: &[(f64, f64)] = if full {
        &[(40.0, 2069.0), (80.0, 11_537.0), (160.0, 63_851.0), (320.0, f64::NAN)]
    } else {
        &[(40.0, 2069.0), (80.0, 11_537.0), (160.0, 63_851.0)]
    };
    for (dimension, limits, slope, source) in [
        (2, flat, 1.305_688, "McMullen 1998"),
        (3, solid, 2.473_946_5, "Borkovec, De Paris & Peikert 1994"),
    ] {
        let mut counts: Vec<(f64, f64)> = Vec::new();
        let mut last = 0.0;
        let case = |balls, setting, seconds| Case {
            method: "apollonian",
            dimension,
            balls,
            setting,
            seconds: vec![seconds],
        };
        for &(limit, expected) in limits {
            let (count, seconds) = timed(|| apollonian_count(dimension, limit));
            counts.push((limit, count as f64));
            last = seconds;
            let known = (expected, "exact, own program of another make");
            let case = case(count, format!("bends up to {limit}"), seconds);
            rows.push(case.row("number of balls", &[count as f64], known));
        }
        if let [.., (a, m), (b, n)] = counts.as_slice() {
            let case = case(*n as usize, format!("bends {a} to {b}"), last);
            rows.push(case.row("dimension", &[(n / m).ln() / (b / a).ln()], (slope, source)));
        }
    }
}

fn apollonian_count(dimension: usize, limit: f64) -> usize {
    if dimension == 3 {
        return apollonian::balls(limit, usize::MAX).len();
    }
    let mut count = 0;
    apollonian::discs(apollonian::Start::Integer, limit, |_| {
        count += 1;
        true
    });
    count
}

/// Shares of pores against N; the curve for the chart.
fn random_apollonian_pores(
    dimension: usize,
    full: bool,
    job: &Job,
    rows: &mut Vec<Row>,
) -> Result<Series, StudyError> {
    let (cap, expected): (f64, [f64; 4]) = match dimension {
        2 => (0.05, [0.2704, 0.1481, 0.08288, 0.04651]),
        _ => (0.03, [0.9115, 0.7136, 0.5622, 0.4550]),
    };
    let known = [1000, 8000, 64_000, 512_000].into_iter().zip(expected);
    let mut all = Vec::new();
    let mut before: Option<(usize, Vec<f64>)> = None;
    for (count, reference) in known.take(if full { 4 } else { 3 }) {
        // One small sample scatters by more than 1 %.
        let samples = if count <= 1000 { 10 } else { samples(full) };
        let (found, seconds) = sampled(samples, job, |seed| {
            let space = unit_box(dimension);
            random_apollonian::grown(&space, count, cap, 0.0, 1_000_000, seed, job).0
        })?;
        let pores: Vec<f64> =
            found.iter().map(|balls| 1.0 - ball_share(balls, dimension)).collect();
        all = found.into_iter().next().unwrap_or_default();
        let case = |setting| Case {
            method: "random_apollonian",
            dimension,
            balls: count,
            setting,
            seconds: seconds.clone(),
        };
        let known = (reference, "8.2 million balls, own program of another make");
        rows.push(case(format!("radius up to {cap}")).row("share of pores", &pores, known));
        if let Some((earlier, free)) = before.filter(|_| count >= 64_000) {
            let slopes: Vec<f64> = free
                .iter()
                .zip(&pores)
                .map(|(&a, &b)| decay_dimension((earlier, a), (count, b), dimension))
                .collect();
            let expected = if dimension == 2 { 1.5653 } else { 2.733 };
            let known = (expected, "Manna 1992; Dodds & Weitz 2002; 8.2 million balls");
            rows.push(case(format!("N from {earlier} to {count}")).row(
                "dimension",
                &slopes,
                known,
            ));
        }
        before = Some((count, pores));
    }
    let mut points = Vec::new();
    let mut next = 10.0_f64;
    let mut free = 1.0;
    for (index, ball) in all.iter().enumerate() {
        free -= ball_share(std::slice::from_ref(ball), dimension);
        if (index + 1) as f64 >= next {
            points.push(((index + 1) as f64, free));
            next *= 1.3;
        }
    }
    Ok(Series { name: format!("{dimension} dimensions"), points, dots: true })
}

/// D from P ~ N^(−(d − D)/D).
fn decay_dimension(before: (usize, f64), after: (usize, f64), dimension: usize) -> f64 {
    let slope = (after.1 / before.1).ln() / (after.0 as f64 / before.0 as f64).ln();
    dimension as f64 / (1.0 - slope)
}

/// Limit of random sequential addition.
fn saturated(
    dimension: usize,
    full: bool,
    job: &Job,
    rows: &mut Vec<Row>,
) -> Result<(), StudyError> {
    let reference = if dimension == 2 { 0.5471 } else { 0.3841 };
    let sizes: &[(f64, u64)] = match (dimension, full) {
        (2, false) => &[(0.012, 300_000), (0.006, 2_000_000)],
        (2, true) => &[(0.012, 300_000), (0.006, 3_000_000), (0.003, 20_000_000)],
        (_, false) => &[(0.05, 200_000), (0.03, 2_000_000)],
        (_, true) => &[(0.05, 200_000), (0.03, 3_000_000), (0.018, 20_000_000)],
    };
    for &(radius, tries) in sizes {
        let (histories, seconds) = sampled(samples(full), job, |seed| {
            saturation::history(&unit_box(dimension), radius, tries, seed, job)
        })?;
        let limits: Vec<f64> =
            histories.iter().filter_map(|points| saturation::limit(points, dimension)).collect();
        let volume = unit_ball(dimension) * radius.powi(dimension as i32);
        let filled = histories.first().and_then(|points| points.last()).map_or(0.0, |last| last.1);
        let case = Case {
            method: "random",
            dimension,
            balls: (filled / volume).round() as usize,
            setting: format!("{tries} tries (extrapolated)"),
            seconds,
        };
        let known = (reference, "Feder 1980; Torquato, Uche & Stillinger 2006");
        rows.push(case.row("solid fraction", &limits, known));
    }
    Ok(())
}

/// Balls that are born together.
fn together(
    dimension: usize,
    full: bool,
    job: &Job,
    rows: &mut Vec<Row>,
) -> Result<(), StudyError> {
    let reference = if dimension == 2 { 0.349 } else { 0.186 };
    for count in [1000, 10_000, 100_000].into_iter().take(if full { 3 } else { 2 }) {
        let rule = Rule { births: None, slowest: 1.0, cap: f64::MAX, tries: 1 };
        let (shares, seconds) = sampled(samples(full), job, |seed| {
            ball_share(&grow(&unit_box(dimension), count, &rule, seed, job).0, dimension)
        })?;
        let case = Case {
            method: "simultaneous_growth",
            dimension,
            balls: count,
            setting: "born together".into(),
            seconds,
        };
        rows.push(case.row("solid fraction", &shares, (reference, "Daley, Stoyan & Stoyan 1999")));
    }
    Ok(())
}

/// Dimensions of growth with births all the time: from the decay of pores with N at one birth rate.
fn grown(dimension: usize, full: bool, job: &Job, rows: &mut Vec<Row>) -> Result<(), StudyError> {
    let counts: &[usize] =
        if full { &[500, 2000, 8000, 32_000, 128_000] } else { &[500, 2000, 8000, 32_000] };
    for (method, slowest, source) in [
        ("simultaneous_growth", 1.0, "as for random_apollonian (one class of growth)"),
        ("packing_limited_growth", 0.1, "Dodds & Weitz 2002"),
    ] {
        let mut before: Option<(usize, Vec<f64>)> = None;
        for &count in counts {
            // Births a unit of time such that about fifty balls grow at a time at first.
            let rule = Rule { births: Some(2000.0), slowest, cap: f64::MAX, tries: 1_000_000 };
            let (pores, seconds) = sampled(samples(full), job, |seed| {
                let balls = grow(&unit_box(dimension), count, &rule, seed, job).0;
                1.0 - ball_share(&balls, dimension)
            })?;
            if let Some((earlier, free)) = before {
                let slopes: Vec<f64> = free
                    .iter()
                    .zip(&pores)
                    .map(|(&a, &b)| decay_dimension((earlier, a), (count, b), dimension))
                    .collect();
                let setting = format!("N from {earlier} to {count}");
                let case = Case { method, dimension, balls: count, setting, seconds };
                let expected = if dimension == 2 { 1.564 } else { 2.733 };
                rows.push(case.row("dimension", &slopes, (expected, source)));
            }
            before = Some((count, pores));
        }
    }
    Ok(())
}

/// Force-biased packings of equal spheres.
fn dense(full: bool, job: &Job, rows: &mut Vec<Row>) -> Result<(), StudyError> {
    let cases: &[(usize, f64, f64)] = if full {
        &[
            (1000, 1e-2, 0.5127),
            (1000, 1e-3, 0.6064),
            (1000, 1e-4, 0.6377),
            (10_000, 1e-3, 0.6054),
            (10_000, 1e-4, 0.6366),
            (10_000, 7e-5, f64::NAN),
        ]
    } else {
        &[(1000, 1e-2, 0.5127), (1000, 1e-3, 0.6064), (1000, 1e-4, 0.6377)]
    };
    for &(count, rate, reference) in cases {
        let radii = vec![1.0; count];
        let (found, seconds) = sampled(samples(full), job, |seed| {
            force_biased::densest(&unit_box(3), &radii, rate, f64::INFINITY, seed, job)
                .map(|found| unit_ball(3) * found.factor.powi(3) * count as f64)
        })?;
        let shares: Vec<f64> = found.into_iter().flatten().collect();
        let case = Case {
            method: "force_biased",
            dimension: 3,
            balls: count,
            setting: format!("rate {rate:.0e}"),
            seconds,
        };
        let known = (reference, "PackingGeneration (Baranau), measured");
        rows.push(case.row("solid fraction", &shares, known));
    }
    Ok(())
}

/// Contacts of frictionless balls that have just jammed: 2 d without rattlers.
fn isostatic(full: bool, job: &Job, rows: &mut Vec<Row>) -> Result<(), StudyError> {
    for dimension in [2, 3] {
        for count in [300, 1000, 4000].into_iter().take(if full { 3 } else { 2 }) {
            let (found, seconds) =
                sampled(samples(full), job, |seed| jammed(dimension, count, seed, job))?;
            let setting = match dimension {
                2 => "just jammed (sizes 1 and 1.4)",
                _ => "just jammed",
            };
            let case = Case {
                method: "radius_expansion",
                dimension,
                balls: count,
                setting: setting.into(),
                seconds,
            };
            let (fractions, contacts): (Vec<f64>, Vec<f64>) = found.into_iter().unzip();
            let isostatic = (2.0 * dimension as f64, "isostatic, without rattlers");
            rows.push(case.row("contacts a ball", &contacts, isostatic));
            let known = if dimension == 2 { 0.84 } else { 0.639 };
            rows.push(case.row("solid fraction", &fractions, (known, "O'Hern et al. 2003")));
        }
    }
    Ok(())
}

/// Solid fraction and contacts a ball where balls have just jammed.
fn jammed(dimension: usize, count: usize, seed: u64, job: &Job) -> (f64, f64) {
    let sizes: Vec<f64> =
        (0..count).map(|i| if dimension == 2 && i % 2 == 0 { 1.4 } else { 1.0 }).collect();
    let unit = unit_ball(dimension);
    let start = if dimension == 2 { 0.86 } else { 0.665 };
    let sum: f64 = sizes.iter().map(|r| unit * r.powi(dimension as i32)).sum();
    let factor = (start / sum).powf(1.0 / dimension as f64);
    let radii: Vec<f64> = sizes.iter().map(|r| r * factor).collect();
    let method = RadiusExpansion { steps: 20_000, ..RadiusExpansion::default() };
    let Some((mut soft, mut relaxed)) = method.expand(&unit_box(dimension), &radii, seed, job)
    else {
        return (f64::NAN, f64::NAN);
    };
    let fraction =
        |soft: &Soft| unit * soft.radii.iter().map(|r| r.powi(dimension as i32)).sum::<f64>();
    let mut last = (f64::NAN, f64::NAN);
    for _ in 0..60 {
        if relaxed.rest == Rest::Apart || relaxed.worst < 1e-4 || job.is_cancelled() {
            break;
        }
        last = (fraction(&soft), soft.coordination(0.0).0);
        soft.grow(1.0 - 0.08 * relaxed.worst);
        relaxed = soft.relax(1e-6, 1e-4, 5000, job);
    }
    last
}

/// Drop and roll: core of a box, layers next to walls left out.
fn rolled(dimension: usize, full: bool, job: &Job, rows: &mut Vec<Row>) -> Result<(), StudyError> {
    let counts: &[usize] = match (dimension, full) {
        (2, _) => &[500, 3000],
        (_, false) => &[2000],
        (_, true) => &[2000, 10_000, 30_000],
    };
    for &count in counts {
        // As wide as high.
        let share = if dimension == 2 { 0.80 } else { 0.56 };
        let radius = (share / unit_ball(dimension) / count as f64).powf(1.0 / dimension as f64);
        let mut space = unit_box(dimension);
        space.periodic = [false; 3];
        space.bounds.high[dimension - 1] = 1.5;
        let radii = vec![radius; count];
        let (found, seconds) = sampled(samples(full), job, |seed| {
            DropAndRoll::default().settle(space, &radii, seed, job).0
        })?;
        let (fractions, contacts): (Vec<f64>, Vec<f64>) = found
            .into_iter()
            .map(|found| {
                let balls: Vec<Ball> = found.into_iter().map(|(_, ball)| ball).collect();
                core(&balls, dimension, 4.0 * radius, 0.85)
            })
            .unzip();
        let case = Case {
            method: "drop_and_roll",
            dimension,
            balls: count,
            setting: "core (two diameters off the walls)".into(),
            seconds,
        };
        let known = (if dimension == 2 { 0.82 } else { 0.582 }, "Visscher & Bolsterli 1972");
        rows.push(case.row("solid fraction", &fractions, known));
        let built = (2.0 * dimension as f64, "by construction");
        rows.push(case.row("contacts a ball", &contacts, built));
    }
    Ok(())
}

/// Solid fraction and contacts a ball in the middle of a bed, up to a height.
fn core(balls: &[Ball], dimension: usize, margin: f64, top: f64) -> (f64, f64) {
    let up = dimension - 1;
    let inside = |p: &Vec3| {
        (0..dimension).all(|axis| {
            let high = if axis == up { top } else { 1.0 };
            (margin..high - margin).contains(&p[axis])
        })
    };
    let mut grid = BallGrid::new(margin * 0.25);
    balls.iter().for_each(|ball| {
        grid.insert(ball.centre, ball.radius);
    });
    let mut source = stream(0, "study.core", 0);
    let (mut solid, points) = (0_u32, 200_000_u32);
    for _ in 0..points {
        let mut point = Vec3::zeros();
        for axis in 0..dimension {
            let high = if axis == up { top } else { 1.0 };
            point[axis] = uniform(&mut source, margin, high - margin);
        }
        solid += u32::from(grid.any_near(&point, 0.0));
    }
    let (mut contacts, mut count) = (0_usize, 0_usize);
    for (index, ball) in balls.iter().enumerate().filter(|(_, ball)| inside(&ball.centre)) {
        count += 1;
        grid.near(&ball.centre, ball.radius * (1.0 + 1e-6), |other, _| {
            contacts += usize::from(other as usize != index);
            true
        });
    }
    (f64::from(solid) / f64::from(points), contacts as f64 / count.max(1) as f64)
}
