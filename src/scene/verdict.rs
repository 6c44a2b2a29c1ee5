//! Judging a scene without running it: a few grains of each family are made in
//! memory, the rest is arithmetic.

use super::build::{self, Built};
use super::grains::{self, Grain};
use super::walls::Room;
use super::{Loaded, SceneError};
use crate::dem;
use crate::dem::limit::Advice;
use crate::geometry::Region;
use crate::model::{Dimension, FarMethod, Model};
use crate::num::{Fault, Job, Rotation, Vec3};
use crate::pack::{Measures, Packing, Placement};
use crate::scene::materials::PairFacts;
use crate::solver::{self, LimitKind};
use serde::Serialize;

/// Distinct grains of each family that are made to judge a scene.
const SAMPLES: usize = 5;
/// Distinct plain spheres of each family that are looked at.
const PLAIN_SAMPLES: usize = 2_000;
/// Memory of our own DEM for one sphere while a frame is written, bytes (measured on 100 000
/// spheres, see validation/06-hundred-thousand).
const BYTES_PER_SPHERE: f64 = 600.0;
/// Seconds for one term of gravity between bodies on one thread (order of magnitude).
const SECONDS_PER_TERM: f64 = 1e-8;
/// Sphere-steps a second of our own DEM on one thread (order of magnitude, for the forecast of time).
const SPEED: f64 = 4e6;

/// How neighbours are searched (D11). Cells are as wide as the largest sphere and the skin, so few
/// spheres share one: measured faster than cells of 5 to 20 spheres (see `dem/neighbours.rs`).
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Lists {
    /// Edge of a cell of the coarsest level, m.
    pub cell: f64,
    /// Mean number of spheres a cell over the container, if there is one.
    pub spheres_per_cell: Option<f64>,
    /// Gap up to which pairs are listed, m.
    pub skin: f64,
    /// Steps between two rebuilds at the fastest speed expected; `None` if nothing moves.
    pub steps_between: Option<f64>,
    /// Rebuilds of the whole run at that speed: an upper forecast.
    pub rebuilds: u64,
}

impl Lists {
    fn of(model: &Model, advice: &Advice, spheres: f64, volume: Option<f64>) -> Self {
        let radii = || model.spheres.iter().map(|sphere| sphere.radius);
        let largest = radii().fold(0.0, f64::max);
        let skin = dem::list_skin(model);
        let cell = 2.0 * largest + skin;
        let size = if model.dimension == Dimension::Two { cell * cell } else { cell.powi(3) };
        // The advice takes a tenth of the smallest radius a step at that speed.
        let speed = advice.speed.map(|step| 0.1 * radii().fold(f64::INFINITY, f64::min) / step);
        let steps_between =
            speed.map(|speed| (0.5 * skin / (speed * model.plan.step)).floor().max(1.0));
        Self {
            cell,
            spheres_per_cell: volume.map(|volume| spheres * size / volume),
            skin,
            steps_between,
            rebuilds: 1 + steps_between.map_or(0, |steps| (model.plan.steps as f64 / steps) as u64),
        }
    }
}

/// Seconds of all passes of gravity between bodies on one thread.
fn far_seconds(model: &Model, bodies: f64) -> f64 {
    let terms = match model.mutual.map(|law| law.method) {
        None => return 0.0,
        Some(FarMethod::AllPairs) => bodies,
        // Shells of cells seen under the angle θ, one for each doubling of the distance.
        Some(FarMethod::Tree(tree)) => {
            (4.0 / tree.theta.powi(3) * bodies.max(2.0).log2()).min(bodies)
        }
    };
    bodies * terms * model.plan.steps as f64 * SECONDS_PER_TERM
}

