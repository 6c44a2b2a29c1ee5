//! Cells: forms as runs of owned cells, and the lattice that says which cells are taken.
//!
//! Lengths in cells here. A form is turned about the corner point (0, 0, 0) of the
//! lattice; a run is a row of cells along x. A cell belongs to a form whose inside holds its centre
//! ([`Ownership::Centre`]: unbiased volume), or that touches it anywhere ([`Ownership::Touched`]: forms
//! that share no cell share no point). Surfaces are filled by the parity of their crossings with
//! the centre line of each row; an edge seen by two triangles is decided by one and
//! the same number, so a closed surface has no leaks. O(triangles + crossings log crossings).
//!
//! The lattice keeps one bit a cell, 64 in a word along x, with a taken rim around but where sides repeat: there
//! cells begin again, after as many whole ones as fit (what is left over stays between the images).

use super::forms::{Form, Shaped};
use crate::geometry::{Ball, Region};
use crate::num::{Rotation, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which cells a grain owns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Ownership {
    /// Those whose centre lies in it: true volume, true overlaps up to about a cell.
    #[default]
    Centre,
    /// Those that it touches: never a true overlap, grains stand up to about a cell apart.
    Touched,
}

/// Cells `from..to` along x in row (y, z).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Run {
    z: i32,
    y: i32,
    from: i32,
    to: i32,
}

/// The cells of a form.
#[derive(Debug, Clone, Default)]
pub struct Cells {
    runs: Vec<Run>,
    low: [i32; 3],
    high: [i32; 3],
}

impl Cells {
    /// The cells of `shaped`, turned, with cells of `edge` m; in two dimensions one layer.
    pub fn of(
        shaped: &Shaped,
        turn: &Rotation,
        edge: f64,
        dimension: usize,
        ownership: Ownership,
    ) -> Self {
        let mut runs = Vec::new();
        match &shaped.form {
            Form::Balls(balls) => {
                for ball in balls {
                    let ball =
                        Ball { centre: turn * ball.centre / edge, radius: ball.radius / edge };
                    ball_runs(&ball, dimension, ownership, &mut runs);
                }
            }
            Form::Surface(mesh) => {
                let corners: Vec<Vec3> = mesh.vertices.iter().map(|v| turn * v / edge).collect();
                surface_runs(&corners, &mesh.triangles, ownership, &mut runs);
            }
        }
        Self::united(runs)
    }

    fn united(mut runs: Vec<Run>) -> Self {
        runs.retain(|run| run.from < run.to);
        runs.sort_unstable();
        let mut merged: Vec<Run> = Vec::with_capacity(runs.len());
        for run in runs {
            match merged.last_mut() {
                Some(last) if (last.z, last.y) == (run.z, run.y) && run.from <= last.to => {
                    last.to = last.to.max(run.to);
                }
                _ => merged.push(run),
            }
        }
        let (mut low, mut high) = ([0; 3], [0; 3]);
        for (index, run) in merged.iter().enumerate() {
            let (l, h) = ([run.from, run.y, run.z], [run.to, run.y + 1, run.z + 1]);
            for axis in 0..3 {
                low[axis] = if index == 0 { l[axis] } else { low[axis].min(l[axis]) };
                high[axis] = if index == 0 { h[axis] } else { high[axis].max(h[axis]) };
            }
        }
        Self { runs: merged, low, high }
    }

    /// How many.
    pub fn count(&self) -> u64 {
        self.runs.iter().map(|run| (run.to - run.from) as u64).sum()
    }

    /// First cell and cell after the last along an axis, seen from the corner that the form is turned about.
    pub fn extent(&self, axis: usize) -> (i32, i32) {
        (self.low[axis], self.high[axis])
    }
}

/// Distance from `at` to the interval of one cell.
fn beside(at: f64, cell: i32) -> f64 {
    (f64::from(cell) - at).max(at - f64::from(cell) - 1.0).max(0.0)
}

