//! The charts of a report, from runs, comparisons and clumps.

use super::chart::{Axis, Bars, Chart, Series};
use super::compare::statistics::Statistics;
use super::compare::{Comparison, Trajectory};
use super::gallery::upwards;
use super::number::with_unit;
use crate::clump::Clump;
use crate::model::{Model, Run, SeriesRow};
use crate::num::statistics::quantile;

fn line(name: impl Into<String>, points: Vec<(f64, f64)>) -> Series {
    Series { name: name.into(), points, dots: false }
}

/// Kinetic, elastic, gravitational and dissipated energy and the work of walls
/// over time; terms that are 0 throughout are left out.
pub fn energies(rows: &[SeriesRow]) -> Chart {
    type Term = (&'static str, fn(&SeriesRow) -> f64);
    let terms: [Term; 8] = [
        ("kinetic", |r| r.kinetic),
        ("elastic", |r| r.elastic),
        ("gravitational", |r| r.gravitational),
        ("normal dashpot", |r| r.normal_dashpot),
        ("tangential dashpot", |r| r.tangential_dashpot),
        ("slip", |r| r.slip),
        ("local damping", |r| r.local_damping),
        ("work of walls", |r| r.wall_work),
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

/// |energy error| over time, relative to the largest energy of the ledger.
pub fn energy_error(rows: &[SeriesRow]) -> Chart {
    let scale = rows
        .iter()
        .flat_map(|r| [r.kinetic, r.elastic, r.gravitational.abs(), r.wall_work.abs()])
        .fold(0.0, f64::max);
    let points = rows.iter().map(|row| (row.time, row.energy_error.abs() / scale)).collect();
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

/// Top of the bed (95 % quantile of sphere tops, along up) over time for every run.
pub fn heights(model: &Model, runs: &[&Run]) -> Chart {
    let up = upwards(model);
    over_frames("Top of the bed", "height of the top (95 %)", "m", runs, |frame| {
        let tops: Vec<f64> =
            frame.centres.iter().zip(&model.spheres).map(|(c, s)| c.dot(&up) + s.radius).collect();
        quantile(&tops, 0.95).unwrap_or(f64::NAN)
    })
}

/// Kinetic energy over time for every run.
pub fn kinetic(model: &Model, runs: &[&Run]) -> Chart {
    let mut chart = over_frames("Kinetic energy", "kinetic energy", "J", runs, |frame| {
        frame.kinetic_energy(model)
    });
    chart.y.log = true;
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

/// Largest position difference over time: each solver against its twin, and against our run.
pub fn divergence(comparison: &Comparison) -> Chart {
    let curve = |name: String, trajectory: &Trajectory| {
        let points: Vec<_> = trajectory.points.iter().map(|p| (p.time, p.largest)).collect();
        let equal = !points.is_empty() && points.iter().all(|point| point.1 == 0.0);
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
    Chart {
        title: "How far trajectories are apart".into(),
        caption: format!(
            "Largest distance of any sphere from where the other run has it, in radii of the \
             smallest sphere. Times at which two runs agree to the last bit are not drawn. Twins are \
             judged until t = {}.",
            with_unit(comparison.window_end, "s")
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
        title: "Contact forces of the final state".into(),
        caption: "Share of the contacts between spheres that carry at least this normal force \
                  (elastic part, from the overlaps, in the same way for every run)."
            .into(),
        x: Axis::linear("normal force", "N"),
        y: Axis::log("share of contacts", ""),
        series: sides.iter().map(|(name, found)| line(*name, curve(found))).collect(),
        mark: None,
    }
}

/// CPU seconds of every run.
pub fn cpu(runs: &[&Run]) -> Bars {
    Bars {
        title: "CPU time".into(),
        caption: "User and system time of the whole run: start-up and output included.".into(),
        unit: "s".into(),
        bars: runs.iter().map(|run| (run.solver.clone(), run.cost.cpu_seconds)).collect(),
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

/// Root mean square surface distance of clumps, in equivalent diameters, over
/// their number of spheres; `None` unless at least two have errors.
pub fn fidelity(clumps: &[Clump]) -> Option<Chart> {
    let sorted = |value: fn(&crate::clump::Fidelity) -> f64| {
        let mut points: Vec<(f64, f64)> = clumps
            .iter()
            .filter_map(|clump| {
                let found = clump.fidelity.as_ref()?;
                Some((clump.balls.len() as f64, value(found)))
            })
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        points
    };
    let distance = sorted(|f| f.rms_distance / f.equivalent_diameter);
    let counts_differ = distance.first().map(|p| p.0) != distance.last().map(|p| p.0);
    counts_differ.then(|| Chart {
        title: "Errors of the clumps over their number of spheres".into(),
        caption: "Surface distance over the equivalent-volume diameter; volume and inertia \
                  relative to the solid. One entry a clump."
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
    use crate::num::Vec3;
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
