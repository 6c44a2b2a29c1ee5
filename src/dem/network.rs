//! The largest stable step of the contacts that are present.
//!
//! Small motions about a state obey q̈ = −K q − C q̇ with q scaled by √m and √I, and
//! K = Σ k u uᵀ, C = Σ c u uᵀ over contacts and over the normal and two tangents d,
//! u = (d/√m, (r × d)/√I; −d/√m', −(r' × d)/√I'). With dashpots that see the velocity of
//! half a step before, x_{n+1} − 2 x_n + x_{n−1} = −Δt² K x_n − Δt C (x_n − x_{n−1}): all
//! roots z of a mode lie within the unit circle if and only if
//!     λ_max(Δt² K + 2 Δt C) < 4,
//! for any mixture of dashpots (the first root to leave does so at z = −1). Without
//! dashpots this is Δt < 2/√λ_max(K). For `path_averaged`, z = −1 is reached at
//! λ_max(Σ u uᵀ (Δt² k + 4 Δt c)/(1 + Δt c |u|²)) = 4. Both are written with an effective stiffness
//! k(Δt) = k + 2 c/Δt, or (k + 4 c/Δt)/(1 + Δt c |u|²), which falls with Δt, so that
//! Δt' = 2/√λ(k(Δt)) from a stable Δt is stable too and not smaller. Local damping α
//! scales k by at most 1 + α, contacts with servo walls are 4/3 as stiff (see [`super::servo`]). All tangential springs are taken to stick.
//!
//! λ_max is bounded from above, so the step from below, in three stages:
//! - trace: λ ≤ max_i Σ w k |a|² over the contacts of body i, where u = (a; b) and w =
//!   1 + |b|/|a| (1 at walls), since (x·a + y·b)² ≤ (1 + θ)(x·a)² + (1 + 1/θ)(y·b)²;
//! - block: λ ≤ max_i λ_max(Σ w k a aᵀ), 6 × 6. Rigorous; 0.8 to 1.0 of the limit in
//!   beds and lattices, any size ratio;
//! - Lanczos: k steps from a random start leave θ ≥ (1 − ε) λ_max but for a probability of
//!   1.648 √n exp(−√ε (2k − 1)) (Kuczyński & Woźniakowski 1992, SIAM J. Matrix Anal.
//!   Appl. 13, 1094, theorem 4.2); k is chosen for ε = 0.09 and 10⁻⁹, so 42 to 50 steps, and
//!   θ/0.91 is used: 0.95 of the limit, 0.9 where dashpots rule. Exact for small networks.
//!
//! Cost: trace O(contacts), about a tenth of a force pass for equal spheres, whose contacts are counted
//! only; block O(contacts + bodies) with a 6 × 6 eigenvalue problem for bodies that
//! (Σ λ⁸)^⅛ ≥ λ does not show to be below the largest so far; Lanczos about 45 passes. Later
//! stages run only where, and for the bodies that, the earlier cannot clear.

use super::bond_limit;
use super::lanczos::Chords;
use super::neighbours;
use super::servo;
use super::setting::Setting;
use super::state::{Ball, List, State, is_alone};
use super::surface;
use crate::model::{Body, Contact, Scheme, Wall};
use crate::num::{Rotation, Vec3};
use nalgebra::{Matrix6, SymmetricEigen, Vector6};
use std::cell::Cell;

/// Least number of bodies whose blocks are held at a time (288 bytes each).
const CHUNK: usize = 1 << 15;
/// Most passes over the contacts to make all blocks.
const PASSES: usize = 4;
/// More than rounding makes of a distance or a trace, relative.
const ROUNDING: f64 = 1e-9;

/// A bound and the body it comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Largest step known to be stable, s.
    pub step: f64,
    /// Index of the body.
    pub body: u32,
}

/// A contact and how deep it is.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Deepest {
    /// Index of the body, and of the other; `None` at walls.
    pub bodies: (u32, Option<u32>),
    /// Overlap over the smaller radius.
    pub depth: f64,
}

