//! `riprap list`: every method with its key, source and one line.

use super::arguments::{Kind, List};
use super::{Ending, Screen};
use crate::clump;
use crate::dem;
use crate::format;
use crate::num::entry::MethodEntry;
use crate::pack;
use crate::scene::{Scene, shipped};
use crate::shape;
use crate::solver;
use crate::study;
use serde::Serialize;
use serde_json::json;

/// One line of a list.
#[derive(Debug, Serialize)]
struct Line {
    kind: &'static str,
    key: String,
    id: String,
    summary: String,
    source: String,
    example: &'static str,
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
        Kind::Measures,
        Kind::Contacts,
        Kind::Solvers,
        Kind::Formats,
        Kind::Studies,
    ];
    let lines: Vec<Line> = match arguments.what {
        Some(kind) => lines(kind),
        None => all.into_iter().flat_map(lines).collect(),
    };
    let mut text = table(&lines);
    let mut value = json!({ "entries": lines });
    if arguments.what == Some(Kind::Solvers) {
        text.push_str(&format!("\n{}", solver::capability::text()));
        value["abilities"] = abilities();
    }
    screen.result(&value, &text)
}

/// What decks can say, feature by feature.
fn abilities() -> serde_json::Value {
    let row = |feature: &solver::capability::Feature| {
        let cells = solver::all().into_iter().zip(feature.abilities);
        let cells = cells.map(|(solver, ability)| {
            (solver.key().to_owned(), json!({ "ability": ability.word(), "note": ability.note() }))
        });
        json!({ "feature": feature.what, "solvers": cells.collect::<serde_json::Map<_, _>>() })
    };
    solver::capability::FEATURES.iter().map(row).collect()
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
                example: "",
            })
            .collect(),
        Kind::Shapes => entries("shape", shape::METHODS),
        Kind::Clumps => entries("clump", clump::METHODS),
        Kind::Packings => entries("packing", &[pack::METHODS, pack::OPTIONS].concat()),
        Kind::Measures => entries("measure", pack::survey::METHODS),
        Kind::Contacts => entries("contact", dem::METHODS),
        Kind::Solvers => solver::all()
            .into_iter()
            .map(|solver| {
                let name = solver.name();
                let summary = match solver.find() {
                    Some(found) => {
                        format!("{name}: {} at {}", found.version, found.program.display())
                    }
                    None => format!("{name} {}", solver.absence()),
                };
                Line {
                    kind: "solver",
                    key: solver.key().to_owned(),
                    id: String::new(),
                    summary,
                    source: String::new(),
                    example: "",
                }
            })
            .collect(),
        Kind::Studies => study::STUDIES
            .iter()
            .map(|study| Line {
                kind: "study",
                key: study.key.to_owned(),
                id: String::new(),
                summary: study.summary.to_owned(),
                source: String::new(),
                example: "",
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
                example: "",
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
            example: entry.example,
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
            let plural = line
                .kind
                .strip_suffix('y')
                .map_or(format!("{}s", line.kind), |stem| format!("{stem}ies"));
            text.push_str(&format!("{plural}\n"));
            last = line.kind;
        }
        let id = if line.id.is_empty() { String::new() } else { format!("[{}] ", line.id) };
        text.push_str(&format!("  {:width$}  {id}{}\n", line.key, line.summary));
        if !line.source.is_empty() {
            text.push_str(&format!("  {:width$}  {}\n", "", line.source));
        }
        if !line.example.is_empty() {
            text.push_str(&format!("  {:width$}  {}\n", "", line.example));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Loaded;
    use std::path::Path;

    /// A scene with the line `example` in its place.
    fn scene_with(example: &str) -> String {
        let or = |start: &str, usual: &str| {
            if example.starts_with(start) { example.to_owned() } else { usual.to_owned() }
        };
        let cluster = example.starts_with("cluster");
        let clump = if cluster || example.contains("sphere\"") || example.starts_with("clump") {
            ""
        } else {
            "clump.normals = {}"
        };
        format!(
            "title = \"x\"\n{}\n{}\n{}\n[[grains]]\nname = \"ball\"\ncount = 2\n{}\n{}\n{}\n{clump}\n\
             [materials.glass]\ndensity = 2500.0\n\
             [plan]\nduration = 1.0\n{}\n",
            or("packing", "packing.random = {}"),
            or("container", "container.shape.box = { size = [1, 1, 1] }"),
            or("contact", "contact = { kn = 1000.0 }"),
            or("size", "size = 0.01"),
            or("shape", if cluster { "shape = \"sphere\"" } else { "shape.union = {}" }),
            if ["clump", "body", "cluster", "insert"].iter().any(|key| example.starts_with(key)) {
                example
            } else {
                ""
            },
            if example.starts_with("plan") { &example["plan.".len()..] } else { "" },
        )
    }

    #[test]
    fn every_method_has_an_example_that_a_scene_takes() {
        for line in
            [Kind::Shapes, Kind::Clumps, Kind::Packings, Kind::Contacts].map(lines).iter().flatten()
        {
            // What every run does is not asked for.
            if line.summary.starts_with("always") {
                continue;
            }
            assert!(!line.example.is_empty(), "{line:?}");
            assert!(line.example.contains(&line.key) || line.key == "linear", "{line:?}");
            let text = scene_with(line.example);
            let read = Loaded::parse(Path::new("example.toml"), text);
            assert!(
                read.is_ok(),
                "{line:?}\n{}",
                read.err().map(|e| e.to_string()).unwrap_or_default()
            );
        }
    }

    #[test]
    fn every_system_of_the_sources_is_listed() {
        let kinds =
            [Kind::Shapes, Kind::Clumps, Kind::Packings, Kind::Measures, Kind::Contacts].map(lines);
        let listed = |id: &str| {
            kinds.iter().flatten().flat_map(|line| line.id.split(", ")).any(|part| part == id)
        };
        for (letter, last) in [('D', 11), ('G', 12), ('R', 5), ('P', 18)] {
            for number in 1..=last {
                let id = format!("{letter}{number}");
                assert!(listed(&id), "{id}");
            }
        }
    }
}
