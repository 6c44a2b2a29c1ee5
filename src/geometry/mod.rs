//! Surfaces, solids, distances, containers. parry3d and boolmesh live in this
//! room only; nothing of theirs appears in a public signature.

pub mod arcs;
pub mod balls;
pub mod bounds;
pub mod cell;
pub mod collide;
pub mod cone;
pub mod container;
pub mod distance;
pub mod grid;
pub mod hollow;
pub mod mass;
pub mod mesh;
pub mod outline;
pub mod polyhedron;
pub mod primitive;
pub mod refine;
pub mod region;
#[cfg(test)]
pub mod samples;
pub mod shaped_container;
pub mod shared;
pub mod united;
pub mod visible;

pub use balls::Ball;
pub use bounds::Bounds;
pub use cell::Cell;
pub use collide::Collider;
pub use container::Container;
pub use distance::{DistanceError, Nearest, SignedDistance, SurfacePoint};
pub use grid::BallGrid;
pub mod check;
pub mod error;
pub mod hull;
pub mod intersection;
pub mod repair;
mod rim;
pub mod topology;
pub mod union;

pub use check::MeshFault;
pub use error::GeometryError;
pub use mass::MassProperties;
pub use mesh::Mesh;
pub use primitive::{Posed, Primitive};
pub use region::{Region, Surface};
pub use repair::Repairs;
pub use topology::MeshReport;
pub use visible::Visible;
