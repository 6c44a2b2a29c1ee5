//! Roundness in space: radius of curvature at corners over the radius of the
//! largest inscribed sphere.
//!
//! Wadell (1932) divides the mean radius of the corners of an outline by that
//! of its largest inscribed circle. In space there is no agreed form; here
//! roundness = Σ min(κ, 1/R) / Σ κ over points spread evenly on the surface where κ > 0: the mean
//! of min(1, (1/κ)/R) weighted with curvature, so that corners count and flats
//! do not. R is the radius of the largest inscribed sphere, κ the larger principal curvature at the
//! scale s = 0.08 d_V (at least 0.005 of the diagonal): largest eigenvalue of
//! Σ w θ_e |e| t⊗t / (π s²/2) over the pieces of edges within s of the point, w = 1 − ρ²/s² with
//! ρ the distance, θ_e the dihedral angle (positive where convex), t the direction of the edge
//! (curvature measures, Cohen-Steiner & Morvan 2003; the
//! eigenvalue along t belongs to bending across t; the denominator is ∫w over a
//! plane). That is a property of the surface, not of its triangles, as long as these are
//! no larger than s; coarser ones count as edges. A sphere has 1. A sharp edge of
//! angle θ has κ = 8θ/(3πs) (1 − u²)^1.5 at the distance u s from it: a cube comes out at 0.24,
//! and angularity finer than s cannot be told from an edge. R: largest clearance
//! found by a pattern search from the deepest of 126 points (a local optimum could
//! be missed). Cost O(E log E + n · pieces in a ball).

use crate::geometry::distance::sample_surface;
use crate::geometry::{Mesh, SignedDistance};
use crate::num::{Mat3, Vec3, eigen, random};
use std::collections::BTreeMap;

/// Points that curvature is measured at.
const CENTRES: usize = 500;
/// Scale of curvature over the volume-equivalent diameter.
pub const SCALE: f64 = 0.08;
/// The scale over the diagonal is at least this: slender solids have a small volume.
const LEAST_SCALE: f64 = 0.005;

/// Roundness and inscribed radius (m) of a closed mesh; `None` where it has no signed distance.
pub fn roundness(mesh: &Mesh) -> Option<(f64, f64)> {
    let inscribed = inscribed_radius(mesh)?;
    let scale = (SCALE * mesh.mass_properties().equivalent_diameter())
        .max(LEAST_SCALE * mesh.bounds().diagonal());
    let (mut capped, mut whole) = (0.0, 0.0);
    for curvature in curvatures(mesh, scale) {
        capped += curvature.clamp(0.0, 1.0 / inscribed);
        whole += curvature.max(0.0);
    }
    let roundness = if whole > 0.0 { capped / whole } else { 1.0 };
    Some((roundness, inscribed))
}

/// Radius of the largest sphere found inside, m.
pub fn inscribed_radius(mesh: &Mesh) -> Option<f64> {
    let distance = SignedDistance::new(mesh).ok()?;
    let mass = mesh.mass_properties();
    let bounds = mesh.bounds();
    // Points of a coarse grid, the deepest of which are improved.
    let mut starts = vec![(-distance.at(&mass.centroid), mass.centroid)];
    let size = bounds.size();
    for k in 0..125 {
        let share = [k % 5, k / 5 % 5, k / 25].map(|i| (f64::from(i) + 0.5) / 5.0);
        let point = bounds.low + Vec3::from(share).component_mul(&size);
        starts.push((-distance.at(&point), point));
    }
    starts.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut best = 0.0f64;
    for (mut depth, mut point) in starts.into_iter().take(3) {
        let mut step = 0.1 * size.max();
        while step > 1e-3 * size.max() {
            let mut improved = false;
            for direction in directions() {
                let next = point + direction * step;
                // A surface that passes through itself may have an inside without end.
                if !bounds.contains(&next) {
                    continue;
                }
                let there = -distance.at(&next);
                if there > depth {
                    (depth, point, improved) = (there, next, true);
                }
            }
            if !improved {
                step *= 0.5;
            }
        }
        best = best.max(depth);
    }
    (best > 0.0).then_some(best)
}

/// Along the axes and the diagonals of space.
fn directions() -> impl Iterator<Item = Vec3> {
    let axes = (0..3)
        .flat_map(|k| [1.0, -1.0].map(|s| Vec3::from_fn(|i, _| if i == k { s } else { 0.0 })));
    let corner = |k: u32| Vec3::from_fn(|i, _| if k >> i & 1 == 1 { 0.577 } else { -0.577 });
    axes.chain((0..8).map(corner))
}

/// A piece of an edge.
struct Bend {
    at: Vec3,
    /// Angle times length, m.
    bend: f64,
    along: Vec3,
}

