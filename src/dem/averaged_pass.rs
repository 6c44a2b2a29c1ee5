//! Contacts of the path-averaged scheme: geometry at the middle of the step,
//! accelerations of the last step and effective masses. See [`super::averaged`]. Here one
//! contact at a time, of clumps and with triangles; [`super::averaged_meet`] has the rest.
//!
//! Normals, closest points and walls are those of the middle of the step, gap rates
//! are taken along these normals; sliding velocities are those of the beginning of the step,
//! with normals and arms of then, so that displacements from middle to middle are of
//! second order while normals turn (walls that turn are taken as they are at the middle). A
//! triangle mesh hands a sphere from one face to the next at the middle of a step: where
//! that changes the number of contacts, at bent edges, the scheme is of first order, as the
//! rest are. O(candidates); cannot fail.

use super::averaged::{Meeting, advance, window};
use super::contacts::Scratch;
use super::forces::Field;
use super::lanes::Line;
use super::law::{BookView, Kind, Reply, Tally};
use super::setting::Setting;
use super::state::{Ball, State};
use super::surface::{self, Feature};
use super::walls::{Hit, hand_over};
use crate::num::Vec3;
use nalgebra::Matrix3;

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
    /// Of each ball: acceleration of the centre by the loads of the last pass, m/s², 1/m of
    /// the body, 1/kg; angular acceleration by them, rad/s², 1/I, 1/(kg m²) (of balls that
    /// are a body by themselves). With dashpots only.
    pub lines: Vec<Line>,
    /// Index into [`Memory::solids`] of each ball that is not a body by itself; empty where
    /// there is none.
    solid: Vec<u32>,
    solids: Vec<Bulk>,
}

/// A [`Line`] of [`Memory::lines`].
#[inline(always)]
fn line(pull: Vec3, light: f64, twist: Vec3, turning: f64) -> Line {
    Line([pull.x, pull.y, pull.z, light, twist.x, twist.y, twist.z, turning])
}

impl Memory {
    /// Looks at the loads of the last pass, before they are overwritten. Places are
    /// those of the present pass.
    pub fn look(&mut self, setting: &Setting<'_>, state: &State) {
        self.lines.clear();
        self.solid.clear();
        self.solids.clear();
        let gravity = setting.gravity;
        if setting.kept.damping {
            self.lines.extend(state.loads.iter().enumerate().map(|(slot, load)| {
                let light = state.light.at(slot);
                let pull = load.force * light.mass + gravity;
                line(pull, light.mass, load.torque * light.inertia, light.inertia)
            }));
        }
        if !state.solids.is_empty() {
            self.solid.resize(state.balls.len(), u32::MAX);
        }
        for (index, solid) in state.solids.iter().enumerate() {
            let body = &setting.model.bodies[solid.body as usize];
            let axes = solid.turn.to_rotation_matrix().into_inner();
            let inverse = Matrix3::from_diagonal(&body.inertia.map(f64::recip));
            let turning = axes * inverse * axes.transpose();
            let twist = turning * solid.load.torque;
            for sphere in body.first_sphere..body.first_sphere + body.sphere_count {
                let slot = state.slot[sphere as usize] as usize;
                self.solid[slot] = index as u32;
                let arm = state.balls[slot].place - solid.place;
                let pull = solid.load.force / body.mass + gravity + twist.cross(&arm);
                if let Some(place) = self.lines.get_mut(slot) {
                    *place = line(pull, 1.0 / body.mass, twist, 0.0);
                }
            }
            let nutation = turning * solid.momentum.cross(&solid.spin);
            self.solids.push(Bulk { place: solid.place, turning, spin: solid.spin, nutation });
        }
    }

    /// Whether there are bodies of several spheres.
    pub fn has_solids(&self) -> bool {
        !self.solids.is_empty()
    }

    /// Accelerations of a ball in the last step, m/s² and rad/s².
    #[inline(always)]
    fn past(&self, slot: usize) -> (Vec3, Vec3) {
        let Line([a, b, c, _, d, e, f, _]) = self.lines[slot];
        (Vec3::new(a, b, c), Vec3::new(d, e, f))
    }

    /// Velocity of the centre of a ball and its spin `half` a step before the places of the
    /// pass: those of the pass but for the free rotation of clumps.
    #[inline(always)]
    fn early(&self, slot: usize, ball: &Ball, spin: &Vec3, half: f64) -> (Vec3, Vec3) {
        if ball.alone {
            return (ball.velocity, *spin);
        }
        let bulk = &self.solids[self.solid[slot] as usize];
        let lever = ball.place - bulk.place;
        let bend = bulk.nutation.cross(&lever) + bulk.spin.cross(&bulk.spin.cross(&lever));
        (ball.velocity - bend * half, spin - bulk.nutation * half)
    }

