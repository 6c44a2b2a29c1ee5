//! The cases of a sweep, each as a scene of its own.
//!
//! Order: the replicate counts fastest, then the samples, the rows of the list,
//! and the keys of the grid from the last to the first. O(cases × keys).

use super::file::{Hypercube, Scale};
use super::{Sweep, SweepError};
use crate::num::Fault;
use crate::num::random::{RngExt, stream};
use crate::scene::file::{read_text, wrong};
use crate::scene::{Loaded, SceneError};
use std::path::{Component, Path, PathBuf};

/// One case.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// `0001`, …: as many digits as the last one needs, at least 4.
    pub name: String,
    /// Keys with the values that this case sets.
    pub values: Vec<(String, toml::Value)>,
    /// The scene file of the case.
    pub text: String,
}

impl Case {
    /// `key = value, …` for messages.
    pub fn describe(&self) -> String {
        let parts: Vec<String> =
            self.values.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        parts.join(", ")
    }
}

/// All cases of the sweep in the file `path`, for folders below `out`; every scene is valid.
///
/// # Errors
/// A scene that cannot be read; a case whose scene is wrong.
pub fn cases(sweep: &Sweep, path: &Path, out: &Path) -> Result<Vec<Case>, SweepError> {
    let scene = path.parent().unwrap_or(Path::new(".")).join(&sweep.scene);
    let text = read_text(&scene)?;
    // The scene by itself must be right, so that messages point at its own lines.
    let loaded = Loaded::parse(&scene, text.clone())?;
    let table: toml::Table = crate::scene::file::deserialize(&scene, &text)?;
    let combined = combinations(sweep, loaded.scene.seed);
    let digits = combined.len().to_string().len().max(4);
    let mut cases = Vec::with_capacity(combined.len());
    for (index, values) in combined.into_iter().enumerate() {
        let name = format!("{:0digits$}", index + 1);
        let mut case = Case { name, values, text: String::new() };
        let folder = out.join("cases").join(&case.name);
        let of = |case: &Case, error: SceneError| SweepError::Case {
            case: case.name.clone(),
            values: case.describe(),
            error,
        };
        case.text = scene_text(&table, &case, loaded.base(), &folder)
            .map_err(|fault| of(&case, wrong(&scene, &text, &[fault])))?;
        Loaded::parse(&folder.join("scene.toml"), case.text.clone())
            .map_err(|error| of(&case, error))?;
        cases.push(case);
    }
    Ok(cases)
}

type Values = Vec<(String, toml::Value)>;

/// What each case sets.
fn combinations(sweep: &Sweep, seed: u64) -> Vec<Values> {
    let mut all: Vec<Values> = vec![Vec::new()];
    let mut times = |choices: Vec<Values>| {
        all = all
            .iter()
            .flat_map(|head| choices.iter().map(move |tail| [&head[..], &tail[..]].concat()))
            .collect();
    };
    for (key, values) in &sweep.grid {
        times(values.iter().map(|value| vec![(key.clone(), value.clone())]).collect());
    }
    if !sweep.list.is_empty() {
        let row = |row: &std::collections::BTreeMap<String, toml::Value>| {
            row.iter().map(|(key, value)| (key.clone(), value.clone())).collect()
        };
        times(sweep.list.iter().map(row).collect());
    }
    if let Some(cube) = &sweep.latin_hypercube {
        times(samples(cube));
    }
    if sweep.replicates > 1 {
        let seeds = 0..u64::from(sweep.replicates);
        // TOML has no whole numbers above 2^63 − 1; seeds up there go on from 0.
        let value =
            |add: u64| toml::Value::Integer((seed.wrapping_add(add) & (u64::MAX >> 1)) as i64);
        times(seeds.map(|add| vec![("seed".to_owned(), value(add))]).collect());
    }
    all
}

/// Samples of a Latin hypercube: each key has one value in each of `samples` equal parts of its range.
fn samples(cube: &Hypercube) -> Vec<Values> {
    let count = cube.samples as usize;
    let mut rows: Vec<Values> = vec![Vec::new(); count];
    for (key, range) in &cube.keys {
        let mut source = stream(cube.seed, &format!("latin hypercube {key}"), 0);
        let mut parts: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            parts.swap(last, source.random_range(0..=last));
        }
        // Ranges are validated when the file is read.
        let (low, high, unit) = range.ends().unwrap_or((0.0, 0.0, String::new()));
        for (row, part) in rows.iter_mut().zip(parts) {
            let fraction = (part as f64 + source.random::<f64>()) / count as f64;
            let mut value = match range.scale {
                Scale::Linear => low + (high - low) * fraction,
                Scale::Log => low * (high / low).powf(fraction),
            };
            if range.whole {
                value = value.round();
            }
            row.push((key.clone(), with_unit(value, &unit, range.whole)));
        }
    }
    rows
}

fn with_unit(value: f64, unit: &str, whole: bool) -> toml::Value {
    match (unit.is_empty(), whole) {
        (true, true) => toml::Value::Integer(value as i64),
        (true, false) => toml::Value::Float(value),
        (false, _) => toml::Value::String(format!("{value} {unit}")),
    }
}

/// The scene file of a case that lies in `folder`.
fn scene_text(
    table: &toml::Table,
    case: &Case,
    base: &Path,
    folder: &Path,
) -> Result<String, Fault> {
    let mut scene = toml::Value::Table(table.clone());
    for (key, value) in &case.values {
        set(&mut scene, key, value.clone())?;
    }
    let prefix = way(folder, base);
    move_files(&mut scene, &prefix);
    toml::to_string(&scene)
        .map_err(|error| Fault::new("", format!("cannot be written: {error}"), "another value"))
}

