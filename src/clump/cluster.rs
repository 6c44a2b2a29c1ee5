//! Clusters (P15): a sphere or disc replaced by two to seven equal ones, one in the middle
//! and the others around it, as the note's ROCKFALL program makes them.
//!
//! The middle one lies at the origin, the others at the distance 2 R t with R the radius of
//! the members and t the tightness (below 1 they overlap, above 1 they are apart), from a
//! random first angle on in equal steps of 2π/(n − 1) or, close-packed, of π/3; or, in three
//! dimensions only, along the axes ±x, ±y, ±z. Members have the volume of the grain together,
//! or each its radius as in the note. Mass and inertia are those of the members, overlaps
//! counted twice. O(n).

use super::Clump;
use crate::geometry::{Ball, MassProperties};
use crate::num::random::{RngExt, Stream};
use crate::num::{Fault, Mat3, MethodEntry, Rotation, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// What `riprap list clumps` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "cluster",
    id: "P15",
    summary: "a sphere or disc becomes two to seven, one in the middle and the others around it",
    source: "Itasca ROCKFALL example, as in the note",
    example: r#"cluster = { count = 7, pattern = "equal_angles", tightness = 1.0 }"#,
};

/// A sphere or disc replaced by two to seven equal ones (P15).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cluster {
    /// Number of members, 2 to 7; default 7.
    #[serde(default = "seven")]
    pub count: u32,
    /// Where the others stand about the middle one; default `equal_angles`.
    #[serde(default)]
    pub pattern: Pattern,
    /// Distance of the others from the middle over the diameter of a member, 0.5 to 2; default 1: touching.
    #[serde(default = "one")]
    pub tightness: f64,
    /// Size of the members; default `same_volume`.
    #[serde(default)]
    pub members: Members,
}

/// Where the others stand about the middle one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Pattern {
    /// In the x–y plane, at equal angles from a random first one.
    #[default]
    EqualAngles,
    /// In the x–y plane, 60 degrees apart from a random first one.
    ClosePacked,
    /// Along x, −x, y, −y, z, −z, in this order; in three dimensions only.
    Axes,
}

/// Size of the members.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Members {
    /// Together they have the volume of the grain.
    #[default]
    SameVolume,
    /// Each has the radius of the grain (the note).
    SameRadius,
}

fn seven() -> u32 {
    7
}

fn one() -> f64 {
    1.0
}

impl Cluster {
    /// # Errors
    /// [`Fault`] for a value out of its range.
    pub fn validate(&self, dimension: u8) -> Result<(), Fault> {
        if !(2..=7).contains(&self.count) {
            return Err(Fault::new("count", format!("is {}", self.count), "2 to 7"));
        }
        if dimension == 2 && self.pattern == Pattern::Axes {
            let allowed = "`equal_angles` or `close_packed` in two dimensions";
            return Err(Fault::new("pattern", "is `axes`", allowed));
        }
        Fault::within("tightness", self.tightness, 0.5, 2.0)
    }

    /// The cluster that replaces a sphere (disc) of `radius` m.
    pub fn make(&self, name: &str, radius: f64, planar: bool, source: &mut Stream) -> Clump {
        let count = f64::from(self.count);
        let member = match (self.members, planar) {
            (Members::SameRadius, _) => radius,
            (Members::SameVolume, true) => radius / count.sqrt(),
            (Members::SameVolume, false) => radius / count.cbrt(),
        };
        let places = self.places(2.0 * member * self.tightness, source.random::<f64>() * TAU);
        let centroid = places.iter().sum::<Vec3>() / count;
        let (one, factor) = match planar {
            true => (PI * member * member, 0.5),
            false => (4.0 / 3.0 * PI * member.powi(3), 0.4),
        };
        let inertia: Mat3 = places
            .iter()
            .map(|place| {
                let arm = place - centroid;
                let own = Mat3::identity() * (factor * member * member);
                (own + Mat3::identity() * arm.norm_squared() - arm * arm.transpose()) * one
            })
            .sum();
        let (inertia, axes) = match planar {
            // Only the moment about z counts in the plane; see `super::disc`.
            true => (Vec3::repeat(inertia[(2, 2)]), Rotation::identity()),
            false => MassProperties { volume: one * count, centroid, inertia }.principal(),
        };
        let ball = |place: &Vec3| Ball {
            centre: axes.inverse_transform_vector(&(place - centroid)),
            radius: member,
        };
        Clump {
            name: name.to_owned(),
            method: format!("cluster of {} (P15), tightness {}", self.count, self.tightness),
            balls: places.iter().map(ball).collect(),
            volume: one * count,
            inertia,
            centroid,
            axes,
            fidelity: None,
        }
    }

    fn places(&self, distance: f64, first: f64) -> Vec<Vec3> {
        let step = match self.pattern {
            Pattern::EqualAngles => TAU / f64::from(self.count - 1),
            _ => PI / 3.0,
        };
        let around = (0..self.count - 1).map(|j| match self.pattern {
            Pattern::Axes => {
                let mut way = Vec3::zeros();
                way[(j / 2) as usize] = if j % 2 == 0 { distance } else { -distance };
                way
            }
            _ => {
                let angle = first + step * f64::from(j);
                Vec3::new(angle.cos(), angle.sin(), 0.0) * distance
            }
        });
        std::iter::once(Vec3::zeros()).chain(around).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::stream;

    fn made(cluster: Cluster, planar: bool) -> Clump {
        cluster.make("c", 1.0, planar, &mut stream(3, "test", 0))
    }

    #[test]
    fn members_touch_the_middle_and_keep_the_volume() {
        for count in 2..=7 {
            for pattern in [Pattern::EqualAngles, Pattern::ClosePacked, Pattern::Axes] {
                for planar in [true, false] {
                    let cluster =
                        Cluster { count, pattern, tightness: 1.0, members: Members::SameVolume };
                    assert_eq!(cluster.validate(2).is_err(), pattern == Pattern::Axes);
                    let clump = made(cluster, planar);
                    assert_eq!(clump.balls.len() as u32, count);
                    let whole = if planar { PI } else { 4.0 / 3.0 * PI };
                    assert!((clump.volume / whole - 1.0).abs() < 1e-12);
                    let (middle, radius) = (clump.balls[0].centre, clump.balls[0].radius);
                    for other in &clump.balls[1..] {
                        assert!(
                            ((other.centre - middle).norm() / (2.0 * radius) - 1.0).abs() < 1e-12
                        );
                    }
                    let centre: Vec3 = clump.balls.iter().map(|b| b.centre).sum();
                    assert!(centre.norm() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn seven_discs_at_equal_angles_are_close_packed_and_the_note_keeps_the_radius() {
        let cluster = Cluster {
            count: 7,
            pattern: Pattern::EqualAngles,
            tightness: 0.9,
            members: Members::SameRadius,
        };
        let clump = made(cluster, true);
        assert_eq!(clump.balls[0].radius, 1.0);
        let way = |a: usize, b: usize| (clump.balls[a].centre - clump.balls[b].centre).norm();
        assert!((way(1, 2) - 1.8).abs() < 1e-12 && (way(6, 1) - 1.8).abs() < 1e-12);
        let inertia = 7.0 * PI * 0.5 + 6.0 * PI * 1.8 * 1.8;
        assert!((clump.inertia.z / inertia - 1.0).abs() < 1e-12);
        assert!(Cluster { count: 8, ..cluster }.validate(2).is_err());
        assert!(Cluster { tightness: 0.1, ..cluster }.validate(2).is_err());
    }
}
