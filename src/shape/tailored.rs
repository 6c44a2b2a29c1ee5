//! Made to measure: grains whose descriptors follow wanted distributions.
//!
//! For each grain a target is drawn: each wanted descriptor from a normal
//! distribution (mean, standard deviation) cut off at its limits, or all of
//! them at once from one file of a folder of scanned grains (chosen at random, so that
//! correlations between descriptors are kept), with some scatter. A star-shaped family with
//! six parameters is then searched for it: ratios of axes b/a and c/b, the exponent e of a
//! superellipsoid (edges), the depth of cuts by 8 to 18 planes of the grain's own (facets; over the
//! support (Σ|n_k|^q)^(1/q), q = 2/(2 − e), of the superellipsoid in their directions n), and the amplitudes of two series of spherical
//! harmonics with random coefficients of the grain's own (degrees 3–5: dents; 6–12: roughness).
//! Without the cuts no member has corners that are sharp and yet nearly a sphere's volume over its area.
//! Two short searches (Nelder & Mead 1965), one that begins with edges and one with cuts, and one more from the better make the mean square of the misses, each over its
//! tolerance, least; descriptors that are not wanted are left free, held only
//! weakly at the start. What cannot be had together (a sphericity above that of the ellipsoid
//! of the same elongation and flatness, say) ends at the nearest that the
//! family has: asked and measured are both reported. Cost: 240 meshes a grain,
//! about 1.5 s where roundness is wanted, 0.1 to 0.3 s otherwise. Edges between cuts keep their angle, as the
//! nearest vertices are moved onto them, but corners are as blunt as the triangles are large: roundness
//! below 0.45 together with a convexity near 1 comes out up to 0.09 too high.

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
    /// Steps of the searches together, from 20 to 2000; default 240.
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
            steps: 240,
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
        let cost = |x: &Point| {
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
        // Corners by the superellipsoid or by cuts: a search does not find from one to the other.
        let part = self.parameters.steps / 3;
        let [square, cut] = self.starts().map(|start| search(&cost, start, part));
        let nearer = if cost(&cut) < cost(&square) { cut } else { square };
        let best = search(&cost, nearer, self.parameters.steps - 2 * part);
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
    /// Where searches begin: the axes as wanted, edges, cuts and waves by rule of thumb.
    fn starts(&self) -> [Point; 2] {
        let [elongation, flatness, sphericity, roundness, convexity] = self.target;
        let ratio = |value: Option<f64>| value.unwrap_or(0.8).min(0.999).ln();
        let sharp = roundness.map_or(0.4, |r| 1.0 - r);
        let dents = convexity.map_or(0.3, |c| 4.0 * (1.0 - c));
        let waves = sphericity.map_or(0.3, |s| 2.0 * (0.95 - s).max(0.0));
        [[1.2, 0.0], [0.6, 1.5]].map(|[edges, cuts]| {
            let (b, c) = (ratio(elongation), ratio(flatness));
            [b, c, edges * sharp, dents, waves, cuts * sharp]
        })
    }
}

/// Turns parameters into a mesh, with the waves of one grain.
struct Maker {
    sphere: Mesh,
    segments: u32,
    /// Directions of planes and how deep each of them cuts beside the others.
    planes: Vec<(Vec3, f64)>,
    dents: Vec<f64>,
    waves: Vec<f64>,
}

impl Maker {
    fn new(segments: u32, stream: &mut Stream) -> Self {
        let sphere = Primitive::Sphere { diameter: 2.0 }.mesh(segments);
        let dents = Series::draw(3, &[0.7, 0.55, 0.45], stream);
        let waves = Series::draw(6, &[0.5, 0.45, 0.4, 0.37, 0.33, 0.3, 0.28], stream);
        let on = |series: &Series| sphere.vertices.iter().map(|d| series.at(d)).collect();
        let planes = planes(stream);
        Self { dents: on(&dents), waves: on(&waves), planes, sphere, segments }
    }

