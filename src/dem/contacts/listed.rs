//! Lists of places whose highest are known: then all exist where the highest do, and a pass need not look at each.
//!
//! Lists are built once in many passes. Who has one of these types has numbers that somebody looked at, and
//! that nobody has changed since. O(1) but where numbers are looked at; cannot fail.

use super::{Pairs, Second};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::ops::{Deref, Range};

/// Numbers that never change, and the highest of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Numbers<T> {
    values: Vec<T>,
    highest: T,
}

impl<T: Copy + Ord + Default> From<Vec<T>> for Numbers<T> {
    fn from(values: Vec<T>) -> Self {
        Self { highest: Bounded::of(&values).highest, values }
    }
}

impl<T> From<Numbers<T>> for Vec<T> {
    fn from(numbers: Numbers<T>) -> Self {
        numbers.values
    }
}

impl<T> Deref for Numbers<T> {
    type Target = Vec<T>;
    fn deref(&self) -> &Vec<T> {
        &self.values
    }
}

impl<T: Copy> Numbers<T> {
    /// All of them.
    pub fn all(&self) -> Bounded<'_, T> {
        Bounded { values: &self.values, highest: self.highest }
    }

    /// Some of them.
    pub fn part(&self, range: Range<usize>) -> Bounded<'_, T> {
        Bounded { values: &self.values[range], highest: self.highest }
    }
}

// As the numbers alone: what is read is looked at anew.
impl<T: Serialize> Serialize for Numbers<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.values.serialize(serializer)
    }
}

impl<'de, T: Deserialize<'de> + Copy + Ord + Default> Deserialize<'de> for Numbers<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Vec::deserialize(deserializer).map(Self::from)
    }
}

/// Numbers, none of which is above the highest.
#[derive(Debug, Clone, Copy)]
pub struct Bounded<'a, T> {
    values: &'a [T],
    highest: T,
}

impl<'a, T: Copy + Ord + Default> Bounded<'a, T> {
    /// Looks at all of them.
    pub fn of(values: &'a [T]) -> Self {
        let highest = values.iter().fold(T::default(), |top, value| top.max(*value));
        Self { values, highest }
    }
}

/// Pairs with the highest places among them.
#[derive(Debug, Clone, Copy)]
pub struct Listed<'a> {
    pairs: Pairs<'a>,
    highest: Highest,
}

/// No place is above these.
#[derive(Debug, Clone, Copy)]
pub struct Highest {
    /// Of the first spheres in the block.
    pub first: usize,
    /// Of what the second are.
    pub second: usize,
    /// Of the second in the block.
    pub seat: usize,
}

impl<'a> Listed<'a> {
    /// Pairs of a `block`: see [`Pairs`].
    pub fn new(
        (block, kind): (usize, Second),
        first: Bounded<'a, u16>,
        second: Bounded<'a, u32>,
        seats: Bounded<'a, u16>,
    ) -> Self {
        let highest = Highest {
            first: usize::from(first.highest),
            second: second.highest as usize,
            seat: usize::from(seats.highest),
        };
        let (first, second, seats) = (first.values, second.values, seats.values);
        Self { pairs: Pairs { block, first, second, seats, kind }, highest }
    }

    /// Looks at all `pairs`.
    pub fn of(pairs: Pairs<'a>) -> Self {
        let Pairs { block, first, second, seats, kind } = pairs;
        Self::new((block, kind), Bounded::of(first), Bounded::of(second), Bounded::of(seats))
    }

    /// The highest places.
    pub fn highest(&self) -> Highest {
        self.highest
    }
}

impl<'a> Deref for Listed<'a> {
    type Target = Pairs<'a>;
    fn deref(&self) -> &Pairs<'a> {
        &self.pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_is_known_of_what_was_built_and_of_what_was_read() {
        let built = Numbers::from(vec![3u32, 9, 2]);
        let text = serde_json::to_string(&built).expect("numbers can be written");
        assert_eq!(text, "[3,9,2]");
        let read: Numbers<u32> = serde_json::from_str(&text).expect("as they were written");
        assert_eq!((built.highest, &read), (9, &built));
        let part = read.part(2..3);
        assert_eq!((part.values, part.highest), (&[2][..], 9));
        assert_eq!(Numbers::<u32>::default().all().highest, 0);
    }
}
