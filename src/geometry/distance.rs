//! Signed distance to a closed triangle surface, and points spread over it.
//!
//! Nearest point through a bounding volume hierarchy (parry3d); the sign from
//! the angle-weighted pseudo-normal of the nearest face, edge or vertex
//! (Bærentzen & Aanæs 2005). Where that normal stands so nearly at right angles
//! to the offset that rounding could turn the sign, the generalised winding
//! number decides (solid angles: van Oosterom & Strackee 1983).
//!
//! The surface is shifted and scaled to unit size inside, so that grains of a
//! micrometre and boulders of a kilometre meet the same tolerances.
//! Set-up O(n log n) for n triangles, a query O(log n) on usual meshes.

use super::Mesh;
use crate::num::Vec3;
use crate::num::random::{Stream, uniform};
use parry3d::math::Vector;
use parry3d::query::PointQueryWithLocation;
use parry3d::shape::{TriMesh, TriMeshFlags, TrianglePointLocation};
use std::collections::HashMap;

/// Why a surface has no signed distance.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DistanceError {
    /// No triangles.
    #[error("the surface has no triangles")]
    Empty,
    /// A triangle names a vertex that is not there, or a coordinate is NaN or infinite.
    #[error("the surface has a missing or non-finite vertex")]
    BadVertex,
    /// Edges without exactly one partner that runs the other way.
    #[error("the surface is not closed: {edges} edges have no opposite partner")]
    Open {
        /// How many.
        edges: usize,
    },
    /// Triangles run clockwise seen from outside, or the surface encloses nothing.
    #[error("the surface is inside out or encloses no volume")]
    InsideOut,
}

/// The surface point nearest to some point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Where, m.
    pub point: Vec3,
    /// Distance, m; negative inside the solid.
    pub distance: f64,
    /// Triangle of the mesh it lies on.
    pub triangle: usize,
}

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Where, m.
    pub point: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Area that the point stands for, m².
    pub area: f64,
}

/// Answers how far points are from a closed surface.
pub struct SignedDistance {
    surface: TriMesh,
    shift: Vec3,
    scale: f64,
}

/// Below this cosine between offset and pseudo-normal the winding number decides.
const UNSURE: f64 = 1e-5;

impl SignedDistance {
    /// Prepares `mesh`, which must be closed and outward-oriented.
    ///
    /// # Errors
    /// [`DistanceError`] where it is not.
    pub fn new(mesh: &Mesh) -> Result<Self, DistanceError> {
        check(mesh)?;
        let bounds = mesh.bounds();
        let (shift, scale) = (bounds.centre(), bounds.diagonal());
        let vertices = mesh.vertices.iter().map(|v| to_parry(&((v - shift) / scale))).collect();
        let surface = TriMesh::with_flags(vertices, mesh.triangles.clone(), TriMeshFlags::ORIENTED)
            .map_err(|_| DistanceError::Empty)?;
        Ok(Self { surface, shift, scale })
    }

    /// Signed distance of a finite point, m; negative inside.
    pub fn at(&self, point: &Vec3) -> f64 {
        self.nearest(point).distance
    }

    /// The surface point nearest to a finite `point`, with the signed distance.
    pub fn nearest(&self, point: &Vec3) -> Nearest {
        let unit = to_parry(&((point - self.shift) / self.scale));
        let (projection, (triangle, place)) =
            self.surface.project_local_point_and_get_location(unit, false);
        let offset = unit - projection.point;
        let length = offset.length();
        let cosine = offset.dot(self.pseudo_normal(triangle, place)) / length;
        // `length` 0 makes the cosine NaN: the point lies on the surface and has no sign.
        let inside = if cosine.abs() < UNSURE { self.winding(unit) > 0.5 } else { cosine < 0.0 };
        let sign = if inside { -1.0 } else { 1.0 };
        Nearest {
            point: from_parry(projection.point) * self.scale + self.shift,
            distance: sign * length * self.scale,
            triangle: triangle as usize,
        }
    }

    /// Unit pseudo-normal of a feature; zero where the feature has none.
    fn pseudo_normal(&self, triangle: u32, place: TrianglePointLocation) -> Vector {
        let Some(normals) = self.surface.pseudo_normals() else { return Vector::ZERO };
        match place {
            TrianglePointLocation::OnEdge(edge, _) => {
                normals.edges_pseudo_normal[triangle as usize][edge as usize]
            }
            TrianglePointLocation::OnVertex(corner) => {
                let vertex = self.surface.indices()[triangle as usize][corner as usize];
                normals.vertices_pseudo_normal[vertex as usize]
            }
            _ => self.surface.triangle(triangle).scaled_normal(),
        }
        .normalize_or_zero()
    }

