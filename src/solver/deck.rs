//! A deck: a folder of files that a solver runs as they are, written whole or not at all.

use super::left_out::{LeftOut, left_out};
use super::restart_springs::{self, Layout};
use super::table::{self, Table};
use super::{Limit, LimitKind, Solver, SolverError, finite, templates};
use crate::model::Model;
use crate::num::Vec3;
use serde::Serialize;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// How a deck is to be run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeckOptions {
    /// MPI ranks, at least 1 (YADE: 1).
    pub ranks: usize,
    /// Processor grid; `None` lets the solver choose. The product must be `ranks`.
    pub processors: Option<[usize; 3]>,
    /// Also write `job.slurm` for a batch queue.
    pub queue_script: bool,
}

impl Default for DeckOptions {
    fn default() -> Self {
        Self { ranks: 1, processors: None, queue_script: false }
    }
}

impl DeckOptions {
    /// An error when ranks and processor grid do not fit.
    pub fn check(&self) -> Result<(), SolverError> {
        if self.ranks == 0 {
            return Err(SolverError::Options("a deck needs at least 1 MPI rank".into()));
        }
        match self.processors {
            Some(grid) if grid.iter().product::<usize>() != self.ranks => {
                Err(SolverError::Options(format!(
                    "a processor grid of {} x {} x {} does not make {} ranks",
                    grid[0], grid[1], grid[2], self.ranks
                )))
            }
            _ => Ok(()),
        }
    }
}

impl DeckOptions {
    /// Text of the `processors` command of LAMMPS and LIGGGHTS; empty for one rank. Without a
    /// grid of the user's, the box is not cut across gravity, where the load is uneven.
    pub fn processors_text(&self, model: &Model) -> String {
        match self.processors {
            Some(grid) => grid.map(|n| n.to_string()).join(" "),
            None if self.ranks == 1 => String::new(),
            None => {
                let needs = model.needs();
                let down = needs.gravity.then(|| model.gravity.iamax());
                [0, 1, 2]
                    .map(|axis| {
                        let flat = needs.discs && axis == 2;
                        if Some(axis) == down || flat { "1" } else { "*" }
                    })
                    .join(" ")
            }
        }
    }
}

/// A deck that was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Deck {
    /// The folder.
    pub folder: PathBuf,
    /// File names in the folder, `run.sh` among them.
    pub files: Vec<String>,
    /// MPI ranks that `run.sh` starts.
    pub ranks: usize,
    /// What the solver does differently from the model.
    pub limits: Vec<Limit>,
}

/// A vector as templates take it.
pub fn plain(vector: &Vec3) -> [f64; 3] {
    [vector.x, vector.y, vector.z]
}

/// What stands at the top of every deck.
#[derive(Debug, Clone, Serialize)]
pub struct Header {
    version: &'static str,
    solver: &'static str,
    title: String,
    seed: u64,
    steps: u64,
    step: f64,
    duration: f64,
    bodies: usize,
    spheres: usize,
    left_out: Vec<LeftOut>,
    differs: Vec<String>,
}

impl Header {
    /// The header of the deck of `model` for `solver`.
    pub fn new(solver: &dyn Solver, model: &Model, limits: &[Limit]) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            solver: solver.name(),
            title: one_line(&model.title),
            seed: model.seed,
            steps: model.plan.steps,
            step: model.plan.step,
            duration: model.plan.duration(),
            bodies: model.bodies.len(),
            spheres: model.spheres.len(),
            left_out: left_out(&model.needs()),
            differs: limits.iter().map(|limit| limit.what.clone()).collect(),
        }
    }
}

/// Text that cannot leave the comment line it is put in: a title may hold line
/// breaks, and `&` at the end of a line continues it in LIGGGHTS.
fn one_line(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    text.trim().trim_end_matches('&').to_owned()
}

/// Refuses what cannot be written; else the limits that remain.
fn accept(solver: &dyn Solver, model: &Model) -> Result<Vec<Limit>, SolverError> {
    finite::check(model)?;
    let limits = solver.limits(model);
    let reasons: Vec<String> = limits
        .iter()
        .filter(|limit| limit.kind == LimitKind::Refused)
        .map(|limit| limit.what.clone())
        .collect();
    if reasons.is_empty() {
        return Ok(limits);
    }
    Err(SolverError::Refused { solver: solver.name(), reasons })
}

