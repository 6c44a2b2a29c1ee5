//! Refinement of all centres and radii of a set of spheres against a surface.
//!
//! Least over centres c_k and radii r_k of Σ_i |f_i|^p over even surface points x_i, with
//! f_i = min_k (|x_i − c_k| − r_k): the distance of the point from the union where it lies
//! outside, minus the depth below the deepest sphere where it lies inside. Inner points count
//! with max(f_i + m, 0), so that no void opens; m is the depth to which they are to be covered. Every point belongs to the sphere of its least
//! value; the Gauss–Newton system then falls apart in one of 4 × 4 a sphere: rows −(u, 1),
//! u the unit vector from the centre to the point, weights |f|^(p−2) (iteratively reweighted
//! least squares), damped after Levenberg and Marquardt. Then points change hands (Lloyd's
//! alternation, as in the variational sphere sets of Wang et al. 2006, here with distances
//! instead of outside volumes).
//!
//! A sphere that would hardly be missed is from time to time taken to where a candidate
//! lowers the sum most; the change stays if the refined set is better.
//!
//! Cost O(N·G + 10·M) a sweep for N spheres, M points in G groups. Ends after the sweeps it
//! is given with the best set seen that hangs together; never with a worse one than it got.

use super::cover::Gaps;
use super::patches::Patches;
use super::pieces;
use crate::geometry::Ball;
use crate::num::Vec3;
use nalgebra::{Matrix4, Vector4};

/// Weight of an inner point that no sphere covers.
const VOID: f64 = 50.0;
/// Trials in a row without success before relocation ends.
const PATIENCE: usize = 5;
/// Sweeps of a full and of a trial refinement.
pub(super) const SWEEPS: usize = 40;
pub(super) const TRIAL_SWEEPS: usize = 10;
/// An improvement by less than this share is none.
const WORTH: f64 = 1e-3;

/// Room in the lists of spheres near a group, over the largest radius of a group.
const MARGIN: f64 = 0.3;

/// For every group the spheres that can be the nearest or the second to one of its points, as
/// long as no sphere has changed by more than half the margin since.
struct Lists {
    margin: f64,
    balls: Vec<Ball>,
    near: Vec<u32>,
    starts: Vec<usize>,
}

impl Lists {
    fn new(patches: &Patches, balls: &[Ball], margin: f64) -> Self {
        let mut reach = vec![0.0; balls.len()];
        let (mut near, mut starts) = (Vec::new(), vec![0]);
        for group in &patches.groups {
            for (ball, reach) in balls.iter().zip(&mut reach) {
                *reach = (group.centre - ball.centre).norm() - ball.radius;
            }
            // The two least values at the centre bound those of every point of the group.
            let (mut least, mut second) = (f64::INFINITY, f64::INFINITY);
            for &reach in &reach {
                second = second.min(least.max(reach));
                least = least.min(reach);
            }
            let second = if second.is_finite() { second } else { least };
            let limit = second + 2.0 * group.radius + margin;
            near.extend((0..balls.len() as u32).filter(|&k| reach[k as usize] <= limit));
            starts.push(near.len());
        }
        Self { margin, balls: balls.to_vec(), near, starts }
    }

    fn of(&self, group: usize) -> &[u32] {
        &self.near[self.starts[group]..self.starts[group + 1]]
    }

    fn hold(&self, balls: &[Ball]) -> bool {
        let moved =
            |(a, b): (&Ball, &Ball)| (a.centre - b.centre).norm() + (a.radius - b.radius).abs();
        self.balls.len() == balls.len()
            && self.balls.iter().zip(balls).map(moved).all(|moved| 2.0 * moved <= self.margin)
    }
}

/// What is minimised, and within which limits.
pub struct Refiner<'a> {
    /// Points of the solid.
    pub patches: &'a Patches,
    /// Fewer of them, where candidates are compared.
    pub scouts: &'a Patches,
    /// p.
    pub power: f64,
    /// Weight of surface points inside a sphere over that of points outside.
    pub inner_weight: f64,
    /// Least radius, m.
    pub smallest: f64,
    /// Largest radius that a sphere with this centre may have, m; between two centres it
    /// must not change by more than their distance.
    pub limit: &'a dyn Fn(&Vec3) -> f64,
}