fn ball_runs(ball: &Ball, dimension: usize, ownership: Ownership, runs: &mut Vec<Run>) {
    let Ball { centre, radius } = ball;
    let rows = |middle: f64| (middle - radius).floor() as i32..=(middle + radius).floor() as i32;
    let layers = if dimension == 2 { 0..=0 } else { rows(centre.z) };
    for z in layers {
        for y in rows(centre.y) {
            let off = |at: f64, cell: i32| match ownership {
                Ownership::Centre => at - f64::from(cell) - 0.5,
                Ownership::Touched => beside(at, cell),
            };
            let dz = if dimension == 2 { 0.0 } else { off(centre.z, z) };
            let dy = off(centre.y, y);
            let half = radius * radius - dy * dy - dz * dz;
            if half <= 0.0 {
                continue;
            }
            let (low, high) = (centre.x - half.sqrt(), centre.x + half.sqrt());
            let (from, to) = match ownership {
                Ownership::Centre => between(low, high),
                Ownership::Touched => (low.floor() as i32, high.ceil() as i32),
            };
            runs.push(Run { z, y, from, to });
        }
    }
}

/// Cells whose centres lie in `low..high`.
fn between(low: f64, high: f64) -> (i32, i32) {
    ((low - 0.5).ceil() as i32, (high - 0.5).ceil() as i32)
}

fn surface_runs(
    corners: &[Vec3],
    triangles: &[[u32; 3]],
    ownership: Ownership,
    runs: &mut Vec<Run>,
) {
    let mut crossings: Vec<(i32, i32, f64)> = Vec::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| corners[corner as usize]);
        let rows = |axis: usize| {
            let (low, high) =
                (a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis]));
            low.floor() as i32..=high.floor() as i32
        };
        for z in rows(2) {
            for y in rows(1) {
                if let Some(x) = crossing(corners, triangle, y, z) {
                    crossings.push((z, y, x));
                }
                if ownership == Ownership::Touched
                    && let Some((low, high)) = cut_to_row([a, b, c], y, z)
                {
                    runs.push(Run { z, y, from: low.floor() as i32, to: high.ceil() as i32 });
                }
            }
        }
    }
    crossings.sort_unstable_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    for pair in crossings.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        for ends in pair.chunks_exact(2) {
            let (from, to) = between(ends[0].2, ends[1].2);
            runs.push(Run { z: ends[0].0, y: ends[0].1, from, to });
        }
    }
}

/// Where the centre line of row (y, z) meets a triangle, if it does.
fn crossing(corners: &[Vec3], triangle: &[u32; 3], y: i32, z: i32) -> Option<f64> {
    // Just beside the centre: edges of solids along the axes must not lie on the line.
    let (y, z) = (f64::from(y) + 0.5 + 3.7e-10, f64::from(z) + 0.5 + 2.3e-10);
    let at = |corner: u32| corners[corner as usize];
    // Twice the area of (line, from, to) in the y-z plane, the same number but for
    // its sign whichever way the edge is walked; never 0.
    let side = |from: u32, to: u32| {
        let (first, last) = (from.min(to), from.max(to));
        let (p, q) = (at(first), at(last));
        let area = (p.y - y) * (q.z - z) - (p.z - z) * (q.y - y);
        let area = if area == 0.0 { f64::MIN_POSITIVE } else { area };
        if first == from { area } else { -area }
    };
    let [a, b, c] = *triangle;
    let weights = [side(b, c), side(c, a), side(a, b)];
    let same = weights.iter().all(|w| *w > 0.0) || weights.iter().all(|w| *w < 0.0);
    let sum: f64 = weights.iter().sum();
    same.then(|| {
        let x = (weights[0] * at(a).x + weights[1] * at(b).x + weights[2] * at(c).x) / sum;
        if x.is_finite() { x } else { at(a).x }
    })
}

