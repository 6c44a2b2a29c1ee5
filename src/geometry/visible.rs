//! The visible surface of a union of balls: exact distance to it, points spread over it.
//!
//! The surface is made of sphere patches, of arcs where two spheres meet and of
//! the corners where those arcs end. Seen from outside the union the nearest
//! point lies on the nearest ball; from inside it is the radial projection on
//! some ball (where no other ball hides it), the nearest point of a visible arc,
//! or the end of one. All of them are tried, nearest bounds first refused.
//!
//! Set-up O(n·k²) for n balls with k neighbours each, a query O(n + arcs).

use super::arcs::Cover;
use super::{Ball, SurfacePoint};
use crate::num::Vec3;
use crate::num::random::{Stream, direction, uniform};
use std::f64::consts::{PI, TAU};

/// A union of balls, ready for questions about its surface.
pub struct Visible {
    balls: Vec<Ball>,
    /// Balls that meet ball `i`, without those that lie inside it.
    neighbours: Vec<Vec<u32>>,
    exposed: Vec<bool>,
    rings: Vec<Ring>,
}

/// The circle where two spheres meet, with its visible arcs.
struct Ring {
    centre: Vec3,
    radius: f64,
    normal: Vec3,
    u: Vec3,
    v: Vec3,
    free: Vec<(f64, f64)>,
}

/// A point counts as hidden by a ball when it lies deeper than this share of the radius.
const ON_SURFACE: f64 = 1e-10;

impl Visible {
    /// Finds which parts of which balls can be seen.
    pub fn new(balls: &[Ball]) -> Self {
        let neighbours = meet(balls);
        let mut visible = Self {
            balls: balls.to_vec(),
            exposed: neighbours.iter().map(Vec::is_empty).collect(),
            neighbours,
            rings: Vec::new(),
        };
        let mut cover = Cover::default();
        // A ball inside another has that other in its list and not the other way round.
        let listed = |i: usize, j: u32| visible.neighbours[j as usize].contains(&(i as u32));
        let whole: Vec<bool> =
            (0..balls.len()).map(|i| visible.neighbours[i].iter().all(|&j| listed(i, j))).collect();
        for i in (0..balls.len()).filter(|&i| whole[i]) {
            for j in visible.neighbours[i].clone() {
                if (j as usize) < i || !whole[j as usize] {
                    continue;
                }
                if let Some(ring) = visible.ring(i, j as usize, &mut cover) {
                    visible.exposed[i] = true;
                    visible.exposed[j as usize] = true;
                    visible.rings.push(ring);
                }
            }
        }
        visible
    }

    /// The circle of balls `i` and `j`, if any of it can be seen.
    fn ring(&self, i: usize, j: usize, cover: &mut Cover) -> Option<Ring> {
        let (a, b) = (&self.balls[i], &self.balls[j]);
        let along = b.centre - a.centre;
        let distance = along.norm();
        let normal = along / distance;
        let height = (distance - (b.radius - a.radius) * (b.radius + a.radius) / distance) / 2.0;
        let square = a.radius * a.radius - height * height;
        if square <= 0.0 {
            return None;
        }
        let radius = square.sqrt();
        let centre = a.centre + normal * height;
        let u = normal.cross(&across(&normal)).normalize();
        let v = normal.cross(&u);
        cover.clear();
        for &k in self.neighbours[i].iter().filter(|&&k| k as usize != j) {
            let other = &self.balls[k as usize];
            let w = centre - other.centre;
            let (wu, wv) = (w.dot(&u), w.dot(&v));
            let swing = 2.0 * radius * wu.hypot(wv);
            // Inside where swing·cos(θ − φ) < room.
            let room = other.radius * other.radius - w.norm_squared() - square;
            if room >= swing {
                return None;
            }
            if room > -swing {
                cover.cover(wv.atan2(wu) + PI, PI - (room / swing).acos());
            }
        }
        let mut free = Vec::new();
        cover.each_free(|from, to| free.push((from, to)));
        (!free.is_empty()).then_some(Ring { centre, radius, normal, u, v, free })
    }

    /// Signed distance of `point` to the visible surface, m; negative inside the union;
    /// infinite for no balls.
    pub fn at(&self, point: &Vec3) -> f64 {
        let outside = self
            .balls
            .iter()
            .map(|ball| (point - ball.centre).norm() - ball.radius)
            .fold(f64::INFINITY, f64::min);
        if outside >= 0.0 { outside } else { -self.depth(point) }
    }

