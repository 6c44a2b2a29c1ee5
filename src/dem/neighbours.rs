//! Verlet lists: which spheres, planes and triangles a sphere can touch before
//! the lists are built again.
//!
//! Hierarchical grid (Krijgsman, Ogarko & Luding 2014): a sphere lives in the
//! finest level whose cell is not smaller than its diameter plus the skin;
//! level l has cells of half the size of level l − 1. Each sphere looks at its
//! own level and at all coarser ones, so a wide range of sizes costs no more
//! than a narrow one. Slots are ordered by level (finest first) and cell, so
//! that neighbours in space are neighbours in memory.
//!
//! A pair is listed while its gap is below the skin s; lists are valid while no
//! sphere moved more than s/2, and no sphere and wall together more than s.
//! Where contacts are looked for along the path of a step (`path_averaged`), the
//! gap may be larger by twice the way w of half a step, and a sphere must be within
//! s/2 + w of where it was at the build at both ends of the step.
//! Cells one sphere wide hold 0.7 spheres of a bed. PFC aims at 5 to 20, where a cell is searched for each
//! body; here runs of cells are, and smaller ones enclose the range more closely. Building the lists of 100 000
//! settled spheres takes 77 ms so, 80 ms with cells twice as wide (5.6 spheres), 86 ms 2.9 times (17)
//! (medians of 10 alternating builds, 2026-11-23, two shared cores: ±15 ms); a run of 10 000 makes 16.2, 15.6
//! and 15.9 million sphere-steps a CPU second.
//! The skin follows the motion: see [`next_skin`].
//! In a periodic box bodies are brought home first, each sphere also looks from its images near
//! the other side, and a pair is listed at its nearest image only.
//! Tangential springs go over to the new lists by the slots that spheres had before.
//! O(N log N) time, O(N) memory; beside bodies and new lists there are only the touching entries
//! of the old ones. Cannot fail: positions that are not finite
//! land in some cell and are caught by the guard.

use super::crew::Crew;
use super::law::Book;
use super::setting::{FIRST_SKIN, MOST_SKIN, Setting};
use super::state::{Ball, List, Load, State};
use super::surface;
use crate::geometry::Cell;
use crate::model::Scheme;
use crate::num::Vec3;
use std::ops::Range;

/// More levels than any range of sizes needs (2^40).
const LEVELS: u32 = 40;

/// Steps between two looks whether the lists are too wide.
const LOOK: u64 = 100;

/// Spheres whose partners a thread looks for at a time.
const STRETCH: usize = 512;

/// Cells along x and along y of a tile.
const TILE: usize = 12;

/// Builds all lists anew.
pub fn rebuild(setting: &Setting<'_>, state: &mut State, crew: &Crew) {
    let time = setting.pass_time(state.step);
    if state.rebuilds > 0 {
        state.skin = next_skin(setting, state);
    }
    if let Some(cell) = &setting.model.periodic {
        bring_home(setting, state, cell);
    }
    state.sweep = sweep(setting, state);
    // What the next pass sets anew makes room for two lists at a time.
    state.built = Vec::new();
    let spheres = state.balls.len();
    if setting.scheme != Scheme::PathAveraged {
        state.loads = Vec::new();
    }
    let grid = Grid::new(&state.balls, &state.order, state.skin);
    permute(state, &grid);
    let old = [&mut state.pairs, &mut state.planes, &mut state.faces].map(std::mem::take);
    let [pairs_before, planes_before, faces_before] = old.map(List::touching);
    let (start, partner) = pairs(setting, state, &grid, crew);
    let from = grid.from;
    drop(grid.levels);
    let book = remember_pairs(setting, pairs_before, (&start, &partner), &from);
    state.pairs = List { start, partner, book };
    let (start, partner) = planes(setting, state, time);
    let book = remember(setting, planes_before, (&start, &partner), &from);
    state.planes = List { start, partner, book };
    let (start, partner) = faces(setting, state, time);
    let book = remember(setting, faces_before, (&start, &partner), &from);
    state.faces = List { start, partner, book };
    state.loads.resize(spheres, Load::default());
    state.built = state.balls.iter().map(|ball| ball.place).collect();
    state.built_at = state.step;
    state.rebuilds += 1;
}

