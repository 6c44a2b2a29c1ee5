//! A volume as the matrix of its occupied cells, and the surface of that volume.
//!
//! The surface is made from the matrix directly: every face between a full and
//! an empty cell becomes two triangles on shared corners, so that it is closed
//! and oriented by construction and the same bits every time (a boolean kernel
//! has no sure order for faces in one plane). Where cells meet in an edge or a
//! corner only, that surface is no manifold: [`Cells::fill_joints`] adds the
//! cells that join them. Cost O(cells).

use crate::geometry::Mesh;
use crate::num::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is done where cells meet in an edge or a corner only, which is no solid.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Joints {
    /// Cells are added until there is no such place; the recipe says how many.
    #[default]
    Fill,
    /// Nothing: such a volume is refused as no solid and drawn again.
    Keep,
}

/// What is done with a volume in several pieces.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Pieces {
    /// It is refused as no solid and drawn again.
    #[default]
    Refuse,
    /// The largest piece is kept and cavities in it are filled; the recipe says how many cells that changed.
    Largest,
}

/// Occupied cells of a box-shaped grid; outside it everything is empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cells {
    size: [usize; 3],
    full: Vec<bool>,
}

const FACES: [[i64; 3]; 6] = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];

impl Cells {
    /// An empty grid.
    pub fn new(size: [usize; 3]) -> Self {
        Self { size, full: vec![false; size.iter().product()] }
    }

    /// The smallest grid around `cells`.
    pub fn around(cells: &[[i64; 3]]) -> Self {
        let end = |pick: fn(i64, i64) -> i64, axis: usize| {
            cells.iter().map(|cell| cell[axis]).reduce(pick).unwrap_or(0)
        };
        let low: [i64; 3] = std::array::from_fn(|axis| end(i64::min, axis));
        let size = std::array::from_fn(|axis| (end(i64::max, axis) - low[axis] + 1) as usize);
        let mut grid = Self::new(size);
        for cell in cells {
            grid.set(std::array::from_fn(|axis| (cell[axis] - low[axis]) as usize));
        }
        grid
    }

    fn index(&self, cell: [i64; 3]) -> Option<usize> {
        let inside = (0..3).all(|axis| (0..self.size[axis] as i64).contains(&cell[axis]));
        let [x, y, z] = cell.map(|k| k as usize);
        inside.then(|| (z * self.size[1] + y) * self.size[0] + x)
    }

    fn place(&self, index: usize) -> [i64; 3] {
        let [x, y, _] = self.size;
        [index % x, index / x % y, index / (x * y)].map(|k| k as i64)
    }

    /// True if the cell is full.
    pub fn is_full(&self, cell: [i64; 3]) -> bool {
        self.index(cell).is_some_and(|index| self.full[index])
    }

    /// Fills a cell of the grid.
    pub fn set(&mut self, cell: [usize; 3]) {
        if let Some(index) = self.index(cell.map(|k| k as i64)) {
            self.full[index] = true;
        }
    }

    /// Number of full cells.
    pub fn count(&self) -> usize {
        self.full.iter().filter(|full| **full).count()
    }

    /// Number of pieces: full cells joined over faces.
    pub fn pieces(&self) -> usize {
        self.labelled(true).1
    }

    /// Pieces of the full or of the empty cells: a number for each cell (0 for
    /// the others), and how many pieces there are; numbers start at 1.
    fn labelled(&self, full: bool) -> (Vec<u32>, usize) {
        let mut label = vec![0u32; self.full.len()];
        let mut pieces = 0;
        for start in 0..self.full.len() {
            if self.full[start] != full || label[start] != 0 {
                continue;
            }
            pieces += 1;
            label[start] = pieces;
            let mut waiting = vec![start];
            while let Some(here) = waiting.pop() {
                let [x, y, z] = self.place(here);
                for [i, j, k] in FACES {
                    if let Some(there) = self.index([x + i, y + j, z + k])
                        && self.full[there] == full
                        && label[there] == 0
                    {
                        label[there] = pieces;
                        waiting.push(there);
                    }
                }
            }
        }
        (label, pieces as usize)
    }

