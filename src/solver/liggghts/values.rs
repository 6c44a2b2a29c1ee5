//! The values that the LIGGGHTS templates print: one struct a template.

use super::multisphere;
use crate::geometry::{Bounds, Mesh};
use crate::model::extra::{Cohesion, Rolling};
use crate::model::{
    Body, Contact, Lost, Model, Motion, Needs, PairForces, Sphere, Wall, WallShape,
};
use crate::num::{Mat3, Vec3};
use crate::solver::deck::{DeckOptions, Header, plain};
use crate::solver::mesh_check::inspect;
use crate::solver::rigid_masses::{self, Balance, Masses, Point};
use crate::solver::surface;
use crate::solver::table::{Cell, Table};
use crate::solver::{Limit, Solver};
use serde::Serialize;
use std::f64::consts::{PI, TAU};

const AXES: [&str; 3] = ["x", "y", "z"];
/// Smallest angle of a mesh triangle that LIGGGHTS takes with its default
/// `curvature`, rad (0.256235 degrees).
pub const DEFAULT_CURVATURE: f64 = 0.256_235 / 180.0 * std::f64::consts::PI;

/// Radius of points of mass over the smallest radius; nothing touches them.
const POINT_RADIUS: f64 = 0.1;
/// Skin of the neighbour list over the smallest radius: fast for settled beds and flows alike.
const SKIN: f64 = 0.1;

/// Values of `in.liggghts`.
#[derive(Debug, Serialize)]
pub struct Script {
    header: Header,
    needs: Needs,
    /// Clumps are held by fix rigid.
    rigid: bool,
    /// Clumps are held by fix multisphere.
    multisphere: bool,
    boundary: String,
    tension: bool,
    cohesion: &'static str,
    rolling: &'static str,
    drag: f64,
    processors: String,
    skin: f64,
    points: usize,
    point_type: usize,
    material_names: Vec<String>,
    tables: Vec<Pairs>,
    step: f64,
    planes: Vec<Plane>,
    surfaces: Vec<SurfaceValues>,
    gravity: f64,
    gravity_direction: [f64; 3],
    dumps: Vec<Dump>,
    contact_columns: usize,
    last: u64,
    report_every: u64,
    restart_every: u64,
    steps: u64,
    /// What `thermo_modify lost` does.
    lost: &'static str,
}

/// One `property/global` of pairs of atom types.
#[derive(Debug, Serialize)]
struct Pairs {
    fix: &'static str,
    property: &'static str,
    size: usize,
    rows: Vec<Vec<f64>>,
}

/// A primitive wall.
#[derive(Debug, Serialize)]
struct Plane {
    name: String,
    type_number: usize,
    axis: &'static str,
    position: f64,
    shears: bool,
    shear_axis: &'static str,
    shear: f64,
}

/// A mesh wall; which of the motion values count is said by `motion`.
#[derive(Debug, Serialize)]
struct SurfaceValues {
    name: String,
    file: String,
    type_number: usize,
    sharp: bool,
    curvature: f64,
    motion: &'static str,
    velocity: [f64; 3],
    origin: [f64; 3],
    axis: [f64; 3],
    rate: f64,
    period: f64,
}

/// One dump of all spheres.
#[derive(Debug, Serialize)]
struct Dump {
    id: &'static str,
    every: u64,
    file: &'static str,
}

/// A wall that goes into the deck as triangles.
#[derive(Debug)]
pub struct Surface<'a> {
    wall: &'a Wall,
    mesh: Mesh,
    /// The wall stays in place and only its material moves (in-plane motion of a plane).
    in_place: bool,
}