/// The skin that costs least if spheres go on as they went since the last build, m. Where the
/// farthest goes v a step, a skin s lasts for n = s/(2 v) steps of time t each; a pair in it costs 0.2 t and
/// there are 5 s/r such pairs a sphere (r the median radius; measured in beds); a build costs
/// 15 t. The sum of both a step, s/r + 15/n, is least at s = √(30 v r).
/// Within 0.02 r and 0.3 r, and a quarter to twice what it was.
fn next_skin(setting: &Setting<'_>, state: &State) -> f64 {
    let radius = setting.skin / FIRST_SKIN;
    let near = best_skin(setting, state).clamp(0.25 * state.skin, 2.0 * state.skin);
    near.clamp(0.02 * radius, MOST_SKIN * radius)
}

/// Whether lists that are still valid hold so many pairs too many that building them pays: looked at
/// every [`LOOK`] steps. The skin s costs s/r a step; the best skin b costs twice b/r with its builds, and
/// the build now 15 t, which must come in again within as many steps as the lists have lasted.
pub fn too_wide(setting: &Setting<'_>, state: &State) -> bool {
    let lasted = state.step - state.built_at;
    if lasted == 0 || !lasted.is_multiple_of(LOOK) {
        return false;
    }
    let radius = setting.skin / FIRST_SKIN;
    let next = next_skin(setting, state);
    state.skin > 2.0 * next + 15.0 * radius / lasted as f64
}

/// See [`next_skin`].
fn best_skin(setting: &Setting<'_>, state: &State) -> f64 {
    let lasted = (state.step - state.built_at).max(1) as f64;
    let ways = state.balls.iter().zip(&state.built).map(|(ball, built)| ball.place - built);
    let far = ways.map(|way| way.norm_squared()).fold(0.0, f64::max).sqrt();
    let time = |step: u64| step as f64 * setting.step;
    let walls = setting.wall_travel(time(state.built_at), time(state.step));
    let radius = setting.skin / FIRST_SKIN;
    (15.0 * radius * walls.max(2.0 * far) / lasted).sqrt()
}

/// Moves bodies whose centre of mass has left a periodic box to their image in it.
fn bring_home(setting: &Setting<'_>, state: &mut State, cell: &Cell) {
    let bodies = &setting.model.bodies;
    let mut carried = 0.0;
    for ball in state.balls.iter_mut().filter(|ball| ball.alone) {
        let way = cell.home(&ball.place);
        ball.place += way;
        carried += bodies[ball.body as usize].mass * setting.gravity.dot(&way);
    }
    for solid in &mut state.solids {
        let way = cell.home(&solid.place);
        if way == Vec3::zeros() {
            continue;
        }
        solid.place += way;
        let body = &bodies[solid.body as usize];
        carried += body.mass * setting.gravity.dot(&way);
        for sphere in body.first_sphere..body.first_sphere + body.sphere_count {
            state.balls[state.slot[sphere as usize] as usize].place += way;
        }
    }
    if carried.is_finite() {
        state.ledger.carried += carried;
    }
}

/// Farthest that a sphere goes in half a step, and a wall, m; only where contacts are
/// looked for along the path of a step. At most a diameter: what is faster flies through anyway.
fn sweep(setting: &Setting<'_>, state: &State) -> f64 {
    if setting.scheme != Scheme::PathAveraged {
        return 0.0;
    }
    let square = state.balls.iter().map(|ball| ball.velocity.norm_squared()).fold(0.0, f64::max);
    // A speed that is not finite is for the guard.
    let half = 0.5 * setting.step;
    let far = half * square.sqrt() + setting.wall_travel(0.0, half);
    let most = state.balls.iter().map(|ball| 2.0 * ball.radius).fold(0.0, f64::max);
    if far.is_finite() { far.min(most) } else { 0.0 }
}

