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
