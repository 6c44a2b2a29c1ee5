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
//! like ġ_m. It is kept half a step back, ξ + (φ − 1) Δt/2 w, and the half step to
//! t_n is added with the velocity then known: that is the spring of the energies.
//!
//! Where all contacts persist this is position Verlet. Second order where contacts
//! begin and end; velocity Verlet, Runge–Kutta 4 and their like are of first order
//! there, because a clipped dashpot's force jumps within a step. While a contact slips
//! in a turning direction (clumps mostly) the Coulomb limit's radial return is of first order.
//! Source: own; related: Kuhn (2020, slip within a step), Swope et al. (1982, position Verlet).
//!
//! Dissipation is the work that the forces do beyond what springs store; a spring
//! cut in the step in which a contact begins may give back ½ kt of the square of the
//! cut. Symbols as in [`super::law`]. O(1); cannot fail.

use super::law::{BookView, Cut, Reply, Rule, Tally, cut, rescale};
use crate::model::Contact;
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
    /// Relative acceleration of the contact points by free rotation of clumps, m/s².
    pub bend: Vec3,
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
    // Springs need the velocity at t_n, before members of clumps have turned for half a step.
    let early = |step: f64| {
        if FRICTION {
            let bend = meeting.bend - normal * meeting.bend.dot(&normal);
            slide - bend * (0.5 * step)
        } else {
            slide
        }
    };
    let Some((from, to)) = window(meeting.gap - half, meeting.gap + half) else {
        if book.touching[k] {
            release::<FRICTION>(pair, meeting, early(span) * (0.5 * span), book, k, tally);
        }
        return None;
    };
    let part = to - from;
    let elastic = -pair.kn * (meeting.gap + (from + to - 1.0) * half) * part;
    let mut force = elastic;
    if DAMPING {
        let own = book.lag[k][0] * meeting.ease;
        let free = rate + 0.5 * span * (meeting.pull.dot(&normal) - own);
        let drag = pair.cn * part;
        let implicit = 0.5 * span * meeting.ease;
        force = (elastic - drag * free) / (1.0 + implicit * drag);
        if !rule.law.tension {
            force = part * pushing(force / part, (pair.kn * part * half).abs());
        }
        tally.normal_dashpot += rule.interval * (elastic - force) * (free + implicit * force);
    }
    let mut tangent = Vec3::zeros();
    if FRICTION {
        let early = early(span);
        let old = if book.touching[k] {
            rescale(&book.spring[k], &normal) + early * (0.5 * span)
        } else {
            Vec3::zeros()
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
            cut(rule.law.coulomb, pair, trial, sliding, limit);
        tangent = against * -part;
        if rule.interval > 0.0 {
            if slips {
                tally.slip += 0.5 * pair.kt * (trial - way + spring).dot(&(trial - spring));
            }
            if DAMPING {
                tally.tangential_dashpot += rule.interval * part * dash.dot(&sliding);
            }
        }
        book.spring[k] = spring + (way - early * step) * 0.5;
        if to < 1.0 {
            let end = spring + way * 0.5;
            tally.slip += 0.5 * pair.kt * end.norm_squared();
        }
    }
    if to < 1.0 {
        book.clear(k);
    } else {
        book.touching[k] = true;
        if DAMPING {
            book.lag[k] = [force, 0.0];
        }
        if let Some(place) = book.pull.get_mut(k) {
            *place = tangent;
        }
    }
    Some(Reply { normal: force, tangent })
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
        let spring = rescale(&book.spring[k], &meeting.normal) + way;
        tally.slip += 0.5 * pair.kt * spring.norm_squared();
    }
    book.clear(k);
}
