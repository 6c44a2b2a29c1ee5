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

use crate::model::{Contact, Coulomb, History, Law};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// What every evaluation of the law in one force pass has in common.
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    /// Variant of the law.
    pub law: Law,
    /// Time by which springs advance, s; 0 in the set-up pass of kick-drift-kick schemes.
    pub advance: f64,
    /// Time over which energy is counted, s; 0 in the first pass.
    pub interval: f64,
    /// True: a contact that slips before its spring has moved gives no tangential force (LAMMPS
    /// in its set-up pass).
    pub bare_slip: bool,
}

/// Geometry and motion of a contact.
#[derive(Debug, Clone, Copy)]
pub struct Approach {
    /// Unit vector from the partner towards the sphere.
    pub normal: Vec3,
    /// Overlap, m.
    pub overlap: f64,
    /// Velocity of the sphere's contact point relative to the partner's, m/s.
    pub velocity: Vec3,
    /// Sum of both angular velocities, rad/s.
    pub spins: Vec3,
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
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.normal_dashpot += other.normal_dashpot;
        self.tangential_dashpot += other.tangential_dashpot;
        self.slip += other.slip;
        self.wall_power += other.wall_power;
    }
}

/// What contacts remember, one entry a candidate; arrays that the scene does
/// not need are empty.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Book {
    /// True while in contact.
    pub touching: Vec<bool>,
    /// Tangential springs, m; with friction only.
    pub spring: Vec<Vec3>,
    /// Non-elastic normal force [N] and power of the tangential dashpot [W] at the last pass;
    /// of path-averaged contacts the whole normal force [N] and 0. With damping only.
    pub lag: Vec<[f64; 2]>,
    /// Normal of the last pass; with springs that turn with it only.
    pub normal: Vec<Vec3>,
    /// Tangential force on the sphere in the last pass, N; where dashpots are implicit only.
    pub pull: Vec<Vec3>,
}

/// One entry of a book.
#[derive(Debug, Clone, Copy, Default)]
pub struct Record {
    /// Tangential spring, m.
    pub spring: Vec3,
    /// See [`Book::lag`].
    pub lag: [f64; 2],
    /// See [`Book::normal`].
    pub normal: Vec3,
    /// See [`Book::pull`].
    pub pull: Vec3,
}

impl Record {
    /// The same contact seen from the other side.
    pub fn reversed(self) -> Self {
        Self { spring: -self.spring, lag: self.lag, normal: -self.normal, pull: -self.pull }
    }
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
}

impl Book {
    /// A book of `size` open contacts.
    pub fn open(size: usize, kept: Kept) -> Self {
        let of = |wanted: bool| if wanted { size } else { 0 };
        Self {
            touching: vec![false; size],
            spring: vec![Vec3::zeros(); of(kept.friction)],
            lag: vec![[0.0; 2]; of(kept.damping)],
            normal: vec![Vec3::zeros(); of(kept.friction && kept.normals)],
            pull: vec![Vec3::zeros(); of(kept.friction && kept.pulls)],
        }
    }

    /// Entry `k`, zeros for what is not kept.
    pub fn record(&self, k: usize) -> Record {
        Record {
            spring: self.spring.get(k).copied().unwrap_or_default(),
            lag: self.lag.get(k).copied().unwrap_or_default(),
            normal: self.normal.get(k).copied().unwrap_or_default(),
            pull: self.pull.get(k).copied().unwrap_or_default(),
        }
    }

    /// Marks entry `k` as touching with `record`.
    pub fn restore(&mut self, k: usize, record: Record) {
        self.touching[k] = true;
        if let Some(place) = self.spring.get_mut(k) {
            *place = record.spring;
        }
        if let Some(place) = self.lag.get_mut(k) {
            *place = record.lag;
        }
        if let Some(place) = self.normal.get_mut(k) {
            *place = record.normal;
        }
        if let Some(place) = self.pull.get_mut(k) {
            *place = record.pull;
        }
    }

    /// The whole book as slices.
    pub fn view(&mut self) -> BookView<'_> {
        BookView {
            touching: &mut self.touching,
            spring: &mut self.spring,
            lag: &mut self.lag,
            normal: &mut self.normal,
            pull: &mut self.pull,
        }
    }
}

