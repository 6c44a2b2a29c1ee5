//! Balls, alone and united.

use crate::num::Vec3;
use serde::{Deserialize, Serialize};

/// A ball (a disc in two dimensions).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ball {
    /// Centre, m.
    pub centre: Vec3,
    /// Radius, m.
    pub radius: f64,
}