    /// Distance from an inner point to the visible surface.
    fn depth(&self, point: &Vec3) -> f64 {
        let mut best = f64::INFINITY;
        for (i, ball) in self.balls.iter().enumerate() {
            let offset = point - ball.centre;
            let length = offset.norm();
            let gap = (length - ball.radius).abs();
            if !self.exposed[i] || gap >= best {
                continue;
            }
            let toward = if length > 0.0 { offset / length } else { Vec3::x() };
            if self.seen(i, &(ball.centre + toward * ball.radius)) {
                best = gap;
            }
        }
        let mut square = best * best;
        for ring in &self.rings {
            let w = point - ring.centre;
            let height = w.dot(&ring.normal);
            if height * height < square {
                square = square.min(ring.square_distance(&w, height, square));
            }
        }
        square.sqrt()
    }

    /// True if a point of sphere `i` lies inside no other ball.
    fn seen(&self, i: usize, point: &Vec3) -> bool {
        self.neighbours[i].iter().all(|&j| {
            let other = &self.balls[j as usize];
            (point - other.centre).norm_squared() >= (other.radius * (1.0 - ON_SURFACE)).powi(2)
        })
    }

    /// About `count` points spread evenly over the visible surface, each standing
    /// for an equal area; their areas sum to an estimate of the visible area.
    pub fn sample(&self, count: usize, stream: &mut Stream) -> Vec<SurfacePoint> {
        let whole: f64 = self.balls.iter().map(|b| b.radius * b.radius * 4.0 * PI).sum();
        if count == 0 || whole <= 0.0 {
            return Vec::new();
        }
        // A first, thin round says what share of all spheres can be seen.
        let pilot = self.spread(whole / (count as f64).min(2000.0), stream);
        let seen: f64 = pilot.iter().map(|p| p.area).sum();
        if seen <= 0.0 {
            return pilot;
        }
        self.spread(seen / count as f64, stream)
    }

    /// Points of a turned spiral on every exposed ball, each for the area `share`.
    fn spread(&self, share: f64, stream: &mut Stream) -> Vec<SurfacePoint> {
        const GOLDEN: f64 = 2.399_963_229_728_653;
        let mut points = Vec::new();
        for (i, ball) in self.balls.iter().enumerate() {
            let (pole, phase) = (direction(stream), uniform(stream, 0.0, TAU));
            let wanted = 4.0 * PI * ball.radius * ball.radius / share;
            // Rounded at random, so that small balls are not always short of points.
            let number = (wanted + uniform(stream, 0.0, 1.0)).floor() as usize;
            if !self.exposed[i] {
                continue;
            }
            let u = pole.cross(&across(&pole)).normalize();
            let v = pole.cross(&u);
            for k in 0..number {
                let z = 1.0 - (2 * k + 1) as f64 / number as f64;
                let (s, c) = (phase + GOLDEN * k as f64).sin_cos();
                let normal = pole * z + (u * c + v * s) * (1.0 - z * z).sqrt();
                let point = ball.centre + normal * ball.radius;
                if self.seen(i, &point) {
                    points.push(SurfacePoint { point, normal, area: share });
                }
            }
        }
        points
    }
}

impl Ring {
    /// Squared distance to the visible arcs of a point at `w` from the centre,
    /// `height` above the plane; any number above `limit` when it is beyond that.
    fn square_distance(&self, w: &Vec3, height: f64, limit: f64) -> f64 {
        let (x, y) = (w.dot(&self.u), w.dot(&self.v));
        let reach = x.hypot(y);
        let nearest = height * height + (reach - self.radius).powi(2);
        if nearest >= limit {
            return f64::INFINITY;
        }
        let angle = y.atan2(x).rem_euclid(TAU);
        if self.free.iter().any(|&(from, to)| (from..=to).contains(&angle)) {
            return nearest;
        }
        let closest = self
            .free
            .iter()
            .flat_map(|&(from, to)| [from, to])
            .map(|end| (angle - end).cos())
            .fold(-1.0, f64::max);
        nearest + 2.0 * self.radius * reach * (1.0 - closest)
    }
}

/// A unit vector that is not parallel to `axis`.
fn across(axis: &Vec3) -> Vec3 {
    let mut unit = Vec3::zeros();
    unit[axis.iamin()] = 1.0;
    unit
}

