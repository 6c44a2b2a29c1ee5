//! Contacts of the path-averaged scheme: geometry at the middle of the step,
//! accelerations of the last step and effective masses. See [`super::averaged`].
//!
//! Normals, closest points and walls are those of the middle of the step, gap rates
//! are taken along these normals; sliding velocities are those of the beginning of the step,
//! with normals and arms of then, so that displacements from middle to middle are of
//! second order while normals turn (walls that turn are taken as they are at the middle). A
//! triangle mesh hands a sphere from one face to the next at the middle of a step: where
//! that changes the number of contacts, at bent edges, the scheme is of first order, as the
//! rest are. O(candidates); cannot fail.

use super::averaged::{Meeting, respond, window};
use super::forces::Field;
use super::law::{BookView, Reply, Tally};
use super::setting::Setting;
use super::state::{Ball, Load, State};
use super::surface::{self, Feature};
use super::walls::{Hit, hand_over};
use crate::model::Motion;
use crate::num::Vec3;
use nalgebra::Matrix3;

/// Force of a pair on its first sphere.
#[derive(Debug, Clone, Copy)]
pub struct Push {
    /// The force, N.
    pub force: Vec3,
    /// Normal × tangential force; times the arm it is the torque taken from each sphere.
    pub couple: Vec3,
    /// Arms of both spheres, m.
    pub arms: [f64; 2],
}

/// What the dashpots need to know of a ball: one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub struct Past {
    /// Acceleration of the centre by the loads of the last pass, m/s².
    pull: Vec3,
    /// Angular acceleration by them, rad/s².
    twist: Vec3,
    /// 1/m of the body, 1/kg.
    light: f64,
    /// Index into [`Memory::solids`] if the ball is not a body by itself.
    solid: u32,
}

/// What dashpots need to know of a clump.
#[derive(Debug, Clone, Copy)]
struct Bulk {
    /// Centre of mass, m.
    place: Vec3,
    /// Inverse inertia in the world frame, 1/(kg m²).
    turning: Matrix3<f64>,
    /// Angular velocity, rad/s.
    spin: Vec3,
    /// Angular acceleration without loads, rad/s².
    nutation: Vec3,
}

/// Accelerations of the last step and effective masses.
#[derive(Debug, Default)]
pub struct Memory {
    balls: Vec<Past>,
    solids: Vec<Bulk>,
}

impl Memory {
    /// Looks at the loads of the last pass, before they are overwritten. Places are
    /// those of the present pass.
    pub fn look(&mut self, setting: &Setting<'_>, state: &State) {
        self.balls.clear();
        self.solids.clear();
        let gravity = setting.gravity;
        self.balls.extend(state.loads.iter().enumerate().map(|(slot, load)| {
            let light = state.light.at(slot);
            Past {
                pull: load.force * light.mass + gravity,
                twist: load.torque * light.inertia,
                light: light.mass,
                solid: u32::MAX,
            }
        }));
        for (index, solid) in state.solids.iter().enumerate() {
            let body = &setting.model.bodies[solid.body as usize];
            let axes = solid.turn.to_rotation_matrix().into_inner();
            let inverse = Matrix3::from_diagonal(&body.inertia.map(f64::recip));
            let turning = axes * inverse * axes.transpose();
            let twist = turning * solid.load.torque;
            for sphere in body.first_sphere..body.first_sphere + body.sphere_count {
                let slot = state.slot[sphere as usize] as usize;
                let arm = state.balls[slot].place - solid.place;
                self.balls[slot] = Past {
                    pull: solid.load.force / body.mass + gravity + twist.cross(&arm),
                    twist,
                    light: 1.0 / body.mass,
                    solid: index as u32,
                };
            }
            let nutation = turning * solid.momentum.cross(&solid.spin);
            self.solids.push(Bulk { place: solid.place, turning, spin: solid.spin, nutation });
        }
    }

    /// Velocity of the centre of a ball and its spin `half` a step before the places of the
    /// pass: those of the pass but for the free rotation of clumps.
    #[inline(always)]
    fn early(&self, slot: usize, ball: &Ball, spin: &Vec3, half: f64) -> (Vec3, Vec3) {
        if ball.alone {
            return (ball.velocity, *spin);
        }
        let bulk = &self.solids[self.balls[slot].solid as usize];
        let lever = ball.place - bulk.place;
        let bend = bulk.nutation.cross(&lever) + bulk.spin.cross(&bulk.spin.cross(&lever));
        (ball.velocity - bend * half, spin - bulk.nutation * half)
    }

    /// Inverse effective mass of a ball's body for a force along the contact normal.
    #[inline(always)]
    fn along(&self, slot: usize, ball: &Ball, normal: &Vec3) -> f64 {
        let past = &self.balls[slot];
        if ball.alone {
            return past.light;
        }
        let bulk = &self.solids[past.solid as usize];
        let lever = (ball.place - bulk.place).cross(normal);
        past.light + lever.dot(&(bulk.turning * lever))
    }

