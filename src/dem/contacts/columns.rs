//! What the sweeps of [`super`] hand each other.

use super::*;
use crate::dem::averaged::Meeting;
use std::ops::{Deref, DerefMut};

/// One quantity of all pairs of a sweep.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub struct Column(pub [f64; SWEEP]);

/// What the sweeps over the same pairs hand each other, and the lines of the block.
#[derive(Debug)]
pub struct Scratch {
    /// Unit normal towards the first sphere.
    pub unit: Triple<Column>,
    /// Velocity of the first contact point relative to the other, m/s.
    pub velocity: Triple<Column>,
    /// Sum of both angular velocities, rad/s; where springs turn with it only.
    pub spins: Triple<Column>,
    /// Springs of the last pass, turned with the contacts, m.
    pub before: Triple<Column>,
    /// Overlap, m.
    pub overlap: Column,
    /// Of path-averaged contacts: see [`Meeting`].
    pub early: Triple<Column>,
    pub pull: Triple<Column>,
    pub ease: Column,
    pub across: Column,
    /// Lever arms, m.
    pub arms: [Column; 2],
    /// Which pairs touch, a bit each.
    pub touches: [u8; SWEEP],
    /// Force on the first sphere, N.
    pub push: Triple<Column>,
    /// Normal × tangential force, N.
    pub couple: Triple<Column>,
    /// Energies taken, J, one sum for each place in a group; and the power of moving planes, W.
    pub sums: [[f64; GROUP]; 3],
    pub power: [f64; GROUP],
    /// Velocity of the planes, m/s; where they move only.
    pub drift: Triple<Column>,
    /// Triangles that wait until they fill a sweep.
    pub waiting: Waiting,
    /// Closest points of the triangles near a sphere.
    pub hits: Vec<Hit>,
    /// Force and torque on each sphere of the block, then on strangers; zeros between blocks.
    pub pulls: Vec<Line>,
}

impl Default for Scratch {
    fn default() -> Self {
        let column = || Column([0.0; SWEEP]);
        let triple = || Triple { x: column(), y: column(), z: column() };
        Self {
            unit: triple(),
            velocity: triple(),
            spins: triple(),
            before: triple(),
            overlap: column(),
            early: triple(),
            pull: triple(),
            ease: column(),
            across: column(),
            arms: [column(), column()],
            touches: [0; SWEEP],
            push: triple(),
            couple: triple(),
            sums: [[0.0; GROUP]; 3],
            power: [0.0; GROUP],
            drift: triple(),
            waiting: Waiting { first: [0; SWEEP], second: [0; SWEEP], entry: [0; SWEEP], count: 0 },
            hits: Vec::new(),
            pulls: Vec::new(),
        }
    }
}

impl Scratch {
    /// Bytes that it takes.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.pulls.capacity() * size_of::<Line>()
    }
}

impl Triple<Column> {
    /// Writes one vector.
    pub fn put(&mut self, at: usize, value: Triple<f64>) {
        (self.x.0[at], self.y.0[at], self.z.0[at]) = (value.x, value.y, value.z);
    }
}

impl Scratch {
    /// Parts the pairs from `count` on, which fill up a group: they do not touch.
    #[inline(always)]
    pub fn part<const W: usize>(&mut self, count: usize, groups: usize) {
        for group in count / W..groups {
            let real = (1u32 << count.saturating_sub(group * W)) - 1;
            self.touches[within::<W>(group * W)] &= real as u8;
        }
    }

    /// Writes one path-averaged contact.
    pub fn put_meeting(&mut self, at: usize, meeting: &Meeting, arms: [f64; 2]) {
        self.unit.put(at, meeting.normal);
        self.velocity.put(at, meeting.velocity);
        self.early.put(at, meeting.early);
        self.pull.put(at, meeting.pull);
        self.overlap.0[at] = -meeting.gap;
        (self.ease.0[at], self.across.0[at]) = (meeting.ease, meeting.across);
        (self.arms[0].0[at], self.arms[1].0[at]) = (arms[0], arms[1]);
    }
}

impl Column {
    #[inline(always)]
    pub fn get<const W: usize, L: Wide<W>>(&self, at: usize) -> L {
        L::load(chunk(&self.0, within::<W>(at)))
    }

