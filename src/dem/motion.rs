//! From one force pass to the next.
//!
//! With F_n the loads at x_n, evaluated with the velocities v_{n−1/2}:
//! - `leapfrog`, `liggghts`, `lammps` (kick–drift–kick, Swope et al. 1982):
//!   v_n = v_{n−1/2} + Δt/2 F_n/m; v_{n+1/2} = v_n + Δt/2 F_n/m; x_{n+1} = x_n + Δt v_{n+1/2}.
//! - `yade` (leapfrog): v_{n+1/2} = v_{n−1/2} + Δt F_n/m; x_{n+1} = x_n + Δt v_{n+1/2}.
//!
//! Rotation the same with torque and moment of inertia; clumps see [`super::turn`].
//! Single spheres have no orientation: nothing depends on it. In `leapfrog` their kicks are fused (see
//! [`Setting::fused`]); clumps, whose motion is not what takes the time, are not.
//! O(N) a step; cannot fail.

use super::crew::Crew;
#[cfg(target_arch = "x86_64")]
use super::lanes::Four;
use super::lanes::{Line, Plain, Wide};
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
    let leap = Leap::new(setting, state, owed);
    let Leap { kick, owed, .. } = leap;
    margin.follow(setting, state, crew);
    state.step += 1;
    let mut far = walls_are_far(setting, state);
    if state.solids.len() < setting.model.bodies.len() {
        let fast = match margin.went.take() {
            Some(Went { fast }) => fast,
            None => move_alone(setting, state, crew, &leap, margin),
        };
        far |= margin.used_up(setting, state, crew, fast);
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
    }
    far | margin.members_used_up(setting, state)
}

/// Whether the walls have used up their leeway.
fn walls_are_far(setting: &Setting<'_>, state: &State) -> bool {
    let time = |step: u64| step as f64 * setting.step;
    setting.wall_travel(time(state.built_at), time(state.step)) > state.wall_leeway
}

/// How long balls cannot have used up their leeway, known from their speeds: so few steps look at
/// where each ball was when the lists were built.
#[derive(Debug, Default)]
pub struct Margin {
    /// Which lists.
    lists: u64,
    /// Farthest along each axis that each ball may go in a step to be counted without a look, m.
    pace: Vec<f32>,
    /// Steps without a look that are left while no ball is faster.
    left: u64,
    /// The same of the members of clumps.
    reins: Vec<Rein>,
    members_left: u64,
    /// The balls have moved on in the last force pass already.
    pub went: Option<Went>,
}

/// How fast a clump may be, to be counted without a look at its members.
#[derive(Debug, Clone, Copy)]
struct Rein {
    /// At most so far a member goes in a step for the largest component of the velocity, s, and of the angular momentum,
    /// s/(kg m). Axes are turned about one after the other, three times at most by the whole angle.
    gain: [f64; 2],
    /// Farthest that a member may go in a step, m.
    pace: f64,
}

impl Rein {
    /// At most so far a member of the clump has gone in the last step, m.
    fn way(&self, solid: &Solid) -> f64 {
        self.gain[0] * solid.velocity.amax() + self.gain[1] * solid.momentum.amax()
    }
}

/// A move of all balls.
#[derive(Debug, Clone, Copy, Default)]
pub struct Went {
    /// Whether one was faster than its pace.
    pub fast: bool,
}

impl Margin {
    /// A little more than √3: along all three axes.
    const ACROSS: f64 = 1.7321;
    /// How much faster than now balls may become until the next look.
    const FASTER: f64 = 1.5;
    /// Steps in which a ball at rest may use up its leeway without a look.
    const SOON: f64 = 64.0;
    /// A little less than 1, more than rounding makes of a way.
    const ROUNDING: f64 = 1.0 - 1e-6;

    /// Looks at the balls of new lists.
    pub fn follow(&mut self, setting: &Setting<'_>, state: &State, crew: &Crew) {
        if self.lists != state.rebuilds || self.pace.len() != state.balls.len() {
            self.lists = state.rebuilds;
            self.pace.resize(state.balls.len(), 0.0);
            self.look(setting, state, crew);
            self.look_at_members(setting, state);
        }
    }

