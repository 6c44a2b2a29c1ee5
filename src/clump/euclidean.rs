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
use super::reproduce::{Found, Target};
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
            let (cell, square) = squares.iter().copied().enumerate().fold(
                (0, 0.0),
                |best: (usize, f64), now| if now.1 > best.1 { now } else { best },
            );
            let centre = voxels.centre(cell);
            // The outer cell's own boundary is about half an edge nearer than its centre.
            let left = (square.sqrt() - 0.5) * edge;
            if left < self.smallest * target.diameter {
                break;
            }
            // Cleared parts of earlier spheres are no surface: only the solid's own counts.
            let radius = (-target.distance.at(&centre)).max(left).max(0.0);
            let radius = if balls.is_empty() { radius } else { radius.min(left / (1.0 - self.overlap)) };
            let radius = radius.min(-target.distance.at(&centre));
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