impl std::fmt::Display for Deepest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "body {} overlaps ", self.bodies.0)?;
        match self.bodies.1 {
            Some(other) => write!(f, "body {other}")?,
            None => write!(f, "a wall")?,
        }
        write!(f, " by {:.3} of the smaller radius", self.depth)
    }
}

/// A contact as its bodies feel it.
#[derive(Debug, Clone, Copy)]
pub struct Link<'a> {
    /// Index of the body, and of the other; `None` at walls.
    pub bodies: (u32, Option<u32>),
    /// Unit normal.
    pub normal: Vec3,
    /// From the centres of mass to the contact, m.
    pub arms: [Vec3; 2],
    /// Stiffnesses and dashpots.
    pub law: &'a Contact,
    /// Overlap over the smaller radius.
    pub depth: f64,
    /// How much stiffer it is for the motion of its wall.
    pub stiffer: f64,
}

/// One direction of a contact in scaled coordinates.
#[derive(Debug, Clone, Copy)]
pub struct Strand {
    /// Part of the first body.
    pub mine: Vector6<f64>,
    /// Part of the other; zeros at walls.
    pub other: Vector6<f64>,
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Dashpot, N s/m.
    pub dashpot: f64,
}

/// How a scheme turns stiffness and dashpot into the effective stiffness of a step.
#[derive(Debug, Clone, Copy)]
pub struct Stepping {
    implicit: bool,
    amplified: f64,
}

impl Stepping {
    /// That of a run.
    pub fn of(setting: &Setting<'_>) -> Self {
        Self {
            implicit: setting.scheme == Scheme::PathAveraged,
            amplified: 1.0 + setting.model.local_damping,
        }
    }

    /// k(Δt); `step` may be infinite for k alone.
    pub fn effective(&self, strand: &Strand, step: f64) -> f64 {
        let ease = || strand.mine.norm_squared() + strand.other.norm_squared();
        self.stiffness(strand.stiffness, strand.dashpot, ease, step)
    }

    /// The same for stiffness k, dashpot c and |u|².
    #[inline(always)]
    fn stiffness(&self, k: f64, c: f64, ease: impl Fn() -> f64, step: f64) -> f64 {
        let value = match self.implicit {
            _ if c == 0.0 || step.is_infinite() => k,
            true => (k + 4.0 * c / step) / (1.0 + step * c * ease()),
            false => k + 2.0 * c / step,
        };
        value * self.amplified
    }

    /// The largest stable step, given λ(Δt) that bounds the eigenvalue from above at the
    /// effective stiffness of Δt, and the largest c/k, s.
    pub fn largest(&self, delay: f64, top: impl Fn(f64) -> f64) -> f64 {
        let free = 2.0 / top(f64::INFINITY).sqrt();
        if delay == 0.0 {
            return free;
        }
        let delay = if self.implicit { 2.0 * delay } else { delay };
        let mut step = if delay.is_finite() {
            // free²/(√(delay² + free²) + delay) without loss of digits.
            free * free / (delay.hypot(free) + delay)
        } else {
            free.min(1.0)
        };
        while step > 0.0 && step * step * top(step) > 4.0 * (1.0 + 1e-12) {
            step *= 1e-2;
        }
        // The distance from the limit halves at least, as a ratio.
        for _ in 0..20 {
            let next = 2.0 / top(step).sqrt();
            if next <= step * 1.002 {
                break;
            }
            step = next;
        }
        step
    }
}

/// Scaled motion of a body along `direction` at `arm` from its centre of mass.
fn along(body: &Body, turn: &Rotation, arm: &Vec3, direction: &Vec3, planar: bool) -> Vector6<f64> {
    let lever = arm.cross(direction);
    let mut push = direction / body.mass.sqrt();
    let mut twist =
        turn.inverse_transform_vector(&lever).component_div(&body.inertia.map(f64::sqrt));
    if planar {
        push.z = 0.0;
        twist = Vec3::z() * (lever.z / body.inertia.z.sqrt());
    }
    Vector6::new(push.x, push.y, push.z, twist.x, twist.y, twist.z)
}