    /// The same along `direction` in the contact plane, `arm` from the centre of the ball.
    #[inline(always)]
    fn across(&self, field: &Field<'_>, slot: usize, arm: &Vec3, direction: &Vec3) -> f64 {
        let (past, ball) = (&self.balls[slot], &field.balls[slot]);
        if ball.alone {
            return past.light + arm.norm_squared() * field.light.at(slot).inertia;
        }
        let bulk = &self.solids[past.solid as usize];
        let lever = (ball.place + arm - bulk.place).cross(direction);
        past.light + lever.dot(&(bulk.turning * lever))
    }
}

/// Mean force of one sphere–sphere candidate on the first of the two; `None` if apart.
#[inline(always)]
pub fn pair<const FRICTION: bool, const DAMPING: bool>(
    field: &Field<'_>,
    slot: usize,
    other: usize,
    book: &mut BookView<'_>,
    k: usize,
    tally: &mut Tally,
) -> Option<Push> {
    let (me, them) = (&field.balls[slot], &field.balls[other]);
    let between = field.setting.way(me.place - them.place);
    let mut velocity = me.velocity - them.velocity;
    let square = between.norm_squared();
    let sum = me.radius + them.radius;
    // The gap at an end of the step, d − R − Δt/2 |d·v|/d, is positive if d² − R² > Δt |d·v|.
    let apart = square - sum * sum > field.rule.advance * between.dot(&velocity).abs();
    if apart && !book.touching[k] {
        return None;
    }
    let distance = square.sqrt();
    let normal = between * distance.recip();
    let gap = distance - sum;
    let share = field.setting.share;
    let arms = [me.radius + share * gap, them.radius + share * gap];
    let (mut pull, mut early, mut ease) = (Vec3::zeros(), Vec3::zeros(), 0.0);
    if FRICTION {
        early = early_slide(field, [slot, other], &between, &velocity);
        velocity += normal.cross(&(field.spins[slot] * arms[0] + field.spins[other] * arms[1]));
    }
    if DAMPING {
        let (mine, theirs) = (&field.memory.balls[slot], &field.memory.balls[other]);
        pull = mine.pull - theirs.pull;
        if FRICTION {
            pull += normal.cross(&(mine.twist * arms[0] + theirs.twist * arms[1]));
        }
        ease = field.memory.along(slot, me, &normal) + field.memory.along(other, them, &normal);
    }
    let law = field.setting.pair(me.material, them.material);
    let meeting = Meeting { normal, gap, velocity, early, pull, ease };
    let across = |direction: &Vec3| {
        field.memory.across(field, slot, &(normal * -arms[0]), direction)
            + field.memory.across(field, other, &(normal * arms[1]), direction)
    };
    let rule = (field.rule, field.setting.step);
    let Reply { normal: size, tangent } =
        respond::<FRICTION, DAMPING>(rule, law, &meeting, across, book, k, tally)?;
    let couple = if FRICTION { normal.cross(&tangent) } else { Vec3::zeros() };
    Some(Push { force: normal * size + tangent, couple, arms })
}

/// Sliding velocity of two balls at the beginning of the step, m/s, from their places
/// and velocities at its middle.
#[inline(always)]
fn early_slide(
    field: &Field<'_>,
    [slot, other]: [usize; 2],
    between: &Vec3,
    velocity: &Vec3,
) -> Vec3 {
    let (me, them) = (&field.balls[slot], &field.balls[other]);
    let half = 0.5 * field.rule.advance;
    let before = between - velocity * half;
    let distance = before.norm();
    let normal = before * distance.recip();
    let depth = field.setting.share * (distance - me.radius - them.radius);
    let (mine, my_spin) = field.memory.early(slot, me, &field.spins[slot], half);
    let (theirs, their_spin) = field.memory.early(other, them, &field.spins[other], half);
    let turning = my_spin * (me.radius + depth) + their_spin * (them.radius + depth);
    let whole = mine - theirs + normal.cross(&turning);
    whole - normal * whole.dot(&normal)
}

/// A sphere near a wall.
struct Spot<'a> {
    /// From the wall to the centre of the sphere, m, and its length.
    away: Vec3,
    distance: f64,
    /// From the wall to the centre at the beginning of the step, m; with friction only.
    before: Vec3,
    /// Point of the wall that is closest, m.
    foot: Vec3,
    motion: &'a Motion,
    material: u16,
    share: f64,
}

