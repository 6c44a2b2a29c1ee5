//! Growth along inward normals (R5).
//!
//! Source: Ferellec & McDowell 2010, Géotechnique 60, 459–464 (2008 in
//! Géomécanique et Géoingénierie). A sphere touches the surface at a point p with
//! outward normal n, its centre p − r·n; it grows until another surface point q
//! would lie deeper than t inside it:
//!   r = (|q−p|² − t²) / (2 ((p−q)·n − t)) for (p−q)·n > t,
//! least over all q; t = 0 is the source's rule. The q that stops the growth is
//! found exactly: grow to a bound, take the surface point nearest to the centre,
//! shrink to it, repeat (Ma, Bae & Choi 2012). Points are drawn on the faces, not
//! at vertices only, and the last step takes the radius from the distance itself,
//! so that no sphere sticks out by more than t whatever the triangulation.
//!
//! A point starts a sphere only while it is farther than δ from all spheres so
//! far. Order `random` is the source's; order `fit` takes next the sphere that
//! lowers the sum of squared distances from the points to the spheres most, points
//! inside spheres included (lazy greedy: gains hardly ever rise as spheres are added).
//!
//! One piece: after the first, a sphere counts only if it overlaps an earlier one
//! (by 5 % of the smaller radius at least); places that cannot be reached so stay
//! uncovered, and the method line gives the share of covered points.
//! Measured on eight rock shapes with 20 spheres: root mean square distance 1.3 % of the
//! equivalent diameter, volume within 9 % (mean 3.4 %), moments within 2 %. The best t
//! falls with the count: 0.02 at 20 spheres, 0.01 at 50, 0.005 at 200.
//! Cost: two to five distance queries and O(points) a sphere tried, O(points) a gain.

use super::ClumpError;
use super::pieces::joined;
use super::target::{Found, Target};
use crate::geometry::distance::sample_surface;
use crate::geometry::{Ball, SurfacePoint};
use crate::num::random::{Stream, whole};
use crate::num::{Fault, Job, MethodEntry, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `riprap list clumps` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "normals",
    id: "R5",
    summary: "spheres grown along inward normals from random surface points",
    source: "Ferellec & McDowell 2010",
    example: r#"clump.normals = { spheres = 20 }"#,
};

/// Spheres grown along inward normals from random surface points (R5). Lengths
/// are shares of the solid's equivalent diameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Normals {
    /// Most spheres; 1 to 10000, default 20.
    #[serde(default = "default_spheres")]
    pub spheres: usize,
    /// δ: a surface point nearer than this to a sphere is covered; 0.0001 to 0.5, default 0.01.
    #[serde(default = "default_threshold")]
    pub threshold: f64,
    /// Least radius; 0.001 to 0.5, default 0.03.
    #[serde(default = "default_smallest")]
    pub smallest: f64,
    /// t: how far a sphere may stick out of the solid; 0 (inscribed) to 0.2, default 0.02.
    #[serde(default = "default_protrusion")]
    pub protrusion: f64,
    /// Stops when this share of the surface points is covered; 0.01 to 1, default 1.
    #[serde(default = "default_coverage")]
    pub coverage: f64,
    /// Surface points; 50 to 20000, default 1000; the cost grows with their square.
    #[serde(default = "default_points")]
    pub points: usize,
    /// Which point comes next; default `fit`.
    #[serde(default)]
    pub order: Order,
}

/// Which surface point starts the next sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// The one whose sphere brings the spheres nearest to the surface.
    #[default]
    Fit,
    /// Any, at random, as in the source: many more spheres for the same error.
    Random,
}

fn default_spheres() -> usize {
    20
}
fn default_threshold() -> f64 {
    0.01
}
fn default_smallest() -> f64 {
    0.03
}
fn default_protrusion() -> f64 {
    0.02
}
fn default_coverage() -> f64 {
    1.0
}
fn default_points() -> usize {
    1000
}

impl Default for Normals {
    fn default() -> Self {
        Self {
            spheres: default_spheres(),
            threshold: default_threshold(),
            smallest: default_smallest(),
            protrusion: default_protrusion(),
            coverage: default_coverage(),
            points: default_points(),
            order: Order::default(),
        }
    }
}