/// The range of x of the part of a triangle in the row of square cross-section (y, z), if there is any.
fn cut_to_row(triangle: [Vec3; 3], y: i32, z: i32) -> Option<(f64, f64)> {
    let mut polygon = triangle.to_vec();
    let sides = [(1, y, 1.0), (1, y + 1, -1.0), (2, z, 1.0), (2, z + 1, -1.0)];
    for (axis, level, sign) in sides {
        let depth = |p: &Vec3| sign * (p[axis] - f64::from(level));
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (index, p) in polygon.iter().enumerate() {
            let next = &polygon[(index + 1) % polygon.len()];
            let (here, there) = (depth(p), depth(next));
            if here >= 0.0 {
                kept.push(*p);
            }
            if (here >= 0.0) != (there >= 0.0) {
                kept.push(p + (next - p) * (here / (here - there)));
            }
        }
        polygon = kept;
        if polygon.is_empty() {
            return None;
        }
    }
    let low = polygon.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
    let high = polygon.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
    // A flat end exactly between two cells belongs to one of them.
    Some((low, if high > low { high } else { low + f64::EPSILON * low.abs().max(1.0) }))
}

/// Which cells of a container are taken.
pub struct Lattice {
    /// Edge of a cell, m.
    pub edge: f64,
    /// Corner of cell (0, 0, 0), m.
    pub origin: Vec3,
    /// Cells along each axis, the rim included.
    pub size: [i32; 3],
    /// Axes along which cells begin again, without a rim.
    pub periodic: [bool; 3],
    /// 2 or 3.
    pub dimension: usize,
    /// Cells that the container leaves free when it is empty.
    pub room: u64,
    words: usize,
    bits: Vec<u64>,
}

/// Most cells of a lattice: 512 MiB.
pub const MOST_CELLS: f64 = 4.3e9;

impl Lattice {
    /// Cells that a container needs with cells of `edge` m.
    pub fn cells_needed(region: &Region, edge: f64) -> f64 {
        let size = region.bounds().size();
        (0..region.dimension()).map(|axis| (size[axis] / edge).ceil() + 2.0).product()
    }

    /// The largest edge up to `wanted` (m) of which a whole number fits the longest side that repeats, if any does.
    pub fn edge(region: &Region, wanted: f64) -> f64 {
        let lengths = region.cell().map_or(Vec3::repeat(f64::INFINITY), |cell| cell.lengths());
        let longest =
            lengths.iter().copied().filter(|length| length.is_finite()).fold(0.0, f64::max);
        if longest > 0.0 { longest / (longest / wanted - 1e-9).ceil().max(1.0) } else { wanted }
    }

    /// The empty container.
    pub fn new(region: &Region, edge: f64, ownership: Ownership) -> Self {
        let (bounds, dimension) = (region.bounds(), region.dimension());
        let mut size = [1; 3];
        let mut origin = Vec3::zeros();
        let periodic = region.cell().map_or([false; 3], |cell| cell.periodic);
        for axis in 0..dimension {
            if periodic[axis] {
                size[axis] = ((bounds.size()[axis] / edge + 1e-9).floor() as i32).max(1);
                origin[axis] = bounds.low[axis];
                continue;
            }
            let cells = (bounds.size()[axis] / edge - 1e-9).ceil().max(1.0);
            // What does not fill a whole cell is shared by both sides.
            origin[axis] = bounds.centre()[axis] - (0.5 * cells + 1.0) * edge;
            size[axis] = cells as i32 + 2;
        }
        if dimension == 2 {
            origin.z = 0.0;
        }
        let words = (size[0] as usize).div_ceil(64);
        let rows = size[1] as usize * size[2] as usize;
        let bits = vec![!0; words * rows];
        let mut lattice = Self { edge, origin, size, periodic, dimension, room: 0, words, bits };
        lattice.open(region, ownership);
        lattice
    }

