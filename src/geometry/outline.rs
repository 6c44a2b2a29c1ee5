//! Containers in two dimensions with straight sides at any angles, and with holes: closed loops of corners.
//!
//! Distance to the nearest side, inside or outside by the parity of crossings; O(corners) a query.
//! The walls of a run are the sides, 1 m wide along z like all of a two-dimensional scene.

use super::surface::Surface;
use super::{Bounds, Mesh};
use crate::num::{Fault, Vec3};

/// A region of the x-y plane.
#[derive(Debug, Clone, PartialEq)]
pub struct OutlineRegion {
    /// The outer loop, anticlockwise, then the holes, clockwise.
    loops: Vec<Loop>,
}

/// A closed loop of corners.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// Corners, m; the last is joined to the first.
    pub corners: Vec<[f64; 2]>,
    /// True for a side (from the corner of this number to the next) without a wall.
    pub open: Vec<bool>,
}

type Side = ([f64; 2], [f64; 2]);

impl Loop {
    /// A loop with walls all round.
    pub fn closed(corners: Vec<[f64; 2]>) -> Self {
        let open = vec![false; corners.len()];
        Self { corners, open }
    }

    /// A regular polygon that touches a circle from outside.
    pub fn around(centre: [f64; 2], radius: f64, segments: u32) -> Self {
        let step = std::f64::consts::TAU / f64::from(segments);
        let reach = radius / (0.5 * step).cos();
        let corner = |index: u32| {
            let (sin, cos) = ((f64::from(index) + 0.5) * step).sin_cos();
            [centre[0] + reach * cos, centre[1] + reach * sin]
        };
        Self::closed((0..segments).map(corner).collect())
    }

    fn sides(&self) -> impl Iterator<Item = Side> + '_ {
        let count = self.corners.len();
        (0..count).map(move |i| (self.corners[i], self.corners[(i + 1) % count]))
    }

    /// Area, m²; positive for an anticlockwise loop.
    fn area(&self) -> f64 {
        0.5 * self.sides().map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>()
    }

    fn turned(mut self, anticlockwise: bool) -> Self {
        if (self.area() > 0.0) != anticlockwise {
            self.corners.reverse();
            // Side i now runs between what were corners n − 1 − i and n − 2 − i.
            self.open.reverse();
            self.open.rotate_left(1);
        }
        self
    }

    fn holds(&self, point: &[f64; 2]) -> bool {
        self.sides().fold(false, |inside, (a, b)| {
            let between = (a[1] > point[1]) != (b[1] > point[1]);
            let crosses =
                between && point[0] < a[0] + (point[1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1]);
            inside != crosses
        })
    }
}

fn distance((a, b): &Side, point: &[f64; 2]) -> f64 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let square = along[0] * along[0] + along[1] * along[1];
    let share = ((to[0] * along[0] + to[1] * along[1]) / square).clamp(0.0, 1.0);
    (to[0] - share * along[0]).hypot(to[1] - share * along[1])
}

