//! G5: random rain of cubes (Sajjadi & Khalili 2015).
//!
//! Cubes fall, one after another, on random places of a grid of columns and
//! stop on what lies there; the matrix of how many cubes stand at each place is
//! the volume. With `sticking` a cube also stops beside a cube that is already
//! there, its side against that cube's (ballistic deposition, Vold 1959), which
//! makes overhangs. Unit of length: the edge of a cube. Cost O(cubes).
//! Not every draw is one piece: the gate says so, and it is drawn again.

use super::cells::{Cells, Joints, Pieces};
use super::draw::{Draw, Drawn, Fact, ordered_whole};
use crate::geometry::GeometryError;
use crate::num::Fault;
use crate::num::random::{self, Stream};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rain of cubes on a grid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RainParameters {
    /// Columns of the grid along x and y, each from 1 to 100; default [4, 4].
    pub grid: [u32; 2],
    /// Least and largest number of cubes, each from 1 to 100 000; default [30, 60].
    pub cubes: [u32; 2],
    /// Cubes also stop beside other cubes; default false.
    pub sticking: bool,
    /// Cubes that meet in an edge or a corner only: `fill` (default) or `keep`.
    pub joints: Joints,
    /// Several pieces: `refuse` (default) or `largest`.
    pub pieces: Pieces,
}

impl Default for RainParameters {
    fn default() -> Self {
        Self {
            grid: [4, 4],
            cubes: [30, 60],
            sticking: false,
            joints: Joints::Fill,
            pieces: Pieces::Refuse,
        }
    }
}

impl Draw for RainParameters {
    fn validate(&self) -> Result<(), Fault> {
        for (index, columns) in self.grid.iter().enumerate() {
            Fault::within(&format!("grid[{index}]"), f64::from(*columns), 1.0, 100.0)?;
        }
        ordered_whole("cubes", self.cubes, 1, 100_000)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let [nx, ny] = self.grid.map(i64::from);
        let count = random::whole(stream, u64::from(self.cubes[0]), u64::from(self.cubes[1]));
        let mut tops = vec![0i64; (nx * ny) as usize];
        let mut cubes: Vec<[i64; 3]> = Vec::new();
        for _ in 0..count {
            let column = random::whole(stream, 0, (nx * ny) as u64 - 1) as i64;
            let (x, y) = (column % nx, column / nx);
            let mut level = tops[column as usize];
            if self.sticking {
                for (i, j) in [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)] {
                    if (0..nx).contains(&i) && (0..ny).contains(&j) {
                        level = level.max(tops[(j * nx + i) as usize] - 1);
                    }
                }
            }
            tops[column as usize] = level + 1;
            cubes.push([x, y, level]);
        }
        let mut cells = Cells::around(&cubes);
        let pieces = cells.pieces();
        let mended = cells.mend(self.joints, self.pieces);
        Ok(Drawn {
            mesh: cells.mesh(),
            recipe: format!("rain of {count} cubes on {nx} x {ny} columns{mended}"),
            facts: vec![
                Fact::asked("cubes", count as f64, cells.count() as f64),
                Fact::found("pieces before mending", pieces as f64),
            ],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cube_is_in_the_volume() {
        let rain = RainParameters { joints: Joints::Keep, ..Default::default() };
        for sticking in [false, true] {
            let rain = RainParameters { sticking, ..rain.clone() };
            let drawn = rain.draw(&mut random::stream(1, "rain", 0)).expect("cubes");
            let fact = &drawn.facts[0];
            assert_eq!(fact.asked, Some(fact.measured));
            assert!((drawn.mesh.mass_properties().volume - fact.measured).abs() < 1e-9);
        }
    }

    #[test]
    fn columns_have_no_overhangs_and_sticking_makes_some() {
        let roofs = |sticking| {
            let rain = RainParameters { sticking, joints: Joints::Keep, ..Default::default() };
            let drawn = rain.draw(&mut random::stream(3, "rain", 0)).expect("cubes");
            let down =
                |[a, b, c]: [crate::num::Vec3; 3]| (b - a).cross(&(c - a)).z < 0.0 && a.z > 0.0;
            drawn.mesh.facets().filter(|corners| down(*corners)).count()
        };
        assert_eq!(roofs(false), 0);
        assert!(roofs(true) > 0);
    }
}
