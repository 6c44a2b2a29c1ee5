//! The three bulk scenes, and what is measured of a run whichever code did it: places of spheres
//! in frames only, so that codes are not asked for what they define in their own ways.

use crate::geometry::{Bounds, Mesh};
use crate::model::restitution::dashpot;
use crate::model::{Contact, Frame, Model, Motion, Run, Scheme, Wall, WallShape};
use crate::num::statistics::{mean, quantile};
use crate::num::{Vec3, random};
use crate::study::models;
use std::f64::consts::{PI, TAU};

/// Mean radius, m; density, kg/m³; stiffness, N/m; restitution; friction.
const RADIUS: f64 = 0.005;
const DENSITY: f64 = 2500.0;
const KN: f64 = 1e4;
const RESTITUTION: f64 = 0.5;
const FRICTION: f64 = 0.5;
/// Places of spheres at the start, in radii: apart even where radii are 10 % larger.
const PITCH: f64 = 2.3;
/// Force on the lid of the compression at which the bed is looked at, over the area, Pa.
const STRESS: f64 = 2000.0;
/// Rotation of the drum about the y axis, rad/s.
const RATE: f64 = PI;

/// Something measured at the end of a run.
pub struct Quantity {
    /// Name.
    pub name: &'static str,
    /// Unit; empty for pure numbers.
    pub unit: &'static str,
    /// Difference within which two codes count as equivalent, in this unit.
    pub margin: f64,
}

/// How large a scene is.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Spheres along the three axes at the start (drum: along its axis, and in all).
    pub counts: [u32; 3],
    /// Simulated time, s.
    pub time: f64,
}

/// A bulk scene.
pub struct Bulk {
    /// Key of its files.
    pub key: &'static str,
    /// What happens.
    pub what: &'static str,
    /// Quantities, the one of the charts first.
    pub quantities: &'static [Quantity],
    /// Frames over the run.
    pub frames: u64,
    /// Bodies and walls for a seed.
    pub build: fn(&mut Model, Extent, u64),
    /// Its quantities, in their order; NaN where the run does not have one.
    pub measure: fn(&Model, &Run) -> Vec<f64>,
}

/// All scenes.
pub const SCENES: [Bulk; 3] = [
    Bulk {
        key: "collapse",
        what: "Collapse into a trench",
        quantities: &[
            Quantity { name: "angle of the heap", unit: "degrees", margin: 1.0 },
            Quantity { name: "run-out", unit: "mm", margin: 5.0 },
        ],
        frames: 1,
        build: column,
        measure: heap,
    },
    Bulk {
        key: "drum",
        what: "Drum at 30 rpm (mesh)",
        quantities: &[
            Quantity { name: "angle in the drum", unit: "degrees", margin: 1.5 },
            Quantity { name: "distance from the axis", unit: "mm", margin: 0.5 },
        ],
        frames: 80,
        build: drum,
        measure: flow,
    },
    Bulk {
        key: "compression",
        what: "Bed under a lid, 2 kPa",
        quantities: &[
            Quantity { name: "porosity", unit: "", margin: 0.01 },
            Quantity { name: "contacts a sphere", unit: "", margin: 0.3 },
            Quantity { name: "side stress over stress", unit: "", margin: 0.1 },
        ],
        frames: 400,
        build: bed,
        measure: pressed,
    },
];

/// The model of a scene at a step of `per_contact` a collision of two spheres.
pub fn model(bulk: &Bulk, extent: Extent, seed: u64, scheme: Scheme, per_contact: f64) -> Model {
    let mass = DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3);
    let contact = Contact {
        kn: KN,
        kt: 2.0 / 7.0 * KN,
        // A restitution within (0, 1] always has a dashpot.
        cn: dashpot(RESTITUTION, KN, 0.5 * mass, false).unwrap_or(0.0),
        ct: 0.0,
        friction: FRICTION,
    };
    let mut model = models::empty(scheme, contact, DENSITY);
    model.title = bulk.what.to_owned();
    model.seed = seed;
    model.gravity = Vec3::z() * -9.81;
    (bulk.build)(&mut model, extent, seed);
    let step = PI * (0.5 * mass / KN).sqrt() / per_contact;
    let a_frame = (extent.time / bulk.frames as f64 / step).ceil();
    let plan = &mut model.plan;
    plan.step = extent.time / bulk.frames as f64 / a_frame;
    plan.steps = bulk.frames * a_frame as u64;
    plan.frame_every = a_frame as u64;
    plan.series_every = plan.steps;
    model
}

