//! A block of spheres that collapses on a plane with friction: how far trajectories are
//! from a converged reference while they can be compared (before chaos), and later
//! whether the schemes give the same heap, over seeds.
//!
//! Early: root mean square of the differences of all positions from the path-averaged
//! scheme at an eighth of the finest step. Late: run-out (radius of gyration
//! about the vertical axis) and height of the centre of mass; each seed starts from the same
//! places in every scheme, the differences from `leapfrog` at 50 steps a contact are
//! paired, and two schemes count as equivalent if the 90 % confidence interval of the mean
//! difference lies within ±2 % of the mean (two one-sided tests at 5 %, Schuirmann 1987).
//! Cost: O(spheres × steps) a run.

use super::equivalence::{deviation, interval};
use super::{Effort, StudyError, go_on, models};
use crate::dem;
use crate::model::{Contact, Model, Motion, Outcome, Run, Scheme};
use crate::num::statistics::{mean, median, root_mean_square};
use crate::num::{Job, Vec3, random};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::curves::work_precision;
use crate::report::findings::{Findings, Sheet};

/// Radius, m; density, kg/m³; stiffness, N/m; dashpot of restitution 0.5 for two spheres, N s/m.
const RADIUS: f64 = 0.01;
const DENSITY: f64 = 2500.0;
const KN: f64 = 1e5;
const CN: f64 = 11.6826;
/// Runs of each step length, of whose times the median counts.
const ROUNDS: usize = 5;
/// Runs of so many seconds are not repeated.
const LONG: f64 = 2.0;
/// Equivalence margin of the late statistics, part of the mean.
const MARGIN: f64 = 0.02;

/// What an effort computes.
struct Size {
    side: u32,
    layers: u32,
    times: &'static [f64],
    steps: &'static [f64],
    /// Finer steps of `leapfrog` alone.
    finer: &'static [f64],
    reference: f64,
    /// Errors for which costs are compared: time, s, and root mean square, m.
    wanted: &'static [(f64, f64)],
    seeds: u64,
    late: f64,
}

impl Size {
    fn of(effort: Effort) -> Self {
        match effort {
            Effort::Quick => Self {
                side: 4,
                layers: 4,
                times: &[0.03, 0.05],
                steps: &[10.0, 20.0, 50.0, 100.0],
                finer: &[],
                reference: 800.0,
                wanted: &[(0.05, 2e-6)],
                seeds: 6,
                late: 0.3,
            },
            Effort::Full => Self {
                side: 5,
                layers: 8,
                times: &[0.03, 0.05, 0.08, 0.12],
                steps: &[10.0, 20.0, 50.0, 100.0, 200.0, 400.0, 800.0, 1600.0],
                finer: &[25600.0],
                reference: 6400.0,
                wanted: &[(0.03, 2e-7), (0.05, 1e-6), (0.08, 5e-5), (0.08, 1e-5), (0.12, 5e-5)],
                seeds: 24,
                late: 0.5,
            },
        }
    }
}

/// See [`super::STUDIES`].
pub fn study(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    let size = Size::of(effort);
    let mut remarks = Vec::new();
    let (early, charts) = trajectories(&size, job, &mut remarks)?;
    let late = heaps(&size, job, &mut remarks)?;
    let spheres = size.side * size.side * size.layers;
    Ok(Findings {
        title: "Collapse: error against run time".into(),
        question: format!(
            "{spheres} spheres fall apart on a plane (e = 0.5, μ = 0.5, kt/kn = 2/7): how far are \
             positions from the converged motion at which step and cost, and do the schemes \
             agree on the heap once the motion is chaotic?"
        ),
        remarks,
        tables: vec![early, late],
        charts,
        pictures: Vec::new(),
    })
}

type Charts = Vec<(String, Chart)>;

