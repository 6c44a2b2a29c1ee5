//! Verlet lists: which spheres, planes and triangles a sphere can touch before
//! the lists are built again.
//!
//! Each sphere looks at its own level of the [grid](super::grid) and at all coarser ones. A pair is listed while its gap
//! is below the sum of both leeways (see [`super::leeway`]), of two spheres or of a sphere and the walls; lists are
//! valid while no sphere and no wall has gone farther than its leeway.
//! Where contacts are looked for along the path of a step (`path_averaged`), the
//! gap may be larger by twice the way w of half a step, and a sphere must be within
//! its leeway and w of where it was at the build at both ends of the step.
//! In a periodic box bodies are brought home first, each sphere also looks from its images near
//! the other side, and a pair is listed at its nearest image only.
//! What contacts remember goes over to the new lists by the slots that spheres had before (see [`super::remembered`]).
//! O(N log N) time, O(N) memory; beside bodies and new lists there are only the touching entries
//! of the old ones. Cannot fail: positions that are not finite
//! land in some cell and are caught by the guard.

use super::bins::Bins;
use super::crew::Crew;
use super::grid::Grid;
use super::setting::Setting;
use super::state::{Ball, List, Load, State};
use super::{leeway, remembered, surface};
use crate::geometry::Cell;
use crate::model::Scheme;
use crate::num::Vec3;
use std::ops::Range;

/// Spheres whose partners a thread looks for at a time.
const STRETCH: usize = 512;

/// Builds all lists anew.
pub fn rebuild(setting: &Setting<'_>, state: &mut State, crew: &Crew) {
    let time = setting.pass_time(state.step);
    if state.rebuilds > 0 {
        leeway::renew(setting, state);
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
    let grid = Grid::new(&state.balls, &state.order, &state.leeway);
    permute(state, &grid);
    let old = [&mut state.pairs, &mut state.planes, &mut state.faces].map(std::mem::take);
    let [pairs_before, planes_before, faces_before] = old.map(List::touching);
    let (start, partner) = pairs(setting, state, &grid, crew);
    let from = grid.from;
    drop(grid.levels);
    let book = remembered::of_pairs(setting, pairs_before, (&start, &partner), &from);
    state.pairs = List { start, partner: partner.into(), book };
    let (start, partner) = planes(setting, state, time);
    let book = remembered::of_walls(setting, planes_before, (&start, &partner), &from);
    state.planes = List { start, partner: partner.into(), book };
    let (start, partner) = faces(setting, state, time);
    let book = remembered::of_walls(setting, faces_before, (&start, &partner), &from);
    state.faces = List { start, partner: partner.into(), book };
    state.loads.resize(spheres, Load::default());
    state.built = state.balls.iter().map(|ball| ball.place).collect();
    state.built_at = state.step;
    state.rebuilds += 1;
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
    pick(&mut state.leeway, &grid.from);
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
    let widest = state.widest();
    let images =
        setting.model.periodic.map(|cell| (cell, reach_of_images(&state.balls, &cell, widest)));
    let search = Search { setting, state, grid, widest, images };
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
            search.partners(slot, &mut stretch.partner);
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

/// What the search for partners needs to know.
struct Search<'a> {
    setting: &'a Setting<'a>,
    state: &'a State,
    grid: &'a Grid,
    /// Largest gap below which a pair may be listed, m.
    widest: f64,
    /// In a periodic box, and how far outside it images are looked for, m.
    images: Option<(Cell, f64)>,
}

impl Search<'_> {
    /// Radius and leeway of a sphere, m, and what the path of a step needs besides.
    fn own_reach(&self, slot: usize) -> f64 {
        let state = self.state;
        state.balls[slot].radius + f64::from(state.leeway[slot]) + 2.0 * state.sweep
    }

    /// Whether a pair whose centres are so far apart (m, squared) is to be listed.
    #[inline(always)]
    fn near(&self, slot: usize, other: usize, square: f64) -> bool {
        let state = self.state;
        let sum = state.balls[slot].radius + state.balls[other].radius;
        let most = sum + self.widest;
        // Most candidates are farther than any leeway reaches, which need not be read then.
        square < most * most && {
            let range = sum + state.margin_of(slot, other);
            square < range * range
        }
    }

    /// Adds the partners of the sphere in `slot`.
    fn partners(&self, slot: usize, partner: &mut Vec<u32>) {
        let Self { setting, state, grid, images, .. } = self;
        let (balls, ball) = (&state.balls, &state.balls[slot]);
        let bonded = |other: usize| {
            setting.needs.bonds
                && state.bonds.holds(&setting.bonds, state.order[slot], state.order[other])
        };
        for level in &grid.levels[grid.level[slot] as usize..] {
            let reach = Vec3::repeat(self.own_reach(slot) + level.reach);
            level.runs(&(ball.place - reach), &(ball.place + reach), |from, to| {
                for other in from.max(slot as u32 + 1)..to {
                    let there = &balls[other as usize];
                    let between = ball.place - there.place;
                    let near = self.near(slot, other as usize, between.norm_squared())
                        && (images.is_none() || setting.shift(&between) == Vec3::zeros());
                    if near && ball.body != there.body && !bonded(other as usize) {
                        partner.push(other);
                    }
                }
            });
        }
        if let Some((cell, outside)) = images {
            cell.images(&ball.place, *outside, |way| self.partners_of_image(slot, way, partner));
        }
    }

    /// Adds the partners of the image of a sphere that lies `way` from it. A pair is met at its nearest image only, so
    /// none is listed twice.
    fn partners_of_image(&self, slot: usize, way: Vec3, partner: &mut Vec<u32>) {
        let Self { setting, state, grid, .. } = self;
        let (balls, ball) = (&state.balls, &state.balls[slot]);
        let image = ball.place + way;
        for level in &grid.levels[grid.level[slot] as usize..] {
            let reach = Vec3::repeat(self.own_reach(slot) + level.reach);
            let (low, high) = (image - reach, image + reach);
            if !level.meets(&low, &high) {
                continue;
            }
            level.runs(&low, &high, |from, to| {
                for other in from.max(slot as u32 + 1)..to {
                    let there = &balls[other as usize];
                    let square = (image - there.place).norm_squared();
                    let near = self.near(slot, other as usize, square);
                    let nearest = || setting.shift(&(ball.place - there.place)) == way;
                    if near && nearest() && ball.body != there.body {
                        partner.push(other);
                    }
                }
            });
        }
    }
}

