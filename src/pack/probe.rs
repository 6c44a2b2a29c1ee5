//! Measuring spheres (circles in two dimensions) and layers: where they are, what they share with
//! balls and with the lines along which contacts carry forces.

use crate::geometry::{Bounds, shared};
use crate::num::Vec3;

/// A part of space that is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Probe {
    /// A measuring sphere, or circle.
    Ball {
        /// Its middle, m.
        at: Vec3,
        /// Its radius, m.
        radius: f64,
    },
    /// A box along the axes; in two dimensions its z does not count.
    Box(Bounds),
}

impl Probe {
    /// Volume inside `room`, m³ (m²).
    pub fn volume(&self, room: &Bounds, dimension: usize) -> f64 {
        match self {
            Self::Ball { at, radius } => shared::ball_and_box(at, *radius, room, dimension),
            Self::Box(bounds) => (0..dimension)
                .map(|axis| {
                    let high = bounds.high[axis].min(room.high[axis]);
                    (high - bounds.low[axis].max(room.low[axis])).max(0.0)
                })
                .product(),
        }
    }

    /// Volume that a ball shares with it, m³ (m²).
    pub fn shares(&self, centre: &Vec3, ball: f64, dimension: usize) -> f64 {
        match self {
            Self::Ball { at, radius } => {
                shared::two_balls((centre - at).norm(), ball, *radius, dimension)
            }
            Self::Box(bounds) => shared::ball_and_box(centre, ball, bounds, dimension),
        }
    }

    /// Middle and radius of a ball around it, m.
    pub fn around(&self, dimension: usize) -> (Vec3, f64) {
        match self {
            Self::Ball { at, radius } => (*at, *radius),
            Self::Box(bounds) => {
                let mut half = bounds.size() * 0.5;
                if dimension == 2 {
                    half.z = 0.0;
                }
                (bounds.centre(), half.norm())
            }
        }
    }

    /// True if a point is inside.
    pub fn holds(&self, point: &Vec3, dimension: usize) -> bool {
        match self {
            Self::Ball { at, radius } => (point - at).norm_squared() < radius * radius,
            // Half-open, so that layers share no point.
            Self::Box(bounds) => (0..dimension)
                .all(|axis| (bounds.low[axis]..bounds.high[axis]).contains(&point[axis])),
        }
    }

    /// How a ball lies to it: 1 wholly inside, −1 wholly outside, 0 across its surface.
    pub fn side(&self, centre: &Vec3, ball: f64, dimension: usize) -> i8 {
        let depth = match self {
            Self::Ball { at, radius } => radius - (centre - at).norm(),
            Self::Box(bounds) => (0..dimension).fold(f64::INFINITY, |least, axis| {
                least.min(centre[axis] - bounds.low[axis]).min(bounds.high[axis] - centre[axis])
            }),
        };
        i8::from(depth >= ball) - i8::from(depth <= -ball)
    }

    /// Part of the line from `from` to `to` that is inside, 0 to 1.
    pub fn part_of_line(&self, from: &Vec3, to: &Vec3, dimension: usize) -> f64 {
        let way = to - from;
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        match self {
            Self::Ball { at, radius } => {
                let start = from - at;
                let (a, b) = (way.norm_squared(), start.dot(&way));
                let c = start.norm_squared() - radius * radius;
                if a <= 0.0 {
                    return if c < 0.0 { 1.0 } else { 0.0 };
                }
                let root = b * b - a * c;
                if root <= 0.0 {
                    return 0.0;
                }
                enter = enter.max((-b - root.sqrt()) / a);
                leave = leave.min((-b + root.sqrt()) / a);
            }
            Self::Box(bounds) => {
                for axis in 0..dimension {
                    let (low, high) =
                        (bounds.low[axis] - from[axis], bounds.high[axis] - from[axis]);
                    if way[axis] == 0.0 {
                        if low > 0.0 || high <= 0.0 {
                            return 0.0;
                        }
                        continue;
                    }
                    let (s, t) = (low / way[axis], high / way[axis]);
                    enter = enter.max(s.min(t));
                    leave = leave.min(s.max(t));
                }
            }
        }
        (leave - enter).clamp(0.0, 1.0)
    }

    /// Where the line through `point` along `axis` is inside: lowest and highest coordinate.
    pub fn chord(&self, point: &Vec3, axis: usize, dimension: usize) -> Option<(f64, f64)> {
        match self {
            Self::Ball { at, radius } => {
                let mut off = point - at;
                off[axis] = 0.0;
                if dimension == 2 {
                    off.z = 0.0;
                }
                let half = radius * radius - off.norm_squared();
                (half > 0.0).then(|| (at[axis] - half.sqrt(), at[axis] + half.sqrt()))
            }
            Self::Box(bounds) => {
                let inside = (0..dimension)
                    .filter(|&other| other != axis)
                    .all(|other| (bounds.low[other]..bounds.high[other]).contains(&point[other]));
                inside.then(|| (bounds.low[axis], bounds.high[axis]))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_where_the_surface_is() {
        let ball = Probe::Ball { at: Vec3::zeros(), radius: 1.0 };
        let part =
            |from: [f64; 3], to: [f64; 3]| ball.part_of_line(&Vec3::from(from), &Vec3::from(to), 3);
        assert_eq!(part([-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]), 0.5);
        assert_eq!(part([0.0, 0.0, 0.0], [0.0, 4.0, 0.0]), 0.25);
        assert_eq!(part([2.0, 0.0, 0.0], [4.0, 0.0, 0.0]), 0.0);
        assert_eq!(part([0.0, 1.5, -2.0], [0.0, 1.5, 2.0]), 0.0);
        let slab =
            Probe::Box(Bounds { low: Vec3::new(-9.0, -9.0, 0.0), high: Vec3::new(9.0, 9.0, 1.0) });
        assert_eq!(
            slab.part_of_line(&Vec3::new(0.0, 0.0, -1.0), &Vec3::new(0.0, 0.0, 3.0), 3),
            0.25
        );
        assert_eq!(slab.part_of_line(&Vec3::new(0.0, 0.0, 2.0), &Vec3::new(1.0, 0.0, 2.0), 3), 0.0);
        assert_eq!(slab.part_of_line(&Vec3::new(0.0, 0.0, 0.5), &Vec3::new(1.0, 0.0, 0.5), 3), 1.0);
    }

    #[test]
    fn sides_and_volumes() {
        let room = Bounds { low: Vec3::zeros(), high: Vec3::repeat(2.0) };
        let ball = Probe::Ball { at: Vec3::new(0.0, 1.0, 1.0), radius: 0.5 };
        assert!((ball.volume(&room, 3) - 0.5 * shared::ball(0.5, 3)).abs() < 1e-15);
        assert_eq!(ball.side(&Vec3::new(0.0, 1.0, 1.0), 0.4, 3), 1);
        assert_eq!(ball.side(&Vec3::new(0.0, 1.0, 1.4), 0.4, 3), 0);
        assert_eq!(ball.side(&Vec3::new(0.0, 1.0, 2.0), 0.4, 3), -1);
        let (low, high) = ball.chord(&Vec3::new(0.3, 1.0, 9.0), 2, 3).expect("inside");
        assert!((high - low - 0.8).abs() < 1e-15);
    }
}
