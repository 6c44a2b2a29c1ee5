//! Reproduction of solids as clumps of spheres: one file a method.

use crate::geometry::Ball;
use crate::num::{Rotation, Vec3};
use serde::{Deserialize, Serialize};

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
