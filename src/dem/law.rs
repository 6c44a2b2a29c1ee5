//! One contact: linear spring and dashpot along the normal, spring, dashpot and
//! Coulomb limit in the contact plane, and the energy that each of them takes.
//!
//! Normal: Fn = kn δ + cn u, clipped at 0 unless the law keeps tension.
//! Tangent: spring ξ follows the contact plane (see [`History`]), grows by w Δt,
//! and is cut by μ|Fn| (see [`Coulomb`]); Ft = −(kt ξ + ct w).
//! Sources: Cundall & Strack 1979; the variants as LIGGGHTS 3.8.0
//! `hooke/stiffness` and YADE 2023.02a `ViscElPhys` compute them.
//!
//! Symbols: δ overlap [m]; n unit normal towards the sphere; u closing speed
//! [m/s] = −v·n; w sliding velocity [m/s]; ξ spring stretch [m].
//!
//! Energy over the interval between two force evaluations is the mean of the
//! forces at both ends times the displacement in between, so its error is of
//! second order in the step. O(1); cannot fail.
//!
//! The law stands once, for any number of contacts side by side (see [`super::lanes`]); walls and
//! broken bonds use it for one contact, pairs of spheres for several.

use super::lanes::{Lanes, Triple};
use crate::model::{Contact, Coulomb, History, Law};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};
use std::ops::{AddAssign, Range};

/// What every evaluation of the law in one force pass has in common.
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    /// Variant of the law.
    pub law: Law,
    /// Time by which springs advance, s; 0 in the set-up pass of kick-drift-kick schemes.
    pub advance: f64,
    /// Time over which energy is counted, s; 0 in the first pass.
    pub interval: f64,
    /// What becomes of a contact that slips.
    pub slip: Slip,
    /// Whether somebody asks for [`Book::lag`] after the pass; a ledger does in every pass.
    pub seen: bool,
}

/// What becomes of a contact that slips: solvers have set-up passes of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slip {
    /// Its spring is as long as the Coulomb limit lets it be.
    Cut,
    /// The same, and there is no tangential force while the spring has not moved (LAMMPS in its
    /// set-up pass).
    Bare,
    /// The force is cut, the spring stays as it was (LIGGGHTS in its set-up pass).
    Kept,
}

/// Geometry and motion of a contact.
#[derive(Debug, Clone, Copy)]
pub struct Approach<L = f64> {
    /// Unit vector from the partner towards the sphere.
    pub normal: Triple<L>,
    /// Overlap, m.
    pub overlap: L,
    /// Velocity of the sphere's contact point relative to the partner's, m/s.
    pub velocity: Triple<L>,
    /// Sum of both angular velocities, rad/s.
    pub spins: Triple<L>,
}

impl Approach {
    /// One contact.
    #[inline(always)]
    pub fn new(normal: Vec3, overlap: f64, velocity: Vec3, spins: Vec3) -> Self {
        Self { normal: normal.into(), overlap, velocity: velocity.into(), spins: spins.into() }
    }
}

/// Parameters of contacts.
#[derive(Debug, Clone, Copy)]
pub struct Parameters<L> {
    /// Normal stiffness, N/m.
    pub kn: L,
    /// Tangential stiffness, N/m.
    pub kt: L,
    /// Normal dashpot, N s/m.
    pub cn: L,
    /// Tangential dashpot, N s/m.
    pub ct: L,
    /// Coefficient of friction.
    pub friction: L,
    /// 1/kt, m/N; 0 where there are no tangential springs.
    pub soft: L,
}

impl<L: Lanes> Parameters<L> {
    /// Those of `pair` everywhere.
    #[inline(always)]
    pub fn of(pair: &Contact) -> Self {
        Self {
            kn: L::splat(pair.kn),
            kt: L::splat(pair.kt),
            cn: L::splat(pair.cn),
            ct: L::splat(pair.ct),
            friction: L::splat(pair.friction),
            soft: L::splat(softness(pair)),
        }
    }
}

/// 1/kt, m/N; 0 without tangential springs.
pub fn softness(pair: &Contact) -> f64 {
    if pair.kt > 0.0 { 1.0 / pair.kt } else { 0.0 }
}

