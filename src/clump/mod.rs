//! Reproduction of solids as clumps of spheres: one file a method.
//!
//! [`reproduce`] turns a solid into a [`Clump`] by a [`Method`]; [`spheres`] does the search
//! for spheres alone; [`reproduce_to_error`] finds how many are needed; [`sphere`] and
//! [`disc`] are the grains that are spheres or discs by themselves; [`measure`]
//! says how far spheres are from a solid; [`mod@file`] keeps clumps on disk.

mod axial;
mod cluster;
mod cover;
mod dynamic;
mod euclidean;
mod fidelity;
pub mod file;
mod fitted;
mod four_points;
mod hollows;
mod ladder;
mod lattice;
mod maximal;
mod nodes;
mod normals;
mod patches;
mod pieces;
mod refine;
mod replaced;
mod reproduce;
mod target;
mod voxels;

pub use axial::{Axial, Girth};
pub use cluster::{Cluster, Members, Pattern};
pub use dynamic::Dynamic;
pub use euclidean::Euclidean;
pub use fidelity::{POINTS, measure};
pub use fitted::{Fitted, Volume};
pub use four_points::FourPoints;
pub use ladder::{counted, reproduce_to_error};
pub use lattice::{Lattice, Stacking};
pub use nodes::{Nodes, Place};
pub use normals::{Normals, Order};
pub use replaced::Replaced;
pub use reproduce::{MassSource, Method, reproduce, spheres};

use crate::format::FormatError;
use crate::geometry::{Ball, DistanceError};
use crate::num::{Fault, MethodEntry, Rotation, Vec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::path::PathBuf;

/// Every way of making clumps, for `riprap list clumps`.
pub const METHODS: &[MethodEntry] = &[
    fitted::ENTRY,
    nodes::ENTRY,
    replaced::ENTRY,
    dynamic::ENTRY,
    four_points::ENTRY,
    normals::ENTRY,
    axial::ENTRY,
    euclidean::ENTRY,
    cluster::ENTRY,
    lattice::ENTRY,
];

/// Spheres that stand for one solid and move as one body, in the body frame:
/// centre of mass at the origin, principal axes of inertia along x, y, z.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Clump {
    /// Name of the solid it stands for.
    pub name: String,
    /// Method and parameters, one line for people.
    pub method: String,
    /// Spheres in the body frame.
    pub balls: Vec<Ball>,
    /// Volume that the mass is computed from, m³.
    pub volume: f64,
    /// Principal moments of inertia for density 1, m⁵, rising.
    pub inertia: Vec3,
    /// Centre of mass in the frame of the solid, m.
    pub centroid: Vec3,
    /// Turns body-frame vectors into the frame of the solid.
    pub axes: Rotation,
    /// Errors against the solid; `None` where the grain is a sphere by itself.
    pub fidelity: Option<Fidelity>,
}

/// How far a clump is from its solid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Fidelity {
    /// Equivalent-volume diameter of the solid, m: what lengths are compared with.
    pub equivalent_diameter: f64,
    /// (V of the united spheres − V of the solid) / V of the solid.
    pub volume_error: f64,
    /// Mean distance between the two surfaces, both ways, m.
    pub mean_distance: f64,
    /// Root mean square distance between the two surfaces, both ways, m.
    pub rms_distance: f64,
    /// Largest distance of either surface from the other (Hausdorff), m.
    pub largest_distance: f64,
    /// Distance between the centroid of the united spheres and that of the solid, m.
    pub centroid_error: f64,
    /// Frobenius norm of the difference of the inertia tensors over that of the solid, masses made equal.
    pub inertia_error: f64,
}

