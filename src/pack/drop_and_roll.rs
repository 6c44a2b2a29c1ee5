//! Drop and roll (P2): grains fall one by one and roll down over those that lie there until
//! they rest in a hollow; or they stick where they touch first, with a probability.
//!
//! Sources: Visscher & Bolsterli 1972 (Nature 239, 504); Jodrey & Tory 1979 (Simulation 32, 1);
//! sticking at first touch: ballistic deposition (Vold 1959; Meakin & Jullien 1987, J. Phys. 48, 1651).
//!
//! The path is that of steepest descent: the direction is gravity projected on the cone of directions that lead into no
//! contact (n_k · v ≥ 0). Free fall onto balls is exact; rolling goes in steps of a tenth of the radius, each put back
//! onto its contacts by Newton's rule, the last one cut where the next contact begins. So any container serves.
//! A ball rests when gravity lies in the cone of its contacts: three in three dimensions, two in two,
//! or the floor; hence 6 (4) contacts a ball on average by construction. Level sides may repeat. Each ball rests for ever: no inertia, no
//! rearrangement, no friction. Clumps fall as their bounding spheres.
//!
//! Cost about 50 steps a ball, each with one search for near balls. Memory O(balls). A grain that finds the way in
//! blocked `tries` times is dropped. Small grains fall through gaps between others of more than 6.5 times their size.

use super::occupied::clump_radius;
use super::space::Space;
use super::{Grain, Laid, Turn, dress};
use crate::geometry::{Ball, BallGrid, Region};
use crate::num::random::{Stream, stream, uniform, whole};
use crate::num::{Fault, Job, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of drop and roll.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DropAndRoll {
    /// Probability that a grain stays where it touches first, 0 to 1: 0 rolls (dense), 1 sticks (fractal-like, very loose); default 0.
    pub sticking: f64,
    /// Places above the bed that are tried before a grain is dropped, 1 to 1 000 000; default 100.
    pub tries: u32,
    /// Which grains fall first; default `shuffled`.
    pub order: Order,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
}

/// Which grains fall first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// In random order: families are mixed.
    Shuffled,
    /// In the order of the list of grains: one family above the other.
    AsGiven,
}

impl Default for DropAndRoll {
    fn default() -> Self {
        Self { sticking: 0.0, tries: 100, order: Order::Shuffled, orientation: Turn::Random }
    }
}

/// Distance at which surfaces count as touching, in radii of the falling ball.
const TOUCH: f64 = 1e-9;
/// Steps of rolling before a ball is left where it is.
const STEPS: usize = 5000;

/// What the falling ball may touch.
#[derive(Clone, Copy)]
enum Partner {
    Ball(Ball),
    /// A side of a box: axis, and 1 for the low one, −1 for the high one.
    Side(usize, f64),
    /// The boundary of any other region.
    Boundary,
}

/// Settled balls.
struct Bed<'a> {
    space: Space<'a>,
    grid: BallGrid,
    balls: Vec<Ball>,
    largest: f64,
    /// Axis against gravity.
    up: usize,
    /// Highest point of any ball, m.
    top: f64,
}