/// What contacts remember of the last pass; see [`Book`].
#[derive(Debug, Clone, Copy)]
pub struct Past<L> {
    /// Tangential spring, m.
    pub spring: Triple<L>,
    /// See [`Book::lag`].
    pub lag: L,
    /// See [`Book::power`].
    pub power: L,
    /// See [`Book::normal`].
    pub normal: Triple<L>,
}

impl<L: Lanes> Past<L> {
    /// Nothing.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = L::splat(0.0);
        Self { spring: Triple::zero(), lag: zero, power: zero, normal: Triple::zero() }
    }
}

/// Force on the sphere.
#[derive(Debug, Clone, Copy)]
pub struct Reply {
    /// Normal force, N, positive when pushing apart.
    pub normal: f64,
    /// Tangential force, N.
    pub tangent: Vec3,
}

/// Energy taken in one pass, J, and power of walls, W.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Dissipated by normal dashpots (and by clipping the normal force).
    pub normal_dashpot: f64,
    /// Dissipated by tangential dashpots.
    pub tangential_dashpot: f64,
    /// Dissipated by slip.
    pub slip: f64,
    /// Power of moving walls on the spheres, W.
    pub wall_power: f64,
    /// Dissipated by resistance to rolling.
    pub rolling: f64,
    /// Freed where liquid bridges formed.
    pub wetting: f64,
    /// Power of drag, W.
    pub drag_power: f64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.normal_dashpot += other.normal_dashpot;
        self.tangential_dashpot += other.tangential_dashpot;
        self.slip += other.slip;
        self.wall_power += other.wall_power;
        self.rolling += other.rolling;
        self.wetting += other.wetting;
        self.drag_power += other.drag_power;
    }
}

/// What contacts remember, one entry a candidate; arrays that the scene does
/// not need are empty.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Book {
    /// True while in contact.
    pub touching: Vec<bool>,
    /// Tangential springs, m; with friction only.
    pub spring: Triple<Vec<f64>>,
    /// Non-elastic normal force at the last pass, without a ledger at the last that was [`Rule::seen`], N; of
    /// path-averaged contacts the whole normal force. With damping only.
    pub lag: Vec<f64>,
    /// Power of the tangential dashpot at the last pass, W; 0 of path-averaged contacts. With friction,
    /// damping and a ledger only. No force follows from it, and the energies that do are
    /// of second order in the step: single precision is enough.
    pub power: Vec<f32>,
    /// Normal of the last pass; with springs that turn with it only.
    pub normal: Triple<Vec<f64>>,
    /// Tangential force on the sphere in the last pass, N; where dashpots are implicit only.
    pub pull: Triple<Vec<f64>>,
}

/// Forces in one entry of a book.
#[derive(Debug, Clone, Copy, Default)]
pub struct Record {
    /// Tangential spring, m.
    pub spring: Vec3,
    /// See [`Book::lag`].
    pub lag: f64,
}

/// Which arrays of a book are kept.
#[derive(Debug, Clone, Copy)]
pub struct Kept {
    /// Springs.
    pub friction: bool,
    /// Dashpots.
    pub damping: bool,
    /// Old normals.
    pub normals: bool,
    /// Old tangential forces.
    pub pulls: bool,
    /// What the energies that contacts take follow from.
    pub ledger: bool,
}

impl Kept {
    /// Whether powers of tangential dashpots are.
    pub fn powers(self) -> bool {
        self.friction && self.damping && self.ledger
    }
}

impl Book {
    /// A book of `size` open contacts.
    pub fn open(size: usize, kept: Kept) -> Self {
        let of = |wanted: bool| if wanted { size } else { 0 };
        Self {
            touching: vec![false; size],
            spring: Triple::zeros(of(kept.friction)),
            lag: vec![0.0; of(kept.damping)],
            power: vec![0.0; of(kept.powers())],
            normal: Triple::zeros(of(kept.friction && kept.normals)),
            pull: Triple::zeros(of(kept.friction && kept.pulls)),
        }
    }

