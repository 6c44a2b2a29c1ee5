//! Statistics that methods of random grains keep of their surfaces, asked and measured: a table and charts.

use super::Loaded;
use super::grains::Draw;
use crate::report::chart::{Axis, Chart, Series};
use crate::shape::{Fact, Shape};
use std::io::Write;

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
