//! What the error of a clump costs in a DEM run: how the clumps of a solid rebound and heap,
//! beside the finest clump of that solid.
//!
//! Rebound: the clump falls on a plane without gravity, turned at random the same way for every
//! clump of a solid; compared are the velocities afterwards, root mean square over the turns,
//! over the speed of the impact. All turns are bodies of one model, far apart.
//! Angle of repose: grains settle between four walls, the walls are taken away, and the heap that
//! is left has the angle of the cone with its height of the centre of mass z and its radius of
//! gyration s about the vertical axis: tan α = 4 z / R, R = s √(10/3).
//! Every sphere that touches has its own spring and dashpot, as in every DEM code: a clump that
//! lies on a face with more spheres is stiffer there. That is part of what is measured.
//! Means come with 95 % confidence intervals (Student's t): over the turns of the impacts, the root mean
//! square difference by the interval of its square; over the seeds of the heaps, differences of
//! angles in pairs of equal seeds.
//! Cost O(spheres × steps): 48 grains and some 10⁴ steps a heap.

use super::equivalence::{Difference, interval_95};
use super::solids::solids;
use super::{Effort, StudyError, go_on, models};
use crate::clump::{self, Clump, MassSource, Method};
use crate::dem;
use crate::model::{Body, Contact, Model, Motion, Outcome, Run, Scheme, Sphere, restitution};
use crate::num::random::{rotation, stream, uniform};
use crate::num::statistics::{mean, root_mean_square};
use crate::num::{Job, Rotation, Vec3};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::findings::{Cell, Findings, Sheet};
use rayon::prelude::*;

/// Equivalent diameter of every grain, m; density, kg/m³; stiffness, N/m.
const DIAMETER: f64 = 0.02;
const DENSITY: f64 = 2500.0;
const KN: f64 = 2e4;
/// Stiffness in a heap, N/m, where contacts need not be short: 0.2 % overlap under a grain's own weight times ten.
const SOFT: f64 = 5e3;
/// Steps in the shortest contact, of impacts and of heaps.
const FINE: f64 = 50.0;
const COARSE: f64 = 25.0;
/// Speed of the impacts, m/s.
const SPEED: f64 = 0.3;
/// Grains of a heap: so many side by side, so many layers; width of the room, diameters.
const SIDE: u32 = 4;
const LAYERS: u32 = 3;
const ROOM: f64 = 4.5;

/// Clumps of one solid, from few spheres to many; the last is what the others are compared with.
pub struct Ladder {
    /// Name of the solid.
    pub solid: String,
    /// Its clumps.
    pub clumps: Vec<Clump>,
}

/// What one clump does.
struct Behaviour {
    spheres: usize,
    /// Root mean square surface distance over the equivalent diameter, %.
    error: f64,
    /// Velocity after each impact over the speed before it.
    rebounds: Vec<Vec3>,
    /// Angle of each heap, degrees.
    angles: Vec<f64>,
}

/// The study `motion`, see [`super::STUDIES`].
pub fn study(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    let (names, counts): (&[&str], &[u32]) = match effort {
        Effort::Quick => (&["cube", "sharp-0"], &[5, 15, 40]),
        Effort::Full => (&["ellipsoid", "cube", "smooth-0", "sharp-0"], &[5, 10, 20, 50, 100]),
    };
    let mut ladders = Vec::new();
    for solid in solids()?.iter().filter(|solid| names.contains(&solid.name.as_str())) {
        let fit = |&count: &u32| {
            go_on(job)?;
            Method::by_key("fitted", count)
                .and_then(|method| {
                    clump::reproduce(solid, &method, MassSource::Solid, 0, 0, &job.with_threads(1))
                })
                .map_err(|error| StudyError::Work(error.to_string()))
        };
        let clumps = counts.iter().map(fit).collect::<Result<_, _>>()?;
        ladders.push(Ladder { solid: solid.name.clone(), clumps });
    }
    let mut findings = Findings {
        title: "What the error of a clump costs in a DEM run".into(),
        question: "How far do rebounds and the angle of repose of a clump lie from those of the finest clump of its solid?".into(),
        remarks: Vec::new(),
        tables: Vec::new(),
        charts: Vec::new(),
        pictures: Vec::new(),
    };
    add(&mut findings, &ladders, effort, job)?;
    Ok(findings)
}