/// A part of a book that one thread may write.
pub struct BookView<'a> {
    /// See [`Book::touching`].
    pub touching: &'a mut [bool],
    /// See [`Book::spring`].
    pub spring: &'a mut [Vec3],
    /// See [`Book::lag`].
    pub lag: &'a mut [[f64; 2]],
    /// See [`Book::normal`].
    pub normal: &'a mut [Vec3],
    /// See [`Book::pull`].
    pub pull: &'a mut [Vec3],
}

impl<'a> BookView<'a> {
    /// The first `at` entries and the rest.
    pub fn split_at(self, at: usize) -> (Self, Self) {
        let (t, touching) = self.touching.split_at_mut(at);
        let (s, spring) = self.spring.split_at_mut(at.min(self.spring.len()));
        let (l, lag) = self.lag.split_at_mut(at.min(self.lag.len()));
        let (n, normal) = self.normal.split_at_mut(at.min(self.normal.len()));
        let (p, pull) = self.pull.split_at_mut(at.min(self.pull.len()));
        (
            Self { touching: t, spring: s, lag: l, normal: n, pull: p },
            Self { touching, spring, lag, normal, pull },
        )
    }

    /// Empties entry `k`.
    pub fn clear(&mut self, k: usize) {
        self.touching[k] = false;
        if let Some(place) = self.spring.get_mut(k) {
            *place = Vec3::zeros();
        }
        if let Some(place) = self.lag.get_mut(k) {
            *place = [0.0; 2];
        }
        if let Some(place) = self.pull.get_mut(k) {
            *place = Vec3::zeros();
        }
    }
}

/// Force in a contact that exists; advances entry `k` of `book`.
#[inline(always)]
pub fn respond<const FRICTION: bool, const DAMPING: bool>(
    rule: &Rule,
    pair: &Contact,
    approach: &Approach,
    book: &mut BookView<'_>,
    k: usize,
    tally: &mut Tally,
) -> Reply {
    book.touching[k] = true;
    let closing = -approach.velocity.dot(&approach.normal);
    let elastic = pair.kn * approach.overlap;
    let mut normal = elastic;
    let old = if DAMPING { book.lag[k] } else { [0.0; 2] };
    let mut new = [0.0; 2];
    if DAMPING {
        normal += pair.cn * closing;
        if normal < 0.0 && !rule.law.tension {
            normal = 0.0;
        }
        new[0] = normal - elastic;
        tally.normal_dashpot += 0.5 * rule.interval * closing * (old[0] + new[0]);
    }
    let mut tangent = Vec3::zeros();
    if FRICTION {
        let slide = approach.velocity + approach.normal * closing;
        let limit = pair.friction * normal.abs();
        let carried = carry(rule, approach, book, k);
        let mut trial = carried + slide * rule.advance;
        if rule.law.history == History::Projected {
            trial -= approach.normal * trial.dot(&approach.normal);
        }
        let Cut { spring, dash, force, slips } = cut(rule.law.coulomb, pair, trial, slide, limit);
        tangent = -force;
        book.spring[k] = spring;
        if slips {
            if rule.interval > 0.0 {
                let before = trial - slide * rule.interval;
                tally.slip += 0.5 * pair.kt * (before + spring).dot(&(trial - spring));
            } else if rule.bare_slip && trial == Vec3::zeros() {
                (tangent, book.spring[k]) = (Vec3::zeros(), Vec3::zeros());
            }
        }
        if DAMPING {
            new[1] = dash.dot(&slide);
            tally.tangential_dashpot += rule.interval * mean_power(old[1], new[1]);
        }
    }
    if DAMPING {
        book.lag[k] = new;
    }
    Reply { normal, tangent }
}

/// Mean power of a tangential dashpot between two passes at which it had the
/// powers `before` and `now`. The forces act on the sliding velocity w between
/// the passes, ½(c w' + c w)·w = ¼ c w'² + ¾ c w² − ¼ c (w − w')²; the last term
/// is of second order. A dashpot that was or is off takes half of the other power.
#[inline(always)]
fn mean_power(before: f64, now: f64) -> f64 {
    if before > 0.0 && now > 0.0 { 0.25 * before + 0.75 * now } else { 0.5 * (before + now) }
}

