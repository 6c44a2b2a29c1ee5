//! Which spheres hang together.

use crate::geometry::Ball;

/// Share of the smaller radius by which two spheres must overlap to count as joined.
pub const HOLD: f64 = 0.05;

/// The same for spheres that just touch: rounding cannot part them.
const TOUCH: f64 = 1e-9;

/// True if two spheres overlap enough to count as joined.
pub fn joined(a: &Ball, b: &Ball) -> bool {
    overlap_by(a, b, HOLD)
}

/// True if two spheres overlap by `share` of the smaller radius.
fn overlap_by(a: &Ball, b: &Ball, share: f64) -> bool {
    let reach = a.radius + b.radius - share * a.radius.min(b.radius);
    (a.centre - b.centre).norm_squared() <= reach * reach
}

/// True if all spheres hang together, were it by touching only.
#[cfg(test)]
pub fn touching(balls: &[Ball]) -> bool {
    label_by(balls, TOUCH).iter().all(|&piece| piece == 0)
}

/// Makes spheres hang together: the nearest two of two pieces grow by equal lengths until they touch.
/// O(n log n) where they do; O(n²) a gap.
pub fn glue(balls: &mut [Ball]) {
    loop {
        let label = label_by(balls, TOUCH);
        let mut nearest: Option<(f64, usize, usize)> = None;
        for (i, _) in label.iter().enumerate().filter(|(_, piece)| **piece == 0) {
            for (j, _) in label.iter().enumerate().filter(|(_, piece)| **piece != 0) {
                let gap =
                    (balls[i].centre - balls[j].centre).norm() - balls[i].radius - balls[j].radius;
                if nearest.is_none_or(|(least, ..)| gap < least) {
                    nearest = Some((gap, i, j));
                }
            }
        }
        let Some((gap, i, j)) = nearest else { return };
        // More than a touch, so that turning the clump does not part them by rounding.
        let by = 0.5 * gap.max(0.0) + 1e-6 * balls[i].radius.min(balls[j].radius);
        balls[i].radius += by;
        balls[j].radius += by;
    }
}

/// The piece with the greatest sum of r³, in the given order, and how many spheres were left out.
pub fn largest_piece(balls: Vec<Ball>) -> (Vec<Ball>, usize) {
    let label = label(&balls);
    let mut weight = vec![0.0; balls.len()];
    for (ball, &piece) in balls.iter().zip(&label) {
        weight[piece] += ball.radius.powi(3);
    }
    // The first of equals, so that the choice does not depend on rounding elsewhere.
    let mut best = 0;
    for (piece, &w) in weight.iter().enumerate() {
        if w > weight[best] {
            best = piece;
        }
    }
    let total = balls.len();
    let kept: Vec<Ball> = balls
        .into_iter()
        .zip(&label)
        .filter(|(_, piece)| **piece == best)
        .map(|(b, _)| b)
        .collect();
    let dropped = total - kept.len();
    (kept, dropped)
}

/// For every sphere the lowest index of its piece.
pub fn label(balls: &[Ball]) -> Vec<usize> {
    label_by(balls, HOLD)
}

/// For every sphere the lowest index of its piece, where pieces overlap by `share` of the smaller radius.
fn label_by(balls: &[Ball], share: f64) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..balls.len()).collect();
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    let mut order: Vec<usize> = (0..balls.len()).collect();
    let low = |i: usize| balls[i].centre.x - balls[i].radius;
    order.sort_by(|&i, &j| low(i).total_cmp(&low(j)).then(i.cmp(&j)));
    for (at, &i) in order.iter().enumerate() {
        let right = balls[i].centre.x + balls[i].radius;
        for &j in &order[at + 1..] {
            if low(j) > right {
                break;
            }
            if overlap_by(&balls[i], &balls[j], share) {
                let (a, b) = (root(&mut parent, i), root(&mut parent, j));
                parent[a.max(b)] = a.min(b);
            }
        }
    }
    (0..balls.len()).map(|i| root(&mut parent, i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Vec3;

    #[test]
    fn the_larger_piece_stays() {
        let ball = |x: f64, radius: f64| Ball { centre: Vec3::new(x, 0.0, 0.0), radius };
        let balls = vec![ball(0.0, 1.0), ball(1.5, 1.0), ball(5.0, 1.0), ball(3.0, 0.6)];
        let (kept, dropped) = largest_piece(balls.clone());
        assert_eq!((kept.len(), dropped), (3, 1));
        assert_eq!(label(&balls), vec![0, 0, 2, 0]);
        let mut glued = balls;
        glue(&mut glued);
        assert!(touching(&glued) && glued[0].radius == 1.0 && glued[1].radius == 1.0);
        let held = |at: usize, before: f64| (glued[at].radius - before).abs() < 1e-6;
        assert!(held(2, 1.0 + 0.2) && held(3, 0.6 + 0.2), "{glued:?}");
        // Touching is not enough to hold.
        assert!(!joined(&ball(0.0, 1.0), &ball(2.0, 1.0)));
    }
}
