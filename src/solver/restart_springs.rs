//! Tangential springs that contacts have at the start of a run of LIGGGHTS or LAMMPS: their data files have none,
//! their restart files do.
//!
//! `run.sh` starts the solver twice. The first start sets everything up and writes `start.restart`;
//! `springs.py` (Python 3) writes the springs into its contacts, which have none yet; the second start goes on
//! from there. Neither moves anything before the run, and the set-up pass does not advance springs.

use crate::model::{Model, Partner, Spring, Wall};
use crate::solver::Limit;
use crate::solver::table::{Cell, Table};
use serde::Serialize;

/// What the solver of this name cannot be given, whose deck has some walls as primitive planes.
pub fn limits(model: &Model, name: &str, is_primitive: fn(&Wall) -> bool) -> Vec<Limit> {
    let needs = model.needs();
    if !needs.springs {
        return Vec::new();
    }
    let other = |what: &str| {
        Limit::refused(format!(
            "tangential springs at the start {what} (in {name}): use compare.start = \"final\" (springs begin at zero), or YADE where it takes them"
        ))
    };
    let at_plane = |spring: &Spring| match spring.other {
        Partner::Sphere(_) => true,
        Partner::Plane(wall) => is_primitive(&model.walls[usize::from(wall)]),
        Partner::Face { .. } => false,
    };
    let refused = [
        (
            needs.clumps,
            "of rigid clumps: after a restart fix rigid has their momenta anew from their spheres",
        ),
        (needs.discs, "of discs: not checked, so riprap writes no such deck"),
        (needs.periodic, "in a periodic box: not checked, so riprap writes no such deck"),
        (
            needs.rolling || needs.cohesion,
            "with cohesion or resistance to rolling, which keep histories of their own",
        ),
        (needs.arrivals || needs.restarts, "with grains inserted over time or restarts"),
        (
            !model.springs.iter().all(at_plane),
            "at meshes, oblique planes and planes that move along their normal: such contacts are known by numbers of the solver's own",
        ),
    ];
    refused.into_iter().filter(|(there, _)| *there).map(|(_, what)| other(what)).collect()
}

/// Values of `springs.py`.
#[derive(Debug, Serialize)]
pub struct Script {
    solver: &'static str,
    spheres: usize,
    planes: usize,
    own: usize,
    tail: usize,
    contacts_first: bool,
    plain_numbers: bool,
}

/// How a restart file keeps an atom.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// Name of the solver.
    pub solver: &'static str,
    /// Doubles of an atom itself.
    pub own: usize,
    /// Bytes after the atoms.
    pub tail: usize,
    /// Contacts with spheres come before those with walls.
    pub contacts_first: bool,
    /// Numbers of partners are doubles, not bits of whole numbers.
    pub plain_numbers: bool,
    /// Whether a wall is a primitive plane of the deck.
    pub is_primitive: fn(&Wall) -> bool,
}

impl Script {
    /// Reads a model.
    pub fn new(model: &Model, layout: Layout) -> Self {
        let Layout { solver, own, tail, contacts_first, plain_numbers, is_primitive } = layout;
        let planes = model.walls.iter().filter(|wall| is_primitive(wall)).count();
        Self {
            solver,
            spheres: model.spheres.len(),
            planes,
            own,
            tail,
            contacts_first,
            plain_numbers,
        }
    }
}

/// Springs: number of the atom, kind of its partner, the partner (atom, or plane as the deck counts them), stretch.
pub fn table(model: &Model, is_primitive: fn(&Wall) -> bool) -> Table<'_> {
    const COLUMNS: &[&str] = &["sphere", "kind", "other", "x", "y", "z"];
    Table::new("springs", COLUMNS, move |rows| {
        let plane = |wall: u16| {
            model.walls[..usize::from(wall)].iter().filter(|wall| is_primitive(wall)).count()
        };
        for spring in &model.springs {
            let (kind, other) = match spring.other {
                Partner::Sphere(other) => (0, other as usize + 1),
                Partner::Plane(wall) => (1, plane(wall)),
                // Refused by the limits.
                Partner::Face { .. } => continue,
            };
            let mut cells = [spring.sphere as usize + 1, kind, other, 0, 0, 0].map(Cell::from);
            for (cell, part) in cells[3..].iter_mut().zip(spring.stretch.iter()) {
                *cell = (*part).into();
            }
            rows.put(&cells)?;
        }
        Ok(())
    })
}
