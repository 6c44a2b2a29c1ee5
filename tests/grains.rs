//! Random grains against independent measures of the same solids.

use riprap::geometry::{Mesh, Posed, Primitive, topology};
use riprap::num::random::{self, Stream};
use riprap::num::{Rotation, Vec3};
use riprap::shape::union_of_solids::{self, Family, Turns};
use riprap::shape::{Shape, UnionParameters, descriptors, generate};
use std::path::Path;

/// A convex base solid with the planes of its triangles.
struct Faceted {
    exact: Posed,
    core: Posed,
    planes: Vec<(Vec3, f64)>,
}

impl Faceted {
    fn new(exact: Posed, segments: u32) -> Self {
        let planes = exact
            .mesh(segments)
            .facets()
            .map(|[a, b, c]| {
                let normal = (b - a).cross(&(c - a)).normalize();
                (normal, normal.dot(&a))
            })
            .collect();
        Self { exact, core: Posed { primitive: shrunk(exact.primitive, 0.95), ..exact }, planes }
    }

    /// Inside the triangle surface: surely so in the core, surely not outside
    /// the exact solid that it is inscribed in, else by its planes.
    fn contains(&self, point: &Vec3) -> bool {
        self.core.contains(point)
            || self.exact.contains(point)
                && self.planes.iter().all(|(normal, level)| normal.dot(point) <= *level)
    }
}

fn shrunk(solid: Primitive, by: f64) -> Primitive {
    match solid {
        Primitive::Box { edges } => Primitive::Box { edges: edges * by },
        Primitive::Cylinder { diameter, height } => {
            Primitive::Cylinder { diameter: diameter * by, height: height * by }
        }
        Primitive::Cone { diameter, height } => {
            Primitive::Cone { diameter: diameter * by, height: height * by }
        }
        Primitive::Ellipsoid { axes } => Primitive::Ellipsoid { axes: axes * by },
        Primitive::Sphere { diameter } => Primitive::Sphere { diameter: diameter * by },
    }
}

/// Volume of the union by random points, and its standard error.
fn monte_carlo(parts: &[Faceted], mesh: &Mesh, points: u32, stream: &mut Stream) -> (f64, f64) {
    let bounds = mesh.bounds();
    let size = bounds.size();
    let inside = (0..points)
        .filter(|_| {
            let share = Vec3::from_fn(|_, _| random::uniform(stream, 0.0, 1.0));
            let point = bounds.low + share.component_mul(&size);
            parts.iter().any(|part| part.contains(&point))
        })
        .count() as f64;
    let (n, p) = (f64::from(points), inside / f64::from(points));
    (p * size.product(), (p * (1.0 - p) / n).sqrt() * size.product())
}

/// Compares `count` unions with random points.
fn unions_against_random_points(parameters: &UnionParameters, count: u32) {
    let shape = Shape::Union(parameters.clone());
    let (mut squares, mut largest, mut doubtful) = (0.0, 0.0_f64, 0);
    for index in 0..u64::from(count) {
        let mut stream = random::stream(11, "grains", index);
        let solids = union_of_solids::draw(parameters, &mut stream);
        let mesh = union_of_solids::unite(&solids, parameters.segments).expect("a union");
        let parts: Vec<_> =
            solids.iter().map(|solid| Faceted::new(*solid, parameters.segments)).collect();
        let mut points = random::stream(12, "points", index);
        let volume = mesh.mass_properties().volume;
        let mut off = |points_used: u32| {
            let (expected, error) = monte_carlo(&parts, &mesh, points_used, &mut points);
            (volume - expected) / error
        };
        let mut deviation = off(20_000);
        // Where nearly all points are inside, those outside are few and not Gaussian.
        if deviation.abs() > 4.0 {
            doubtful += 1;
            deviation = off(2_000_000);
        }
        assert!(deviation.abs() < 5.0, "grain {index}: {deviation} standard errors");
        squares += deviation * deviation;
        largest = largest.max(deviation.abs());

        // The grain that users get is the same solid, at its own size and in single precision.
        let grain = generate(&shape, "g", index, None, 11, "grains", Path::new("."))
            .expect("no draw of these needs more than the redraws");
        if !grain.recipe.contains("earlier draws") {
            let ratio = grain.mass.volume / mesh.mass_properties().volume;
            assert!((ratio - 1.0).abs() < 1e-6, "grain {index}: {ratio}");
        }
        let report = topology::inspect(&grain.mesh);
        assert!(report.is_closed() && report.pieces == 1, "grain {index}: {report:?}");
        assert_eq!(report.euler_characteristic, 2, "grain {index}: star-shaped, so no handles");
    }
    // n squared deviations of variance 1 sum to n ± √(2n): no bias hides below 5 errors.
    let n = f64::from(count);
    println!(
        "{count} grains: mean square of the deviation {:.3}, largest {largest:.2} standard errors; \
         {doubtful} looked at with 100 times the points",
        squares / n
    );
    assert!((squares - n).abs() < 6.0 * (2.0 * n).sqrt(), "{squares} of {n}");
}

/// Grains to compare: more with `RIPRAP_GRAINS=1000`.
fn grains() -> u32 {
    std::env::var("RIPRAP_GRAINS").ok().and_then(|text| text.parse().ok()).unwrap_or(100)
}

#[test]
fn unions_have_the_volume_that_random_points_find() {
    unions_against_random_points(&UnionParameters::default(), grains());
}

#[test]
fn unions_of_up_to_twelve_solids_have_the_volume_that_random_points_find() {
    let parameters = UnionParameters { solids: [2, 12], ..Default::default() };
    unions_against_random_points(&parameters, grains() / 4);
}

#[test]
fn unions_along_the_axes_that_share_faces_have_the_volume_that_random_points_find() {
    let parameters = UnionParameters {
        solids: [2, 12],
        turns: Turns::Quarter,
        step: 0.25,
        lift: [0.0, 0.0],
        ..Default::default()
    };
    unions_against_random_points(&parameters, grains() / 4);
}

#[test]
fn smooth_grains_are_rounder_than_sharp_ones() {
    let mean = |family| {
        let shape = Shape::Union(UnionParameters { family, ..Default::default() });
        (0..10)
            .map(|index| {
                let grain = generate(&shape, "g", index, Some(1.0), 5, "family", Path::new("."))
                    .expect("a grain");
                descriptors::describe(&grain.mesh).expect("a hull").wadell_sphericity / 10.0
            })
            .sum::<f64>()
    };
    let (smooth, sharp) = (mean(Family::Smooth), mean(Family::Sharp));
    assert!(smooth > sharp + 0.05, "{smooth} {sharp}");
}

#[test]
fn a_union_of_equal_concentric_spheres_and_of_one_solid_is_that_solid() {
    let ball = Posed {
        primitive: Primitive::Sphere { diameter: 1.0 },
        rotation: Rotation::identity(),
        centre: Vec3::zeros(),
    };
    let alone = ball.mesh(32).mass_properties().volume;
    for count in [1, 2, 3] {
        let mesh = union_of_solids::unite(&vec![ball; count], 32).expect("a ball");
        assert!((mesh.mass_properties().volume / alone - 1.0).abs() < 1e-9, "{count}");
    }
}
