//! Packing methods against what is known of them, over CPU time and number of balls.
//!
//! Solid fractions, shares of pores, dimensions and coordination numbers in boxes whose sides
//! repeat (drop and roll: the core of a box). References are published, or measured with
//! programs of another make (said in the table). CPU time is that of this process.

use super::{Effort, StudyError, go_on, models, timed};
use crate::dem;
use crate::geometry::Ball;
use crate::num::units::Pressure;
use crate::num::{Job, Vec3};
use crate::pack::compression::{Compression, Until};
use crate::pack::drop_and_roll::DropAndRoll;
use crate::pack::moving_boundary::MovingBoundary;
use crate::pack::radius_expansion::RadiusExpansion;
use crate::pack::soft::{Rest, Soft};
use crate::pack::space::Space;
use crate::pack::touch_and_stop::{Rule, grow};
use crate::pack::{apollonian, force_biased, random_apollonian, saturation};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::curves::work_precision;
use crate::report::findings::{Findings, Sheet};
use std::f64::consts::PI;

/// One figure of one method.
struct Row {
    method: &'static str,
    dimension: usize,
    balls: usize,
    setting: String,
    quantity: &'static str,
    found: f64,
    reference: f64,
    source: &'static str,
    seconds: f64,
}

/// See [`super::STUDIES`].
pub fn study(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    let full = effort == Effort::Full;
    let mut rows = Vec::new();
    let mut pores = Vec::new();
    apollonian_counts(full, &mut rows);
    for dimension in [2, 3] {
        go_on(job)?;
        pores.push(random_apollonian_pores(dimension, full, job, &mut rows)?);
        go_on(job)?;
        saturated(dimension, full, job, &mut rows)?;
        go_on(job)?;
        together(dimension, full, job, &mut rows);
        grown(dimension, full, job, &mut rows)?;
    }
    go_on(job)?;
    dense(full, job, &mut rows)?;
    go_on(job)?;
    isostatic(full, job, &mut rows)?;
    go_on(job)?;
    for dimension in [2, 3] {
        rolled(dimension, full, job, &mut rows);
    }
    go_on(job)?;
    compressed(full, job, &mut rows)?;
    let faults = faults(full, job)?;
    Ok(findings(&rows, pores, &faults))
}

/// Spheres and discs that our own DEM compresses at some frictions.
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
        go_on(job)?;
        let model = models::loose_spheres(count, 0.3, friction);
        let wanted = Compression {
            // Overlaps of about 1e-4 of the radius.
            until: Until::Stress(Pressure(25.0)),
            friction,
            tolerance: 0.05,
            ..Compression::default()
        };
        let (done, seconds) = timed(|| dem::compress(&model, 1.0, 0.3, &wanted, job));
        let done = done.map_err(|error| StudyError::Work(error.to_string()))?;
        let mut row = |quantity, found, reference, source| {
            rows.push(Row {
                method: "compression",
                dimension: 3,
                balls: count,
                setting: format!("friction {friction}"),
                quantity,
                found,
                reference,
                source,
                seconds,
            });
        };
        row("solid fraction", 0.3 * done.scale.powi(3), fraction, "Agnolin & Roux 2007");
        row(
            "contacts a ball",
            done.coordination,
            contacts,
            "Agnolin & Roux 2007, without rattlers",
        );
    }
    Ok(())
}

/// What the moving boundary costs and does, beside radius expansion to the same solid fraction.
struct Fault {
    fraction: f64,
    way: f64,
    steps: u64,
    other_steps: u64,
    beside: f64,
    middle: f64,
}

/// The three faults of the moving boundary: another boundary, slow, uneven.
fn faults(full: bool, job: &Job) -> Result<Vec<Fault>, StudyError> {
    let count = if full { 2000 } else { 500 };
    let mut found = Vec::new();
    for fraction in [0.40, 0.50, 0.56] {
        go_on(job)?;
        let mut space = unit_box(3);
        space.periodic = [false; 3];
        let radius = (fraction / (4.0 / 3.0 * PI) / count as f64).cbrt();
        let radii = vec![radius; count];
        // One lid, as in most uses.
        let lid = [[false; 2], [false; 2], [false, true]];
        let method = MovingBoundary::default();
        let Some(pressed) = method.press(&space, &lid, &radii, fraction, 1, job) else { continue };
        let even = RadiusExpansion { steps: method.steps, ..RadiusExpansion::default() };
        let Some((_, relaxed)) = even.expand(&space, &radii, 1, job) else { continue };
        found.push(Fault {
            fraction,
            way: pressed.way[2],
            steps: pressed.relaxed.steps,
            other_steps: relaxed.steps,
            beside: pressed.fractions.0,
            middle: pressed.fractions.1,
        });
    }
    Ok(found)
}

