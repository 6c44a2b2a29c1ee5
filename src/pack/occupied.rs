//! What is already in the container, and whether one more grain fits.
//!
//! Clumps: every ball against the balls of other bodies through a cell grid,
//! O(balls of the grain). Solids: bounding spheres through the grid, then
//! surface against surface.

use super::{Grain, Placement};
use crate::geometry::collide::Place;
use crate::geometry::region::SolidRoom;
use crate::geometry::{Ball, BallGrid, Bounds, Cell, Collider, Region};
use crate::num::{Rotation, Vec3};
use std::collections::BTreeMap;
use std::rc::Rc;

/// The spheres of a grain in world places.
pub fn world_balls<'a>(balls: &'a [Ball], at: &'a Place) -> impl Iterator<Item = Ball> + 'a {
    balls.iter().map(|ball| Ball { centre: at.0 + at.1 * ball.centre, radius: ball.radius })
}

/// The spheres of a placed grain, its scale included.
pub fn placed_balls<'a>(balls: &'a [Ball], laid: &'a Placement) -> impl Iterator<Item = Ball> + 'a {
    balls.iter().map(|ball| Ball {
        centre: laid.position + laid.orientation * (ball.centre * laid.scale),
        radius: ball.radius * laid.scale,
    })
}

/// Radius of the sphere about the centre of mass that holds the whole clump, m.
pub fn clump_radius(grain: &Grain) -> f64 {
    grain.clump.balls.iter().map(|ball| ball.centre.norm() + ball.radius).fold(0.0, f64::max)
}

/// The true shape of a grain, or its spheres where it has no other.
enum Body {
    Balls,
    Solid(Rc<Collider>),
}

/// Grains that were placed, ready for the question whether another one fits.
pub struct Occupied<'a> {
    grains: &'a [Grain<'a>],
    region: &'a Region,
    gap: f64,
    /// Of each grain; empty when clumps are tested.
    bodies: Vec<Body>,
    room: Option<SolidRoom<'a>>,
    /// Length that all colliders are made with, m.
    unit: f64,
    /// Largest distance of any point of each grain from its centre of mass.
    radii: Vec<f64>,
    /// Size of each grain over the wanted one.
    scales: Vec<f64>,
    /// Balls of all bodies, or one bounding sphere a body when solids are tested.
    grid: BallGrid,
    /// Grain and place behind each bounding sphere.
    placed: Vec<(usize, Place)>,
    /// How space repeats itself.
    cell: Option<Cell>,
}

