//! YADE 2023.02a (Šmilauer et al. 2021): ViscElMat contacts, clumps with given
//! mass properties, walls and facets.

mod bonds;
mod limits;
mod read;
pub mod series;
mod values;

use super::deck::{Deck, DeckOptions, Queue, accept, write_folder};
use super::process::{self, Command};
use super::{Installation, Limit, Solver, SolverError, templates};
use crate::model::{Model, Run};
use crate::num::Job;
use std::path::Path;

/// YADE 2023.02a.
pub struct Yade;

const PROGRAM: &str = "yade";
const VARIABLE: &str = "RIPRAP_YADE";

impl Solver for Yade {
    fn key(&self) -> &'static str {
        "yade"
    }

    fn name(&self) -> &'static str {
        "YADE 2023.02a"
    }

    fn find(&self) -> Option<Installation> {
        let program = process::program(VARIABLE, PROGRAM)?;
        let version = process::says(&program, &["--version"], "Yade version:")?;
        Some(Installation { program, version })
    }

    fn how_to_install(&self) -> &'static str {
        "install it (Debian and Ubuntu: apt install yade), or set RIPRAP_YADE to the program"
    }

    fn takes_ranks(&self) -> bool {
        false
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
        if options.ranks != 1 {
            return Err(SolverError::Options(
                "YADE decks run on 1 rank: with more threads its results differ from run to run"
                    .into(),
            ));
        }
        let limits = accept(self, model)?;
        let script = values::Script::new(self, model, &limits)?;
        let needs = model.needs();
        let mut files = vec![
            ("run.py".to_owned(), templates::render("yade/run.py", &script)?),
            ("run.sh".to_owned(), templates::render("yade/run.sh", &values::Nothing {})?),
        ];
        if needs.spheres {
            let text = templates::render("yade/spheres.csv", &values::Spheres::new(model))?;
            files.push(("spheres.csv".to_owned(), text));
        }
        if needs.clumps {
            let text = templates::render("yade/clumps.csv", &values::Clumps::new(model))?;
            files.push(("clumps.csv".to_owned(), text));
            let text = templates::render("yade/members.csv", &values::Members::new(model))?;
            files.push(("members.csv".to_owned(), text));
        }
        if needs.bonds {
            let text = templates::render("yade/bonds.csv", &bonds::Bonds::new(model))?;
            files.push(("bonds.csv".to_owned(), text));
        }
        for (name, facets) in values::facets(model) {
            files.push((name, templates::render("yade/wall.txt", &facets)?));
        }
        if options.queue_script {
            files.push(("job.slurm".to_owned(), Queue::render(model, 1)?));
        }
        write_folder(folder, &files)?;
        let files = files.into_iter().map(|(name, _)| name).collect();
        Ok(Deck { folder: folder.to_owned(), files, ranks: 1, limits })
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