impl List {
    /// The touching entries only.
    fn touching(mut self) -> Self {
        fn keep<T: Copy>(values: &mut Vec<T>, touching: &[bool]) {
            if !values.is_empty() {
                let mut kept = touching.iter();
                values.retain(|_| kept.next().is_some_and(|touching| *touching));
                values.shrink_to_fit();
            }
        }
        let mut left = 0;
        let mut from = 0;
        for start in &mut self.start {
            let to = *start as usize;
            left += self.book.touching[from..to].iter().filter(|touching| **touching).count();
            (from, *start) = (to, left as u32);
        }
        let touching = std::mem::take(&mut self.book.touching);
        keep(&mut self.partner, &touching);
        keep(&mut self.book.spring, &touching);
        keep(&mut self.book.lag, &touching);
        keep(&mut self.book.power, &touching);
        keep(&mut self.book.normal, &touching);
        keep(&mut self.book.pull, &touching);
        self
    }

    /// Entry of `slot` with `partner`.
    fn find(&self, slot: u32, partner: u32) -> Option<usize> {
        let slot = slot as usize;
        // There are no lists yet at the first build.
        let from = *self.start.get(slot)? as usize;
        let entries = &self.partner[from..self.start[slot + 1] as usize];
        entries.iter().position(|entry| *entry == partner).map(|at| from + at)
    }
}

fn join(a: u32, b: u32) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}

/// Nothing is remembered of an entry.
const NEW: u32 = u32::MAX;
/// What is remembered is seen from the other side.
const TURNED: u32 = 1 << 31;

/// What sphere–sphere contacts remember, by the slots `before` the build of each slot. A list
/// holds a pair at the sphere that comes first.
fn remember_pairs(
    setting: &Setting<'_>,
    old: List,
    (start, partner): (&[u32], &[u32]),
    before: &[u32],
) -> Book {
    let place = |slot: usize, other: u32| {
        let (one, other) = (before[slot], before[other as usize]);
        if one < other {
            old.find(one, other).map(|at| at as u32)
        } else {
            old.find(other, one).map(|at| at as u32 | TURNED)
        }
    };
    let places = places(start, partner, place);
    carry(setting, old.book, &places)
}

/// The same of contacts with walls, whose partners keep their numbers.
fn remember(
    setting: &Setting<'_>,
    old: List,
    (start, partner): (&[u32], &[u32]),
    before: &[u32],
) -> Book {
    let places =
        places(start, partner, |slot, wall| old.find(before[slot], wall).map(|at| at as u32));
    carry(setting, old.book, &places)
}

/// For each entry of a list its `place` in what is remembered.
fn places(start: &[u32], partner: &[u32], place: impl Fn(usize, u32) -> Option<u32>) -> Vec<u32> {
    let mut places = Vec::with_capacity(partner.len());
    for (slot, range) in start.windows(2).enumerate() {
        let entries = &partner[range[0] as usize..range[1] as usize];
        places.extend(entries.iter().map(|other| place(slot, *other).unwrap_or(NEW)));
    }
    places
}

/// A book of `old` entries at new places. One array after the other, so that few are there twice.
fn carry(setting: &Setting<'_>, old: Book, places: &[u32]) -> Book {
    fn moved<T: Copy>(
        (wanted, old): (bool, Vec<T>),
        places: &[u32],
        none: T,
        turn: impl Fn(T) -> T,
    ) -> Vec<T> {
        let of = |place: &u32| match *place {
            NEW => none,
            place if place & TURNED != 0 => turn(old[(place & !TURNED) as usize]),
            place => old[place as usize],
        };
        let wanted = if wanted { places } else { &[] };
        wanted.iter().map(of).collect()
    }
    let (kept, zero) = (setting.kept, Vec3::zeros());
    let Book { spring, lag, power, normal, pull, .. } = old;
    Book {
        lag: moved((kept.damping, lag), places, 0.0, |lag| lag),
        power: moved((kept.friction && kept.damping, power), places, 0.0, |power| power),
        spring: moved((kept.friction, spring), places, zero, |v| -v),
        touching: places.iter().map(|place| *place != NEW).collect(),
        normal: moved((kept.friction && kept.normals, normal), places, zero, |v| -v),
        pull: moved((kept.friction && kept.pulls, pull), places, zero, |v| -v),
    }
}