/// What `riprap check` says of a scene.
#[derive(Debug, Clone, Serialize)]
pub struct Verdict {
    /// Title of the scene.
    pub title: String,
    /// Grains asked for.
    pub grains: u64,
    /// Spheres that stand for them, from a few grains of each family.
    pub spheres: u64,
    /// Number of walls.
    pub walls: usize,
    /// Time step, s.
    pub step: f64,
    /// Why.
    pub reason: String,
    /// Number of steps.
    pub steps: u64,
    /// Stability limits and overlap forecast.
    pub advice: Advice,
    /// Contact parameters by pair of materials.
    pub pairs: Vec<PairFacts>,
    /// What the scene needs, as keys.
    pub needs: Vec<&'static str>,
    /// What is left out of kernels, decks and memory, as keys.
    pub left_out: Vec<&'static str>,
    /// Memory of our own DEM, bytes.
    pub memory: f64,
    /// Seconds that our own DEM will take on one thread.
    pub seconds: f64,
    /// Cells and lists of neighbours.
    pub lists: Lists,
    /// What is possible but hardly meant.
    pub warnings: Vec<String>,
    /// What outside solvers cannot do or do differently.
    pub solvers: Vec<String>,
}

/// What a few grains of each family tell of the whole scene.
struct Sample {
    built: Built,
    /// Spheres of all grains.
    spheres: f64,
    /// Volume of all grains that are packed, m³ (discs: m²).
    solid: f64,
    /// Volume of the container.
    room: Option<f64>,
}

/// Overlap at rest over the radius from which contacts count as too soft.
const SOFT: f64 = 0.05;

/// What is possible but hardly meant.
fn warnings(loaded: &Loaded, sample: &Sample, advice: &Advice, memory: f64) -> Vec<String> {
    let mut all = Vec::new();
    let keeps_sizes = !loaded.scene.packing.makes_sizes();
    if let Some(room) = sample.room.filter(|room| keeps_sizes && sample.solid > *room) {
        all.push(format!(
            "the grains alone take {:.3e} times the volume of the container: most will find no place \
             (numbers without a unit are metres)",
            sample.solid / room
        ));
    }
    if advice.static_overlap > SOFT {
        all.push(format!(
            "grains at rest sink about {:.3e} radii into each other; usual is 0.01 or less: \
             give stiffer contacts (kn or young)",
            advice.static_overlap
        ));
    }
    if let Some(free) = free_memory().filter(|free| memory > *free) {
        let (needs, free) = (memory / 1e9, free / 1e9);
        all.push(format!("needs about {needs:.1} GB of memory; {free:.1} GB are free here"));
    }
    all
}

/// Memory that programs can still get, bytes; `None` where the system does not tell.
fn free_memory() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok().map(|kilobytes| kilobytes * 1024.0)
}

impl Verdict {
    /// Judges a scene.
    ///
    /// # Errors
    /// Everything that would stop the scene before its run.
    pub fn of(loaded: &Loaded, job: &Job) -> Result<Self, SceneError> {
        let sample = sample(loaded, job).map_err(|fault| loaded.wrong(&[fault]))?;
        let spheres = sample.spheres;
        let memory = spheres * BYTES_PER_SPHERE;
        let warnings = warnings(loaded, &sample, &sample.built.advice, memory);
        let volume = sample.room;
        let Built { model, pairs, advice } = sample.built;
        let lists = Lists::of(&model, &advice, spheres, volume);
        let grains: u64 = loaded.scene.grains.iter().map(|family| u64::from(family.count)).sum();
        let (needs, left_out): (Vec<_>, Vec<_>) =
            model.needs().table().into_iter().partition(|row| row.2);
        let key = |rows: Vec<(&'static str, &'static str, bool)>| {
            rows.into_iter().map(|row| row.0).collect()
        };
        let reason = match &model.plan.reason {
            crate::model::StepReason::Given => "given in the scene".to_owned(),
            crate::model::StepReason::Auto(reason) => reason.clone(),
        };
        let solvers = solver::all()
            .into_iter()
            .flat_map(|s| {
                s.limits(&model).into_iter().map(move |limit| match limit.kind {
                    LimitKind::Refused => {
                        format!("{} cannot run this scene: {}", s.name(), limit.what)
                    }
                    _ => format!("{}: {}", s.name(), limit.what),
                })
            })
            .collect();
        Ok(Self {
            title: model.title.clone(),
            grains,
            spheres: spheres.round() as u64,
            walls: model.walls.len(),
            step: model.plan.step,
            reason,
            steps: model.plan.steps,
            advice,
            pairs,
            needs: key(needs),
            left_out: key(left_out),
            memory,
            seconds: spheres * model.plan.steps as f64 / SPEED + far_seconds(&model, grains as f64),
            lists,
            warnings,
            solvers,
        })
    }
}

