//! The values that the YADE templates print: one struct a template.

use super::series::{self, Class};
use crate::geometry::Bounds;
use crate::model::{Body, Contact, Dimension, Lost, Model, Motion, Needs, Wall, WallShape};
use crate::num::Vec3;
use crate::solver::deck::{Header, plain};
use crate::solver::table::{Cell, Table};
use crate::solver::{Limit, Solver, SolverError, surface};
use serde::Serialize;

/// `verletDist` over the smallest radius.
const VERLET: f64 = 0.1;

/// Values of `run.py`.
#[derive(Debug, Serialize)]
pub struct Script {
    header: Header,
    needs: Needs,
    materials: Vec<MaterialValues>,
    many_frictions: bool,
    frictions: Vec<(usize, usize, f64)>,
    planes: Vec<WallValues>,
    surfaces: Vec<WallValues>,
    oscillating: Vec<Oscillating>,
    /// Names of all walls in the deck.
    walls: Vec<String>,
    /// Steps between two looks for spheres outside the room below; 0 where they may go.
    lost_every: u64,
    room: [[f64; 2]; 3],
    servos: Vec<Servo>,
    moves: bool,
    verlet: f64,
    damping: f64,
    gravity: [f64; 3],
    /// Edge lengths of the periodic cell.
    cell: [f64; 3],
    bonds_every: usize,
    zero_every: u64,
    zero_until: u64,
    frame_every: u64,
    restart_every: u64,
    report_every: u64,
}

/// One YADE material: a material of the scene as bodies or as walls use it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaterialValues {
    name: String,
    density: f64,
    kn: f64,
    cn: f64,
    ks: f64,
    cs: f64,
    friction_angle: f64,
    #[serde(skip)]
    classes: Vec<Class>,
}

/// One wall; which of the motion values count is said by `motion`.
#[derive(Debug, Serialize)]
struct WallValues {
    variable: String,
    name: String,
    file: String,
    material: usize,
    point: [f64; 3],
    axis: usize,
    motion: &'static str,
    velocity: [f64; 3],
    origin: [f64; 3],
    turn: [f64; 3],
}

/// A wall that goes back and forth.
#[derive(Debug, Serialize)]
struct Oscillating {
    variable: String,
    amplitude: [f64; 3],
    frequency: f64,
    phase: f64,
}

/// A wall that seeks a force.
#[derive(Debug, Serialize)]
struct Servo {
    variable: String,
    direction: [f64; 3],
    force: f64,
    speed: f64,
}

/// The template without values.
#[derive(Debug, Serialize)]
pub struct Nothing {}

impl Script {
    /// Reads a model whose limits allow a deck.
    pub fn new(solver: &dyn Solver, model: &Model, limits: &[Limit]) -> Result<Self, SolverError> {
        let refuse = |reasons| SolverError::Refused { solver: solver.name(), reasons };
        let materials = materials(model).map_err(refuse)?;
        let frictions = frictions(model, &materials);
        let many = frictions.iter().any(|(_, _, mu)| *mu != frictions[0].2);
        let walls = |plane: bool| -> Vec<WallValues> {
            let numbered = model.walls.iter().enumerate();
            numbered
                .filter(|(_, wall)| is_plane(wall) == plane)
                .map(|(number, wall)| WallValues::new(number, wall, &materials))
                .collect()
        };
        Ok(Self {
            header: Header::new(solver, model, limits),
            needs: model.needs(),
            many_frictions: many,
            frictions,
            planes: walls(true),
            surfaces: walls(false),
            materials,
            oscillating: oscillating(model),
            walls: (0..model.walls.len()).map(variable).collect(),
            lost_every: if model.plan.guard.lost == Lost::Remove {
                crate::model::LOOK_EVERY
            } else {
                0
            },
            room: room(model),
            servos: servos(model),
            moves: moves(model),
            verlet: VERLET * model.smallest_radius(),
            damping: model.local_damping,
            gravity: plain(&model.gravity),
            cell: model.periodic.map_or([0.0; 3], |cell| plain(&cell.bounds.size())),
            bonds_every: super::bonds::looked_at_every(model),
            zero_every: model.plan.zero_every,
            zero_until: model.plan.zero_until.min(model.plan.steps),
            frame_every: model.plan.frame_every.max(1),
            restart_every: model.decks.restart_every(model.plan.steps),
            report_every: (model.plan.steps / 50).max(1),
        })
    }
}

