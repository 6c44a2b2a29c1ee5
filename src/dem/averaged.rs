//! One contact averaged over the path of a step, with implicit dashpots.
//!
//! Drift–kick–drift evaluates forces once, at the middle of a step. Along the step
//! the gap is taken as linear, g(t) = g_m + ġ (t − Δt/2), so the contact lasts for
//! the part φ of the step in which g < 0; its mean gap there is g_w. The mean force is
//!     f = φ (−kn g_w − cn ġ_m),   ġ_m = ġ + Δt/2 (a − f₀/m + f/m),
//! solved for f: a is the relative acceleration of the last step along the normal,
//! f₀ this contact's own force in it, m the effective mass. Without tension the part
//! of the window in which the force, linear in time, would pull is cut off.
//! The tangential spring ξ stands at the middle of the window,
//! ξ = ξ_n + φ Δt/2 w (0 at entry), and |φ (kt ξ + ct w_m)| ≤ μ f with w_m implicit
//! like ġ_m; w, the sliding velocity at t_n, is taken with the contact plane and the arms of
//! t_n. ξ is kept half a step back, ξ + (φ − 1) Δt/2 w, and the half step to
//! t_n is added with the velocity then known: that is the spring of the energies.
//!
//! Where the Coulomb limit L = μ f/φ cuts a trial force T, the spring goes back along the
//! mean of the old direction n₀ and the new one n₁ (generalised trapezoidal return, Ortiz & Popov
//! 1985, Int. J. Numer. Meth. Engng 21, 1561, with θ = ½): L n₁ = T − λ (n₀ + n₁)/2, |n₁| = 1,
//! so λ = (|T|² − L²)/(L + T·n₀), in closed form. Return along n₁ alone (radial) is of first order
//! while the direction turns, as it does for clumps and spinning spheres; it is used
//! where T·n₀ ≤ 0. A contact with a tangential dashpot begins with the spring that the law
//! asks for at its first moment, kt ξ = −(ct |w| − μ f)₊ w/|w|.
//!
//! Where all contacts persist this is position Verlet. Second order where contacts
//! begin and end; velocity Verlet, Runge–Kutta 4 and their like are of first order
//! there, because a clipped dashpot's force jumps within a step.
//! Source: own; related: Kuhn (2020, slip within a step), Swope et al. (1982, position Verlet).
//!
//! Dissipation is the work that the forces do beyond what springs store; a contact that
//! begins slipping is taken to end its step with twice the spring of its middle.
//! Symbols as in [`super::law`]. Like that law it stands once, for any number of contacts side by
//! side: what is rare (contacts that begin, end, pull or slip) has a branch over all of them
//! where it costs a division or a root. O(1); cannot fail.

use super::lanes::{Lanes, Triple};
use super::law::{BookView, Kind, Parameters, Reply, Rule, Tally, rescale};
use crate::model::{Contact, Coulomb, History};

/// What sits inside the contact loop, known to the compiler. `DRAGS`: tangential dashpots.
#[derive(Debug, Clone, Copy)]
pub struct Averaged<
    const FRICTION: bool,
    const DAMPING: bool,
    const DRAGS: bool,
    const LEDGER: bool,
>;

impl<const FRICTION: bool, const DAMPING: bool, const DRAGS: bool, const LEDGER: bool> Kind
    for Averaged<FRICTION, DAMPING, DRAGS, LEDGER>
{
    const LEDGER: bool = LEDGER;
    const FRICTION: bool = FRICTION;
    const DAMPING: bool = DAMPING;
    const COULOMB: Coulomb = Coulomb::Sum;
    const HISTORY: History = History::Rescaled;
    const AVERAGED: bool = true;
    const DRAGS: bool = DRAGS;
}

