//! One force pass: contacts of all candidates, loads on all spheres.
//!
//! Each kernel exists once for every combination of friction and damping, so a
//! scene without one of them does not carry it. Sphere–sphere forces are added
//! in the same order however many threads work: incoming pairs by rising slot,
//! then a sphere's own pairs, then planes, then triangles; energies are summed
//! over blocks of [`BLOCK`] spheres. Results are equal to the bit.
//!
//! One thread adds the force of a pair to both spheres at once; several threads
//! write it to a buffer first (72 bytes a listed pair) and sum a sphere at a time.
//! O(candidates); cannot fail.

use super::averaged_pass::{self, Memory};
use super::far::Far;
use super::law::{Approach, BookView, Reply, Rule, Tally, release, respond};
use super::neighbours;
use super::setting::{PlaneNow, Setting, wall_spin};
use super::state::{Ball, Lightness, List, Load, State};
use super::surface::{self, Feature};
use crate::model::Scheme;
use crate::num::Vec3;
use rayon::prelude::*;

/// Spheres a block.
const BLOCK: usize = 512;
/// Scenes below this size run on one thread: a pass is shorter than waking a second one.
const WORTH_THREADS: usize = 2000;

/// Scratch memory and threads of a run.
pub struct Workspace {
    pool: Option<rayon::ThreadPool>,
    pushes: Vec<Push>,
    incoming_start: Vec<u32>,
    incoming: Vec<u32>,
    indexed_at: Option<u64>,
    planes: Vec<PlaneNow>,
    faces: Vec<[Vec3; 3]>,
    walls_at: Option<u64>,
    memory: Memory,
    /// Gravity between bodies.
    pub far: Far,
}

/// Force of a pair on its first sphere.
#[derive(Debug, Clone, Copy)]
pub struct Push {
    /// The force, N.
    pub force: Vec3,
    /// Normal × tangential force; times the arm it is the torque taken from each sphere.
    pub couple: Vec3,
    /// Arms of both spheres, m.
    pub arms: [f64; 2],
}

const NO_PUSH: Push =
    Push { force: Vec3::new(0.0, 0.0, 0.0), couple: Vec3::new(0.0, 0.0, 0.0), arms: [0.0; 2] };

