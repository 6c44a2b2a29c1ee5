//! Which balls are near a point: a hierarchical cell grid over balls.
//!
//! Each ball lies in exactly one cell of exactly one level; the cells of level
//! k are 2^k times as wide as those of level 0 and at least as wide as every
//! ball in them, so a query looks at a handful of cells a level whatever the
//! ratio of sizes (Ogarko & Luding 2012, Comput. Phys. Commun. 183, 931; the hierarchical
//! hash of Ericson, "Real-Time Collision Detection", 2005, section 7.2).
//!
//! Cost: O(1) an insertion, O(levels + balls found) a query whose reach is not
//! much larger than the balls. A query of a large ball among many small ones
//! looks at no more cells than there are balls in the level. Answers are exact
//! for any coordinates; order of visit depends only on the order of insertion.

use crate::num::Vec3;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

const NONE: u32 = u32::MAX;
/// Bits of a cell number along one axis; numbers that differ by a multiple of
/// 2^21 share a chain, which costs time and never changes an answer.
const BITS: u32 = 21;

/// Balls that can be looked up by place.
#[derive(Debug, Clone)]
pub struct BallGrid {
    smallest_cell: f64,
    centres: Vec<Vec3>,
    radii: Vec<f64>,
    next: Vec<u32>,
    levels: Vec<Level>,
}

#[derive(Debug, Clone, Default)]
struct Level {
    cell: f64,
    largest_radius: f64,
    /// First ball of the chain of each cell.
    heads: HashMap<u64, u32, BuildHasherDefault<CellHasher>>,
    members: Vec<u32>,
}

/// Spreads packed cell numbers over the table (Fibonacci hashing).
#[derive(Debug, Clone, Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        self.0 = crate::num::random::fnv1a(bytes);
    }

    fn write_u64(&mut self, key: u64) {
        let spread = key.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 = spread ^ (spread >> 32);
    }
}

fn cell_key(cell: [i64; 3]) -> u64 {
    let mask = (1_u64 << BITS) - 1;
    cell.iter().fold(0, |key, &c| (key << BITS) | (c as u64 & mask))
}

impl BallGrid {
    /// An empty grid; `smallest_radius` (m) is about the radius of the smallest
    /// balls to come (it matters for speed only; smaller ones are welcome).
    pub fn new(smallest_radius: f64) -> Self {
        let usable = smallest_radius.is_finite() && smallest_radius > 0.0;
        Self {
            smallest_cell: if usable { 2.0 * smallest_radius } else { 1.0 },
            centres: Vec::new(),
            radii: Vec::new(),
            next: Vec::new(),
            levels: Vec::new(),
        }
    }

    /// An empty grid with room for balls of these radii (m), so that nothing is moved while they come.
    pub fn expecting(radii: &[f64]) -> Self {
        let mut grid = Self::new(radii.iter().copied().fold(f64::INFINITY, f64::min));
        let mut counts = Vec::new();
        for &radius in radii {
            let level = grid.level_of(radius);
            if counts.len() <= level {
                counts.resize(level + 1, 0);
            }
            counts[level] += 1;
        }
        for count in counts {
            let level = grid.add_level();
            level.members.reserve_exact(count);
            level.heads.reserve(count);
        }
        grid.centres.reserve_exact(radii.len());
        grid.radii.reserve_exact(radii.len());
        grid.next.reserve_exact(radii.len());
        grid
    }

    /// Number of balls.
    pub fn len(&self) -> usize {
        self.radii.len()
    }

    /// True if there is no ball.
    pub fn is_empty(&self) -> bool {
        self.radii.is_empty()
    }

    /// Adds a ball and returns its number: 0, 1, 2, … in the order of insertion.
    pub fn insert(&mut self, centre: Vec3, radius: f64) -> u32 {
        let number = self.radii.len() as u32;
        let place = self.level_of(radius);
        while self.levels.len() <= place {
            self.add_level();
        }
        let level = &mut self.levels[place];
        level.largest_radius = level.largest_radius.max(radius);
        level.members.push(number);
        let key = cell_key(cell_of(&centre, level.cell));
        self.next.push(level.heads.insert(key, number).unwrap_or(NONE));
        self.centres.push(centre);
        self.radii.push(radius);
        number
    }

    fn level_of(&self, radius: f64) -> usize {
        // Balls too large for the last level only make its queries wider.
        (2.0 * radius / self.smallest_cell).log2().ceil().clamp(0.0, 63.0) as usize
    }

    fn add_level(&mut self) -> &mut Level {
        let cell = self.smallest_cell * (self.levels.len() as f64).exp2();
        self.levels.push_mut(Level { cell, ..Level::default() })
    }

    /// Calls `visit(number, gap)` for every ball whose surface lies nearer than
    /// `reach` to `centre` (`gap` = distance between `centre` and the ball's
    /// centre less the ball's radius, m; negative inside the ball) until it returns false.
    /// Returns false if `visit` stopped the search.
    pub fn near(&self, centre: &Vec3, reach: f64, mut visit: impl FnMut(u32, f64) -> bool) -> bool {
        self.candidates(centre, reach, |number| {
            let i = number as usize;
            let limit = reach + self.radii[i];
            let square = (self.centres[i] - centre).norm_squared();
            if limit <= 0.0 || square >= limit * limit {
                return true;
            }
            visit(number, square.sqrt() - self.radii[i])
        })
    }

