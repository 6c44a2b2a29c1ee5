//! How the spheres of a pass are cut into blocks: which pairs and walls each answers, and what
//! blocks send each other.
//!
//! A pair belongs to the block of its first sphere, which is the lower slot. What it does to a sphere of a
//! later block, a stranger, is summed apart and handed over afterwards, in the order of the blocks. O(listed pairs)
//! once a list; cannot fail.

use super::contacts::listed::{Bounded, Listed, Numbers};
use super::contacts::{self, Scratch, Second};
use super::law::{BookView, Tally};
use super::state::{List, Load, State};
use std::ops::Range;

/// Least number of spheres a block.
pub const BLOCK: usize = 1200;
/// Most blocks of less than [`MOST`] spheres.
const BLOCKS: usize = 64;
/// Most spheres a block: half of what the places of spheres and strangers leave.
const MOST: usize = 1 << 15;

/// All blocks.
#[derive(Debug, Default)]
pub struct Blocks {
    /// Where in the blocks spheres are.
    pub index: Index,
    /// One for each thread.
    pub scratch: Vec<Scratch>,
    /// Loads of each block on spheres of later blocks.
    pub strangers: Vec<Vec<Load>>,
    /// For each block what it gets, by spheres: block, place among its strangers, sphere.
    pub mail: Vec<Vec<[u32; 3]>>,
    indexed_at: Option<u64>,
}

/// Places of spheres in blocks.
#[derive(Debug, Default)]
pub struct Index {
    /// Spheres a block.
    pub size: usize,
    /// Of each block, place of the first sphere of each pair in it.
    owners: Vec<Numbers<u16>>,
    /// Place of the second: the block's own, then strangers.
    seats: Vec<Numbers<u16>>,
    /// Place of the sphere of each entry of the planes' list.
    at_planes: Vec<Numbers<u16>>,
    /// Spheres with triangles in their lists.
    at_faces: Vec<u32>,
}

impl Blocks {
    /// Gives back the memory of what belongs to lists.
    pub fn forget(&mut self) {
        let scratch = std::mem::take(&mut self.scratch);
        *self = Self { scratch, ..Self::default() };
    }

    /// Follows lists that were built for the `rebuilds`th time.
    pub fn follow(&mut self, state: &State) {
        if self.indexed_at == Some(state.rebuilds) {
            return;
        }
        self.indexed_at = Some(state.rebuilds);
        let count = state.balls.len();
        let mut number = (count / BLOCK).clamp(1, BLOCKS).max(count.div_ceil(MOST));
        // More blocks only where one has more strangers than can be told apart: never yet seen.
        while !self.cut(state, number) && number < count {
            number *= 2;
        }
        let has = |slot: &usize| state.faces.start[slot + 1] > state.faces.start[*slot];
        let Index { size, at_planes, at_faces, .. } = &mut self.index;
        at_faces.clear();
        at_faces.extend((0..count).filter(has).map(|slot| slot as u32));
        at_planes.clear();
        for low in (0..count).step_by(*size) {
            let high = (low + *size).min(count);
            at_planes.push(places_of_owners(&state.planes, low..high).into());
        }
    }

    /// Cuts the spheres into `number` blocks; false if places in them do not fit their type.
    fn cut(&mut self, state: &State, number: usize) -> bool {
        let (pairs, count) = (&state.pairs, state.balls.len());
        let size = count.div_ceil(number).max(1);
        self.mail = vec![Vec::new(); number];
        self.strangers.resize_with(number, Vec::new);
        let mut index = Index { size, ..Index::default() };
        // For each sphere the last block that it is a stranger of, and its place there.
        let mut known = vec![(u32::MAX, 0); if number > 1 { count } else { 0 }];
        let mut fits = true;
        let mut place_of = |place: usize| {
            fits &= place <= usize::from(u16::MAX);
            place as u16
        };
        for from in 0..number {
            let low = (from * size).min(count);
            let high = (low + size).min(count);
            let mut met = 0;
            let owners = places_of_owners(pairs, low..high);
            let mut seats = Vec::with_capacity(owners.len());
            for slot in low..high {
                let range = pairs.start[slot] as usize..pairs.start[slot + 1] as usize;
                for other in &pairs.partner[range] {
                    let slot = *other as usize;
                    if slot < high {
                        seats.push((slot - low) as u16);
                        continue;
                    }
                    let (block, place) = &mut known[slot];
                    if *block != from as u32 {
                        (*block, *place) = (from as u32, met);
                        self.mail[slot / size].push([from as u32, met, *other]);
                        met += 1;
                    }
                    seats.push(place_of(high - low + *place as usize));
                }
            }
            index.owners.push(owners.into());
            index.seats.push(seats.into());
            self.strangers[from] = vec![Load::default(); met as usize];
        }
        for mail in &mut self.mail {
            // Stable: what one sphere gets stays in the order of the blocks.
            mail.sort_by_key(|[_, _, sphere]| *sphere);
            mail.shrink_to_fit();
        }
        self.index = index;
        fits
    }
}

