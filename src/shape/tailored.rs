//! Made to measure: grains whose descriptors follow wanted distributions.
//!
//! For each grain a target is drawn: each wanted descriptor from a normal
//! distribution (mean, standard deviation) cut off at its limits, or all of
//! them at once from one file of a folder of scanned grains (chosen at random, so that
//! correlations between descriptors are kept), with some scatter. A star-shaped family with
//! five parameters is then searched for it: ratios of axes b/a and c/b, the exponent of a
//! superellipsoid (edges), and the amplitudes of two series of spherical
//! harmonics with random coefficients of the grain's own (degrees 3–5: dents; 6–12: roughness).
//! The search (Nelder & Mead 1965) makes the mean square of the misses, each over its
//! tolerance, least; descriptors that are not wanted are left free, held only
//! weakly at the start. What cannot be had together (a sphericity above that of the ellipsoid
//! of the same elongation and flatness, say) ends at the nearest that the
//! family has: asked and measured are both reported. Cost: 120 meshes a grain,
//! about 1 s where roundness is wanted, 0.3 s otherwise.

use super::descriptors::{Descriptors, describe};
use super::draw::{Draw, Drawn, Fact};
use super::harmonics::Series;
use super::superquadric;
use super::{FileParameters, ShapeError};
use crate::format;
use crate::geometry::{GeometryError, Mesh, Primitive, check};
use crate::num::random::{self, Stream};
use crate::num::units::Length;
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Wanted distributions; each a mean and a standard deviation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TailoredParameters {
    /// I/L: mean from 0.2 to 1, standard deviation from 0 to 0.5; default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elongation: Option<[f64; 2]>,
    /// S/I: mean from 0.2 to 1, standard deviation from 0 to 0.5; default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flatness: Option<[f64; 2]>,
    /// Wadell's sphericity: mean from 0.4 to 1, standard deviation from 0 to 0.5; default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sphericity: Option<[f64; 2]>,
    /// Roundness: mean from 0.1 to 1, standard deviation from 0 to 0.5; default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roundness: Option<[f64; 2]>,
    /// V/V_hull: mean from 0.5 to 1, standard deviation from 0 to 0.5; default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub convexity: Option<[f64; 2]>,
    /// Folder of scanned grains (.stl, .ply, .obj) whose descriptors are wanted, instead of the above; default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub like: Option<PathBuf>,
    /// Standard deviation of the scatter about the descriptors of the files, from 0 to 0.2; default 0.01.
    pub scatter: f64,
    /// Steps of the search, from 20 to 2000; default 120.
    pub steps: u32,
    /// Pieces of the surface in a turn, from 15 to 100; default 40.
    pub segments: u32,
}

impl Default for TailoredParameters {
    fn default() -> Self {
        Self {
            elongation: None,
            flatness: None,
            sphericity: None,
            roundness: None,
            convexity: None,
            like: None,
            scatter: 0.01,
            steps: 120,
            segments: 40,
        }
    }
}

const NAMES: [&str; 5] = ["elongation", "flatness", "sphericity", "roundness", "convexity"];
/// Limits of what can be asked for.
const LIMITS: [[f64; 2]; 5] = [[0.2, 1.0], [0.2, 1.0], [0.4, 1.0], [0.1, 1.0], [0.5, 1.0]];
/// What counts as one unit of miss.
const TOLERANCE: [f64; 5] = [0.01, 0.01, 0.005, 0.02, 0.005];

/// Wanted values of the five descriptors, where wanted.
pub type Target = [Option<f64>; 5];

fn values(d: &Descriptors) -> [f64; 5] {
    [d.elongation, d.flatness, d.wadell_sphericity, d.roundness, d.convexity]
}

impl TailoredParameters {
    fn wanted(&self) -> [Option<[f64; 2]>; 5] {
        [self.elongation, self.flatness, self.sphericity, self.roundness, self.convexity]
    }

    /// The first value out of its range, if any; files are not opened.
    pub fn validate(&self) -> Result<(), Fault> {
        let wanted = self.wanted();
        for (k, pair) in wanted.iter().enumerate() {
            let Some([mean, deviation]) = pair else { continue };
            let [low, high] = LIMITS[k];
            Fault::within(&format!("{}[0]", NAMES[k]), *mean, low, high)?;
            Fault::within(&format!("{}[1]", NAMES[k]), *deviation, 0.0, 0.5)?;
        }
        let any = wanted.iter().any(Option::is_some);
        if any == self.like.is_some() {
            let problem = if any { "is given beside descriptors" } else { "is missing" };
            let allowed = "at least one descriptor such as `elongation = [0.7, 0.1]`, or `like`";
            return Err(Fault::new("like", problem, allowed));
        }
        Fault::within("scatter", self.scatter, 0.0, 0.2)?;
        Fault::within("steps", f64::from(self.steps), 20.0, 2000.0)?;
        Fault::within("segments", f64::from(self.segments), 15.0, 100.0)
    }

