//! What is written, and how solvers are compared.

use crate::num::Fault;
use crate::report::compare::Tolerances;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is written, and how often.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OutputParameters {
    /// Number of snapshots over the run besides the first. Default 20.
    pub frames: u32,
    /// Number of rows of `run/series.csv` besides the first. Default 200.
    pub rows: u32,
    /// Number of checkpoints over the run. Default 4; 0 for none.
    pub checkpoints: u32,
    /// True: a VTP file for ParaView for each snapshot. Default false.
    pub vtp: bool,
}

impl Default for OutputParameters {
    fn default() -> Self {
        Self { frames: 20, rows: 200, checkpoints: 4, vtp: false }
    }
}

/// How solvers are compared.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CompareParameters {
    /// State that all solvers start from: `packing` (default) or `final`, the last state of riprap's own run, without its contact history.
    pub start: Start,
    /// Number of steps to compare over. Default: as many as the plan has.
    pub steps: Option<u64>,
    /// What counts as agreement.
    pub tolerance: Tolerances,
}

/// Where a comparison starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// The packing.
    #[default]
    Packing,
    /// The last state of riprap's own run.
    Final,
}

impl OutputParameters {
    pub(super) fn validate(&self) -> Result<(), Fault> {
        for (key, value) in [("frames", self.frames), ("rows", self.rows)] {
            if value == 0 {
                return Err(Fault::new(key, "is 0", "at least 1"));
            }
        }
        Ok(())
    }
}

impl CompareParameters {
    pub(super) fn validate(&self) -> Result<(), Fault> {
        if self.steps == Some(0) {
            return Err(Fault::new("steps", "is 0", "at least 1, or left out"));
        }
        self.tolerance.validate().map_err(|fault| fault.under("tolerance"))
    }
}