fn faults_sheet(faults: &[Fault]) -> Sheet {
    let columns = [
        "solid fraction",
        "way of the lid over the height",
        "relaxation steps",
        "radius expansion",
        "solid fraction beside the lid",
        "in the middle",
    ];
    Sheet {
        key: "moving-boundary".into(),
        title:
            "What the moving boundary costs: a boundary that is not that of the start, slow, uneven"
                .into(),
        caption: "One lid comes down on equal spheres. Beside: one to three radii off it.".into(),
        columns: columns.map(String::from).to_vec(),
        rows: faults
            .iter()
            .map(|fault| {
                vec![
                    fault.fraction.into(),
                    fault.way.into(),
                    fault.steps.into(),
                    fault.other_steps.into(),
                    fault.beside.into(),
                    fault.middle.into(),
                ]
            })
            .collect(),
    }
}

fn faults_charts(faults: &[Fault]) -> Vec<(String, Chart)> {
    let line = |name: &str, of: fn(&Fault) -> f64| Series {
        name: name.into(),
        points: faults.iter().map(|fault| (fault.fraction, of(fault))).collect(),
        dots: true,
    };
    let chart = |title: &str, y: Axis, series| Chart {
        title: title.into(),
        caption: "Equal spheres under one lid.".into(),
        x: Axis::linear("solid fraction", ""),
        y,
        series,
        mark: None,
    };
    vec![
        (
            "moving-boundary-steps".into(),
            chart(
                "Moving boundary: relaxation steps",
                Axis::log("steps", ""),
                vec![
                    line("moving boundary", |f| f.steps as f64),
                    line("radius expansion", |f| f.other_steps as f64),
                ],
            ),
        ),
        (
            "moving-boundary-evenness".into(),
            chart(
                "Moving boundary: solid fraction beside the lid and in the middle",
                Axis::linear("solid fraction there", ""),
                vec![line("beside the lid", |f| f.beside), line("in the middle", |f| f.middle)],
            ),
        ),
    ]
}

fn ball_share(balls: &[Ball], dimension: usize) -> f64 {
    let unit = if dimension == 2 { PI } else { 4.0 / 3.0 * PI };
    unit * balls.iter().map(|ball| ball.radius.powi(dimension as i32)).sum::<f64>()
}

fn unit_box(dimension: usize) -> Space<'static> {
    Space::repeating(dimension, Vec3::repeat(1.0))
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
        for &(limit, expected) in limits {
            let (count, seconds) = timed(|| match dimension {
                2 => {
                    let mut count = 0_usize;
                    apollonian::discs(apollonian::Start::Integer, limit, |_| {
                        count += 1;
                        true
                    });
                    count
                }
                _ => apollonian::balls(limit, usize::MAX).len(),
            });
            counts.push((limit, count as f64));
            rows.push(Row {
                method: "apollonian",
                dimension,
                balls: count,
                setting: format!("bends up to {limit}"),
                quantity: "number of balls",
                found: count as f64,
                reference: expected,
                source: "exact, own program of another make",
                seconds,
            });
        }
        if let [.., (a, m), (b, n)] = counts.as_slice() {
            rows.push(Row {
                method: "apollonian",
                dimension,
                balls: *n as usize,
                setting: format!("bends {a} to {b}"),
                quantity: "dimension",
                found: (n / m).ln() / (b / a).ln(),
                reference: slope,
                source,
                seconds: rows.last().map_or(0.0, |row| row.seconds),
            });
        }
    }
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
    let known: Vec<(usize, f64)> = known.take(if full { 4 } else { 3 }).collect();
    let mut all = Vec::new();
    let mut measured: Vec<(usize, f64)> = Vec::new();
    for &(count, reference) in &known {
        // One small sample scatters by more than 1 %.
        let samples = if count <= 1000 { 10 } else { 1 };
        let (mut found, mut seconds) = (0.0, 0.0);
        for seed in 1..=samples {
            let ((balls, _), spent) = timed(|| {
                random_apollonian::grown(
                    &unit_box(dimension),
                    count,
                    cap,
                    0.0,
                    1_000_000,
                    seed,
                    job,
                )
            });
            go_on(job)?;
            found += (1.0 - ball_share(&balls, dimension)) / samples as f64;
            seconds += spent / samples as f64;
            all = balls;
        }
        measured.push((count, found));
        rows.push(Row {
            method: "random_apollonian",
            dimension,
            balls: count,
            setting: match samples {
                1 => format!("radius up to {cap}"),
                _ => format!("radius up to {cap} (mean of {samples})"),
            },
            quantity: "share of pores",
            found,
            reference,
            source: "8.2 million balls, own program of another make",
            seconds,
        });
    }
    if let [.., (m, before), (n, after)] = measured.as_slice() {
        rows.push(Row {
            method: "random_apollonian",
            dimension,
            balls: *n,
            setting: format!("N from {m} to {n}"),
            quantity: "dimension",
            found: decay_dimension((*m, *before), (*n, *after), dimension),
            reference: if dimension == 2 { 1.5653 } else { 2.733 },
            source: "Manna 1992; Dodds & Weitz 2002; 8.2 million balls",
            seconds: rows.last().map_or(0.0, |row| row.seconds),
        });
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
        let (points, seconds) =
            timed(|| saturation::history(&unit_box(dimension), radius, tries, 1, job));
        go_on(job)?;
        let Some(found) = saturation::limit(&points, dimension) else { continue };
        let volume = ball_share(&[Ball { centre: Vec3::zeros(), radius }], dimension);
        rows.push(Row {
            method: "random",
            dimension,
            balls: (points.last().map_or(0.0, |point| point.1) / volume).round() as usize,
            setting: format!("{tries} tries (extrapolated)"),
            quantity: "solid fraction",
            found,
            reference,
            source: "Feder 1980; Torquato, Uche & Stillinger 2006",
            seconds,
        });
    }
    Ok(())
}

