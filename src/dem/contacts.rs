//! Contacts between the spheres of one block, in three sweeps over a few dozen pairs at a
//! time: what the law needs of both spheres is gathered into lines of four numbers; the
//! law is answered for all pairs in one loop without branches, which the compiler turns
//! into vector code; forces are added to the spheres.
//!
//! The middle loop is compiled a second time for processors with AVX2 and chosen when the
//! program runs. Neither version contracts or reorders sums, so both give the same bytes.
//! Pairs that are apart go through the law like the others and get no force: few listed
//! pairs are. O(listed pairs); cannot fail.

use super::forces::Field;
use super::law::{Approach, BookView, Kind, Record, Response, Rule, Tally, respond};
use super::state::Load;
use crate::model::{Contact, History};
use crate::num::Vec3;
use std::ops::Range;

/// Pairs a sweep: what they need and give stays in the innermost cache.
const SWEEP: usize = 128;

/// Four numbers that are read and written together.
type Line = [f64; 4];

/// Force [N] and torque [N m]; the fourth numbers mean nothing.
pub type Pull = [Line; 2];

/// Arrays of one sweep, and sums over the block.
#[derive(Debug)]
pub struct Scratch {
    /// Centre to centre, m.
    between: Vec<Line>,
    /// Fourth first: relative velocity, m/s.
    moving: Vec<Line>,
    /// Angular velocity of the first, rad/s, and its radius, m; sum of both angular
    /// velocities where all spheres are alike.
    mine: Vec<Line>,
    /// Angular velocity of the second, rad/s, and its radius, m.
    theirs: Vec<Line>,
    /// Parameters.
    laws: Vec<Contact>,
    /// Force on the first, N; its arm, m.
    force: Vec<Line>,
    /// Normal × tangential force, N; arm of the second, m. Where all spheres are alike the
    /// torque taken from each, N m.
    couple: Vec<Line>,
    /// Energies taken, J.
    taken: Vec<Line>,
    /// On each sphere of the block.
    pulls: Vec<Pull>,
}

const NO_LAW: Contact = Contact { kn: 0.0, kt: 0.0, cn: 0.0, ct: 0.0, friction: 0.0 };

impl Default for Scratch {
    fn default() -> Self {
        let lines = || vec![[0.0; 4]; SWEEP];
        Self {
            between: lines(),
            moving: lines(),
            mine: lines(),
            theirs: lines(),
            laws: vec![NO_LAW; SWEEP],
            force: lines(),
            couple: lines(),
            taken: lines(),
            pulls: Vec::new(),
        }
    }
}

impl Scratch {
    /// In a periodic box: ways between spheres become those to the nearest images.
    #[inline(always)]
    fn nearest(&mut self, field: &Field<'_>, count: usize) {
        if field.setting.needs.periodic {
            for [x, y, z, _] in &mut self.between[..count] {
                let way = field.setting.way(Vec3::new(*x, *y, *z));
                (*x, *y, *z) = (way.x, way.y, way.z);
            }
        }
    }

    /// Bytes that it takes.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        SWEEP * (7 * size_of::<Line>() + size_of::<Contact>()) + self.pulls.capacity() * 64
    }
}

/// Both spheres of each pair of the block, in the order of the list.
pub type Pairs<'a> = (&'a [u32], &'a [u32]);

/// What the law of all pairs of a pass has in common.
#[derive(Debug, Clone, Copy)]
struct Common {
    rule: Rule,
    /// Parameters and radius, if all spheres are alike.
    law: Contact,
    radius: f64,
    /// Part of the overlap taken from the radius to give the lever arm of the torque.
    share: f64,
    /// The same for the sliding velocity.
    slide_share: f64,
    /// Whether spheres at overlap 0 touch.
    kiss: bool,
}

/// Part of the results that belongs to one block.
pub struct Part<'a> {
    /// First sphere.
    pub first: usize,
    /// Their loads: those of pairs within the block.
    pub loads: &'a mut [Load],
    /// Entries of the book that belong to its pairs.
    pub book: BookView<'a>,
    /// Pulls on spheres of later blocks, in the order of the list.
    pub outbox: &'a mut Vec<Pull>,
}

