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
//! Symbols as in [`super::law`]. O(1); cannot fail.

use super::law::{self, BookView, Parameters, Reply, Rule, Tally};
use crate::model::{Contact, Coulomb};
use crate::num::Vec3;

/// A contact, or what may become one, at the middle of a step.
#[derive(Debug, Clone, Copy)]
pub struct Meeting {
    /// Unit vector from the partner towards the sphere.
    pub normal: Vec3,
    /// Gap, m; negative in contact.
    pub gap: f64,
    /// Velocity of the sphere's contact point relative to the partner's, before the kick, m/s.
    pub velocity: Vec3,
    /// The same of the acceleration in the last step, m/s²; with dashpots only.
    pub pull: Vec3,
    /// The velocity at t_n, with the places of then and no part along the normal of then,
    /// m/s; with friction only.
    pub early: Vec3,
    /// Inverse effective mass along the normal, 1/kg; with dashpots only.
    pub ease: f64,
}

/// Part of a step in contact: from and to, 0 to 1.
#[inline(always)]
pub fn window(first: f64, last: f64) -> Option<(f64, f64)> {
    // Gaps that are not numbers go on, so that the guard sees them.
    if first >= 0.0 && last >= 0.0 {
        return None;
    }
    let crossing = || first / (first - last);
    let from = if first >= 0.0 { crossing() } else { 0.0 };
    let to = if last >= 0.0 { crossing() } else { 1.0 };
    (from != to).then_some((from, to))
}

/// Mean over a window of a force that is linear in time, with `mean` and `lean`
/// more and less at its ends, where its negative part is cut off.
#[inline(always)]
fn pushing(mean: f64, lean: f64) -> f64 {
    let high = mean + lean;
    if mean - lean >= 0.0 {
        mean
    } else if high <= 0.0 {
        0.0
    } else {
        high * high / (4.0 * lean)
    }
}

/// What the Coulomb limit leaves.
struct Cut {
    /// Spring, m.
    spring: Vec3,
    /// The dashpot's part of the force, N.
    dash: Vec3,
    /// Whole force against the motion, N.
    force: Vec3,
    /// Whether anything was cut.
    slips: bool,
}

/// See [`law::rescale`].
#[inline(always)]
fn rescaled(spring: &Vec3, normal: &Vec3) -> Vec3 {
    law::rescale::<f64>((*spring).into(), (*normal).into()).into()
}

/// Mean force over the step in which entry `k` meets; advances it. `across` gives
/// the inverse effective mass along a tangent. `None` if there is no contact.
#[inline(always)]
pub fn respond<const FRICTION: bool, const DAMPING: bool>(
    (rule, step): (&Rule, f64),
    pair: &Contact,
    meeting: &Meeting,
    across: impl Fn(&Vec3) -> f64,
    book: &mut BookView<'_>,
    k: usize,
    tally: &mut Tally,
) -> Option<Reply> {
    let (span, normal) = (rule.advance, meeting.normal);
    let rate = meeting.velocity.dot(&normal);
    let half = 0.5 * span * rate;
    let slide = meeting.velocity - normal * rate;
    let early =
        if FRICTION { meeting.early - normal * meeting.early.dot(&normal) } else { Vec3::zeros() };
    let Some((from, to)) = window(meeting.gap - half, meeting.gap + half) else {
        if book.touching[k] {
            release::<FRICTION>(pair, meeting, early * (0.5 * span), book, k, tally);
        }
        return None;
    };
    let part = to - from;
    let elastic = -pair.kn * (meeting.gap + (from + to - 1.0) * half) * part;
    let mut force = elastic;
    let mut first = 0.0;
    if DAMPING {
        let own = book.lag[k] * meeting.ease;
        let free = rate + 0.5 * span * (meeting.pull.dot(&normal) - own);
        let drag = pair.cn * part;
        let implicit = 0.5 * span * meeting.ease;
        force = (elastic - drag * free) / (1.0 + implicit * drag);
        let lean = (pair.kn * part * half).abs();
        first = pair.friction * (force / part - lean).max(0.0);
        if !rule.law.tension {
            force = part * pushing(force / part, lean);
        }
        tally.normal_dashpot += rule.interval * (elastic - force) * (free + implicit * force);
    }
    let mut tangent = Vec3::zeros();
    if FRICTION {
        let entry = !book.touching[k];
        let (back, old) = if entry {
            let start = if DAMPING { begin(pair, &early, first) } else { Vec3::zeros() };
            (Vec3::zeros(), start)
        } else {
            let carried = rescaled(&book.spring[k], &normal);
            let back = if DAMPING && pair.ct > 0.0 {
                normal * book.pull[k].dot(&normal) - book.pull[k]
            } else {
                carried
            };
            (back, carried + early * (0.5 * span))
        };
        let way = early * (part * span);
        let trial = old + way * 0.5;
        let mut sliding = slide;
        if DAMPING && pair.ct > 0.0 {
            sliding = implicit_sliding(pair, meeting, (trial, slide), (part, span), across, {
                book.pull[k]
            });
        }
        let limit = pair.friction * force.abs() / part;
        let Cut { spring, dash, force: against, slips } =
            turn_back(pair, trial, sliding, limit, &back);
        tangent = against * -part;
        let plain = !(DAMPING && pair.ct > 0.0);
        let end = if entry && slips && plain { spring * 2.0 } else { spring + way * 0.5 };
        if rule.interval > 0.0 {
            if entry {
                // All work that the spring did not keep.
                let kept = end.norm_squared();
                tally.slip += pair.kt * (spring.dot(&way) - 0.5 * kept);
            } else if slips {
                tally.slip += 0.5 * pair.kt * (trial - way + spring).dot(&(trial - spring));
            }
            if DAMPING {
                tally.tangential_dashpot += rule.interval * part * dash.dot(&sliding);
            }
        }
        book.spring[k] = end - early * (0.5 * step);
        if to < 1.0 {
            tally.slip += 0.5 * pair.kt * end.norm_squared();
        }
    }
    if to < 1.0 {
        book.clear(k);
    } else {
        book.touching[k] = true;
        if DAMPING {
            book.lag[k] = force;
        }
        if let Some(place) = book.pull.get_mut(k) {
            *place = tangent;
        }
    }
    Some(Reply { normal: force, tangent })
}