/// Outside solvers sort the whole domain into cells, so it is no larger than the scene.
fn room(model: &mut Model, low: Vec3, high: Vec3) {
    model.domain = Bounds { low, high }.grown(RADIUS);
}

/// Spheres of ±10 % radii on a lattice that leans, with places off by ±0.05 radii.
fn lattice(
    model: &mut Model,
    counts: [u32; 3],
    seed: u64,
    corner: Vec3,
    keep: impl Fn(&Vec3) -> bool,
) {
    let mut source = random::stream(seed, "ensembles", 0);
    for index in 0..counts[0] * counts[1] * counts[2] {
        let [x, y, z] =
            [index % counts[0], index / counts[0] % counts[1], index / counts[0] / counts[1]];
        let jitter = Vec3::from_fn(|_, _| random::uniform(&mut source, -0.05, 0.05));
        let radius = RADIUS * random::uniform(&mut source, 0.9, 1.1);
        let place = Vec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, f64::from(z) + 0.5) * PITCH;
        let place = corner + (place + jitter) * RADIUS;
        if keep(&place) {
            models::sphere(model, place, radius, DENSITY, Vec3::zeros());
        }
    }
}

fn wall(model: &mut Model, axis: usize, at: f64, side: f64) {
    let (mut point, mut normal) = (Vec3::zeros(), Vec3::zeros());
    (point[axis], normal[axis]) = (at, side);
    models::plane(model, point, normal, Motion::Still);
}

/// Floor, back wall and two side walls; open towards +x.
fn column(model: &mut Model, extent: Extent, seed: u64) {
    let [length, width, height] = extent.counts.map(|count| PITCH * RADIUS * f64::from(count));
    // Single spheres roll off, but not that far.
    let far = length + 5.0 * height;
    room(model, Vec3::zeros(), Vec3::new(far, width, height));
    wall(model, 2, 0.0, 1.0);
    wall(model, 0, 0.0, 1.0);
    wall(model, 1, 0.0, 1.0);
    wall(model, 1, width, -1.0);
    lattice(model, extent.counts, seed, Vec3::zeros(), |_| true);
}

/// A wedge against the back wall has its centre of mass at a third of its length and height, so
/// its slope is that of the centre of mass; the run-out is passed by 5 % of the spheres.
fn heap(_: &Model, run: &Run) -> Vec<f64> {
    let Some(frame) = run.frames.last() else { return vec![f64::NAN; 2] };
    let centre = middle(frame);
    let along: Vec<f64> = frame.centres.iter().map(|place| place.x).collect();
    let far = quantile(&along, 0.95).unwrap_or(f64::NAN);
    vec![centre.z.atan2(centre.x).to_degrees(), 1e3 * far]
}

fn middle(frame: &Frame) -> Vec3 {
    frame.centres.iter().sum::<Vec3>() / frame.centres.len() as f64
}

/// Radius of the drum, m.
fn drum_radius(extent: Extent) -> f64 {
    PITCH * RADIUS * 0.5 * f64::from(extent.counts[0])
}