/// One level of the grid.
struct Level {
    low: Vec3,
    cell: f64,
    size: [usize; 3],
    /// First slot of each cell, and one past the last.
    start: Vec<u32>,
    /// Largest radius in the level.
    reach: f64,
}

/// All levels, and the order of slots that belongs to them.
struct Grid {
    levels: Vec<Level>,
    /// Old slot of each new slot.
    from: Vec<u32>,
    /// Level of each new slot.
    level: Vec<u8>,
    /// Cell of each new slot.
    cell: Vec<u32>,
}

impl Level {
    fn new(balls: &[Ball], members: &[u32], cell: f64) -> Self {
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        let mut reach = 0.0f64;
        for member in members {
            let ball = &balls[*member as usize];
            if ball.place.iter().all(|x| x.is_finite()) {
                low = low.inf(&ball.place);
                high = high.sup(&ball.place);
            }
            reach = reach.max(ball.radius);
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
    fn meets(&self, low: &Vec3, high: &Vec3) -> bool {
        (0..3).all(|axis| {
            let end = self.low[axis] + self.cell * self.size[axis] as f64;
            low[axis] <= end && high[axis] >= self.low[axis]
        })
    }

    /// Slots in the cells between two corners, as runs of consecutive slots.
    fn runs(&self, low: &Vec3, high: &Vec3, mut visit: impl FnMut(u32, u32)) {
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
    fn new(balls: &[Ball], order: &[u32], skin: f64) -> Self {
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
        let mut grid =
            Self { levels: Vec::new(), from: Vec::new(), level: Vec::new(), cell: Vec::new() };
        for depth in (0..LEVELS as usize).rev() {
            if members[depth].is_empty() {
                continue;
            }
            let cell = top / (1u64 << depth) as f64;
            grid.add(balls, order, &members[depth], cell);
        }
        grid
    }

    fn add(&mut self, balls: &[Ball], order: &[u32], members: &[u32], cell: f64) {
        let mut level = Level::new(balls, members, cell);
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
        for (key, slot) in sorted {
            self.from.push(slot);
            self.level.push(number);
            self.cell.push((key >> 32) as u32);
        }
        self.levels.push(level);
    }
}

/// Puts the arrays of the state in the grid's order.
fn permute(state: &mut State, grid: &Grid) {
    fn pick<T: Copy>(values: &mut Vec<T>, from: &[u32]) {
        if !values.is_empty() {
            *values = from.iter().map(|slot| values[*slot as usize]).collect();
        }
    }
    pick(&mut state.balls, &grid.from);
    pick(&mut state.spins, &grid.from);
    pick(&mut state.loads, &grid.from);
    if state.light.0.len() > 1 {
        pick(&mut state.light.0, &grid.from);
    }
    pick(&mut state.order, &grid.from);
    for (slot, number) in state.order.iter().enumerate() {
        state.slot[*number as usize] = slot as u32;
    }
}

/// Pairs of some spheres that follow each other: how many the first few of them have together, and
/// the second spheres.
struct Stretch {
    slots: Range<usize>,
    ends: Vec<u32>,
    partner: Vec<u32>,
}

/// Where the pairs of each sphere begin, and their second spheres.
fn pairs(setting: &Setting<'_>, state: &State, grid: &Grid, crew: &Crew) -> (Vec<u32>, Vec<u32>) {
    let count = state.balls.len();
    let skin = state.skin + 2.0 * state.sweep;
    let images =
        setting.model.periodic.map(|cell| (cell, reach_of_images(&state.balls, &cell, skin)));
    // One stretch on one thread: nothing is there twice.
    let size = if crew.size() > 1 { STRETCH } else { count.max(1) };
    let stretch = |from: usize| {
        let slots = from..(from + size).min(count);
        let room = slots.len();
        Stretch { slots, ends: Vec::with_capacity(room), partner: Vec::with_capacity(4 * room) }
    };
    let mut stretches: Vec<Stretch> = (0..count).step_by(size).map(stretch).collect();
    crew.share(&mut stretches, &mut vec![(); crew.size()], |stretch, ()| {
        for slot in stretch.slots.clone() {
            partners_of(setting, state, grid, slot, skin, &images, &mut stretch.partner);
            stretch.ends.push(stretch.partner.len() as u32);
        }
    });
    let mut start = Vec::with_capacity(count + 1);
    start.push(0);
    let mut all = Vec::new();
    for Stretch { ends, partner, .. } in stretches {
        let base = all.len() as u32;
        start.extend(ends.iter().map(|end| base + end));
        if base == 0 { all = partner } else { all.extend_from_slice(&partner) }
    }
    all.shrink_to_fit();
    (start, all)
}

/// Adds the partners of the sphere in `slot`.
fn partners_of(
    setting: &Setting<'_>,
    state: &State,
    grid: &Grid,
    slot: usize,
    skin: f64,
    images: &Option<(Cell, f64)>,
    partner: &mut Vec<u32>,
) {
    let (balls, ball) = (&state.balls, &state.balls[slot]);
    let bonded = |other: usize| {
        setting.needs.bonds
            && state.bonds.holds(&setting.bonds, state.order[slot], state.order[other])
    };
    for level in &grid.levels[grid.level[slot] as usize..] {
        let reach = Vec3::repeat(ball.radius + level.reach + skin);
        level.runs(&(ball.place - reach), &(ball.place + reach), |from, to| {
            for other in from.max(slot as u32 + 1)..to {
                let there = &balls[other as usize];
                let range = ball.radius + there.radius + skin;
                let between = ball.place - there.place;
                let near = between.norm_squared() < range * range
                    && (images.is_none() || setting.shift(&between) == Vec3::zeros());
                if near && ball.body != there.body && !bonded(other as usize) {
                    partner.push(other);
                }
            }
        });
    }
    if let Some((cell, outside)) = images {
        from_images(setting, balls, grid, slot, skin, cell, *outside, partner);
    }
}

/// How far outside the box an image can lie that a sphere may touch, m.
fn reach_of_images(balls: &[Ball], cell: &Cell, skin: f64) -> f64 {
    let largest = balls.iter().map(|ball| ball.radius).fold(0.0, f64::max);
    let sticking_out = balls.iter().map(|ball| cell.home(&ball.place)).zip(balls);
    let farthest = sticking_out
        .filter(|(way, _)| *way != Vec3::zeros())
        .map(|(_, ball)| {
            let over = (cell.bounds.low - ball.place).sup(&(ball.place - cell.bounds.high));
            (0..3).filter(|a| cell.periodic[*a]).map(|a| over[a]).fold(0.0, f64::max)
        })
        .fold(0.0, f64::max);
    // Bodies that are nowhere are for the guard.
    let reach = 2.0 * largest + skin + farthest;
    if reach.is_finite() { reach.min(cell.bounds.size().max()) } else { 0.0 }
}

/// Adds the partners of the images of a sphere. A pair is met at its nearest image only, so
/// none is listed twice.
#[allow(clippy::too_many_arguments)] // what one sphere's search needs
fn from_images(
    setting: &Setting<'_>,
    balls: &[Ball],
    grid: &Grid,
    slot: usize,
    skin: f64,
    cell: &Cell,
    outside: f64,
    partner: &mut Vec<u32>,
) {
    let ball = &balls[slot];
    cell.images(&ball.place, outside, |way| {
        let image = ball.place + way;
        for level in &grid.levels[grid.level[slot] as usize..] {
            let reach = Vec3::repeat(ball.radius + level.reach + skin);
            let (low, high) = (image - reach, image + reach);
            if !level.meets(&low, &high) {
                continue;
            }
            level.runs(&low, &high, |from, to| {
                for other in from.max(slot as u32 + 1)..to {
                    let there = &balls[other as usize];
                    let range = ball.radius + there.radius + skin;
                    let near = (image - there.place).norm_squared() < range * range;
                    let nearest = || setting.shift(&(ball.place - there.place)) == way;
                    if near && nearest() && ball.body != there.body {
                        partner.push(other);
                    }
                }
            });
        }
    });
}

fn planes(setting: &Setting<'_>, state: &State, time: f64) -> (Vec<u32>, Vec<u32>) {
    let now = setting.planes_at(time);
    let skin = state.skin + 2.0 * state.sweep;
    listed(state, |ball, found| {
        for (index, plane) in now.iter().enumerate() {
            let distance = (ball.place - plane.point).dot(&plane.normal).abs();
            if distance < ball.radius + skin {
                found.push(index as u32);
            }
        }
    })
}

fn faces(setting: &Setting<'_>, state: &State, time: f64) -> (Vec<u32>, Vec<u32>) {
    let count = setting.surfaces.start.len();
    if count == 0 {
        return (vec![0; state.balls.len() + 1], Vec::new());
    }
    let mut now = Vec::new();
    faces_at(setting, time, &mut now);
    let largest = state.balls.iter().map(|ball| ball.radius).fold(0.0, f64::max);
    let skin = state.skin + 2.0 * state.sweep;
    let bins = Bins::new(&now, 2.0 * largest + skin, count + state.balls.len());
    listed(state, |ball, found| {
        let range = ball.radius + skin;
        bins.near(&ball.place, range, found);
        found.retain(|face| {
            let (point, _) = surface::closest(&ball.place, &now[*face as usize]);
            (point - ball.place).norm_squared() < range * range
        });
    })
}

/// Corners of triangle `face` at `time`, s.
pub fn face_at(setting: &Setting<'_>, face: usize, time: f64) -> [Vec3; 3] {
    let wall = setting.surfaces.wall[face] as usize;
    setting.surfaces.start[face].map(|corner| setting.wall_place(wall, &corner, time))
}

/// Corners of all triangles at `time`, s.
pub fn faces_at(setting: &Setting<'_>, time: f64, faces: &mut Vec<[Vec3; 3]>) {
    faces.clear();
    let walls = 0..setting.model.walls.len();
    let places: Vec<_> = walls.map(|wall| setting.wall_at(wall, time)).collect();
    let surfaces = &setting.surfaces;
    faces.extend(surfaces.start.iter().zip(&surfaces.wall).map(|(corners, wall)| {
        let place = &places[*wall as usize];
        corners.map(|corner| place(&corner))
    }));
}

/// A list of what `find` finds for each ball: where its entries begin, and all of them.
fn listed(state: &State, find: impl Fn(&Ball, &mut Vec<u32>)) -> (Vec<u32>, Vec<u32>) {
    let mut start = Vec::with_capacity(state.balls.len() + 1);
    let (mut partner, mut found) = (Vec::new(), Vec::new());
    start.push(0);
    for ball in &state.balls {
        found.clear();
        find(ball, &mut found);
        partner.extend_from_slice(&found);
        start.push(partner.len() as u32);
    }
    (start, partner)
}

/// Triangles sorted into cells by their bounding boxes.
struct Bins {
    low: Vec3,
    cell: f64,
    size: [usize; 3],
    start: Vec<u32>,
    faces: Vec<u32>,
}

impl Bins {
    fn new(faces: &[[Vec3; 3]], cell: f64, work: usize) -> Self {
        let corners = || faces.iter().flatten();
        let low = corners().fold(Vec3::repeat(f64::INFINITY), |low, p| low.inf(p));
        let high = corners().fold(Vec3::repeat(f64::NEG_INFINITY), |high, p| high.sup(p));
        let mut bins = Self { low, cell, size: [1; 3], start: Vec::new(), faces: Vec::new() };
        let most = 4.0 * work as f64 + 64.0;
        loop {
            let size: [f64; 3] =
                std::array::from_fn(|axis| ((high[axis] - low[axis]) / bins.cell).floor() + 1.0);
            if size.iter().product::<f64>() <= most {
                bins.size = size.map(|n| n as usize);
                break;
            }
            bins.cell *= 1.25;
        }
        let mut entries = Vec::new();
        for (index, [a, b, c]) in faces.iter().enumerate() {
            bins.cells(&a.inf(b).inf(c), &a.sup(b).sup(c), |cell| {
                entries.push((cell as u32, index as u32));
            });
        }
        entries.sort_unstable();
        bins.start = vec![0; bins.size.iter().product::<usize>() + 1];
        for (cell, _) in &entries {
            bins.start[*cell as usize + 1] += 1;
        }
        for cell in 1..bins.start.len() {
            bins.start[cell] += bins.start[cell - 1];
        }
        bins.faces = entries.into_iter().map(|entry| entry.1).collect();
        bins
    }

    fn cells(&self, low: &Vec3, high: &Vec3, mut visit: impl FnMut(usize)) {
        let along = |axis: usize, x: f64| {
            (((x - self.low[axis]) / self.cell) as usize).min(self.size[axis] - 1)
        };
        let from: [usize; 3] = std::array::from_fn(|axis| along(axis, low[axis]));
        let to: [usize; 3] = std::array::from_fn(|axis| along(axis, high[axis]));
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    visit(x + self.size[0] * (y + self.size[1] * z));
                }
            }
        }
    }