/// How far outside the box an image can lie that a sphere may touch, m.
fn reach_of_images(balls: &[Ball], cell: &Cell, widest: f64) -> f64 {
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
    let reach = 2.0 * largest + widest + farthest;
    if reach.is_finite() { reach.min(cell.bounds.size().max()) } else { 0.0 }
}

fn planes(setting: &Setting<'_>, state: &State, time: f64) -> (Vec<u32>, Vec<u32>) {
    let now = setting.planes_at(time);
    listed(state, |slot, ball, found| {
        let range = ball.radius + state.margin_at_walls(slot);
        for (index, plane) in now.iter().enumerate() {
            let distance = (ball.place - plane.point).dot(&plane.normal).abs();
            if distance < range {
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
    let bins = Bins::new(&now, 2.0 * largest + state.widest(), count + state.balls.len());
    listed(state, |slot, ball, found| {
        let range = ball.radius + state.margin_at_walls(slot);
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
fn listed(state: &State, find: impl Fn(usize, &Ball, &mut Vec<u32>)) -> (Vec<u32>, Vec<u32>) {
    let mut start = Vec::with_capacity(state.balls.len() + 1);
    let (mut partner, mut found) = (Vec::new(), Vec::new());
    start.push(0);
    for (slot, ball) in state.balls.iter().enumerate() {
        found.clear();
        find(slot, ball, &mut found);
        partner.extend_from_slice(&found);
        start.push(partner.len() as u32);
    }
    (start, partner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dem::grid::join;
    use crate::dem::setting::FIRST_SKIN;
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
                if gap < FIRST_SKIN * setting.median_radius {
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
            state.pairs.book.spring.put(k, Vec3::new(k as f64 + 1.0, 0.5, -1.0));
        }
        // By the spheres' numbers, seen from the lower one.
        let named = |state: &State| {
            let mut named = Vec::new();
            for slot in 0..state.balls.len() {
                for k in state.pairs.start[slot] as usize..state.pairs.start[slot + 1] as usize {
                    let other = state.pairs.partner[k] as usize;
                    let (one, other) = (state.order[slot], state.order[other]);
                    let spring = state.pairs.book.spring.at(k);
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