/// Contacts, or what may become some, at the middle of a step.
#[derive(Debug, Clone, Copy)]
pub struct Meeting<L = f64> {
    /// Unit vector from the partner towards the sphere.
    pub normal: Triple<L>,
    /// Gap, m; negative in contact.
    pub gap: L,
    /// Velocity of the sphere's contact point relative to the partner's, before the kick, m/s.
    pub velocity: Triple<L>,
    /// The same of the acceleration in the last step, m/s²; with dashpots only, and without
    /// tangential ones of the centres.
    pub pull: Triple<L>,
    /// The velocity at t_n, with the places of then and no part along the normal of then,
    /// m/s; with friction only.
    pub early: Triple<L>,
    /// Inverse effective mass along the normal, 1/kg; with dashpots only.
    pub ease: L,
    /// The same along the sliding velocity; with tangential dashpots only.
    pub across: L,
}

/// What contacts remember of the last step.
#[derive(Clone, Copy)]
pub struct Past<L: Lanes> {
    /// Whether they touched at its end.
    pub touched: L::Mask,
    /// Tangential spring, turned with the contact, m.
    pub spring: Triple<L>,
    /// Normal force, N.
    pub lag: L,
    /// Tangential force, N; with tangential dashpots only.
    pub pull: Triple<L>,
}

/// Mean forces over the step, and what contacts remember of it.
#[derive(Clone, Copy)]
pub struct Answer<L: Lanes> {
    /// Normal force, N, positive when pushing apart; 0 if apart.
    pub normal: L,
    /// Tangential force, N; 0 if apart.
    pub tangent: Triple<L>,
    /// Zeros where the contact has ended.
    pub memory: Past<L>,
    /// Energy taken by the normal dashpot, the tangential dashpot and slip, J; 0 without a ledger.
    pub taken: [L; 3],
}

/// Part of a step in contact, from and to, 0 to 1; meaningless where the mask says no.
#[inline(always)]
pub fn window<L: Lanes>(first: L, last: L) -> (L, L, L::Mask) {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    // Gaps that are not numbers go on, so that the guard sees them.
    let (opens, ends) = (zero.at_most(first), zero.at_most(last));
    let apart = L::both(opens, ends);
    let (mut from, mut to) = (zero, one);
    if L::any(L::both(L::either(opens, ends), L::not(apart))) {
        let crossing = first / (first - last);
        from = L::only(opens, crossing);
        to = L::pick(ends, crossing, one);
    }
    let empty = (to - from).abs().at_most(zero);
    (from, to, L::not(L::either(apart, empty)))
}

/// Mean over a window of forces that are linear in time, with `mean` and `lean`
/// more and less at its ends, where the negative part of those that matter is cut off.
#[inline(always)]
fn pushing<L: Lanes>(mean: L, lean: L, matters: L::Mask) -> L {
    let zero = L::splat(0.0);
    let high = mean + lean;
    let (whole, none) = (lean.at_most(mean), high.at_most(zero));
    let mut push = L::pick(none, zero, mean);
    let clipped = L::both(matters, L::not(L::either(whole, none)));
    if L::any(clipped) {
        push = L::pick(clipped, high * high / (L::splat(4.0) * lean), push);
    }
    L::pick(whole, mean, push)
}

/// These where they are positive, elsewhere 0.
#[inline(always)]
fn positive<L: Lanes>(value: L) -> L {
    L::only(L::splat(0.0).below(value), value)
}

