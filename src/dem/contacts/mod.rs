//! Contacts between the spheres of one block, several pairs side by side, in four sweeps over a
//! few dozen pairs at a time; contacts with planes the same way (first and last sweep: [`super::planes`]), and with
//! triangles (see [`faces`]). The path-averaged scheme has sweeps of its own between (see
//! [`super::averaged_meet`]).
//!
//! A sphere is one line of the cache. First the lines of both spheres of each pair are read whole and
//! their differences turned in registers, so that each quantity of all pairs stands side by
//! side; then springs are turned with their contacts, and the law answers (see [`super::law`]); then forces are turned back into lines and added
//! to both spheres in the order of the list. Pairs that are apart go through the law
//! like the others and get no force: few listed pairs are.
//!
//! The same functions are compiled for eight pairs (AVX-512), four (AVX2) and four on any processor,
//! and chosen when the program runs; each again for the scheme `leapfrog`, which adds products without rounding them first
//! (see [`Setting::fused`]). The first and last sweep do not know the
//! law, the others not the sizes: few versions of each are needed. Pairs are taken in groups of eight, with one sum of each
//! energy for each place in the group: all fused versions give the same bytes, and so do all others.
//! O(listed pairs); cannot fail.

mod columns;
mod faces;
pub mod listed;
#[cfg(test)]
mod tests;
pub mod version;

use columns::Memories;
pub use columns::{Scratch, groups, groups_mut, within};
pub use faces::{Spot, answer_waiting, meet};

use super::averaged_meet;
use super::forces::Field;
#[cfg(target_arch = "x86_64")]
use super::lanes::{Eight, Four};
use super::lanes::{Lanes, Line, Plain, Triple, Wide};
use super::law::{
    self, Approach, BookView, Kind, Parameters, Past, Response, Tally, Variant, respond, softness,
};
use super::planes;
use super::setting::Setting;
use super::state::{Ball, Load};
use super::walls::Hit;
use crate::model::History;
use crate::num::Vec3;
use faces::Waiting;
use listed::{Highest, Listed};
use std::array::from_fn;
use version::Version;

/// Pairs that are taken together, on every processor.
pub const GROUP: usize = 8;

pub const ZEROS: Line = Line([0.0; 8]);
/// What the second sphere gets of a row of force and torque.
const AGAINST: Line = Line([-1.0, -1.0, -1.0, 0.0, 1.0, 1.0, 1.0, 0.0]);

/// Eight answers for each set of bits.
pub const ANSWERS: [[bool; GROUP]; 256] = {
    let mut table = [[false; GROUP]; 256];
    let mut bits = 0;
    while bits < 256 {
        let mut lane = 0;
        while lane < GROUP {
            table[bits][lane] = bits >> lane & 1 == 1;
            lane += 1;
        }
        bits += 1;
    }
    table
};

/// Pairs a sweep: what the sweeps hand each other stays in the innermost cache. A multiple of
/// [`GROUP`].
const SWEEP: usize = 64;

/// Spheres of scenes up to this size stay near the processor by themselves.
const NEAR: usize = 4096;

/// The pairs of a block in the order of the list, or its spheres with the planes near them.
#[derive(Debug, Clone, Copy)]
pub struct Pairs<'a> {
    /// Slot of the first sphere of the block.
    pub block: usize,
    /// Places of the first spheres in the block.
    pub first: &'a [u16],
    /// What the second are: see [`Second`].
    pub second: &'a [u32],
    /// Places of the second in the block: its spheres, then strangers; of spheres only.
    pub seats: &'a [u16],
    /// What kind they are.
    pub kind: Second,
}

/// What spheres meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Second {
    /// Spheres, by their slots.
    Balls,
    /// Planes, by their numbers.
    Planes,
    /// Triangles, by the material of their wall.
    Faces,
}

/// Pairs whose places all exist: see [`check`].
#[derive(Debug, Clone, Copy)]
pub struct Checked<'a>(Pairs<'a>);

impl<'a> std::ops::Deref for Checked<'a> {
    type Target = Pairs<'a>;
    #[inline(always)]
    fn deref(&self) -> &Pairs<'a> {
        &self.0
    }
}