/// The three directions of a contact.
pub fn strands(
    (body, turn): (&Body, &Rotation),
    other: Option<(&Body, &Rotation)>,
    link: &Link<'_>,
    planar: bool,
) -> [Strand; 3] {
    let n = link.normal;
    let side = n.cross(&if n.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() }).normalize();
    let law = link.law;
    let (kt, ct) = if law.friction > 0.0 { (law.kt, law.ct) } else { (0.0, 0.0) };
    [(n, law.kn, law.cn), (side, kt, ct), (n.cross(&side), kt, ct)].map(
        |(direction, stiffness, dashpot)| Strand {
            mine: along(body, turn, &link.arms[0], &direction, planar),
            other: other.map_or(Vector6::zeros(), |(body, turn)| {
                -along(body, turn, &link.arms[1], &direction, planar)
            }),
            stiffness: stiffness * link.stiffer,
            dashpot: dashpot * link.stiffer,
        },
    )
}

/// Weights with which both bodies of a strand take it alone.
fn weights(strand: &Strand) -> [f64; 2] {
    let (a, b) = (strand.mine.norm(), strand.other.norm());
    if a == 0.0 || b == 0.0 { [1.0, 1.0] } else { [1.0 + b / a, 1.0 + a / b] }
}

/// The contacts (overlap not negative) that the lists of a state hold.
pub struct Network<'a> {
    setting: &'a Setting<'a>,
    state: &'a State,
    /// Time of the places in the state, s.
    time: f64,
    stepping: Stepping,
}

impl<'a> Network<'a> {
    /// Looks at a state whose places are those of `time`, s.
    pub fn new(setting: &'a Setting<'a>, state: &'a State, time: f64) -> Self {
        Self { setting, state, time, stepping: Stepping::of(setting) }
    }

    /// The largest step known to be stable; `None` if nothing touches. `enough` [s]: larger
    /// bounds need not be sharp.
    pub fn limit(&self, enough: f64) -> Option<Bound> {
        let delay = self.delay()?;
        let worst = Cell::new(0);
        let block = self.stepping.largest(delay, |step| {
            let (top, body) = self.block(step, None);
            worst.set(body);
            top
        });
        let mut step = block;
        if block < enough {
            let chords = self.chords();
            step = self.stepping.largest(delay, |step| chords.top(step, f64::INFINITY)).max(block);
        }
        Some(Bound { step, body: worst.get() })
    }

    /// `None` if `step` [s] is stable; otherwise the limit. To be asked after a force pass.
    pub fn exceeded_by(&self, step: f64) -> Option<Bound> {
        let most = 4.0 / (step * step);
        let traces = self.counted(step).unwrap_or_else(|| self.traces(step));
        let unclear = |body: &u32| traces[*body as usize] > most;
        let unclear: Vec<u32> = (0..traces.len() as u32).filter(unclear).collect();
        drop(traces);
        if unclear.is_empty()
            || self.block(step, Some(unclear)).0 <= most
            || self.chords().top(step, most) <= most
        {
            return None;
        }
        self.limit(f64::INFINITY)
    }

