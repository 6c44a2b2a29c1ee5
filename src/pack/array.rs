//! Regular arrays (P9): nodes of a lattice, filled from the low corner.
//!
//! Square: rows and columns (simple cubic in three dimensions). Staggered:
//! hexagonal rows (hexagonal close packing, layers A B A B). The pitch is the
//! largest bounding sphere of all grains plus the gap, so equal spheres fill
//! π/4 and π/(2√3) of the plane, π/6 and π/(3√2) of space far from the walls.
//!
//! Lengths in m; p pitch, r largest bounding radius. Cost O(nodes visited) with
//! one clearance query a node for a cylinder or mesh, none for a box. Along periodic axes
//! the array is stretched so that whole steps (an even number of shifted rows or layers) fill the box. Grains
//! beyond the last node are dropped and reported.

use super::occupied::{clump_radius, placement};
use super::{Grain, Laid, Turn, common_velocity, finite_velocity, tally};
use crate::geometry::{Bounds, Region};
use crate::num::random::{direction, stream, uniform};
use crate::num::units::{Length, Speed};
use crate::num::{Fault, Job, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of a regular array.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Array {
    /// Arrangement; default `square`.
    pub pattern: Pattern,
    /// Distance between neighbouring bounding spheres and to the boundary, m, 0 or more; default 0.
    pub gap: Length,
    /// Largest random displacement from the node, m, 0 to half the gap (so nothing overlaps); default 0.
    pub jitter: Length,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
    /// Velocity of all bodies at the start, m/s; default 0.
    pub velocity: [Speed; 3],
}

impl Default for Array {
    fn default() -> Self {
        Self {
            pattern: Pattern::Square,
            gap: Length(0.0),
            jitter: Length(0.0),
            orientation: Turn::Random,
            velocity: [Speed(0.0); 3],
        }
    }
}

/// Arrangement of the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Pattern {
    /// Rows above rows: square in two dimensions, simple cubic in three.
    Square,
    /// Rows shifted by half a pitch: hexagonal in two dimensions, hexagonal close-packed in three.
    Staggered,
}

/// Room by which a node may miss the boundary, in radii: rounding only.
const SLACK: f64 = 1e-9;

impl Array {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::not_negative("gap", self.gap.0)?;
        Fault::not_negative("jitter", self.jitter.0)?;
        if self.jitter.0 > 0.5 * self.gap.0 {
            let problem = format!("is {} m, more than half of `gap`", self.jitter.0);
            return Err(Fault::new("jitter", problem, format!("0 to {} m", 0.5 * self.gap.0)));
        }
        finite_velocity(&self.velocity)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let dimension = region.dimension();
        let velocity = common_velocity(&self.velocity, dimension).map_err(|f| f.under("array"))?;
        let radius = grains.iter().map(clump_radius).fold(0.0, f64::max);
        let nodes = Nodes::new(self.pattern, region, radius, self.gap.0);
        let mut placements = Vec::with_capacity(grains.len());
        let mut free = nodes.iter().filter(|node| nodes.keep(region, node));
        for (index, grain) in grains.iter().enumerate() {
            if index % 4096 == 0 {
                job.report("grains placed", index as u64, grains.len() as u64);
                if job.is_cancelled() {
                    break;
                }
            }
            let Some(node) = free.next() else { break };
            let mut source = stream(seed, "pack.array", index as u64);
            let turn = self.orientation.draw(grain, dimension, &mut source);
            let shift = match (self.jitter.0 > 0.0, dimension) {
                (false, _) => Vec3::zeros(),
                (true, 2) => {
                    let angle = uniform(&mut source, 0.0, std::f64::consts::TAU);
                    let length = self.jitter.0 * uniform(&mut source, 0.0, 1.0).sqrt();
                    Vec3::new(angle.cos(), angle.sin(), 0.0) * length
                }
                (true, _) => {
                    direction(&mut source) * (self.jitter.0 * uniform(&mut source, 0.0, 1.0).cbrt())
                }
            };
            placements.push(placement(index, (node + shift, turn), velocity));
        }
        let dropped: Vec<u32> = (placements.len() as u32..grains.len() as u32).collect();
        let why = match job.is_cancelled() {
            true => "stopped before the array was full",
            false => "the array is full",
        };
        let outcome = tally(grains, &placements, &dropped, why);
        Ok(Laid { placements, dropped, outcome })
    }
}