/// A mesh of 24 sides about the y axis between two planes; filled from below.
fn drum(model: &mut Model, extent: Extent, seed: u64) {
    const SIDES: u32 = 24;
    let (radius, width) = (drum_radius(extent), PITCH * RADIUS * f64::from(extent.counts[1]));
    room(model, Vec3::new(-radius, 0.0, -radius), Vec3::new(radius, width, radius));
    // The sheet reaches beyond the planes: nothing touches its rim.
    let corner = |k: u32, y: f64| {
        let angle = TAU * f64::from(k) / f64::from(SIDES);
        Vec3::new(radius * angle.cos(), y, radius * angle.sin())
    };
    let vertices = (0..SIDES)
        .flat_map(|k| [corner(k, -2.0 * RADIUS), corner(k, width + 2.0 * RADIUS)])
        .collect();
    let triangles = (0..SIDES)
        .flat_map(|k| {
            let (a, b) = (2 * k, 2 * ((k + 1) % SIDES));
            [[a, b, b + 1], [a, b + 1, a + 1]]
        })
        .collect();
    model.walls.push(Wall {
        name: "drum".to_owned(),
        shape: WallShape::Mesh { mesh: Mesh { vertices, triangles } },
        motion: Motion::Rotate { origin: Vec3::zeros(), axis: Vec3::y(), rate: RATE },
        material: 0,
    });
    wall(model, 1, 0.0, 1.0);
    wall(model, 1, width, -1.0);
    let across = extent.counts[0];
    let flat = radius * (PI / f64::from(SIDES)).cos() - 1.2 * RADIUS;
    let counts = [across, extent.counts[1], extent.counts[2]];
    let corner = Vec3::new(-radius, 0.0, -radius);
    lattice(model, counts, seed, corner, |place| place.x.hypot(place.z) < flat);
}

/// Where the centre of mass is seen from the axis, over the second half of the run.
fn flow(_: &Model, run: &Run) -> Vec<f64> {
    let late = &run.frames[run.frames.len() / 2..];
    let centres: Vec<Vec3> = late.iter().map(middle).collect();
    let angles: Vec<f64> = centres.iter().map(|c| (-c.x).atan2(-c.z).to_degrees()).collect();
    let depths: Vec<f64> = centres.iter().map(|c| 1e3 * c.x.hypot(c.z)).collect();
    vec![mean(&angles).unwrap_or(f64::NAN), mean(&depths).unwrap_or(f64::NAN)]
}

/// A box with a lid that comes down until the bed is dense.
fn bed(model: &mut Model, extent: Extent, seed: u64) {
    let side = |axis: usize| PITCH * RADIUS * f64::from(extent.counts[axis]);
    room(model, Vec3::zeros(), Vec3::new(side(0), side(1), side(2)));
    wall(model, 2, 0.0, 1.0);
    for axis in [0, 1] {
        wall(model, axis, 0.0, 1.0);
        wall(model, axis, side(axis), -1.0);
    }
    let narrow = f64::from(extent.counts[0].min(extent.counts[1]));
    // Solid fraction of the lattice, and of a dense bed between walls that many spheres apart.
    let (loose, dense) = (4.0 / 3.0 * PI / PITCH.powi(3), 0.57 * (1.0 - 0.4 / narrow));
    let (top, end) = (side(2), loose / dense * side(2));
    let speed = (top - end) / extent.time;
    models::plane(
        model,
        Vec3::z() * top,
        -Vec3::z(),
        Motion::Translate { velocity: Vec3::z() * -speed },
    );
    lattice(model, extent.counts, seed, Vec3::zeros(), |_| true);
}

/// The bed where the springs at the lid first carry [`STRESS`], between two frames.
fn pressed(model: &Model, run: &Run) -> Vec<f64> {
    let sizes = |wall: usize| match &model.walls[wall].shape {
        WallShape::Plane { point, .. } => *point,
        WallShape::Mesh { .. } => Vec3::zeros(),
    };
    let (across, along) = (sizes(2).x, sizes(4).y);
    let lid = model.walls.len() - 1;
    let stress = |frame: &Frame| force_on(model, frame, lid) / (across * along);
    let height = |frame: &Frame| model.walls[lid].motion.place(&sizes(lid), frame.time).z;
    let Some(at) = run.frames.iter().position(|frame| stress(frame) >= STRESS) else {
        return vec![f64::NAN; 3];
    };
    let (now, before) = (&run.frames[at], &run.frames[at.saturating_sub(1)]);
    let (low, high) = (stress(before), stress(now));
    let part = if high > low { (STRESS - low) / (high - low) } else { 1.0 };
    let level = height(before) + part * (height(now) - height(before));
    let solid: f64 = model.spheres.iter().map(|s| 4.0 / 3.0 * PI * s.radius.powi(3)).sum();
    let sides: f64 = (1..5).map(|wall| force_on(model, now, wall)).sum();
    let side_stress = sides / (2.0 * (across + along) * height(now));
    vec![1.0 - solid / (across * along * level), contacts(model, now), side_stress / high]
}