    /// What one grain should have; relative paths start at `base`.
    pub fn target(&self, base: &Path, stream: &mut Stream) -> Result<Target, ShapeError> {
        let drawn = |stream: &mut Stream, k: usize, mean: f64, deviation: f64| {
            let [low, high] = LIMITS[k];
            (mean + deviation * random::normal(stream)).clamp(low, high)
        };
        let Some(folder) = &self.like else {
            // A number is drawn for each, so that one more wish does not change the others.
            let wanted = self.wanted();
            return Ok(std::array::from_fn(|k| {
                let [mean, deviation] = wanted[k].unwrap_or([0.0; 2]);
                let value = drawn(stream, k, mean, deviation);
                wanted[k].map(|_| value)
            }));
        };
        let (paths, folder, unit) = (Vec::new(), Some(folder.clone()), Length(1.0));
        let files = FileParameters { paths, folder, unit }.list(base)?;
        let path = &files[random::whole(stream, 0, files.len() as u64 - 1) as usize];
        let refused = |fault| ShapeError::NoSolid { path: path.clone(), fault };
        let (mesh, _) = check::solid_in_double(format::read_mesh(path)?).map_err(refused)?;
        let own = describe(&mesh).map_err(|reason| ShapeError::NoDraw {
            name: path.display().to_string(),
            draws: 1,
            reason,
        })?;
        let own = values(&own);
        Ok(std::array::from_fn(|k| Some(drawn(stream, k, own[k], self.scatter))))
    }
}

/// A search for one target.
pub struct Fitted<'a> {
    /// What the grain should have.
    pub target: Target,
    /// How it is searched for.
    pub parameters: &'a TailoredParameters,
}

impl Draw for Fitted<'_> {
    fn validate(&self) -> Result<(), Fault> {
        self.parameters.validate()
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let maker = Maker::new(self.parameters.segments, stream);
        let roundness = self.target[3].is_some();
        let cost = |x: &[f64; 5]| {
            let mesh = maker.mesh(x);
            let found =
                if roundness { describe(&mesh) } else { super::descriptors::describe_form(&mesh) };
            let Ok(found) = found else { return 1e12 };
            let misses = values(&found);
            let miss: f64 = (0..5)
                .filter_map(|k| Some(((misses[k] - self.target[k]?) / TOLERANCE[k]).powi(2)))
                .sum();
            // Weak: keeps parameters that nothing asks for where they started.
            miss + 1e-3 * x.iter().map(|p| p * p).sum::<f64>()
        };
        let start = self.start();
        let best = search(&cost, start, self.parameters.steps);
        let mesh = maker.mesh(&best);
        let found = values(&describe(&mesh)?);
        let facts = (0..5).map(|k| Fact {
            quantity: NAMES[k].to_owned(),
            asked: self.target[k],
            measured: found[k],
        });
        Ok(Drawn { mesh, recipe: "made to measure".to_owned(), facts: facts.collect() })
    }
}

impl Fitted<'_> {
    /// Where the search begins: the axes as wanted, edges and waves by rule of thumb.
    fn start(&self) -> [f64; 5] {
        let [elongation, flatness, sphericity, roundness, convexity] = self.target;
        let ratio = |value: Option<f64>| value.unwrap_or(0.8).min(0.999).ln();
        let edges = roundness.map_or(0.5, |r| 1.2 * (1.0 - r));
        let dents = convexity.map_or(0.3, |c| 4.0 * (1.0 - c));
        let waves = sphericity.map_or(0.3, |s| 2.0 * (0.95 - s).max(0.0));
        [ratio(elongation), ratio(flatness), edges, dents, waves]
    }
}

/// Turns parameters into a mesh, with the waves of one grain.
struct Maker {
    sphere: Mesh,
    dents: Vec<f64>,
    waves: Vec<f64>,
}

impl Maker {
    fn new(segments: u32, stream: &mut Stream) -> Self {
        let sphere = Primitive::Sphere { diameter: 2.0 }.mesh(segments);
        let dents = Series::draw(3, &[0.7, 0.55, 0.45], stream);
        let waves = Series::draw(6, &[0.5, 0.45, 0.4, 0.37, 0.33, 0.3, 0.28], stream);
        let on = |series: &Series| sphere.vertices.iter().map(|d| series.at(d)).collect();
        Self { dents: on(&dents), waves: on(&waves), sphere }
    }

    fn mesh(&self, x: &[f64; 5]) -> Mesh {
        let axes =
            Vec3::new(1.0, x[0].clamp(-2.5, 0.3).exp(), (x[0] + x[1]).clamp(-4.0, 0.3).exp());
        // 1 is an ellipsoid; smaller exponents have edges.
        let exponent = (-x[2].abs()).exp().clamp(0.12, 1.0);
        let vertices = self
            .sphere
            .vertices
            .iter()
            .enumerate()
            .map(|(k, d)| {
                let height = 0.15 * x[3] * self.dents[k] + 0.1 * x[4] * self.waves[k];
                let radius =
                    superquadric::radius(d, exponent, exponent) * height.clamp(-2.0, 1.0).exp();
                (d * radius).component_mul(&axes)
            })
            .collect();
        Mesh { vertices, triangles: self.sphere.triangles.clone() }
    }
}