    /// Entry `k`, zeros for what is not kept.
    pub fn record(&self, k: usize) -> Record {
        Record {
            spring: self.spring.get(k).unwrap_or_default(),
            lag: self.lag.get(k).copied().unwrap_or_default(),
        }
    }

    /// The whole book as slices.
    pub fn view(&mut self) -> BookView<'_> {
        BookView {
            touching: &mut self.touching,
            spring: self.spring.view(),
            lag: &mut self.lag,
            power: &mut self.power,
            normal: self.normal.view(),
            pull: self.pull.view(),
        }
    }
}

/// A part of a book that one thread may write.
#[derive(Default)]
pub struct BookView<'a> {
    /// See [`Book::touching`].
    pub touching: &'a mut [bool],
    /// See [`Book::spring`].
    pub spring: Triple<&'a mut [f64]>,
    /// See [`Book::lag`].
    pub lag: &'a mut [f64],
    /// See [`Book::power`].
    pub power: &'a mut [f32],
    /// See [`Book::normal`].
    pub normal: Triple<&'a mut [f64]>,
    /// See [`Book::pull`].
    pub pull: Triple<&'a mut [f64]>,
}

impl<'a> BookView<'a> {
    /// The first `at` entries and the rest.
    pub fn split_at(self, at: usize) -> (Self, Self) {
        let (t, touching) = self.touching.split_at_mut(at);
        let (s, spring) = self.spring.split_at(at);
        let (l, lag) = self.lag.split_at_mut(at.min(self.lag.len()));
        let (w, power) = self.power.split_at_mut(at.min(self.power.len()));
        let (n, normal) = self.normal.split_at(at);
        let (p, pull) = self.pull.split_at(at);
        (
            Self { touching: t, spring: s, lag: l, power: w, normal: n, pull: p },
            Self { touching, spring, lag, power, normal, pull },
        )
    }

    /// What a contact of kind `K` needs of entry `k`.
    #[inline(always)]
    pub fn recall<K: Kind>(&self, k: usize) -> Past<f64> {
        let mut past = Past::none();
        if K::FRICTION {
            past.spring = self.spring.at(k).into();
            if K::HISTORY == History::Rotated {
                past.normal = self.normal.at(k).into();
            }
        }
        if K::DAMPING {
            past.lag = self.lag[k];
            if K::FRICTION && K::LEDGER {
                past.power = f64::from(self.power[k]);
            }
        }
        past
    }

    /// Writes what a contact of kind `K` remembers to entry `k`.
    #[inline(always)]
    pub fn keep<K: Kind>(&mut self, k: usize, past: &Past<f64>) {
        if K::FRICTION {
            self.spring.put(k, past.spring.into());
            if K::HISTORY == History::Rotated {
                self.normal.put(k, past.normal.into());
            }
        }
        if K::DAMPING {
            self.lag[k] = past.lag;
            if K::FRICTION && K::LEDGER {
                self.power[k] = past.power as f32;
            }
        }
    }

    /// Takes over what contacts of kind `K` remember in as many entries of `other`.
    #[inline(always)]
    pub fn copy<K: Kind>(&mut self, to: Range<usize>, other: &BookView<'_>, from: Range<usize>) {
        self.touching[to.clone()].copy_from_slice(&other.touching[from.clone()]);
        if K::FRICTION {
            self.spring.copy(to.clone(), &other.spring, from.clone());
            if K::HISTORY == History::Rotated {
                self.normal.copy(to.clone(), &other.normal, from.clone());
            }
        }
        if K::DRAGS {
            self.pull.copy(to.clone(), &other.pull, from.clone());
        }
        if K::DAMPING {
            self.lag[to.clone()].copy_from_slice(&other.lag[from.clone()]);
            if K::FRICTION && K::LEDGER {
                self.power[to].copy_from_slice(&other.power[from]);
            }
        }
    }

    /// Empties entry `k`.
    pub fn clear(&mut self, k: usize) {
        self.touching[k] = false;
        if !self.spring.is_empty() {
            self.spring.put(k, Vec3::zeros());
        }
        if let Some(place) = self.lag.get_mut(k) {
            *place = 0.0;
        }
        if let Some(place) = self.power.get_mut(k) {
            *place = 0.0;
        }
        if !self.pull.is_empty() {
            self.pull.put(k, Vec3::zeros());
        }
    }
}

