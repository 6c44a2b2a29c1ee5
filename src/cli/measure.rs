//! `riprap measure`: descriptors of meshes, clumps, packings and states.

use super::arguments::Measure;
use super::{Ending, Screen};
use crate::scene::measuring;
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;

pub fn measure(arguments: &Measure, screen: &Screen) -> Result<(), Ending> {
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
