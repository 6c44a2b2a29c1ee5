//! The scenes that are timed. Each is settled once by our own DEM, kept beside the
//! other build products, and given to every code in that same state.

use riprap::dem::{self, Observer};
use riprap::geometry::{Bounds, Mesh};
use riprap::model::*;
use riprap::num::random::{self, RngExt};
use riprap::num::{Job, Rotation, Vec3};
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

/// Radius of the spheres, m.
pub const RADIUS: f64 = 1e-3;
/// Density, kg/m³.
pub const DENSITY: f64 = 2500.0;
/// Normal stiffness, N/m.
pub const KN: f64 = 1e3;
/// Time step, s: a 22nd of the contact time of two spheres.
pub const STEP: f64 = 1e-5;
/// The variant without energy ledger.
pub const BARE: &str = "bare";
/// Width of the bed of 10 000 spheres, m.
const BED: f64 = 0.0405;
/// Radius and half length of the drum, m.
const DRUM: [f64; 2] = [0.035, 0.0225];

/// The model that a name such as `A10000`, `A10000-frictionless`, `A10000-2d`, `A10000-bare`, `B` or `C`
/// stands for, to be run for `steps` steps; settled on the first call.
pub fn model(name: &str, steps: u64, cache: &Path) -> Model {
    let (scene, variant) = name.split_once('-').unwrap_or((name, ""));
    let mut model = match scene {
        "A100000" => tiled(&model("A10000", 0, cache), 5, 2),
        "A1000000" => tiled(&model("A10000", 0, cache), 10, 10),
        _ if variant == "2d" => settled(name, cache),
        _ => settled(scene, cache),
    };
    if variant == "frictionless" {
        let contact = Contact { kt: 0.0, ct: 0.0, friction: 0.0, ..*model.contacts.between(0, 0) };
        model.contacts = ContactTable::uniform(1, contact);
        for body in &mut model.bodies {
            body.spin = Vec3::zeros();
        }
    }
    model.plan.steps = steps;
    model.plan.ledger = variant != BARE;
    model
}

/// Reads the settled scene, or settles it.
fn settled(name: &str, cache: &Path) -> Model {
    let path: PathBuf = cache.join(format!("{name}.json"));
    if let Some(model) =
        std::fs::read(&path).ok().and_then(|text| serde_json::from_slice(&text).ok())
    {
        return model;
    }
    eprintln!("settling {name} ...");
    let mut model = loose(name);
    model.plan.steps = 40_000;
    let mut last = Last(None);
    let summary =
        dem::simulate(&model, None, &Job::quiet(), &mut last).expect("the scene is sound");
    assert_eq!(summary.outcome, Outcome::Finished, "{name}");
    let frame = last.0.expect("a run has a last frame");
    for (body, state) in model.bodies.iter_mut().zip(&frame.bodies) {
        (body.position, body.orientation) = (state.position, state.orientation);
        (body.velocity, body.spin) = (state.velocity, state.spin);
    }
    std::fs::create_dir_all(cache).expect("the cache folder can be made");
    std::fs::write(&path, serde_json::to_vec(&model).expect("a model can be written"))
        .expect("the settled scene can be written");
    model
}

struct Last(Option<Frame>);

impl Observer for Last {
    fn frame(&mut self, frame: &Frame) {
        self.0 = Some(frame.clone());
    }
    fn row(&mut self, _row: &SeriesRow) {}
    fn checkpoint(&mut self, _bytes: &[u8]) {}
}

/// The scene before it settles.
fn loose(name: &str) -> Model {
    match name {
        "B" => drum(),
        "C" => clumps(),
        _ if name.ends_with("-2d") => discs(count(name.trim_end_matches("-2d"))),
        _ => bed(count(name)),
    }
}

fn count(name: &str) -> usize {
    name.trim_start_matches('A').parse().expect("a bed is called A and the number of its spheres")
}

fn empty(title: &str, dimension: Dimension, mass: f64) -> Model {
    // Restitution 0.5 between two spheres of this mass.
    let log = 0.5f64.ln();
    let cn = -2.0 * log * (KN * 0.5 * mass / (PI * PI + log * log)).sqrt();
    let contact = Contact { kn: KN, kt: KN * 2.0 / 7.0, cn, ct: 0.5 * cn, friction: 0.5 };
    let material = Material { name: "grain".to_owned(), density: DENSITY };
    let plan = Plan { step: STEP, insist: true, ..Plan::new(Scheme::Leapfrog) };
    Model {
        title: title.to_owned(),
        seed: 1,
        gravity: match dimension {
            Dimension::Two => -Vec3::y() * 9.81,
            Dimension::Three => -Vec3::z() * 9.81,
        },
        ..Model::empty(dimension, material, contact, plan)
    }
}