fn trajectories(
    size: &Size,
    job: &Job,
    remarks: &mut Vec<String>,
) -> Result<(Sheet, Charts), StudyError> {
    let last = size.times[size.times.len() - 1];
    let run = |scheme, per_contact| -> Result<(Vec<Vec<Vec3>>, f64), StudyError> {
        go_on(job)?;
        let run = collapse(size, scheme, per_contact, 0, last)?;
        let places: Vec<_> = size.times.iter().map(|time| nearest(&run, *time)).collect();
        Ok((places, run.cost.loop_seconds.unwrap_or(run.cost.cpu_seconds)))
    };
    let timed = |scheme, per_contact| {
        let (places, first) = run(scheme, per_contact)?;
        let mut seconds = vec![first];
        let rounds = if first < LONG { ROUNDS } else { 1 };
        for _ in 1..rounds {
            seconds.push(run(scheme, per_contact)?.1);
        }
        Ok::<_, StudyError>((places, median(&seconds).unwrap_or(first)))
    };
    let (fine, _) = run(Scheme::PathAveraged, size.reference)?;
    let (half, _) = run(Scheme::PathAveraged, 0.5 * size.reference)?;
    let floor: Vec<f64> = fine.iter().zip(&half).map(|(a, b)| distance(a, b)).collect();
    let mut columns: Vec<String> = vec!["scheme".into(), "steps a contact".into()];
    columns.extend(size.times.iter().map(|time| format!("at {time} s [m]")));
    columns.push("CPU [s]".into());
    let mut rows = Vec::new();
    let (mut over_steps, mut over_time, mut curves) = (Vec::new(), Vec::new(), Vec::new());
    for scheme in [Scheme::Leapfrog, Scheme::PathAveraged] {
        let (mut by_step, mut by_time, mut costs) = (Vec::new(), Vec::new(), Vec::new());
        let finer = if scheme == Scheme::Leapfrog { size.finer } else { &[] };
        for &per_contact in size.steps.iter().chain(finer) {
            let (places, seconds) = timed(scheme, per_contact)?;
            let errors: Vec<f64> = fine.iter().zip(&places).map(|(a, b)| distance(a, b)).collect();
            let end = errors[errors.len() - 1];
            by_step.push((per_contact, end));
            by_time.push((seconds, end));
            costs.push((per_contact, seconds, errors.clone()));
            let mut row = vec![scheme.key().into(), per_contact.into()];
            row.extend(errors.into_iter().map(Into::into));
            row.push(seconds.into());
            rows.push(row);
        }
        curves.push(costs);
        over_time.push((scheme.key().to_owned(), by_time));
        over_steps.push(Series { name: scheme.key().into(), points: by_step, dots: true });
    }
    let mut row = vec!["floor (reference at half its steps)".into(), (0.5 * size.reference).into()];
    row.extend(floor.iter().map(|error| (*error).into()));
    row.push(f64::NAN.into());
    rows.push(row);
    for &(time, wanted) in size.wanted {
        let at = size.times.iter().position(|other| *other == time).unwrap_or(0);
        remarks.push(compared(&curves, at, time, wanted));
    }
    let sheet = Sheet {
        key: "trajectories".into(),
        title: "Distance from the converged motion".into(),
        caption: format!(
            "Root mean square over all spheres; reference: path_averaged at {} steps a contact. CPU: median of {ROUNDS} runs, of one above {LONG} s.",
            size.reference
        ),
        columns,
        rows,
    };
    let chart = Chart {
        title: format!("Error of positions at {last} s over the step"),
        caption: "Root mean square over all spheres.".into(),
        x: Axis::log("steps a contact", ""),
        y: Axis::log("error of positions", "m"),
        series: over_steps,
        mark: None,
    };
    let time = work_precision(
        &format!("Error of positions at {last} s over CPU time"),
        &over_time,
        "error of positions",
        "m",
        None,
    );
    Ok((sheet, vec![("collapse-steps".into(), chart), ("collapse-time".into(), time)]))
}

/// A step length: steps a contact, CPU time, s, and errors at all times, m.
type Cost = (f64, f64, Vec<f64>);

