//! Largest spheres of a voxel image by its distance transform.
//!
//! Source: Angelidakis, Nadimi, Otsubo & Utili 2021, SoftwareX 15, 100735 (CLUMP,
//! "Euclidean 3D"). The solid becomes cells; the cell farthest from the outside is the centre
//! of a sphere whose radius is that distance; the part of the sphere within (1 − overlap) of
//! its radius becomes outside; again, until there are enough spheres or the next would be too
//! small. Every sphere lies inside to half a cell.
//!
//! Unlike the source's program, spheres come back in the frame of the solid (cells are
//! measured from their centres), the radius is the exact distance of the centre from the
//! surface where that is less, and spheres apart from the largest piece are left out.
//! Cost O(cells) a sphere: 1.5 ms at 50 cells across.

use super::ClumpError;
use super::pieces::largest_piece;
use super::target::{Found, Target};
use super::voxels::Voxels;
use crate::geometry::Ball;
use crate::num::{Fault, Job, MethodEntry};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `riprap list clumps` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "euclidean",
    id: "",
    summary: "the largest sphere that fits in what is left of a voxel image, again and again",
    source: "Angelidakis et al. 2021",
    example: r#"clump.euclidean = { spheres = 20 }"#,
};

/// Cells before the work is refused: about a gigabyte and a minute.
const MOST_CELLS: f64 = 2e7;

/// Largest spheres of a voxel image by its distance transform.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Euclidean {
    /// Most spheres; 1 to 1000, default 20.
    #[serde(default = "default_spheres")]
    pub spheres: usize,
    /// Cells over one equivalent diameter; 10 to 200, default 50.
    #[serde(default = "default_across")]
    pub across: f64,
    /// Share of the radius by which later spheres may reach into a sphere; 0.05 to 0.95, default 0.6.
    #[serde(default = "default_overlap")]
    pub overlap: f64,
    /// Least radius as a share of the equivalent diameter; 0.001 to 0.5, default 0.01.
    #[serde(default = "default_smallest")]
    pub smallest: f64,
}

fn default_spheres() -> usize {
    20
}
fn default_across() -> f64 {
    50.0
}
fn default_overlap() -> f64 {
    0.6
}
fn default_smallest() -> f64 {
    0.01
}

impl Default for Euclidean {
    fn default() -> Self {
        Self {
            spheres: default_spheres(),
            across: default_across(),
            overlap: default_overlap(),
            smallest: default_smallest(),
        }
    }
}

impl Euclidean {
    /// # Errors
    /// [`Fault`] for a value out of its range.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("spheres", self.spheres as f64, 1.0, 1000.0)?;
        Fault::within("across", self.across, 10.0, 200.0)?;
        Fault::within("overlap", self.overlap, 0.05, 0.95)?;
        Fault::within("smallest", self.smallest, 1e-3, 0.5)
    }

    pub(super) fn find(&self, target: &Target, job: &Job) -> Result<Found, ClumpError> {
        let edge = target.diameter / self.across;
        let cells = Voxels::number(&target.solid.mesh, edge);
        if cells > MOST_CELLS {
            return Err(Fault::new(
                "euclidean.across",
                format!("is {} and makes {cells:.1e} cells around this solid", self.across),
                format!("a value that makes at most {MOST_CELLS:.0e} cells"),
            )
            .into());
        }
        let mut voxels = Voxels::new(&target.solid.mesh, edge);
        let mut balls = Vec::new();
        while balls.len() < self.spheres {
            if job.is_cancelled() {
                return Err(ClumpError::Cancelled);
            }
            let squares = voxels.squared_distances();
            let (cell, square) =
                squares.iter().copied().enumerate().fold((0, 0.0), |best: (usize, f64), now| {
                    if now.1 > best.1 { now } else { best }
                });
            let centre = voxels.centre(cell);
            // The outer cell's own boundary is about half an edge nearer than its centre.
            let left = (square.sqrt() - 0.5) * edge;
            if left < self.smallest * target.diameter {
                break;
            }
            // What was cleared of earlier spheres is no surface, but holds later ones back by the overlap.
            let inside = -target.distance.at(&centre);
            let radius = inside.min(left / (1.0 - self.overlap));
            if radius <= 0.0 {
                voxels.clear(&centre, 0.5 * edge);
                continue;
            }
            balls.push(Ball { centre, radius });
            voxels.clear(&centre, (radius * (1.0 - self.overlap)).max(0.6 * edge));
            job.report("spheres", balls.len() as u64, self.spheres as u64);
        }
        let (balls, dropped) = largest_piece(balls);
        if balls.is_empty() {
            return Err(ClumpError::NoSphere {
                name: target.solid.name.clone(),
                advice: "raise `across` or lower `smallest`",
            });
        }
        let left = match dropped {
            0 => String::new(),
            count => format!("; {count} spheres apart from the largest piece left out"),
        };
        let note = format!(
            "euclidean (Angelidakis et al. 2021): {} of at most {} spheres, {} cells across, overlap {}{left}",
            balls.len(),
            self.spheres,
            self.across,
            self.overlap
        );
        Ok(Found { balls, note })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clump::reproduce::tests::solid;
    use crate::clump::{MassSource, Method, reproduce};
    use crate::geometry::SignedDistance;
    use crate::geometry::samples::{box_mesh, random_star};
    use crate::num::Vec3;

    #[test]
    fn the_first_sphere_of_a_cube_is_its_inscribed_one_and_all_lie_inside() {
        for (mesh, first) in [
            (box_mesh(Vec3::repeat(2.0)).mapped(|v| v + Vec3::repeat(5.0)), Some(1.0)),
            (random_star(4, 0.5), None),
        ] {
            let distance = SignedDistance::new(&mesh).expect("closed");
            let solid = solid("x", mesh);
            let method = Euclidean { spheres: 15, across: 24.0, ..Euclidean::default() };
            let clump = reproduce(
                &solid,
                &Method::Euclidean(method),
                MassSource::Solid,
                1,
                0,
                &Job::quiet(),
            )
            .expect("a clump");
            let balls = clump.in_solid_frame();
            assert!(balls.len() > 8, "{}", clump.method);
            assert!(balls.iter().all(|b| b.radius + distance.at(&b.centre) < 1e-9));
            if let Some(radius) = first {
                // Its centre is known to half a cell along each axis.
                assert!((balls[0].radius - radius).abs() < 0.1, "{:?}", balls[0]);
                assert!((balls[0].centre - solid.mass.centroid).norm() < 0.15);
            }
            assert!(clump.fidelity.expect("measured").volume_error < 0.0);
        }
        assert!(Euclidean { overlap: 1.0, ..Euclidean::default() }.validate().is_err());
    }
}