/// Larger principal curvature at points spread over `mesh`, at the length `scale`, 1/m.
fn curvatures(mesh: &Mesh, scale: f64) -> Vec<f64> {
    let mut stream = random::stream(0, "roundness", 0);
    let centres = sample_surface(mesh, CENTRES, &mut stream);
    let bends = bends(mesh, 0.25 * scale);
    let cell =
        |p: &Vec3| -> [i64; 3] { std::array::from_fn(|axis| (p[axis] / scale).floor() as i64) };
    let mut grid: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
    for (index, bend) in bends.iter().enumerate() {
        grid.entry(cell(&bend.at)).or_default().push(index as u32);
    }
    let plane = 0.5 * std::f64::consts::PI * scale * scale;
    centres
        .iter()
        .map(|centre| {
            let [x, y, z] = cell(&centre.point);
            let mut tensor = Mat3::zeros();
            for k in 0..27 {
                let here = [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1];
                for index in grid.get(&here).into_iter().flatten() {
                    let Bend { at, bend, along } = &bends[*index as usize];
                    let weight = 1.0 - (at - centre.point).norm_squared() / (scale * scale);
                    if weight > 0.0 {
                        tensor += along * along.transpose() * (weight * bend);
                    }
                }
            }
            eigen::symmetric(&tensor).0[2] / plane
        })
        .collect()
}

/// Edges that are bent, in pieces no longer than `piece`.
fn bends(mesh: &Mesh, piece: f64) -> Vec<Bend> {
    let normals: Vec<Vec3> = mesh
        .facets()
        .map(|[a, b, c]| (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros))
        .collect();
    let mut bends = Vec::new();
    for edge in crate::geometry::topology::edges(mesh) {
        let [(s, s_rising), (t, _)] = edge.triangles[..] else { continue };
        let [p, q] = edge.ends.map(|end| mesh.vertices[end as usize]);
        let (m, n) = (normals[s as usize], normals[t as usize]);
        let Some(along) = (q - p).try_normalize(0.0) else { continue };
        let forward = if s_rising { along } else { -along };
        // Turning from the first normal to the second about the edge: positive where convex.
        let angle = m.cross(&n).dot(&forward).atan2(m.dot(&n));
        if angle.abs() < 1e-9 {
            continue;
        }
        let length = (q - p).norm();
        let count = (length / piece).ceil().max(1.0);
        for k in 0..count as usize {
            let at = p + (q - p) * ((k as f64 + 0.5) / count);
            bends.push(Bend { at, bend: angle * length / count, along });
        }
    }
    bends
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use std::f64::consts::PI;

    fn of(solid: Primitive, segments: u32) -> (f64, f64) {
        let turn = random::rotation(&mut random::stream(1, "roundness test", 0));
        roundness(&solid.mesh(segments).mapped(|p| turn * p * 2e-3)).expect("closed")
    }

    #[test]
    fn a_sphere_is_round() {
        let (round, radius) = of(Primitive::Sphere { diameter: 2.0 }, 100);
        assert!(round > 0.9, "{round}");
        assert!((radius / 2e-3 - 1.0).abs() < 0.01, "{radius}");
    }

    #[test]
    fn sharp_edges_have_the_closed_form() {
        for edges in [Vec3::new(1.0, 1.5, 0.8), Vec3::repeat(1.0)] {
            let (round, radius) = of(Primitive::Box { edges }, 4);
            let inscribed = 0.5 * edges.min();
            assert!((radius / (inscribed * 2e-3) - 1.0).abs() < 1e-2, "{radius}");
            let scale = SCALE * (6.0 * edges.product() / PI).cbrt();
            let (mut capped, mut whole) = (0.0, 0.0);
            for k in 0..1000 {
                let u = (f64::from(k) + 0.5) / 1000.0;
                let kappa = 8.0 * (0.5 * PI) / (3.0 * PI * scale) * (1.0 - u * u).powf(1.5);
                capped += kappa.min(1.0 / inscribed);
                whole += kappa;
            }
            assert!((round / (capped / whole) - 1.0).abs() < 0.15, "{round} {}", capped / whole);
        }
    }

    #[test]
    fn an_ellipsoid_has_what_integration_finds() {
        // κ over a fine parameter grid by the closed form of an ellipsoid's curvatures.
        let [a, b, c] = [1.5f64, 1.0, 0.7];
        let (mut capped, mut whole) = (0.0, 0.0);
        let n = 400;
        for i in 0..n {
            let theta = PI * (i as f64 + 0.5) / n as f64;
            for j in 0..n {
                let phi = 2.0 * PI * (j as f64 + 0.5) / n as f64;
                let (st, ct) = theta.sin_cos();
                let (sp, cp) = phi.sin_cos();
                let p = Vec3::new(a * st * cp, b * st * sp, c * ct);
                let square =
                    (p.x / (a * a)).powi(2) + (p.y / (b * b)).powi(2) + (p.z / (c * c)).powi(2);
                let h = 1.0 / square.sqrt();
                let gauss = h.powi(4) / (a * b * c).powi(2);
                let mean = h.powi(3) * (a * a + b * b + c * c - p.norm_squared())
                    / (2.0 * (a * b * c).powi(2));
                let kappa = mean + (mean * mean - gauss).max(0.0).sqrt();
                let element = st * a * b * c / h;
                capped += element * kappa.min(1.0 / c);
                whole += element * kappa;
            }
        }
        let expected = capped / whole;
        let (round, _) =
            of(Primitive::Ellipsoid { axes: Vec3::new(2.0 * a, 2.0 * b, 2.0 * c) }, 160);
        assert!((round / expected - 1.0).abs() < 0.1, "{round} {expected}");
    }
}