impl<'a> Checked<'a> {
    #[inline(always)]
    fn slice(self, from: usize, to: usize) -> Self {
        let Pairs { block, first, second, seats, kind } = self.0;
        let seats = if kind == Second::Balls { &seats[from..to] } else { &[] };
        Self(Pairs { block, first: &first[from..to], second: &second[from..to], seats, kind })
    }
}

/// Part of the results that belongs to one block.
pub struct Part<'a> {
    /// Its pairs.
    pub pairs: Listed<'a>,
    /// The planes at it.
    pub at_planes: Listed<'a>,
    /// Loads of its spheres.
    pub loads: &'a mut [Load],
    /// Entries of the book that belong to its pairs.
    pub book: BookView<'a>,
    /// The same with planes.
    pub planes: BookView<'a>,
    /// Loads on spheres of later blocks that its pairs reach, in the order of their seats.
    pub strangers: &'a mut [Load],
}

/// The spheres of a pass, while the pairs of a block are answered one sweep after the other.
pub trait Bodies {
    /// Spheres and their angular velocities.
    fn now(&self) -> (&[Ball], &[Vec3]);
    /// Hears that the pass no longer needs the spheres of the block before `place`: they have all of their `pulls`
    /// but those of earlier blocks, and no later pair looks at them, since each stands at its first sphere.
    fn left_behind(&mut self, place: usize, pulls: &mut [Line]);
}

/// Spheres that wait for the end of the pass.
pub struct Waiters<'a>(pub &'a [Ball], pub &'a [Vec3]);

impl Bodies for Waiters<'_> {
    fn now(&self) -> (&[Ball], &[Vec3]) {
        (self.0, self.1)
    }
    fn left_behind(&mut self, _: usize, _: &mut [Line]) {}
}

/// Calls a function with the lanes that this processor has, `$fused` or not.
macro_rules! with_lanes {
    ($fused:literal, $lanes:ident => $call:expr) => {{
        #[cfg(target_arch = "x86_64")]
        {
            if <Eight>::is_here() {
                type $lanes = Eight<$fused>;
                return $call;
            }
            if <Four>::is_here() {
                type $lanes = Four<$fused>;
                return $call;
            }
        }
        type $lanes = Plain<$fused>;
        $call
    }};
}

/// The same for contacts of kind `$kind` in a `$field`, fused where the scheme says so. The kinds of
/// the path-averaged scheme have no fused version: the compiler sees that none is called.
macro_rules! with_lanes_for {
    ($kind:ident, $field:ident, $lanes:ident => $call:expr) => {{
        if $kind::AVERAGED {
            return with_lanes!(false, $lanes => $call);
        }
        if $field.setting.fused {
            return with_lanes!(true, $lanes => $call);
        }
        with_lanes!(false, $lanes => $call)
    }};
}

use {with_lanes, with_lanes_for};

/// Answers the planes at a block. To be followed by triangles, then by [`between`], then by [`finish`] or
/// [`hand_on`].
pub fn at_planes<K: Kind>(field: &Field<'_>, part: &mut Part<'_>, scratch: &mut Scratch) {
    with_lanes_for!(K, field, L => begin::<L, K>(field, part, scratch))
}

/// [`at_planes`] with one version.
fn begin<V: Version, K: Kind>(field: &Field<'_>, part: &mut Part<'_>, scratch: &mut Scratch) {
    (scratch.sums, scratch.power) = ([[0.0; GROUP]; 3], [0.0; GROUP]);
    scratch.pulls.resize(part.loads.len() + part.strangers.len(), ZEROS);
    let mut bodies = Waiters(field.balls, field.spins);
    sweeps::<V, K, _>(field, &mut bodies, part.at_planes, &mut part.planes, scratch);
}

/// Answers all pairs whose first sphere is in the block. `field` need not have the spheres.
pub fn between<K: Kind, B: Bodies>(
    field: &Field<'_>,
    bodies: &mut B,
    part: &mut Part<'_>,
    scratch: &mut Scratch,
) {
    let (list, book) = (part.pairs, &mut part.book);
    with_lanes_for!(K, field, L => sweeps::<L, K, _>(field, bodies, list, book, scratch));
}

/// Sets the loads of a block and of strangers; what its contacts took.
pub fn finish(part: &mut Part<'_>, scratch: &mut Scratch) -> Tally {
    hand_over(part.loads, &mut scratch.pulls[..part.loads.len()]);
    hand_on(part, scratch)
}