/// What sits inside the contact loop, known to the compiler.
pub trait Kind: Copy + Send + Sync {
    /// Tangential force.
    const FRICTION: bool;
    /// Dashpots.
    const DAMPING: bool;
    /// What the Coulomb limit cuts.
    const COULOMB: Coulomb;
    /// How springs follow the contact plane.
    const HISTORY: History;
    /// Whether the energies that contacts take are counted.
    const LEDGER: bool;
    /// Forces averaged over the path of a step (see [`super::averaged`]).
    const AVERAGED: bool = false;
    /// Of these, tangential dashpots.
    const DRAGS: bool = false;
}

/// A kind by its numbers: see [`for_kind`].
#[derive(Debug, Clone, Copy)]
pub struct Variant<
    const FRICTION: bool,
    const DAMPING: bool,
    const COULOMB: u8,
    const HISTORY: u8,
    const LEDGER: bool,
>;

impl<
    const FRICTION: bool,
    const DAMPING: bool,
    const COULOMB: u8,
    const HISTORY: u8,
    const LEDGER: bool,
> Kind for Variant<FRICTION, DAMPING, COULOMB, HISTORY, LEDGER>
{
    const LEDGER: bool = LEDGER;
    const FRICTION: bool = FRICTION;
    const DAMPING: bool = DAMPING;
    const COULOMB: Coulomb = match COULOMB {
        0 => Coulomb::Sum,
        1 => Coulomb::SpringThenDashpot,
        _ => Coulomb::Spring,
    };
    const HISTORY: History = match HISTORY {
        0 => History::Projected,
        1 => History::Rescaled,
        _ => History::Rotated,
    };
}

/// Evaluates an expression with the type `$kind` that belongs to what is kept and to a law.
macro_rules! for_kind {
    ($kept:expr, $law:expr, $kind:ident => $body:expr) => {{
        use $crate::dem::law::Variant;
        use $crate::model::{Coulomb, History};
        macro_rules! with {
            ($friction:literal, $damping:literal, $coulomb:literal, $history:literal) => {{
                if $kept.ledger {
                    type $kind = Variant<$friction, $damping, $coulomb, $history, true>;
                    $body
                } else {
                    type $kind = Variant<$friction, $damping, $coulomb, $history, false>;
                    $body
                }
            }};
        }
        match ($kept.friction, $kept.damping, $law.coulomb, $law.history) {
            (false, false, _, _) => with!(false, false, 0, 0),
            (false, true, _, _) => with!(false, true, 0, 0),
            // Without dashpots all three limits cut the same.
            (true, false, _, History::Projected) => with!(true, false, 1, 0),
            (true, false, _, History::Rescaled) => with!(true, false, 1, 1),
            (true, false, _, History::Rotated) => with!(true, false, 1, 2),
            (true, true, Coulomb::Sum, History::Projected) => with!(true, true, 0, 0),
            (true, true, Coulomb::Sum, History::Rescaled) => with!(true, true, 0, 1),
            (true, true, Coulomb::Sum, History::Rotated) => with!(true, true, 0, 2),
            (true, true, Coulomb::SpringThenDashpot, History::Projected) => with!(true, true, 1, 0),
            (true, true, Coulomb::SpringThenDashpot, History::Rescaled) => with!(true, true, 1, 1),
            (true, true, Coulomb::SpringThenDashpot, History::Rotated) => with!(true, true, 1, 2),
            (true, true, Coulomb::Spring, History::Projected) => with!(true, true, 2, 0),
            (true, true, Coulomb::Spring, History::Rescaled) => with!(true, true, 2, 1),
            (true, true, Coulomb::Spring, History::Rotated) => with!(true, true, 2, 2),
        }
    }};
}
pub(crate) use for_kind;

/// Answer of the law to an approach.
#[derive(Debug, Clone, Copy)]
pub struct Response<L> {
    /// Normal force, N, positive when pushing apart; 0 if apart.
    pub normal: L,
    /// Tangential force, N; 0 if apart.
    pub tangent: Triple<L>,
    /// What the contact remembers now; zeros if apart.
    pub past: Past<L>,
    /// Energy taken by the normal dashpot, the tangential dashpot and slip, J; 0 without a ledger.
    pub taken: [L; 3],
}

