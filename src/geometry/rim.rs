//! Parts of the rim of a disc that no other disc covers, without an angle but for the free ones.
//!
//! A place on the rim is the cosine and sine of its angle θ; places are ordered by
//! k = s/(|c|+|s|), unfolded to 0 ≤ k < 4, which rises with θ. Covered parts are kept merged
//! and in order, so that a rim that is covered wholly is known at once.
//! Cost O(free and covered parts) for every part that is added.

use std::f64::consts::TAU;

/// Cosine and sine of an angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    pub c: f64,
    pub s: f64,
}

const START: Point = Point { c: 1.0, s: 0.0 };
/// Of the whole turn.
const END: f64 = 4.0;

impl Point {
    /// Rises with the angle, from 0 to 4.
    fn key(self) -> f64 {
        let share = self.s / (self.c.abs() + self.s.abs());
        if self.c < 0.0 {
            2.0 - share
        } else if share < 0.0 {
            4.0 + share
        } else {
            share
        }
    }

    /// The angle, 0 to 2π.
    fn angle(self) -> f64 {
        self.s.atan2(self.c).rem_euclid(TAU)
    }
}

#[derive(Debug, Clone, Copy)]
struct End {
    key: f64,
    at: Point,
}

/// Covered parts of one rim.
#[derive(Debug, Clone, Default)]
pub struct Rim {
    /// Apart from each other, rising.
    covered: Vec<(End, End)>,
    whole: bool,
}

impl Rim {
    /// Forgets everything, keeps the memory.
    pub fn clear(&mut self) {
        self.covered.clear();
        self.whole = false;
    }

    /// Covers the whole rim.
    pub fn cover_all(&mut self) {
        self.whole = true;
    }

    /// True if nothing is free.
    pub fn is_whole(&self) -> bool {
        self.whole
    }

    /// Covers what is within the angle of `half` (0 to π) of `middle`.
    pub fn cover(&mut self, middle: Point, half: Point) {
        let from = Point {
            c: middle.c * half.c + middle.s * half.s,
            s: middle.s * half.c - middle.c * half.s,
        };
        let to = Point {
            c: middle.c * half.c - middle.s * half.s,
            s: middle.s * half.c + middle.c * half.s,
        };
        let [from, to] = [from, to].map(|at| End { key: at.key(), at });
        // Where the ends cannot be told apart, next to nothing or next to all is covered.
        if from.key == to.key {
            self.whole |= half.c < 0.0;
        } else if from.key < to.key {
            self.insert(from, to);
        } else {
            self.insert(from, End { key: END, at: START });
            self.insert(End { key: 0.0, at: START }, to);
        }
        if let [(first, last)] = self.covered[..] {
            self.whole |= first.key <= 0.0 && last.key >= END;
        }
    }

    fn insert(&mut self, mut from: End, mut to: End) {
        let first = self.covered.iter().position(|part| part.1.key >= from.key);
        let first = first.unwrap_or(self.covered.len());
        let mut last = first;
        while let Some(part) = self.covered.get(last).filter(|part| part.0.key <= to.key) {
            if part.0.key < from.key {
                from = part.0;
            }
            if part.1.key > to.key {
                to = part.1;
            }
            last += 1;
        }
        if first == last {
            self.covered.insert(first, (from, to));
        } else {
            self.covered[first] = (from, to);
            self.covered.drain(first + 1..last);
        }
    }

    /// Calls `free(from, to, angle between)` for each uncovered arc; an arc that runs through
    /// the angle 0 comes in two parts.
    pub fn each_free(&self, mut free: impl FnMut(Point, Point, f64)) {
        if self.whole {
            return;
        }
        let mut reached = End { key: 0.0, at: START };
        let mut angle = 0.0;
        for (from, to) in &self.covered {
            if from.key > reached.key {
                let next = if from.key >= END { TAU } else { from.at.angle() };
                free(reached.at, from.at, (next - angle).max(0.0));
            }
            reached = *to;
            angle = if to.key >= END { TAU } else { to.at.angle() };
        }
        if reached.key < END {
            free(reached.at, START, (TAU - angle).max(0.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::arcs::Cover;
    use crate::num::random::{stream, uniform};

    fn point(angle: f64) -> Point {
        Point { c: angle.cos(), s: angle.sin() }
    }

    #[test]
    fn free_arcs_are_those_found_with_angles() {
        let mut source = stream(1, "rim", 0);
        for round in 0..300 {
            let (mut rim, mut cover) = (Rim::default(), Cover::default());
            for _ in 0..round % 12 {
                let middle = uniform(&mut source, -3.2, 3.2);
                let half = uniform(&mut source, 0.0, if round % 3 == 0 { 3.1 } else { 0.6 });
                rim.cover(point(middle), point(half));
                cover.cover(middle, half);
            }
            let (mut ours, mut others) = (Vec::new(), Vec::new());
            rim.each_free(|from, to, angle| ours.push((from, to, angle)));
            cover.each_free(|from, to| others.push((from, to)));
            assert_eq!(ours.len(), others.len(), "round {round}");
            assert_eq!(rim.is_whole(), others.is_empty());
            for ((from, to, angle), (a, b)) in ours.iter().zip(&others) {
                assert!((angle - (b - a)).abs() < 1e-12);
                let near = |p: &Point, at: f64| {
                    (p.c - at.cos()).abs() < 1e-12 && (p.s - at.sin()).abs() < 1e-12
                };
                assert!(near(from, *a) && near(to, *b));
            }
        }
    }

    #[test]
    fn nothing_and_everything() {
        let mut rim = Rim::default();
        let mut total = 0.0;
        rim.each_free(|_, _, angle| total += angle);
        assert_eq!(total, TAU);
        rim.cover_all();
        rim.each_free(|_, _, _| panic!("nothing is free"));
        rim.clear();
        rim.cover(point(0.0), point(3.0));
        rim.cover(point(3.0), point(0.5));
        assert!(rim.is_whole());
    }
}
