//! The union of closed solids as one closed surface, by boolmesh (after the
//! method of the Manifold library, Lalish; Smith 2009: topologically robust
//! booleans from symbolically perturbed predicates).
//!
//! Exact to some 1e-12 of the size. Cost: about 5 ms a pair of solids of 1000
//! triangles. Surfaces come back sorted (vertices by coordinates, triangles by
//! corners), because the kernel's own order varies from run to run. Where faces
//! of different solids lie exactly in one plane, the kernel also triangulates
//! that plane differently from run to run: the surface is the same, its
//! triangles may not be. Solids at random angles never meet that case.

use super::check;
use super::error::GeometryError;
use super::{Mesh, MeshFault, topology};
use crate::num::Vec3;
use boolmesh::prelude::{Manifold, OpType, compute_boolean};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The union of `solids`, in double precision. They may be given in any order,
/// also one where some are joined to the rest only by later ones; an error if
/// one is no solid, or if the union is not a single solid (solids that do not
/// touch, or touch only in an edge or a corner).
pub fn unite(solids: &[Mesh]) -> Result<Mesh, GeometryError> {
    let refused = |what: String| move |fault: MeshFault| GeometryError::NoSolid { what, fault };
    let mut sum: Option<Manifold> = None;
    for (index, mesh) in solids.iter().enumerate() {
        let (part, _) =
            check::solid_in_double(mesh.clone()).map_err(refused(format!("solid {index}")))?;
        // The running sum stays in the kernel's own form: there, surfaces that
        // touch in an edge are still two, which welding would make one.
        sum = Some(
            manifold(&part)
                .and_then(|part| match &sum {
                    None => Ok(part),
                    Some(before) => add(before, &part),
                })
                .map_err(|reason| GeometryError::Union { index, reason })?,
        );
    }
    let sum = mesh(&sum.ok_or(GeometryError::NothingToUnite)?);
    let (mut sum, _) = check::solid_in_double(sum).map_err(refused("the union".to_owned()))?;
    sort(&mut sum);
    Ok(sum)
}

/// As [`unite`], for many solids, with cavities filled: also returns how many
/// there were. The solids are united in halves, quarters and so on, so that n
/// of them cost O(n log n) instead of O(n²) where neighbours in the list are
/// neighbours in space.
pub fn unite_filled(solids: &[Mesh]) -> Result<(Mesh, usize), GeometryError> {
    let refused = |what: String| move |fault: MeshFault| GeometryError::NoSolid { what, fault };
    let mut parts = Vec::with_capacity(solids.len());
    for (index, solid) in solids.iter().enumerate() {
        let (part, _) =
            check::solid_in_double(solid.clone()).map_err(refused(format!("solid {index}")))?;
        parts.push(manifold(&part).map_err(|reason| GeometryError::Union { index, reason })?);
    }
    let mut width = 1;
    while parts.len() > 1 {
        let mut joined = Vec::with_capacity(parts.len().div_ceil(2));
        let mut rest = parts.into_iter();
        while let Some(first) = rest.next() {
            let Some(second) = rest.next() else {
                joined.push(first);
                break;
            };
            let index = (2 * joined.len() + 1) * width;
            joined.push(
                add(&first, &second).map_err(|reason| GeometryError::Union { index, reason })?,
            );
        }
        parts = joined;
        width *= 2;
    }
    let mut sum = mesh(parts.first().ok_or(GeometryError::NothingToUnite)?);
    let cavities = fill_cavities(&mut sum);
    let (mut sum, _) = check::solid_in_double(sum).map_err(refused("the union".to_owned()))?;
    sort(&mut sum);
    Ok((sum, cavities))
}

