//! Grains from spherical harmonics with a given spectrum over degrees (Grigoriu
//! et al. 2006; Mollon & Zhao 2014).
//!
//! r(θ, φ) = r₀ (1 + Σ_l Σ_m c_lm Y_lm), Y real and normalised to mean square 1 over
//! the sphere. Coefficients of a degree are normal and then scaled so that the
//! degree has exactly its RMS D_l: given one by one, or rms·l^(−decay) over a range of degrees, scaled so
//! that ΣD_l² = rms². Star-shaped about its middle, so never self-intersecting;
//! a draw whose radius falls below a twentieth is refused. Functions by the
//! stable recursion over l at fixed m. Cost O(vertices · degree²).

use super::draw::{Draw, Drawn, Fact};
use crate::geometry::{GeometryError, Mesh, Primitive};
use crate::num::random::{self, Stream};
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Spherical harmonics with a given spectrum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HarmonicsParameters {
    /// Lowest and highest degree, from 1 to 40; default [2, 15].
    pub degrees: [u32; 2],
    /// RMS of all radii about their mean over the mean, from 0 to 0.5; default 0.12.
    pub rms: f64,
    /// The RMS of a degree l falls as l^(-decay); from 0 to 6; default 1.5.
    pub decay: f64,
    /// RMS of each degree from the lowest on, instead of `rms` and `decay`; default none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub spectrum: Vec<f64>,
    /// Stretch along x, y, z afterwards, each from 0.1 to 10; default [1, 1, 1].
    pub axes: [f64; 3],
    /// Pieces of the surface in a turn, from 10 to 200; default 50.
    pub segments: u32,
}

impl Default for HarmonicsParameters {
    fn default() -> Self {
        Self {
            degrees: [2, 15],
            rms: 0.12,
            decay: 1.5,
            spectrum: Vec::new(),
            axes: [1.0; 3],
            segments: 50,
        }
    }
}

impl HarmonicsParameters {
    /// RMS of each degree from the lowest on.
    fn spectrum(&self) -> Vec<f64> {
        if !self.spectrum.is_empty() {
            return self.spectrum.clone();
        }
        let [low, high] = self.degrees;
        let raw: Vec<f64> = (low..=high).map(|l| f64::from(l).powf(-self.decay)).collect();
        let total = raw.iter().map(|d| d * d).sum::<f64>().sqrt();
        raw.iter().map(|d| d * self.rms / total).collect()
    }
}

impl Draw for HarmonicsParameters {
    fn validate(&self) -> Result<(), Fault> {
        super::draw::ordered_whole("degrees", self.degrees, 1, 40)?;
        Fault::within("rms", self.rms, 0.0, 0.5)?;
        Fault::within("decay", self.decay, 0.0, 6.0)?;
        for (k, rms) in self.spectrum.iter().enumerate() {
            Fault::within(&format!("spectrum[{k}]"), *rms, 0.0, 0.5)?;
        }
        let highest = self.degrees[0] as usize + self.spectrum.len();
        Fault::within("spectrum", highest as f64, 1.0, 41.0)?;
        for (axis, stretch) in self.axes.iter().enumerate() {
            Fault::within(&format!("axes[{axis}]"), *stretch, 0.1, 10.0)?;
        }
        Fault::within("segments", f64::from(self.segments), 10.0, 200.0)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let spectrum = self.spectrum();
        let series = Series::draw(self.degrees[0] as usize, &spectrum, stream);
        let sphere = Primitive::Sphere { diameter: 2.0 }.mesh(self.segments);
        let radii: Vec<f64> = sphere.vertices.iter().map(|d| 1.0 + series.at(d)).collect();
        let least = radii.iter().copied().fold(f64::INFINITY, f64::min);
        if least < 0.05 {
            let reason = format!("the radius falls to {least:.3} of its mean");
            return Err(GeometryError::Method { reason });
        }
        let mut facts = vec![Fact::asked(
            "rms of the radius",
            spectrum.iter().map(|d| d * d).sum::<f64>().sqrt(),
            mean_over(&sphere, |k| (radii[k] - 1.0).powi(2)).sqrt(),
        )];
        for (k, asked) in spectrum.iter().enumerate().take(6) {
            let degree = self.degrees[0] as usize + k;
            let measured = degree_rms(&sphere, &radii, degree);
            facts.push(Fact::asked(&format!("rms of degree {degree}"), *asked, measured));
        }
        let stretch = Vec3::from(self.axes);
        let vertices = sphere
            .vertices
            .iter()
            .zip(&radii)
            .map(|(d, r)| (d * *r).component_mul(&stretch))
            .collect();
        Ok(Drawn {
            mesh: Mesh { vertices, triangles: sphere.triangles },
            recipe: format!(
                "spherical harmonics of degrees {} to {}",
                self.degrees[0],
                self.degrees[0] as usize + spectrum.len() - 1
            ),
            facts,
        })
    }
}

/// A sum of real spherical harmonics: degrees from `low` on, 2l + 1 coefficients each.
#[derive(Debug, Clone)]
pub(super) struct Series {
    low: usize,
    coefficients: Vec<Vec<f64>>,
}

