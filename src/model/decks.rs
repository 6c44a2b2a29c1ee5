//! What a scene says of the decks of outside solvers; our own DEM knows nothing of it.

use serde::{Deserialize, Serialize};

/// Choices for decks.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(deny_unknown_fields, default)]
pub struct Decks {
    /// How LIGGGHTS holds rigid clumps: "rigid" (default: `fix rigid`, any number of shapes and
    /// bodies) or "multisphere" (`fix multisphere`: at most 150 shapes and 10 000 clumps).
    pub liggghts_clumps: ClumpRoute,
    /// Number of restart files that decks of LIGGGHTS and YADE write over the run, evenly; `run.sh
    /// --resume` goes on from the newest. Default 0: none.
    pub restarts: u32,
}

impl Decks {
    /// Steps between two restart files of a run of `steps` steps; 0 for none.
    pub fn restart_every(&self, steps: u64) -> u64 {
        match self.restarts {
            0 => 0,
            count => (steps / u64::from(count)).max(1),
        }
    }
}

/// How LIGGGHTS holds rigid clumps.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum ClumpRoute {
    /// `fix rigid`, bodies placed by file.
    #[default]
    Rigid,
    /// `fix multisphere`, a template a shape, bodies inserted one by one.
    Multisphere,
}