/// Lowest and highest coordinates that a body may have; the largest numbers where it may go.
fn room(model: &Model) -> [[f64; 2]; 3] {
    [0, 1, 2].map(|axis| {
        let wraps = model.periodic.is_some_and(|cell| cell.periodic[axis]);
        match wraps || axis >= model.dimension.count() {
            true => [f64::MIN, f64::MAX],
            false => [model.domain.low[axis], model.domain.high[axis]],
        }
    })
}

/// Name of wall `number` in the deck.
fn variable(number: usize) -> String {
    format!("wall{number}")
}

fn oscillating(model: &Model) -> Vec<Oscillating> {
    let walls = model.walls.iter().enumerate();
    walls
        .filter_map(|(number, wall)| match &wall.motion {
            Motion::Oscillate { amplitude, frequency, phase } => Some(Oscillating {
                variable: variable(number),
                amplitude: plain(amplitude),
                frequency: *frequency,
                phase: *phase,
            }),
            _ => None,
        })
        .collect()
}

fn servos(model: &Model) -> Vec<Servo> {
    let walls = model.walls.iter().enumerate();
    walls
        .filter_map(|(number, wall)| match &wall.motion {
            Motion::Servo { direction, force, speed } => Some(Servo {
                variable: variable(number),
                direction: plain(direction),
                force: *force,
                speed: *speed,
            }),
            _ => None,
        })
        .collect()
}

/// A plane along an axis that stays one: at rest, sliding, or turning about its normal.
pub fn is_plane(wall: &Wall) -> bool {
    wall.shape.axis_plane().is_some()
        && (!matches!(wall.motion, Motion::Rotate { .. }) || wall.stays_in_plane())
}

impl WallValues {
    fn new(number: usize, wall: &Wall, materials: &[MaterialValues]) -> Self {
        let plane = is_plane(wall);
        let (axis, _, _) = wall.shape.axis_plane().unwrap_or((0, 0.0, 0.0));
        let mut values = Self {
            variable: variable(number),
            name: wall.name.clone(),
            file: facet_file(wall),
            material: index_of(materials, wall.material, true),
            point: [0.0; 3],
            axis,
            motion: "still",
            velocity: [0.0; 3],
            origin: [0.0; 3],
            turn: [0.0; 3],
        };
        if let WallShape::Plane { point, .. } = &wall.shape {
            values.point = plain(point);
        }
        match &wall.motion {
            // Walls of the other two kinds get their velocities in every step.
            Motion::Still | Motion::Oscillate { .. } | Motion::Servo { .. } => {}
            Motion::Translate { velocity } => {
                values.motion = "slide";
                values.velocity = plain(velocity);
            }
            Motion::Rotate { rate: 0.0, .. } => {}
            Motion::Rotate { origin, axis: turn, rate } if plane => {
                // The wall's own point must lie on the axis of rotation.
                let across = values.point[axis];
                values.point = plain(origin);
                values.point[axis] = across;
                values.motion = "spin";
                values.velocity = plain(&(turn * *rate));
            }
            Motion::Rotate { origin, axis: turn, rate } => {
                values.motion = "turn";
                values.origin = plain(origin);
                values.turn = plain(&(turn * *rate));
            }
        }
        values
    }
}

fn facet_file(wall: &Wall) -> String {
    format!("wall_{}.txt", wall.name)
}