/// Force of the springs between the spheres and a plane, N.
fn force_on(model: &Model, frame: &Frame, wall: usize) -> f64 {
    let wall = &model.walls[wall];
    let WallShape::Plane { point, normal } = &wall.shape else { return 0.0 };
    let point = wall.motion.place(point, frame.time);
    let spheres = frame.centres.iter().zip(&model.spheres);
    spheres.map(|(c, s)| KN * (s.radius - (c - point).dot(normal)).max(0.0)).sum()
}

/// Mean number of spheres and walls that a sphere touches.
fn contacts(model: &Model, frame: &Frame) -> f64 {
    let mut count = 0_usize;
    for (i, (a, first)) in frame.centres.iter().zip(&model.spheres).enumerate() {
        let later = frame.centres[i + 1..].iter().zip(&model.spheres[i + 1..]);
        count += 2 * later.filter(|(b, s)| (a - *b).norm() < first.radius + s.radius).count();
        let at_wall = |wall: &&Wall| match &wall.shape {
            WallShape::Plane { point, normal } => {
                (a - wall.motion.place(point, frame.time)).dot(normal) < first.radius
            }
            WallShape::Mesh { .. } => false,
        };
        count += model.walls.iter().filter(at_wall).count();
    }
    count as f64 / frame.centres.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dem;
    use crate::model::Outcome;
    use crate::num::Job;

    fn frame(centres: Vec<Vec3>, time: f64) -> Frame {
        let model = models::empty(
            Scheme::Leapfrog,
            Contact { kn: KN, kt: 0.0, cn: 0.0, ct: 0.0, friction: 0.0 },
            DENSITY,
        );
        Frame { time, centres, ..Frame::initial(&model) }
    }

    #[test]
    fn a_wedge_has_the_angle_of_its_slope() {
        // Points spread evenly over a triangle of length 3 and height 1.
        let centres: Vec<Vec3> = (0..300)
            .flat_map(|i| (0..100).map(move |k| (0.01 * f64::from(i), 0.01 * f64::from(k))))
            .filter(|(x, z)| x / 3.0 + z < 1.0)
            .map(|(x, z)| Vec3::new(x, 0.0, z))
            .collect();
        let run = Run { frames: vec![frame(centres, 0.0)], ..empty_run() };
        let found = heap(&models::empty(Scheme::Leapfrog, contact(), 1.0), &run);
        assert!((found[0] - (1.0_f64 / 3.0).atan().to_degrees()).abs() < 0.2, "{found:?}");
    }

    fn contact() -> Contact {
        Contact { kn: KN, kt: 0.0, cn: 0.0, ct: 0.0, friction: 0.0 }
    }

    fn empty_run() -> Run {
        let model = models::empty(Scheme::Leapfrog, contact(), 1.0);
        dem::run(&model, &Job::quiet()).expect("nothing to do")
    }

    #[test]
    fn every_scene_gives_its_quantities() {
        for (bulk, counts) in SCENES.iter().zip([[3, 2, 4], [6, 2, 3], [3, 3, 4]]) {
            let extent = Extent { counts, time: 0.3 };
            let model = model(bulk, extent, 1, Scheme::Leapfrog, 20.0);
            let run = dem::run(&model, &Job::quiet()).expect("runs");
            assert!(matches!(run.outcome, Outcome::Finished), "{}: {:?}", bulk.key, run.outcome);
            let found = (bulk.measure)(&model, &run);
            assert_eq!(found.len(), bulk.quantities.len());
            assert!(found.iter().all(|v| v.is_finite()), "{}: {found:?}", bulk.key);
        }
    }
}
