//! The page of the packing study: table, charts, remarks.

use super::Row;
use super::faults::{self, Fault};
use super::neighbours::{self, Search};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::curves::work_precision;
use crate::report::findings::{Findings, Sheet};

/// All that was found.
pub fn findings(
    rows: &[Row],
    pores: Vec<Series>,
    pressed: &[Fault],
    searches: &[Search],
) -> Findings {
    let chart_of = |title: &str, quantities: &[&str], dimensions: &[usize]| {
        let curves = curves(rows, quantities, dimensions, |row| row.seconds);
        let title = format!("{title}: distance from the reference over CPU time");
        work_precision(&title, &curves, "relative difference", "", None)
    };
    let over_number = |title: &str, quantities: &[&str], dimensions: &[usize]| Chart {
        title: format!("{title}: distance from the reference over the number of balls"),
        caption: "Methods with one number of balls are dots.".into(),
        x: Axis::log("balls", ""),
        y: Axis::log("relative difference", ""),
        series: curves(rows, quantities, dimensions, |row| row.balls as f64)
            .into_iter()
            .map(|(name, points)| Series { name, points, dots: true })
            .collect(),
        mark: None,
    };
    let solids = ["solid fraction", "share of pores"];
    let chart = Chart {
        title: "Share of pores of random Apollonian packings".into(),
        caption: "Straight lines of slope −(d − D)/D: D near 1.565 and 2.73.".into(),
        x: Axis::log("balls", ""),
        y: Axis::log("share of pores", ""),
        series: pores,
        mark: None,
    };
    Findings {
        title: "Packing methods against what is known of them".into(),
        question: "How far is each method from its reference (density, dimension, coordination), at what CPU time and number of balls?".into(),
        remarks: remarks(rows),
        tables: vec![sheet(rows), neighbours::sheet(searches), faults::sheet(pressed)],
        charts: [vec![
            ("packing-solids-2d".into(), chart_of("Solid fraction, discs", &solids, &[2])),
            ("packing-solids-3d".into(), chart_of("Solid fraction, spheres", &solids, &[3])),
            ("packing-dimension".into(), chart_of("Dimension", &["dimension"], &[2, 3])),
            ("packing-contacts".into(), chart_of("Contacts a ball", &["contacts a ball"], &[2, 3])),
            ("packing-solids-number".into(), over_number("Solid fraction", &solids, &[2, 3])),
            ("packing-dimension-number".into(), over_number("Dimension", &["dimension"], &[2, 3])),
            ("packing-contacts-number".into(), over_number("Contacts a ball", &["contacts a ball"], &[2, 3])),
            ("packing-pores".into(), chart),
        ], faults::charts(pressed), neighbours::charts(searches)].concat(),
        pictures: Vec::new(),
    }
}

fn sheet(rows: &[Row]) -> Sheet {
    Sheet {
        key: "packing".into(),
        title: "Each method against its reference".into(),
        caption: "Means over samples of other seeds with their standard errors; CPU seconds of this machine for one. A difference is relative.".into(),
        columns: [
            "method",
            "dimensions",
            "balls",
            "setting",
            "quantity",
            "samples",
            "found",
            "standard error",
            "reference",
            "difference",
            "source",
            "CPU [s]",
        ]
        .map(String::from)
        .to_vec(),
        rows: rows
            .iter()
            .map(|row| {
                vec![
                    row.method.into(),
                    (row.dimension as u64).into(),
                    (row.balls as u64).into(),
                    row.setting.as_str().into(),
                    row.quantity.into(),
                    row.samples.into(),
                    row.found.into(),
                    row.error.into(),
                    row.reference.into(),
                    (row.found / row.reference - 1.0).into(),
                    row.source.into(),
                    row.seconds.into(),
                ]
            })
            .collect(),
    }
}

/// A curve a method: distance from the reference over what `over` gives.
fn curves(
    rows: &[Row],
    quantities: &[&str],
    dimensions: &[usize],
    over: fn(&Row) -> f64,
) -> Vec<(String, Vec<(f64, f64)>)> {
    let mut curves: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    let shown = |row: &&Row| {
        quantities.contains(&row.quantity)
            && dimensions.contains(&row.dimension)
            && row.method != "apollonian"
            && row.reference.is_finite()
    };
    for row in rows.iter().filter(shown) {
        let name = format!("{} {}-D", row.method, row.dimension);
        let point = (over(row), (row.found / row.reference - 1.0).abs());
        match curves.iter_mut().find(|curve| curve.0 == name) {
            Some(curve) => curve.1.push(point),
            None => curves.push((name, vec![point])),
        }
    }
    curves
}

/// One sentence a method and quantity: the largest case.
fn remarks(rows: &[Row]) -> Vec<String> {
    let mut last: Vec<&Row> = Vec::new();
    for row in rows.iter().filter(|row| row.reference.is_finite()) {
        let same = |other: &&&Row| {
            (other.method, other.dimension, other.quantity)
                == (row.method, row.dimension, row.quantity)
        };
        match last.iter().position(|other| same(&other)) {
            Some(place) => last[place] = row,
            None => last.push(row),
        }
    }
    last.iter()
        .map(|row| {
            let digits = if row.quantity == "number of balls" { 0 } else { 4 };
            format!(
                "{}, {} dimensions, {} balls ({}): {} {:.digits$} against {:.digits$} ({}) in {:.2} s.",
                row.method,
                row.dimension,
                row.balls,
                row.setting,
                row.quantity,
                row.found,
                row.reference,
                row.source,
                row.seconds
            )
        })
        .collect()
}
