//! What a method of this room is given and what it hands back.

use super::ClumpError;
use crate::geometry::{Ball, SignedDistance};
use crate::shape::Solid;

/// A solid prepared for fitting.
pub(super) struct Target<'a> {
    pub solid: &'a Solid,
    pub distance: SignedDistance,
    /// Equivalent-volume diameter, m.
    pub diameter: f64,
}

impl<'a> Target<'a> {
    pub fn new(solid: &'a Solid) -> Result<Self, ClumpError> {
        let distance = SignedDistance::new(&solid.mesh)
            .map_err(|source| ClumpError::Surface { name: solid.name.clone(), source })?;
        Ok(Self { solid, distance, diameter: solid.mass.equivalent_diameter() })
    }
}

/// What a method hands back: at least one sphere, in the frame of the solid, and
/// one line that says how they were found.
pub(super) struct Found {
    pub balls: Vec<Ball>,
    pub note: String,
}
