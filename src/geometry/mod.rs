//! Surfaces, solids, distances, containers. parry3d and boolmesh live in this
//! room only; nothing of theirs appears in a public signature.

pub mod arcs;
pub mod balls;
pub mod bounds;
pub mod distance;
pub mod mass;
pub mod mesh;
#[cfg(test)]
pub mod samples;
pub mod united;
pub mod visible;

pub use balls::Ball;
pub use bounds::Bounds;
pub use distance::{DistanceError, Nearest, SignedDistance, SurfacePoint};
pub use mass::MassProperties;
pub use mesh::Mesh;
pub use visible::Visible;
