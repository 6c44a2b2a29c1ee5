//! Deposition under gravity by our own DEM: parameters. The work is done in [`crate::dem::deposit`].
//!
//! Grains start at random places without overlap all over the container, and fall, so the container has to be about
//! twice as tall as the bed that is wanted. Little friction makes dense beds, much makes loose ones; when all are at
//! rest friction becomes that of the scene, and they come to rest again.

use crate::num::Fault;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of deposition by the DEM.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Deposition {
    /// Friction while grains fall and come to rest, 0 to 100; default: that of the scene.
    pub friction: Option<f64>,
    /// Local damping (Cundall) while they fall, 0 to 0.95, beside the dashpots of the scene; default 0.1. A grain falls with
    /// 1 − damping of the gravity. Once all have landed it is at least 0.4.
    pub damping: f64,
    /// Mean force that is left over on a grain, its weight included, over the mean force of a contact, for rest, 1e-8 to 0.1; default 1e-3.
    pub balance: f64,
    /// Most steps of the DEM in all, 100 to 100 000 000; default 1 000 000.
    pub steps: u64,
}

impl Default for Deposition {
    fn default() -> Self {
        Self { friction: None, damping: 0.1, balance: 1e-3, steps: 1_000_000 }
    }
}

impl Deposition {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        if let Some(friction) = self.friction {
            Fault::within("friction", friction, 0.0, 100.0)?;
        }
        Fault::within("damping", self.damping, 0.0, 0.95)?;
        Fault::within("balance", self.balance, 1e-8, 0.1)?;
        Fault::within("steps", self.steps as f64, 100.0, 1e8)
    }
}
