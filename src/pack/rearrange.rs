//! Rearrangements (P4) for random placement: a grain that does not fit where it was drawn turns, moves about
//! that place, and at last shrinks.
//!
//! Source: Sajjadi & Khalili 2015 (RRAP and other rearrangements of random Apollonian packing); turning:
//! Delaney, Hutzler & Aste 2008. Each costs one more test of fit, so what it
//! brings is to be held against as many more tries: the outcome says how many grains and which share of the volume
//! found their place by each, and how many tests were made in all. Measured (validation/61-digital): at the same
//! number of tests plain draws place more.

use crate::num::Fault;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is tried where a grain does not fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Rearrange {
    /// Other angles tried at each place, 0 to 100 000; default 10.
    pub turns: u32,
    /// Other places tried about each place, 0 to 100 000; default 10.
    pub moves: u32,
    /// Largest distance of those from the first place, over the radius of the grain, above 0 to 100; default 0.5.
    pub within: f64,
    /// Smallest size over the wanted one, above 0 to 1; a grain that found no place in all its
    /// tries shrinks towards it in eight stages. Default 1: sizes are kept.
    pub smallest: f64,
}

impl Default for Rearrange {
    fn default() -> Self {
        Self { turns: 10, moves: 10, within: 0.5, smallest: 1.0 }
    }
}

/// Stages of shrinking.
pub const STAGES: u32 = 8;

impl Rearrange {
    /// A fault for values that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("turns", f64::from(self.turns), 0.0, 1e5)?;
        Fault::within("moves", f64::from(self.moves), 0.0, 1e5)?;
        Fault::positive("within", self.within)?;
        Fault::within("within", self.within, 0.0, 100.0)?;
        Fault::positive("smallest", self.smallest)?;
        Fault::within("smallest", self.smallest, 0.0, 1.0)
    }

    /// Sizes over the wanted one that are tried after the wanted one itself.
    pub fn sizes(&self) -> Vec<f64> {
        if self.smallest >= 1.0 {
            return Vec::new();
        }
        let share = |stage: u32| f64::from(stage) / f64::from(STAGES);
        (1..=STAGES).map(|stage| self.smallest.powf(share(stage))).collect()
    }
}

/// How a grain found its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum How {
    /// Where it was drawn.
    Drawn,
    /// Turned there.
    Turned,
    /// Moved about it.
    Moved,
    /// Smaller than wanted.
    Shrunk,
}

/// What each way has brought.
#[derive(Debug, Default)]
pub struct Gain {
    /// Tests of fit.
    pub tests: u64,
    counts: [u64; 4],
    volumes: [f64; 4],
    scales: f64,
}

impl Gain {
    /// One more grain, of this volume as placed and this scale.
    pub fn add(&mut self, how: How, volume: f64, scale: f64) {
        self.counts[how as usize] += 1;
        self.volumes[how as usize] += volume;
        if how == How::Shrunk {
            self.scales += scale;
        }
    }

    /// For people.
    pub fn text(&self) -> String {
        let total: f64 = self.volumes.iter().sum();
        let part = |how: How| {
            let share = if total > 0.0 { 100.0 * self.volumes[how as usize] / total } else { 0.0 };
            format!("{} ({share:.2} % of the volume)", self.counts[how as usize])
        };
        let shrunk = self.counts[How::Shrunk as usize];
        let sizes = match shrunk {
            0 => "sizes as wanted".to_owned(),
            _ => format!(
                "sizes of {shrunk} grains changed, to {:.4} times those wanted on average",
                self.scales / shrunk as f64
            ),
        };
        format!(
            "{} placed where drawn, {} turned, {} moved, {} shrunk, in {} tests of fit; {sizes}",
            part(How::Drawn),
            part(How::Turned),
            part(How::Moved),
            part(How::Shrunk),
            self.tests
        )
    }
}