    /// Keeps the largest piece and fills what it encloses; returns the numbers
    /// of cells taken away and added.
    pub fn keep_largest(&mut self) -> (usize, usize) {
        let before = self.count();
        let (label, pieces) = self.labelled(true);
        let mut sizes = vec![0usize; pieces + 1];
        label.iter().for_each(|piece| sizes[*piece as usize] += 1);
        // The first of equal pieces, so that the choice is always the same.
        let largest = (1..=pieces).fold(1, |b, p| if sizes[p] > sizes[b] { p } else { b });
        for (full, piece) in self.full.iter_mut().zip(&label) {
            *full = *piece as usize == largest;
        }
        let kept = self.count();
        let (label, voids) = self.labelled(false);
        let mut open = vec![false; voids + 1];
        for (index, void) in label.iter().enumerate() {
            let cell = self.place(index);
            if (0..3).any(|axis| cell[axis] == 0 || cell[axis] + 1 == self.size[axis] as i64) {
                open[*void as usize] = true;
            }
        }
        for (full, void) in self.full.iter_mut().zip(&label) {
            *full |= !open[*void as usize];
        }
        (before - kept, self.count() - kept)
    }

    /// Adds cells until full cells and empty cells around every corner of the
    /// grid are joined over faces, so that the surface is a manifold; returns
    /// how many. Ends, since it only adds.
    pub fn fill_joints(&mut self) -> usize {
        let before = self.count();
        let [nx, ny, nz] = self.size.map(|k| k as i64);
        loop {
            let mut changed = false;
            for z in -1..nz {
                for y in -1..ny {
                    for x in -1..nx {
                        while let Some(cell) = self.joint([x, y, z]) {
                            self.full[cell] = true;
                            changed = true;
                        }
                    }
                }
            }
            if !changed {
                return self.count() - before;
            }
        }
    }

    /// A cell to fill in the block of 2 × 2 × 2 cells from `low` on; `None`
    /// where its full cells are joined over faces and so are its empty ones.
    fn joint(&self, low: [i64; 3]) -> Option<usize> {
        let corner = |bits: usize| -> [i64; 3] {
            std::array::from_fn(|axis| low[axis] + (bits >> axis & 1) as i64)
        };
        let full = (0..8).fold(0u8, |mask, b| mask | u8::from(self.is_full(corner(b))) << b);
        if full == 0 || full == 0xff || (joined(full) && joined(!full)) {
            return None;
        }
        // Any empty cell beside a full one brings the block nearer to being
        // joined; cells outside the grid stay empty.
        (0..8usize)
            .filter(|b| full >> b & 1 == 0)
            .filter_map(|b| self.index(corner(b)).map(|index| (b, index)))
            .max_by_key(|(b, index)| {
                let beside = (0..3).filter(|axis| full >> (b ^ (1 << axis)) & 1 == 1).count();
                (beside, std::cmp::Reverse(*index))
            })
            .map(|(_, index)| index)
    }

    /// Applies `joints` and `pieces`; says what that changed, for the recipe.
    pub fn mend(&mut self, joints: Joints, pieces: Pieces) -> String {
        let mut said = String::new();
        if pieces == Pieces::Largest {
            let (gone, filled) = self.keep_largest();
            if gone + filled > 0 {
                said.push_str(&format!(
                    "; {gone} cells of smaller pieces removed, {filled} in cavities filled"
                ));
            }
        }
        if joints == Joints::Fill {
            let added = self.fill_joints();
            if added > 0 {
                said.push_str(&format!(
                    "; {added} cells added where cells met in an edge or a corner only"
                ));
            }
            if pieces == Pieces::Largest {
                // Joining cells can enclose what was open.
                self.keep_largest();
            }
        }
        said
    }

