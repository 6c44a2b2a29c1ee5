//! Compression by our own DEM: parameters. The work is done in [`crate::dem::compress`].
//!
//! Grains start without overlap in the container and are compressed by small steps of equal strain in all
//! directions, at rest after each, with a friction of their own. Seen from the grains the container shrinks;
//! seen from the container, which is that of the scene and stays, all grains grow by one factor, as other methods
//! do that meet a porosity. The two are one and the same motion in two frames, and the second suits containers of every
//! shape and periodic boxes.

use crate::num::Fault;
use crate::num::units::Pressure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of compression by the DEM.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Compression {
    /// What to compress to; default a stress of 1 kPa.
    pub until: Until,
    /// Friction while grains are compressed, 0 to 100; default 0, which gives the densest states; large values give loose ones.
    pub friction: f64,
    /// Local damping (Cundall) while grains come to rest, 0.05 to 0.95; default 0.3. With friction more damping gives
    /// looser states, as grains are stopped sooner.
    pub damping: f64,
    /// Solid fraction at the start, 0.01 to 0.5; default 0.3.
    pub start: f64,
    /// How near to the target is near enough, relative, 1e-4 to 0.5; default 0.01.
    pub tolerance: f64,
    /// Mean force that is left over on a grain over the mean force of a contact, for rest, 1e-8 to 0.1; default 1e-3.
    pub balance: f64,
    /// Most steps of the DEM in all, 100 to 100 000 000; default 200 000.
    pub steps: u64,
}

/// What to compress to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Until {
    /// Mean stress, Pa (N/m in two dimensions).
    Stress(Pressure),
    /// Porosity of the container, 0.01 to 0.999.
    Porosity(f64),
    /// Mean number of other grains that each touches, 1 to 12: without friction without rattlers (fewer than d + 1
    /// contacts), with friction without those of no contact or one.
    Coordination(f64),
}

impl Default for Compression {
    fn default() -> Self {
        Self {
            until: Until::Stress(Pressure(1e3)),
            friction: 0.0,
            damping: 0.3,
            start: 0.3,
            tolerance: 0.01,
            balance: 1e-3,
            steps: 200_000,
        }
    }
}

impl Compression {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        match self.until {
            Until::Stress(stress) => Fault::positive("until.stress", stress.0)?,
            Until::Porosity(porosity) => Fault::within("until.porosity", porosity, 0.01, 0.999)?,
            Until::Coordination(number) => Fault::within("until.coordination", number, 1.0, 12.0)?,
        }
        Fault::within("friction", self.friction, 0.0, 100.0)?;
        Fault::within("damping", self.damping, 0.05, 0.95)?;
        Fault::within("start", self.start, 0.01, 0.5)?;
        Fault::within("tolerance", self.tolerance, 1e-4, 0.5)?;
        Fault::within("balance", self.balance, 1e-8, 0.1)?;
        Fault::within("steps", self.steps as f64, 100.0, 1e8)
    }
}
