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
use super::blocks::{BLOCK, Blocks, Part};
use super::contacts::{self, Bodies, Scratch, Waiters};
use super::crew::Crew;
use super::far::Far;
use super::law::{Kind, Rule, Tally, for_kind};
use super::motion::{Leap, Margin, Went};
use super::neighbours;
use super::onward::Onward;
use super::planes::Planes;
use super::setting::Setting;
use super::state::{Ball, State};
use super::walls;
use crate::model::Scheme;
use crate::num::Vec3;

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
        self.blocks.forget();
    }

    /// The next pass asks where walls are and how they move, even if it is at the time of the last.
    pub fn forget_walls(&mut self) {
        self.walls_at = None;
    }

    /// Bytes of what grows with the number of spheres and pairs.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        self.blocks.bytes()
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
    (rule, onward): (&Rule, Option<&Leap>),
) -> Tally {
    work.place_walls(setting, state.step);
    work.blocks.follow(state);
    if setting.scheme == Scheme::PathAveraged {
        return averaged(setting, state, work, rule);
    }
    if onward.is_some() {
        work.margin.follow(setting, state, &work.crew);
    }
    for_kind!(setting.kept, setting.law, K => pass::<K>(setting, state, work, (rule, onward)))
}

/// What every kernel reads.
#[derive(Clone, Copy)]
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

impl<'a> Field<'a> {
    /// The same with the spheres as they are now.
    #[inline(always)]
    pub fn with<B: Bodies>(self, bodies: &'a B) -> Self {
        let (balls, spins) = bodies.now();
        Self { balls, spins, ..self }
    }
}

/// [`evaluate`] with one kernel.
fn pass<K: Kind>(
    setting: &Setting<'_>,
    state: &mut State,
    work: &mut Workspace,
    (rule, onward): (&Rule, Option<&Leap>),
) -> Tally {
    let field = Field {
        setting,
        rule,
        balls: &[],
        spins: &[],
        planes: &work.planes,
        faces: &work.faces,
        memory: &work.memory,
        yade: setting.scheme == Scheme::Yade,
    };
    let Blocks { index, scratch, strangers, mail, .. } = &mut work.blocks;
    scratch.resize_with(work.crew.size(), Scratch::default);
    let State { balls, spins, loads, pairs, planes, faces, light, .. } = state;
    let mut parts = Part::all(index, [pairs, planes, faces], (loads, strangers));
    let mut total = Tally::default();
    if let Some(leap) = onward {
        let (paces, went) = (work.margin.paces(), Went::default());
        let mut onward = Onward { setting, leap, lights: light, paces, balls, spins, went };
        let scratch = &mut scratch[0];
        for number in 0..parts.len() {
            let (earlier, part) = parts.split_at_mut(number);
            let mail = (&mail[number][..], &*earlier);
            total += go_on::<K>(&field, &mut part[0], &mut onward, mail, scratch);
        }
        work.margin.went = Some(onward.went);
        return total;
    }
    let waiters = Waiters(balls, spins);
    let field = field.with(&waiters);
    work.crew.share(&mut parts, scratch, |part, scratch| {
        at_walls::<K>(&field, part, scratch);
        let mut waiters = Waiters(field.balls, field.spins);
        contacts::between::<K, _>(&field, &mut waiters, &mut part.pairs, scratch);
        part.tally += contacts::finish(&mut part.pairs, scratch);
    });
    for part in &parts {
        total += part.tally;
    }
    drop(parts);
    let size = index.size;
    let mut boxes: Vec<_> = loads.chunks_mut(size).zip(mail.iter()).enumerate().collect();
    work.crew.share(&mut boxes, scratch, |(number, (loads, mail)), _| {
        for [from, at, slot] in mail.iter() {
            loads[*slot as usize - *number * size] += strangers[*from as usize][*at as usize];
        }
    });
    total
}

/// One block, whose spheres go on: see [`super::onward`]. What its contacts took.
fn go_on<K: Kind>(
    field: &Field<'_>,
    part: &mut Part<'_>,
    onward: &mut Onward<'_>,
    (mail, earlier): (&[[u32; 3]], &[Part<'_>]),
    scratch: &mut Scratch,
) -> Tally {
    let waiters = Waiters(onward.balls, onward.spins);
    at_walls::<K>(&field.with(&waiters), part, scratch);
    let mut passing = onward.block(part.first, mail, earlier);
    contacts::between::<K, _>(field, &mut passing, &mut part.pairs, scratch);
    passing.go_on(part.pairs.loads.len(), &mut scratch.pulls);
    part.tally += contacts::hand_on(&mut part.pairs, scratch);
    part.tally
}

/// Planes, then triangles at a block.
fn at_walls<K: Kind>(field: &Field<'_>, part: &mut Part<'_>, scratch: &mut Scratch) {
    contacts::at_planes::<K>(field, &mut part.pairs, scratch);
    block_faces::<K>(field, part, scratch);
}

/// Triangles near the spheres of a block.
fn block_faces<K: Kind>(field: &Field<'_>, part: &mut Part<'_>, scratch: &mut Scratch) {
    let (start, partner) = part.face_list;
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
            match setting.kept.ledger {
                true => {
                    type Whole = Averaged<$friction, $damping, $drags, true>;
                    pass::<Whole>(setting, state, work, (rule, None))
                }
                false => {
                    type Bare = Averaged<$friction, $damping, $drags, false>;
                    pass::<Bare>(setting, state, work, (rule, None))
                }
            }
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
