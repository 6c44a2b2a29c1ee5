//! Growth methods that stop at the first touch: all balls at one speed (P5), or each
//! at its own (P6). See [`super::touch_and_stop`] for what is computed and at what cost.
//!
//! Sizes come out of the method: grains go into balls by rank of size and are scaled.

use super::random_apollonian::{cap, validate_sizes};
use super::space::Space;
use super::touch_and_stop::{Rule, grow};
use super::{Grain, Laid, Turn, dress};
use crate::geometry::{Ball, Region};
use crate::num::units::Length;
use crate::num::{Fault, Job};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When balls are born.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Births {
    /// All at the start: ends at a solid fraction near 0.349 in two dimensions and 0.186 in three.
    Together,
    /// One after another at random times: this many (0.001 to 1 000 000 000) while the fastest
    /// ball grows by the mean spacing (volume / number of grains)^(1/d). The more, the more balls grow at a time.
    Steady(f64),
}

/// Parameters of simultaneous growth (P5).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SimultaneousGrowth {
    /// When balls are born; default `together`.
    pub births: Births,
    /// Largest diameter, m, greater than 0; default without limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest: Option<Length>,
    /// Balls with a smaller diameter are left out at the end, m; default 0.
    pub smallest: Length,
    /// Births in taken places one after another before the method ends, 1 to 1 000 000 000; default 100 000.
    pub tries: u32,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
}

impl Default for SimultaneousGrowth {
    fn default() -> Self {
        Self {
            births: Births::Together,
            largest: None,
            smallest: Length(0.0),
            tries: 100_000,
            orientation: Turn::Random,
        }
    }
}

/// Parameters of packing-limited growth (P6).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PackingLimitedGrowth {
    /// When balls are born; default `{ steady = 10 }`.
    pub births: Births,
    /// Speed of the slowest over that of the fastest, above 0 to 1; speeds are uniform between; default 0.1.
    pub slowest: f64,
    /// Largest diameter, m, greater than 0; default that of the largest grain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest: Option<Length>,
    /// Balls with a smaller diameter are left out at the end, m; default 0.
    pub smallest: Length,
    /// Births in taken places one after another before the method ends, 1 to 1 000 000 000; default 100 000.
    pub tries: u32,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
}

impl Default for PackingLimitedGrowth {
    fn default() -> Self {
        Self {
            births: Births::Steady(10.0),
            slowest: 0.1,
            largest: None,
            smallest: Length(0.0),
            tries: 100_000,
            orientation: Turn::Random,
        }
    }
}

impl Births {
    fn validate(self) -> Result<(), Fault> {
        match self {
            Self::Together => Ok(()),
            Self::Steady(rate) => Fault::within("births.steady", rate, 1e-3, 1e9),
        }
    }

    /// Births a unit of time, for `count` balls in `space`.
    pub fn rate(self, space: &Space, count: usize) -> Option<f64> {
        let spacing = (space.volume() / count.max(1) as f64).powf(1.0 / space.dimension as f64);
        match self {
            Self::Together => None,
            Self::Steady(rate) => Some(rate / spacing),
        }
    }
}

impl SimultaneousGrowth {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("tries", f64::from(self.tries), 1.0, 1e9)?;
        self.births.validate()?;
        validate_sizes(self.largest, self.smallest)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let cap = self.largest.map_or(f64::INFINITY, |length| 0.5 * length.0);
        let space = Space::of(region);
        let births = self.births.rate(&space, grains.len());
        let rule = Rule { births, slowest: 1.0, cap, tries: self.tries };
        let grown = grow(&space, grains.len(), &rule, seed, job);
        Ok(dressed(grains, grown, self.smallest, &space, self.orientation, seed))
    }
}

impl PackingLimitedGrowth {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("tries", f64::from(self.tries), 1.0, 1e9)?;
        Fault::within("slowest", self.slowest, 1e-6, 1.0)?;
        self.births.validate()?;
        validate_sizes(self.largest, self.smallest)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let space = Space::of(region);
        let births = self.births.rate(&space, grains.len());
        let cap = cap(self.largest, grains);
        let rule = Rule { births, slowest: self.slowest, cap, tries: self.tries };
        let grown = grow(&space, grains.len(), &rule, seed, job);
        Ok(dressed(grains, grown, self.smallest, &space, self.orientation, seed))
    }
}

fn dressed(
    grains: &[Grain],
    (mut balls, mut ended): (Vec<Ball>, String),
    smallest: Length,
    space: &Space,
    turn: Turn,
    seed: u64,
) -> Laid {
    let before = balls.len();
    balls.retain(|ball| 2.0 * ball.radius >= smallest.0);
    if balls.len() < before {
        ended.push_str(&format!("; {} too small", before - balls.len()));
    }
    dress::by_rank(grains, &balls, space.dimension, turn, seed, &ended)
}

#[cfg(test)]
mod tests {
    use super::super::samples::{brute_force, of, room, sphere};
    use super::super::{Method, pack};
    use super::*;

    #[test]
    fn grains_are_scaled_into_the_room_and_nothing_overlaps() {
        let methods = [
            Method::SimultaneousGrowth(SimultaneousGrowth::default()),
            Method::PackingLimitedGrowth(PackingLimitedGrowth::default()),
        ];
        for dimension in [2, 3] {
            let clumps = vec![sphere(0.1, dimension); 250];
            let grains = of(&clumps);
            let region = room(&vec![1.0; dimension]);
            for method in &methods {
                let packing = pack(&grains, &[], &region, method, 1, &Job::quiet()).expect("right");
                assert_eq!(packing.placements.len(), 250, "{}", packing.outcome);
                let (gap, wall) = brute_force(&packing, &grains, &region);
                assert!(gap > -1e-12 && wall > -1e-12, "{gap} {wall}");
                let again = pack(&grains, &[], &region, method, 1, &Job::quiet()).expect("right");
                assert_eq!(packing, again);
            }
        }
    }

    #[test]
    fn wrong_parameters_name_their_key() {
        let slow = PackingLimitedGrowth { slowest: 0.0, ..PackingLimitedGrowth::default() };
        assert_eq!(slow.validate().expect_err("zero").key, "slowest");
        let never = SimultaneousGrowth {
            births: Births::Steady(f64::NAN),
            ..SimultaneousGrowth::default()
        };
        assert_eq!(never.validate().expect_err("not a number").key, "births.steady");
    }
}
