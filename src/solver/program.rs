//! What all solvers that are programs have in common: finding one, asking for
//! its version, running a deck with it.

use super::process::{self, Command, Ended};
use super::{Deck, Installation, SolverError};
use crate::model::Model;
use crate::num::Job;

/// A program that runs decks.
#[derive(Debug)]
pub struct Program {
    /// Key on the command line and in file names.
    pub key: &'static str,
    /// Name for people, with the version that decks are written for.
    pub name: &'static str,
    /// Command on `PATH`.
    pub command: &'static str,
    /// Environment variable that names another program.
    pub variable: &'static str,
    /// How to get it, as the end of a sentence.
    pub how_to_install: &'static str,
    /// Arguments with which it tells its version.
    pub ask: &'static [&'static str],
    /// What it prints just before its version.
    pub marker: &'static str,
    /// Characters that end the version, besides the end of the line.
    pub until: &'static [char],
    /// Files that a run writes; older ones are removed before it.
    pub outputs: &'static [&'static str],
    /// Reads the step number from a line of output, if it tells one.
    pub step_of: fn(&str) -> Option<u64>,
}

impl Program {
    /// The program on this machine; `None` if there is none that starts.
    pub fn find(&self) -> Option<Installation> {
        let program = process::program(self.variable, self.command)?;
        let version = process::says(&program, self.ask, self.marker)?;
        let version = version.split(self.until).next().unwrap_or_default().to_owned();
        Some(Installation { program, version })
    }

    /// Why there is none, and how to get it: the end of a sentence that starts with its name.
    pub fn absence(&self) -> String {
        let how = self.how_to_install;
        let asked = std::env::var(self.variable).ok().filter(|value| !value.is_empty());
        match (process::program(self.variable, self.command), asked) {
            (Some(path), _) => format!(
                "is not usable: {} does not tell its version when it is called with `{}`; {how}",
                path.display(),
                self.ask.join(" ")
            ),
            (None, Some(value)) => {
                let variable = self.variable;
                format!("is not installed: {variable} names {value}, which is no program; {how}")
            }
            (None, None) => format!("is not installed; {how}"),
        }
    }

    /// Runs `run.sh` of a deck until it ends or `job` is cancelled.
    pub fn run(&self, model: &Model, deck: &Deck, job: &Job) -> Result<Ended, SolverError> {
        let program = process::program(self.variable, self.command)
            .ok_or(SolverError::Missing { solver: self.name, how: self.how_to_install })?;
        process::remove(&deck.folder, self.outputs)?;
        Command {
            folder: &deck.folder,
            variable: self.variable,
            program: &program,
            solver: self.name,
            steps: model.plan.steps,
            step_of: self.step_of,
            ranks: deck.ranks,
        }
        .run(job)
    }
}