/// Place in their block of the sphere of each entry of a list, of the spheres of the block.
fn places_of_owners(list: &List, block: Range<usize>) -> Vec<u16> {
    let entries = list.start.get(block.start..=block.end).unwrap_or_default();
    let first = entries.first().copied().unwrap_or_default();
    let all = entries.last().map_or(0, |end| end - first);
    let mut places = Vec::with_capacity(all as usize);
    for (place, end) in entries.iter().skip(1).enumerate() {
        places.resize((end - first) as usize, place as u16);
    }
    places
}

impl Index {
    /// Bytes that it takes.
    #[cfg(test)]
    fn bytes(&self) -> usize {
        let places = [&self.owners, &self.at_planes, &self.seats].into_iter().flatten();
        places.map(|places| places.capacity() * 2).sum::<usize>() + self.at_faces.capacity() * 4
    }
}

impl Blocks {
    /// Bytes of what grows with the number of spheres and pairs.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        self.index.bytes()
            + self.strangers.iter().map(|met| met.capacity() * 48).sum::<usize>()
            + self.mail.iter().map(|mail| mail.capacity() * 12).sum::<usize>()
            + self.scratch.iter().map(Scratch::bytes).sum::<usize>()
    }
}

/// One block: its pairs and its walls.
pub struct Part<'a> {
    /// First sphere.
    pub first: usize,
    /// Pairs and planes.
    pub pairs: contacts::Part<'a>,
    /// Spheres of the block with triangles in their lists.
    pub at_faces: &'a [u32],
    /// Where the triangles of each sphere begin, and all of them.
    pub face_list: (&'a [u32], &'a [u32]),
    /// Entries of the book that belong to its triangles, and the first of them.
    pub faces: (BookView<'a>, usize),
    /// What its contacts took.
    pub tally: Tally,
}

impl<'a> Part<'a> {
    /// All blocks, of these lists of pairs, planes and triangles.
    pub fn all(
        index: &'a Index,
        [pairs, planes, faces]: [&'a mut List; 3],
        (loads, strangers): (&'a mut [Load], &'a mut [Vec<Load>]),
    ) -> Vec<Self> {
        let lists = [&pairs.start, &planes.start, &faces.start];
        let face_list = (&faces.start[..], &faces.partner[..]);
        let (partner, plane) = (&pairs.partner, &planes.partner);
        let mut books = [pairs.book.view(), planes.book.view(), faces.book.view()].map(Some);
        let mut near = &index.at_faces[..];
        let mut parts = Vec::with_capacity(strangers.len());
        let mine = loads.chunks_mut(index.size).zip(strangers.iter_mut());
        for (number, (loads, strangers)) in mine.enumerate() {
            let (first, last) = (number * index.size, number * index.size + loads.len());
            let mut take = |which: usize| {
                let start = lists[which];
                let (from, to) = (start[first] as usize, start[last] as usize);
                // A book is put back whenever it is taken.
                let (here, rest) = books[which].take().unwrap_or_default().split_at(to - from);
                books[which] = Some(rest);
                (here, from..to)
            };
            let ((book, range), (planes, at), faces) = (take(0), take(1), take(2));
            let (here, rest) = near.split_at(near.partition_point(|slot| (*slot as usize) < last));
            near = rest;
            let (owners, seats) = (index.owners[number].all(), index.seats[number].all());
            let (second, kind) = (partner.part(range), (first, Second::Balls));
            let pairs = Listed::new(kind, owners, second, seats);
            let (owners, none) = (index.at_planes[number].all(), Bounded::of(&[]));
            let at_planes = Listed::new((first, Second::Planes), owners, plane.part(at), none);
            parts.push(Self {
                first,
                pairs: contacts::Part { pairs, at_planes, loads, book, planes, strangers },
                at_faces: here,
                face_list,
                faces: (faces.0, faces.1.start),
                tally: Tally::default(),
            });
        }
        parts
    }
}
