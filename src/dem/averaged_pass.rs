//! Contacts of the path-averaged scheme: geometry at the middle of the step,
//! accelerations of the last step and effective masses. See [`super::averaged`].
//!
//! Normals, closest points and walls are those of the middle of the step, gap rates
//! are taken along these normals. A triangle mesh therefore hands a sphere from one
//! face to the next at the middle of a step: at edges and corners the scheme is of
//! first order, as the rest are. O(candidates); cannot fail.

use super::averaged::{Meeting, respond, window};
use super::forces::{Field, Push};
use super::law::{BookView, Reply, Tally};
use super::setting::Setting;
use super::state::{Ball, Load, State};
use super::surface::{self, Feature};
use super::walls::{Hit, hand_over};
use crate::model::Motion;
use crate::num::Vec3;
use nalgebra::Matrix3;

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
        self.balls.extend(state.loads.iter().zip(&state.light).map(|(load, light)| Past {
            pull: load.force * light.mass + gravity,
            twist: load.torque * light.inertia,
            light: light.mass,
            solid: u32::MAX,
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

    /// Acceleration of the point `arm` from the centre of a ball by free rotation of its clump.
    #[inline(always)]
    fn bend(&self, slot: usize, ball: &Ball, arm: &Vec3) -> Vec3 {
        if ball.alone {
            return Vec3::zeros();
        }
        let bulk = &self.solids[self.balls[slot].solid as usize];
        let lever = ball.place + arm - bulk.place;
        bulk.nutation.cross(&lever) + bulk.spin.cross(&bulk.spin.cross(&lever))
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
            return past.light + arm.norm_squared() * field.light[slot].inertia;
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
    let (mut pull, mut bend, mut ease) = (Vec3::zeros(), Vec3::zeros(), 0.0);
    if FRICTION {
        bend = field.memory.bend(slot, me, &(normal * -arms[0]))
            - field.memory.bend(other, them, &(normal * arms[1]));
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
    let meeting = Meeting { normal, gap, velocity, pull, bend, ease };
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

/// A sphere near a wall.
struct Spot<'a> {
    /// From the wall to the centre of the sphere, m, and its length.
    away: Vec3,
    distance: f64,
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
    let (mut pull, mut bend, mut ease) = (Vec3::zeros(), Vec3::zeros(), 0.0);
    if FRICTION {
        bend = field.memory.bend(slot, ball, &(normal * -arm));
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
    let meeting = Meeting { normal, gap, velocity, pull, bend, ease };
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
        let plane = &field.planes[*partner as usize];
        let height = (ball.place - plane.point).dot(&plane.normal);
        let away = plane.normal * height;
        let spot = Spot {
            away,
            distance: height.abs(),
            foot: ball.place - away,
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
        let spot = Spot {
            away,
            distance: away.norm(),
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
        hits.push(Hit { point, touches, inherits: false });
    }
}
