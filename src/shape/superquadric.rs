//! Superquadrics (Barr 1981): ((|x/a|^(2/e₂) + |y/b|^(2/e₂))^(e₂/e₁) + |z/c|^(2/e₁)) = 1.
//!
//! e = 1 gives an ellipsoid, e → 0 a box (e₂) or cylinder (e₁), e = 2 an octahedron. The
//! surface is star-shaped: each direction of a geodesic sphere is scaled to it.
//! Edges that run between directions are cut off by the size of a triangle.
//! Cost O(vertices).

use super::draw::{Draw, Drawn, ordered};
use crate::geometry::{GeometryError, Primitive};
use crate::num::random::{self, Stream};
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Superquadrics with random axes and exponents.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SuperquadricParameters {
    /// Least and largest axis, relative to each other; from 1e-3 to 1e3; default [0.6, 1.4].
    pub axes: [f64; 2],
    /// Least and largest exponent e₁ (seen from the side), from 0.1 to 2.5; default [0.3, 1].
    pub side: [f64; 2],
    /// Least and largest exponent e₂ (seen along z), from 0.1 to 2.5; default [0.3, 1].
    pub section: [f64; 2],
    /// Pieces of the surface in a turn, from 10 to 200; default 60.
    pub segments: u32,
}

impl Default for SuperquadricParameters {
    fn default() -> Self {
        Self { axes: [0.6, 1.4], side: [0.3, 1.0], section: [0.3, 1.0], segments: 60 }
    }
}

impl Draw for SuperquadricParameters {
    fn validate(&self) -> Result<(), Fault> {
        ordered("axes", self.axes, 1e-3, 1e3)?;
        ordered("side", self.side, 0.1, 2.5)?;
        ordered("section", self.section, 0.1, 2.5)?;
        Fault::within("segments", f64::from(self.segments), 10.0, 200.0)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let axes = Vec3::from_fn(|_, _| random::uniform(stream, self.axes[0], self.axes[1]));
        let side = random::uniform(stream, self.side[0], self.side[1]);
        let section = random::uniform(stream, self.section[0], self.section[1]);
        let half = axes * 0.5;
        let mesh = Primitive::Sphere { diameter: 2.0 }
            .mesh(self.segments)
            .mapped(|d| (d * radius(d, side, section)).component_mul(&half));
        let recipe = format!(
            "superquadric {:.3} x {:.3} x {:.3}, exponents {side:.3} and {section:.3}",
            axes.x, axes.y, axes.z
        );
        Ok(Drawn { mesh, recipe, facts: Vec::new() })
    }
}

/// Radius of the superquadric of half axes 1 in the direction of `d`.
pub(super) fn radius(d: &Vec3, side: f64, section: f64) -> f64 {
    let ring = d.x.abs().powf(2.0 / section) + d.y.abs().powf(2.0 / section);
    let value = ring.powf(section / side) + d.z.abs().powf(2.0 / side);
    value.powf(-0.5 * side)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_give_the_known_solids() {
        let d = Vec3::new(0.2, 0.6, -0.77).normalize();
        assert!((radius(&d, 1.0, 1.0) - 1.0).abs() < 1e-12, "sphere");
        let one_norm: f64 = d.iter().map(|x| x.abs()).sum();
        assert!((radius(&d, 2.0, 2.0) - 1.0 / one_norm).abs() < 1e-12, "octahedron");
        assert!((radius(&d, 0.01, 0.01) - 1.0 / d.amax()).abs() < 0.02, "cube");
    }

    #[test]
    fn the_volume_has_its_closed_form() {
        // e = 1 along z, squarish section: V = 2 a b c e1 e2 B(e1/2+1, e1) B(e2/2, e2/2);
        // for e1 = e2 = 2 (octahedron) 4/3 abc.
        let octahedron = SuperquadricParameters {
            axes: [2.0, 2.0],
            side: [2.0, 2.0],
            section: [2.0, 2.0],
            segments: 100,
        };
        let drawn = octahedron.draw(&mut random::stream(1, "s", 0)).expect("always");
        let volume = drawn.mesh.mass_properties().volume;
        assert!((volume * 3.0 / 4.0 - 1.0).abs() < 0.01, "{volume}");
    }
}