/// Values of the batch-queue script.
#[derive(Debug, Serialize)]
struct Queue {
    name: String,
    ranks: usize,
}

impl Queue {
    /// `job.slurm` for a model on `ranks` ranks.
    fn render(model: &Model, ranks: usize) -> Result<String, SolverError> {
        let name: String = model
            .title
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
            .take(40)
            .collect();
        templates::render("job.slurm", &Self { name, ranks })
    }
}

/// A deck on its way: what is written into its folder at the end.
pub struct Draft<'a> {
    limits: Vec<Limit>,
    files: Vec<File<'a>>,
}

/// A file of a deck: its text, and the tables that it has room for.
struct File<'a> {
    name: String,
    text: String,
    tables: Vec<Table<'a>>,
}

impl<'a> Draft<'a> {
    /// An empty deck of `model`.
    ///
    /// # Errors
    /// Options that do not fit, numbers that are not finite, what the solver cannot express.
    pub fn new(
        solver: &dyn Solver,
        model: &Model,
        options: &DeckOptions,
    ) -> Result<Self, SolverError> {
        options.check()?;
        if options.ranks > 1 && !solver.takes_ranks() {
            return Err(SolverError::Options(format!(
                "{} decks run on 1 rank: with more threads its results differ from run to run",
                solver.name()
            )));
        }
        Ok(Self { limits: accept(solver, model)?, files: Vec::new() })
    }

    /// What the solver does differently.
    pub fn limits(&self) -> &[Limit] {
        &self.limits
    }

    /// Adds a file made from a template.
    pub fn add(
        &mut self,
        name: impl Into<String>,
        template: &str,
        values: &impl Serialize,
    ) -> Result<(), SolverError> {
        self.add_tables(name, template, values, Vec::new())
    }

    /// Adds a file made from a template that has room for tables, which are written row by row.
    pub fn add_tables(
        &mut self,
        name: impl Into<String>,
        template: &str,
        values: &impl Serialize,
        tables: Vec<Table<'a>>,
    ) -> Result<(), SolverError> {
        let text = templates::render(template, values)?;
        self.files.push(File { name: name.into(), text, tables });
        Ok(())
    }

    /// Adds the springs at the start, and what puts them into a restart file.
    pub fn add_springs(&mut self, model: &'a Model, layout: Layout) -> Result<(), SolverError> {
        let script = restart_springs::Script::new(model, layout);
        self.add("springs.py", "springs.py", &script)?;
        let table = restart_springs::table(model, layout.is_primitive);
        self.add_tables("springs.csv", "springs.csv", &script, vec![table])
    }

    /// Writes the deck as `folder`, with a batch script where it is asked for.
    pub fn finish(
        mut self,
        model: &Model,
        folder: &Path,
        options: &DeckOptions,
    ) -> Result<Deck, SolverError> {
        if options.queue_script {
            let text = Queue::render(model, options.ranks)?;
            self.files.push(File { name: "job.slurm".to_owned(), text, tables: Vec::new() });
        }
        write_folder(folder, &self.files)?;
        let files = self.files.into_iter().map(|file| file.name).collect();
        Ok(Deck { folder: folder.to_owned(), files, ranks: options.ranks, limits: self.limits })
    }
}

