//! What changes during a run: bodies, spheres in memory order, candidate lists.

use super::arrive;
use super::bond::Bonds;
use super::contacts::listed::Numbers;
use super::extra::Links;
#[cfg(target_arch = "x86_64")]
use super::lanes::Four;
use super::lanes::{Line, Plain, Wide};
use super::law::Book;
use super::ledger::Ledger;
use super::leeway;
use super::lost::Leavers;
use super::servo::Servo;
use super::setting::{FIRST_SKIN, Setting};
use super::turn;
use crate::model::{Body, BodyState, Frame, Scheme};
use crate::num::{Rotation, Vec3};
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// What pair forces need of a sphere: one cache line, centre and radius side by side.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[repr(C, align(64))]
pub struct Ball {
    /// Centre, m.
    pub place: Vec3,
    /// Radius, m; NaN of bodies that were taken out or have not come yet.
    pub radius: f64,
    /// Velocity, m/s.
    pub velocity: Vec3,
    /// Index of the body.
    pub body: u32,
    /// Index of the material.
    pub material: u16,
    /// True if the ball is a body by itself.
    pub alone: bool,
    /// Fills the line.
    pub spare: u8,
}

impl Ball {
    /// Centre, radius, velocity, and a last number that means nothing.
    #[inline(always)]
    pub fn line(&self) -> &Line {
        const { assert!(size_of::<Ball>() == size_of::<Line>()) };
        // SAFETY: both are 64 bytes on a line of the cache without gaps between fields, and
        // any bits are a number.
        unsafe { &*std::ptr::from_ref(self).cast() }
    }
}

/// Contact force and torque about the centre of a sphere.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[repr(C)]
pub struct Load {
    /// Force, N.
    pub force: Vec3,
    /// Torque, N m.
    pub torque: Vec3,
}

impl Load {
    /// Force and torque.
    #[inline(always)]
    pub fn vectors(&mut self) -> &mut [Vec3; 2] {
        const { assert!(size_of::<Load>() == size_of::<[Vec3; 2]>()) };
        // SAFETY: both are two vectors one after the other.
        unsafe { &mut *std::ptr::from_mut(self).cast() }
    }
}

impl AddAssign for Load {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.torque += other.torque;
    }
}

/// Inverse mass properties of a ball that is a body by itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Lightness {
    /// 1/m, 1/kg.
    pub mass: f64,
    /// 1/I, 1/(kg m²).
    pub inertia: f64,
}

/// Inverse mass properties of all balls: one entry where all bodies are equal, else one a ball.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Lights(pub Vec<Lightness>);

impl Lights {
    /// Those of `balls`.
    fn of(setting: &Setting<'_>, balls: &[Ball]) -> Self {
        let different = if setting.equal_bodies { balls.len().min(1) } else { balls.len() };
        let of = |ball: &Ball| match ball.alone {
            true => Lightness::of(&setting.model.bodies[ball.body as usize]),
            false => Lightness { mass: 0.0, inertia: 0.0 },
        };
        Self(balls[..different].iter().map(of).collect())
    }

    /// Those of every ball, where all are equal.
    pub fn same(&self) -> Option<Lightness> {
        if let [only] = self.0[..] { Some(only) } else { None }
    }

    /// Those of the ball in `slot`.
    #[inline(always)]
    pub fn at(&self, slot: usize) -> Lightness {
        self.0[slot.min(self.0.len() - 1)]
    }
}

impl Lightness {
    /// Of a body of one sphere.
    fn of(body: &Body) -> Self {
        Self { mass: 1.0 / body.mass, inertia: 1.0 / body.inertia.z }
    }
}

/// A body of several spheres, or with mass properties of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Solid {
    /// Index into `Model::bodies`.
    pub body: u32,
    /// Centre of mass, m.
    pub place: Vec3,
    /// Velocity, m/s.
    pub velocity: Vec3,
    /// Orientation, body frame to world.
    pub turn: Rotation,
    /// Angular momentum, kg m²/s.
    pub momentum: Vec3,
    /// Angular velocity, rad/s.
    pub spin: Vec3,
    /// Force and torque about the centre of mass.
    pub load: Load,
}

