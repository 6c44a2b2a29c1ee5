//! Random volumes and the user's own: one file a method.
//!
//! [`generate`] makes one grain; [`descriptors::describe`] measures it.

pub mod balloon;
pub mod base;
pub mod cells;
pub mod crumple;
pub mod descriptors;
pub mod draw;
pub mod field;
pub mod files;
pub mod growth;
pub mod harmonics;
mod methods;
pub mod midpoint;
pub mod node_spheres;
pub mod noise;
pub mod patir;
pub mod polyhedron;
pub mod rain;
pub mod rough;
pub mod roundness;
pub mod sponge;
pub mod superquadric;
pub mod tailored;
pub mod turned_rain;
pub mod union_of_solids;
pub mod voronoi;
pub mod whitehouse;

pub use balloon::BalloonParameters;
pub use crumple::CrumpleParameters;
pub use descriptors::Descriptors;
pub use draw::{Draw, Drawn, Fact};
pub use files::FileParameters;
pub use growth::GrowthParameters;
pub use harmonics::HarmonicsParameters;
pub use methods::METHODS;
pub use midpoint::MidpointParameters;
pub use node_spheres::NodeSphereParameters;
pub use noise::NoiseParameters;
pub use patir::PatirParameters;
pub use polyhedron::PolyhedronParameters;
pub use rain::RainParameters;
pub use sponge::SpongeParameters;
pub use superquadric::SuperquadricParameters;
pub use tailored::TailoredParameters;
pub use turned_rain::TurnedRainParameters;
pub use union_of_solids::UnionParameters;
pub use voronoi::VoronoiParameters;
pub use whitehouse::WhitehouseParameters;

use crate::format::{self, FormatError};
use crate::geometry::{GeometryError, MassProperties, Mesh, MeshFault, Primitive, check};
use crate::num::{Fault, random};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A grain's true shape: one closed, outward-oriented, connected surface of
/// positive volume whose vertices are exactly representable in single
/// precision, so that its STL file is the same solid bit for bit.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// File stem and name in reports, for example `smooth-0007`.
    pub name: String,
    /// Surface, metres; the centroid lies at the origin to single precision.
    pub mesh: Mesh,
    /// Exact for the mesh.
    pub mass: MassProperties,
    /// How it was made, one line for people.
    pub recipe: String,
}

impl Solid {
    /// The same solid `scale` times as large in each direction about its centroid's origin.
    pub fn scaled(&self, scale: f64) -> Self {
        let mesh = self.mesh.mapped(|vertex| vertex * scale);
        let mass = mesh.mass_properties();
        Self { mesh, mass, ..self.clone() }
    }
}

/// How a grain gets its shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Shape {
    /// A sphere.
    Sphere,
    /// Union of random base solids.
    Union(UnionParameters),
    /// Solids from files.
    Files(FileParameters),
    /// Spheres at random nodes of a volume.
    NodeSpheres(NodeSphereParameters),
    /// Inflated base volume.
    Balloon(BalloonParameters),
    /// Rain of cubes on a grid.
    Rain(RainParameters),
    /// Rain of turned cubes.
    TurnedRain(TurnedRainParameters),
    /// Random growth of a cube.
    Growth(GrowthParameters),
    /// Sponge with cubes removed at random.
    Sponge(SpongeParameters),
    /// Rough surface by linear transformation.
    Patir(PatirParameters),
    /// Rough surface from its autocorrelation.
    Whitehouse(WhitehouseParameters),
    /// Crumpled sheet.
    Crumple(CrumpleParameters),
    /// Fractal surface by midpoint displacement.
    Midpoint(MidpointParameters),
    /// Spherical harmonics with a given spectrum.
    Harmonics(HarmonicsParameters),
    /// Polyhedra cut by random planes.
    Polyhedron(PolyhedronParameters),
    /// Voronoi cells.
    Voronoi(VoronoiParameters),
    /// Superquadrics.
    Superquadric(SuperquadricParameters),
    /// Ellipsoids displaced by noise.
    Noise(NoiseParameters),
    /// Made to measure: wanted distributions of descriptors.
    Tailored(TailoredParameters),
}

/// Draws that may fail the gate before a grain is given up.
const REDRAWS: u64 = 20;
/// Pieces in a turn of the surface that stands for a sphere.
const SPHERE_SEGMENTS: u32 = 40;

