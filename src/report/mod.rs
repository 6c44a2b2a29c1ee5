//! What came out, for people: comparison of solvers, charts, pictures, one HTML page.
//!
//! * [`compare::compare`] sets the runs of other solvers, and of our own DEM in
//!   their schemes, against our run: [`compare::Comparison`], JSON and CSV.
//! * [`chart::Chart`] and [`chart::Bars`] draw themselves as SVG text.
//! * [`picture::render`] draws spheres, discs and surfaces into a
//!   [`picture::Picture`]; [`gallery`] knows how meshes, clumps and whole states look.
//! * [`findings::Findings`] is what a study found, as CSV, SVG, JSON and a page.
//! * [`page::page`] puts all of it into one self-contained page.

pub mod base64;
pub mod camera;
pub mod chart;
pub mod colour;
pub mod compare;
pub mod curves;
mod figure;
pub mod findings;
#[cfg(test)]
pub(crate) mod fixture;
pub mod gallery;
pub mod input;
pub mod items;
pub mod number;
mod overlay;
pub mod page;
pub mod picture;
pub mod raster;
mod sections;
mod shade;
pub mod table;
mod verdict;

use crate::format::{FormatError, atomic};
use std::io::Write;
use std::path::Path;

/// What can go wrong with a report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A file could not be written.
    #[error(transparent)]
    File(#[from] FormatError),
    /// The picture could not be turned into a PNG file.
    #[error("cannot encode the picture: {0}")]
    Png(#[from] png::EncodingError),
    /// The page template does not fit its data.
    #[error("cannot fill the report page: {0}")]
    Template(#[from] tera::Error),
    /// The comparison could not be turned into JSON.
    #[error("cannot write the comparison as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// Writes a whole file or nothing: to a temporary beside it, then renamed.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    atomic::write(path, |out| out.write_all(bytes))?;
    Ok(())
}
