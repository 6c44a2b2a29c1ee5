//! The visible surface of a union of balls: exact distance to it, points spread over it.
//!
//! The surface is made of sphere patches, of arcs where two spheres meet and of
//! the corners where those arcs end. Seen from outside the union the nearest
//! point lies on the nearest ball; from inside it is the radial projection on
//! some ball (where no other ball hides it), the nearest point of a visible arc,
//! or the end of one. All of them are tried, from the
//! point's own x outwards until no nearer one can follow.
//!
//! Set-up O(n·k²) for n balls with k neighbours each; a query looks at the balls and
//! arcs whose x is within the distance found plus the largest radius.

use super::arcs::Cover;
use super::{Ball, SurfacePoint};
use crate::num::Vec3;
use crate::num::random::{Stream, direction, uniform};
use std::f64::consts::{PI, TAU};

/// A union of balls, ready for questions about its surface.
pub struct Visible {
    /// In rising order of x.
    balls: Vec<Ball>,
    balls_x: Vec<f64>,
    widest: f64,
    /// Balls whose spheres cut sphere `i`; empty for a ball inside another.
    neighbours: Vec<Vec<u32>>,
    exposed: Vec<bool>,
    /// In rising order of x.
    rings: Vec<Ring>,
    rings_x: Vec<f64>,
    /// Largest radius of a ring.
    widest_ring: f64,
    /// Rings on every ball.
    rings_of: Vec<Vec<u32>>,
}

/// The circle where two spheres meet, with its visible arcs.
struct Ring {
    centre: Vec3,
    radius: f64,
    normal: Vec3,
    u: Vec3,
    v: Vec3,
    free: Vec<(f64, f64)>,
    /// The two balls that meet in it.
    balls: [u32; 2],
}

/// A point counts as hidden by a ball when it lies deeper than this share of the radius.
const ON_SURFACE: f64 = 1e-10;

