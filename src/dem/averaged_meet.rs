//! Contacts of the path-averaged scheme side by side: what [`super::contacts`] does for the law of
//! the others, in the same groups, with the same sums, on the same processors.
//!
//! First sweep: normals and gaps at the middle of the step, sliding velocities at its
//! beginning, accelerations of the last step, effective masses (see [`super::averaged_pass`]).
//! Members of clumps are then looked at one by one. Second sweep: the law, see [`super::averaged`].
//! The last sweep, and the one that turns springs, are those of [`super::contacts`].
//! O(listed pairs); cannot fail.

use super::averaged::{self, Answer, Meeting, respond};
use super::averaged_pass::{member_at_plane, members};
use super::contacts::{
    ANSWERS, Checked, GROUP, Relative, Scratch, Second, chunk, chunk_mut, entries, follow,
    gathered, groups, groups_mut, relative, version::Version, within,
};
use super::forces::Field;
use super::lanes::{Line, Triple, Wide};
use super::law::{BookView, Kind, Parameters};
use super::planes::drift;
use super::state::Ball;

/// What the second sphere gives to a difference of accelerations, and to sums of all else.
const APART: Line = Line([-1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);

/// All sweeps over the same pairs or planes, of which the first `count` are real.
pub fn sweep<V: Version, K: Kind>(
    field: &Field<'_>,
    pairs: Checked<'_>,
    count: usize,
    (book, base): (&mut BookView<'_>, usize),
    scratch: &mut Scratch,
) {
    let mixed = field.setting.alike.is_none();
    let planes = pairs.kind == Second::Planes;
    let near = (count, &book.touching[base..]);
    macro_rules! with {
        ($friction:literal, $damping:literal) => {
            match (planes, mixed) {
                (true, _) => V::meet_planes::<$friction, $damping>(field, pairs, near, scratch),
                (_, false) => V::meet::<$friction, $damping, false>(field, pairs, near, scratch),
                (_, true) => V::meet::<$friction, $damping, true>(field, pairs, near, scratch),
            }
        };
    }
    match (K::FRICTION, K::DAMPING, K::DRAGS) {
        (false, false, _) => with!(false, 0),
        (false, true, _) => with!(false, 1),
        (true, false, _) => with!(true, 0),
        (true, true, false) => with!(true, 1),
        (true, true, true) => with!(true, 2),
    }
    if (0..pairs.first.len()).step_by(V::WIDE).all(|at| scratch.touches[at] == 0) {
        return;
    }
    if field.memory.has_solids() && (K::FRICTION || K::DAMPING) {
        meet_members::<V, K>(field, pairs, scratch);
    }
    follow::<V, K>(field, (book, base), pairs.first.len(), scratch);
    V::answer::<K>(field, pairs, (book, base), scratch);
    let moving = field.planes.moving;
    match (K::FRICTION, planes, if planes { moving } else { mixed }) {
        (false, false, _) => V::deliver::<0, false>(pairs, scratch),
        (true, false, false) => V::deliver::<1, false>(pairs, scratch),
        (true, false, true) => V::deliver::<1, true>(pairs, scratch),
        (false, true, false) => V::deliver_planes::<false, false>(pairs, scratch),
        (false, true, true) => V::deliver_planes::<false, true>(pairs, scratch),
        (true, true, false) => V::deliver_planes::<true, false>(pairs, scratch),
        (true, true, true) => V::deliver_planes::<true, true>(pairs, scratch),
    }
}

/// Members of clumps: their bodies are asked one by one.
fn meet_members<V: Version, K: Kind>(field: &Field<'_>, pairs: Checked<'_>, scratch: &mut Scratch) {
    for at in 0..pairs.first.len() {
        let bits = scratch.touches[at / V::WIDE * V::WIDE];
        if bits >> (at % V::WIDE) & 1 == 0 {
            continue;
        }
        let slot = pairs.block + usize::from(pairs.first[at]);
        let other = pairs.second[at] as usize;
        let planes = pairs.kind == Second::Planes;
        if field.balls[slot].alone && (planes || field.balls[other].alone) {
            continue;
        }
        let (meeting, arms) = if planes {
            let (meeting, arm) = member_at_plane::<K>(field, slot, other);
            (meeting, [arm, 0.0])
        } else {
            members::<K>(field, slot, other)
        };
        scratch.put_meeting(at, &meeting, arms);
    }
}

/// First sweep over pairs: geometry and motion, of which the first `count` may touch, and some are
/// `touching`; nothing of groups in which no pair is near. `DAMPING`: 0 without dashpots, 1 along normals
/// only, 2 along tangents too.
#[inline(always)]
pub fn meet<
    const W: usize,
    L: Wide<W>,
    const FRICTION: bool,
    const DAMPING: u8,
    const MIXED: bool,
>(
    field: &Field<'_>,
    pairs: Checked<'_>,
    (count, touching): (usize, &[bool]),
    scratch: &mut Scratch,
) {
    let Field { balls, spins, setting, rule, memory, .. } = field;
    assert!(DAMPING == 0 || memory.lines.len() >= balls.len());
    let (share, one) = (L::splat(setting.share), L::splat(1.0));
    let (span, half) = (L::splat(rule.advance), L::splat(0.5 * rule.advance));
    let whole = pairs.first.len() / W;
    let (first, second) = (groups::<W, _>(pairs.first, whole), groups::<W, _>(pairs.second, whole));
    let touching = groups::<W, _>(touching, whole);
    for group in 0..whole {
        let (at, me, them) = (within::<W>(group * W), &first[group], &second[group]);
        let (ours, theirs) = (entries(&balls[pairs.block..], me), entries(balls, them));
        let Relative { between, mut velocity, radii } =
            relative::<W, L, MIXED>(setting, ours, theirs);
        let square = between.dot(between);
        let sum = radii[0] + radii[1];
        // The gap at an end of the step, d − R − Δt/2 |d·v|/d, is positive if d² − R² > Δt |d·v|.
        let apart = (span * between.dot(velocity).abs()).below(square - sum * sum);
        let real = (1u32 << (count - at.min(count)).min(W)) - 1;
        let live = !L::bits(apart) & real as u8 | packed(&touching[group]);
        scratch.touches[at] = live;
        if live == 0 {
            continue;
        }
        let distance = square.sqrt();
        let unit = between * (one / distance);
        let gap = distance - sum;
        scratch.unit.set(at, unit);
        scratch.overlap.set(at, -gap);
        let arms = [radii[0] + share * gap, radii[1] + share * gap];
        if FRICTION {
            let before = between - velocity * half;
            let distance = before.dot(before).sqrt();
            let old = before * (one / distance);
            let depth = share * (distance - sum);
            let (mine, away) = (entries(&spins[pairs.block..], me), entries(spins, them));
            let (early, late) = if MIXED {
                let (mine, away): (Triple<L>, Triple<L>) = (L::triples(mine), L::triples(away));
                let early = mine * (radii[0] + depth) + away * (radii[1] + depth);
                (early, mine * arms[0] + away * arms[1])
            } else {
                let both: Triple<L> = L::triple_sums(mine, away);
                (both * (radii[0] + depth), both * arms[0])
            };
            let slide = velocity + old.cross(early);
            scratch.early.set(at, slide - old * slide.dot(old));
            velocity = velocity + unit.cross(late);
            scratch.arms[0].set(at, arms[0]);
            if MIXED {
                scratch.arms[1].set(at, arms[1]);
            }
        }
        scratch.velocity.set(at, velocity);
        if DAMPING > 0 {
            let (mine, away) =
                (entries(&memory.lines[pairs.block..], me), entries(&memory.lines, them));
            let Past { mut pull, twist, ease, turning } =
                past::<W, L, DAMPING, MIXED>(mine, away, arms);
            if DAMPING > 1 {
                pull = pull + unit.cross(twist);
                scratch.across.set(at, ease + turning);
            }
            scratch.pull.set(at, pull);
            scratch.ease.set(at, ease);
        }
    }
}

/// Lines side by side.
#[inline(always)]
fn columns<const W: usize, L: Wide<W>>(lines: [&Line; W]) -> [L; 8] {
    let mut rows = [L::row(lines[0]); W];
    for l in 1..W {
        rows[l] = L::row(lines[l]);
    }
    L::columns(rows)
}

/// What dashpots need to know of both spheres of a pair.
struct Past<L> {
    /// Relative acceleration of the centres in the last step, m/s².
    pull: Triple<L>,
    /// Sum of arms times angular accelerations, m/s².
    twist: Triple<L>,
    /// Sum of 1/m, 1/kg.
    ease: L,
    /// Sum of arms² / I, 1/kg.
    turning: L,
}

/// Brings the memories of `W` pairs side by side, the turning ones for tangential dashpots only.
#[inline(always)]
fn past<const W: usize, L: Wide<W>, const DAMPING: u8, const MIXED: bool>(
    mine: [&Line; W],
    away: [&Line; W],
    arms: [L; 2],
) -> Past<L> {
    let (twist, turning) = (Triple::zero(), L::splat(0.0));
    if !MIXED {
        let apart = L::row(&APART);
        let mut rows = [apart; W];
        for l in 0..W {
            rows[l] = L::signed_sum(L::row(mine[l]), L::row(away[l]), apart);
        }
        let [x, y, z, ease, u, v, w, light] = L::columns(rows);
        let pull = Triple { x, y, z };
        if DAMPING < 2 {
            return Past { pull, twist, ease, turning };
        }
        let twist = Triple { x: u, y: v, z: w } * arms[0];
        return Past { pull, twist, ease, turning: arms[0] * arms[0] * light };
    }
    let [x, y, z, ease, u, v, w, light] = columns::<W, L>(mine);
    let [p, q, r, more, a, b, c, other] = columns::<W, L>(away);
    let pull = Triple { x, y, z } - Triple { x: p, y: q, z: r };
    let ease = ease + more;
    if DAMPING < 2 {
        return Past { pull, twist, ease, turning };
    }
    let twist = Triple { x: u, y: v, z: w } * arms[0] + Triple { x: a, y: b, z: c } * arms[1];
    Past { pull, twist, ease, turning: arms[0] * arms[0] * light + arms[1] * arms[1] * other }
}

/// The same with planes, whose normals are turned towards the spheres.
#[inline(always)]
pub fn meet_planes<const W: usize, L: Wide<W>, const FRICTION: bool, const DAMPING: u8>(
    field: &Field<'_>,
    pairs: Checked<'_>,
    (count, touching): (usize, &[bool]),
    scratch: &mut Scratch,
) {
    let Field { balls, spins, planes, rule, memory, .. } = field;
    assert!(DAMPING == 0 || memory.lines.len() >= balls.len());
    let (zero, half) = (L::splat(0.0), L::splat(0.5 * rule.advance));
    let whole = pairs.first.len() / W;
    let (first, second) = (groups::<W, _>(pairs.first, whole), groups::<W, _>(pairs.second, whole));
    let touching = groups::<W, _>(touching, whole);
    for group in 0..whole {
        let (at, me, them) = (within::<W>(group * W), &first[group], &second[group]);
        let (ours, theirs) = (entries(&balls[pairs.block..], me), entries(&planes.lines, them));
        let [x, y, z, radius, u, v, w, _] = columns::<W, L>(ours.map(Ball::line));
        let mut velocity = Triple { x: u, y: v, z: w };
        let [px, py, pz, share, nx, ny, nz, _] = columns::<W, L>(theirs);
        let between = Triple { x, y, z } - Triple { x: px, y: py, z: pz };
        let normal = Triple { x: nx, y: ny, z: nz };
        let facing = |height: L| Triple::pick(height.below(zero), normal.map(|n| -n), normal);
        let height = between.dot(normal);
        let unit = facing(height);
        let gap = height.abs() - radius;
        if planes.moving {
            let drift: Triple<L> = drift(field, pairs, at, height);
            scratch.drift.set(at, drift);
            velocity = velocity - drift;
        }
        let reach = half * velocity.dot(normal);
        let real = (1u32 << (count - at.min(count)).min(W)) - 1;
        let live = !L::bits(reach.abs().below(gap)) & real as u8 | packed(&touching[group]);
        scratch.touches[at] = live;
        if live == 0 {
            continue;
        }
        scratch.unit.set(at, unit);
        scratch.overlap.set(at, -gap);
        let arm = radius + gap * share;
        let turn = if FRICTION {
            let before = height - reach;
            let old = facing(before);
            let lever = radius + (before.abs() - radius) * share;
            let spin: Triple<L> = L::triples(entries(&spins[pairs.block..], me));
            let slide = velocity + old.cross(spin * lever);
            scratch.early.set(at, slide - old * slide.dot(old));
            scratch.arms[0].set(at, arm);
            unit.cross(spin * arm)
        } else {
            Triple::zero()
        };
        scratch.velocity.set(at, velocity + turn);
        if DAMPING > 0 {
            let lines = entries(&memory.lines[pairs.block..], me);
            let [x, y, z, light, u, v, w, turning] = columns::<W, L>(lines);
            let mut pull = Triple { x, y, z };
            if DAMPING > 1 {
                pull = pull + unit.cross(Triple { x: u, y: v, z: w } * arm);
                scratch.across.set(at, light + arm * arm * turning);
            }
            scratch.pull.set(at, pull);
            scratch.ease.set(at, light);
        }
    }
}

/// Second sweep: the law; the book's entries begin at `base`.
#[inline(always)]
pub fn answer<const W: usize, L: Wide<W>, K: Kind>(
    field: &Field<'_>,
    pairs: Checked<'_>,
    (book, base): (&mut BookView<'_>, usize),
    scratch: &mut Scratch,
) {
    let (rule, step) = (*field.rule, field.setting.step);
    let only = field.setting.only_law().map(|law| Parameters::of(&law));
    let whole = pairs.first.len() / W;
    let of = |wanted: bool| if wanted { whole } else { 0 };
    let touching = groups_mut::<W, _>(book.touching, base, whole);
    let mut spring = book.spring.groups_mut::<W>(base, of(K::FRICTION));
    let lag = groups_mut::<W, _>(book.lag, base, of(K::DAMPING));
    let mut pulls = book.pull.groups_mut::<W>(base, of(K::DRAGS));
    for group in 0..whole {
        let at = within::<W>(group * W);
        let (live, touched) = (scratch.touches[at], packed(&touching[group]));
        if live == 0 {
            scratch.push.set(at, Triple::<L>::zero());
            scratch.couple.set(at, Triple::<L>::zero());
            continue;
        }
        let (zero, none) = (L::splat(0.0), Triple::zero());
        let mut past =
            averaged::Past { touched: L::mask(touched), spring: none, lag: zero, pull: none };
        let mut meeting = Meeting {
            normal: scratch.unit.get(at),
            gap: -scratch.overlap.get::<W, L>(at),
            velocity: scratch.velocity.get(at),
            pull: none,
            early: none,
            ease: zero,
            across: zero,
        };
        if K::FRICTION {
            past.spring = scratch.before.get(at);
            meeting.early = scratch.early.get(at);
        }
        if K::DAMPING {
            past.lag = L::load(&lag[group]);
            meeting.pull = scratch.pull.get(at);
            meeting.ease = scratch.ease.get(at);
        }
        if K::DRAGS {
            past.pull = pulls.load(group);
            meeting.across = scratch.across.get(at);
        }
        let law = match &only {
            Some(law) => *law,
            None => gathered(field, pairs, at),
        };
        let Answer { normal, tangent, memory, taken } =
            respond::<L, K>((&rule, step), &law, &meeting, L::mask(live), &past);
        touching[group] = *chunk(&ANSWERS[L::bits(memory.touched) as usize], 0);
        let unit = meeting.normal;
        if K::FRICTION {
            spring.store(group, memory.spring);
            scratch.push.set(at, unit * normal + tangent);
            scratch.couple.set(at, unit.cross(tangent));
        } else {
            scratch.push.set(at, unit * normal);
        }
        if K::DAMPING {
            memory.lag.store(&mut lag[group]);
        }
        if K::DRAGS {
            pulls.store(group, memory.pull);
        }
        let ways = if K::LEDGER { 3 } else { 0 };
        for (sums, taken) in scratch.sums[..ways].iter_mut().zip(taken) {
            let sums = chunk_mut(sums, at % GROUP);
            (L::load(sums) + taken).store(sums);
        }
    }
}

/// `W` answers as bits, the first lowest.
#[inline(always)]
fn packed<const W: usize>(answers: &[bool; W]) -> u8 {
    let mut bytes = [0; 8];
    for l in 0..W {
        bytes[l] = u8::from(answers[l]);
    }
    // The product has the lowest bit of byte i at bit 56 + i.
    (u64::from_le_bytes(bytes).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}
