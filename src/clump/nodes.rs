//! Clustering (R1): equal spheres at all inner nodes of a regular mesh of the solid.
//!
//! Source: Lu & McDowell 2007, Granular Matter 9, 69–82. A cubic grid of spacing
//! h through the centroid of the solid; a sphere of radius r at every node with
//! φ ≤ −r (inscribed: nothing sticks out), φ ≤ 0 (straddling, the source's rule:
//! every inner node; the surface is overshot by up to r) or φ ≤ −r/2 (balanced:
//! between the two, where the volume comes out about right). φ signed distance, negative inside, m.
//! r/h ≥ √3/2 leaves no holes inside.
//!
//! About V/h³ spheres for volume V, error of order h. Measured on eight rock shapes with
//! ratio 0.9 and across 10: volume −32 % inscribed, −5 % balanced, +28 % straddling; root
//! mean square distance 5.4, 2.4 and 4.0 % of the equivalent diameter. Cost: one distance query a
//! node of the bounding box. Spheres that do not hang together with the largest
//! piece are left out, and the method line says how many.

use super::ClumpError;
use super::pieces::largest_piece;
use super::target::{Found, Target};
use crate::geometry::Ball;
use crate::num::{Fault, Job, MethodEntry, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `riprap list clumps` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "nodes",
    id: "R1",
    summary: "equal spheres at all inner nodes of a regular grid (clustering)",
    source: "Lu & McDowell 2007",
    example: r#"clump.nodes = { across = 10 }"#,
};

/// Nodes of the bounding box that are looked at before the work is refused: a minute.
const MOST_NODES: f64 = 2e7;

/// Equal spheres at all inner nodes of a regular grid (R1).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Nodes {
    /// Nodes over one equivalent diameter, so that the spacing is diameter / across; 2 to 100, default 10.
    #[serde(default = "default_across")]
    pub across: f64,
    /// Radius over spacing; 0.55 to 3, default 0.9. Below √3/2 = 0.866 holes stay inside.
    #[serde(default = "default_ratio")]
    pub ratio: f64,
    /// Which nodes get a sphere; default `balanced`.
    #[serde(default)]
    pub place: Place,
}

/// Which nodes get a sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// Nodes whose sphere lies inside the solid.
    Inscribed,
    /// Nodes at least half a radius inside the solid: volume about right.
    #[default]
    Balanced,
    /// All nodes inside the solid.
    Straddling,
}

fn default_across() -> f64 {
    10.0
}

fn default_ratio() -> f64 {
    0.9
}

impl Default for Nodes {
    fn default() -> Self {
        Self { across: default_across(), ratio: default_ratio(), place: Place::default() }
    }
}

impl Nodes {
    /// # Errors
    /// [`Fault`] for a value out of its range.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("across", self.across, 2.0, 100.0)?;
        Fault::within("ratio", self.ratio, 0.55, 3.0)
    }

    pub(super) fn find(&self, target: &Target, job: &Job) -> Result<Found, ClumpError> {
        let spacing = target.diameter / self.across;
        let radius = self.ratio * spacing;
        let limit = match self.place {
            Place::Inscribed => -radius,
            Place::Balanced => -0.5 * radius,
            Place::Straddling => 0.0,
        };
        let origin = target.solid.mass.centroid;
        let bounds = target.solid.mesh.bounds();
        let low = ((bounds.low - origin) / spacing).map(|c| c.ceil() as i64);
        let high = ((bounds.high - origin) / spacing).map(|c| c.floor() as i64);
        let tries: f64 = (high - low).iter().map(|&steps| (steps + 1).max(0) as f64).product();
        if tries > MOST_NODES {
            return Err(Fault::new(
                "nodes.across",
                format!("is {} and makes {tries:.1e} grid nodes around this solid", self.across),
                format!("a value that makes at most {MOST_NODES:.0e} nodes"),
            )
            .into());
        }
        let mut balls = Vec::new();
        for i in low.x..=high.x {
            if job.is_cancelled() {
                return Err(ClumpError::Cancelled);
            }
            for j in low.y..=high.y {
                for k in low.z..=high.z {
                    let node = origin + Vec3::new(i as f64, j as f64, k as f64) * spacing;
                    if target.distance.at(&node) <= limit {
                        balls.push(Ball { centre: node, radius });
                    }
                }
            }
        }
        let (balls, dropped) = largest_piece(balls);
        if balls.is_empty() {
            return Err(ClumpError::NoSphere {
                name: target.solid.name.clone(),
                advice: "raise `across` or lower `ratio`, or use `place = \"straddling\"`",
            });
        }
        Ok(Found { note: self.note(balls.len(), dropped), balls })
    }

    fn note(&self, kept: usize, dropped: usize) -> String {
        let place = match self.place {
            Place::Inscribed => "inscribed",
            Place::Balanced => "balanced",
            Place::Straddling => "straddling",
        };
        let left = match dropped {
            0 => String::new(),
            count => format!("; {count} spheres apart from the largest piece left out"),
        };
        format!(
            "nodes (Lu & McDowell 2007): {kept} spheres, across {}, ratio {}, {place}{left}",
            self.across, self.ratio
        )
    }
}
