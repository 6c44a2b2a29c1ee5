//! One force pass: contacts of all listed pairs and walls, loads on all spheres.
//!
//! The kernel exists once for every combination of friction, damping and law variant, so a
//! scene does not carry what it does not have. Spheres are cut into blocks whose number
//! depends on their count only; each block answers its own pairs (see [`super::contacts`])
//! and walls, and its sums of forces on strangers, spheres of later blocks, are added afterwards in the
//! order of the blocks. Threads share out the blocks: results are equal to the bit for any number of them.
//! O(listed pairs and walls); cannot fail.

use super::averaged::Averaged;
use super::averaged_pass::{self, Memory};
use super::contacts::{self, Scratch, Second};
use super::crew::Crew;
use super::far::Far;
use super::law::{BookView, Kind, Rule, Tally, for_kind};
use super::motion::Margin;
use super::neighbours;
use super::planes::Planes;
use super::setting::Setting;
use super::state::{Ball, Load, State};
use super::walls;
use crate::model::Scheme;
use crate::num::Vec3;

/// Least number of spheres a block.
const BLOCK: usize = 1200;
/// Most blocks of less than [`MOST`] spheres.
const BLOCKS: usize = 64;
/// Most spheres a block: half of what the places of spheres and strangers leave.
const MOST: usize = 1 << 15;
/// Scenes below this size run on one thread: a pass is shorter than waking a second one.
const WORTH_THREADS: usize = 2 * BLOCK;

/// Scratch memory and threads of a run.
pub struct Workspace {
    /// Threads.
    pub crew: Crew,
    blocks: Blocks,
    planes: Planes,
    faces: Vec<[Vec3; 3]>,
    walls_at: Option<u64>,
    memory: Memory,
    /// Gravity between bodies.
    pub far: Far,
    /// How far balls have gone.
    pub margin: Margin,
}

/// How spheres are cut into blocks, and what blocks send each other.
#[derive(Debug, Default)]
struct Blocks {
    size: usize,
    /// One for each thread.
    scratch: Vec<Scratch>,
    /// Place of the first sphere of each pair in the block.
    owners: Vec<u16>,
    /// Place of the second: the block's own, then strangers.
    seats: Vec<u16>,
    /// Loads of each block on spheres of later blocks.
    strangers: Vec<Vec<Load>>,
    /// For each block what it gets: block, place among its strangers, sphere.
    mail: Vec<Vec<[u32; 3]>>,
    /// Place of the sphere of each entry of the planes' list.
    at_planes: Vec<u16>,
    /// Spheres with triangles in their lists.
    at_faces: Vec<u32>,
    indexed_at: Option<u64>,
}

impl Blocks {
    /// Follows lists that were built for the `rebuilds`th time.
    fn index(&mut self, state: &State) {
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
        self.at_faces.clear();
        self.at_faces.extend((0..count).filter(has).map(|slot| slot as u32));
        self.at_planes.clear();
        for slot in 0..count {
            self.at_planes.resize(state.planes.start[slot + 1] as usize, (slot % self.size) as u16);
        }
    }
}

impl Blocks {
    /// Cuts the spheres into `number` blocks; false if places in them do not fit their type.
    fn cut(&mut self, state: &State, number: usize) -> bool {
        let (pairs, count) = (&state.pairs, state.balls.len());
        self.size = count.div_ceil(number).max(1);
        self.mail = vec![Vec::new(); number];
        self.strangers.resize_with(number, Vec::new);
        let entries = pairs.partner.len();
        (self.owners, self.seats) = (Vec::with_capacity(entries), Vec::with_capacity(entries));
        // For each sphere the last block that it is a stranger of, and its place there.
        let mut known = vec![(u32::MAX, 0); if number > 1 { count } else { 0 }];
        let mut fits = true;
        let mut place_of = |place: usize| {
            fits &= place <= usize::from(u16::MAX);
            place as u16
        };
        for from in 0..number {
            let low = (from * self.size).min(count);
            let high = (low + self.size).min(count);
            let mut met = 0;
            for slot in low..high {
                let range = pairs.start[slot] as usize..pairs.start[slot + 1] as usize;
                self.owners.resize(range.end, (slot - low) as u16);
                for other in &pairs.partner[range] {
                    let slot = *other as usize;
                    if slot < high {
                        self.seats.push((slot - low) as u16);
                        continue;
                    }
                    let (block, place) = &mut known[slot];
                    if *block != from as u32 {
                        (*block, *place) = (from as u32, met);
                        self.mail[slot / self.size].push([from as u32, met, *other]);
                        met += 1;
                    }
                    self.seats.push(place_of(high - low + *place as usize));
                }
            }
            self.strangers[from] = vec![Load::default(); met as usize];
        }
        self.mail.iter_mut().for_each(Vec::shrink_to_fit);
        fits
    }
}

