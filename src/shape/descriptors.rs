//! Measures of a grain's size and form.
//!
//! Principal dimensions L ≥ I ≥ S are the extents along the principal axes of
//! inertia (Fonseca et al. 2012). Where principal moments agree to 1e-3 those
//! axes are arbitrary, and the tightest fit takes their place: for two equal
//! moments the smallest rectangle around the projection along the third axis
//! (Freeman & Shapira 1975); for three the smallest box that has a face flush
//! with a face of the convex hull (after O'Rourke 1985). The smallest box is not
//! used for all, because elongated irregular grains lie across it and would
//! come out as equant. Elongation I/L, flatness S/I and
//! classes at 2/3: Zingg 1935. (S·I/L²)^(1/3): Krumbein 1941. Sphericity
//! π^(1/3) (6V)^(2/3) / A: Wadell 1932. Convexity V/V_hull. (S²/(L·I))^(1/3):
//! Sneed & Folk 1958. Cost at most O(F·(n log n + m²)) for a hull of F face
//! directions and n vertices whose outline has m corners. Volumes and areas are
//! exact for the mesh. Roundness: see [`super::roundness`]. Roughness A / A_hull: Janoo 1998
//! has perimeter over convex perimeter; here areas take the place of perimeters,
//! so that dents of the form count too.

use super::roundness::roundness;
use crate::geometry::hull::convex_hull;
use crate::geometry::{GeometryError, MassProperties, Mesh};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Form class after Zingg 1935, limits at 2/3.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Zingg {
    /// I/L > 2/3 and S/I ≤ 2/3: disc.
    Disc,
    /// I/L > 2/3 and S/I > 2/3: equant.
    Equant,
    /// I/L ≤ 2/3 and S/I ≤ 2/3: blade.
    Blade,
    /// I/L ≤ 2/3 and S/I > 2/3: rod.
    Rod,
}

/// Size and form of a solid; lengths in metres, ratios without unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Descriptors {
    /// Volume, m³.
    pub volume: f64,
    /// Surface area, m².
    pub area: f64,
    /// Diameter of the sphere of equal volume, m.
    pub volume_diameter: f64,
    /// Diameter of the sphere of equal area, m.
    pub area_diameter: f64,
    /// Largest distance of two points, m.
    pub span: f64,
    /// Longest principal dimension L, m.
    pub long: f64,
    /// Intermediate principal dimension I, m.
    pub intermediate: f64,
    /// Shortest principal dimension S, m.
    pub short: f64,
    /// I/L, from 0 to 1.
    pub elongation: f64,
    /// S/I, from 0 to 1.
    pub flatness: f64,
    /// Class of elongation and flatness.
    pub zingg: Zingg,
    /// Krumbein's sphericity (S·I/L²)^(1/3).
    pub krumbein_sphericity: f64,
    /// Sneed and Folk's maximum projection sphericity (S²/(L·I))^(1/3).
    pub projection_sphericity: f64,
    /// Wadell's sphericity: area of the sphere of equal volume over the area.
    pub wadell_sphericity: f64,
    /// Volume over that of the convex hull.
    pub convexity: f64,
    /// Radius of curvature at corners over that of the inscribed sphere, see [`super::roundness`].
    pub roundness: f64,
    /// Surface area over that of the convex hull, at least 1.
    pub roughness: f64,
    /// Diameter of the largest inscribed sphere, m.
    pub inscribed_diameter: f64,
}

/// Measures a closed, outward-oriented mesh; an error if it has no convex hull.
pub fn describe(mesh: &Mesh) -> Result<Descriptors, GeometryError> {
    let mut made = describe_form(mesh)?;
    let (roundness, inscribed) = roundness(mesh).ok_or(GeometryError::Method {
        reason: "the surface has no inside to put a sphere in".to_owned(),
    })?;
    (made.roundness, made.inscribed_diameter) = (roundness, 2.0 * inscribed);
    Ok(made)
}