/// Balls that are born together.
fn together(dimension: usize, full: bool, job: &Job, rows: &mut Vec<Row>) {
    let reference = if dimension == 2 { 0.349 } else { 0.186 };
    for count in [1000, 10_000, 100_000].into_iter().take(if full { 3 } else { 2 }) {
        let rule = Rule { births: None, slowest: 1.0, cap: f64::MAX, tries: 1 };
        let ((balls, _), seconds) = timed(|| grow(&unit_box(dimension), count, &rule, 1, job));
        rows.push(Row {
            method: "simultaneous_growth",
            dimension,
            balls: count,
            setting: "born together".into(),
            quantity: "solid fraction",
            found: ball_share(&balls, dimension),
            reference,
            source: "Daley, Stoyan & Stoyan 1999",
            seconds,
        });
    }
}

/// Dimensions of growth with births all the time: from the decay of pores with N at one birth rate.
fn grown(dimension: usize, full: bool, job: &Job, rows: &mut Vec<Row>) -> Result<(), StudyError> {
    let counts: &[usize] =
        if full { &[500, 2000, 8000, 32_000, 128_000] } else { &[500, 2000, 8000, 32_000] };
    for (method, slowest, source) in [
        ("simultaneous_growth", 1.0, "as for random_apollonian (one class of growth)"),
        ("packing_limited_growth", 0.1, "Dodds & Weitz 2002"),
    ] {
        let mut before: Option<(usize, f64)> = None;
        for &count in counts {
            go_on(job)?;
            // Births a unit of time such that about fifty balls grow at a time at first.
            let rule = Rule { births: Some(2000.0), slowest, cap: f64::MAX, tries: 1_000_000 };
            let ((balls, _), seconds) = timed(|| grow(&unit_box(dimension), count, &rule, 1, job));
            let free = 1.0 - ball_share(&balls, dimension);
            if let Some(earlier) = before {
                rows.push(Row {
                    method,
                    dimension,
                    balls: count,
                    setting: format!("N from {} to {count}", earlier.0),
                    quantity: "dimension",
                    found: decay_dimension(earlier, (count, free), dimension),
                    reference: if dimension == 2 { 1.564 } else { 2.733 },
                    source,
                    seconds,
                });
            }
            before = Some((count, free));
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
            (10_000, 1e-4, 6366.0 / 1e4),
        ]
    } else {
        &[(1000, 1e-2, 0.5127), (1000, 1e-3, 0.6064), (1000, 1e-4, 0.6377)]
    };
    for &(count, rate, reference) in cases {
        go_on(job)?;
        let radii = vec![1.0; count];
        let space = unit_box(3);
        let (found, seconds) =
            timed(|| force_biased::densest(&space, &radii, rate, f64::INFINITY, 1, job));
        let Some(found) = found else { continue };
        rows.push(Row {
            method: "force_biased",
            dimension: 3,
            balls: count,
            setting: format!("rate {rate:.0e}"),
            quantity: "solid fraction",
            found: 4.0 / 3.0 * PI * found.factor.powi(3) * count as f64,
            reference,
            source: "PackingGeneration (Baranau), measured",
            seconds,
        });
    }
    Ok(())
}

