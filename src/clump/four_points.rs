//! Spheres through four surface points, then two alternating adjustments (R4).
//!
//! Source: Price, Murariu & Morrison 2007 (sphere clump generation and trajectory comparison
//! for real particles). 1. The sphere through each random set of four surface points: its
//! centre solves 2 (p_j − p_0)·c = |p_j|² − |p_0|², j = 1…3; sets nearly in one plane are
//! refused (determinant of the edges below 1e-6 of the product of their lengths), and so are
//! spheres that stick out by more than the tolerance. Of those kept the ones that bring the
//! union nearest to the surface are taken, one after the other. 2. Every surface point is tied
//! to its nearest sphere; alternately (a) every centre moves by the mean of its points' gap
//! vectors and (b) every radius becomes the mean distance of its points, until centres move
//! less than 1e-4 of the equivalent diameter or after `rounds` rounds.
//!
//! A set is drawn around one random point, within a random reach: four points anywhere on the
//! surface hardly ever have their sphere inside. Cost O(draws · log triangles) and
//! O(rounds · points · spheres).

use super::ClumpError;
use super::cover::greedy;
use super::patches::Patches;
use super::pieces::largest_piece;
use super::target::{Found, Target};
use crate::geometry::Ball;
use crate::num::random::{Stream, uniform, whole};
use crate::num::{Fault, Job, Mat3, MethodEntry, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `riprap list clumps` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "four_points",
    id: "R4",
    summary: "spheres through random sets of four surface points, then centres and radii in turn",
    source: "Price et al. 2007",
    example: r#"clump.four_points = { spheres = 20 }"#,
};

/// Spheres through four surface points (R4). Lengths are shares of the equivalent diameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct FourPoints {
    /// Most spheres; 1 to 1000, default 20.
    #[serde(default = "default_spheres")]
    pub spheres: usize,
    /// Sets of four points that are drawn; 100 to 1000000, default 40000.
    #[serde(default = "default_draws")]
    pub draws: usize,
    /// How far a sphere of the first step may stick out; 0 to 0.2, default 0.02.
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
    /// Least radius; 0.001 to 0.5, default 0.02.
    #[serde(default = "default_smallest")]
    pub smallest: f64,
    /// Most rounds of the second step; 0 (without) to 10000, default 100.
    #[serde(default = "default_rounds")]
    pub rounds: usize,
    /// Surface points; 100 to 20000, default 1500.
    #[serde(default = "default_points")]
    pub points: usize,
}

fn default_spheres() -> usize {
    20
}
fn default_draws() -> usize {
    40_000
}
fn default_tolerance() -> f64 {
    0.02
}
fn default_smallest() -> f64 {
    0.02
}
fn default_rounds() -> usize {
    100
}
fn default_points() -> usize {
    1500
}

impl Default for FourPoints {
    fn default() -> Self {
        Self {
            spheres: default_spheres(),
            draws: default_draws(),
            tolerance: default_tolerance(),
            smallest: default_smallest(),
            rounds: default_rounds(),
            points: default_points(),
        }
    }
}