impl Surface<'_> {
    /// Name of its STL file.
    pub fn file(&self) -> String {
        format!("wall_{}.stl", self.wall.name)
    }

    fn values(&self) -> SurfaceValues {
        let angle = inspect(&self.mesh).sharpest.map_or(PI, |(angle, _)| angle);
        let mut values = SurfaceValues {
            name: self.wall.name.clone(),
            file: self.file(),
            type_number: type_number(self.wall.material),
            sharp: angle < DEFAULT_CURVATURE,
            curvature: (0.5 * angle).to_degrees(),
            motion: "still",
            velocity: [0.0; 3],
            origin: [0.0; 3],
            axis: [0.0; 3],
            rate: 0.0,
            period: 0.0,
        };
        match &self.wall.motion {
            // Servo walls are refused (see the limits).
            Motion::Still | Motion::Servo { .. } => {}
            Motion::Oscillate { amplitude, frequency, .. } => {
                values.motion = "wiggle";
                values.velocity = plain(amplitude);
                values.period = 1.0 / frequency;
            }
            Motion::Translate { velocity } => {
                values.motion = if self.in_place { "slide" } else { "move" };
                values.velocity = plain(velocity);
            }
            Motion::Rotate { rate: 0.0, .. } => {}
            Motion::Rotate { origin, axis, rate } => {
                values.motion = if self.in_place { "spin" } else { "turn" };
                values.origin = plain(origin);
                // A period has no sign: the axis takes it.
                values.axis = plain(&(axis * rate.signum()));
                values.rate = rate.abs();
                values.period = TAU / rate.abs();
            }
        }
        values
    }
}

/// Walls of `model` that become meshes: meshes, oblique planes, and planes that
/// move in a way that primitive walls cannot.
pub fn surfaces(model: &Model) -> Vec<Surface<'_>> {
    let room = covered(model);
    model
        .walls
        .iter()
        .filter(|wall| primitive(wall).is_none())
        .map(|wall| match &wall.shape {
            WallShape::Mesh { mesh } => Surface { wall, mesh: mesh.clone(), in_place: false },
            WallShape::Plane { point, normal } => {
                let in_place = wall.stays_in_plane();
                let along_axis = wall.shape.axis_plane().is_some()
                    && matches!(wall.motion, Motion::Translate { .. });
                let mesh = if in_place || along_axis {
                    surface::plane_in(&room, point, normal)
                } else {
                    travelling_square(&room, wall, point, normal, model.plan.duration())
                };
                Surface { wall, mesh, in_place }
            }
        })
        .filter(|surface| !surface.mesh.triangles.is_empty())
        .collect()
}

/// A square of an oblique or turning plane that still covers the room when it has moved.
fn travelling_square(room: &Bounds, wall: &Wall, point: &Vec3, normal: &Vec3, time: f64) -> Mesh {
    let (centre, reach) = match &wall.motion {
        Motion::Rotate { origin, .. } => (*origin, (room.centre() - origin).norm()),
        Motion::Translate { velocity } => (room.centre(), velocity.norm() * time),
        Motion::Oscillate { amplitude, .. } => (room.centre(), 2.0 * amplitude.norm()),
        Motion::Still | Motion::Servo { .. } => (room.centre(), 0.0),
    };
    surface::square_mesh(
        &surface::project(&centre, point, normal),
        normal,
        0.5 * room.diagonal() + reach,
    )
}

/// A wall as a primitive plane, if it can be one: along an axis, and at rest
/// or sliding along one axis of its own plane.
fn primitive(wall: &Wall) -> Option<Plane> {
    let (axis, position, _) = wall.shape.axis_plane()?;
    let mut plane = Plane {
        name: wall.name.clone(),
        type_number: type_number(wall.material),
        axis: AXES[axis],
        position,
        shears: false,
        shear_axis: "",
        shear: 0.0,
    };
    match &wall.motion {
        Motion::Still => Some(plane),
        Motion::Oscillate { .. } | Motion::Servo { .. } => None,
        Motion::Translate { velocity } => {
            let moving: Vec<usize> = (0..3).filter(|a| velocity[*a] != 0.0).collect();
            match moving.as_slice() {
                [] => Some(plane),
                [along] if *along != axis => {
                    plane.shears = true;
                    plane.shear_axis = AXES[*along];
                    plane.shear = velocity[*along];
                    Some(plane)
                }
                _ => None,
            }
        }
        Motion::Rotate { rate, .. } => (*rate == 0.0).then_some(plane),
    }
}

/// Whether the deck has the wall as a primitive plane.
pub fn is_primitive(wall: &Wall) -> bool {
    primitive(wall).is_some()
}

/// The room in which spheres may touch walls: the domain and one radius around it.
fn covered(model: &Model) -> Bounds {
    let mut room = model.domain.grown(model.largest_radius());
    if model.needs().discs {
        let half = 0.5 * room.size().xy().max();
        (room.low.z, room.high.z) = (-half, half);
    }
    room
}

