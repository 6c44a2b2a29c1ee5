//! The values that the LAMMPS templates print: one struct a template.

use crate::geometry::Bounds;
use crate::model::{Body, Contact, Model, Motion, Needs, WallShape};
use crate::num::{Mat3, Vec3};
use crate::solver::deck::{DeckOptions, Header};
use crate::solver::table::{Cell, Table};
use crate::solver::{Limit, Solver};
use serde::Serialize;
use std::f64::consts::PI;

const AXES: [&str; 3] = ["x", "y", "z"];
/// Skin of the neighbour list over the smallest radius.
const SKIN: f64 = 0.1;

/// Values of `in.lammps`.
#[derive(Debug, Serialize)]
pub struct Script {
    header: Header,
    needs: Needs,
    boundary: String,
    tension: bool,
    drag: f64,
    processors: String,
    skin: f64,
    material_names: Vec<String>,
    /// Types that walls tell apart; none if bodies are of one material.
    kinds: Vec<usize>,
    pairs: Vec<Pair>,
    step: f64,
    walls: Vec<WallValues>,
    gravity: f64,
    gravity_direction: [f64; 3],
    dumps: Vec<Dump>,
    last: u64,
    report_every: u64,
    steps: u64,
}

/// The contact of two atom types.
#[derive(Debug, Serialize)]
struct Pair {
    first: usize,
    second: usize,
    law: String,
}

/// A wall against the bodies of one material.
#[derive(Debug, Serialize)]
struct WallValues {
    name: String,
    /// 0: the bodies of all materials.
    material: usize,
    law: String,
    primitive: bool,
    /// Axis of a primitive wall, and its low and high place.
    axis: &'static str,
    low: String,
    high: String,
    shear_axis: &'static str,
    shear: f64,
    point: [f64; 3],
    normal: [f64; 3],
    moves: bool,
    velocity: [f64; 3],
    turns: bool,
    origin: [f64; 3],
    turn_axis: [f64; 3],
    rate: f64,
    /// The first of the fixes of its wall: it declares the region.
    first: bool,
}

/// One dump of all spheres.
#[derive(Debug, Serialize)]
struct Dump {
    id: &'static str,
    every: u64,
    file: &'static str,
}

fn plain(vector: &Vec3) -> [f64; 3] {
    [vector.x, vector.y, vector.z]
}

/// Atom types count from 1.
fn type_number(material: u16) -> usize {
    usize::from(material) + 1
}

/// Materials that bodies have, in rising order.
fn body_materials(model: &Model) -> Vec<u16> {
    let mut materials: Vec<u16> = model.bodies.iter().map(|body| body.material).collect();
    materials.sort_unstable();
    materials.dedup();
    materials
}

/// Number of materials that bodies have.
pub fn kinds(model: &Model) -> usize {
    body_materials(model).len()
}

