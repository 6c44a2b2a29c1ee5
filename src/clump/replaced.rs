//! Small spheres, groups of which are replaced by larger ones (R2).
//!
//! Source: Wang, Park & Fu 2007, Construction and Building Materials 21, 338–346 (X-ray
//! images filled with small balls, which larger ones burn away). 1. Equal spheres of radius r
//! at all nodes of a cubic grid of spacing h that keep them inside. 2. Candidates are the nodes,
//! each with the largest sphere around it that stays inside; in order of falling radius a
//! candidate replaces all small spheres that still stand and lie in it to the tolerance τ·r,
//! if they are at least `least`. Ends when no candidate is left.
//!
//! Same surface as the small spheres alone to the tolerance, with far fewer spheres; r sets
//! the sharpness. Where `across` is left out, the finest grid is taken that needs at most
//! `spheres` spheres (steps of 4 % in the spacing, up from the coarsest).
//! Cost O(nodes · (log triangles + small spheres within a candidate)).

use super::ClumpError;
use super::pieces::largest_piece;
use super::target::{Found, Target};
use crate::geometry::Ball;
use crate::num::{Fault, Job, MethodEntry, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `riprap list clumps` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "replaced",
    id: "R2",
    summary: "small spheres on a grid, groups of which are replaced by larger ones",
    source: "Wang et al. 2007",
    example: r#"clump.replaced = { across = 16 }"#,
};

/// Nodes of the bounding box before the work is refused: some minutes.
const MOST_NODES: f64 = 3e6;

/// Small spheres, groups of which are replaced by larger ones (R2).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Replaced {
    /// Nodes over one equivalent diameter; 3 to 100. Left out: as many as `spheres` allow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub across: Option<f64>,
    /// Most spheres where `across` is left out; 4 to 5000, default 100.
    #[serde(default = "default_spheres")]
    pub spheres: usize,
    /// Radius over spacing of the small spheres; 0.5 to 2, default 0.9.
    #[serde(default = "default_ratio")]
    pub ratio: f64,
    /// τ: how far, in radii of the small spheres, they may stand out of what replaces them; 0 to 2, default 0.5.
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
    /// Fewest small spheres that one larger one must replace; 2 to 1000, default 2.
    #[serde(default = "default_least")]
    pub least: usize,
}

fn default_spheres() -> usize {
    100
}
fn default_ratio() -> f64 {
    0.9
}
fn default_tolerance() -> f64 {
    0.5
}
fn default_least() -> usize {
    2
}

impl Default for Replaced {
    fn default() -> Self {
        Self {
            across: None,
            spheres: default_spheres(),
            ratio: default_ratio(),
            tolerance: default_tolerance(),
            least: default_least(),
        }
    }
}

impl Replaced {
    /// # Errors
    /// [`Fault`] for a value out of its range.
    pub fn validate(&self) -> Result<(), Fault> {
        if let Some(across) = self.across {
            Fault::within("across", across, 3.0, 100.0)?;
        }
        Fault::within("spheres", self.spheres as f64, 4.0, 5000.0)?;
        Fault::within("ratio", self.ratio, 0.5, 2.0)?;
        Fault::within("tolerance", self.tolerance, 0.0, 2.0)?;
        Fault::within("least", self.least as f64, 2.0, 1000.0)
    }

    pub(super) fn find(&self, target: &Target, job: &Job) -> Result<Found, ClumpError> {
        let (across, small, balls) = match self.across {
            Some(across) => {
                let (small, balls) = self.fill(target, across, job)?;
                (across, small, balls)
            }
            None => self.finest(target, job)?,
        };
        let (balls, dropped) = largest_piece(balls);
        if balls.is_empty() {
            return Err(ClumpError::NoSphere {
                name: target.solid.name.clone(),
                advice: "raise `across` or `spheres`, or lower `ratio`",
            });
        }
        let left = match dropped {
            0 => String::new(),
            count => format!("; {count} spheres apart from the largest piece left out"),
        };
        let note = format!(
            "replaced (Wang et al. 2007): {} spheres for {small} small ones, across {across:.2}, \
             tolerance {}{left}",
            balls.len(),
            self.tolerance
        );
        Ok(Found { balls, note })
    }

    /// The finest of the grids before the first one that needs too many spheres.
    fn finest(&self, target: &Target, job: &Job) -> Result<(f64, usize, Vec<Ball>), ClumpError> {
        let mut across = 3.0;
        let mut best = (across, 0, Vec::new());
        // A coarse grid in an unlucky place may need more than a finer one: three misses end it.
        let mut misses = 0;
        while misses < 3 && across < 60.0 {
            let (small, balls) = self.fill(target, across, job)?;
            if balls.len() > self.spheres {
                misses += 1;
            } else if !balls.is_empty() {
                best = (across, small, balls);
                misses = 0;
            }
            across *= 1.04;
        }
        Ok(best)
    }