/// The simulation box: the covered room, everything that walls sweep, and a margin.
fn simulation_box(model: &Model, surfaces: &[Surface]) -> Bounds {
    let room = surfaces.iter().fold(covered(model), |room, surface| {
        if surface.in_place {
            return room.union(&surface.mesh.bounds());
        }
        room.union(&surface::swept(&surface.mesh, &surface.wall.motion, model.plan.duration()))
    });
    let mut all = room.grown(model.largest_radius());
    if let Some(cell) = &model.periodic {
        for axis in (0..3).filter(|axis| cell.periodic[*axis]) {
            (all.low[axis], all.high[axis]) = (cell.bounds.low[axis], cell.bounds.high[axis]);
        }
    }
    if model.needs().discs && !surfaces.is_empty() {
        // LIGGGHTS sorts mesh elements by bounding spheres, which must lie in the box.
        let half = 2.0 * all.size().xy().max();
        (all.low.z, all.high.z) = (-half, half);
    }
    all
}

/// Atom types count from 1.
fn type_number(material: u16) -> usize {
    usize::from(material) + 1
}

impl Script {
    /// Reads a model.
    pub fn new(
        solver: &dyn Solver,
        model: &Model,
        options: &DeckOptions,
        surfaces: &[Surface],
        points: &[Extra],
        limits: &[Limit],
    ) -> Self {
        let needs = model.needs();
        let steps = model.plan.steps;
        Self {
            header: Header::new(solver, model, limits),
            needs,
            rigid: is_rigid(model),
            multisphere: multisphere::is_used(model),
            boundary: boundary(model),
            tension: model.plan.law.tension,
            cohesion: cohesion_model(model).unwrap_or(""),
            rolling: rolling_model(model).unwrap_or(""),
            drag: model.extra.drag,
            processors: options.processors_text(model),
            skin: SKIN * model.smallest_radius(),
            points: points.len(),
            point_type: point_type(model),
            material_names: model
                .materials
                .iter()
                .map(|m| m.name.replace(['\n', '&'], " "))
                .collect(),
            tables: tables(model, &needs, model.materials.len() + usize::from(!points.is_empty())),
            step: model.plan.step,
            planes: model.walls.iter().filter_map(primitive).collect(),
            surfaces: surfaces.iter().map(Surface::values).collect(),
            gravity: model.gravity.norm(),
            gravity_direction: plain(&model.gravity),
            dumps: dumps(model),
            contact_columns: if needs.friction { 9 } else { 6 },
            last: steps.max(1),
            report_every: (steps / 100).max(1),
            restart_every: model.decks.restart_every(steps),
            steps,
            lost: if model.plan.guard.lost == Lost::Remove { "ignore" } else { "error" },
        }
    }
}

/// Whether clumps are there and held by `fix rigid`.
fn is_rigid(model: &Model) -> bool {
    model.needs().clumps && !multisphere::is_used(model)
}

/// Arguments of the `boundary` command.
fn boundary(model: &Model) -> String {
    let flat = model.needs().discs;
    let wraps = |axis: usize| model.periodic.is_some_and(|cell| cell.periodic[axis]);
    [0, 1, 2].map(|axis| if wraps(axis) || flat && axis == 2 { "p" } else { "f" }).join(" ")
}

/// Name of the cohesion model, empty for none; `None` if there are two.
pub fn cohesion_model(model: &Model) -> Option<&'static str> {
    let has = |circle: bool| {
        model.extra.any(|f| match f.cohesion {
            Some(Cohesion::Sjkr { .. }) => circle,
            Some(Cohesion::Sjkr2 { .. }) => !circle,
            _ => false,
        })
    };
    match (has(true), has(false)) {
        (true, true) => None,
        (true, false) => Some("sjkr"),
        (false, true) => Some("sjkr2"),
        (false, false) => Some(""),
    }
}

/// Name of the rolling model, empty for none; `None` if there are two.
pub fn rolling_model(model: &Model) -> Option<&'static str> {
    let kinds = [
        ("cdt", model.extra.any(|f| matches!(f.rolling, Some(Rolling::Cdt { .. })))),
        ("epsd", model.extra.any(|f| matches!(f.rolling, Some(Rolling::Epsd { .. })))),
        ("epsd2", model.extra.any(|f| matches!(f.rolling, Some(Rolling::Epsd2 { .. })))),
    ];
    let mut found = kinds.into_iter().filter(|(_, there)| *there).map(|(name, _)| name);
    match (found.next(), found.next()) {
        (None, _) => Some(""),
        (Some(name), None) => Some(name),
        _ => None,
    }
}