#[inline]
fn at_wall<const FRICTION: bool, const DAMPING: bool>(
    field: &Field<'_>,
    slot: usize,
    spot: &Spot<'_>,
    book: &mut BookView<'_>,
    k: usize,
    load: &mut Load,
    tally: &mut Tally,
) {
    let ball = &field.balls[slot];
    let normal = spot.away / spot.distance;
    let gap = spot.distance - ball.radius;
    let arm = ball.radius + gap * spot.share;
    let moving = spot.motion.velocity(&spot.foot);
    let mut velocity = ball.velocity - moving;
    let (mut pull, mut early, mut ease) = (Vec3::zeros(), Vec3::zeros(), 0.0);
    if FRICTION {
        let half = 0.5 * field.rule.advance;
        let distance = spot.before.norm();
        let (old, depth) = (spot.before / distance, distance - ball.radius);
        let lever = ball.radius + depth * spot.share;
        let (mine, spin) = field.memory.early(slot, ball, &field.spins[slot], half);
        let whole = mine - moving + old.cross(&(spin * lever));
        early = whole - old * whole.dot(&old);
        velocity += normal.cross(&(field.spins[slot] * arm));
    }
    if DAMPING {
        let mine = &field.memory.balls[slot];
        pull = mine.pull;
        if FRICTION {
            pull += normal.cross(&(mine.twist * arm));
        }
        ease = field.memory.along(slot, ball, &normal);
    }
    let law = field.setting.pair(ball.material, spot.material);
    let meeting = Meeting { normal, gap, velocity, early, pull, ease };
    let across = |direction: &Vec3| field.memory.across(field, slot, &(normal * -arm), direction);
    let rule = (field.rule, field.setting.step);
    let reply = respond::<FRICTION, DAMPING>(rule, law, &meeting, across, book, k, tally);
    let Some(Reply { normal: size, tangent }) = reply else { return };
    let force = normal * size + tangent;
    load.force += force;
    if FRICTION {
        load.torque -= normal.cross(&tangent) * arm;
    }
    tally.wall_power += force.dot(&moving);
}

/// Contacts of a sphere with the planes near it.
#[inline]
pub fn on_planes<const FRICTION: bool, const DAMPING: bool>(
    field: &Field<'_>,
    slot: usize,
    partners: &[u32],
    base: usize,
    book: &mut BookView<'_>,
    load: &mut Load,
    tally: &mut Tally,
) {
    let ball = &field.balls[slot];
    for (at, partner) in partners.iter().enumerate() {
        let plane = &field.planes.now[*partner as usize];
        let height = (ball.place - plane.point).dot(&plane.normal);
        let away = plane.normal * height;
        let foot = ball.place - away;
        let drift = (ball.velocity - plane.motion.velocity(&foot)).dot(&plane.normal);
        let spot = Spot {
            away,
            distance: height.abs(),
            before: plane.normal * (height - 0.5 * field.rule.advance * drift),
            foot,
            motion: &plane.motion,
            material: plane.material,
            share: plane.share,
        };
        at_wall::<FRICTION, DAMPING>(field, slot, &spot, book, base + at, load, tally);
    }
}

/// Contacts of a sphere with the triangles near it.
#[allow(clippy::too_many_arguments)] // the arguments of `on_planes` and the scratch
pub fn on_faces<const FRICTION: bool, const DAMPING: bool>(
    field: &Field<'_>,
    slot: usize,
    partners: &[u32],
    base: usize,
    book: &mut BookView<'_>,
    load: &mut Load,
    tally: &mut Tally,
    hits: &mut Vec<Hit>,
) {
    let ball = &field.balls[slot];
    find_hits(field, ball, partners, hits);
    if FRICTION {
        hand_over::<DAMPING>(field, partners, base, book, hits);
    }
    for (at, (partner, hit)) in partners.iter().zip(hits.iter()).enumerate() {
        if !hit.touches {
            if book.touching[base + at] {
                // Another face has taken over; its spring went with it or is lost.
                book.clear(base + at);
            }
            continue;
        }
        book.touching[base + at] |= hit.inherits;
        let number = field.setting.surfaces.wall[*partner as usize] as usize;
        let wall = &field.setting.model.walls[number];
        let away = ball.place - hit.point;
        let mut before = away;
        if FRICTION {
            let drift = ball.velocity - wall.motion.velocity(&hit.point);
            let place = ball.place - drift * (0.5 * field.rule.advance);
            before = place - surface::closest(&place, &field.faces[*partner as usize]).0;
        }
        let spot = Spot {
            away,
            distance: away.norm(),
            before,
            foot: hit.point,
            motion: &field.setting.walls[number].motion,
            material: wall.material,
            share: field.setting.share,
        };
        at_wall::<FRICTION, DAMPING>(field, slot, &spot, book, base + at, load, tally);
    }
}

/// Closest points, and which triangles a sphere touches in the course of the step
/// under the rule of [`surface`].
fn find_hits(field: &Field<'_>, ball: &Ball, partners: &[u32], hits: &mut Vec<Hit>) {
    let surfaces = &field.setting.surfaces;
    hits.clear();
    for (at, partner) in partners.iter().enumerate() {
        let face = *partner as usize;
        let (point, feature) = surface::closest(&ball.place, &field.faces[face]);
        let away = ball.place - point;
        let distance = away.norm();
        let motion = &field.setting.walls[surfaces.wall[face] as usize].motion;
        let rate = (ball.velocity - motion.velocity(&point)).dot(&away) / distance;
        let (gap, half) = (distance - ball.radius, 0.5 * field.rule.advance * rate);
        let touches = window(gap - half, gap + half).is_some()
            && surfaces.acts(face, feature)
            && !(feature == Feature::Face
                && partners[..at]
                    .iter()
                    .zip(hits.iter())
                    .any(|(other, hit)| hit.touches && surfaces.coplanar(*partner, *other)));
        hits.push(Hit { point, touches, inherits: false, bare: false });
    }
}
