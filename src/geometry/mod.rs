//! Surfaces, solids, distances, containers. parry3d and boolmesh live in this
//! room only; nothing of theirs appears in a public signature.

pub mod arcs;
pub mod balls;
pub mod bounds;
pub mod cell;
pub mod check;
pub mod collide;
pub mod cone;
pub mod container;
pub mod distance;
pub mod error;
pub mod grid;
pub mod hollow;
pub mod hull;
pub mod intersection;
pub mod mass;
pub mod mesh;
pub mod outline;
pub mod polyhedron;
pub mod primitive;
pub mod refine;
pub mod region;
pub mod repair;
mod rim;
#[cfg(test)]
pub mod samples;
pub mod shaped_container;
pub mod shared;
mod surface;
pub mod topology;
pub mod union;
pub mod united;
pub mod visible;

pub use balls::Ball;
pub use bounds::Bounds;
pub use cell::Cell;
pub use check::MeshFault;
pub use collide::Collider;
pub use container::Container;
pub use distance::{DistanceError, Nearest, SignedDistance, SurfacePoint};
pub use error::GeometryError;
pub use grid::BallGrid;
pub use mass::MassProperties;
pub use mesh::Mesh;
pub use primitive::{Posed, Primitive};
pub use region::Region;
pub use repair::Repairs;
pub use surface::Surface;
pub use topology::MeshReport;
pub use visible::Visible;
