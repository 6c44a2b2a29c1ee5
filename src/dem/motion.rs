//! From one force pass to the next.
//!
//! With F_n the loads at x_n, evaluated with the velocities v_{n−1/2}:
//! - `leapfrog`, `liggghts`, `lammps` (kick–drift–kick, Swope et al. 1982):
//!   v_n = v_{n−1/2} + Δt/2 F_n/m; v_{n+1/2} = v_n + Δt/2 F_n/m; x_{n+1} = x_n + Δt v_{n+1/2}.
//! - `yade` (leapfrog): v_{n+1/2} = v_{n−1/2} + Δt F_n/m; x_{n+1} = x_n + Δt v_{n+1/2}.
//!
//! Rotation the same with torque and moment of inertia; clumps see [`super::turn`].
//! Single spheres have no orientation: nothing depends on it.
//! O(N) a step; cannot fail.

use super::crew::Crew;
#[cfg(target_arch = "x86_64")]
use super::lanes::Four;
use super::lanes::{Plain, Wide};
use super::setting::Setting;
use super::state::{Ball, Lightness, Lights, Load, Solid, State};
use super::turn;
use crate::model::Scheme;
use crate::num::Vec3;

/// Second half kick of kick–drift–kick schemes; nothing for YADE's.
pub fn finish(setting: &Setting<'_>, state: &mut State) {
    if setting.scheme == Scheme::Yade {
        return;
    }
    kick_alone(setting, state, 0.5 * setting.step);
    kick_solids(setting, state, 0.5 * setting.step);
    for solid in &mut state.solids {
        let inertia = &setting.model.bodies[solid.body as usize].inertia;
        solid.spin = turn::spin(&solid.turn, inertia, &solid.momentum);
    }
    for index in 0..state.solids.len() {
        state.pace_members(setting, index);
    }
}

/// Kick and drift to the place of the next force pass; before that the second half kick of
/// the last step, if it is `owed`. True if some sphere has moved so far that the lists are no
/// longer valid (or is nowhere).
pub fn advance(
    setting: &Setting<'_>,
    state: &mut State,
    (crew, margin): (&Crew, &mut Margin),
    owed: bool,
) -> bool {
    let step = setting.step;
    let kick = if setting.scheme == Scheme::Yade { step } else { 0.5 * step };
    margin.follow(state);
    state.step += 1;
    let room = room(setting, state);
    let owed = owed && setting.scheme != Scheme::Yade;
    let square = room * room;
    let mut far = false;
    if state.solids.len() < setting.model.bodies.len() {
        let mixed = !state.solids.is_empty() || !setting.model.arrivals.is_empty();
        let leap = Leap { kick, owed, mixed, pace: margin.pace, square };
        far = move_alone(setting, state, crew, &leap, (margin, room));
    }
    if owed {
        kick_solids(setting, state, kick);
    }
    match setting.scheme {
        Scheme::Yade => (0..state.solids.len()).for_each(|at| move_as_yade(setting, state, at)),
        scheme => {
            kick_solids(setting, state, kick);
            drift_solids(setting, &mut state.solids, scheme);
        }
    }
    for index in 0..state.solids.len() {
        state.carry_members(setting, index);
        let body = &setting.model.bodies[state.solids[index].body as usize];
        let members = body.first_sphere..body.first_sphere + body.sphere_count;
        far |= members
            .map(|sphere| state.slot[sphere as usize] as usize)
            .any(|slot| !within(&(state.balls[slot].place - state.built[slot]), square));
    }
    far || room <= 0.0
}

/// How far a sphere may move before the lists can miss a contact, m; 0 or less
/// if walls alone have used up the skin.
fn room(setting: &Setting<'_>, state: &State) -> f64 {
    let time = |step: u64| step as f64 * setting.step;
    let travel = setting.wall_travel(time(state.built_at), time(state.step));
    (0.5 * state.skin).min(state.skin - travel)
}

/// How far balls can have gone since the lists were built, known from their speeds: so few steps look at
/// where each ball was then.
#[derive(Debug, Default)]
pub struct Margin {
    /// Which lists.
    lists: u64,
    /// No ball is farther from where it was, m.
    gone: f64,
    /// Farthest along each axis that a ball may go in a step to be counted without a look, m.
    pace: f64,
}

impl Margin {
    /// A little more than √3: along all three axes.
    const ACROSS: f64 = 1.7321;
    /// How much faster than now balls may become until the next look.
    const FASTER: f64 = 1.5;
    /// More than rounding makes of a way.
    const ROUNDING: f64 = 1e-6;

