//! What every random method of this room has in common: parameters, a draw
//! from a stream of random numbers, and what was asked for beside what came out.

use crate::geometry::{GeometryError, Mesh};
use crate::num::Fault;
use crate::num::random::Stream;
use serde::{Deserialize, Serialize};

/// A random method: its parameters can be checked, and it draws surfaces.
pub trait Draw {
    /// The first value out of its range, if any; keys relative to the parameters.
    fn validate(&self) -> Result<(), Fault>;
    /// One surface. It need not be a valid grain: the gate judges that afterwards.
    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError>;
}

/// A surface as a method drew it, before the gate.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Surface in the method's own unit of length.
    pub mesh: Mesh,
    /// How it was made, one line for people.
    pub recipe: String,
    /// Statistics of the surface, asked and measured.
    pub facts: Vec<Fact>,
}

/// One statistic of a drawn surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fact {
    /// What, with its unit where it has one.
    pub quantity: String,
    /// What the parameters ask for, where they do.
    pub asked: Option<f64>,
    /// What the surface has.
    pub measured: f64,
}

impl Fact {
    /// A statistic that the parameters ask for.
    pub fn asked(quantity: &str, asked: f64, measured: f64) -> Self {
        Self { quantity: quantity.to_owned(), asked: Some(asked), measured }
    }

    /// A statistic that comes out as it comes.
    pub fn found(quantity: &str, measured: f64) -> Self {
        Self { quantity: quantity.to_owned(), asked: None, measured }
    }
}

/// A fault unless `low` ≤ `pair[0]` ≤ `pair[1]` ≤ `high`.
pub(super) fn ordered(key: &str, pair: [f64; 2], low: f64, high: f64) -> Result<(), Fault> {
    Fault::within(&format!("{key}[0]"), pair[0], low, high)?;
    Fault::within(&format!("{key}[1]"), pair[1], pair[0], high)
}

/// As [`ordered`], for whole numbers.
pub(super) fn ordered_whole(key: &str, pair: [u32; 2], low: u32, high: u32) -> Result<(), Fault> {
    ordered(key, pair.map(f64::from), f64::from(low), f64::from(high))
}