    /// Inverse effective mass of a ball's body for a force along the contact normal.
    #[inline(always)]
    fn along(&self, slot: usize, ball: &Ball, normal: &Vec3) -> f64 {
        let light = self.lines[slot].0[3];
        if ball.alone {
            return light;
        }
        let bulk = &self.solids[self.solid[slot] as usize];
        let lever = (ball.place - bulk.place).cross(normal);
        light + lever.dot(&(bulk.turning * lever))
    }

    /// The same along `direction` in the contact plane, `arm` from the centre of the ball.
    #[inline(always)]
    fn across(&self, slot: usize, ball: &Ball, arm: &Vec3, direction: &Vec3) -> f64 {
        let Line([_, _, _, light, .., turning]) = self.lines[slot];
        if ball.alone {
            return light + arm.norm_squared() * turning;
        }
        let bulk = &self.solids[self.solid[slot] as usize];
        let lever = (ball.place + arm - bulk.place).cross(direction);
        light + lever.dot(&(bulk.turning * lever))
    }
}

/// Direction of the sliding velocity; 0 if nothing slides.
#[inline(always)]
fn sliding(velocity: &Vec3, normal: &Vec3) -> Vec3 {
    let slide = velocity - normal * velocity.dot(normal);
    slide.try_normalize(0.0).unwrap_or_default()
}

/// Two spheres, one of them at least a member of a clump, and the arms of both, m.
pub fn members<K: Kind>(field: &Field<'_>, slot: usize, other: usize) -> (Meeting, [f64; 2]) {
    let (me, them) = (&field.balls[slot], &field.balls[other]);
    let between = field.setting.way(me.place - them.place);
    let mut velocity = me.velocity - them.velocity;
    let distance = between.norm();
    let normal = between * distance.recip();
    let gap = distance - (me.radius + them.radius);
    let share = field.setting.share;
    let arms = [me.radius + share * gap, them.radius + share * gap];
    let (mut pull, mut early, mut ease, mut across) = (Vec3::zeros(), Vec3::zeros(), 0.0, 0.0);
    if K::FRICTION {
        early = early_slide(field, [slot, other], &between, &velocity);
        velocity += normal.cross(&(field.spins[slot] * arms[0] + field.spins[other] * arms[1]));
    }
    let memory = field.memory;
    if K::DAMPING {
        let ((mine, turn), (theirs, their_turn)) = (memory.past(slot), memory.past(other));
        pull = mine - theirs;
        if K::DRAGS {
            pull += normal.cross(&(turn * arms[0] + their_turn * arms[1]));
        }
        ease = memory.along(slot, me, &normal) + memory.along(other, them, &normal);
    }
    if K::DRAGS {
        let way = sliding(&velocity, &normal);
        across = memory.across(slot, me, &(normal * -arms[0]), &way)
            + memory.across(other, them, &(normal * arms[1]), &way);
    }
    (meeting(normal, gap, [velocity, early, pull], [ease, across]), arms)
}

