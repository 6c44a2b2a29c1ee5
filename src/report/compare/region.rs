//! Where heights and porosity are measured.
//!
//! * Up is against gravity; without gravity it is z (y in two dimensions).
//! * The floor is an axis-aligned plane that faces up, else the lowest point of any
//!   sphere in *our* final state, for every run.
//! * The container seen from above is bounded by axis-aligned planes; where these
//!   do not close it, by mesh walls, cut at `SLICES` heights: the area inside a
//!   cut is ∮ u dv over its segments (Green), with v the axis along which planes
//!   close what the meshes leave open. Without walls around there is no porosity.
//!
//! Cost O(walls + triangles × slices).

use crate::geometry::Mesh;
use crate::model::{Frame, Model, WallShape};
use crate::num::Vec3;
use crate::report::gallery::upwards;

/// Heights at which mesh walls are cut.
const SLICES: usize = 48;

/// The part of space in which a bed is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Unit vector upwards.
    pub up: Vec3,
    /// Height of the floor along `up`, m.
    pub base: f64,
    room: Room,
}

/// The container from the floor upwards.
#[derive(Debug, Clone, PartialEq)]
enum Room {
    /// None, or nothing that could be measured.
    Open,
    /// The same area at every height, m² (length in m in two dimensions).
    Prism(f64),
    /// Room between the floor and 1, 2, … steps above it, m³.
    Slices { step: f64, beneath: Vec<f64> },
}

impl Region {
    /// Of a model whose last state in our run is `last` (else its state at time 0).
    pub fn of(model: &Model, last: Option<&Frame>) -> Self {
        let up = upwards(model);
        let time = last.map_or(0.0, |frame| frame.time);
        let sides = Sides::of(model, time);
        let axis = up.iamax();
        let aligned = up[axis].abs() > 1.0 - 1e-9;
        let floor =
            aligned.then(|| if up[axis] > 0.0 { sides.low[axis] } else { sides.high[axis] });
        let lowest = || {
            let initial = model.sphere_centres(&model.initial_states());
            let centres = last.map_or(&initial, |frame| &frame.centres);
            let bottoms = centres.iter().zip(&model.spheres).map(|(c, s)| c.dot(&up) - s.radius);
            let lowest = bottoms.fold(f64::INFINITY, f64::min);
            if lowest.is_finite() { lowest } else { 0.0 }
        };
        let base = floor.flatten().map_or_else(lowest, |place| place * up[axis].signum());
        let mut region = Self { up, base, room: Room::Open };
        if aligned && model.gravity.norm_squared() > 0.0 {
            region.room = region.room(model, &sides, axis);
        }
        region
    }

    /// Room of the container between the floor and the height `top` above it, m³
    /// (m² in two dimensions); `None` if there is no container.
    pub fn beneath(&self, top: f64) -> Option<f64> {
        let room = match &self.room {
            Room::Open => return None,
            Room::Prism(area) => area * top,
            Room::Slices { step, beneath } => {
                let place = (top / step).clamp(0.0, beneath.len() as f64);
                let whole = (place.floor() as usize).min(beneath.len() - 1);
                let below = if whole > 0 { beneath[whole - 1] } else { 0.0 };
                below + (beneath[whole] - below) * (place - whole as f64)
            }
        };
        (room > 0.0).then_some(room)
    }

    fn room(&self, model: &Model, sides: &Sides, axis: usize) -> Room {
        let across: Vec<usize> =
            (0..model.dimension.count()).filter(|other| *other != axis).collect();
        let width = |axis: usize| Some(sides.high[axis]? - sides.low[axis]?);
        let widths: Vec<f64> = across.iter().filter_map(|axis| width(*axis)).collect();
        if widths.len() == across.len() {
            return Room::Prism(widths.iter().product());
        }
        let [u, v] = across[..] else { return Room::Open };
        let (u, v) = if width(u).is_some() { (v, u) } else { (u, v) };
        let heights = sides.meshes.iter().flat_map(|mesh| &mesh.vertices);
        let top = heights.map(|p| p.dot(&self.up) - self.base).fold(0.0, f64::max);
        let step = top / SLICES as f64;
        let mut sum = 0.0;
        let beneath: Vec<f64> = (0..SLICES)
            .map(|slice| {
                let height = self.base + (slice as f64 + 0.5) * step;
                let areas = sides.meshes.iter().map(|mesh| self.cut(mesh, height, u, v).abs());
                sum += areas.fold(0.0, f64::max) * step;
                sum
            })
            .collect();
        if sum > 0.0 { Room::Slices { step, beneath } } else { Room::Open }
    }