    /// Upper bounds of the traces of all blocks from the number of contacts in the last pass: O(listed pairs), no
    /// geometry. Where all spheres are alike and bodies by themselves.
    fn counted(&self, step: f64) -> Option<Vec<f64>> {
        let (setting, state) = (self.setting, self.state);
        let radius = setting.alike.filter(|_| setting.equal_bodies && !setting.needs.bonds)?.1;
        let material = setting.model.bodies.first()?.material;
        let most = |other: Option<u32>, there: u16, stiffer: f64| {
            let arms = [-1.0, 1.0].map(|side| Vec3::x() * (side * radius));
            let law = setting.stiff_pair(material, there);
            let link =
                Link { bodies: (0, other), normal: Vec3::x(), arms, law, depth: 0.0, stiffer };
            self.round_trace(&link, step).map(|parts| parts[0] * (1.0 + ROUNDING))
        };
        let pair = most(Some(0), material, 1.0)?;
        let at_wall = |wall: &Wall| most(None, wall.material, servo::stiffer(&wall.motion));
        let wall = setting.model.walls.iter().filter_map(at_wall).fold(0.0, f64::max);
        let spheres = touched(&state.pairs, true);
        let walls = touched(&state.planes, false).into_iter().zip(touched(&state.faces, false));
        let mut traces = vec![0.0; setting.model.bodies.len()];
        for ((ball, spheres), (planes, faces)) in state.balls.iter().zip(spheres).zip(walls) {
            let at_walls = f64::from(planes + faces) * wall;
            traces[ball.body as usize] = f64::from(spheres) * pair + at_walls;
        }
        Some(traces)
    }

    /// The contact with the largest overlap over the smaller radius; its bodies.
    pub fn deepest(&self) -> Option<Deepest> {
        let worst: Cell<Option<Deepest>> = Cell::new(None);
        // Farther apart than this, two spheres are not deeper than the deepest so far.
        let balls = &self.state.balls;
        let reach = |one: usize, other: usize| {
            let (one, other) = (&balls[one], &balls[other]);
            let smaller = one.radius.min(other.radius);
            let depth = worst.get().map_or(0.0, |worst| worst.depth);
            (one.radius + other.radius) * (1.0 + ROUNDING) - smaller * depth
        };
        each_link(self.setting, self.state, self.time, reach, |link| {
            if worst.get().is_none_or(|worst| link.depth > worst.depth) {
                worst.set(Some(Deepest { bodies: link.bodies, depth: link.depth }));
            }
        });
        worst.into_inner()
    }

    /// Largest c/k of a strand, s; `None` without contacts.
    fn delay(&self) -> Option<f64> {
        let mut largest = None;
        self.each(|_, strands| {
            let delays = strands.iter().map(|strand| match (strand.stiffness, strand.dashpot) {
                (_, 0.0) => 0.0,
                (k, c) => c / k,
            });
            largest = Some(delays.fold(largest.unwrap_or(0.0f64), f64::max));
        });
        self.each_bond(|_, strand| {
            let delay = if strand.dashpot > 0.0 { strand.dashpot / strand.stiffness } else { 0.0 };
            largest = Some(largest.unwrap_or(0.0f64).max(delay));
        });
        largest
    }

    /// Largest eigenvalue bound of the blocks of all or of some bodies at the effective stiffness of `step`, and
    /// its body; 0 without contacts.
    fn block(&self, step: f64, wanted: Option<Vec<u32>>) -> (f64, u32) {
        let count = self.setting.model.bodies.len();
        let wanted = wanted.unwrap_or_else(|| (0..count as u32).collect());
        let mut best = (0.0, wanted.first().copied().unwrap_or(0));
        // Place of each body in its chunk.
        let mut place = vec![u32::MAX; if wanted.is_empty() { 0 } else { count }];
        for chunk in wanted.chunks(CHUNK.max(count.div_ceil(PASSES))) {
            let numbered = || chunk.iter().zip(0..);
            numbered().for_each(|(body, at)| place[*body as usize] = at);
            for (body, block) in chunk.iter().zip(self.blocks(step, &place, chunk.len())) {
                if block == Matrix6::zeros() || not_above(&block, best.0) {
                    continue;
                }
                let top = SymmetricEigen::new(block).eigenvalues.max();
                if top > best.0 {
                    best = (top, *body);
                }
            }
            numbered().for_each(|(body, _)| place[*body as usize] = u32::MAX);
        }
        best
    }

