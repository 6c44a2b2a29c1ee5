//! Near pairs of balls of any sizes, in flat arrays.
//!
//! Hierarchical cells (Ogarko & Luding 2012, Comput. Phys. Commun. 183, 931): balls are
//! sorted into levels by powers of 2 of the radius, each level into a dense
//! array of cells that are as wide as its balls reach and no more than twice as many as its
//! balls. Within a level each cell looks at those ahead of it; a ball looks into all finer levels, where
//! the cells that it covers lie in rows one after another in memory (the other way round every small ball would
//! look at eight cells of each coarser level). Sides may repeat; each pair
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
}

#[derive(Debug, Default)]
struct Level {
    largest: f64,
    members: Vec<u32>,
    count: [usize; 3],
    edge: Vec3,
    /// 1/m.
    per_edge: Vec3,
    /// First place in `balls` of each cell, and the end.
    first: Vec<u32>,
    /// Cell by cell.
    balls: Vec<Seen>,
    /// Cell of each of them along each axis.
    cells: Vec<[u32; 3]>,
}

/// A ball as the search sees it: all it needs side by side.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    centre: Vec3,
    radius: f64,
    number: u32,
}

/// What all searches of one call have in common.
struct Search<'a> {
    space: &'a Space<'a>,
    shifts: &'a [Vec3],
    stretch: f64,
    skin: f64,
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
        for level in self.levels.iter_mut().filter(|level| !level.members.is_empty()) {
            level.fill(space, centres, radii, stretch, skin);
        }
        let search = Search { space, shifts: &self.shifts, stretch, skin };
        for (coarse, level) in self.levels.iter().enumerate() {
            level.among_themselves(&search, &mut self.list);
            for finer in self.levels[..coarse].iter().filter(|finer| !finer.members.is_empty()) {
                for ball in &level.balls {
                    finer.near(&search, ball, &mut self.list);
                }
            }
        }
    }

    fn sort_into_levels(&mut self, radii: &[f64]) {
        let smallest = radii.iter().copied().fold(f64::INFINITY, f64::min);
        for level in &mut self.levels {
            level.members.clear();
            level.balls.clear();
            level.largest = 0.0;
        }
        for (i, &radius) in radii.iter().enumerate() {
            let level = (radius / smallest).log2().clamp(0.0, 62.0) as usize;
            while self.levels.len() <= level {
                self.levels.push(Level::default());
            }
            self.levels[level].members.push(i as u32);
            self.levels[level].largest = self.levels[level].largest.max(radius);
        }
    }
}

/// The whole number at or below `x`, which is far smaller than 2⁶³ in size.
fn floor(x: f64) -> i64 {
    let cut = x as i64;
    cut - i64::from(x < cut as f64)
}