impl DropAndRoll {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("sticking", self.sticking, 0.0, 1.0)?;
        Fault::within("tries", f64::from(self.tries), 1.0, 1e6)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let radii: Vec<f64> = grains.iter().map(clump_radius).collect();
        let space = Space::of(region);
        let (found, unsettled) = self.settle(space, &radii, seed, job);
        let mut why = match (job.is_cancelled(), found.len() == grains.len()) {
            (true, _) => "stopped before all had fallen".to_owned(),
            (_, true) => "all grains rest".to_owned(),
            (_, false) => {
                format!("ended full: no way in for the others in {} tries each", self.tries)
            }
        };
        if unsettled > 0 {
            why.push_str(&format!("; {unsettled} still rolled after {STEPS} steps"));
        }
        Ok(dress::laid(grains, &found, space.dimension, self.orientation, seed, &why))
    }

    /// Balls of `radii` (m) that came to rest, each with its number, and how many still rolled.
    pub fn settle(
        &self,
        space: Space,
        radii: &[f64],
        seed: u64,
        job: &Job,
    ) -> (Vec<(usize, Ball)>, usize) {
        let mut source = stream(seed, "pack.drop_and_roll", 0);
        let mut order: Vec<usize> = (0..radii.len()).collect();
        if self.order == Order::Shuffled {
            for i in (1..order.len()).rev() {
                order.swap(i, whole(&mut source, 0, i as u64) as usize);
            }
        }
        let smallest = radii.iter().copied().fold(f64::INFINITY, f64::min);
        let up = space.dimension - 1;
        let mut bed = Bed {
            grid: BallGrid::new(smallest),
            balls: Vec::new(),
            largest: 0.0,
            up,
            top: space.bounds.low[up],
            space,
        };
        let (mut found, mut unsettled) = (Vec::with_capacity(radii.len()), 0);
        for (done, &grain) in order.iter().enumerate() {
            if done % 256 == 0 {
                job.report("grains fallen", done as u64, radii.len() as u64);
                if job.is_cancelled() {
                    break;
                }
            }
            let Some(start) = bed.way_in(radii[grain], self.tries, &mut source) else { continue };
            let (centre, rests) = bed.fall(start, radii[grain], self.sticking, &mut source);
            unsettled += usize::from(!rests);
            bed.add(Ball { centre, radius: radii[grain] });
            found.push((grain, Ball { centre, radius: radii[grain] }));
        }
        (found, unsettled)
    }
}

