//! Packing: where each grain goes. One file a method.

use crate::clump::Clump;
use crate::num::{Rotation, Vec3};
use crate::shape::Solid;
use serde::{Deserialize, Serialize};

/// One grain to be placed.
#[derive(Debug, Clone, Copy)]
pub struct Grain<'a> {
    /// Spheres and mass properties in the body frame.
    pub clump: &'a Clump,
    /// True shape, in the frame that `clump.centroid` and `clump.axes` refer to;
    /// `None` for plain spheres and discs.
    pub solid: Option<&'a Solid>,
    /// Index of the family in the scene.
    pub family: u16,
}

/// Where one grain went.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Index into the list of grains that was given.
    pub grain: u32,
    /// Centre of mass, m.
    pub position: Vec3,
    /// Turns the body frame into the world frame.
    pub orientation: Rotation,
    /// Velocity, m/s.
    pub velocity: Vec3,
    /// Angular velocity in the world frame, rad/s.
    pub spin: Vec3,
}

/// A packing and how it came out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Packing {
    /// One entry for each grain that was placed, in the order in which bodies are numbered.
    pub placements: Vec<Placement>,
    /// Grains that found no place.
    pub dropped: Vec<u32>,
    /// How the method ended, one line for people.
    pub outcome: String,
    /// What the packing is like.
    pub measures: Measures,
}

/// Measures of a packing (P18).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Measures {
    /// Volume (area in two dimensions) of the container, m³ (m²).
    pub container_volume: f64,
    /// Porosity: 1 − volume of the united grains over that of the container.
    pub porosity: f64,
    /// Standard error of the porosity; 0 where it is exact.
    pub porosity_error: f64,
    /// Mean number of other bodies each body touches (gap ≤ `gap_tolerance`).
    pub coordination: f64,
    /// Gap up to which two bodies count as touching, m.
    pub gap_tolerance: f64,
    /// Largest overlap between spheres of different bodies over the smaller radius.
    pub worst_overlap: f64,
    /// Least gap between spheres of different bodies, m (negative: overlap); `None` for fewer than two bodies
    /// or where no two bodies are near each other.
    pub least_gap: Option<f64>,
}