    /// The blocks of the bodies that have a `place`, at the effective stiffness of `step`.
    fn blocks(&self, step: f64, place: &[u32], count: usize) -> Vec<Matrix6<f64>> {
        let mut blocks = vec![Matrix6::zeros(); count];
        let state = self.state;
        let held = |ball: &Ball| place[ball.body as usize] != u32::MAX;
        let held: Vec<bool> = state.balls.iter().map(held).collect();
        let reach = |one: usize, other: usize| {
            let wanted = held[one] || held[other];
            if wanted { touching(&state.balls[one], &state.balls[other]) } else { 0.0 }
        };
        each_link(self.setting, self.state, self.time, reach, |link| {
            let at = [Some(link.bodies.0), link.bodies.1]
                .map(|body| body.map_or(u32::MAX, |body| place[body as usize]));
            if at == [u32::MAX; 2] || link.normal == Vec3::zeros() {
                return;
            }
            for strand in &self.strands(&link) {
                let k = self.stepping.effective(strand, step);
                let parts = at.into_iter().zip([strand.mine, strand.other]);
                for ((at, part), weight) in parts.zip(weights(strand)) {
                    if at != u32::MAX {
                        blocks[at as usize] += part * part.transpose() * (k * weight);
                    }
                }
            }
        });
        self.each_bond(|body, strand| {
            let at = place[body as usize];
            if at != u32::MAX {
                let k = self.stepping.effective(strand, step);
                blocks[at as usize] += strand.mine * strand.mine.transpose() * k;
            }
        });
        blocks
    }

    /// Upper bounds of the traces of all blocks at the effective stiffness of `step`.
    fn traces(&self, step: f64) -> Vec<f64> {
        let mut traces = vec![0.0; self.setting.model.bodies.len()];
        self.each_contact(|link| {
            let parts = self.round_trace(&link, step).unwrap_or_else(|| self.trace(&link, step));
            traces[link.bodies.0 as usize] += parts[0];
            if let Some(other) = link.bodies.1 {
                traces[other as usize] += parts[1];
            }
        });
        self.each_bond(|body, strand| {
            let k = self.stepping.effective(strand, step);
            traces[body as usize] += k * strand.mine.norm_squared();
        });
        traces
    }

    /// What a contact adds to the traces of its bodies.
    fn trace(&self, link: &Link<'_>, step: f64) -> [f64; 2] {
        let mut parts = [0.0; 2];
        for strand in &self.strands(link) {
            let k = self.stepping.effective(strand, step);
            let [first, second] = weights(strand);
            parts[0] += first * k * strand.mine.norm_squared();
            parts[1] += second * k * strand.other.norm_squared();
        }
        parts
    }

    /// The same between spheres that are bodies by themselves, whose arms lie along the
    /// normal: |a|² is 1/m along the normal and 1/m + r²/I along both tangents.
    fn round_trace(&self, link: &Link<'_>, step: f64) -> Option<[f64; 2]> {
        if self.setting.planar {
            return None;
        }
        let ease = |body: u32, arm: &Vec3| {
            let alone = is_alone(self.setting, body as usize);
            let body = &self.setting.model.bodies[body as usize];
            let light = 1.0 / body.mass;
            alone.then(|| [light, light + arm.norm_squared() / body.inertia.z])
        };
        let mine = ease(link.bodies.0, &link.arms[0])?;
        let other = match link.bodies.1 {
            Some(body) => ease(body, &link.arms[1])?,
            None => [0.0; 2],
        };
        let law = link.law;
        let (kt, ct) = if law.friction > 0.0 { (law.kt, law.ct) } else { (0.0, 0.0) };
        let mut parts = [0.0; 2];
        for (way, (k, c), times) in [(0, (law.kn, law.cn), 1.0), (1, (kt, ct), 2.0)] {
            let (a, b) = (mine[way], other[way]);
            let (k, c) = (k * link.stiffer, c * link.stiffer);
            let k = times * self.stepping.stiffness(k, c, || a + b, step);
            let both = (a * b).sqrt();
            parts[0] += k * (a + both);
            parts[1] += k * (b + both);
        }
        Some(parts)
    }

