//! Near pairs of balls of any sizes, in flat arrays.
//!
//! Hierarchical cells (Ogarko & Luding 2012, Comput. Phys. Commun. 183, 931): balls are
//! sorted into levels by powers of 2 of the radius, each level into a dense
//! array of cells that are as wide as its balls reach and no more than twice as many as its
//! balls. A ball looks into its own level and all coarser ones. Sides may repeat; each pair
//! carries the shift of its image, so forces need no nearest-image search.
//!
//! Cost O(n · levels + pairs), whatever the ratio of sizes, for balls spread evenly; memory O(n + pairs).

use super::space::Space;
use crate::num::Vec3;

/// Two balls that are near: `centre(i) − centre(j) + shift` is the short way between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pair {
    /// One ball.
    pub i: u32,
    /// The other one.
    pub j: u32,
    /// Which of [`Pairs::shifts`] to add.
    pub shift: u8,
}

/// Near pairs and the arrays they are found with, kept for the next search.
#[derive(Debug, Default)]
pub struct Pairs {
    /// Each near pair once.
    pub list: Vec<Pair>,
    /// Steps from one image to another, m; number 13 is none.
    pub shifts: Vec<Vec3>,
    levels: Vec<Level>,
    level_of: Vec<u8>,
}

#[derive(Debug, Default)]
struct Level {
    largest: f64,
    members: Vec<u32>,
    count: [usize; 3],
    edge: Vec3,
    /// First place in `sorted` of each cell, and the end.
    first: Vec<u32>,
    sorted: Vec<u32>,
}

impl Pairs {
    /// Finds all pairs nearer than `stretch · (r_i + r_j) + skin` m, centre to centre.
    /// Centres must lie in the box of a space that repeats.
    pub fn find(
        &mut self,
        space: &Space,
        centres: &[Vec3],
        radii: &[f64],
        stretch: f64,
        skin: f64,
    ) {
        self.list.clear();
        let size = space.bounds.size();
        self.shifts.clear();
        for code in 0..27 {
            let step = |axis: usize, digit: i32| {
                if space.periodic[axis] { f64::from(digit - 1) * size[axis] } else { 0.0 }
            };
            self.shifts.push(Vec3::new(
                step(0, code / 9),
                step(1, code / 3 % 3),
                step(2, code % 3),
            ));
        }
        self.sort_into_levels(radii);
        for level in &mut self.levels {
            level.fill(space, centres, stretch, skin);
        }
        for i in 0..radii.len() {
            for finer in usize::from(self.level_of[i])..self.levels.len() {
                if !self.levels[finer].members.is_empty() {
                    self.look(space, i, finer, centres, radii, stretch, skin);
                }
            }
        }
    }

