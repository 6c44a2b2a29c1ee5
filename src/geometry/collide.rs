//! Do two solids come nearer to each other than a given distance?
//!
//! Surfaces against surfaces by parry3d (both bounding volume trees
//! walked together, GJK between triangles), with lengths scaled so that the tolerances of GJK,
//! which are absolute, stay far below the size of a grain; one solid inside
//! the other by a parity count of crossings along a ray. A skin of 10⁻⁶ of the smaller
//! solid stands between "apart" and "touching", so rounding errs to the safe side.
//! Cost about O(k log n) for k triangles of one near the other.

use super::{Bounds, Mesh};
use crate::num::{Rotation, Vec3};
use parry3d::math::{Pose, Vector};
use parry3d::partitioning::BvhNode;
use parry3d::query::DefaultQueryDispatcher;
use parry3d::query::{ClosestPoints, PointQuery, QueryDispatcher, Ray, RayCast};
use parry3d::shape::TriMesh;

/// Where a body is: its origin and how its frame is turned.
pub type Place = (Vec3, Rotation);

/// A closed surface made ready for collision queries, in its own frame.
#[derive(Clone)]
pub struct Collider {
    mesh: TriMesh,
    vertices: Vec<Vec3>,
    scale: f64,
    radius: f64,
    /// Radius of the ball about the origin of the frame that the solid holds, m; 0 for none.
    core: f64,
    bounds: Bounds,
}