    /// Frees the cells inside the container.
    fn open(&mut self, region: &Region, ownership: Ownership) {
        // A cell lies wholly inside if its centre keeps half an edge from walls along
        // the axes, half a diagonal from others.
        let half = match region {
            Region::Box(_) => 0.5,
            _ => 0.5 * (self.dimension as f64).sqrt(),
        };
        let least = match ownership {
            Ownership::Centre => 0.0,
            Ownership::Touched => half * self.edge * (1.0 - 1e-9),
        };
        for z in 0..self.size[2] {
            for y in 0..self.size[1] {
                let mut x = 0;
                while x < self.size[0] {
                    let middle =
                        Vec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, f64::from(z) + 0.5);
                    let mut point = self.origin + middle * self.edge;
                    if self.dimension == 2 {
                        point.z = 0.0;
                    }
                    let beyond = region.clearance(&point) - least;
                    // The clearance changes by no more than the way.
                    let same = (1 + (beyond.abs() / self.edge).min(1e6).floor() as i32)
                        .min(self.size[0] - x);
                    if beyond >= 0.0 {
                        let run = Run { z: 0, y: 0, from: 0, to: same };
                        self.clear_run(&run, [x, y, z]);
                        self.room += same as u64;
                    }
                    x += same;
                }
            }
        }
    }

    /// `at` with coordinates along axes that repeat brought home.
    pub fn home(&self, at: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|axis| match self.periodic[axis] {
            true => at[axis].rem_euclid(self.size[axis]),
            false => at[axis],
        })
    }

    /// Place of the first word of a row, and the one or two stretches of cells along it (the second may be empty).
    fn stretches(&self, run: &Run, at: [i32; 3]) -> (usize, [(usize, usize); 2]) {
        let [x, y, z] = self.home([at[0] + run.from, at[1] + run.y, at[2] + run.z]);
        let row = (z as usize * self.size[1] as usize + y as usize) * self.words;
        let (from, to) = (x as usize, (x + run.to - run.from) as usize);
        let end = if self.periodic[0] { self.size[0] as usize } else { usize::MAX };
        (row, [(from, to.min(end)), (0, to.saturating_sub(end))])
    }

    fn clear_run(&mut self, run: &Run, at: [i32; 3]) {
        let (row, stretches) = self.stretches(run, at);
        for (word, mask) in words(stretches) {
            self.bits[row + word] &= !mask;
        }
    }

    /// True if no cell of `cells`, put at corner `at`, is taken or beyond the rim.
    pub fn is_free(&self, cells: &Cells, at: [i32; 3]) -> bool {
        let inside = (0..3).all(|axis| {
            self.periodic[axis]
                || at[axis] + cells.low[axis] >= 0 && at[axis] + cells.high[axis] <= self.size[axis]
        });
        inside
            && cells.runs.iter().all(|run| {
                let (row, stretches) = self.stretches(run, at);
                words(stretches).all(|(word, mask)| self.bits[row + word] & mask == 0)
            })
    }

    /// Takes the cells.
    pub fn take(&mut self, cells: &Cells, at: [i32; 3]) {
        for run in &cells.runs {
            let (row, stretches) = self.stretches(run, at);
            for (word, mask) in words(stretches) {
                self.bits[row + word] |= mask;
            }
        }
    }

    /// Gives the cells back.
    pub fn give(&mut self, cells: &Cells, at: [i32; 3]) {
        for run in &cells.runs {
            self.clear_run(run, at);
        }
    }

    /// The corner point `at`, m; z = 0 in two dimensions.
    pub fn point(&self, at: [i32; 3]) -> Vec3 {
        let mut point = self.origin
            + Vec3::new(f64::from(at[0]), f64::from(at[1]), f64::from(at[2])) * self.edge;
        if self.dimension == 2 {
            point.z = 0.0;
        }
        point
    }
}

/// The words of a row that hold cells of these stretches, with the bits of them.
fn words(stretches: [(usize, usize); 2]) -> impl Iterator<Item = (usize, u64)> {
    stretches.into_iter().filter(|(from, to)| to > from).flat_map(|(from, to)| {
        (from / 64..=(to - 1) / 64).map(move |word| (word, mask(word, from, to)))
    })
}

/// Bits of cells `from..to` that lie in this word of a row; `to > from`.
fn mask(word: usize, from: usize, to: usize) -> u64 {
    let start = word * 64;
    let low = !0_u64 << from.saturating_sub(start).min(63);
    let high = !0_u64 >> (start + 64).saturating_sub(to).min(63);
    low & high
}

#[cfg(test)]
mod tests {
    use super::super::random::Test;
    use super::super::samples::{dumbbell, room, solid};
    use super::super::{Grain, forms::Forms};
    use super::*;
    use crate::geometry::Collider;
    use crate::geometry::samples::{icosphere, l_mesh};
    use crate::num::random::{rotation, stream};
    use std::collections::BTreeSet;