impl Workspace {
    /// Scratch for a run of `spheres` spheres on `threads` threads. Falls back to one
    /// thread where no more can be started.
    pub fn new(threads: usize, spheres: usize) -> Self {
        let pool = (threads > 1 && spheres >= WORTH_THREADS)
            .then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok())
            .flatten();
        Self {
            pool,
            pushes: Vec::new(),
            incoming_start: Vec::new(),
            incoming: Vec::new(),
            indexed_at: None,
            planes: Vec::new(),
            faces: Vec::new(),
            walls_at: None,
            memory: Memory::default(),
            far: Far::new(threads),
        }
    }

    /// Puts walls where they are at the state's time.
    fn place_walls(&mut self, setting: &Setting<'_>, step: u64) {
        if self.walls_at == Some(step) {
            return;
        }
        let time = setting.pass_time(step);
        let first = self.walls_at.is_none();
        self.walls_at = Some(step);
        if first
            || setting.needs.sliding_walls
            || setting.needs.servo_walls
            || setting.needs.turning_walls
        {
            self.planes = setting.planes_at(time);
        }
        if first || setting.surfaces.moving {
            self.faces.clear();
            let count = setting.surfaces.start.len();
            self.faces.extend((0..count).map(|face| neighbours::face_at(setting, face, time)));
        }
    }

    /// For each sphere the pairs in which it comes second.
    fn index_incoming(&mut self, pairs: &List, rebuilds: u64) {
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

/// Evaluates all contacts: fills `state.loads`, advances the books; returns the energies.
pub fn evaluate(
    setting: &Setting<'_>,
    state: &mut State,
    work: &mut Workspace,
    rule: &Rule,
) -> Tally {
    work.place_walls(setting, state.step);
    let averaged = setting.scheme == Scheme::PathAveraged;
    if averaged && (setting.kept.damping || !state.solids.is_empty()) {
        work.memory.look(setting, state);
    }
    match (setting.kept.friction, setting.kept.damping, averaged) {
        (false, false, false) => pass::<false, false, false>(setting, state, work, rule),
        (false, true, false) => pass::<false, true, false>(setting, state, work, rule),
        (true, false, false) => pass::<true, false, false>(setting, state, work, rule),
        (true, true, false) => pass::<true, true, false>(setting, state, work, rule),
        (false, false, true) => pass::<false, false, true>(setting, state, work, rule),
        (false, true, true) => pass::<false, true, true>(setting, state, work, rule),
        (true, false, true) => pass::<true, false, true>(setting, state, work, rule),
        (true, true, true) => pass::<true, true, true>(setting, state, work, rule),
    }
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
    /// Their inverse mass properties.
    pub light: &'a [Lightness],
    /// Planes at the time of the pass.
    pub planes: &'a [PlaneNow],
    /// Triangles at the time of the pass.
    pub faces: &'a [[Vec3; 3]],
    /// Last step and effective masses, where forces are averaged over the path.
    pub memory: &'a Memory,
    /// Pairs at overlap 0 touch (YADE) or not (LIGGGHTS); walls turn about the end of the arm.
    yade: bool,
}

fn pass<const FRICTION: bool, const DAMPING: bool, const AVERAGED: bool>(
    setting: &Setting<'_>,
    state: &mut State,
    work: &mut Workspace,
    rule: &Rule,
) -> Tally {
    if work.pool.is_some() {
        work.index_incoming(&state.pairs, state.rebuilds);
    }
    let field = Field {
        setting,
        rule,
        balls: &state.balls,
        spins: &state.spins,
        light: &state.light,
        planes: &work.planes,
        faces: &work.faces,
        memory: &work.memory,
        yade: setting.scheme == Scheme::Yade,
    };
    match &work.pool {
        None => serial::<FRICTION, DAMPING, AVERAGED>(
            &field,
            &mut state.pairs,
            &mut state.planes,
            &mut state.faces,
            &mut state.loads,
        ),
        Some(pool) => pool.install(|| {
            parallel::<FRICTION, DAMPING, AVERAGED>(
                &field,
                &mut state.pairs,
                &mut state.planes,
                &mut state.faces,
                &mut state.loads,
                &mut work.pushes,
                (&work.incoming_start, &work.incoming),
            )
        }),
    }
}

fn serial<const FRICTION: bool, const DAMPING: bool, const AVERAGED: bool>(
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
                let push = pair::<FRICTION, DAMPING, AVERAGED>(
                    field,
                    slot,
                    other,
                    &mut pair_book,
                    k,
                    &mut inner,
                );
                let Some(push) = push else { continue };
                load.force += push.force;
                loads[other].force -= push.force;
                if FRICTION {
                    load.torque -= push.couple * push.arms[0];
                    loads[other].torque -= push.couple * push.arms[1];
                }
            }
            let range = planes.start[slot] as usize..planes.start[slot + 1] as usize;
            on_planes::<FRICTION, DAMPING, AVERAGED>(
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
                on_faces::<FRICTION, DAMPING, AVERAGED>(
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

fn parallel<const FRICTION: bool, const DAMPING: bool, const AVERAGED: bool>(
    field: &Field<'_>,
    pairs: &mut List,
    planes: &mut List,
    faces: &mut List,
    loads: &mut [Load],
    pushes: &mut [Push],
    (incoming_start, incoming): (&[u32], &[u32]),
) -> Tally {
    let count = loads.len();
    let mut parts = Vec::with_capacity(count / BLOCK + 1);
    let (mut book, mut rest) = (pairs.book.view(), &mut *pushes);
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
                part.pushes[at] = pair::<FRICTION, DAMPING, AVERAGED>(
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
            on_planes::<FRICTION, DAMPING, AVERAGED>(
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
                on_faces::<FRICTION, DAMPING, AVERAGED>(
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

/// Force of one sphere–sphere candidate on the first of the two; `None` if apart.
#[inline(always)]
fn pair<const FRICTION: bool, const DAMPING: bool, const AVERAGED: bool>(
    field: &Field<'_>,
    slot: usize,
    other: usize,
    book: &mut BookView<'_>,
    k: usize,
    tally: &mut Tally,
) -> Option<Push> {
    if AVERAGED {
        return averaged_pass::pair::<FRICTION, DAMPING>(field, slot, other, book, k, tally);
    }
    let (me, them) = (&field.balls[slot], &field.balls[other]);
    let between = field.setting.way(me.place - them.place);
    let square = between.norm_squared();
    let sum = me.radius + them.radius;
    let touches = square < sum * sum || (field.yade && square == sum * sum);
    if !touches && !book.touching[k] {
        return None;
    }
    let distance = square.sqrt();
    let normal = between * distance.recip();
    let overlap = sum - distance;
    let share = field.setting.share;
    let arms = [me.radius - share * overlap, them.radius - share * overlap];
    let mut velocity = me.velocity - them.velocity;
    let mut spins = Vec3::zeros();
    if FRICTION {
        let (mine, theirs) = (field.spins[slot], field.spins[other]);
        velocity += normal.cross(&(mine * arms[0] + theirs * arms[1]));
        spins = mine + theirs;
    }
    let law = field.setting.pair(me.material, them.material);
    let approach = Approach { normal, overlap, velocity, spins };
    if !touches {
        release::<FRICTION, DAMPING>(field.rule, law, &approach, book, k, tally);
        return None;
    }
    let Reply { normal: size, tangent } =
        respond::<FRICTION, DAMPING>(field.rule, law, &approach, book, k, tally);
    let couple = if FRICTION { normal.cross(&tangent) } else { Vec3::zeros() };
    Some(Push { force: normal * size + tangent, couple, arms })
}

/// A sphere at a wall: what the wall is there.
struct Spot {
    /// From the wall to the centre of the sphere, m.
    away: Vec3,
    /// Length of it.
    distance: f64,
    /// Velocity of the wall there, m/s.
    velocity: Vec3,
    /// Angular velocity of the wall, rad/s.
    spin: Vec3,
    material: u16,
    /// Part of the overlap taken from the radius to give the lever arm.
    share: f64,
    touches: bool,
}

#[inline]
fn at_wall<const FRICTION: bool, const DAMPING: bool>(
    field: &Field<'_>,
    slot: usize,
    spot: &Spot,
    book: &mut BookView<'_>,
    k: usize,
    load: &mut Load,
    tally: &mut Tally,
) {
    let ball = &field.balls[slot];
    let normal = spot.away / spot.distance;
    let overlap = ball.radius - spot.distance;
    let arm = ball.radius - overlap * spot.share;
    let mut velocity = ball.velocity - spot.velocity;
    let mut spins = Vec3::zeros();
    if FRICTION {
        velocity += normal.cross(&(field.spins[slot] * arm));
        spins = field.spins[slot] + spot.spin;
        if field.yade {
            // YADE takes the velocity at the contact point, where the arm ends.
            velocity += spot.spin.cross(&(normal * (arm - spot.distance)));
        }
    }
    let law = field.setting.pair(ball.material, spot.material);
    let approach = Approach { normal, overlap, velocity, spins };
    if !spot.touches {
        release::<FRICTION, DAMPING>(field.rule, law, &approach, book, k, tally);
        return;
    }
    let Reply { normal: size, tangent } =
        respond::<FRICTION, DAMPING>(field.rule, law, &approach, book, k, tally);
    let force = normal * size + tangent;
    load.force += force;
    if FRICTION {
        load.torque -= normal.cross(&tangent) * arm;
    }
    tally.wall_power += force.dot(&spot.velocity);
}

#[inline]
fn on_planes<const FRICTION: bool, const DAMPING: bool, const AVERAGED: bool>(
    field: &Field<'_>,
    slot: usize,
    partners: &[u32],
    base: usize,
    book: &mut BookView<'_>,
    load: &mut Load,
    tally: &mut Tally,
) {
    if AVERAGED {
        averaged_pass::on_planes::<FRICTION, DAMPING>(
            field, slot, partners, base, book, load, tally,
        );
        return;
    }
    let ball = &field.balls[slot];
    for (at, partner) in partners.iter().enumerate() {
        let plane = &field.planes[*partner as usize];
        let height = (ball.place - plane.point).dot(&plane.normal);
        let touches = height.abs() <= ball.radius;
        if !touches && !book.touching[base + at] {
            continue;
        }
        let away = plane.normal * height;
        let spot = Spot {
            away,
            distance: height.abs(),
            velocity: plane.motion.velocity(&(ball.place - away)),
            spin: wall_spin(&plane.motion),
            material: plane.material,
            share: plane.share,
            touches,
        };
        at_wall::<FRICTION, DAMPING>(field, slot, &spot, book, base + at, load, tally);
    }
}

/// A triangle near a sphere.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// Its closest point, m.
    pub point: Vec3,
    /// Whether it acts on the sphere.
    pub touches: bool,
    /// Whether it took the spring of another in this pass.
    pub inherits: bool,
}

#[allow(clippy::too_many_arguments)] // the arguments of `on_planes` and the scratch
fn on_faces<const FRICTION: bool, const DAMPING: bool, const AVERAGED: bool>(
    field: &Field<'_>,
    slot: usize,
    partners: &[u32],
    base: usize,
    book: &mut BookView<'_>,
    load: &mut Load,
    tally: &mut Tally,
    hits: &mut Vec<Hit>,
) {
    if AVERAGED {
        averaged_pass::on_faces::<FRICTION, DAMPING>(
            field, slot, partners, base, book, load, tally, hits,
        );
        return;
    }
    let ball = &field.balls[slot];
    find_hits(field, ball, partners, hits);
    if FRICTION {
        hand_over::<DAMPING>(field, partners, base, book, hits);
    }
    for (at, (partner, hit)) in partners.iter().zip(hits.iter()).enumerate() {
        if !hit.touches && !book.touching[base + at] {
            continue;
        }
        let number = field.setting.surfaces.wall[*partner as usize] as usize;
        let (wall, motion) =
            (&field.setting.model.walls[number], &field.setting.walls[number].motion);
        let away = ball.place - hit.point;
        let spot = Spot {
            away,
            distance: away.norm(),
            velocity: motion.velocity(&hit.point),
            spin: wall_spin(motion),
            material: wall.material,
            share: field.setting.share,
            touches: hit.touches,
        };
        at_wall::<FRICTION, DAMPING>(field, slot, &spot, book, base + at, load, tally);
    }
}

/// Closest points, and which triangles touch under the rule of [`surface`].
fn find_hits(field: &Field<'_>, ball: &Ball, partners: &[u32], hits: &mut Vec<Hit>) {
    let surfaces = &field.setting.surfaces;
    hits.clear();
    for (at, partner) in partners.iter().enumerate() {
        let (point, feature) = surface::closest(&ball.place, &field.faces[*partner as usize]);
        let near = (ball.place - point).norm_squared() <= ball.radius * ball.radius;
        let touches = near
            && surfaces.acts(*partner as usize, feature)
            && !(feature == Feature::Face
                && partners[..at]
                    .iter()
                    .zip(hits.iter())
                    .any(|(other, hit)| hit.touches && surfaces.coplanar(*partner, *other)));
        hits.push(Hit { point, touches, inherits: false });
    }
}

/// A triangle that begins to touch takes the spring of a coplanar one that touched before.
pub fn hand_over<const DAMPING: bool>(
    field: &Field<'_>,
    partners: &[u32],
    base: usize,
    book: &mut BookView<'_>,
    hits: &mut [Hit],
) {
    for at in 0..partners.len() {
        if !hits[at].touches || book.touching[base + at] {
            continue;
        }
        let donor = (0..partners.len()).find(|other| {
            book.touching[base + other]
                && field.setting.surfaces.coplanar(partners[at], partners[*other])
        });
        let Some(donor) = donor else { continue };
        hits[at].inherits = true;
        book.spring[base + at] = book.spring[base + donor];
        if let Some(normal) = book.normal.get(base + donor).copied() {
            book.normal[base + at] = normal;
        }
        if DAMPING {
            book.lag[base + at] = book.lag[base + donor];
        }
        if let Some(pull) = book.pull.get(base + donor).copied() {
            book.pull[base + at] = pull;
        }
        if !hits[donor].touches {
            book.clear(base + donor);
        }
    }
}
