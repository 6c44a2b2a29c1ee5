//! From a packing to the model that all solvers share.

use super::bonding;
use super::grains::Grain;
use super::inserting::Arrival;
use super::materials::{self, GrainFacts, PairFacts};
use super::parameters::{Hold, StepParameter};
use super::walls::swept_bounds;
use super::{Loaded, Scene};
use crate::dem::limit::{Advice, advise};
use crate::geometry::region::Rectangle;
use crate::geometry::{Bounds, Region};
use crate::model::{Body, Dimension, Model, Plan, Sphere, StepReason, Wall};
use crate::num::statistics::median;
use crate::num::{Fault, Vec3};
use crate::pack::{Packing, Placement};

/// More steps than any machine does.
const MOST_STEPS: f64 = 1e14;

/// A model with what people want to know about how it came about.
#[derive(Debug, Clone)]
pub struct Built {
    /// What the solvers get.
    pub model: Model,
    /// Contact parameters by pair.
    pub pairs: Vec<PairFacts>,
    /// Step limits and forecasts.
    pub advice: Advice,
}

/// Puts grains, packing, walls, plan and grains that come later (in the order of time) together.
///
/// # Errors
/// A fault where contact parameters cannot be reached or the step is above the stability limit.
pub fn build(
    loaded: &Loaded,
    region: Option<&Region>,
    scene_walls: &[Wall],
    grains: &[Grain],
    copies: &[u32],
    packing: &Packing,
    arrivals: &[Arrival],
) -> Result<Built, Fault> {
    let scene = &loaded.scene;
    let dimension = if scene.dimension == 2 { Dimension::Two } else { Dimension::Three };
    let come = arrivals.iter().map(|arrival| &arrival.placement);
    let (mut bodies, spheres, first_spheres) =
        bodies(scene, dimension, grains, copies, packing.placements.iter().chain(come))?;
    if let Some(cell) = region.and_then(Region::cell) {
        for body in &mut bodies {
            body.position += cell.home(&body.position);
        }
        if scene.plan.mutual_gravity.is_some() {
            let problem = "acts in a periodic box";
            let allowed = "a box without `periodic`: images would attract each other without end (Ewald sums are not there)";
            return Err(Fault::new("plan.mutual_gravity", problem, allowed));
        }
    }
    let facts: Vec<GrainFacts> = bodies.iter().map(|body| facts(body, &spheres)).collect();
    let wall_materials: Vec<u16> = scene_walls.iter().map(|wall| wall.material).collect();
    let contacts = materials::contacts(scene, &facts, &wall_materials)?;
    let walls: Vec<Wall> = scene_walls
        .iter()
        .map(|wall| Wall { material: contacts.of_walls[wall.material as usize], ..wall.clone() })
        .collect();
    let bonds =
        bonding::bonds(scene, dimension, &first_spheres, &bodies, &spheres, &contacts.table);
    let gravity = scene.gravity();
    let domain = domain(scene, region, &walls, &bodies, &spheres, &gravity);
    let plan = Plan {
        law: scene.plan.law(),
        insist: scene.plan.insist,
        guard: scene.plan.guard,
        ledger: scene.plan.ledger,
        ..Plan::new(scene.plan.scheme)
    };
    let mut model = Model {
        title: scene.title.clone(),
        dimension,
        seed: scene.seed,
        bodies,
        spheres,
        bonds,
        materials: contacts.materials,
        contacts: contacts.table,
        extra: contacts.extra,
        walls,
        gravity,
        mutual: scene.plan.mutual_gravity,
        local_damping: scene.plan.local_damping,
        domain,
        periodic: region.and_then(Region::cell),
        plan,
        springs: Vec::new(),
        arrivals: arrivals.iter().map(|arrival| arrival.time).collect(),
        decks: scene.decks,
    };
    let advice = advise(&model);
    set_step(scene, &mut model.plan, &advice)?;
    Ok(Built { model, pairs: contacts.pairs, advice })
}

fn facts(body: &Body, spheres: &[Sphere]) -> GrainFacts {
    let mine = &spheres[body.first_sphere as usize..][..body.sphere_count as usize];
    let radii: Vec<f64> = mine.iter().map(|sphere| sphere.radius).collect();
    // A body has at least one sphere, so there is a median.
    let radius = median(&radii).unwrap_or(0.0);
    GrainFacts { material: body.material, mass: body.mass, radius }
}

/// Bodies, their spheres, and where the spheres of each placement begin.
type Laid = (Vec<Body>, Vec<Sphere>, Vec<u32>);

fn bodies<'a>(
    scene: &Scene,
    dimension: Dimension,
    grains: &[Grain],
    copies: &[u32],
    placements: impl Iterator<Item = &'a Placement>,
) -> Result<Laid, Fault> {
    let materials: Vec<u16> = scene
        .grains
        .iter()
        .enumerate()
        .map(|(index, family)| {
            scene
                .material(family.material.as_deref())
                .map_err(|f| f.under(format!("grains[{index}]")))
        })
        .collect::<Result<_, _>>()?;
    let densities: Vec<f64> =
        scene.materials.values().map(|m| m.density.map_or(0.0, |d| d.0)).collect();
    let mut bodies = Vec::with_capacity(placements.size_hint().0);
    let mut spheres = Vec::new();
    let mut first_spheres = vec![0];
    for placement in placements {
        let number = copies[placement.grain as usize];
        let grain = &grains[number as usize];
        let material = materials[grain.family as usize];
        let density = densities[material as usize];
        let first_sphere = spheres.len() as u32;
        let body = bodies.len() as u32;
        let balls = &grain.clump.balls;
        spheres.extend(balls.iter().map(|ball| Sphere {
            offset: ball.centre,
            radius: ball.radius,
            body,
        }));
        let mut made = body_of(dimension, grain, placement, density, material, first_sphere);
        if let ([_], Some(sphere)) = (balls.as_slice(), spheres.last_mut()) {
            let sphere: &mut Sphere = sphere;
            sphere.offset = Vec3::zeros();
        }
        made.velocity = placement.velocity;
        made.spin = placement.spin;
        made.family = grain.family;
        made.grain = number;
        let bonded = matches!(scene.grains[grain.family as usize].body, Hold::Bonded(_));
        if bonded && balls.len() > 1 {
            bonding::split(dimension, made, placement, &mut bodies, &mut spheres);
        } else {
            bodies.push(made);
        }
        first_spheres.push(spheres.len() as u32);
    }
    Ok((bodies, spheres, first_spheres))
}