/// Why there is no clump.
#[derive(Debug, thiserror::Error)]
pub enum ClumpError {
    /// A parameter cannot be used.
    #[error(transparent)]
    Input(#[from] Fault),
    /// The solid's surface is not closed or not outward-oriented.
    #[error("`{name}`: {source}")]
    Surface {
        /// Name of the solid.
        name: String,
        /// What is wrong with it.
        source: DistanceError,
    },
    /// The method found no place for a single sphere.
    #[error("`{name}`: no sphere fits; {advice}")]
    NoSphere {
        /// Name of the solid.
        name: String,
        /// Which parameter to change, and how.
        advice: &'static str,
    },
    /// No clump of the ladder is near enough to its solid.
    #[error("{method} does not reach an RMS distance of {error}; its best was {best:.4}")]
    NotReached {
        /// Key of the method.
        method: String,
        /// RMS surface distance over equivalent diameter that was asked for.
        error: f64,
        /// The least that was reached.
        best: f64,
    },
    /// The user asked to stop.
    #[error("stopped before the clump was finished")]
    Cancelled,
    /// A file could not be read or written.
    #[error(transparent)]
    File(#[from] FormatError),
    /// A file does not hold what it should.
    #[error("{path}, line {line}: {problem}")]
    Content {
        /// Which.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong there.
        problem: String,
    },
}

impl Clump {
    /// Radius of the ball about the centre of mass that holds every sphere, m.
    pub fn bounding_radius(&self) -> f64 {
        self.balls.iter().map(|b| b.centre.norm() + b.radius).fold(0.0, f64::max)
    }

    /// The spheres in the frame of the solid.
    pub fn in_solid_frame(&self) -> Vec<Ball> {
        self.balls
            .iter()
            .map(|b| Ball { centre: self.axes * b.centre + self.centroid, radius: b.radius })
            .collect()
    }

    /// The same clump `scale` times as large in each direction; `dimension` 2 for discs
    /// (one metre thick), 3 otherwise. Errors against the solid scale along.
    pub fn scaled(&self, scale: f64, dimension: u32) -> Self {
        let dimension = dimension as i32;
        let ball = |b: &Ball| Ball { centre: b.centre * scale, radius: b.radius * scale };
        Self {
            balls: self.balls.iter().map(ball).collect(),
            volume: self.volume * scale.powi(dimension),
            inertia: self.inertia * scale.powi(dimension + 2),
            centroid: self.centroid * scale,
            fidelity: self.fidelity.map(|f| Fidelity {
                equivalent_diameter: f.equivalent_diameter * scale,
                mean_distance: f.mean_distance * scale,
                rms_distance: f.rms_distance * scale,
                largest_distance: f.largest_distance * scale,
                centroid_error: f.centroid_error * scale,
                ..f
            }),
            ..self.clone()
        }
    }

    fn single(name: &str, method: &str, radius: f64, volume: f64, inertia: f64) -> Self {
        Self {
            name: name.to_owned(),
            method: method.to_owned(),
            balls: vec![Ball { centre: Vec3::zeros(), radius }],
            volume,
            inertia: Vec3::repeat(inertia),
            centroid: Vec3::zeros(),
            axes: Rotation::identity(),
            fidelity: None,
        }
    }
}

/// A grain that is a sphere of `radius` m.
pub fn sphere(name: &str, radius: f64) -> Clump {
    let volume = 4.0 / 3.0 * PI * radius.powi(3);
    Clump::single(name, "sphere", radius, volume, 0.4 * volume * radius * radius)
}

/// A grain of a two-dimensional scene: a disc of `radius` m, one metre thick.
/// The volume is π r² × 1 m. Only the moment about z acts in the plane, ½ π r⁴;
/// all three components are set to it.
pub fn disc(name: &str, radius: f64) -> Clump {
    let volume = PI * radius * radius;
    Clump::single(name, "disc", radius, volume, 0.5 * volume * radius * radius)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_grains_have_their_closed_forms() {
        let ball = sphere("s", 2.0);
        assert!((ball.volume - 32.0 / 3.0 * PI).abs() < 1e-12);
        assert!((ball.inertia.x - 0.4 * ball.volume * 4.0).abs() < 1e-12);
        assert_eq!(ball.bounding_radius(), 2.0);
        let plate = disc("d", 2.0);
        assert!((plate.volume - 4.0 * PI).abs() < 1e-12);
        assert!((plate.inertia.z - 8.0 * PI).abs() < 1e-12);
    }
}