/// Nelder & Mead 1965 with the usual coefficients; returns the best point.
fn search(cost: &dyn Fn(&[f64; 5]) -> f64, start: [f64; 5], steps: u32) -> [f64; 5] {
    const STEP: [f64; 5] = [0.1, 0.1, 0.3, 0.3, 0.3];
    let mut simplex: Vec<(f64, [f64; 5])> = (0..6)
        .map(|k| {
            let mut x = start;
            if k > 0 {
                x[k - 1] += STEP[k - 1];
            }
            (cost(&x), x)
        })
        .collect();
    let mut used = 6;
    while used < steps {
        simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Half a tolerance off in all is good enough.
        if simplex[0].0 < 0.1 {
            break;
        }
        let middle: [f64; 5] =
            std::array::from_fn(|i| simplex[..5].iter().map(|(_, x)| x[i]).sum::<f64>() / 5.0);
        let worst = simplex[5];
        let towards = |factor: f64| -> (f64, [f64; 5]) {
            let x = std::array::from_fn(|i| middle[i] + factor * (worst.1[i] - middle[i]));
            (cost(&x), x)
        };
        let mirrored = towards(-1.0);
        used += 1;
        simplex[5] = if mirrored.0 < simplex[0].0 {
            let farther = towards(-2.0);
            used += 1;
            if farther.0 < mirrored.0 { farther } else { mirrored }
        } else if mirrored.0 < simplex[4].0 {
            mirrored
        } else {
            let nearer = towards(if mirrored.0 < worst.0 { -0.5 } else { 0.5 });
            used += 1;
            if nearer.0 >= worst.0.min(mirrored.0) {
                let best = simplex[0].1;
                for entry in &mut simplex[1..] {
                    let x = std::array::from_fn(|i| 0.5 * (best[i] + entry.1[i]));
                    *entry = (cost(&x), x);
                    used += 1;
                }
                continue;
            }
            nearer
        };
    }
    simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
    simplex[0].1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fitted(target: Target, steps: u32) -> Drawn {
        let parameters = TailoredParameters { steps, segments: 20, ..Default::default() };
        Fitted { target, parameters: &parameters }
            .draw(&mut random::stream(1, "tailored", 0))
            .expect("a mesh")
    }

    #[test]
    fn the_search_finds_what_can_be_had() {
        let target = [Some(0.75), Some(0.6), Some(0.84), None, Some(0.97)];
        let drawn = fitted(target, 200);
        for (fact, tolerance) in drawn.facts.iter().zip([0.02, 0.02, 0.015, 1.0, 0.015]) {
            let Some(asked) = fact.asked else { continue };
            assert!((fact.measured - asked).abs() < tolerance, "{fact:?}");
        }
    }

    #[test]
    fn targets_follow_the_wanted_distribution() {
        let parameters = TailoredParameters {
            elongation: Some([0.7, 0.1]),
            convexity: Some([0.99, 0.05]),
            ..Default::default()
        };
        parameters.validate().expect("in their ranges");
        let targets: Vec<Target> = (0..400)
            .map(|index| {
                let mut stream = random::stream(1, "target", index);
                parameters.target(Path::new("."), &mut stream).expect("no files")
            })
            .collect();
        let elongations: Vec<f64> = targets.iter().filter_map(|t| t[0]).collect();
        let [mean, deviation, ..] = crate::shape::field::moments(&elongations);
        assert!((mean - 0.7).abs() < 0.02 && (deviation - 0.1).abs() < 0.02);
        assert!(targets.iter().all(|t| t[1].is_none() && t[4].is_some_and(|c| c <= 1.0)));
        let nothing = TailoredParameters::default();
        assert_eq!(nothing.validate().expect_err("nothing wanted").key, "like");
    }

    #[test]
    fn a_folder_of_grains_gives_its_own_descriptors() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mesh = Primitive::Ellipsoid { axes: Vec3::new(2.0, 1.5, 1.0) }.mesh(40);
        format::stl::write(&folder.path().join("a.stl"), &mesh).expect("writes");
        let parameters =
            TailoredParameters { like: Some(".".into()), scatter: 0.0, ..Default::default() };
        let mut stream = random::stream(1, "like", 0);
        let target = parameters.target(folder.path(), &mut stream).expect("one file");
        assert!((target[0].expect("all") - 0.75).abs() < 0.01, "{target:?}");
        assert!((target[1].expect("all") - 2.0 / 3.0).abs() < 0.01, "{target:?}");
    }
}
