//! Rough surfaces as bodies: a sheet (open), a slab between two fields, a ball.
//!
//! Every field covers the unit square. Sheet: z = h(x, y), open, so no grain,
//! but a surface to look at or to use as a wall. Slab: two independent fields
//! on the two faces of a plate. Ball: six independent fields, one around each end of
//! the axes of a sphere of diameter 1, laid on it by the equal-area projection
//! of Lambert (true at the middle, lengths within 16 % at 60°) and blended with
//! weights w of Σw² = 1, which keeps variance and correlation of heights without
//! mean. A sum of two skewed heights is less skewed than each, and fields that each have
//! the wanted variance do not have it together with their slopes; so the blended heights are
//! then replaced, rank by rank, by those of the six fields: their distribution is kept to
//! the last moment. r = 1/2 + h. Heights of a ball must stay above −1/2, those
//! of a slab must not meet: a draw where they do is refused. Cost O(points² log points).

use super::draw::{Drawn, Fact};
use super::field::{Field, first_fall, moments};
use crate::geometry::{GeometryError, Mesh, Primitive};
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the rough surface bounds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Bounded {
    /// A sphere of diameter 1 with a rough surface.
    #[default]
    Ball,
    /// A plate of edge 1 with two rough faces.
    Slab {
        /// Mean thickness over the edge, from 0.01 to 2.
        thickness: f64,
    },
    /// Nothing: an open surface over the unit square, never a grain.
    Sheet,
}

/// Outline of sheets and slabs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Outline {
    /// A square.
    #[default]
    Square,
    /// A circle.
    Circle,
}

impl Bounded {
    pub(super) fn validate(&self) -> Result<(), Fault> {
        match self {
            Self::Slab { thickness } => Fault::within("slab.thickness", *thickness, 0.01, 2.0),
            Self::Ball | Self::Sheet => Ok(()),
        }
    }
}

/// A fault unless `points` is a usable number of points along a side.
pub(super) fn validate_points(points: u32) -> Result<(), Fault> {
    Fault::within("points", f64::from(points), 8.0, 512.0)
}

/// What the heights of a surface should be; lengths over the side or the diameter.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Asked {
    pub rms: Option<f64>,
    pub skewness: Option<f64>,
    pub kurtosis: Option<f64>,
    /// Length at which R falls to the level that comes with it, along x and y.
    pub correlation: Option<([f64; 2], f64)>,
    pub dimension: Option<f64>,
}

/// Level that R falls to at the correlation length where a method asks for none.
const LEVEL: f64 = 0.367_879_441_171_442_33;

/// The body that fields drawn by `field` bound, with its statistics.
pub(super) fn body(
    bounded: Bounded,
    outline: Outline,
    asked: &Asked,
    recipe: String,
    mut field: impl FnMut() -> Result<Field, GeometryError>,
) -> Result<Drawn, GeometryError> {
    match bounded {
        Bounded::Sheet => {
            let top = field()?;
            let (mesh, _) = face(&top, 0.0, outline);
            Ok(Drawn { mesh, recipe: format!("{recipe}, open sheet"), facts: facts(&top, asked) })
        }
        Bounded::Slab { thickness } => {
            let (top, bottom) = (field()?, field()?);
            let mut facts = facts(&top, asked);
            let pairs = top.heights.iter().zip(&bottom.heights);
            let least = pairs.map(|(t, b)| thickness + t - b).fold(f64::INFINITY, f64::min);
            facts.push(Fact::found("least thickness", least));
            if least <= 0.0 {
                let reason = format!("the two faces meet: least thickness {least:.4}");
                return Err(GeometryError::Method { reason });
            }
            let mesh = slab(&top, &bottom, thickness, outline);
            Ok(Drawn { mesh, recipe: format!("{recipe}, slab"), facts })
        }
        Bounded::Ball => {
            let mut fields = Vec::new();
            for _ in 0..6 {
                fields.push(field()?);
            }
            let (mesh, heights, directions) = ball(&fields);
            let least = heights.iter().copied().fold(f64::INFINITY, f64::min);
            if least <= -0.48 {
                let reason = format!("the surface reaches the middle of the ball: {least:.4}");
                return Err(GeometryError::Method { reason });
            }
            let facts = ball_facts(&fields, &heights, &directions, asked);
            Ok(Drawn { mesh, recipe: format!("{recipe}, ball"), facts })
        }
    }
}

