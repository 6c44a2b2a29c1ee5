//! Every clump method on a set of solids: error against the number of spheres and
//! against the CPU time of the fit.
//!
//! Errors are those of [`crate::clump::measure`], relative to the solid: distances
//! over its equivalent diameter. Every method has its defaults, and its number of
//! spheres set; some find fewer than they may. A fit is repeated until it has taken
//! a tenth of a second, and the mean is given. What the error of the fitted clumps costs
//! in a DEM run: [`super::stand_in`].

use super::solids::solids;
use super::stand_in::{self, Ladder};
use super::{Effort, StudyError, go_on};
use crate::clump::{self, Clump, ClumpError, Fidelity, MassSource, Method, counted};
use crate::num::statistics::median;
use crate::num::{Job, clock};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::curves::work_precision;
use crate::report::findings::{Cell, Findings, Sheet};
use crate::report::gallery::solid_beside_clump;
use crate::report::picture::Picture;
use crate::shape::Solid;
use std::time::Instant;

/// Repeats of one fit at most, and CPU seconds after which there are enough.
const REPEATS: u32 = 10;
const ENOUGH: f64 = 0.1;

/// Solids whose clumps are set in motion.
const IN_MOTION: (&[usize], &[usize]) = (&[1, 3], &[0, 1, 2, 3]);

/// See [`super::STUDIES`].
pub fn study(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    let (mut findings, mut ladders) = shapes(effort, job)?;
    let kept = if effort == Effort::Quick { IN_MOTION.0 } else { IN_MOTION.1 };
    let mut index = 0;
    ladders.retain(|_| {
        index += 1;
        kept.contains(&(index - 1))
    });
    stand_in::add(&mut findings, &ladders, effort, job)?;
    Ok(findings)
}

/// The study without DEM runs.
pub fn shapes_alone(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    Ok(shapes(effort, job)?.0)
}

/// Errors of all methods, and the fitted clumps of each solid.
fn shapes(effort: Effort, job: &Job) -> Result<(Findings, Vec<Ladder>), StudyError> {
    let (kinds, counts): (usize, &[u32]) = match effort {
        Effort::Quick => (4, &[10, 30, 100]),
        Effort::Full => (8, &[5, 10, 20, 50, 100, 200]),
    };
    let solids: Vec<Solid> = solids()?.into_iter().take(kinds).collect();
    let total = (solids.len() * counted().count() * counts.len()) as u64;
    let (mut rows, mut pictures, mut ladders) = (Vec::new(), Vec::new(), Vec::new());
    for solid in &solids {
        let mut ladder = Ladder { solid: solid.name.clone(), clumps: Vec::new() };
        for method in counted() {
            for &count in counts {
                go_on(job)?;
                if let Some((clump, seconds)) = fit(solid, method, count, job)? {
                    rows.push(Row::new(solid, method, count, &clump, seconds));
                    if method == "fitted" {
                        if count == counts[counts.len() / 2] {
                            pictures.push(picture(solid, &clump));
                        }
                        ladder.clumps.push(clump);
                    }
                }
                job.report("clumps", rows.len() as u64, total);
            }
        }
        ladders.push(ladder);
    }
    let findings = Findings {
        title: "Clumps: error against number of spheres and run time".into(),
        question: "How far is a clump from its solid, for every method, with how many spheres and at which cost?".into(),
        remarks: remarks(&rows, counts),
        tables: vec![medians(&rows, counts), sheet(&rows)],
        charts: charts(&rows, counts),
        pictures,
    };
    Ok((findings, ladders))
}

/// One clump, measured.
struct Row {
    solid: String,
    method: &'static str,
    asked: u32,
    spheres: usize,
    fidelity: Fidelity,
    seconds: f64,
}

