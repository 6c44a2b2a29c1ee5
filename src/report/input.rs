//! What the report page is made from.

use super::chart::Chart;
use super::compare::Comparison;
use super::table::Table;
use crate::clump::Clump;
use crate::model::{Model, Run};
use crate::pack::Packing;
use crate::shape::Solid;

/// What the page is made from; whatever is empty or `None` is left out.
#[derive(Debug, Clone, Copy, Default)]
pub struct PageInput<'a> {
    /// Heading of the page.
    pub title: &'a str,
    /// Name and version of the program: "riprap 0.1.0".
    pub version: &'a str,
    /// The scene: facts, needs, picture of the packing, final states.
    pub model: Option<&'a Model>,
    /// True shapes of the grains.
    pub solids: &'a [Solid],
    /// Shape descriptors; without them a few are computed from the surfaces.
    pub shape_table: Option<&'a Table>,
    /// Clumps; shown beside the solid whose name they carry.
    pub clumps: &'a [Clump],
    /// How the packing came out.
    pub packing: Option<&'a Packing>,
    /// Run of our own DEM.
    pub ours: Option<&'a Run>,
    /// Measuring spheres of that run: name and verdict of each, and what they read over time.
    pub measures: (&'a [[String; 2]], &'a [Chart]),
    /// Runs of other solvers, in the order of `comparison.others`.
    pub others: &'a [Run],
    /// How far they agree.
    pub comparison: Option<&'a Comparison>,
    /// Solvers that did not take part and why, one sentence each.
    pub missing: &'a [String],
    /// Commands that reproduce the page, one a line.
    pub commands: &'a [String],
}
