//! What does not change during a run, laid out for the kernels.

use super::bond;
use super::extra::{self, Fixed};
use super::law::Kept;
use super::servo::{Servo, WallNow};
use super::state::is_alone;
use super::surface::Surfaces;
use crate::model::{
    Body, Contact, Dimension, History, Law, Model, Motion, Needs, Scheme, WallShape,
};
use crate::num::{Rotation, Vec3};

/// Fixed data of a run.
pub struct Setting<'a> {
    /// The model.
    pub model: &'a Model,
    /// What the scene needs.
    pub needs: Needs,
    /// Scheme.
    pub scheme: Scheme,
    /// Whether products of contacts between spheres and walls, and of the motion of spheres, are added without rounding
    /// them first: faster. Not in schemes that follow a solver to rounding, since solvers are not compiled so.
    pub fused: bool,
    /// Law variant.
    pub law: Law,
    /// Part of the overlap that is taken from the radius to give the lever arm between spheres.
    pub share: f64,
    /// The same for the sliding velocity between spheres.
    pub slide_share: f64,
    /// The same at walls, but at axis-aligned planes.
    pub wall_share: f64,
    /// Two dimensions.
    pub planar: bool,
    /// Acceleration of gravity, within the plane in two dimensions, m/s².
    pub gravity: Vec3,
    /// Time step, s.
    pub step: f64,
    /// Median radius of the spheres, m.
    pub median_radius: f64,
    /// Arrays that contacts keep.
    pub kept: Kept,
    /// Edges of a periodic box, infinite along other axes, m.
    pub edges: Vec3,
    /// Mesh walls.
    pub surfaces: Surfaces,
    /// Where the walls are now; set before each pass.
    pub walls: Vec<WallNow>,
    /// Indices of plane walls in `model.walls`.
    pub planes: Vec<u16>,
    /// Bonds between bodies.
    pub bonds: bond::Table,
    /// Fixed values of forces besides the linear contact.
    pub extra: Fixed,
    /// Parameters between spheres and their radius, if all are alike.
    pub alike: Option<(Contact, f64)>,
    /// Whether all bodies are single spheres (see [`is_alone`]) of the same mass and inertia.
    pub equal_bodies: bool,
    table: Vec<Contact>,
    stiff: Vec<Contact>,
    materials: usize,
}

/// A plane wall at one time.
#[derive(Debug, Clone, Copy)]
pub struct PlaneNow {
    /// A point on it, m.
    pub point: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Motion of its material.
    pub motion: Motion,
    /// Index into the materials.
    pub material: u16,
    /// Part of the overlap that is taken from the radius to give the lever arm.
    pub share: f64,
}

impl<'a> Setting<'a> {
    /// Reads a model.
    pub fn new(model: &'a Model) -> Self {
        let needs = model.needs();
        let plan = &model.plan;
        let materials = model.contacts.size();
        let size = materials as u16;
        let table = (0..size)
            .flat_map(|a| (0..size).map(move |b| (a, b)))
            .map(|(a, b)| *model.contacts.between(a, b))
            .collect();
        let planes = (0..model.walls.len() as u16)
            .filter(|w| matches!(model.walls[*w as usize].shape, WallShape::Plane { .. }))
            .collect();
        let mut setting = Self {
            model,
            needs,
            scheme: plan.scheme,
            fused: plan.scheme == Scheme::Leapfrog,
            law: plan.law,
            share: plan.law.arm.share(),
            slide_share: plan.law.arm.slide_share(),
            wall_share: plan.law.arm.wall_share(),
            planar: model.dimension == Dimension::Two,
            gravity: match model.dimension {
                Dimension::Two => Vec3::new(model.gravity.x, model.gravity.y, 0.0),
                Dimension::Three => model.gravity,
            },
            step: plan.step,
            median_radius: median_radius(model),
            kept: Kept {
                friction: needs.friction,
                damping: needs.normal_damping || needs.tangential_damping,
                normals: plan.law.history == History::Rotated,
                pulls: plan.scheme == Scheme::PathAveraged && needs.tangential_damping,
                ledger: needs.ledger,
            },
            edges: model.periodic.map_or(Vec3::repeat(f64::INFINITY), |cell| cell.lengths()),
            surfaces: Surfaces::new(model),
            walls: model
                .walls
                .iter()
                .map(|w| WallNow::of(&w.motion, &Servo::default(), 0.0, 0.0))
                .collect(),
            planes,
            bonds: bond::Table::default(),
            extra: Fixed::new(model),
            stiff: extra::stiffened(model),
            alike: alike(model),
            equal_bodies: false,
            table,
            materials,
        };
        setting.equal_bodies = equal_bodies(&setting);
        setting.bonds = bond::Table::new(&setting);
        setting
    }

