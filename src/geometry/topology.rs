//! How the triangles of a mesh hang together: edges, pieces, Euler characteristic.
//!
//! Vertices count as the same only if their index is the same: weld first.
//! Cost O(n log n) for n triangles; the order of everything found is fixed.

use super::Mesh;
use crate::num::Vec3;
use serde::Serialize;

/// One side of a triangle, seen from its edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    low: u32,
    high: u32,
    triangle: u32,
    /// True if the triangle runs along the edge from `low` to `high`.
    rising: bool,
}

/// An edge with the triangles that have it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edge {
    /// The two vertices, the smaller index first.
    pub ends: [u32; 2],
    /// Triangles with this edge; true where the triangle runs from the first end to the second.
    pub triangles: Vec<(u32, bool)>,
}

/// All edges of a mesh, sorted by their ends.
pub fn edges(mesh: &Mesh) -> Vec<Edge> {
    let mut sides: Vec<Side> = Vec::with_capacity(3 * mesh.triangles.len());
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let (low, high) = (a.min(b), a.max(b));
            sides.push(Side { low, high, triangle: triangle as u32, rising: a < b });
        }
    }
    sides.sort_unstable();
    sides
        .chunk_by(|a, b| (a.low, a.high) == (b.low, b.high))
        .map(|group| Edge {
            ends: [group[0].low, group[0].high],
            triangles: group.iter().map(|side| (side.triangle, side.rising)).collect(),
        })
        .collect()
}

/// Disjoint sets of `0..n`; the representative of a set is its smallest member.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    pub(super) fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    pub(super) fn find(&mut self, mut item: u32) -> u32 {
        while self.0[item as usize] != item {
            let above = self.0[self.0[item as usize] as usize];
            self.0[item as usize] = above;
            item = above;
        }
        item
    }

    pub(super) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// The piece every triangle belongs to (triangles joined by edges), numbered
/// from 0 in order of their first triangle, and the number of pieces.
pub fn pieces(mesh: &Mesh) -> (Vec<u32>, usize) {
    let mut sets = Sets::new(mesh.triangles.len());
    for edge in edges(mesh) {
        for pair in edge.triangles.windows(2) {
            sets.join(pair[0].0, pair[1].0);
        }
    }
    let mut number = vec![u32::MAX; mesh.triangles.len()];
    let mut count = 0;
    for triangle in 0..mesh.triangles.len() {
        let first = sets.find(triangle as u32) as usize;
        if number[first] == u32::MAX {
            number[first] = count;
            count += 1;
        }
        number[triangle] = number[first];
    }
    (number, count as usize)
}

/// What a mesh is, as found, nothing repaired.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshReport {
    /// Number of triangles.
    pub triangles: usize,
    /// Number of vertices that a triangle uses.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Edges that belong to one triangle only.
    pub open_edges: usize,
    /// Edges that belong to more than two triangles.
    pub crowded_edges: usize,
    /// Edges whose two triangles run along it in the same direction.
    pub misoriented_edges: usize,
    /// Vertices where separate fans of triangles meet in one point, counted
    /// once for each fan beyond the first.
    pub pinched_vertices: usize,
    /// Triangles with two equal corners or no area at all.
    pub degenerate: usize,
    /// Pieces that are not joined by any edge.
    pub pieces: usize,
    /// Vertices − edges + triangles: 2 for a closed surface without handles.
    pub euler_characteristic: i64,
    /// Signed volume, m³: negative for a closed mesh that is inside out.
    pub volume: f64,
}

impl MeshReport {
    /// True if every edge has exactly two triangles that run along it in opposite directions.
    pub fn is_closed(&self) -> bool {
        self.triangles > 0
            && self.open_edges + self.crowded_edges + self.misoriented_edges + self.degenerate == 0
    }
}

/// Counts what `mesh` is made of. Vertices are compared by index: weld first.
pub fn inspect(mesh: &Mesh) -> MeshReport {
    let edges = edges(mesh);
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|corner| used[*corner as usize] = true);
    let vertices = used.iter().filter(|used| **used).count();
    let count = |test: fn(&Edge) -> bool| edges.iter().filter(|edge| test(edge)).count();
    MeshReport {
        triangles: mesh.triangles.len(),
        vertices,
        edges: edges.len(),
        open_edges: count(|edge| edge.triangles.len() == 1),
        crowded_edges: count(|edge| edge.triangles.len() > 2),
        misoriented_edges: count(|edge| {
            edge.triangles.len() == 2 && edge.triangles[0].1 == edge.triangles[1].1
        }),
        pinched_vertices: fans(mesh, &edges).saturating_sub(vertices),
        degenerate: (0..mesh.triangles.len()).filter(|index| has_no_area(mesh, *index)).count(),
        pieces: pieces(mesh).1,
        euler_characteristic: vertices as i64 - edges.len() as i64 + mesh.triangles.len() as i64,
        volume: mesh.mass_properties().volume,
    }
}

/// True if two corners of triangle `index` are one vertex or all lie exactly on a line.
pub(super) fn has_no_area(mesh: &Mesh, index: usize) -> bool {
    let [i, j, k] = mesh.triangles[index];
    let [a, b, c] = mesh.corners(index);
    i == j || j == k || k == i || (b - a).cross(&(c - a)) == Vec3::zeros()
}

/// Number of fans: groups of triangle corners at one vertex, joined across edges.
fn fans(mesh: &Mesh, edges: &[Edge]) -> usize {
    let mut sets = Sets::new(3 * mesh.triangles.len());
    let corner = |triangle: u32, vertex: u32| {
        let place = mesh.triangles[triangle as usize].iter().position(|v| *v == vertex);
        3 * triangle + place.unwrap_or(0) as u32
    };
    for edge in edges {
        for pair in edge.triangles.windows(2) {
            for end in edge.ends {
                sets.join(corner(pair[0].0, end), corner(pair[1].0, end));
            }
        }
    }
    (0..3 * mesh.triangles.len() as u32).filter(|item| sets.find(*item) == *item).count()
}