impl Row {
    fn new(solid: &Solid, method: &'static str, asked: u32, clump: &Clump, seconds: f64) -> Self {
        // Every clump of a solid has been measured.
        let fidelity = clump.fidelity.unwrap_or(Fidelity {
            equivalent_diameter: f64::NAN,
            volume_error: f64::NAN,
            mean_distance: f64::NAN,
            rms_distance: f64::NAN,
            largest_distance: f64::NAN,
            centroid_error: f64::NAN,
            inertia_error: f64::NAN,
        });
        let spheres = clump.balls.len();
        Self { solid: solid.name.clone(), method, asked, spheres, fidelity, seconds }
    }

    /// Per cent: volume, mean, root mean square and largest distance, centroid, inertia.
    fn errors(&self) -> [f64; 6] {
        let f = &self.fidelity;
        let d = f.equivalent_diameter;
        [
            f.volume_error,
            f.mean_distance / d,
            f.rms_distance / d,
            f.largest_distance / d,
            f.centroid_error / d,
            f.inertia_error,
        ]
        .map(|error| 100.0 * error)
    }
}

/// A clump and the CPU seconds of its fit; `None` where the method finds no sphere.
fn fit(
    solid: &Solid,
    method: &str,
    count: u32,
    job: &Job,
) -> Result<Option<(Clump, f64)>, StudyError> {
    let failed = |error: ClumpError| match error {
        ClumpError::Cancelled => StudyError::Cancelled,
        other => StudyError::Work(other.to_string()),
    };
    let method = Method::by_key(method, count).map_err(failed)?;
    let alone = job.with_threads(1);
    let (cpu, wall) = (clock::cpu_seconds(), Instant::now());
    let mut repeats = 0;
    while repeats < REPEATS && (repeats == 0 || clock::since(cpu, wall) < ENOUGH) {
        match clump::spheres(solid, &method, 0, 0, &alone) {
            Err(ClumpError::NoSphere { .. }) => return Ok(None),
            found => drop(found.map_err(failed)?),
        }
        repeats += 1;
    }
    let seconds = clock::since(cpu, wall) / f64::from(repeats);
    let clump =
        clump::reproduce(solid, &method, MassSource::Solid, 0, 0, &alone).map_err(failed)?;
    Ok(Some((clump, seconds)))
}

fn picture(solid: &Solid, clump: &Clump) -> (String, String, String, Picture) {
    let rms = clump.fidelity.map_or(f64::NAN, |f| 100.0 * f.rms_distance / f.equivalent_diameter);
    (
        format!("clump-{}", solid.name),
        format!("{} and its clump", solid.name),
        format!("fitted, {} spheres, root mean square distance {rms:.2} %", clump.balls.len()),
        solid_beside_clump(solid, clump, 640, 320),
    )
}

/// Median over solids of `of` for one method and count; `None` without any.
fn middle(rows: &[Row], method: &str, asked: u32, of: impl Fn(&Row) -> f64) -> Option<f64> {
    let found: Vec<f64> =
        rows.iter().filter(|r| r.method == method && r.asked == asked).map(of).collect();
    median(&found)
}

const COLUMNS: [&str; 6] = [
    "volume [%]",
    "mean distance [%]",
    "rms distance [%]",
    "largest distance [%]",
    "centroid [%]",
    "inertia [%]",
];

fn sheet(rows: &[Row]) -> Sheet {
    let cells = |row: &Row| -> Vec<Cell> {
        let mut cells: Vec<Cell> = vec![
            row.solid.as_str().into(),
            row.method.into(),
            u64::from(row.asked).into(),
            (row.spheres as u64).into(),
        ];
        cells.extend(row.errors().map(Cell::from));
        cells.push(row.seconds.into());
        cells
    };
    Sheet {
        key: "clumps".into(),
        title: "Every clump".into(),
        caption:
            "Distances over the equivalent diameter of the solid; CPU seconds of the fit alone."
                .into(),
        columns: ["solid", "method", "asked", "spheres"]
            .into_iter()
            .chain(COLUMNS)
            .chain(["CPU [s]"])
            .map(String::from)
            .collect(),
        rows: rows.iter().map(cells).collect(),
    }
}

