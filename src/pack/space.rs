//! Where the centres of balls may be: inside a region, or in a box whose sides repeat.
//!
//! Methods that are periodic by nature ask this, so that one code serves
//! containers and periodic boxes: distances by the nearest image, walls through
//! the clearance of the region. O(1) but for clearances of meshes, O(log triangles).

use crate::geometry::{BallGrid, Bounds, Region};
use crate::num::Vec3;
use crate::num::random::{Stream, uniform};

/// A place for balls.
#[derive(Debug, Clone, Copy)]
pub struct Space<'a> {
    /// 2 or 3.
    pub dimension: usize,
    /// The smallest box around it, m.
    pub bounds: Bounds,
    /// Axes along which the box repeats.
    pub periodic: [bool; 3],
    region: Option<&'a Region>,
}

impl<'a> Space<'a> {
    /// The inside of a region. A box keeps its bounds and periodic sides only, which may then be moved.
    pub fn of(region: &'a Region) -> Self {
        Self {
            dimension: region.dimension(),
            bounds: region.bounds(),
            periodic: region.cell().map_or([false; 3], |cell| cell.periodic),
            region: (!matches!(region, Region::Box(_))).then_some(region),
        }
    }

    /// A box from the origin with edges `size` (m) whose sides repeat.
    pub fn repeating(dimension: usize, size: Vec3) -> Self {
        let (mut low, mut high) = (Vec3::zeros(), size);
        if dimension == 2 {
            (low.z, high.z) = (-0.5, 0.5);
        }
        let periodic = [true, true, dimension == 3];
        Self { dimension, bounds: Bounds { low, high }, periodic, region: None }
    }

    /// A box of which some sides repeat.
    pub fn boxed(dimension: usize, bounds: Bounds, periodic: [bool; 3]) -> Self {
        Self { dimension, bounds, periodic, region: None }
    }

    /// The region, where it is not a box.
    pub fn region(&self) -> Option<&'a Region> {
        self.region
    }

    /// Volume, m³ (area in two dimensions).
    pub fn volume(&self) -> f64 {
        match self.region {
            Some(region) => region.volume(),
            None => (0..self.dimension).map(|axis| self.bounds.size()[axis]).product(),
        }
    }

    /// Distance to the nearest wall, m, negative outside; infinite where nothing but repeating sides is.
    pub fn clearance(&self, point: &Vec3) -> f64 {
        if let Some(region) = self.region {
            return region.clearance(point);
        }
        let walls = (0..self.dimension).filter(|&axis| !self.periodic[axis]);
        walls.fold(f64::INFINITY, |least, axis| {
            least.min(point[axis] - self.bounds.low[axis]).min(self.bounds.high[axis] - point[axis])
        })
    }

    /// Unit vector along which the clearance grows fastest, by central differences of `step` m.
    pub fn inward(&self, point: &Vec3, step: f64) -> Option<Vec3> {
        let region = self.region?;
        let slope = Vec3::from_fn(|axis, _| {
            if axis >= self.dimension {
                return 0.0;
            }
            let mut shift = Vec3::zeros();
            shift[axis] = step;
            region.clearance(&(point + shift)) - region.clearance(&(point - shift))
        });
        slope.try_normalize(1e-3 * step)
    }

    /// `a − b` by the nearest image, m.
    pub fn apart(&self, a: &Vec3, b: &Vec3) -> Vec3 {
        let mut d = a - b;
        for axis in 0..3 {
            if self.periodic[axis] {
                let edge = self.bounds.high[axis] - self.bounds.low[axis];
                d[axis] -= edge * (d[axis] / edge).round();
            }
        }
        d
    }

    /// The image of `point` inside the box.
    pub fn wrap(&self, point: &Vec3) -> Vec3 {
        let mut p = *point;
        for axis in 0..3 {
            if self.periodic[axis] {
                let edge = self.bounds.high[axis] - self.bounds.low[axis];
                p[axis] -= edge * ((p[axis] - self.bounds.low[axis]) / edge).floor();
            }
        }
        p
    }

    /// A random point inside, uniform; `None` as for [`Region::sample`].
    pub fn sample(&self, stream: &mut Stream) -> Option<Vec3> {
        if let Some(region) = self.region {
            return region.sample(stream);
        }
        let mut point = Vec3::zeros();
        for axis in 0..self.dimension {
            point[axis] = uniform(stream, self.bounds.low[axis], self.bounds.high[axis]);
        }
        Some(point)
    }

    /// Calls `visit` for the images of `point` that lie within `reach` of the box, until it returns false.
    pub fn images(&self, point: &Vec3, reach: f64, mut visit: impl FnMut(&Vec3) -> bool) -> bool {
        let size = self.bounds.size();
        let shifts = |axis: usize| {
            let low = self.periodic[axis] && point[axis] - self.bounds.low[axis] < reach;
            let high = self.periodic[axis] && self.bounds.high[axis] - point[axis] < reach;
            [Some(0.0), low.then_some(size[axis]), high.then_some(-size[axis])]
        };
        let (xs, ys, zs) = (shifts(0), shifts(1), shifts(2));
        for x in xs.into_iter().flatten() {
            for y in ys.into_iter().flatten() {
                for z in zs.into_iter().flatten() {
                    if !visit(&(point + Vec3::new(x, y, z))) {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Distance from `point` to the nearest surface of a ball of `balls` (m), negative
    /// inside; at most `limit`. `guess` is where the search starts to widen.
    /// `largest` is the largest radius of them.
    pub fn gap(&self, balls: &BallGrid, point: &Vec3, limit: f64, guess: f64, largest: f64) -> f64 {
        let mut reach = guess.min(limit);
        loop {
            let mut least = reach;
            self.images(point, reach + largest, |image| {
                balls.near(image, least, |_, gap| {
                    least = least.min(gap);
                    // Inside a ball there is nothing more to know.
                    least > 0.0
                }) || least > 0.0
            });
            if least < reach || reach >= limit {
                return least;
            }
            reach = (2.0 * reach).min(limit);
        }
    }

    /// True if a ball would come nearer than nothing to one of `balls`.
    pub fn overlaps(&self, balls: &BallGrid, centre: &Vec3, radius: f64, largest: f64) -> bool {
        !self.images(centre, radius + largest, |image| !balls.any_near(image, radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_see_across_the_sides() {
        let space = Space::repeating(3, Vec3::new(1.0, 2.0, 3.0));
        let d = space.apart(&Vec3::new(0.95, 0.1, 0.1), &Vec3::new(0.05, 1.9, 2.9));
        assert!((d - Vec3::new(-0.1, 0.2, 0.2)).norm() < 1e-12, "{d}");
        let mut balls = BallGrid::new(0.1);
        balls.insert(Vec3::new(0.05, 0.05, 0.05), 0.1);
        let gap = space.gap(&balls, &Vec3::new(0.95, 1.95, 2.95), 10.0, 0.01, 0.1);
        assert!((gap - (0.03_f64.sqrt() - 0.1)).abs() < 1e-12, "{gap}");
        assert!(space.overlaps(&balls, &Vec3::new(0.85, 0.05, 0.05), 0.11, 0.1));
        assert!(!space.overlaps(&balls, &Vec3::new(0.85, 0.05, 0.05), 0.09, 0.1));
        assert_eq!(space.wrap(&Vec3::new(-0.25, 2.5, 3.0)), Vec3::new(0.75, 0.5, 0.0));
        let flat = Space::repeating(2, Vec3::new(2.0, 2.0, 9.0));
        assert_eq!(flat.volume(), 4.0);
        assert_eq!(flat.clearance(&Vec3::zeros()), f64::INFINITY);
    }
}
