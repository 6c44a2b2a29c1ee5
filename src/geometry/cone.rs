//! A cone or a part of one as a container: a pyramid of flat facets that touches the round cone from outside,
//! as the cylinder of [`super::region`] is a prism. Convex, so the least distance to the planes of
//! the facets is the distance to the wall; O(1) a query, because the nearest facet is the
//! one that the point looks at.

use super::surface::{Surface, plane};
use super::{Bounds, Mesh};
use crate::num::Vec3;
use std::f64::consts::{PI, TAU};

/// A regular pyramid, or a part between two planes across its axis.
#[derive(Debug, Clone, PartialEq)]
pub struct ConeRegion {
    /// Middle of the low end, m.
    pub base: Vec3,
    /// Axis: 0, 1 or 2.
    pub axis: usize,
    /// Distance of the facets from the axis at the low and the high end, m; one may be 0.
    pub radii: [f64; 2],
    /// Length, m.
    pub height: f64,
    /// Number of facets.
    pub segments: u32,
    /// True for an end without a wall: low, high.
    pub open: [bool; 2],
}

impl ConeRegion {
    /// Distance to the facets, positive inside; `closed` leaves open ends out of sight.
    pub fn clearance(&self, point: &Vec3, open: [bool; 2]) -> f64 {
        let along = point[self.axis] - self.base[self.axis];
        let [first, second] = self.across();
        let (u, v) = (point[first] - self.base[first], point[second] - self.base[second]);
        let step = TAU / f64::from(self.segments);
        let (sin, cos) = ((v.atan2(u) / step).round() * step).sin_cos();
        let rise = (self.radii[1] - self.radii[0]) / self.height;
        let side = (self.radii[0] + rise * along - (u * cos + v * sin)) / rise.hypot(1.0);
        let low = if open[0] { f64::INFINITY } else { along };
        let high = if open[1] { f64::INFINITY } else { self.height - along };
        side.min(low).min(high)
    }

    /// Volume, m³.
    pub fn volume(&self) -> f64 {
        let (n, [a, b]) = (f64::from(self.segments), self.radii);
        n * (PI / n).tan() * self.height * (a * a + a * b + b * b) / 3.0
    }

    /// The smallest box around it.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(&self.surface([false; 2]).vertices)
    }

    /// Side and those ends that are not left out, facing outwards.
    pub fn surface(&self, without: [bool; 2]) -> Mesh {
        let [first, second] = self.across();
        let n = self.segments;
        let mut vertices = Vec::new();
        // Corner `index` of each end; an end without width is one corner.
        let mut ends = [[0_u32; 2]; 2];
        for (end, &radius) in self.radii.iter().enumerate() {
            let mut middle = self.base;
            middle[self.axis] += if end == 1 { self.height } else { 0.0 };
            ends[end] = [vertices.len() as u32, u32::from(radius > 0.0)];
            for index in 0..if radius > 0.0 { n } else { 1 } {
                let (sin, cos) = ((f64::from(index) - 0.5) * TAU / f64::from(n)).sin_cos();
                let reach = radius / (PI / f64::from(n)).cos();
                let mut corner = middle;
                corner[first] += reach * cos;
                corner[second] += reach * sin;
                vertices.push(corner);
            }
        }
        let at = |end: usize, index: u32| ends[end][0] + ends[end][1] * (index % n);
        let mut triangles = Vec::new();
        for i in 0..n {
            triangles.push([at(0, i), at(0, i + 1), at(1, i + 1)]);
            triangles.push([at(0, i), at(1, i + 1), at(1, i)]);
            if i > 0 && i + 1 < n {
                if !without[0] {
                    triangles.push([at(0, 0), at(0, i + 1), at(0, i)]);
                }
                if !without[1] {
                    triangles.push([at(1, 0), at(1, i), at(1, i + 1)]);
                }
            }
        }
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        Mesh { vertices, triangles }
    }

    /// The side as a mesh, the ends that have width and a wall as planes.
    pub fn walls(&self) -> Vec<(String, Surface)> {
        let mut walls = vec![("side".to_owned(), Surface::Mesh(self.surface([true; 2])))];
        for high in [false, true] {
            if !self.open[usize::from(high)] && self.radii[usize::from(high)] > 0.0 {
                let mut point = self.base;
                point[self.axis] += if high { self.height } else { 0.0 };
                walls.push(plane(self.axis, high, point));
            }
        }
        walls
    }

    fn across(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }
}