    /// Puts walls where they are at `time`, s, `ahead` [s] of the last pass.
    pub fn place_walls(&mut self, servos: &[Servo], time: f64, ahead: f64) {
        if !(self.needs.servo_walls || self.needs.sliding_walls) {
            return;
        }
        for (index, (now, wall)) in self.walls.iter_mut().zip(&self.model.walls).enumerate() {
            let servo = servos.get(index).copied().unwrap_or_default();
            *now = WallNow::of(&wall.motion, &servo, time, ahead);
            if self.scheme == Scheme::Liggghts {
                now.add_velocities(&wall.motion, self.step, (time / self.step).round());
            }
        }
    }

    /// Walls lose the velocity that the solver of this scheme does not give them in its set-up pass.
    pub fn rest_for_set_up(&mut self) {
        for (now, wall) in self.walls.iter_mut().zip(&self.model.walls) {
            if wall.rests_at_set_up(self.scheme) {
                now.motion = Motion::Still;
            }
        }
    }

    /// Where the point of wall `wall` is at `time` that was at `point` at time 0; walls that
    /// oscillate or seek a force are where they were placed last.
    pub fn wall_place(&self, wall: usize, point: &Vec3, time: f64) -> Vec3 {
        self.wall_at(wall, time)(point)
    }

    /// [`Setting::wall_place`] for many points.
    pub fn wall_at(&self, wall: usize, time: f64) -> impl Fn(&Vec3) -> Vec3 + '_ {
        let motion = &self.model.walls[wall].motion;
        let place = motion.at(time);
        let placed = matches!(motion, Motion::Oscillate { .. } | Motion::Servo { .. });
        let shift = self.walls[wall].shift;
        move |point| if placed { point + shift } else { place(point) }
    }

    /// Time of the force pass that belongs to step `step`, s: the middle of the step
    /// where forces are averaged over it, otherwise its end.
    pub fn pass_time(&self, step: u64) -> f64 {
        match self.scheme {
            Scheme::PathAveraged if step > 0 => (step as f64 - 0.5) * self.step,
            _ => step as f64 * self.step,
        }
    }

    /// From a way between two places at home to that to the nearest image, m.
    #[inline(always)]
    pub fn shift(&self, way: &Vec3) -> Vec3 {
        way.zip_map(&self.edges, |way, edge| {
            if way > 0.5 * edge {
                -edge
            } else if way < -0.5 * edge {
                edge
            } else {
                0.0
            }
        })
    }

    /// The way `way` between two places at home, in a periodic box that to the nearest image, m.
    #[inline(always)]
    pub fn way(&self, way: Vec3) -> Vec3 {
        if self.needs.periodic { way + self.shift(&way) } else { way }
    }

    /// Parameters between two materials.
    #[inline(always)]
    pub fn pair(&self, a: u16, b: u16) -> &Contact {
        &self.table[a as usize * self.materials + b as usize]
    }

    /// Parameters between all spheres, where there is one material.
    pub fn only_law(&self) -> Option<Contact> {
        (self.materials == 1).then(|| self.table[0])
    }

    /// The same with the stiffness of attraction and rolling added, for the step limit.
    pub fn stiff_pair(&self, a: u16, b: u16) -> &Contact {
        &self.stiff[a as usize * self.materials + b as usize]
    }

    /// Plane number `index` of [`Setting::planes`] at `time`, s.
    pub fn plane(&self, index: usize, time: f64) -> PlaneNow {
        let number = self.planes[index] as usize;
        let wall = &self.model.walls[number];
        let WallShape::Plane { point, normal } = &wall.shape else {
            unreachable!("`planes` lists plane walls only")
        };
        let turned = match wall.motion {
            Motion::Rotate { axis, rate, .. } => {
                Rotation::from_scaled_axis(axis * (rate * time)) * normal
            }
            _ => *normal,
        };
        PlaneNow {
            point: self.wall_place(number, point, time),
            normal: turned,
            motion: self.walls[number].motion,
            material: wall.material,
            share: match wall.shape.axis_plane() {
                Some(_) => self.law.plane_arm.wall_share(),
                None => self.wall_share,
            },
        }
    }

    /// All planes at `time`, s.
    pub fn planes_at(&self, time: f64) -> Vec<PlaneNow> {
        (0..self.planes.len()).map(|index| self.plane(index, time)).collect()
    }

    /// Farthest that any wall material near the domain moves between two times, m.
    pub fn wall_travel(&self, from: f64, to: f64) -> f64 {
        let domain = &self.model.domain;
        let span = (to - from).abs();
        let travel = |motion: &Motion| match motion {
            Motion::Still => 0.0,
            Motion::Translate { velocity } => velocity.norm() * span,
            Motion::Oscillate { .. } | Motion::Servo { .. } => {
                motion.velocity(&Vec3::zeros()).norm() * span
            }
            Motion::Rotate { origin, axis, rate } => {
                let reach = (0..8)
                    .map(|corner| {
                        let pick = |axis: usize| {
                            if corner >> axis & 1 == 0 {
                                domain.low[axis]
                            } else {
                                domain.high[axis]
                            }
                        };
                        let arm = Vec3::new(pick(0), pick(1), pick(2)) - origin;
                        arm.cross(axis).norm()
                    })
                    .fold(0.0, f64::max);
                rate.abs() * span * reach
            }
        };
        self.model.walls.iter().map(|wall| travel(&wall.motion)).fold(0.0, f64::max)
    }
}