    fn sort_into_levels(&mut self, radii: &[f64]) {
        let smallest = radii.iter().copied().fold(f64::INFINITY, f64::min);
        self.level_of.clear();
        for level in &mut self.levels {
            level.members.clear();
            level.largest = 0.0;
        }
        for (i, &radius) in radii.iter().enumerate() {
            let level = (radius / smallest).log2().clamp(0.0, 62.0) as usize;
            while self.levels.len() <= level {
                self.levels.push(Level::default());
            }
            self.level_of.push(level as u8);
            self.levels[level].members.push(i as u32);
            self.levels[level].largest = self.levels[level].largest.max(radius);
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn look(
        &mut self,
        space: &Space,
        i: usize,
        level: usize,
        centres: &[Vec3],
        radii: &[f64],
        stretch: f64,
        skin: f64,
    ) {
        let own = usize::from(self.level_of[i]) == level;
        let level = &self.levels[level];
        let reach = stretch * (radii[i] + level.largest) + skin;
        let here = centres[i];
        let spans: [Span; 3] = std::array::from_fn(|axis| {
            let x = here[axis] - space.bounds.low[axis];
            let low = ((x - reach) / level.edge[axis]).floor() as i64;
            let high = ((x + reach) / level.edge[axis]).floor() as i64;
            Span::new(low, high, level.count[axis], space.periodic[axis])
        });
        for x in spans[0].cells() {
            let (cx, sx) = spans[0].wrapped(x);
            for y in spans[1].cells() {
                let (cy, sy) = spans[1].wrapped(y);
                for z in spans[2].cells() {
                    let (cz, sz) = spans[2].wrapped(z);
                    let cell = (cx * level.count[1] + cy) * level.count[2] + cz;
                    let code = sx * 9 + sy * 3 + sz;
                    // The other ball is seen at +shift, so the way to it is centre − (other + shift).
                    let seen = here - self.shifts[usize::from(code)];
                    let range = level.first[cell] as usize..level.first[cell + 1] as usize;
                    for &j in &level.sorted[range] {
                        let j_at = j as usize;
                        if own && j_at <= i {
                            continue;
                        }
                        let limit = stretch * (radii[i] + radii[j_at]) + skin;
                        if (seen - centres[j_at]).norm_squared() < limit * limit {
                            self.list.push(Pair { i: i as u32, j, shift: 26 - code });
                        }
                    }
                }
            }
        }
    }
}

/// Cells along one axis that a ball looks into.
struct Span {
    low: i64,
    high: i64,
    count: i64,
    periodic: bool,
}

impl Span {
    fn new(low: i64, high: i64, count: usize, periodic: bool) -> Self {
        let count = count as i64;
        match periodic {
            true => Self { low, high: high.min(low + 3 * count - 1), count, periodic },
            false => {
                let clamp = |c: i64| c.clamp(0, count - 1);
                Self { low: clamp(low), high: clamp(high), count, periodic }
            }
        }
    }

    fn cells(&self) -> std::ops::RangeInclusive<i64> {
        self.low..=self.high
    }

    /// Cell inside the box, and the digit of the shift: 0 below, 1 inside, 2 above.
    fn wrapped(&self, cell: i64) -> (usize, u8) {
        if !self.periodic {
            return (cell as usize, 1);
        }
        let turns = cell.div_euclid(self.count);
        ((cell - turns * self.count) as usize, (1 + turns.clamp(-1, 1)) as u8)
    }
}

impl Level {
    fn fill(&mut self, space: &Space, centres: &[Vec3], stretch: f64, skin: f64) {
        let size = space.bounds.size();
        let axes = space.dimension;
        let wanted = 2.0 * stretch * self.largest + skin;
        // As wide as its balls reach, but no more than about two cells a ball.
        let volume: f64 = (0..axes).map(|axis| size[axis]).product();
        let even = (volume / (2.0 * self.members.len().max(1) as f64)).powf(1.0 / axes as f64);
        let edge = wanted.max(even);
        for axis in 0..3 {
            let fits =
                if axis < axes { (size[axis] / edge).floor().clamp(1.0, 4096.0) } else { 1.0 };
            self.count[axis] = fits as usize;
            self.edge[axis] = if axis < axes { size[axis] / fits } else { f64::MAX };
        }
        let cells = self.count.iter().product::<usize>();
        self.first.clear();
        self.first.resize(cells + 1, 0);
        let cell_of = |centre: &Vec3| {
            let at: [usize; 3] = std::array::from_fn(|axis| {
                let c = ((centre[axis] - space.bounds.low[axis]) / self.edge[axis]).floor();
                (c.max(0.0) as usize).min(self.count[axis] - 1)
            });
            (at[0] * self.count[1] + at[1]) * self.count[2] + at[2]
        };
        for &i in &self.members {
            self.first[cell_of(&centres[i as usize]) + 1] += 1;
        }
        for cell in 0..cells {
            self.first[cell + 1] += self.first[cell];
        }
        self.sorted.clear();
        self.sorted.resize(self.members.len(), 0);
        let mut free = self.first.clone();
        for &i in &self.members {
            let place = &mut free[cell_of(&centres[i as usize])];
            self.sorted[*place as usize] = i;
            *place += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::{stream, uniform};
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(30))]
        #[test]
        fn pairs_are_those_of_brute_force(
            seed in 0_u64..1000, dimension in 2_usize..4, periodic: bool, span in 0.0..2.0_f64,
        ) {
            let mut source = stream(seed, "pairs", 0);
            let size = Vec3::new(1.0, 1.3, 0.9);
            let mut space = Space::repeating(dimension, size);
            if !periodic {
                space.periodic = [false; 3];
            }
            let count = 120;
            let centres: Vec<Vec3> = (0..count)
                .map(|_| space.sample(&mut source).expect("a box"))
                .collect();
            let radii: Vec<f64> =
                (0..count).map(|_| 0.1 * 10.0_f64.powf(-uniform(&mut source, 0.0, span))).collect();
            let mut pairs = Pairs::default();
            pairs.find(&space, &centres, &radii, 1.1, 0.02);
            let mut found: Vec<(u32, u32)> = Vec::new();
            for pair in &pairs.list {
                let (i, j) = (pair.i as usize, pair.j as usize);
                let way = centres[i] - centres[j] + pairs.shifts[usize::from(pair.shift)];
                let straight = space.apart(&centres[i], &centres[j]);
                prop_assert!((way.norm() - straight.norm()).abs() < 1e-12);
                found.push((pair.i.min(pair.j), pair.i.max(pair.j)));
            }
            found.sort_unstable();
            let mut expected = Vec::new();
            for i in 0..count {
                for j in i + 1..count {
                    let d = space.apart(&centres[i], &centres[j]).norm();
                    if d < 1.1 * (radii[i] + radii[j]) + 0.02 {
                        expected.push((i as u32, j as u32));
                    }
                }
            }
            prop_assert_eq!(found, expected);
        }
    }
}
