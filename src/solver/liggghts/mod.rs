//! LIGGGHTS 3.8.0 (Kloss et al. 2012), as Debian builds it: hooke/stiffness
//! contacts, `fix rigid` clumps placed by file or `fix multisphere`, primitive and mesh walls.

mod arrivals;
mod limits;
mod multisphere;
mod read;
mod start;
mod values;

use super::deck::{Deck, DeckOptions, Draft};
use super::dump;
use super::program::Program;
use super::restart_springs::Layout;
use super::{Installation, Limit, Solver, SolverError};
use crate::model::{Law, Model, Run, Scheme};
use crate::num::Job;
use std::path::Path;

/// LIGGGHTS 3.8.0.
pub struct Liggghts;

const PROGRAM: Program = Program {
    name: "LIGGGHTS 3.8.0",
    command: "liggghts",
    variable: "RIPRAP_LIGGGHTS",
    how_to_install: "install it (Debian and Ubuntu: apt install liggghts), or build LIGGGHTS-PUBLIC 3.8.0 and set RIPRAP_LIGGGHTS to the program",
    ask: &["-log", "none", "-h"],
    marker: "Version ",
    until: &[',', ' '],
    outputs: read::OUTPUTS,
    step_of: dump::step_of,
};

const LAYOUT: Layout = Layout {
    solver: PROGRAM.name,
    own: 17,
    tail: 0,
    contacts_first: false,
    plain_numbers: false,
    is_primitive: values::is_primitive,
};

impl Solver for Liggghts {
    fn key(&self) -> &'static str {
        "liggghts"
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

    fn scheme(&self, tension: bool) -> (Scheme, Law) {
        (Scheme::Liggghts, Law { tension, ..Scheme::Liggghts.law() })
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
        let points = values::extras(model);
        let mut draft = Draft::new(self, model, options)?;
        let surfaces = values::surfaces(model);
        let limits = draft.limits();
        let script = values::Script::new(self, model, options, &surfaces, &points, limits);
        draft.add("in.liggghts", "liggghts/in.liggghts", &script)?;
        let data = values::Data::new(model, &surfaces, &points);
        let tables = vec![values::atoms(model, &points), values::velocities(model, &points)];
        draft.add_tables("spheres.data", "liggghts/spheres.data", &data, tables)?;
        draft.add("run.sh", "liggghts/run.sh", &start::Start::new(model, options))?;
        if multisphere::is_used(model) {
            let clumps = multisphere::Clumps::new(model);
            let tables = vec![multisphere::places(model), multisphere::insertions(model)];
            draft.add_tables("clumps.in", "liggghts/clumps.in", &clumps, tables)?;
            let table = vec![multisphere::numbers(model)];
            draft.add_tables("placed.in", "liggghts/placed.in", &clumps, table)?;
        } else if model.needs().clumps {
            let (rigid, table) = (values::Rigid::new(model), values::rigid(model));
            draft.add_tables("rigid.inf", "liggghts/rigid.inf", &rigid, vec![table])?;
        }
        if model.needs().springs {
            draft.add_springs(model, LAYOUT)?;
        }
        if model.needs().arrivals {
            let head = arrivals::Arrivals::new(model);
            draft.add_tables(
                "arrivals.in",
                "liggghts/arrivals.in",
                &head,
                arrivals::tables(model),
            )?;
        }
        for surface in &surfaces {
            draft.add(surface.file(), "liggghts/wall.stl", &values::Stl::new(surface))?;
        }
        draft.finish(model, folder, options)
    }

    fn run(&self, model: &Model, deck: &Deck, job: &Job) -> Result<Run, SolverError> {
        let ended = PROGRAM.run(model, deck, job)?;
        read::run(self.name(), model, deck, &ended)
    }
}