/// Sets the loads of strangers; what the contacts of the block took. What acts on its own spheres has been used.
pub fn hand_on(part: &mut Part<'_>, scratch: &mut Scratch) -> Tally {
    hand_over(part.strangers, &mut scratch.pulls[part.loads.len()..]);
    let [normal_dashpot, tangential_dashpot, slip] = scratch.sums.map(|sums| sums.iter().sum());
    let wall_power = scratch.power.iter().sum();
    Tally { normal_dashpot, tangential_dashpot, slip, wall_power, ..Tally::default() }
}

/// [`take`] with the lanes that this processor has.
fn hand_over(loads: &mut [Load], pulls: &mut [Line]) {
    with_lanes!(false, L => L::take(loads, pulls))
}

/// Hands over what was summed, and leaves zeros for the next block while the lines are at hand.
#[inline(always)]
fn take<const W: usize, L: Wide<W>>(loads: &mut [Load], pulls: &mut [Line]) {
    for (load, pull) in loads.iter_mut().zip(pulls) {
        L::keep_six(L::row(pull), load.vectors());
        L::keep(L::row(&ZEROS), pull);
    }
}

/// All pairs, or all planes, with one version.
fn sweeps<V: Version, K: Kind, B: Bodies>(
    field: &Field<'_>,
    bodies: &mut B,
    pairs: Listed<'_>,
    book: &mut BookView<'_>,
    scratch: &mut Scratch,
) {
    let pairs = check(pairs, &field.with(bodies), scratch.pulls.len());
    let whole = pairs.first.len() / GROUP * GROUP;
    for begin in (0..whole).step_by(SWEEP) {
        let field = field.with(bodies);
        if field.balls.len() > NEAR && pairs.kind == Second::Balls {
            let next = begin + SWEEP..(begin + 2 * SWEEP).min(whole);
            let ahead = pairs.second.get(next).unwrap_or_default();
            ahead.iter().for_each(|slot| fetch(&field, *slot as usize));
        }
        let end = (begin + SWEEP).min(whole);
        let swept = pairs.slice(begin, end);
        sweep::<V, K>(&field, swept, end - begin, (book, begin), scratch);
        if let Some(next) = pairs.first.get(end) {
            bodies.left_behind(usize::from(*next), &mut scratch.pulls);
        }
    }
    if whole < pairs.first.len() {
        rest::<V, K>(&field.with(bodies), pairs, book, whole, scratch);
    }
}

/// Asks for what the next sweep reads of a sphere, which stands anywhere near in memory.
#[inline(always)]
fn fetch(field: &Field<'_>, slot: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let ball = field.balls.as_ptr().wrapping_add(slot);
        let spin = field.spins.as_ptr().wrapping_add(slot);
        // SAFETY: fetching has no effect but on time, whatever the address.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(ball.cast());
            _mm_prefetch::<_MM_HINT_T0>(spin.cast());
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (field, slot);
}

