//! Grains that come during the run instead of being packed.

use crate::geometry::Container;
use crate::num::Fault;
use crate::num::units::{Speed, Spin, Time};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When, where and how fast the grains of a family come. Places and times are drawn before the run, so that every
/// code can repeat them. Until a grain comes, frames and pictures show it at rest where it will come.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InsertionParameters {
    /// Room in which grains come, each wholly inside. Nothing but grains that come must ever be there: one that finds
    /// its place taken ends the run.
    pub region: Container,
    /// Grains a second, greater than 0.
    pub rate: f64,
    /// Time at which the first one comes. Default 0 (after the first step).
    #[serde(default = "at_once")]
    pub start: Time,
    /// Velocity with which they come. Default 0.
    #[serde(default = "no_velocity")]
    pub velocity: [Speed; 3],
    /// Angular velocity with which they come. Default 0.
    #[serde(default = "no_spin")]
    pub spin: [Spin; 3],
}

fn at_once() -> Time {
    Time(0.0)
}

fn no_velocity() -> [Speed; 3] {
    [Speed(0.0); 3]
}

fn no_spin() -> [Spin; 3] {
    [Spin(0.0); 3]
}

impl InsertionParameters {
    /// Time at which grain number `index` of the family comes, s.
    pub fn time(&self, index: usize) -> f64 {
        self.start.0 + index as f64 / self.rate
    }

    pub(super) fn validate(&self, dimension: u8) -> Result<(), Fault> {
        self.region.validate().map_err(|fault| fault.under("region"))?;
        Fault::positive("rate", self.rate)?;
        Fault::not_negative("start", self.start.0)?;
        let finite = self.velocity.iter().all(|v| v.0.is_finite())
            && self.spin.iter().all(|w| w.0.is_finite());
        let flat = dimension == 2;
        if !finite || flat && self.velocity[2].0 != 0.0 {
            let allowed = "finite numbers, 0 along z in two dimensions";
            return Err(Fault::new("velocity", "or the spin cannot be used", allowed));
        }
        if flat && (self.spin[0].0 != 0.0 || self.spin[1].0 != 0.0) {
            return Err(Fault::new("spin", "leaves the x–y plane", "about z in two dimensions"));
        }
        Ok(())
    }
}
