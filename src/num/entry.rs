//! One line of `riprap list`: a method, its key in a scene file, its source.

use serde::Serialize;

/// A method that a scene can ask for. Every room lists its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct MethodEntry {
    /// Key in the scene file, for example `union`.
    pub key: &'static str,
    /// Short id, for example `G1`; empty where a method has none.
    pub id: &'static str,
    /// What it does, one line.
    pub summary: &'static str,
    /// Authors and year.
    pub source: &'static str,
    /// What to write in a scene file.
    pub example: &'static str,
}