    /// The three directions of a contact.
    fn strands(&self, link: &Link<'_>) -> [Strand; 3] {
        let bodies = &self.setting.model.bodies;
        let turn = |body: u32| turn_of(self.setting, self.state, body);
        let first = turn(link.bodies.0);
        let second = link.bodies.1.map(turn);
        let other =
            link.bodies.1.zip(second.as_ref()).map(|(body, turn)| (&bodies[body as usize], turn));
        strands((&bodies[link.bodies.0 as usize], &first), other, link, self.setting.planar)
    }

    /// All strands, for many products with their matrix.
    fn chords(&self) -> Chords {
        let mut place = vec![u32::MAX; self.setting.model.bodies.len()];
        let mut count = 0;
        let mut number = |body: u32| {
            let entry = &mut place[body as usize];
            if *entry == u32::MAX {
                *entry = count;
                count += 1;
            }
            *entry
        };
        let mut kept = Vec::new();
        self.each(|link, strands| {
            let first = number(link.bodies.0);
            let second = link.bodies.1.map_or(first, &mut number);
            let active = strands.iter().filter(|s| s.stiffness > 0.0 || s.dashpot > 0.0);
            kept.extend(active.map(|strand| (first, second, *strand)));
        });
        self.each_bond(|body, strand| {
            let place = number(body);
            kept.push((place, place, *strand));
        });
        let seed = self.setting.model.seed;
        Chords { stepping: self.stepping, seed, size: count as usize, strands: kept }
    }

    /// Calls `visit` for every body of every bond: springs that already count for a body alone.
    fn each_bond(&self, mut visit: impl FnMut(u32, &Strand)) {
        if self.setting.needs.bonds {
            bond_limit::each_part(self.setting, self.state, |part| {
                let (stiffness, dashpot) = (part.stiffness, part.stiffness * part.viscosity);
                let (mine, other) = (part.way, Vector6::zeros());
                visit(part.body, &Strand { mine, other, stiffness, dashpot });
            });
        }
    }