/// True if two sides have a point in common.
fn meet(p: &Side, q: &Side) -> bool {
    let turn = |a: &[f64; 2], b: &[f64; 2], c: &[f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let apart = |a: &Side, b: &Side| {
        let (one, two) = (turn(&a.0, &a.1, &b.0), turn(&a.0, &a.1, &b.1));
        (one > 0.0 && two > 0.0) || (one < 0.0 && two < 0.0)
    };
    let overlap = |axis: usize| {
        let range = |s: &Side| (s.0[axis].min(s.1[axis]), s.0[axis].max(s.1[axis]));
        let ((a, b), (c, d)) = (range(p), range(q));
        a <= d && c <= b
    };
    !apart(p, q) && !apart(q, p) && overlap(0) && overlap(1)
}

impl OutlineRegion {
    /// The inside of `outer` without what is inside `holes`.
    ///
    /// Errors: a loop without area or that crosses itself, a hole that is not wholly inside or that touches another.
    pub fn new(outer: Loop, holes: Vec<Loop>) -> Result<Self, Fault> {
        let mut loops = vec![outer.turned(true)];
        loops.extend(holes.into_iter().map(|hole| hole.turned(false)));
        let key = |index: usize| match index {
            0 => String::new(),
            _ => format!("holes[{}]", index - 1),
        };
        for (index, one) in loops.iter().enumerate() {
            let wrong = |problem: &str, allowed: &str| {
                Err(Fault::new(key(index), problem.to_owned(), allowed.to_owned()))
            };
            let sides: Vec<Side> = one.sides().collect();
            let count = sides.len();
            let finite = one.corners.iter().flatten().all(|value| value.is_finite());
            if count < 3 || !finite || one.area().abs() <= 0.0 {
                return wrong("encloses no area", "3 corners or more around an area");
            }
            for i in 0..count {
                for j in i + 1..count {
                    let neighbours = j == i + 1 || (i == 0 && j == count - 1);
                    if !neighbours && meet(&sides[i], &sides[j]) {
                        return wrong("crosses itself", "corners in their order around the area");
                    }
                }
            }
            for before in &loops[..index] {
                let crossing = before.sides().any(|p| sides.iter().any(|q| meet(&p, q)));
                let outer = std::ptr::eq(before, &loops[0]);
                let nested = if outer {
                    !before.holds(&one.corners[0])
                } else {
                    before.holds(&one.corners[0]) || one.holds(&before.corners[0])
                };
                if crossing || nested {
                    return wrong(
                        "is not wholly inside the container, or touches another hole",
                        "holes inside, clear of each other",
                    );
                }
            }
        }
        Ok(Self { loops })
    }

    /// Distance to the nearest side, positive inside; `walls` leaves open sides out.
    pub fn clearance(&self, point: &Vec3, walls: bool) -> f64 {
        let at = [point.x, point.y];
        let mut nearest = f64::INFINITY;
        let mut inside = false;
        for one in &self.loops {
            inside = inside != one.holds(&at);
            for (index, side) in one.sides().enumerate() {
                if !(walls && one.open[index]) {
                    nearest = nearest.min(distance(&side, &at));
                }
            }
        }
        // Beyond an open side there is no wall to be behind of.
        if inside || (walls && self.is_open()) { nearest } else { -nearest }
    }

    /// Area, m².
    pub fn area(&self) -> f64 {
        self.loops.iter().map(Loop::area).sum()
    }

    /// The smallest box around it, z from −0.5 m to 0.5 m.
    pub fn bounds(&self) -> Bounds {
        let corners = self.loops[0].corners.iter();
        let points: Vec<Vec3> = corners
            .flat_map(|c| [Vec3::new(c[0], c[1], -0.5), Vec3::new(c[0], c[1], 0.5)])
            .collect();
        Bounds::of(&points)
    }

    /// True if some side has no wall.
    pub fn is_open(&self) -> bool {
        self.loops.iter().any(|one| one.open.contains(&true))
    }

    /// One mesh for the outer loop and one for each hole.
    pub fn walls(&self) -> Vec<(String, Surface)> {
        let mut walls = Vec::new();
        for (index, one) in self.loops.iter().enumerate() {
            let mut mesh = Mesh::default();
            let count = one.corners.len() as u32;
            for corner in &one.corners {
                mesh.vertices.push(Vec3::new(corner[0], corner[1], -0.5));
                mesh.vertices.push(Vec3::new(corner[0], corner[1], 0.5));
            }
            for side in (0..count).filter(|&side| !one.open[side as usize]) {
                let (a, b) = (2 * side, 2 * ((side + 1) % count));
                mesh.triangles.push([a, b, b + 1]);
                mesh.triangles.push([a, b + 1, a + 1]);
            }
            if !mesh.triangles.is_empty() {
                let name = if index == 0 { "outline".to_owned() } else { format!("hole_{index}") };
                walls.push((name, Surface::Mesh(mesh)));
            }
        }
        walls
    }

    /// The outer loop.
    pub fn outer(&self) -> &Loop {
        &self.loops[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> Loop {
        Loop::closed(vec![[low, low], [high, low], [high, high], [low, high]])
    }

    #[test]
    fn a_ring_of_squares_has_its_distances() {
        let region = OutlineRegion::new(square(0.0, 4.0), vec![square(1.0, 2.0)]).expect("a ring");
        assert_eq!(region.area(), 15.0);
        let at = |x: f64, y: f64| region.clearance(&Vec3::new(x, y, 0.0), false);
        assert_eq!((at(0.25, 2.0), at(1.5, 1.75), at(5.0, 2.0)), (0.25, -0.25, -1.0));
        assert!((at(2.3, 2.4) - 0.5).abs() < 1e-12);
        for (name, wall) in region.walls() {
            let Surface::Mesh(mesh) = wall else { panic!("{name}") };
            for [a, b, c] in mesh.facets() {
                let normal = (b - a).cross(&(c - a)).normalize();
                let middle = (a + b + c) / 3.0;
                assert!(region.clearance(&(middle - normal * 0.01), false) > 0.0, "{name}");
                assert!(region.clearance(&(middle + normal * 0.01), false) < 0.0, "{name}");
            }
        }
    }

    #[test]
    fn open_sides_are_no_walls() {
        let mut clockwise = square(0.0, 1.0);
        clockwise.corners.reverse();
        // From (0, 1) to (1, 1): the top.
        clockwise.open = vec![true, false, false, false];
        let region = OutlineRegion::new(clockwise, Vec::new()).expect("a square");
        assert!(region.is_open());
        assert_eq!(region.clearance(&Vec3::new(0.5, 0.9, 0.0), true), 0.5);
        assert!((region.clearance(&Vec3::new(0.5, 0.9, 0.0), false) - 0.1).abs() < 1e-12);
        assert_eq!(region.clearance(&Vec3::new(0.5, 0.2, 0.0), true), 0.2);
    }

    #[test]
    fn wrong_loops_are_refused() {
        let bow = Loop::closed(vec![[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]]);
        assert!(OutlineRegion::new(bow, Vec::new()).is_err());
        let key = |holes| OutlineRegion::new(square(0.0, 4.0), holes).expect_err("wrong").key;
        assert_eq!(key(vec![square(3.0, 5.0)]), "holes[0]");
        assert_eq!(key(vec![square(5.0, 6.0)]), "holes[0]");
        assert_eq!(key(vec![square(1.0, 2.0), square(1.5, 3.0)]), "holes[1]");
        assert_eq!(key(vec![square(1.0, 3.0), square(1.5, 2.0)]), "holes[1]");
        let round = Loop::around([1.0, 2.0], 0.5, 64);
        let region = OutlineRegion::new(round, Vec::new()).expect("round");
        assert!((region.clearance(&Vec3::new(1.0, 2.0, 0.0), false) - 0.5).abs() < 1e-12);
    }
}
