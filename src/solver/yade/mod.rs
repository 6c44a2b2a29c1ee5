//! YADE 2023.02a (Šmilauer et al. 2021): ViscElMat contacts, clumps with given
//! mass properties, walls and facets.

mod bonds;
mod limits;
mod read;
pub mod series;
mod springs;
mod values;

use super::deck::{Deck, DeckOptions, Draft};
use super::program::Program;
use super::{Installation, Limit, Solver, SolverError};
use crate::model::{Law, Model, Run, Scheme};
use crate::num::Job;
use std::path::Path;

/// YADE 2023.02a.
pub struct Yade;

const PROGRAM: Program = Program {
    name: "YADE 2023.02a",
    command: "yade",
    variable: "RIPRAP_YADE",
    how_to_install: "install it (Debian and Ubuntu: apt install yade), or set RIPRAP_YADE to the program",
    ask: &["--version"],
    marker: "Yade version:",
    until: &[],
    outputs: read::OUTPUTS,
    step_of: read::step_of,
};

impl Solver for Yade {
    fn key(&self) -> &'static str {
        "yade"
    }

    fn name(&self) -> &'static str {
        PROGRAM.name
    }

    fn find(&self) -> Option<Installation> {
        PROGRAM.find()
    }

    fn absence(&self) -> String {
        PROGRAM.absence()
    }

    fn takes_ranks(&self) -> bool {
        false
    }

    fn scheme(&self, _tension: bool) -> (Scheme, Law) {
        (Scheme::Yade, Scheme::Yade.law())
    }

    fn limits(&self, model: &Model) -> Vec<Limit> {
        limits::of(model)
    }

    fn write(
        &self,
        model: &Model,
        folder: &Path,
        options: &DeckOptions,
    ) -> Result<Deck, SolverError> {
        let mut draft = Draft::new(self, model, options)?;
        let script = values::Script::new(self, model, draft.limits())?;
        let needs = model.needs();
        draft.add("run.py", "yade/run.py", &script)?;
        draft.add("run.sh", "yade/run.sh", &values::Nothing {})?;
        if needs.spheres {
            let (head, table) = (values::Spheres::new(model), values::spheres(model));
            draft.add_tables("spheres.csv", "yade/spheres.csv", &head, vec![table])?;
        }
        if needs.clumps {
            let (nothing, table) = (values::Nothing {}, values::clumps(model));
            draft.add_tables("clumps.csv", "yade/clumps.csv", &nothing, vec![table])?;
            let (head, table) = (values::Members::new(model), values::members(model));
            draft.add_tables("members.csv", "yade/members.csv", &head, vec![table])?;
        }
        if needs.arrivals {
            let (nothing, table) = (values::Nothing {}, values::arrivals(model));
            draft.add_tables("arrivals.csv", "yade/arrivals.csv", &nothing, vec![table])?;
        }
        if needs.bonds {
            let (nothing, table) = (values::Nothing {}, bonds::table(model));
            draft.add_tables("bonds.csv", "yade/bonds.csv", &nothing, vec![table])?;
        }
        if needs.springs {
            let (nothing, table) = (values::Nothing {}, springs::table(model));
            draft.add_tables("springs.csv", "yade/springs.csv", &nothing, vec![table])?;
        }
        for (name, facets) in values::facets(model) {
            draft.add(name, "yade/wall.txt", &facets)?;
        }
        draft.finish(model, folder, options)
    }

    fn run(&self, model: &Model, deck: &Deck, job: &Job) -> Result<Run, SolverError> {
        let ended = PROGRAM.run(model, deck, job)?;
        read::run(self.name(), model, deck, &ended)
    }
}