/// The spring at the first moment of a contact with a tangential dashpot, m, where the
/// Coulomb limit is `limit` [N].
#[inline(always)]
fn begin(pair: &Contact, slide: &Vec3, limit: f64) -> Vec3 {
    let size = slide.norm();
    let over = pair.ct * size - limit;
    if pair.ct > 0.0 && pair.kt > 0.0 && over > 0.0 {
        slide * (-over / (pair.kt * size))
    } else {
        Vec3::zeros()
    }
}

/// Applies the Coulomb limit to a trial spring; `back` has the direction of the force of the
/// step before, or is 0.
#[inline(always)]
fn turn_back(pair: &Contact, trial: Vec3, slide: Vec3, limit: f64, back: &Vec3) -> Cut {
    let dash = slide * pair.ct;
    let total = trial * pair.kt + dash;
    let square = total.norm_squared();
    if square <= limit * limit {
        return Cut { spring: trial, dash, force: total, slips: false };
    }
    let (ahead, length) = (total.dot(back), back.norm());
    if !(ahead > 0.0 && length > 0.0 && pair.kt > 0.0) {
        let (pair, trial, slide) = (Parameters::of(pair), trial.into(), slide.into());
        let law::Cut { spring, dash, force, slips } =
            law::cut(Coulomb::Sum, &pair, trial, slide, limit, true);
        return Cut { spring: spring.into(), dash: dash.into(), force: force.into(), slips };
    }
    let way = 0.5 * (square - limit * limit) / (limit + ahead / length);
    let raw = total - back * (way / length);
    // |raw| = limit + way but for rounding and parts of `back` along the normal.
    let force = raw * (limit / raw.norm());
    Cut { spring: (force - dash) / pair.kt, dash, force, slips: true }
}

/// Sliding velocity at the middle of the step with the contact's own force in it.
#[inline(always)]
fn implicit_sliding(
    pair: &Contact,
    meeting: &Meeting,
    (trial, slide): (Vec3, Vec3),
    (part, span): (f64, f64),
    across: impl Fn(&Vec3) -> f64,
    old: Vec3,
) -> Vec3 {
    let size = slide.norm();
    if size == 0.0 {
        return slide;
    }
    let ease = across(&(slide / size));
    let others = meeting.pull - old * ease;
    let pull = others - meeting.normal * others.dot(&meeting.normal);
    let implicit = 0.5 * span * ease * part;
    (slide + pull * (0.5 * span) - trial * (implicit * pair.kt)) / (1.0 + implicit * pair.ct)
}

/// Closes entry `k`, which touched at the last pass and is apart for the whole step.
#[inline(never)]
fn release<const FRICTION: bool>(
    pair: &Contact,
    meeting: &Meeting,
    way: Vec3,
    book: &mut BookView<'_>,
    k: usize,
    tally: &mut Tally,
) {
    if FRICTION {
        let spring = rescaled(&book.spring[k], &meeting.normal) + way;
        tally.slip += 0.5 * pair.kt * spring.norm_squared();
    }
    book.clear(k);
}
