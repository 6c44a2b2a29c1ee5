//! `riprap list`: every method with its key, source and one line.

use super::arguments::{Kind, List};
use super::{Ending, Screen};
use crate::num::entry::MethodEntry;
use crate::scene::{Scene, shipped};
use crate::{clump, dem, format, pack, shape, solver};
use serde::Serialize;

/// One line of a list.
#[derive(Debug, Serialize)]
struct Line {
    kind: &'static str,
    key: String,
    id: String,
    summary: String,
    source: String,
}

pub fn list(arguments: &List, screen: &Screen) -> Result<(), Ending> {
    if arguments.schema {
        let schema = schemars::schema_for!(Scene);
        let text = serde_json::to_string_pretty(&schema)
            .map_err(|error| Ending::Work(error.to_string()))?;
        return screen.raw(format!("{text}\n").as_bytes());
    }
    let all = [
        Kind::Scenes,
        Kind::Shapes,
        Kind::Clumps,
        Kind::Packings,
        Kind::Contacts,
        Kind::Solvers,
        Kind::Formats,
    ];
    let lines: Vec<Line> = match arguments.what {
        Some(kind) => lines(kind),
        None => all.into_iter().flat_map(lines).collect(),
    };
    screen.result(&lines, &table(&lines))
}

fn lines(kind: Kind) -> Vec<Line> {
    match kind {
        Kind::Scenes => shipped::SCENES
            .iter()
            .map(|scene| Line {
                kind: "scene",
                key: scene.name.to_owned(),
                id: String::new(),
                summary: scene.summary.to_owned(),
                source: String::new(),
            })
            .collect(),
        Kind::Shapes => entries("shape", shape::METHODS),
        Kind::Clumps => entries("clump", clump::METHODS),
        Kind::Packings => entries("packing", pack::METHODS),
        Kind::Contacts => entries("contact", dem::METHODS),
        Kind::Solvers => solver::all()
            .into_iter()
            .map(|solver| {
                let found = match solver.find() {
                    Some(found) => format!("{} at {}", found.version, found.program.display()),
                    None => format!("not installed; {}", solver.how_to_install()),
                };
                Line {
                    kind: "solver",
                    key: solver.key().to_owned(),
                    id: String::new(),
                    summary: format!("{}: {found}", solver.name()),
                    source: String::new(),
                }
            })
            .collect(),
        Kind::Formats => format::FORMATS
            .iter()
            .map(|format| Line {
                kind: "format",
                key: format.extensions.join(", "),
                id: String::new(),
                summary: format.about.to_owned(),
                source: String::new(),
            })
            .collect(),
    }
}

fn entries(kind: &'static str, methods: &[MethodEntry]) -> Vec<Line> {
    methods
        .iter()
        .map(|entry| Line {
            kind,
            key: entry.key.to_owned(),
            id: entry.id.to_owned(),
            summary: entry.summary.to_owned(),
            source: entry.source.to_owned(),
        })
        .collect()
}

fn table(lines: &[Line]) -> String {
    let mut text = String::new();
    let mut last = "";
    let width = lines.iter().map(|line| line.key.chars().count()).max().unwrap_or(0);
    for line in lines {
        if line.kind != last {
            if !last.is_empty() {
                text.push('\n');
            }
            text.push_str(&format!("{}s\n", line.kind));
            last = line.kind;
        }
        let id = if line.id.is_empty() { String::new() } else { format!("[{}] ", line.id) };
        text.push_str(&format!("  {:width$}  {id}{}\n", line.key, line.summary));
        if !line.source.is_empty() {
            text.push_str(&format!("  {:width$}  {}\n", "", line.source));
        }
    }
    text
}
