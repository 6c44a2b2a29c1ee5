//! G7: random growth of a cube (Sajjadi & Khalili 2015) by random expansion of
//! its boundary (Eden 1961).
//!
//! Starting from one cube, an empty cell that shares a face with the volume is
//! filled, chosen with weight d_axis · n^s: d for the direction of the face
//! over which it is reached (elongation), n the number of full cells beside it
//! (s > 0 smooths, s < 0 roughens). One piece by construction. Unit of length:
//! the edge of a cube. Cost O(cells · boundary).

use super::cells::{Cells, Joints, Pieces};
use super::draw::{Draw, Drawn, Fact, ordered_whole};
use crate::geometry::GeometryError;
use crate::num::Fault;
use crate::num::random::{self, Stream};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Random growth of a cube.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GrowthParameters {
    /// Least and largest number of cells, each from 1 to 20 000; default [80, 200].
    pub cells: [u32; 2],
    /// Weights of growth along x, y, z, each from 0.01 to 100; default [1, 1, 1].
    pub weights: [f64; 3],
    /// Power of the number of full neighbours, from -4 to 4; default 1.
    pub smoothing: f64,
    /// Cells that meet in an edge or a corner only: `fill` (default) or `keep`.
    pub joints: Joints,
}

impl Default for GrowthParameters {
    fn default() -> Self {
        Self { cells: [80, 200], weights: [1.0; 3], smoothing: 1.0, joints: Joints::Fill }
    }
}

impl Draw for GrowthParameters {
    fn validate(&self) -> Result<(), Fault> {
        ordered_whole("cells", self.cells, 1, 20_000)?;
        for (axis, weight) in self.weights.iter().enumerate() {
            Fault::within(&format!("weights[{axis}]"), *weight, 0.01, 100.0)?;
        }
        Fault::within("smoothing", self.smoothing, -4.0, 4.0)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let count = random::whole(stream, u64::from(self.cells[0]), u64::from(self.cells[1]));
        let mut full: Vec<[i64; 3]> = Vec::new();
        let mut state = Boundary::default();
        let mut next = [0i64; 3];
        for grown in 1..=count {
            full.push(next);
            state.fill(next);
            if grown < count {
                next = state.choose(self, stream);
            }
        }
        let mut cells = Cells::around(&full);
        // A void inside is filled: the boundary that grows is the outer one.
        let mended = cells.mend(self.joints, Pieces::Largest);
        Ok(Drawn {
            mesh: cells.mesh(),
            recipe: format!("random growth of a cube to {count} cells{mended}"),
            facts: vec![Fact::asked("cells", count as f64, cells.count() as f64)],
        })
    }
}

/// Cells of the volume and those beside it, with their full neighbours along each axis.
#[derive(Default)]
struct Boundary {
    known: BTreeMap<[i64; 3], Cell>,
}

#[derive(Clone, Copy)]
enum Cell {
    Full,
    Beside([u32; 3]),
}

impl Boundary {
    fn fill(&mut self, cell: [i64; 3]) {
        self.known.insert(cell, Cell::Full);
        for axis in 0..3 {
            for step in [-1, 1] {
                let mut there = cell;
                there[axis] += step;
                let entry = self.known.entry(there).or_insert(Cell::Beside([0; 3]));
                if let Cell::Beside(faces) = entry {
                    faces[axis] += 1;
                }
            }
        }
    }

    fn choose(&self, parameters: &GrowthParameters, stream: &mut Stream) -> [i64; 3] {
        let weight = |faces: &[u32; 3]| {
            let along = (0..3).map(|axis| parameters.weights[axis] * f64::from(faces[axis]));
            let full = f64::from(faces.iter().sum::<u32>());
            along.sum::<f64>() / full * full.powf(parameters.smoothing)
        };
        let beside = || {
            self.known.iter().filter_map(|(cell, state)| match state {
                Cell::Full => None,
                Cell::Beside(faces) => Some((*cell, weight(faces))),
            })
        };
        let total: f64 = beside().map(|(_, weight)| weight).sum();
        let mut left = random::uniform(stream, 0.0, total);
        let mut last = [0; 3];
        for (cell, weight) in beside() {
            last = cell;
            left -= weight;
            if left < 0.0 {
                break;
            }
        }
        last
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::topology::inspect;

    #[test]
    fn growth_is_one_piece_of_at_least_the_wanted_cells() {
        for index in 0..10 {
            let drawn = GrowthParameters::default()
                .draw(&mut random::stream(1, "growth", index))
                .expect("cells");
            let report = inspect(&drawn.mesh);
            assert!(report.is_closed() && report.pieces == 1, "{report:?}");
            let fact = &drawn.facts[0];
            assert!(fact.asked.is_some_and(|asked| fact.measured >= asked));
        }
    }

    #[test]
    fn weights_elongate_and_smoothing_lessens_the_area() {
        let drawn = |weights, smoothing| {
            let cells = [400, 400];
            let growth = GrowthParameters { cells, weights, smoothing, joints: Joints::Fill };
            growth.draw(&mut random::stream(2, "growth", 0)).expect("cells").mesh
        };
        let long = drawn([1.0, 1.0, 20.0], 1.0).bounds().size();
        assert!(long.z > 2.0 * long.x.max(long.y), "{long}");
        let per_volume = |mesh: crate::geometry::Mesh| mesh.area() / mesh.mass_properties().volume;
        assert!(per_volume(drawn([1.0; 3], 3.0)) < 0.8 * per_volume(drawn([1.0; 3], -2.0)));
    }
}