fn medians(rows: &[Row], counts: &[u32]) -> Sheet {
    let mut table = Vec::new();
    for key in counted() {
        for &count in counts {
            let mut cells: Vec<Cell> = vec![key.into(), u64::from(count).into()];
            for column in 0..COLUMNS.len() {
                let value = middle(rows, key, count, |row| row.errors()[column].abs());
                cells.push(value.unwrap_or(f64::NAN).into());
            }
            let seconds = middle(rows, key, count, |row| row.seconds);
            cells.push(seconds.unwrap_or(f64::NAN).into());
            table.push(cells);
        }
    }
    Sheet {
        key: "medians".into(),
        title: "Medians over the solids".into(),
        caption: "Sizes of the errors. A method may find fewer spheres than it was asked for."
            .into(),
        columns: ["method", "asked"]
            .into_iter()
            .chain(COLUMNS)
            .chain(["CPU [s]"])
            .map(String::from)
            .collect(),
        rows: table,
    }
}

fn charts(rows: &[Row], counts: &[u32]) -> Vec<(String, Chart)> {
    let over_spheres = |title: &str, column: usize, label: &str| Chart {
        title: title.into(),
        caption: "Median over the solids; number of spheres asked for.".into(),
        x: Axis::log("spheres", ""),
        y: Axis::log(label, "%"),
        series: counted()
            .map(|key| Series {
                name: key.into(),
                points: counts
                    .iter()
                    .filter_map(|&n| {
                        let value = middle(rows, key, n, |r| r.errors()[column].abs())?;
                        Some((f64::from(n), value))
                    })
                    .collect(),
                dots: true,
            })
            .collect(),
        mark: None,
    };
    let over_time: Vec<(String, Vec<(f64, f64)>)> = counted()
        .map(|key| {
            let points = counts.iter().filter_map(|&n| {
                let seconds = middle(rows, key, n, |row| row.seconds)?;
                Some((seconds.max(1e-5), middle(rows, key, n, |row| row.errors()[2])?))
            });
            (key.to_owned(), points.collect())
        })
        .collect();
    vec![
        (
            "rms-spheres".into(),
            over_spheres("Surface distance over spheres", 2, "rms distance / diameter"),
        ),
        (
            "largest-spheres".into(),
            over_spheres("Largest distance over spheres", 3, "largest distance / diameter"),
        ),
        ("volume-spheres".into(), over_spheres("Volume error over spheres", 0, "volume error")),
        (
            "rms-time".into(),
            work_precision(
                "Surface distance over CPU time of the fit",
                &over_time,
                "rms distance / diameter",
                "%",
                None,
            ),
        ),
    ]
}

fn remarks(rows: &[Row], counts: &[u32]) -> Vec<String> {
    counts
        .iter()
        .filter_map(|&count| {
            let of = |key: &str| middle(rows, key, count, |row| row.errors()[2]);
            let fitted = of("fitted")?;
            let (other, rms) = counted()
                .filter(|key| *key != "fitted")
                .filter_map(|key| Some((key, of(key)?)))
                .min_by(|a, b| a.1.total_cmp(&b.1))?;
            Some(format!(
                "{count} spheres: median rms distance {fitted:.3} % with fitted, {rms:.3} % with the next best ({other})."
            ))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solids_are_closed_and_a_fit_is_a_row() {
        let solids = solids().expect("solids");
        assert_eq!(solids.len(), 8);
        assert!(solids.iter().all(|solid| solid.mass.volume > 0.0));
        let (clump, seconds) =
            fit(&solids[1], "normals", 6, &Job::quiet()).expect("it runs").expect("spheres");
        assert!(seconds >= 0.0);
        let rows = vec![Row::new(&solids[1], "normals", 6, &clump, seconds)];
        assert!(rows[0].errors().iter().all(|error| error.is_finite()));
        assert_eq!(sheet(&rows).rows[0].len(), sheet(&rows).columns.len());
        assert!(counted().all(|method| Method::by_key(method, 6).is_ok()));
        assert!(!counted().any(|method| method == "cluster" || method == "lattice"));
        let table = medians(&rows, &[6]);
        assert!(table.rows.iter().all(|row| row.len() == table.columns.len()));
    }
}