/// What the schemes take for an error of `wanted` at `time`, the times' number `at`.
fn compared(curves: &[Vec<Cost>], at: usize, time: f64, wanted: f64) -> String {
    let reached = |curve: &[Cost]| {
        let steps: Vec<_> = curve.iter().map(|(steps, _, e)| (*steps, e[at])).collect();
        let seconds: Vec<_> = curve.iter().map(|(_, seconds, e)| (*seconds, e[at])).collect();
        Some((cost_at(&steps, wanted)?, cost_at(&seconds, wanted)?))
    };
    match (reached(&curves[0]), reached(&curves[1])) {
        (Some(one), Some(other)) => format!(
            "For {wanted:.0e} m at {time} s leapfrog takes {:.0} steps a contact and path_averaged {:.0}: \
             {:.1} times as many steps, {:.1} times the CPU time.",
            one.0,
            other.0,
            one.0 / other.0,
            one.1 / other.1
        ),
        (None, Some(other)) => format!(
            "For {wanted:.0e} m at {time} s path_averaged takes {:.0} steps a contact; leapfrog, {:.1e} m off at {} \
             steps, would take more than {:.0} times its CPU time.",
            other.0,
            curves[0].last().map_or(f64::NAN, |cost| cost.2[at]),
            curves[0].last().map_or(f64::NAN, |cost| cost.0),
            curves[0].last().map_or(f64::NAN, |cost| cost.1) / other.1
        ),
        _ => format!("Neither scheme crosses {wanted:.0e} m at {time} s within the steps tried."),
    }
}

/// Steps or CPU time for an error by interpolation in logarithms; `None` outside the points.
fn cost_at(curve: &[(f64, f64)], error: f64) -> Option<f64> {
    curve.windows(2).find_map(|pair| {
        let [(t0, e0), (t1, e1)] = [pair[0], pair[1]];
        let inside = e0 >= error && e1 <= error && e0 > e1;
        inside.then(|| {
            let share = (e0 / error).ln() / (e0 / e1).ln();
            (t0.ln() + share * (t1 / t0).ln()).exp()
        })
    })
}

fn heaps(size: &Size, job: &Job, remarks: &mut Vec<String>) -> Result<Sheet, StudyError> {
    let variants =
        [(Scheme::Leapfrog, 50.0), (Scheme::PathAveraged, 50.0), (Scheme::PathAveraged, 10.0)];
    let mut found: Vec<Vec<[f64; 2]>> = vec![Vec::new(); variants.len()];
    for seed in 1..=size.seeds {
        for ((scheme, per_contact), found) in variants.iter().zip(&mut found) {
            go_on(job)?;
            let run = collapse(size, *scheme, *per_contact, seed, size.late)?;
            found.push(shape(&nearest(&run, size.late)));
            job.report("heaps", seed, size.seeds);
        }
    }
    let mut rows = Vec::new();
    for (at, quantity) in ["run-out", "height"].into_iter().enumerate() {
        let base: Vec<f64> = found[0].iter().map(|values| values[at]).collect();
        let scale = mean(&base).unwrap_or(f64::NAN);
        for ((scheme, per_contact), found) in variants.iter().zip(&found) {
            let values: Vec<f64> = found.iter().map(|values| values[at]).collect();
            let differences: Vec<f64> =
                values.iter().zip(&base).map(|(a, b)| (a - b) / scale).collect();
            let (middle, half) = interval(&differences);
            let (percent, width) = (100.0 * middle, 100.0 * half);
            let (verdict, said) = match middle.abs() + half <= MARGIN {
                _ if *scheme == Scheme::Leapfrog => ("reference", None),
                true => ("equivalent", Some("equivalent within 2 %")),
                false => ("not shown", Some("equivalence within 2 % is not shown")),
            };
            let name = format!("{} tc/{per_contact}", scheme.key());
            remarks.extend(said.map(|said| {
                format!(
                    "{quantity}, {name}: {percent:+.2} % ± {width:.2} % (90 %) from leapfrog tc/50 over {} \
                     seeds: {said}.",
                    size.seeds
                )
            }));
            rows.push(vec![
                quantity.into(),
                name.as_str().into(),
                mean(&values).unwrap_or(f64::NAN).into(),
                deviation(&values).into(),
                percent.into(),
                width.into(),
                verdict.into(),
            ]);
        }
    }
    let columns = [
        "quantity",
        "scheme",
        "mean [m]",
        "standard deviation [m]",
        "difference [%]",
        "half width of 90 % [%]",
        "verdict",
    ];
    Ok(Sheet {
        key: "heaps".into(),
        title: format!("The heap at {} s", size.late),
        caption: format!(
            "{} seeds, the same starting places for all; differences are paired, in percent of \
             the mean of the reference; margin 2 %.",
            size.seeds
        ),
        columns: columns.map(String::from).to_vec(),
        rows,
    })
}

