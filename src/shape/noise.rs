//! Ellipsoids with a displaced surface: noise of several octaves (Perlin 1985
//! in spirit; here each octave is a sum of plane waves of random direction and
//! phase, which is smooth, isotropic and has no lattice).
//!
//! r(d) = 1 + Σ_o g^o n_o(d), n_o with unit variance from 24 waves of length
//! λ/2^o, g the gain; the whole is scaled to the RMS that is asked for, then
//! stretched to the axes. Star-shaped. A draw whose radius falls below a
//! twentieth is refused. Cost O(vertices · octaves).

use super::draw::{Draw, Drawn, Fact, ordered};
use super::field::moments;
use crate::geometry::{GeometryError, Mesh, Primitive};
use crate::num::random::{self, Stream};
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Ellipsoids displaced by noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseParameters {
    /// Least and largest axis, relative to each other; from 1e-3 to 1e3; default [0.7, 1.3].
    pub axes: [f64; 2],
    /// RMS of the radius over its mean before stretching, from 0 to 0.4; default 0.06.
    pub rms: f64,
    /// Length of the longest waves over the mean diameter, from 0.05 to 2; default 0.7.
    pub length: f64,
    /// Octaves, from 1 to 8; default 4.
    pub octaves: u32,
    /// RMS of an octave over that of the one before, from 0 to 1; default 0.5.
    pub gain: f64,
    /// Pieces of the surface in a turn, from 10 to 200; default 60.
    pub segments: u32,
}

impl Default for NoiseParameters {
    fn default() -> Self {
        Self { axes: [0.7, 1.3], rms: 0.06, length: 0.7, octaves: 4, gain: 0.5, segments: 60 }
    }
}

/// Waves of an octave.
const WAVES: usize = 24;

impl Draw for NoiseParameters {
    fn validate(&self) -> Result<(), Fault> {
        ordered("axes", self.axes, 1e-3, 1e3)?;
        Fault::within("rms", self.rms, 0.0, 0.4)?;
        Fault::within("length", self.length, 0.05, 2.0)?;
        Fault::within("octaves", f64::from(self.octaves), 1.0, 8.0)?;
        Fault::within("gain", self.gain, 0.0, 1.0)?;
        Fault::within("segments", f64::from(self.segments), 10.0, 200.0)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let axes = Vec3::from_fn(|_, _| random::uniform(stream, self.axes[0], self.axes[1]));
        let mut waves = Vec::new();
        for octave in 0..self.octaves as i32 {
            // Unit sphere: its diameter is 2.
            let number = TAU / (2.0 * self.length) * 2f64.powi(octave);
            for _ in 0..WAVES {
                let wave = random::direction(stream) * number;
                let phase = random::uniform(stream, 0.0, TAU);
                waves.push((wave, phase, self.gain.powi(octave)));
            }
        }
        let sphere = Primitive::Sphere { diameter: 2.0 }.mesh(self.segments);
        let raw: Vec<f64> = sphere
            .vertices
            .iter()
            .map(|d| waves.iter().map(|(k, phase, a)| a * (k.dot(d) + phase).cos()).sum())
            .collect();
        let [mean, rms, ..] = moments(&raw);
        let factor = if rms > 0.0 { self.rms / rms } else { 0.0 };
        let radii: Vec<f64> = raw.iter().map(|h| 1.0 + (h - mean) * factor).collect();
        let least = radii.iter().copied().fold(f64::INFINITY, f64::min);
        if least < 0.05 {
            let reason = format!("the radius falls to {least:.3} of its mean");
            return Err(GeometryError::Method { reason });
        }
        let vertices = sphere
            .vertices
            .iter()
            .zip(&radii)
            .map(|(d, r)| (d * *r).component_mul(&(axes * 0.5)))
            .collect();
        Ok(Drawn {
            mesh: Mesh { vertices, triangles: sphere.triangles },
            recipe: format!(
                "ellipsoid {:.3} x {:.3} x {:.3} displaced by {} octaves of noise",
                axes.x, axes.y, axes.z, self.octaves
            ),
            facts: vec![Fact::asked("rms of the radius", self.rms, moments(&radii)[1])],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_noise_is_the_ellipsoid_and_noise_has_its_rms() {
        let plain = NoiseParameters { rms: 0.0, axes: [1.0, 1.0], ..Default::default() };
        let drawn = plain.draw(&mut random::stream(1, "noise", 0)).expect("an ellipsoid");
        assert!(drawn.mesh.vertices.iter().all(|p| (p.norm() - 0.5).abs() < 1e-12));
        let rough = NoiseParameters { axes: [1.0, 1.0], ..Default::default() };
        let drawn = rough.draw(&mut random::stream(1, "noise", 0)).expect("shallow");
        assert!((drawn.facts[0].measured - 0.06).abs() < 1e-12);
        let deep = NoiseParameters { rms: 0.4, ..Default::default() };
        let refused = (0..10).any(|k| deep.draw(&mut random::stream(1, "noise", k)).is_err());
        assert!(refused, "0.4 of RMS reaches the middle now and then");
    }
}
