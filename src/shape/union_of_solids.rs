//! G1 and G2: the union of random base solids (Sajjadi & Khalili 2015, first
//! method; families by limits on kinds and dimensions).
//!
//! M base solids are drawn. Each has a random kind, random dimensions, and a
//! work plane through the origin at a random angle (uniform on SO(3)) on which
//! it stands: its axis runs through the origin, its centre is lifted above the
//! plane by `lift` half heights. With lift < 1 the origin lies inside every
//! base solid, so all overlap, and the union is one piece without handles
//! (star-shaped about the origin). Cost: M boolean operations, a few ms each.
//! What cannot be finished: a union that fails the gate after rounding to
//! single precision is drawn again by the caller.

use super::draw::{Draw, Drawn};
use crate::geometry::{GeometryError, Mesh, Posed, Primitive, union};
use crate::num::random::{self, Stream};
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kinds of base solids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Rectangular box, three dimensions.
    Box,
    /// Circular cylinder: diameter and height.
    Cylinder,
    /// Circular cone: diameter and height.
    Cone,
    /// Ellipsoid, three axes.
    Ellipsoid,
    /// Sphere.
    Sphere,
}

/// Families of base solids.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// All kinds.
    #[default]
    Any,
    /// Ellipsoids and spheres.
    Smooth,
    /// Boxes, cylinders and cones.
    Sharp,
}

impl Family {
    fn kinds(self) -> &'static [Kind] {
        match self {
            Self::Any => &[Kind::Box, Kind::Cylinder, Kind::Cone, Kind::Ellipsoid, Kind::Sphere],
            Self::Smooth => &[Kind::Ellipsoid, Kind::Sphere],
            Self::Sharp => &[Kind::Box, Kind::Cylinder, Kind::Cone],
        }
    }
}

/// Union of random base solids.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnionParameters {
    /// Least and largest number of base solids, each from 1 to 50; default [3, 6].
    #[serde(default = "default_solids")]
    pub solids: [u32; 2],
    /// Kinds to draw from, each as often as it is listed; instead of `family`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kinds: Vec<Kind>,
    /// Kinds to draw from: any, smooth (ellipsoids, spheres) or sharp (boxes,
    /// cylinders, cones); default any.
    #[serde(default)]
    pub family: Family,
    /// Least and largest dimension (edge, diameter, height, full axis) of a base
    /// solid, relative to each other since the grain is scaled to its size; in
    /// metres where no size is asked for. From 1e-3 to 1e3, ratio at most 100;
    /// default [0.5, 1.5].
    #[serde(default = "default_dimensions")]
    pub dimensions: [f64; 2],
    /// Least and largest height of the middle of a base solid above its work
    /// plane, in half heights: 0 is centred on the plane. From 0 to 0.9;
    /// default [0, 0.8].
    #[serde(default = "default_lift")]
    pub lift: [f64; 2],
    /// Pieces that round solids have in a turn, from 6 to 200; default 32.
    #[serde(default = "default_segments")]
    pub segments: u32,
}

fn default_solids() -> [u32; 2] {
    [3, 6]
}

fn default_dimensions() -> [f64; 2] {
    [0.5, 1.5]
}

fn default_lift() -> [f64; 2] {
    [0.0, 0.8]
}

fn default_segments() -> u32 {
    32
}

impl Default for UnionParameters {
    fn default() -> Self {
        Self {
            solids: default_solids(),
            kinds: Vec::new(),
            family: Family::Any,
            dimensions: default_dimensions(),
            lift: default_lift(),
            segments: default_segments(),
        }
    }
}

impl Draw for UnionParameters {
    fn validate(&self) -> Result<(), Fault> {
        let [few, many] = self.solids.map(f64::from);
        Fault::within("solids[0]", few, 1.0, 50.0)?;
        Fault::within("solids[1]", many, few, 50.0)?;
        if !self.kinds.is_empty() && self.family != Family::Any {
            return Err(Fault::new("kinds", "is given together with `family`", "one of the two"));
        }
        let [small, large] = self.dimensions;
        Fault::within("dimensions[0]", small, 1e-3, 1e3)?;
        Fault::within("dimensions[1]", large, small, 1e3f64.min(100.0 * small))?;
        let [low, high] = self.lift;
        Fault::within("lift[0]", low, 0.0, 0.9)?;
        Fault::within("lift[1]", high, low, 0.9)?;
        Fault::within("segments", f64::from(self.segments), 6.0, 200.0)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let solids = draw(self, stream);
        let mesh = unite(&solids, self.segments)?;
        Ok(Drawn { mesh, recipe: describe(&solids), facts: Vec::new() })
    }
}

/// Draws the base solids of one grain.
pub fn draw(parameters: &UnionParameters, stream: &mut Stream) -> Vec<Posed> {
    let [few, many] = parameters.solids;
    let kinds = match parameters.kinds[..] {
        [] => parameters.family.kinds(),
        ref kinds => kinds,
    };
    (0..random::whole(stream, u64::from(few), u64::from(many)))
        .map(|_| {
            let kind = kinds[random::whole(stream, 0, kinds.len() as u64 - 1) as usize];
            let [small, large] = parameters.dimensions;
            // Three numbers are drawn for every kind, so that the stream stays in step.
            let sides = Vec3::from_fn(|_, _| random::uniform(stream, small, large));
            let primitive = match kind {
                Kind::Box => Primitive::Box { edges: sides },
                Kind::Cylinder => Primitive::Cylinder { diameter: sides.x, height: sides.z },
                Kind::Cone => Primitive::Cone { diameter: sides.x, height: sides.z },
                Kind::Ellipsoid => Primitive::Ellipsoid { axes: sides },
                Kind::Sphere => Primitive::Sphere { diameter: sides.z },
            };
            let lift = random::uniform(stream, parameters.lift[0], parameters.lift[1]);
            let rotation = random::rotation(stream);
            let centre = rotation * Vec3::new(0.0, 0.0, 0.5 * sides.z * lift);
            Posed { primitive, rotation, centre }
        })
        .collect()
}

/// The union of `solids`, round ones in `segments` pieces a turn.
pub fn unite(solids: &[Posed], segments: u32) -> Result<Mesh, GeometryError> {
    let meshes: Vec<Mesh> = solids.iter().map(|solid| solid.mesh(segments)).collect();
    union::unite(&meshes)
}

/// Kinds and dimensions in one line for people.
pub fn describe(solids: &[Posed]) -> String {
    let said: Vec<String> = solids
        .iter()
        .map(|solid| match solid.primitive {
            Primitive::Box { edges: e } => format!("box {:.3} x {:.3} x {:.3}", e.x, e.y, e.z),
            Primitive::Cylinder { diameter, height } => {
                format!("cylinder {diameter:.3} x {height:.3}")
            }
            Primitive::Cone { diameter, height } => format!("cone {diameter:.3} x {height:.3}"),
            Primitive::Ellipsoid { axes: a } => {
                format!("ellipsoid {:.3} x {:.3} x {:.3}", a.x, a.y, a.z)
            }
            Primitive::Sphere { diameter } => format!("sphere {diameter:.3}"),
        })
        .collect();
    format!("union of {}", said.join(", "))
}