/// Sets `key` (`contact.friction`, `grains[0].size`) in `scene`; tables on the way are made if missing.
fn set(scene: &mut toml::Value, key: &str, value: toml::Value) -> Result<(), Fault> {
    let dotted = key.replace('[', ".[");
    let mut place = scene;
    for part in dotted.split('.').filter(|part| !part.is_empty()) {
        let wrong = |what: &str| {
            let problem = format!("has no `{part}` on the way to the key `{key}` of the sweep");
            Fault::new("", problem, what.to_owned())
        };
        place = match part.strip_prefix('[').and_then(|index| index.strip_suffix(']')) {
            Some(index) => {
                let index: usize =
                    index.parse().map_err(|_| wrong("a whole number in brackets"))?;
                let items = place.as_array_mut().ok_or_else(|| wrong("an array there"))?;
                items.get_mut(index).ok_or_else(|| wrong("an index within the array"))?
            }
            None => place
                .as_table_mut()
                .ok_or_else(|| wrong("a table there"))?
                .entry(part)
                .or_insert_with(|| toml::Value::Table(toml::Table::new())),
        };
    }
    *place = value;
    Ok(())
}

/// Puts `prefix` before every relative file name: the values of `file`, `paths` and `folder`.
fn move_files(value: &mut toml::Value, prefix: &Path) {
    match value {
        toml::Value::Table(table) => {
            for (key, inner) in table.iter_mut() {
                if ["file", "paths", "folder"].contains(&key.as_str()) {
                    prefixed(inner, prefix);
                } else {
                    move_files(inner, prefix);
                }
            }
        }
        toml::Value::Array(items) => items.iter_mut().for_each(|item| move_files(item, prefix)),
        _ => {}
    }
}

fn prefixed(value: &mut toml::Value, prefix: &Path) {
    match value {
        toml::Value::String(name) => *name = prefix.join(&*name).to_string_lossy().into_owned(),
        toml::Value::Array(items) => items.iter_mut().for_each(|item| prefixed(item, prefix)),
        _ => {}
    }
}

/// The way from folder `from` to folder `to`, which need not exist; absolute if there is no relative one.
fn way(from: &Path, to: &Path) -> PathBuf {
    // The folder of a bare file name is the empty path.
    let absolute = |path: &Path| {
        std::path::absolute(Path::new(".").join(path)).unwrap_or_else(|_| path.to_owned())
    };
    let (from, to) = (absolute(from), absolute(to));
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let steps_up = from.components().skip(shared);
    if steps_up.clone().any(|part| part == Component::ParentDir) {
        return to;
    }
    let up = steps_up.map(|_| Component::ParentDir);
    up.chain(to.components().skip(shared)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(text: &str) -> Sweep {
        toml::from_str(&format!("scene = \"s.toml\"\n{text}")).expect("a sweep")
    }

    #[test]
    fn grids_lists_and_replicates_multiply() {
        let text = "replicates = 2\n[grid]\na = [1, 2, 3]\nb = [\"x\", \"y\"]\n[[list]]\nc = 1\nd = 2\n[[list]]\nc = 3\n";
        let sweep = sweep(text);
        let all = combinations(&sweep, 7);
        assert_eq!((all.len(), sweep.count()), (24, 24));
        let mut distinct: Vec<String> = all.iter().map(|values| format!("{values:?}")).collect();
        distinct.sort();
        distinct.dedup();
        assert_eq!(distinct.len(), 24);
        assert_eq!(all[0].last(), Some(&("seed".to_owned(), toml::Value::Integer(7))));
    }

    #[test]
    fn a_hypercube_has_one_value_in_each_part() {
        let text = "[latin_hypercube]\nsamples = 50\nkeys.x = { min = 2, max = 4 }\nkeys.y = { min = \"1 kN/m\", max = \"100 kN/m\", scale = \"log\" }\nkeys.n = { min = 1, max = 50, whole = true }\n";
        let rows = combinations(&sweep(text), 0);
        let mut parts: Vec<usize> = rows
            .iter()
            .map(|row| ((row[1].1.as_float().expect("a number") - 2.0) / 2.0 * 50.0) as usize)
            .collect();
        parts.sort_unstable();
        assert_eq!(parts, (0..50).collect::<Vec<_>>());
        for row in &rows {
            let stiffness = row[2].1.as_str().expect("a text with a unit");
            let number: f64 = stiffness.trim_end_matches(" kN/m").parse().expect("a number");
            assert!((1.0..=100.0).contains(&number));
            assert!(row[0].1.as_integer().is_some_and(|n| (1..=50).contains(&n)));
        }
        assert_eq!(rows, combinations(&sweep(text), 0));
    }

    #[test]
    fn keys_reach_into_arrays_and_files_keep_their_place() {
        let mut scene: toml::Value = toml::from_str::<toml::Table>(
            "[[grains]]\nsize = 1\n[grains.shape.files]\nfolder = \"rocks\"\n",
        )
        .expect("a table")
        .into();
        set(&mut scene, "grains[0].size", toml::Value::Integer(5)).expect("there");
        set(&mut scene, "contact.friction", toml::Value::Float(0.5)).expect("made");
        assert!(set(&mut scene, "grains[1].size", toml::Value::Integer(5)).is_err());
        assert!(set(&mut scene, "grains[0].size.min", toml::Value::Integer(5)).is_err());
        move_files(&mut scene, &way(Path::new("out/cases/0001"), Path::new("")));
        let folder = scene["grains"][0]["shape"]["files"]["folder"].as_str();
        assert_eq!(folder, Some("../../../rocks"));
        assert_eq!(scene["contact"]["friction"].as_float(), Some(0.5));
    }
}