    /// Calls `visit` for every contact.
    fn each(&self, mut visit: impl FnMut(&Link<'_>, &[Strand; 3])) {
        self.each_contact(|link| visit(&link, &self.strands(&link)));
    }

    /// Calls `visit` for every contact that has a normal.
    fn each_contact(&self, mut visit: impl FnMut(Link<'a>)) {
        let balls = &self.state.balls;
        let reach = |one: usize, other: usize| touching(&balls[one], &balls[other]);
        each_link(self.setting, self.state, self.time, reach, |link| {
            if link.normal != Vec3::zeros() {
                visit(link);
            }
        });
    }
}

fn turn_of(setting: &Setting<'_>, state: &State, body: u32) -> Rotation {
    state
        .solids
        .binary_search_by_key(&body, |solid| solid.body)
        .map_or(setting.model.bodies[body as usize].orientation, |at| state.solids[at].turn)
}

/// Distance of two centres below which each of them may touch the other, m.
fn touching(one: &Ball, other: &Ball) -> f64 {
    (one.radius + other.radius) * (1.0 + ROUNDING)
}

/// How many entries of a list touched in the last pass, of each sphere; those of its partners too where these are
/// spheres.
fn touched(list: &List, spheres: bool) -> Vec<u32> {
    let mut counts = vec![0; list.start.len().saturating_sub(1)];
    for (slot, range) in list.start.windows(2).enumerate() {
        let range = range[0] as usize..range[1] as usize;
        let touching = &list.book.touching[range.clone()];
        counts[slot] += touching.iter().map(|touches| u32::from(*touches)).sum::<u32>();
        if spheres {
            for (other, touches) in list.partner[range].iter().zip(touching) {
                counts[*other as usize] += u32::from(*touches);
            }
        }
    }
    counts
}

/// Whether all eigenvalues λ ≥ 0 of `block` are known to be at most `best`, from
/// λ⁸ ≤ Σ λ⁸ = |B⁴|², |·| the root of the sum of squares. False where numbers are not finite.
fn not_above(block: &Matrix6<f64>, best: f64) -> bool {
    if best <= 0.0 {
        return false;
    }
    let scaled = block / best;
    let square = scaled * scaled;
    (square * square).norm_squared() <= 1.0 - ROUNDING
}

/// Calls `visit` for every contact of the lists; the normal is 0 where centres coincide.
/// Spheres farther apart than the `reach` of their slots, m, are passed over.
fn each_link<'a>(
    setting: &'a Setting<'_>,
    state: &State,
    time: f64,
    reach: impl Fn(usize, usize) -> f64,
    mut visit: impl FnMut(Link<'a>),
) {
    let centre = |slot: usize| {
        let ball = &state.balls[slot];
        if ball.alone {
            return ball.place;
        }
        state
            .solids
            .binary_search_by_key(&ball.body, |solid| solid.body)
            .map_or(ball.place, |at| state.solids[at].place)
    };
    let entries =
        |list: &List, slot: usize| list.start[slot] as usize..list.start[slot + 1] as usize;
    let planes = setting.planes_at(time);
    let mut corners = Vec::new();
    if !state.faces.partner.is_empty() {
        neighbours::faces_at(setting, time, &mut corners);
    }
    for (slot, ball) in state.balls.iter().enumerate() {
        for k in entries(&state.pairs, slot) {
            let there = state.pairs.partner[k] as usize;
            let reach = reach(slot, there);
            if reach <= 0.0 {
                continue;
            }
            let other = &state.balls[there];
            let between = setting.way(ball.place - other.place);
            let square = between.norm_squared();
            if square > reach * reach {
                continue;
            }
            let distance = square.sqrt();
            let overlap = ball.radius + other.radius - distance;
            if overlap.is_nan() || overlap < -1e-12 * ball.radius {
                continue;
            }
            let normal = if distance > 0.0 { between / distance } else { Vec3::zeros() };
            let law = setting.stiff_pair(ball.material, other.material);
            let ends = [
                ball.place - normal * (ball.radius - setting.share * overlap),
                other.place + normal * (other.radius - setting.share * overlap),
            ];
            visit(Link {
                bodies: (ball.body, Some(other.body)),
                normal,
                arms: [ends[0] - centre(slot), ends[1] - centre(there)],
                law,
                depth: overlap / ball.radius.min(other.radius),
                stiffer: 1.0,
            });
        }
        let mut wall = |away: Vec3, number: usize| {
            let distance = away.norm();
            if distance.is_nan() || distance > ball.radius * (1.0 + 1e-12) {
                return;
            }
            let normal = if distance > 0.0 { away / distance } else { Vec3::zeros() };
            // The longer of the arms at planes and elsewhere.
            let share = setting.share.min(0.5);
            let overlap = ball.radius - distance;
            let arm = ball.place - normal * (ball.radius - share * overlap) - centre(slot);
            let wall = &setting.model.walls[number];
            let law = setting.stiff_pair(ball.material, wall.material);
            let stiffer = servo::stiffer(&wall.motion);
            let depth = 1.0 - distance / ball.radius;
            let arms = [arm, Vec3::zeros()];
            visit(Link { bodies: (ball.body, None), normal, arms, law, depth, stiffer });
        };
        for k in entries(&state.planes, slot) {
            let index = state.planes.partner[k] as usize;
            let (plane, number) = (&planes[index], setting.planes[index] as usize);
            wall(plane.normal * (ball.place - plane.point).dot(&plane.normal), number);
        }
        for k in entries(&state.faces, slot) {
            let face = state.faces.partner[k] as usize;
            let (point, _) = surface::closest(&ball.place, &corners[face]);
            wall(ball.place - point, setting.surfaces.wall[face] as usize);
        }
    }
}