    /// Generalised winding number: 1 inside, 0 outside.
    fn winding(&self, point: Vector) -> f64 {
        let angle: f64 = self
            .surface
            .triangles()
            .map(|t| {
                let (a, b, c) = (t.a - point, t.b - point, t.c - point);
                let (la, lb, lc) = (a.length(), b.length(), c.length());
                let volume = a.dot(b.cross(c));
                let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
                2.0 * volume.atan2(below)
            })
            .sum();
        angle / (4.0 * std::f64::consts::PI)
    }
}

fn to_parry(v: &Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn from_parry(v: Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

fn check(mesh: &Mesh) -> Result<(), DistanceError> {
    if mesh.triangles.is_empty() {
        return Err(DistanceError::Empty);
    }
    let known = mesh.vertices.len();
    let indices_good = mesh.triangles.iter().flatten().all(|&corner| (corner as usize) < known);
    if !indices_good || !mesh.vertices.iter().all(|v| v.iter().all(|c| c.is_finite())) {
        return Err(DistanceError::BadVertex);
    }
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from.min(to), from.max(to))).or_default() +=
                if from < to { 1 } else { -1 };
        }
    }
    let open = edges.values().filter(|&&balance| balance != 0).count();
    if open > 0 {
        return Err(DistanceError::Open { edges: open });
    }
    if mesh.mass_properties().volume <= 0.0 {
        return Err(DistanceError::InsideOut);
    }
    Ok(())
}

/// `count` points spread over `mesh` by area: one at random in each of `count`
/// equal shares of the area, taken triangle after triangle.
pub fn sample_surface(mesh: &Mesh, count: usize, stream: &mut Stream) -> Vec<SurfacePoint> {
    let total = mesh.area();
    if count == 0 || total <= 0.0 {
        return Vec::new();
    }
    let share = total / count as f64;
    let mut points = Vec::with_capacity(count);
    let mut passed = 0.0;
    let mut next = share * uniform(stream, 0.0, 1.0);
    for [a, b, c] in mesh.facets() {
        let cross = (b - a).cross(&(c - a));
        let double = cross.norm();
        passed += 0.5 * double;
        while next < passed && points.len() < count {
            // Square root: uniform in the triangle (Turk 1990).
            let (root, along) = (uniform(stream, 0.0, 1.0).sqrt(), uniform(stream, 0.0, 1.0));
            let point = a + (b - a) * (root * (1.0 - along)) + (c - a) * (root * along);
            points.push(SurfacePoint { point, normal: cross / double, area: share });
            next = share * (points.len() as f64 + uniform(stream, 0.0, 1.0));
        }
    }
    // Rounding of the running sum can lose the very last share.
    if let Some(&last) = points.last() {
        points.resize(count, last);
    }
    points
}

#[cfg(test)]
mod tests {
    use super::super::samples::{box_mesh, icosphere, l_mesh, random_star, random_union};
    use super::*;
    use crate::num::random::{direction, stream};

    /// Crossings of a ray with all triangles (Möller & Trumbore 1997): odd means inside.
    fn parity_inside(mesh: &Mesh, from: &Vec3, along: &Vec3) -> bool {
        mesh.facets()
            .filter(|[a, b, c]| {
                let (e1, e2) = (b - a, c - a);
                let p = along.cross(&e2);
                let det = e1.dot(&p);
                let t = from - a;
                let q = t.cross(&e1);
                let (u, v) = (t.dot(&p) / det, along.dot(&q) / det);
                u >= 0.0 && v >= 0.0 && u + v <= 1.0 && e2.dot(&q) / det > 0.0
            })
            .count()
            % 2
            == 1
    }

    /// Random points, most of them close to vertices and edges, where signs go wrong.
    fn probes(mesh: &Mesh, source: &mut Stream, count: usize) -> Vec<Vec3> {
        let size = mesh.bounds().diagonal();
        (0..count)
            .map(|i| {
                let [a, b, c] = mesh.corners(i % mesh.triangles.len());
                let near = size * 10f64.powf(uniform(source, -6.0, -0.5));
                let t = uniform(source, 0.0, 1.0);
                let place = match i % 4 {
                    0 => a,
                    1 => a + (b - a) * t,
                    2 => (a + b + c) / 3.0,
                    _ => mesh.bounds().centre(),
                };
                place + direction(source) * near
            })
            .collect()
    }

