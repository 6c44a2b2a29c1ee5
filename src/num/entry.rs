//! One line of `riprap list`: a method, its key in scene files, its source.

use serde::Serialize;

/// A method that a scene file can name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct MethodEntry {
    /// Key in the scene file.
    pub key: &'static str,
    /// Id of the requirement it meets, for example `R5`.
    pub id: &'static str,
    /// What it does, one line.
    pub summary: &'static str,
    /// Authors and year.
    pub source: &'static str,
}
