//! The user's own solids: STL, PLY and OBJ files.

use super::ShapeError;
use crate::num::Fault;
use crate::num::units::Length;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

const EXTENSIONS: [&str; 3] = ["stl", "ply", "obj"];

/// Solids read from files; grain number i takes file number i modulo their count.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileParameters {
    /// Files (.stl, .ply, .obj), relative to the scene file; default none.
    #[serde(default)]
    pub paths: Vec<PathBuf>,
    /// Folder whose .stl, .ply and .obj files are taken too, sorted by name; default none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub folder: Option<PathBuf>,
    /// Length that the number 1 in the files means, greater than 0; default "1 m".
    /// Only matters where no grain size is asked for.
    #[serde(default = "default_unit")]
    pub unit: Length,
}

fn default_unit() -> Length {
    Length(1.0)
}

impl FileParameters {
    /// The first value that cannot be used, if any; files are not opened.
    pub fn validate(&self) -> Result<(), Fault> {
        if self.paths.is_empty() && self.folder.is_none() {
            return Err(Fault::new("paths", "is empty", "at least one file, or a `folder`"));
        }
        for (index, path) in self.paths.iter().enumerate() {
            if !has_known_extension(path) {
                return Err(Fault::new(
                    format!("paths[{index}]"),
                    format!("is `{}`", path.display()),
                    "a file that ends in .stl, .ply or .obj",
                ));
            }
        }
        Fault::positive("unit", self.unit.0)
    }

    /// All files, in the order in which grains take them; relative paths start at `base`.
    pub fn list(&self, base: &Path) -> Result<Vec<PathBuf>, ShapeError> {
        let mut files: Vec<PathBuf> = self.paths.iter().map(|path| base.join(path)).collect();
        if let Some(folder) = &self.folder {
            let folder = base.join(folder);
            let unreadable = |source| ShapeError::Folder { path: folder.clone(), source };
            let mut found = Vec::new();
            for entry in std::fs::read_dir(&folder).map_err(unreadable)? {
                let path = entry.map_err(unreadable)?.path();
                if path.is_file() && has_known_extension(&path) {
                    found.push(path);
                }
            }
            found.sort();
            if found.is_empty() && files.is_empty() {
                return Err(ShapeError::NoFiles { path: folder });
            }
            files.extend(found);
        }
        Ok(files)
    }
}

fn has_known_extension(path: &Path) -> bool {
    path.extension()
        .and_then(|ending| ending.to_str())
        .is_some_and(|ending| EXTENSIONS.contains(&ending.to_ascii_lowercase().as_str()))
}

/// The name of a file without folder and ending, as part of another file name.
pub fn stem(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
    stem.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect()
}