    fn list(cells: &Cells) -> BTreeSet<[i32; 3]> {
        let all = cells.runs.iter().flat_map(|r| (r.from..r.to).map(move |x| [x, r.y, r.z]));
        all.collect()
    }

    #[test]
    fn owned_cells_are_those_whose_centres_are_inside() {
        let mut source = stream(3, "voxels", 0);
        let (clump, solid) = solid(l_mesh());
        let pair = dumbbell(0.6, 1.0);
        for case in 0..6 {
            let grain = match case % 2 {
                0 => Grain { clump: &clump, solid: Some(&solid), family: 0 },
                _ => Grain { clump: &pair, solid: None, family: 0 },
            };
            let forms = Forms::new(&[grain], Test::Solid, 3);
            let (turn, edge) = (rotation(&mut source), 0.13);
            let shaped = &forms.distinct[0];
            let cells = list(&Cells::of(shaped, &turn, edge, 3, Ownership::Centre));
            let touched = list(&Cells::of(shaped, &turn, edge, 3, Ownership::Touched));
            assert!(cells.is_subset(&touched));
            let place = (Vec3::zeros(), turn);
            let holds = |p: &Vec3| match &shaped.form {
                Form::Surface(mesh) => {
                    Collider::new(mesh, 1.0).expect("triangles").holds(&place, p)
                }
                Form::Balls(balls) => balls.iter().any(|b| (turn * b.centre - p).norm() < b.radius),
            };
            let reach = (shaped.radius / edge).ceil() as i32 + 1;
            for z in -reach..reach {
                for y in -reach..reach {
                    for x in -reach..reach {
                        let point = |u: f64, v: f64, w: f64| {
                            edge * Vec3::new(f64::from(x) + u, f64::from(y) + v, f64::from(z) + w)
                        };
                        let key = [x, y, z];
                        assert_eq!(holds(&point(0.5, 0.5, 0.5)), cells.contains(&key), "{key:?}");
                        let corner = holds(&point(0.02, 0.97, 0.5));
                        assert!(!corner || touched.contains(&key), "{case} {key:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_ball_as_mesh_and_as_ball_owns_nearly_the_same() {
        let (clump, solid) = solid(icosphere(4));
        let as_mesh = Grain { clump: &clump, solid: Some(&solid), family: 0 };
        let count = |test| {
            let forms = Forms::new(&[as_mesh], test, 3);
            let turn = Rotation::identity();
            Cells::of(&forms.distinct[0], &turn, 2.0 / 30.0, 3, Ownership::Centre).count() as f64
        };
        assert!((count(Test::Solid) / count(Test::Clump) - 1.0).abs() < 0.02);
    }

    #[test]
    fn cells_are_owned_once() {
        let mut lattice = Lattice::new(&room(&[1.0, 0.5, 2.0]), 0.01, Ownership::Touched);
        assert_eq!(lattice.size, [102, 52, 202]);
        assert_eq!(lattice.room, 100 * 50 * 200);
        let run = |y, z, from, to| Run { y, z, from, to };
        let cells = Cells::united(vec![run(0, 0, -3, 70), run(1, 0, 0, 1), run(0, 0, 60, 80)]);
        assert_eq!((cells.count(), cells.extent(0), cells.extent(2)), (84, (-3, 80), (0, 1)));
        assert!(lattice.is_free(&cells, [4, 1, 1]) && !lattice.is_free(&cells, [3, 1, 1]));
        assert!(!lattice.is_free(&cells, [22, 1, 1]) && lattice.is_free(&cells, [21, 1, 1]));
        lattice.take(&cells, [4, 1, 1]);
        assert!(!lattice.is_free(&cells, [5, 1, 1]) && lattice.is_free(&cells, [5, 3, 1]));
        assert!(!lattice.is_free(&cells, [4, 0, 1]) && lattice.is_free(&cells, [4, 1, 2]));
        lattice.give(&cells, [4, 1, 1]);
        assert!(lattice.is_free(&cells, [5, 1, 1]));
        let flat = Lattice::new(&room(&[1.0, 0.5]), 0.01, Ownership::Centre);
        assert_eq!((flat.size, flat.room), ([102, 52, 1], 5000));
    }
}
