//! Surfaces, solids, distances, containers. parry3d and boolmesh live in this
//! room only; nothing of theirs appears in a public signature.

pub mod arcs;
pub mod balls;
pub mod bounds;
pub mod check;
pub mod collide;
pub mod container;
pub mod distance;
pub mod error;
pub mod grid;
pub mod hull;
pub mod intersection;
pub mod mass;
pub mod mesh;
pub mod primitive;
pub mod region;
pub mod repair;
#[cfg(test)]
pub mod samples;
pub mod topology;
pub mod union;
pub mod united;
pub mod visible;

pub use balls::Ball;
pub use bounds::Bounds;
pub use check::MeshFault;
pub use collide::Collider;
pub use container::Container;
pub use distance::{DistanceError, Nearest, SignedDistance, SurfacePoint};
pub use error::GeometryError;
pub use grid::BallGrid;
pub use mass::MassProperties;
pub use mesh::Mesh;
pub use primitive::{Posed, Primitive};
pub use region::{Region, Surface};
pub use repair::Repairs;
pub use topology::MeshReport;
pub use visible::Visible;