    #[test]
    fn signs_agree_with_ray_parity_near_edges_and_vertices() {
        let mut source = stream(11, "distance", 0);
        for size in [1e-6, 1.0, 1e4] {
            for case in 0..8 {
                let mesh = match case {
                    0 => box_mesh(Vec3::new(1.0, 2.0, 0.05)),
                    1 => l_mesh(),
                    2..4 => random_union(case, 6),
                    _ => random_star(case, 0.8),
                }
                .mapped(|v| v * size);
                let distance = SignedDistance::new(&mesh).expect("closed");
                for point in probes(&mesh, &mut source, 600) {
                    // Two of three rays: a single one can run through an edge.
                    let votes = (0..3)
                        .filter(|_| parity_inside(&mesh, &point, &direction(&mut source)))
                        .count();
                    let at = distance.at(&point);
                    assert_eq!(at < 0.0, votes >= 2, "case {case} size {size} at {at:e}");
                    assert_eq!(
                        distance.winding(to_parry(&((point - distance.shift) / distance.scale)))
                            > 0.5,
                        votes >= 2
                    );
                }
            }
        }
    }

    #[test]
    fn distance_of_a_box_has_its_closed_form() {
        let half = Vec3::new(0.5, 1.0, 1.5);
        let mesh = box_mesh(half * 2.0);
        let distance = SignedDistance::new(&mesh).expect("closed");
        let mut source = stream(12, "distance", 0);
        for _ in 0..500 {
            let p = Vec3::from_fn(|_, _| uniform(&mut source, -2.0, 2.0));
            let q = p.abs() - half;
            let expected = q.sup(&Vec3::zeros()).norm() + q.max().min(0.0);
            assert!((distance.at(&p) - expected).abs() < 1e-12, "{p}");
            let nearest = distance.nearest(&p);
            assert!(((nearest.point - p).norm() - expected.abs()).abs() < 1e-12);
        }
    }

    proptest::proptest! {
        #[test]
        fn a_step_changes_the_distance_by_no_more_than_its_length(seed in 0u64..1000) {
            let mut source = stream(seed, "distance", 1);
            let distance = SignedDistance::new(&random_star(seed, 0.6)).expect("closed");
            for _ in 0..20 {
                let p = direction(&mut source) * uniform(&mut source, 0.0, 1.2);
                let step = direction(&mut source) * uniform(&mut source, 0.0, 0.3);
                let change = (distance.at(&(p + step)) - distance.at(&p)).abs();
                proptest::prop_assert!(change <= step.norm() + 1e-12);
            }
        }
    }

    #[test]
    fn open_and_inverted_surfaces_are_refused() {
        let mut mesh = box_mesh(Vec3::repeat(1.0));
        let inverted = Mesh {
            triangles: mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
            ..mesh.clone()
        };
        assert_eq!(SignedDistance::new(&inverted).err(), Some(DistanceError::InsideOut));
        mesh.triangles.pop();
        assert_eq!(SignedDistance::new(&mesh).err(), Some(DistanceError::Open { edges: 3 }));
        assert_eq!(SignedDistance::new(&Mesh::default()).err(), Some(DistanceError::Empty));
    }

    #[test]
    fn samples_lie_on_the_surface_and_integrate_to_its_area_and_volume() {
        let mesh = icosphere(3);
        let points = sample_surface(&mesh, 4000, &mut stream(13, "distance", 0));
        assert_eq!(points.len(), 4000);
        let area: f64 = points.iter().map(|p| p.area).sum();
        assert!((area - mesh.area()).abs() < 1e-9);
        // Divergence theorem: the volume is a third of the integral of x·n.
        let volume = points.iter().map(|p| p.area * p.point.dot(&p.normal)).sum::<f64>() / 3.0;
        assert!((volume / mesh.mass_properties().volume - 1.0).abs() < 2e-3);
        let distance = SignedDistance::new(&mesh).expect("closed");
        assert!(points.iter().all(|p| distance.at(&p.point).abs() < 1e-12));
    }
}
