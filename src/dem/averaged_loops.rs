//! Force pass of the path-averaged scheme: contacts of all candidates, loads on all spheres.
//!
//! Sphere–sphere forces are added in the same order however many threads work: incoming
//! pairs by rising slot, then a sphere's own pairs, then planes, then triangles; energies
//! are summed over blocks of [`BLOCK`] spheres. Results are equal to the bit.
//!
//! One thread adds the force of a pair to both spheres at once; several threads
//! write it to a buffer first (72 bytes a listed pair) and sum a sphere at a time.
//! O(candidates); cannot fail.

use super::averaged_pass::{Push, on_faces, on_planes, pair};
use super::forces::Field;
use super::law::{BookView, Tally};
use super::state::{List, Load};
use crate::num::Vec3;
use rayon::prelude::*;

/// Spheres a block.
const BLOCK: usize = 512;

const NO_PUSH: Push =
    Push { force: Vec3::new(0.0, 0.0, 0.0), couple: Vec3::new(0.0, 0.0, 0.0), arms: [0.0; 2] };

/// Forces of pairs, and for each sphere the pairs in which it comes second; for several threads.
#[derive(Debug, Default)]
pub struct Buffer {
    pushes: Vec<Push>,
    incoming_start: Vec<u32>,
    incoming: Vec<u32>,
    indexed_at: Option<u64>,
}

impl Buffer {
    /// Follows lists that were built for the `rebuilds`th time.
    pub fn index(&mut self, pairs: &List, rebuilds: u64) {
        if self.indexed_at == Some(rebuilds) {
            return;
        }
        self.indexed_at = Some(rebuilds);
        let count = pairs.start.len() - 1;
        self.incoming_start = vec![0; count + 1];
        for partner in &pairs.partner {
            self.incoming_start[*partner as usize + 1] += 1;
        }
        for slot in 0..count {
            self.incoming_start[slot + 1] += self.incoming_start[slot];
        }
        let mut next = self.incoming_start.clone();
        self.incoming = vec![0; pairs.partner.len()];
        for (pair, partner) in pairs.partner.iter().enumerate() {
            let place = &mut next[*partner as usize];
            self.incoming[*place as usize] = pair as u32;
            *place += 1;
        }
        self.pushes.resize(pairs.partner.len(), NO_PUSH);
    }
}

/// One thread.
pub fn serial<const FRICTION: bool, const DAMPING: bool>(
    field: &Field<'_>,
    pairs: &mut List,
    planes: &mut List,
    faces: &mut List,
    loads: &mut [Load],
) -> Tally {
    loads.fill(Load::default());
    let (mut pair_book, mut plane_book, mut face_book) =
        (pairs.book.view(), planes.book.view(), faces.book.view());
    let mut total = Tally::default();
    let mut hits = Vec::new();
    for block in (0..loads.len()).step_by(BLOCK) {
        let (mut inner, mut outer) = (Tally::default(), Tally::default());
        for slot in block..(block + BLOCK).min(loads.len()) {
            let mut load = loads[slot];
            let range = pairs.start[slot] as usize..pairs.start[slot + 1] as usize;
            for k in range {
                let other = pairs.partner[k] as usize;
                let push =
                    pair::<FRICTION, DAMPING>(field, slot, other, &mut pair_book, k, &mut inner);
                let Some(push) = push else { continue };
                load.force += push.force;
                loads[other].force -= push.force;
                if FRICTION {
                    load.torque -= push.couple * push.arms[0];
                    loads[other].torque -= push.couple * push.arms[1];
                }
            }
            let range = planes.start[slot] as usize..planes.start[slot + 1] as usize;
            on_planes::<FRICTION, DAMPING>(
                field,
                slot,
                &planes.partner[range.clone()],
                range.start,
                &mut plane_book,
                &mut load,
                &mut outer,
            );
            let range = faces.start[slot] as usize..faces.start[slot + 1] as usize;
            if !range.is_empty() {
                on_faces::<FRICTION, DAMPING>(
                    field,
                    slot,
                    &faces.partner[range.clone()],
                    range.start,
                    &mut face_book,
                    &mut load,
                    &mut outer,
                    &mut hits,
                );
            }
            loads[slot] = load;
        }
        total += inner;
        total += outer;
    }
    total
}

