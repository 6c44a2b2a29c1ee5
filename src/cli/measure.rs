//! `riprap measure`: descriptors of meshes, clumps, packings and states.

use super::arguments::Measure;
use super::{Ending, Screen};
use crate::format::{self, Data, particles::Particles};
use crate::geometry::{Bounds, check};
use crate::pack::measure::contacts_of;
use crate::shape::descriptors::describe;
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;

/// Gap up to which two bodies count as touching, over the median radius.
const GAP: f64 = 1e-6;

/// Measures of a table of spheres.
#[derive(Debug, Serialize)]
struct SphereMeasures {
    spheres: usize,
    bodies: usize,
    smallest_radius: f64,
    largest_radius: f64,
    low: [f64; 3],
    high: [f64; 3],
    sphere_volume: f64,
    coordination: f64,
    worst_overlap: f64,
    least_gap: Option<f64>,
    fastest: Option<f64>,
}

pub fn measure(arguments: &Measure, screen: &Screen) -> Result<(), Ending> {
    let mut rows = Vec::new();
    let mut text = String::new();
    for path in &arguments.files {
        let (value, lines) = match format::read(path)? {
            Data::Mesh(mesh) => {
                let (mesh, repairs) = check::solid(mesh)
                    .map_err(|fault| Ending::Input(format!("{}: {fault}", path.display())))?;
                if !repairs.is_none() {
                    screen.warn(&format!("{}: {repairs}", path.display()));
                }
                described(path, &describe(&mesh)?)?
            }
            Data::Particles(table) => described(path, &spheres(&table))?,
        };
        rows.push(value);
        text.push_str(&lines);
    }
    screen.result(&rows, &text)
}

/// A row as JSON and as `name value` lines.
fn described(path: &Path, measures: &impl Serialize) -> Result<(Value, String), Ending> {
    let value = serde_json::to_value(measures).map_err(|error| Ending::Work(error.to_string()))?;
    let mut text = format!("{}\n", path.display());
    for (name, value) in value.as_object().into_iter().flatten() {
        text.push_str(&format!("  {:24} {value}\n", name.replace('_', " ")));
    }
    Ok((json!({ "file": path, "measures": value }), text))
}

fn spheres(table: &Particles) -> SphereMeasures {
    let body: Vec<u32> = match &table.bodies {
        Some(bodies) => numbered(bodies),
        None => (0..table.len() as u32).collect(),
    };
    let bodies = body.iter().max().map_or(0, |last| *last as usize + 1);
    let median = crate::num::statistics::median(&table.radii).unwrap_or(0.0);
    let contacts = contacts_of(&table.positions, &table.radii, &body, GAP * median);
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
