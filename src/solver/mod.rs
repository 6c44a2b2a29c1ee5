//! Decks for other people's solvers, running them, reading them back.
//!
//! Every line of a deck stands in a template under `templates/`; this room
//! computes the values. What a solver cannot express, or does differently from
//! what the model says, is listed before a deck is written.

pub mod capability;
mod deck;
#[cfg(test)]
mod deck_tests;
mod dump;
mod finite;
pub mod lammps;
mod left_out;
pub mod liggghts;
mod mesh_check;
mod orientation;
mod process;
mod program;
mod reading;
mod restart_springs;
pub mod rigid_masses;
mod single;
mod surface;
mod table;
pub mod templates;
pub mod yade;

pub use deck::{Deck, DeckOptions};
pub use program::Program;

use crate::model::{Law, Model, Run, Scheme};
use crate::num::Job;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A solver that decks can be written for.
pub trait Solver: Sync {
    /// Its program, as decks are written for it.
    fn program(&self) -> &'static Program;
    /// Key on the command line and in file names: `liggghts`, `yade`, `lammps`.
    fn key(&self) -> &'static str {
        self.program().key
    }
    /// Name for people, with the version that decks are written for.
    fn name(&self) -> &'static str {
        self.program().name
    }
    /// The program on this machine: from the environment variable `RIPRAP_LIGGGHTS`,
    /// `RIPRAP_YADE` or `RIPRAP_LAMMPS` where it is set, else from `PATH`; `None` if there is
    /// none that starts.
    fn find(&self) -> Option<Installation> {
        self.program().find()
    }
    /// Why [`Self::find`] finds none and how to get it: the end of a sentence that starts with
    /// its name, "is not installed; …".
    fn absence(&self) -> String {
        self.program().absence()
    }
    /// True if its decks can be run on several MPI ranks.
    fn takes_ranks(&self) -> bool;
    /// Scheme and law with which our own DEM computes what its decks compute, to rounding;
    /// `tension` says whether the normal force of the scene may pull.
    fn scheme(&self, tension: bool) -> (Scheme, Law);
    /// What of `model` this solver cannot express or does differently.
    fn limits(&self, model: &Model) -> Vec<Limit>;
    /// The first limit that forbids a deck of `model`, if any does.
    fn refusal(&self, model: &Model) -> Option<Limit> {
        self.limits(model).into_iter().find(|limit| limit.kind == LimitKind::Refused)
    }
    /// `model` with the scheme and law in which our own DEM computes what the deck of `model` computes.
    fn twin(&self, model: &Model) -> Model {
        let mut twin = model.clone();
        (twin.plan.scheme, twin.plan.law) = self.scheme(model.plan.law.tension);
        twin
    }
    /// Writes the deck of `model` as `folder`, which must not hold anything but an
    /// older deck: everything goes to a temporary folder beside it, which then takes its place.
    fn write(
        &self,
        model: &Model,
        folder: &Path,
        options: &DeckOptions,
    ) -> Result<Deck, SolverError>;
    /// Runs `run.sh` of the deck, reports progress to `job`, stops the solver when
    /// `job` is cancelled, and reads back what it wrote.
    fn run(&self, model: &Model, deck: &Deck, job: &Job) -> Result<Run, SolverError>;
}

/// The solvers, in the order in which they are listed.
pub fn all() -> [&'static dyn Solver; 3] {
    [&liggghts::Liggghts, &yade::Yade, &lammps::Lammps]
}

/// Those of `solvers` that can run `model`, and one sentence for each of the others on what it cannot do.
pub fn able(
    solvers: &[&'static dyn Solver],
    model: &Model,
) -> (Vec<&'static dyn Solver>, Vec<String>) {
    let (mut able, mut unable) = (Vec::new(), Vec::new());
    for solver in solvers {
        match solver.refusal(model) {
            Some(limit) => unable.push(limit.of(*solver)),
            None => able.push(*solver),
        }
    }
    (able, unable)
}

/// A solver found on this machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Installation {
    /// The program.
    pub program: PathBuf,
    /// What it says its version is.
    pub version: String,
}

/// Something that a solver cannot do as the model says.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limit {
    /// Whether a deck can be written all the same.
    pub kind: LimitKind,
    /// What, in one or two sentences.
    pub what: String,
}

/// How much a limit matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LimitKind {
    /// No deck is written: it would not mean the model.
    Refused,
    /// A deck is written; the solver does this in its own way.
    Differs,
}

impl Limit {
    /// A limit that forbids the deck.
    pub fn refused(what: impl Into<String>) -> Self {
        Self { kind: LimitKind::Refused, what: what.into() }
    }

    /// That it keeps `solver` from running a scene, as a sentence.
    pub fn of(&self, solver: &dyn Solver) -> String {
        format!("{} cannot run this scene: {}", solver.name(), self.what)
    }

    /// A limit that changes what the solver computes.
    pub fn differs(what: impl Into<String>) -> Self {
        Self { kind: LimitKind::Differs, what: what.into() }
    }
}

/// Why a deck was not written or a solver gave nothing that can be used.
#[derive(Debug, thiserror::Error)]
pub enum SolverError {
    /// The solver cannot express the model.
    #[error("{solver} cannot express this scene: {}", reasons.join("; "))]
    Refused {
        /// Name of the solver.
        solver: &'static str,
        /// The limits that forbid a deck.
        reasons: Vec<String>,
    },
    /// A number of the model that would end in the deck is NaN or infinite.
    #[error("{what} is {value}; a deck can only hold finite numbers")]
    NotFinite {
        /// Which number, for example `bodies[3].velocity`.
        what: String,
        /// Its value.
        value: f64,
    },
    /// The options do not fit each other.
    #[error("{0}")]
    Options(String),
    /// The solver is not installed.
    #[error("{solver} was not found on this machine; {how}")]
    Missing {
        /// Name of the solver.
        solver: &'static str,
        /// How to install it.
        how: &'static str,
    },
    /// A file or folder cannot be written or read.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A template cannot be rendered: a fault of riprap.
    #[error("the deck template {template} cannot be rendered: {problem}")]
    Template {
        /// Which template.
        template: String,
        /// What tera says.
        problem: String,
    },
    /// The solver ended with an error before it wrote a frame.
    #[error("{solver} ended with {status} before it wrote anything{}", said(tail))]
    Solver {
        /// Name of the solver.
        solver: &'static str,
        /// Exit status.
        status: String,
        /// The last lines that it printed.
        tail: String,
    },
    /// What the solver wrote is not what was asked for.
    #[error("{path}: {problem}", path = path.display())]
    Output {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
}

/// Last lines of output as the end of a message.
fn said(tail: &str) -> String {
    if tail.trim().is_empty() { "; it said nothing".to_owned() } else { format!(":\n{tail}") }
}

impl SolverError {
    /// An [`SolverError::Io`] at `path`, for `map_err`.
    fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Io { path: path.to_owned(), source }
    }

    /// An [`SolverError::Output`] at `path`.
    fn output(path: &Path, problem: impl Into<String>) -> Self {
        Self::Output { path: path.to_owned(), problem: problem.into() }
    }
}
