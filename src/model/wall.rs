//! Walls: planes and triangle meshes, still or in rigid motion.

use crate::geometry::Mesh;
use crate::num::{Rotation, Vec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A wall of infinite mass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Name for messages and decks: letters, digits and `_` only, unique.
    pub name: String,
    /// Surface at time 0.
    pub shape: WallShape,
    /// How it moves.
    pub motion: Motion,
    /// Index into `Model::materials`.
    pub material: u16,
}

impl Wall {
    /// True for a plane whose motion keeps it in its place: sliding along itself or
    /// turning about its own normal.
    pub fn stays_in_plane(&self) -> bool {
        let WallShape::Plane { normal, .. } = &self.shape else { return false };
        match &self.motion {
            Motion::Still => true,
            Motion::Translate { velocity } => normal.dot(velocity) == 0.0,
            Motion::Oscillate { .. } | Motion::Servo { .. } => false,
            Motion::Rotate { axis, .. } => axis.cross(normal).norm() == 0.0,
        }
    }

    /// True for a plane along an axis that is at rest or slides along one axis of its own: what
    /// LIGGGHTS and LAMMPS have as a primitive wall.
    pub fn is_primitive(&self) -> bool {
        let Some((axis, _, _)) = self.shape.axis_plane() else { return false };
        match self.motion {
            Motion::Still => true,
            Motion::Translate { velocity } => {
                let moving: Vec<usize> = (0..3).filter(|a| velocity[*a] != 0.0).collect();
                moving.is_empty() || (moving.len() == 1 && moving[0] != axis)
            }
            Motion::Rotate { rate, .. } => rate == 0.0,
            Motion::Oscillate { .. } | Motion::Servo { .. } => false,
        }
    }

    /// True if the solver of `scheme` gives this wall its velocity only after the set-up force
    /// pass: LIGGGHTS where `fix move/mesh` moves it, LAMMPS where a region moves.
    pub fn rests_at_set_up(&self, scheme: super::Scheme) -> bool {
        match scheme {
            super::Scheme::Liggghts => self.motion.moves() && !self.stays_in_plane(),
            super::Scheme::Lammps => self.motion.moves() && !self.is_primitive(),
            _ => false,
        }
    }
}

/// Surface of a wall. Both sides of either kind act on spheres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum WallShape {
    /// An infinite plane.
    Plane {
        /// A point on the plane, m.
        point: Vec3,
        /// Unit normal, towards the bodies.
        normal: Vec3,
    },
    /// A triangle mesh, vertices shared between neighbours (welded).
    Mesh {
        /// Vertices in m at time 0.
        #[serde(with = "mesh_serde")]
        mesh: Mesh,
    },
}

impl WallShape {
    /// The axis (0, 1, 2), coordinate and side (+1 or −1: where the bodies are)
    /// of a plane that is exactly axis-aligned.
    pub fn axis_plane(&self) -> Option<(usize, f64, f64)> {
        let Self::Plane { point, normal } = self else { return None };
        let axis = normal.iamax();
        let aligned = (0..3).all(|other| other == axis || normal[other] == 0.0);
        aligned.then(|| (axis, point[axis], normal[axis].signum()))
    }
}

/// Rigid motion of a wall from time 0 on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Motion {
    /// At rest.
    Still,
    /// Constant velocity, m/s.
    Translate {
        /// Velocity, m/s.
        velocity: Vec3,
    },
    /// Constant rotation about a fixed axis, right-handed.
    Rotate {
        /// A point on the axis, m.
        origin: Vec3,
        /// Unit vector along the axis.
        axis: Vec3,
        /// Angular speed, rad/s.
        rate: f64,
    },
    /// Back and forth: x(t) = x(0) + A (sin(2π f t + φ) − sin φ).
    Oscillate {
        /// Amplitude A, m.
        amplitude: Vec3,
        /// Frequency f, Hz.
        frequency: f64,
        /// Phase φ at time 0, rad.
        phase: f64,
    },
    /// Moves along a direction so that it pushes the bodies that way with a force; where it is
    /// follows from the run.
    Servo {
        /// Unit vector along which it moves and pushes.
        direction: Vec3,
        /// Force on the bodies that it seeks, N.
        force: f64,
        /// Largest speed, m/s.
        speed: f64,
    },
}

