//! What a sweep writes at its end: `manifest.csv` with a row a case, charts of
//! outputs against inputs, a page, and a job array for a cluster.

use super::cases::Case;
use super::file::Stage;
use super::work::{Record, Status};
use super::{Sweep, SweepError};
use crate::format::atomic;
use crate::report::chart::{Axis, Chart, Series};
use crate::report::findings::{Cell, Findings, Sheet};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;

/// Most charts of one input; all numbers are in the CSV file.
const CHARTS: usize = 16;
/// Points of a chart; more different inputs are put together in so many groups.
const POINTS: usize = 20;

/// Writes `manifest.csv`, `index.html`, charts and the job array into `root`.
///
/// # Errors
/// A file that cannot be written.
pub fn write(
    sweep: &Sweep,
    records: &[Record],
    root: &Path,
    command: &str,
) -> Result<Findings, SweepError> {
    let sheet = sheet(records);
    let charts = charts(sweep, records);
    let failed: Vec<&Record> = records.iter().filter(|r| r.status != Status::Done).collect();
    let mut remarks = vec![format!("{} cases, {} as they should be.", records.len(), {
        records.len() - failed.len()
    })];
    remarks.extend(failed.iter().take(50).map(|r| format!("Case {}: {}", r.case, r.message)));
    let findings = Findings {
        title: format!("Sweep of {}", sweep.scene.display()),
        question: "What comes out of every case, and how it depends on what was varied.".into(),
        remarks,
        tables: vec![sheet],
        charts,
        pictures: Vec::new(),
    };
    findings.write(root, command)?;
    Ok(findings)
}

/// Writes a script that does the cases as a job array of Slurm: `array.slurm`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_array(stage: Stage, cases: &[Case], root: &Path) -> Result<(), SweepError> {
    let digits = cases.first().map_or(4, |case| case.name.len());
    let text = include_str!("../../templates/array.slurm")
        .replace("{{ last }}", &cases.len().to_string())
        .replace("{{ digits }}", &digits.to_string())
        .replace("{{ verb }}", stage.verb());
    atomic::write(&root.join("array.slurm"), |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

/// A row a case: number, status, inputs, outputs, time, message.
fn sheet(records: &[Record]) -> Sheet {
    let names = |of: fn(&Record) -> Vec<String>| -> Vec<String> {
        records.iter().flat_map(of).collect::<BTreeSet<_>>().into_iter().collect()
    };
    let inputs = names(|record| record.values.keys().cloned().collect());
    let outputs = names(|record| record.outputs.keys().cloned().collect());
    let mut columns = vec!["case".to_owned(), "status".to_owned()];
    columns.extend(inputs.iter().chain(&outputs).cloned());
    columns.extend(["wall time [s]".to_owned(), "message".to_owned()]);
    let row = |record: &Record| {
        let status = match record.status {
            Status::Done => "done",
            Status::Outside => "outside tolerance",
            Status::Failed => "failed",
        };
        let mut row: Vec<Cell> = vec![record.case.as_str().into(), status.into()];
        row.extend(inputs.iter().map(|key| record.values.get(key).map_or("".into(), cell)));
        row.extend(
            outputs.iter().map(|key| record.outputs.get(key).map_or("".into(), |v| (*v).into())),
        );
        row.extend([record.wall_seconds.into(), Cell::from(record.message.as_str())]);
        row
    };
    Sheet {
        key: "manifest".into(),
        title: "Cases".into(),
        caption: "The folder of a case is cases/NUMBER.".into(),
        columns,
        rows: records.iter().map(row).collect(),
    }
}

fn cell(value: &toml::Value) -> Cell {
    match value {
        toml::Value::Float(number) => (*number).into(),
        toml::Value::Integer(number) => number.to_string().into(),
        toml::Value::String(text) => text.as_str().into(),
        other => other.to_string().into(),
    }
}

/// Number of a value with or without a unit.
fn number(value: &toml::Value) -> Option<f64> {
    match value {
        toml::Value::Float(number) => Some(*number),
        toml::Value::Integer(number) => Some(*number as f64),
        toml::Value::String(text) => text.split_whitespace().next()?.parse().ok(),
        _ => None,
    }
}

fn charts(sweep: &Sweep, records: &[Record]) -> Vec<(String, Chart)> {
    let outputs: BTreeSet<&String> = records.iter().flat_map(|r| r.outputs.keys()).collect();
    let mut charts = Vec::new();
    for input in sweep.keys().iter().filter(|key| *key != "seed") {
        let before = charts.len();
        for output in &outputs {
            let points: Vec<(f64, f64)> = records
                .iter()
                .filter_map(|r| Some((number(r.values.get(input)?)?, *r.outputs.get(*output)?)))
                .collect();
            let grouped = grouped(points);
            let flat = grouped.windows(2).all(|pair| pair[0].1 == pair[1].1);
            if grouped.len() < 2 || flat || charts.len() == before + CHARTS {
                continue;
            }
            let unit = records.iter().find_map(|r| unit(r.values.get(input)?)).unwrap_or_default();
            let name = slug(&format!("{output} over {input}"));
            charts.push((name, chart(input, &unit, output, grouped)));
        }
    }
    charts
}

/// Letters and digits with single dashes between.
fn slug(text: &str) -> String {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-").to_lowercase()
}

fn unit(value: &toml::Value) -> Option<String> {
    let (_, unit) = value.as_str()?.trim().split_once(char::is_whitespace)?;
    Some(unit.trim().to_owned())
}

fn chart(input: &str, unit: &str, output: &str, points: Vec<(f64, f64)>) -> Chart {
    let label = if unit.is_empty() { input.to_owned() } else { format!("{input} [{unit}]") };
    Chart {
        title: format!("{output} over {input}"),
        caption: "Mean over the cases with the same value, or with neighbouring values where there are many.".into(),
        // The unit stands in the label as the sweep file has it: the axis must not scale it again.
        x: Axis::linear(&label, ""),
        y: Axis::linear(output, ""),
        series: vec![Series { name: output.to_owned(), points, dots: true }],
        mark: None,
    }
}

/// Means of y over equal x; over [`POINTS`] groups of neighbouring x where there are more.
fn grouped(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut groups: Vec<Vec<(f64, f64)>> =
        points.chunk_by(|a, b| a.0 == b.0).map(<[_]>::to_vec).collect();
    if groups.len() > POINTS {
        let size = points.len().div_ceil(POINTS);
        groups = points.chunks(size).map(<[_]>::to_vec).collect();
    }
    let mean = |group: &Vec<(f64, f64)>| {
        let count = group.len() as f64;
        let sum = group.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0, sum.1 + p.1));
        (sum.0 / count, sum.1 / count)
    };
    groups.iter().map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_means() {
        let points = vec![(2.0, 4.0), (1.0, 1.0), (1.0, 3.0)];
        assert_eq!(grouped(points), [(1.0, 2.0), (2.0, 4.0)]);
        let many = (0..100).map(|i| (f64::from(i), f64::from(i))).collect();
        let few = grouped(many);
        assert_eq!((few.len(), few[0]), (20, (2.0, 2.0)));
    }
}
