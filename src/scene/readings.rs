//! What the measuring spheres of a run have read (P18): table, charts over time, and whether it has come to rest.

use crate::num::statistics::mean;
use crate::pack::Reading;
use crate::report::chart::{Axis, Chart, Series};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};

/// What all measuring spheres read in one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Time, s.
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// One a measuring sphere.
    pub readings: Vec<Reading>,
}

/// All that was read.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Readings {
    /// Names of the measuring spheres.
    pub names: Vec<String>,
    /// One a frame.
    pub rows: Vec<Row>,
}

impl Readings {
    /// `run/measures.csv`.
    pub fn csv(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "t,step,name,volume,porosity,porosity_error,bodies,coordination,coordination_held,\
             coordination_mechanical,rattlers,contacts,fabric_xx,fabric_yy,fabric_zz,stress_xx,stress_yy,\
             stress_zz,stress_xy,stress_xz,stress_yz,mean_stress,deviator"
        )?;
        for row in &self.rows {
            for (name, r) in self.names.iter().zip(&row.readings) {
                write!(out, "{:e},{},{name}", row.time, row.step)?;
                write!(
                    out,
                    ",{:e},{:e},{:e},{}",
                    r.volume, r.porosity, r.porosity_error, r.bodies
                )?;
                let numbers =
                    [r.coordination, r.coordination_held, r.coordination_mechanical, r.rattlers];
                numbers.into_iter().try_for_each(|x| optional(out, x))?;
                write!(out, ",{}", r.contacts)?;
                (0..3).try_for_each(|i| optional(out, r.fabric.map(|f| f[i][i])))?;
                for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
                    optional(out, r.stress.map(|s| s[i][j]))?;
                }
                optional(out, r.mean_stress)?;
                optional(out, r.deviator)?;
                writeln!(out)?;
            }
        }
        Ok(())
    }

    /// What is read over time: the name of each file and its chart.
    pub fn charts(&self) -> Vec<(&'static str, Chart)> {
        type Of = fn(&Reading) -> Option<f64>;
        let quantities: [(&str, &str, &str, Of); 3] = [
            ("run/measures-porosity.svg", "porosity", "", |r| Some(r.porosity)),
            ("run/measures-coordination.svg", "coordination number", "", |r| r.coordination),
            ("run/measures-stress.svg", "mean stress", "Pa", |r| r.mean_stress),
        ];
        quantities
            .into_iter()
            .map(|(file, what, unit, of)| {
                let line = |(index, name): (usize, &String)| Series {
                    name: name.clone(),
                    points: self
                        .rows
                        .iter()
                        .filter_map(|row| Some((row.time, of(&row.readings[index])?)))
                        .collect(),
                    dots: true,
                };
                let chart = Chart {
                    title: format!("Measuring spheres: {what} over time"),
                    caption: String::new(),
                    x: Axis::linear("time", "s"),
                    y: Axis::linear(what, unit),
                    series: self.names.iter().enumerate().map(line).collect(),
                    mark: None,
                };
                (file, chart)
            })
            .collect()
    }

    /// Whether each measuring sphere has come to rest: its name, and how much porosity and mean stress still
    /// vary over the last quarter of the frames.
    pub fn verdicts(&self) -> Vec<[String; 2]> {
        let from = self.rows.len() - self.rows.len().div_ceil(4);
        let tail = &self.rows[from..];
        self.names
            .iter()
            .enumerate()
            .map(|(index, name)| {
                let varies = |of: fn(&Reading) -> Option<f64>| {
                    let values: Vec<f64> =
                        tail.iter().filter_map(|row| of(&row.readings[index])).collect();
                    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
                    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                    let mean = mean(&values).filter(|m| *m != 0.0)?;
                    Some((mean, (high - low) / mean.abs()))
                };
                let said = |what: &str, found: Option<(f64, f64)>| match found {
                    Some((mean, spread)) => {
                        format!("{what} {mean:.4e} within {:.2} %", 100.0 * spread)
                    }
                    None => format!("no {what}"),
                };
                let told = format!(
                    "last {} frames: {}; {}",
                    tail.len(),
                    said("porosity", varies(|r| Some(r.porosity))),
                    said("mean stress [Pa]", varies(|r| r.mean_stress))
                );
                [name.clone(), told]
            })
            .collect()
    }
}

fn optional(out: &mut dyn Write, value: Option<f64>) -> io::Result<()> {
    match value {
        Some(value) => write!(out, ",{value:e}"),
        None => write!(out, ","),
    }
}