impl Series {
    /// Random coefficients with exactly the given RMS of each degree.
    pub fn draw(low: usize, spectrum: &[f64], stream: &mut Stream) -> Self {
        let degree = |(k, rms): (usize, &f64)| {
            let raw: Vec<f64> = (0..2 * (low + k) + 1).map(|_| random::normal(stream)).collect();
            let norm = raw.iter().map(|c| c * c).sum::<f64>().sqrt();
            raw.iter().map(|c| c * rms / norm).collect()
        };
        Self { low, coefficients: spectrum.iter().enumerate().map(degree).collect() }
    }

    /// Value in the direction of the unit vector `d`.
    pub fn at(&self, d: &Vec3) -> f64 {
        let high = self.low + self.coefficients.len() - 1;
        let mut sum = 0.0;
        basis(d, high, |l, column, value| {
            if l >= self.low {
                sum += self.coefficients[l - self.low][column] * value;
            }
        });
        sum
    }
}

/// Calls `visit(l, column, Y)` for all functions up to degree `high`; columns
/// 0 … 2l: m = 0, then cosine and sine of m = 1, 2, …
fn basis(d: &Vec3, high: usize, mut visit: impl FnMut(usize, usize, f64)) {
    let cosine = d.z.clamp(-1.0, 1.0);
    let sine = (1.0 - cosine * cosine).sqrt();
    let ring = d.x.hypot(d.y);
    let (c1, s1) = if ring > 0.0 { (d.x / ring, d.y / ring) } else { (1.0, 0.0) };
    let (mut c, mut s) = (1.0, 0.0);
    let mut diagonal = 1.0;
    for m in 0..=high {
        if m > 0 {
            let twice = 2.0 * m as f64;
            // √3 for m = 1, as the functions with m > 0 carry a factor √2.
            let factor = if m == 1 { 3.0 } else { (twice + 1.0) / twice };
            diagonal *= sine * f64::sqrt(factor);
            (c, s) = (c * c1 - s * s1, s * c1 + c * s1);
        }
        let (mut before, mut here) = (0.0, diagonal);
        for l in m..=high {
            if m == 0 {
                visit(l, 0, here);
            } else {
                visit(l, 2 * m - 1, here * c);
                visit(l, 2 * m, here * s);
            }
            let (lf, mf) = ((l + 1) as f64, m as f64);
            let a = ((4.0 * lf * lf - 1.0) / (lf * lf - mf * mf)).sqrt();
            let b =
                ((lf - 1.0).powi(2) - mf * mf).max(0.0) / (4.0 * (lf - 1.0).powi(2) - 1.0).abs();
            (before, here) = (here, a * (cosine * here - b.sqrt() * before));
        }
    }
}

/// Mean of `value(vertex)` over the sphere, vertices weighted by their solid angle.
fn mean_over(sphere: &Mesh, value: impl Fn(usize) -> f64) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for (triangle, [a, b, c]) in sphere.triangles.iter().zip(sphere.facets()) {
        let area = (b - a).cross(&(c - a)).norm();
        total += area;
        sum += area * triangle.iter().map(|k| value(*k as usize)).sum::<f64>() / 3.0;
    }
    sum / total
}

/// RMS of the part of `radii` that has the given degree.
fn degree_rms(sphere: &Mesh, radii: &[f64], degree: usize) -> f64 {
    let mut columns = vec![vec![0.0; radii.len()]; 2 * degree + 1];
    for (k, d) in sphere.vertices.iter().enumerate() {
        basis(d, degree, |l, column, value| {
            if l == degree {
                columns[column][k] = value;
            }
        });
    }
    let squares = columns.iter().map(|column| mean_over(sphere, |k| radii[k] * column[k]).powi(2));
    squares.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_orthonormal() {
        let sphere = Primitive::Sphere { diameter: 2.0 }.mesh(100);
        let mut values: Vec<Vec<f64>> = vec![Vec::new(); 25];
        for d in &sphere.vertices {
            basis(d, 4, |l, column, value| values[l * l + column].push(value));
        }
        for (i, first) in values.iter().enumerate() {
            for (j, second) in values.iter().enumerate() {
                let product = mean_over(&sphere, |k| first[k] * second[k]);
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 0.02, "{i} {j}: {product}");
            }
        }
    }

    #[test]
    fn degree_two_is_the_known_function() {
        let d = Vec3::new(0.3, -0.5, 0.8).normalize();
        let mut found = [0.0; 5];
        basis(&d, 2, |l, column, value| {
            if l == 2 {
                found[column] = value;
            }
        });
        assert!((found[0] - 5f64.sqrt() * 0.5 * (3.0 * d.z * d.z - 1.0)).abs() < 1e-12);
        assert!((found[1] - 15f64.sqrt() * d.x * d.z).abs() < 1e-12);
        assert!((found[4] - 15f64.sqrt() * d.x * d.y).abs() < 1e-12);
    }

    #[test]
    fn the_spectrum_is_as_asked() {
        let drawn = HarmonicsParameters { segments: 120, ..Default::default() }
            .draw(&mut random::stream(1, "harmonics", 0))
            .expect("no deep dents");
        for fact in &drawn.facts {
            let asked = fact.asked.expect("all are asked for");
            assert!((fact.measured / asked - 1.0).abs() < 0.07, "{fact:?}");
        }
        let given = HarmonicsParameters { spectrum: vec![0.1, 0.05], ..Default::default() };
        assert_eq!(given.spectrum(), vec![0.1, 0.05]);
    }
}
