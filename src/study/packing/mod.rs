//! Packing methods against what is known of them, over CPU time and number of balls.
//!
//! Solid fractions, shares of pores, dimensions and coordination numbers in boxes whose sides
//! repeat (drop and roll: the core of a box). References are published, or measured with
//! programs of another make (said in the table). CPU time is that of this process.

mod faults;
mod methods;
mod mixtures;
mod neighbours;
mod page;

use super::{Effort, StudyError};
use crate::num::Job;
use crate::num::statistics::{mean, standard_error};
use crate::report::findings::Findings;

/// One figure of one method.
struct Row {
    method: &'static str,
    dimension: usize,
    balls: usize,
    setting: String,
    quantity: &'static str,
    /// Mean over the samples.
    found: f64,
    /// Standard error of the mean; not a number for one sample.
    error: f64,
    samples: u64,
    reference: f64,
    source: &'static str,
    /// CPU time of one sample, mean.
    seconds: f64,
}

/// What was packed, in samples of other seeds.
struct Case {
    method: &'static str,
    dimension: usize,
    balls: usize,
    setting: String,
    /// CPU seconds of each sample.
    seconds: Vec<f64>,
}

impl Case {
    /// One figure: its values in the samples.
    fn row(
        &self,
        quantity: &'static str,
        values: &[f64],
        (reference, source): (f64, &'static str),
    ) -> Row {
        Row {
            method: self.method,
            dimension: self.dimension,
            balls: self.balls,
            setting: self.setting.clone(),
            quantity,
            found: mean(values).unwrap_or(f64::NAN),
            error: standard_error(values).unwrap_or(f64::NAN),
            samples: values.len() as u64,
            reference,
            source,
            seconds: mean(&self.seconds).unwrap_or(f64::NAN),
        }
    }
}

/// See [`super::STUDIES`].
pub fn study(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    let full = effort == Effort::Full;
    let mut rows = Vec::new();
    let pores = methods::all(full, job, &mut rows)?;
    mixtures::mixtures(full, job, &mut rows)?;
    let searches = neighbours::searches(full, job)?;
    let pressed = faults::faults(full, job)?;
    Ok(page::findings(&rows, pores, &pressed, &searches))
}
