//! Convex polyhedra as intersections of half spaces.
//!
//! A polyhedron is cut by one plane at a time: vertices beyond the plane go,
//! edges across it get a new vertex, and the new vertices form a new face.
//! Neighbouring faces share vertices by number, so the result is closed by
//! construction. Cost O(faces) a cut.

use super::Mesh;
use crate::num::Vec3;
use std::collections::BTreeMap;

/// A convex polyhedron: faces as rings of vertices, counter-clockwise from outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Polyhedron {
    vertices: Vec<Vec3>,
    faces: Vec<Vec<u32>>,
}

impl Polyhedron {
    /// The box of the given half edges about the origin.
    pub fn cuboid(half: Vec3) -> Self {
        let vertices = (0..8u32)
            .map(|i| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { half[k] } else { -half[k] }))
            .collect();
        let faces =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Self { vertices, faces: faces.iter().map(|ring| ring.to_vec()).collect() }
    }

    /// Number of faces.
    pub fn faces(&self) -> usize {
        self.faces.len()
    }

    /// Vertices in use.
    pub fn corners(&self) -> Vec<Vec3> {
        let mut used: Vec<u32> = self.faces.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        used.iter().map(|k| self.vertices[*k as usize]).collect()
    }

    /// Keeps the part with normal · x ≤ level; false if nothing was cut off or
    /// nothing would be left (then nothing changes).
    pub fn cut(&mut self, normal: &Vec3, level: f64) -> bool {
        let heights: Vec<f64> = self.vertices.iter().map(|p| normal.dot(p) - level).collect();
        let beyond = |k: u32| heights[k as usize] > 0.0;
        let used = || self.faces.iter().flatten();
        if !used().any(|k| beyond(*k)) || used().all(|k| beyond(*k)) {
            return false;
        }
        let mut fresh: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        // New face: for each of its vertices the next one.
        let mut next: BTreeMap<u32, u32> = BTreeMap::new();
        let mut faces = Vec::with_capacity(self.faces.len() + 1);
        for ring in &self.faces {
            let mut kept = Vec::with_capacity(ring.len() + 1);
            let (mut leaving, mut entering) = (None, None);
            for (k, &here) in ring.iter().enumerate() {
                let there = ring[(k + 1) % ring.len()];
                if !beyond(here) {
                    kept.push(here);
                }
                if beyond(here) == beyond(there) {
                    continue;
                }
                let key = (here.min(there), here.max(there));
                let crossing = *fresh.entry(key).or_insert_with(|| {
                    let (p, q) = (self.vertices[key.0 as usize], self.vertices[key.1 as usize]);
                    let (a, b) = (heights[key.0 as usize], heights[key.1 as usize]);
                    self.vertices.push(p + (q - p) * (a / (a - b)));
                    self.vertices.len() as u32 - 1
                });
                kept.push(crossing);
                if beyond(there) { leaving = Some(crossing) } else { entering = Some(crossing) }
            }
            if let (Some(out), Some(back)) = (leaving, entering) {
                // The old face runs from `out` to `back` along the cut, the new one the other way.
                next.insert(back, out);
            }
            if kept.len() >= 3 {
                faces.push(kept);
            }
        }
        let Some((&start, _)) = next.first_key_value() else { return false };
        let mut ring = vec![start];
        while let Some(&there) = ring.last().and_then(|last| next.get(last)) {
            if there == start || ring.len() > next.len() {
                break;
            }
            ring.push(there);
        }
        faces.push(ring);
        self.faces = faces;
        true
    }

    /// Surface, each face as a fan of triangles.
    pub fn mesh(&self) -> Mesh {
        let mut place: BTreeMap<u32, u32> = BTreeMap::new();
        let mut mesh = Mesh::default();
        for ring in &self.faces {
            let ring: Vec<u32> = ring
                .iter()
                .map(|k| {
                    *place.entry(*k).or_insert_with(|| {
                        mesh.vertices.push(self.vertices[*k as usize]);
                        mesh.vertices.len() as u32 - 1
                    })
                })
                .collect();
            mesh.triangles.extend((1..ring.len() - 1).map(|k| [ring[0], ring[k], ring[k + 1]]));
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::topology::inspect;
    use crate::num::random;

    #[test]
    fn a_corner_cut_off_a_cube_takes_its_volume() {
        let mut cube = Polyhedron::cuboid(Vec3::repeat(1.0));
        assert!(!cube.cut(&Vec3::x(), 1.5), "misses");
        assert!(!cube.cut(&Vec3::x(), -1.5), "would leave nothing");
        let diagonal = Vec3::repeat(1.0);
        assert!(cube.cut(&diagonal, 2.0));
        assert_eq!((cube.faces(), cube.corners().len()), (7, 10));
        let report = inspect(&cube.mesh());
        assert!(report.is_closed());
        assert!((report.volume - (8.0 - 1.0 / 6.0)).abs() < 1e-12, "{}", report.volume);
    }

    #[test]
    fn many_tangent_planes_leave_a_ball() {
        let mut stream = random::stream(1, "polyhedron", 0);
        let mut solid = Polyhedron::cuboid(Vec3::repeat(1.1));
        for _ in 0..400 {
            solid.cut(&random::direction(&mut stream), 1.0);
        }
        let report = inspect(&solid.mesh());
        assert!(report.is_closed() && report.euler_characteristic == 2, "{report:?}");
        let ball = 4.0 / 3.0 * std::f64::consts::PI;
        assert!(report.volume > ball && report.volume < 1.05 * ball, "{}", report.volume);
    }
}