/// The materials of the deck, or what makes them impossible.
///
/// A material that both bodies and walls have gets one entry if the same values
/// serve both. Without clumps `density` is the scene's; with clumps spheres must
/// be without mass, and masses are given body by body in either case.
pub fn materials(model: &Model) -> Result<Vec<MaterialValues>, Vec<String>> {
    let needs = model.needs();
    let classes = classes(model);
    let mut faults = Vec::new();
    let mut of = |name: &str, value: fn(&Contact) -> f64| {
        let pair = |a: &Class, b: &Class| value(model.contacts.between(a.material, b.material));
        series::solve(&classes, pair).unwrap_or_else(|unmet| {
            let called = |i: usize| &model.materials[usize::from(classes[i].material)].name;
            faults.push(format!(
                "YADE puts the {name} of two materials in series; {} N/m or N s/m between `{}` and `{}` is out of reach (it would be {}): at most twice the like pair at walls, the harmonic mean of the like pairs between bodies",
                unmet.wanted,
                called(unmet.first),
                called(unmet.second),
                unmet.got,
            ));
            vec![0.0; classes.len()]
        })
    };
    let kn = of("kn", |c| c.kn);
    let cn = of("cn", |c| c.cn);
    let none = vec![0.0; classes.len()];
    let ks = if needs.friction { of("kt", |c| c.kt) } else { none.clone() };
    let cs = if needs.tangential_damping { of("ct", |c| c.ct) } else { none };
    if !faults.is_empty() {
        return Err(faults);
    }
    let mut list: Vec<MaterialValues> = Vec::new();
    for (i, class) in classes.iter().enumerate() {
        let material = &model.materials[usize::from(class.material)];
        let friction = if needs.friction { common_friction(model, &classes) } else { 0.0 };
        let entry = MaterialValues {
            name: one_line(&material.name),
            density: if needs.clumps { 0.0 } else { material.density },
            kn: kn[i],
            cn: cn[i],
            ks: ks[i],
            cs: cs[i],
            friction_angle: friction.atan(),
            classes: vec![*class],
        };
        // Bodies and walls of one material share an entry where the same values serve both.
        let same = list.iter_mut().find(|other| {
            other.classes[0].material == class.material
                && MaterialValues { classes: other.classes.clone(), ..entry.clone() } == **other
        });
        match same {
            Some(other) => other.classes.push(*class),
            None => list.push(entry),
        }
    }
    Ok(list)
}