/// Answers all pairs whose first sphere is in the block: sets its loads, fills its outbox.
pub fn block<K: Kind>(
    field: &Field<'_>,
    pairs: Pairs<'_>,
    part: &mut Part<'_>,
    scratch: &mut Scratch,
) -> Tally {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2, which is all that the function asks for.
        return unsafe { block_avx2::<K>(field, pairs, part, scratch) };
    }
    block_anywhere::<K, false>(field, pairs, part, scratch)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn block_avx2<K: Kind>(
    field: &Field<'_>,
    pairs: Pairs<'_>,
    part: &mut Part<'_>,
    scratch: &mut Scratch,
) -> Tally {
    block_anywhere::<K, true>(field, pairs, part, scratch)
}

#[inline(always)]
fn block_anywhere<K: Kind, const AVX2: bool>(
    field: &Field<'_>,
    pairs: Pairs<'_>,
    part: &mut Part<'_>,
    scratch: &mut Scratch,
) -> Tally {
    let (law, radius) = field.setting.alike.unwrap_or((NO_LAW, 0.0));
    let common = Common {
        rule: *field.rule,
        law,
        radius,
        share: field.setting.share,
        slide_share: field.setting.slide_share,
        kiss: field.yade,
    };
    part.outbox.clear();
    scratch.pulls.clear();
    scratch.pulls.resize(part.loads.len(), [[0.0; 4]; 2]);
    let mut sums = [0.0; 4];
    let mut begin = 0;
    for (first, second) in pairs.0.chunks(SWEEP).zip(pairs.1.chunks(SWEEP)) {
        let count = first.len();
        let entries = begin..begin + count;
        begin += count;
        if field.setting.alike.is_some() {
            gather::<K, false>(field, (first, second), scratch);
            scratch.nearest(field, count);
            answer::<K, false, AVX2>(&common, scratch, &mut part.book, entries);
            scatter::<K, false>((first, second), part, scratch);
        } else {
            gather::<K, true>(field, (first, second), scratch);
            scratch.nearest(field, count);
            answer::<K, true, AVX2>(&common, scratch, &mut part.book, entries);
            scatter::<K, true>((first, second), part, scratch);
        }
        for line in &scratch.taken[..count] {
            for (sum, taken) in sums.iter_mut().zip(line) {
                *sum += taken;
            }
        }
    }
    for (load, [force, torque]) in part.loads.iter_mut().zip(&scratch.pulls) {
        load.force = Vec3::new(force[0], force[1], force[2]);
        load.torque = Vec3::new(torque[0], torque[1], torque[2]);
    }
    Tally {
        normal_dashpot: sums[0],
        tangential_dashpot: sums[1],
        slip: sums[2],
        ..Tally::default()
    }
}

/// Brings what the law needs of both spheres side by side.
#[inline(always)]
fn gather<K: Kind, const MIXED: bool>(
    field: &Field<'_>,
    (first, second): Pairs<'_>,
    scratch: &mut Scratch,
) {
    let (balls, spins) = (field.balls, field.spins);
    let lines = scratch.between.iter_mut().zip(&mut scratch.moving);
    for ((i, j), (between, moving)) in first.iter().zip(second).zip(lines) {
        let (me, them) = (&balls[*i as usize], &balls[*j as usize]);
        // Four numbers that stand side by side in memory: the fourth is not used.
        *between = [
            me.place.x - them.place.x,
            me.place.y - them.place.y,
            me.place.z - them.place.z,
            me.radius - them.radius,
        ];
        *moving = [
            me.radius - them.radius,
            me.velocity.x - them.velocity.x,
            me.velocity.y - them.velocity.y,
            me.velocity.z - them.velocity.z,
        ];
    }
    if MIXED {
        let lines = scratch.mine.iter_mut().zip(&mut scratch.theirs).zip(&mut scratch.laws);
        for ((i, j), ((mine, theirs), law)) in first.iter().zip(second).zip(lines) {
            let (me, them) = (&balls[*i as usize], &balls[*j as usize]);
            (mine[3], theirs[3]) = (me.radius, them.radius);
            if K::FRICTION {
                let (spin, away) = (&spins[*i as usize], &spins[*j as usize]);
                *mine = [spin.x, spin.y, spin.z, me.radius];
                *theirs = [away.x, away.y, away.z, them.radius];
            }
            *law = *field.setting.pair(me.material, them.material);
        }
    } else if K::FRICTION {
        for ((i, j), mine) in first.iter().zip(second).zip(&mut scratch.mine) {
            let (spin, away) = (&spins[*i as usize], &spins[*j as usize]);
            *mine = [spin.x + away.x, spin.y + away.y, spin.z + away.z, 0.0];
        }
    }
}