fn height_facts(heights: &[f64], asked: &Asked, of: &str) -> Vec<Fact> {
    let [_, rms, skewness, kurtosis] = moments(heights);
    let fact = |quantity: &str, asked: Option<f64>, measured: f64| Fact {
        quantity: format!("{quantity}{of}"),
        asked,
        measured,
    };
    vec![
        fact("rms height", asked.rms, rms),
        fact("skewness", asked.skewness, skewness),
        fact("kurtosis", asked.kurtosis, kurtosis),
    ]
}

/// Statistics of a field over the unit square.
fn facts(field: &Field, asked: &Asked) -> Vec<Fact> {
    let mut facts = height_facts(&field.heights, asked, "");
    let level = asked.correlation.map_or(LEVEL, |(_, level)| level);
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        let curve = field.autocorrelation(axis, field.points / 2);
        let Some(found) = first_fall(&curve, level) else { continue };
        facts.push(Fact {
            quantity: format!("length along {name} at which R falls to {level:.3}"),
            asked: asked.correlation.map(|(lengths, _)| lengths[axis]),
            measured: found / (field.points - 1) as f64,
        });
    }
    facts.push(Fact {
        quantity: "fractal dimension".to_owned(),
        asked: asked.dimension,
        measured: field.fractal_dimension(),
    });
    facts
}

/// Statistics of the fields and of the heights on the sphere.
fn ball_facts(fields: &[Field], heights: &[f64], directions: &[Vec3], asked: &Asked) -> Vec<Fact> {
    let mut facts = height_facts(heights, asked, " on the ball");
    let level = asked.correlation.map_or(LEVEL, |(_, level)| level);
    let step = 1.0 / (fields[0].points - 1) as f64;
    let curve = sphere_correlation(heights, directions, step);
    if let Some(found) = first_fall(&curve, level) {
        facts.push(Fact {
            quantity: format!("arc at which R falls to {level:.3} on the ball"),
            // One length where both axes ask for the same.
            asked: asked.correlation.and_then(|([x, y], _)| (x == y).then_some(x)),
            measured: found * step,
        });
    }
    let mean = fields.iter().map(Field::fractal_dimension).sum::<f64>() / fields.len() as f64;
    facts.push(Fact {
        quantity: "mean fractal dimension of the six fields".to_owned(),
        asked: asked.dimension,
        measured: mean,
    });
    facts
}

/// R over the arc on a sphere of diameter 1, in bins about multiples of `step`.
fn sphere_correlation(heights: &[f64], directions: &[Vec3], step: f64) -> Vec<f64> {
    let [mean, rms, ..] = moments(heights);
    let bins = (0.5 / step) as usize;
    let mut sums = vec![(0.0, 0.0); bins + 1];
    // Some 400 vertices spread over the list, each with all others.
    for i in (0..heights.len()).step_by((heights.len() / 400).max(1)) {
        for j in 0..heights.len() {
            let arc = 0.5 * directions[i].dot(&directions[j]).clamp(-1.0, 1.0).acos();
            let bin = (arc / step).round() as usize;
            if let Some((sum, count)) = sums.get_mut(bin) {
                *sum += (heights[i] - mean) * (heights[j] - mean);
                *count += 1.0;
            }
        }
    }
    sums.iter().map(|(sum, count)| sum / f64::max(*count, 1.0) / (rms * rms).max(1e-300)).collect()
}

/// The sphere of diameter 1 with the heights of six fields: surface, heights, directions.
fn ball(fields: &[Field]) -> (Mesh, Vec<f64>, Vec<Vec3>) {
    // An edge of the icosahedron in a sphere of diameter 1 is 0.526 long.
    let parts = (0.526 * fields[0].points as f64).ceil() as u32;
    let sphere = Primitive::Sphere { diameter: 2.0 }.mesh(5 * parts);
    let mut heights: Vec<f64> = sphere.vertices.iter().map(|d| blended(fields, d)).collect();
    take_distribution(&mut heights, fields);
    let vertices = sphere.vertices.iter().zip(&heights).map(|(d, h)| d * (0.5 + h)).collect();
    (Mesh { vertices, triangles: sphere.triangles }, heights, sphere.vertices)
}

