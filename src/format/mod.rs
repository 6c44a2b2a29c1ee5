//! (format)

pub mod atomic;
pub mod error;
pub mod obj;
pub mod ply;
pub mod stl;

#[cfg(test)]
mod mesh_tests;