/// `a + b s`.
#[inline(always)]
fn sum(a: &Line, b: &Line, s: f64) -> Line {
    [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s, a[3] + b[3] * s]
}

/// Adds the forces of a sweep to the spheres, in the order of the list.
#[inline(always)]
fn scatter<K: Kind, const MIXED: bool>(
    (first, second): Pairs<'_>,
    part: &mut Part<'_>,
    scratch: &mut Scratch,
) {
    let Scratch { force, couple, pulls, .. } = scratch;
    let lines = force.iter().zip(&*couple);
    for ((i, j), (force, couple)) in first.iter().zip(second).zip(lines) {
        let (arm, reach) = if MIXED { (force[3], couple[3]) } else { (1.0, 1.0) };
        let [push, turn] = &mut pulls[*i as usize - part.first];
        *push = sum(push, force, 1.0);
        if K::FRICTION {
            *turn = sum(turn, couple, -arm);
        }
        if let Some([away, spin]) = pulls.get_mut(*j as usize - part.first) {
            *away = sum(away, force, -1.0);
            if K::FRICTION {
                *spin = sum(spin, couple, -reach);
            }
        } else {
            let spin = if K::FRICTION { couple.map(|c| -c * reach) } else { [0.0; 4] };
            part.outbox.push([force.map(|f| -f), spin]);
        }
    }
}

/// Chooses the version of [`law_loop`] that this processor runs.
#[inline(always)]
fn answer<K: Kind, const MIXED: bool, const AVX2: bool>(
    common: &Common,
    scratch: &mut Scratch,
    book: &mut BookView<'_>,
    entries: Range<usize>,
) {
    let count = entries.len();
    let of = |kept: bool| if kept { entries.clone() } else { 0..0 };
    let (a, b) = (&scratch.between[..count], &scratch.moving[..count]);
    let (c, d) = (&scratch.mine[..count], &scratch.theirs[..count]);
    let (e, f) = (&scratch.laws[..count], &mut book.touching[entries.clone()]);
    let (g, h) = (&mut book.spring[of(K::FRICTION)], &mut book.lag[of(K::DAMPING)]);
    let i = &mut book.normal[of(K::FRICTION && K::HISTORY == History::Rotated)];
    let (j, k) = (&mut scratch.force[..count], &mut scratch.couple[..count]);
    let l = &mut scratch.taken[..count];
    #[cfg(target_arch = "x86_64")]
    if AVX2 {
        // SAFETY: only `block_avx2` asks for this version.
        unsafe { law_loop_avx2::<K, MIXED>(common, a, b, c, d, e, f, g, h, i, j, k, l) };
        return;
    }
    law_loop::<K, MIXED>(common, a, b, c, d, e, f, g, h, i, j, k, l);
}

