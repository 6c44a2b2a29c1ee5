//! A solid as cells of a regular grid, and the distance of every inner cell from the
//! nearest cell outside.
//!
//! Cells are inside where their centre is: a line along z through the centres crosses the
//! surface, and between the first crossing and the second, the third and the fourth, … it is
//! inside. Distance transform: exact, one axis after the other by the lower envelope of
//! parabolas (Felzenszwalb & Huttenlocher 2012, Theory of Computing 8, 415–428).
//! Cost O(triangles · cells in their shadow + cells).

use crate::geometry::Mesh;
use crate::num::Vec3;

/// Cells of a box around a solid, with a rim of one outer cell on every side.
pub struct Voxels {
    /// Edge of a cell, m.
    pub edge: f64,
    /// Centre of cell (0, 0, 0), m.
    origin: Vec3,
    /// Cells along x, y, z; z runs fastest.
    counts: [usize; 3],
    /// True inside the solid.
    pub inside: Vec<bool>,
}

impl Voxels {
    /// Number of cells that a grid of this spacing has around `mesh`.
    pub fn number(mesh: &Mesh, edge: f64) -> f64 {
        mesh.bounds().size().iter().map(|side| (side / edge).ceil() + 3.0).product()
    }

    /// Cells of the closed `mesh`.
    pub fn new(mesh: &Mesh, edge: f64) -> Self {
        let bounds = mesh.bounds();
        let counts: [usize; 3] =
            std::array::from_fn(|axis| (bounds.size()[axis] / edge).ceil() as usize + 3);
        // Off the corners of round numbers, where a line would run along an edge.
        let nudge = Vec3::new(0.013_37, 0.027_1, 0.0) * edge;
        let origin = bounds.low - Vec3::repeat(edge) + nudge;
        let mut crossings = vec![Vec::new(); counts[0] * counts[1]];
        for [a, b, c] in mesh.facets() {
            shadow(&[a, b, c], &origin, edge, counts, &mut crossings);
        }
        let mut inside = vec![false; counts.iter().product()];
        for (column, heights) in crossings.iter_mut().enumerate() {
            heights.sort_unstable_by(f64::total_cmp);
            for pair in heights.chunks_exact(2) {
                let [from, to] =
                    [pair[0], pair[1]].map(|z| ((z - origin.z) / edge).ceil().max(0.0) as usize);
                let start = column * counts[2];
                inside[start + from.min(counts[2])..start + to.min(counts[2])].fill(true);
            }
        }
        Self { edge, origin, counts, inside }
    }

    /// Centre of a cell.
    pub fn centre(&self, cell: usize) -> Vec3 {
        let [i, j, k] = self.place(cell).map(|n| n as f64);
        self.origin + Vec3::new(i, j, k) * self.edge
    }

    fn place(&self, cell: usize) -> [usize; 3] {
        let [_, ny, nz] = self.counts;
        [cell / (ny * nz), cell / nz % ny, cell % nz]
    }

    /// Sets every cell whose centre lies in the ball to outside.
    pub fn clear(&mut self, centre: &Vec3, radius: f64) {
        let low = (centre - self.origin - Vec3::repeat(radius)) / self.edge;
        let high = (centre - self.origin + Vec3::repeat(radius)) / self.edge;
        let range = |axis: usize| {
            low[axis].ceil().max(0.0) as usize
                ..(high[axis].floor().max(-1.0) + 1.0).min(self.counts[axis] as f64) as usize
        };
        for i in range(0) {
            for j in range(1) {
                for k in range(2) {
                    let cell = (i * self.counts[1] + j) * self.counts[2] + k;
                    if (self.centre(cell) - centre).norm_squared() <= radius * radius {
                        self.inside[cell] = false;
                    }
                }
            }
        }
    }

    /// Squared distance of every cell from the nearest outer cell, in edges; 0 outside.
    pub fn squared_distances(&self) -> Vec<f64> {
        let [nx, ny, nz] = self.counts;
        // Larger than any distance in the grid, and exact in the sums below.
        let far = ((nx + ny + nz) as f64).powi(2);
        let mut values: Vec<f64> =
            self.inside.iter().map(|&inside| if inside { far } else { 0.0 }).collect();
        let mut line = Envelope::default();
        for (length, stride, starts) in [
            (nz, 1, lines(nx * ny, nz, 1, 0)),
            (ny, nz, lines(nx, ny * nz, nz, 1)),
            (nx, ny * nz, lines(1, 0, ny * nz, 1)),
        ] {
            for start in starts {
                line.transform(&mut values, start, stride, length);
            }
        }
        values
    }
}

/// First cells of the lines along one axis: `outer` blocks of `step` cells with `inner` lines each.
fn lines(outer: usize, step: usize, inner: usize, spacing: usize) -> Vec<usize> {
    (0..outer).flat_map(|o| (0..inner).map(move |i| o * step + i * spacing)).collect()
}

