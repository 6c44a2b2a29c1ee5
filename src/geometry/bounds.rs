//! Axis-aligned boxes.

use crate::num::Vec3;
use serde::{Deserialize, Serialize};

/// An axis-aligned box between two corners, metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Corner with the smallest coordinates.
    pub low: Vec3,
    /// Corner with the largest coordinates.
    pub high: Vec3,
}

impl Bounds {
    /// The box that holds nothing: grows to whatever is added.
    pub const EMPTY: Self = Self {
        low: Vec3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// The smallest box around `points`; [`Bounds::EMPTY`] for none.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| bounds.with(point))
    }

    /// This box grown to hold `point`.
    pub fn with(self, point: &Vec3) -> Self {
        Self { low: self.low.inf(point), high: self.high.sup(point) }
    }

    /// The smallest box that holds both.
    pub fn union(self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// This box moved outwards by `margin` on every side.
    pub fn grown(self, margin: f64) -> Self {
        let shift = Vec3::repeat(margin);
        Self { low: self.low - shift, high: self.high + shift }
    }

    /// Edge lengths.
    pub fn size(&self) -> Vec3 {
        self.high - self.low
    }

    /// Middle.
    pub fn centre(&self) -> Vec3 {
        (self.low + self.high) * 0.5
    }

    /// Length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        self.size().norm()
    }

    /// True if the box holds no point at all.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.low[axis] > self.high[axis])
    }

    /// True if `point` lies inside or on the box.
    pub fn contains(&self, point: &Vec3) -> bool {
        (0..3).all(|axis| (self.low[axis]..=self.high[axis]).contains(&point[axis]))
    }
}