impl<'a> Occupied<'a> {
    /// Nothing yet; clumps are tested against clumps.
    pub fn of_clumps(grains: &'a [Grain<'a>], region: &'a Region, gap: f64) -> Self {
        let radii = grains.iter().map(clump_radius).collect();
        let balls = grains.iter().flat_map(|grain| &grain.clump.balls);
        let smallest = balls.map(|ball| ball.radius).fold(f64::INFINITY, f64::min);
        let grid = BallGrid::new(smallest);
        Self {
            grains,
            region,
            gap,
            bodies: Vec::new(),
            room: None,
            unit: 1.0,
            radii,
            scales: vec![1.0; grains.len()],
            grid,
            placed: Vec::new(),
            cell: region.cell(),
        }
    }

    /// Nothing yet; true shapes are tested against true shapes.
    pub fn of_solids(grains: &'a [Grain<'a>], region: &'a Region, gap: f64) -> Self {
        let unit = grains.iter().map(clump_radius).fold(0.0, f64::max);
        // One collider for all grains that share clump and solid; the map is only looked up.
        let mut known: BTreeMap<(usize, usize), Rc<Collider>> = BTreeMap::new();
        let bodies: Vec<Body> = grains
            .iter()
            .map(|grain| {
                let Some(solid) = grain.solid else { return Body::Balls };
                let clump = grain.clump;
                let key = (std::ptr::from_ref(clump).addr(), std::ptr::from_ref(solid).addr());
                if let Some(collider) = known.get(&key) {
                    return Body::Solid(Rc::clone(collider));
                }
                let in_body = |v: &Vec3| clump.axes.inverse() * (v - clump.centroid);
                match Collider::new(&solid.mesh.mapped(in_body), unit) {
                    Some(collider) => {
                        let collider = Rc::new(collider);
                        known.insert(key, Rc::clone(&collider));
                        Body::Solid(collider)
                    }
                    None => Body::Balls,
                }
            })
            .collect();
        let radii: Vec<f64> = grains
            .iter()
            .zip(&bodies)
            .map(|(grain, body)| match body {
                Body::Balls => clump_radius(grain),
                Body::Solid(collider) => collider.radius(),
            })
            .collect();
        let grid = BallGrid::new(radii.iter().copied().fold(f64::INFINITY, f64::min));
        let room = Some(region.for_solids(unit));
        let scales = vec![1.0; grains.len()];
        let (cell, placed) = (region.cell(), Vec::new());
        Self { grains, region, gap, bodies, room, unit, radii, scales, grid, placed, cell }
    }

    /// Makes `grain`, which was not placed yet, `scale` times as large as it is wanted.
    pub fn resize(&mut self, grain: usize, scale: f64) {
        self.radii[grain] *= scale / self.scales[grain];
        self.scales[grain] = scale;
        let what = &self.grains[grain];
        if let (Some(Body::Solid(_)), Some(solid)) = (self.bodies.get(grain), what.solid) {
            let clump = what.clump;
            let in_body = |v: &Vec3| clump.axes.inverse() * (v - clump.centroid) * scale;
            if let Some(collider) = Collider::new(&solid.mesh.mapped(in_body), self.unit) {
                self.bodies[grain] = Body::Solid(Rc::new(collider));
            }
        }
    }

    /// The radius of a grain at its present size, m.
    pub fn radius(&self, grain: usize) -> f64 {
        self.radii[grain]
    }

    fn balls<'b>(&'b self, grain: usize, at: &'b Place) -> impl Iterator<Item = Ball> + 'b {
        let scale = self.scales[grain];
        self.grains[grain].clump.balls.iter().map(move |ball| Ball {
            centre: at.0 + at.1 * (ball.centre * scale),
            radius: ball.radius * scale,
        })
    }

    /// Bounds of `grain`, turned, about its centre of mass.
    pub fn extent(&self, grain: usize, turn: &Rotation) -> Bounds {
        match self.bodies.get(grain) {
            Some(Body::Solid(collider)) => {
                collider.vertices().iter().fold(Bounds::EMPTY, |b, v| b.with(&(turn * v)))
            }
            _ => self.balls(grain, &(Vec3::zeros(), *turn)).fold(Bounds::EMPTY, |bounds, ball| {
                let reach = Vec3::repeat(ball.radius);
                bounds.with(&(ball.centre - reach)).with(&(ball.centre + reach))
            }),
        }
    }

    /// True if `grain` overlaps neither boundary nor bodies there and keeps the gap from all.
    pub fn fits(&self, grain: usize, at: &Place) -> bool {
        self.inside(grain, at) && self.free(grain, at)
    }

    fn inside(&self, grain: usize, at: &Place) -> bool {
        if self.region.clearance(&at.0) >= self.radii[grain] + self.gap {
            return true;
        }
        match (self.bodies.get(grain), &self.room) {
            (Some(Body::Solid(collider)), Some(room)) => room.holds(collider, at, self.gap),
            _ => self
                .balls(grain, at)
                .all(|ball| self.region.clearance(&ball.centre) >= ball.radius + self.gap),
        }
    }

    fn free(&self, grain: usize, at: &Place) -> bool {
        if self.bodies.is_empty() {
            return self
                .balls(grain, at)
                .all(|ball| !self.grid.any_near(&ball.centre, ball.radius + self.gap));
        }
        // The skin that the solid test keeps is far below this widening.
        let reach = self.radii[grain] * (1.0 + 1e-5) + self.gap;
        self.grid.near(&at.0, reach, |number, _| {
            let (other, other_at) = &self.placed[number as usize];
            !self.close(grain, at, *other, other_at)
        })
    }

    fn close(&self, grain: usize, at: &Place, other: usize, other_at: &Place) -> bool {
        match (&self.bodies[grain], &self.bodies[other]) {
            (Body::Solid(a), Body::Solid(b)) => a.nearer_than(at, b, other_at, self.gap),
            (Body::Solid(a), Body::Balls) => self
                .balls(other, other_at)
                .any(|ball| a.ball_nearer_than(at, &ball.centre, ball.radius, self.gap)),
            (Body::Balls, Body::Solid(b)) => self
                .balls(grain, at)
                .any(|ball| b.ball_nearer_than(other_at, &ball.centre, ball.radius, self.gap)),
            (Body::Balls, Body::Balls) => self.balls(grain, at).any(|a| {
                self.balls(other, other_at)
                    .any(|b| (a.centre - b.centre).norm() < a.radius + b.radius + self.gap)
            }),
        }
    }

    /// Puts `grain` there, and its images where they can be met.
    pub fn add(&mut self, grain: usize, at: Place) {
        self.add_one(grain, at);
        let Some(cell) = self.cell else { return };
        let largest = self.radii.iter().copied().fold(0.0, f64::max);
        let reach = self.radii[grain] + largest + self.gap;
        let mut images = Vec::new();
        cell.images(&at.0, reach, |way| images.push((at.0 + way, at.1)));
        images.into_iter().for_each(|image| self.add_one(grain, image));
    }

    fn add_one(&mut self, grain: usize, at: Place) {
        if self.bodies.is_empty() {
            let balls: Vec<Ball> = self.balls(grain, &at).collect();
            for ball in balls {
                self.grid.insert(ball.centre, ball.radius);
            }
        } else {
            self.grid.insert(at.0, self.radii[grain]);
            self.placed.push((grain, at));
        }
    }
}

/// A placement at rest but for `velocity`.
pub fn placement(grain: usize, (position, orientation): Place, velocity: Vec3) -> Placement {
    Placement {
        grain: grain as u32,
        position,
        orientation,
        velocity,
        spin: Vec3::zeros(),
        scale: 1.0,
    }
}
