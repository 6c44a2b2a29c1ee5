//! Random volumes and the user's own: one file a method.
//!
//! [`generate`] makes one grain; [`descriptors::describe`] measures it.

pub mod descriptors;
pub mod files;
pub mod union_of_solids;

pub use descriptors::Descriptors;
pub use files::FileParameters;
pub use union_of_solids::UnionParameters;

use crate::format::{self, FormatError};
use crate::geometry::{GeometryError, MassProperties, Mesh, MeshFault, Primitive, check};
use crate::num::{Fault, MethodEntry, random};
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
}

/// The methods of this room.
pub const METHODS: &[MethodEntry] = &[
    MethodEntry {
        key: "sphere",
        id: "",
        summary: "a sphere",
        source: "",
        example: r#"shape = "sphere""#,
    },
    MethodEntry {
        key: "union",
        id: "G1",
        summary: "union of random boxes, cylinders, cones, ellipsoids and spheres through one point",
        source: "Sajjadi & Khalili 2015",
        example: r#"shape.union = { solids = [2, 5] }"#,
    },
    MethodEntry {
        key: "union",
        id: "G2",
        summary: "families of the union: smooth, sharp, chosen kinds and ranges of dimensions",
        source: "Sajjadi & Khalili 2015",
        example: r#"shape.union = { family = "sharp", solids = [2, 4] }"#,
    },
    MethodEntry {
        key: "files",
        id: "",
        summary: "the user's own closed surfaces: STL, PLY, OBJ",
        source: "",
        example: r#"shape.files = { folder = "grains" }"#,
    },
];

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

impl Shape {
    /// The first value that cannot be used, if any; keys are relative to this shape.
    pub fn validate(&self) -> Result<(), Fault> {
        match self {
            Self::Sphere => Ok(()),
            Self::Union(parameters) => parameters.validate().map_err(|f| f.under("union")),
            Self::Files(parameters) => parameters.validate().map_err(|f| f.under("files")),
        }
    }
}

/// Grain number `index` of the grains called `name`.
///
/// `size` is the diameter of the sphere of equal volume [m]; without it the
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
    shape.validate()?;
    if let Some(size) = size {
        Fault::positive("size", size)?;
    }
    let numbered = format!("{name}-{index:04}");
    match shape {
        Shape::Sphere => sphere(numbered, size.unwrap_or(1.0)),
        Shape::Union(parameters) => {
            let draws = Draws { seed, stream_name, index };
            united(parameters, numbered, size, &draws)
        }
        Shape::Files(parameters) => from_file(parameters, numbered, index, size, base),
    }
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

fn united(
    parameters: &UnionParameters,
    name: String,
    size: Option<f64>,
    draws: &Draws,
) -> Result<Solid, ShapeError> {
    let scale = size.map_or(Scale::Factor(1.0), Scale::Size);
    let mut last = GeometryError::NothingToUnite;
    for redraw in 0..=REDRAWS {
        let purpose = match redraw {
            0 => draws.stream_name.to_owned(),
            _ => format!("{}/redraw-{redraw}", draws.stream_name),
        };
        let mut stream = random::stream(draws.seed, &purpose, draws.index);
        let solids = union_of_solids::draw(parameters, &mut stream);
        let mut recipe = union_of_solids::describe(&solids);
        if redraw > 0 {
            recipe.push_str(&format!("; {redraw} earlier draws gave no solid"));
        }
        let made = union_of_solids::unite(&solids, parameters.segments).and_then(|mesh| {
            finish(&mesh, name.clone(), recipe, scale)
                .map_err(|fault| GeometryError::NoSolid { what: "the grain".to_owned(), fault })
        });
        match made {
            Ok(solid) => return Ok(solid),
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
mod tests;