/// Why there is no grain.
#[derive(Debug, Error)]
pub enum ShapeError {
    /// A parameter is out of its range.
    #[error("{0}")]
    Parameters(#[from] Fault),
    /// A file cannot be read.
    #[error("{0}")]
    File(#[from] FormatError),
    /// A folder cannot be read.
    #[error("{}: cannot read the folder: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A folder holds nothing that could be a solid.
    #[error("{}: the folder holds no .stl, .ply or .obj file", path.display())]
    NoFiles {
        /// The folder.
        path: PathBuf,
    },
    /// A file holds a surface that is no solid.
    #[error("{}: {fault}", path.display())]
    NoSolid {
        /// The file.
        path: PathBuf,
        /// Why.
        fault: MeshFault,
    },
    /// No draw gave a solid.
    #[error("grain `{name}`: none of {draws} draws gave a solid; the last: {reason}")]
    NoDraw {
        /// The grain.
        name: String,
        /// Draws made.
        draws: u64,
        /// Why the last one failed.
        reason: GeometryError,
    },
}

/// A grain with the statistics of its surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Made {
    /// The grain.
    pub solid: Solid,
    /// Statistics that its method keeps, asked and measured.
    pub facts: Vec<Fact>,
}

impl Shape {
    /// The random method and its key; `None` for spheres and files.
    fn method(&self) -> Option<(&'static str, &dyn Draw)> {
        Some(match self {
            Self::Sphere | Self::Files(_) | Self::Tailored(_) => return None,
            Self::Union(parameters) => ("union", parameters),
            Self::NodeSpheres(parameters) => ("node_spheres", parameters),
            Self::Balloon(parameters) => ("balloon", parameters),
            Self::Rain(parameters) => ("rain", parameters),
            Self::TurnedRain(parameters) => ("turned_rain", parameters),
            Self::Growth(parameters) => ("growth", parameters),
            Self::Sponge(parameters) => ("sponge", parameters),
            Self::Patir(parameters) => ("patir", parameters),
            Self::Whitehouse(parameters) => ("whitehouse", parameters),
            Self::Crumple(parameters) => ("crumple", parameters),
            Self::Midpoint(parameters) => ("midpoint", parameters),
            Self::Harmonics(parameters) => ("harmonics", parameters),
            Self::Polyhedron(parameters) => ("polyhedron", parameters),
            Self::Voronoi(parameters) => ("voronoi", parameters),
            Self::Superquadric(parameters) => ("superquadric", parameters),
            Self::Noise(parameters) => ("noise", parameters),
        })
    }

    /// The first value that cannot be used, if any; keys are relative to this shape.
    pub fn validate(&self) -> Result<(), Fault> {
        match (self, self.method()) {
            (Self::Files(parameters), _) => parameters.validate().map_err(|f| f.under("files")),
            (Self::Tailored(parameters), _) => {
                parameters.validate().map_err(|f| f.under("tailored"))
            }
            (_, Some((key, method))) => method.validate().map_err(|f| f.under(key)),
            (_, None) => Ok(()),
        }
    }
}

/// Grain number `index` of the grains called `name`.
///
/// `size` is the diameter of the sphere of equal volume (m); without it the
/// grain keeps its own dimensions (a sphere has diameter 1 m). Numbers come
/// from the stream `stream_name`, `index` of `seed`; a draw that fails the gate
/// is repeated, up to 20 times, with the stream `stream_name/redraw-k`, and the
/// recipe says so. Relative paths start at `base`. The result has passed
/// [`check::solid`] and [`check::simple`] at its final size.
pub fn generate(
    shape: &Shape,
    name: &str,
    index: u64,
    size: Option<f64>,
    seed: u64,
    stream_name: &str,
    base: &Path,
) -> Result<Solid, ShapeError> {
    make(shape, name, index, size, seed, stream_name, base).map(|made| made.solid)
}

/// As [`generate`], with the statistics that the method keeps.
pub fn make(
    shape: &Shape,
    name: &str,
    index: u64,
    size: Option<f64>,
    seed: u64,
    stream_name: &str,
    base: &Path,
) -> Result<Made, ShapeError> {
    shape.validate()?;
    if let Some(size) = size {
        Fault::positive("size", size)?;
    }
    let numbered = format!("{name}-{index:04}");
    let plain = |solid| Made { solid, facts: Vec::new() };
    match (shape, shape.method()) {
        (Shape::Files(parameters), _) => {
            from_file(parameters, numbered, index, size, base).map(plain)
        }
        (Shape::Tailored(parameters), _) => {
            let draws = Draws { seed, stream_name, index };
            let mut wanted = random::stream(seed, &format!("{stream_name}/wanted"), index);
            let target = parameters.target(base, &mut wanted)?;
            drawn(&tailored::Fitted { target, parameters }, numbered, size, &draws)
        }
        (_, Some((_, method))) => {
            let draws = Draws { seed, stream_name, index };
            drawn(method, numbered, size, &draws)
        }
        (_, None) => sphere(numbered, size.unwrap_or(1.0)).map(plain),
    }
}

/// The first draw of grain `index` as it comes, with centroid and size as the
/// grain would have, and why it is no valid grain, if so: for surfaces and
/// volumes that are of interest by themselves. Not scaled where it encloses nothing.
pub fn first_draw(
    shape: &Shape,
    index: u64,
    size: Option<f64>,
    seed: u64,
    stream_name: &str,
) -> Result<Option<(Drawn, Option<MeshFault>)>, ShapeError> {
    shape.validate()?;
    let Some((_, method)) = shape.method() else { return Ok(None) };
    let mut stream = random::stream(seed, stream_name, index);
    let mut drawn = method.draw(&mut stream).map_err(|reason| ShapeError::NoDraw {
        name: format!("{index}"),
        draws: 1,
        reason,
    })?;
    let scale = size.map_or(Scale::Factor(1.0), Scale::Size);
    let (mesh, fault) = match finish(&drawn.mesh, String::new(), String::new(), scale) {
        Ok(solid) => (solid.mesh, None),
        Err(fault) => {
            let own = drawn.mesh.mass_properties();
            let open = matches!(fault, MeshFault::Open { .. }) || own.volume <= 0.0;
            let factor = match size {
                Some(size) if !open => size / own.equivalent_diameter(),
                _ => 1.0,
            };
            (drawn.mesh.mapped(|p| p * factor), Some(fault))
        }
    };
    drawn.mesh = mesh;
    Ok(Some((drawn, fault)))
}

/// A surface whose volume is that of the sphere.
fn sphere(name: String, size: f64) -> Result<Solid, ShapeError> {
    let mesh = Primitive::Sphere { diameter: 1.0 }.mesh(SPHERE_SEGMENTS);
    let recipe = format!("sphere of diameter {size} m in {} triangles", mesh.triangles.len());
    finish(&mesh, name.clone(), recipe, Scale::Size(size)).map_err(|fault| ShapeError::NoDraw {
        name,
        draws: 1,
        reason: GeometryError::NoSolid { what: "the sphere".to_owned(), fault },
    })
}

/// Where the numbers of a grain come from.
struct Draws<'a> {
    seed: u64,
    stream_name: &'a str,
    index: u64,
}