    /// After a move: whether a member of a clump has used up its leeway.
    fn members_used_up(&mut self, setting: &Setting<'_>, state: &State) -> bool {
        let mut clumps = state.solids.iter().zip(&self.reins);
        // What is nowhere is not slow.
        let slow = clumps.all(|(solid, rein)| rein.way(solid) <= rein.pace);
        if self.members_left > 0 && slow {
            self.members_left -= 1;
            return false;
        }
        self.look_at_members(setting, state)
    }

    /// Looks how far members of clumps are from where they were when the lists were built, and how fast; true if one has
    /// used up its leeway.
    fn look_at_members(&mut self, setting: &Setting<'_>, state: &State) -> bool {
        let mut left = f64::INFINITY;
        self.reins.clear();
        for solid in &state.solids {
            let body = &setting.model.bodies[solid.body as usize];
            let members = body.first_sphere..body.first_sphere + body.sphere_count;
            let (mut reach, mut slack, mut leeway) = (0.0f64, f64::INFINITY, f64::INFINITY);
            for slot in members.map(|sphere| state.slot[sphere as usize] as usize) {
                let (place, own) = (&state.balls[slot].place, f64::from(state.leeway[slot]));
                let over = own - (place - state.built[slot]).norm();
                reach = reach.max((place - solid.place).norm());
                leeway = leeway.min(own);
                // What is nowhere is too far.
                slack = if over >= 0.0 { slack.min(over) } else { -1.0 };
                if slack < 0.0 {
                    break;
                }
            }
            let across = setting.step * Self::ACROSS;
            let gain = [across, 3.0 * across * reach / body.inertia.min()];
            let mut rein = Rein { gain, pace: leeway / Self::SOON };
            rein.pace = rein.pace.max(Self::FASTER * rein.way(solid));
            let ahead = Self::ROUNDING * slack / rein.pace;
            left = if slack >= 0.0 && ahead >= 0.0 { left.min(ahead) } else { -1.0 };
            self.reins.push(rein);
        }
        // Saturating cast.
        self.members_left = left as u64;
        left < 0.0
    }

    /// After a move: whether a ball has used up its leeway.
    fn used_up(&mut self, setting: &Setting<'_>, state: &State, crew: &Crew, fast: bool) -> bool {
        if self.left > 0 && !fast {
            self.left -= 1;
            return false;
        }
        self.look(setting, state, crew)
    }

    /// Farthest along each axis that each ball may go in a step to be counted without a look, m.
    pub fn paces(&self) -> &[f32] {
        &self.pace
    }

    /// Looks how far balls are from where they were when the lists were built, and how fast; true if one has used up its
    /// leeway.
    fn look(&mut self, setting: &Setting<'_>, state: &State, crew: &Crew) -> bool {
        let flocks = self.pace.chunks_mut(FLOCK).enumerate();
        let mut flocks: Vec<_> = flocks.map(|(number, pace)| (number, pace, 0.0)).collect();
        crew.share(&mut flocks, &mut vec![(); crew.size()], |(number, pace, left), ()| {
            *left = look(setting, state, *number * FLOCK, pace);
        });
        let left = flocks.iter().map(|(.., left)| *left).fold(f64::INFINITY, f64::min);
        // Saturating cast.
        self.left = left as u64;
        left < 0.0
    }
}

/// [`Margin::look`] at the balls from `first`: sets their paces; steps that are left, below 0 if one is too far.
fn look(setting: &Setting<'_>, state: &State, first: usize, paces: &mut [f32]) -> f64 {
    let mut left = f64::INFINITY;
    for (at, pace) in paces.iter_mut().enumerate() {
        let (ball, leeway) = (&state.balls[first + at], f64::from(state.leeway[first + at]));
        if !ball.alone {
            continue;
        }
        let way = ball.place - state.built[first + at];
        let own = Margin::FASTER * setting.step * ball.velocity.amax();
        *pace = own.max(leeway / (Margin::ACROSS * Margin::SOON)) as f32;
        let ahead = Margin::ROUNDING * (leeway - way.norm()) / (Margin::ACROSS * f64::from(*pace));
        // What is nowhere is too far.
        left = if ahead >= 0.0 { ahead.min(left) } else { -1.0 };
        if left < 0.0 {
            break;
        }
    }
    left
}

/// How balls that are bodies by themselves go on.
pub struct Leap {
    /// Time of a kick, s.
    kick: f64,
    /// Whether to kick twice.
    owed: bool,
    /// Whether there are balls that are not bodies by themselves, or not yet there.
    mixed: bool,
}

