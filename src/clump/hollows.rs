//! Hollows in a set of spheres: found by their creases, filled by refinement or by a sphere of little use.
//!
//! No point of the surface sees a hollow that balls enclose, nor the bottom of a pocket between
//! them, and inner points are too coarse for small ones: it holds next to no volume, but lies far from
//! the surface of the solid. Every one has creases, where visible spheres meet; those that lie deep
//! inside, or what is before them, are to be covered. Thin hollows between many spheres only open
//! elsewhere then: one sphere is taken inside for them. What lowers the largest distance for little
//! stays. Cost: some refinements ([`super::refine`]) where there are hollows, else one look at all creases.

use super::refine::{Fit, Refiner, SWEEPS, one_piece};
use super::target::Target;
use crate::geometry::{Ball, Visible};
use crate::num::Vec3;

/// A hollow is deeper than this many times the largest distance of a surface point, and than this
/// share of the diameter.
const POCKET: f64 = 1.5;
const SHALLOW: f64 = 0.02;
/// Rounds of filling hollows, how deep their creases are to be covered, over the largest distance of
/// a surface point, and how much the mean square of the distances may rise for it.
const VOID_ROUNDS: usize = 2;
const VOID_DEPTH: f64 = 0.2;
const VOID_PRICE: f64 = 1.25;
/// What a crease counts for beside the deepest one, over its depth.
const EACH: f64 = 0.01;
/// Spheres that are taken inside at most, how many are tried for each, and the radius there over
/// the depth of the centre.
const PLUGS: usize = 2;
const PLUG_TRIALS: usize = 3;
const PLUG: f64 = 0.9;
/// `fit` without hollows deeper than `deep` [m], or as it was.
pub fn filled(refiner: &Refiner, fit: Fit, target: &Target, deep: f64) -> Fit {
    let surface = refiner.patches.normals.len();
    let largest = |fit: &Fit| fit.gaps[..surface].iter().fold(0.0, |a: f64, gap| a.max(gap.abs()));
    let rough = largest(&fit);
    let deep = deep.min(POCKET * rough).max(SHALLOW * target.diameter);
    let mut found = Hollows::new(&fit, rough, target, deep);
    let (mut best, mut extra) = (fit, Vec::new());
    let price = VOID_PRICE * best.cost;
    for round in 0..VOID_ROUNDS + PLUGS {
        if found.creases.is_empty() {
            break;
        }
        let trials = if round < VOID_ROUNDS {
            extra.extend_from_slice(&found.creases);
            covered(refiner, &best.balls, &extra, rough, target.diameter)
        } else {
            plugged(refiner, &best.balls, &found)
        };
        for trial in trials {
            let trial = refiner.assign(trial);
            let left = Hollows::new(&trial, largest(&trial), target, deep);
            let holds = one_piece(&trial.balls) || !one_piece(&best.balls);
            if left.badness < found.badness && trial.cost < price && holds {
                (best, found) = (trial, left);
            }
        }
    }
    best
}

/// Largest distance of a surface point or of a crease of the union from the other surface, m.
pub fn farthest(fit: &Fit, refiner: &Refiner, target: &Target) -> f64 {
    let gaps = &fit.gaps[..refiner.patches.normals.len()];
    let bare = gaps.iter().fold(0.0, |a: f64, gap| a.max(gap.abs()));
    let visible = Visible::new(&fit.balls);
    visible.creases().map(|(point, _)| target.distance.at(&point).abs()).fold(bare, f64::max)
}

/// Creases of the union that lie deeper inside the solid than they should.
struct Hollows {
    creases: Vec<Crease>,
    /// The largest distance of them and of the surface points, and a little for each, m.
    badness: f64,
}

#[derive(Clone, Copy)]
struct Crease {
    point: Vec3,
    /// Out of both spheres.
    way: Vec3,
    /// Depth inside the solid, m.
    depth: f64,
}

impl Hollows {
    fn new(fit: &Fit, largest: f64, target: &Target, deep: f64) -> Self {
        let creases: Vec<Crease> = Visible::new(&fit.balls)
            .creases()
            .map(|(point, way)| Crease { point, way, depth: -target.distance.at(&point) })
            .filter(|crease| crease.depth > deep)
            .collect();
        let deepest = creases.iter().map(|c| c.depth).fold(largest, f64::max);
        let sum: f64 = creases.iter().map(|c| c.depth).sum();
        Self { badness: deepest + EACH * sum, creases }
    }
}