    /// Of new lists nothing is known but at the step they were built in.
    fn follow(&mut self, state: &State) {
        if self.lists != state.rebuilds {
            self.lists = state.rebuilds;
            self.gone = if state.step == state.built_at { 0.0 } else { f64::INFINITY };
        }
    }

    /// Counts a step in which no ball went farther than `pace`; false if then one can be out of its `room`, m.
    fn allows(&mut self, room: f64) -> bool {
        let ahead = self.gone + Self::ACROSS * self.pace;
        let allows = ahead * (1.0 + Self::ROUNDING) <= room;
        if allows {
            self.gone = ahead;
        }
        allows
    }
}

/// False for NaN as well.
fn within(way: &Vec3, square: f64) -> bool {
    way.norm_squared() <= square
}

/// How balls that are bodies by themselves go on.
struct Leap {
    /// Time of a kick, s.
    kick: f64,
    /// Whether to kick twice.
    owed: bool,
    /// Whether there are balls that are not bodies by themselves, or not yet there.
    mixed: bool,
    /// See [`Margin`], m.
    pace: f64,
    /// Square of the distance from the place of the last build that is allowed, m².
    square: f64,
}

/// Some balls with what belongs to them.
struct Flock<'a> {
    balls: &'a mut [Ball],
    /// Empty if nothing turns.
    spins: &'a mut [Vec3],
    loads: &'a [Load],
    /// Number of the first.
    first: usize,
    built: &'a [Vec3],
    /// Whether one was faster than the pace.
    fast: bool,
    seen: Seen,
}

/// What a look at a flock finds.
#[derive(Debug, Default)]
struct Seen {
    /// Whether one went too far.
    far: bool,
    /// Square of the farthest way from where a ball was when the lists were built, m².
    square: f64,
    /// Largest component of a velocity, m/s.
    speed: f64,
}

/// Spheres that a thread moves at a time.
const FLOCK: usize = 1024;

/// Kicks and moves the balls that are bodies by themselves; true if one went too far.
fn move_alone(
    setting: &Setting<'_>,
    state: &mut State,
    crew: &Crew,
    leap: &Leap,
    (margin, room): (&mut Margin, f64),
) -> bool {
    // Without rotation no chunks: every flock gets none.
    let mut spins = state.spins.chunks_mut(FLOCK);
    let lights = &state.light;
    let mut flocks: Vec<Flock<'_>> = state
        .balls
        .chunks_mut(FLOCK)
        .zip(state.loads.chunks(FLOCK).zip(state.built.chunks(FLOCK)))
        .enumerate()
        .map(|(number, (balls, (loads, built)))| {
            let spins = spins.next().unwrap_or_default();
            let first = number * FLOCK;
            Flock { balls, spins, loads, first, built, fast: false, seen: Seen::default() }
        })
        .collect();
    let nobody = &mut vec![(); crew.size()];
    crew.share(&mut flocks, nobody, |flock, ()| {
        flock.fast = !go(setting, lights, flock, leap);
    });
    if flocks.iter().all(|flock| !flock.fast) && margin.allows(room) {
        return false;
    }
    crew.share(&mut flocks, nobody, |flock, ()| flock.seen = look(flock, leap));
    let most =
        |of: fn(&Seen) -> f64| flocks.iter().map(|flock| of(&flock.seen)).fold(0.0, f64::max);
    margin.gone = most(|seen| seen.square).sqrt();
    margin.pace = Margin::FASTER * setting.step * most(|seen| seen.speed);
    flocks.iter().any(|flock| flock.seen.far)
}

/// Looks where the balls of a flock are.
fn look(flock: &Flock<'_>, leap: &Leap) -> Seen {
    let mut seen = Seen::default();
    for (ball, built) in flock.balls.iter().zip(flock.built).filter(|(ball, _)| ball.alone) {
        let way = ball.place - built;
        seen.far |= !within(&way, leap.square);
        seen.square = seen.square.max(way.norm_squared());
        seen.speed = seen.speed.max(ball.velocity.amax());
    }
    seen
}

/// [`go_by`] with the lanes that this processor has.
fn go(setting: &Setting<'_>, lights: &Lights, flock: &mut Flock<'_>, leap: &Leap) -> bool {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        #[target_feature(enable = "avx2")]
        fn with_avx2(
            setting: &Setting<'_>,
            lights: &Lights,
            flock: &mut Flock<'_>,
            leap: &Leap,
        ) -> bool {
            go_by::<Four>(setting, lights, flock, leap)
        }
        // SAFETY: the processor has what the function asks for.
        return unsafe { with_avx2(setting, lights, flock, leap) };
    }
    go_by::<Plain>(setting, lights, flock, leap)
}