/// As [`describe`] without what needs distances: roundness and inscribed
/// diameter are 0. A tenth of the cost.
pub fn describe_form(mesh: &Mesh) -> Result<Descriptors, GeometryError> {
    let mass = mesh.mass_properties();
    let area = mesh.area();
    let hull = convex_hull(&mesh.vertices)?;
    // Dimensions of a hull of very many vertices: by its outermost points in 2 000 directions.
    let coarse = match hull.vertices.len() {
        0..=LARGE => None,
        _ => convex_hull(&outermost(&hull.vertices)).ok(),
    };
    let form = coarse.as_ref().unwrap_or(&hull);
    let [short, intermediate, long] = principal_dimensions(&mass, form);
    let (elongation, flatness) = (intermediate / long, short / intermediate);
    let volume = mass.volume;
    Ok(Descriptors {
        volume,
        area,
        volume_diameter: mass.equivalent_diameter(),
        area_diameter: (area / PI).sqrt(),
        span: span(&form.vertices),
        long,
        intermediate,
        short,
        elongation,
        flatness,
        zingg: match (elongation > 2.0 / 3.0, flatness > 2.0 / 3.0) {
            (true, false) => Zingg::Disc,
            (true, true) => Zingg::Equant,
            (false, false) => Zingg::Blade,
            (false, true) => Zingg::Rod,
        },
        krumbein_sphericity: (short * intermediate / (long * long)).cbrt(),
        projection_sphericity: (short * short / (long * intermediate)).cbrt(),
        wadell_sphericity: PI.cbrt() * (6.0 * volume).cbrt().powi(2) / area,
        convexity: (volume / hull.mass_properties().volume).min(1.0),
        roundness: 0.0,
        roughness: (area / hull.area()).max(1.0),
        inscribed_diameter: 0.0,
    })
}

/// Vertices of a hull from which on its dimensions are those of its outermost points.
const LARGE: usize = 3000;

/// The points that are outermost in 2 000 directions spread evenly (Fibonacci
/// spiral): lengths between them are short by 0.1 % at most, as no direction is
/// farther than 0.04 from one of these.
fn outermost(points: &[Vec3]) -> Vec<Vec3> {
    let golden = PI * (3.0 - 5f64.sqrt());
    let mut kept: Vec<usize> = (0..2000)
        .filter_map(|k| {
            let z = 1.0 - (f64::from(k) + 0.5) / 1000.0;
            let ring = (1.0 - z * z).sqrt();
            let (s, c) = (golden * f64::from(k)).sin_cos();
            let along = Vec3::new(ring * c, ring * s, z);
            let height = |i: &usize| along.dot(&points[*i]);
            (0..points.len()).max_by(|i, j| height(i).total_cmp(&height(j)))
        })
        .collect();
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|k| points[k]).collect()
}

/// Principal moments that differ by less than this share count as equal.
const SAME_MOMENT: f64 = 1e-3;

/// S, I, L.
fn principal_dimensions(mass: &MassProperties, hull: &Mesh) -> [f64; 3] {
    let (moments, turn) = mass.principal();
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| turn * axis);
    let same = |i: usize, j: usize| (moments[j] - moments[i]) < SAME_MOMENT * moments[2];
    let mut sides = match (same(0, 1), same(1, 2)) {
        (true, true) => return smallest_box(hull),
        (true, false) => around(hull, &axes[2], &axes[0]),
        (false, true) => around(hull, &axes[0], &axes[1]),
        (false, false) => axes.map(|axis| extent(hull, &axis)),
    };
    sides.sort_by(f64::total_cmp);
    sides
}

fn extent(hull: &Mesh, axis: &Vec3) -> f64 {
    let (low, high) = hull
        .vertices
        .iter()
        .map(|p| axis.dot(p))
        .fold((f64::MAX, f64::MIN), |(low, high), h| (low.min(h), high.max(h)));
    high - low
}

/// Sides of the smallest box with one edge along `axis`; `across` is any unit vector square to it.
fn around(hull: &Mesh, axis: &Vec3, across: &Vec3) -> [f64; 3] {
    let third = axis.cross(across);
    let shadow = hull.vertices.iter().map(|p| [across.dot(p), third.dot(p)]).collect();
    let [width, length] = smallest_rectangle(shadow);
    [extent(hull, axis), width, length]
}

fn span(points: &[Vec3]) -> f64 {
    let squared = |(i, p): (usize, &Vec3)| {
        points[i..].iter().map(|q| (p - q).norm_squared()).fold(0.0, f64::max)
    };
    points.iter().enumerate().map(squared).fold(0.0, f64::max).sqrt()
}

/// Edges of the smallest box with a face flush with one of `hull`, rising.
fn smallest_box(hull: &Mesh) -> [f64; 3] {
    let mut best = (f64::INFINITY, [0.0; 3]);
    let mut seen: Vec<Vec3> = Vec::new();
    for [a, b, c] in hull.facets() {
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
        // Triangles of one flat face, or of opposite faces, give the same box.
        if seen.iter().any(|known| known.cross(&normal).norm_squared() < 1e-24) {
            continue;
        }
        seen.push(normal);
        let sides = around(hull, &normal, &(b - a).normalize());
        let volume = sides.iter().product();
        if volume < best.0 {
            best = (volume, sides);
        }
    }
    best.1.sort_by(f64::total_cmp);
    best.1
}

