//! Base volumes that other methods start from: one base solid, or a G1 union.

use super::draw::Draw;
use super::union_of_solids::{self, UnionParameters};
use crate::geometry::{GeometryError, Mesh, Posed, Primitive};
use crate::num::random::Stream;
use crate::num::{Fault, Rotation, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A base volume; lengths relative to each other, as the grain is scaled to its size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Base {
    /// Sphere of this diameter.
    Sphere(f64),
    /// Ellipsoid of these axes.
    Ellipsoid([f64; 3]),
    /// Box of these edges.
    Box([f64; 3]),
    /// Cylinder.
    Cylinder {
        /// Diameter.
        diameter: f64,
        /// Height.
        height: f64,
    },
    /// Cone.
    Cone {
        /// Diameter of the base.
        diameter: f64,
        /// Height.
        height: f64,
    },
    /// Union of random base solids (G1), drawn anew for each grain.
    Union(UnionParameters),
}

/// Pieces in a turn of the round surfaces of single base solids.
const SEGMENTS: u32 = 40;

/// A drawn base volume: the set of its points and its surface.
pub struct Body {
    /// The solids whose union it is.
    pub solids: Vec<Posed>,
    /// Its surface.
    pub mesh: Mesh,
}

impl Body {
    /// True if `point` lies in the volume.
    pub fn contains(&self, point: &Vec3) -> bool {
        self.solids.iter().any(|solid| solid.contains(point))
    }
}

impl Base {
    pub(super) fn validate(&self) -> Result<(), Fault> {
        let length = |key: &str, value: f64| Fault::within(key, value, 1e-3, 1e3);
        let three = |name: &str, sides: &[f64; 3]| {
            (0..3).try_for_each(|axis| length(&format!("{name}[{axis}]"), sides[axis]))
        };
        match self {
            Self::Sphere(diameter) => length("sphere", *diameter),
            Self::Ellipsoid(axes) => three("ellipsoid", axes),
            Self::Box(edges) => three("box", edges),
            Self::Cylinder { diameter, height } => {
                length("cylinder.diameter", *diameter)?;
                length("cylinder.height", *height)
            }
            Self::Cone { diameter, height } => {
                length("cone.diameter", *diameter)?;
                length("cone.height", *height)
            }
            Self::Union(parameters) => parameters.validate().map_err(|f| f.under("union")),
        }
    }

    pub(super) fn draw(&self, stream: &mut Stream) -> Result<Body, GeometryError> {
        let primitive = match *self {
            Self::Sphere(diameter) => Primitive::Sphere { diameter },
            Self::Ellipsoid(axes) => Primitive::Ellipsoid { axes: axes.into() },
            Self::Box(edges) => Primitive::Box { edges: edges.into() },
            Self::Cylinder { diameter, height } => Primitive::Cylinder { diameter, height },
            Self::Cone { diameter, height } => Primitive::Cone { diameter, height },
            Self::Union(ref parameters) => {
                let solids = union_of_solids::draw(parameters, stream);
                let mesh = union_of_solids::unite(&solids, parameters.segments)?;
                return Ok(Body { solids, mesh });
            }
        };
        let rotation = Rotation::identity();
        let posed = Posed { primitive, rotation, centre: Vec3::zeros() };
        Ok(Body { solids: vec![posed], mesh: posed.mesh(SEGMENTS) })
    }

    /// Name for people.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Sphere(_) => "a sphere",
            Self::Ellipsoid(_) => "an ellipsoid",
            Self::Box(_) => "a box",
            Self::Cylinder { .. } => "a cylinder",
            Self::Cone { .. } => "a cone",
            Self::Union(_) => "a union of random solids",
        }
    }
}