/// Adds a table and two charts.
pub fn add(
    findings: &mut Findings,
    ladders: &[Ladder],
    effort: Effort,
    job: &Job,
) -> Result<(), StudyError> {
    let (turns, seeds): (u64, u64) = match effort {
        Effort::Quick => (100, 4),
        Effort::Full => (200, 6),
    };
    let cases: Vec<(usize, usize)> = ladders
        .iter()
        .enumerate()
        .flat_map(|(s, ladder)| (0..ladder.clumps.len()).map(move |c| (s, c)))
        .collect();
    let done = std::sync::atomic::AtomicU64::new(0);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(job.threads).build();
    let all = || {
        cases
            .par_iter()
            .map(|&(s, c)| {
                let reach = reach(&ladders[s]);
                let found = behaviour(&ladders[s].clumps[c], reach, turns, seeds, job)?;
                let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                job.report("clumps in motion", count, cases.len() as u64);
                Ok(found)
            })
            .collect::<Result<Vec<Behaviour>, StudyError>>()
    };
    let behaviours = match pool {
        Ok(pool) => pool.install(all)?,
        Err(_) => all()?,
    };
    let mut rest = &behaviours[..];
    let (mut rows, mut rebound, mut heap) = (Vec::new(), Vec::new(), Vec::new());
    let mut worst: Vec<Apart> = Vec::new();
    for ladder in ladders {
        let (mine, others) = rest.split_at(ladder.clumps.len());
        rest = others;
        let Some(finest) = mine.last() else { continue };
        let (mut off, mut angles) = (Vec::new(), Vec::new());
        for (rung, one) in mine.iter().enumerate() {
            let is_finest = rung + 1 == mine.len();
            let [difference, from, to] = difference(one, finest).map(|share| 100.0 * share);
            let (angle, angle_half) = interval_95(&one.angles);
            let turned = Difference::of_pairs(&one.angles, &finest.angles);
            if angle.is_finite() {
                angles.push((one.spheres as f64, angle));
            }
            if !is_finest && difference.is_finite() && turned.middle.is_finite() {
                off.push((one.spheres as f64, difference));
                worst.push(Apart { spheres: one.spheres, rebound: difference, angle: turned });
            }
            let upward: Vec<f64> = one.rebounds.iter().map(|velocity| velocity.z).collect();
            let (up, up_half) = interval_95(&upward);
            let or_empty = |value: f64| Cell::from(if is_finest { f64::NAN } else { value });
            rows.push(vec![
                ladder.solid.as_str().into(),
                (one.spheres as u64).into(),
                one.error.into(),
                up.into(),
                up_half.into(),
                or_empty(difference),
                or_empty(from),
                or_empty(to),
                angle.into(),
                angle_half.into(),
                or_empty(turned.middle),
                or_empty(turned.half_95),
            ]);
        }
        rebound.push(Series { name: ladder.solid.clone(), points: off, dots: true });
        heap.push(Series { name: ladder.solid.clone(), points: angles, dots: true });
    }
    findings.remarks.extend(remark(&worst));
    findings.tables.push(table(rows, turns, seeds));
    findings.charts.push(("rebound-spheres".into(), rebounds(rebound)));
    findings.charts.push(("repose-spheres".into(), heaps(heap, seeds)));
    Ok(())
}

/// How far a clump is from the finest one of its solid.
struct Apart {
    spheres: usize,
    /// %.
    rebound: f64,
    /// Degrees.
    angle: Difference,
}

fn remark(worst: &[Apart]) -> Option<String> {
    let few = worst.iter().map(|w| w.spheres).min()?;
    let many = worst.iter().map(|w| w.spheres).max()?;
    let of = |count: usize| {
        let mine: Vec<f64> =
            worst.iter().filter(|w| w.spheres == count).map(|w| w.rebound).collect();
        mean(&mine)
    };
    let largest =
        worst.iter().max_by(|a, b| a.angle.middle.abs().total_cmp(&b.angle.middle.abs()))?;
    let apart = worst.iter().filter(|w| w.angle.middle.abs() > w.angle.half_95).count();
    Some(format!(
        "In motion, beside the finest clump of the same solid: velocities after an impact differ by {:.0} % \
         of the speed with {few} spheres and by {:.0} % with {many} (root mean square); the angle of \
         repose differs by {:.1} ± {:.1}° at most (95 %), and by more than chance in {apart} of {} clumps.",
        of(few)?,
        of(many)?,
        largest.angle.middle,
        largest.angle.half_95,
        worst.len()
    ))
}

