//! The sweep file: which scene, what to do with it, which keys to vary and how.
//!
//! ```toml
//! scene = "scene.toml"
//! stage = "run"
//! replicates = 2
//!
//! [grid]
//! "contact.friction" = [0.2, 0.4, 0.6]
//!
//! [[list]]
//! "grains[0].size" = "4 mm"
//! "grains[0].count" = 400
//!
//! [latin_hypercube]
//! samples = 20
//! keys."contact.restitution" = { min = 0.3, max = 0.9 }
//! keys."contact.kn" = { min = "1 kN/m", max = "100 kN/m", scale = "log" }
//! ```
//! Cases: every combination of the grid × every row of the list × every sample ×
//! every replicate. McKay, Beckman & Conover 1979 for the hypercube.

use crate::num::Fault;
use crate::scene::SceneError;
use crate::scene::file::{deserialize, read_text, wrong};
use crate::solver;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Most cases of one sweep.
pub const MOST: usize = 100_000;

/// A sweep file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Scene file, relative to the sweep file.
    pub scene: PathBuf,
    /// What is done with every case. Default `run`.
    #[serde(default)]
    pub stage: Stage,
    /// Solvers for the stages `export` and `compare`. Default: all.
    #[serde(default)]
    pub solvers: Vec<String>,
    /// Each case with so many seeds, counted up from that of the scene. Default 1.
    #[serde(default = "one")]
    pub replicates: u32,
    /// Keys of the scene with the values each of them takes: all combinations.
    #[serde(default)]
    pub grid: BTreeMap<String, Vec<toml::Value>>,
    /// Rows of keys with their values, set together.
    #[serde(default)]
    pub list: Vec<BTreeMap<String, toml::Value>>,
    /// Samples that cover the ranges of several keys evenly.
    #[serde(default)]
    pub latin_hypercube: Option<Hypercube>,
}

/// A Latin hypercube.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hypercube {
    /// Number of samples, at least 1.
    pub samples: u32,
    /// Seed of the hypercube. Default 0.
    #[serde(default)]
    pub seed: u64,
    /// Keys of the scene with their ranges.
    pub keys: BTreeMap<String, Range>,
}

/// Range of one key.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// Least value: a number, or a text with a unit.
    pub min: toml::Value,
    /// Largest value, in the same unit.
    pub max: toml::Value,
    /// Even in the value or in its logarithm. Default linear.
    #[serde(default)]
    pub scale: Scale,
    /// Whole numbers only. Default false.
    #[serde(default)]
    pub whole: bool,
}

/// How samples are spread over a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// Evenly in the logarithm.
    Log,
}

/// What is done with a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Shapes as STL.
    Generate,
    /// Clumps.
    Reproduce,
    /// The packing.
    Pack,
    /// Decks.
    Export,
    /// Our own DEM.
    #[default]
    Run,
    /// Our own DEM and the outside solvers.
    Compare,
}

impl Stage {
    /// The verb of the command line that does it.
    pub fn verb(self) -> &'static str {
        match self {
            Self::Generate => "generate",
            Self::Reproduce => "reproduce",
            Self::Pack => "pack",
            Self::Export => "export",
            Self::Run => "run",
            Self::Compare => "compare",
        }
    }
}

fn one() -> u32 {
    1
}

impl Range {
    /// Both ends as numbers in one unit, and that unit.
    ///
    /// # Errors
    /// Ends that are no numbers, units that differ, an empty range.
    pub fn ends(&self) -> Result<(f64, f64, String), Fault> {
        let (low, unit) = quantity(&self.min, "min")?;
        let (high, other) = quantity(&self.max, "max")?;
        if unit != other {
            let problem = format!("has the unit \"{other}\"");
            return Err(Fault::new("max", problem, format!("the unit of min, \"{unit}\"")));
        }
        if high < low {
            return Err(Fault::new("max", format!("is {high}, less than min"), "at least min"));
        }
        if self.scale == Scale::Log && low <= 0.0 {
            let allowed = "greater than 0 on a logarithmic scale";
            return Err(Fault::new("min", format!("is {low}"), allowed));
        }
        Ok((low, high, unit))
    }
}