fn one_line(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Friction of the first pair that can meet; pairs that differ are listed one by one.
fn common_friction(model: &Model, classes: &[Class]) -> f64 {
    let bodies = || classes.iter().filter(|class| !class.wall);
    let Some(first) = bodies().next() else { return 0.0 };
    let other =
        if first.meets_itself { Some(first) } else { classes.iter().find(|class| class != &first) };
    other.map_or(0.0, |other| model.contacts.between(first.material, other.material).friction)
}

/// Materials as bodies use them, in order, then materials as walls use them.
fn classes(model: &Model) -> Vec<Class> {
    let count = model.materials.len() as u16;
    let mut users = vec![0_usize; model.materials.len()];
    for body in &model.bodies {
        users[usize::from(body.material)] += 1;
    }
    let bodies = (0..count).filter_map(|material| {
        let users = users[usize::from(material)];
        (users > 0).then_some(Class { material, wall: false, meets_itself: users > 1 })
    });
    let walls = (0..count).filter_map(|material| {
        let used = model.walls.iter().any(|wall| wall.material == material);
        used.then_some(Class { material, wall: true, meets_itself: false })
    });
    bodies.chain(walls).collect()
}

fn index_of(materials: &[MaterialValues], material: u16, wall: bool) -> usize {
    let user = |class: &Class| class.material == material && class.wall == wall;
    let found = materials.iter().position(|entry| entry.classes.iter().any(user));
    // `classes` lists every material that a body or wall of the model has.
    found.unwrap_or(0)
}

/// Friction of every two materials that can meet.
fn frictions(model: &Model, materials: &[MaterialValues]) -> Vec<(usize, usize, f64)> {
    let mut list = Vec::new();
    if !model.needs().friction {
        return list;
    }
    let bodies = |entry: &MaterialValues| entry.classes.iter().any(|class| !class.wall);
    let material = |entry: &MaterialValues| entry.classes[0].material;
    for (i, a) in materials.iter().enumerate() {
        for (j, b) in materials.iter().enumerate().skip(i) {
            if bodies(a) || bodies(b) {
                let contact = model.contacts.between(material(a), material(b));
                list.push((i, j, contact.friction));
            }
        }
    }
    list
}

/// Triangles of one wall.
#[derive(Debug, Serialize)]
pub struct Facets {
    facets: Vec<[f64; 9]>,
}

/// File name and triangles of every wall that is not an axis plane.
pub fn facets(model: &Model) -> Vec<(String, Facets)> {
    let room = model.domain;
    let walls = model.walls.iter().filter(|wall| !is_plane(wall));
    walls
        .map(|wall| {
            let facets = match &wall.shape {
                WallShape::Mesh { mesh } => mesh.facets().map(|corners| nine(&corners)).collect(),
                WallShape::Plane { point, normal } => {
                    vec![nine(&covering_triangle(
                        &room,
                        wall,
                        point,
                        normal,
                        model.plan.duration(),
                    ))]
                }
            };
            (facet_file(wall), Facets { facets })
        })
        .collect()
}

/// One triangle for a plane that covers the domain at all times, so that no
/// sphere comes near its edges.
fn covering_triangle(
    room: &Bounds,
    wall: &Wall,
    point: &Vec3,
    normal: &Vec3,
    time: f64,
) -> [Vec3; 3] {
    let (centre, reach) = match &wall.motion {
        Motion::Rotate { origin, .. } => (*origin, (room.centre() - origin).norm()),
        Motion::Translate { velocity } => (room.centre(), velocity.norm() * time),
        Motion::Oscillate { amplitude, .. } => (room.centre(), 2.0 * amplitude.norm()),
        Motion::Servo { speed, .. } => (room.centre(), speed * time),
        Motion::Still => (room.centre(), 0.0),
    };
    let foot = surface::project(&centre, point, normal);
    surface::triangle_around(&foot, normal, room.diagonal() + reach)
}

fn nine(corners: &[Vec3; 3]) -> [f64; 9] {
    let [a, b, c] = corners;
    [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z]
}

/// True if some body has a velocity or spin to be given, the half step of gravity included.
fn moves(model: &Model) -> bool {
    model.needs().gravity
        || model.bodies.iter().any(|b| b.velocity != Vec3::zeros() || b.spin != Vec3::zeros())
}

/// Velocity half a step before the start: v − Δt/2 g.
fn early(model: &Model, velocity: &Vec3) -> Vec3 {
    velocity - model.gravity * (0.5 * model.plan.step)
}

/// Values of `spheres.csv` besides its table.
#[derive(Debug, Serialize)]
pub struct Spheres {
    needs: Needs,
    moves: bool,
}

impl Spheres {
    /// Reads a model.
    pub fn new(model: &Model) -> Self {
        Self { needs: model.needs(), moves: moves(model) }
    }
}

/// The bodies of one sphere.
pub fn spheres(model: &Model) -> Table<'_> {
    const COLUMNS: &[&str] = &[
        "index", "material", "x", "y", "z", "radius", "mass", "inertia", "vx", "vy", "vz", "wx",
        "wy", "wz",
    ];
    Table::new("spheres", COLUMNS, move |rows| {
        let materials = body_materials(model);
        let bodies = &model.bodies[..model.first_arrival()];
        for body in bodies.iter().filter(|body| body.sphere_count == 1) {
            rows.put(&sphere(model, body, &materials))?;
        }
        Ok(())
    })
}

/// Index, material; place, radius, mass, moment of inertia, velocity half a step before, spin of a body of one sphere.
fn sphere(model: &Model, body: &Body, materials: &[usize]) -> [Cell; 14] {
    let flat = model.dimension == Dimension::Two;
    let (x, index) = (&body.position, body.first_sphere as usize);
    let inertia = if flat { body.inertia.z } else { body.inertia.x };
    let (v, w) = (early(model, &body.velocity), &body.spin);
    let z = if flat { 0.0 } else { x.z };
    let radius = model.spheres[index].radius;
    let row = [x.x, x.y, z, radius, body.mass, inertia, v.x, v.y, v.z, w.x, w.y, w.z];
    let mut cells = [Cell::Count(index); 14];
    cells[1] = materials[usize::from(body.material)].into();
    cells[2..].copy_from_slice(&row.map(Cell::Number));
    cells
}

