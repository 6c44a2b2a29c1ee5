//! Spheres that go on to the next step during the force pass, each as soon as the pass needs it no more: what is
//! read and written of it is then still in the innermost cache, and its load is never put into memory.
//!
//! A pair stands at its lower slot. So once the pairs of all slots up to a sphere are answered, its
//! own among them, nobody looks at it again in this pass, and it has all of its load. That
//! holds on one thread; several would look at spheres of each other's blocks. To the bit what
//! [`super::motion::advance`] does after the pass. O(1) a sphere; cannot fail.

use super::blocks::Part;
use super::contacts::{Bodies, ZEROS};
use super::lanes::Line;
use super::motion::{self, Flock, Leap, Went};
use super::setting::Setting;
use super::state::{Ball, Lights, State};
use crate::model::{Lost, Scheme};
use crate::num::Vec3;

/// Least number of spheres that go on together: to begin costs as much as a few of them.
const MANY: usize = 128;

/// Whether bodies are single spheres, all there, and only their contacts with spheres and walls act on them besides
/// gravity: then nothing happens between a pass and the move after it.
pub fn fits(setting: &Setting<'_>, state: &State) -> bool {
    let needs = &setting.needs;
    let more = needs.bonds
        || needs.extra()
        || needs.drag
        || needs.local_damping
        || needs.mutual_gravity
        || needs.servo_walls
        || needs.arrivals;
    !more
        && !setting.planar
        && state.solids.is_empty()
        && setting.scheme != Scheme::PathAveraged
        && setting.model.plan.guard.lost != Lost::Remove
}

/// All spheres of a pass.
pub struct Onward<'a> {
    pub setting: &'a Setting<'a>,
    pub leap: &'a Leap,
    pub lights: &'a Lights,
    /// See [`motion::Margin`], m.
    pub paces: &'a [f32],
    pub balls: &'a mut [Ball],
    /// Empty if nothing turns.
    pub spins: &'a mut [Vec3],
    /// Of all that have gone on.
    pub went: Went,
}

/// The spheres while the pairs of a block are answered.
pub struct Passing<'a, 'b> {
    all: &'a mut Onward<'b>,
    /// First sphere of the block, and first of those that have not gone on.
    first: usize,
    next: usize,
    /// What the block gets and has not yet looked at, and from whom.
    mail: &'a [[u32; 3]],
    earlier: &'a [Part<'a>],
}

impl<'b> Onward<'b> {
    /// None of the block that begins with sphere `first` has gone on yet; `mail` of `earlier` blocks is for it.
    pub fn block<'a>(
        &'a mut self,
        first: usize,
        mail: &'a [[u32; 3]],
        earlier: &'a [Part<'a>],
    ) -> Passing<'a, 'b> {
        Passing { all: self, first, next: first, mail, earlier }
    }
}

impl Bodies for Passing<'_, '_> {
    fn now(&self) -> (&[Ball], &[Vec3]) {
        (self.all.balls, self.all.spins)
    }

    fn left_behind(&mut self, place: usize, pulls: &mut [Line]) {
        if self.first + place >= self.next + MANY {
            self.go_on(place, pulls);
        }
    }
}

impl Passing<'_, '_> {
    /// All spheres before `place` go on.
    pub fn go_on(&mut self, place: usize, pulls: &mut [Line]) {
        let end = self.first + place;
        while let Some(([block, at, sphere], rest)) = self.mail.split_first()
            && (*sphere as usize) < end
        {
            let load = &self.earlier[*block as usize].pairs.strangers[*at as usize];
            let [x, y, z, _, u, v, w, _] = &mut pulls[*sphere as usize - self.first].0;
            (*x, *y, *z) = (*x + load.force.x, *y + load.force.y, *z + load.force.z);
            (*u, *v, *w) = (*u + load.torque.x, *v + load.torque.y, *w + load.torque.z);
            self.mail = rest;
        }
        let range = self.next..end;
        let Onward { setting, leap, lights, paces, balls, spins, went } = self.all;
        let pulls = &mut pulls[range.start - self.first..place];
        let mut flock = Flock {
            balls: &mut balls[range.clone()],
            spins: spins.get_mut(range.clone()).unwrap_or_default(),
            pulls,
            first: range.start,
            pace: &paces[range],
        };
        went.fast |= !motion::go(setting, lights, &mut flock, leap);
        pulls.fill(ZEROS);
        self.next = end;
    }
}
