//! LAMMPS 29 Sep 2021 (Thompson et al. 2022), as Debian builds it: `pair_style granular`,
//! `fix rigid/small` clumps placed by file, planes. Triangulated walls came to LAMMPS later.

mod limits;
mod read;
mod values;

use super::deck::{Deck, DeckOptions, Draft};
use super::dump;
use super::program::Program;
use super::restart_springs::Layout;
use super::{Installation, Limit, Solver, SolverError};
use crate::model::{Arm, History, Law, Model, Run, Scheme, Wall};
use crate::num::Job;
use std::path::Path;

/// LAMMPS 29 Sep 2021.
pub struct Lammps;

const PROGRAM: Program = Program {
    name: "LAMMPS 29 Sep 2021",
    command: "lmp",
    variable: "RIPRAP_LAMMPS",
    how_to_install: "install it (Debian and Ubuntu: apt install lammps), or build LAMMPS with the packages GRANULAR and RIGID and set RIPRAP_LAMMPS to the program",
    ask: &["-log", "none", "-h"],
    marker: "Massively Parallel Simulator - ",
    until: &[],
    outputs: read::OUTPUTS,
    step_of: dump::step_of,
};

const LAYOUT: Layout = Layout {
    solver: PROGRAM.name,
    own: 16,
    tail: 16,
    contacts_first: true,
    plain_numbers: true,
    is_primitive: Wall::is_primitive,
};

impl Solver for Lammps {
    fn key(&self) -> &'static str {
        "lammps"
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
        true
    }

    /// The scheme is that of `gran/hooke/history`; `granular` keeps the length of a turned
    /// spring and shortens the arm of the torque between spheres.
    fn scheme(&self, tension: bool) -> (Scheme, Law) {
        let law = Scheme::Lammps.law();
        (Scheme::Lammps, Law { tension, history: History::Rescaled, arm: Arm::Split, ..law })
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
        let script = values::Script::new(self, model, options, draft.limits());
        draft.add("in.lammps", "lammps/in.lammps", &script)?;
        let (data, atoms) = (values::Data::new(model), values::atoms(model));
        let tables = vec![atoms, values::velocities(model), values::molecules(model)];
        draft.add_tables("spheres.data", "lammps/spheres.data", &data, tables)?;
        draft.add("run.sh", "lammps/run.sh", &values::Start::new(model, options))?;
        if model.needs().springs {
            draft.add_springs(model, LAYOUT)?;
        }
        if model.needs().arrivals {
            let (head, table) = (values::Arrivals::new(model), values::arrivals(model));
            draft.add_tables("arrivals.in", "lammps/arrivals.in", &head, vec![table])?;
        }
        if model.needs().clumps {
            let (rigid, table) = (values::Rigid::new(model), values::rigid(model));
            draft.add_tables("rigid.inf", "lammps/rigid.inf", &rigid, vec![table])?;
        }
        draft.finish(model, folder, options)
    }

    fn run(&self, model: &Model, deck: &Deck, job: &Job) -> Result<Run, SolverError> {
        let ended = PROGRAM.run(model, deck, job)?;
        read::run(self.name(), model, deck, &ended)
    }
}
