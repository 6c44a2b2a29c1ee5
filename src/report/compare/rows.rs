//! Quantity by quantity: how far two runs are apart, and how far chance may bring them.
//!
//! Once trajectories have parted, two runs of one bed are two realisations of it.
//! What they may differ by is the largest of
//! 1. the tolerance;
//! 2. two standard errors of the difference over time ([`super::span`]);
//! 3. two standard errors from the number of bodies or contacts (where the quantity
//!    is a mean over them);
//! 4. t √2 s: s the standard deviation among the realisations we have (our run and
//!    the twins that parted from it and from each other), t Student's factor (1908)
//!    for 95 % and their number less one, at most `STUDENT[0]`.
//!
//! No more than [`MOST_CHANCE`] tolerances are ever allowed: a bed that scatters
//! more is too small, or too short a time, to be judged, and fails.

use super::span::Span;
use super::statistics::Quantity;
use super::{Comparison, Row, Twin, usable};
use crate::model::{Model, Run};
use crate::num::statistics::deviation;
use serde::{Deserialize, Serialize};

/// Student's factor for 95 % with 2, 3, … degrees of freedom. With one it would be
/// 12.7, which allows anything: the first entry is taken instead.
const STUDENT: [f64; 6] = [4.303, 3.182, 2.776, 2.571, 2.447, 2.365];
/// Chance may widen a tolerance to at most this many of it.
pub const MOST_CHANCE: f64 = 3.0;
/// Distance beyond which two runs are two realisations, smallest radii.
pub(super) const APART: f64 = 0.1;

/// Runs of the same bed by our own DEM that chance has made different.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Realisations {
    /// Who made them; ours first.
    pub runs: Vec<String>,
    /// t √2: how many standard deviations two of them may differ by.
    pub factor: f64,
    /// The scatter of each quantity; empty with fewer than two realisations.
    pub scatter: Vec<Scatter>,
}

/// How a quantity differs between realisations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    /// Which.
    pub quantity: Quantity,
    /// Mean over the last part of each run.
    pub values: Vec<f64>,
    /// Standard deviation of these.
    pub deviation: f64,
}

impl Realisations {
    /// Finds the twins that are realisations of their own and measures them.
    pub(super) fn of(
        model: &Model,
        ours: &Run,
        twins: &[Twin],
        measure: impl Fn(&Run) -> Option<Span>,
        radius: f64,
    ) -> Self {
        let mut chosen: Vec<&Run> = vec![ours];
        for twin in twins {
            if chosen.iter().all(|run| apart(model, run, &twin.run, radius)) {
                chosen.push(&twin.run);
            }
        }
        let spans: Vec<Span> = chosen.iter().filter_map(|run| measure(run)).collect();
        let runs = chosen.iter().map(|run| run.solver.clone()).collect();
        if spans.len() < 2 || spans.len() != chosen.len() {
            return Self { runs, ..Self::default() };
        }
        let factor = STUDENT[(spans.len().max(3) - 3).min(STUDENT.len() - 1)] * 2_f64.sqrt();
        let scatter = Quantity::ALL
            .into_iter()
            .filter_map(|quantity| {
                let values: Option<Vec<f64>> =
                    spans.iter().map(|span| span.statistics.value(quantity)).collect();
                let values = values?;
                let deviation = deviation(&values).unwrap_or(f64::NAN);
                Some(Scatter { quantity, values, deviation })
            })
            .collect();
        Self { runs, factor, scatter }
    }

    fn reach(&self, quantity: Quantity) -> f64 {
        let found = self.scatter.iter().find(|scatter| scatter.quantity == quantity);
        found.map_or(0.0, |scatter| self.factor * scatter.deviation)
    }
}

/// True if any sphere of the last frames is elsewhere.
fn apart(model: &Model, a: &Run, b: &Run, radius: f64) -> bool {
    let last = |run| usable(model, run).and_then(|frames| frames.last());
    let (Some(a), Some(b)) = (last(a), last(b)) else { return false };
    a.centres.iter().zip(&b.centres).any(|(x, y)| model.way(x - y).norm() > APART * radius)
}

/// Every quantity of `theirs` against `ours`; `parted`: they are two realisations,
/// so chance is allowed for.
pub(super) fn rows(ours: &Span, theirs: &Span, context: &Comparison, parted: bool) -> Vec<Row> {
    Quantity::ALL
        .into_iter()
        .filter_map(|quantity| {
            let (a, b) = (ours.statistics.of(quantity)?, theirs.statistics.of(quantity)?);
            let (tolerance, scale) = asked(quantity, ours, context);
            let scale =
                if scale > 0.0 { scale } else { a.value.abs().max(b.value.abs()).max(1e-300) };
            let errors = [
                2.0 * ours.error_of_difference(theirs, quantity),
                2.0 * a.sample_error.hypot(b.sample_error),
                context.realisations.reach(quantity),
            ];
            let chance = if parted { errors.into_iter().fold(0.0, f64::max) / scale } else { 0.0 };
            let relative = (b.value - a.value) / scale;
            let allowed = chance.clamp(tolerance, MOST_CHANCE * tolerance);
            let passed = relative.abs() <= allowed;
            let (ours, theirs) = (a.value, b.value);
            Some(Row {
                quantity,
                ours,
                theirs,
                relative,
                scale,
                tolerance,
                allowed,
                chance,
                passed,
            })
        })
        .collect()
}

/// Tolerance of a quantity and what its differences are divided by.
fn asked(quantity: Quantity, ours: &Span, context: &Comparison) -> (f64, f64) {
    let tolerances = &context.tolerances;
    let value = |quantity| ours.statistics.value(quantity).unwrap_or(0.0).abs();
    let least = context.smallest_radius;
    match quantity {
        Quantity::TopHeight | Quantity::MeanHeight => {
            (tolerances.height, value(Quantity::TopHeight).max(least))
        }
        Quantity::Spread => (tolerances.height, value(quantity).max(least)),
        Quantity::Porosity => (tolerances.porosity, value(quantity)),
        Quantity::Kinetic => (tolerances.kinetic, context.energy_scale),
        Quantity::Coordination => (tolerances.coordination, value(quantity)),
        Quantity::MeanForce | Quantity::HighForce => (tolerances.contact_force, value(quantity)),
    }
}
