//! From balls that a method has found to grains that lie there.
//!
//! Methods that make their own sizes put the largest grain into the largest
//! ball, and so on: every grain is scaled so that its bounding sphere is the
//! ball. Methods that keep sizes give each grain its own ball. What happened to the wanted sizes is
//! said in one clause. O(n log n).

use super::occupied::{clump_radius, placement};
use super::{Grain, Laid, Turn};
use crate::geometry::Ball;
use crate::num::Vec3;
use crate::num::random::stream;
use crate::num::statistics::median;

/// Grains in `balls`, largest in largest; grains left over are dropped.
pub fn by_rank(
    grains: &[Grain],
    balls: &[Ball],
    dimension: usize,
    turn: Turn,
    seed: u64,
    why: &str,
) -> Laid {
    let wanted: Vec<f64> = grains.iter().map(clump_radius).collect();
    let falling = |radii: &dyn Fn(usize) -> f64, count: usize| {
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| radii(b).total_cmp(&radii(a)).then(a.cmp(&b)));
        order
    };
    let grain_order = falling(&|i| wanted[i], wanted.len());
    let ball_order = falling(&|i| balls[i].radius, balls.len());
    let pairs: Vec<(usize, Ball)> =
        grain_order.iter().zip(&ball_order).map(|(&g, &b)| (g, balls[b])).collect();
    laid(grains, &pairs, dimension, turn, seed, why)
}

/// Grain `balls[i].0` in ball `balls[i].1`; grains without a ball are dropped.
pub fn laid(
    grains: &[Grain],
    balls: &[(usize, Ball)],
    dimension: usize,
    turn: Turn,
    seed: u64,
    why: &str,
) -> Laid {
    let mut placements = Vec::with_capacity(balls.len());
    let mut is_placed = vec![false; grains.len()];
    for &(grain, ball) in balls {
        is_placed[grain] = true;
        let mut source = stream(seed, "pack.turn", grain as u64);
        let turned = turn.draw(&grains[grain], dimension, &mut source);
        let mut laid = placement(grain, (ball.centre, turned), Vec3::zeros());
        let scale = ball.radius / clump_radius(&grains[grain]);
        // Rounding alone is no change of size.
        laid.scale = if (scale - 1.0).abs() < 1e-12 { 1.0 } else { scale };
        placements.push(laid);
    }
    let dropped: Vec<u32> =
        (0..grains.len() as u32).filter(|&grain| !is_placed[grain as usize]).collect();
    let without = match dropped.len() {
        0 => String::new(),
        count => format!(", {count} without a place"),
    };
    let outcome = format!(
        "{why}; placed {} of {} grains{without}; {}{}",
        placements.len(),
        grains.len(),
        sizes(&placements.iter().map(|laid| laid.scale).collect::<Vec<_>>()),
        clumps(grains),
    );
    Laid { placements, dropped, outcome }
}

/// "sizes as wanted", or how much they were changed.
fn sizes(scales: &[f64]) -> String {
    let low = scales.iter().copied().fold(f64::INFINITY, f64::min);
    let high = scales.iter().copied().fold(0.0, f64::max);
    match median(scales) {
        None => "no sizes".to_owned(),
        Some(_) if low == 1.0 && high == 1.0 => "sizes as wanted".to_owned(),
        Some(_) if high - low < 1e-9 * high => format!("all sizes times {low:.6}"),
        Some(middle) => {
            format!(
                "sizes are the method's own: {low:.4e} to {high:.4e} times those wanted, median {middle:.4e}"
            )
        }
    }
}

fn clumps(grains: &[Grain]) -> &'static str {
    match grains.iter().any(|grain| grain.clump.balls.len() > 1) {
        true => "; clumps were packed as their bounding spheres",
        false => "",
    }
}
