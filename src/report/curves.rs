//! The charts of a report, from runs, comparisons and clumps.

use super::chart::{Axis, Bars, Chart, Series};
use super::compare::Statistics;
use super::compare::region::Region;
use super::compare::{Comparison, Trajectory};
use super::number::with_unit;
use crate::clump::Clump;
use crate::model::{Cost, Model, Run, SeriesRow};
use crate::num::Vec3;
use crate::num::statistics::{median, quantile};
use std::collections::BTreeMap;

fn line(name: impl Into<String>, points: Vec<(f64, f64)>) -> Series {
    Series { name: name.into(), points, dots: false }
}

/// Kinetic, elastic, gravitational and dissipated energy and the work of walls
/// over time; terms that are 0 throughout are left out.
pub fn energies(rows: &[SeriesRow]) -> Chart {
    type Term = (&'static str, fn(&SeriesRow) -> f64);
    let terms: [Term; 17] = [
        ("kinetic", |r| r.kinetic),
        ("elastic", |r| r.elastic),
        ("gravitational", |r| r.gravitational),
        ("normal dashpot", |r| r.normal_dashpot),
        ("tangential dashpot", |r| r.tangential_dashpot),
        ("slip", |r| r.slip),
        ("local damping", |r| r.local_damping),
        ("attraction", |r| r.attraction),
        ("rolling resistance", |r| r.rolling),
        ("forming of bridges", |r| r.wetting),
        ("drag", |r| r.drag),
        ("work of walls", |r| r.wall_work),
        ("elastic in bonds", |r| r.bond_elastic),
        ("dashpots of bonds", |r| r.bond_damping),
        ("set free by breaks", |r| r.bond_released),
        ("zeroed velocities", |r| r.zeroed),
        ("bodies taken out", |r| r.lost_energy),
    ];
    let series = terms
        .into_iter()
        .filter(|(_, value)| rows.iter().any(|row| value(row) != 0.0))
        .map(|(name, value)| line(name, rows.iter().map(|row| (row.time, value(row))).collect()))
        .collect();
    Chart {
        title: "Energy ledger of our DEM".into(),
        caption: "Dissipated energies and the work of walls are sums since the start; potential \
                  energy is relative to the start. Terms that are 0 throughout are left out."
            .into(),
        x: Axis::linear("time", "s"),
        y: Axis::linear("energy", "J"),
        series,
        mark: None,
    }
}

/// |energy error| over time, relative to the largest energy of the ledger; without a ledger no points.
pub fn energy_error(rows: &[SeriesRow]) -> Chart {
    let scale = rows
        .iter()
        .flat_map(|r| [r.kinetic, r.elastic, r.gravitational.abs(), r.wall_work.abs()])
        .fold(0.0, f64::max);
    let found = |row: &SeriesRow| Some((row.time, row.energy_error?.abs() / scale));
    let points = rows.iter().filter_map(found).collect();
    Chart {
        title: "Energy that the ledger misses".into(),
        caption:
            "Size of (kinetic + elastic + gravitational + dissipated − work of walls − start) \
                  over the largest term. It closes equally well for schemes whose trajectories \
                  differ a hundredfold: a check of consistency, not of accuracy."
                .into(),
        x: Axis::linear("time", "s"),
        y: Axis::log("energy error / largest energy", ""),
        series: vec![line("energy error", points)],
        mark: None,
    }
}

/// Top of the bed (95 % quantile of sphere tops above the floor) over time for every run.
pub fn heights(model: &Model, runs: &[&Run]) -> Chart {
    let region = Region::of(model, runs.first().and_then(|run| run.frames.last()));
    let top = |centre: &Vec3, radius: f64| centre.dot(&region.up) - region.base + radius;
    over_frames("Top of the bed", "height of the top (95 %)", "m", runs, |frame| {
        let spheres = frame.centres.iter().zip(&model.spheres);
        let tops: Vec<f64> = spheres.map(|(centre, s)| top(centre, s.radius)).collect();
        quantile(&tops, 0.95).unwrap_or(f64::NAN)
    })
}

/// Kinetic energy below this part of the largest is rest and not drawn.
const QUIET: f64 = 1e-8;

/// Kinetic energy over time for every run; on a logarithmic axis where it changes much.
pub fn kinetic(model: &Model, runs: &[&Run]) -> Chart {
    let mut chart = over_frames("Kinetic energy", "kinetic energy", "J", runs, |frame| {
        frame.kinetic_energy(model)
    });
    let all = || chart.series.iter().flat_map(|series| &series.points).map(|point| point.1);
    let most = all().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let least = all().filter(|v| *v > most * QUIET).fold(most, f64::min);
    chart.y.log = least < 0.03 * most;
    if chart.y.log {
        for point in chart.series.iter_mut().flat_map(|series| &mut series.points) {
            point.1 = if point.1 > most * QUIET { point.1 } else { f64::NAN };
        }
    }
    chart
}

fn over_frames(
    title: &str,
    label: &str,
    unit: &str,
    runs: &[&Run],
    value: impl Fn(&crate::model::Frame) -> f64,
) -> Chart {
    let points = |run: &Run| run.frames.iter().map(|f| (f.time, value(f))).collect();
    Chart {
        title: title.into(),
        caption: String::new(),
        x: Axis::linear("time", "s"),
        y: Axis::linear(label, unit),
        series: runs.iter().map(|run| line(run.solver.clone(), points(run))).collect(),
        mark: None,
    }
}

/// Smallest radii below which a difference is less than one rounding of a coordinate.
const ROUNDING: f64 = 1e-16;

/// Largest position difference over time: each solver against its twin, and against our run.
pub fn divergence(comparison: &Comparison) -> Chart {
    let curve = |name: String, trajectory: &Trajectory| {
        // Every run starts from the same state: time 0 says nothing.
        let late = trajectory.points.iter().filter(|point| point.time > 0.0);
        let equal = late.clone().count() > 0 && late.clone().all(|point| point.largest == 0.0);
        let points = late.map(|point| (point.time, point.largest.max(ROUNDING))).collect();
        line(if equal { format!("{name}: equal to the last bit") } else { name }, points)
    };
    let mut series = Vec::new();
    for other in &comparison.others {
        let name = &other.side.solver;
        if let Some(twin) = &other.twin {
            let name = format!("{name} – ours as {}", twin.scheme);
            series.push(curve(name, &twin.trajectory));
        }
        series.push(curve(format!("{name} – ours"), &other.against_ours));
    }
    let end = series.iter().flat_map(|s| &s.points).map(|point| point.0).fold(0.0, f64::max);
    let until = Some(comparison.window_end).filter(|time| *time < end);
    Chart {
        title: "How far trajectories are apart".into(),
        caption: format!(
            "Largest distance of any sphere from where the other run has it, in radii of the \
             smallest sphere; less than a rounding of a coordinate is drawn at 1e-16. {}",
            until.map_or("Twins are judged over the whole run.".to_owned(), |time| {
                format!("Twins are judged until t = {}.", with_unit(time, "s"))
            })
        ),
        x: Axis::linear("time", "s"),
        y: Axis::log("largest distance / smallest radius", ""),
        series,
        mark: Some((comparison.tolerances.trajectory, "tolerance".into())),
    }
}

/// Share of contacts with more than a given normal force, for every run.
pub fn forces(sides: &[(&str, &Statistics)]) -> Chart {
    let curve = |found: &Statistics| {
        let count = found.forces.len();
        found
            .forces
            .iter()
            .enumerate()
            .map(|(below, force)| (*force, (count - below) as f64 / count as f64))
            .collect()
    };
    Chart {
        title: "Contact forces in the last frame".into(),
        caption: "Share of the contacts between spheres that carry at least this normal force \
                  (elastic part, from the overlaps, in the same way for every run)."
            .into(),
        x: Axis::linear("normal force", "N"),
        y: Axis::log("share of contacts", ""),
        series: sides.iter().map(|(name, found)| line(*name, curve(found))).collect(),
        mark: None,
    }
}

/// CPU seconds, or wall-clock seconds below what the clock of CPU time resolves.
fn cpu_seconds(cost: &Cost) -> f64 {
    cost.cpu_seconds.max(cost.wall_seconds.min(0.01))
}

/// CPU seconds of every run.
pub fn cpu(runs: &[&Run]) -> Bars {
    Bars {
        title: "CPU time".into(),
        caption: "User and system time of the whole run: start-up and output included. Our run \
                  makes no process of its own; times under 10 ms are wall-clock time."
            .into(),
        unit: "s".into(),
        bars: runs.iter().map(|run| (run.solver.clone(), cpu_seconds(&run.cost))).collect(),
    }
}

/// Error against run time, both logarithmic, one curve a method: `methods` are
/// names with points (seconds, error); `label` and `unit` say what the error is
/// and `floor` is the error of the reference itself, below which nothing counts.
pub fn work_precision(
    title: &str,
    methods: &[(String, Vec<(f64, f64)>)],
    label: &str,
    unit: &str,
    floor: Option<f64>,
) -> Chart {
    let curve = |(name, points): &(String, Vec<(f64, f64)>)| {
        let mut points = points.clone();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        Series { name: name.clone(), points, dots: true }
    };
    Chart {
        title: title.into(),
        caption: "Lower left is better: less error for less time.".into(),
        x: Axis::log("run time", "s"),
        y: Axis::log(label, unit),
        series: methods.iter().map(curve).collect(),
        mark: floor.map(|value| (value, "error of the reference".into())),
    }
}

/// Median errors of clumps over their number of spheres; `None` unless at least
/// two numbers of spheres are there. Grains that one sphere stands for are left out.
pub fn fidelity(clumps: &[Clump]) -> Option<Chart> {
    let sorted = |value: fn(&crate::clump::Fidelity) -> f64| {
        let mut groups: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for clump in clumps.iter().filter(|clump| clump.balls.len() > 1) {
            if let Some(found) = &clump.fidelity {
                groups.entry(clump.balls.len()).or_default().push(value(found));
            }
        }
        let point = |(count, values): (usize, Vec<f64>)| Some((count as f64, median(&values)?));
        groups.into_iter().filter_map(point).collect::<Vec<_>>()
    };
    let line = |name: &str, points| Series { name: name.into(), points, dots: true };
    let distance = sorted(|f| f.rms_distance / f.equivalent_diameter);
    let counts_differ = distance.first().map(|p| p.0) != distance.last().map(|p| p.0);
    counts_differ.then(|| Chart {
        title: "Errors of the clumps over their number of spheres".into(),
        caption: "Median over all clumps with that many spheres. Surface distance over the \
                  equivalent-volume diameter; volume and inertia relative to the solid."
            .into(),
        x: Axis::linear("spheres in the clump", ""),
        y: Axis::log("error", ""),
        series: vec![
            line("surface distance (rms)", distance),
            line("volume", sorted(|f| f.volume_error.abs())),
            line("inertia", sorted(|f| f.inertia_error)),
        ],
        mark: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::fixture;

    #[test]
    fn what_is_zero_throughout_is_left_out_of_the_ledger() {
        let model = fixture::model(2);
        let run = fixture::run(&model, "ours", |_| Vec3::zeros());
        let chart = energies(&run.series);
        let names: Vec<&str> = chart.series.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["kinetic", "elastic", "gravitational", "normal dashpot"]);
        let error = energy_error(&run.series).series.remove(0).points[10];
        assert!((error.1 - 1e-6 / 1e-3).abs() < 1e-12, "{error:?}");
    }

    #[test]
    fn heights_follow_the_bed() {
        let model = fixture::model(2);
        let run = fixture::run(&model, "ours", |step| Vec3::z() * (1e-6 * step as f64));
        let points = heights(&model, &[&run]).series.remove(0).points;
        assert!((points[10].1 - points[0].1 - 1e-3).abs() < 1e-12);
        assert!((points[0].1 - (1.5 * 0.0099 + 0.005)).abs() < 1e-12);
    }

    #[test]
    fn work_precision_sorts_by_time_and_draws_every_point() {
        let methods = vec![("a".to_owned(), vec![(4.0, 1e-5), (1.0, 1e-3), (2.0, 1e-4)])];
        let chart = work_precision("study", &methods, "error", "m", Some(1e-7));
        assert_eq!(chart.series[0].points[0], (1.0, 1e-3));
        let svg = chart.svg().expect("three points");
        assert_eq!(svg.matches("<circle").count(), 3);
        assert!(svg.contains("error of the reference") && svg.contains("run time, s"));
    }

    #[test]
    fn clumps_of_one_size_have_no_curve() {
        let clump = fixture::clump("a");
        assert!(fidelity(&[clump.clone(), clump.clone()]).is_none());
        let mut finer = clump.clone();
        finer.balls.extend(clump.balls.clone());
        let chart = fidelity(&[finer, clump]).expect("two numbers of spheres");
        assert_eq!(chart.series[0].points[0].0, 3.0);
        assert!((chart.series[0].points[0].1 - 0.03 / 1.6).abs() < 1e-12);
    }

    #[test]
    fn forces_are_shares_that_fall_from_one() {
        let model = fixture::model(2);
        let run = fixture::run(&model, "ours", |_| Vec3::zeros());
        let found = crate::report::compare::compare(
            &model,
            &run,
            &[],
            &[],
            &crate::report::compare::Tolerances::default(),
        );
        let statistics = found.ours.statistics.expect("a final state");
        let points = forces(&[("ours", &statistics)]).series.remove(0).points;
        assert_eq!((points.len(), points[0].1), (12, 1.0));
        assert!((points[11].1 - 1.0 / 12.0).abs() < 1e-15);
    }
}
