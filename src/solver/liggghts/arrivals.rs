//! Spheres that come during the run: a template for every distinct one, and one insertion a sphere
//! that leaves it no choice.
//!
//! As with `fix multisphere` a sphere is inserted into a block that reaches one rounding of its
//! coordinates to either side. `fix insert/pack` puts it in at its step, after places have moved
//! and before forces are computed, so that its velocity is the one half a step before: v − Δt/2 g.
//! Atoms count on from those of the data file in the order of time.

use super::multisphere::{LEAST, MOST_BODIES, MOST_SHAPES, SEED};
use crate::model::Model;
use crate::num::Vec3;
use crate::solver::Limit;
use crate::solver::table::{Cell, Table};
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// What of `model` cannot be inserted.
pub fn limits(model: &Model) -> Vec<Limit> {
    let needs = model.needs();
    if !needs.arrivals {
        return Vec::new();
    }
    let (count, kinds) = (model.coming().count(), kinds(model).1.len());
    let refused = [
        (
            needs.clumps,
            "grains inserted over time with rigid clumps: fix rigid takes no new bodies, and atoms of fix multisphere are counted in another order; use spheres, or riprap's own run".to_owned(),
        ),
        (needs.discs, "discs inserted over time: fix insert is for three dimensions only; use YADE or LAMMPS".to_owned()),
        (needs.periodic, "grains inserted over time in a periodic box: riprap writes no such deck".to_owned()),
        (needs.restarts, "restarts with grains inserted over time: riprap writes no such deck".to_owned()),
        (
            kinds > MOST_SHAPES,
            format!("{kinds} different spheres inserted over time: LIGGGHTS takes {MOST_SHAPES} (its start-up grows with the fourth power of their number); give families a few sizes"),
        ),
        (
            count > MOST_BODIES,
            format!("{count} spheres inserted over time: LIGGGHTS takes {MOST_BODIES} (its start-up grows with the square of their number)"),
        ),
    ];
    refused.into_iter().filter(|(there, _)| *there).map(|(_, why)| Limit::refused(why)).collect()
}

/// Template of every sphere that comes, and the first body of every template.
fn kinds(model: &Model) -> (Vec<usize>, Vec<usize>) {
    let mut known = BTreeMap::new();
    let mut first = Vec::new();
    let of_body = model.coming().map(|(index, body)| {
        let radius = model.spheres[body.first_sphere as usize].radius;
        *known.entry((body.material, radius.to_bits(), body.mass.to_bits())).or_insert_with(|| {
            first.push(index);
            first.len() - 1
        })
    });
    let of_body = of_body.collect();
    (of_body, first)
}

/// Values of `arrivals.in` besides its tables.
#[derive(Debug, Serialize)]
pub struct Arrivals {
    templates: Vec<Template>,
    spheres: usize,
}

#[derive(Debug, Serialize)]
struct Template {
    number: usize,
    seed: u32,
    type_number: usize,
    radius: f64,
    density: f64,
}

impl Arrivals {
    /// Reads a model.
    pub fn new(model: &Model) -> Self {
        let (_, first) = kinds(model);
        let template = |(number, index): (usize, &usize)| {
            let body = &model.bodies[*index];
            let radius = model.spheres[body.first_sphere as usize].radius;
            Template {
                number: number + 1,
                seed: SEED,
                type_number: usize::from(body.material) + 1,
                radius,
                density: body.mass / (4.0 / 3.0 * PI * radius.powi(3)),
            }
        };
        let templates = first.iter().enumerate().map(template).collect();
        Self { templates, spheres: model.coming().count() }
    }
}

/// Blocks of one rounding around the places, and insertions, one a sphere.
pub fn tables(model: &Model) -> Vec<Table<'_>> {
    const PLACES: &[&str] = &["sphere", "xlow", "xhigh", "ylow", "yhigh", "zlow", "zhigh"];
    const INSERTIONS: &[&str] = &["sphere", "step", "template", "vx", "vy", "vz", "wx", "wy", "wz"];
    let places = Table::new("places", PLACES, move |rows| {
        for (number, (_, body)) in model.coming().enumerate() {
            let mut cells = [Cell::Count(number + 1); 7];
            for (axis, at) in body.position.iter().enumerate() {
                let reach = (at.abs() * f64::EPSILON).max(LEAST);
                cells[1 + 2 * axis] = (at - reach).into();
                cells[2 + 2 * axis] = (at + reach).into();
            }
            rows.put(&cells)?;
        }
        Ok(())
    });
    let insertions = Table::new("insertions", INSERTIONS, move |rows| {
        let (of_body, _) = kinds(model);
        for (number, ((index, body), template)) in model.coming().zip(of_body).enumerate() {
            let early: Vec3 = body.velocity - model.gravity * (0.5 * model.plan.step);
            let (v, w) = (early, body.spin);
            let mut cells = [Cell::Count(number + 1); 9];
            cells[1] = (model.arrival_step(index) as usize).into();
            cells[2] = (template + 1).into();
            cells[3..].copy_from_slice(&[v.x, v.y, v.z, w.x, w.y, w.z].map(Cell::Number));
            rows.put(&cells)?;
        }
        Ok(())
    });
    vec![places, insertions]
}
