//! Forces at a distance and liquid bridges at mesh walls: which cells of a mesh (see
//! [`super::complex`]) are near a sphere, and the pass over them.
//!
//! The force of a cell goes along the way to its nearest point, as at a plane that far away. Liquid wets a
//! mesh triangle by triangle: what a sphere touches, and what hangs together with it over edges and corners nearer than
//! where a bridge breaks; it dries where the sphere is farther away than that. So a bridge goes with its
//! sphere over any edge, and in a hollow joint it wets the other side too, on touch or when it gets across
//! the edge; what that frees is counted as where bridges form. Potentials of bridges end at 0 where they
//! break, so wetting what comes within reach changes no energy.
//!
//! O(cells + spheres) to build, with those near each sphere; O(near cells + points of moving
//! meshes) a pass; 5 bytes a near cell. Cannot fail.

use super::Effect;
use super::complex::Complex;
use crate::dem::attraction::{self, Between};
use crate::dem::bins::Bins;
use crate::dem::law::Rule;
use crate::dem::setting::Setting;
use crate::dem::state::{Ball, State};
use crate::model::extra::PairForces;
use crate::num::Vec3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Liquid between a sphere and a cell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Liquid {
    /// Farther away than where a bridge breaks.
    #[default]
    Away,
    /// Near, but none.
    Dry,
    /// Part of a bridge.
    Wet,
}

/// Cells near each sphere of the model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Shores {
    /// Where the cells of each sphere begin; empty if no mesh acts at a distance.
    start: Vec<u32>,
    /// Their numbers, rising.
    cell: Vec<u32>,
    /// One a cell; empty without bridges.
    liquid: Vec<Liquid>,
}

/// A cell near a sphere.
struct Near<'a> {
    cell: u32,
    wall: usize,
    /// Nearest point, m.
    point: Vec3,
    /// From there to the sphere; 0 at its centre.
    normal: Vec3,
    between: Between,
    forces: &'a PairForces,
    /// Before and after this pass.
    liquid: [Liquid; 2],
}

impl<'a> Near<'a> {
    fn of(
        setting: &'a Setting<'_>,
        points: &[Vec3],
        ball: &Ball,
        cell: u32,
        liquid: Liquid,
    ) -> Self {
        let complex = &setting.extra.complex;
        let wall = complex.wall(cell);
        let point = complex.nearest(cell, points, &ball.place);
        let away = ball.place - point;
        let distance = away.norm();
        Self {
            cell,
            wall,
            point,
            normal: if distance > 0.0 { away / distance } else { Vec3::zeros() },
            between: Between {
                first: ball.radius,
                second: f64::INFINITY,
                gap: distance - ball.radius,
            },
            forces: setting.extra.at_mesh(ball.material, wall),
            liquid: [liquid; 2],
        }
    }

    /// Force, N, positive when pushing away.
    fn push(&self, complex: &Complex) -> f64 {
        let bridged = self.liquid[1] == Liquid::Wet;
        complex.weight(self.cell) * attraction::push(self.forces, &self.between, bridged)
    }

    /// Potential energy, J.
    fn energy(&self, complex: &Complex) -> f64 {
        let bridged = self.liquid[1] == Liquid::Wet;
        complex.weight(self.cell) * attraction::total(self.forces, &self.between, bridged).energy
    }

    /// Whether a bridge would reach that far.
    fn within(&self) -> bool {
        self.forces.bridge.is_some_and(|law| !law.breaks(self.between.gap))
    }

    /// Potential energy of a bridge, J.
    fn bridge(&self, complex: &Complex) -> f64 {
        let alone = PairForces { bridge: self.forces.bridge, ..PairForces::default() };
        complex.weight(self.cell) * attraction::total(&alone, &self.between, true).energy
    }
}

/// Distance from the centre of a sphere within which a wall acts, m.
fn range(setting: &Setting<'_>, ball: &Ball, wall: usize) -> f64 {
    let forces = setting.extra.at_mesh(ball.material, wall);
    if forces.is_empty() {
        return 0.0;
    }
    ball.radius + attraction::reach(forces, ball.radius, f64::INFINITY)
}

impl Shores {
    /// Finds all cells within reach until the next build; liquid stays.
    pub fn rebuild(&mut self, setting: &Setting<'_>, state: &State) {
        let complex = &setting.extra.complex;
        if complex.is_empty() {
            return;
        }
        let old = std::mem::take(self);
        let points = complex.points_at(setting, setting.pass_time(state.step));
        let corners: Vec<[Vec3; 3]> =
            (0..complex.len() as u32).map(|cell| complex.corners(cell, &points)).collect();
        let walls = 0..setting.model.walls.len();
        let farthest = |slot: usize| {
            let ranges = walls.clone().map(|wall| range(setting, &state.balls[slot], wall));
            ranges.fold(0.0, f64::max) + state.margin_at_walls(slot)
        };
        let largest = (0..state.balls.len()).map(&farthest).fold(f64::MIN_POSITIVE, f64::max);
        let bins = Bins::new(&corners, 2.0 * largest, complex.len() + state.balls.len());
        self.start.push(0);
        let mut near = Vec::new();
        for (number, slot) in state.slot.iter().enumerate() {
            let slot = *slot as usize;
            let (ball, margin) = (&state.balls[slot], state.margin_at_walls(slot));
            near.clear();
            bins.near(&ball.place, farthest(slot), &mut near);
            near.retain(|cell| {
                let reach = range(setting, ball, complex.wall(*cell));
                let way = complex.nearest(*cell, &points, &ball.place) - ball.place;
                reach > 0.0 && way.norm_squared() < (reach + margin).powi(2)
            });
            if setting.needs.bridges {
                let before = old.of(number);
                let cells = &old.cell[before.clone()];
                self.liquid.extend(near.iter().map(|cell| match cells.binary_search(cell) {
                    Ok(at) => old.liquid[before.start + at],
                    Err(_) => Liquid::Away,
                }));
            }
            self.cell.extend_from_slice(&near);
            self.start.push(self.cell.len() as u32);
        }
    }

