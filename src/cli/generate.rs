//! `riprap generate`: true shapes as STL.

use super::arguments::{Generate, SceneOnly};
use super::{Ending, Screen};
use crate::scene::road::Road;
use crate::shape::descriptors::Descriptors;
use serde_json::json;

pub fn generate(arguments: &Generate, screen: &Screen) -> Result<(), Ending> {
    let SceneOnly { scene, output } = &arguments.scene;
    let mut road = Road::open(scene, output.as_deref(), screen.job())?;
    if arguments.as_drawn {
        return as_drawn(&mut road, screen);
    }
    let described = road.solids()?.described;
    screen.remarks(&mut road);
    let rows: Vec<(&str, &Descriptors)> =
        described.iter().flatten().map(|known| (known.name.as_str(), &known.measures)).collect();
    let spheres = described.len() - rows.len();
    let mut text = String::new();
    if !rows.is_empty() {
        text.push_str(&format!(
            "{:24} {:>11} {:>10} {:>10} {:>10} {:>10}\n",
            "grain", "d_eq mm", "elong.", "flatn.", "convexity", "roundness"
        ));
    }
    for (name, d) in rows.iter().take(12) {
        text.push_str(&format!(
            "{name:24} {:>11.3} {:>10.3} {:>10.3} {:>10.3} {:>10.3}\n",
            d.volume_diameter * 1e3,
            d.elongation,
            d.flatness,
            d.convexity,
            d.roundness
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

fn as_drawn(road: &mut Road, screen: &Screen) -> Result<(), Ending> {
    let verdicts = road.as_drawn()?;
    let mut text = String::new();
    for v in verdicts.iter().take(24) {
        let said =
            v.fault.as_deref().map_or("a valid grain".to_owned(), |why| format!("no grain: {why}"));
        text.push_str(&format!("{:24} {said}\n", v.name));
        for fact in &v.facts {
            let asked = fact.asked.map_or("-".to_owned(), |asked| format!("{asked:.5}"));
            let (quantity, measured) = (&fact.quantity, fact.measured);
            text.push_str(&format!("    {quantity:44} asked {asked:>10}  is {measured:>10.5}\n"));
        }
    }
    let valid = verdicts.iter().filter(|v| v.fault.is_none()).count();
    text.push_str(&format!(
        "{valid} of {} are valid grains; all surfaces in {}\n",
        verdicts.len(),
        road.store.path("as-drawn").display()
    ));
    screen.result(&json!({ "output": road.store.root(), "drawn": verdicts }), &text)
}