    /// All balls in the cells that can hold a ball nearer than `reach`.
    fn candidates(&self, centre: &Vec3, reach: f64, mut check: impl FnMut(u32) -> bool) -> bool {
        for level in self.levels.iter().filter(|level| !level.members.is_empty()) {
            let span = reach + level.largest_radius;
            if span < 0.0 {
                continue;
            }
            let low = cell_of(&(centre - Vec3::repeat(span)), level.cell);
            let high = cell_of(&(centre + Vec3::repeat(span)), level.cell);
            let cells: f64 = (0..3).map(|a| high[a] as f64 - low[a] as f64 + 1.0).product();
            if cells > level.members.len() as f64 {
                if !level.members.iter().all(|&number| check(number)) {
                    return false;
                }
                continue;
            }
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    for z in low[2]..=high[2] {
                        if !self.chain(level, [x, y, z], &mut check) {
                            return false;
                        }
                    }
                }
            }
        }
        true
    }

    fn chain(&self, level: &Level, cell: [i64; 3], check: &mut impl FnMut(u32) -> bool) -> bool {
        let mut number = level.heads.get(&cell_key(cell)).copied().unwrap_or(NONE);
        while number != NONE {
            if !check(number) {
                return false;
            }
            number = self.next[number as usize];
        }
        true
    }

    /// True if some ball's surface lies nearer than `reach` to `centre`: with
    /// `reach` = radius + gap, if a ball of that radius would come closer than the gap.
    pub fn any_near(&self, centre: &Vec3, reach: f64) -> bool {
        !self.near(centre, reach, |_, _| false)
    }
}

/// Cell of `point`; saturates far outside the numbers that a cell can have.
fn cell_of(point: &Vec3, cell: f64) -> [i64; 3] {
    [0, 1, 2].map(|axis| (point[axis] / cell).floor() as i64)
}

/// Calls `visit(i, j, gap)` once for each pair of balls whose surfaces are
/// nearer than `reach()` (m), asked again for every ball so that a search for
/// the least gap can narrow as it goes. `gap` is negative for an overlap.
/// Pairs with `body[i] == body[j]` are passed over. Order: fixed by the input.
///
/// Cost O(n log n + pairs + n · levels): balls are taken from large to small
/// and each is looked up among those before it, which are no smaller.
pub fn near_pairs(
    centres: &[Vec3],
    radii: &[f64],
    body: &[u32],
    reach: impl Fn() -> f64,
    mut visit: impl FnMut(u32, u32, f64),
) {
    let mut order: Vec<u32> = (0..radii.len() as u32).collect();
    order
        .sort_unstable_by(|&a, &b| radii[b as usize].total_cmp(&radii[a as usize]).then(a.cmp(&b)));
    let mut grid = BallGrid::expecting(radii);
    for &i in &order {
        let at = i as usize;
        grid.near(&centres[at], radii[at] + reach(), |found, distance| {
            let j = order[found as usize];
            if body[j as usize] != body[at] {
                visit(i.min(j), i.max(j), distance - radii[at]);
            }
            true
        });
        grid.insert(centres[at], radii[at]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::{stream, uniform};
    use proptest::prelude::*;

    fn random_balls(seed: u64, count: usize, ratio: f64) -> (Vec<Vec3>, Vec<f64>) {
        let mut source = stream(seed, "grid test", 0);
        let centres =
            (0..count).map(|_| Vec3::from_fn(|_, _| uniform(&mut source, -1.0, 1.0))).collect();
        let radii = (0..count).map(|_| 0.1 * ratio.powf(-uniform(&mut source, 0.0, 1.0))).collect();
        (centres, radii)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn pairs_are_those_of_brute_force(seed in 0_u64..1000, ratio in 1.0..300.0_f64, reach in -0.02..0.1_f64) {
            let (centres, radii) = random_balls(seed, 120, ratio);
            let body: Vec<u32> = (0..120).map(|i| i / 3).collect();
            let mut found = Vec::new();
            near_pairs(&centres, &radii, &body, || reach, |i, j, gap| found.push((i, j, gap)));
            found.sort_by_key(|&(i, j, _)| (i, j));
            let mut expected = Vec::new();
            for i in 0..120_usize {
                for j in i + 1..120 {
                    let distance = (centres[i] - centres[j]).norm();
                    let limit = radii[i] + radii[j] + reach;
                    if body[i] != body[j] && limit > 0.0 && distance < limit {
                        expected.push((i as u32, j as u32, distance - radii[i] - radii[j]));
                    }
                }
            }
            prop_assert_eq!(found.len(), expected.len());
            for (a, b) in found.iter().zip(&expected) {
                prop_assert_eq!((a.0, a.1), (b.0, b.1));
                prop_assert!((a.2 - b.2).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn far_coordinates_are_found() {
        let mut grid = BallGrid::new(1e-6);
        let far = Vec3::new(1e6, -1e6, 3.0);
        grid.insert(far, 1.0);
        grid.insert(Vec3::zeros(), 1e-6);
        assert!(grid.any_near(&(far + Vec3::x() * 1.5), 0.6));
        assert!(!grid.any_near(&(far + Vec3::x() * 1.5), 0.4));
        assert!(!grid.any_near(&Vec3::new(5.0, 0.0, 0.0), 1.0));
    }

    #[test]
    fn a_wide_size_ratio_looks_at_few_candidates() {
        // 20 large balls beside 20 000 small ones: one grid of large cells would
        // offer thousands of candidates to each small ball.
        let (mut centres, mut radii) = random_balls(3, 20_020, 1.0);
        radii.iter_mut().skip(20).for_each(|r| *r = 1e-3);
        centres.iter_mut().take(20).for_each(|c| *c *= 3.0);
        let mut grid = BallGrid::new(1e-3);
        let mut looked = 0_usize;
        for (centre, &radius) in centres.iter().zip(&radii) {
            grid.candidates(centre, radius, |_| {
                looked += 1;
                true
            });
            grid.insert(*centre, radius);
        }
        assert!(looked < 30 * 20_020, "{looked}");
    }
}