/// The rigid body of a grain, at rest.
fn body_of(
    dimension: Dimension,
    grain: &Grain,
    placement: &Placement,
    density: f64,
    material: u16,
    first_sphere: u32,
) -> Body {
    let balls = &grain.clump.balls;
    let centre = placement.position + placement.orientation * balls[0].centre;
    let ball = Body::sphere(dimension, centre, balls[0].radius, density, material, first_sphere);
    let mass = density * grain.clump.volume;
    match (&grain.clump.fidelity, balls.len()) {
        (None, 1) => ball,
        // One sphere is a good enough clump for this grain: it keeps the mass of the grain and
        // turns like a homogeneous sphere about its own centre.
        (Some(_), 1) => Body { mass, inertia: ball.inertia * (mass / ball.mass), ..ball },
        (_, count) => Body {
            position: placement.position,
            orientation: placement.orientation,
            sphere_count: count as u32,
            mass,
            inertia: grain.clump.inertia * density,
            ..ball
        },
    }
}

/// The room that bodies may be in: container, walls over their motion and bodies,
/// with a margin of two body diameters; open sides leave as much room again as the container is high.
fn domain(
    scene: &Scene,
    region: Option<&Region>,
    walls: &[Wall],
    bodies: &[Body],
    spheres: &[Sphere],
    gravity: &Vec3,
) -> Bounds {
    if let Some(region) = region
        && let Some(cell) = region.cell()
    {
        // Open sides have walls or none as usual; periodic sides are where the box ends.
        let open = Region::Box(Rectangle {
            bounds: cell.bounds,
            dimension: region.dimension(),
            open: [[region.is_open(); 2]; 3],
            periodic: [false; 3],
        });
        let mut bounds = domain(scene, Some(&open), walls, bodies, spheres, gravity);
        for axis in (0..3).filter(|axis| cell.periodic[*axis]) {
            bounds.low[axis] = cell.bounds.low[axis];
            bounds.high[axis] = cell.bounds.high[axis];
        }
        return bounds;
    }
    let mut bounds = swept_bounds(walls, scene.plan.duration.0);
    let mut largest = 0.0f64;
    let mut fastest = 0.0f64;
    for body in bodies {
        let mine = &spheres[body.first_sphere as usize..][..body.sphere_count as usize];
        let reach = mine.iter().map(|s| s.offset.norm() + s.radius).fold(0.0, f64::max);
        bounds = bounds.union(&Bounds::of([&body.position]).grown(reach));
        largest = largest.max(reach);
        fastest = fastest.max(body.velocity.norm());
    }
    match region {
        Some(region) => {
            let room = region.bounds();
            let open = if region.is_open() { room.size().amax() } else { 0.0 };
            bounds.union(&room).grown(4.0 * largest + open)
        }
        None => {
            let time = scene.plan.duration.0;
            bounds.grown(4.0 * largest + fastest * time + 0.5 * gravity.norm() * time * time)
        }
    }
}

fn set_step(scene: &Scene, plan: &mut Plan, advice: &Advice) -> Result<(), Fault> {
    let duration = scene.plan.duration.0;
    match scene.plan.step {
        StepParameter::Given(step) => {
            if step.0 > advice.limit && !scene.plan.insist {
                let problem = format!(
                    "is {:.4e} s, above the stability limit {:.4e} s ({})",
                    step.0, advice.limit, advice.reason
                );
                let allowed = format!(
                    "at most {:.4e} s, \"auto\" ({:.4e} s), or `insist = true`",
                    advice.limit, advice.step
                );
                return Err(Fault::new("plan.step", problem, allowed));
            }
            plan.step = step.0;
            plan.steps = (duration / step.0).round().max(1.0) as u64;
        }
        StepParameter::Auto => {
            plan.steps = (duration / advice.step).ceil().max(1.0) as u64;
            plan.step = duration / plan.steps as f64;
            plan.reason = StepReason::Auto(advice.reason.clone());
        }
    }
    if duration / plan.step > MOST_STEPS || !plan.step.is_normal() {
        let problem = format!(
            "is {duration:e} s, {:.1e} steps of {:.3e} s ({})",
            duration / plan.step,
            plan.step,
            advice.reason
        );
        let allowed = "a duration that can be computed, softer contacts or heavier bodies";
        return Err(Fault::new("plan.duration", problem, allowed));
    }
    plan.zero_every = scene.plan.zero_velocities_every.map_or(0, u64::from);
    if plan.zero_every > 0 {
        let last = scene.plan.zero_velocities_until.map(|time| (time.0 / plan.step).floor() as u64);
        plan.zero_until = last.unwrap_or(u64::MAX);
    }
    let every = |count: u32| (plan.steps / u64::from(count.max(1))).max(1);
    plan.frame_every = every(scene.output.frames);
    plan.series_every = every(scene.output.rows);
    plan.checkpoint_every =
        if scene.output.checkpoints == 0 { 0 } else { every(scene.output.checkpoints) };
    Ok(())
}
