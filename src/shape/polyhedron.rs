//! Cut polyhedra: an ellipsoid cut by random planes until only planes are left.
//!
//! A box around the ellipsoid is cut by planes of random direction n (uniform),
//! each at (1 − depth) of the distance of the tangent plane of that direction,
//! √(Σ (a_k n_k)²). Convex, so always a valid grain. Cost O(cuts · faces).

use super::draw::{Draw, Drawn, Fact, ordered, ordered_whole};
use crate::geometry::GeometryError;
use crate::geometry::polyhedron::Polyhedron;
use crate::num::random::{self, Stream};
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Polyhedra cut by random planes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PolyhedronParameters {
    /// Least and largest axis of the ellipsoid, relative to each other; from 1e-3 to 1e3; default [0.7, 1.3].
    pub axes: [f64; 2],
    /// Least and largest number of cuts, from 4 to 500; default [10, 24].
    pub cuts: [u32; 2],
    /// Least and largest depth of a cut over the distance of the tangent plane, from 0 to 0.8; default [0, 0.3].
    pub depth: [f64; 2],
}

impl Default for PolyhedronParameters {
    fn default() -> Self {
        Self { axes: [0.7, 1.3], cuts: [10, 24], depth: [0.0, 0.3] }
    }
}

impl Draw for PolyhedronParameters {
    fn validate(&self) -> Result<(), Fault> {
        ordered("axes", self.axes, 1e-3, 1e3)?;
        ordered_whole("cuts", self.cuts, 4, 500)?;
        ordered("depth", self.depth, 0.0, 0.8)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let half = Vec3::from_fn(|_, _| 0.5 * random::uniform(stream, self.axes[0], self.axes[1]));
        let cuts = random::whole(stream, u64::from(self.cuts[0]), u64::from(self.cuts[1]));
        let mut solid = Polyhedron::cuboid(half * 1.05);
        for _ in 0..cuts {
            let normal = random::direction(stream);
            let depth = random::uniform(stream, self.depth[0], self.depth[1]);
            solid.cut(&normal, (1.0 - depth) * normal.component_mul(&half).norm());
        }
        Ok(Drawn {
            mesh: solid.mesh(),
            recipe: format!("convex polyhedron of {} faces after {cuts} cuts", solid.faces()),
            facts: vec![Fact::found("faces", solid.faces() as f64)],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hull::convex_hull;

    #[test]
    fn polyhedra_are_convex_and_closed() {
        for index in 0..20 {
            let drawn = PolyhedronParameters::default()
                .draw(&mut random::stream(1, "polyhedron", index))
                .expect("always");
            let report = crate::geometry::topology::inspect(&drawn.mesh);
            assert!(report.is_closed() && report.euler_characteristic == 2);
            let hull = convex_hull(&drawn.mesh.vertices).expect("points in space");
            assert!((report.volume / hull.mass_properties().volume - 1.0).abs() < 1e-9);
        }
    }
}