/// Mean forces over the step of the contacts that `live`: those that touched at its
/// beginning, and those that may touch in it.
#[inline(always)]
pub fn respond<L: Lanes, K: Kind>(
    (rule, step): (&Rule, f64),
    pair: &Parameters<L>,
    meeting: &Meeting<L>,
    live: L::Mask,
    past: &Past<L>,
) -> Answer<L> {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let interval = L::splat(rule.interval);
    let half_span = L::splat(0.5 * rule.advance);
    let n = meeting.normal;
    let rate = meeting.velocity.dot(n);
    let half = half_span * rate;
    let (from, to, within) = window(meeting.gap - half, meeting.gap + half);
    let meets = L::both(live, within);
    let part = to - from;
    let mut taken = [zero; 3];
    // Mean over the window; the mean over the step is `part` of it.
    let mut mean = -(pair.kn * (meeting.gap + (from + to - one) * half));
    let mut first = zero;
    if K::DAMPING {
        let elastic = mean * part;
        let free = rate + half_span * (meeting.pull.dot(n) - past.lag * meeting.ease);
        let implicit = half_span * meeting.ease;
        mean = (mean - pair.cn * free) / (one + implicit * pair.cn * part);
        let lean = (pair.kn * part * half).abs();
        if K::DRAGS {
            first = pair.friction * positive(mean - lean);
        }
        if !rule.law.tension {
            mean = pushing(mean, lean, meets);
        }
        let force = mean * part;
        if K::LEDGER {
            let work = interval * (elastic - force) * (free + implicit * force);
            taken[0] = L::only(meets, work);
        }
    }
    let normal = L::only(meets, mean * part);
    let leaves = L::both(meets, to.below(one));
    let stays = L::both(meets, L::not(leaves));
    let mut memory =
        Past { touched: stays, spring: Triple::zero(), lag: zero, pull: Triple::zero() };
    if K::DAMPING {
        memory.lag = L::only(stays, normal);
    }
    let mut tangent = Triple::zero();
    if K::FRICTION {
        let slide = meeting.velocity - n * rate;
        let early = meeting.early - n * meeting.early.dot(n);
        let entry = L::both(meets, L::not(past.touched));
        let drags = if K::DRAGS { zero.below(pair.ct) } else { L::all(false) };
        // Springs and forces of contacts that begin are 0.
        let (mut old, mut back) = (past.spring + early * half_span, past.spring);
        if L::any(entry) {
            let start = if K::DRAGS { begin(pair, early, first, entry) } else { Triple::zero() };
            old = Triple::pick(entry, start, old);
        }
        let way = early * (part * L::splat(rule.advance));
        let trial = old + way * L::splat(0.5);
        let mut sliding = slide;
        if K::DRAGS {
            back = Triple::pick(drags, n * past.pull.dot(n) - past.pull, back);
            let slow =
                implicit_sliding(pair, meeting, (trial, slide), (part, half_span), past.pull);
            sliding = Triple::pick(drags, slow, slide);
        }
        let limit = pair.friction * mean.abs();
        let Cut { spring, dash, force, slips } =
            turn_back::<L, K>(pair, (trial, sliding), limit, back, meets);
        tangent = Triple::only(meets, force * -part);
        let begins_slipping = L::both(L::both(entry, slips), L::not(drags));
        let half_way = way * L::splat(0.5);
        let end = spring + Triple::pick(begins_slipping, spring, half_way);
        if K::DRAGS {
            if K::LEDGER {
                taken[1] = L::only(meets, interval * part * dash.dot(sliding));
            }
            memory.pull = Triple::only(stays, tangent);
        }
        let released = L::both(L::both(live, past.touched), L::not(meets));
        let ends = L::either(leaves, released);
        if K::LEDGER && L::any(L::either(ends, L::either(entry, slips))) {
            let held = L::splat(0.5) * pair.kt * end.dot(end);
            let left = L::splat(0.5) * pair.kt * old.dot(old);
            taken[2] = L::pick(released, left, L::only(leaves, held));
            if rule.interval > 0.0 {
                // All work that the spring did not keep.
                let begun = pair.kt * spring.dot(way) - held;
                let cut = L::splat(0.5) * pair.kt * (trial - way + spring).dot(trial - spring);
                taken[2] = taken[2] + L::pick(entry, begun, L::only(slips, cut));
            }
        }
        memory.spring = Triple::only(stays, end - early * L::splat(0.5 * step));
    }
    Answer { normal, tangent, memory, taken }
}

/// The springs at the first moment of contacts with tangential dashpots, m, where the
/// Coulomb limit is `limit` [N].
#[inline(always)]
fn begin<L: Lanes>(pair: &Parameters<L>, slide: Triple<L>, limit: L, entry: L::Mask) -> Triple<L> {
    let zero = L::splat(0.0);
    let size = slide.dot(slide).sqrt();
    let over = pair.ct * size - limit;
    let both = L::both(zero.below(pair.ct), zero.below(pair.kt));
    let loaded = L::both(L::both(entry, both), zero.below(over));
    Triple::only(loaded, slide * (-over / (pair.kt * size)))
}