/// The part of all arrays that belongs to one block of spheres.
struct Part<'a> {
    first: usize,
    book: BookView<'a>,
    base: usize,
    pushes: &'a mut [Push],
    tally: Tally,
}

struct WallPart<'a> {
    first: usize,
    loads: &'a mut [Load],
    planes: (BookView<'a>, usize),
    faces: (BookView<'a>, usize),
    tally: Tally,
}

/// The threads of the present pool.
pub fn parallel<const FRICTION: bool, const DAMPING: bool>(
    field: &Field<'_>,
    pairs: &mut List,
    planes: &mut List,
    faces: &mut List,
    loads: &mut [Load],
    buffer: &mut Buffer,
) -> Tally {
    let Buffer { pushes, incoming_start, incoming, .. } = buffer;
    let count = loads.len();
    let mut parts = Vec::with_capacity(count / BLOCK + 1);
    let (mut book, mut rest) = (pairs.book.view(), pushes.as_mut_slice());
    for first in (0..count).step_by(BLOCK) {
        let (from, to) =
            (pairs.start[first] as usize, pairs.start[(first + BLOCK).min(count)] as usize);
        let (mine, others) = book.split_at(to - from);
        let (here, there) = rest.split_at_mut(to - from);
        parts.push(Part { first, book: mine, base: from, pushes: here, tally: Tally::default() });
        (book, rest) = (others, there);
    }
    parts.par_iter_mut().for_each(|part| {
        for slot in part.first..(part.first + BLOCK).min(count) {
            for k in pairs.start[slot] as usize..pairs.start[slot + 1] as usize {
                let (other, at) = (pairs.partner[k] as usize, k - part.base);
                part.pushes[at] = pair::<FRICTION, DAMPING>(
                    field,
                    slot,
                    other,
                    &mut part.book,
                    at,
                    &mut part.tally,
                )
                .unwrap_or(NO_PUSH);
            }
        }
    });
    let inner: Vec<Tally> = parts.iter().map(|part| part.tally).collect();
    drop(parts);
    let mut parts = Vec::with_capacity(inner.len());
    let (mut plane_book, mut face_book, mut rest) = (planes.book.view(), faces.book.view(), loads);
    for first in (0..count).step_by(BLOCK) {
        let last = (first + BLOCK).min(count);
        let (here, there) = rest.split_at_mut(last - first);
        let (p, f) = (planes.start[first] as usize, faces.start[first] as usize);
        let (mine_p, others_p) = plane_book.split_at(planes.start[last] as usize - p);
        let (mine_f, others_f) = face_book.split_at(faces.start[last] as usize - f);
        parts.push(WallPart {
            first,
            loads: here,
            planes: (mine_p, p),
            faces: (mine_f, f),
            tally: Tally::default(),
        });
        (plane_book, face_book, rest) = (others_p, others_f, there);
    }
    let pushes = &*pushes;
    parts.par_iter_mut().for_each_init(Vec::new, |hits, part| {
        for at in 0..part.loads.len() {
            let slot = part.first + at;
            let mut load = Load::default();
            for k in &incoming[incoming_start[slot] as usize..incoming_start[slot + 1] as usize] {
                let push = &pushes[*k as usize];
                load.force -= push.force;
                load.torque -= push.couple * push.arms[1];
            }
            for push in &pushes[pairs.start[slot] as usize..pairs.start[slot + 1] as usize] {
                load.force += push.force;
                load.torque -= push.couple * push.arms[0];
            }
            let range = planes.start[slot] as usize..planes.start[slot + 1] as usize;
            let base = range.start - part.planes.1;
            on_planes::<FRICTION, DAMPING>(
                field,
                slot,
                &planes.partner[range],
                base,
                &mut part.planes.0,
                &mut load,
                &mut part.tally,
            );
            let range = faces.start[slot] as usize..faces.start[slot + 1] as usize;
            if !range.is_empty() {
                let base = range.start - part.faces.1;
                on_faces::<FRICTION, DAMPING>(
                    field,
                    slot,
                    &faces.partner[range],
                    base,
                    &mut part.faces.0,
                    &mut load,
                    &mut part.tally,
                    hits,
                );
            }
            part.loads[at] = load;
        }
    });
    let mut total = Tally::default();
    for (inner, part) in inner.into_iter().zip(&parts) {
        total += inner;
        total += part.tally;
    }
    total
}