impl Workspace {
    /// Scratch for a run of `spheres` spheres on `threads` threads. Falls back to one
    /// thread where no more can be started.
    pub fn new(threads: usize, spheres: usize) -> Self {
        let threads = if spheres >= WORTH_THREADS { threads } else { 1 };
        Self {
            crew: Crew::new(threads),
            blocks: Blocks::default(),
            planes: Planes::default(),
            faces: Vec::new(),
            walls_at: None,
            memory: Memory::default(),
            far: Far::new(threads),
            margin: Margin::default(),
        }
    }

    /// Gives back the memory of what belongs to lists that are about to be built anew.
    pub fn forget_lists(&mut self) {
        let scratch = std::mem::take(&mut self.blocks.scratch);
        self.blocks = Blocks { scratch, ..Blocks::default() };
    }

    /// The next pass asks where walls are and how they move, even if it is at the time of the last.
    pub fn forget_walls(&mut self) {
        self.walls_at = None;
    }

    /// Bytes of what grows with the number of spheres and pairs.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        let blocks = &self.blocks;
        blocks.owners.capacity() * 2
            + blocks.at_planes.capacity() * 2
            + blocks.at_faces.capacity() * 4
            + blocks.seats.capacity() * 2
            + blocks.strangers.iter().map(|met| met.capacity() * 48).sum::<usize>()
            + blocks.mail.iter().map(|mail| mail.capacity() * 12).sum::<usize>()
            + blocks.scratch.iter().map(Scratch::bytes).sum::<usize>()
    }

    /// Puts walls where they are at the state's time.
    fn place_walls(&mut self, setting: &Setting<'_>, step: u64) {
        if self.walls_at == Some(step) {
            return;
        }
        let time = setting.pass_time(step);
        let first = self.walls_at.is_none();
        self.walls_at = Some(step);
        let needs = &setting.needs;
        if first || needs.sliding_walls || needs.turning_walls || needs.servo_walls {
            self.planes = Planes::new(setting.planes_at(time));
        }
        if first || setting.surfaces.moving {
            neighbours::faces_at(setting, time, &mut self.faces);
        }
    }
}

/// Evaluates all contacts: fills `state.loads`, advances the books; returns the energies.
pub fn evaluate(
    setting: &Setting<'_>,
    state: &mut State,
    work: &mut Workspace,
    rule: &Rule,
) -> Tally {
    work.place_walls(setting, state.step);
    work.blocks.index(state);
    if setting.scheme == Scheme::PathAveraged {
        return averaged(setting, state, work, rule);
    }
    for_kind!(setting.kept, setting.law, K => pass::<K>(setting, state, work, rule))
}

/// What every kernel reads.
pub struct Field<'a> {
    /// Fixed data.
    pub setting: &'a Setting<'a>,
    /// What the pass is for.
    pub rule: &'a Rule,
    /// Spheres.
    pub balls: &'a [Ball],
    /// Their angular velocities.
    pub spins: &'a [Vec3],
    /// Planes at the time of the pass.
    pub planes: &'a Planes,
    /// Triangles at the time of the pass.
    pub faces: &'a [[Vec3; 3]],
    /// Last step and effective masses, where forces are averaged over the path.
    pub memory: &'a Memory,
    /// Pairs at overlap 0 touch (YADE) or not (LIGGGHTS); walls turn about the end of the arm.
    pub yade: bool,
}