/// The first of up to 21 draws that is a valid grain.
fn drawn(
    method: &dyn Draw,
    name: String,
    size: Option<f64>,
    draws: &Draws,
) -> Result<Made, ShapeError> {
    let scale = size.map_or(Scale::Factor(1.0), Scale::Size);
    let mut last = GeometryError::NothingToUnite;
    for redraw in 0..=REDRAWS {
        let purpose = match redraw {
            0 => draws.stream_name.to_owned(),
            _ => format!("{}/redraw-{redraw}", draws.stream_name),
        };
        let mut stream = random::stream(draws.seed, &purpose, draws.index);
        let made = method.draw(&mut stream).and_then(|drawn| {
            let mut recipe = drawn.recipe;
            if redraw > 0 {
                recipe.push_str(&format!("; {redraw} earlier draws gave no solid"));
            }
            finish(&drawn.mesh, name.clone(), recipe, scale)
                .map(|solid| Made { solid, facts: drawn.facts })
                .map_err(|fault| GeometryError::NoSolid { what: "the grain".to_owned(), fault })
        });
        match made {
            Ok(made) => return Ok(made),
            Err(reason) => last = reason,
        }
    }
    Err(ShapeError::NoDraw { name, draws: REDRAWS + 1, reason: last })
}

fn from_file(
    parameters: &FileParameters,
    name: String,
    index: u64,
    size: Option<f64>,
    base: &Path,
) -> Result<Solid, ShapeError> {
    let paths = parameters.list(base)?;
    let path = &paths[(index % paths.len() as u64) as usize];
    let refused = |fault| ShapeError::NoSolid { path: path.clone(), fault };
    let (mesh, repairs) = check::solid_in_double(format::read_mesh(path)?).map_err(refused)?;
    let name = format!("{name}-{}", files::stem(path));
    let recipe = format!("{}; {repairs}", path.display());
    let scale = size.map_or(Scale::Factor(parameters.unit.0), Scale::Size);
    finish(&mesh, name, recipe, scale).map_err(refused)
}

/// How large a grain becomes.
#[derive(Debug, Clone, Copy)]
enum Scale {
    /// Diameter of the sphere of equal volume, m.
    Size(f64),
    /// Times its own dimensions.
    Factor(f64),
}

/// Moves the centroid to the origin, scales, and passes the gate.
fn finish(mesh: &Mesh, name: String, recipe: String, scale: Scale) -> Result<Solid, MeshFault> {
    let own = mesh.mass_properties();
    let factor = match scale {
        Scale::Size(size) => size / own.equivalent_diameter(),
        Scale::Factor(factor) => factor,
    };
    let (mesh, _) = check::solid(mesh.mapped(|p| (p - own.centroid) * factor))?;
    check::simple(&mesh)?;
    let mass = mesh.mass_properties();
    Ok(Solid { name, mesh, mass, recipe })
}

#[cfg(test)]
mod closed_forms;
#[cfg(test)]
mod tests;