/// Spheres with what the points say of them.
#[derive(Clone)]
pub struct Fit {
    /// Spheres.
    pub balls: Vec<Ball>,
    /// f of every point, m.
    pub gaps: Vec<f64>,
    /// Sphere of every point.
    owners: Vec<u32>,
    /// f of every point without its sphere, m.
    seconds: Vec<f64>,
    /// Lower bounds of the limit of every sphere, m; −∞ where nothing is known.
    limits: Vec<f64>,
    /// Weighted mean |f|^p.
    pub cost: f64,
}

impl Refiner<'_> {
    /// Gives every point to its sphere. There must be a sphere.
    pub fn assign(&self, balls: Vec<Ball>) -> Fit {
        let mut lists = Lists::new(self.patches, &balls, 0.0);
        self.assign_by(balls, &mut lists)
    }

    /// As [`Self::assign`], with lists that may be used again while the spheres move little.
    fn assign_by(&self, balls: Vec<Ball>, lists: &mut Lists) -> Fit {
        if !lists.hold(&balls) {
            *lists = Lists::new(self.patches, &balls, lists.margin);
        }
        let count = self.patches.points.len();
        let mut fit = Fit {
            limits: vec![f64::NEG_INFINITY; balls.len()],
            balls,
            gaps: vec![f64::INFINITY; count],
            owners: vec![0; count],
            seconds: vec![f64::INFINITY; count],
            cost: 0.0,
        };
        for (at, group) in self.patches.groups.iter().enumerate() {
            let range = group.first..group.end;
            let (first, second) = (&mut fit.gaps[range.clone()], &mut fit.seconds[range.clone()]);
            let owner = &mut fit.owners[range.clone()];
            let [x, y, z] = self.patches.along(range);
            for &k in lists.of(at) {
                let Ball { centre, radius } = fit.balls[k as usize];
                // Without a branch, so that several points are dealt with at once.
                for i in 0..first.len() {
                    let (u, v, w) = (x[i] - centre.x, y[i] - centre.y, z[i] - centre.z);
                    let gap = (u * u + v * v + w * w).sqrt() - radius;
                    let (old, is_less) = (first[i], gap < first[i]);
                    second[i] = second[i].min(if is_less { old } else { gap });
                    owner[i] = if is_less { k } else { owner[i] };
                    first[i] = if is_less { gap } else { old };
                }
            }
            for i in group.first..group.end {
                fit.gaps[i] = group.gap(fit.gaps[i]);
                fit.seconds[i] = group.gap(fit.seconds[i]);
                fit.cost += self.weight(i, fit.gaps[i]) * self.raised(fit.gaps[i]);
            }
        }
        fit.cost /= self.patches.normals.len() as f64;
        fit
    }

    fn weight(&self, point: usize, gap: f64) -> f64 {
        if point >= self.patches.normals.len() {
            VOID
        } else if gap < 0.0 {
            self.inner_weight
        } else {
            1.0
        }
    }

    fn raised(&self, gap: f64) -> f64 {
        if self.power == 2.0 { gap * gap } else { gap.abs().powf(self.power) }
    }

    /// One damped Gauss–Newton step of every sphere against its own points, and new bounds of
    /// their limits.
    fn step(&self, fit: &Fit, damping: f64) -> (Vec<Ball>, Vec<f64>) {
        let mut matrices = vec![Matrix4::<f64>::zeros(); fit.balls.len()];
        let mut sides = vec![Vector4::<f64>::zeros(); fit.balls.len()];
        // Where |f| is far below its mean, |f|^(p−2) is unbounded or of no weight.
        let floor = fit.cost.powf(1.0 / self.power) * 1e-2;
        for (i, &k) in fit.owners.iter().enumerate() {
            let gap = fit.gaps[i];
            let is_covered = i >= self.patches.normals.len() && gap <= 0.0;
            let k = k as usize;
            let offset = self.patches.points[i] - fit.balls[k].centre;
            let length = offset.norm();
            if is_covered || length <= 0.0 {
                continue;
            }
            let u = offset / length;
            let row = Vector4::new(u.x, u.y, u.z, 1.0);
            let curve =
                if self.power == 2.0 { 1.0 } else { gap.abs().max(floor).powf(self.power - 2.0) };
            let weight = self.weight(i, gap) * curve;
            matrices[k] += row * row.transpose() * weight;
            sides[k] += row * (weight * gap);
        }
        let newton = 1.0 / (self.power - 1.0).max(1.0);
        fit.balls
            .iter()
            .zip(&fit.limits)
            .zip(matrices.iter().zip(&sides))
            .map(|((ball, &limit), (matrix, side))| {
                let scale = matrix.trace() / 4.0;
                let damped = matrix + Matrix4::identity() * (scale * damping);
                let Some(solved) = damped.cholesky() else { return (*ball, limit) };
                let mut change = solved.solve(side) * newton;
                let most = 0.5 * ball.radius;
                let length = change.norm();
                if length > most {
                    change *= most / length;
                }
                let centre = ball.centre + change.xyz();
                let asked = ball.radius + change.w;
                // Like a distance, the limit changes by no more than the centre moves.
                let bound = limit - change.xyz().norm();
                let limit_here = if asked <= bound { bound } else { (self.limit)(&centre) };
                let radius = asked.min(limit_here);
                if radius.is_finite() && radius >= self.smallest {
                    (Ball { centre, radius }, limit_here)
                } else {
                    (*ball, limit)
                }
            })
            .unzip()
    }

    /// At most `sweeps` sweeps; the best set seen that hangs together, or what was given.
    pub fn sweeps(&self, fit: Fit, sweeps: usize) -> Fit {
        let mut held = fit.balls.clone();
        let mut fit = fit;
        let mut damping = 1e-2;
        let mut idle = 0;
        let mut is_held = true;
        let typical = self.patches.groups.iter().map(|g| g.radius).fold(0.0, f64::max);
        let mut lists = Lists::new(self.patches, &fit.balls, MARGIN * typical);
        for _ in 0..sweeps {
            let (balls, limits) = self.step(&fit, damping);
            let next = Fit { limits, ..self.assign_by(balls, &mut lists) };
            if next.cost < fit.cost {
                idle = if next.cost > fit.cost * (1.0 - WORTH) { idle + 1 } else { 0 };
                fit = next;
                damping = (damping * 0.5).max(1e-4);
                is_held = one_piece(&fit.balls);
                if is_held {
                    held.clone_from(&fit.balls);
                }
            } else {
                damping *= 4.0;
            }
            if idle > 3 || damping > 1e2 {
                break;
            }
        }
        if is_held { fit } else { self.assign(held) }
    }

    /// What the cost would rise by without each sphere.
    pub fn losses(&self, fit: &Fit) -> Vec<f64> {
        let mut losses = vec![0.0; fit.balls.len()];
        for (i, &k) in fit.owners.iter().enumerate() {
            let (first, second) = (fit.gaps[i], fit.seconds[i]);
            losses[k as usize] += self.weight(i, second) * self.raised(second)
                - self.weight(i, first) * self.raised(first);
        }
        losses
    }

    /// Takes spheres of little use to better places, `trials` times at most, several at once
    /// where there are many, each trial refined by at most `sweeps` sweeps.
    pub fn relocate(&self, mut fit: Fit, candidates: &[Ball], trials: usize, sweeps: usize) -> Fit {
        let (mut passed, mut failed) = (0, 0);
        for _ in 0..trials {
            let count = fit.balls.len();
            let together = (count / 16).max(1);
            if failed >= PATIENCE || count < 2 || passed + together > count {
                break;
            }
            let losses = self.losses(&fit);
            let mut order: Vec<usize> = (0..count).collect();
            order.sort_by(|&a, &b| losses[a].total_cmp(&losses[b]).then(a.cmp(&b)));
            let leave = &order[passed..passed + together];
            let mut balls: Vec<Ball> =
                (0..count).filter(|k| !leave.contains(k)).map(|k| fit.balls[k]).collect();
            self.insert(&mut balls, candidates, together);
            let trial = self.sweeps(self.assign(balls), sweeps);
            let holds = one_piece(&trial.balls) || !one_piece(&fit.balls);
            if trial.cost < fit.cost * (1.0 - WORTH) && holds {
                fit = trial;
                (passed, failed) = (0, 0);
            } else {
                passed += together;
                failed += 1;
            }
        }
        fit
    }

    /// Adds the `count` candidates that lower the sum of squares most, one after the other.
    fn insert(&self, balls: &mut Vec<Ball>, candidates: &[Ball], count: usize) {
        let scouts = Refiner { patches: self.scouts, ..*self };
        let mut gaps = Gaps::new(self.scouts, scouts.assign(balls.clone()).gaps);
        // Gains hardly ever rise: one that was less than the best when last looked at still is.
        let mut gains: Vec<f64> =
            candidates.iter().map(|ball| gaps.gain(self.scouts, ball)).collect();
        for _ in 0..count {
            let mut fresh = vec![false; candidates.len()];
            let best = loop {
                let best = gains.iter().enumerate().fold((0.0, None), |best, (k, &gain)| {
                    if gain > best.0 { (gain, Some(k)) } else { best }
                });
                match best.1 {
                    Some(k) if !fresh[k] => {
                        gains[k] = gaps.gain(self.scouts, &candidates[k]);
                        fresh[k] = true;
                    }
                    other => break other,
                }
            };
            let Some(best) = best else { break };
            gaps.add(self.scouts, &candidates[best]);
            balls.push(candidates[best]);
        }
    }
}