fn vector(v: &Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn pose((origin, turn): &Place, scale: f64) -> Pose {
    let q = turn.quaternion();
    let rotation = parry3d::math::Rotation::from_xyzw(q.i, q.j, q.k, q.w);
    Pose::from_parts(vector(&(origin * scale)), rotation)
}

impl Collider {
    /// Prepares a closed mesh; `unit` (m) is about the size of the largest
    /// solid and must be the same for all solids that are compared.
    /// `None` for a mesh without triangles or a unit that is not positive.
    pub fn new(mesh: &Mesh, unit: f64) -> Option<Self> {
        if !(unit.is_finite() && unit > 0.0) {
            return None;
        }
        let scaled = mesh.vertices.iter().map(|v| vector(&(v / unit))).collect();
        let radius = mesh.vertices.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let mut collider = Self {
            mesh: TriMesh::new(scaled, mesh.triangles.clone()).ok()?,
            vertices: mesh.vertices.clone(),
            scale: 1.0 / unit,
            radius,
            core: 0.0,
            bounds: mesh.bounds(),
        };
        if collider.holds_local(&Vec3::zeros()) {
            let nearest = collider.mesh.project_local_point(Vector::ZERO, false).point;
            collider.core = nearest.length() * unit;
        }
        Some(collider)
    }

    /// Largest distance of the surface from the origin of its frame, m.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Vertices in the solid's frame, m.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// True if the solids overlap or their surfaces are nearer than `gap` (m).
    pub fn nearer_than(&self, at: &Place, other: &Self, other_at: &Place, gap: f64) -> bool {
        let distance = (at.0 - other_at.0).norm();
        let apart = distance - self.radius - other.radius;
        if apart > gap.max(0.0) + 1e-6 * self.radius.min(other.radius) {
            return false;
        }
        if self.core > 0.0 && other.core > 0.0 && distance < self.core + other.core {
            return true;
        }
        self.surfaces_nearer_than(at, other, other_at, gap)
            || self.holds(at, &other.some_point(other_at))
            || other.holds(other_at, &self.some_point(at))
    }

    /// True if the two surfaces are nearer than `gap` (m); one solid may be inside the other.
    pub fn surfaces_nearer_than(
        &self,
        at: &Place,
        other: &Self,
        other_at: &Place,
        gap: f64,
    ) -> bool {
        let skin = 1e-6 * self.size().min(other.size());
        let between = pose(at, self.scale).inv_mul(&pose(other_at, self.scale));
        let margin = (gap.max(0.0) + skin) * self.scale;
        let boxes_near = |mine: &BvhNode, its: &BvhNode| {
            let its = its.aabb().transform_by(&between);
            let apart = (mine.mins() - its.maxs).max(its.mins - mine.maxs());
            apart.max_element() <= margin
        };
        self.mesh.bvh().leaf_pairs(other.mesh.bvh(), boxes_near).any(|(mine, its)| {
            let (mine, its) = (self.mesh.triangle(mine), other.mesh.triangle(its));
            let found = DefaultQueryDispatcher.closest_points(&between, &mine, &its, margin);
            // Triangles are supported by the dispatcher; were they not, "near" is the safe answer.
            !matches!(found, Ok(ClosestPoints::Disjoint))
        })
    }

    /// True if a ball overlaps the solid or is nearer to it than `gap` (m).
    pub fn ball_nearer_than(&self, at: &Place, centre: &Vec3, radius: f64, gap: f64) -> bool {
        let local = at.1.inverse_transform_vector(&(centre - at.0));
        let reach = radius + gap.max(0.0);
        let outside = local - local.sup(&self.bounds.low).inf(&self.bounds.high);
        if outside.norm() > reach {
            return false;
        }
        let point = vector(&(local * self.scale));
        let nearest = self.mesh.project_local_point(point, false).point;
        (nearest - point).length() < reach * self.scale || self.holds_local(&local)
    }

    /// True if `point` [m, world] lies inside the solid at `at`.
    pub fn holds(&self, at: &Place, point: &Vec3) -> bool {
        self.holds_local(&at.1.inverse_transform_vector(&(point - at.0)))
    }

    fn size(&self) -> f64 {
        self.bounds.diagonal() * 0.5
    }

    fn some_point(&self, at: &Place) -> Vec3 {
        // A mesh with triangles has vertices: `new` refuses any other.
        at.0 + at.1 * self.vertices.first().copied().unwrap_or_default()
    }

    /// Parity of the crossings of three skew rays, by majority: one ray that
    /// grazes an edge does not decide.
    fn holds_local(&self, point: &Vec3) -> bool {
        if !self.bounds.contains(point) {
            return false;
        }
        let rays = [
            Vector::new(0.7236, 0.5257, 0.4472),
            Vector::new(-0.3171, 0.8944, 0.3155),
            Vector::new(0.2811, -0.4141, 0.8658),
        ];
        rays.iter().filter(|ray| self.crossings(point, ray) % 2 == 1).count() >= 2
    }

    fn crossings(&self, point: &Vec3, along: &Vector) -> usize {
        let origin = vector(&(point * self.scale));
        let ray = Ray::new(origin, along.normalize());
        let bvh = self.mesh.bvh();
        bvh.leaves(|node| node.cast_ray(&ray, f64::MAX) < f64::MAX)
            .filter(|&leaf| {
                self.mesh.triangle(leaf).cast_local_ray(&ray, f64::MAX, false).is_some()
            })
            .count()
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::box_mesh as cuboid;
    use super::*;
    use crate::num::random::{direction, rotation, stream, uniform};

    /// Separating axes of two boxes (exact): least separation over the 15 axes.
    fn boxes_separation(a: &Vec3, at: &Place, b: &Vec3, bt: &Place) -> f64 {
        let axes = |turn: &Rotation| [turn * Vec3::x(), turn * Vec3::y(), turn * Vec3::z()];
        let (u, v) = (axes(&at.1), axes(&bt.1));
        let mut candidates: Vec<Vec3> = u.iter().chain(&v).copied().collect();
        for p in &u {
            for q in &v {
                candidates.push(p.cross(q));
            }
        }
        let between = bt.0 - at.0;
        let mut best = f64::NEG_INFINITY;
        for axis in candidates.iter().filter(|axis| axis.norm() > 1e-9).map(|axis| axis.normalize())
        {
            let half = |e: &[Vec3; 3], s: &Vec3| {
                (0..3).map(|k| 0.5 * s[k] * e[k].dot(&axis).abs()).sum::<f64>()
            };
            best = best.max(between.dot(&axis).abs() - half(&u, a) - half(&v, b));
        }
        best
    }

    #[test]
    fn boxes_agree_with_separating_axes_at_millimetre_size() {
        let mut source = stream(5, "collide", 0);
        let (mut hits, mut misses) = (0, 0);
        for _ in 0..400 {
            let a = Vec3::from_fn(|_, _| uniform(&mut source, 0.3e-3, 2e-3));
            let b = Vec3::from_fn(|_, _| uniform(&mut source, 0.3e-3, 2e-3));
            let at = (Vec3::repeat(0.5), rotation(&mut source));
            let apart = uniform(&mut source, 0.0, 2.5e-3);
            let bt = (at.0 + direction(&mut source) * apart, rotation(&mut source));
            let separation = boxes_separation(&a, &at, &b, &bt);
            if separation.abs() < 1e-8 {
                continue;
            }
            let ca = Collider::new(&cuboid(a), 1e-3).expect("a box");
            let cb = Collider::new(&cuboid(b), 1e-3).expect("a box");
            let near = ca.nearer_than(&at, &cb, &bt, 0.0);
            assert_eq!(near, separation < 0.0, "separation {separation}");
            assert_eq!(near, cb.nearer_than(&bt, &ca, &at, 0.0));
            if near { hits += 1 } else { misses += 1 }
        }
        assert!(hits > 50 && misses > 50, "{hits} {misses}");
    }

    #[test]
    fn aligned_faces_and_containment() {
        let at = |x: f64| (Vec3::new(x, 0.0, 0.0), Rotation::identity());
        let unit = Collider::new(&cuboid(Vec3::repeat(1.0)), 1.0).expect("a box");
        let small = Collider::new(&cuboid(Vec3::repeat(0.1)), 1.0).expect("a box");
        assert!(unit.nearer_than(&at(0.0), &small, &at(0.2), 0.0));
        assert!(small.nearer_than(&at(0.2), &unit, &at(0.0), 0.0));
        assert!(!unit.nearer_than(&at(0.0), &unit, &at(1.001), 0.0));
        assert!(unit.nearer_than(&at(0.0), &unit, &at(1.001), 0.01));
        assert!(unit.nearer_than(&at(0.0), &unit, &at(0.999), 0.0));
        assert!(unit.nearer_than(&at(0.0), &unit, &at(0.0), 0.0));
    }

    #[test]
    fn balls_against_a_box() {
        let place = (Vec3::new(1.0, 2.0, 3.0), Rotation::identity());
        let unit = Collider::new(&cuboid(Vec3::repeat(1.0)), 1.0).expect("a box");
        let near = |x: f64, radius, gap| {
            unit.ball_nearer_than(&place, &(place.0 + Vec3::x() * x), radius, gap)
        };
        assert!(near(0.0, 0.01, 0.0), "inside");
        assert!(near(0.7, 0.21, 0.0));
        assert!(!near(0.7, 0.19, 0.0));
        assert!(near(0.7, 0.19, 0.02));
    }
}