/// Tables of values of cohesion and rolling; those of points of mass are zero.
fn extra_tables(model: &Model, size: usize) -> Vec<Pairs> {
    let materials = model.materials.len();
    let table = |fix, property, value: fn(&PairForces) -> f64| {
        let pair = |a: usize, b: usize| match a.max(b) < materials {
            true => value(model.extra.between(a as u16, b as u16)),
            false => 0.0,
        };
        let rows = (0..size).map(|a| (0..size).map(|b| pair(a, b)).collect()).collect();
        Pairs { fix, property, size, rows }
    };
    let needs = model.needs();
    let mut tables = Vec::new();
    if needs.cohesion {
        tables.push(table("ced", "cohesionEnergyDensity", |f| match f.cohesion {
            Some(Cohesion::Sjkr { energy_density } | Cohesion::Sjkr2 { energy_density }) => {
                energy_density.0
            }
            _ => 0.0,
        }));
    }
    if needs.rolling {
        tables.push(table("rmu", "coefficientRollingFriction", |f| {
            f.rolling.map_or(0.0, |rolling| rolling.coefficient())
        }));
    }
    if rolling_model(model) == Some("epsd") {
        tables.push(table("reta", "coefficientRollingViscousDamping", |f| match f.rolling {
            Some(Rolling::Epsd { damping, .. }) => damping,
            _ => 0.0,
        }));
    }
    tables
}

/// Tables of contact values; those of points of mass are zero.
fn tables(model: &Model, needs: &Needs, size: usize) -> Vec<Pairs> {
    let materials = model.materials.len();
    let table = |fix, property, value: fn(&Contact) -> f64| {
        let pair = |a: usize, b: usize| match a.max(b) < materials {
            true => value(model.contacts.between(a as u16, b as u16)),
            false => 0.0,
        };
        let rows = (0..size).map(|a| (0..size).map(|b| pair(a, b)).collect()).collect();
        Pairs { fix, property, size, rows }
    };
    let mut tables = vec![
        table("kn", "kn", |c| c.kn),
        if needs.friction { table("kt", "kt", |c| c.kt) } else { table("kt", "kt", |_| 0.0) },
        table("cn", "gamman_abs", |c| c.cn),
        if needs.tangential_damping {
            table("ct", "gammat_abs", |c| c.ct)
        } else {
            table("ct", "gammat_abs", |_| 0.0)
        },
    ];
    if needs.friction {
        tables.push(table("mu", "coefficientFriction", |c| c.friction));
    }
    tables.extend(extra_tables(model, size));
    tables
}

/// Frames at every `frame_every`, and one at the end where that is not among them.
fn dumps(model: &Model) -> Vec<Dump> {
    let (every, steps) = (model.plan.frame_every.max(1), model.plan.steps);
    let mut dumps = vec![Dump { id: "frames", every, file: "spheres.dump" }];
    if steps % every != 0 {
        dumps.push(Dump { id: "last", every: steps, file: "last.dump" });
    }
    dumps
}

/// Values of `spheres.data` besides its tables.
#[derive(Debug, Serialize)]
pub struct Data {
    rigid: bool,
    types: usize,
    sides: Vec<Side>,
    atoms: usize,
    moves: bool,
}

#[derive(Debug, Serialize)]
struct Side {
    name: &'static str,
    low: f64,
    high: f64,
}

impl Data {
    /// Reads a model.
    pub fn new(model: &Model, surfaces: &[Surface], points: &[Extra]) -> Self {
        let bounds = simulation_box(model, surfaces);
        let sides = (0..3)
            .map(|a| Side { name: AXES[a], low: bounds.low[a], high: bounds.high[a] })
            .collect();
        let inserted = multisphere::is_used(model);
        let listed = |body: &&Body| !inserted || body.sphere_count == 1;
        let bodies = || model.bodies[..model.first_arrival()].iter().filter(listed);
        let spheres: usize = bodies().map(|body| body.sphere_count as usize).sum();
        Self {
            rigid: is_rigid(model),
            types: model.materials.len() + usize::from(!points.is_empty()),
            sides,
            atoms: spheres + points.len(),
            moves: bodies().any(|b| b.velocity.amax() > 0.0 || b.spin.amax() > 0.0),
        }
    }
}

