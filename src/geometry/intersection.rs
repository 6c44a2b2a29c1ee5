//! Does a surface pass through itself?
//!
//! Pairs of triangles with overlapping boxes (parry's bounding volume tree) are
//! compared: they intersect if an edge of one passes through the inside of the
//! other (Möller & Trumbore 1997). Neighbours along an edge count only where one
//! is folded flat onto the other. Coplanar triangles that overlap without such
//! a crossing are not found. Cost O(n log n) for n triangles of similar size.

use super::{Bounds, Mesh};
use crate::num::Vec3;
use parry3d::bounding_volume::Aabb;
use parry3d::math::Vec3 as Point;
use parry3d::partitioning::{Bvh, BvhBuildStrategy};

/// Pairs of triangles (smaller number first, sorted) of which one passes
/// through the other by more than `depth` (m), measured from the plane of the
/// one to the nearer end of the edge of the other.
pub fn self_intersections(mesh: &Mesh, depth: f64) -> Vec<(u32, u32)> {
    let boxes: Vec<Aabb> = mesh
        .facets()
        .map(|corners| {
            let Bounds { low, high } = Bounds::of(&corners);
            Aabb::new(Point::new(low.x, low.y, low.z), Point::new(high.x, high.y, high.z))
        })
        .collect();
    let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    let mut pairs = Vec::new();
    for (first, bounds) in boxes.iter().enumerate() {
        for second in tree.intersect_aabb(bounds) {
            if first < second as usize && meet(mesh, first, second as usize, depth) {
                pairs.push((first as u32, second));
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

fn meet(mesh: &Mesh, first: usize, second: usize, depth: f64) -> bool {
    let (s, t) = (mesh.triangles[first], mesh.triangles[second]);
    let shared = s.iter().filter(|corner| t.contains(corner)).count();
    if shared >= 2 {
        return folded(mesh, s, t, depth);
    }
    // Edges that end in a shared vertex only touch the other triangle there.
    pierces(mesh, s, t, depth) || pierces(mesh, t, s, depth)
}

/// True if an edge of `s` that has no end in common with `t` passes through `t`.
fn pierces(mesh: &Mesh, s: [u32; 3], t: [u32; 3], depth: f64) -> bool {
    let [a, b, c] = t.map(|corner| mesh.vertices[corner as usize]);
    let normal = (b - a).cross(&(c - a));
    let area = normal.norm();
    if area == 0.0 {
        return false;
    }
    (0..3).any(|k| {
        let ends = [s[k], s[(k + 1) % 3]];
        if ends.iter().any(|end| t.contains(end)) {
            return false;
        }
        let [p, q] = ends.map(|end| mesh.vertices[end as usize]);
        let (above, below) = (normal.dot(&(p - a)) / area, normal.dot(&(q - a)) / area);
        if above * below >= 0.0 || above.abs().min(below.abs()) <= depth {
            return false;
        }
        let crossing = p + (q - p) * (above / (above - below));
        inside(&crossing, [a, b, c], &normal, depth)
    })
}

/// True if `point` in the plane of the triangle lies inside it by more than `depth`.
fn inside(point: &Vec3, [a, b, c]: [Vec3; 3], normal: &Vec3, depth: f64) -> bool {
    [(a, b), (b, c), (c, a)].iter().all(|(p, q)| {
        let edge = q - p;
        let inwards = normal.cross(&edge);
        inwards.dot(&(point - p)) > depth * inwards.norm()
    })
}

/// True if two triangles with a common edge lie on top of each other.
fn folded(mesh: &Mesh, s: [u32; 3], t: [u32; 3], depth: f64) -> bool {
    let (Some(apex), Some(other)) =
        (s.iter().find(|corner| !t.contains(corner)), t.iter().find(|corner| !s.contains(corner)))
    else {
        return true;
    };
    let common: Vec<Vec3> = s
        .iter()
        .filter(|corner| t.contains(corner))
        .map(|corner| mesh.vertices[*corner as usize])
        .collect();
    let along = common[1] - common[0];
    let away = |corner: u32| {
        let arm = mesh.vertices[corner as usize] - common[0];
        arm - along * (arm.dot(&along) / along.norm_squared())
    };
    let (u, v) = (away(*apex), away(*other));
    let reach = u.norm().min(v.norm());
    reach > depth && u.dot(&v) > 0.0 && u.cross(&v).norm() <= 1e-9 * u.norm() * v.norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;

    #[test]
    fn convex_solids_do_not_meet_themselves() {
        for solid in [
            Primitive::Box { edges: Vec3::new(1.0, 2.0, 3.0) },
            Primitive::Cylinder { diameter: 1.0, height: 2.0 },
            Primitive::Sphere { diameter: 1.0 },
        ] {
            assert_eq!(self_intersections(&solid.mesh(24), 0.0), vec![]);
        }
    }

    #[test]
    fn a_vertex_pushed_through_the_far_side_is_found() {
        let mut mesh = Primitive::Sphere { diameter: 1.0 }.mesh(20);
        let deepest = mesh.vertices[0];
        mesh.vertices[0] = deepest * -1.2;
        let pairs = self_intersections(&mesh, 1e-6);
        assert!(!pairs.is_empty());
        assert!(
            pairs
                .iter()
                .all(|(i, j)| { [i, j].iter().any(|t| mesh.triangles[**t as usize].contains(&0)) })
        );
        // Pushed in only half way, nothing meets.
        mesh.vertices[0] = deepest * 0.5;
        assert_eq!(self_intersections(&mesh, 1e-6), vec![]);
    }

    #[test]
    fn a_flat_fold_is_found() {
        let mesh = Mesh {
            vertices: vec![
                Vec3::zeros(),
                Vec3::x(),
                Vec3::new(0.3, 1.0, 0.0),
                Vec3::new(0.6, 0.7, 0.0),
            ],
            triangles: vec![[0, 1, 2], [1, 0, 3]],
        };
        assert_eq!(self_intersections(&mesh, 0.0), vec![(0, 1)]);
    }
}