/// Drops pieces of the surface that enclose a cavity: those of negative volume.
fn fill_cavities(mesh: &mut Mesh) -> usize {
    let (piece, pieces) = topology::pieces(mesh);
    let shift = mesh.bounds().centre();
    let mut volumes = vec![0.0; pieces];
    for (corners, piece) in mesh.facets().zip(&piece) {
        let [a, b, c] = corners.map(|p| p - shift);
        volumes[*piece as usize] += a.dot(&b.cross(&c));
    }
    let mut numbers = piece.iter();
    mesh.triangles.retain(|_| numbers.next().is_none_or(|piece| volumes[*piece as usize] > 0.0));
    volumes.iter().filter(|volume| **volume <= 0.0).count()
}

fn add(first: &Manifold, second: &Manifold) -> Result<Manifold, String> {
    // The kernel indexes with results of its own predicates; should one of
    // those be inconsistent, it panics, which is a refusal here and no crash.
    catch_unwind(AssertUnwindSafe(|| compute_boolean(first, second, OpType::Add)))
        .map_err(|_| "the boolean kernel failed".to_owned())?
}

fn mesh(manifold: &Manifold) -> Mesh {
    Mesh {
        vertices: manifold.ps.iter().map(|p| Vec3::new(p.x, p.y, p.z)).collect(),
        triangles: manifold
            .hs
            .chunks_exact(3)
            .filter(|sides| sides.iter().all(|side| side.tail().is_some()))
            .map(|sides| std::array::from_fn(|k| sides[k].tail as u32))
            .collect(),
    }
}

fn manifold(mesh: &Mesh) -> Result<Manifold, String> {
    let positions: Vec<f64> = mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    let corners: Vec<usize> = mesh.triangles.iter().flatten().map(|i| *i as usize).collect();
    Manifold::new(&positions, &corners)
}

