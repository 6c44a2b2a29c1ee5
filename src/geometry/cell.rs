//! Periodic boxes: space repeats along some of the axes.
//!
//! L edge lengths. A place x and x + n L (n whole, along periodic axes) are one place; the
//! way between two places is that to the nearest image. O(1) a query.

use super::Bounds;
use crate::num::Vec3;
use serde::{Deserialize, Serialize};

/// A box that repeats itself along some axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Corners, m. Along axes that are not periodic they mean nothing.
    pub bounds: Bounds,
    /// Along which axes it repeats; at least one.
    pub periodic: [bool; 3],
}

impl Cell {
    /// Edge lengths along periodic axes, infinite along others, m.
    pub fn lengths(&self) -> Vec3 {
        let size = self.bounds.size();
        Vec3::from_fn(|axis, _| if self.periodic[axis] { size[axis] } else { f64::INFINITY })
    }

    /// The shortest of all images of the way `way` between two places.
    pub fn way(&self, way: &Vec3) -> Vec3 {
        let size = self.bounds.size();
        Vec3::from_fn(|axis, _| match self.periodic[axis] {
            true => way[axis] - size[axis] * (way[axis] / size[axis]).round(),
            false => way[axis],
        })
    }

    /// The way from `place` to its image inside the box; zero for places inside.
    pub fn home(&self, place: &Vec3) -> Vec3 {
        let (low, size) = (self.bounds.low, self.bounds.size());
        Vec3::from_fn(|axis, _| match self.periodic[axis] {
            true => -size[axis] * ((place[axis] - low[axis]) / size[axis]).floor(),
            false => 0.0,
        })
    }

    /// Calls `visit` with the way to every other image of `place` that lies no farther than
    /// `reach` (m) outside the box along every periodic axis. For places in or near the box.
    pub fn images(&self, place: &Vec3, reach: f64, mut visit: impl FnMut(Vec3)) {
        let size = self.bounds.size();
        let shifts = |axis: usize| if self.periodic[axis] { -1..=1 } else { 0..=0 };
        for x in shifts(0) {
            for y in shifts(1) {
                for z in shifts(2) {
                    let shift = Vec3::new(f64::from(x), f64::from(y), f64::from(z));
                    let way = shift.component_mul(&size);
                    let there = place + way;
                    let near = (0..3).all(|axis| {
                        !self.periodic[axis]
                            || (there[axis] >= self.bounds.low[axis] - reach
                                && there[axis] <= self.bounds.high[axis] + reach)
                    });
                    if near && [x, y, z] != [0; 3] {
                        visit(way);
                    }
                }
            }
        }
    }

    /// The first periodic axis that is too short for bodies that reach `reach` (m) from their
    /// centres: every pair must have one nearest image only, and no body may meet itself.
    pub fn too_short(&self, reach: f64) -> Option<usize> {
        (0..3).find(|axis| self.periodic[*axis] && self.bounds.size()[*axis] < 4.0 * reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cell() -> Cell {
        let bounds = Bounds { low: Vec3::new(-1.0, 2.0, 0.0), high: Vec3::new(1.0, 5.0, 4.0) };
        Cell { bounds, periodic: [true, true, false] }
    }

    proptest! {
        #[test]
        fn ways_are_shortest_and_homes_inside(x in -9.0..9.0_f64, y in -9.0..9.0_f64, z in -9.0..9.0_f64) {
            let (cell, place) = (cell(), Vec3::new(x, y, z));
            let way = cell.way(&place);
            prop_assert!(way.x.abs() <= 1.0 + 1e-12 && way.y.abs() <= 1.5 + 1e-12 && way.z == z);
            let home = place + cell.home(&place);
            prop_assert!((-1.0..=1.0).contains(&home.x) && (2.0..=5.0).contains(&home.y));
            prop_assert!(cell.way(&(home - place)).norm() < 1e-12);
        }
    }

    #[test]
    fn images_near_a_corner() {
        let mut ways = Vec::new();
        cell().images(&Vec3::new(-0.95, 2.02, 1.0), 0.1, |way| ways.push(way));
        let expected =
            [Vec3::new(0.0, 3.0, 0.0), Vec3::new(2.0, 0.0, 0.0), Vec3::new(2.0, 3.0, 0.0)];
        assert_eq!(ways, expected);
        assert_eq!(cell().home(&Vec3::new(0.3, 2.0, 99.0)), Vec3::zeros());
        assert_eq!((cell().too_short(0.5), cell().too_short(0.6)), (None, Some(0)));
    }
}