impl Level {
    fn fill(&mut self, space: &Space, centres: &[Vec3], radii: &[f64], stretch: f64, skin: f64) {
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
            self.per_edge[axis] = if axis < axes { fits / size[axis] } else { 0.0 };
        }
        let cells = self.count.iter().product::<usize>();
        self.first.clear();
        self.first.resize(cells + 1, 0);
        let cell_of = |centre: &Vec3| -> [u32; 3] {
            std::array::from_fn(|axis| {
                let c = floor((centre[axis] - space.bounds.low[axis]) * self.per_edge[axis]);
                c.clamp(0, self.count[axis] as i64 - 1) as u32
            })
        };
        let number = |at: &[u32; 3]| {
            (at[0] as usize * self.count[1] + at[1] as usize) * self.count[2] + at[2] as usize
        };
        for &i in &self.members {
            self.first[number(&cell_of(&centres[i as usize])) + 1] += 1;
        }
        for cell in 0..cells {
            self.first[cell + 1] += self.first[cell];
        }
        self.balls.clear();
        self.balls.resize(self.members.len(), Seen::default());
        self.cells.clear();
        self.cells.resize(self.members.len(), [0; 3]);
        let mut free = self.first.clone();
        for &i in &self.members {
            let centre = centres[i as usize];
            let cell = cell_of(&centre);
            let place = &mut free[number(&cell)];
            self.balls[*place as usize] = Seen { centre, radius: radii[i as usize], number: i };
            self.cells[*place as usize] = cell;
            *place += 1;
        }
    }

    /// Pairs of balls of this level, each once: every cell with those ahead of it. Where sides
    /// repeat after fewer than three cells, or balls reach farther than the next, with all.
    fn among_themselves(&self, search: &Search, list: &mut Vec<Pair>) {
        let axes = search.space.dimension;
        let reach = 2.0 * search.stretch * self.largest + search.skin;
        let plain = (0..axes).all(|axis| {
            (!search.space.periodic[axis] || self.count[axis] >= 3)
                && (self.count[axis] == 1 || reach <= self.edge[axis])
        });
        if !plain {
            for ball in &self.balls {
                let from = list.len();
                self.near(search, ball, list);
                // Each pair is seen from both sides; a ball also meets itself and its images.
                let mut kept = from;
                for at in from..list.len() {
                    if list[at].j > list[at].i {
                        list[kept] = list[at];
                        kept += 1;
                    }
                }
                list.truncate(kept);
            }
            return;
        }
        const AHEAD: [[i64; 2]; 4] = [[0, 1], [1, -1], [1, 0], [1, 1]];
        for (place, ball) in self.balls.iter().enumerate() {
            let at = self.cells[place].map(i64::from);
            let own = (at[0] as usize * self.count[1] + at[1] as usize) * self.count[2];
            let end = self.first[own + at[2] as usize + 1] as usize;
            self.scan(search, ball, place + 1..end, 13, list);
            self.column(search, ball, [at[0], at[1]], [at[2] + 1, at[2] + 1], list);
            for [x, y] in AHEAD {
                let column = [at[0] + x, at[1] + y];
                self.column(search, ball, column, [at[2] - 1, at[2] + 1], list);
            }
        }
    }

    /// Pairs of `ball`, of a coarser level or this one, with all near balls of this level. Balls outside a
    /// box that does not repeat lie in its outermost cells.
    fn near(&self, search: &Search, ball: &Seen, list: &mut Vec<Pair>) {
        let reach = search.stretch * (ball.radius + self.largest) + search.skin;
        let span = |axis: usize| {
            let x = ball.centre[axis] - search.space.bounds.low[axis];
            let low = floor((x - reach) * self.per_edge[axis]);
            let high = floor((x + reach) * self.per_edge[axis]);
            match search.space.periodic[axis] {
                true => [low, high.min(low + 3 * self.count[axis] as i64 - 1)],
                false => [low, high].map(|cell| cell.clamp(0, self.count[axis] as i64 - 1)),
            }
        };
        let (xs, ys, zs) = (span(0), span(1), span(2));
        for x in xs[0]..=xs[1] {
            for y in ys[0]..=ys[1] {
                self.column(search, ball, [x, y], zs, list);
            }
        }
    }

    /// Pairs of `ball` with the balls in cells `zs[0]..=zs[1]` of a column; cells beyond sides that repeat are
    /// those of the other side, beyond others there is nothing.
    fn column(
        &self,
        search: &Search,
        ball: &Seen,
        at: [i64; 2],
        zs: [i64; 2],
        list: &mut Vec<Pair>,
    ) {
        let mut code = 0;
        let mut column = 0;
        for (axis, &cell) in at.iter().enumerate() {
            let count = self.count[axis] as i64;
            let (inside, digit) = self.wrapped(search, axis, cell);
            if !(0..count).contains(&inside) {
                return;
            }
            code = 3 * code + digit;
            column = column * self.count[axis] + inside as usize;
        }
        let count = self.count[2] as i64;
        let base = column * self.count[2];
        let mut z = zs[0];
        if !search.space.periodic[2] {
            z = z.max(0);
        }
        while z <= zs[1] {
            let (inside, digit) = self.wrapped(search, 2, z);
            if inside >= count {
                return;
            }
            // All cells up to the next side lie one after another.
            let last = (inside + zs[1] - z).min(count - 1);
            let from = self.first[base + inside as usize] as usize;
            let to = self.first[base + last as usize + 1] as usize;
            self.scan(search, ball, from..to, 3 * code + digit, list);
            z += last - inside + 1;
        }
    }

    /// Cell inside the box, and the digit of the shift: 0 below, 1 inside, 2 above.
    fn wrapped(&self, search: &Search, axis: usize, cell: i64) -> (i64, usize) {
        let count = self.count[axis] as i64;
        if !search.space.periodic[axis] || (0..count).contains(&cell) {
            return (cell, 1);
        }
        let turns = cell.div_euclid(count);
        (cell - turns * count, (1 + turns.clamp(-1, 1)) as usize)
    }

    #[inline(always)]
    fn scan(
        &self,
        search: &Search,
        ball: &Seen,
        range: std::ops::Range<usize>,
        code: usize,
        list: &mut Vec<Pair>,
    ) {
        // The other ball is seen at +shift, so the way to it is centre − (other + shift).
        let seen = ball.centre - search.shifts[code];
        let own = search.stretch * ball.radius + search.skin;
        for other in &self.balls[range] {
            let limit = own + search.stretch * other.radius;
            if (seen - other.centre).norm_squared() < limit * limit {
                list.push(Pair { i: ball.number, j: other.number, shift: 26 - code as u8 });
            }
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