/// Nodes of the lattice inside the bounds of a region, x fastest, then y, then z.
struct Nodes {
    pattern: Pattern,
    dimension: usize,
    /// Box that the centres lie in.
    room: Bounds,
    radius: f64,
    gap: f64,
    /// How many steps fill the box along each periodic axis.
    whole: [Option<usize>; 3],
}

impl Nodes {
    fn new(pattern: Pattern, region: &Region, radius: f64, gap: f64) -> Self {
        let room = region.bounds().grown(-(radius + gap));
        let dimension = region.dimension();
        let mut nodes = Self { pattern, dimension, room, radius, gap, whole: [None; 3] };
        let Some(cell) = region.cell() else { return nodes };
        let (size, (row, layer)) = (cell.bounds.size(), nodes.least_steps());
        for axis in (0..dimension).filter(|axis| cell.periodic[*axis]) {
            let step = [nodes.pitch(), row, layer][axis];
            let fits = ((size[axis] + SLACK * radius) / step) as usize;
            // Shifted rows and layers alternate: an odd one would meet its own image's neighbour.
            let even = pattern == Pattern::Staggered && axis > 0;
            nodes.whole[axis] = Some(if even { fits - fits % 2 } else { fits });
            (nodes.room.low[axis], nodes.room.high[axis]) =
                (cell.bounds.low[axis], cell.bounds.high[axis]);
        }
        nodes
    }

    /// Distance between nodes along x, between rows and between layers; along periodic
    /// axes a little more than the least, so that whole steps fill the box.
    fn spacing(&self) -> [f64; 3] {
        let (row, layer) = self.least_steps();
        let least = [self.pitch(), row, layer];
        std::array::from_fn(|axis| match self.whole[axis] {
            Some(steps) if steps > 0 => self.room.size()[axis] / steps as f64,
            _ => least[axis],
        })
    }

    fn pitch(&self) -> f64 {
        2.0 * self.radius + self.gap
    }

    /// Least distances between rows and between layers.
    fn least_steps(&self) -> (f64, f64) {
        match self.pattern {
            Pattern::Square => (self.pitch(), self.pitch()),
            Pattern::Staggered => {
                (self.pitch() * 0.75_f64.sqrt(), self.pitch() * (2.0 / 3.0_f64).sqrt())
            }
        }
    }

    /// How many steps from `from` stay inside on `axis`, the first node included.
    fn count(&self, axis: usize, shift: f64, step: f64) -> usize {
        if let Some(whole) = self.whole[axis] {
            return whole;
        }
        let length = self.room.size()[axis] - shift + SLACK * self.radius;
        if step > 0.0 && length >= 0.0 { (length / step) as usize + 1 } else { 0 }
    }

