//! Clumps by `fix multisphere`: a template for every distinct clump, and one insertion a body
//! that leaves it no choice.
//!
//! A body is inserted into a block that reaches one rounding of its coordinates to either side,
//! with its turn, velocity and spin as constants, in a step of 1e-30 s before the run; mass,
//! moments of inertia and places of spheres in the template are those of the model. Places come
//! out right to one or two roundings. Unlike `fix rigid` the weight acts on the body, so that no
//! point of mass is needed.
//!
//! LIGGGHTS' start-up grows with the fourth power of the number of templates and the square of
//! the number of bodies: see [`MOST_SHAPES`] and [`MOST_BODIES`].
//! Atoms count from the single spheres on, then come those of clumps, body by body.

use crate::model::{Body, ClumpRoute, Model};
use crate::num::Vec3;
use crate::solver::Limit;
use crate::solver::table::{Cell, Table};
use serde::Serialize;
use std::collections::BTreeMap;

/// Most distinct clumps: 100 take 0.3 s to start, 200 6 s, 400 more than a minute (measured).
pub const MOST_SHAPES: usize = 150;
/// Most clumps: 1 000 take 0.3 s to start, 10 000 about 35 s (measured).
pub const MOST_BODIES: usize = 10_000;
/// Half width of the block around a coordinate of zero, m: its volume must stay above 1e-80 m³.
pub const LEAST: f64 = 1e-26;

/// Whether the deck of `model` holds clumps by `fix multisphere`.
pub fn is_used(model: &Model) -> bool {
    model.decks.liggghts_clumps == ClumpRoute::Multisphere && has_clumps(model)
}

fn has_clumps(model: &Model) -> bool {
    model.bodies.iter().any(|body| body.sphere_count > 1)
}

/// What `fix multisphere` cannot do of `model`.
pub fn limits(model: &Model) -> Vec<Limit> {
    let mut limits = Vec::new();
    if !is_used(model) {
        return limits;
    }
    let needs = model.needs();
    let other = "; leave decks.liggghts_clumps at \"rigid\"";
    if needs.discs {
        limits.push(Limit::refused(format!(
            "clumps of discs by fix multisphere, which is for three dimensions only{other}"
        )));
    }
    if needs.periodic {
        limits.push(Limit::refused(format!(
            "clumps by fix multisphere in a periodic box: riprap writes no such deck{other}"
        )));
    }
    let (_, shapes) = shapes(model);
    if shapes.len() > MOST_SHAPES {
        limits.push(Limit::refused(format!(
            "{} distinct clumps by fix multisphere, which takes {MOST_SHAPES} (its start-up grows with the fourth power of their number){other}",
            shapes.len()
        )));
    }
    let bodies = clumps(model).count();
    if bodies > MOST_BODIES {
        limits.push(Limit::refused(format!(
            "{bodies} clumps by fix multisphere, which takes {MOST_BODIES} in about 35 s of start-up, growing with the square of their number{other}"
        )));
    }
    limits
}

fn clumps(model: &Model) -> impl Iterator<Item = (usize, &Body)> {
    model.bodies.iter().enumerate().filter(|(_, body)| body.sphere_count > 1)
}

/// What two clumps must share to share a template, bit by bit.
type Shape = (u16, Vec<u64>);

fn shape(model: &Model, index: usize) -> Shape {
    let body = &model.bodies[index];
    let own = [body.mass, body.inertia.x, body.inertia.y, body.inertia.z];
    let spheres = model.spheres_of(index).iter();
    let balls = spheres.flat_map(|s| [s.offset.x, s.offset.y, s.offset.z, s.radius]);
    (body.material, own.into_iter().chain(balls).map(f64::to_bits).collect())
}

/// Template of every clump, in the order of the bodies, and the first body of every template.
fn shapes(model: &Model) -> (Vec<usize>, Vec<usize>) {
    let mut known = BTreeMap::new();
    let mut first = Vec::new();
    let of_body = clumps(model).map(|(index, _)| {
        *known.entry(shape(model, index)).or_insert_with(|| {
            first.push(index);
            first.len() - 1
        })
    });
    let of_body = of_body.collect();
    (of_body, first)
}

/// Index of the sphere that every atom of the deck is, by the numbers of the atoms.
pub fn order(model: &Model) -> Vec<u32> {
    let of = |clump: bool| {
        let bodies = model.bodies.iter().filter(move |body| (body.sphere_count > 1) == clump);
        bodies.flat_map(|body| body.first_sphere..body.first_sphere + body.sphere_count)
    };
    of(false).chain(of(true)).collect()
}

/// Values of `clumps.in` besides its tables.
#[derive(Debug, Serialize)]
pub struct Clumps {
    templates: Vec<Template>,
    bodies: usize,
}

#[derive(Debug, Serialize)]
struct Template {
    number: usize,
    seed: u32,
    type_number: usize,
    mass: f64,
    inertia: [f64; 3],
    /// Place in the frame of the body and radius.
    spheres: Vec<[f64; 4]>,
}

/// Seeds must be primes above 10 000; places are given, so that all templates may share one.
pub const SEED: u32 = 15_485_863;

