//! G12: random Sierpinski (Menger) sponge (Sajjadi & Khalili 2015, after
//! fractal sponges of 2006).
//!
//! A cube is divided into 3 × 3 × 3; the seven cubes in the middles of the faces
//! and of the cube go, and each of the other 20 stays with probability p; the
//! same again in each that stayed, `level` times. Unit of length: the smallest
//! cube. Cost O(27^level). Mean fraction of the cube that stays: (20·p/27)^level.
//! Such a volume is often in several pieces, which the gate refuses; with
//! `pieces = "largest"` the largest one is the grain.

use super::cells::{Cells, Joints, Pieces};
use super::draw::{Draw, Drawn, Fact};
use crate::geometry::{GeometryError, topology};
use crate::num::Fault;
use crate::num::random::{self, Stream};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Sponge with cubes removed at random.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SpongeParameters {
    /// Times that cubes are divided, from 1 to 4; default 2.
    pub level: u32,
    /// Probability that each of the 20 cubes stays, from 0.1 to 1 (1: the regular sponge); default 0.95.
    pub probability: f64,
    /// Cubes that meet in an edge or a corner only: `fill` (default) or `keep`.
    pub joints: Joints,
    /// Several pieces: `refuse` (default) or `largest`.
    pub pieces: Pieces,
}

impl Default for SpongeParameters {
    fn default() -> Self {
        Self { level: 2, probability: 0.95, joints: Joints::Fill, pieces: Pieces::Refuse }
    }
}

impl Draw for SpongeParameters {
    fn validate(&self) -> Result<(), Fault> {
        Fault::within("level", f64::from(self.level), 1.0, 4.0)?;
        Fault::within("probability", self.probability, 0.1, 1.0)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let mut cubes = vec![[0usize; 3]];
        for _ in 0..self.level {
            let mut smaller = Vec::new();
            for [x, y, z] in cubes {
                for part in 0..27 {
                    let at = [part % 3, part / 3 % 3, part / 9];
                    let middles = at.iter().filter(|k| **k == 1).count();
                    // A number is drawn for each of the 20, so that the stream stays in step.
                    if middles < 2 && random::uniform(stream, 0.0, 1.0) < self.probability {
                        smaller.push([3 * x + at[0], 3 * y + at[1], 3 * z + at[2]]);
                    }
                }
            }
            cubes = smaller;
        }
        let edge = 3usize.pow(self.level);
        let mut cells = Cells::new([edge; 3]);
        cubes.iter().for_each(|cube| cells.set(*cube));
        let whole = (edge * edge * edge) as f64;
        let mut facts = vec![
            Fact::asked(
                "fraction of the cube",
                (20.0 * self.probability / 27.0).powi(self.level as i32),
                cells.count() as f64 / whole,
            ),
            Fact::found("pieces before mending", cells.pieces() as f64),
        ];
        let mended = cells.mend(self.joints, self.pieces);
        let mesh = cells.mesh();
        let report = topology::inspect(&mesh);
        facts.push(Fact::found("fraction of the cube after mending", cells.count() as f64 / whole));
        facts.push(Fact::found(
            "handles",
            report.pieces as f64 - 0.5 * report.euler_characteristic as f64,
        ));
        let recipe = format!(
            "Menger sponge of level {}, each cube kept with probability {}{mended}",
            self.level, self.probability
        );
        Ok(Drawn { mesh, recipe, facts })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(level: u32, probability: f64, index: u64) -> Drawn {
        SpongeParameters { level, probability, ..Default::default() }
            .draw(&mut random::stream(1, "sponge", index))
            .expect("cubes")
    }

    fn fact(drawn: &Drawn, quantity: &str) -> f64 {
        drawn.facts.iter().find(|f| f.quantity == quantity).expect("measured").measured
    }

    #[test]
    fn the_regular_sponge_has_its_known_volume_and_handles() {
        for (level, cubes, handles) in [(1, 20.0, 5.0), (2, 400.0, 81.0)] {
            let sponge = drawn(level, 1.0, 0);
            assert!((sponge.mesh.mass_properties().volume - cubes).abs() < 1e-9);
            assert_eq!(fact(&sponge, "handles"), handles);
            assert_eq!(fact(&sponge, "pieces before mending"), 1.0);
        }
    }

    #[test]
    fn the_mean_fraction_is_as_asked() {
        let mean =
            (0..200).map(|index| fact(&drawn(1, 0.7, index), "fraction of the cube")).sum::<f64>()
                / 200.0;
        // 4000 draws of probability 0.7: standard error 0.0072 of 20/27.
        assert!((mean - 14.0 / 27.0).abs() < 4.0 * 0.0072 * 20.0 / 27.0, "{mean}");
    }
}
