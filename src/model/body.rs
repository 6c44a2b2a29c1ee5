//! Rigid bodies and the spheres they are made of.

use super::{BodyState, Dimension};
use crate::num::{Rotation, Vec3};
use serde::{Deserialize, Serialize};

/// A rigid body: one sphere (disc) or a clump of spheres that move as one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Centre of mass, m.
    pub position: Vec3,
    /// Turns the body frame (principal axes of inertia) into the world frame.
    pub orientation: Rotation,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vec3,
    /// Angular velocity in the world frame, rad/s.
    pub spin: Vec3,
    /// Mass, kg.
    pub mass: f64,
    /// Principal moments of inertia in the body frame, kg m².
    pub inertia: Vec3,
    /// Index of the first sphere in `Model::spheres`.
    pub first_sphere: u32,
    /// Number of spheres, at least 1.
    pub sphere_count: u32,
    /// Index into `Model::materials`.
    pub material: u16,
    /// Index of the grain family of the scene, for reports.
    pub family: u16,
    /// Index of the grain (clump, solid) of the scene that this body is a copy of, for reports.
    pub grain: u32,
}

impl Body {
    /// The part of the body that changes in time.
    pub fn state(&self) -> BodyState {
        BodyState {
            position: self.position,
            orientation: self.orientation,
            velocity: self.velocity,
            spin: self.spin,
        }
    }

    /// A homogeneous sphere (or disc of unit thickness) that is sphere number
    /// `first_sphere`; mass and inertia from `radius` (m) and `density` (kg/m³).
    pub fn sphere(
        dimension: Dimension,
        position: Vec3,
        radius: f64,
        density: f64,
        material: u16,
        first_sphere: u32,
    ) -> Self {
        let (mass, factor) = match dimension {
            Dimension::Three => (density * std::f64::consts::PI * 4.0 / 3.0 * radius.powi(3), 0.4),
            Dimension::Two => (density * std::f64::consts::PI * radius.powi(2), 0.5),
        };
        Self {
            position,
            orientation: Rotation::identity(),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            mass,
            inertia: Vec3::repeat(factor * mass * radius.powi(2)),
            first_sphere,
            sphere_count: 1,
            material,
            family: 0,
            grain: 0,
        }
    }
}

/// One sphere (disc) of a body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sphere {
    /// Centre in the body frame, m.
    pub offset: Vec3,
    /// Radius, m.
    pub radius: f64,
    /// Index into `Model::bodies`.
    pub body: u32,
}

/// A material; contact parameters belong to pairs of materials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Name in the scene file.
    pub name: String,
    /// Density, kg/m³.
    pub density: f64,
}
