//! Spheres moved and grown by virtual forces (R3).
//!
//! Source: Matsushima & Saomoto 2002 and Matsushima et al. 2003 (dynamic optimisation for
//! three-dimensional irregular particles). N spheres start at random places inside with
//! random radii. Every surface point x pulls at its nearest sphere with its gap
//! g = |x − c| − r: the force k_t·g along the line from centre to point moves the centre,
//! the force k_r·g changes the radius. Equations of motion with unit mass a sphere and mean
//! forces of its points, damped at the rate c:
//!   v̇ = k_t ⟨g u⟩ − c v, ẇ = k_r ⟨g⟩ − c w,
//! semi-implicit Euler. Ends when the mean force falls below 1e-4 of k_t·d or after `steps`.
//! From several starts the one with the least mean square gap is kept; the method line gives
//! the spread of the others, because the result depends on the start and on k_r/k_t.
//!
//! Cost O(starts · steps · points · spheres).

use super::ClumpError;
use super::patches::Patches;
use super::pieces::largest_piece;
use super::target::{Found, Target};
use crate::geometry::Ball;
use crate::num::random::{Stream, uniform};
use crate::num::{Fault, Job, MethodEntry, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `riprap list clumps` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "dynamic",
    id: "R3",
    summary: "random spheres moved and grown by virtual forces from the surface",
    source: "Matsushima et al. 2003",
    example: r#"clump.dynamic = { spheres = 10 }"#,
};

/// Time step over the time unit of k_t = 1: a fortieth of the shortest period.
const STEP: f64 = 0.15;
/// Rate of damping.
const DAMPING: f64 = 1.0;

/// Spheres moved and grown by virtual forces (R3).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Dynamic {
    /// Spheres; 1 to 500, default 10.
    #[serde(default = "default_spheres")]
    pub spheres: usize,
    /// k_r/k_t: stiffness of growth over that of motion; 0.01 to 10, default 1.
    #[serde(default = "default_growth")]
    pub growth: f64,
    /// Starts from which the best is kept; 1 to 100, default 4.
    #[serde(default = "default_starts")]
    pub starts: usize,
    /// Most time steps a start; 10 to 100000, default 600.
    #[serde(default = "default_steps")]
    pub steps: usize,
    /// Surface points; 50 to 20000, default 1000.
    #[serde(default = "default_points")]
    pub points: usize,
}

fn default_spheres() -> usize {
    10
}
fn default_growth() -> f64 {
    1.0
}
fn default_starts() -> usize {
    4
}
fn default_steps() -> usize {
    600
}
fn default_points() -> usize {
    1000
}

impl Default for Dynamic {
    fn default() -> Self {
        Self {
            spheres: default_spheres(),
            growth: default_growth(),
            starts: default_starts(),
            steps: default_steps(),
            points: default_points(),
        }
    }
}