/// Contacts of frictionless balls that have just jammed: 2 d without rattlers.
fn isostatic(full: bool, job: &Job, rows: &mut Vec<Row>) -> Result<(), StudyError> {
    for dimension in [2, 3] {
        for count in [300, 1000, 4000].into_iter().take(if full { 3 } else { 2 }) {
            go_on(job)?;
            let ((fraction, contacts), seconds) = timed(|| jammed(dimension, count, job));
            let mut row = |quantity, found, reference, source| {
                rows.push(Row {
                    method: "radius_expansion",
                    dimension,
                    balls: count,
                    setting: match dimension {
                        2 => "just jammed (sizes 1 and 1.4)".into(),
                        _ => "just jammed".into(),
                    },
                    quantity,
                    found,
                    reference,
                    source,
                    seconds,
                });
            };
            row("contacts a ball", contacts, 2.0 * dimension as f64, "isostatic, without rattlers");
            let known = if dimension == 2 { 0.84 } else { 0.639 };
            row("solid fraction", fraction, known, "O'Hern et al. 2003");
        }
    }
    Ok(())
}

/// Solid fraction and contacts a ball where balls have just jammed.
fn jammed(dimension: usize, count: usize, job: &Job) -> (f64, f64) {
    let sizes: Vec<f64> =
        (0..count).map(|i| if dimension == 2 && i % 2 == 0 { 1.4 } else { 1.0 }).collect();
    let unit = if dimension == 2 { PI } else { 4.0 / 3.0 * PI };
    let start = if dimension == 2 { 0.86 } else { 0.665 };
    let sum: f64 = sizes.iter().map(|r| unit * r.powi(dimension as i32)).sum();
    let factor = (start / sum).powf(1.0 / dimension as f64);
    let radii: Vec<f64> = sizes.iter().map(|r| r * factor).collect();
    let method = RadiusExpansion { steps: 20_000, ..RadiusExpansion::default() };
    let Some((mut soft, mut relaxed)) = method.expand(&unit_box(dimension), &radii, 1, job) else {
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
fn rolled(dimension: usize, full: bool, job: &Job, rows: &mut Vec<Row>) {
    let counts: &[usize] = match (dimension, full) {
        (2, _) => &[500, 3000],
        (_, false) => &[2000],
        (_, true) => &[2000, 10_000, 30_000],
    };
    for &count in counts {
        // As wide as high.
        let share = if dimension == 2 { 0.80 } else { 0.56 };
        let unit = if dimension == 2 { PI } else { 4.0 / 3.0 * PI };
        let radius = (share / unit / count as f64).powf(1.0 / dimension as f64);
        let mut space = unit_box(dimension);
        space.periodic = [false; 3];
        space.bounds.high[dimension - 1] = 1.5;
        let radii = vec![radius; count];
        let ((found, _), seconds) = timed(|| DropAndRoll::default().settle(space, &radii, 1, job));
        let balls: Vec<Ball> = found.into_iter().map(|(_, ball)| ball).collect();
        let (fraction, contacts) = core(&balls, dimension, 4.0 * radius, 0.85);
        let mut row = |quantity, found, reference, source| {
            rows.push(Row {
                method: "drop_and_roll",
                dimension,
                balls: count,
                setting: "core (two diameters off the walls)".into(),
                quantity,
                found,
                reference,
                source,
                seconds,
            });
        };
        let known = if dimension == 2 { 0.82 } else { 0.582 };
        row("solid fraction", fraction, known, "Visscher & Bolsterli 1972");
        row("contacts a ball", contacts, 2.0 * dimension as f64, "by construction");
    }
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
    let mut grid = crate::geometry::BallGrid::new(margin * 0.25);
    balls.iter().for_each(|ball| {
        grid.insert(ball.centre, ball.radius);
    });
    let mut source = crate::num::random::stream(0, "study.core", 0);
    let (mut solid, points) = (0_u32, 200_000_u32);
    for _ in 0..points {
        let mut point = Vec3::zeros();
        for axis in 0..dimension {
            let high = if axis == up { top } else { 1.0 };
            point[axis] = crate::num::random::uniform(&mut source, margin, high - margin);
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

fn findings(rows: &[Row], pores: Vec<Series>, faults: &[Fault]) -> Findings {
    let sheet = Sheet {
        key: "packing".into(),
        title: "Each method against its reference".into(),
        caption: "One seed; CPU seconds of this machine. A difference is relative.".into(),
        columns: [
            "method",
            "dimensions",
            "balls",
            "setting",
            "quantity",
            "found",
            "reference",
            "difference",
            "source",
            "CPU [s]",
        ]
        .map(String::from)
        .to_vec(),
        rows: rows
            .iter()
            .map(|row| {
                vec![
                    row.method.into(),
                    (row.dimension as u64).into(),
                    (row.balls as u64).into(),
                    row.setting.clone().into(),
                    row.quantity.into(),
                    row.found.into(),
                    row.reference.into(),
                    (row.found / row.reference - 1.0).into(),
                    row.source.into(),
                    row.seconds.into(),
                ]
            })
            .collect(),
    };
    let curves_of = |quantities: &[&str], dimensions: &[usize], over: fn(&Row) -> f64| {
        let mut curves: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
        let shown = |row: &&Row| {
            quantities.contains(&row.quantity)
                && dimensions.contains(&row.dimension)
                && row.method != "apollonian"
                && row.reference.is_finite()
        };
        for row in rows.iter().filter(shown) {
            let name = format!("{} {}-D", row.method, row.dimension);
            let point = (over(row), (row.found / row.reference - 1.0).abs());
            match curves.iter_mut().find(|curve| curve.0 == name) {
                Some(curve) => curve.1.push(point),
                None => curves.push((name, vec![point])),
            }
        }
        curves
    };
    let chart_of = |title: &str, quantities: &[&str], dimensions: &[usize]| {
        let curves = curves_of(quantities, dimensions, |row| row.seconds);
        let title = format!("{title}: distance from the reference over CPU time");
        work_precision(&title, &curves, "relative difference", "", None)
    };
    let over_number = |title: &str, quantities: &[&str], dimensions: &[usize]| Chart {
        title: format!("{title}: distance from the reference over the number of balls"),
        caption: "Methods with one number of balls are dots.".into(),
        x: Axis::log("balls", ""),
        y: Axis::log("relative difference", ""),
        series: curves_of(quantities, dimensions, |row| row.balls as f64)
            .into_iter()
            .map(|(name, points)| Series { name, points, dots: true })
            .collect(),
        mark: None,
    };
    let solids = ["solid fraction", "share of pores"];
    let chart = Chart {
        title: "Share of pores of random Apollonian packings".into(),
        caption: "Straight lines of slope −(d − D)/D: D near 1.565 and 2.73.".into(),
        x: Axis::log("balls", ""),
        y: Axis::log("share of pores", ""),
        series: pores,
        mark: None,
    };
    Findings {
        title: "Packing methods against what is known of them".into(),
        question: "How far is each method from its reference (density, dimension, coordination), at what CPU time and number of balls?".into(),
        remarks: remarks(rows),
        tables: vec![sheet, faults_sheet(faults)],
        charts: [vec![
            ("packing-solids-2d".into(), chart_of("Solid fraction, discs", &solids, &[2])),
            ("packing-solids-3d".into(), chart_of("Solid fraction, spheres", &solids, &[3])),
            ("packing-dimension".into(), chart_of("Dimension", &["dimension"], &[2, 3])),
            ("packing-contacts".into(), chart_of("Contacts a ball", &["contacts a ball"], &[2, 3])),
            ("packing-solids-number".into(), over_number("Solid fraction", &solids, &[2, 3])),
            ("packing-dimension-number".into(), over_number("Dimension", &["dimension"], &[2, 3])),
            ("packing-contacts-number".into(), over_number("Contacts a ball", &["contacts a ball"], &[2, 3])),
            ("packing-pores".into(), chart),
        ], faults_charts(faults)].concat(),
        pictures: Vec::new(),
    }
}

/// One sentence a method and quantity: the largest case.
fn remarks(rows: &[Row]) -> Vec<String> {
    let mut last: Vec<&Row> = Vec::new();
    for row in rows.iter().filter(|row| row.reference.is_finite()) {
        let same = |other: &&&Row| {
            (other.method, other.dimension, other.quantity)
                == (row.method, row.dimension, row.quantity)
        };
        match last.iter().position(|other| same(&other)) {
            Some(place) => last[place] = row,
            None => last.push(row),
        }
    }
    last.iter()
        .map(|row| {
            let digits = if row.quantity == "number of balls" { 0 } else { 4 };
            format!(
                "{}, {} dimensions, {} balls ({}): {} {:.digits$} against {:.digits$} ({}) in {:.2} s.",
                row.method,
                row.dimension,
                row.balls,
                row.setting,
                row.quantity,
                row.found,
                row.reference,
                row.source,
                row.seconds
            )
        })
        .collect()
}