/// A point of mass of a clump.
#[derive(Debug, Clone, Copy)]
pub struct Extra {
    body: usize,
    molecule: usize,
    point: Point,
}

/// Points of mass, in the order of the atoms that follow the spheres.
pub fn extras(model: &Model) -> Vec<Extra> {
    if multisphere::is_used(model) {
        return Vec::new();
    }
    let clumps = (0..model.bodies.len()).filter(|i| model.bodies[*i].sphere_count > 1);
    let extra = |(number, body)| {
        balance(model, body).point.map(|point| Extra { body, molecule: number + 1, point })
    };
    clumps.enumerate().filter_map(extra).collect()
}

/// All spheres. Every one has a density of its own, so that its mass is the one that the body
/// has in the model; points of mass come last.
pub fn atoms<'a>(model: &'a Model, points: &'a [Extra]) -> Table<'a> {
    let columns = &["id", "type", "diameter", "density", "x", "y", "z", "molecule"];
    Table::new("atoms", columns, move |rows| {
        let needs = model.needs();
        let sphere_volume = |r: f64| 4.0 / 3.0 * PI * r * r * r;
        let mut put = |id: usize, kind: usize, r: f64, density: f64, x: Vec3, molecule: usize| {
            let z = if needs.discs { 0.0 } else { x.z };
            let place = [2.0 * r, density, x.x, x.y, z].map(Cell::from);
            let [d, density, x, y, z] = place;
            rows.put(&[(id + 1).into(), kind.into(), d, density, x, y, z, molecule.into()])
        };
        let (inserted, mut molecule, mut number) = (multisphere::is_used(model), 0, 0);
        for (index, body) in model.bodies[..model.first_arrival()].iter().enumerate() {
            let clump = body.sphere_count > 1;
            if clump && inserted {
                continue;
            }
            molecule += usize::from(clump);
            let masses = if clump { balance(model, index).masses } else { vec![body.mass] };
            for (local, mass) in masses.iter().enumerate() {
                let sphere = body.first_sphere as usize + local;
                let Sphere { offset, radius: r, .. } = &model.spheres[sphere];
                // The plain sphere style takes discs for discs; the hybrid style does not.
                let flat = needs.discs && !needs.clumps;
                let volume = if flat { PI * r * r } else { sphere_volume(*r) };
                let place = body.position + body.orientation * offset;
                let own = if clump { molecule } else { 0 };
                put(number, type_number(body.material), *r, mass / volume, place, own)?;
                number += 1;
            }
        }
        let (kind, r) = (point_type(model), POINT_RADIUS * model.smallest_radius());
        for (number, Extra { body, molecule, point }) in points.iter().enumerate() {
            let place = model.bodies[*body].position + point.offset;
            let density = point.mass / sphere_volume(r);
            put(model.spheres.len() + number, kind, r, density, place, *molecule)?;
        }
        Ok(())
    })
}

/// Velocities and angular velocities of all spheres and points of mass.
pub fn velocities<'a>(model: &'a Model, points: &'a [Extra]) -> Table<'a> {
    Table::new("velocities", &["id", "vx", "vy", "vz", "wx", "wy", "wz"], move |rows| {
        let mut put = |id: usize, v: &Vec3, w: &Vec3| {
            let [x, y, z, u, v, w] = [v.x, v.y, v.z, w.x, w.y, w.z].map(Cell::from);
            rows.put(&[(id + 1).into(), x, y, z, u, v, w])
        };
        let (inserted, mut number) = (multisphere::is_used(model), 0);
        for (index, body) in model.bodies[..model.first_arrival()].iter().enumerate() {
            if inserted && body.sphere_count > 1 {
                continue;
            }
            let still = body.velocity.amax() == 0.0 && body.spin.amax() == 0.0;
            let spin = match body.sphere_count {
                1 => body.spin,
                _ if still => Vec3::zeros(),
                _ => start_of_clump(model, index, &balance(model, index)),
            };
            for _ in 0..body.sphere_count {
                put(number, &body.velocity, &spin)?;
                number += 1;
            }
        }
        for (number, Extra { body, .. }) in points.iter().enumerate() {
            put(model.spheres.len() + number, &model.bodies[*body].velocity, &Vec3::zeros())?;
        }
        Ok(())
    })
}