/// Number and unit (empty for plain numbers) of a value.
fn quantity(value: &toml::Value, key: &str) -> Result<(f64, String), Fault> {
    let wrong = || {
        let allowed = "a number, or a text with a number and a unit such as \"2 mm\"";
        Fault::new(key, format!("is {value}"), allowed)
    };
    let (number, unit) = match value {
        toml::Value::Integer(number) => (*number as f64, String::new()),
        toml::Value::Float(number) => (*number, String::new()),
        toml::Value::String(text) => {
            let text = text.trim();
            let end = text.find(char::is_whitespace).unwrap_or(text.len());
            let (number, unit) = text.split_at(end);
            (number.parse().map_err(|_| wrong())?, unit.trim().to_owned())
        }
        _ => return Err(wrong()),
    };
    if number.is_finite() { Ok((number, unit)) } else { Err(wrong()) }
}

impl Sweep {
    /// Reads and validates the sweep file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read; every fault found, with its place.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let text = read_text(path)?;
        let sweep: Self = deserialize(path, &text)?;
        match sweep.faults() {
            faults if faults.is_empty() => Ok(sweep),
            faults => Err(wrong(path, &text, &faults)),
        }
    }

    /// Number of cases, capped at [`MOST`] + 1.
    pub fn count(&self) -> usize {
        let samples = self.latin_hypercube.as_ref().map_or(1, |cube| cube.samples as usize);
        let parts = self.grid.values().map(Vec::len).chain([
            self.list.len().max(1),
            samples,
            self.replicates as usize,
        ]);
        parts.fold(1, |product: usize, part| product.saturating_mul(part)).min(MOST + 1)
    }

    fn faults(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        let fault = |key: &str, problem: &str, allowed: &str| Fault::new(key, problem, allowed);
        if self.grid.is_empty() && self.list.is_empty() && self.latin_hypercube.is_none() {
            let allowed = "a [grid], a [[list]] or a [latin_hypercube]; or replicates above 1";
            if self.replicates < 2 {
                faults.push(fault("", "varies nothing", allowed));
            }
        }
        if self.replicates == 0 {
            faults.push(fault("replicates", "is 0", "at least 1"));
        }
        if self.grid.values().any(Vec::is_empty) {
            faults.push(fault("grid", "has a key without values", "at least one value a key"));
        }
        if self.list.iter().any(BTreeMap::is_empty) {
            faults.push(fault("list", "has an empty row", "at least one key a row"));
        }
        if let Some(cube) = &self.latin_hypercube {
            if cube.samples == 0 {
                faults.push(fault("latin_hypercube.samples", "is 0", "at least 1"));
            }
            for range in cube.keys.values() {
                faults.extend(range.ends().err().map(|f| f.under("latin_hypercube.keys")));
            }
            if cube.keys.is_empty() {
                faults.push(fault("latin_hypercube.keys", "is empty", "at least one key"));
            }
        }
        let mut seen = std::collections::BTreeSet::new();
        for key in self.keys() {
            if !seen.insert(key.clone()) {
                let problem = format!("varies {key} twice");
                faults.push(Fault::new("", problem, "each key in one of grid, list, hypercube"));
            }
        }
        if self.replicates > 1 && seen.contains("seed") {
            faults.push(fault("replicates", "changes the seed, as a key does", "one of the two"));
        }
        if self.count() > MOST {
            faults.push(Fault::new("", format!("has more than {MOST} cases"), "fewer"));
        }
        let known: Vec<&str> = solver::all().iter().map(|solver| solver.key()).collect();
        for (index, key) in self.solvers.iter().enumerate() {
            if !known.contains(&key.as_str()) {
                let problem = format!("is \"{key}\"");
                let allowed = format!("one of {}", known.join(", "));
                faults.push(Fault::new(format!("solvers[{index}]"), problem, allowed));
            }
        }
        faults
    }

    /// Keys that are varied: of the grid, of the list (each once), of the hypercube.
    pub fn keys(&self) -> Vec<String> {
        let mut listed: Vec<String> = self.list.iter().flat_map(BTreeMap::keys).cloned().collect();
        listed.sort();
        listed.dedup();
        let cube = self.latin_hypercube.iter().flat_map(|cube| cube.keys.keys().cloned());
        self.grid.keys().cloned().chain(listed).chain(cube).collect()
    }
}