/// True if the spheres hang together.
pub fn one_piece(balls: &[Ball]) -> bool {
    pieces::label(balls).iter().all(|&piece| piece == 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clump::cover;
    use crate::geometry::samples::{icosphere, l_mesh, random_star};

    fn refiner(patches: &Patches, power: f64) -> Refiner<'_> {
        let limit = &|_: &Vec3| f64::INFINITY;
        Refiner { patches, scouts: patches, power, inner_weight: 1.0, smallest: 0.01, limit }
    }

    #[test]
    fn one_sphere_finds_the_ball_from_far_off() {
        let off = Vec3::new(3.0, -2.0, 1.0);
        let patches = Patches::new(&icosphere(3).mapped(|v| v * 0.7 + off), 800);
        for power in [1.5, 2.0, 4.0] {
            let refiner = refiner(&patches, power);
            let start = Ball { centre: off + Vec3::new(0.2, 0.1, -0.3), radius: 0.3 };
            let fit = refiner.sweeps(refiner.assign(vec![start]), 60);
            let ball = fit.balls[0];
            // The mesh lies up to 0.6 % of the radius inside the ball.
            assert!((ball.centre - off).norm() < 2e-3, "{power} {ball:?}");
            assert!((ball.radius - 0.7).abs() < 6e-3, "{power} {ball:?}");
        }
    }

    #[test]
    fn gaps_and_owners_are_those_of_brute_force() {
        let mut patches = Patches::new(&random_star(4, 0.5), 1200);
        patches.add_inner((0..40).map(|i| Vec3::repeat(0.01 * f64::from(i))).collect(), 0.0);
        let candidates = cover::candidates(&patches, 1, 0.01, 0.02, 2.0);
        let balls = cover::greedy(&patches, &candidates, Vec::new(), 25);
        let fit = refiner(&patches, 2.0).assign(balls);
        for (i, point) in patches.points.iter().enumerate() {
            let mut gaps: Vec<f64> =
                fit.balls.iter().map(|b| (point - b.centre).norm() - b.radius).collect();
            let owner = fit.owners[i] as usize;
            let own = gaps[owner];
            gaps.sort_by(f64::total_cmp);
            assert_eq!(own, gaps[0]);
            let least = if i < 1200 { f64::NEG_INFINITY } else { 0.0 };
            assert_eq!((fit.gaps[i], fit.seconds[i]), (gaps[0].max(least), gaps[1].max(least)));
        }
    }

    #[test]
    fn refinement_never_makes_worse_and_keeps_one_piece() {
        for mesh in [l_mesh(), random_star(6, 0.6)] {
            let patches = Patches::new(&mesh, 1500);
            let candidates = cover::candidates(&patches, 2, 0.02, 0.02, 2.0);
            for count in [2, 9, 40] {
                let refiner = refiner(&patches, 2.0);
                let start = refiner.assign(cover::greedy(&patches, &candidates, Vec::new(), count));
                let first = start.cost;
                let fit = refiner.sweeps(start, 30);
                assert!(fit.cost < 0.7 * first, "{count}: {first} {}", fit.cost);
                assert!(one_piece(&fit.balls));
                let second = fit.cost;
                let fit = refiner.relocate(fit, &candidates, 6, 8);
                assert!(fit.cost <= second && one_piece(&fit.balls));
            }
        }
    }
}
