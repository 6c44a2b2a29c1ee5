//! The scene file and the road from it to a report: reads and judges
//! parameters, turns them into the rooms' own types, runs the stages in order
//! and remembers which of them need not be done again.

mod bonding;
pub mod build;
pub mod compared;
pub mod comparing;
mod compressing;
pub mod drawing;
pub mod file;
pub mod grading;
pub mod grains;
pub mod inserting;
pub mod lockstep;
pub mod materials;
pub mod measuring;
mod packing;
pub mod paging;
pub mod parameters;
mod preparing;
pub mod readings;
pub mod road;
pub mod running;
pub mod shipped;
mod statistics;
pub mod store;
pub mod surveying;
pub mod verdict;
pub mod walls;
pub mod watching;

pub use file::{Loaded, SceneError};
pub use parameters::Scene;