fn meeting(
    normal: Vec3,
    gap: f64,
    [velocity, early, pull]: [Vec3; 3],
    [ease, across]: [f64; 2],
) -> Meeting {
    Meeting {
        normal: normal.into(),
        gap,
        velocity: velocity.into(),
        early: early.into(),
        pull: pull.into(),
        ease,
        across,
    }
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
struct Spot {
    /// From the wall to the centre of the sphere, m, and its length.
    away: Vec3,
    distance: f64,
    /// From the wall to the centre at the beginning of the step, m; with friction only.
    before: Vec3,
    /// Velocity of the wall at its closest point, m/s.
    moving: Vec3,
    share: f64,
}

/// How it meets the wall, and its arm, m.
#[inline]
fn at_wall<K: Kind>(field: &Field<'_>, slot: usize, spot: &Spot) -> (Meeting, f64) {
    let ball = &field.balls[slot];
    let normal = spot.away / spot.distance;
    let gap = spot.distance - ball.radius;
    let arm = ball.radius + gap * spot.share;
    let mut velocity = ball.velocity - spot.moving;
    let (mut pull, mut early, mut ease, mut across) = (Vec3::zeros(), Vec3::zeros(), 0.0, 0.0);
    let memory = field.memory;
    if K::FRICTION {
        let half = 0.5 * field.rule.advance;
        let distance = spot.before.norm();
        let (old, depth) = (spot.before / distance, distance - ball.radius);
        let lever = ball.radius + depth * spot.share;
        let (mine, spin) = memory.early(slot, ball, &field.spins[slot], half);
        let whole = mine - spot.moving + old.cross(&(spin * lever));
        early = whole - old * whole.dot(&old);
        velocity += normal.cross(&(field.spins[slot] * arm));
    }
    if K::DAMPING {
        let (mine, twist) = memory.past(slot);
        pull = mine;
        if K::DRAGS {
            pull += normal.cross(&(twist * arm));
        }
        ease = memory.along(slot, ball, &normal);
    }
    if K::DRAGS {
        let way = sliding(&velocity, &normal);
        across = memory.across(slot, ball, &(normal * -arm), &way);
    }
    (meeting(normal, gap, [velocity, early, pull], [ease, across]), arm)
}

/// A member of a clump near a plane, and its arm, m.
pub fn member_at_plane<K: Kind>(field: &Field<'_>, slot: usize, plane: usize) -> (Meeting, f64) {
    let (ball, plane) = (&field.balls[slot], &field.planes.now[plane]);
    let height = (ball.place - plane.point).dot(&plane.normal);
    let away = plane.normal * height;
    let moving = plane.motion.velocity(&(ball.place - away));
    let drift = (ball.velocity - moving).dot(&plane.normal);
    let spot = Spot {
        away,
        distance: height.abs(),
        before: plane.normal * (height - 0.5 * field.rule.advance * drift),
        moving,
        share: plane.share,
    };
    at_wall::<K>(field, slot, &spot)
}

/// Contacts of the sphere in `slot`, of the block that begins at `block`, with the triangles
/// near it, whose entries of the book begin at `base`.
pub fn on_faces<K: Kind>(
    field: &Field<'_>,
    (slot, base): (usize, usize),
    partners: &[u32],
    (block, book): (usize, &mut BookView<'_>),
    scratch: &mut Scratch,
    tally: &mut Tally,
) {
    let ball = &field.balls[slot];
    let mut hits = std::mem::take(&mut scratch.hits);
    find_hits(field, ball, partners, &mut hits);
    if K::FRICTION {
        if K::DAMPING {
            hand_over::<true>(field, partners, base, book, &mut hits);
        } else {
            hand_over::<false>(field, partners, base, book, &mut hits);
        }
    }
    for (at, (partner, hit)) in partners.iter().zip(hits.iter()).enumerate() {
        let k = base + at;
        if !hit.touches {
            if book.touching[k] {
                // Another face has taken over; its spring went with it or is lost.
                book.clear(k);
            }
            continue;
        }
        book.touching[k] |= hit.inherits;
        let number = field.setting.surfaces.wall[*partner as usize] as usize;
        let wall = &field.setting.model.walls[number];
        let motion = &field.setting.walls[number].motion;
        let away = ball.place - hit.point;
        let moving = motion.velocity(&hit.point);
        let mut before = away;
        if K::FRICTION {
            let place = ball.place - (ball.velocity - moving) * (0.5 * field.rule.advance);
            before = place - surface::closest(&place, &field.faces[*partner as usize]).0;
        }
        let share = field.setting.share;
        let spot = Spot { away, distance: away.norm(), before, moving, share };
        let (meeting, arm) = at_wall::<K>(field, slot, &spot);
        let law = field.setting.pair(ball.material, wall.material);
        let rule = (field.rule, field.setting.step);
        let Reply { normal, tangent } = advance::<K>(rule, law, &meeting, (book, k), tally);
        let unit = Vec3::from(meeting.normal);
        let force = unit * normal + tangent;
        let torque = if K::FRICTION { unit.cross(&tangent) * -arm } else { Vec3::zeros() };
        let Line(sums) = &mut scratch.pulls[slot - block];
        for axis in 0..3 {
            sums[axis] += force[axis];
            sums[axis + 4] += torque[axis];
        }
        tally.wall_power += force.dot(&moving);
    }
    scratch.hits = hits;
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
        let touches = window(gap - half, gap + half).2
            && surfaces.acts(face, feature)
            && !(feature == Feature::Face
                && partners[..at]
                    .iter()
                    .zip(hits.iter())
                    .any(|(other, hit)| hit.touches && surfaces.coplanar(*partner, *other)));
        hits.push(Hit { point, touches, inherits: false, bare: false });
    }
}