/// For every ball the others that hide a part of it. Of two equal balls the later
/// one has the earlier in its list and not the other way round.
fn meet(balls: &[Ball]) -> Vec<Vec<u32>> {
    let mut order: Vec<usize> = (0..balls.len()).collect();
    order.sort_by(|&i, &j| {
        let low = |k: usize| balls[k].centre.x - balls[k].radius;
        low(i).total_cmp(&low(j)).then(i.cmp(&j))
    });
    let mut lists = vec![Vec::new(); balls.len()];
    for (at, &i) in order.iter().enumerate() {
        let right = balls[i].centre.x + balls[i].radius;
        for &j in &order[at + 1..] {
            let (a, b) = (&balls[i], &balls[j]);
            if b.centre.x - b.radius > right {
                break;
            }
            let square = (a.centre - b.centre).norm_squared();
            if square >= (a.radius + b.radius).powi(2) {
                continue;
            }
            let inside = square <= (a.radius - b.radius).powi(2);
            // Which of the two is hidden whole, if one is.
            let i_inside = inside && (a.radius < b.radius || (a.radius == b.radius && i > j));
            if !inside || i_inside {
                lists[i].push(j as u32);
            }
            if !inside || !i_inside {
                lists[j].push(i as u32);
            }
        }
    }
    for list in &mut lists {
        list.sort_unstable();
    }
    lists
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::stream;

    fn cloud(source: &mut Stream, count: usize) -> Vec<Ball> {
        (0..count)
            .map(|_| {
                let centre = Vec3::from_fn(|_, _| uniform(source, -1.0, 1.0));
                Ball { centre, radius: uniform(source, 0.2, 0.8) }
            })
            .collect()
    }

    #[test]
    fn two_balls_have_their_closed_forms() {
        let pair = [-0.5, 0.5].map(|x| Ball { centre: Vec3::new(x, 0.0, 0.0), radius: 1.0 });
        let visible = Visible::new(&pair);
        // Each sphere loses a cap of height 1/2: visible area 2 · 2π(2 − 1/2).
        let points = visible.sample(20_000, &mut stream(31, "visible", 0));
        let area: f64 = points.iter().map(|p| p.area).sum();
        assert!((area / (6.0 * PI) - 1.0).abs() < 3e-3, "{area}");
        assert!((points.len() as f64 / 20_000.0 - 1.0).abs() < 0.05);
        // The middle is nearest to the circle where the spheres meet.
        assert!((visible.at(&Vec3::zeros()) + 0.75f64.sqrt()).abs() < 1e-12);
        assert!((visible.at(&Vec3::new(3.0, 0.0, 0.0)) - 1.5).abs() < 1e-12);
        assert!((visible.at(&Vec3::new(-0.7, 0.0, 0.0)) + 0.8).abs() < 1e-12);
    }

    #[test]
    fn distance_agrees_with_a_dense_sample_of_the_surface() {
        let mut source = stream(32, "visible", 0);
        for count in [1, 3, 12] {
            let balls = cloud(&mut source, count);
            let visible = Visible::new(&balls);
            let points = visible.sample(20_000, &mut source);
            for point in &points {
                assert!(visible.at(&point.point).abs() < 1e-9);
            }
            for _ in 0..100 {
                let p = Vec3::from_fn(|_, _| uniform(&mut source, -1.2, 1.2));
                let sampled =
                    points.iter().map(|s| (s.point - p).norm()).fold(f64::INFINITY, f64::min);
                let exact = visible.at(&p);
                let inside = balls.iter().any(|b| (p - b.centre).norm() < b.radius);
                assert_eq!(exact < 0.0, inside);
                // The sample is a subset of the surface, 0.03 apart at most.
                assert!(exact.abs() <= sampled + 1e-9, "{exact} {sampled}");
                assert!(sampled <= exact.abs() + 0.06, "{exact} {sampled}");
            }
        }
    }

    #[test]
    fn hidden_and_doubled_balls_change_nothing() {
        let mut balls = cloud(&mut stream(33, "visible", 0), 5);
        let p = Vec3::new(0.1, 0.2, -0.1);
        let before = Visible::new(&balls).at(&p);
        balls.push(balls[0]);
        balls.push(Ball { centre: balls[1].centre, radius: balls[1].radius * 0.5 });
        let visible = Visible::new(&balls);
        assert!((visible.at(&p) - before).abs() < 1e-12);
        assert!(!visible.exposed[6] && !visible.exposed[5]);
        assert_eq!(Visible::new(&[]).at(&p), f64::INFINITY);
    }
}