/// Candidates of every sphere: partners of sphere `i` are entries
/// `start[i]..start[i + 1]`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct List {
    /// Where the entries of each sphere begin.
    pub start: Vec<u32>,
    /// Sphere slot, plane number or triangle number.
    pub partner: Numbers<u32>,
    /// What the contacts remember.
    pub book: Book,
}

/// Everything that a run needs to go on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Steps done.
    pub step: u64,
    /// Balls in memory order.
    pub balls: Vec<Ball>,
    /// Angular velocities of the balls; empty if nothing turns.
    pub spins: Vec<Vec3>,
    /// Contact loads on the balls.
    pub loads: Vec<Load>,
    /// Inverse mass properties of the balls.
    pub light: Lights,
    /// Index into `Model::spheres` of each slot.
    pub order: Vec<u32>,
    /// Slot of each sphere of the model.
    pub slot: Vec<u32>,
    /// Clumps.
    pub solids: Vec<Solid>,
    /// Sphere–sphere candidates.
    pub pairs: List,
    /// Sphere–plane candidates.
    pub planes: List,
    /// Sphere–triangle candidates.
    pub faces: List,
    /// Centres when the lists were built, m.
    pub built: Vec<Vec3>,
    /// Step at which the lists were built.
    pub built_at: u64,
    /// Times the lists were built.
    pub rebuilds: u64,
    /// How far each ball may go before lists are built again, m: see [`super::leeway`].
    pub leeway: Vec<f32>,
    /// The same of walls, m.
    pub wall_leeway: f64,
    /// How far spheres and walls went in half a step when the lists were built, m;
    /// 0 where only the places of a force pass matter.
    pub sweep: f64,
    /// Bodies that were taken out.
    pub gone: Leavers,
    /// How many of the bodies that come during the run have come.
    pub come: usize,
    /// Servo walls, one entry each wall; empty if there is none.
    pub servos: Vec<Servo>,
    /// What changes of the bonds.
    pub bonds: Bonds,
    /// Pairs with forces besides the linear contact.
    pub links: Links,
    /// Energy book-keeping.
    pub ledger: Ledger,
}

impl State {
    /// The state at time 0 with no lists yet.
    pub fn new(setting: &Setting<'_>) -> Self {
        let model = setting.model;
        let count = model.spheres.len();
        let first = 0.5 * FIRST_SKIN * setting.median_radius;
        let mut state = Self {
            step: 0,
            balls: Vec::with_capacity(count),
            spins: Vec::with_capacity(if setting.needs.rotation { count } else { 0 }),
            loads: vec![Load::default(); count],
            light: Lights(Vec::new()),
            order: (0..count as u32).collect(),
            slot: (0..count as u32).collect(),
            solids: Vec::new(),
            pairs: List::default(),
            planes: List::default(),
            faces: List::default(),
            built: Vec::new(),
            built_at: 0,
            rebuilds: 0,
            leeway: vec![leeway::single(first); count],
            wall_leeway: first,
            sweep: 0.0,
            gone: Leavers::default(),
            come: 0,
            servos: match setting.needs.servo_walls {
                true => vec![Servo::default(); model.walls.len()],
                false => Vec::new(),
            },
            bonds: Bonds::new(setting),
            links: Links::default(),
            ledger: Ledger::default(),
        };
        // YADE stores velocities half a step early.
        let early = match setting.scheme {
            Scheme::Yade => setting.gravity * (-0.5 * setting.step),
            _ => Vec3::zeros(),
        };
        for (index, body) in model.bodies.iter().enumerate() {
            let alone = is_alone(setting, index);
            for sphere in model.spheres_of(index) {
                state.balls.push(Ball {
                    place: body.position + body.orientation * sphere.offset,
                    radius: sphere.radius,
                    velocity: body.velocity + early,
                    body: index as u32,
                    material: body.material,
                    alone,
                    spare: 0,
                });
                if setting.needs.rotation {
                    state.spins.push(body.spin);
                }
            }
            if !alone {
                state.solids.push(Solid {
                    body: index as u32,
                    place: body.position,
                    velocity: body.velocity + early,
                    turn: body.orientation,
                    momentum: turn::momentum(&body.orientation, &body.inertia, &body.spin),
                    spin: body.spin,
                    load: Load::default(),
                });
            }
        }
        state.light = Lights::of(setting, &state.balls);
        for index in 0..state.solids.len() {
            state.carry_members(setting, index);
        }
        arrive::put_off(setting, &mut state);
        state
    }