/// One block: its pairs and its walls.
struct Part<'a> {
    /// First sphere.
    first: usize,
    /// Pairs and planes.
    lists: [contacts::Pairs<'a>; 2],
    pairs: contacts::Part<'a>,
    /// Spheres of the block with triangles in their lists.
    at_faces: &'a [u32],
    faces: (BookView<'a>, usize),
    tally: Tally,
}

fn pass<K: Kind>(
    setting: &Setting<'_>,
    state: &mut State,
    work: &mut Workspace,
    rule: &Rule,
) -> Tally {
    let field = Field {
        setting,
        rule,
        balls: &state.balls,
        spins: &state.spins,
        planes: &work.planes,
        faces: &work.faces,
        memory: &work.memory,
        yade: setting.scheme == Scheme::Yade,
    };
    let size = work.blocks.size;
    let Blocks { scratch, owners, seats, strangers, mail, at_planes, at_faces, .. } =
        &mut work.blocks;
    let (pairs, planes, faces) = (&mut state.pairs, &mut state.planes, &mut state.faces);
    let lists = [&pairs.start, &planes.start, &faces.start];
    let (partner, plane) = (&pairs.partner[..], &planes.partner[..]);
    let face_list = (&faces.start[..], &faces.partner[..]);
    let mut books = [pairs.book.view(), planes.book.view(), faces.book.view()].map(Some);
    let mut near: &[u32] = at_faces;
    let mut parts: Vec<Part<'_>> = Vec::with_capacity(mail.len());
    let mine = state.loads.chunks_mut(size).zip(strangers.iter_mut());
    for (number, (loads, strangers)) in mine.enumerate() {
        let (first, last) = (number * size, number * size + loads.len());
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
        parts.push(Part {
            first,
            lists: [
                contacts::Pairs {
                    block: first,
                    first: &owners[range.clone()],
                    second: &partner[range.clone()],
                    seats: &seats[range],
                    kind: Second::Balls,
                },
                contacts::Pairs {
                    block: first,
                    first: &at_planes[at.clone()],
                    second: &plane[at],
                    seats: &[],
                    kind: Second::Planes,
                },
            ],
            pairs: contacts::Part { loads, book, planes, strangers },
            at_faces: here,
            faces: (faces.0, faces.1.start),
            tally: Tally::default(),
        });
    }
    scratch.resize_with(work.crew.size(), Scratch::default);
    work.crew.share(&mut parts, scratch, |part, scratch| {
        contacts::block::<K>(&field, part.lists, &mut part.pairs, scratch);
        block_faces::<K>(&field, face_list, part, scratch);
        part.tally += contacts::finish(&mut part.pairs, scratch);
    });
    let mut total = Tally::default();
    for part in &parts {
        total += part.tally;
    }
    drop(parts);
    let mut boxes: Vec<_> = state.loads.chunks_mut(size).zip(mail.iter()).enumerate().collect();
    work.crew.share(&mut boxes, scratch, |(number, (loads, mail)), _| {
        for [from, at, slot] in mail.iter() {
            loads[*slot as usize - *number * size] += strangers[*from as usize][*at as usize];
        }
    });
    total
}

/// Triangles near the spheres of a block.
fn block_faces<K: Kind>(
    field: &Field<'_>,
    (start, partner): (&[u32], &[u32]),
    part: &mut Part<'_>,
    scratch: &mut Scratch,
) {
    let (book, base) = (&mut part.faces.0, part.faces.1);
    for slot in part.at_faces {
        let slot = *slot as usize;
        let range = start[slot] as usize..start[slot + 1] as usize;
        let at = (slot, range.start - base);
        let (range, to) = (&partner[range], (part.first, &mut *book));
        if K::AVERAGED {
            averaged_pass::on_faces::<K>(field, at, range, to, scratch, &mut part.tally);
        } else {
            walls::on_faces::<K>(field, at, range, to, scratch);
        }
    }
    contacts::answer_waiting::<K>(field, (part.first, book), scratch);
}

/// The pass of the path-averaged scheme.
fn averaged(setting: &Setting<'_>, state: &mut State, work: &mut Workspace, rule: &Rule) -> Tally {
    if setting.kept.damping || !state.solids.is_empty() {
        work.memory.look(setting, state);
    }
    macro_rules! with {
        ($friction:literal, $damping:literal, $drags:literal) => {
            pass::<Averaged<$friction, $damping, $drags>>(setting, state, work, rule)
        };
    }
    let kept = setting.kept;
    match (kept.friction, kept.damping, kept.pulls) {
        (false, false, _) => with!(false, false, false),
        (false, true, _) => with!(false, true, false),
        (true, false, _) => with!(true, false, false),
        (true, true, false) => with!(true, true, false),
        (true, true, true) => with!(true, true, true),
    }
}