/// The spring of the last pass, turned with the contact.
#[inline(always)]
fn carry(rule: &Rule, approach: &Approach, book: &mut BookView<'_>, k: usize) -> Vec3 {
    let old = book.spring[k];
    let n = approach.normal;
    match rule.law.history {
        History::Projected => old,
        History::Rescaled => rescale(&old, &n),
        History::Rotated => {
            let from = book.normal[k];
            book.normal[k] = n;
            let tilted = old - old.cross(&from.cross(&n));
            let twist = from * (0.5 * rule.advance * from.dot(&approach.spins));
            tilted - tilted.cross(&twist)
        }
    }
}

/// `old` projected on the plane of normal `n`, at its old length.
#[inline(always)]
pub fn rescale(old: &Vec3, n: &Vec3) -> Vec3 {
    let along = old.dot(n);
    let flat = old - n * along;
    let (was, lost) = (old.norm_squared(), along * along);
    if lost < 1e-8 * was {
        // 1/√(1 − ε) to the last digit without a root: most contacts turn slowly.
        flat * (1.0 + 0.5 * lost / was)
    } else {
        let is = flat.norm_squared();
        if is > 0.0 { flat * (was / is).sqrt() } else { flat }
    }
}

/// What the Coulomb limit leaves.
pub struct Cut {
    /// Spring, m.
    pub spring: Vec3,
    /// The dashpot's part of the force, N.
    pub dash: Vec3,
    /// Whole force against the motion, N.
    pub force: Vec3,
    /// Whether anything was cut.
    pub slips: bool,
}

/// Applies the Coulomb limit to a trial spring.
#[inline(always)]
pub fn cut(kind: Coulomb, pair: &Contact, trial: Vec3, slide: Vec3, limit: f64) -> Cut {
    let (pull, dash) = (trial * pair.kt, slide * pair.ct);
    let total = pull + dash;
    let limited = if kind == Coulomb::Sum { total } else { pull };
    let square = limited.norm_squared();
    if square <= limit * limit {
        return Cut { spring: trial, dash, force: total, slips: false };
    }
    let part = limit / square.sqrt();
    let force = limited * part;
    let (spring, dash, force) = match kind {
        Coulomb::SpringThenDashpot => (trial * part, Vec3::zeros(), force),
        Coulomb::Spring => (trial * part, dash, force + dash),
        Coulomb::Sum if pair.kt > 0.0 => ((force - dash) / pair.kt, dash, force),
        Coulomb::Sum => (trial, force, force),
    };
    Cut { spring, dash, force, slips: true }
}