/// A model of a few grains of each family, side by side without contact, and
/// what the whole scene will have of spheres and volumes.
fn sample(loaded: &Loaded, job: &Job) -> Result<Sample, Fault> {
    let room = Room::of(loaded)?;
    let mut samples: Vec<Grain> = Vec::new();
    let (mut spheres, mut solid) = (0.0, 0.0);
    let draws = grains::draws(loaded)?;
    for (number, family) in loaded.scene.grains.iter().enumerate() {
        let first = samples.len();
        let plain = matches!(family.shape, crate::shape::Shape::Sphere);
        let most = if plain { PLAIN_SAMPLES } else { SAMPLES };
        for draw in draws.iter().filter(|draw| draw.family == number as u16).take(most) {
            let solid = grains::made(loaded, draw)?.map(|made| made.solid);
            let clump = grains::reproduce(loaded, draw, solid.as_ref(), job)?;
            samples.push(Grain { family: draw.family, solid, clump });
        }
        let made = samples.len() - first;
        let balls: usize = samples[first..].iter().map(|grain| grain.clump.balls.len()).sum();
        let each = f64::from(family.count) / made.max(1) as f64;
        spheres += each * balls as f64;
        if family.insertion.is_none() {
            let volumes = samples[first..].iter().map(|grain| grain.clump.volume);
            solid += each * volumes.sum::<f64>();
        }
    }
    let packing =
        side_by_side(&samples, room.region.as_ref().map_or_else(Vec3::zeros, |r| top(loaded, r)));
    let copies: Vec<u32> = (0..samples.len() as u32).collect();
    let (region, walls) = (room.region.as_ref(), &room.walls);
    let mut built = build::build(loaded, region, walls, &samples, &copies, &packing, &[])?;
    if loaded.scene.grains.iter().any(|family| family.insertion.is_some()) {
        // One that comes stands for all: what solvers can say depends on whether there is any.
        built.model.arrivals = vec![loaded.scene.plan.duration.0];
    }
    Ok(Sample { built, spheres, solid, room: room.region.as_ref().map(Region::volume) })
}

/// The highest place of a region, against gravity: grains may fall from there.
fn top(loaded: &Loaded, region: &Region) -> Vec3 {
    let bounds = region.bounds();
    let up = -loaded.scene.gravity().try_normalize(0.0).unwrap_or_else(Vec3::zeros);
    bounds.centre() + up * (0.5 * up.abs().dot(&bounds.size()))
}

/// Grains in a row far from each other.
fn side_by_side(samples: &[Grain], start: Vec3) -> Packing {
    let mut x = 0.0;
    let placements = samples
        .iter()
        .enumerate()
        .map(|(index, grain)| {
            let radius = grain.clump.bounding_radius();
            x += 3.0 * radius;
            let position = start + Vec3::new(x, 0.0, 0.0);
            x += 3.0 * radius;
            Placement {
                grain: index as u32,
                position,
                orientation: Rotation::identity(),
                velocity: Vec3::zeros(),
                spin: Vec3::zeros(),
                scale: 1.0,
            }
        })
        .collect();
    Packing {
        placements,
        dropped: Vec::new(),
        outcome: String::new(),
        measures: Measures {
            container_volume: 0.0,
            porosity: 1.0,
            porosity_error: 0.0,
            coordination: 0.0,
            gap_tolerance: 0.0,
            worst_overlap: 0.0,
            least_gap: None,
        },
    }
}