    /// Takes sizes and masses that the model has now, and counts time and energy from zero:
    /// places, velocities, spins and contact memories stay.
    pub fn begin_again(&mut self, setting: &Setting<'_>) {
        let model = setting.model;
        (self.step, self.built_at, self.rebuilds) = (0, 0, 0);
        self.ledger = Ledger::default();
        self.links.outdate();
        for (sphere, &slot) in model.spheres.iter().zip(&self.slot) {
            self.balls[slot as usize].radius = sphere.radius;
        }
        self.light = Lights::of(setting, &self.balls);
        for index in 0..self.solids.len() {
            let solid = &mut self.solids[index];
            let inertia = &model.bodies[solid.body as usize].inertia;
            solid.momentum = turn::momentum(&solid.turn, inertia, &solid.spin);
            self.carry_members(setting, index);
        }
    }

    /// Largest gap at which a pair is in the lists, m.
    pub fn widest(&self) -> f64 {
        let most = self.leeway.iter().copied().fold(0.0, f32::max);
        2.0 * (f64::from(most) + self.sweep)
    }

    /// Gap below which the balls of two slots are in the lists, m.
    #[inline(always)]
    pub fn margin_of(&self, slot: usize, other: usize) -> f64 {
        f64::from(self.leeway[slot]) + f64::from(self.leeway[other]) + 2.0 * self.sweep
    }

    /// Gap below which a ball and a wall are in the lists, m.
    pub fn margin_at_walls(&self, slot: usize) -> f64 {
        f64::from(self.leeway[slot]) + self.wall_leeway + 2.0 * self.sweep
    }

    /// Moves the balls of a solid with it.
    pub fn carry_members(&mut self, setting: &Setting<'_>, index: usize) {
        let solid = &self.solids[index];
        let body = &setting.model.bodies[solid.body as usize];
        let turn = solid.turn.to_rotation_matrix();
        for sphere in body.first_sphere..body.first_sphere + body.sphere_count {
            let arm = turn * setting.model.spheres[sphere as usize].offset;
            let slot = self.slot[sphere as usize] as usize;
            let ball = &mut self.balls[slot];
            ball.place = solid.place + arm;
            ball.velocity = solid.velocity + solid.spin.cross(&arm);
            if let Some(spin) = self.spins.get_mut(slot) {
                *spin = solid.spin;
            }
        }
    }

    /// Gives the balls of a solid its velocity.
    pub fn pace_members(&mut self, setting: &Setting<'_>, index: usize) {
        let solid = &self.solids[index];
        let body = &setting.model.bodies[solid.body as usize];
        for sphere in body.first_sphere..body.first_sphere + body.sphere_count {
            let slot = self.slot[sphere as usize] as usize;
            let ball = &mut self.balls[slot];
            ball.velocity = solid.velocity + solid.spin.cross(&(ball.place - solid.place));
            if let Some(spin) = self.spins.get_mut(slot) {
                *spin = solid.spin;
            }
        }
    }

