//! Small models that studies run.

use crate::clump::Clump;
use crate::geometry::region::Rectangle;
use crate::geometry::{Bounds, Cell, Region};
use crate::model::{
    Body, Contact, Dimension, Material, Model, Motion, Plan, Scheme, Sphere, Wall, WallShape,
};
use crate::num::{Job, Vec3};
use crate::pack::random::Random;
use crate::pack::space::Space;
use crate::pack::{self, Grain, PackError, scatter};

/// A model in three dimensions without bodies, walls and gravity, of one material
/// of `density` [kg/m³]; frames and rows at start and end only; steps to be set.
pub fn empty(scheme: Scheme, contact: Contact, density: f64) -> Model {
    let material = Material { name: "grain".to_owned(), density };
    let plan = Plan { step: 1e-6, ..Plan::new(scheme) };
    let model = Model::empty(Dimension::Three, material, contact, plan);
    Model { title: "study".to_owned(), ..model }
}

/// Adds a plane wall through `point` with the unit `normal` towards the bodies.
pub fn plane(model: &mut Model, point: Vec3, normal: Vec3, motion: Motion) {
    let name = format!("plane{}", model.walls.len());
    model.walls.push(Wall { name, shape: WallShape::Plane { point, normal }, motion, material: 0 });
}

/// Adds a sphere of `radius` [m] and `density` [kg/m³] at `place` [m] with `velocity` [m/s].
pub fn sphere(model: &mut Model, place: Vec3, radius: f64, density: f64, velocity: Vec3) {
    model.add_sphere(place, radius, density, 0).velocity = velocity;
}

/// Equal spheres that fill `share` of a cube of edge 1 m whose sides repeat, at random places without overlap.
pub fn loose_spheres(count: usize, share: f64, friction: f64, seed: u64) -> Model {
    let contact = Contact { kn: 1e5, kt: 2.0 / 7.0 * 1e5, cn: 0.0, ct: 0.0, friction };
    let mut model = empty(Scheme::Leapfrog, contact, 2500.0);
    let bounds = Bounds { low: Vec3::zeros(), high: Vec3::repeat(1.0) };
    model.domain = bounds;
    model.periodic = Some(Cell { bounds, periodic: [true; 3] });
    let radius = (share / (4.0 / 3.0 * std::f64::consts::PI) / count as f64).cbrt();
    let space = Space::repeating(3, Vec3::repeat(1.0));
    if let Some((centres, _)) = scatter::apart(&space, &vec![radius; count], 100_000, seed) {
        for centre in centres {
            sphere(&mut model, centre, radius, 2500.0, Vec3::zeros());
        }
    }
    model
}

/// Equal clumps whose `volume`s fill `share` of a cube of edge 1 m whose sides repeat, at random places and angles
/// without overlap.
///
/// # Errors
/// As [`pack::pack`].
pub fn loose_clumps(
    clump: &Clump,
    count: usize,
    share: f64,
    friction: f64,
    job: &Job,
) -> Result<Model, PackError> {
    let contact = Contact { kn: 1e5, kt: 2.0 / 7.0 * 1e5, cn: 0.0, ct: 0.0, friction };
    let mut model = empty(Scheme::Leapfrog, contact, 2500.0);
    let bounds = Bounds { low: Vec3::zeros(), high: Vec3::repeat(1.0) };
    model.domain = bounds;
    model.periodic = Some(Cell { bounds, periodic: [true; 3] });
    let clump = clump.scaled((share / count as f64 / clump.volume).cbrt(), 3);
    let grains = vec![Grain { clump: &clump, solid: None, family: 0 }; count];
    let cube = Rectangle { bounds, dimension: 3, open: [[false; 2]; 3], periodic: [true; 3] };
    let method = pack::Method::Random(Random { tries: 100_000, ..Random::default() });
    let packing = pack::pack(&grains, &["clump"], &Region::Box(cube), &method, 1, job)?;
    for laid in &packing.placements {
        let (first, body) = (model.spheres.len() as u32, model.bodies.len() as u32);
        let ball = clump.balls[0];
        let centre = laid.position + laid.orientation * ball.centre;
        let sphere = Body::sphere(Dimension::Three, centre, ball.radius, 2500.0, 0, first);
        let single = clump.balls.len() == 1;
        model.spheres.extend(clump.balls.iter().map(|ball| Sphere {
            offset: if single { Vec3::zeros() } else { ball.centre },
            radius: ball.radius,
            body,
        }));
        model.bodies.push(match single {
            true => sphere,
            false => Body {
                position: laid.position,
                orientation: laid.orientation,
                sphere_count: clump.balls.len() as u32,
                mass: 2500.0 * clump.volume,
                inertia: 2500.0 * clump.inertia,
                ..sphere
            },
        });
    }
    Ok(model)
}