/// Sorts vertices by coordinates and triangles by corners, each from its smallest corner on.
fn sort(mesh: &mut Mesh) {
    let mut order: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    order.sort_by(|i, j| {
        let (a, b) = (mesh.vertices[*i as usize], mesh.vertices[*j as usize]);
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
    });
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(new, old)| place[*old as usize] = new as u32);
    mesh.vertices = order.iter().map(|old| mesh.vertices[*old as usize]).collect();
    for triangle in &mut mesh.triangles {
        *triangle = triangle.map(|corner| place[corner as usize]);
        let smallest = (0..3).fold(0, |s, k| if triangle[k] < triangle[s] { k } else { s });
        triangle.rotate_left(smallest);
    }
    mesh.triangles.sort_unstable();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Posed, Primitive, topology::inspect};
    use crate::num::{Rotation, random};

    fn cube_at(x: f64, y: f64, z: f64) -> Mesh {
        let cube = Primitive::Box { edges: Vec3::repeat(1.0) };
        Posed { primitive: cube, rotation: Rotation::identity(), centre: Vec3::new(x, y, z) }
            .mesh(3)
    }

    #[test]
    fn boxes_that_share_faces_become_one() {
        let row: Vec<Mesh> = (0..4).map(|i| cube_at(f64::from(i), 0.0, 0.0)).collect();
        let mesh = unite(&row).expect("a row of boxes");
        let report = inspect(&mesh);
        assert!(report.is_closed() && report.euler_characteristic == 2);
        assert!((report.volume - 4.0).abs() < 1e-12);
        assert!((mesh.area() - 18.0).abs() < 1e-12);
    }

    #[test]
    fn boxes_on_a_grid_with_shared_faces_and_edges() {
        for seed in 0..20 {
            let mut source = random::stream(seed, "grid", 0);
            let mut cells: Vec<[u64; 3]> = vec![[0, 0, 0]];
            while cells.len() < 12 {
                // Growth over faces only, so that the union is one piece.
                let mut next =
                    cells[random::whole(&mut source, 0, cells.len() as u64 - 1) as usize];
                next[random::whole(&mut source, 0, 2) as usize] += 1;
                if !cells.contains(&next) {
                    cells.push(next);
                }
            }
            let boxes: Vec<Mesh> =
                cells.iter().map(|c| cube_at(c[0] as f64, c[1] as f64, c[2] as f64)).collect();
            match unite(&boxes) {
                Ok(mesh) => {
                    let report = inspect(&mesh);
                    assert!(report.is_closed());
                    assert!((report.volume - 12.0).abs() < 1e-9, "{seed}: {}", report.volume);
                }
                // Cells that meet along an edge only are no solid, and said to be none.
                Err(GeometryError::NoSolid { fault: MeshFault::NonManifold { .. }, .. }) => {}
                Err(other) => panic!("{seed}: {other}"),
            }
        }
    }

    #[test]
    fn two_cubes_through_each_other_have_the_known_volume() {
        let mesh = unite(&[cube_at(0.0, 0.0, 0.0), cube_at(0.25, 0.5, 0.75)]).expect("overlap");
        assert!((mesh.mass_properties().volume - (2.0 - 0.75 * 0.5 * 0.25)).abs() < 1e-12);
    }

    #[test]
    fn solids_apart_are_refused_unless_joined_later() {
        let (left, middle, right) =
            (cube_at(0.0, 0.0, 0.0), cube_at(0.9, 0.1, 0.2), cube_at(1.8, 0.0, 0.0));
        let fault = unite(&[left.clone(), right.clone()]).expect_err("a gap between them");
        assert!(fault.to_string().contains("2 pieces"), "{fault}");
        let joined = unite(&[left.clone(), right, middle]).expect("joined by the last");
        assert_eq!(inspect(&joined).pieces, 1);
        let corner = cube_at(1.0, 1.0, 1.0);
        assert!(unite(&[left.clone(), corner]).is_err());
        let inside = Primitive::Sphere { diameter: 0.5 }.mesh(12);
        let alone = unite(&[left, inside]).expect("the small one vanishes");
        assert!((alone.mass_properties().volume - 1.0).abs() < 1e-12);
        assert_eq!(unite(&[]), Err(GeometryError::NothingToUnite));
        assert!(unite(&[Mesh::default()]).is_err());
    }

    #[test]
    fn uniting_in_halves_gives_the_same_solid_and_fills_cavities() {
        // Six plates around an empty middle.
        let plates: Vec<Mesh> = (0..6)
            .map(|face| {
                let mut edges = Vec3::repeat(3.0 + 0.1 * f64::from(face));
                edges[face as usize % 3] = 1.0;
                let mut centre = Vec3::zeros();
                centre[face as usize % 3] = if face < 3 { -1.2 } else { 1.2 };
                let rotation = Rotation::identity();
                Posed { primitive: Primitive::Box { edges }, rotation, centre }.mesh(3)
            })
            .collect();
        let (filled, cavities) = unite_filled(&plates).expect("one piece");
        assert_eq!(cavities, 1);
        assert!(unite(&plates).is_err(), "the cavity is a second surface");
        let whole = filled.mass_properties().volume;
        let hollow = plates[0].mass_properties().volume;
        assert!(whole > 27.0 && hollow < 11.0, "{whole}");
        let row: Vec<Mesh> = (0..5).map(|i| cube_at(0.7 * f64::from(i), 0.1, 0.0)).collect();
        let (joined, none) = unite_filled(&row).expect("a row");
        assert_eq!(none, 0);
        assert!((joined.mass_properties().volume - 3.8).abs() < 1e-12);
    }

    #[test]
    fn the_same_solids_give_the_same_bytes() {
        let mut source = random::stream(9, "same", 0);
        let parts: Vec<Mesh> = (0..5)
            .map(|_| {
                Posed {
                    primitive: Primitive::Cylinder { diameter: 1.0, height: 1.5 },
                    rotation: random::rotation(&mut source),
                    centre: Vec3::zeros(),
                }
                .mesh(24)
            })
            .collect();
        let first = unite(&parts).expect("they share the origin");
        for _ in 0..3 {
            assert_eq!(first, unite(&parts).expect("as before"));
        }
    }
}