/// Kicks and moves the balls that are bodies by themselves, the three numbers of a vector side by side. True
/// if none was faster than the pace.
#[inline(always)]
fn go_by<L: Wide<4>>(
    setting: &Setting<'_>,
    lights: &Lights,
    flock: &mut Flock<'_>,
    leap: &Leap,
) -> bool {
    if leap.mixed {
        return by_light::<L, true>(setting, lights, flock, leap);
    }
    by_light::<L, false>(setting, lights, flock, leap)
}

/// [`go_by`] where some balls may not be bodies by themselves, or all are.
#[inline(always)]
fn by_light<L: Wide<4>, const MIXED: bool>(
    setting: &Setting<'_>,
    lights: &Lights,
    flock: &mut Flock<'_>,
    leap: &Leap,
) -> bool {
    let first = flock.first;
    let own = |at: usize| lights.at(first + at);
    match (lights.same(), leap.owed) {
        (Some(light), true) => each::<L, MIXED, true>(setting, |_| light, flock, leap),
        (Some(light), false) => each::<L, MIXED, false>(setting, |_| light, flock, leap),
        (None, true) => each::<L, MIXED, true>(setting, own, flock, leap),
        (None, false) => each::<L, MIXED, false>(setting, own, flock, leap),
    }
}

/// [`go_by`] with one kick or two.
#[inline(always)]
fn each<L: Wide<4>, const MIXED: bool, const OWED: bool>(
    setting: &Setting<'_>,
    light: impl Fn(usize) -> Lightness,
    flock: &mut Flock<'_>,
    leap: &Leap,
) -> bool {
    let (gravity, step, kick) =
        (L::three(&setting.gravity), L::splat(setting.step), L::splat(leap.kick));
    let pace = L::splat(leap.pace);
    let kicked = |motion: &Vec3, gain: L| {
        let motion = if OWED { L::three(motion) + gain } else { L::three(motion) };
        motion + gain
    };
    let mut slow = L::all(true);
    for (at, (ball, load)) in flock.balls.iter_mut().zip(flock.loads).enumerate() {
        if MIXED && !ball.alone {
            continue;
        }
        let gain = (L::three(&load.force) * L::splat(light(at).mass) + gravity) * kick;
        let velocity = kicked(&ball.velocity, gain);
        let way = velocity * step;
        let place = L::three(&ball.place) + way;
        velocity.keep_three(&mut ball.velocity);
        place.keep_three(&mut ball.place);
        slow = L::both(slow, way.abs().at_most(pace));
    }
    for (at, (spin, load)) in flock.spins.iter_mut().zip(flock.loads).enumerate() {
        let gain = L::three(&load.torque) * L::splat(light(at).inertia * leap.kick);
        kicked(spin, gain).keep_three(spin);
    }
    L::bits(slow) == 0b1111
}

fn kick_alone(setting: &Setting<'_>, state: &mut State, span: f64) {
    let gravity = setting.gravity;
    for (slot, (ball, load)) in state.balls.iter_mut().zip(&state.loads).enumerate() {
        if ball.alone {
            ball.velocity += (load.force * state.light.at(slot).mass + gravity) * span;
        }
    }
    kick_spins(setting, state, span);
}

fn kick_spins(setting: &Setting<'_>, state: &mut State, span: f64) {
    if setting.needs.rotation {
        for (slot, (spin, load)) in state.spins.iter_mut().zip(&state.loads).enumerate() {
            *spin += load.torque * (state.light.at(slot).inertia * span);
        }
    }
}

/// Kicks momenta; spins are for whoever needs them.
fn kick_solids(setting: &Setting<'_>, state: &mut State, span: f64) {
    for solid in &mut state.solids {
        let body = &setting.model.bodies[solid.body as usize];
        solid.velocity += (solid.load.force / body.mass + setting.gravity) * span;
        solid.momentum += solid.load.torque * span;
    }
}

