//! Surfaces, solids, distances, containers. parry3d and boolmesh live in this
//! room only; nothing of theirs appears in a public signature.

pub mod balls;
pub mod bounds;
pub mod mass;
pub mod mesh;
pub mod primitive;

pub use balls::Ball;
pub use bounds::Bounds;
pub use mass::MassProperties;
pub use mesh::Mesh;
pub use primitive::{Posed, Primitive};