impl Bed<'_> {
    fn add(&mut self, ball: Ball) {
        self.grid.insert(ball.centre, ball.radius);
        self.balls.push(ball);
        self.largest = self.largest.max(ball.radius);
        self.top = self.top.max(ball.centre[self.up] + ball.radius);
    }

    /// A free place above the bed; `None` if there is none in `tries` tries.
    fn way_in(&self, radius: f64, tries: u32, source: &mut Stream) -> Option<Vec3> {
        let bounds = self.space.bounds;
        let (floor, lid) = (bounds.low[self.up] + radius, bounds.high[self.up] - radius);
        let highest = lid.min(self.top + radius * (1.0 + 1e-6)).max(floor.min(lid));
        for _ in 0..tries {
            let mut centre = Vec3::zeros();
            for axis in (0..self.space.dimension).filter(|&axis| axis != self.up) {
                let off = if self.space.periodic[axis] { 0.0 } else { radius };
                centre[axis] = uniform(source, bounds.low[axis] + off, bounds.high[axis] - off);
            }
            centre[self.up] = highest;
            if self.space.region().is_some() {
                // From the lid down to where the ball has room.
                centre[self.up] = lid;
                while self.space.clearance(&centre) < radius && centre[self.up] > floor {
                    centre[self.up] -= 0.1 * radius;
                }
            }
            let free = self.space.clearance(&centre) >= radius * (1.0 - 1e-9)
                && !self.space.overlaps(&self.grid, &centre, radius, self.largest);
            if free {
                return Some(centre);
            }
        }
        None
    }

    /// Calls `visit` for all balls, or images of them, whose surface is nearer to `centre` than `reach`.
    fn near(&self, centre: &Vec3, reach: f64, mut visit: impl FnMut(Ball)) {
        self.space.images(centre, reach + self.largest, |image| {
            self.grid.near(image, reach, |number, _| {
                let Ball { centre: there, radius } = self.balls[number as usize];
                visit(Ball { centre: there + (centre - image), radius });
                true
            });
            true
        });
    }

    fn partners(&self, centre: &Vec3, reach: f64, list: &mut Vec<Partner>) {
        list.clear();
        self.near(centre, reach, |ball| list.push(Partner::Ball(ball)));
        if self.space.region().is_some() {
            list.push(Partner::Boundary);
            return;
        }
        for axis in (0..self.space.dimension).filter(|&axis| !self.space.periodic[axis]) {
            list.extend([Partner::Side(axis, 1.0), Partner::Side(axis, -1.0)]);
        }
    }

    fn gap(&self, partner: &Partner, centre: &Vec3, radius: f64) -> f64 {
        match partner {
            Partner::Ball(ball) => (centre - ball.centre).norm() - radius - ball.radius,
            Partner::Side(axis, sign) if *sign > 0.0 => {
                centre[*axis] - self.space.bounds.low[*axis] - radius
            }
            Partner::Side(axis, _) => self.space.bounds.high[*axis] - centre[*axis] - radius,
            Partner::Boundary => self.space.clearance(centre) - radius,
        }
    }

    fn normal(&self, partner: &Partner, centre: &Vec3, radius: f64) -> Vec3 {
        match partner {
            Partner::Ball(ball) => {
                (centre - ball.centre).try_normalize(0.0).unwrap_or_else(|| self.upwards())
            }
            Partner::Side(axis, sign) => {
                let mut normal = Vec3::zeros();
                normal[*axis] = *sign;
                normal
            }
            Partner::Boundary => {
                self.space.inward(centre, 1e-5 * radius).unwrap_or_else(|| self.upwards())
            }
        }
    }

    fn upwards(&self) -> Vec3 {
        let mut up = Vec3::zeros();
        up[self.up] = 1.0;
        up
    }

    /// Where a ball from `centre` comes to rest, and whether it did.
    fn fall(
        &self,
        mut centre: Vec3,
        radius: f64,
        sticking: f64,
        source: &mut Stream,
    ) -> (Vec3, bool) {
        let gravity = -self.upwards();
        let longest = 0.1 * radius;
        let (mut step, mut touched) = (longest, false);
        let mut near = Vec::new();
        for _ in 0..STEPS {
            centre = self.space.wrap(&centre);
            self.partners(&centre, radius + 4.0 * longest, &mut near);
            let contacts: Vec<(Partner, Vec3)> = near
                .iter()
                .filter(|partner| self.gap(partner, &centre, radius) <= TOUCH * radius)
                .map(|partner| (*partner, self.normal(partner, &centre, radius)))
                .collect();
            if !touched && !contacts.is_empty() && self.holds(&contacts) {
                touched = true;
                if uniform(source, 0.0, 1.0) < sticking {
                    return (centre, true);
                }
            }
            let normals: Vec<Vec3> = contacts.iter().map(|contact| contact.1).collect();
            let Some((way, held_by)) = descent(&gravity, &normals, self.space.dimension) else {
                return (centre, true);
            };
            if way.norm() < 1e-9 {
                if self.is_stable(&held_by, &contacts) {
                    return (centre, true);
                }
                // On the very top of a ball: any side will do that nothing is in the way of.
                let Some(aside) = self.nudge(&normals, source) else { return (centre, true) };
                centre += aside * (1e-8 * radius);
                continue;
            }
            let held: Vec<Partner> = held_by.iter().map(|&i| contacts[i].0).collect();
            if held.is_empty() {
                centre += gravity * self.free_fall(&centre, radius);
                step = longest;
                continue;
            }
            let next = self.roll(&centre, &(way / way.norm()), step, radius, &held, &near);
            if next[self.up] >= centre[self.up] - 1e-13 * radius {
                step *= 0.5;
                if step < 1e-8 * radius {
                    return (centre, true);
                }
                continue;
            }
            step = (2.0 * step).min(longest);
            centre = next;
        }
        (centre, false)
    }

    /// True if one of the contacts carries: it is met from above.
    fn holds(&self, contacts: &[(Partner, Vec3)]) -> bool {
        contacts.iter().any(|(_, normal)| normal[self.up] > 1e-9)
    }

    /// True if a ball held by these contacts does not roll off.
    fn is_stable(&self, held_by: &[usize], contacts: &[(Partner, Vec3)]) -> bool {
        let round = held_by.iter().all(|&i| matches!(contacts[i].0, Partner::Ball(_)));
        !round || held_by.len() >= self.space.dimension
    }

    /// A level direction that leads into none of the contacts, if one is found.
    fn nudge(&self, normals: &[Vec3], source: &mut Stream) -> Option<Vec3> {
        (0..40).find_map(|_| {
            let angle = uniform(source, 0.0, std::f64::consts::TAU);
            let aside = match self.space.dimension {
                2 => Vec3::new(if angle < std::f64::consts::PI { 1.0 } else { -1.0 }, 0.0, 0.0),
                _ => Vec3::new(angle.cos(), angle.sin(), 0.0),
            };
            normals.iter().all(|normal| normal.dot(&aside) >= -0.01).then_some(aside)
        })
    }

    /// How far the ball falls before it meets something new, at most some radii.
    fn free_fall(&self, centre: &Vec3, radius: f64) -> f64 {
        let mut fall = 2.0 * radius.max(self.largest);
        self.near(centre, radius + fall, |ball| {
            let apart = centre - ball.centre;
            let height = apart[self.up];
            let (aside, reach) =
                (apart.norm_squared() - height * height, (radius + ball.radius).powi(2));
            if height > 0.0 && aside < reach {
                fall = fall.min((height - (reach - aside).sqrt()).max(0.0));
            }
        });
        if self.space.region().is_none() {
            return fall.min((centre[self.up] - self.space.bounds.low[self.up] - radius).max(0.0));
        }
        let room = self.space.clearance(centre) - radius;
        // Along a wall the clearance says nothing about the way down, so the fall is felt for.
        let wall = room.max(0.1 * radius);
        if wall >= fall {
            return fall;
        }
        let below = |way: f64| {
            let mut p = *centre;
            p[self.up] -= way;
            self.space.clearance(&p) - radius
        };
        if below(wall) >= 0.0 {
            return wall.max(TOUCH * radius);
        }
        let (mut low, mut high) = (0.0, wall);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if below(middle) >= 0.0 { low = middle } else { high = middle }
        }
        low.max(1e-10 * radius)
    }

    /// One step along `way`, put back onto `held`, cut short where another contact begins.
    fn roll(
        &self,
        centre: &Vec3,
        way: &Vec3,
        step: f64,
        radius: f64,
        held: &[Partner],
        near: &[Partner],
    ) -> Vec3 {
        let at = |length: f64| self.put_back(centre + way * length, radius, held);
        let free = |place: &Vec3| {
            near.iter().all(|partner| self.gap(partner, place, radius) >= -0.5 * TOUCH * radius)
        };
        let end = at(step);
        if free(&end) {
            return end;
        }
        let (mut low, mut high, mut best) = (0.0, step, *centre);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let place = at(middle);
            if free(&place) {
                (low, best) = (middle, place);
            } else {
                high = middle;
            }
            if high - low < 1e-13 * radius {
                break;
            }
        }
        best
    }

    /// The nearest place that touches all of `held` (one or two).
    fn put_back(&self, mut centre: Vec3, radius: f64, held: &[Partner]) -> Vec3 {
        for _ in 0..12 {
            let gaps: Vec<f64> = held.iter().map(|p| self.gap(p, &centre, radius)).collect();
            if gaps.iter().all(|gap| gap.abs() < 1e-13 * radius) {
                break;
            }
            let normals: Vec<Vec3> = held.iter().map(|p| self.normal(p, &centre, radius)).collect();
            match (normals.as_slice(), gaps.as_slice()) {
                ([n], [gap]) => centre -= n * *gap,
                ([a, b, ..], [p, q, ..]) => {
                    let cosine = a.dot(b);
                    let size = 1.0 - cosine * cosine;
                    if size < 1e-12 {
                        return centre - a * *p;
                    }
                    centre -= a * ((p - cosine * q) / size) + b * ((q - cosine * p) / size);
                }
                _ => break,
            }
        }
        centre
    }
}

