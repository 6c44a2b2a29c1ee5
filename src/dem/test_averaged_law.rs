//! The law of the path-averaged scheme, side by side and without branches, against the same law as
//! it reads: one contact, plain vectors, a branch for each case.

use super::averaged::{Averaged, Meeting, advance};
use super::law::{self, Book, BookView, Kept, Parameters, Reply, Rule, Slip, Tally};
use super::test_scenes::contact;
use crate::model::{Contact, Coulomb, Scheme};
use crate::num::Vec3;
use crate::num::random::{self, uniform};

/// How often each case came.
#[derive(Debug, Default)]
struct Cases {
    begins: u32,
    ends: u32,
    grazes: u32,
    stays: u32,
    leaves: u32,
    slips: u32,
    pulls: u32,
}

/// What happens at one contact, in plain vectors.
#[derive(Debug)]
struct Met {
    normal: Vec3,
    gap: f64,
    velocity: Vec3,
    pull: Vec3,
    early: Vec3,
    ease: f64,
}

/// Part of a step in contact: from and to, 0 to 1.
fn window(first: f64, last: f64) -> Option<(f64, f64)> {
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
fn rescaled(spring: &Vec3, normal: &Vec3) -> Vec3 {
    law::rescale::<f64>((*spring).into(), (*normal).into()).into()
}

/// Mean force over the step in which entry `k` meets; advances it. `across` gives
/// the inverse effective mass along a tangent. `None` if there is no contact.
fn answered<const FRICTION: bool, const DAMPING: bool>(
    (rule, step): (&Rule, f64),
    pair: &Contact,
    meeting: &Met,
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
            let carried = rescaled(&book.spring.at(k), &normal);
            let back = if DAMPING && pair.ct > 0.0 {
                normal * book.pull.at(k).dot(&normal) - book.pull.at(k)
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
                book.pull.at(k)
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
        book.spring.put(k, end - early * (0.5 * step));
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
        if !book.pull.is_empty() {
            book.pull.put(k, tangent);
        }
    }
    Some(Reply { normal: force, tangent })
}

/// The spring at the first moment of a contact with a tangential dashpot, m, where the
/// Coulomb limit is `limit` [N].
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
fn implicit_sliding(
    pair: &Contact,
    meeting: &Met,
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
fn release<const FRICTION: bool>(
    pair: &Contact,
    meeting: &Met,
    way: Vec3,
    book: &mut BookView<'_>,
    k: usize,
    tally: &mut Tally,
) {
    if FRICTION {
        let spring = rescaled(&book.spring.at(k), &meeting.normal) + way;
        tally.slip += 0.5 * pair.kt * spring.norm_squared();
    }
    book.clear(k);
}

/// A random contact: gaps, speeds and memories so that every case is common.
fn draw(source: &mut random::Stream, drags: bool) -> (Contact, Met, f64, Book) {
    let mut vector = |size: f64| Vec3::from_fn(|_, _| uniform(source, -size, size));
    let (normal, velocity, early) = (vector(1.0).normalize(), vector(1.0), vector(1.0));
    let (pull, spring, force) = (vector(300.0), vector(1.0), vector(3.0));
    let mut number = |low: f64, high: f64| uniform(source, low, high);
    let ct = if drags && number(0.0, 1.0) < 0.7 { number(0.5, 8.0) } else { 0.0 };
    let kt = if number(0.0, 1.0) < 0.9 { 3e3 } else { 0.0 };
    let pair = contact(kt, number(0.0, 12.0), ct, number(0.0, 0.6));
    let (ease, across) = (number(50.0, 300.0), number(100.0, 600.0));
    let reach = (0.5 * STEP * velocity.dot(&normal)).abs();
    let deep = number(0.0, 1.0);
    let gap = if deep < 0.5 { number(-1.2, 1.2) * reach } else { number(-20.0, 1.0) * reach };
    let met = Met { normal, gap, velocity, pull, early: early - normal * 0.2, ease };
    let mut book = Book::open(
        1,
        Kept { friction: true, damping: true, normals: false, pulls: drags, ledger: true },
    );
    if number(0.0, 1.0) < 0.6 {
        let flat = |v: Vec3| v - normal * (0.999 * v.dot(&normal));
        book.touching[0] = true;
        book.spring.put(0, flat(spring) * (10f64.powf(number(-2.0, 1.0)) * STEP));
        book.lag[0] = number(-0.5, 3.0);
        if drags {
            book.pull.put(0, flat(force));
        }
    }
    (pair, met, across, book)
}

const STEP: f64 = 1e-4;

/// Compares one kind over many contacts.
fn compare<const FRICTION: bool, const DAMPING: bool, const DRAGS: bool>(cases: &mut Cases) {
    let mut source = random::stream(11, "meetings", u64::from(DRAGS));
    for number in 0..6000 {
        let (mut pair, met, across, mut book) = draw(&mut source, DRAGS);
        if !DAMPING {
            pair.cn = 0.0;
        }
        let law = law_of(number % 2 == 0);
        let interval = if number % 5 == 0 { 0.0 } else { STEP };
        let rule = Rule { law, advance: STEP, interval, slip: Slip::Cut, seen: true };
        let meeting = Meeting {
            normal: met.normal.into(),
            gap: met.gap,
            velocity: met.velocity.into(),
            pull: met.pull.into(),
            early: met.early.into(),
            ease: met.ease,
            across,
        };
        let (mut theirs, touched) = (book.clone(), book.touching[0]);
        let (mut mine, mut other) = (Tally::default(), Tally::default());
        let here = advance::<Averaged<FRICTION, DAMPING, DRAGS, true>>(
            (&rule, STEP),
            &pair,
            &meeting,
            (&mut book.view(), 0),
            &mut mine,
        );
        let there = answered::<FRICTION, DAMPING>(
            (&rule, STEP),
            &pair,
            &met,
            |_| across,
            &mut theirs.view(),
            0,
            &mut other,
        );
        let answer = there.unwrap_or(Reply { normal: 0.0, tangent: Vec3::zeros() });
        let name = format!("{number} {pair:?} {met:?} {here:?} {there:?}");
        let close = |a: f64, b: f64, scale: f64| (a - b).abs() <= 1e-11 * scale;
        let scale = 1.0 + answer.normal.abs() + answer.tangent.norm();
        assert!(close(here.normal, answer.normal, scale), "{name}");
        assert!((here.tangent - answer.tangent).norm() <= 1e-11 * scale, "{name}");
        assert_eq!(book.touching, theirs.touching, "{name}");
        if FRICTION {
            let size = 1e-3 + theirs.spring.at(0).norm();
            assert!((book.spring.at(0) - theirs.spring.at(0)).norm() <= 1e-11 * size, "{name}");
        }
        if DAMPING {
            assert!(close(book.lag[0], theirs.lag[0], scale), "{name}");
        }
        if DRAGS {
            assert!((book.pull.at(0) - theirs.pull.at(0)).norm() <= 1e-11 * scale, "{name}");
        }
        for (a, b) in [
            (mine.normal_dashpot, other.normal_dashpot),
            (mine.tangential_dashpot, other.tangential_dashpot),
            (mine.slip, other.slip),
        ] {
            assert!(close(a, b, 1e-3 + b.abs()), "{a} {b} {name}");
        }
        let stays = book.touching[0];
        cases.begins += u32::from(there.is_some() && !touched && stays);
        cases.ends += u32::from(there.is_some() && touched && !stays);
        cases.grazes += u32::from(there.is_some() && !touched && !stays);
        cases.stays += u32::from(there.is_some() && touched && stays);
        cases.leaves += u32::from(there.is_none() && touched);
        cases.slips += u32::from(stays && other.slip > 0.0);
        cases.pulls += u32::from(answer.normal < 0.0);
    }
}

fn law_of(tension: bool) -> crate::model::Law {
    crate::model::Law { tension, ..Scheme::PathAveraged.law() }
}

#[test]
fn the_law_side_by_side_is_the_law_as_it_reads() {
    let mut cases = Cases::default();
    compare::<false, false, false>(&mut cases);
    compare::<false, true, false>(&mut cases);
    compare::<true, false, false>(&mut cases);
    compare::<true, true, false>(&mut cases);
    compare::<true, true, true>(&mut cases);
    let Cases { begins, ends, grazes, stays, leaves, slips, pulls } = cases;
    let least = [begins, ends, grazes, stays, leaves, slips, pulls].into_iter().min();
    assert!(least > Some(300), "{cases:?}");
}