impl FourPoints {
    /// # Errors
    /// [`Fault`] for a value out of its range.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("spheres", self.spheres as f64, 1.0, 1000.0)?;
        Fault::within("draws", self.draws as f64, 100.0, 1e6)?;
        Fault::within("tolerance", self.tolerance, 0.0, 0.2)?;
        Fault::within("smallest", self.smallest, 1e-3, 0.5)?;
        Fault::within("rounds", self.rounds as f64, 0.0, 10_000.0)?;
        Fault::within("points", self.points as f64, 100.0, 20_000.0)
    }

    pub(super) fn find(
        &self,
        target: &Target,
        stream: &mut Stream,
        job: &Job,
    ) -> Result<Found, ClumpError> {
        let patches = Patches::new(&target.solid.mesh, self.points);
        let kept = self.draw(target, &patches, stream, job)?;
        let drawn = kept.len();
        let mut balls = greedy(&patches, &kept, Vec::new(), self.spheres);
        let rounds = self.adjust(target, &patches, &mut balls, job)?;
        let (balls, dropped) = largest_piece(balls);
        if balls.is_empty() {
            return Err(ClumpError::NoSphere {
                name: target.solid.name.clone(),
                advice: "raise `draws` or `tolerance`, or lower `smallest`",
            });
        }
        let left = match dropped {
            0 => String::new(),
            count => format!("; {count} spheres apart from the largest piece left out"),
        };
        let note = format!(
            "four_points (Price et al. 2007): {} of at most {} spheres, {drawn} of {} sets kept, \
             {rounds} rounds{left}",
            balls.len(),
            self.spheres,
            self.draws
        );
        Ok(Found { balls, note })
    }

    /// Spheres of the first step that may be used.
    fn draw(
        &self,
        target: &Target,
        patches: &Patches,
        stream: &mut Stream,
        job: &Job,
    ) -> Result<Vec<Ball>, ClumpError> {
        let points = &patches.points;
        let last = points.len() as u64 - 1;
        let (smallest, allowed) =
            (self.smallest * target.diameter, self.tolerance * target.diameter);
        let mut kept = Vec::new();
        for draw in 0..self.draws {
            if draw % 512 == 0 && job.is_cancelled() {
                return Err(ClumpError::Cancelled);
            }
            let first = points[whole(stream, 0, last) as usize];
            // Even in the logarithm: large and small neighbourhoods as often.
            let reach = target.diameter * 10f64.powf(uniform(stream, -1.5, 0.1));
            let mut set = [first; 4];
            let mut have = 1;
            for _ in 0..200 {
                let other = points[whole(stream, 0, last) as usize];
                if (other - first).norm_squared() < reach * reach {
                    set[have] = other;
                    have += 1;
                    if have == 4 {
                        break;
                    }
                }
            }
            let Some(ball) = (have == 4).then(|| circumscribed(&set)).flatten() else { continue };
            let small = ball.radius >= smallest && ball.radius < target.diameter;
            if small && ball.radius + target.distance.at(&ball.centre) <= allowed {
                kept.push(ball);
            }
        }
        Ok(kept)
    }

    /// The second step; returns the rounds it took.
    fn adjust(
        &self,
        target: &Target,
        patches: &Patches,
        balls: &mut [Ball],
        job: &Job,
    ) -> Result<usize, ClumpError> {
        let smallest = self.smallest * target.diameter;
        for round in 0..self.rounds {
            if job.is_cancelled() {
                return Err(ClumpError::Cancelled);
            }
            let ties = tie(patches, balls);
            let mut moved: f64 = 0.0;
            for (k, own) in ties.iter().enumerate().filter(|(_, own)| !own.is_empty()) {
                let ball = &mut balls[k];
                let share = 1.0 / own.len() as f64;
                let pull: Vec3 = own
                    .iter()
                    .map(|&i| {
                        let offset = patches.points[i as usize] - ball.centre;
                        let length = offset.norm();
                        offset * ((length - ball.radius) / length.max(f64::MIN_POSITIVE))
                    })
                    .sum();
                ball.centre += pull * share;
                moved = moved.max(pull.norm() * share);
            }
            for (k, own) in tie(patches, balls).iter().enumerate().filter(|(_, o)| !o.is_empty()) {
                let ball = &mut balls[k];
                let sum: f64 =
                    own.iter().map(|&i| (patches.points[i as usize] - ball.centre).norm()).sum();
                ball.radius = (sum / own.len() as f64).max(smallest);
            }
            if moved < 1e-4 * target.diameter {
                return Ok(round + 1);
            }
        }
        Ok(self.rounds)
    }
}

/// For every sphere the surface points that are nearer to it than to any other.
fn tie(patches: &Patches, balls: &[Ball]) -> Vec<Vec<u32>> {
    let mut ties = vec![Vec::new(); balls.len()];
    for (i, point) in patches.points.iter().enumerate() {
        let nearest = balls.iter().enumerate().fold((0, f64::INFINITY), |best, (k, ball)| {
            let gap = (point - ball.centre).norm() - ball.radius;
            if gap < best.1 { (k, gap) } else { best }
        });
        if let Some(tied) = ties.get_mut(nearest.0) {
            tied.push(i as u32);
        }
    }
    ties
}

/// The sphere through four points; `None` where they lie nearly in one plane.
fn circumscribed(set: &[Vec3; 4]) -> Option<Ball> {
    let [a, b, c] = [set[1] - set[0], set[2] - set[0], set[3] - set[0]];
    let edges = Mat3::from_rows(&[a.transpose(), b.transpose(), c.transpose()]);
    let size = a.norm() * b.norm() * c.norm();
    if edges.determinant().abs() <= 1e-6 * size {
        return None;
    }
    let right = Vec3::new(a.norm_squared(), b.norm_squared(), c.norm_squared()) * 0.5;
    let offset = edges.lu().solve(&right)?;
    let radius = offset.norm();
    radius.is_finite().then_some(Ball { centre: set[0] + offset, radius })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clump::reproduce::tests::solid;
    use crate::clump::{Clump, MassSource, Method, reproduce};
    use crate::geometry::samples::random_star;
    use crate::num::random::{direction, stream};

    #[test]
    fn four_points_of_a_sphere_give_it_back() {
        let mut source = stream(51, "four points", 0);
        let (centre, radius) = (Vec3::new(1.0, -2.0, 0.5), 0.3);
        for _ in 0..50 {
            let set = std::array::from_fn(|_| centre + direction(&mut source) * radius);
            let Some(ball) = circumscribed(&set) else { continue };
            assert!((ball.centre - centre).norm() < 1e-8 && (ball.radius - radius).abs() < 1e-8);
        }
        let flat =
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.3)].map(|(x, y)| Vec3::new(x, y, 0.0));
        assert!(circumscribed(&flat).is_none());
    }

    #[test]
    fn the_second_step_lowers_the_error() {
        let star = solid("star", random_star(5, 0.5));
        let rms = |rounds| {
            let method = FourPoints {
                spheres: 12,
                rounds,
                draws: 2000,
                points: 600,
                ..FourPoints::default()
            };
            let clump: Clump = reproduce(
                &star,
                &Method::FourPoints(method),
                MassSource::Solid,
                1,
                0,
                &Job::quiet(),
            )
            .expect("a clump");
            clump.fidelity.expect("measured").rms_distance
        };
        let (without, with) = (rms(0), rms(60));
        assert!(with < without, "{with} {without}");
        assert!(FourPoints { draws: 5, ..FourPoints::default() }.validate().is_err());
    }
}
