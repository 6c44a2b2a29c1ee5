//! The stage that writes the report page.

use super::build::Built;
use super::compared::Compared;
use super::road::{Packed, Road, RoadError};
use super::store::key;
use crate::clump::Clump;
use crate::model::Run;
use crate::report::chart::Chart;
use crate::report::input::PageInput;
use crate::report::page::write_page;
use crate::shape::Solid;

/// Writes `report/index.html` from what is there. A run without comparison keeps
/// the page that a comparison of the same run has written.
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
    let title = serde_json::Value::from(road.loaded.scene.title.as_str());
    let key_of =
        |verb: &str| key(&road.run_key(packed), &[title.clone(), verb.into()], road.loaded.base());
    let verb = if compared.is_some() { "compare" } else { "run" };
    let known = ["run", "compare"].map(key_of);
    if verb == "run" && known.iter().any(|key| road.store.is_done("report", key)) {
        road.unchanged("report", "report/index.html");
        return Ok(());
    }
    let mut running = road.store.begin("report", &known[usize::from(verb == "compare")])?;
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
    let readings = road.read_measures()?.unwrap_or_default();
    let (verdicts, charts) = (readings.verdicts(), readings.charts());
    let charts: Vec<Chart> = charts.into_iter().map(|(_, chart)| chart).collect();
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
        others: compared.map_or(&[], |compared| compared.others.as_slice()),
        comparison: compared.filter(|c| !c.others.is_empty()).map(|compared| &compared.comparison),
        missing: compared.map_or(&[], |compared| compared.missing.as_slice()),
        measures: (&verdicts, &charts),
        commands: &commands,
    };
    write_page(&input, &path).map_err(|error| RoadError::Work(error.to_string()))?;
    running.count("solvers", input.others.len());
    running.count("shapes", solids.len());
    running.count("clumps", clumps.len());
    road.close(running, "wrote the report")
}
