//! G11: fractal surface by random midpoint displacement (diamond–square,
//! Fournier, Fussell & Carpenter 1982; used for rough surfaces of rock since
//! about 2002).
//!
//! Grid of 2^k + 1 points; at stage n the middles of squares, then those of
//! their edges, get the mean of their neighbours plus a normal deviate of
//! standard deviation σ₀ 2^(−nH/2), n counted in half stages, so that the
//! variance of height differences grows as distance^(2H): fractal dimension
//! D = 3 − H. The field is then scaled to the RMS height that was asked for.
//! Known fault: the increments are not stationary (creases along the first
//! squares), and D comes out some 0.1 off; the measured value is reported.
//! Cost O(points²).

use super::draw::{Draw, Drawn};
use super::field::Field;
use super::rough::{Asked, Bounded, Outline, body};
use crate::geometry::GeometryError;
use crate::num::Fault;
use crate::num::random::{self, Stream};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fractal surface by midpoint displacement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MidpointParameters {
    /// RMS height over the side (diameter of a ball), from 1e-5 to 0.2; default 0.03.
    pub rms: f64,
    /// Fractal dimension of the surface, from 2.02 to 2.98; default 2.3.
    pub dimension: f64,
    /// Times that the side is halved, from 3 to 9 (2^level + 1 points); default 5.
    pub level: u32,
    /// `ball` (default), `slab = { thickness = 0.3 }` or `sheet` (open, no grain).
    pub body: Bounded,
}

impl Default for MidpointParameters {
    fn default() -> Self {
        Self { rms: 0.03, dimension: 2.3, level: 5, body: Bounded::Ball }
    }
}

impl Draw for MidpointParameters {
    fn validate(&self) -> Result<(), Fault> {
        Fault::within("rms", self.rms, 1e-5, 0.2)?;
        Fault::within("dimension", self.dimension, 2.02, 2.98)?;
        Fault::within("level", f64::from(self.level), 3.0, 9.0)?;
        self.body.validate().map_err(|fault| fault.under("body"))
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let asked =
            Asked { rms: Some(self.rms), dimension: Some(self.dimension), ..Asked::default() };
        let recipe = format!(
            "midpoint fractal of dimension {} with {} points a side",
            self.dimension,
            (1 << self.level) + 1
        );
        body(self.body, Outline::Square, &asked, recipe, || Ok(self.field(stream)))
    }
}

impl MidpointParameters {
    fn field(&self, stream: &mut Stream) -> Field {
        let last = 1usize << self.level;
        let hurst = 3.0 - self.dimension;
        let mut field = Field::from_fn(last + 1, |_, _| 0.0);
        for (i, j) in [(0, 0), (last, 0), (0, last), (last, last)] {
            field.heights[j * (last + 1) + i] = random::normal(stream);
        }
        let mut deviation = 1.0;
        let mut step = last;
        while step > 1 {
            let half = step / 2;
            deviation *= 0.5f64.powf(0.5 * hurst);
            for j in (half..last).step_by(step) {
                for i in (half..last).step_by(step) {
                    displace(&mut field, [i, j], half, true, deviation, stream);
                }
            }
            deviation *= 0.5f64.powf(0.5 * hurst);
            for j in (0..=last).step_by(half) {
                let start = if (j / half).is_multiple_of(2) { half } else { 0 };
                for i in (start..=last).step_by(step) {
                    displace(&mut field, [i, j], half, false, deviation, stream);
                }
            }
            step = half;
        }
        field.scaled_to(self.rms)
    }
}

/// Mean of the neighbours at distance `half`, diagonal or straight, plus a deviate.
fn displace(
    field: &mut Field,
    [i, j]: [usize; 2],
    half: usize,
    diagonal: bool,
    deviation: f64,
    stream: &mut Stream,
) {
    let h = half as i64;
    let around = if diagonal {
        [(-h, -h), (h, -h), (-h, h), (h, h)]
    } else {
        [(-h, 0), (h, 0), (0, -h), (0, h)]
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for (x, y) in around {
        let (x, y) = (i as i64 + x, j as i64 + y);
        if (0..field.points as i64).contains(&x) && (0..field.points as i64).contains(&y) {
            sum += field.at(x as usize, y as usize);
            count += 1.0;
        }
    }
    field.heights[j * field.points + i] = sum / count + deviation * random::normal(stream);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::field::moments;

    #[test]
    fn rms_is_exact_and_dimension_follows_what_was_asked() {
        let measured: Vec<f64> = [2.1, 2.5, 2.9]
            .into_iter()
            .map(|dimension| {
                let parameters = MidpointParameters { dimension, level: 7, ..Default::default() };
                (0..4)
                    .map(|index| {
                        let field = parameters.field(&mut random::stream(1, "midpoint", index));
                        assert!((moments(&field.heights)[1] - 0.03).abs() < 1e-12);
                        field.fractal_dimension() / 4.0
                    })
                    .sum()
            })
            .collect();
        for (found, asked) in measured.iter().zip([2.1, 2.5, 2.9]) {
            assert!((found - asked).abs() < 0.15, "{found} {asked}");
        }
    }

    #[test]
    fn every_point_is_set() {
        let field = MidpointParameters::default().field(&mut random::stream(3, "midpoint", 0));
        assert_eq!(field.points, 33);
        let mean_only = field.heights.iter().filter(|z| **z == field.heights[0]).count();
        assert_eq!(mean_only, 1);
    }
}
