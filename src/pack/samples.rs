//! Grains and rooms that the tests of this room share.

use super::{Grain, Packing};
use crate::clump::Clump;
use crate::geometry::container::{BoxContainer, Container};
use crate::geometry::region::{CylinderRegion, MeshRegion, Rectangle};
use crate::geometry::samples::icosphere;
use crate::geometry::{Ball, Collider, Mesh, Region};
use crate::num::units::Length;
use crate::num::{Rotation, Vec3};
use crate::shape::Solid;
use std::f64::consts::PI;

pub fn sphere(radius: f64, dimension: usize) -> Clump {
    let volume = if dimension == 2 { PI * radius.powi(2) } else { 4.0 / 3.0 * PI * radius.powi(3) };
    clump(vec![Ball { centre: Vec3::zeros(), radius }], volume)
}

/// Two touching-or-apart balls along x, so that volumes add.
pub fn dumbbell(radius: f64, distance: f64) -> Clump {
    let ball = |x| Ball { centre: Vec3::new(x, 0.0, 0.0), radius };
    clump(vec![ball(0.5 * distance), ball(-0.5 * distance)], 8.0 / 3.0 * PI * radius.powi(3))
}

pub fn clump(balls: Vec<Ball>, volume: f64) -> Clump {
    Clump {
        name: "test".to_owned(),
        method: String::new(),
        balls,
        volume,
        inertia: Vec3::repeat(1.0),
        centroid: Vec3::zeros(),
        axes: Rotation::identity(),
        fidelity: None,
    }
}

/// A solid and a one-ball clump about its centroid, principal axes as they come.
pub fn solid(mesh: Mesh) -> (Clump, Solid) {
    let mass = mesh.mass_properties();
    let (inertia, axes) = mass.principal();
    let radius = 0.5 * mass.equivalent_diameter();
    let clump = Clump {
        inertia,
        axes,
        centroid: mass.centroid,
        ..clump(vec![Ball { centre: Vec3::zeros(), radius }], mass.volume)
    };
    (clump, Solid { name: "test".to_owned(), mesh, mass, recipe: String::new() })
}

pub fn of(clumps: &[Clump]) -> Vec<Grain<'_>> {
    clumps.iter().map(|clump| Grain { clump, solid: None, family: 0 }).collect()
}

/// A box from the origin; two numbers for two dimensions.
pub fn room(size: &[f64]) -> Region {
    let dimension = size.len();
    let size = Some(size.iter().map(|&edge| Length(edge)).collect());
    Container::Box(BoxContainer { size, ..BoxContainer::default() })
        .region(dimension, None)
        .expect("a box")
}

/// A closed cylinder of radius 0.5 m and height 1 m on the origin.
pub fn cylinder() -> Region {
    Region::Cylinder(CylinderRegion {
        base: Vec3::zeros(),
        axis: 2,
        radius: 0.5,
        height: 1.0,
        segments: 24,
        open: [false; 2],
    })
}

/// A faceted ball of radius 1 m about the origin.
pub fn ball() -> Region {
    Region::Mesh(Box::new(MeshRegion::new(icosphere(2)).expect("closed")))
}

/// A box from the origin that repeats itself along these axes.
pub fn periodic_room(size: &[f64], periodic: [bool; 3]) -> Region {
    let Region::Box(room) = room(size) else { unreachable!("`room` is a box") };
    Region::Box(Rectangle { periodic, ..room })
}

/// Spheres of all bodies: centre, radius, body.
pub fn spheres(packing: &Packing, grains: &[Grain]) -> Vec<(Vec3, f64, usize)> {
    let mut all = Vec::new();
    for (body, laid) in packing.placements.iter().enumerate() {
        for ball in super::occupied::placed_balls(&grains[laid.grain as usize].clump.balls, laid) {
            all.push((ball.centre, ball.radius, body));
        }
    }
    all
}

/// Pairs of placed solids, all of the same form, that touch or cross each other or an image of each other.
pub fn crossing_solids(packing: &Packing, solid: &Solid, clump: &Clump, region: &Region) -> usize {
    let mesh = solid.mesh.mapped(|v| clump.axes.inverse() * (v - clump.centroid));
    let collider = Collider::new(&mesh, 1.0).expect("triangles");
    let mut found = 0;
    for (i, a) in packing.placements.iter().enumerate() {
        for b in &packing.placements[..i] {
            let way = b.position - a.position;
            let way = region.cell().map_or(way, |cell| cell.way(&way));
            let (at, there) = ((a.position, a.orientation), (a.position + way, b.orientation));
            found += usize::from(collider.nearer_than(&at, &collider, &there, 0.0));
        }
    }
    found
}

/// Every pair and every wall, without any grid: the least gap and the least wall clearance.
pub fn brute_force(packing: &Packing, grains: &[Grain], region: &Region) -> (f64, f64) {
    let all = spheres(packing, grains);
    let (mut gap, mut wall) = (f64::INFINITY, f64::INFINITY);
    for (i, a) in all.iter().enumerate() {
        wall = wall.min(region.clearance(&a.0) - a.1);
        for b in all[..i].iter().filter(|b| b.2 != a.2) {
            let way = region.cell().map_or(a.0 - b.0, |cell| cell.way(&(a.0 - b.0)));
            gap = gap.min(way.norm() - a.1 - b.1);
        }
    }
    (gap, wall)
}