    /// Number of small spheres, and what stands in their place.
    fn fill(
        &self,
        target: &Target,
        across: f64,
        job: &Job,
    ) -> Result<(usize, Vec<Ball>), ClumpError> {
        let spacing = target.diameter / across;
        let radius = self.ratio * spacing;
        let mut nodes = self.nodes(target, across, spacing, radius, job)?;
        let small = nodes.len();
        nodes.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut stands = vec![true; nodes.len()];
        let mut balls = Vec::new();
        for (centre, depth) in &nodes {
            let reach = depth - radius + self.tolerance * radius;
            if reach < spacing {
                break;
            }
            let inside: Vec<usize> = (0..nodes.len())
                .filter(|&j| stands[j] && (nodes[j].0 - centre).norm_squared() <= reach * reach)
                .collect();
            if inside.len() >= self.least {
                inside.iter().for_each(|&j| stands[j] = false);
                balls.push(Ball { centre: *centre, radius: *depth });
            }
        }
        let rest = nodes.iter().zip(&stands).filter(|(_, stands)| **stands);
        balls.extend(rest.map(|((centre, _), _)| Ball { centre: *centre, radius }));
        Ok((small, balls))
    }

    /// Nodes whose small sphere lies inside, each with its distance from the surface.
    fn nodes(
        &self,
        target: &Target,
        across: f64,
        spacing: f64,
        radius: f64,
        job: &Job,
    ) -> Result<Vec<(Vec3, f64)>, ClumpError> {
        let origin = target.solid.mass.centroid;
        let bounds = target.solid.mesh.bounds();
        let low = ((bounds.low - origin) / spacing).map(|c| c.ceil() as i64);
        let high = ((bounds.high - origin) / spacing).map(|c| c.floor() as i64);
        let tries: f64 = (high - low).iter().map(|&steps| (steps + 1).max(0) as f64).product();
        if tries > MOST_NODES {
            return Err(Fault::new(
                "replaced.across",
                format!("is {across} and makes {tries:.1e} grid nodes around this solid"),
                format!("a value that makes at most {MOST_NODES:.0e} nodes"),
            )
            .into());
        }
        let mut nodes = Vec::new();
        for i in low.x..=high.x {
            if job.is_cancelled() {
                return Err(ClumpError::Cancelled);
            }
            for j in low.y..=high.y {
                for k in low.z..=high.z {
                    let node = origin + Vec3::new(i as f64, j as f64, k as f64) * spacing;
                    let depth = -target.distance.at(&node);
                    if depth >= radius {
                        nodes.push((node, depth));
                    }
                }
            }
        }
        Ok(nodes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clump::reproduce::tests::solid;
    use crate::clump::{Clump, MassSource, Method, Nodes, Place, reproduce};
    use crate::geometry::samples::{l_mesh, random_star};

    fn make(mesh: crate::geometry::Mesh, method: Method) -> Clump {
        reproduce(&solid("x", mesh), &method, MassSource::Solid, 1, 0, &Job::quiet())
            .expect("a clump")
    }

    #[test]
    fn far_fewer_spheres_than_the_grid_for_the_same_error() {
        for mesh in [l_mesh(), random_star(7, 0.4)] {
            let nodes = Nodes { across: 9.0, place: Place::Inscribed, ..Nodes::default() };
            let grid = make(mesh.clone(), Method::Nodes(nodes));
            let method = Replaced { across: Some(9.0), ..Replaced::default() };
            let fewer = make(mesh, Method::Replaced(method));
            assert!(2 * fewer.balls.len() < grid.balls.len(), "{}", fewer.method);
            let [a, b] = [&fewer, &grid].map(|c| c.fidelity.expect("measured").rms_distance);
            assert!(a < 1.1 * b, "{a} {b}");
        }
    }

    #[test]
    fn the_count_is_kept_and_all_lies_inside() {
        let mesh = random_star(7, 0.4);
        let method = Replaced { spheres: 40, ..Replaced::default() };
        let clump = make(mesh.clone(), Method::Replaced(method));
        assert!((10..=40).contains(&clump.balls.len()), "{}", clump.method);
        let distance = crate::geometry::SignedDistance::new(&mesh).expect("closed");
        for ball in clump.in_solid_frame() {
            assert!(ball.radius + distance.at(&ball.centre) < 1e-9);
        }
        assert!(Replaced { least: 1, ..Replaced::default() }.validate().is_err());
    }
}
