//! `compare.json` and `compare.csv`.

use super::{Comparison, Opponent, Trajectory};
use crate::model::Cost;
use crate::report::{ReportError, write_whole};
use std::fmt::Write;
use std::path::Path;

const HEADER: &str = "solver,quantity,unit,value,ours,difference,relative,allowed,passed\n";

impl Comparison {
    /// Writes `compare.json` and `compare.csv` into `folder`, each whole or not at all.
    pub fn write(&self, folder: &Path) -> Result<(), ReportError> {
        let json = serde_json::to_vec_pretty(self)?;
        write_whole(&folder.join("compare.json"), &json)?;
        write_whole(&folder.join("compare.csv"), self.csv().as_bytes())
    }

    /// One row a solver and quantity; cells that have no meaning are empty.
    pub fn csv(&self) -> String {
        let mut text = HEADER.to_owned();
        if let Some(statistics) = &self.ours.statistics {
            for quantity in super::Quantity::ALL {
                if let Some(value) = statistics.value(quantity) {
                    let (key, unit) = (quantity.key(), quantity.unit());
                    line(&mut text, &self.ours.solver, key, unit, value);
                }
            }
        }
        costs(&mut text, &self.ours.solver, &self.ours.cost);
        for other in &self.others {
            solver(&mut text, other);
        }
        text
    }
}

fn solver(text: &mut String, other: &Opponent) {
    let name = quoted(&other.side.solver);
    for row in &other.rows {
        let (key, unit) = (row.quantity.key(), row.quantity.unit());
        // Writing into a String cannot fail.
        let _ = writeln!(
            text,
            "{name},{key},{unit},{},{},{},{},{},{}",
            short(row.theirs),
            short(row.ours),
            short(row.theirs - row.ours),
            short(row.relative),
            short(row.allowed),
            row.passed
        );
    }
    trajectory(text, &other.side.solver, "ours", &other.against_ours);
    if let Some(twin) = &other.twin {
        trajectory(text, &other.side.solver, "twin", &twin.trajectory);
        if let Some(worst) = twin.worst_in_window {
            line(text, &other.side.solver, "twin_worst_in_window", "smallest radii", worst);
        }
    }
    costs(text, &other.side.solver, &other.side.cost);
}

fn trajectory(text: &mut String, solver: &str, against: &str, trajectory: &Trajectory) {
    if let Some(worst) = &trajectory.worst {
        line(text, solver, &format!("{against}_worst_position"), "smallest radii", worst.largest);
        line(text, solver, &format!("{against}_worst_time"), "s", worst.time);
    }
    if let Some(time) = trajectory.agrees_until {
        line(text, solver, &format!("{against}_agrees_until"), "s", time);
    }
    if let Some(time) = trajectory.growth_time {
        line(text, solver, &format!("{against}_growth_time"), "s", time);
    }
}

fn costs(text: &mut String, solver: &str, cost: &Cost) {
    line(text, solver, "cpu", "s", cost.cpu_seconds);
    line(text, solver, "wall", "s", cost.wall_seconds);
    line(text, solver, "steps", "", cost.steps as f64);
    if let Some(speed) = cost.speed() {
        line(text, solver, "sphere_steps_per_second", "1/s", speed);
    }
    if let Some(bytes) = cost.peak_bytes {
        line(text, solver, "peak_memory", "B", bytes as f64);
    }
}

fn line(text: &mut String, solver: &str, key: &str, unit: &str, value: f64) {
    if value.is_finite() {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "{},{key},{unit},{},,,,,", quoted(solver), short(value));
    }
}

/// The shortest text that reads back as the same number.
fn short(value: f64) -> String {
    let (plain, scientific) = (value.to_string(), format!("{value:e}"));
    if plain.len() <= scientific.len() { plain } else { scientific }
}

/// A cell of a CSV file, in quotes where it needs them (RFC 4180).
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}