/// Parameters between spheres and their radius, if all spheres are of one material and size.
fn alike(model: &Model) -> Option<(Contact, f64)> {
    let (material, radius) = (model.bodies.first()?.material, model.spheres.first()?.radius);
    let same = model.bodies.iter().all(|body| body.material == material)
        && model.spheres.iter().all(|sphere| sphere.radius == radius);
    same.then(|| (*model.contacts.between(material, material), radius))
}

fn equal_bodies(setting: &Setting<'_>) -> bool {
    let bodies = &setting.model.bodies;
    let same = |body: &Body| (body.mass, body.inertia.z) == (bodies[0].mass, bodies[0].inertia.z);
    (0..bodies.len()).all(|index| same(&bodies[index]) && is_alone(setting, index))
}

/// Angular velocity of a wall, rad/s.
pub fn wall_spin(motion: &Motion) -> Vec3 {
    match motion {
        Motion::Rotate { axis, rate, .. } => axis * *rate,
        _ => Vec3::zeros(),
    }
}

/// Gap up to which the first lists hold pairs over the median radius: flat optimum for beds (0.05) and flows (0.2).
pub const FIRST_SKIN: f64 = 0.15;

/// Median radius of the spheres, m; 0 without spheres.
pub fn median_radius(model: &Model) -> f64 {
    let radii: Vec<f64> = model.spheres.iter().map(|sphere| sphere.radius).collect();
    crate::num::statistics::median(&radii).unwrap_or(0.0)
}
