//! Base solids: box, cylinder, cone, ellipsoid, sphere, as exact sets of
//! points and as closed triangle surfaces.
//!
//! Every solid is centred: its bounding box in the body frame has its middle at
//! the origin; cylinder and cone have their axis along z, the cone its apex at
//! +z. Round surfaces are inscribed: all vertices lie on the true surface, so
//! the mesh is smaller than the solid by a volume of O(1/segments²).
//! Ellipsoid and sphere are geodesic (an icosahedron with every edge split
//! evenly), so that no triangle is a needle. Cost O(triangles).

use super::Mesh;
use crate::num::{Rotation, Vec3};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// A base solid in its own frame, lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Primitive {
    /// Rectangular box of the given edges along x, y, z.
    Box {
        /// Edge lengths.
        edges: Vec3,
    },
    /// Circular cylinder about z, from z = −height/2 to height/2.
    Cylinder {
        /// Diameter.
        diameter: f64,
        /// Height.
        height: f64,
    },
    /// Circular cone about z, base at z = −height/2, apex at z = height/2.
    Cone {
        /// Diameter of the base.
        diameter: f64,
        /// Height.
        height: f64,
    },
    /// Ellipsoid with the given full axes along x, y, z.
    Ellipsoid {
        /// Full axes (twice the semi-axes).
        axes: Vec3,
    },
    /// Sphere.
    Sphere {
        /// Diameter.
        diameter: f64,
    },
}

/// A base solid placed in space: a point p of its frame lies at rotation · p + centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Posed {
    /// The solid in its own frame.
    pub primitive: Primitive,
    /// Turns the frame of the solid into that of the world.
    pub rotation: Rotation,
    /// Where the centre of the solid lies, m.
    pub centre: Vec3,
}

impl Posed {
    /// True if `point` lies inside or on the exact solid.
    pub fn contains(&self, point: &Vec3) -> bool {
        self.primitive.contains(&self.rotation.inverse_transform_vector(&(point - self.centre)))
    }

    /// Closed surface with round parts in `segments` pieces a turn.
    pub fn mesh(&self, segments: u32) -> Mesh {
        self.primitive.mesh(segments).mapped(|point| self.rotation * point + self.centre)
    }
}

impl Primitive {
    /// True if `point` (own frame) lies inside or on the exact solid.
    pub fn contains(&self, point: &Vec3) -> bool {
        let ring = point.x.hypot(point.y);
        match *self {
            Self::Box { edges } => (0..3).all(|axis| 2.0 * point[axis].abs() <= edges[axis]),
            Self::Cylinder { diameter, height } => {
                2.0 * point.z.abs() <= height && 2.0 * ring <= diameter
            }
            Self::Cone { diameter, height } => {
                2.0 * point.z.abs() <= height
                    && 2.0 * ring * height <= diameter * (0.5 * height - point.z)
            }
            Self::Ellipsoid { axes } => 4.0 * point.component_div(&axes).norm_squared() <= 1.0,
            Self::Sphere { diameter } => 2.0 * point.norm() <= diameter,
        }
    }

    /// Volume of the exact solid, m³.
    pub fn volume(&self) -> f64 {
        match *self {
            Self::Box { edges } => edges.product(),
            Self::Cylinder { diameter, height } => PI / 4.0 * diameter * diameter * height,
            Self::Cone { diameter, height } => PI / 12.0 * diameter * diameter * height,
            Self::Ellipsoid { axes } => PI / 6.0 * axes.product(),
            Self::Sphere { diameter } => PI / 6.0 * diameter.powi(3),
        }
    }

    /// Closed surface in the own frame, round parts in `segments` (at least 3)
    /// pieces a turn; ellipsoids and spheres have 20·⌈segments/5⌉² triangles.
    pub fn mesh(&self, segments: u32) -> Mesh {
        match *self {
            Self::Box { edges } => cuboid(edges),
            Self::Cylinder { diameter, height } => cylinder(0.5 * diameter, height, segments),
            Self::Cone { diameter, height } => cone(0.5 * diameter, height, segments),
            Self::Ellipsoid { axes } => {
                geodesic(segments).mapped(|p| p.component_mul(&(axes * 0.5)))
            }
            Self::Sphere { diameter } => geodesic(segments).mapped(|p| p * (0.5 * diameter)),
        }
    }
}

