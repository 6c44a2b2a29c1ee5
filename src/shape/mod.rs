//! Random volumes and the user's own: one file a method.

use crate::geometry::{MassProperties, Mesh};

/// A grain's true shape: one closed, outward-oriented, connected surface of
/// positive volume whose vertices are exactly representable in single
/// precision, so that its STL file is the same solid bit for bit.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// File stem and name in reports, for example `smooth-0007`.
    pub name: String,
    /// Surface, metres.
    pub mesh: Mesh,
    /// Exact for the mesh.
    pub mass: MassProperties,
    /// How it was made, one line for people.
    pub recipe: String,
}