    /// The surface, cells of edge 1, low corner of the grid at the origin.
    pub fn mesh(&self) -> Mesh {
        let mut mesh = Mesh::default();
        let [nx, ny, nz] = self.size.map(|k| k + 1);
        let mut known = vec![u32::MAX; nx * ny * nz];
        for index in (0..self.full.len()).filter(|index| self.full[*index]) {
            let cell = self.place(index);
            for face in FACES {
                let beyond = std::array::from_fn(|axis| cell[axis] + face[axis]);
                if self.is_full(beyond) {
                    continue;
                }
                let quad = corners(cell, face).map(|[x, y, z]| {
                    let slot = &mut known[(z as usize * ny + y as usize) * nx + x as usize];
                    if *slot == u32::MAX {
                        *slot = mesh.vertices.len() as u32;
                        mesh.vertices.push(Vec3::new(x as f64, y as f64, z as f64));
                    }
                    *slot
                });
                let [a, b, c, d] = quad;
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh
    }
}

/// True if the cells of `mask`, one bit each in a block of 2 × 2 × 2, are joined over faces.
fn joined(mask: u8) -> bool {
    let mut reached = mask & mask.wrapping_neg();
    loop {
        let before = reached;
        for b in (0..8).filter(|b| before >> b & 1 == 1) {
            for axis in 0..3 {
                reached |= mask & 1 << (b ^ (1 << axis));
            }
        }
        if reached == before {
            return reached == mask;
        }
    }
}

/// Corners of the face of `cell` towards `face`, counter-clockwise from outside.
fn corners(cell: [i64; 3], face: [i64; 3]) -> [[i64; 3]; 4] {
    let axis = (0..3).find(|axis| face[*axis] != 0).unwrap_or(0);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut ring = [(0, 0), (1, 0), (1, 1), (0, 1)];
    if face[axis] < 0 {
        ring.reverse();
    }
    ring.map(|(a, b)| {
        let mut corner = cell;
        corner[axis] += i64::from(face[axis] > 0);
        corner[u] += a;
        corner[v] += b;
        corner
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::topology::inspect;
    use crate::num::random;

    fn grid(cells: &[[i64; 3]]) -> Cells {
        Cells::around(cells)
    }

    #[test]
    fn one_cell_is_a_cube_and_a_ring_has_a_hole() {
        let cube = grid(&[[4, 5, 6]]).mesh();
        let report = inspect(&cube);
        assert!(report.is_closed() && report.euler_characteristic == 2);
        assert!((report.volume - 1.0).abs() < 1e-14 && (cube.area() - 6.0).abs() < 1e-14);
        let ring: Vec<[i64; 3]> = (0..9).filter(|k| *k != 4).map(|k| [k % 3, k / 3, 0]).collect();
        let report = inspect(&grid(&ring).mesh());
        assert!(report.is_closed() && report.euler_characteristic == 0, "{report:?}");
    }

    #[test]
    fn cells_that_meet_in_an_edge_or_a_corner_are_joined() {
        for other in [[1, 1, 0], [1, 1, 1]] {
            let mut cells = grid(&[[0, 0, 0], other]);
            assert_eq!(cells.pieces(), 2);
            assert!(cells.fill_joints() > 0);
            let report = inspect(&cells.mesh());
            assert!(report.is_closed() && report.pieces == 1 && report.pinched_vertices == 0);
        }
    }

    #[test]
    fn random_matrices_become_manifolds() {
        for seed in 0..40 {
            let mut stream = random::stream(seed, "cells", 0);
            let mut cells = Cells::new([5, 6, 4]);
            for index in 0..120 {
                if random::uniform(&mut stream, 0.0, 1.0) < 0.45 {
                    cells.set([index % 5, index / 5 % 6, index / 30]);
                }
            }
            cells.mend(Joints::Fill, Pieces::Largest);
            let report = inspect(&cells.mesh());
            assert!(report.is_closed() && report.pieces == 1, "{seed} {report:?}");
            assert_eq!(report.pinched_vertices, 0, "{seed}");
            assert!((report.volume - cells.count() as f64).abs() < 1e-9);
        }
    }

    #[test]
    fn the_largest_piece_stays_and_its_cavity_is_filled() {
        let mut shell: Vec<[i64; 3]> = (0..27).map(|k| [k % 3, k / 3 % 3, k / 9]).collect();
        shell.retain(|cell| *cell != [1, 1, 1]);
        shell.push([6, 0, 0]);
        let mut cells = grid(&shell);
        assert_eq!(cells.pieces(), 2);
        assert_eq!(cells.keep_largest(), (1, 1));
        assert_eq!(cells.count(), 27);
    }
}
