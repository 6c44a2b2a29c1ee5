//! Error against run time: `riprap study WHAT`. One file a study; each is a
//! function from [`Effort`] to [`Findings`], which become tables, charts, CSV
//! and a page. Figures of CPU time depend on the machine; everything else is
//! the same at every run.

mod bulk;
mod clump;
mod contact;
mod ensembles;
mod equivalence;
mod impact;
mod limit;
pub mod matrix;
mod models;
mod oblique;
mod outside;
mod packing;
mod reproduction;
mod shapes;
mod solids;
mod stand_in;
mod tree;

use crate::num::{Job, clock};
use crate::report::findings::Findings;
use std::time::Instant;

/// How much a study computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// Enough to see every method once: seconds to some minutes.
    Quick,
    /// What validation pages are made from: minutes to half an hour.
    Full,
}

/// Why a study did not end.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The user asked to stop.
    #[error("stopped; a study keeps nothing of what it has not finished")]
    Cancelled,
    /// What was asked for is not there.
    #[error("{0}")]
    Input(String),
    /// A computation failed that should not.
    #[error("{0}")]
    Work(String),
}

/// What does a study.
pub type Work = fn(Effort, &Job) -> Result<Findings, StudyError>;

/// A study.
pub struct Study {
    /// Key on the command line.
    pub key: &'static str,
    /// What it shows, in one line.
    pub summary: &'static str,
    /// Does it.
    pub run: Work,
}

/// All studies.
pub const STUDIES: &[Study] = &[
    Study {
        key: "contact",
        summary: "restitution and oblique rebound of each scheme against closed forms, over the step and CPU time",
        run: contact::study,
    },
    Study {
        key: "tree",
        summary: "gravity between bodies: error of the tree code over θ and CPU time, n log n cost",
        run: tree::study,
    },
    Study {
        key: "clump",
        summary: "error of each clump method against the number of spheres and CPU time, on eight solids, and what it costs in rebounds and heaps",
        run: clump::study,
    },
    Study {
        key: "motion",
        summary: "rebound and angle of repose of fitted clumps beside the finest clump of their solid, with 95 % intervals",
        run: stand_in::study,
    },
    Study {
        key: "reproduction",
        summary: "R1 to R5 against what their papers say of them: spheres at equal error, starts, constants, cost, thresholds",
        run: reproduction::study,
    },
    Study {
        key: "packing",
        summary: "density, dimension and coordination of each packing method against references, over CPU time and number",
        run: packing::study,
    },
    Study {
        key: "shapes",
        summary: "loose and dense solid fractions of spheres, dimers, spherocylinders, ellipsoids, cubes and tetrahedra by method; what control points depend on",
        run: shapes::study,
    },
    Study {
        key: "bulk",
        summary: "a collapse: distance from the converged motion over step and CPU time, and the heap over seeds",
        run: bulk::study,
    },
    Study {
        key: "ensembles",
        summary: "three bulk scenes over seeds: statistical error of our schemes and the outside solvers, equivalence, CPU time",
        run: ensembles::study,
    },
    Study {
        key: "limit",
        summary: "where a settled bed becomes unstable, against the step bound of its contacts",
        run: limit::study,
    },
];

/// The study of this key.
pub fn find(key: &str) -> Option<&'static Study> {
    STUDIES.iter().find(|study| study.key == key)
}

/// The study of this key without its DEM runs; `None` where it is nothing else or has none.
pub fn without_dem(key: &str) -> Option<Work> {
    (key == "clump").then_some(clump::shapes_alone as _)
}

/// Fails once the user has asked to stop.
fn go_on(job: &Job) -> Result<(), StudyError> {
    if job.is_cancelled() { Err(StudyError::Cancelled) } else { Ok(()) }
}

/// A result and the CPU seconds of this process that it took.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let (cpu, wall) = (clock::cpu_seconds(), Instant::now());
    let result = work();
    (result, clock::since(cpu, wall))
}
