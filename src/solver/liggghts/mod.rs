//! LIGGGHTS 3.8.0 (Kloss et al. 2012), as Debian builds it: hooke/stiffness
//! contacts, `fix rigid` clumps placed by file, primitive and mesh walls.

mod limits;
mod read;
mod values;

use super::deck::{Deck, DeckOptions, Queue, accept, write_folder};
use super::process::{self, Command};
use super::{Installation, Limit, Solver, SolverError, templates};
use crate::model::{Model, Run};
use crate::num::Job;
use std::path::Path;

/// LIGGGHTS 3.8.0.
pub struct Liggghts;

const PROGRAM: &str = "liggghts";
const VARIABLE: &str = "RIPRAP_LIGGGHTS";

impl Solver for Liggghts {
    fn key(&self) -> &'static str {
        "liggghts"
    }

    fn name(&self) -> &'static str {
        "LIGGGHTS 3.8.0"
    }

    fn find(&self) -> Option<Installation> {
        let program = process::program(VARIABLE, PROGRAM)?;
        let version = process::says(&program, &["-log", "none", "-h"], "Version ")?;
        let version = version.split([',', ' ']).next().unwrap_or_default().to_owned();
        Some(Installation { program, version })
    }

    fn how_to_install(&self) -> &'static str {
        "install it (Debian and Ubuntu: apt install liggghts), or build LIGGGHTS-PUBLIC 3.8.0 and set RIPRAP_LIGGGHTS to the program"
    }

    fn takes_ranks(&self) -> bool {
        true
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
        options.check()?;
        let limits = accept(self, model)?;
        let surfaces = values::surfaces(model);
        let script = values::Script::new(self, model, options, &surfaces, &limits);
        let mut files = vec![
            ("in.liggghts".to_owned(), templates::render("liggghts/in.liggghts", &script)?),
            (
                "spheres.data".to_owned(),
                templates::render("liggghts/spheres.data", &values::Data::new(model, &surfaces))?,
            ),
            (
                "run.sh".to_owned(),
                templates::render("liggghts/run.sh", &values::Start::new(options))?,
            ),
        ];
        if model.needs().clumps {
            let text = templates::render("liggghts/rigid.inf", &values::Rigid::new(model))?;
            files.push(("rigid.inf".to_owned(), text));
        }
        for surface in &surfaces {
            let text = templates::render("liggghts/wall.stl", &values::Stl::new(surface))?;
            files.push((surface.file(), text));
        }
        if options.queue_script {
            files.push(("job.slurm".to_owned(), Queue::render(model, options.ranks)?));
        }
        write_folder(folder, &files)?;
        let files = files.into_iter().map(|(name, _)| name).collect();
        Ok(Deck { folder: folder.to_owned(), files, ranks: options.ranks, limits })
    }

    fn run(&self, model: &Model, deck: &Deck, job: &Job) -> Result<Run, SolverError> {
        let program = process::program(VARIABLE, PROGRAM)
            .ok_or(SolverError::Missing { solver: self.name(), how: self.how_to_install() })?;
        process::remove(&deck.folder, read::OUTPUTS)?;
        let ended = Command {
            folder: &deck.folder,
            variable: VARIABLE,
            program: &program,
            solver: self.name(),
            steps: model.plan.steps,
            step_of: read::step_of,
            ranks: deck.ranks,
        }
        .run(job)?;
        read::run(self.name(), model, deck, &ended)
    }
}