/// Mass of a sphere, kg.
pub fn sphere_mass() -> f64 {
    DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3)
}

fn add_sphere(model: &mut Model, place: Vec3, velocity: Vec3) {
    model.add_sphere(place, RADIUS, DENSITY, 0).velocity = velocity;
}

fn plane(model: &mut Model, axis: usize, at: f64, side: f64) {
    let mut unit = Vec3::zeros();
    unit[axis] = 1.0;
    model.walls.push(Wall {
        name: format!("wall{}", model.walls.len()),
        shape: WallShape::Plane { point: unit * at, normal: unit * side },
        motion: Motion::Still,
        material: 0,
    });
}

/// Four sides and a floor about [0, wide]².
fn sides(model: &mut Model, wide: [f64; 2], deep: f64) {
    for (axis, size) in wide.into_iter().enumerate() {
        plane(model, axis, 0.0, 1.0);
        plane(model, axis, size, -1.0);
    }
    plane(model, 2, 0.0, 1.0);
    model.domain = Bounds { low: Vec3::repeat(-RADIUS), high: Vec3::new(wide[0], wide[1], deep) }
        .grown(2.0 * RADIUS);
}

/// Spheres thrown loosely into a box of planes.
fn bed(count: usize) -> Model {
    let mut model = empty("settled bed", Dimension::Three, sphere_mass());
    let wide = BED * (count as f64 / 10_000.0).cbrt();
    let mut source = random::stream(1, "bench", 0);
    let cells = (wide / (2.3 * RADIUS)).floor() as usize;
    let pitch = wide / cells as f64;
    for index in 0..count {
        let (i, j, k) = (index % cells, index / cells % cells, index / cells / cells);
        let place = Vec3::new(i as f64 + 0.5, j as f64 + 0.5, k as f64 + 0.5) * pitch;
        let shake = Vec3::from_fn(|_, _| random::uniform(&mut source, -0.14, 0.14)) * RADIUS;
        let velocity = Vec3::from_fn(|_, _| random::uniform(&mut source, -0.3, 0.3));
        add_sphere(&mut model, place + shake, velocity);
    }
    let deep = (count / cells / cells + 2) as f64 * pitch;
    sides(&mut model, [wide, wide], deep);
    model
}

/// Discs thrown loosely into a trough.
fn discs(count: usize) -> Model {
    let mass = DENSITY * PI * RADIUS.powi(2);
    let mut model = empty("settled discs", Dimension::Two, mass);
    // A disc of 1 m thickness is 750 times as heavy: the same contact time.
    let heavier = mass / sphere_mass();
    let c = *model.contacts.between(0, 0);
    let contact = Contact { kn: c.kn * heavier, kt: c.kt * heavier, ..c };
    let contact = Contact { cn: c.cn * heavier.sqrt(), ct: c.ct * heavier.sqrt(), ..contact };
    model.contacts = ContactTable::uniform(1, contact);
    let cells = (count as f64).sqrt() as usize;
    let pitch = 2.2 * RADIUS;
    let mut source = random::stream(1, "bench", 1);
    for index in 0..count {
        let place = Vec3::new((index % cells) as f64 + 0.5, (index / cells) as f64 + 0.5, 0.0);
        let mut shake = || random::uniform(&mut source, -0.09, 0.09) * RADIUS;
        let shake = Vec3::new(shake(), shake(), 0.0);
        add_sphere(&mut model, place * pitch + shake, Vec3::zeros());
    }
    let wide = cells as f64 * pitch;
    plane(&mut model, 0, 0.0, 1.0);
    plane(&mut model, 0, wide, -1.0);
    plane(&mut model, 1, 0.0, 1.0);
    model.domain = Bounds {
        low: Vec3::new(0.0, 0.0, -1.0),
        high: Vec3::new(wide, (count / cells + 2) as f64 * pitch, 1.0),
    }
    .grown(2.0 * RADIUS);
    model
}