impl Normals {
    /// # Errors
    /// [`Fault`] for a value out of its range.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("spheres", self.spheres as f64, 1.0, 10_000.0)?;
        Fault::within("threshold", self.threshold, 1e-4, 0.5)?;
        Fault::within("smallest", self.smallest, 1e-3, 0.5)?;
        Fault::within("protrusion", self.protrusion, 0.0, 0.2)?;
        Fault::within("coverage", self.coverage, 0.01, 1.0)?;
        Fault::within("points", self.points as f64, 50.0, 20_000.0)
    }

    pub(super) fn find(
        &self,
        target: &Target,
        stream: &mut Stream,
        job: &Job,
    ) -> Result<Found, ClumpError> {
        let mut points = sample_surface(&target.solid.mesh, self.points, stream);
        shuffle(&mut points, stream);
        let mut growth = Growth {
            method: self,
            target,
            gaps: points.iter().map(|p| (p.point - target.solid.mass.centroid).norm()).collect(),
            points,
            balls: Vec::new(),
            widest: target.solid.mesh.bounds().diagonal() / 2.0,
            job,
        };
        match self.order {
            Order::Fit => growth.by_fit()?,
            Order::Random => growth.at_random()?,
        }
        if growth.balls.is_empty() {
            return Err(ClumpError::NoSphere {
                name: target.solid.name.clone(),
                advice: "lower `smallest` or raise `protrusion`",
            });
        }
        Ok(Found { note: self.note(&growth), balls: growth.balls })
    }

    fn note(&self, growth: &Growth) -> String {
        let order = match self.order {
            Order::Fit => "fit",
            Order::Random => "random",
        };
        format!(
            "normals (Ferellec & McDowell 2010): {} of at most {} spheres, {:.1} % of {} points within {} of the \
             equivalent diameter, protrusion {}, smallest {}, order {order}",
            growth.balls.len(),
            self.spheres,
            100.0 * growth.covered(),
            self.points,
            self.threshold,
            self.protrusion,
            self.smallest,
        )
    }
}

/// Fisher–Yates.
fn shuffle(points: &mut [SurfacePoint], stream: &mut Stream) {
    for last in (1..points.len()).rev() {
        points.swap(last, whole(stream, 0, last as u64) as usize);
    }
}

/// Radius at which a sphere that touches the surface at p swallows the point at
/// `offset` from p to the depth `allowed`; infinite if it never does.
pub(super) fn stop(offset: &Vec3, normal: &Vec3, allowed: f64) -> f64 {
    let below = -offset.dot(normal) - allowed;
    let over = offset.norm_squared() - allowed * allowed;
    if below > 0.0 && over > 0.0 { over / (2.0 * below) } else { f64::INFINITY }
}

/// Spheres so far, and how far each surface point is from them.
struct Growth<'a> {
    method: &'a Normals,
    target: &'a Target<'a>,
    points: Vec<SurfacePoint>,
    /// Distance from each point to the nearest sphere so far, negative inside; at first to the centroid, m.
    gaps: Vec<f64>,
    balls: Vec<Ball>,
    /// No sphere inside the solid is larger, m.
    widest: f64,
    job: &'a Job,
}

