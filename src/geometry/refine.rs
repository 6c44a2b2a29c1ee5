//! A finer mesh of the same surface: every edge longer than a limit is halved,
//! again and again; triangles are cut at the new middles (one, two or three).
//!
//! Neighbours share the new vertices, so a closed mesh stays closed. The
//! surface is the same to rounding. Cost O(n log n) a pass, log₂(longest edge /
//! limit) passes.

use super::Mesh;
use crate::num::Vec3;
use std::collections::BTreeMap;

/// `mesh` with no edge longer than `length` (m), or as fine as 20 passes make it.
pub fn refined(mesh: &Mesh, length: f64) -> Mesh {
    let mut mesh = mesh.clone();
    for _ in 0..20 {
        if !halve(&mut mesh, length) {
            break;
        }
    }
    mesh
}

/// One pass; false if no edge was too long.
fn halve(mesh: &mut Mesh, length: f64) -> bool {
    let mut middles: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let mut vertices = std::mem::take(&mut mesh.vertices);
    let mut middle = |vertices: &mut Vec<Vec3>, a: u32, b: u32| -> Option<u32> {
        // The ends in one order, so that both neighbours judge and round alike.
        let (low, high) = (a.min(b), a.max(b));
        let (p, q) = (vertices[low as usize], vertices[high as usize]);
        if (p - q).norm() <= length {
            return None;
        }
        Some(*middles.entry((low, high)).or_insert_with(|| {
            vertices.push((p + q) * 0.5);
            vertices.len() as u32 - 1
        }))
    };
    let mut triangles = Vec::with_capacity(2 * mesh.triangles.len());
    let mut any = false;
    for &[a, b, c] in &mesh.triangles {
        let cuts = [(a, b), (b, c), (c, a)].map(|(from, to)| middle(&mut vertices, from, to));
        any |= cuts.iter().any(Option::is_some);
        triangles.extend(cut([a, b, c], cuts, &vertices));
    }
    mesh.vertices = vertices;
    mesh.triangles = triangles;
    any
}

/// The parts of a triangle whose edges ab, bc, ca have the given new middles.
fn cut(corners: [u32; 3], cuts: [Option<u32>; 3], vertices: &[Vec3]) -> Vec<[u32; 3]> {
    for turn in 0..3 {
        let [a, b, c] = [0, 1, 2].map(|k| corners[(k + turn) % 3]);
        match [0, 1, 2].map(|k| cuts[(k + turn) % 3]) {
            [None, None, None] => return vec![corners],
            [Some(ab), None, None] => return vec![[a, ab, c], [ab, b, c]],
            [Some(ab), Some(bc), None] => {
                // The shorter diagonal of the quadrangle a, ab, bc, c.
                let span =
                    |i: u32, j: u32| (vertices[i as usize] - vertices[j as usize]).norm_squared();
                return if span(a, bc) <= span(ab, c) {
                    vec![[ab, b, bc], [a, ab, bc], [a, bc, c]]
                } else {
                    vec![[ab, b, bc], [a, ab, c], [ab, bc, c]]
                };
            }
            [Some(ab), Some(bc), Some(ca)] => {
                return vec![[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
            }
            _ => {}
        }
    }
    vec![corners]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Primitive, topology::inspect};

    #[test]
    fn the_surface_stays_and_edges_become_short() {
        for solid in [
            Primitive::Box { edges: Vec3::new(3.0, 1.0, 0.2) },
            Primitive::Cone { diameter: 1.0, height: 2.0 },
        ] {
            let coarse = solid.mesh(9);
            let fine = refined(&coarse, 0.15);
            let report = inspect(&fine);
            assert!(report.is_closed() && report.euler_characteristic == 2, "{report:?}");
            assert!((fine.area() - coarse.area()).abs() < 1e-9);
            assert!((report.volume - coarse.mass_properties().volume).abs() < 1e-12);
            let longest = fine
                .facets()
                .flat_map(|[a, b, c]| [(a - b).norm(), (b - c).norm(), (c - a).norm()])
                .fold(0.0, f64::max);
            assert!(longest <= 0.15, "{longest}");
        }
    }
}