/// Pairs of materials that meet: bodies with bodies, bodies with walls.
pub fn pairs(model: &Model) -> Vec<(u16, u16)> {
    let bodies = body_materials(model);
    let mut pairs = Vec::new();
    for (at, a) in bodies.iter().enumerate() {
        pairs.extend(bodies[at..].iter().map(|b| (*a, *b)));
        pairs.extend(model.walls.iter().map(|wall| (*a, wall.material)));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Arguments of `granular` for one contact. A pair without friction in a scene with friction
/// keeps a spring that the limit 0 holds at nothing; LAMMPS divides by its stiffness.
fn law(contact: &Contact, friction: bool, tension: bool) -> String {
    let tangential = if friction {
        let sticks = contact.friction > 0.0 && contact.kt > 0.0;
        let kt = if contact.kt > 0.0 { contact.kt } else { contact.kn };
        let ratio = if sticks && contact.ct > 0.0 { contact.ct / contact.cn } else { 0.0 };
        let limit = if sticks { contact.friction } else { 0.0 };
        format!("linear_history {kt:?} {ratio:?} {limit:?}")
    } else {
        "linear_nohistory 0.0 0.0".to_owned()
    };
    let limited = if tension { "" } else { " limit_damping" };
    format!(
        "hooke {:?} {:?} tangential {tangential} damping velocity{limited}",
        contact.kn, contact.cn
    )
}

fn walls(model: &Model) -> Vec<WallValues> {
    let (needs, materials) = (model.needs(), body_materials(model));
    let mut all = Vec::new();
    for wall in &model.walls {
        let WallShape::Plane { point, normal } = &wall.shape else { continue };
        let (axis, position, side) = wall.shape.axis_plane().unwrap_or((0, 0.0, 1.0));
        let velocity = match wall.motion {
            Motion::Translate { velocity } => velocity,
            _ => Vec3::zeros(),
        };
        let (origin, turn_axis, rate) = match wall.motion {
            Motion::Rotate { origin, axis, rate } => (origin, axis, rate),
            _ => (Vec3::zeros(), Vec3::zeros(), 0.0),
        };
        let along = (0..3).find(|a| velocity[*a] != 0.0);
        let place = format!("{position:?}");
        let (low, high) = if side > 0.0 { (place, "NULL".into()) } else { ("NULL".into(), place) };
        for (number, material) in materials.iter().enumerate() {
            let contact = model.contacts.between(*material, wall.material);
            all.push(WallValues {
                name: wall.name.clone(),
                material: if materials.len() > 1 { type_number(*material) } else { 0 },
                law: law(contact, needs.friction, model.plan.law.tension),
                primitive: wall.is_primitive(),
                axis: AXES[axis],
                low: low.clone(),
                high: high.clone(),
                shear_axis: along.map_or("", |a| AXES[a]),
                shear: along.map_or(0.0, |a| velocity[a]),
                point: plain(point),
                normal: plain(normal),
                moves: velocity.norm() > 0.0,
                velocity: plain(&velocity),
                turns: rate != 0.0,
                origin: plain(&origin),
                turn_axis: plain(&turn_axis),
                rate,
                first: number == 0,
            });
        }
    }
    all
}

impl Script {
    /// Reads a model.
    pub fn new(
        solver: &dyn Solver,
        model: &Model,
        options: &DeckOptions,
        limits: &[Limit],
    ) -> Self {
        let needs = model.needs();
        let steps = model.plan.steps;
        let every = model.plan.frame_every.max(1);
        let mut dumps = vec![Dump { id: "frames", every, file: "spheres.dump" }];
        if !steps.is_multiple_of(every) {
            dumps.push(Dump { id: "last", every: steps, file: "last.dump" });
        }
        let kinds = model.materials.len() as u16;
        let bodies = body_materials(model);
        let several = bodies.len() > 1 && !model.walls.is_empty();
        let pair = |a: u16, b: u16| Pair {
            first: type_number(a),
            second: type_number(b),
            law: law(model.contacts.between(a, b), needs.friction, model.plan.law.tension),
        };
        Self {
            header: Header::new(solver, model, limits),
            needs,
            boundary: boundary(model),
            tension: model.plan.law.tension,
            drag: model.extra.drag,
            processors: options.processors_text(model),
            skin: SKIN * model.smallest_radius(),
            material_names: model
                .materials
                .iter()
                .map(|m| m.name.replace(['\n', '&'], " "))
                .collect(),
            kinds: if several { bodies.into_iter().map(type_number).collect() } else { Vec::new() },
            pairs: (0..kinds)
                .flat_map(|a| (a..kinds).map(move |b| (a, b)))
                .map(|(a, b)| pair(a, b))
                .collect(),
            step: model.plan.step,
            walls: walls(model),
            gravity: model.gravity.norm(),
            gravity_direction: plain(&model.gravity),
            dumps,
            last: steps.max(1),
            report_every: (steps / 100).max(1),
            steps,
        }
    }
}

/// Values of `spheres.data` besides its tables.
#[derive(Debug, Serialize)]
pub struct Data {
    needs: Needs,
    types: usize,
    sides: Vec<(&'static str, f64, f64)>,
    atoms: usize,
    moves: bool,
}

impl Data {
    /// Reads a model.
    pub fn new(model: &Model) -> Self {
        let bounds = simulation_box(model);
        Self {
            needs: model.needs(),
            types: model.materials.len(),
            sides: (0..3).map(|a| (AXES[a], bounds.low[a], bounds.high[a])).collect(),
            atoms: there(model).map(|(_, body)| body.sphere_count as usize).sum(),
            moves: there(model).any(|(_, b)| b.velocity.amax() > 0.0 || b.spin.amax() > 0.0),
        }
    }
}

/// The bodies that are there from the start.
fn there(model: &Model) -> impl Iterator<Item = (usize, &Body)> {
    model.bodies[..model.first_arrival()].iter().enumerate()
}

/// All spheres. LAMMPS computes masses from densities as of spheres, discs too.
pub fn atoms(model: &Model) -> Table<'_> {
    let columns = &["id", "type", "diameter", "density", "x", "y", "z"];
    Table::new("atoms", columns, move |rows| {
        let flat = model.needs().discs;
        for (index, body) in there(model) {
            let spheres = model.spheres_of(index);
            let volume: f64 = spheres.iter().map(|s| s.radius.powi(3)).sum();
            // Of clumps the masses of single spheres act on nothing: shares by volume.
            let density = body.mass / (4.0 / 3.0 * PI * volume);
            for (sphere, id) in spheres.iter().zip(body.first_sphere as usize + 1..) {
                let place = body.position + body.orientation * sphere.offset;
                let z = if flat { 0.0 } else { place.z };
                let numbers = [2.0 * sphere.radius, density, place.x, place.y, z];
                let [d, density, x, y, z] = numbers.map(Cell::from);
                rows.put(&[id.into(), type_number(body.material).into(), d, density, x, y, z])?;
            }
        }
        Ok(())
    })
}

/// Velocities and angular velocities of all spheres. The set-up pass takes these; later fix
/// rigid has its own of clumps.
pub fn velocities(model: &Model) -> Table<'_> {
    Table::new("velocities", &["id", "vx", "vy", "vz", "wx", "wy", "wz"], move |rows| {
        for (index, body) in there(model) {
            let spheres = model.spheres_of(index);
            for (sphere, id) in spheres.iter().zip(body.first_sphere as usize + 1..) {
                let place = body.position + body.orientation * sphere.offset;
                let v = body.velocity + body.spin.cross(&(place - body.position));
                let w = &body.spin;
                let [x, y, z, u, v, w] = [v.x, v.y, v.z, w.x, w.y, w.z].map(Cell::from);
                rows.put(&[id.into(), x, y, z, u, v, w])?;
            }
        }
        Ok(())
    })
}

/// Number of the clump of every sphere, 0 for none.
pub fn molecules(model: &Model) -> Table<'_> {
    Table::new("molecules", &["id", "molecule"], move |rows| {
        let mut molecule = 0;
        for body in &model.bodies {
            let clump = body.sphere_count > 1;
            molecule += usize::from(clump);
            let first = body.first_sphere as usize + 1;
            for id in first..first + body.sphere_count as usize {
                rows.put(&[id.into(), if clump { molecule } else { 0 }.into()])?;
            }
        }
        Ok(())
    })
}