impl Visible {
    /// Finds which parts of which balls can be seen.
    pub fn new(balls: &[Ball]) -> Self {
        let mut balls = balls.to_vec();
        balls.sort_by(|a, b| a.centre.x.total_cmp(&b.centre.x));
        let neighbours = meet(&balls);
        let mut visible = Self {
            balls_x: balls.iter().map(|b| b.centre.x).collect(),
            widest: balls.iter().map(|b| b.radius).fold(0.0, f64::max),
            exposed: neighbours
                .iter()
                .map(|list| matches!(list, Some(l) if l.is_empty()))
                .collect(),
            neighbours: neighbours.into_iter().map(Option::unwrap_or_default).collect(),
            balls,
            rings: Vec::new(),
            rings_x: Vec::new(),
            widest_ring: 0.0,
            rings_of: Vec::new(),
        };
        let mut cover = Cover::default();
        for i in 0..visible.balls.len() {
            for j in visible.neighbours[i].clone() {
                if (j as usize) < i {
                    continue;
                }
                if let Some(ring) = visible.ring(i, j as usize, &mut cover) {
                    visible.exposed[i] = true;
                    visible.exposed[j as usize] = true;
                    visible.rings.push(ring);
                }
            }
        }
        visible.rings.sort_by(|a, b| a.centre.x.total_cmp(&b.centre.x));
        visible.rings_x = visible.rings.iter().map(|ring| ring.centre.x).collect();
        visible.widest_ring = visible.rings.iter().map(|ring| ring.radius).fold(0.0, f64::max);
        visible.rings_of = vec![Vec::new(); visible.balls.len()];
        for (number, ring) in visible.rings.iter().enumerate() {
            ring.balls.iter().for_each(|&k| visible.rings_of[k as usize].push(number as u32));
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
        let balls = [i as u32, j as u32];
        (!free.is_empty()).then_some(Ring { centre, radius, normal, u, v, free, balls })
    }

    /// Signed distance of `point` to the visible surface, m; negative inside the union;
    /// infinite for no balls.
    pub fn at(&self, point: &Vec3) -> f64 {
        let mut outside = f64::INFINITY;
        outward(&self.balls_x, point.x, |i| {
            let ball = &self.balls[i];
            outside = outside.min((point - ball.centre).norm() - ball.radius);
            // One ball around the point is enough to know that it is inside.
            if outside < 0.0 { f64::NEG_INFINITY } else { outside + self.widest }
        });
        if outside >= 0.0 { outside } else { -self.depth(point) }
    }

    /// Distance from an inner point to the visible surface.
    fn depth(&self, point: &Vec3) -> f64 {
        // Nothing can be seen nearer than the surface of the ball that holds the point
        // deepest; mostly the nearest point of that one is seen, and the search is over.
        let (mut deepest, mut least) = (None, 0.0);
        for (i, ball) in self.balls.iter().enumerate() {
            let inside = ball.radius - (point - ball.centre).norm();
            if inside > least {
                (deepest, least) = (Some(i), inside);
            }
        }
        let mut best = f64::INFINITY;
        if let Some(i) = deepest {
            if self.exposed[i] && self.seen(i, &self.projected(i, point)) {
                return least;
            }
            // The arcs of that ball lie near and bound what follows.
            let mut square = f64::INFINITY;
            for &ring in &self.rings_of[i] {
                square = self.rings[ring as usize].nearer(point, square);
            }
            best = square.sqrt();
        }
        outward(&self.balls_x, point.x, |i| {
            let ball = &self.balls[i];
            let gap = ((point - ball.centre).norm() - ball.radius).abs();
            if gap < best && self.exposed[i] && self.seen(i, &self.projected(i, point)) {
                best = gap;
            }
            best + self.widest
        });
        let mut square = best * best;
        outward(&self.rings_x, point.x, |i| {
            square = self.rings[i].nearer(point, square);
            square.sqrt() + self.widest_ring
        });
        square.sqrt()
    }

    /// The point of sphere `i` nearest to `point`.
    fn projected(&self, i: usize, point: &Vec3) -> Vec3 {
        let ball = &self.balls[i];
        let offset = point - ball.centre;
        let length = offset.norm();
        ball.centre + if length > 0.0 { offset / length } else { Vec3::x() } * ball.radius
    }

    /// True if a point of sphere `i` lies inside no other ball.
    fn seen(&self, i: usize, point: &Vec3) -> bool {
        self.neighbours[i].iter().all(|&j| {
            let other = &self.balls[j as usize];
            (point - other.centre).norm_squared() >= (other.radius * (1.0 - ON_SURFACE)).powi(2)
        })
    }

    /// Points of all visible arcs where two spheres meet, their ends included, at most a ninth of a
    /// turn apart, each with a direction that leads out of both spheres (zero where there is
    /// none). Every hollow that balls enclose has some.
    pub fn creases(&self) -> impl Iterator<Item = (Vec3, Vec3)> + '_ {
        self.rings.iter().flat_map(move |ring| {
            ring.free.iter().flat_map(move |&(from, to)| {
                let parts = ((to - from) / (TAU / 9.0)).ceil().max(1.0);
                (0..=parts as u32).map(move |k| {
                    let (s, c) = (from + (to - from) * f64::from(k) / parts).sin_cos();
                    let point = ring.centre + (ring.u * c + ring.v * s) * ring.radius;
                    let out = |k: u32| {
                        let ball = &self.balls[k as usize];
                        (point - ball.centre) / ball.radius
                    };
                    let way = out(ring.balls[0]) + out(ring.balls[1]);
                    (point, way.try_normalize(1e-9).unwrap_or_else(Vec3::zeros))
                })
            })
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
    /// The least of `square` and the squared distance of `point` to the visible arcs.
    fn nearer(&self, point: &Vec3, square: f64) -> f64 {
        let w = point - self.centre;
        let height = w.dot(&self.normal);
        if height * height >= square {
            return square;
        }
        square.min(self.square_distance(&w, height, square))
    }

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

/// Visits the indices of `keys`, which rise, from the one nearest to `at` outwards, as
/// long as they are no farther than what the last visit returned.
fn outward(keys: &[f64], at: f64, mut visit: impl FnMut(usize) -> f64) {
    let mut high = keys.partition_point(|&key| key < at);
    let mut low = high;
    let mut reach = f64::INFINITY;
    loop {
        let below = if low > 0 { at - keys[low - 1] } else { f64::INFINITY };
        let above = if high < keys.len() { keys[high] - at } else { f64::INFINITY };
        if below.min(above) > reach || (low == 0 && high == keys.len()) {
            return;
        }
        let index = if below <= above {
            low -= 1;
            low
        } else {
            high += 1;
            high - 1
        };
        reach = visit(index);
    }
}

/// A unit vector that is not parallel to `axis`.
fn across(axis: &Vec3) -> Vec3 {
    let mut unit = Vec3::zeros();
    unit[axis.iamin()] = 1.0;
    unit
}

/// For every ball, in rising order of x, the others whose spheres cut its sphere; `None`
/// for a ball inside another one (of two equal balls the later), which nobody lists.
fn meet(balls: &[Ball]) -> Vec<Option<Vec<u32>>> {
    let widest = balls.iter().map(|b| b.radius).fold(0.0, f64::max);
    let mut pairs = Vec::new();
    let mut inside = vec![false; balls.len()];
    for (i, a) in balls.iter().enumerate() {
        let right = a.centre.x + a.radius + widest;
        for (j, b) in balls.iter().enumerate().skip(i + 1) {
            if b.centre.x > right {
                break;
            }
            let square = (a.centre - b.centre).norm_squared();
            if square >= (a.radius + b.radius).powi(2) {
                continue;
            }
            if square > (a.radius - b.radius).powi(2) {
                pairs.push((i, j));
            } else {
                inside[if a.radius < b.radius { i } else { j }] = true;
            }
        }
    }
    let mut lists: Vec<Option<Vec<u32>>> =
        inside.iter().map(|&inside| (!inside).then(Vec::new)).collect();
    for (i, j) in pairs.into_iter().filter(|&(i, j)| !inside[i] && !inside[j]) {
        for (of, other) in [(i, j), (j, i)] {
            if let Some(list) = &mut lists[of] {
                list.push(other as u32);
            }
        }
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
    fn creases_lie_where_spheres_meet_and_point_out() {
        let balls = cloud(&mut stream(35, "visible", 0), 12);
        let visible = Visible::new(&balls);
        assert!(visible.creases().count() > 40);
        for (point, _) in visible.creases() {
            let on = |b: &&Ball| ((point - b.centre).norm() - b.radius).abs() < 1e-7;
            assert!(visible.at(&point).abs() < 1e-7 && balls.iter().filter(on).count() >= 2);
        }
        let pair = [-0.5, 0.5].map(|x| Ball { centre: Vec3::new(x, 0.0, 0.0), radius: 1.0 });
        let visible = Visible::new(&pair);
        assert_eq!(visible.creases().count(), 10);
        for (point, way) in visible.creases() {
            assert!(point.x.abs() < 1e-12 && way.x.abs() < 1e-12);
            assert!((visible.at(&(point + way * 0.1)) - 0.1).abs() < 0.02);
        }
    }

    #[test]
    fn hidden_and_doubled_balls_change_nothing() {
        let mut balls = cloud(&mut stream(33, "visible", 0), 5);
        let p = Vec3::new(0.1, 0.2, -0.1);
        let visible = Visible::new(&balls);
        let hidden = visible.exposed.iter().filter(|&&e| !e).count();
        let before = visible.at(&p);
        balls.push(balls[0]);
        balls.push(Ball { centre: balls[1].centre, radius: balls[1].radius * 0.5 });
        let visible = Visible::new(&balls);
        assert!((visible.at(&p) - before).abs() < 1e-12);
        assert_eq!(visible.exposed.iter().filter(|&&e| !e).count(), 2 + hidden);
        assert_eq!(Visible::new(&[]).at(&p), f64::INFINITY);
    }
}
