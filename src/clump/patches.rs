//! Points spread evenly over a surface, and some inside, kept in compact groups, so that a
//! question about one sphere looks at a few groups only.
//!
//! Surface points: equal shares of area along the triangles, in each triangle at the places of
//! Roberts' R2 sequence (2018), whose gaps are smaller than those of random points.
//! Groups: halves along the widest side of the box until at most 24 points are left.
//! Cost O(M log M) for M points.

use crate::geometry::{Bounds, Mesh};
use crate::num::Vec3;
use std::ops::Range;

/// Most points of a group.
const GROUP: usize = 24;

/// Points of a solid in groups: first those of its surface, then inner ones.
#[derive(Clone)]
pub struct Patches {
    /// Where, m.
    pub points: Vec<Vec3>,
    /// Outward unit normals of the surface points.
    pub normals: Vec<Vec3>,
    /// Which points lie close together.
    pub groups: Vec<Group>,
    /// The same points, coordinate by coordinate.
    coordinates: [Vec<f64>; 3],
}

/// Points `first..end` and the ball around them.
#[derive(Debug, Clone, Copy)]
pub struct Group {
    /// Middle of the box around them, m.
    pub centre: Vec3,
    /// Largest distance of a point from there, m.
    pub radius: f64,
    /// First point.
    pub first: usize,
    /// One after the last.
    pub end: usize,
    /// How deep the points are to be covered, m, if they lie inside the solid and nothing else is
    /// asked of them; `None` for points of the surface.
    pub inner: Option<f64>,
}

impl Group {
    /// What counts of the distance `from` a sphere to one of the points, m.
    pub fn gap(&self, from: f64) -> f64 {
        self.inner.map_or(from, |depth| (from + depth).max(0.0))
    }
}

impl Patches {
    /// `count` points on `mesh`.
    pub fn new(mesh: &Mesh, count: usize) -> Self {
        let mut sample = even_points(mesh, count);
        let mut groups = Vec::new();
        split(&mut sample, 0, None, &mut groups);
        let (points, normals): (Vec<Vec3>, Vec<Vec3>) = sample.into_iter().unzip();
        let coordinates = split_up(&points);
        Self { points, normals, groups, coordinates }
    }

    /// Coordinates x, y, z of some points.
    pub fn along(&self, range: Range<usize>) -> [&[f64]; 3] {
        self.coordinates.each_ref().map(|values| &values[range.clone()])
    }

    /// Adds points that must be covered, `depth` m deep.
    pub fn add_inner(&mut self, inner: Vec<Vec3>, depth: f64) {
        let mut sample: Vec<(Vec3, Vec3)> = inner.into_iter().map(|p| (p, Vec3::zeros())).collect();
        split(&mut sample, self.points.len(), Some(depth), &mut self.groups);
        self.points.extend(sample.iter().map(|(p, _)| p));
        self.coordinates = split_up(&self.points);
    }
}

fn split_up(points: &[Vec3]) -> [Vec<f64>; 3] {
    std::array::from_fn(|axis| points.iter().map(|p| p[axis]).collect())
}

fn even_points(mesh: &Mesh, count: usize) -> Vec<(Vec3, Vec3)> {
    let share = mesh.area() / count.max(1) as f64;
    let mut points = Vec::with_capacity(count);
    let mut passed = 0.0;
    for [a, b, c] in mesh.facets() {
        let cross = (b - a).cross(&(c - a));
        let double = cross.norm();
        passed += 0.5 * double;
        while (points.len() as f64 + 0.5) * share < passed && points.len() < count {
            let k = points.len() as f64;
            // Powers of the plastic number's inverse; folded over the diagonal to stay in the triangle.
            let (mut u, mut v) =
                ((k * 0.754_877_666_246_692_8).fract(), (k * 0.569_840_290_998_053_3).fract());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            points.push((a + (b - a) * u + (c - a) * v, cross / double));
        }
    }
    points
}

fn split(sample: &mut [(Vec3, Vec3)], first: usize, inner: Option<f64>, groups: &mut Vec<Group>) {
    let bounds = Bounds::of(sample.iter().map(|(p, _)| p));
    if sample.len() <= GROUP {
        if !sample.is_empty() {
            let centre = bounds.centre();
            let radius = sample.iter().map(|(p, _)| (p - centre).norm()).fold(0.0, f64::max);
            groups.push(Group { centre, radius, first, end: first + sample.len(), inner });
        }
        return;
    }
    let axis = bounds.size().imax();
    let middle = sample.len() / 2;
    sample.select_nth_unstable_by(middle, |(p, _), (q, _)| {
        p[axis].total_cmp(&q[axis]).then_with(|| {
            // All three, so that equal coordinates leave no choice.
            let next = (axis + 1) % 3;
            let last = (axis + 2) % 3;
            p[next].total_cmp(&q[next]).then(p[last].total_cmp(&q[last]))
        })
    });
    let (low, high) = sample.split_at_mut(middle);
    split(low, first, inner, groups);
    split(high, first + middle, inner, groups);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::samples::{box_mesh, icosphere};

    #[test]
    fn points_are_even_and_every_group_holds_its_own() {
        for mesh in [box_mesh(Vec3::new(1.0, 2.0, 3.0)), icosphere(3)] {
            let patches = Patches::new(&mesh, 3000);
            assert_eq!(patches.points.len(), 3000);
            let share = mesh.area() / 3000.0;
            let flux: f64 =
                patches.points.iter().zip(&patches.normals).map(|(p, n)| p.dot(n) * share).sum();
            assert!((flux / 3.0 / mesh.mass_properties().volume - 1.0).abs() < 3e-3);
            let mut next = 0;
            for group in &patches.groups {
                assert_eq!(group.first, next);
                next = group.end;
                for point in &patches.points[group.first..group.end] {
                    assert!((point - group.centre).norm() <= group.radius * (1.0 + 1e-12));
                }
            }
            assert_eq!(next, 3000);
            let surface = patches.groups.len();
            let mut patches = patches;
            patches.add_inner((0..50).map(|i| Vec3::repeat(f64::from(i) * 1e-3)).collect(), 0.0);
            assert_eq!(patches.points.len(), 3050);
            assert!(patches.groups[surface..].iter().all(|group| group.inner == Some(0.0)));
            assert_eq!(patches.groups.last().map(|group| group.end), Some(3050));
        }
    }
}