/// A cylinder of 1 920 triangles about the y axis, 10 000 spheres in it.
fn drum() -> Model {
    let mut model = empty("drum", Dimension::Three, sphere_mass());
    let ([radius, half], around, along) = (DRUM, 64u32, 12u32);
    let mut mesh = Mesh::default();
    let ring = |mesh: &mut Mesh, radius: f64, y: f64| -> u32 {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend((0..around).map(|k| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(around)).sin_cos();
            Vec3::new(radius * cos, y, radius * sin)
        }));
        first
    };
    let rings: Vec<u32> = (0..=along)
        .map(|k| ring(&mut mesh, radius, -half + 2.0 * half * f64::from(k) / f64::from(along)))
        .collect();
    let inner = [-half, half].map(|y| ring(&mut mesh, 0.5 * radius, y));
    let mut bands: Vec<[u32; 2]> = rings.windows(2).map(|w| [w[0], w[1]]).collect();
    bands.push([inner[0], rings[0]]);
    bands.push([rings[along as usize], inner[1]]);
    for [a, b] in bands {
        for k in 0..around {
            let l = (k + 1) % around;
            mesh.triangles.extend([[a + k, a + l, b + l], [a + k, b + l, b + k]]);
        }
    }
    for (first, y) in [(inner[0], -half), (inner[1], half)] {
        let centre = mesh.vertices.len() as u32;
        mesh.vertices.push(Vec3::new(0.0, y, 0.0));
        mesh.triangles.extend((0..around).map(|k| [centre, first + k, first + (k + 1) % around]));
    }
    assert_eq!(mesh.triangles.len(), 1920);
    model.walls.push(Wall {
        name: "drum".to_owned(),
        shape: WallShape::Mesh { mesh },
        motion: Motion::Rotate { origin: Vec3::zeros(), axis: Vec3::y(), rate: TAU / 4.0 },
        material: 0,
    });
    let mut source = random::stream(1, "bench", 2);
    let pitch = 2.15 * RADIUS;
    let rows = (2.0 * (half - 1.1 * RADIUS) / pitch).floor() as i32;
    let mut z = -radius;
    while model.bodies.len() < 10_000 {
        z += pitch;
        for i in -20..=20 {
            for j in 0..=rows {
                let place = Vec3::new(
                    f64::from(i) * pitch,
                    (f64::from(j) - 0.5 * f64::from(rows)) * pitch,
                    z,
                );
                let inside =
                    place.x.hypot(place.z) < radius * (PI / f64::from(around)).cos() - 1.1 * RADIUS;
                if inside && model.bodies.len() < 10_000 {
                    let shake = Vec3::from_fn(|_, _| random::uniform(&mut source, -0.07, 0.07));
                    add_sphere(&mut model, place + shake * RADIUS, Vec3::zeros());
                }
            }
        }
    }
    let high = Vec3::new(radius, half, radius);
    model.domain = Bounds { low: -high, high }.grown(2.0 * RADIUS);
    model
}

/// 1 000 rigid clumps of ten spheres in a box of planes.
fn clumps() -> Model {
    let mut model = empty("clumps", Dimension::Three, 3.0e-5);
    let mut source = random::stream(1, "bench", 3);
    let mut members: Vec<(Vec3, f64)> = (0..10)
        .map(|_| {
            let place =
                random::direction(&mut source) * (0.8 * RADIUS * source.random::<f64>().sqrt());
            (place, random::uniform(&mut source, 0.6, 1.0) * RADIUS)
        })
        .collect();
    let middle: Vec3 = members.iter().map(|m| m.0).sum::<Vec3>() / 10.0;
    members.iter_mut().for_each(|m| m.0 -= middle);
    let reach = members.iter().map(|m| m.0.norm() + m.1).fold(0.0, f64::max);
    let (cells, pitch) = (8, 2.05 * reach);
    let wide = cells as f64 * pitch;
    for index in 0..1000u32 {
        let cell = |n: u32| f64::from(n % cells) + 0.5;
        let height = f64::from(index / cells / cells) + 0.5;
        let position = Vec3::new(cell(index), cell(index / cells), height) * pitch;
        let first_sphere = model.spheres.len() as u32;
        model.spheres.extend(members.iter().map(|(offset, radius)| Sphere {
            offset: *offset,
            radius: *radius,
            body: index,
        }));
        model.bodies.push(Body {
            position,
            orientation: Rotation::from_scaled_axis(
                random::direction(&mut source) * PI * source.random::<f64>(),
            ),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            mass: 3.0e-5,
            inertia: Vec3::new(1.6e-11, 1.8e-11, 2.0e-11),
            first_sphere,
            sphere_count: 10,
            material: 0,
            family: 0,
            grain: 0,
        });
    }
    sides(&mut model, [wide, wide], 17.0 * pitch);
    model
}

/// Copies of a bed side by side, without walls between them.
fn tiled(bed: &Model, along: u32, across: u32) -> Model {
    let wide = BED;
    let mut model =
        Model { bodies: Vec::new(), spheres: Vec::new(), walls: Vec::new(), ..bed.clone() };
    for (i, j) in (0..across).flat_map(|j| (0..along).map(move |i| (i, j))) {
        let shift = Vec3::new(f64::from(i), f64::from(j), 0.0) * wide;
        for (body, sphere) in bed.bodies.iter().zip(&bed.spheres) {
            let index = model.bodies.len() as u32;
            model.bodies.push(Body {
                position: body.position + shift,
                first_sphere: index,
                ..body.clone()
            });
            model.spheres.push(Sphere { body: index, ..*sphere });
        }
    }
    sides(&mut model, [wide * f64::from(along), wide * f64::from(across)], bed.domain.high.z);
    model
}