    /// Triangles whose cells the box of half-width `range` about `place` meets, rising.
    fn near(&self, place: &Vec3, range: f64, found: &mut Vec<u32>) {
        let reach = Vec3::repeat(range);
        self.cells(&(place - reach), &(place + reach), |cell| {
            let (from, to) = (self.start[cell] as usize, self.start[cell + 1] as usize);
            found.extend_from_slice(&self.faces[from..to]);
        });
        found.sort_unstable();
        found.dedup();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dem::test_scenes;

    #[test]
    fn lists_hold_every_near_pair_once_for_wide_sizes() {
        let model = test_scenes::wide_sizes(400, 30.0);
        let setting = Setting::new(&model);
        let mut state = State::new(&setting);
        rebuild(&setting, &mut state, &Crew::new(1));
        let mut listed = Vec::new();
        for slot in 0..state.balls.len() {
            for k in state.pairs.start[slot]..state.pairs.start[slot + 1] {
                let other = state.pairs.partner[k as usize];
                let (one, other) = (state.order[slot], state.order[other as usize]);
                listed.push(join(one.min(other), one.max(other)));
            }
        }
        listed.sort_unstable();
        let mut expected = Vec::new();
        for (a, first) in model.spheres.iter().enumerate() {
            for (b, second) in model.spheres.iter().enumerate().skip(a + 1) {
                let gap = (model.bodies[a].position - model.bodies[b].position).norm()
                    - first.radius
                    - second.radius;
                if gap < setting.skin {
                    expected.push(join(a as u32, b as u32));
                }
            }
        }
        assert!(expected.len() > 20);
        assert_eq!(listed, expected);
    }

    #[test]
    fn rebuilding_keeps_contacts() {
        let model = test_scenes::wide_sizes(200, 4.0);
        let setting = Setting::new(&model);
        let mut state = State::new(&setting);
        rebuild(&setting, &mut state, &Crew::new(1));
        for (k, touching) in state.pairs.book.touching.iter_mut().enumerate() {
            *touching = true;
            state.pairs.book.spring[k] = Vec3::new(k as f64 + 1.0, 0.5, -1.0);
        }
        // By the spheres' numbers, seen from the lower one.
        let named = |state: &State| {
            let mut named = Vec::new();
            for slot in 0..state.balls.len() {
                for k in state.pairs.start[slot] as usize..state.pairs.start[slot + 1] as usize {
                    let other = state.pairs.partner[k] as usize;
                    let (one, other) = (state.order[slot], state.order[other]);
                    let spring = state.pairs.book.spring[k];
                    if state.pairs.book.touching[k] {
                        let spring = if one < other { spring } else { -spring };
                        named.push((join(one.min(other), one.max(other)), spring));
                    }
                }
            }
            named.sort_unstable_by_key(|entry| entry.0);
            named
        };
        let before = named(&state);
        let shift = Vec3::new(3e-3, -2e-3, 1e-3);
        for ball in &mut state.balls {
            ball.place = -(ball.place + shift);
        }
        rebuild(&setting, &mut state, &Crew::new(1));
        assert_eq!(before, named(&state));
    }
}