/// Closes entry `k`, which was touching at the last pass and is apart now.
#[inline(never)]
pub fn release<const FRICTION: bool, const DAMPING: bool>(
    rule: &Rule,
    pair: &Contact,
    approach: &Approach,
    book: &mut BookView<'_>,
    k: usize,
    tally: &mut Tally,
) {
    let closing = -approach.velocity.dot(&approach.normal);
    let slide = approach.velocity + approach.normal * closing;
    if DAMPING {
        tally.normal_dashpot += 0.5 * rule.interval * closing * book.lag[k][0];
    }
    if FRICTION {
        let spring = book.spring[k];
        tally.slip += 0.5 * pair.kt * spring.dot(&(spring + slide * rule.interval));
        if DAMPING {
            tally.tangential_dashpot += rule.interval * mean_power(book.lag[k][1], 0.0);
        }
    }
    book.clear(k);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Arm;
    use proptest::prelude::*;

    fn vector(size: f64) -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-size..size).prop_map(Vec3::from)
    }

    fn laws() -> impl Strategy<Value = Law> {
        let coulomb = prop_oneof![
            Just(Coulomb::Sum),
            Just(Coulomb::Spring),
            Just(Coulomb::SpringThenDashpot)
        ];
        let history =
            prop_oneof![Just(History::Projected), Just(History::Rescaled), Just(History::Rotated)];
        (any::<bool>(), coulomb, history).prop_map(|(tension, coulomb, history)| Law {
            tension,
            coulomb,
            history,
            arm: Arm::Half,
            plane_arm: Arm::Half,
        })
    }

    const KEPT: Kept = Kept { friction: true, damping: true, normals: true, pulls: false };

    proptest! {
        #[test]
        fn limits_hold_and_nothing_gives_energy(
            law in laws(), old in vector(1e-4), velocity in vector(2.0),
            tilt in vector(1e-3), overlap in 0.0..1e-3f64, friction in 0.0..1.0f64,
        ) {
            let pair = Contact { kn: 1e4, kt: 7e3, cn: 2.0, ct: 1.0, friction };
            let normal = (Vec3::z() + tilt).normalize();
            let mut book = Book::open(1, KEPT);
            let flat = Vec3::new(old.x, old.y, 0.0);
            book.restore(0, Record { spring: flat, normal: Vec3::z(), ..Record::default() });
            let rule = Rule { law, advance: 1e-6, interval: 1e-6, bare_slip: false };
            let approach = Approach { normal, overlap, velocity, spins: Vec3::zeros() };
            let mut tally = Tally::default();
            let reply = respond::<true, true>(&rule, &pair, &approach, &mut book.view(), 0, &mut tally);
            prop_assert!(law.tension || reply.normal >= 0.0);
            let limit = friction * reply.normal.abs() * (1.0 + 1e-12);
            match law.coulomb {
                Coulomb::Sum => prop_assert!(reply.tangent.norm() <= limit),
                Coulomb::SpringThenDashpot | Coulomb::Spring => {
                    prop_assert!(pair.kt * book.spring[0].norm() <= limit);
                }
            }
            prop_assert!(reply.tangent.dot(&normal).abs() <= 1e-5 * reply.tangent.norm() + 1e-12);
            prop_assert!(tally.tangential_dashpot >= 0.0);
            prop_assert!(tally.normal_dashpot >= 0.0);
        }

        #[test]
        fn rescaling_keeps_length_and_plane(old in vector(1e-4), tilt in vector(0.3)) {
            let law = Law {
                tension: false,
                coulomb: Coulomb::Sum,
                history: History::Rescaled,
                arm: Arm::Half,
                plane_arm: Arm::Half,
            };
            let normal = (Vec3::z() + tilt).normalize();
            let mut book = Book::open(1, KEPT);
            let flat = Vec3::new(old.x, old.y, 0.0);
            prop_assume!(flat.norm() > 1e-8);
            book.restore(0, Record { spring: flat, ..Record::default() });
            let rule = Rule { law, advance: 1e-6, interval: 1e-6, bare_slip: false };
            let approach = Approach { normal, overlap: 0.0, velocity: Vec3::zeros(), spins: Vec3::zeros() };
            let turned = carry(&rule, &approach, &mut book.view(), 0);
            prop_assert!((turned.norm() / flat.norm() - 1.0).abs() < 1e-12);
            prop_assert!(turned.dot(&normal).abs() < 1e-12 * flat.norm());
        }

        #[test]
        fn a_contact_seen_from_the_other_side_is_the_same(
            law in laws(), velocity in vector(1.0), overlap in 0.0..1e-3f64,
        ) {
            let pair = Contact { kn: 1e4, kt: 7e3, cn: 2.0, ct: 1.0, friction: 0.4 };
            let rule = Rule { law, advance: 1e-6, interval: 1e-6, bare_slip: false };
            let mut forces = [1.0, -1.0].map(|side| {
                let mut book = Book::open(1, KEPT);
                let approach = Approach {
                    normal: Vec3::x() * side,
                    overlap,
                    velocity: velocity * side,
                    spins: Vec3::zeros(),
                };
                let mut tally = Tally::default();
                let reply = respond::<true, true>(&rule, &pair, &approach, &mut book.view(), 0, &mut tally);
                (reply.normal, reply.tangent, tally)
            });
            forces[1].1 = -forces[1].1;
            prop_assert_eq!(forces[0], forces[1]);
        }
    }
}