impl Growth<'_> {
    /// The sphere that touches the surface at point `at`; `None` below the least radius.
    fn grow(&self, at: usize) -> Option<Ball> {
        let SurfacePoint { point, normal, .. } = self.points[at];
        let diameter = self.target.diameter;
        let allowed = self.method.protrusion * diameter;
        let smallest = self.method.smallest * diameter;
        let near_enough = allowed + 1e-4 * diameter;
        let mut radius = self.bound(&point, &normal, allowed);
        while radius >= smallest {
            let centre = point - normal * radius;
            let nearest = self.target.distance.nearest(&centre);
            if radius + nearest.distance <= near_enough {
                let radius = radius.min(allowed - nearest.distance);
                return (radius >= smallest).then_some(Ball { centre, radius });
            }
            let next = stop(&(nearest.point - point), &normal, allowed);
            // A centre outside the solid may have no bound from its nearest point.
            radius = if next < radius * 0.999_999 { next } else { radius * 0.5 };
        }
        None
    }

    /// The radius at which the first of the drawn points stops the growth: never
    /// below the true one, and close to it, which saves slow queries from deep inside.
    fn bound(&self, point: &Vec3, normal: &Vec3, allowed: f64) -> f64 {
        self.points
            .iter()
            .map(|other| stop(&(other.point - point), normal, allowed))
            .fold(self.widest, f64::min)
    }

    fn by_fit(&mut self) -> Result<(), ClumpError> {
        let mut candidates = Vec::new();
        for at in 0..self.points.len() {
            if at % 256 == 0 {
                self.stop_if_asked()?;
            }
            if let Some(ball) = self.grow(at) {
                candidates.push(Candidate { ball, at, gain: f64::INFINITY });
            }
        }
        while !self.done() {
            self.stop_if_asked()?;
            // Falling by the gain they had when last looked at, which bounds the gain now.
            candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain).then(a.at.cmp(&b.at)));
            let mut best: Option<(f64, usize)> = None;
            for (index, candidate) in candidates.iter_mut().enumerate() {
                if best.is_some_and(|(gain, _)| gain >= candidate.gain) {
                    break;
                }
                candidate.gain =
                    if self.open(candidate.at) { self.gain(&candidate.ball) } else { 0.0 };
                let better = best.is_none_or(|(gain, _)| candidate.gain > gain);
                if better && candidate.gain > 0.0 && self.holds(&candidate.ball) {
                    best = Some((candidate.gain, index));
                }
            }
            let Some((_, index)) = best else { return Ok(()) };
            self.add(candidates.swap_remove(index).ball);
        }
        Ok(())
    }

    fn at_random(&mut self) -> Result<(), ClumpError> {
        let mut waiting: Vec<usize> = (0..self.points.len()).collect();
        loop {
            let before = self.balls.len();
            let mut apart = Vec::new();
            for at in waiting {
                if self.done() {
                    return Ok(());
                }
                self.stop_if_asked()?;
                if !self.open(at) {
                    continue;
                }
                match self.grow(at) {
                    Some(ball) if self.holds(&ball) => self.add(ball),
                    // May hang together with a later sphere.
                    Some(_) => apart.push(at),
                    None => {}
                }
            }
            if apart.is_empty() || self.balls.len() == before {
                return Ok(());
            }
            waiting = apart;
        }
    }

    fn stop_if_asked(&self) -> Result<(), ClumpError> {
        if self.job.is_cancelled() { Err(ClumpError::Cancelled) } else { Ok(()) }
    }

    fn done(&self) -> bool {
        self.balls.len() >= self.method.spheres
            || (!self.balls.is_empty() && self.covered() >= self.method.coverage)
    }

    fn open(&self, at: usize) -> bool {
        self.balls.is_empty() || self.gaps[at] > self.method.threshold * self.target.diameter
    }

    fn covered(&self) -> f64 {
        let open = (0..self.points.len()).filter(|&at| self.open(at)).count();
        1.0 - open as f64 / self.points.len() as f64
    }

    fn holds(&self, ball: &Ball) -> bool {
        self.balls.is_empty() || self.balls.iter().any(|other| joined(ball, other))
    }

    /// How much the sum of squared distances would fall.
    fn gain(&self, ball: &Ball) -> f64 {
        self.points
            .iter()
            .zip(&self.gaps)
            .map(|(p, &old)| {
                // Without the square root where the sphere is no nearer than others.
                let square = (p.point - ball.centre).norm_squared();
                if square >= (ball.radius + old).max(0.0).powi(2) {
                    return 0.0;
                }
                let new = (square.sqrt() - ball.radius).min(old);
                old * old - new * new
            })
            .sum()
    }

    fn add(&mut self, ball: Ball) {
        for (p, gap) in self.points.iter().zip(&mut self.gaps) {
            *gap = gap.min((p.point - ball.centre).norm() - ball.radius);
        }
        self.balls.push(ball);
        let (done, most) = (self.balls.len() as u64, self.method.spheres as u64);
        self.job.report("spheres", done, most);
    }
}

/// A sphere that may be taken next.
struct Candidate {
    ball: Ball,
    at: usize,
    gain: f64,
}
