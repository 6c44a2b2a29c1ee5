//! riprap: from one scene file to random grains, clumps, a packing, a discrete
//! element run, LIGGGHTS, YADE and LAMMPS decks, and a report of how far they agree.
//!
//! Rooms, and which way imports go (each may use what stands left of it):
//! `num, geometry <- format <- shape <- clump <- pack <- model <- {dem, solver} <- report <- scene <- {study, sweep} <- cli`.
//! `tests/house.rs` holds every `use crate::…` against this line.

#![warn(missing_docs)]

pub mod clump;
pub mod dem;
pub mod format;
pub mod geometry;
pub mod model;
pub mod num;
pub mod pack;
pub mod report;
pub mod scene;
pub mod shape;
pub mod solver;
pub mod study;
pub mod sweep;

pub mod cli;

/// Version of riprap, written into manifests and decks.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
