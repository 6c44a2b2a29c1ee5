//! What is written, and how solvers are compared.

use crate::num::Fault;
use crate::num::units::Length;
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
    /// True: contact forces of the last snapshot in `run/contacts.csv`, for `riprap measure --contacts`. Default false.
    #[serde(skip_serializing_if = "is_false")]
    pub contacts: bool,
    /// Measuring spheres (circles in two dimensions) that are read in every snapshot: porosity, coordination
    /// numbers, fabric and stress in `run/measures.csv`. Default none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub measures: Vec<MeasureParameters>,
}

fn is_false(value: &bool) -> bool {
    !value
}

/// A measuring sphere, or circle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasureParameters {
    /// Its name in the table: letters, digits, `_` and `-`.
    pub name: String,
    /// Its middle.
    pub at: [Length; 3],
    /// Its radius.
    pub radius: Length,
}

impl Default for OutputParameters {
    fn default() -> Self {
        Self {
            frames: 20,
            rows: 200,
            checkpoints: 4,
            vtp: false,
            contacts: false,
            measures: Vec::new(),
        }
    }
}

/// How solvers are compared.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CompareParameters {
    /// State that all solvers start from: `packing` (default); `final`, the last state of riprap's own run, without its contact history; or `final_with_springs`, that state with the tangential springs of its contacts (riprap and YADE; decks of the others are refused).
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
    /// The last state of riprap's own run; contacts begin without tangential springs.
    Final,
    /// The last state of riprap's own run with the tangential springs of its contacts.
    FinalWithSprings,
}

impl OutputParameters {
    pub(super) fn validate(&self) -> Result<(), Fault> {
        for (key, value) in [("frames", self.frames), ("rows", self.rows)] {
            if value == 0 {
                return Err(Fault::new(key, "is 0", "at least 1"));
            }
        }
        for (index, measure) in self.measures.iter().enumerate() {
            let here = |fault: Fault| fault.under(format!("measures[{index}]"));
            super::validate_name(&measure.name).map_err(here)?;
            Fault::positive("radius", measure.radius.0).map_err(here)?;
            if self.measures[..index].iter().any(|other| other.name == measure.name) {
                let problem = format!("is \"{}\", as of an earlier one", measure.name);
                return Err(here(Fault::new("name", problem, "a name of its own")));
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