/// Force between two bodies that `touch`, or that are apart and perhaps did touch at the
/// last pass (then `old` is not zero and the energy of the end of the contact is counted). The spring of
/// `old` is not looked at, but `before`, what [`carry`] made of it.
#[inline(always)]
pub fn respond<L: Lanes, K: Kind>(
    rule: &Rule,
    pair: &Parameters<L>,
    approach: &Approach<L>,
    touches: L::Mask,
    (old, before): (&Past<L>, Triple<L>),
) -> Response<L> {
    let zero = L::splat(0.0);
    let mut past = Past::none();
    let mut taken = [zero; 3];
    let n = approach.normal;
    let closing = -approach.velocity.dot(n);
    let elastic = pair.kn * approach.overlap;
    let mut normal = elastic;
    if K::DAMPING {
        normal = normal.plus_product(pair.cn, closing);
        let pulls = L::both(normal.below(zero), L::all(!rule.law.tension));
        normal = L::pick(pulls, zero, normal);
        past.lag = L::only(touches, normal - elastic);
        if K::LEDGER {
            taken[0] = L::splat(0.5 * rule.interval) * closing * (old.lag + past.lag);
        }
    }
    normal = L::only(touches, normal);
    let mut tangent = Triple::zero();
    if K::FRICTION {
        let slide = approach.velocity.plus_product(n, closing);
        let limit = pair.friction * normal.abs();
        let mut trial = before.plus_product(slide, L::splat(rule.advance));
        if K::HISTORY == History::Projected {
            trial = trial.minus_product(n, trial.dot(n));
        }
        if K::HISTORY == History::Rotated {
            past.normal = n;
        }
        let Cut { spring, dash, force, slips } =
            cut(K::COULOMB, pair, trial, slide, limit, touches);
        let (mut holds, mut left) = (touches, spring);
        match rule.slip {
            Slip::Cut => {}
            Slip::Bare => {
                let bare = L::both(slips, trial.dot(trial).at_most(zero));
                holds = L::both(touches, L::not(bare));
            }
            Slip::Kept => left = trial,
        }
        tangent = Triple::only(holds, force.map(|f| -f));
        past.spring = Triple::only(holds, left);
        // With springs that do not move, as in the set-up pass, slip takes nothing.
        if K::LEDGER && rule.interval > 0.0 {
            let ends = L::either(slips, L::not(touches));
            let lost = (before + past.spring).dot(trial - past.spring);
            taken[2] = L::only(ends, L::splat(0.5) * pair.kt * lost);
        }
        if K::LEDGER && K::DAMPING {
            past.power = L::only(touches, dash.dot(slide));
            taken[1] = L::splat(rule.interval) * mean_power(old.power, past.power);
        }
    }
    Response { normal, tangent, past, taken }
}

/// Mean power of a tangential dashpot between two passes at which it had the
/// powers `before` and `now`. The forces act on the sliding velocity w between
/// the passes, ½(c w' + c w)·w = ¼ c w'² + ¾ c w² − ¼ c (w − w')²; the last term
/// is of second order. A dashpot that was or is off takes half of the other power.
#[inline(always)]
fn mean_power<L: Lanes>(before: L, now: L) -> L {
    let zero = L::splat(0.0);
    let both = L::both(zero.below(before), zero.below(now));
    let shift = L::only(both, L::splat(0.25));
    let half = L::splat(0.5);
    ((half - shift) * before).plus_product(half + shift, now)
}

/// The spring of the last pass, turned with the contact.
#[inline(always)]
pub fn carry<L: Lanes, K: Kind>(
    rule: &Rule,
    n: Triple<L>,
    spins: Triple<L>,
    old: &Past<L>,
) -> Triple<L> {
    match K::HISTORY {
        History::Projected => old.spring,
        History::Rescaled => rescale(old.spring, n),
        History::Rotated => {
            let from = old.normal;
            let tilted = old.spring - old.spring.cross(from.cross(n));
            let half = L::splat(0.5 * rule.advance);
            let twist = from * (half * from.dot(spins));
            tilted - tilted.cross(twist)
        }
    }
}