    /// Sums the loads of the balls of every solid about its centre of mass.
    pub fn gather_solids(&mut self, setting: &Setting<'_>) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            #[target_feature(enable = "avx2")]
            fn with_avx2(state: &mut State, setting: &Setting<'_>) {
                state.gather::<Four>(setting);
            }
            // SAFETY: the processor has what the function asks for.
            return unsafe { with_avx2(self, setting) };
        }
        self.gather::<Plain>(setting);
    }

    /// [`State::gather_solids`], the three numbers of a vector side by side.
    #[inline(always)]
    fn gather<L: Wide<4>>(&mut self, setting: &Setting<'_>) {
        for solid in &mut self.solids {
            let body = &setting.model.bodies[solid.body as usize];
            let (mut force, mut torque) = (L::splat(0.0), L::splat(0.0));
            let centre = L::three(&solid.place);
            for sphere in body.first_sphere..body.first_sphere + body.sphere_count {
                let slot = self.slot[sphere as usize] as usize;
                let (ball, load) = (&self.balls[slot], &self.loads[slot]);
                let (arm, push) = (L::three(&ball.place) - centre, L::three(&load.force));
                force = force + push;
                torque = torque + (L::three(&load.torque) + arm.cross_three(push));
            }
            force.keep_three(&mut solid.load.force);
            torque.keep_three(&mut solid.load.torque);
        }
    }

    /// State of every body, in the model's order.
    pub fn bodies(&self, setting: &Setting<'_>) -> Vec<BodyState> {
        let model = setting.model;
        let mut states = model.initial_states();
        for (index, body) in model.bodies.iter().enumerate() {
            let slot = self.slot[body.first_sphere as usize] as usize;
            let ball = &self.balls[slot];
            if ball.alone {
                states[index].position = ball.place;
                states[index].velocity = ball.velocity;
                states[index].spin = self.spins.get(slot).copied().unwrap_or_default();
            }
        }
        // Who has not come yet stands still.
        for state in &mut states[model.first_arrival() + self.come..] {
            (state.velocity, state.spin) = (Vec3::zeros(), Vec3::zeros());
        }
        for solid in &self.solids {
            states[solid.body as usize] = BodyState {
                position: solid.place,
                orientation: solid.turn,
                velocity: solid.velocity,
                spin: solid.spin,
            };
        }
        states
    }

    /// Place and velocity of every body, in the model's order.
    pub fn paths<'a>(
        &'a self,
        setting: &'a Setting<'_>,
    ) -> impl Iterator<Item = (Vec3, Vec3)> + 'a {
        let mut solids = self.solids.iter().peekable();
        setting.model.bodies.iter().zip(0u32..).map(move |(body, index)| {
            match solids.next_if(|solid| solid.body == index) {
                Some(solid) => (solid.place, solid.velocity),
                None => {
                    let ball = &self.balls[self.slot[body.first_sphere as usize] as usize];
                    (ball.place, ball.velocity)
                }
            }
        })
    }

    /// A snapshot in the model's order.
    pub fn frame(&self, setting: &Setting<'_>) -> Frame {
        let model = setting.model;
        let slots = || self.slot.iter().map(|slot| *slot as usize);
        let mut frame = Frame {
            step: self.step,
            time: self.step as f64 * setting.step,
            centres: slots().map(|s| self.balls[s].place).collect(),
            velocities: slots().map(|s| self.balls[s].velocity).collect(),
            spins: slots().map(|s| self.spins.get(s).copied().unwrap_or_default()).collect(),
            forces: slots()
                .map(|s| {
                    let ball = &self.balls[s];
                    let weight = if ball.alone {
                        setting.gravity * model.bodies[ball.body as usize].mass
                    } else {
                        Vec3::zeros()
                    };
                    self.loads[s].force + weight
                })
                .collect(),
            bodies: self.bodies(setting),
        };
        frame.bring_home(model);
        frame
    }
}

/// True for a body that is one sphere about its own centre with the same moment about every axis.
pub fn is_alone(setting: &Setting<'_>, index: usize) -> bool {
    let body = &setting.model.bodies[index];
    let sphere = &setting.model.spheres[body.first_sphere as usize];
    let round =
        setting.planar || (body.inertia.x == body.inertia.y && body.inertia.y == body.inertia.z);
    body.sphere_count == 1 && sphere.offset == Vec3::zeros() && round
}
