//! The loop of methods in which grains enter and then wander in small trial steps: who enters when, when
//! the bed has settled, and the cold end in which nothing goes up any more.
//!
//! One sweep gives each grain inside one trial. Every [`WINDOW`] sweeps the mean height
//! is compared with that of the window before; the bed has settled when it
//! fell by less than the tolerance and no grain came in. O(grains) a sweep.

use crate::num::Job;
use crate::num::random::{Stream, whole};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where grains come into the container.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Insertion {
    /// At random free places in the whole container.
    #[default]
    Anywhere,
    /// At random free places in its uppermost layer, two grain sizes thick: a rain.
    Top,
}

/// Grains that wander.
pub trait Wanderers {
    /// Tries to bring `grain` in at one random place.
    fn enter(&mut self, grain: usize, source: &mut Stream) -> bool;
    /// One trial step of `grain`; `cold`: nothing may go up.
    fn stir(&mut self, grain: usize, cold: bool, source: &mut Stream);
    /// Height of its centre of mass, m.
    fn height(&self, grain: usize) -> f64;
}

/// How long to go on.
pub struct Schedule {
    /// Sweeps at most before the cold end; the cold end takes half as many at most.
    pub sweeps: u64,
    /// Grains that try to enter in a sweep.
    pub rate: u64,
    /// Fall of the mean height over a window that counts as none, m.
    pub settled: f64,
    /// False: no down; done when all are in.
    pub gravity: bool,
}

/// Sweeps over which heights are averaged.
pub const WINDOW: u64 = 100;
/// Windows without an entry after which those that wait are given up.
const PATIENCE: u32 = 3;

/// How it ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Walked {
    /// "settled", "sweeps used up", …
    pub end: &'static str,
    /// Sweeps done, the cold ones included.
    pub sweeps: u64,
    /// Grains that did not get in, rising.
    pub outside: Vec<usize>,
}

/// Lets `count` grains enter and wander.
pub fn walk(
    wanderers: &mut impl Wanderers,
    count: usize,
    schedule: &Schedule,
    source: &mut Stream,
    job: &Job,
) -> Walked {
    let mut waiting: Vec<usize> = (0..count).collect();
    // Families mix: grains enter in random order (Fisher & Yates).
    for i in (1..count).rev() {
        waiting.swap(i, whole(source, 0, i as u64) as usize);
    }
    let mut inside: Vec<usize> = Vec::with_capacity(count);
    let mut level = Level::default();
    let mut sweeps = 0;
    let ended = |end, sweeps, mut outside: Vec<usize>| {
        outside.sort_unstable();
        Walked { end, sweeps, outside }
    };
    let end = loop {
        if job.is_cancelled() {
            return ended("stopped by the user", sweeps, waiting);
        }
        if sweeps == schedule.sweeps {
            break "sweeps used up";
        }
        let before = inside.len();
        admit(wanderers, &mut waiting, &mut inside, schedule.rate, source);
        level.entered |= inside.len() > before;
        if !schedule.gravity && waiting.is_empty() {
            return ended("all grains are in", sweeps, waiting);
        }
        for &grain in &inside {
            wanderers.stir(grain, false, source);
        }
        sweeps += 1;
        if sweeps % 20 == 0 {
            job.report("sweeps", sweeps, schedule.sweeps);
        }
        let settled = level.after(wanderers, &inside, sweeps, schedule.settled);
        if settled && (waiting.is_empty() || level.without_entry > PATIENCE) {
            break "settled";
        }
    };
    if schedule.gravity {
        let mut level = Level::default();
        for cold in 1..=schedule.sweeps / 2 {
            if job.is_cancelled() {
                return ended("stopped by the user", sweeps, waiting);
            }
            for &grain in &inside {
                wanderers.stir(grain, true, source);
            }
            sweeps += 1;
            if level.after(wanderers, &inside, cold, schedule.settled) {
                break;
            }
        }
    }
    job.report("sweeps", schedule.sweeps, schedule.sweeps);
    ended(end, sweeps, waiting)
}

fn admit(
    wanderers: &mut impl Wanderers,
    waiting: &mut Vec<usize>,
    inside: &mut Vec<usize>,
    rate: u64,
    source: &mut Stream,
) {
    let tried = waiting.len().min(rate as usize);
    let mut refused = Vec::new();
    for grain in waiting.drain(..tried) {
        if wanderers.enter(grain, source) {
            inside.push(grain);
        } else {
            refused.push(grain);
        }
    }
    // Those that found no place go to the end of the queue.
    waiting.append(&mut refused);
}

/// Mean heights of this window and the one before.
#[derive(Default)]
struct Level {
    sum: f64,
    before: Option<f64>,
    entered: bool,
    without_entry: u32,
}

impl Level {
    fn after(
        &mut self,
        wanderers: &impl Wanderers,
        inside: &[usize],
        sweep: u64,
        least: f64,
    ) -> bool {
        let heights: f64 = inside.iter().map(|&grain| wanderers.height(grain)).sum();
        self.sum += heights / inside.len().max(1) as f64;
        if !sweep.is_multiple_of(WINDOW) {
            return false;
        }
        let mean = self.sum / WINDOW as f64;
        self.without_entry = if self.entered { 0 } else { self.without_entry + 1 };
        let still = self.before.is_some_and(|before| before - mean < least);
        let settled = still && !self.entered;
        (self.sum, self.before, self.entered) = (0.0, Some(mean), false);
        settled
    }
}