fn table(rows: Vec<Vec<Cell>>, turns: u64, seeds: u64) -> Sheet {
    Sheet {
        key: "in-motion".into(),
        title: "What the error costs in a DEM run".into(),
        caption: format!(
            "Fitted clumps of one solid beside its finest one. {turns} impacts on a plane (e = 0.5, μ = 0.5), \
             each turned another way; {seeds} heaps of {} grains. ±, from, to: 95 % confidence.",
            SIDE * SIDE * LAYERS
        ),
        columns: [
            "solid",
            "spheres",
            "rms distance [%]",
            "mean rebound over speed",
            "± rebound",
            "rebound off finest [%]",
            "from [%]",
            "to [%]",
            "angle of repose [degrees]",
            "± angle [degrees]",
            "angle off finest [degrees]",
            "± angle off finest [degrees]",
        ]
        .map(String::from)
        .to_vec(),
        rows,
    }
}

fn rebounds(series: Vec<Series>) -> Chart {
    Chart {
        title: "Rebound: distance from the finest clump".into(),
        caption: "Root mean square difference of the velocities after an impact, over its speed."
            .into(),
        x: Axis::log("spheres", ""),
        y: Axis::log("difference of velocities / speed", "%"),
        series,
        mark: None,
    }
}

fn heaps(series: Vec<Series>, seeds: u64) -> Chart {
    Chart {
        title: "Angle of repose over spheres".into(),
        caption: format!("Mean of {seeds} heaps; confidence intervals are in the table."),
        x: Axis::log("spheres", ""),
        y: Axis::linear("angle", "degrees"),
        series,
        mark: None,
    }
}

/// Root mean square of the differences of the velocities after the impacts, over the speed, and
/// the ends of its 95 % interval; not a number where one of them did not end.
fn difference(one: &Behaviour, other: &Behaviour) -> [f64; 3] {
    if one.rebounds.len() != other.rebounds.len() {
        return [f64::NAN; 3];
    }
    let squares: Vec<f64> =
        one.rebounds.iter().zip(&other.rebounds).map(|(a, b)| (a - b).norm_squared()).collect();
    let (middle, half) = interval_95(&squares);
    [middle, (middle - half).max(0.0), middle + half].map(f64::sqrt)
}

/// Largest bounding radius of the clumps of a solid at the size of the study, m.
fn reach(ladder: &Ladder) -> f64 {
    ladder.clumps.iter().map(|clump| sized(clump).bounding_radius()).fold(0.0, f64::max)
}

/// The clump with the volume of a sphere of the study's diameter.
fn sized(clump: &Clump) -> Clump {
    let diameter = (6.0 * clump.volume / std::f64::consts::PI).cbrt();
    clump.scaled(DIAMETER / diameter, 3)
}

fn behaviour(
    clump: &Clump,
    reach: f64,
    turns: u64,
    seeds: u64,
    job: &Job,
) -> Result<Behaviour, StudyError> {
    let clump = sized(clump);
    go_on(job)?;
    let rebounds = impacts(&clump, reach, turns)?;
    let mut angles = Vec::new();
    for seed in 0..seeds {
        go_on(job)?;
        angles.push(repose(&clump, reach, seed)?);
    }
    let error = clump.fidelity.map_or(0.0, |f| 100.0 * f.rms_distance / f.equivalent_diameter);
    Ok(Behaviour { spheres: clump.balls.len(), error, rebounds, angles })
}