/// The spheres that come during the run, in the order of time: the step after which each is there, and what `spheres.csv` says of it.
pub fn arrivals(model: &Model) -> Table<'_> {
    const COLUMNS: &[&str] = &[
        "step", "index", "material", "x", "y", "z", "radius", "mass", "inertia", "vx", "vy", "vz",
        "wx", "wy", "wz",
    ];
    Table::new("arrivals", COLUMNS, move |rows| {
        let materials = body_materials(model);
        for (index, body) in model.bodies.iter().enumerate().skip(model.first_arrival()) {
            let mut cells = [Cell::Count(model.arrival_step(index) as usize); 15];
            cells[1..].copy_from_slice(&sphere(model, body, &materials));
            rows.put(&cells)?;
        }
        Ok(())
    })
}

/// Place of every material of the scene in the deck's list, as bodies use it:
/// body classes come first, in order. 0 for materials that only walls have.
fn body_materials(model: &Model) -> Vec<usize> {
    let classes = classes(model);
    let place = |material: usize| {
        classes.iter().position(|c| !c.wall && usize::from(c.material) == material).unwrap_or(0)
    };
    (0..model.materials.len()).map(place).collect()
}

/// The bodies of several spheres: first member row, members, material; x, q (wxyz), mass,
/// moments, v, w, angular momentum.
pub fn clumps(model: &Model) -> Table<'_> {
    const COLUMNS: &[&str] = &[
        "first_sphere",
        "spheres",
        "material",
        "x",
        "y",
        "z",
        "qw",
        "qx",
        "qy",
        "qz",
        "mass",
        "i1",
        "i2",
        "i3",
        "vx",
        "vy",
        "vz",
        "wx",
        "wy",
        "wz",
        "lx",
        "ly",
        "lz",
    ];
    Table::new("clumps", COLUMNS, move |rows| {
        let flat = model.needs().discs;
        let materials = body_materials(model);
        let mut first = 0;
        for body in model.bodies.iter().filter(|body| body.sphere_count > 1) {
            let count = body.sphere_count as usize;
            let axes = body.orientation.to_rotation_matrix();
            let inertia = if flat {
                // Only the moment about z counts; the largest becomes YADE's third axis.
                let about_z = (0..3).map(|a| body.inertia[a] * axes[(2, a)].powi(2)).sum::<f64>();
                Vec3::new(0.5 * about_z, 0.75 * about_z, about_z)
            } else {
                body.inertia
            };
            let turn = if flat { crate::num::Rotation::identity() } else { body.orientation };
            let momentum = turn * inertia.component_mul(&turn.inverse_transform_vector(&body.spin));
            let (x, v, w) = (&body.position, early(model, &body.velocity), &body.spin);
            let z = if flat { 0.0 } else { x.z };
            let row = [
                x.x, x.y, z, turn.w, turn.i, turn.j, turn.k, body.mass, inertia.x, inertia.y,
                inertia.z, v.x, v.y, v.z, w.x, w.y, w.z, momentum.x, momentum.y, momentum.z,
            ];
            let mut cells = [Cell::Count(first); 23];
            cells[1] = count.into();
            cells[2] = materials[usize::from(body.material)].into();
            cells[3..].copy_from_slice(&row.map(Cell::Number));
            rows.put(&cells)?;
            first += count;
        }
        Ok(())
    })
}

/// Values of `members.csv` besides its table.
#[derive(Debug, Serialize)]
pub struct Members {
    needs: Needs,
}

impl Members {
    /// Reads a model.
    pub fn new(model: &Model) -> Self {
        Self { needs: model.needs() }
    }
}

/// The spheres of all clumps: index of the sphere in the scene, place from the centre
/// of mass, radius. Places are in body axes, in two dimensions in world axes.
pub fn members(model: &Model) -> Table<'_> {
    Table::new("members", &["index", "x", "y", "z", "radius"], move |rows| {
        let flat = model.needs().discs;
        for (index, sphere) in model.spheres.iter().enumerate() {
            let body = &model.bodies[sphere.body as usize];
            if body.sphere_count == 1 {
                continue;
            }
            let turned = body.orientation * sphere.offset;
            let place = if flat { Vec3::new(turned.x, turned.y, 0.0) } else { sphere.offset };
            let [x, y, z, r] = [place.x, place.y, place.z, sphere.radius].map(Cell::from);
            rows.put(&[index.into(), x, y, z, r])?;
        }
        Ok(())
    })
}