/// `old` projected on the plane of normal `n`, at its old length.
#[inline(always)]
pub fn rescale<L: Lanes>(old: Triple<L>, n: Triple<L>) -> Triple<L> {
    let flat = old.minus_product(n, old.dot(n));
    let (was, is) = (old.dot(old), flat.dot(flat));
    let one = L::splat(1.0);
    let ratio = was / is;
    // √(1 + d): d is the square of the angle turned through in a step, and four terms have all
    // digits below 1e-3. A root costs as much as all else here.
    let d = ratio - one;
    let small = d.abs().below(L::splat(1e-3));
    let series = L::splat(0.0625).minus_product(L::splat(5.0 / 128.0), d);
    let series = L::splat(0.5).minus_product(d, L::splat(0.125).minus_product(d, series));
    let series = one.plus_product(d, series);
    let is_there = L::splat(0.0).below(is);
    let mut stretch = L::pick(small, series, one);
    let large = L::both(is_there, L::not(small));
    if L::any(large) {
        stretch = L::pick(large, ratio.sqrt(), stretch);
    }
    flat * L::pick(is_there, stretch, one)
}

/// What the Coulomb limit leaves.
pub struct Cut<L: Lanes> {
    /// Spring, m.
    pub spring: Triple<L>,
    /// The dashpot's part of the force, N.
    pub dash: Triple<L>,
    /// Whole force against the motion, N.
    pub force: Triple<L>,
    /// Whether anything was cut.
    pub slips: L::Mask,
}

/// Applies the Coulomb limit to a trial spring where the contact `touches`.
#[inline(always)]
pub fn cut<L: Lanes>(
    kind: Coulomb,
    pair: &Parameters<L>,
    trial: Triple<L>,
    slide: Triple<L>,
    limit: L,
    touches: L::Mask,
) -> Cut<L> {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let (pull, dash) = (trial * pair.kt, slide * pair.ct);
    let total = dash.plus_product(trial, pair.kt);
    let limited = if kind == Coulomb::Sum { total } else { pull };
    let square = limited.dot(limited);
    let slips = L::both(touches, (limit * limit).below(square));
    if !L::any(slips) {
        return Cut { spring: trial, dash, force: total, slips };
    }
    let part = L::pick(slips, limit / square.sqrt(), one);
    match kind {
        Coulomb::SpringThenDashpot => {
            let dash = Triple::only(L::not(slips), dash);
            let force = dash.plus_product(limited, part);
            Cut { spring: trial * part, dash, force, slips }
        }
        Coulomb::Spring => {
            let force = dash.plus_product(limited, part);
            Cut { spring: trial * part, dash, force, slips }
        }
        Coulomb::Sum => {
            let force = limited * part;
            let springs = zero.below(pair.soft);
            let left = (force - dash) * pair.soft;
            let spring = Triple::pick(L::both(slips, springs), left, trial);
            let dash = Triple::pick(L::both(slips, L::not(springs)), force, dash);
            Cut { spring, dash, force, slips }
        }
    }
}

/// Answers at entry `k` of a book: what [`respond`] says, remembered and counted.
#[inline(always)]
pub fn advance<K: Kind>(
    rule: &Rule,
    pair: &Contact,
    approach: &Approach,
    touches: bool,
    (book, k): (&mut BookView<'_>, usize),
    tally: &mut Tally,
) -> Reply {
    let old = book.recall::<K>(k);
    let pair = Parameters::of(pair);
    let mut before = Triple::zero();
    if K::FRICTION {
        before = carry::<f64, K>(rule, approach.normal, approach.spins, &old);
    }
    let Response { normal, tangent, past, taken } =
        respond::<f64, K>(rule, &pair, approach, touches, (&old, before));
    book.touching[k] = touches;
    book.keep::<K>(k, &past);
    tally.normal_dashpot += taken[0];
    tally.tangential_dashpot += taken[1];
    tally.slip += taken[2];
    Reply { normal, tangent: tangent.into() }
}