    /// Entries of a sphere of the model.
    fn of(&self, number: usize) -> Range<usize> {
        match self.start.get(number..number + 2) {
            Some(ends) => ends[0] as usize..ends[1] as usize,
            None => 0..0,
        }
    }

    /// Calls `visit(slot, cells)` for every sphere with cells near it.
    fn each(
        &self,
        setting: &Setting<'_>,
        state: &State,
        time: f64,
        mut visit: impl FnMut(usize, &mut [Near<'_>]),
    ) {
        if self.cell.is_empty() {
            return;
        }
        let points = setting.extra.complex.points_at(setting, time);
        let mut near = Vec::new();
        for (number, slot) in state.slot.iter().enumerate() {
            let range = self.of(number);
            if range.is_empty() {
                continue;
            }
            let ball = &state.balls[*slot as usize];
            near.clear();
            near.extend(range.map(|k| {
                let liquid = self.liquid.get(k).copied().unwrap_or_default();
                Near::of(setting, &points, ball, self.cell[k], liquid)
            }));
            visit(*slot as usize, &mut near);
        }
    }
}

/// Potential energy at `time` [s] with the liquid of the last pass, J.
pub fn energy(setting: &Setting<'_>, state: &State, shores: &Shores, time: f64) -> f64 {
    let mut energy = 0.0;
    shores.each(setting, state, time, |_, near| {
        energy += near.iter().map(|n| n.energy(&setting.extra.complex)).sum::<f64>();
    });
    energy
}

/// Adds the forces of meshes at a distance.
pub fn pass(
    setting: &Setting<'_>,
    state: &State,
    rule: &Rule,
    shores: &mut Shores,
    effect: &mut Effect<'_>,
) {
    let complex = &setting.extra.complex;
    let mut after = Vec::with_capacity(shores.liquid.len());
    shores.each(setting, state, setting.pass_time(state.step), |slot, near| {
        if setting.needs.bridges {
            let freed = wet(complex, near);
            effect.tally.wetting += if rule.interval > 0.0 { freed } else { 0.0 };
            after.extend(near.iter().map(|n| n.liquid[1]));
        }
        for n in near.iter() {
            let push = n.push(complex);
            if push == 0.0 {
                continue;
            }
            let bridged = n.liquid[1] == Liquid::Wet;
            let slope =
                || complex.weight(n.cell) * attraction::slope(n.forces, &n.between, bridged);
            let velocity = setting.walls[n.wall].motion.velocity(&n.point);
            effect.at_wall(setting, (slot, n.wall), &n.normal, (push, slope), &velocity);
        }
    });
    shores.liquid = after;
}

/// Wets and dries the cells near a sphere; the energy that this frees, J.
fn wet(complex: &Complex, near: &mut [Near<'_>]) -> f64 {
    let mut any = false;
    for n in near.iter_mut() {
        n.liquid[1] = match (n.within(), n.liquid[0]) {
            (false, _) => Liquid::Away,
            (true, Liquid::Wet) if complex.is_triangle(n.cell) => Liquid::Wet,
            (true, _) => Liquid::Dry,
        };
        any |= n.liquid[1] != Liquid::Away;
    }
    if !any {
        return 0.0;
    }
    // What has just come within reach is wetted without a jump.
    spread(complex, near, |n| n.liquid[0] == Liquid::Away);
    let (mut touches, mut energy) = (false, 0.0);
    for n in near.iter_mut() {
        // Wet by going on, and by what follows.
        n.liquid[0] = n.liquid[1];
        if n.between.gap <= 0.0 && n.liquid[1] == Liquid::Dry && complex.is_triangle(n.cell) {
            (n.liquid[1], touches) = (Liquid::Wet, true);
        }
    }
    if spread(complex, near, |_| true) || touches {
        for n in near.iter().filter(|n| n.liquid[0] != n.liquid[1]) {
            energy += n.bridge(complex);
        }
    }
    -energy
}

/// Spreads liquid from wet triangles over near edges and corners to triangles that `may` be wetted; edges and corners
/// all of whose triangles are wet are wet. True if some triangle was wetted.
fn spread(complex: &Complex, near: &mut [Near<'_>], may: impl Fn(&Near<'_>) -> bool) -> bool {
    let ends = near.partition_point(|n| complex.is_triangle(n.cell));
    let (triangles, joints) = near.split_at_mut(ends);
    let mut some = false;
    loop {
        let mut more = false;
        for joint in joints.iter_mut().filter(|joint| joint.within()) {
            let around = complex.around(joint.cell);
            let at = |cell: &u32| triangles.binary_search_by_key(cell, |n| n.cell).ok();
            let is_wet = |t: &[Near<'_>], at: usize| t[at].liquid[1] == Liquid::Wet;
            let wet = around.iter().filter_map(at).filter(|at| is_wet(triangles, *at)).count();
            if wet > 0 && wet < around.len() {
                for cell in around {
                    let Ok(at) = triangles.binary_search_by_key(cell, |n| n.cell) else { continue };
                    if !is_wet(triangles, at) && triangles[at].within() && may(&triangles[at]) {
                        triangles[at].liquid[1] = Liquid::Wet;
                        more = true;
                    }
                }
            } else if wet == around.len() {
                joint.liquid[1] = Liquid::Wet;
            }
        }
        if !more {
            return some;
        }
        some = true;
    }
}
