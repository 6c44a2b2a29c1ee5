//! Batch preprocessing: many cases of one scene, `riprap sweep`.
//!
//! A sweep file names a scene and the keys to vary: [`file::Sweep`]. [`cases`]
//! turns it into scenes, one a case, all of them checked before any work.
//! [`work`] does the cases in parallel, each in a folder of its own that can be
//! run by hand as well; what is finished is kept at any instant. [`summary`]
//! sets outputs against inputs.

pub mod cases;
pub mod file;
pub mod summary;
pub mod work;

pub use file::{Stage, Sweep};

use crate::report::ReportError;
use crate::scene::SceneError;

/// Why a sweep could not begin or be written down. A case that fails is no
/// error of the sweep: see [`work::Status`].
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The sweep file, or the scene of a case, cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A case whose scene cannot be used.
    #[error("case {case} ({values}):\n{error}")]
    Case {
        /// Its number.
        case: String,
        /// What it sets.
        values: String,
        /// What is wrong with it.
        error: SceneError,
    },
    /// The output folder holds something that would be lost.
    #[error("{0}")]
    Folder(String),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] crate::format::FormatError),
    /// A page or chart cannot be written.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The user asked to stop.
    #[error(
        "stopped; {done} of {total} cases are finished, `riprap sweep … --resume` does the rest"
    )]
    Cancelled {
        /// Finished cases.
        done: usize,
        /// All cases.
        total: usize,
    },
}
