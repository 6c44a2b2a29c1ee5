//! `riprap measure`: descriptors of meshes, clumps, packings and states.

use super::arguments::Measure;
use super::{Ending, Screen};
use crate::geometry::Bounds;
use crate::num::Vec3;
use crate::report::findings::Findings;
use crate::scene::measuring;
use crate::scene::surveying::{self, Survey};
use serde::Serialize;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

pub fn measure(arguments: &Measure, screen: &Screen) -> Result<(), Ending> {
    if let Some(wanted) = wanted(arguments)? {
        return survey(arguments, &wanted, screen);
    }
    let mut rows = Vec::new();
    let mut text = String::new();
    for path in &arguments.files {
        if let Some(mesh) = &arguments.against {
            let (value, lines) = described(path, &measuring::against(path, mesh)?)?;
            rows.push(value);
            text.push_str(&lines);
            continue;
        }
        let (measured, repairs) = measuring::measure(path)?;
        if let Some(repairs) = repairs {
            screen.warn(&format!("{}: {repairs}", path.display()));
        }
        let (value, lines) = described(path, &measured)?;
        rows.push(value);
        text.push_str(&lines);
    }
    screen.result(&json!({ "files": rows }), &text)
}

/// A row as JSON and as `name value` lines.
fn described(path: &Path, measures: &impl Serialize) -> Result<(Value, String), Ending> {
    let value = serde_json::to_value(measures).map_err(|error| Ending::Work(error.to_string()))?;
    let mut text = format!("{}\n", path.display());
    for (name, value) in value.as_object().into_iter().flatten() {
        text.push_str(&format!("  {:24} {value}\n", name.replace('_', " ")));
    }
    Ok((json!({ "file": path, "measures": value }), text))
}

/// What is asked of spheres beyond the plain measures; `None` for nothing.
fn wanted(arguments: &Measure) -> Result<Option<Survey>, Ending> {
    let asked = !arguments.at.is_empty()
        || arguments.layers.is_some()
        || arguments.field.is_some()
        || arguments.room.is_some()
        || arguments.periodic.is_some()
        || arguments.discs
        || arguments.gap.is_some()
        || arguments.contacts.is_some()
        || arguments.stiffness.is_some()
        || arguments.output.is_some();
    if !asked {
        return Ok(None);
    }
    let wrong = |problem: &str| Err(Ending::Input(problem.to_owned()));
    let radii = &arguments.radius;
    if radii.len() != 1 && radii.len() != arguments.at.len() {
        return wrong("give one --radius for all --at, or one for each");
    }
    let lengths = radii.iter().chain(&arguments.field).chain(&arguments.stiffness);
    if lengths.into_iter().any(|x| !(x.is_finite() && *x > 0.0)) {
        return wrong("--radius, --field and --stiffness must be greater than 0");
    }
    if arguments.gap.is_some_and(|gap| !(gap.is_finite() && gap >= 0.0)) {
        return wrong("--gap must be 0 or more");
    }
    let room = arguments
        .room
        .map(|[a, b, c, d, e, f]| Bounds { low: Vec3::new(a, b, c), high: Vec3::new(d, e, f) });
    let dimension = if arguments.discs { 2 } else { 3 };
    if room.is_some_and(|room| (0..dimension).any(|axis| room.low[axis] >= room.high[axis])) {
        return wrong("--box needs low corners below high ones");
    }
    let mut periodic = [false; 3];
    for axis in arguments.periodic.iter().flat_map(|axes| axes.chars()) {
        match "xyz".find(axis) {
            Some(index) if index < dimension => periodic[index] = true,
            _ => return wrong("--periodic takes axes out of x, y, z (x, y for --discs)"),
        }
    }
    if periodic.contains(&true) && room.is_none() {
        return wrong("--periodic needs the container: --box");
    }
    let probe = |(index, at): (usize, &[f64; 3])| {
        let radius = if radii.len() == 1 { radii[0] } else { radii[index] };
        (Vec3::from(*at), radius)
    };
    Ok(Some(Survey {
        probes: arguments.at.iter().enumerate().map(probe).collect(),
        dimension,
        room,
        periodic,
        gap: arguments.gap,
        contacts: arguments.contacts.clone(),
        stiffness: arguments.stiffness,
        layers: usize::from(arguments.layers.unwrap_or(20)),
        field: arguments.field,
    }))
}

/// A folder for each of several files: its name without extension, numbered where others have it too.
fn folders(files: &[PathBuf]) -> Vec<String> {
    let mut taken: Vec<String> = Vec::new();
    for path in files {
        let stem = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let free = |name: &String| !taken.contains(name);
        let numbered = (2..).map(|number| format!("{stem}-{number}"));
        // Numbers go on until one is free.
        let name = std::iter::once(stem.clone()).chain(numbered).find(free).unwrap_or(stem);
        taken.push(name);
    }
    taken
}

/// Rows of a table that a terminal still shows.
const SHOWN: usize = 40;

/// Measuring spheres, layers, radial distribution of each file.
fn survey(arguments: &Measure, wanted: &Survey, screen: &Screen) -> Result<(), Ending> {
    let (mut values, mut text) = (Vec::new(), String::new());
    let folders = folders(&arguments.files);
    for (path, own) in arguments.files.iter().zip(&folders) {
        let found = surveying::survey(path, wanted)?;
        let mut files = Vec::new();
        if let Some(folder) = &arguments.output {
            let folder = if folders.len() > 1 { folder.join(own) } else { folder.clone() };
            files = found.write(&folder, &format!("riprap measure {}", path.display()))?;
            screen.say(&format!("wrote {} files into {}", files.len(), folder.display()));
        }
        values.push(json!({ "file": path, "found": found.json(), "files": files }));
        let short = found.tables.iter().filter(|sheet| sheet.rows.len() <= SHOWN).cloned();
        text.push_str(&Findings { tables: short.collect(), ..found.clone() }.text());
    }
    screen.result(&json!({ "files": values }), &text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_one_name_get_folders_of_their_own() {
        let files = ["a/final.csv", "b/final.csv", "final-2.csv", "c.csv"].map(PathBuf::from);
        assert_eq!(folders(&files), ["final", "final-2", "final-2-2", "c"]);
    }
}