/// Box of the given edges about the origin: 8 vertices, 12 triangles.
fn cuboid(edges: Vec3) -> Mesh {
    let half = edges * 0.5;
    let vertices = (0..8u32)
        .map(|i| Vec3::from_fn(|axis, _| if i >> axis & 1 == 1 { half[axis] } else { -half[axis] }))
        .collect();
    let triangles = vec![
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    Mesh { vertices, triangles }
}

/// Points of a circle about z at height `z`.
fn ring(radius: f64, z: f64, segments: u32) -> impl Iterator<Item = Vec3> {
    (0..segments).map(move |i| {
        let angle = TAU * f64::from(i) / f64::from(segments);
        Vec3::new(radius * angle.cos(), radius * angle.sin(), z)
    })
}

fn cylinder(radius: f64, height: f64, segments: u32) -> Mesh {
    let n = segments.max(3);
    let mut vertices: Vec<Vec3> = ring(radius, -0.5 * height, n).collect();
    vertices.extend(ring(radius, 0.5 * height, n));
    vertices.push(Vec3::new(0.0, 0.0, -0.5 * height));
    vertices.push(Vec3::new(0.0, 0.0, 0.5 * height));
    let triangles = (0..n)
        .flat_map(|i| {
            let j = (i + 1) % n;
            [[i, j, n + j], [i, n + j, n + i], [2 * n, j, i], [2 * n + 1, n + i, n + j]]
        })
        .collect();
    Mesh { vertices, triangles }
}

fn cone(radius: f64, height: f64, segments: u32) -> Mesh {
    let n = segments.max(3);
    let mut vertices: Vec<Vec3> = ring(radius, -0.5 * height, n).collect();
    vertices.push(Vec3::new(0.0, 0.0, -0.5 * height));
    vertices.push(Vec3::new(0.0, 0.0, 0.5 * height));
    let triangles = (0..n)
        .flat_map(|i| {
            let j = (i + 1) % n;
            [[n, j, i], [n + 1, i, j]]
        })
        .collect();
    Mesh { vertices, triangles }
}

/// Unit sphere: the icosahedron with every edge in ⌈segments/5⌉ equal parts,
/// new vertices pushed out to the sphere (class I geodesic).
fn geodesic(segments: u32) -> Mesh {
    let parts = segments.max(3).div_ceil(5);
    let base = icosahedron();
    let mut vertices: Vec<Vec3> = Vec::new();
    let mut triangles = Vec::new();
    // A vertex is known by its weights on the corners of the icosahedron, so
    // that neighbouring faces share the vertices on their common edge exactly.
    let mut known: BTreeMap<[(u32, u32); 3], u32> = BTreeMap::new();
    for corners in &base.triangles {
        let mut at = |i: u32, j: u32| {
            let weights = [parts - i - j, i, j];
            let mut key = std::array::from_fn(|k| {
                if weights[k] == 0 { (u32::MAX, 0) } else { (corners[k], weights[k]) }
            });
            key.sort_unstable();
            *known.entry(key).or_insert_with(|| {
                let sum = key.iter().filter(|(_, weight)| *weight > 0).fold(
                    Vec3::zeros(),
                    |sum, (corner, weight)| {
                        sum + base.vertices[*corner as usize] * f64::from(*weight)
                    },
                );
                vertices.push(sum.normalize());
                vertices.len() as u32 - 1
            })
        };
        for i in 0..parts {
            for j in 0..parts - i {
                triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < parts {
                    triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    Mesh { vertices, triangles }
}

fn icosahedron() -> Mesh {
    let long = 0.5 * (1.0 + 5f64.sqrt());
    let mut vertices = Vec::with_capacity(12);
    for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        vertices.push(Vec3::new(a, b * long, 0.0));
        vertices.push(Vec3::new(0.0, a, b * long));
        vertices.push(Vec3::new(b * long, 0.0, a));
    }
    let mut triangles = Vec::with_capacity(20);
    let near = |a: u32, b: u32| (vertices[a as usize] - vertices[b as usize]).norm() < 2.1;
    for a in 0..12u32 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let [p, q, r] = [a, b, c].map(|i| vertices[i as usize]);
                    let outwards = p.dot(&q.cross(&r)) > 0.0;
                    triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    Mesh { vertices, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random;

    fn all() -> [Primitive; 5] {
        [
            Primitive::Box { edges: Vec3::new(1.0, 2.0, 3.0) },
            Primitive::Cylinder { diameter: 1.5, height: 0.7 },
            Primitive::Cone { diameter: 1.5, height: 2.0 },
            Primitive::Ellipsoid { axes: Vec3::new(1.0, 2.0, 0.5) },
            Primitive::Sphere { diameter: 1.3 },
        ]
    }

    #[test]
    fn volumes_converge_quadratically_from_below() {
        for solid in all() {
            let error = |n| 1.0 - solid.mesh(n).mass_properties().volume / solid.volume();
            let (coarse, fine) = (error(40), error(80));
            if matches!(solid, Primitive::Box { .. }) {
                assert!(coarse.abs() < 1e-14);
                continue;
            }
            assert!(fine > 0.0 && fine < 0.005, "{solid:?}: {fine}");
            assert!((coarse / fine - 4.0).abs() < 0.1, "{solid:?}: {coarse} {fine}");
        }
    }

    #[test]
    fn the_set_and_the_surface_are_the_same_solid() {
        let mut source = random::stream(5, "primitive", 0);
        for solid in all() {
            let posed = Posed {
                primitive: solid,
                rotation: random::rotation(&mut source),
                centre: Vec3::new(3.0, -1.0, 0.5),
            };
            let mesh = posed.mesh(64);
            let bounds = mesh.bounds().grown(0.02);
            let tries = 40_000;
            let inside = (0..tries)
                .filter(|_| {
                    let size = bounds.size();
                    let p = bounds.low
                        + Vec3::from_fn(|axis, _| random::uniform(&mut source, 0.0, size[axis]));
                    posed.contains(&p)
                })
                .count() as f64;
            let share = solid.volume() / bounds.size().product();
            let deviation = (share * (1.0 - share) / f64::from(tries)).sqrt();
            assert!((inside / f64::from(tries) - share).abs() < 5.0 * deviation, "{solid:?}");
            let centre = mesh.vertices.iter().sum::<Vec3>() / mesh.vertices.len() as f64;
            assert!(posed.contains(&centre));
            for p in &mesh.vertices {
                let towards = centre + (p - centre) * (1.0 - 1e-9);
                assert!(posed.contains(&towards), "{solid:?}");
            }
        }
    }
}
