//! Spheres and planes, several contacts side by side: first and last sweep of [`super::contacts`],
//! whose second sweep, the law, is that of pairs.
//!
//! A plane acts from both sides: its normal is turned towards the centre of the sphere. O(1) a contact; cannot fail.

use super::contacts::{Checked, GROUP, Scratch, add, chunk, chunk_mut, entries, groups, within};
use super::forces::Field;
use super::lanes::{Line, Triple, Wide};
use super::setting::{PlaneNow, wall_spin};
use crate::model::Motion;
use crate::num::Vec3;

/// All planes at the time of a pass.
#[derive(Debug, Default)]
pub struct Planes {
    /// One by one.
    pub now: Vec<PlaneNow>,
    /// Point, part of the overlap that is taken from the arm, normal.
    pub lines: Vec<Line>,
    /// Whether one has a velocity.
    pub moving: bool,
}

impl Planes {
    /// The planes `now`.
    pub fn new(now: Vec<PlaneNow>) -> Self {
        let line = |plane: &PlaneNow| {
            let (p, n) = (plane.point, plane.normal);
            Line([p.x, p.y, p.z, plane.share, n.x, n.y, n.z, 0.0])
        };
        let lines = now.iter().map(line).collect();
        let moving = now.iter().any(|plane| plane.motion != Motion::Still);
        Self { now, lines, moving }
    }
}

/// First sweep: geometry and motion, of which the first `count` may touch.
#[inline(always)]
pub fn approach<const W: usize, L: Wide<W>, const SPINS: bool, const MOVING: bool>(
    field: &Field<'_>,
    pairs: Checked<'_>,
    count: usize,
    scratch: &mut Scratch,
) {
    let Field { balls, spins, planes, .. } = field;
    let whole = pairs.first.len() / W;
    let (first, second) = (groups::<W, _>(pairs.first, whole), groups::<W, _>(pairs.second, whole));
    for group in 0..whole {
        let (at, me, them) = (within::<W>(group * W), &first[group], &second[group]);
        let (ours, theirs) = (entries(&balls[pairs.block..], me), entries(&planes.lines, them));
        let mut rows = [L::row(theirs[0]); W];
        for l in 0..W {
            rows[l] = L::row(ours[l].line());
        }
        let [x, y, z, radius, u, v, w, _] = L::columns(rows);
        let mut velocity = Triple { x: u, y: v, z: w };
        for l in 0..W {
            rows[l] = L::row(theirs[l]);
        }
        let [px, py, pz, share, nx, ny, nz, _] = L::columns(rows);
        let between = Triple { x, y, z } - Triple { x: px, y: py, z: pz };
        let normal = Triple { x: nx, y: ny, z: nz };
        let height = between.dot(normal);
        let distance = height.abs();
        scratch.touches[at] = L::bits(distance.at_most(radius));
        let behind = height.below(L::splat(0.0));
        let unit = Triple::pick(behind, normal.map(|n| -n), normal);
        let overlap = radius - distance;
        scratch.unit.set(at, unit);
        scratch.overlap.set(at, overlap);
        if MOVING {
            let drift: Triple<L> = drift(field, pairs, at, height);
            scratch.drift.set(at, drift);
            velocity = velocity - drift;
        }
        if SPINS {
            let arm = radius.minus_product(overlap, share);
            let mut spins: Triple<L> = L::triples(entries(&spins[pairs.block..], me));
            velocity = velocity.plus_cross(unit, spins * arm);
            if MOVING {
                let turning: Triple<L> = turning(field, them);
                spins = spins + turning;
                if field.yade {
                    // YADE takes the velocity at the contact point, where the arm ends.
                    velocity = velocity.plus_cross(turning, unit * (arm - distance));
                }
            }
            scratch.arms[0].set(at, arm);
            scratch.spins.set(at, spins);
        }
        scratch.velocity.set(at, velocity);
    }
    scratch.part::<W>(count, whole);
}

/// Velocities of the planes where the spheres are nearest, m/s.
#[inline(always)]
pub fn drift<const W: usize, L: Wide<W>>(
    field: &Field<'_>,
    pairs: Checked<'_>,
    at: usize,
    height: L,
) -> Triple<L> {
    let (me, them) = (chunk::<W, _>(pairs.first, at), chunk::<W, _>(pairs.second, at));
    let (mut heights, mut drifts) = ([0.0; W], [Vec3::zeros(); W]);
    height.store(&mut heights);
    for l in 0..W {
        let plane = &field.planes.now[them[l] as usize];
        let place = &field.balls[pairs.block + usize::from(me[l])].place;
        drifts[l] = plane.motion.velocity(&(place - plane.normal * heights[l]));
    }
    L::triples(drifts.each_ref())
}

/// Angular velocities of the planes, rad/s.
#[inline(always)]
fn turning<const W: usize, L: Wide<W>>(field: &Field<'_>, them: &[u32; W]) -> Triple<L> {
    let mut spins = [Vec3::zeros(); W];
    for l in 0..W {
        spins[l] = wall_spin(&field.planes.now[them[l] as usize].motion);
    }
    L::triples(spins.each_ref())
}

/// Third sweep: adds the forces to the lines of the spheres.
#[inline(always)]
pub fn deliver<const W: usize, L: Wide<W>, const SPINS: bool, const MOVING: bool>(
    pairs: Checked<'_>,
    scratch: &mut Scratch,
) {
    let zero = L::splat(0.0);
    for (group, me) in groups::<W, _>(pairs.first, pairs.first.len() / W).iter().enumerate() {
        let at = within::<W>(group * W);
        let push: Triple<L> = scratch.push.get(at);
        let mut turn = Triple::zero();
        if SPINS {
            let (couple, arm): (Triple<L>, L) = (scratch.couple.get(at), scratch.arms[0].get(at));
            turn = couple * -arm;
        }
        if MOVING {
            let drift: Triple<L> = scratch.drift.get(at);
            let sums = chunk_mut(&mut scratch.power, at % GROUP);
            (L::load(sums) + push.dot(drift)).store(sums);
        }
        let rows = L::rows([push.x, push.y, push.z, zero, turn.x, turn.y, turn.z, zero]);
        for l in 0..W {
            // SAFETY: `check` has looked at the places.
            let pull = unsafe { scratch.pulls.get_unchecked_mut(me[l] as usize) };
            if SPINS {
                add::<W, L, 1>(rows[l], pull);
            } else {
                add::<W, L, 0>(rows[l], pull);
            }
        }
    }
}
