//! The three faults of the moving boundary (P12): another boundary, slow, uneven.

use super::super::{StudyError, go_on};
use super::methods::unit_box;
use crate::num::Job;
use crate::pack::moving_boundary::MovingBoundary;
use crate::pack::radius_expansion::RadiusExpansion;
use crate::report::chart::{Axis, Chart, Series};
use crate::report::findings::Sheet;
use std::f64::consts::PI;

/// What the moving boundary costs and does, beside radius expansion to the same solid fraction.
pub struct Fault {
    fraction: f64,
    way: f64,
    steps: u64,
    other_steps: u64,
    beside: f64,
    middle: f64,
}

/// Spheres pressed by one lid to some solid fractions.
pub fn faults(full: bool, job: &Job) -> Result<Vec<Fault>, StudyError> {
    let count = if full { 2000 } else { 500 };
    let mut found = Vec::new();
    for fraction in [0.40, 0.50, 0.56] {
        go_on(job)?;
        let mut space = unit_box(3);
        space.periodic = [false; 3];
        let radius = (fraction / (4.0 / 3.0 * PI) / count as f64).cbrt();
        let radii = vec![radius; count];
        // One lid, as in most uses.
        let lid = [[false; 2], [false; 2], [false, true]];
        let method = MovingBoundary::default();
        let Some(pressed) = method.press(&space, &lid, &radii, fraction, 1, job) else { continue };
        let even = RadiusExpansion { steps: method.steps, ..RadiusExpansion::default() };
        let Some((_, relaxed)) = even.expand(&space, &radii, 1, job) else { continue };
        found.push(Fault {
            fraction,
            way: pressed.way[2],
            steps: pressed.relaxed.steps,
            other_steps: relaxed.steps,
            beside: pressed.fractions.0,
            middle: pressed.fractions.1,
        });
    }
    Ok(found)
}

/// Figures of the faults.
pub fn sheet(faults: &[Fault]) -> Sheet {
    let columns = [
        "solid fraction",
        "way of the lid over the height",
        "relaxation steps",
        "radius expansion",
        "solid fraction beside the lid",
        "in the middle",
    ];
    Sheet {
        key: "moving-boundary".into(),
        title:
            "What the moving boundary costs: a boundary that is not that of the start, slow, uneven"
                .into(),
        caption: "One lid comes down on equal spheres. Beside: one to three radii off it.".into(),
        columns: columns.map(String::from).to_vec(),
        rows: faults
            .iter()
            .map(|fault| {
                vec![
                    fault.fraction.into(),
                    fault.way.into(),
                    fault.steps.into(),
                    fault.other_steps.into(),
                    fault.beside.into(),
                    fault.middle.into(),
                ]
            })
            .collect(),
    }
}

/// Steps and evenness over the solid fraction.
pub fn charts(faults: &[Fault]) -> Vec<(String, Chart)> {
    let line = |name: &str, of: fn(&Fault) -> f64| Series {
        name: name.into(),
        points: faults.iter().map(|fault| (fault.fraction, of(fault))).collect(),
        dots: true,
    };
    let chart = |title: &str, y: Axis, series| Chart {
        title: title.into(),
        caption: "Equal spheres under one lid.".into(),
        x: Axis::linear("solid fraction", ""),
        y,
        series,
        mark: None,
    };
    vec![
        (
            "moving-boundary-steps".into(),
            chart(
                "Moving boundary: relaxation steps",
                Axis::log("steps", ""),
                vec![
                    line("moving boundary", |f| f.steps as f64),
                    line("radius expansion", |f| f.other_steps as f64),
                ],
            ),
        ),
        (
            "moving-boundary-evenness".into(),
            chart(
                "Moving boundary: solid fraction beside the lid and in the middle",
                Axis::linear("solid fraction there", ""),
                vec![line("beside the lid", |f| f.beside), line("in the middle", |f| f.middle)],
            ),
        ),
    ]
}