impl Clumps {
    /// Reads a model.
    pub fn new(model: &Model) -> Self {
        let (of_body, first) = shapes(model);
        let templates = first.iter().enumerate().map(|(number, index)| {
            let body = &model.bodies[*index];
            let spheres = model.spheres_of(*index).iter();
            Template {
                number: number + 1,
                seed: SEED,
                type_number: usize::from(body.material) + 1,
                mass: body.mass,
                inertia: [body.inertia.x, body.inertia.y, body.inertia.z],
                spheres: spheres.map(|s| [s.offset.x, s.offset.y, s.offset.z, s.radius]).collect(),
            }
        });
        Self { templates: templates.collect(), bodies: of_body.len() }
    }
}

/// Blocks of one rounding around the centres of mass.
pub fn places(model: &Model) -> Table<'_> {
    const COLUMNS: &[&str] = &["body", "xlow", "xhigh", "ylow", "yhigh", "zlow", "zhigh"];
    Table::new("places", COLUMNS, move |rows| {
        for (number, (_, body)) in clumps(model).enumerate() {
            let mut cells = [Cell::Count(number + 1); 7];
            for (axis, at) in body.position.iter().enumerate() {
                let reach = (at.abs() * f64::EPSILON).max(LEAST);
                cells[1 + 2 * axis] = (at - reach).into();
                cells[2 + 2 * axis] = (at + reach).into();
            }
            rows.put(&cells)?;
        }
        Ok(())
    })
}

/// Insertions, one a clump.
pub fn insertions(model: &Model) -> Table<'_> {
    const COLUMNS: &[&str] =
        &["body", "template", "vx", "vy", "vz", "wx", "wy", "wz", "qw", "qx", "qy", "qz"];
    Table::new("insertions", COLUMNS, move |rows| {
        let (of_body, _) = shapes(model);
        for (number, ((_, body), template)) in clumps(model).zip(of_body).enumerate() {
            let (q, v, w): (_, Vec3, Vec3) =
                (body.orientation.into_inner(), body.velocity, body.spin);
            let row = [v.x, v.y, v.z, w.x, w.y, w.z, q.w, q.i, q.j, q.k];
            let mut cells = [Cell::Count(number + 1); 12];
            cells[1] = (template + 1).into();
            cells[2..].copy_from_slice(&row.map(Cell::Number));
            rows.put(&cells)?;
        }
        Ok(())
    })
}

/// Numbers of the insertions, which are taken away again.
pub fn numbers(model: &Model) -> Table<'_> {
    Table::new("numbers", &["body"], move |rows| {
        (1..=clumps(model).count()).try_for_each(|number| rows.put(&[number.into()]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Cell as PeriodicCell;
    use crate::model::Dimension;
    use crate::solver::deck::examples;
    use crate::solver::{LimitKind, Solver, liggghts::Liggghts};

    fn three_clumps(dimension: Dimension) -> Model {
        let mut model = examples::empty(dimension, examples::contact());
        examples::add_clump(&mut model, Vec3::new(-5e-3, 0.0, 0.0));
        examples::add_sphere(&mut model, Vec3::zeros(), 1e-3, Vec3::zeros(), 0);
        examples::add_clump(&mut model, Vec3::new(5e-3, 0.0, 0.0));
        examples::add_clump(&mut model, Vec3::new(10e-3, 0.0, 0.0));
        model.decks.liggghts_clumps = ClumpRoute::Multisphere;
        model
    }

    #[test]
    fn equal_clumps_share_a_template() {
        let mut model = three_clumps(Dimension::Three);
        assert_eq!(shapes(&model), (vec![0, 0, 0], vec![0]));
        let last = model.spheres.len() - 1;
        model.spheres[last].radius *= 1.0 + 1e-15;
        assert_eq!(shapes(&model), (vec![0, 0, 1], vec![0, 3]));
        model.bodies[2].mass *= 2.0;
        assert_eq!(shapes(&model), (vec![0, 1, 2], vec![0, 2, 3]));
    }

    #[test]
    fn single_spheres_come_first() {
        let model = three_clumps(Dimension::Three);
        assert_eq!(order(&model), [4, 0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12]);
    }

    fn refused(model: &Model, word: &str) -> bool {
        Liggghts
            .limits(model)
            .iter()
            .any(|limit| limit.kind == LimitKind::Refused && limit.what.contains(word))
    }

    #[test]
    fn what_it_cannot_do_is_refused() {
        let mut model = three_clumps(Dimension::Three);
        assert!(!refused(&model, "multisphere"));
        assert!(refused(&three_clumps(Dimension::Two), "three dimensions"));
        model.periodic = Some(PeriodicCell { bounds: model.domain, periodic: [true; 3] });
        assert!(refused(&model, "periodic box"));
        model.periodic = None;
        for shape in 0..MOST_SHAPES {
            examples::add_clump(&mut model, Vec3::zeros());
            model.bodies.last_mut().expect("a clump").mass *= 1.0 + 0.001 * (shape + 1) as f64;
        }
        assert!(refused(&model, "151 distinct clumps"));
        let mut many = three_clumps(Dimension::Three);
        for _ in 0..MOST_BODIES {
            many.bodies.push(many.bodies[0].clone());
        }
        assert!(refused(&many, "10003 clumps"));
        many.decks.liggghts_clumps = ClumpRoute::Rigid;
        assert!(!refused(&many, "multisphere"));
    }
}
