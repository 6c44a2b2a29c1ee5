//! `riprap pack`: where each grain goes.

use super::arguments::SceneOnly;
use super::{Ending, Screen};
use crate::scene::road::Road;
use serde_json::json;

pub fn pack(arguments: &SceneOnly, screen: &Screen) -> Result<(), Ending> {
    let mut road = Road::open(&arguments.scene, arguments.output.as_deref(), screen.job())?;
    let packed = road.packed()?;
    screen.remarks(&mut road);
    let packing = &packed.packing;
    let m = &packing.measures;
    let gap = m.least_gap.map_or("no two near each other".to_owned(), |gap| format!("{gap:.3e} m"));
    let text = format!(
        "{}\nplaced {} of {}; porosity {:.4} ± {:.1e}; coordination {:.2} (gap ≤ {:.1e} m); \
         worst overlap {:.2e} of the smaller radius; least gap {gap}\n{}\n",
        packing.outcome,
        packing.placements.len(),
        packed.grains.copies.len(),
        m.porosity,
        m.porosity_error,
        m.coordination,
        m.gap_tolerance,
        m.worst_overlap,
        road.store.path("packing.csv").display(),
    );
    if !packing.dropped.is_empty() {
        screen.warn(&format!("{} grains found no place", packing.dropped.len()));
    }
    let json = json!({
        "output": road.store.root(),
        "placed": packing.placements.len(),
        "dropped": packing.dropped.len(),
        "outcome": packing.outcome,
        "measures": packing.measures,
    });
    screen.result(&json, &text)
}