/// Sides of the rectangle of least area around `points`: one of its sides is
/// flush with a side of their outline (Freeman & Shapira 1975). Every corner is
/// looked at for every side: rotating calipers stop too early where rounding
/// makes the outline of nearly equal points not quite convex.
fn smallest_rectangle(points: Vec<[f64; 2]>) -> [f64; 2] {
    let ring = outline(points);
    let mut best = (f64::INFINITY, [0.0; 2]);
    for (i, p) in ring.iter().enumerate() {
        let q = ring[(i + 1) % ring.len()];
        let length = (q[0] - p[0]).hypot(q[1] - p[1]);
        if length == 0.0 {
            continue;
        }
        let (c, s) = ((q[0] - p[0]) / length, (q[1] - p[1]) / length);
        let extent = |a: f64, b: f64| {
            let along = ring.iter().map(|r| a * r[0] + b * r[1]);
            let (low, high) =
                along.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
            high - low
        };
        let sides = [extent(c, s), extent(-s, c)];
        if sides[0] * sides[1] < best.0 {
            best = (sides[0] * sides[1], sides);
        }
    }
    best.1
}

/// Convex outline, counter-clockwise (monotone chain, Andrew 1979).
fn outline(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let turn = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| {
        (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    };
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., o, a] = chain[..]
                && turn(o, a, p) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut ring = chain(&mut points.iter().copied());
    ring.extend(chain(&mut points.iter().rev().copied()));
    ring
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::num::random;

    fn turned(solid: Primitive, segments: u32) -> Mesh {
        let turn = random::rotation(&mut random::stream(8, "descriptors", 0));
        solid.mesh(segments).mapped(|p| turn * p + Vec3::new(1.0, 2.0, 3.0))
    }

    fn assert_close(found: f64, expected: f64, tolerance: f64, what: &str) {
        assert!((found - expected).abs() <= tolerance, "{what}: {found}, expected {expected}");
    }

    #[test]
    fn cube_and_box() {
        let cube = describe(&turned(Primitive::Box { edges: Vec3::repeat(2.0) }, 3)).expect("hull");
        for (found, expected, what) in [
            (cube.volume, 8.0, "volume"),
            (cube.area, 24.0, "area"),
            (cube.long, 2.0, "long"),
            (cube.short, 2.0, "short"),
            (cube.krumbein_sphericity, 1.0, "krumbein"),
            (cube.wadell_sphericity, (PI / 6.0).cbrt(), "wadell"),
            (cube.convexity, 1.0, "convexity"),
            (cube.span, 12f64.sqrt(), "span"),
            (cube.area_diameter, (24.0 / PI).sqrt(), "area diameter"),
        ] {
            assert_close(found, expected, 1e-11, what);
        }
        assert_eq!(cube.zingg, Zingg::Equant);
        for (edges, class) in [
            ([4.0, 3.5, 1.0], Zingg::Disc),
            ([4.0, 2.0, 1.0], Zingg::Blade),
            ([4.0, 1.2, 1.0], Zingg::Rod),
        ] {
            let made = describe(&turned(Primitive::Box { edges: edges.into() }, 3)).expect("hull");
            assert_eq!(made.zingg, class);
            let [l, i, s] = edges;
            assert_close(made.long, l, 1e-11, "L");
            assert_close(made.intermediate, i, 1e-11, "I");
            assert_close(made.short, s, 1e-11, "S");
            assert_close(made.projection_sphericity, (s * s / (l * i)).cbrt(), 1e-11, "S&F");
        }
    }

    #[test]
    fn ellipsoid() {
        let axes = Vec3::new(3.0, 2.0, 1.0);
        let made = describe(&turned(Primitive::Ellipsoid { axes }, 70)).expect("hull");
        assert_close(made.volume, PI, 0.01, "volume");
        assert_close(made.long, 3.0, 0.06, "L");
        assert_close(made.intermediate, 2.0, 0.06, "I");
        assert_close(made.short, 1.0, 0.03, "S");
        // Area of the ellipsoid of semi-axes 1.5, 1, 0.5 by elliptic integrals.
        assert_close(made.area, 12.2205, 0.04, "area");
        assert_close(made.convexity, 1.0, 1e-6, "convexity");
        let ball = describe(&turned(Primitive::Sphere { diameter: 2.0 }, 60)).expect("hull");
        assert_close(ball.wadell_sphericity, 1.0, 0.003, "wadell");
    }

    #[test]
    fn cylinder() {
        let solid = Primitive::Cylinder { diameter: 2.0, height: 5.0 };
        let made = describe(&turned(solid, 120)).expect("hull");
        assert_close(made.long, 5.0, 1e-9, "L");
        assert_close(made.short, 2.0, 1e-3, "S");
        assert_close(made.span, 29f64.sqrt(), 1e-9, "span");
        assert_close(made.area, 12.0 * PI, 0.03, "area");
        let wadell = PI.cbrt() * (30.0 * PI).cbrt().powi(2) / (12.0 * PI);
        assert_close(made.wadell_sphericity, wadell, 1e-3, "wadell");
        assert_eq!(made.zingg, Zingg::Rod);
    }

    #[test]
    fn tetrahedron_and_a_dented_solid() {
        let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let mut mesh = Mesh {
            vertices: corners.map(Vec3::from).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 1]],
        };
        let made = describe(&mesh).expect("hull");
        assert_close(made.volume, 8.0 / 3.0, 1e-12, "volume");
        assert_close(made.area, 8.0 * 3f64.sqrt(), 1e-12, "area");
        assert_close(made.wadell_sphericity, 0.671_139, 1e-6, "wadell");
        // Edge a = √8: a rectangle a × a√3/2 on the face, height a√(2/3).
        let box_volume = made.long * made.intermediate * made.short;
        assert_close(box_volume, 8f64.powf(1.5) * 0.5f64.sqrt(), 1e-11, "box");
        mesh.vertices.push(Vec3::zeros());
        mesh.triangles.splice(0..1, [[0, 1, 4], [1, 2, 4], [2, 0, 4]]);
        assert_close(describe(&mesh).expect("hull").convexity, 0.75, 1e-12, "a quarter is gone");
    }

    /// Volume of the box around `mesh` in a frame turned by `turn`.
    fn box_volume(mesh: &Mesh, turn: &crate::num::Rotation) -> f64 {
        mesh.mapped(|p| turn * p).bounds().size().product()
    }

    #[test]
    fn smallest_box_is_what_a_search_over_rotations_finds() {
        for seed in 0..6 {
            let mut source = random::stream(seed, "box", 0);
            let points: Vec<Vec3> = (0..40)
                .map(|_| random::direction(&mut source).component_mul(&Vec3::new(1.5, 1.0, 0.6)))
                .collect();
            // Copies a rounding error away, as meshes from files have them.
            let twins = points.iter().map(|p| p * (1.0 + 1e-16) + Vec3::repeat(1e-17));
            let all: Vec<Vec3> = points.iter().copied().chain(twins).collect();
            let hull = convex_hull(&all).expect("points in space");
            let found: f64 = smallest_box(&hull).iter().product();
            let mut searched = f64::MAX;
            for _ in 0..10 {
                let mut turn = random::rotation(&mut source);
                let mut here = box_volume(&hull, &turn);
                for step in 0..300 {
                    let size = 0.5 * 0.975f64.powi(step);
                    let tilt = random::direction(&mut source) * size;
                    let next = crate::num::Rotation::from_scaled_axis(tilt) * turn;
                    let there = box_volume(&hull, &next);
                    if there < here {
                        (here, turn) = (there, next);
                    }
                }
                searched = searched.min(here);
            }
            assert!(found <= 1.02 * searched && found >= 0.98 * searched, "{found} {searched}");
        }
    }

    #[test]
    fn smallest_rectangle_is_no_larger_than_a_search_finds() {
        for seed in 0..50 {
            let mut source = random::stream(seed, "rectangle", 0);
            let points: Vec<[f64; 2]> = (0..12)
                .map(|_| [random::normal(&mut source), 0.3 * random::normal(&mut source)])
                .collect();
            let sides = smallest_rectangle(points.clone());
            let searched = (0..20_000)
                .map(|i| {
                    let (s, c) = (f64::from(i) * PI / 40_000.0).sin_cos();
                    let extent = |a: f64, b: f64| {
                        let (low, high) = points
                            .iter()
                            .map(|p| a * p[0] + b * p[1])
                            .fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
                        high - low
                    };
                    extent(c, s) * extent(-s, c)
                })
                .fold(f64::MAX, f64::min);
            let found = sides[0] * sides[1];
            assert!(found <= searched && found > searched * 0.995, "{found} {searched}");
        }
    }
}
