//! The stage that writes the report page.

use super::build::Built;
use super::comparing::Compared;
use super::road::{Packed, Road, RoadError};
use crate::clump::Clump;
use crate::model::Run;
use crate::report::page::{PageInput, write_page};
use crate::shape::Solid;

/// Writes `report/index.html` from what is there.
///
/// # Errors
/// A folder that cannot be written.
pub fn write(
    road: &mut Road,
    packed: &Packed,
    built: &Built,
    run: &Run,
    compared: Option<&Compared>,
) -> Result<(), RoadError> {
    let mut running = road.store.begin("report", "")?;
    let path = road.store.prepare(&mut running, "report/index.html")?;
    let solids: Vec<Solid> =
        packed.grains.distinct.iter().filter_map(|grain| grain.solid.clone()).collect();
    let clumps: Vec<Clump> = packed
        .grains
        .distinct
        .iter()
        .map(|grain| &grain.clump)
        .filter(|clump| clump.fidelity.is_some())
        .cloned()
        .collect();
    let verb = if compared.is_some() { "compare" } else { "run" };
    let commands = [format!("riprap {verb} {}", road.loaded.path.display())];
    let input = PageInput {
        title: &road.loaded.scene.title,
        version: &format!("riprap {}", crate::VERSION),
        model: Some(&built.model),
        solids: &solids,
        shape_table: None,
        clumps: &clumps,
        packing: Some(&packed.packing),
        ours: Some(compared.map_or(run, |compared| &compared.ours)),
        others: compared.map_or(&[], |compared| &compared.others),
        comparison: compared.map(|compared| &compared.comparison),
        missing: compared.map_or(&[], |compared| &compared.missing),
        commands: &commands,
    };
    write_page(&input, &path).map_err(|error| RoadError::Work(error.to_string()))?;
    Ok(road.store.finish(running)?)
}
