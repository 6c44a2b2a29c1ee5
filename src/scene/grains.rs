//! Which grains a scene asks for: distinct shapes, and how often each is used.

use super::Loaded;
use super::parameters::{Family, Size};
use crate::clump::{self, Clump};
use crate::geometry::MeshFault;
use crate::num::random::{stream, uniform};
use crate::num::{Fault, Job};
use crate::shape::{self, Drawn, Made, Shape, ShapeError, Solid};
use std::path::Path;

/// One distinct grain: what it is drawn from.
#[derive(Debug, Clone, PartialEq)]
pub struct Draw {
    /// Index of the family.
    pub family: u16,
    /// Number within the family.
    pub index: u32,
    /// `family-0007`.
    pub name: String,
    /// Equivalent-volume diameter, m; `None` keeps the size of the shape.
    pub size: Option<f64>,
}

/// One distinct grain, made.
#[derive(Debug, Clone)]
pub struct Grain {
    /// Index of the family.
    pub family: u16,
    /// True shape; `None` for spheres and discs, and where it was left on disk.
    pub solid: Option<Solid>,
    /// Spheres and mass properties.
    pub clump: Clump,
}

/// Number of distinct grains of a family.
fn distinct(family: &Family, base: &Path) -> u32 {
    let natural = match (&family.shape, &family.size) {
        (Shape::Sphere, Some(Size::Fixed(_))) if family.cluster.is_none() => 1,
        // Files that cannot be listed are reported when the shapes are read.
        (Shape::Files(files), Some(Size::Fixed(_)) | None) => {
            files.list(base).map_or(family.count, |found| found.len() as u32)
        }
        _ => family.count,
    };
    family.distinct.unwrap_or(natural).min(family.count)
}

/// Distinct grains of a scene in order, each with its size drawn.
///
/// # Errors
/// A fault under the family's `size` if its sieve file cannot be used.
pub fn draws(loaded: &Loaded) -> Result<Vec<Draw>, Fault> {
    let scene = &loaded.scene;
    let mut draws = Vec::new();
    for (number, family) in scene.grains.iter().enumerate() {
        let count = distinct(family, loaded.base());
        let graded = match &family.size {
            Some(Size::Graded(grading)) => grading
                .sizes(
                    count as usize,
                    scene.dimension as usize,
                    loaded.base(),
                    scene.seed,
                    &format!("size {}", family.name),
                )
                .map_err(|fault| fault.under(format!("grains[{number}].size")))?,
            _ => Vec::new(),
        };
        for index in 0..count {
            let size = family.size.as_ref().map(|size| match size {
                // One size was drawn for each.
                Size::Graded(_) => graded[index as usize],
                Size::Fixed(length) => length.0,
                Size::Uniform(limits) => {
                    let mut source =
                        stream(scene.seed, &format!("size {}", family.name), u64::from(index));
                    uniform(&mut source, limits.min.0, limits.max.0)
                }
            });
            let name = format!("{}-{index:04}", family.name);
            draws.push(Draw { family: number as u16, index, name, size });
        }
    }
    Ok(draws)
}

/// For every single grain of the scene, family by family, the index of its draw.
pub fn copies(loaded: &Loaded, draws: &[Draw]) -> Vec<u32> {
    let mut copies = Vec::new();
    let mut first = 0;
    for (number, family) in loaded.scene.grains.iter().enumerate() {
        let count = draws[first..].iter().take_while(|draw| draw.family == number as u16).count();
        copies.extend((0..family.count).map(|copy| first as u32 + copy % count.max(1) as u32));
        first += count;
    }
    copies
}

/// The true shape of a draw, with its statistics; `None` for spheres and discs.
///
/// # Errors
/// A fault under the family's `shape` if its files cannot be used or no valid grain was drawn.
pub fn made(loaded: &Loaded, draw: &Draw) -> Result<Option<Made>, Fault> {
    let family = &loaded.scene.grains[draw.family as usize];
    if matches!(family.shape, Shape::Sphere) {
        return Ok(None);
    }
    let purpose = format!("shape {}", family.name);
    shape::make(
        &family.shape,
        &family.name,
        u64::from(draw.index),
        draw.size,
        loaded.scene.seed,
        &purpose,
        loaded.base(),
    )
    .map(Some)
    .map_err(|error| no_solid(draw, &error))
}

fn no_solid(draw: &Draw, error: &ShapeError) -> Fault {
    let key = format!("grains[{}].shape", draw.family);
    Fault::new(key, error.to_string(), "a shape that gives closed solids of one piece")
}

/// What the method of a draw gives at first, valid grain or not, and why not;
/// `None` for shapes that are not drawn.
///
/// # Errors
/// A fault under the family's `shape` if nothing at all was drawn.
pub fn as_drawn(loaded: &Loaded, draw: &Draw) -> Result<Option<(Drawn, Option<MeshFault>)>, Fault> {
    let family = &loaded.scene.grains[draw.family as usize];
    let purpose = format!("shape {}", family.name);
    let (index, seed) = (u64::from(draw.index), loaded.scene.seed);
    shape::first_draw(&family.shape, index, draw.size, seed, &purpose)
        .map_err(|error| no_solid(draw, &error))
}

/// The clump of a draw.
///
/// # Errors
/// A fault under the family's `clump` if the method finds no sphere for this shape.
pub fn reproduce(
    loaded: &Loaded,
    draw: &Draw,
    solid: Option<&Solid>,
    job: &Job,
) -> Result<Clump, Fault> {
    let family = &loaded.scene.grains[draw.family as usize];
    let (Some(solid), Some(method)) = (solid, &family.clump) else {
        let radius = draw.size.unwrap_or(1.0) * 0.5;
        if let Some(cluster) = &family.cluster {
            let purpose = format!("cluster {}", family.name);
            let mut source = stream(loaded.scene.seed, &purpose, u64::from(draw.index));
            let planar = loaded.scene.dimension == 2;
            return Ok(cluster.make(&draw.name, radius, planar, &mut source));
        }
        return Ok(match loaded.scene.dimension {
            2 => clump::disc(&draw.name, radius),
            _ => clump::sphere(&draw.name, radius),
        });
    };
    clump::reproduce(solid, method, family.mass, loaded.scene.seed, u64::from(draw.index), job)
        .map_err(|error| {
            let key = format!("grains[{}].clump", draw.family);
            Fault::new(key, error.to_string(), "parameters that give at least one sphere")
        })
}