/// What the Coulomb limit leaves.
struct Cut<L: Lanes> {
    /// Spring, m.
    spring: Triple<L>,
    /// The dashpot's part of the force, N.
    dash: Triple<L>,
    /// Whole force against the motion, N.
    force: Triple<L>,
    /// Whether anything was cut.
    slips: L::Mask,
}

/// Applies the Coulomb limit to trial springs of contacts that `matter`; `back` has the direction
/// of the force of the step before, or is 0.
#[inline(always)]
fn turn_back<L: Lanes, K: Kind>(
    pair: &Parameters<L>,
    (trial, slide): (Triple<L>, Triple<L>),
    limit: L,
    back: Triple<L>,
    matter: L::Mask,
) -> Cut<L> {
    let (zero, half) = (L::splat(0.0), L::splat(0.5));
    let pull = trial * pair.kt;
    let dash = if K::DRAGS { slide * pair.ct } else { Triple::zero() };
    let total = if K::DRAGS { pull + dash } else { pull };
    let square = total.dot(total);
    let slips = L::both(matter, (limit * limit).below(square));
    if !L::any(slips) {
        return Cut { spring: trial, dash, force: total, slips };
    }
    let springs = zero.below(pair.kt);
    let (ahead, size) = (total.dot(back), back.dot(back));
    let turns = L::both(springs, L::both(zero.below(ahead), zero.below(size)));
    let inverse = L::splat(1.0) / size.sqrt();
    let way = half * (square - limit * limit) / (limit + ahead * inverse);
    // |raw| = limit + way but for rounding and parts of `back` along the normal.
    let raw = Triple::pick(turns, total - back * (way * inverse), total);
    let cut = raw * (limit / raw.dot(raw).sqrt());
    let left = (cut - dash) * pair.soft;
    Cut {
        spring: Triple::pick(L::both(slips, springs), left, trial),
        dash: Triple::pick(L::both(slips, L::not(springs)), cut, dash),
        force: Triple::pick(slips, cut, total),
        slips,
    }
}

/// Sliding velocities at the middle of the step with the contacts' own forces in them.
#[inline(always)]
fn implicit_sliding<L: Lanes>(
    pair: &Parameters<L>,
    meeting: &Meeting<L>,
    (trial, slide): (Triple<L>, Triple<L>),
    (part, half_span): (L, L),
    old: Triple<L>,
) -> Triple<L> {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let others = meeting.pull - old * meeting.across;
    let pull = others - meeting.normal * others.dot(meeting.normal);
    let implicit = half_span * meeting.across * part;
    let free = slide + pull * half_span - trial * (implicit * pair.kt);
    let slow = free * (one / (one + implicit * pair.ct));
    let moves = zero.below(slide.dot(slide));
    Triple::pick(moves, slow, slide)
}

/// Answers at entry `k` of a book: what [`respond`] says, remembered and counted.
#[inline(always)]
pub fn advance<K: Kind>(
    rule: (&Rule, f64),
    pair: &Contact,
    meeting: &Meeting,
    (book, k): (&mut BookView<'_>, usize),
    tally: &mut Tally,
) -> Reply {
    let mut past =
        Past { touched: book.touching[k], spring: Triple::zero(), lag: 0.0, pull: Triple::zero() };
    if K::FRICTION {
        past.spring = rescale::<f64>(book.spring.at(k).into(), meeting.normal);
    }
    if K::DAMPING {
        past.lag = book.lag[k];
    }
    if K::DRAGS {
        past.pull = book.pull.at(k).into();
    }
    let pair = Parameters::of(pair);
    let Answer { normal, tangent, memory, taken } =
        respond::<f64, K>(rule, &pair, meeting, true, &past);
    book.touching[k] = memory.touched;
    if K::FRICTION {
        book.spring.put(k, memory.spring.into());
    }
    if K::DAMPING {
        book.lag[k] = memory.lag;
    }
    if K::DRAGS {
        book.pull.put(k, memory.pull.into());
    }
    tally.normal_dashpot += taken[0];
    tally.tangential_dashpot += taken[1];
    tally.slip += taken[2];
    Reply { normal, tangent: tangent.into() }
}