/// A model of nothing but a plane at z = 0, with springs of `kn` N/m.
fn ground(kn: f64, wanted_restitution: f64, share: f64) -> Model {
    let mass = DENSITY * std::f64::consts::PI / 6.0 * DIAMETER.powi(3);
    let cn = restitution::dashpot(wanted_restitution, kn, share * mass, false).unwrap_or(0.0);
    let contact = Contact { kn, kt: 2.0 / 7.0 * kn, cn, ct: 0.0, friction: 0.5 };
    let mut model = models::empty(Scheme::Leapfrog, contact, DENSITY);
    models::plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    model.domain.low = Vec3::repeat(-1e3 * DIAMETER);
    model.domain.high = Vec3::repeat(1e3 * DIAMETER);
    model
}

/// Adds a grain; `turn` is that of the solid, so that all clumps of it lie the same way.
fn put(model: &mut Model, clump: &Clump, place: Vec3, turn: Rotation, velocity: Vec3) {
    let (first_sphere, body) = (model.spheres.len() as u32, model.bodies.len() as u32);
    model.spheres.extend(clump.balls.iter().map(|ball| Sphere {
        offset: ball.centre,
        radius: ball.radius,
        body,
    }));
    let ball = Body::sphere(model.dimension, place, 1.0, DENSITY, 0, first_sphere);
    model.bodies.push(Body {
        orientation: turn * clump.axes,
        velocity,
        mass: DENSITY * clump.volume,
        inertia: clump.inertia * DENSITY,
        sphere_count: clump.balls.len() as u32,
        ..ball
    });
}

/// Runs a model with `fineness` steps in its shortest contact; `None` where the guard stops it.
///
/// Overlaps are small beside a grain, not beside the smallest of its spheres, which the guard and
/// the advised step would compare them with.
fn run(mut model: Model, fineness: f64, duration: f64) -> Result<Option<(Model, Run)>, StudyError> {
    let advice = dem::advise(&model);
    model.plan.step = (advice.contact_time / fineness).min(0.5 * advice.limit);
    model.plan.steps = (duration / model.plan.step).ceil() as u64;
    (model.plan.guard.overlap, model.plan.guard.travel) = (1e3, 10.0);
    let run =
        dem::run(&model, &Job::quiet()).map_err(|error| StudyError::Work(error.to_string()))?;
    Ok(matches!(run.outcome, Outcome::Finished).then_some((model, run)))
}

/// Velocities after impacts on a plane over the speed before, one for each turn.
fn impacts(clump: &Clump, reach: f64, turns: u64) -> Result<Vec<Vec3>, StudyError> {
    let mut model = ground(KN, 0.5, 1.0);
    let columns = (turns as f64).sqrt().ceil() as u64;
    for index in 0..turns {
        let turn = rotation(&mut stream(1, "impacts", index));
        let whole = turn * clump.axes;
        let lowest = clump
            .balls
            .iter()
            .map(|ball| (whole * ball.centre).z - ball.radius)
            .fold(f64::INFINITY, f64::min);
        let place =
            Vec3::new((index % columns) as f64, (index / columns) as f64, 0.0) * 4.0 * reach
                + Vec3::z() * (1e-3 * DIAMETER - lowest);
        put(&mut model, clump, place, turn, -Vec3::z() * SPEED);
    }
    let mass = DENSITY * clump.volume;
    let contact = std::f64::consts::PI * (mass / KN).sqrt();
    let ended = run(model, FINE, 1e-3 * DIAMETER / SPEED + 4.0 * contact)?;
    let last = ended.and_then(|(_, run)| run.frames.last().cloned());
    Ok(last.map_or(Vec::new(), |frame| {
        frame.bodies.iter().map(|state| state.velocity / SPEED).collect()
    }))
}