/// Writes `files` as `folder`: into a temporary folder beside it
/// first, which then takes its place.
fn write_folder(folder: &Path, files: &[File<'_>]) -> Result<(), SolverError> {
    let name = folder.file_name().ok_or_else(|| {
        SolverError::Options(format!("{} is not a folder that can be made", folder.display()))
    })?;
    let parent = match folder.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(parent).map_err(SolverError::io(parent))?;
    let label = format!(".{}.{}.part", name.to_string_lossy(), std::process::id());
    let temporary = parent.join(label);
    let written = fill(&temporary, files).and_then(|()| replace(folder, &temporary));
    if written.is_err() {
        // The first error is the one to tell; a leftover folder is hidden and named `.part`.
        let _ = fs::remove_dir_all(&temporary);
    }
    written
}

fn fill(folder: &Path, files: &[File<'_>]) -> Result<(), SolverError> {
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(SolverError::io(folder))?;
    }
    fs::create_dir(folder).map_err(SolverError::io(folder))?;
    for File { name, text, tables } in files {
        let path = folder.join(name);
        let file = fs::File::create(&path).map_err(SolverError::io(&path))?;
        let mut out = std::io::BufWriter::with_capacity(1 << 16, file);
        table::write(&mut out, text, tables)?;
        out.flush().map_err(SolverError::io(&path))?;
        if name.ends_with(".sh") {
            make_executable(&path)?;
        }
    }
    Ok(())
}

/// Puts `temporary` where `folder` is; refuses to remove a folder that is not a deck.
fn replace(folder: &Path, temporary: &Path) -> Result<(), SolverError> {
    if folder.exists() {
        let empty = fs::read_dir(folder).map_err(SolverError::io(folder))?.next().is_none();
        if !empty && !folder.join("run.sh").exists() {
            return Err(SolverError::Options(format!(
                "{} holds files but no run.sh: it is not a deck and is left alone",
                folder.display()
            )));
        }
        keep_strangers(folder, temporary)?;
        fs::remove_dir_all(folder).map_err(SolverError::io(folder))?;
    }
    fs::rename(temporary, folder).map_err(SolverError::io(folder))
}

/// Moves what somebody else put into the old deck to the new one; files of decks and what
/// solvers write stay behind.
fn keep_strangers(old: &Path, new: &Path) -> Result<(), SolverError> {
    for entry in fs::read_dir(old).map_err(SolverError::io(old))? {
        let name = entry.map_err(SolverError::io(old))?.file_name();
        let own = is_of_decks(&name.to_string_lossy());
        if !own && !new.join(&name).exists() {
            fs::rename(old.join(&name), new.join(&name)).map_err(SolverError::io(old))?;
        }
    }
    Ok(())
}

/// True for names of files that decks have, or that solvers write when they run one.
fn is_of_decks(name: &str) -> bool {
    let starts =
        ["in.", "run.", "job.slurm", "wall_", "springs.", "start.restart", "restart", "log."];
    let ends = [".dump", ".data", ".inf", ".in"];
    let tables = ["spheres", "clumps", "members", "arrivals", "bonds"].map(|t| format!("{t}.csv"));
    starts.iter().any(|start| name.starts_with(start))
        || ends.iter().any(|end| name.ends_with(end))
        || ["frames.txt", "contacts.txt", "breaks.txt"].contains(&name)
        || tables.iter().any(|table| table == name)
}

#[cfg(unix)]
fn make_executable(path: &Path) -> Result<(), SolverError> {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).map_err(SolverError::io(path))
}

#[cfg(not(unix))]
fn make_executable(_path: &Path) -> Result<(), SolverError> {
    Ok(())
}

#[cfg(test)]
pub mod examples;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deck_replaces_a_deck_and_nothing_else() {
        let room = tempfile::tempdir().expect("temporary folder");
        let folder = room.path().join("decks/liggghts");
        let file = |name: &str, text: &str| File {
            name: name.to_owned(),
            text: text.to_owned(),
            tables: Vec::new(),
        };
        let files = |text: &str| vec![file("run.sh", text)];
        write_folder(&folder, &files("one")).expect("written");
        write_folder(&folder, &files("two")).expect("replaced");
        assert_eq!(fs::read_to_string(folder.join("run.sh")).expect("there"), "two");
        fs::write(folder.join("notes.txt"), "mine").expect("written");
        fs::write(folder.join("spheres.dump"), "old").expect("written");
        write_folder(&folder, &files("three")).expect("replaced");
        assert_eq!(fs::read_to_string(folder.join("notes.txt")).expect("kept"), "mine");
        assert!(!folder.join("spheres.dump").exists(), "results of another deck go");
        let other = room.path().join("letters");
        fs::create_dir(&other).expect("made");
        fs::write(other.join("dear.txt"), "x").expect("written");
        assert!(write_folder(&other, &files("three")).is_err());
        assert!(other.join("dear.txt").exists());
        let left: Vec<_> = fs::read_dir(room.path()).expect("listed").collect();
        assert_eq!(left.len(), 2, "no temporary folder is left: {left:?}");
    }

    #[test]
    fn titles_stay_on_their_line() {
        assert_eq!(one_line("a\nprint 'x' &&"), "a print 'x' ");
    }

    #[test]
    fn processor_grids_must_fit() {
        let options = DeckOptions { ranks: 4, processors: Some([2, 1, 1]), queue_script: false };
        assert!(options.check().is_err());
        assert!(DeckOptions { ranks: 0, ..DeckOptions::default() }.check().is_err());
        assert!(DeckOptions::default().check().is_ok());
    }
}