impl Leap {
    /// From the present step to the next. `owed`: see [`advance`].
    pub fn new(setting: &Setting<'_>, state: &State, owed: bool) -> Self {
        let yade = setting.scheme == Scheme::Yade;
        Self {
            kick: if yade { setting.step } else { 0.5 * setting.step },
            owed: owed && !yade,
            mixed: !state.solids.is_empty() || !setting.model.arrivals.is_empty(),
        }
    }
}

/// Force and torque on a ball, as the pass leaves them.
pub trait Pull {
    /// Force, N, and a 0.
    fn force<L: Wide<4>>(&self) -> L;
    /// Torque, N m, and a 0.
    fn torque<L: Wide<4>>(&self) -> L;
}

impl Pull for Load {
    #[inline(always)]
    fn force<L: Wide<4>>(&self) -> L {
        L::three(&self.force)
    }
    #[inline(always)]
    fn torque<L: Wide<4>>(&self) -> L {
        L::three(&self.torque)
    }
}

impl Pull for Line {
    #[inline(always)]
    fn force<L: Wide<4>>(&self) -> L {
        let [x, y, z, none, ..] = self.0;
        L::load(&[x, y, z, none])
    }
    #[inline(always)]
    fn torque<L: Wide<4>>(&self) -> L {
        let [.., x, y, z, none] = self.0;
        L::load(&[x, y, z, none])
    }
}

/// Some balls with what belongs to them.
pub struct Flock<'a, P> {
    /// Balls.
    pub balls: &'a mut [Ball],
    /// Empty if nothing turns.
    pub spins: &'a mut [Vec3],
    /// What acts on them.
    pub pulls: &'a [P],
    /// Number of the first.
    pub first: usize,
    /// See [`Margin`], m.
    pub pace: &'a [f32],
}

/// Spheres that a thread moves at a time.
const FLOCK: usize = 1024;

/// Kicks and moves the balls that are bodies by themselves; true if one was faster than its pace.
fn move_alone(
    setting: &Setting<'_>,
    state: &mut State,
    crew: &Crew,
    leap: &Leap,
    margin: &Margin,
) -> bool {
    // Without rotation no chunks: every flock gets none.
    let mut spins = state.spins.chunks_mut(FLOCK);
    let lights = &state.light;
    let mut flocks: Vec<(Flock<'_, Load>, bool)> = state
        .balls
        .chunks_mut(FLOCK)
        .zip(state.loads.chunks(FLOCK).zip(margin.pace.chunks(FLOCK)))
        .enumerate()
        .map(|(number, (balls, (pulls, pace)))| {
            let spins = spins.next().unwrap_or_default();
            (Flock { balls, spins, pulls, first: number * FLOCK, pace }, false)
        })
        .collect();
    crew.share(&mut flocks, &mut vec![(); crew.size()], |(flock, fast), ()| {
        *fast = !go(setting, lights, flock, leap);
    });
    flocks.iter().any(|(_, fast)| *fast)
}

/// [`go_by`] with the lanes that this processor has.
pub fn go<P: Pull>(
    setting: &Setting<'_>,
    lights: &Lights,
    flock: &mut Flock<'_, P>,
    leap: &Leap,
) -> bool {
    if setting.fused {
        return go_with::<true, P>(setting, lights, flock, leap);
    }
    go_with::<false, P>(setting, lights, flock, leap)
}

/// [`go`] with fused lanes or others.
fn go_with<const FUSED: bool, P: Pull>(
    setting: &Setting<'_>,
    lights: &Lights,
    flock: &mut Flock<'_, P>,
    leap: &Leap,
) -> bool {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        #[target_feature(enable = "avx2,fma")]
        fn with_avx2<const FUSED: bool, P: Pull>(
            setting: &Setting<'_>,
            lights: &Lights,
            flock: &mut Flock<'_, P>,
            leap: &Leap,
        ) -> bool {
            go_by::<Four<FUSED>, P>(setting, lights, flock, leap)
        }
        // SAFETY: the processor has what the function asks for.
        return unsafe { with_avx2::<FUSED, P>(setting, lights, flock, leap) };
    }
    go_by::<Plain<FUSED>, P>(setting, lights, flock, leap)
}

