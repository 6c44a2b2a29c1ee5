//! Small closed surfaces that tests of several rooms share.

use super::Mesh;
use crate::num::Vec3;
use crate::num::random::{stream, uniform};
use std::collections::HashMap;

/// Box of the given edges about the origin.
pub fn box_mesh(edges: Vec3) -> Mesh {
    let vertices = (0..8)
        .map(|i| {
            let corner = Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
            (corner - Vec3::repeat(0.5)).component_mul(&edges)
        })
        .collect();
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { vertices, triangles }
}

/// Unit sphere from an icosahedron halved `level` times, corners on the sphere.
pub fn icosphere(level: usize) -> Mesh {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut vertices: Vec<Vec3> = [
        (-1.0, g, 0.0),
        (1.0, g, 0.0),
        (-1.0, -g, 0.0),
        (1.0, -g, 0.0),
        (0.0, -1.0, g),
        (0.0, 1.0, g),
        (0.0, -1.0, -g),
        (0.0, 1.0, -g),
        (g, 0.0, -1.0),
        (g, 0.0, 1.0),
        (-g, 0.0, -1.0),
        (-g, 0.0, 1.0),
    ]
    .iter()
    .map(|&(x, y, z)| Vec3::new(x, y, z).normalize())
    .collect();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..level {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
            })
            .collect();
    }
    Mesh { vertices, triangles }
}

/// L-shaped prism: the 2 × 2 square without its upper right quarter, 1 high.
pub fn l_mesh() -> Mesh {
    let outline = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
    let vertices =
        [0.0, 1.0].iter().flat_map(|&z| outline.map(|(x, y)| Vec3::new(x, y, z))).collect();
    let mut triangles = Vec::new();
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        triangles.push([a, c, b]);
        triangles.push([a + 6, b + 6, c + 6]);
    }
    for i in 0..6 {
        let j = (i + 1) % 6;
        triangles.push([i, j, j + 6]);
        triangles.push([i, j + 6, i + 6]);
    }
    Mesh { vertices, triangles }
}

/// Icosphere whose corners are moved along their rays by up to `rough` of the
/// radius at random: star-shaped, strongly non-convex.
pub fn random_star(seed: u64, rough: f64) -> Mesh {
    let mut source = stream(seed, "random star", 0);
    let mut mesh = icosphere(2);
    for vertex in &mut mesh.vertices {
        *vertex *= 1.0 - rough * uniform(&mut source, 0.0, 1.0);
    }
    mesh
}

/// Ellipsoid with the given half axes.
pub fn ellipsoid_mesh(half: Vec3) -> Mesh {
    icosphere(3).mapped(|v| v.component_mul(&half))
}

/// Union of `count` turned boxes about the origin, rounded to single precision:
/// concave edges, slivers, and triangles that rounding has all but flattened.
pub fn random_union(seed: u64, count: usize) -> Mesh {
    use boolmesh::prelude::{Manifold, OpType, compute_boolean};
    let mut source = stream(seed, "random union", 0);
    let mut part = || {
        let edges = Vec3::from_fn(|_, _| uniform(&mut source, 0.2, 1.5));
        let turn = crate::num::random::rotation(&mut source);
        let mesh = box_mesh(edges).mapped(|v| turn * v);
        let positions: Vec<f64> = mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let corners: Vec<usize> = mesh.triangles.iter().flatten().map(|i| *i as usize).collect();
        Manifold::new(&positions, &corners).expect("a box")
    };
    let mut sum = part();
    for _ in 1..count {
        sum = compute_boolean(&sum, &part(), OpType::Add).expect("boxes in general position");
    }
    Mesh {
        vertices: sum
            .ps
            .iter()
            .map(|p| Vec3::new(p.x, p.y, p.z).map(|c| f64::from(c as f32)))
            .collect(),
        triangles: sum
            .hs
            .chunks_exact(3)
            .filter(|sides| sides.iter().all(|side| side.tail().is_some()))
            .map(|sides| std::array::from_fn(|k| sides[k].tail as u32))
            .collect(),
    }
}
