//! A container in three dimensions with holes: what is inside one region and outside closed surfaces.
//!
//! Clearance: the least of that of the region and the signed distances to the holes. Volume: that of the
//! union with all holes less that of the holes, so holes may reach through the walls.

use super::region::Region;
use super::surface::Surface;
use super::{Collider, Mesh, SignedDistance, union};
use crate::num::{Fault, Rotation, Vec3};
use std::fmt;

/// A region without the inside of closed surfaces.
pub struct HollowRegion {
    outside: Region,
    holes: Vec<Hole>,
    volume: f64,
}

struct Hole {
    mesh: Mesh,
    distance: SignedDistance,
}

impl fmt::Debug for HollowRegion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "HollowRegion({:?}, {} holes)", self.outside, self.holes.len())
    }
}

impl HollowRegion {
    /// `outside` without the insides of `holes` (closed, outward-oriented, m).
    ///
    /// Errors: a hole that is no closed surface, lies outside, or touches another.
    pub fn new(outside: Region, holes: Vec<Mesh>) -> Result<Self, Fault> {
        let unit = outside.bounds().diagonal();
        let still = (Vec3::zeros(), Rotation::identity());
        let key = |index: usize| format!("holes[{index}]");
        let mut ready: Vec<Hole> = Vec::with_capacity(holes.len());
        let mut colliders: Vec<Collider> = Vec::with_capacity(holes.len());
        for (index, mesh) in holes.into_iter().enumerate() {
            let distance = SignedDistance::new(&mesh).map_err(|error| {
                Fault::new(key(index), error.to_string(), "a closed surface with volume")
            })?;
            let Some(collider) = Collider::new(&mesh, unit) else {
                return Err(Fault::new(key(index), "has no triangles", "a closed surface"));
            };
            if colliders.iter().any(|other| other.nearer_than(&still, &collider, &still, 0.0)) {
                return Err(Fault::new(
                    key(index),
                    "touches another hole",
                    "holes apart from each other",
                ));
            }
            colliders.push(collider);
            ready.push(Hole { mesh, distance });
        }
        let surface = outside.surface();
        let mut all = vec![surface];
        all.extend(ready.iter().map(|hole| hole.mesh.clone()));
        let united = union::unite(&all).map_err(|error| {
            let allowed = "holes that lie inside the container or reach into it";
            Fault::new("holes", format!("cannot be cut out: {error}"), allowed)
        })?;
        let cut: f64 = ready.iter().map(|hole| hole.mesh.mass_properties().volume).sum();
        let volume = united.mass_properties().volume - cut;
        if volume <= 1e-9 * outside.volume() {
            return Err(Fault::new("holes", "leave nothing of the container", "smaller holes"));
        }
        Ok(Self { outside, holes: ready, volume })
    }

    /// The region that the holes are cut out of.
    pub fn outside(&self) -> &Region {
        &self.outside
    }

    /// Volume, m³.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Distance to the nearest hole, m; negative inside one.
    pub fn from_holes(&self, point: &Vec3) -> f64 {
        self.holes.iter().map(|hole| hole.distance.at(point)).fold(f64::INFINITY, f64::min)
    }

    /// The holes made ready for queries; `unit` as for [`Collider::new`].
    pub fn colliders(&self, unit: f64) -> Vec<Collider> {
        self.holes.iter().filter_map(|hole| Collider::new(&hole.mesh, unit)).collect()
    }

    /// Walls of the outside and of each hole, which face away from the inside of the container.
    pub fn walls(&self) -> Vec<(String, Surface)> {
        let mut walls = self.outside.walls();
        for (index, hole) in self.holes.iter().enumerate() {
            let mut mesh = hole.mesh.clone();
            mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
            walls.push((format!("hole_{}", index + 1), Surface::Mesh(mesh)));
        }
        walls
    }
}