    fn mesh(&self, x: &Point) -> Mesh {
        let axes =
            Vec3::new(1.0, x[0].clamp(-2.5, 0.3).exp(), (x[0] + x[1]).clamp(-4.0, 0.3).exp());
        // 1 is an ellipsoid; smaller exponents have edges.
        let exponent = (-x[2].abs()).exp().clamp(0.12, 1.0);
        let depth = (0.2 * x[5].abs()).min(0.7);
        // Less than half the height of a triangle, so that none turns over.
        let near = 0.3 * 2.0 * std::f64::consts::PI / f64::from(self.segments);
        let conjugate = 2.0 / (2.0 - exponent);
        let support = |n: &Vec3| n.map(|c| c.abs().powf(conjugate)).sum().powf(1.0 / conjugate);
        let planes: Vec<Vec3> =
            self.planes.iter().map(|(n, share)| n / (support(n) * (1.0 - depth * share))).collect();
        let vertices = self
            .sphere
            .vertices
            .iter()
            .enumerate()
            .map(|(k, d)| {
                let height = 0.15 * x[3] * self.dents[k] + 0.1 * x[4] * self.waves[k];
                let d = &to_ridge(d, &planes, near);
                // 1/r of the plane that is nearest along d.
                let cut = planes.iter().map(|plane| plane.dot(d)).fold(0.0, f64::max);
                let whole = superquadric::radius(d, exponent, exponent).min(1.0 / cut);
                let radius = whole * height.clamp(-2.0, 1.0).exp();
                (d * radius).component_mul(&axes)
            })
            .collect();
        Mesh { vertices, triangles: self.sphere.triangles.clone() }
    }
}

/// The direction `d`, moved to where the two planes nearest along it meet if that is no farther than
/// `near`: else triangles would cut off the edge between them.
fn to_ridge(d: &Vec3, planes: &[Vec3], near: f64) -> Vec3 {
    let mut two = [(0.0, 0), (0.0, 0)];
    for (index, plane) in planes.iter().enumerate() {
        let cut = plane.dot(d);
        if cut > two[0].0 {
            two = [(cut, index), two[0]];
        } else if cut > two[1].0 {
            two[1] = (cut, index);
        }
    }
    let Some(across) = (planes[two[0].1] - planes[two[1].1]).try_normalize(1e-9) else { return *d };
    let off = across.dot(d);
    if two[1].0 > 0.0 && off < near { (d - across * off).normalize() } else { *d }
}

/// Directions spread evenly (Fibonacci spiral, turned at random) and shaken, with depths.
fn planes(stream: &mut Stream) -> Vec<(Vec3, f64)> {
    let count = random::whole(stream, 8, 18);
    let turn = random::rotation(stream);
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count)
        .map(|k| {
            let z = 1.0 - (2 * k + 1) as f64 / count as f64;
            let (s, c) = (golden * k as f64).sin_cos();
            let ring = (1.0 - z * z).sqrt();
            let shaken = Vec3::new(ring * c, ring * s, z) + random::direction(stream) * 0.2;
            (turn * shaken.normalize(), random::uniform(stream, 0.0, 1.0))
        })
        .collect()
}

/// Parameters of the family.
type Point = [f64; 6];

/// Nelder & Mead 1965 with the usual coefficients; returns the best point.
fn search(cost: &dyn Fn(&Point) -> f64, start: Point, steps: u32) -> Point {
    const STEP: Point = [0.1, 0.1, 0.3, 0.3, 0.3, 0.3];
    let corners = start.len() + 1;
    let mut simplex: Vec<(f64, Point)> = (0..corners)
        .map(|k| {
            let mut x = start;
            if k > 0 {
                x[k - 1] += STEP[k - 1];
            }
            (cost(&x), x)
        })
        .collect();
    let mut used = corners as u32;
    while used < steps {
        simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Half a tolerance off in all is good enough.
        if simplex[0].0 < 0.1 {
            break;
        }
        let last = corners - 1;
        let middle: Point = std::array::from_fn(|i| {
            simplex[..last].iter().map(|(_, x)| x[i]).sum::<f64>() / last as f64
        });
        let worst = simplex[last];
        let towards = |factor: f64| -> (f64, Point) {
            let x = std::array::from_fn(|i| middle[i] + factor * (worst.1[i] - middle[i]));
            (cost(&x), x)
        };
        let mirrored = towards(-1.0);
        used += 1;
        simplex[last] = if mirrored.0 < simplex[0].0 {
            let farther = towards(-2.0);
            used += 1;
            if farther.0 < mirrored.0 { farther } else { mirrored }
        } else if mirrored.0 < simplex[last - 1].0 {
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
    fn edges_between_cuts_are_not_cut_off() {
        let planes = [Vec3::x(), Vec3::new(0.0, 1.0, 0.0), Vec3::z()];
        let d = Vec3::new(1.0, 0.95, 0.1).normalize();
        let moved = to_ridge(&d, &planes, 0.1);
        assert!((moved.x - moved.y).abs() < 1e-12 && (moved.norm() - 1.0).abs() < 1e-12);
        assert!((moved - d).norm() < 0.05);
        assert_eq!(to_ridge(&d, &planes, 0.01), d);
        assert_eq!(to_ridge(&d, &planes[..1], 0.1), d);
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
