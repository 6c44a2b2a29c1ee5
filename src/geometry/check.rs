//! The gate: a mesh is a solid, or it is refused with a reason.
//!
//! A solid is one closed, connected, outward-oriented surface of positive
//! volume. Coordinates are rounded to single precision first, because binary
//! STL holds no more: what is closed in double precision can be non-manifold
//! in single precision, so the rounded surface is the one that is judged.

use super::intersection::self_intersections;
use super::repair::{self, Repairs};
use super::{Mesh, topology};
use crate::num::Vec3;
use thiserror::Error;

/// Welding distance, over the diagonal of the bounding box, that is tried when
/// a surface is open with vertices welded only where they are equal.
const LOOSE_WELD: f64 = 1e-6;
/// Height over the diagonal below which a triangle counts as a line.
const SLIVER: f64 = 1e-9;
/// Depth over the diagonal from which on triangles count as passing through each other.
const CROSSING: f64 = 1e-5;
/// Relative rounding error of single precision, for the least credible volume.
const SINGLE: f64 = 6e-8;

/// Why a mesh is no solid.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeshFault {
    /// There is no triangle at all.
    #[error("empty: there is no triangle{}", left(*dropped))]
    Empty {
        /// Triangles that were there before those without area went.
        dropped: usize,
    },
    /// A corner index points at no vertex.
    #[error("triangle {triangle} names vertex {vertex}, but there are {vertices} vertices")]
    NoSuchVertex {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// The index it names.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A coordinate is NaN, infinite, or too large for single precision.
    #[error("triangle {triangle} has a corner at ({}, {}, {}), which is no finite point in single precision", at.x, at.y, at.z)]
    NotFinite {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// The corner.
        at: Vec3,
    },
    /// There are holes.
    #[error("open: {edges} edges belong to one triangle only, first at {}", point(at))]
    Open {
        /// Number of such edges.
        edges: usize,
        /// Middle of the first one.
        at: Vec3,
    },
    /// More than two triangles share an edge.
    #[error(
        "non-manifold: {edges} edges belong to more than two triangles, first at {}",
        point(at)
    )]
    NonManifold {
        /// Number of such edges.
        edges: usize,
        /// Middle of the first one.
        at: Vec3,
    },
    /// The surface has one side only.
    #[error("not orientable: the surface has one side only, seen at {}", point(at))]
    OneSided {
        /// Middle of a triangle where both orientations meet.
        at: Vec3,
    },
    /// Several surfaces.
    #[error(
        "{pieces} pieces: a solid is one connected surface (a cavity inside is a second one); the second piece has a corner at {}",
        point(at)
    )]
    Pieces {
        /// Number of pieces.
        pieces: usize,
        /// A corner of the second piece.
        at: Vec3,
    },
    /// The surface passes through itself.
    #[error(
        "self-intersecting: {pairs} pairs of triangles pass through each other, first at {}",
        point(at)
    )]
    SelfIntersecting {
        /// Number of such pairs.
        pairs: usize,
        /// Middle of the first triangle.
        at: Vec3,
    },
    /// Nothing is enclosed.
    #[error(
        "no volume: the surface of {area:e} m² encloses {volume:e} m³, within rounding of nothing"
    )]
    NoVolume {
        /// Surface area, m².
        area: f64,
        /// Volume, m³.
        volume: f64,
    },
}

fn left(dropped: usize) -> String {
    if dropped == 0 {
        return String::new();
    }
    format!(" left of {dropped}: they have no area or face each other")
}

fn point(at: &Vec3) -> String {
    format!("({:e}, {:e}, {:e})", at.x, at.y, at.z)
}

/// The solid that `mesh` is, with all coordinates exactly representable in
/// single precision, and what had to be repaired; or why it is none.
///
/// Repaired without question: equal vertices, triangles without area, repeated
/// triangles, orientation. If holes remain, vertices nearer than 1e-6 of the
/// diagonal are welded too. Intersections of the surface with itself are not
/// looked for here: see [`simple`].
pub fn solid(mesh: Mesh) -> Result<(Mesh, Repairs), MeshFault> {
    finite(&mesh)?;
    let mut mesh = mesh;
    repair::round_to_single(&mut mesh);
    let reach = reach(&mesh);
    judge(mesh, SINGLE * reach)
}

/// An error if `mesh` passes through itself by more than 1e-5 of its diagonal:
/// rounding to single precision moves slivers by less.
pub fn simple(mesh: &Mesh) -> Result<(), MeshFault> {
    let pairs = self_intersections(mesh, CROSSING * mesh.bounds().diagonal());
    let Some((first, _)) = pairs.first() else { return Ok(()) };
    let at = mesh.corners(*first as usize).iter().sum::<Vec3>() / 3.0;
    Err(MeshFault::SelfIntersecting { pairs: pairs.len(), at })
}

