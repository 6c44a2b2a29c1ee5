//! Files of surfaces and sphere tables: one registry, one file a format.
//!
//! [`read`] and [`write()`] choose the format by extension, [`convert`] goes from
//! any to any and says what was lost. To add a format, write its file and add a
//! row to [`FORMATS`]. All lengths are in metres and all values in SI units.

pub mod atomic;
pub mod base64;
mod columns;
mod convert;
pub mod csv;
pub mod error;
pub mod lammps_dump;
pub mod liggghts_data;
#[cfg(test)]
mod mesh_tests;
mod number;
pub mod obj;
pub mod particles;
pub mod ply;
mod registry;
pub mod stl;
#[cfg(test)]
mod tests;
mod text;
pub mod vtp;
mod vtp_read;
mod xml;
pub mod xyz;
pub mod yade_text;

pub use convert::{ConvertReport, convert};
pub use error::FormatError;
pub use number::{number, push_number};
pub use particles::Particles;
pub use registry::{Column, FORMATS, Format};

use crate::geometry::Mesh;
use std::io::Read;
use std::path::{Path, PathBuf};

/// What a file holds.
// One value stands for a whole file, so its own size does not matter.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    /// A triangle surface.
    Mesh(Mesh),
    /// A table of spheres.
    Particles(Particles),
}

impl Data {
    /// What it is and how much, for people: "12 triangles", "1 sphere".
    pub fn summary(&self) -> String {
        let (count, what) = match self {
            Self::Mesh(mesh) => (mesh.triangles.len(), "triangle"),
            Self::Particles(particles) => (particles.len(), "sphere"),
        };
        format!("{count} {what}{}", if count == 1 { "" } else { "s" })
    }
}

/// Reads a file of any known format; see [`format_of`] for how it is chosen.
/// Of several frames the last one is read.
///
/// # Errors
/// The file cannot be opened, its format is not known, or its content is wrong:
/// the message names file, line (or byte) and what would be right.
pub fn read(path: &Path) -> Result<Data, FormatError> {
    let path = &spheres_beside(path);
    (format_of(path)?.read)(path).map(|(data, _)| data)
}

/// `packing.csv` of a scene has a row a body; its spheres lie in `packing.vtp` beside it. Any
/// other path as it is.
pub fn spheres_beside(path: &Path) -> PathBuf {
    let vtp = path.with_extension("vtp");
    let bodies = path.file_name().is_some_and(|name| name == "packing.csv") && vtp.is_file();
    if bodies { vtp } else { path.to_owned() }
}

/// Reads a file that must hold a surface.
///
/// # Errors
/// As [`read`]; a file of spheres.
pub fn read_mesh(path: &Path) -> Result<Mesh, FormatError> {
    match read(path)? {
        Data::Mesh(mesh) => Ok(mesh),
        Data::Particles(_) => Err(FormatError::file(
            path,
            "holds spheres, not a surface; a surface is .stl, .ply or .obj",
        )),
    }
}

/// Writes `data` in the format that the extension of `path` names, complete or
/// not at all. Returns one sentence for each thing that was not written or was
/// not known and had to be chosen.
///
/// # Errors
/// The extension is not known, its format cannot hold this kind of data, some
/// value is not finite, or the file cannot be written.
pub fn write(path: &Path, data: &Data) -> Result<Vec<String>, FormatError> {
    let format = by_extension(path).ok_or_else(|| unknown(path))?;
    format.write(path, data)
}

/// The format of an existing file: by its extension, or by its first lines where
/// the extension is `.txt` or not known.
pub fn format_of(path: &Path) -> Result<&'static Format, FormatError> {
    let named = by_extension(path);
    if let Some(format) = named
        && extension(path) != "txt"
    {
        return Ok(format);
    }
    let mut head = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(4096).read_to_end(&mut head))
        .map_err(|source| FormatError::io(path, "read", source))?;
    let head = String::from_utf8_lossy(&head);
    let head = head.trim_start_matches('\u{feff}').trim_start();
    FORMATS.iter().find(|format| (format.recognises)(head)).or(named).ok_or_else(|| unknown(path))
}

/// The format that writes files with the extension of `path`.
pub fn by_extension(path: &Path) -> Option<&'static Format> {
    let extension = extension(path);
    FORMATS.iter().find(|format| format.extensions.contains(&extension.as_str()))
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn unknown(path: &Path) -> FormatError {
    FormatError::file(path, format!("format not known; known extensions: {}", known(|_| true)))
}

/// The extensions of all formats that pass `test`, for messages.
fn known(test: impl Fn(&Format) -> bool) -> String {
    let names: Vec<String> = FORMATS
        .iter()
        .filter(|format| test(format))
        .flat_map(|format| format.extensions.iter().map(|extension| format!(".{extension}")))
        .collect();
    names.join(" ")
}