    fn iter(&self) -> impl Iterator<Item = Vec3> + '_ {
        let [pitch, row_step, layer_step] = self.spacing();
        let layers = if self.dimension == 2 { 1 } else { self.count(2, 0.0, layer_step) };
        (0..layers).flat_map(move |layer| {
            let odd_layer = self.pattern == Pattern::Staggered && layer % 2 == 1;
            // A sphere of layer B lies in the hollow of three spheres of layer A.
            let y_shift = if odd_layer { row_step / 3.0 } else { 0.0 };
            let rows = self.count(1, y_shift, row_step);
            (0..rows).flat_map(move |row| {
                let odd = self.pattern == Pattern::Staggered && (row % 2 == 1) != odd_layer;
                let x_shift = if odd { 0.5 * pitch } else { 0.0 };
                (0..self.count(0, x_shift, pitch)).map(move |column| {
                    let z = match self.dimension {
                        2 => 0.0,
                        _ => self.room.low.z + layer_step * layer as f64,
                    };
                    Vec3::new(
                        self.room.low.x + x_shift + pitch * column as f64,
                        self.room.low.y + y_shift + row_step * row as f64,
                        z,
                    )
                })
            })
        })
    }

    /// True if the bounding sphere of a node keeps the gap from the boundary.
    fn keep(&self, region: &Region, node: &Vec3) -> bool {
        matches!(region, Region::Box(_))
            || region.clearance(node) >= self.radius * (1.0 - SLACK) + self.gap
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{brute_force, of, periodic_room, room, sphere};
    use super::super::{Method, Packing, pack};
    use super::*;
    use crate::geometry::region::CylinderRegion;
    use std::f64::consts::PI;

    fn lay(grains: &[Grain], region: &Region, parameters: Array) -> Packing {
        pack(grains, &[], region, &Method::Array(parameters), 1, &Job::quiet())
            .expect("right parameters")
    }

    fn array(pattern: Pattern) -> Array {
        Array { pattern, ..Array::default() }
    }

    /// Solid fraction of equal spheres in the middle of an array, from the number of centres in a
    /// box whose faces are averaged over many offsets.
    fn core_fraction(packing: &Packing, radius: f64, dimension: usize, side: f64) -> f64 {
        let ball =
            if dimension == 2 { PI * radius.powi(2) } else { 4.0 / 3.0 * PI * radius.powi(3) };
        let mut source = stream(9, "core", 0);
        let (window, mut count) = (0.4 * side, 0_usize);
        let windows = 400;
        for _ in 0..windows {
            let low = Vec3::from_fn(|axis, _| {
                if axis < dimension { uniform(&mut source, 0.15, 0.45) * side } else { -1.0 }
            });
            let inside =
                |p: &Vec3| (0..dimension).all(|a| (0.0..window).contains(&(p[a] - low[a])));
            count += packing.placements.iter().filter(|laid| inside(&laid.position)).count();
        }
        count as f64 / f64::from(windows) * ball / window.powi(dimension as i32)
    }

    #[test]
    fn fractions_are_those_of_the_lattices() {
        let cases = [
            (Pattern::Square, 2, PI / 4.0, 60),
            (Pattern::Staggered, 2, PI / 12.0_f64.sqrt(), 60),
            (Pattern::Square, 3, PI / 6.0, 20),
            (Pattern::Staggered, 3, PI / 18.0_f64.sqrt(), 20),
        ];
        for (pattern, dimension, expected, across) in cases {
            let radius = 0.5 / f64::from(across);
            let clumps = vec![sphere(radius, dimension); 12_000];
            let grains = of(&clumps);
            let region = room(&vec![1.0; dimension]);
            let packing = lay(&grains, &region, array(pattern));
            let fraction = core_fraction(&packing, radius, dimension, 1.0);
            assert!((fraction / expected - 1.0).abs() < 0.01, "{pattern:?} {dimension} {fraction}");
            assert!(packing.measures.worst_overlap < 1e-9);
            assert!(packing.measures.porosity_error == 0.0);
        }
    }

    #[test]
    fn a_room_of_whole_pitches_is_full_to_the_last_node() {
        let clumps = vec![sphere(0.05, 3); 1001];
        let grains = of(&clumps);
        let packing = lay(&grains, &room(&[1.0, 1.0, 1.0]), array(Pattern::Square));
        assert_eq!(packing.placements.len(), 1000);
        assert_eq!(packing.dropped, [1000]);
        assert!((packing.measures.porosity - (1.0 - PI / 6.0)).abs() < 1e-12);
        // Six neighbours inside, five on faces, four on edges, three in corners.
        let contacts = 6.0 * 512.0 + 5.0 * 384.0 + 4.0 * 96.0 + 3.0 * 8.0;
        assert!((packing.measures.coordination - contacts / 1000.0).abs() < 1e-12);
    }

    #[test]
    fn lattices_go_on_across_periodic_sides() {
        let cases = [
            (Pattern::Square, 6.0, PI / 6.0, [1.0, 1.0, 1.0]),
            // Ten pitches, ten rows and twelve layers of a hexagonal close packing.
            (
                Pattern::Staggered,
                12.0,
                PI / 18.0_f64.sqrt(),
                [1.0, 0.75_f64.sqrt(), 1.2 * (2.0 / 3.0_f64).sqrt()],
            ),
        ];
        for (pattern, touching, fraction, size) in cases {
            let clumps = vec![sphere(0.05, 3); 1300];
            let grains = of(&clumps);
            let region = periodic_room(&size, [true; 3]);
            let packing = lay(&grains, &region, array(pattern));
            assert!((1.0 - packing.measures.porosity - fraction).abs() < 1e-6, "{pattern:?}");
            assert!((packing.measures.coordination - touching).abs() < 1e-9, "{pattern:?}");
            // A box that is a little larger is filled with as many, farther apart.
            let wider = periodic_room(&size.map(|edge| edge * 1.03), [true; 3]);
            let loose = lay(&grains, &wider, array(pattern));
            assert_eq!(loose.placements.len(), packing.placements.len());
            assert!(brute_force(&loose, &grains, &wider).0 > 2e-3);
        }
    }

    #[test]
    fn staggered_spheres_touch_twelve_others_in_the_core() {
        let clumps = vec![sphere(0.05, 3); 2000];
        let grains = of(&clumps);
        let packing = lay(&grains, &room(&[1.0, 1.0, 1.0]), array(Pattern::Staggered));
        let centre = Vec3::repeat(0.5);
        let middle = packing
            .placements
            .iter()
            .min_by(|a, b| (a.position - centre).norm().total_cmp(&(b.position - centre).norm()))
            .expect("placed");
        let near = |p: &&super::super::Placement| (p.position - middle.position).norm() < 0.1001;
        assert_eq!(packing.placements.iter().filter(near).count(), 13);
    }

    #[test]
    fn gap_and_jitter_never_overlap_and_stay_inside() {
        let clumps = vec![sphere(0.03, 3); 500];
        let grains = of(&clumps);
        let cylinder = Region::Cylinder(CylinderRegion {
            base: Vec3::zeros(),
            axis: 0,
            radius: 0.4,
            height: 1.0,
            segments: 24,
            open: [false; 2],
        });
        for region in [room(&[0.7, 0.8, 0.9]), cylinder] {
            for pattern in [Pattern::Square, Pattern::Staggered] {
                let parameters =
                    Array { gap: Length(0.01), jitter: Length(0.005), ..array(pattern) };
                let packing = lay(&grains, &region, parameters);
                assert!(packing.placements.len() > 300, "{}", packing.outcome);
                let (gap, wall) = brute_force(&packing, &grains, &region);
                assert!((0.0..0.01).contains(&gap) && wall > 0.0, "{gap} {wall}");
            }
        }
        let fault = Array { jitter: Length(0.1), ..Array::default() }.validate();
        assert_eq!(fault.expect_err("more than half the gap").key, "jitter");
    }

    #[test]
    fn nothing_fits_is_an_outcome() {
        let clumps = vec![sphere(0.6, 3); 2];
        let grains = of(&clumps);
        let packing = lay(&grains, &room(&[1.0, 5.0, 5.0]), Array::default());
        assert_eq!(packing.dropped, [0, 1]);
        assert!(lay(&[], &room(&[1.0, 1.0]), Array::default()).placements.is_empty());
    }
}
