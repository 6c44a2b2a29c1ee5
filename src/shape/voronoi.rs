//! Voronoi cells: the part of space nearer to one point than to its neighbours.
//!
//! Neighbours are thrown at random into a ball about the middle point, at least
//! `spread`² of a mean distance apart (hard core: 0 gives a Poisson–Voronoi cell,
//! larger values more regular ones); the cell is the intersection of the half
//! spaces of the bisecting planes, then stretched. A cell that the thrown
//! points do not close is refused and drawn again. Convex. Cost O(points²).

use super::draw::{Draw, Drawn, Fact};
use crate::geometry::GeometryError;
use crate::geometry::polyhedron::Polyhedron;
use crate::num::random::{self, Stream};
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Cells of random points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VoronoiParameters {
    /// Least distance of points over that of a close packing of as many, from 0 (any) to 0.7; default 0.4.
    pub regularity: f64,
    /// Stretch along x, y, z afterwards, each from 0.1 to 10; default [1, 1, 1].
    pub axes: [f64; 3],
}

impl Default for VoronoiParameters {
    fn default() -> Self {
        Self { regularity: 0.4, axes: [1.0; 3] }
    }
}

/// Points in the ball; its radius for one point a unit volume is 4.57, far more than cells reach.
const POINTS: usize = 400;
/// Throws of a point before it is placed anyway.
const THROWS: u32 = 2000;

impl Draw for VoronoiParameters {
    fn validate(&self) -> Result<(), Fault> {
        Fault::within("regularity", self.regularity, 0.0, 0.7)?;
        for (axis, stretch) in self.axes.iter().enumerate() {
            Fault::within(&format!("axes[{axis}]"), *stretch, 0.1, 10.0)?;
        }
        Ok(())
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let radius = (3.0 * POINTS as f64 / (4.0 * std::f64::consts::PI)).cbrt();
        // One point a unit volume in close packing: 2^(1/6) apart.
        let apart = self.regularity * 2f64.powf(1.0 / 6.0);
        let mut points = vec![Vec3::zeros()];
        while points.len() < POINTS {
            for throw in 0..THROWS {
                let reach = radius * random::uniform(stream, 0.0, 1.0).cbrt();
                let point = random::direction(stream) * reach;
                let free = points.iter().all(|other| (other - point).norm() >= apart);
                if free || throw + 1 == THROWS {
                    points.push(point);
                    break;
                }
            }
        }
        let mut cell = Polyhedron::cuboid(Vec3::repeat(radius));
        for point in &points[1..] {
            let distance = point.norm();
            cell.cut(&(point / distance), 0.5 * distance);
        }
        let reach = cell.corners().iter().map(Vec3::norm).fold(0.0, f64::max);
        if reach > 0.5 * radius {
            // A point outside the ball could still cut such a corner.
            let reason = format!("the cell is not closed: it reaches {reach:.2} of {radius:.2}");
            return Err(GeometryError::Method { reason });
        }
        let stretch = Vec3::from(self.axes);
        Ok(Drawn {
            mesh: cell.mesh().mapped(|p| p.component_mul(&stretch)),
            recipe: format!("Voronoi cell of {} faces", cell.faces()),
            facts: vec![Fact::found("faces", cell.faces() as f64)],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poisson_cells_have_the_known_mean_number_of_faces() {
        let parameters = VoronoiParameters { regularity: 0.0, ..Default::default() };
        let (mut faces, mut cells) = (0.0, 0.0);
        for index in 0..150 {
            // Large cells are refused more often: the mean is a little low.
            if let Ok(drawn) = parameters.draw(&mut random::stream(1, "voronoi", index)) {
                faces += drawn.facts[0].measured;
                cells += 1.0;
            }
        }
        // 48π²/35 + 2 = 15.54 (Meijering 1953), standard deviation 3.3 a cell.
        assert!(
            cells > 50.0 && (faces / cells - 15.54).abs() < 1.5,
            "{} of {cells}",
            faces / cells
        );
    }
}