/// As [`solid`], without rounding: for steps on the way to a solid.
pub fn solid_in_double(mesh: Mesh) -> Result<(Mesh, Repairs), MeshFault> {
    let reach = reach(&mesh);
    judge(mesh, f64::EPSILON * reach)
}

/// Largest coordinate, either sign.
fn reach(mesh: &Mesh) -> f64 {
    mesh.vertices.iter().fold(0.0f64, |most, p| most.max(p.amax()))
}

/// Judges a mesh whose coordinates are known to within `rounding` [m].
fn judge(mut mesh: Mesh, rounding: f64) -> Result<(Mesh, Repairs), MeshFault> {
    finite(&mesh)?;
    let mut repairs = Repairs { unused: repair::drop_unused(&mut mesh), ..Repairs::default() };
    let before = mesh.triangles.len();
    let diagonal = mesh.bounds().diagonal();
    tidy(&mut mesh, 0.0, diagonal, false, &mut repairs);
    if topology::edges(&mesh).iter().any(|edge| edge.triangles.len() == 1) {
        tidy(&mut mesh, LOOSE_WELD * diagonal, diagonal, false, &mut repairs);
    }
    // Vertices left without a triangle by the repairs are part of those repairs.
    repair::drop_unused(&mut mesh);
    if mesh.triangles.is_empty() {
        return Err(MeshFault::Empty { dropped: before });
    }
    manifold(&mesh)?;
    repairs.flipped = repair::orient(&mut mesh).map_err(|at| MeshFault::OneSided { at })?;
    repairs.inside_out = repairs.flipped == mesh.triangles.len();
    one_piece(&mesh)?;
    let (volume, area) = (mesh.mass_properties().volume, mesh.area());
    if volume <= rounding * area {
        return Err(MeshFault::NoVolume { area, volume });
    }
    Ok((mesh, repairs))
}

/// A surface that need not be closed (a wall) with equal vertices welded and
/// degenerate and repeated triangles dropped, in double precision, and what was
/// repaired. Refused only where it is empty or not finite.
pub fn surface(mesh: Mesh) -> Result<(Mesh, Repairs), MeshFault> {
    finite(&mesh)?;
    let mut mesh = mesh;
    let mut repairs = Repairs { unused: repair::drop_unused(&mut mesh), ..Repairs::default() };
    let before = mesh.triangles.len();
    let diagonal = mesh.bounds().diagonal();
    tidy(&mut mesh, 0.0, diagonal, true, &mut repairs);
    repair::drop_unused(&mut mesh);
    if mesh.triangles.is_empty() {
        return Err(MeshFault::Empty { dropped: before });
    }
    Ok((mesh, repairs))
}

fn tidy(mesh: &mut Mesh, weld: f64, diagonal: f64, keep_one: bool, repairs: &mut Repairs) {
    repairs.welded += repair::weld(mesh, weld);
    repairs.degenerate += repair::drop_degenerate(mesh);
    repairs.slivers += repair::drop_slivers(mesh, SLIVER * diagonal);
    let (duplicates, cancelled) = repair::drop_duplicates(mesh, keep_one);
    repairs.duplicates += duplicates;
    repairs.cancelled += cancelled;
}

fn finite(mesh: &Mesh) -> Result<(), MeshFault> {
    if mesh.triangles.is_empty() {
        return Err(MeshFault::Empty { dropped: 0 });
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for corner in corners {
            let at = *mesh.vertices.get(*corner as usize).ok_or(MeshFault::NoSuchVertex {
                triangle,
                vertex: *corner,
                vertices: mesh.vertices.len(),
            })?;
            if !at.iter().all(|x| x.is_finite()) {
                return Err(MeshFault::NotFinite { triangle, at });
            }
        }
    }
    Ok(())
}

fn manifold(mesh: &Mesh) -> Result<(), MeshFault> {
    let edges = topology::edges(mesh);
    let middle = |edge: &topology::Edge| {
        edge.ends.iter().map(|end| mesh.vertices[*end as usize]).sum::<Vec3>() * 0.5
    };
    let crowded: Vec<_> = edges.iter().filter(|edge| edge.triangles.len() > 2).collect();
    let open: Vec<_> = edges.iter().filter(|edge| edge.triangles.len() == 1).collect();
    match (open.first(), crowded.first()) {
        (Some(first), _) => Err(MeshFault::Open { edges: open.len(), at: middle(first) }),
        (None, Some(first)) => {
            Err(MeshFault::NonManifold { edges: crowded.len(), at: middle(first) })
        }
        (None, None) => Ok(()),
    }
}

fn one_piece(mesh: &Mesh) -> Result<(), MeshFault> {
    let (numbers, pieces) = topology::pieces(mesh);
    let Some(second) = numbers.iter().position(|number| *number == 1) else { return Ok(()) };
    Err(MeshFault::Pieces { pieces, at: mesh.corners(second)[0] })
}

#[cfg(test)]
mod tests;