/// Adds the heights at which lines along z through cell centres cross a triangle.
fn shadow(
    corners: &[Vec3; 3],
    origin: &Vec3,
    edge: f64,
    counts: [usize; 3],
    crossings: &mut [Vec<f64>],
) {
    let [a, b, c] = corners;
    let double = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if double == 0.0 {
        return;
    }
    let range = |axis: usize| {
        let values = corners.map(|corner| (corner[axis] - origin[axis]) / edge);
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        low.ceil().max(0.0) as usize..((high.floor().max(-1.0) + 1.0) as usize).min(counts[axis])
    };
    // Signs of all lines against one edge agree between the two triangles that share it,
    // because the corners enter in one order.
    let side = |p: &Vec3, q: &Vec3, x: f64, y: f64| {
        let swap = (p.x, p.y) > (q.x, q.y);
        let (p, q) = if swap { (q, p) } else { (p, q) };
        let value = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
        if swap { value <= 0.0 } else { value > 0.0 }
    };
    for i in range(0) {
        for j in range(1) {
            let (x, y) = (origin.x + i as f64 * edge, origin.y + j as f64 * edge);
            let sides = [side(a, b, x, y), side(b, c, x, y), side(c, a, x, y)];
            if sides[0] != sides[1] || sides[1] != sides[2] {
                continue;
            }
            let u = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / double;
            let v = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / double;
            crossings[i * counts[1] + j].push(a.z + u * (b.z - a.z) + v * (c.z - a.z));
        }
    }
}

/// Memory for the lower envelope of parabolas along one line.
#[derive(Default)]
struct Envelope {
    values: Vec<f64>,
    /// Places of the parabolas of the envelope, and where each begins.
    places: Vec<usize>,
    starts: Vec<f64>,
}

impl Envelope {
    fn transform(&mut self, all: &mut [f64], start: usize, stride: usize, length: usize) {
        self.values.clear();
        self.values.extend((0..length).map(|n| all[start + n * stride]));
        self.places.clear();
        self.starts.clear();
        for n in 0..length {
            let mut begin = f64::NEG_INFINITY;
            while let (Some(&last), Some(&from)) = (self.places.last(), self.starts.last()) {
                let height = |n: usize| self.values[n] + (n * n) as f64;
                begin = (height(n) - height(last)) / (2.0 * (n - last) as f64);
                if begin > from {
                    break;
                }
                self.places.pop();
                self.starts.pop();
                begin = f64::NEG_INFINITY;
            }
            self.places.push(n);
            self.starts.push(begin);
        }
        let mut at = 0;
        for n in 0..length {
            while at + 1 < self.starts.len() && self.starts[at + 1] < n as f64 {
                at += 1;
            }
            let offset = n.abs_diff(self.places[at]);
            all[start + n * stride] = self.values[self.places[at]] + (offset * offset) as f64;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::SignedDistance;
    use crate::geometry::samples::{l_mesh, random_star};
    use crate::num::Rotation;

    #[test]
    fn cells_and_distances_are_those_of_brute_force() {
        let turn = Rotation::from_euler_angles(0.4, 0.7, 1.1);
        for mesh in [l_mesh(), l_mesh().mapped(|v| turn * v), random_star(3, 0.5)] {
            let voxels = Voxels::new(&mesh, 0.17);
            let distance = SignedDistance::new(&mesh).expect("closed");
            let squares = voxels.squared_distances();
            let outside: Vec<Vec3> = (0..voxels.inside.len())
                .filter(|&cell| !voxels.inside[cell])
                .map(|cell| voxels.centre(cell))
                .collect();
            for (cell, square) in squares.iter().enumerate() {
                let centre = voxels.centre(cell);
                let exact = distance.at(&centre);
                assert!(exact.abs() < 1e-9 || voxels.inside[cell] == (exact < 0.0));
                if cell % 7 == 0 {
                    let nearest = outside
                        .iter()
                        .map(|o| (o - centre).norm_squared())
                        .fold(f64::INFINITY, f64::min);
                    let scaled = nearest / voxels.edge.powi(2);
                    let expected = if voxels.inside[cell] { scaled } else { 0.0 };
                    assert!((square - expected).abs() < 1e-9, "{square} {expected}");
                }
            }
        }
    }

    #[test]
    fn a_cleared_ball_is_outside() {
        let mut voxels = Voxels::new(&l_mesh(), 0.1);
        let centre = Vec3::new(0.5, 0.5, 0.5);
        voxels.clear(&centre, 0.4);
        for cell in 0..voxels.inside.len() {
            assert!(!voxels.inside[cell] || (voxels.centre(cell) - centre).norm() > 0.4);
        }
        assert!(voxels.inside.iter().any(|&inside| inside));
    }
}
