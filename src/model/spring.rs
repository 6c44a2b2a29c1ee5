//! Tangential springs of contacts, to go on from a state with them.

use serde::{Deserialize, Serialize};

use crate::num::Vec3;

/// The tangential spring of one contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spring {
    /// Index of the sphere that the force acts on.
    pub sphere: u32,
    /// What it touches.
    pub other: Partner,
    /// Stretch ξ, m: the force on the sphere is −kt ξ.
    pub stretch: Vec3,
}

/// What a sphere touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Partner {
    /// Another sphere.
    Sphere(u32),
    /// A plane wall.
    Plane(u16),
    /// A triangle of a mesh wall.
    Face {
        /// Index of the wall.
        wall: u16,
        /// Index of the triangle in its mesh.
        triangle: u32,
    },
}