/// Moves and turns all solids.
fn drift_solids(setting: &Setting<'_>, solids: &mut [Solid], scheme: Scheme) {
    let step = setting.step;
    for solid in solids.iter_mut() {
        solid.place += solid.velocity * step;
        if scheme.is_richardson() {
            let inertia = &setting.model.bodies[solid.body as usize].inertia;
            (solid.turn, solid.spin) =
                turn::richardson(&solid.turn, inertia, &solid.momentum, step);
        }
    }
    if !scheme.is_richardson() {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            #[target_feature(enable = "avx2")]
            fn with_avx2(setting: &Setting<'_>, solids: &mut [Solid]) {
                turn_solids::<Four>(setting, solids);
            }
            // SAFETY: the processor has what the function asks for.
            return unsafe { with_avx2(setting, solids) };
        }
        turn_solids::<Plain>(setting, solids);
    }
}

/// Turns all solids, four at a time; the last group is filled up with its last.
#[inline(always)]
fn turn_solids<L: Wide<4>>(setting: &Setting<'_>, solids: &mut [Solid]) {
    for group in solids.chunks_mut(4) {
        let last = group.len() - 1;
        let at = [0, 1.min(last), 2.min(last), last];
        let (turns, worlds) = (at.map(|l| &group[l].turn), at.map(|l| &group[l].momentum));
        let inertias = at.map(|l| &setting.model.bodies[group[l].body as usize].inertia);
        let (turns, spins) = turn::split_four::<L>(turns, inertias, worlds, setting.step);
        for (solid, (turn, spin)) in group.iter_mut().zip(turns.into_iter().zip(spins)) {
            (solid.turn, solid.spin) = (turn, spin);
        }
    }
}

fn move_as_yade(setting: &Setting<'_>, state: &mut State, index: usize) {
    let step = setting.step;
    let solid = &mut state.solids[index];
    let body = &setting.model.bodies[solid.body as usize];
    solid.velocity += (solid.load.force / body.mass + setting.gravity) * step;
    solid.place += solid.velocity * step;
    if setting.planar {
        // A body with blocked rotations: angular velocity about z, plain rotation vector.
        let inertia = turn::momentum(&solid.turn, &body.inertia, &Vec3::z()).z;
        solid.spin.z += step * solid.load.torque.z / inertia;
        solid.turn = crate::num::Rotation::from_scaled_axis(solid.spin * step) * solid.turn;
        solid.momentum = Vec3::z() * (inertia * solid.spin.z);
    } else {
        (solid.turn, solid.momentum, solid.spin) =
            turn::yade(&solid.turn, &body.inertia, &solid.momentum, &solid.load.torque, step);
    }
}

/// Applies local damping to the loads of the present pass; returns its power, W.
/// YADE's rule: a ← a (1 − α sign(a (v + a Δt/2))) per axis for velocities and
/// single spheres' spins, M ← M (1 − α sign(M ω)) for torques on clumps.
pub fn damp(setting: &Setting<'_>, state: &mut State, first: bool) -> f64 {
    let alpha = setting.model.local_damping;
    if alpha == 0.0 {
        return 0.0;
    }
    let half = 0.5 * setting.step;
    // At the first pass kick–drift–kick velocities stand at the time of the pass.
    let ahead = if first && setting.scheme != Scheme::Yade { 0.0 } else { half };
    let brake = |pull: &Vec3, velocity: &Vec3| {
        pull.zip_map(velocity, |a, v| a * (1.0 - alpha * sign(a * (v + half * a))))
    };
    let mut power = 0.0;
    for slot in 0..state.balls.len() {
        let (ball, light) = (&state.balls[slot], state.light.at(slot));
        if !ball.alone {
            continue;
        }
        let load = &mut state.loads[slot];
        let pull = load.force * light.mass + setting.gravity;
        let slow = brake(&pull, &ball.velocity);
        let velocity = ball.velocity + slow * ahead;
        power += (pull - slow).dot(&velocity) / light.mass;
        load.force += (slow - pull) / light.mass;
        if setting.needs.friction {
            let spin = state.spins[slot];
            let pull = load.torque * light.inertia;
            let slow = brake(&pull, &spin);
            power += (pull - slow).dot(&(spin + slow * ahead)) / light.inertia;
            load.torque = slow / light.inertia;
        }
    }
    for solid in &mut state.solids {
        let body = &setting.model.bodies[solid.body as usize];
        let pull = solid.load.force / body.mass + setting.gravity;
        let slow = brake(&pull, &solid.velocity);
        power += (pull - slow).dot(&(solid.velocity + slow * ahead)) * body.mass;
        solid.load.force += (slow - pull) * body.mass;
        let torque = solid.load.torque;
        let braked = torque.zip_map(&solid.spin, |m, w| m * (1.0 - alpha * sign(m * w)));
        power += (torque - braked).dot(&solid.spin);
        solid.load.torque = braked;
    }
    power
}

fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}