/// Sets refined with creases, or points before them, that must be covered.
fn covered(
    refiner: &Refiner,
    balls: &[Ball],
    creases: &[Crease],
    rough: f64,
    diameter: f64,
) -> Vec<Vec<Ball>> {
    let before = |share: f64| creases.iter().map(move |c| c.point + c.way * (share * diameter));
    let with = |points: Vec<Vec3>, depth: f64| {
        let mut patches = refiner.patches.clone();
        patches.add_inner(points, depth);
        let with_voids = Refiner { patches: &patches, ..*refiner };
        with_voids.sweeps(with_voids.assign(balls.to_vec()), SWEEPS).balls
    };
    vec![
        with(before(0.0).collect(), VOID_DEPTH * rough),
        with(before(0.01).chain(before(0.03)).collect(), 0.0),
    ]
}

/// Refined sets with one of the spheres that would be missed least taken to where it covers most of
/// the hollows: about one of their creases, inside the solid.
fn plugged(refiner: &Refiner, balls: &[Ball], found: &Hollows) -> Vec<Vec<Ball>> {
    let covered = |ball: &Ball| -> f64 {
        let inside = |c: &&Crease| (c.point - ball.centre).norm() < ball.radius;
        found.creases.iter().filter(inside).map(|c| c.depth).sum()
    };
    let plugs = found.creases.iter().map(|c| {
        let ball = Ball { centre: c.point, radius: PLUG * c.depth };
        (covered(&ball), ball)
    });
    let Some((_, best)) = plugs.max_by(|a, b| a.0.total_cmp(&b.0)) else { return Vec::new() };
    let mut more = balls.to_vec();
    more.push(best);
    let losses = refiner.losses(&refiner.assign(more.clone()));
    let mut order: Vec<usize> = (0..balls.len()).collect();
    order.sort_by(|&a, &b| losses[a].total_cmp(&losses[b]).then(a.cmp(&b)));
    let without = |&least: &usize| {
        let mut balls = more.clone();
        balls.remove(least);
        refiner.sweeps(refiner.assign(balls), SWEEPS).balls
    };
    order.iter().take(PLUG_TRIALS).map(without).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clump::patches::Patches;
    use crate::clump::reproduce::tests::solid;
    use crate::geometry::samples::icosphere;

    #[test]
    fn a_hollow_between_spheres_is_filled() {
        let ball = solid("ball", icosphere(3));
        let target = Target::new(&ball).expect("closed");
        // Six along the axes and eight between them leave the middle free and close it off.
        let mut ways = vec![Vec3::x(), Vec3::y(), Vec3::z(), -Vec3::x(), -Vec3::y(), -Vec3::z()];
        ways.extend((0..8).map(|k| {
            let sign = |bit: u32| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
            Vec3::new(sign(0), sign(1), sign(2)).normalize()
        }));
        let balls: Vec<Ball> =
            ways.iter().map(|way| Ball { centre: way * 0.55, radius: 0.45 }).collect();
        let patches = Patches::new(&ball.mesh, 1500);
        let limit = &|centre: &Vec3| 0.1 - target.distance.at(centre);
        let refiner = Refiner {
            patches: &patches,
            scouts: &patches,
            power: 2.0,
            inner_weight: 1.0,
            smallest: 0.01,
            limit,
        };
        let fit = refiner.assign(balls);
        let cost = fit.cost;
        assert!(Visible::new(&fit.balls).at(&Vec3::zeros()) > 0.09);
        let filled = filled(&refiner, fit, &target, 0.4);
        let visible = Visible::new(&filled.balls);
        let deepest = |depth: f64, (point, _): (Vec3, Vec3)| depth.max(-target.distance.at(&point));
        assert!(visible.at(&Vec3::zeros()) < 0.0);
        assert!(visible.creases().fold(0.0, deepest) < 0.4);
        assert_eq!(filled.balls.len(), 14);
        assert!(filled.cost < VOID_PRICE * cost, "{} {cost}", filled.cost);
    }
}