    /// ∮ u dv round the cut of a surface at `height`, with the sense of its triangles.
    fn cut(&self, mesh: &Mesh, height: f64, u: usize, v: usize) -> f64 {
        mesh.facets()
            .filter_map(|corners| {
                let above = corners.map(|corner| corner.dot(&self.up) - height);
                // From where the outline of the triangle goes up through the plane to where it goes down.
                let crossing = |rising: bool| {
                    (0..3).find_map(|at| {
                        let next = (at + 1) % 3;
                        let (a, b) = (above[at], above[next]);
                        ((a < 0.0) == rising && (a < 0.0) != (b < 0.0))
                            .then(|| corners[at] + (corners[next] - corners[at]) * (a / (a - b)))
                    })
                };
                let (from, to) = (crossing(true)?, crossing(false)?);
                Some(0.5 * (from[u] + to[u]) * (to[v] - from[v]))
            })
            .sum()
    }
}

/// What bounds the scene at one time.
struct Sides {
    /// Coordinate of the plane that bounds each axis from below, and from above.
    low: [Option<f64>; 3],
    high: [Option<f64>; 3],
    meshes: Vec<Mesh>,
}

impl Sides {
    fn of(model: &Model, time: f64) -> Self {
        let mut sides = Self { low: [None; 3], high: [None; 3], meshes: Vec::new() };
        for wall in &model.walls {
            match &wall.shape {
                WallShape::Mesh { mesh } => {
                    sides.meshes.push(mesh.mapped(|vertex| wall.motion.place(vertex, time)));
                }
                WallShape::Plane { point, .. } => {
                    let Some((axis, _, side)) = wall.shape.axis_plane() else { continue };
                    let place = wall.motion.place(point, time)[axis];
                    if side > 0.0 {
                        let old = sides.low[axis].unwrap_or(place);
                        sides.low[axis] = Some(old.max(place));
                    } else {
                        let old = sides.high[axis].unwrap_or(place);
                        sides.high[axis] = Some(old.min(place));
                    }
                }
            }
        }
        sides
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Motion, Wall};
    use crate::report::fixture;

    /// An upright or lying tube of 64 sides without ends, radius 1, length 4, about `axis`.
    fn tube(axis: usize) -> Mesh {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for side in 0..64_u32 {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(side) / 64.0).sin_cos();
            for along in [-2.0, 2.0] {
                let mut vertex = Vec3::zeros();
                (vertex[axis], vertex[(axis + 1) % 3], vertex[(axis + 2) % 3]) = (along, cos, sin);
                vertices.push(vertex);
            }
            let (a, b) = (2 * side, 2 * ((side + 1) % 64));
            triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
        Mesh { vertices, triangles }
    }

    fn region(axis: usize) -> Region {
        let mut model = fixture::model(1);
        model.walls.clear();
        model.walls.push(Wall {
            name: "tube".into(),
            shape: WallShape::Mesh { mesh: tube(axis) },
            motion: Motion::Still,
            material: 0,
        });
        for (place, side) in [(-2.0, 1.0), (2.0, -1.0)] {
            let (mut point, mut normal) = (Vec3::zeros(), Vec3::zeros());
            (point[axis], normal[axis]) = (place, side);
            model.walls.push(Wall {
                name: "end".into(),
                shape: WallShape::Plane { point, normal },
                motion: Motion::Still,
                material: 0,
            });
        }
        let mut frame = fixture::frame(&model, 0, Vec3::zeros());
        frame.centres[0] = Vec3::new(0.0, 0.0, -1.0 + model.spheres[0].radius);
        Region::of(&model, Some(&frame))
    }

    #[test]
    fn an_upright_tube_holds_its_area_times_the_height() {
        let region = region(2);
        let area = 32.0 * (std::f64::consts::TAU / 64.0).sin();
        assert_eq!(region.base, -2.0);
        for top in [0.03, 1.0, 3.99] {
            let found = region.beneath(top).expect("a container");
            assert!((found / (area * top) - 1.0).abs() < 1e-12, "{top}: {found}");
        }
    }

    #[test]
    fn a_lying_tube_between_planes_holds_a_segment() {
        let region = region(1);
        assert!((region.base + 1.0).abs() < 1e-12);
        let full = region.beneath(2.0).expect("a container");
        assert!((full / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{full}");
        let half = region.beneath(1.0).expect("a container");
        assert!((half / (2.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{half}");
    }

    #[test]
    fn without_walls_around_there_is_no_porosity() {
        let mut model = fixture::model(2);
        assert!(Region::of(&model, None).beneath(1.0).is_some());
        model.walls.truncate(2);
        assert_eq!(Region::of(&model, None).beneath(1.0), None);
    }
}
