//! Statistics over the last part of a run.
//!
//! A bed that still moves shows something else at every moment, so each statistic
//! is the mean over the frames of the last [`SHARE`] of the time (at least the last
//! frame, at most [`MOST`] of them). Symbols: xᵢ the m values, s² their variance,
//! ρ = Σ dᵢ dᵢ₊₁ / Σ dᵢ² the correlation of neighbours with dᵢ = xᵢ − x̄. The standard
//! error of the mean is s/√mₑ with mₑ = m (1 − ρ)/(1 + ρ) independent values (of a
//! process with e-folding memory; Bartlett 1946), between 1 and m.
//! Cost O(frames × spheres).

use super::region::Region;
use super::statistics::{Quantity, Snapshot};
use crate::model::{Frame, Model};
use crate::num::statistics::mean;
use serde::{Deserialize, Serialize};

/// Part of the time at the end of the run that counts.
pub const SHARE: f64 = 0.25;
/// Frames that are measured at most, spread evenly, the last one always among them.
pub const MOST: usize = 16;

/// The statistics of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Time of the first frame that counts, s.
    pub from: f64,
    /// Time of the last frame, s.
    pub until: f64,
    /// Number of frames measured.
    pub frames: usize,
    /// Mean of each quantity that means something here, in the order of [`Quantity::ALL`].
    pub means: Vec<Mean>,
    /// Number of contacts between spheres in the last frame.
    pub contacts: usize,
    /// Normal forces of these contacts, rising, N.
    pub forces: Vec<f64>,
}

/// A quantity over the last part of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mean {
    /// Which.
    pub quantity: Quantity,
    /// Mean over the frames.
    pub value: f64,
    /// Its standard error, from how it changes from frame to frame.
    pub time_error: f64,
    /// Standard error from the number of bodies or contacts of the last frame, taken
    /// as independent; 0 for quantities that are no such mean.
    pub sample_error: f64,
}

impl Statistics {
    /// Mean of `quantity`; `None` where it means nothing.
    pub fn value(&self, quantity: Quantity) -> Option<f64> {
        self.of(quantity).map(|mean| mean.value)
    }

    pub(super) fn of(&self, quantity: Quantity) -> Option<&Mean> {
        self.means.iter().find(|mean| mean.quantity == quantity)
    }
}

/// The values behind [`Statistics`], frame by frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Span {
    pub statistics: Statistics,
    times: Vec<f64>,
    values: Vec<(Quantity, Vec<f64>)>,
}

impl Span {
    /// Measures the last part of a run; `None` without frames.
    pub(super) fn of(model: &Model, frames: &[Frame], region: &Region) -> Option<Self> {
        let shown = counted(frames);
        let states: Vec<Snapshot> =
            shown.iter().map(|frame| Snapshot::of(model, frame, region)).collect();
        let last = states.last()?;
        let values: Vec<(Quantity, Vec<f64>)> = Quantity::ALL
            .into_iter()
            .filter_map(|quantity| {
                let values: Option<Vec<f64>> =
                    states.iter().map(|state| state.value(quantity)).collect();
                Some((quantity, values?))
            })
            .collect();
        let means = values
            .iter()
            .map(|(quantity, values)| Mean {
                quantity: *quantity,
                value: mean(values).unwrap_or(0.0),
                time_error: error_of_mean(values),
                sample_error: last.standard_error(*quantity),
            })
            .collect();
        let statistics = Statistics {
            from: shown.first()?.time,
            until: shown.last()?.time,
            frames: shown.len(),
            means,
            contacts: last.forces.len(),
            forces: last.forces.clone(),
        };
        Some(Self { statistics, times: shown.iter().map(|frame| frame.time).collect(), values })
    }

    /// Standard error of the difference of the means of two runs. Where both have
    /// the same times, from the differences frame by frame, so that what both go
    /// through alike does not count as scatter.
    pub(super) fn error_of_difference(&self, other: &Self, quantity: Quantity) -> f64 {
        let find = |span: &Self| {
            span.values.iter().find(|(q, _)| *q == quantity).map(|(_, values)| values.clone())
        };
        let (Some(a), Some(b)) = (find(self), find(other)) else { return 0.0 };
        let tick = 1e-6 * self.statistics.until.abs();
        let alike = self.times.len() == other.times.len()
            && self.times.iter().zip(&other.times).all(|(a, b)| (a - b).abs() <= tick);
        if alike {
            let apart: Vec<f64> = a.iter().zip(&b).map(|(a, b)| b - a).collect();
            error_of_mean(&apart)
        } else {
            error_of_mean(&a).hypot(error_of_mean(&b))
        }
    }
}

