//! Statistics of drawn surfaces as a table, and surfaces as their methods draw
//! them, valid grains or not.

use super::Loaded;
use super::grains::{self, Draw};
use super::road::{Road, RoadError};
use super::store::key;
use crate::format;
use crate::report::chart::{Axis, Chart, Series};
use crate::shape::{Fact, Shape};
use serde::Serialize;
use serde_json::json;
use std::io::Write;

/// One surface as it was drawn.
#[derive(Debug, Serialize)]
pub struct Verdict {
    /// Name of the grain.
    pub name: String,
    /// Why it is no valid grain; `None` if it is one.
    pub fault: Option<String>,
    /// How it was made.
    pub recipe: String,
    /// Its statistics.
    pub facts: Vec<Fact>,
}

impl Road {
    /// The first draw of every distinct grain as it comes, in `as-drawn/`, with
    /// `verdicts.csv` (valid grain or why not) and `statistics.csv`.
    ///
    /// # Errors
    /// A method that draws nothing; a folder that cannot be written.
    pub fn as_drawn(&mut self) -> Result<Vec<Verdict>, RoadError> {
        let draws = grains::draws(&self.loaded).map_err(|fault| self.wrong(fault))?;
        let mut running =
            self.store.begin("as-drawn", &key("", &[json!("always anew")], self.loaded.base()))?;
        let mut verdicts = Vec::new();
        for (count, draw) in draws.iter().enumerate() {
            if self.job.is_cancelled() {
                return Err(RoadError::Cancelled);
            }
            let first = grains::as_drawn(&self.loaded, draw).map_err(|fault| self.wrong(fault))?;
            let Some((drawn, fault)) = first else { continue };
            let file = format!("as-drawn/{}.stl", draw.name);
            let path = self.store.prepare(&mut running, &file)?;
            format::stl::write(&path, &drawn.mesh)?;
            verdicts.push(Verdict {
                name: draw.name.clone(),
                fault: fault.map(|fault| fault.to_string()),
                recipe: drawn.recipe,
                facts: drawn.facts,
            });
            self.job.report("surfaces", count as u64 + 1, draws.len() as u64);
        }
        self.store.write(&mut running, "as-drawn/verdicts.csv", |out| {
            writeln!(out, "name,valid,reason,recipe")?;
            for v in &verdicts {
                let quoted = |text: &str| text.replace('"', "'");
                let reason = quoted(v.fault.as_deref().unwrap_or(""));
                let valid = v.fault.is_none();
                writeln!(out, "{},{valid},\"{reason}\",\"{}\"", v.name, quoted(&v.recipe))?;
            }
            Ok(())
        })?;
        let facts: Vec<_> = verdicts.iter().map(|v| (v.name.as_str(), &v.facts[..])).collect();
        self.store
            .write(&mut running, "as-drawn/statistics.csv", |out| write_facts(out, &facts))?;
        running.count("surfaces", verdicts.len());
        let made = format!("drew {} surfaces", verdicts.len());
        self.close(running, &made)?;
        Ok(verdicts)
    }
}

/// Charts of made-to-measure families: for each wanted descriptor the share of
/// grains below each value, asked and measured, as file name and SVG text.
pub(super) fn distributions(
    loaded: &Loaded,
    draws: &[Draw],
    facts: &[Vec<Fact>],
) -> Vec<(String, String)> {
    let mut charts = Vec::new();
    for (number, family) in loaded.scene.grains.iter().enumerate() {
        if !matches!(family.shape, Shape::Tailored(_)) {
            continue;
        }
        let grains: Vec<&[Fact]> = draws
            .iter()
            .zip(facts)
            .filter(|(draw, facts)| draw.family == number as u16 && !facts.is_empty())
            .map(|(_, facts)| &facts[..])
            .collect();
        let Some(first) = grains.first() else { continue };
        for (k, fact) in first.iter().enumerate() {
            if fact.asked.is_none() {
                continue;
            }
            let asked = grains.iter().filter_map(|facts| facts[k].asked).collect();
            let measured = grains.iter().map(|facts| facts[k].measured).collect();
            let chart = Chart {
                title: format!("{} of {}", fact.quantity, family.name),
                caption: "Share of grains below a value".to_owned(),
                x: Axis::linear(&fact.quantity, ""),
                y: Axis::linear("share below", ""),
                series: vec![cumulative("asked", asked), cumulative("measured", measured)],
                mark: None,
            };
            let file = format!("shapes/{}-{}.svg", family.name, fact.quantity);
            charts.extend(chart.svg().map(|svg| (file, svg)));
        }
    }
    charts
}

fn cumulative(name: &str, mut values: Vec<f64>) -> Series {
    values.sort_by(f64::total_cmp);
    let count = values.len() as f64;
    let points = values.into_iter().enumerate().map(|(k, v)| (v, (k as f64 + 0.5) / count));
    Series { name: name.to_owned(), points: points.collect(), dots: false }
}

/// `statistics.csv`: one row a statistic; `asked` is empty where nothing was asked for.
pub(super) fn write_facts(out: &mut dyn Write, rows: &[(&str, &[Fact])]) -> std::io::Result<()> {
    writeln!(out, "name,quantity,asked,measured")?;
    for (name, facts) in rows {
        for fact in *facts {
            let asked = fact.asked.map_or(String::new(), |asked| format!("{asked:e}"));
            writeln!(out, "{name},\"{}\",{asked},{:e}", fact.quantity, fact.measured)?;
        }
    }
    Ok(())
}
