//! Triangles side by side: contacts of spheres with triangles are found one by one, wait until they fill a
//! sweep, and are answered together by the law that answers pairs. O(1) a contact; cannot fail.

use super::*;

/// Who meets in the columns, of triangles.
#[derive(Debug)]
pub struct Waiting {
    pub first: [u16; SWEEP],
    pub second: [u32; SWEEP],
    /// Entries of the book.
    pub entry: [u32; SWEEP],
    pub count: usize,
}

/// A sphere that touches a triangle, or did at the last pass.
#[derive(Debug, Clone, Copy)]
pub struct Spot {
    /// Place of the sphere in the block.
    pub first: u16,
    /// Material of the wall.
    pub material: u16,
    /// Entry of the book.
    pub entry: usize,
    /// Unit vector from the wall to the centre of the sphere.
    pub normal: Vec3,
    /// Overlap, m.
    pub overlap: f64,
    /// Lever arm, m.
    pub arm: f64,
    /// Velocity of the sphere's contact point relative to the wall, m/s.
    pub velocity: Vec3,
    /// Sum of both angular velocities, rad/s.
    pub spins: Vec3,
    /// Velocity of the wall, m/s.
    pub drift: Vec3,
    /// Whether it touches.
    pub touches: bool,
}

/// Answers a triangle, soon: at the latest with [`answer_waiting`].
pub fn meet<K: Kind>(
    field: &Field<'_>,
    spot: &Spot,
    (block, book): (usize, &mut BookView<'_>),
    scratch: &mut Scratch,
) {
    let at = scratch.waiting.count;
    scratch.put(at, spot);
    scratch.waiting.count += 1;
    if scratch.waiting.count == SWEEP {
        answer_waiting::<K>(field, (block, book), scratch);
    }
}

impl Scratch {
    pub fn put(&mut self, at: usize, spot: &Spot) {
        self.unit.put(at, spot.normal.into());
        self.velocity.put(at, spot.velocity.into());
        self.spins.put(at, spot.spins.into());
        self.drift.put(at, spot.drift.into());
        (self.overlap.0[at], self.arms[0].0[at]) = (spot.overlap, spot.arm);
        // Gathered to one number for all of a group later.
        self.touches[at] = u8::from(spot.touches);
        self.waiting.first[at] = spot.first;
        self.waiting.second[at] = u32::from(spot.material);
        self.waiting.entry[at] = spot.entry as u32;
    }
}

/// Answers all triangles that wait.
pub fn answer_waiting<K: Kind>(
    field: &Field<'_>,
    (block, book): (usize, &mut BookView<'_>),
    scratch: &mut Scratch,
) {
    if scratch.waiting.count == 0 {
        return;
    }
    with_lanes_for!(K, field, L => waiting::<L, K>(field, (block, book), scratch));
}

/// [`answer_waiting`] with one version.
pub fn waiting<V: Version, K: Kind>(
    field: &Field<'_>,
    (block, book): (usize, &mut BookView<'_>),
    scratch: &mut Scratch,
) {
    let Waiting { mut first, second, entry, count } = scratch.waiting;
    scratch.waiting.count = 0;
    let whole = count.next_multiple_of(GROUP);
    // The last group is filled up with forces of 0.
    for at in count..whole {
        first[at] = first[0];
        scratch.touches[at] = 0;
        for triple in [&mut scratch.unit, &mut scratch.velocity, &mut scratch.spins] {
            triple.put(at, Triple::zero());
        }
        scratch.drift.put(at, Triple::zero());
        (scratch.overlap.0[at], scratch.arms[0].0[at]) = (0.0, 0.0);
    }
    for at in (0..whole).step_by(V::WIDE) {
        let bits = (0..V::WIDE).map(|l| scratch.touches[at + l] << l).sum();
        scratch.touches[at] = bits;
    }
    let mut kept = Memories::<SWEEP>::new();
    let mut view = kept.view();
    let entries = || entry[..count].iter().map(|entry| *entry as usize).enumerate();
    for (at, entry) in entries() {
        view.copy::<K>(at..at + 1, book, entry..entry + 1);
    }
    let pairs = Pairs {
        block,
        first: &first[..whole],
        second: &second[..whole],
        seats: &[],
        kind: Second::Faces,
    };
    let pairs = check(Listed::of(pairs), field, scratch.pulls.len());
    follow::<V, K>(field, (&view, 0), whole, scratch);
    V::answer::<K>(field, pairs, (&mut view, 0), scratch);
    if K::FRICTION {
        V::deliver_planes::<true, true>(pairs, scratch);
    } else {
        V::deliver_planes::<false, true>(pairs, scratch);
    }
    for (at, entry) in entries() {
        book.copy::<K>(entry..entry + 1, &view, at..at + 1);
    }
}