/// Angle of the heap that is left of grains that settled between walls, degrees; not a number
/// where the guard stopped the run.
fn repose(clump: &Clump, reach: f64, seed: u64) -> Result<f64, StudyError> {
    let mut model = ground(SOFT, 0.3, 0.5);
    model.gravity = -9.81 * Vec3::z();
    let half = (0.5 * ROOM * DIAMETER).max(1.05 * reach);
    for side in [Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y()] {
        models::plane(&mut model, -side * half, side, Motion::Still);
    }
    // As many side by side as there is room for, in as many layers as that takes.
    let abreast = (((2.0 * half) / (2.0 * reach)).floor() as u32).clamp(1, SIDE);
    let pitch = 2.0 * half / f64::from(abreast);
    for index in 0..SIDE * SIDE * LAYERS {
        let mut source = stream(seed, "heap", u64::from(index));
        let turn = rotation(&mut source);
        let room = (0.5 * pitch - reach).max(0.0);
        let jitter =
            Vec3::from_fn(|axis, _| if axis < 2 { uniform(&mut source, -room, room) } else { 0.0 });
        let [i, j, k] =
            [index % abreast, index / abreast % abreast, index / abreast / abreast].map(f64::from);
        let place = Vec3::new((i + 0.5) * pitch - half, (j + 0.5) * pitch - half, 0.0)
            + Vec3::z() * reach * (1.0 + 2.02 * k)
            + jitter;
        put(&mut model, clump, place, turn, Vec3::zeros());
    }
    let fall =
        (2.0 * 2.02 * reach * f64::from(SIDE * SIDE * LAYERS / abreast / abreast) / 9.81).sqrt();
    let Some((mut model, settled)) = run(model, COARSE, fall + 0.3)? else { return Ok(f64::NAN) };
    model.walls.truncate(1);
    if let Some(last) = settled.frames.last() {
        for (body, state) in model.bodies.iter_mut().zip(&last.bodies) {
            (body.position, body.orientation) = (state.position, state.orientation);
            (body.velocity, body.spin) = (state.velocity, state.spin);
        }
    }
    let Some((_, run)) = run(model, COARSE, 0.6)? else { return Ok(f64::NAN) };
    let places: Vec<Vec3> =
        run.frames.last().map_or(Vec::new(), |f| f.bodies.iter().map(|s| s.position).collect());
    Ok(cone(&places))
}

/// Angle of the cone with the same height of the centre of mass and radius of gyration, degrees.
fn cone(places: &[Vec3]) -> f64 {
    let centre = places.iter().sum::<Vec3>() / places.len() as f64;
    let distances: Vec<f64> = places.iter().map(|place| (place - centre).xy().norm()).collect();
    let spread = root_mean_square(&distances).unwrap_or(f64::NAN);
    (4.0 * centre.z / (spread * (10.0_f64 / 3.0).sqrt())).atan().to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clump;

    #[test]
    fn a_cone_has_its_angle() {
        // Cells of a cone of height 1 and radius 2.
        let mut places = Vec::new();
        for i in -40..=40 {
            for j in -40..=40 {
                for k in 0..40 {
                    let [x, y, z] = [i, j, k].map(|n| (f64::from(n)) * 0.05);
                    if z + 0.025 < 1.0 - Vec3::new(x, y, 0.0).norm() / 2.0 {
                        places.push(Vec3::new(x, y, z + 0.025));
                    }
                }
            }
        }
        assert!((cone(&places) - 0.5_f64.atan().to_degrees()).abs() < 0.3, "{}", cone(&places));
    }

    #[test]
    fn a_sphere_rebounds_as_asked_and_a_twin_does_not_differ() {
        let ball = clump::sphere("ball", 1.0);
        let rebounds = impacts(&sized(&ball), 0.5 * DIAMETER, 3).expect("runs");
        assert_eq!(rebounds.len(), 3);
        assert!(rebounds.iter().all(|v| (v.z - 0.5).abs() < 0.01 && v.xy().norm() < 1e-9));
        let ladder = Ladder { solid: "ball".into(), clumps: vec![ball.clone(), ball] };
        assert!((reach(&ladder) / (0.5 * DIAMETER) - 1.0).abs() < 1e-9);
        let of = |rebounds| Behaviour { spheres: 1, error: 0.0, rebounds, angles: vec![1.0, 2.0] };
        let other: Vec<Vec3> = rebounds.iter().map(|v| v + Vec3::new(0.1, 0.0, 0.0)).collect();
        assert_eq!(difference(&of(rebounds.clone()), &of(rebounds.clone())), [0.0; 3]);
        let apart = difference(&of(other), &of(rebounds));
        assert!(apart.iter().all(|share| (share - 0.1).abs() < 1e-6), "{apart:?}");
    }
}