impl Dynamic {
    /// # Errors
    /// [`Fault`] for a value out of its range.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("spheres", self.spheres as f64, 1.0, 500.0)?;
        Fault::within("growth", self.growth, 0.01, 10.0)?;
        Fault::within("starts", self.starts as f64, 1.0, 100.0)?;
        Fault::within("steps", self.steps as f64, 10.0, 100_000.0)?;
        Fault::within("points", self.points as f64, 50.0, 20_000.0)
    }

    pub(super) fn find(
        &self,
        target: &Target,
        stream: &mut Stream,
        job: &Job,
    ) -> Result<Found, ClumpError> {
        let patches = Patches::new(&target.solid.mesh, self.points);
        let mut best: Option<(f64, Vec<Ball>)> = None;
        let mut worst: f64 = 0.0;
        for start in 0..self.starts {
            let (error, balls) = self.settle(target, &patches, stream, job)?;
            worst = worst.max(error);
            if best.as_ref().is_none_or(|(least, _)| error < *least) {
                best = Some((error, balls));
            }
            job.report("starts", start as u64 + 1, self.starts as u64);
        }
        let (least, balls) = best.unwrap_or_default();
        let (balls, dropped) = largest_piece(balls);
        if balls.is_empty() {
            return Err(ClumpError::NoSphere {
                name: target.solid.name.clone(),
                advice: "raise `starts` or `spheres`",
            });
        }
        let left = match dropped {
            0 => String::new(),
            count => format!("; {count} spheres apart from the largest piece left out"),
        };
        let note = format!(
            "dynamic (Matsushima et al. 2003): {} spheres, growth {}, best of {} starts: \
             root mean square gap {:.4} of the equivalent diameter, worst {:.4}{left}",
            balls.len(),
            self.growth,
            self.starts,
            least / target.diameter,
            worst / target.diameter
        );
        Ok(Found { balls, note })
    }

    /// Root mean square gap, m, and spheres from one random start.
    fn settle(
        &self,
        target: &Target,
        patches: &Patches,
        stream: &mut Stream,
        job: &Job,
    ) -> Result<(f64, Vec<Ball>), ClumpError> {
        let mut balls = self.start(target, stream);
        let mut motion = vec![(Vec3::zeros(), 0.0_f64); balls.len()];
        let floor = 0.01 * target.diameter;
        let mut error = f64::INFINITY;
        for step in 0..self.steps {
            if step % 64 == 0 && job.is_cancelled() {
                return Err(ClumpError::Cancelled);
            }
            let (square, pulls) = pulls(patches, &balls);
            error = square.sqrt();
            let mut force: f64 = 0.0;
            for ((ball, (v, w)), (pull, gap, count)) in balls.iter_mut().zip(&mut motion).zip(pulls)
            {
                let share = 1.0 / f64::from(count.max(1));
                let (pull, growth) = (pull * share, gap * share * self.growth);
                force = force.max(pull.norm()).max(growth.abs());
                *v = (*v + pull * STEP) / (1.0 + DAMPING * STEP);
                *w = (*w + growth * STEP) / (1.0 + DAMPING * STEP);
                ball.centre += *v * STEP;
                ball.radius = (ball.radius + *w * STEP).max(floor);
            }
            if force < 1e-4 * target.diameter {
                break;
            }
        }
        Ok((error, balls))
    }

    /// Spheres at random places inside, between a tenth of and the whole distance to the surface.
    fn start(&self, target: &Target, stream: &mut Stream) -> Vec<Ball> {
        let bounds = target.solid.mesh.bounds();
        let size = bounds.size();
        let mut balls = Vec::with_capacity(self.spheres);
        // A thin solid fills little of its box: the places tried are bounded.
        for _ in 0..2000 * self.spheres {
            if balls.len() == self.spheres {
                break;
            }
            let centre = bounds.low + Vec3::from_fn(|axis, _| uniform(stream, 0.0, size[axis]));
            let depth = -target.distance.at(&centre);
            if depth > 0.0 {
                balls.push(Ball { centre, radius: depth * uniform(stream, 0.1, 1.0) });
            }
        }
        balls
    }
}

/// Mean square gap, and for every sphere the sum of gap vectors, of gaps, and its points.
fn pulls(patches: &Patches, balls: &[Ball]) -> (f64, Vec<(Vec3, f64, u32)>) {
    let mut sums = vec![(Vec3::zeros(), 0.0, 0); balls.len()];
    let mut square = 0.0;
    for point in &patches.points {
        let nearest = balls.iter().enumerate().fold((0, f64::INFINITY), |best, (k, ball)| {
            let gap = (point - ball.centre).norm() - ball.radius;
            if gap < best.1 { (k, gap) } else { best }
        });
        let Some(ball) = balls.get(nearest.0) else { break };
        let sum = &mut sums[nearest.0];
        sum.0 += (point - ball.centre).try_normalize(0.0).unwrap_or_default() * nearest.1;
        sum.1 += nearest.1;
        sum.2 += 1;
        square += nearest.1 * nearest.1;
    }
    (square / patches.points.len().max(1) as f64, sums)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clump::reproduce::tests::solid;
    use crate::clump::{MassSource, Method, reproduce};
    use crate::geometry::samples::{icosphere, random_star};

    #[test]
    fn one_sphere_settles_on_the_ball() {
        let ball = solid("ball", icosphere(3).mapped(|v| v * 1e-3 + Vec3::repeat(5e-3)));
        let method = Method::Dynamic(Dynamic { spheres: 1, starts: 1, ..Dynamic::default() });
        let clump =
            reproduce(&ball, &method, MassSource::Solid, 3, 0, &Job::quiet()).expect("a clump");
        assert!((clump.balls[0].radius / 1e-3 - 1.0).abs() < 0.01, "{}", clump.method);
        assert!(clump.balls[0].centre.norm() < 1e-5);
    }

    #[test]
    fn more_starts_never_do_worse_and_the_spread_is_said() {
        let star = solid("star", random_star(5, 0.5));
        let rms = |starts| {
            let method =
                Dynamic { spheres: 6, starts, steps: 150, points: 300, ..Dynamic::default() };
            let method = Method::Dynamic(method);
            let clump =
                reproduce(&star, &method, MassSource::Solid, 3, 0, &Job::quiet()).expect("a clump");
            let text = clump.method;
            let at = text.find("gap ").expect("said") + 4;
            text[at..at + 6].parse::<f64>().expect("a number")
        };
        let (one, four) = (rms(1), rms(4));
        assert!(four <= one && four < 0.06, "{one} {four}");
        assert!(Dynamic { growth: 0.0, ..Dynamic::default() }.validate().is_err());
    }
}
