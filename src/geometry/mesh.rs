//! Triangle surfaces and their exact mass properties.
//!
//! Mass properties by the divergence theorem over signed tetrahedra with the
//! origin shifted to the bounding-box centre (Eberly 2002; exact for the mesh).

use super::{Bounds, MassProperties};
use crate::num::{Mat3, Vec3};

/// A triangle surface. Triangles index `vertices`; seen from outside their
/// corners run counter-clockwise.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Corner positions, metres.
    pub vertices: Vec<Vec3>,
    /// Corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The three corners of triangle `index`.
    pub fn corners(&self, index: usize) -> [Vec3; 3] {
        self.triangles[index].map(|corner| self.vertices[corner as usize])
    }

    /// The corners of every triangle in turn.
    pub fn facets(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        (0..self.triangles.len()).map(|index| self.corners(index))
    }

    /// The smallest box around all vertices.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(&self.vertices)
    }

    /// Surface area, m².
    pub fn area(&self) -> f64 {
        self.facets().map(|[a, b, c]| (b - a).cross(&(c - a)).norm() * 0.5).sum()
    }

    /// Every vertex moved by `map`.
    pub fn mapped(&self, map: impl Fn(&Vec3) -> Vec3) -> Self {
        Self {
            vertices: self.vertices.iter().map(map).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// Exact volume, centroid and inertia of the solid that the mesh encloses;
    /// the volume is negative for a mesh that is inside out.
    pub fn mass_properties(&self) -> MassProperties {
        let shift = self.bounds().centre();
        let mut volume = 0.0;
        let mut first = Vec3::zeros();
        let mut second = Mat3::zeros();
        for [a, b, c] in self.facets() {
            let (a, b, c) = (a - shift, b - shift, c - shift);
            let six = a.dot(&b.cross(&c));
            let sum = a + b + c;
            volume += six / 6.0;
            first += sum * (six / 24.0);
            second +=
                (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose())
                    * (six / 120.0);
        }
        let offset = if volume == 0.0 { Vec3::zeros() } else { first / volume };
        let central = second - offset * offset.transpose() * volume;
        MassProperties {
            volume,
            centroid: offset + shift,
            inertia: Mat3::identity() * central.trace() - central,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::samples::box_mesh;

    /// Box of edges 1, 2, 3 with its low corner at `corner`.
    fn cuboid(corner: Vec3) -> Mesh {
        let edges = Vec3::new(1.0, 2.0, 3.0);
        box_mesh(edges).mapped(|vertex| vertex + corner + 0.5 * edges)
    }

    #[test]
    fn box_has_its_closed_form() {
        let properties = cuboid(Vec3::new(10.0, -4.0, 1.0)).mass_properties();
        assert!((properties.volume - 6.0).abs() < 1e-12);
        assert!((properties.centroid - Vec3::new(10.5, -3.0, 2.5)).norm() < 1e-12);
        let expected = Vec3::new(4.0 + 9.0, 1.0 + 9.0, 1.0 + 4.0) * (6.0 / 12.0);
        assert!((properties.inertia.diagonal() - expected).norm() < 1e-11);
        let (moments, axes) = properties.principal();
        assert!((moments - Vec3::new(2.5, 5.0, 6.5)).norm() < 1e-11);
        assert!((axes * Vec3::x() - Vec3::z()).norm() < 1e-9);
    }
}