/// The frames that count.
fn counted(frames: &[Frame]) -> Vec<&Frame> {
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else { return Vec::new() };
    let start = last.time - SHARE * (last.time - first.time);
    let late: Vec<&Frame> =
        frames.iter().filter(|f| f.time >= start - 1e-9 * last.time.abs()).collect();
    let shown = late.len().min(MOST);
    (1..=shown).map(|place| late[place * late.len() / shown - 1]).collect()
}

/// Standard error of the mean of values that remember their predecessors; 0 for fewer than two.
fn error_of_mean(values: &[f64]) -> f64 {
    let Some(mean) = mean(values).filter(|_| values.len() > 1) else { return 0.0 };
    let count = values.len() as f64;
    let apart: Vec<f64> = values.iter().map(|value| value - mean).collect();
    let square: f64 = apart.iter().map(|d| d * d).sum();
    if square <= 0.0 {
        return 0.0;
    }
    let memory = apart.windows(2).map(|d| d[0] * d[1]).sum::<f64>() / square;
    let memory = memory.clamp(0.0, 1.0);
    let independent = (count * (1.0 - memory) / (1.0 + memory)).max(1.0);
    (square / (count - 1.0) / independent).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{Vec3, random};
    use crate::report::fixture;

    #[test]
    fn the_last_quarter_counts() {
        let model = fixture::model(2);
        let run = fixture::run(&model, "ours", |step| Vec3::z() * (1e-6 * step as f64));
        let region = Region::of(&model, run.frames.last());
        let found = Span::of(&model, &run.frames, &region).expect("frames").statistics;
        // Steps 800, 900 and 1000 of 1000.
        assert_eq!((found.frames, found.from, found.until), (3, 8e-3, 1e-2));
        let mean = found.value(Quantity::MeanHeight).expect("always there");
        assert!((mean - (0.0099 + 0.9e-3)).abs() < 1e-12);
        let alone = Span::of(&model, &run.frames[10..], &region).expect("a frame").statistics;
        assert_eq!((alone.frames, alone.means[0].time_error), (1, 0.0));
        assert!(Span::of(&model, &[], &region).is_none());
    }

    #[test]
    fn many_frames_are_thinned_evenly_to_the_last() {
        let model = fixture::model(1);
        let frames: Vec<Frame> =
            (0..401).map(|step| fixture::frame(&model, step, Vec3::zeros())).collect();
        let shown: Vec<u64> = counted(&frames).iter().map(|frame| frame.step).collect();
        assert_eq!((shown.len(), shown[MOST - 1]), (MOST, 400));
        assert!(shown.windows(2).all(|pair| (6..=7).contains(&(pair[1] - pair[0]))));
    }

    #[test]
    fn memory_widens_the_error() {
        let mut stream = random::stream(5, "test", 0);
        let noise: Vec<f64> = (0..400).map(|_| random::uniform(&mut stream, -1.0, 1.0)).collect();
        // White noise on [-1, 1]: s = 1/√3.
        let white = error_of_mean(&noise);
        assert!((white * 20.0 * 3_f64.sqrt() - 1.0).abs() < 0.2, "{white}");
        // An autoregressive process with coefficient a has s²/m · (1 + a)/(1 − a).
        let mut value = 0.0;
        let slow: Vec<f64> = noise
            .iter()
            .map(|kick| {
                value = 0.8 * value + kick;
                value
            })
            .collect();
        let expected = (1.0 / 3.0_f64 / (1.0 - 0.64) / 400.0 * 9.0).sqrt();
        assert!((error_of_mean(&slow) / expected - 1.0).abs() < 0.3);
        assert_eq!(error_of_mean(&[2.0; 9]), 0.0);
    }

    #[test]
    fn what_both_runs_go_through_is_no_scatter() {
        let model = fixture::model(2);
        let run = fixture::run(&model, "a", |step| Vec3::z() * (1e-6 * step as f64));
        let higher = fixture::run(&model, "b", |step| Vec3::z() * (1e-6 * step as f64 + 1e-4));
        let region = Region::of(&model, run.frames.last());
        let span = |run: &crate::model::Run| Span::of(&model, &run.frames, &region);
        let (a, b) = (span(&run).expect("frames"), span(&higher).expect("frames"));
        assert!(a.statistics.means[0].time_error > 1e-5);
        assert!(a.error_of_difference(&b, Quantity::TopHeight) < 1e-15);
    }
}