/// All three sweeps over the same pairs, see [`approach`].
fn sweep<V: Version, K: Kind>(
    field: &Field<'_>,
    pairs: Checked<'_>,
    count: usize,
    book: (&mut BookView<'_>, usize),
    scratch: &mut Scratch,
) {
    if K::AVERAGED {
        return averaged_meet::sweep::<V, K>(field, pairs, count, book, scratch);
    }
    if pairs.kind == Second::Planes {
        return sweep_planes::<V, K>(field, pairs, count, book, scratch);
    }
    let mixed = field.setting.alike.is_none();
    let turned = K::HISTORY == History::Rotated;
    match (K::FRICTION, turned, mixed) {
        (false, _, false) => V::approach::<0, false>(field, pairs, count, scratch),
        (false, _, true) => V::approach::<0, true>(field, pairs, count, scratch),
        (true, false, false) => V::approach::<1, false>(field, pairs, count, scratch),
        (true, false, true) => V::approach::<1, true>(field, pairs, count, scratch),
        (true, true, false) => V::approach::<2, false>(field, pairs, count, scratch),
        (true, true, true) => V::approach::<2, true>(field, pairs, count, scratch),
    }
    follow::<V, K>(field, (&*book.0, book.1), pairs.first.len(), scratch);
    V::answer::<K>(field, pairs, book, scratch);
    match (K::FRICTION, mixed) {
        (false, _) => V::deliver::<0, false>(pairs, scratch),
        (true, false) => V::deliver::<1, false>(pairs, scratch),
        (true, true) => V::deliver::<1, true>(pairs, scratch),
    }
}

/// See [`carry`].
pub fn follow<V: Version, K: Kind>(
    field: &Field<'_>,
    (book, base): (&BookView<'_>, usize),
    count: usize,
    scratch: &mut Scratch,
) {
    match (K::FRICTION, K::HISTORY) {
        (false, _) => {}
        (true, History::Projected) => V::carry::<0>(field, (book, base), count, scratch),
        (true, History::Rescaled) => V::carry::<1>(field, (book, base), count, scratch),
        (true, History::Rotated) => V::carry::<2>(field, (book, base), count, scratch),
    }
}

/// The same with planes.
fn sweep_planes<V: Version, K: Kind>(
    field: &Field<'_>,
    pairs: Checked<'_>,
    count: usize,
    book: (&mut BookView<'_>, usize),
    scratch: &mut Scratch,
) {
    let moving = field.planes.moving;
    match (K::FRICTION, moving) {
        (false, false) => V::approach_planes::<false, false>(field, pairs, count, scratch),
        (false, true) => V::approach_planes::<false, true>(field, pairs, count, scratch),
        (true, false) => V::approach_planes::<true, false>(field, pairs, count, scratch),
        (true, true) => V::approach_planes::<true, true>(field, pairs, count, scratch),
    }
    follow::<V, K>(field, (&*book.0, book.1), pairs.first.len(), scratch);
    V::answer::<K>(field, pairs, book, scratch);
    match (K::FRICTION, moving) {
        (false, false) => V::deliver_planes::<false, false>(pairs, scratch),
        (false, true) => V::deliver_planes::<false, true>(pairs, scratch),
        (true, false) => V::deliver_planes::<true, false>(pairs, scratch),
        (true, true) => V::deliver_planes::<true, true>(pairs, scratch),
    }
}

/// The last pairs, fewer than a group: the group is filled up with pairs that do not count.
fn rest<V: Version, K: Kind>(
    field: &Field<'_>,
    pairs: Checked<'_>,
    whole: &mut BookView<'_>,
    from: usize,
    scratch: &mut Scratch,
) {
    let count = pairs.first.len() - from;
    fn filled<T: Copy>(slots: &[T]) -> [T; GROUP] {
        from_fn(|l| slots[l.min(slots.len() - 1)])
    }
    let left = pairs.slice(from, pairs.first.len());
    let (first, second) = (filled(left.first), filled(left.second));
    let seats = match left.kind {
        Second::Balls => filled(left.seats),
        _ => [0; GROUP],
    };
    let seats = if left.kind == Second::Balls { &seats[..] } else { &[] };
    let pairs = Pairs { first: &first, second: &second, seats, ..*pairs };
    let pairs = check(Listed::of(pairs), field, scratch.pulls.len());
    let mut few = Memories::<GROUP>::new();
    let (mut book, entries) = (few.view(), from..from + count);
    book.copy::<K>(0..count, whole, entries.clone());
    sweep::<V, K>(field, pairs, count, (&mut book, 0), scratch);
    whole.copy::<K>(entries, &book, 0..count);
}

/// `W` entries from `at`.
#[inline(always)]
pub fn chunk<const W: usize, T>(values: &[T], at: usize) -> &[T; W] {
    // Groups lie within the lists: `at + W` is never above the length.
    values[at..].first_chunk().expect("a whole group")
}

/// `W` entries from `at`, to be written.
#[inline(always)]
pub fn chunk_mut<const W: usize, T>(values: &mut [T], at: usize) -> &mut [T; W] {
    // See `chunk`.
    values[at..].first_chunk_mut().expect("a whole group")
}

/// First sweep: geometry and motion of the pairs, of which the first `count` may touch.
#[inline(always)]
fn approach<const W: usize, L: Wide<W>, const SPINS: u8, const MIXED: bool>(
    field: &Field<'_>,
    pairs: Checked<'_>,
    count: usize,
    scratch: &mut Scratch,
) {
    let Field { balls, spins, setting, yade, .. } = field;
    let own = &balls[pairs.block..];
    let share = L::splat(setting.share);
    let slide_share = L::splat(setting.slide_share);
    let whole = pairs.first.len() / W;
    let (first, second) = (groups::<W, _>(pairs.first, whole), groups::<W, _>(pairs.second, whole));
    for group in 0..whole {
        let (at, me, them) = (within::<W>(group * W), &first[group], &second[group]);
        let Relative { between, mut velocity, radii } =
            relative::<W, L, MIXED>(setting, entries(own, me), entries(balls, them));
        let square = between.dot(between);
        let sum = radii[0] + radii[1];
        let near = if *yade { square.at_most(sum * sum) } else { square.below(sum * sum) };
        scratch.touches[at] = L::bits(near);
        let distance = square.sqrt();
        let unit = between * (L::splat(1.0) / distance);
        let overlap = sum - distance;
        scratch.unit.set(at, unit);
        scratch.overlap.set(at, overlap);
        if SPINS > 0 {
            let arms = radii.map(|radius| radius.minus_product(share, overlap));
            let slides = radii.map(|radius| radius.minus_product(slide_share, overlap));
            let (mine, away) = (entries(&spins[pairs.block..], me), entries(spins, them));
            let spins = if MIXED {
                let (mine, away) = (L::triples(mine), L::triples(away));
                velocity =
                    velocity.plus_cross(unit, (mine * slides[0]).plus_product(away, slides[1]));
                scratch.arms[1].set(at, arms[1]);
                mine + away
            } else {
                let both = L::triple_sums(mine, away);
                velocity = velocity.plus_product(unit.cross(both), slides[0]);
                both
            };
            scratch.arms[0].set(at, arms[0]);
            if SPINS > 1 {
                scratch.spins.set(at, spins);
            }
        }
        scratch.velocity.set(at, velocity);
    }
    scratch.part::<W>(count, whole);
}

/// Pairs of spheres side by side.
pub struct Relative<L> {
    /// Way from the second centre to the first, m.
    pub between: Triple<L>,
    /// Velocity of the first relative to the second, m/s.
    pub velocity: Triple<L>,
    /// Radii, m.
    pub radii: [L; 2],
}

/// The differences of `W` pairs; of `MIXED` sizes or all alike.
#[inline(always)]
pub fn relative<const W: usize, L: Wide<W>, const MIXED: bool>(
    setting: &Setting<'_>,
    ours: [&Ball; W],
    theirs: [&Ball; W],
) -> Relative<L> {
    let mut rows = [L::row(&ZEROS); W];
    for l in 0..W {
        rows[l] = L::difference(L::row(ours[l].line()), L::row(theirs[l].line()));
    }
    let [x, y, z, _, u, v, w, _] = L::columns(rows);
    let (mut between, velocity) = (Triple { x, y, z }, Triple { x: u, y: v, z: w });
    if setting.needs.periodic {
        between = nearest(between, &setting.edges);
    }
    let radii = if MIXED {
        [L::load(&ours.map(|ball| ball.radius)), L::load(&theirs.map(|ball| ball.radius))]
    } else {
        [L::splat(setting.alike.map_or(0.0, |(_, radius)| radius)); 2]
    };
    Relative { between, velocity, radii }
}

/// Ways between spheres in a periodic box with these edges as those to the nearest images, m.
#[inline(always)]
pub fn nearest<L: Lanes>(way: Triple<L>, edges: &Vec3) -> Triple<L> {
    let along = |way: L, edge: f64| {
        let (edge, half, zero) = (L::splat(edge), L::splat(0.5 * edge), L::splat(0.0));
        let back = L::pick(way.below(-half), edge, zero);
        way + L::pick(half.below(way), -edge, back)
    };
    Triple { x: along(way.x, edges.x), y: along(way.y, edges.y), z: along(way.z, edges.z) }
}

/// The springs of the last pass turned with their contacts: a sweep of its own, since what waits for a
/// division here can go on side by side with the next pairs.
#[inline(always)]
fn carry<const W: usize, L: Wide<W>, const HISTORY: u8>(
    field: &Field<'_>,
    (book, base): (&BookView<'_>, usize),
    count: usize,
    scratch: &mut Scratch,
) {
    type Way<const HISTORY: u8> = Variant<true, true, 0, HISTORY, false>;
    let rule = *field.rule;
    let whole = count / W;
    let springs = book.spring.groups::<W>(base, whole);
    let normals = if HISTORY == 2 { book.normal.groups(base, whole) } else { Triple::default() };
    for group in 0..whole {
        let at = within::<W>(group * W);
        let mut old = Past::none();
        let mut spins = Triple::zero();
        old.spring = springs.load(group);
        if HISTORY == 2 {
            old.normal = normals.load(group);
            spins = scratch.spins.get(at);
        }
        let unit = scratch.unit.get(at);
        let before = law::carry::<L, Way<HISTORY>>(&rule, unit, spins, &old);
        scratch.before.set(at, before);
    }
}

/// Second sweep: the law; the book's entries begin at `base`.
#[inline(always)]
fn answer<const W: usize, L: Wide<W>, K: Kind>(
    field: &Field<'_>,
    pairs: Checked<'_>,
    (book, base): (&mut BookView<'_>, usize),
    scratch: &mut Scratch,
) {
    if K::AVERAGED {
        return averaged_meet::answer::<W, L, K>(field, pairs, (book, base), scratch);
    }
    let rule = *field.rule;
    let only = field.setting.only_law().map(|law| Parameters::of(&law));
    let whole = pairs.first.len() / W;
    let of = |wanted: bool| if wanted { whole } else { 0 };
    let touching = groups_mut::<W, _>(book.touching, base, whole);
    let mut spring = book.spring.groups_mut::<W>(base, of(K::FRICTION));
    let turned = K::FRICTION && K::HISTORY == History::Rotated;
    let mut normals = book.normal.groups_mut::<W>(base, of(turned));
    let lags = K::DAMPING && (K::LEDGER || rule.seen);
    let lag = groups_mut::<W, _>(book.lag, base, of(lags));
    let powers = K::FRICTION && K::DAMPING && K::LEDGER;
    let power = groups_mut::<W, _>(book.power, base, of(powers));
    for group in 0..whole {
        let at = within::<W>(group * W);
        let mut old = Past::none();
        let mut before = Triple::zero();
        if K::FRICTION {
            before = scratch.before.get(at);
        }
        if K::DAMPING && K::LEDGER {
            old.lag = L::load(&lag[group]);
        }
        if powers {
            old.power = L::load_single(&power[group]);
        }
        let approach = Approach {
            normal: scratch.unit.get(at),
            overlap: scratch.overlap.get(at),
            velocity: scratch.velocity.get(at),
            spins: Triple::zero(),
        };
        let law = match &only {
            Some(law) => *law,
            None => gathered(field, pairs, at),
        };
        let bits = scratch.touches[at];
        let Response { normal, tangent, past, taken } =
            respond::<L, K>(&rule, &law, &approach, L::mask(bits), (&old, before));
        touching[group] = *chunk(&ANSWERS[bits as usize], 0);
        let unit = approach.normal;
        if K::FRICTION {
            spring.store(group, past.spring);
            if K::HISTORY == History::Rotated {
                normals.store(group, past.normal);
            }
            scratch.push.set(at, tangent.plus_product(unit, normal));
            scratch.couple.set(at, unit.cross(tangent));
        } else {
            scratch.push.set(at, unit * normal);
        }
        if lags {
            past.lag.store(&mut lag[group]);
        }
        if powers {
            past.power.store_single(&mut power[group]);
        }
        // Without friction nothing else takes energy.
        let ways = if K::FRICTION { 3 } else { usize::from(K::DAMPING) };
        let ways = if K::LEDGER { ways } else { 0 };
        for (sums, taken) in scratch.sums[..ways].iter_mut().zip(taken) {
            let sums = chunk_mut(sums, at % GROUP);
            (L::load(sums) + taken).store(sums);
        }
    }
}

/// Third sweep: adds the forces to the lines of both spheres.
#[inline(always)]
fn deliver<const W: usize, L: Wide<W>, const SPINS: u8, const MIXED: bool>(
    pairs: Checked<'_>,
    scratch: &mut Scratch,
) {
    let zero = L::splat(0.0);
    let whole = pairs.first.len() / W;
    let (first, seats) = (groups::<W, _>(pairs.first, whole), groups::<W, _>(pairs.seats, whole));
    for group in 0..whole {
        let (at, me, seats) = (within::<W>(group * W), &first[group], &seats[group]);
        let push: Triple<L> = scratch.push.get(at);
        let (mut turn, mut back) = (Triple::zero(), Triple::zero());
        if SPINS > 0 {
            let couple: Triple<L> = scratch.couple.get(at);
            let arms: [L; 2] = [scratch.arms[0].get(at), scratch.arms[1].get(at)];
            turn = couple * -arms[0];
            back = couple * -arms[1];
        }
        let rows = L::rows([push.x, push.y, push.z, zero, turn.x, turn.y, turn.z, zero]);
        let mut against = rows;
        if MIXED {
            against = L::rows([push.x, push.y, push.z, zero, back.x, back.y, back.z, zero]);
        }
        for l in 0..W {
            // SAFETY: `check` has made sure of both places.
            let pull = unsafe { scratch.pulls.get_unchecked_mut(me[l] as usize) };
            add::<W, L, SPINS>(rows[l], pull);
            // SAFETY: see above.
            let pull = unsafe { scratch.pulls.get_unchecked_mut(seats[l] as usize) };
            oppose::<W, L, SPINS>(against[l], pull);
        }
    }
}

/// Adds a row to a line; without friction there are no torques.
#[inline(always)]
pub fn add<const W: usize, L: Wide<W>, const SPINS: u8>(row: L::Row, line: &mut Line) {
    if SPINS > 0 {
        L::keep(L::sum(L::row(line), row), line);
    } else {
        L::add_half(row, line);
    }
}

/// Adds a row to the line of the other sphere, which feels the force the other way round and its torque as it is.
#[inline(always)]
fn oppose<const W: usize, L: Wide<W>, const SPINS: u8>(row: L::Row, line: &mut Line) {
    if SPINS > 0 {
        L::keep(L::signed_sum(L::row(line), row, L::row(&AGAINST)), line);
    } else {
        L::take_half(row, line);
    }
}

/// Panics if a place of one of the pairs may not exist, in the `field` or among as many `pulls`: so no access in
/// the sweeps has a branch.
#[inline(always)]
fn check<'a>(pairs: Listed<'a>, field: &Field<'_>, pulls: usize) -> Checked<'a> {
    let count = match field.spins.len() {
        0 => field.balls.len(),
        spins => spins.min(field.balls.len()),
    };
    let Highest { first, second, seat } = pairs.highest();
    let there = match pairs.kind {
        Second::Balls => second < count,
        Second::Planes => second < field.planes.lines.len(),
        Second::Faces => true,
    };
    let all = first.max(seat) < pulls && pairs.block + first < count && there;
    assert!(all || pairs.first.is_empty() && pairs.second.is_empty() && pairs.seats.is_empty());
    Checked(*pairs)
}

/// The values at these places, which exist: see [`check`].
#[inline(always)]
pub fn entries<'a, const W: usize, T, I: Place>(values: &'a [T], places: &[I; W]) -> [&'a T; W] {
    // SAFETY: the places exist.
    let at = |place: I| unsafe { values.get_unchecked(place.number()) };
    let mut found = [at(places[0]); W];
    for l in 1..W {
        found[l] = at(places[l]);
    }
    found
}

/// A number of a sphere.
pub trait Place: Copy {
    /// As an index.
    fn number(self) -> usize;
}

impl Place for u16 {
    #[inline(always)]
    fn number(self) -> usize {
        usize::from(self)
    }
}

impl Place for u32 {
    #[inline(always)]
    fn number(self) -> usize {
        self as usize
    }
}

/// Parameters of as many pairs.
#[inline(always)]
pub fn gathered<const W: usize, L: Wide<W>>(
    field: &Field<'_>,
    list: Checked<'_>,
    at: usize,
) -> Parameters<L> {
    let (me, them) = (chunk::<W, _>(list.first, at), chunk::<W, _>(list.second, at));
    let mut pairs = [field.setting.pair(0, 0); W];
    for l in 0..W {
        let (one, other) = (&field.balls[list.block + usize::from(me[l])], them[l] as usize);
        let other = match list.kind {
            Second::Balls => field.balls[other].material,
            Second::Planes => field.planes.now[other].material,
            Second::Faces => other as u16,
        };
        pairs[l] = field.setting.pair(one.material, other);
    }
    Parameters {
        kn: L::load(&pairs.map(|pair| pair.kn)),
        kt: L::load(&pairs.map(|pair| pair.kt)),
        cn: L::load(&pairs.map(|pair| pair.cn)),
        ct: L::load(&pairs.map(|pair| pair.ct)),
        friction: L::load(&pairs.map(|pair| pair.friction)),
        soft: L::load(&pairs.map(softness)),
    }
}