/// Run-out and height of the centre of mass, m.
fn shape(places: &[Vec3]) -> [f64; 2] {
    let centre = places.iter().sum::<Vec3>() / places.len() as f64;
    let squares: Vec<f64> = places.iter().map(|place| (place - centre).xy().norm()).collect();
    [root_mean_square(&squares).unwrap_or(f64::NAN), centre.z]
}

/// Root mean square of the distances of two sets of places.
fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    let all: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b).norm()).collect();
    root_mean_square(&all).unwrap_or(f64::NAN)
}

/// Places in the frame nearest to a time.
fn nearest(run: &Run, time: f64) -> Vec<Vec3> {
    let best =
        run.frames.iter().min_by(|a, b| (a.time - time).abs().total_cmp(&(b.time - time).abs()));
    best.map_or_else(Vec::new, |frame| frame.centres.clone())
}

fn collapse(
    size: &Size,
    scheme: Scheme,
    per_contact: f64,
    seed: u64,
    duration: f64,
) -> Result<Run, StudyError> {
    let model = block(size, scheme, per_contact, seed, duration);
    let run =
        dem::run(&model, &Job::quiet()).map_err(|error| StudyError::Work(error.to_string()))?;
    match run.outcome {
        Outcome::Finished => Ok(run),
        other => Err(StudyError::Work(format!("a collapse ended early: {other:?}"))),
    }
}

/// A block of spheres of ±10 % radii, loose enough not to touch, above a plane.
fn block(size: &Size, scheme: Scheme, per_contact: f64, seed: u64, duration: f64) -> Model {
    let contact = Contact { kn: KN, kt: 2.0 / 7.0 * KN, cn: CN, ct: 0.0, friction: 0.5 };
    let mut model = models::empty(scheme, contact, DENSITY);
    model.gravity = Vec3::z() * -9.81;
    models::plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    let mut source = random::stream(seed, "collapse", 0);
    for i in 0..size.side * size.side * size.layers {
        let [x, y, z] =
            [i % size.side, i / size.side % size.side, i / size.side / size.side].map(f64::from);
        let jitter = Vec3::from_fn(|_, _| random::uniform(&mut source, -0.05, 0.05));
        let radius = RADIUS * random::uniform(&mut source, 0.9, 1.1);
        // Alternate layers lean against each other: the block does not stand.
        let lean = 0.35 * (z % 2.0);
        let place =
            (Vec3::new(x + lean, y + 0.5 * lean, z) * 2.3 + Vec3::repeat(1.3) + jitter) * RADIUS;
        models::sphere(&mut model, place, radius, DENSITY, Vec3::zeros());
    }
    let mass = DENSITY * std::f64::consts::PI * 4.0 / 3.0 * RADIUS.powi(3);
    let step = std::f64::consts::PI * (0.5 * mass / KN).sqrt() / per_contact;
    // A hundred frames at the same times whatever the step.
    let a_frame = (duration / 100.0 / step).ceil();
    model.plan.step = duration / 100.0 / a_frame;
    model.plan.steps = 100 * a_frame as u64;
    model.plan.frame_every = a_frame as u64;
    model
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_averaged_scheme_is_closer_at_a_fifth_of_the_steps() {
        let size = Size { side: 2, layers: 3, ..Size::of(Effort::Quick) };
        let places = |scheme, n| nearest(&collapse(&size, scheme, n, 0, 0.05).expect("runs"), 0.05);
        let fine = places(Scheme::PathAveraged, 400.0);
        let ours = distance(&fine, &places(Scheme::PathAveraged, 10.0));
        let theirs = distance(&fine, &places(Scheme::Leapfrog, 50.0));
        assert!(ours < theirs, "{ours} {theirs}");
    }
}
