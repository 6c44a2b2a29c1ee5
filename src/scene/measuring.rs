//! Measures of any file that holds a surface or spheres: descriptors of a mesh;
//! extent, coordination and overlaps of a clump, packing, state or dump.

use super::road::RoadError;
use crate::clump::{self, Fidelity};
use crate::format::{self, Data, FormatError, Particles};
use crate::geometry::{Ball, Bounds, Posed, Primitive, check, union};
use crate::num::random;
use crate::pack::measure::contacts_of;
use crate::shape::Solid;
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
    /// Size and form of the united spheres, where they are one body of at most
    /// 500 spheres that overlap; from their surface in triangles, some 1 % off.
    pub form: Option<Box<Descriptors>>,
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
            let mut notes = Vec::new();
            if !repairs.is_none() {
                notes.push(repairs.to_string());
            }
            if let Err(fault) = check::simple(&mesh) {
                notes.push(format!("{fault}; what is enclosed twice counts twice"));
            }
            let note = (!notes.is_empty()).then(|| notes.join("; "));
            Ok((Measured::Mesh(Box::new(descriptors)), note))
        }
        Data::Particles(table) => Ok((Measured::Spheres(spheres(&table)), None)),
    }
}

/// Errors of the spheres in the file at `path`, one body in the frame of the closed
/// surface `mesh`, against the solid it bounds.
///
/// # Errors
/// [`RoadError::Format`] for a file that cannot be read, holds no spheres, or a surface that
/// bounds no solid.
pub fn against(path: &Path, mesh: &Path) -> Result<Fidelity, RoadError> {
    let Data::Particles(table) = format::read(path)? else {
        return Err(FormatError::file(path, "holds no spheres").into());
    };
    let (surface, _) = check::solid(format::read_mesh(mesh)?)
        .map_err(|fault| FormatError::file(mesh, fault.to_string()))?;
    let mass = surface.mass_properties();
    let solid =
        Solid { name: mesh.display().to_string(), mesh: surface, mass, recipe: String::new() };
    let balls: Vec<Ball> = table
        .positions
        .iter()
        .zip(&table.radii)
        .map(|(centre, radius)| Ball { centre: *centre, radius: *radius })
        .collect();
    Ok(clump::measure(&solid, &balls, clump::POINTS)?)
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
        form: (bodies == 1 && table.len() <= 500).then(|| form(table)).flatten().map(Box::new),
        fastest: table.velocities.as_ref().map(|v| v.iter().map(|v| v.norm()).fold(0.0, f64::max)),
    }
}

/// Pieces in a turn of the surfaces that stand for spheres.
const SEGMENTS: u32 = 20;

/// Descriptors of the union of all spheres, each as a geodesic surface of the
/// volume of the sphere; `None` where that is no solid (spheres that only touch).
fn form(table: &Particles) -> Option<Descriptors> {
    let unit = Primitive::Sphere { diameter: 1.0 };
    let swell = (unit.volume() / unit.mesh(SEGMENTS).mass_properties().volume).cbrt();
    let parts: Vec<_> = table
        .positions
        .iter()
        .zip(&table.radii)
        .enumerate()
        .map(|(index, (centre, radius))| {
            let primitive = Primitive::Sphere { diameter: 2.0 * radius * swell };
            // Each turned its own way, so that no faces of two lie in one plane.
            let rotation = random::rotation(&mut random::stream(0, "measure", index as u64));
            Posed { primitive, rotation, centre: *centre }.mesh(SEGMENTS)
        })
        .collect();
    let (mesh, _) = union::unite_filled(&parts).ok()?;
    describe(&mesh).ok()
}

/// Body numbers made consecutive from 0, in order of appearance.
pub(super) fn numbered(bodies: &[u64]) -> Vec<u32> {
    let mut known = std::collections::BTreeMap::new();
    bodies
        .iter()
        .map(|body| {
            let next = known.len() as u32;
            *known.entry(*body).or_insert(next)
        })
        .collect()
}
