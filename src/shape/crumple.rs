//! G10: crumpled sheet (Sajjadi & Khalili 2015: a sheet crushed as in a hand).
//!
//! `folds`: the flat sheet is crushed by a sphere that shrinks: at random
//! planes at the distance of the sphere from its middle, whatever lies beyond
//! is reflected back, x → x − 2 max(0, n·x − d) n. Each reflection keeps all
//! lengths within the sheet, as paper does, and leaves creases. The sheet
//! passes through itself sooner or later (paper would not); the gate finds
//! that and says so. `facets`: heights over the plane that are linear between
//! random creases, z = Σ ± |n_k·x − d_k|: a crumpled sheet pulled flat again, that
//! never meets itself, scaled to its RMS height. `facets` bound a ball, a slab
//! or nothing; `folds` make a sheet of the given thickness (slab) or an open
//! one. Cost O(points² · creases).

use super::draw::{Draw, Drawn, Fact, ordered_whole};
use super::field::Field;
use super::rough::{Asked, Bounded, Outline, body, flat_sheet, thickened, validate_points};
use crate::geometry::GeometryError;
use crate::num::random::{self, Stream};
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// How the sheet is crumpled.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Crush {
    /// Heights that are linear between random creases.
    #[default]
    Facets,
    /// Crushed by a shrinking sphere, lengths in the sheet kept.
    Folds,
}

/// Crumpled sheet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CrumpleParameters {
    /// `facets` (default) or `folds`.
    pub crush: Crush,
    /// Least and largest number of creases (facets) or reflections (folds), from 1 to 200; default [8, 16].
    pub creases: [u32; 2],
    /// RMS height over the side, for `facets`; from 1e-5 to 0.3; default 0.04.
    pub rms: f64,
    /// Radius of the sphere at the end over half the diagonal of the sheet, for `folds`; from 0.1 to 1; default 0.6.
    pub crushed: f64,
    /// Outline of slabs and sheets: `square` (default) or `circle`.
    pub outline: Outline,
    /// Points along a side, from 8 to 512; default 40.
    pub points: u32,
    /// `ball` (default; not for folds), `slab = { thickness = 0.05 }` or `sheet` (open, no grain).
    pub body: Bounded,
}

impl Default for CrumpleParameters {
    fn default() -> Self {
        Self {
            crush: Crush::Facets,
            creases: [8, 16],
            rms: 0.04,
            crushed: 0.6,
            outline: Outline::Square,
            points: 40,
            body: Bounded::Ball,
        }
    }
}

impl Draw for CrumpleParameters {
    fn validate(&self) -> Result<(), Fault> {
        ordered_whole("creases", self.creases, 1, 200)?;
        Fault::within("rms", self.rms, 1e-5, 0.3)?;
        Fault::within("crushed", self.crushed, 0.1, 1.0)?;
        validate_points(self.points)?;
        if self.crush == Crush::Folds && self.body == Bounded::Ball {
            let allowed = "`slab = { thickness = 0.05 }` or `sheet` for `folds`";
            return Err(Fault::new("body", "is a ball", allowed));
        }
        self.body.validate().map_err(|fault| fault.under("body"))
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        match self.crush {
            Crush::Folds => Ok(self.folded(stream)),
            Crush::Facets => {
                let asked = Asked { rms: Some(self.rms), ..Asked::default() };
                let recipe = "crumpled sheet, facets between random creases".to_owned();
                body(self.body, self.outline, &asked, recipe, || Ok(self.facets(stream)))
            }
        }
    }
}

impl CrumpleParameters {
    fn creases(&self, stream: &mut Stream) -> u64 {
        random::whole(stream, u64::from(self.creases[0]), u64::from(self.creases[1]))
    }