/// The angular velocity that each sphere of clump `index` must be given so that
/// `fix rigid` finds the angular momentum of the body.
///
/// `fix rigid` starts from L = Σ (mᵢ dᵢ × vᵢ + 0.4 mᵢ rᵢ² wᵢ). With vᵢ = v of the
/// body for all, one common w of the spheres and none of the point this is I ω for
/// Σ 0.4 mᵢ rᵢ² w = I ω − (Σ mᵢ dᵢ) × v.
fn start_of_clump(model: &Model, index: usize, balance: &Balance) -> Vec3 {
    let body = &model.bodies[index];
    let (_, radii) = offsets_and_radii(model, index);
    let own: f64 = balance.masses.iter().zip(&radii).map(|(m, r)| 0.4 * m * r * r).sum();
    let moment = balance.arm * body.mass;
    let wanted = inertia_tensor(model, index) * body.spin - moment.cross(&body.velocity);
    wanted / own
}

/// Masses of the spheres of clump `index`. Only gravity acts on them one by
/// one, so that without it none needs a point to balance.
fn balance(model: &Model, index: usize) -> Balance {
    let mass = model.bodies[index].mass;
    let (offsets, radii) = offsets_and_radii(model, index);
    // Not `needs`, which looks at every body: this is asked for each of them.
    if model.gravity.norm_squared() > 0.0 {
        return rigid_masses::balance(mass, &offsets, &radii);
    }
    let Masses { masses, arm } = rigid_masses::split(mass, &offsets, &radii);
    Balance { masses, point: None, arm }
}

/// Body and place in its frame of every point of mass, in the order of the atoms that follow the spheres.
pub fn points(model: &Model) -> Vec<(usize, Vec3)> {
    let place = |Extra { body, point, .. }: Extra| {
        (body, model.bodies[body].orientation.inverse_transform_vector(&point.offset))
    };
    extras(model).into_iter().map(place).collect()
}

fn point_type(model: &Model) -> usize {
    model.materials.len() + 1
}

/// Sphere centres from the centre of mass in world axes, and radii, of one body.
fn offsets_and_radii(model: &Model, index: usize) -> (Vec<Vec3>, Vec<f64>) {
    let body = &model.bodies[index];
    model.spheres_of(index).iter().map(|s| (body.orientation * s.offset, s.radius)).unzip()
}

/// Inertia tensor of body `index` in world axes.
fn inertia_tensor(model: &Model, index: usize) -> Mat3 {
    let body = &model.bodies[index];
    let axes = body.orientation.to_rotation_matrix();
    axes.matrix() * Mat3::from_diagonal(&body.inertia) * axes.matrix().transpose()
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

/// Mass properties of clumps, space axes.
pub fn rigid(model: &Model) -> Table<'_> {
    const COLUMNS: &[&str] =
        &["id", "mass", "x", "y", "z", "ixx", "iyy", "izz", "ixy", "ixz", "iyz"];
    Table::new("bodies", COLUMNS, move |rows| {
        let flat = model.needs().discs;
        let clumps = (0..model.bodies.len()).filter(|i| model.bodies[*i].sphere_count > 1);
        for (number, index) in clumps.enumerate() {
            let (x, i) = (&model.bodies[index].position, inertia_tensor(model, index));
            let z = if flat { 0.0 } else { x.z };
            let mass = model.bodies[index].mass;
            let row = [mass, x.x, x.y, z, i.m11, i.m22, i.m33, i.m12, i.m13, i.m23];
            let mut cells = [Cell::Count(number + 1); 11];
            cells[1..].copy_from_slice(&row.map(Cell::Number));
            rows.put(&cells)?;
        }
        Ok(())
    })
}

/// Values of an STL file: three corners and the normal of every triangle.
#[derive(Debug, Serialize)]
pub struct Stl {
    name: String,
    facets: Vec<[[f64; 3]; 4]>,
}

impl Stl {
    /// Reads a surface; every digit of its doubles is kept.
    pub fn new(surface: &Surface) -> Self {
        let facets = surface
            .mesh
            .facets()
            .map(|[a, b, c]| {
                let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros);
                [plain(&a), plain(&b), plain(&c), plain(&normal)]
            })
            .collect();
        Self { name: surface.wall.name.clone(), facets }
    }
}