/// Kicks and moves the balls that are bodies by themselves, the three numbers of a vector side by side. True
/// if none was faster than the pace.
#[inline(always)]
fn go_by<L: Wide<4>, P: Pull>(
    setting: &Setting<'_>,
    lights: &Lights,
    flock: &mut Flock<'_, P>,
    leap: &Leap,
) -> bool {
    if leap.mixed {
        return by_light::<L, P, true>(setting, lights, flock, leap);
    }
    by_light::<L, P, false>(setting, lights, flock, leap)
}

/// [`go_by`] where some balls may not be bodies by themselves, or all are.
#[inline(always)]
fn by_light<L: Wide<4>, P: Pull, const MIXED: bool>(
    setting: &Setting<'_>,
    lights: &Lights,
    flock: &mut Flock<'_, P>,
    leap: &Leap,
) -> bool {
    let first = flock.first;
    let own = |at: usize| lights.at(first + at);
    match (lights.same(), leap.owed) {
        (Some(light), true) => each::<L, P, MIXED, true>(setting, |_| light, flock, leap),
        (Some(light), false) => each::<L, P, MIXED, false>(setting, |_| light, flock, leap),
        (None, true) => each::<L, P, MIXED, true>(setting, own, flock, leap),
        (None, false) => each::<L, P, MIXED, false>(setting, own, flock, leap),
    }
}

/// [`go_by`] with one kick or two.
#[inline(always)]
fn each<L: Wide<4>, P: Pull, const MIXED: bool, const OWED: bool>(
    setting: &Setting<'_>,
    light: impl Fn(usize) -> Lightness,
    flock: &mut Flock<'_, P>,
    leap: &Leap,
) -> bool {
    let (gravity, step, kick) =
        (L::three(&setting.gravity), L::splat(setting.step), L::splat(leap.kick));
    let kicked = |motion: &Vec3, rate: L, time: L| {
        let mut motion = L::three(motion);
        if OWED {
            motion = motion.plus_product(rate, time);
        }
        motion.plus_product(rate, time)
    };
    let mut slow = L::all(true);
    let pulls = flock.pulls.iter().zip(flock.pace);
    for (at, (ball, (pull, pace))) in flock.balls.iter_mut().zip(pulls).enumerate() {
        if MIXED && !ball.alone {
            continue;
        }
        let pace = L::splat(f64::from(*pace));
        let rate = gravity.plus_product(pull.force::<L>(), L::splat(light(at).mass));
        let velocity = kicked(&ball.velocity, rate, kick);
        let way = velocity * step;
        let place = L::three(&ball.place) + way;
        velocity.keep_three(&mut ball.velocity);
        place.keep_three(&mut ball.place);
        slow = L::both(slow, way.abs().at_most(pace));
    }
    for (at, (spin, pull)) in flock.spins.iter_mut().zip(flock.pulls).enumerate() {
        let time = L::splat(light(at).inertia * leap.kick);
        kicked(spin, pull.torque::<L>(), time).keep_three(spin);
    }
    L::bits(slow) == 0b1111
}

/// To the bit the kick that [`go`] gives where it is `owed`.
fn kick_alone(setting: &Setting<'_>, state: &mut State, span: f64) {
    let gravity = &setting.gravity;
    for (slot, (ball, load)) in state.balls.iter_mut().zip(&state.loads).enumerate() {
        if ball.alone {
            let rate = plus_product(setting, gravity, &load.force, state.light.at(slot).mass);
            ball.velocity = plus_product(setting, &ball.velocity, &rate, span);
        }
    }
    kick_spins(setting, state, span);
}

fn kick_spins(setting: &Setting<'_>, state: &mut State, span: f64) {
    if setting.needs.rotation {
        for (slot, (spin, load)) in state.spins.iter_mut().zip(&state.loads).enumerate() {
            let time = state.light.at(slot).inertia * span;
            *spin = plus_product(setting, spin, &load.torque, time);
        }
    }
}

/// `sum + vector × by`, rounded once where the scheme is fused.
fn plus_product(setting: &Setting<'_>, sum: &Vec3, vector: &Vec3, by: f64) -> Vec3 {
    if setting.fused {
        return sum.zip_map(vector, |sum, part| part.mul_add(by, sum));
    }
    sum + vector * by
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