    fn facets(&self, stream: &mut Stream) -> Field {
        let creases: Vec<[f64; 4]> = (0..self.creases(stream))
            .map(|_| {
                let angle = random::uniform(stream, 0.0, PI);
                let through = [0, 1].map(|_| random::uniform(stream, 0.0, 1.0));
                let height = random::normal(stream);
                let (s, c) = angle.sin_cos();
                [c, s, c * through[0] + s * through[1], height]
            })
            .collect();
        let n = self.points as usize;
        let last = (n - 1) as f64;
        let field = Field::from_fn(n, |i, j| {
            let (x, y) = (i as f64 / last, j as f64 / last);
            creases.iter().map(|[c, s, d, height]| height * (c * x + s * y - d).abs()).sum()
        });
        field.scaled_to(self.rms)
    }

    fn folded(&self, stream: &mut Stream) -> Drawn {
        let flat = flat_sheet(self.points as usize, self.outline);
        let start = flat.mesh.bounds().diagonal() * 0.5;
        let count = self.creases(stream);
        let mut sheet = flat.clone();
        for k in 0..count {
            let shrunk = (k + 1) as f64 / count as f64;
            let distance = start * (1.0 + (self.crushed - 1.0) * shrunk);
            // Planes beyond which something lies, or nothing would happen.
            let far = sheet
                .mesh
                .vertices
                .iter()
                .fold(Vec3::zeros(), |far, p| if p.norm() > far.norm() { *p } else { far });
            let tilt = random::direction(stream) * 0.4;
            let normal = (far.normalize() + tilt).normalize();
            for p in &mut sheet.mesh.vertices {
                *p -= normal * (2.0 * (normal.dot(p) - distance).max(0.0));
            }
            let middle = sheet.mesh.bounds().centre();
            sheet.mesh.vertices.iter_mut().for_each(|p| *p -= middle);
        }
        let reach = sheet.mesh.vertices.iter().map(Vec3::norm).fold(0.0, f64::max);
        // Edges across a crease are shorter in space; all others keep their length.
        let kept = sheet.mesh.area() / flat.mesh.area();
        let facts = vec![
            Fact::found("reach from the middle over that of the flat sheet", reach / start),
            Fact::found("area over that of the flat sheet", kept),
        ];
        let (mesh, what) = match self.body {
            Bounded::Slab { thickness } => (thickened(&sheet, thickness), "thick sheet"),
            Bounded::Ball | Bounded::Sheet => (sheet.mesh, "open sheet"),
        };
        Drawn { mesh, recipe: format!("{what} crushed in {count} folds"), facts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::topology::inspect;
    use crate::shape::field::moments;

    #[test]
    fn facets_have_the_height_asked_for_and_flat_parts() {
        let crumple = CrumpleParameters { creases: [3, 3], points: 65, ..Default::default() };
        let field = crumple.facets(&mut random::stream(1, "crumple", 0));
        assert!((moments(&field.heights)[1] - 0.04).abs() < 1e-12);
        let bent = (1..64).flat_map(|i| (1..64).map(move |j| (i, j))).filter(|&(i, j)| {
            (field.at(i + 1, j) - 2.0 * field.at(i, j) + field.at(i - 1, j)).abs() > 1e-9
        });
        // Three creases cross each row at most three times, at two points each.
        assert!(bent.count() <= 63 * 6);
    }

    #[test]
    fn folds_keep_the_area_and_bring_the_sheet_together() {
        let crumple = CrumpleParameters {
            crush: Crush::Folds,
            points: 80,
            creases: [6, 6],
            body: Bounded::Sheet,
            ..Default::default()
        };
        crumple.validate().expect("in their ranges");
        let drawn = crumple.draw(&mut random::stream(2, "crumple", 0)).expect("a sheet");
        let [reach, area] = [0, 1].map(|k| drawn.facts[k].measured);
        assert!(reach < 0.95, "{reach}");
        assert!(area > 0.9 && area <= 1.0 + 1e-9, "{area}");
        let thick =
            CrumpleParameters { body: Bounded::Slab { thickness: 0.02 }, points: 30, ..crumple };
        let closed = thick.draw(&mut random::stream(2, "crumple", 0)).expect("a sheet");
        assert!(inspect(&closed.mesh).is_closed());
        let wrong = CrumpleParameters { body: Bounded::Ball, ..thick };
        assert_eq!(wrong.validate().expect_err("no ball").key, "body");
    }
}