/// Gives `heights` the distribution of the heights of `fields`, keeping their order.
fn take_distribution(heights: &mut [f64], fields: &[Field]) {
    let mut wanted: Vec<f64> = fields.iter().flat_map(|field| &field.heights).copied().collect();
    wanted.sort_by(f64::total_cmp);
    let mut ranks: Vec<usize> = (0..heights.len()).collect();
    // Sorting is stable: equal heights, as on a flat ball, are given in the order of the vertices.
    ranks.sort_by(|a, b| heights[*a].total_cmp(&heights[*b]));
    let share = wanted.len() as f64 / heights.len() as f64;
    for (rank, vertex) in ranks.into_iter().enumerate() {
        // Below the length for every rank, since rank + 1/2 is below the number of heights.
        heights[vertex] = wanted[((rank as f64 + 0.5) * share) as usize];
    }
}

/// Height in the direction of the unit vector `d`.
fn blended(fields: &[Field], d: &Vec3) -> f64 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for (face, field) in fields.iter().enumerate() {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        let cosine = sign * d[axis];
        // Nothing from 60° on: there the field ends.
        if cosine <= 0.5 {
            continue;
        }
        let weight = (2.0 * cosine - 1.0).powi(2);
        let stretch = 0.5 * (2.0 / (1.0 + cosine)).sqrt();
        let (u, v) = (stretch * d[(axis + 1) % 3], stretch * d[(axis + 2) % 3]);
        sum += weight * field.interpolated(0.5 + u, 0.5 + v);
        squares += weight * weight;
    }
    if squares > 0.0 { sum / squares.sqrt() } else { 0.0 }
}

/// A face z = h + `level`, and the ring of its vertices, counter-clockwise from above.
fn face(field: &Field, level: f64, outline: Outline) -> (Mesh, Vec<u32>) {
    let n = field.points;
    let last = (n - 1) as f64;
    let vertices = (0..n * n)
        .map(|k| {
            let square = [(k % n) as f64 / last, (k / n) as f64 / last].map(|t| 2.0 * t - 1.0);
            let [x, y] = match outline {
                Outline::Square => square,
                Outline::Circle => disc(square),
            };
            Vec3::new(0.5 * x, 0.5 * y, level + field.heights[k])
        })
        .collect();
    let at = |i: usize, j: usize| (j * n + i) as u32;
    let mut triangles = Vec::with_capacity(2 * (n - 1) * (n - 1));
    for j in 0..n - 1 {
        for i in 0..n - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            // Diagonals alternate, so that the surface has no grain.
            if (i + j) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    let ring = (0..n - 1)
        .map(|k| at(k, 0))
        .chain((0..n - 1).map(|k| at(n - 1, k)))
        .chain((1..n).rev().map(|k| at(k, n - 1)))
        .chain((1..n).rev().map(|k| at(0, k)))
        .collect();
    (Mesh { vertices, triangles }, ring)
}

/// An open surface with the ring of the vertices of its border.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    pub mesh: Mesh,
    pub ring: Vec<u32>,
}

/// A flat sheet of side (diameter) 1 about the origin in the plane z = 0.
pub(super) fn flat_sheet(points: usize, outline: Outline) -> Sheet {
    let (mesh, ring) = face(&Field::from_fn(points, |_, _| 0.0), 0.0, outline);
    Sheet { mesh, ring }
}

/// `sheet` between copies moved by half the thickness along the normals of its vertices.
pub(super) fn thickened(sheet: &Sheet, thickness: f64) -> Mesh {
    let mut normals = vec![Vec3::zeros(); sheet.mesh.vertices.len()];
    for (triangle, [a, b, c]) in sheet.mesh.triangles.iter().zip(sheet.mesh.facets()) {
        let normal = (b - a).cross(&(c - a));
        triangle.iter().for_each(|corner| normals[*corner as usize] += normal);
    }
    let moved = |distance: f64| {
        let places = sheet.mesh.vertices.iter().zip(&normals);
        let vertices = places
            .map(|(p, n)| p + n.try_normalize(1e-300).unwrap_or_else(Vec3::zeros) * distance)
            .collect();
        Mesh { vertices, triangles: sheet.mesh.triangles.clone() }
    };
    closed(moved(0.5 * thickness), moved(-0.5 * thickness), &sheet.ring)
}

