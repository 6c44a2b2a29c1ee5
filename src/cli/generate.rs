//! `riprap generate`: true shapes as STL.

use super::arguments::SceneOnly;
use super::{Ending, Screen};
use crate::geometry::GeometryError;
use crate::scene::road::Road;
use crate::shape::descriptors::{Descriptors, describe};
use serde_json::json;

pub fn generate(arguments: &SceneOnly, screen: &Screen) -> Result<(), Ending> {
    let mut road = Road::open(&arguments.scene, arguments.output.as_deref(), screen.job())?;
    let solids = road.solids()?.solids;
    screen.remarks(&mut road);
    let rows: Vec<(String, Descriptors)> = solids
        .iter()
        .flatten()
        .map(|solid| Ok((solid.name.clone(), describe(&solid.mesh)?)))
        .collect::<Result<_, GeometryError>>()?;
    let spheres = solids.len() - rows.len();
    let mut text = String::new();
    if !rows.is_empty() {
        text.push_str(&format!(
            "{:24} {:>11} {:>10} {:>10} {:>10}\n",
            "grain", "d_eq mm", "elong.", "flatn.", "convexity"
        ));
    }
    for (name, d) in rows.iter().take(12) {
        text.push_str(&format!(
            "{name:24} {:>11.3} {:>10.3} {:>10.3} {:>10.3}\n",
            d.volume_diameter * 1e3,
            d.elongation,
            d.flatness,
            d.convexity
        ));
    }
    if rows.len() > 12 {
        text.push_str(&format!(
            "… {} more in {}\n",
            rows.len() - 12,
            road.store.path("shapes/shapes.csv").display()
        ));
    }
    if spheres > 0 {
        text.push_str(&format!("{spheres} distinct spheres or discs need no surface\n"));
    }
    text.push_str(&format!(
        "{} closed surfaces in {}\n",
        rows.len(),
        road.store.path("shapes").display()
    ));
    screen
        .result(&json!({ "output": road.store.root(), "shapes": rows, "spheres": spheres }), &text)
}
