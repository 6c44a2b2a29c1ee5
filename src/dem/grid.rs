//! Hierarchical grid (Krijgsman, Ogarko & Luding 2014): a sphere lives in the
//! finest level whose cell is not smaller than its diameter plus twice the mean leeway;
//! level l has cells of half the size of level l − 1. So a wide range of sizes costs no more
//! than a narrow one. Slots are ordered by level (finest first) and cell, so
//! that neighbours in space are neighbours in memory.
//!
//! Cells one sphere wide hold 0.7 spheres of a bed. PFC aims at 5 to 20, where a cell is searched for each
//! body; here runs of cells are, and smaller ones enclose the range more closely. Building the lists of 100 000
//! settled spheres takes 77 ms so, 80 ms with cells twice as wide (5.6 spheres), 86 ms 2.9 times (17)
//! (medians of 10 alternating builds, 2026-11-23, two shared cores: ±15 ms); a run of 10 000 makes 16.2, 15.6
//! and 15.9 million sphere-steps a CPU second.
//! O(N log N); cannot fail.

use super::state::Ball;
use crate::num::Vec3;

/// More levels than any range of sizes needs (2^40).
const LEVELS: u32 = 40;

/// Cells along x and along y of a tile.
const TILE: usize = 12;

/// One level of the grid.
pub struct Level {
    low: Vec3,
    cell: f64,
    size: [usize; 3],
    /// First slot of each cell, and one past the last.
    start: Vec<u32>,
    /// Largest radius and leeway in the level together, m.
    pub reach: f64,
}

/// All levels, and the order of slots that belongs to them.
pub struct Grid {
    /// Finest first.
    pub levels: Vec<Level>,
    /// Old slot of each new slot.
    pub from: Vec<u32>,
    /// Level of each new slot.
    pub level: Vec<u8>,
}

impl Level {
    fn new(balls: &[Ball], leeway: &[f32], members: &[u32], cell: f64) -> Self {
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        let mut reach = 0.0f64;
        for member in members {
            let ball = &balls[*member as usize];
            if ball.place.iter().all(|x| x.is_finite()) {
                low = low.inf(&ball.place);
                high = high.sup(&ball.place);
            }
            reach = reach.max(ball.radius + f64::from(leeway[*member as usize]));
        }
        if low.x > high.x {
            (low, high) = (Vec3::zeros(), Vec3::zeros());
        }
        let most = 4.0 * members.len() as f64 + 64.0;
        let mut cell = cell;
        let count = |cell: f64| -> [f64; 3] {
            std::array::from_fn(|axis| ((high[axis] - low[axis]) / cell).floor() + 1.0)
        };
        while count(cell).iter().product::<f64>() > most {
            cell *= 1.25;
        }
        let size = count(cell).map(|n| n as usize);
        Self { low, cell, size, start: Vec::new(), reach }
    }

    fn along(&self, axis: usize, x: f64) -> usize {
        // Saturating cast: NaN and values below 0 become 0.
        (((x - self.low[axis]) / self.cell) as usize).min(self.size[axis] - 1)
    }

    fn cell_of(&self, place: &Vec3) -> u32 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.along(axis, place[axis]));
        self.number(x, y, z) as u32
    }

    /// Number of a cell: tiles of [`TILE`] × [`TILE`] cells are stacked along z, stacks stand side
    /// by side along x, then along y. So what is near in space is near in memory, and spheres that
    /// follow each other have few neighbours outside.
    fn number(&self, x: usize, y: usize, z: usize) -> usize {
        let [wide, deep, high] = self.size;
        let (left, front) = (x / TILE * TILE, y / TILE * TILE);
        let (across, along) = (TILE.min(wide - left), TILE.min(deep - front));
        wide * high * front + left * high * along + (z * along + y - front) * across + x - left
    }

    /// Whether the box between two corners meets the cells.
    pub fn meets(&self, low: &Vec3, high: &Vec3) -> bool {
        (0..3).all(|axis| {
            let end = self.low[axis] + self.cell * self.size[axis] as f64;
            low[axis] <= end && high[axis] >= self.low[axis]
        })
    }

    /// Slots in the cells between two corners, as runs of consecutive slots.
    pub fn runs(&self, low: &Vec3, high: &Vec3, mut visit: impl FnMut(u32, u32)) {
        let from: [usize; 3] = std::array::from_fn(|axis| self.along(axis, low[axis]));
        let to: [usize; 3] = std::array::from_fn(|axis| self.along(axis, high[axis]));
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                let mut x = from[0];
                while x <= to[0] {
                    let last = (x / TILE * TILE + TILE - 1).min(to[0]);
                    let (first, last_cell) = (self.number(x, y, z), self.number(last, y, z));
                    visit(self.start[first], self.start[last_cell + 1]);
                    x = last + 1;
                }
            }
        }
    }
}

impl Grid {
    /// Sorts the balls with these leeways, m; `order` decides between balls of one cell.
    pub fn new(balls: &[Ball], order: &[u32], leeway: &[f32]) -> Self {
        let mean = leeway.iter().map(|l| f64::from(*l)).sum::<f64>() / balls.len().max(1) as f64;
        let skin = 2.0 * mean;
        let largest = balls.iter().map(|ball| ball.radius).fold(0.0, f64::max);
        let top = 2.0 * largest + skin;
        let level_of = |ball: &Ball| {
            let ratio = (top / (2.0 * ball.radius + skin)).log2().floor();
            (ratio.max(0.0) as u32).min(LEVELS - 1)
        };
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); LEVELS as usize];
        for (slot, ball) in balls.iter().enumerate() {
            members[level_of(ball) as usize].push(slot as u32);
        }
        let mut grid = Self { levels: Vec::new(), from: Vec::new(), level: Vec::new() };
        for depth in (0..LEVELS as usize).rev() {
            if members[depth].is_empty() {
                continue;
            }
            let cell = top / (1u64 << depth) as f64;
            grid.add(balls, (order, leeway), &members[depth], cell);
        }
        grid
    }

    fn add(
        &mut self,
        balls: &[Ball],
        (order, leeway): (&[u32], &[f32]),
        members: &[u32],
        cell: f64,
    ) {
        let mut level = Level::new(balls, leeway, members, cell);
        let mut sorted: Vec<(u64, u32)> = members
            .iter()
            .map(|slot| {
                let cell = level.cell_of(&balls[*slot as usize].place);
                (join(cell, order[*slot as usize]), *slot)
            })
            .collect();
        sorted.sort_unstable();
        let base = self.from.len() as u32;
        let cells = level.size.iter().product::<usize>();
        level.start = vec![0; cells + 1];
        for (key, _) in &sorted {
            level.start[(key >> 32) as usize + 1] += 1;
        }
        level.start[0] = base;
        for cell in 0..cells {
            level.start[cell + 1] += level.start[cell];
        }
        let number = self.levels.len() as u8;
        for (_, slot) in sorted {
            self.from.push(slot);
            self.level.push(number);
        }
        self.levels.push(level);
    }
}

/// Two numbers as one, ordered by the first.
pub fn join(a: u32, b: u32) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}