/// [`law_loop`] for processors with AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline(never)]
#[allow(clippy::too_many_arguments)] // separate slices: only so does the compiler know that they do not overlap
fn law_loop_avx2<K: Kind, const MIXED: bool>(
    common: &Common,
    between: &[Line],
    moving: &[Line],
    mine: &[Line],
    theirs: &[Line],
    laws: &[Contact],
    touching: &mut [bool],
    spring: &mut [Vec3],
    lag: &mut [[f64; 2]],
    normal: &mut [Vec3],
    force: &mut [Line],
    couple: &mut [Line],
    taken: &mut [Line],
) {
    law_loop::<K, MIXED>(
        common, between, moving, mine, theirs, laws, touching, spring, lag, normal, force, couple,
        taken,
    );
}

/// The law for every pair of a sweep.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // see `law_loop_avx2`
fn law_loop<K: Kind, const MIXED: bool>(
    common: &Common,
    between: &[Line],
    moving: &[Line],
    mine: &[Line],
    theirs: &[Line],
    laws: &[Contact],
    touching: &mut [bool],
    spring: &mut [Vec3],
    lag: &mut [[f64; 2]],
    normal: &mut [Vec3],
    force: &mut [Line],
    couple: &mut [Line],
    taken: &mut [Line],
) {
    let Common { rule, law, radius, share, slide_share, kiss } = *common;
    let rotated = K::HISTORY == History::Rotated;
    let count = between.len();
    let (moving, mine, theirs) = (&moving[..count], &mine[..count], &theirs[..count]);
    let (laws, touching) = (&laws[..count], &mut touching[..count]);
    let spring = if K::FRICTION { &mut spring[..count] } else { spring };
    let lag = if K::DAMPING { &mut lag[..count] } else { lag };
    let normal = if K::FRICTION && rotated { &mut normal[..count] } else { normal };
    let (force, couple, taken) = (&mut force[..count], &mut couple[..count], &mut taken[..count]);
    for at in 0..count {
        let ([x, y, z, _], [_, u, v, w]) = (between[at], moving[at]);
        let [radius, reach] = if MIXED { [mine[at][3], theirs[at][3]] } else { [radius; 2] };
        let (between, mut velocity) = (Vec3::new(x, y, z), Vec3::new(u, v, w));
        let square = between.norm_squared();
        let sum = radius + reach;
        let touches = if kiss { square <= sum * sum } else { square < sum * sum };
        let distance = square.sqrt();
        let unit = between * distance.recip();
        let overlap = sum - distance;
        let arms = [radius - share * overlap, reach - share * overlap];
        let slides = [radius - slide_share * overlap, reach - slide_share * overlap];
        let mut spins = Vec3::zeros();
        let mut old = Record::default();
        if K::FRICTION {
            let mine = Vec3::new(mine[at][0], mine[at][1], mine[at][2]);
            if MIXED {
                let theirs = Vec3::new(theirs[at][0], theirs[at][1], theirs[at][2]);
                velocity += unit.cross(&(mine * slides[0] + theirs * slides[1]));
                spins = mine + theirs;
            } else {
                velocity += unit.cross(&mine) * slides[0];
                spins = mine;
            }
            old.spring = spring[at];
            if rotated {
                old.normal = normal[at];
            }
        }
        if K::DAMPING {
            old.lag = lag[at];
        }
        let pair = if MIXED { &laws[at] } else { &law };
        let approach = Approach { normal: unit, overlap, velocity, spins };
        let Response { reply, record, tally } = respond::<K>(&rule, pair, &approach, touches, &old);
        touching[at] = touches;
        let push = unit * reply.normal + reply.tangent;
        force[at] = [push.x, push.y, push.z, arms[0]];
        if K::FRICTION {
            spring[at] = record.spring;
            if rotated {
                normal[at] = record.normal;
            }
            let arm = if MIXED { 1.0 } else { arms[0] };
            let bend = unit.cross(&reply.tangent) * arm;
            couple[at] = [bend.x, bend.y, bend.z, arms[1]];
        }
        if K::DAMPING {
            lag[at] = record.lag;
        }
        taken[at] = [tally.normal_dashpot, tally.tangential_dashpot, tally.slip, 0.0];
    }
}
