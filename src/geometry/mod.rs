//! Surfaces, solids, distances, containers. parry3d and boolmesh live in this
//! room only; nothing of theirs appears in a public signature.

pub mod balls;
pub mod bounds;
pub mod check;
pub mod error;
pub mod hull;
pub mod intersection;
pub mod mass;
pub mod mesh;
pub mod primitive;
pub mod repair;
pub mod topology;
pub mod union;

pub use balls::Ball;
pub use bounds::Bounds;
pub use check::MeshFault;
pub use error::GeometryError;
pub use mass::MassProperties;
pub use mesh::Mesh;
pub use primitive::{Posed, Primitive};
pub use repair::Repairs;
pub use topology::MeshReport;