/// The domain and two radii around it.
/// Arguments of the `boundary` command.
fn boundary(model: &Model) -> String {
    let flat = model.needs().discs;
    let wraps = |axis: usize| model.periodic.is_some_and(|cell| cell.periodic[axis]);
    [0, 1, 2].map(|axis| if wraps(axis) || flat && axis == 2 { "p" } else { "f" }).join(" ")
}

fn simulation_box(model: &Model) -> Bounds {
    let mut room = model.domain.grown(2.0 * model.largest_radius());
    if model.needs().discs {
        let half = 0.5 * room.size().xy().max();
        (room.low.z, room.high.z) = (-half, half);
    }
    if let Some(cell) = &model.periodic {
        for axis in (0..3).filter(|axis| cell.periodic[*axis]) {
            (room.low[axis], room.high[axis]) = (cell.bounds.low[axis], cell.bounds.high[axis]);
        }
    }
    room
}

/// What `fix rigid/small` misses in its first half step: its set-up pass does not know its
/// own `gravity` yet. Clumps start with this velocity on top, m/s.
pub fn missed_kick(model: &Model) -> Vec3 {
    let mut kick = model.gravity * (0.5 * model.plan.step);
    if model.needs().discs {
        kick.z = 0.0;
    }
    kick
}

/// Values of `rigid.inf` besides its table.
#[derive(Debug, Serialize)]
pub struct Rigid {
    bodies: usize,
}