impl Motion {
    /// Where the wall point that was at `point` at time 0 is at `time`, s; of a servo wall where it was.
    pub fn place(&self, point: &Vec3, time: f64) -> Vec3 {
        self.at(time)(point)
    }

    /// [`Motion::place`] for many points at one time, s.
    pub fn at(&self, time: f64) -> impl Fn(&Vec3) -> Vec3 + use<> {
        let (mut centre, mut turn, mut shift) =
            (Vec3::zeros(), Rotation::identity(), Vec3::zeros());
        let turns = matches!(self, Self::Rotate { .. });
        match self {
            Self::Still | Self::Servo { .. } => {}
            Self::Oscillate { amplitude, frequency, phase } => {
                let angle = TAU * frequency * time + phase;
                shift = amplitude * (angle.sin() - phase.sin());
            }
            Self::Translate { velocity } => shift = velocity * time,
            Self::Rotate { origin, axis, rate } => {
                (centre, turn) = (*origin, Rotation::from_scaled_axis(axis * (rate * time)));
            }
        }
        move |point| {
            if turns { centre + turn * (point - centre) } else { point + shift }
        }
    }

    /// Velocity of the wall material at the place `here` at `time`, m/s; of a servo wall its largest.
    pub fn velocity_at(&self, here: &Vec3, time: f64) -> Vec3 {
        match self {
            Self::Oscillate { amplitude, frequency, phase } => {
                amplitude * (TAU * frequency * (TAU * frequency * time + phase).cos())
            }
            _ => self.velocity(here),
        }
    }

    /// Velocity of the wall material at the place `here`, m/s; the largest there is where it
    /// changes with time.
    pub fn velocity(&self, here: &Vec3) -> Vec3 {
        match self {
            Self::Oscillate { amplitude, frequency, .. } => amplitude * (TAU * frequency),
            Self::Servo { direction, speed, .. } => direction * *speed,
            Self::Still => Vec3::zeros(),
            Self::Translate { velocity } => *velocity,
            Self::Rotate { origin, axis, rate } => axis.cross(&(here - origin)) * *rate,
        }
    }

    /// True unless the wall is at rest.
    pub fn moves(&self) -> bool {
        !matches!(self, Self::Still)
    }
}

mod mesh_serde {
    use super::{Mesh, Vec3};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(mesh: &Mesh, serializer: S) -> Result<S::Ok, S::Error> {
        (&mesh.vertices, &mesh.triangles).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Mesh, D::Error> {
        let (vertices, triangles) = <(Vec<Vec3>, Vec<[u32; 3]>)>::deserialize(deserializer)?;
        Ok(Mesh { vertices, triangles })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn place_and_velocity_agree() {
        let motions = [
            Motion::Still,
            Motion::Translate { velocity: Vec3::new(1.0, -2.0, 0.5) },
            Motion::Rotate { origin: Vec3::new(0.1, 0.0, 0.3), axis: Vec3::y(), rate: 3.0 },
            Motion::Oscillate { amplitude: Vec3::new(0.1, 0.0, -0.2), frequency: 1.5, phase: 0.4 },
        ];
        let start = Vec3::new(0.4, 0.2, -0.1);
        for motion in motions {
            let (here, h) = (motion.place(&start, 0.7), 1e-6);
            let slope = (motion.place(&start, 0.7 + h) - motion.place(&start, 0.7 - h)) / (2.0 * h);
            assert!((slope - motion.velocity_at(&here, 0.7)).norm() < 1e-8, "{motion:?}");
            assert!((motion.place(&start, 0.0) - start).norm() < 1e-15);
            assert!(slope.norm() < motion.velocity(&here).norm() + 1e-8);
        }
    }
}
