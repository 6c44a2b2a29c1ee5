//! What [`super::road::Road::compare`] gives.

use crate::model::Run;
use crate::report::compare::Comparison;

/// A comparison with the runs that it was made from.
pub struct Compared {
    /// What differs by how much.
    pub comparison: Comparison,
    /// Our own run.
    pub ours: Run,
    /// Runs of the outside solvers.
    pub others: Vec<Run>,
    /// Messages of solvers that failed.
    pub failures: Vec<String>,
    /// What solvers cannot express of the scene: they were not run.
    pub unable: Vec<String>,
    /// Solvers that did not take part and why: not installed, cannot run this scene, or failed.
    pub missing: Vec<String>,
}