/// The square [-1, 1]² on the unit disc, rings to rings (Shirley & Chiu 1997).
fn disc([x, y]: [f64; 2]) -> [f64; 2] {
    const QUARTER: f64 = std::f64::consts::FRAC_PI_4;
    if x == 0.0 && y == 0.0 {
        return [0.0, 0.0];
    }
    let (radius, angle) =
        if x.abs() > y.abs() { (x, QUARTER * y / x) } else { (y, 2.0 * QUARTER - QUARTER * x / y) };
    [radius * angle.cos(), radius * angle.sin()]
}

/// The plate between `top` and `bottom`, the sides straight.
fn slab(top: &Field, bottom: &Field, thickness: f64, outline: Outline) -> Mesh {
    let (above, ring) = face(top, 0.5 * thickness, outline);
    let (below, _) = face(bottom, -0.5 * thickness, outline);
    closed(above, below, &ring)
}

/// Two copies of a sheet, the lower one turned over, joined along their borders.
fn closed(above: Mesh, below: Mesh, ring: &[u32]) -> Mesh {
    let mut mesh = above;
    let shift = mesh.vertices.len() as u32;
    mesh.vertices.extend(below.vertices);
    mesh.triangles.extend(below.triangles.iter().map(|&[a, b, c]| [a, c, b].map(|k| k + shift)));
    for (k, &here) in ring.iter().enumerate() {
        let next = ring[(k + 1) % ring.len()];
        mesh.triangles.extend([[here + shift, next + shift, next], [here + shift, next, here]]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::topology::inspect;
    use crate::num::random;

    fn flat() -> Result<Field, GeometryError> {
        Ok(Field::from_fn(17, |_, _| 0.0))
    }

    fn made(bounded: Bounded, outline: Outline) -> Drawn {
        body(bounded, outline, &Asked::default(), "flat".to_owned(), flat).expect("flat faces")
    }

    #[test]
    fn flat_fields_bound_the_plain_bodies() {
        let slab = Bounded::Slab { thickness: 0.25 };
        let report = inspect(&made(slab, Outline::Square).mesh);
        assert!(report.is_closed() && report.euler_characteristic == 2, "{report:?}");
        assert!((report.volume - 0.25).abs() < 1e-12);
        let round = inspect(&made(slab, Outline::Circle).mesh);
        assert!(round.is_closed());
        // A polygon of 64 corners in the circle of diameter 1.
        assert!((round.volume / (0.25 * std::f64::consts::FRAC_PI_4) - 1.0).abs() < 3e-3);
        let ball = inspect(&made(Bounded::Ball, Outline::Square).mesh);
        assert!(ball.is_closed() && ball.euler_characteristic == 2);
        assert!((ball.volume / (std::f64::consts::PI / 6.0) - 1.0).abs() < 0.02);
        let sheet = inspect(&made(Bounded::Sheet, Outline::Square).mesh);
        assert_eq!((sheet.open_edges, sheet.pieces), (64, 1));
    }

    #[test]
    fn a_ball_has_the_moments_of_its_fields() {
        let mut stream = random::stream(4, "rough", 0);
        let mut skewed = || (0.3 * random::normal(&mut stream)).exp_m1();
        let fields: Vec<Field> = (0..6).map(|_| Field::from_fn(24, |_, _| skewed())).collect();
        let pooled: Vec<f64> = fields.iter().flat_map(|field| &field.heights).copied().collect();
        let (_, heights, _) = ball(&fields);
        for (of_ball, of_fields) in moments(&heights).into_iter().zip(moments(&pooled)) {
            assert!((of_ball / of_fields - 1.0).abs() < 0.03, "{of_ball} {of_fields}");
        }
    }

    #[test]
    fn blending_weighs_by_the_root_of_the_sum_of_squares() {
        let constant: Vec<Field> = (0..6).map(|_| Field::from_fn(8, |_, _| 1.0)).collect();
        assert!((blended(&constant, &Vec3::x()) - 1.0).abs() < 1e-12);
        let edge = Vec3::new(1.0, 1.0, 0.0).normalize();
        assert!((blended(&constant, &edge) - 2f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn faces_that_meet_are_refused() {
        let mut sign = 1.0;
        let steep = || {
            sign = -sign;
            Ok(Field::from_fn(9, |i, _| sign * i as f64))
        };
        let slab = Bounded::Slab { thickness: 0.5 };
        let made = body(slab, Outline::Square, &Asked::default(), String::new(), steep);
        assert!(made.expect_err("they cross").to_string().contains("faces meet"));
    }
}