    #[inline(always)]
    pub fn set<const W: usize, L: Wide<W>>(&mut self, at: usize, value: L) {
        value.store(chunk_mut(&mut self.0, within::<W>(at)));
    }
}

/// `at`, of which the compiler then sees that `W` entries from there lie within a column.
#[inline(always)]
pub fn within<const W: usize>(at: usize) -> usize {
    at & (SWEEP - W)
}

/// `values` in groups of `W`.
#[inline(always)]
pub fn groups<const W: usize, T>(values: &[T], count: usize) -> &[[T; W]] {
    &values.as_chunks().0[..count]
}

/// The same, to be written; from entry `base`.
#[inline(always)]
pub fn groups_mut<const W: usize, T>(values: &mut [T], base: usize, count: usize) -> &mut [[T; W]] {
    // What is not kept is empty.
    let from = base.min(values.len());
    &mut values[from..].as_chunks_mut().0[..count]
}

impl Triple<Column> {
    #[inline(always)]
    pub fn get<const W: usize, L: Wide<W>>(&self, at: usize) -> Triple<L> {
        Triple { x: self.x.get(at), y: self.y.get(at), z: self.z.get(at) }
    }

    #[inline(always)]
    pub fn set<const W: usize, L: Wide<W>>(&mut self, at: usize, value: Triple<L>) {
        self.x.set(at, value.x);
        self.y.set(at, value.y);
        self.z.set(at, value.z);
    }
}

impl<C: Deref<Target = [f64]>> Triple<C> {
    /// The columns in groups of `W`, from entry `base`.
    #[inline(always)]
    pub fn groups<const W: usize>(&self, base: usize, count: usize) -> Triple<&[[f64; W]]> {
        Triple {
            x: groups(&self.x[base..], count),
            y: groups(&self.y[base..], count),
            z: groups(&self.z[base..], count),
        }
    }
}

impl<C: DerefMut<Target = [f64]>> Triple<C> {
    /// The same, to be written.
    #[inline(always)]
    pub fn groups_mut<const W: usize>(
        &mut self,
        base: usize,
        count: usize,
    ) -> Triple<&mut [[f64; W]]> {
        Triple {
            x: groups_mut(&mut self.x, base, count),
            y: groups_mut(&mut self.y, base, count),
            z: groups_mut(&mut self.z, base, count),
        }
    }
}

impl<const W: usize, G: Deref<Target = [[f64; W]]>> Triple<G> {
    /// The vectors of a group.
    #[inline(always)]
    pub fn load<L: Wide<W>>(&self, group: usize) -> Triple<L> {
        Triple {
            x: L::load(&self.x[group]),
            y: L::load(&self.y[group]),
            z: L::load(&self.z[group]),
        }
    }
}

impl<const W: usize> Triple<&mut [[f64; W]]> {
    /// Writes the vectors of a group.
    #[inline(always)]
    pub fn store<L: Wide<W>>(&mut self, group: usize, value: Triple<L>) {
        value.x.store(&mut self.x[group]);
        value.y.store(&mut self.y[group]);
        value.z.store(&mut self.z[group]);
    }
}

/// A small book: what contacts taken out of their lists remember.
pub struct Memories<const N: usize> {
    touching: [bool; N],
    spring: [[f64; N]; 3],
    lag: [f64; N],
    power: [f32; N],
    normal: [[f64; N]; 3],
    pull: [[f64; N]; 3],
}

impl<const N: usize> Memories<N> {
    pub fn new() -> Self {
        let zeros = [[0.0; N]; 3];
        let (touching, lag, power) = ([false; N], [0.0; N], [0.0; N]);
        Self { touching, spring: zeros, lag, power, normal: zeros, pull: zeros }
    }

    #[inline(always)]
    pub fn view(&mut self) -> BookView<'_> {
        fn columns<const N: usize>([x, y, z]: &mut [[f64; N]; 3]) -> Triple<&mut [f64]> {
            Triple { x, y, z }
        }
        BookView {
            touching: &mut self.touching,
            spring: columns(&mut self.spring),
            lag: &mut self.lag,
            power: &mut self.power,
            normal: columns(&mut self.normal),
            pull: columns(&mut self.pull),
        }
    }
}
