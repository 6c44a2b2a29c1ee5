//! Measuring spheres of a scene (P18), read in every frame of our own run: `run/measures.csv`, charts over
//! time, and whether what they read has come to rest.

use super::parameters::MeasureParameters;
use super::surveying;
use crate::geometry::Region;
use crate::model::{Frame, Model};
use crate::num::Vec3;
use crate::num::statistics::{mean, median};
use crate::pack::survey::measure;
use crate::pack::{Bed, Probe, Push, Reading, Spheres};
use crate::report::chart::{Axis, Chart, Series};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};

/// Gap up to which two bodies count as touching, over the median radius.
const GAP: f64 = 1e-6;

/// What all measuring spheres read in one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    time: f64,
    step: u64,
    readings: Vec<Reading>,
}

/// Measuring spheres at work.
pub struct Watch {
    names: Vec<String>,
    probes: Vec<Probe>,
    spheres: Spheres,
    tolerance: f64,
    /// Whether contact forces of the last frame are kept.
    keeps: bool,
    /// What was read so far.
    pub rows: Vec<Row>,
    /// Contact forces of the last frame.
    pub last: Vec<Push>,
}

impl Watch {
    /// Measuring spheres in a model; `None` where nothing is asked for.
    pub fn new(
        wanted: &[MeasureParameters],
        keeps: bool,
        model: &Model,
        region: Option<&Region>,
        rows: Vec<Row>,
    ) -> Option<Self> {
        if wanted.is_empty() && !keeps {
            return None;
        }
        let radii: Vec<f64> = model.spheres.iter().map(|sphere| sphere.radius).collect();
        let tolerance = GAP * median(&radii).unwrap_or(0.0);
        let spheres = Spheres {
            centres: Vec::new(),
            radii,
            body: model.spheres.iter().map(|sphere| sphere.body).collect(),
            dimension: model.dimension.count(),
            room: match region {
                Some(Region::Box(room)) => Some(room.bounds),
                _ => None,
            },
            periodic: region.and_then(Region::cell).map_or([false; 3], |cell| cell.periodic),
            ..Spheres::default()
        };
        let ball = |m: &MeasureParameters| Probe::Ball {
            at: Vec3::from(m.at.map(|x| x.0)),
            radius: m.radius.0,
        };
        Some(Self {
            names: wanted.iter().map(|m| m.name.clone()).collect(),
            probes: wanted.iter().map(ball).collect(),
            spheres,
            tolerance,
            keeps,
            rows,
            last: Vec::new(),
        })
    }

    /// True if contact forces are wanted with a frame.
    pub fn wants(&self, last: bool) -> bool {
        !self.probes.is_empty() || last
    }

    /// Reads a frame.
    pub fn look(&mut self, frame: &Frame, pushes: Vec<Push>) {
        if !self.probes.is_empty() {
            let spheres = Spheres {
                centres: frame.centres.clone(),
                pushes: pushes.clone(),
                ..self.spheres.clone()
            };
            let bed = Bed::new(spheres, self.tolerance);
            let readings = self.probes.iter().map(|probe| measure(&bed, probe)).collect();
            self.rows.push(Row { time: frame.time, step: frame.step, readings });
        }
        if self.keeps {
            self.last = pushes;
        }
    }

    /// True if there is a table.
    pub fn has_rows(&self) -> bool {
        !self.probes.is_empty()
    }

    /// True if contact forces of the last frame are to be written.
    pub fn keeps_pushes(&self) -> bool {
        self.keeps
    }

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

    /// `run/contacts.csv`.
    pub fn contacts(&self, out: &mut dyn Write) -> io::Result<()> {
        surveying::write_pushes(out, &self.last)
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

    /// Whether each measuring sphere has come to rest: how much porosity and mean stress still
    /// vary over the last quarter of the frames, one sentence each.
    pub fn verdicts(&self) -> Vec<String> {
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
                format!(
                    "measuring sphere {name}, last {} frames: {}; {}",
                    tail.len(),
                    said("porosity", varies(|r| Some(r.porosity))),
                    said("mean stress [Pa]", varies(|r| r.mean_stress))
                )
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