/// Gravity projected on the directions that lead into none of the contacts, and the contacts
/// that press; `None` if there is no such direction but 0 and gravity is held by all together.
fn descent(gravity: &Vec3, normals: &[Vec3], dimension: usize) -> Option<(Vec3, Vec<usize>)> {
    const EPSILON: f64 = 1e-9;
    let allowed = |way: &Vec3, but: &[usize]| {
        normals.iter().enumerate().all(|(k, n)| but.contains(&k) || n.dot(way) >= -EPSILON)
    };
    if allowed(gravity, &[]) {
        return Some((*gravity, Vec::new()));
    }
    for (i, n) in normals.iter().enumerate() {
        let press = -n.dot(gravity);
        let way = gravity + n * press;
        if press > 0.0 && allowed(&way, &[i]) {
            return Some((way, vec![i]));
        }
    }
    if dimension == 2 {
        return None;
    }
    for i in 0..normals.len() {
        for j in i + 1..normals.len() {
            let (a, b) = (&normals[i], &normals[j]);
            let Some(along) = a.cross(b).try_normalize(1e-9) else { continue };
            let way = along * along.dot(gravity);
            let (reaction, cosine) = (way - gravity, a.dot(b));
            let (p, q) = (reaction.dot(a), reaction.dot(b));
            let size = 1.0 - cosine * cosine;
            let (on_a, on_b) = ((p - cosine * q) / size, (q - cosine * p) / size);
            if on_a >= -EPSILON && on_b >= -EPSILON && allowed(&way, &[i, j]) {
                return Some((way, vec![i, j]));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::samples::{ball, brute_force, cylinder, of, room, sphere};
    use super::super::{Method, Packing, pack};
    use super::*;

    fn lay(count: usize, radius: f64, region: &Region, sticking: f64) -> (Packing, f64, f64) {
        let clumps = vec![sphere(radius, region.dimension()); count];
        let grains = of(&clumps);
        let method = Method::DropAndRoll(DropAndRoll { sticking, ..DropAndRoll::default() });
        let packing = pack(&grains, &[], region, &method, 1, &Job::quiet()).expect("right");
        let (gap, wall) = brute_force(&packing, &grains, region);
        (packing, gap / radius, wall / radius)
    }

    #[test]
    fn three_balls_in_a_corner_and_one_on_top() {
        let (packing, gap, wall) = lay(4, 0.05, &room(&[0.2, 0.2, 1.0]), 0.0);
        assert_eq!(packing.placements.len(), 4);
        assert!(gap > -1e-8 && wall > -1e-8, "{gap} {wall}");
        assert!(packing.placements.iter().all(|p| p.position.z < 0.16), "{packing:?}");
    }

    #[test]
    fn beds_rest_on_three_contacts_a_ball_in_containers_of_all_kinds() {
        let cases = [
            (room(&[1.0; 3]), 250, 0.06),
            (room(&[1.0; 2]), 250, 0.03),
            (cylinder(), 150, 0.07),
            (ball(), 60, 0.15),
        ];
        for (region, count, radius) in cases {
            let (packing, gap, wall) = lay(count, radius, &region, 0.0);
            assert!(gap > -1e-7 && wall > -1e-6, "{gap} {wall}");
            assert!(packing.placements.len() * 10 > count * 8, "{}", packing.outcome);
            assert!(!packing.outcome.contains("still rolled"), "{}", packing.outcome);
            // The lower half is full: nothing hangs in the air.
            let up = region.dimension() - 1;
            let lowest =
                packing.placements.iter().map(|p| p.position[up]).fold(f64::INFINITY, f64::min);
            assert!(lowest < region.bounds().low[up] + 2.5 * radius);
        }
    }

    #[test]
    fn sticking_is_loose() {
        let region = room(&[1.0, 4.0]);
        let height = |sticking| {
            let (packing, gap, _) = lay(300, 0.02, &region, sticking);
            assert!(gap > -1e-8, "{gap}");
            assert_eq!(packing.placements.len(), 300);
            packing.placements.iter().map(|p| p.position.y).fold(0.0, f64::max)
        };
        assert!(height(1.0) > 1.6 * height(0.0));
        assert!(DropAndRoll { sticking: 1.5, ..DropAndRoll::default() }.validate().is_err());
    }
}
