//! Measures of any file that holds a surface or spheres: descriptors of a mesh;
//! extent, coordination and overlaps of a clump, packing, state or dump.

use super::road::RoadError;
use crate::format::{self, Data, FormatError, Particles};
use crate::geometry::{Bounds, check};
use crate::pack::measure::contacts_of;
use crate::shape::descriptors::{Descriptors, describe};
use serde::Serialize;
use std::path::Path;

/// Gap up to which two bodies count as touching, over the median radius.
const GAP: f64 = 1e-6;

/// Measures of a table of spheres.
#[derive(Debug, Serialize)]
pub struct SphereMeasures {
    /// Number of spheres.
    pub spheres: usize,
    /// Number of bodies; one a sphere where the file does not say.
    pub bodies: usize,
    /// m.
    pub smallest_radius: f64,
    /// m.
    pub largest_radius: f64,
    /// Lower corner of the box around all spheres, m.
    pub low: [f64; 3],
    /// Upper corner, m.
    pub high: [f64; 3],
    /// Sum of the volumes of the spheres, overlaps counted twice, m³.
    pub sphere_volume: f64,
    /// Mean number of other bodies that a body touches.
    pub coordination: f64,
    /// Largest overlap between bodies over the smaller radius.
    pub worst_overlap: f64,
    /// Least gap between bodies, m; negative: overlap; none where no two are near.
    pub least_gap: Option<f64>,
    /// Largest speed, m/s, where the file has velocities.
    pub fastest: Option<f64>,
}

/// What was measured of a file.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Measured {
    /// A closed surface.
    Mesh(Box<Descriptors>),
    /// A table of spheres.
    Spheres(SphereMeasures),
}

/// Measures the file at `path`; also returns what had to be repaired in a surface, if anything.
///
/// # Errors
/// [`RoadError::Format`] for a file that cannot be read, or a surface that bounds no solid.
pub fn measure(path: &Path) -> Result<(Measured, Option<String>), RoadError> {
    match format::read(path)? {
        Data::Mesh(mesh) => {
            let wrong = |problem: String| FormatError::file(path, problem);
            let (mesh, repairs) = check::solid(mesh).map_err(|fault| wrong(fault.to_string()))?;
            let descriptors = describe(&mesh).map_err(|error| wrong(error.to_string()))?;
            let note = (!repairs.is_none()).then(|| repairs.to_string());
            Ok((Measured::Mesh(Box::new(descriptors)), note))
        }
        Data::Particles(table) => Ok((Measured::Spheres(spheres(&table)), None)),
    }
}

/// Measures a table of spheres.
pub fn spheres(table: &Particles) -> SphereMeasures {
    let body: Vec<u32> = match &table.bodies {
        Some(bodies) => numbered(bodies),
        None => (0..table.len() as u32).collect(),
    };
    let bodies = body.iter().max().map_or(0, |last| *last as usize + 1);
    let median = crate::num::statistics::median(&table.radii).unwrap_or(0.0);
    let contacts = contacts_of(&table.positions, &table.radii, &body, GAP * median, None);
    let bounds =
        table.positions.iter().zip(&table.radii).fold(Bounds::EMPTY, |bounds, (centre, radius)| {
            bounds.union(&Bounds::of([centre]).grown(*radius))
        });
    let ball = |radius: &f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    SphereMeasures {
        spheres: table.len(),
        bodies,
        smallest_radius: table.radii.iter().copied().fold(f64::INFINITY, f64::min),
        largest_radius: table.radii.iter().copied().fold(0.0, f64::max),
        low: bounds.low.into(),
        high: bounds.high.into(),
        sphere_volume: table.radii.iter().map(ball).sum(),
        coordination: contacts.coordination(bodies),
        worst_overlap: contacts.worst_overlap,
        least_gap: contacts.least_gap,
        fastest: table.velocities.as_ref().map(|v| v.iter().map(|v| v.norm()).fold(0.0, f64::max)),
    }
}

/// Body numbers made consecutive from 0, in order of appearance.
fn numbered(bodies: &[u64]) -> Vec<u32> {
    let mut known = std::collections::BTreeMap::new();
    bodies
        .iter()
        .map(|body| {
            let next = known.len() as u32;
            *known.entry(*body).or_insert(next)
        })
        .collect()
}
