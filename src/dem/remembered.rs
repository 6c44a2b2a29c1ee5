//! What contacts remember goes over from old lists to new ones, by the slots that spheres had before. O(listed pairs);
//! cannot fail.

use super::lanes::Triple;
use super::law::Book;
use super::setting::Setting;
use super::state::List;

impl List {
    /// The touching entries only.
    pub fn touching(mut self) -> Self {
        fn keep<T: Copy>(values: &mut Vec<T>, touching: &[bool]) {
            if !values.is_empty() {
                let mut kept = touching.iter();
                values.retain(|_| kept.next().is_some_and(|touching| *touching));
                values.shrink_to_fit();
            }
        }
        let mut left = 0;
        let mut from = 0;
        for start in &mut self.start {
            let to = *start as usize;
            left += self.book.touching[from..to].iter().filter(|touching| **touching).count();
            (from, *start) = (to, left as u32);
        }
        let touching = std::mem::take(&mut self.book.touching);
        let mut partner = Vec::from(self.partner);
        keep(&mut partner, &touching);
        self.partner = partner.into();
        keep(&mut self.book.lag, &touching);
        keep(&mut self.book.power, &touching);
        for vectors in [&mut self.book.spring, &mut self.book.normal, &mut self.book.pull] {
            vectors.all_mut().into_iter().for_each(|column| keep(column, &touching));
        }
        self
    }

    /// Entry of `slot` with `partner`.
    fn find(&self, slot: u32, partner: u32) -> Option<usize> {
        let slot = slot as usize;
        // There are no lists yet at the first build.
        let from = *self.start.get(slot)? as usize;
        let entries = &self.partner[from..self.start[slot + 1] as usize];
        entries.iter().position(|entry| *entry == partner).map(|at| from + at)
    }
}

/// Nothing is remembered of an entry.
const NEW: u32 = u32::MAX;
/// What is remembered is seen from the other side.
const TURNED: u32 = 1 << 31;

/// What sphere–sphere contacts remember, by the slots `before` the build of each slot. A list
/// holds a pair at the sphere that comes first.
pub fn of_pairs(
    setting: &Setting<'_>,
    old: List,
    (start, partner): (&[u32], &[u32]),
    before: &[u32],
) -> Book {
    let place = |slot: usize, other: u32| {
        let (one, other) = (before[slot], before[other as usize]);
        if one < other {
            old.find(one, other).map(|at| at as u32)
        } else {
            old.find(other, one).map(|at| at as u32 | TURNED)
        }
    };
    let places = places(start, partner, place);
    carry(setting, old.book, &places)
}

/// The same of contacts with walls, whose partners keep their numbers.
pub fn of_walls(
    setting: &Setting<'_>,
    old: List,
    (start, partner): (&[u32], &[u32]),
    before: &[u32],
) -> Book {
    let places =
        places(start, partner, |slot, wall| old.find(before[slot], wall).map(|at| at as u32));
    carry(setting, old.book, &places)
}

/// For each entry of a list its `place` in what is remembered.
fn places(start: &[u32], partner: &[u32], place: impl Fn(usize, u32) -> Option<u32>) -> Vec<u32> {
    let mut places = Vec::with_capacity(partner.len());
    for (slot, range) in start.windows(2).enumerate() {
        let entries = &partner[range[0] as usize..range[1] as usize];
        places.extend(entries.iter().map(|other| place(slot, *other).unwrap_or(NEW)));
    }
    places
}

/// A book of `old` entries at new places. One array after the other, so that few are there twice.
fn carry(setting: &Setting<'_>, old: Book, places: &[u32]) -> Book {
    fn moved<T: Copy>(
        (wanted, old): (bool, Vec<T>),
        places: &[u32],
        none: T,
        turn: impl Fn(T) -> T,
    ) -> Vec<T> {
        let of = |place: &u32| match *place {
            NEW => none,
            place if place & TURNED != 0 => turn(old[(place & !TURNED) as usize]),
            place => old[place as usize],
        };
        let wanted = if wanted { places } else { &[] };
        wanted.iter().map(of).collect()
    }
    let kept = setting.kept;
    let vectors = |wanted: bool, old: Triple<Vec<f64>>| {
        old.map(|column| moved((wanted, column), places, 0.0, |number| -number))
    };
    let Book { spring, lag, power, normal, pull, .. } = old;
    Book {
        lag: moved((kept.damping, lag), places, 0.0, |lag| lag),
        power: moved((kept.powers(), power), places, 0.0, |power| power),
        spring: vectors(kept.friction, spring),
        touching: places.iter().map(|place| *place != NEW).collect(),
        normal: vectors(kept.friction && kept.normals, normal),
        pull: vectors(kept.friction && kept.pulls, pull),
    }
}