impl Rigid {
    /// Reads a model.
    pub fn new(model: &Model) -> Self {
        Self { bodies: model.bodies.iter().filter(|body| body.sphere_count > 1).count() }
    }
}

/// Mass properties, velocities and angular momenta of clumps, space axes.
pub fn rigid(model: &Model) -> Table<'_> {
    const COLUMNS: &[&str] = &[
        "id", "mass", "x", "y", "z", "ixx", "iyy", "izz", "ixy", "ixz", "iyz", "vx", "vy", "vz",
        "lx", "ly", "lz",
    ];
    Table::new("bodies", COLUMNS, move |rows| {
        let (kick, flat) = (missed_kick(model), model.needs().discs);
        let clumps = model.bodies.iter().filter(|body| body.sphere_count > 1);
        for (number, body) in clumps.enumerate() {
            let axes = body.orientation.to_rotation_matrix();
            let i = axes.matrix() * Mat3::from_diagonal(&body.inertia) * axes.matrix().transpose();
            let (x, v, l) = (&body.position, body.velocity + kick, i * body.spin);
            let z = if flat { 0.0 } else { x.z };
            let row = [
                body.mass, x.x, x.y, z, i.m11, i.m22, i.m33, i.m12, i.m13, i.m23, v.x, v.y, v.z,
                l.x, l.y, l.z,
            ];
            let mut cells = [Cell::Count(number + 1); 17];
            cells[1..].copy_from_slice(&row.map(Cell::Number));
            rows.put(&cells)?;
        }
        Ok(())
    })
}

/// Values of `run.sh`.
#[derive(Debug, Serialize)]
pub struct Start {
    ranks: usize,
    springs: bool,
}

impl Start {
    /// Reads the options.
    pub fn new(model: &Model, options: &DeckOptions) -> Self {
        Self { ranks: options.ranks, springs: !model.springs.is_empty() }
    }
}

/// Values of `arrivals.in` besides its table.
#[derive(Debug, Serialize)]
pub struct Arrivals {
    spheres: usize,
    kinds: bool,
}

impl Arrivals {
    /// Reads a model.
    pub fn new(model: &Model) -> Self {
        Self { spheres: model.coming().count(), kinds: body_materials(model).len() > 1 }
    }
}

/// The spheres that come during the run, in the order of time.
pub fn arrivals(model: &Model) -> Table<'_> {
    const COLUMNS: &[&str] = &[
        "step", "id", "type", "diameter", "density", "x", "y", "z", "vx", "vy", "vz", "wx", "wy",
        "wz",
    ];
    Table::new("arrivals", COLUMNS, move |rows| {
        let flat = model.needs().discs;
        for (index, body) in model.coming() {
            let radius = model.spheres[body.first_sphere as usize].radius;
            let density = body.mass / (4.0 / 3.0 * PI * radius.powi(3));
            let (x, v, w) = (&body.position, &body.velocity, &body.spin);
            let z = if flat { 0.0 } else { x.z };
            let row = [2.0 * radius, density, x.x, x.y, z, v.x, v.y, v.z, w.x, w.y, w.z];
            let mut cells = [Cell::Count(model.arrival_step(index) as usize); 14];
            cells[1] = (body.first_sphere as usize + 1).into();
            cells[2] = type_number(body.material).into();
            cells[3..].copy_from_slice(&row.map(Cell::Number));
            rows.put(&cells)?;
        }
        Ok(())
    })
}
