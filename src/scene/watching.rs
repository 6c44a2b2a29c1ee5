//! Measuring spheres of a scene (P18), read in every frame of our own run.

use super::parameters::MeasureParameters;
use super::readings::{Readings, Row};
use super::surveying;
use crate::geometry::Region;
use crate::model::{Frame, Model};
use crate::num::Vec3;
use crate::num::statistics::median;
use crate::pack::survey::measure;
use crate::pack::{Bed, Probe, Push, Spheres};
use std::io::{self, Write};

/// Gap up to which two bodies count as touching, over the median radius.
const GAP: f64 = 1e-6;

/// Measuring spheres at work.
pub struct Watch {
    probes: Vec<Probe>,
    spheres: Spheres,
    tolerance: f64,
    /// Whether contact forces of the last frame are kept.
    keeps: bool,
    /// What was read so far.
    pub readings: Readings,
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
            probes: wanted.iter().map(ball).collect(),
            spheres,
            tolerance,
            keeps,
            readings: Readings { names: wanted.iter().map(|m| m.name.clone()).collect(), rows },
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
            self.readings.rows.push(Row { time: frame.time, step: frame.step, readings });
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

    /// `run/contacts.csv`.
    pub fn contacts(&self, out: &mut dyn Write) -> io::Result<()> {
        surveying::write_pushes(out, &self.last)
    }
}
