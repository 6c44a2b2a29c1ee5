//! What bounds a container: planes and triangles.

use super::Mesh;
use crate::num::Vec3;

/// A surface that bodies touch.
#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    /// An infinite plane.
    Plane {
        /// A point on it, m.
        point: Vec3,
        /// Unit normal, towards the inside of the container.
        normal: Vec3,
    },
    /// Triangles, facing away from the inside of the container.
    Mesh(Mesh),
}

/// The wall across `axis` through `point`, named after its side (`z_low`), facing the inside.
pub(super) fn plane(axis: usize, high: bool, point: Vec3) -> (String, Surface) {
    let mut normal = Vec3::zeros();
    normal[axis] = if high { -1.0 } else { 1.0 };
    let name = format!("{}_{}", ["x", "y", "z"][axis], if high { "high" } else { "low" });
    (name, Surface::Plane { point, normal })
}
