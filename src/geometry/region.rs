//! The room that grains are packed into, as geometry: how far a point is from
//! the boundary, bounds, volume, points inside, and the walls that a run needs.
//!
//! A cylinder is treated as what its wall is: a regular prism of flat facets
//! whose inscribed radius is the radius asked for. A grain that is inside the
//! region therefore never overlaps a facet. O(1) a query for box and cylinder,
//! O(log triangles) for a mesh.

use super::collide::Place;
use super::cone::ConeRegion;
use super::hollow::HollowRegion;
use super::outline::OutlineRegion;
use super::primitive::Primitive;
use super::surface::{Surface, plane};
use super::{Bounds, Cell, Collider, Mesh, SignedDistance};
use crate::num::random::{Stream, uniform};
use crate::num::{Fault, Rotation, Vec3};
use std::f64::consts::{PI, TAU};
use std::fmt;

/// A resolved container.
#[derive(Debug)]
pub enum Region {
    /// A box, or a rectangle in two dimensions.
    Box(Rectangle),
    /// A faceted cylinder.
    Cylinder(CylinderRegion),
    /// The inside of a closed surface.
    Mesh(Box<MeshRegion>),
    /// A faceted cone.
    Cone(ConeRegion),
    /// Straight sides in two dimensions, with or without holes.
    Outline(OutlineRegion),
    /// A region of three dimensions with holes.
    Hollow(Box<HollowRegion>),
}

/// A box along the axes; in two dimensions its z extent (−0.5 m to 0.5 m) only carries the thickness.
#[derive(Debug, Clone, PartialEq)]
pub struct Rectangle {
    /// Corners, m.
    pub bounds: Bounds,
    /// 2 or 3.
    pub dimension: usize,
    /// `open[axis][0]`: no wall at the low side; `[1]`: none at the high side.
    pub open: [[bool; 2]; 3],
    /// Axes along which the box repeats itself: no boundary there.
    pub periodic: [bool; 3],
}

/// A regular prism about a cylinder.
#[derive(Debug, Clone, PartialEq)]
pub struct CylinderRegion {
    /// Middle of the low end, m.
    pub base: Vec3,
    /// Axis: 0, 1 or 2.
    pub axis: usize,
    /// Distance of every facet from the axis, m.
    pub radius: f64,
    /// Length, m.
    pub height: f64,
    /// Number of facets.
    pub segments: u32,
    /// True for an end without a wall: low, high.
    pub open: [bool; 2],
}

/// The inside of a closed surface.
pub struct MeshRegion {
    mesh: Mesh,
    distance: SignedDistance,
    volume: f64,
}

impl fmt::Debug for MeshRegion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MeshRegion({} triangles, {} m³)", self.mesh.triangles.len(), self.volume)
    }
}

/// A region that true shapes are held against.
pub struct SolidRoom<'a> {
    region: &'a Region,
    boundary: Option<Collider>,
    /// What is cut out of the region.
    holes: Vec<Collider>,
    /// A vertex of each connected part of the boundary: a solid must not swallow a part whole.
    parts: Vec<Vec3>,
}

impl Region {
    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        match self {
            Self::Box(room) => room.dimension,
            Self::Outline(_) => 2,
            _ => 3,
        }
    }

    /// The smallest box around the region; z from −0.5 m to 0.5 m in two dimensions.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Box(room) => room.bounds,
            Self::Cylinder(room) => room.bounds(),
            Self::Mesh(room) => room.mesh.bounds(),
            Self::Cone(room) => room.bounds(),
            Self::Outline(room) => room.bounds(),
            Self::Hollow(room) => room.outside().bounds(),
        }
    }

    /// How the region repeats itself, if it does.
    pub fn cell(&self) -> Option<Cell> {
        match self {
            Self::Box(room) if room.periodic.contains(&true) => {
                Some(Cell { bounds: room.bounds, periodic: room.periodic })
            }
            _ => None,
        }
    }

    /// Volume, m³; in two dimensions of the rectangle 1 m thick, so the same number as its area in m².
    pub fn volume(&self) -> f64 {
        match self {
            Self::Box(room) => {
                let size = room.bounds.size();
                size.x * size.y * if room.dimension == 2 { 1.0 } else { size.z }
            }
            Self::Cylinder(room) => {
                let n = f64::from(room.segments);
                n * room.radius.powi(2) * (PI / n).tan() * room.height
            }
            Self::Mesh(room) => room.volume,
            Self::Cone(room) => room.volume(),
            Self::Outline(room) => room.area(),
            Self::Hollow(room) => room.volume(),
        }
    }

    /// Distance from `point` to the boundary, open sides included, m; positive
    /// inside. Periodic sides are no boundary. Outside a box or cylinder the size is a lower bound.
    pub fn clearance(&self, point: &Vec3) -> f64 {
        match self {
            Self::Box(room) => room.clearance(point, |_, _| true),
            Self::Cylinder(room) => room.side(point).min(room.ends(point, [false; 2])),
            Self::Mesh(room) => -room.distance.at(point),
            Self::Cone(room) => room.clearance(point, [false; 2]),
            Self::Outline(room) => room.clearance(point, false),
            Self::Hollow(room) => room.outside().clearance(point).min(room.from_holes(point)),
        }
    }

    /// Like [`Region::clearance`] for the sides that have a wall: infinite where none has.
    pub fn wall_clearance(&self, point: &Vec3) -> f64 {
        match self {
            Self::Box(room) => {
                room.clearance(point, |axis, side| !room.open[axis][usize::from(side)])
            }
            Self::Cylinder(room) => room.side(point).min(room.ends(point, room.open)),
            Self::Mesh(_) => self.clearance(point),
            Self::Cone(room) => room.clearance(point, room.open),
            Self::Outline(room) => room.clearance(point, true),
            Self::Hollow(room) => room.outside().wall_clearance(point).min(room.from_holes(point)),
        }
    }

    /// The region made ready for [`SolidRoom::holds`]; `unit` as for [`Collider::new`].
    pub fn for_solids(&self, unit: f64) -> SolidRoom<'_> {
        let (bare, holes) = match self {
            Self::Hollow(room) => (room.outside(), room.colliders(unit)),
            _ => (self, Vec::new()),
        };
        let (boundary, parts) = match bare {
            Self::Mesh(room) => (Collider::new(&room.mesh, unit), one_of_each_part(&room.mesh)),
            _ => (None, Vec::new()),
        };
        SolidRoom { region: self, boundary, holes, parts }
    }

    /// A point uniform in the region (z = 0 in two dimensions), by rejection from the bounds;
    /// `None` if a million draws all fall outside, which takes a region that
    /// fills less than about 10⁻⁵ of its bounds.
    pub fn sample(&self, stream: &mut Stream) -> Option<Vec3> {
        self.sample_within(&self.bounds(), stream)
    }

    /// A point uniform in the part of the region inside `bounds`; `None` as for [`Region::sample`].
    pub fn sample_within(&self, bounds: &Bounds, stream: &mut Stream) -> Option<Vec3> {
        (0..1_000_000).find_map(|_| {
            let mut point = Vec3::zeros();
            for axis in 0..self.dimension() {
                point[axis] = uniform(stream, bounds.low[axis], bounds.high[axis]);
            }
            (self.clearance(&point) > 0.0).then_some(point)
        })
    }

    /// True if some side has no wall.
    pub fn is_open(&self) -> bool {
        match self {
            Self::Box(room) => room.open[..room.dimension].iter().flatten().any(|open| *open),
            Self::Cylinder(room) => room.open.contains(&true),
            Self::Mesh(_) => false,
            Self::Cone(room) => room.open.contains(&true),
            Self::Outline(room) => room.is_open(),
            Self::Hollow(room) => room.outside().is_open(),
        }
    }

    /// The closed surface around the region of three dimensions, open sides included,
    /// facing outwards; without the holes of a hollow one. No triangles in two dimensions.
    pub fn surface(&self) -> Mesh {
        match self {
            Self::Box(room) if room.dimension == 3 => {
                let Bounds { low, high } = room.bounds;
                let edges = high - low;
                Primitive::Box { edges }.mesh(3).mapped(|v| v + (low + high) * 0.5)
            }
            Self::Box(_) | Self::Outline(_) => Mesh::default(),
            Self::Cylinder(room) => ConeRegion {
                base: room.base,
                axis: room.axis,
                radii: [room.radius; 2],
                height: room.height,
                segments: room.segments,
                open: room.open,
            }
            .surface([false; 2]),
            Self::Mesh(room) => room.mesh.clone(),
            Self::Cone(room) => room.surface([false; 2]),
            Self::Hollow(room) => room.outside().surface(),
        }
    }

    /// The walls of a run with their names (letters, digits and `_`): planes
    /// for a box and for the ends of a cylinder, a mesh for the side of a
    /// cylinder and for a closed surface. Open sides have none.
    pub fn walls(&self) -> Vec<(String, Surface)> {
        match self {
            Self::Box(room) => room.walls(),
            Self::Cylinder(room) => room.walls(),
            Self::Mesh(room) => vec![("container".to_owned(), Surface::Mesh(room.mesh.clone()))],
            Self::Cone(room) => room.walls(),
            Self::Outline(room) => room.walls(),
            Self::Hollow(room) => room.walls(),
        }
    }
}

impl SolidRoom<'_> {
    /// True if the solid at `place` lies inside, no nearer than `gap` (m) to the boundary.
    pub fn holds(&self, solid: &Collider, place: &Place, gap: f64) -> bool {
        let inside = |v: &Vec3, gap| self.region.clearance(&(place.0 + place.1 * v)) >= gap;
        let still = (Vec3::zeros(), Rotation::identity());
        if self.holes.iter().any(|hole| hole.nearer_than(&still, solid, place, gap)) {
            return false;
        }
        let Some(boundary) = &self.boundary else {
            // A convex room holds a solid if it holds its vertices.
            return solid.vertices().iter().all(|v| inside(v, gap));
        };
        solid.vertices().first().is_some_and(|v| inside(v, gap))
            && !boundary.surfaces_nearer_than(&still, solid, place, gap)
            && !self.parts.iter().any(|part| solid.holds(place, part))
    }
}

/// The first vertex of each connected part of a mesh.
fn one_of_each_part(mesh: &Mesh) -> Vec<Vec3> {
    let mut parent: Vec<usize> = (0..mesh.vertices.len()).collect();
    fn root(parent: &mut [usize], mut at: usize) -> usize {
        while parent[at] != at {
            parent[at] = parent[parent[at]];
            at = parent[at];
        }
        at
    }
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c)] {
            let (from, to) = (root(&mut parent, from as usize), root(&mut parent, to as usize));
            parent[from.max(to)] = from.min(to);
        }
    }
    let mut first: Vec<usize> =
        mesh.triangles.iter().map(|t| root(&mut parent, t[0] as usize)).collect();
    first.sort_unstable();
    first.dedup();
    first.into_iter().map(|vertex| mesh.vertices[vertex]).collect()
}

impl Rectangle {
    fn clearance(&self, point: &Vec3, counts: impl Fn(usize, bool) -> bool) -> f64 {
        let mut least = f64::INFINITY;
        for axis in (0..self.dimension).filter(|axis| !self.periodic[*axis]) {
            if counts(axis, false) {
                least = least.min(point[axis] - self.bounds.low[axis]);
            }
            if counts(axis, true) {
                least = least.min(self.bounds.high[axis] - point[axis]);
            }
        }
        least
    }

    fn walls(&self) -> Vec<(String, Surface)> {
        let sides = (0..self.dimension).flat_map(|axis| [(axis, false), (axis, true)]);
        sides
            .filter(|&(axis, high)| !self.periodic[axis] && !self.open[axis][usize::from(high)])
            .map(|(axis, high)| {
                let mut point = self.bounds.centre();
                point[axis] = if high { self.bounds.high[axis] } else { self.bounds.low[axis] };
                plane(axis, high, point)
            })
            .collect()
    }
}

impl CylinderRegion {
    /// The two axes across the cylinder, right-handed with its own.
    fn across(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// Distance to the plane of the facet that the point looks at, which is the nearest one.
    fn side(&self, point: &Vec3) -> f64 {
        let [first, second] = self.across();
        let (u, v) = (point[first] - self.base[first], point[second] - self.base[second]);
        let step = TAU / f64::from(self.segments);
        let (sin, cos) = ((v.atan2(u) / step).round() * step).sin_cos();
        self.radius - (u * cos + v * sin)
    }

    fn ends(&self, point: &Vec3, open: [bool; 2]) -> f64 {
        let along = point[self.axis] - self.base[self.axis];
        let low = if open[0] { f64::INFINITY } else { along };
        let high = if open[1] { f64::INFINITY } else { self.height - along };
        low.min(high)
    }

    fn bounds(&self) -> Bounds {
        Bounds::of(&self.side_mesh().vertices)
    }

    /// The side without the ends: two triangles a facet, facing outwards.
    fn side_mesh(&self) -> Mesh {
        let [first, second] = self.across();
        let n = self.segments;
        let corner_radius = self.radius / (PI / f64::from(n)).cos();
        let mut vertices = Vec::with_capacity(2 * n as usize);
        for index in 0..n {
            let (sin, cos) = ((f64::from(index) - 0.5) * TAU / f64::from(n)).sin_cos();
            let mut corner = self.base;
            corner[first] += corner_radius * cos;
            corner[second] += corner_radius * sin;
            vertices.push(corner);
            corner[self.axis] += self.height;
            vertices.push(corner);
        }
        let triangles = (0..n)
            .flat_map(|index| {
                let (a, b) = (2 * index, 2 * ((index + 1) % n));
                [[a, b, b + 1], [a, b + 1, a + 1]]
            })
            .collect();
        Mesh { vertices, triangles }
    }

    fn walls(&self) -> Vec<(String, Surface)> {
        let mut walls = vec![("side".to_owned(), Surface::Mesh(self.side_mesh()))];
        for high in [false, true] {
            if !self.open[usize::from(high)] {
                let mut point = self.base;
                point[self.axis] += if high { self.height } else { 0.0 };
                walls.push(plane(self.axis, high, point));
            }
        }
        walls
    }
}

impl MeshRegion {
    /// The inside of `mesh` (m; vertices welded, outward-oriented).
    ///
    /// Errors: a surface that is empty, not closed, inside out or without volume.
    pub fn new(mesh: Mesh) -> Result<Self, Fault> {
        let wrong = |problem: String| Fault::new("file", problem, "a closed surface with volume");
        let distance = SignedDistance::new(&mesh).map_err(|error| wrong(error.to_string()))?;
        let volume = mesh.mass_properties().volume;
        Ok(Self { mesh, distance, volume })
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{box_mesh, l_mesh};
    use super::*;
    use crate::num::random::stream;
    use proptest::prelude::*;

    fn cylinder(axis: usize, segments: u32) -> CylinderRegion {
        let base = Vec3::new(1.0, -2.0, 0.5);
        CylinderRegion { base, axis, radius: 0.3, height: 0.8, segments, open: [false, true] }
    }

    /// Distance to the nearest of the walls that a run would get; planes signed, meshes not.
    fn distance_to_walls(region: &Region, point: &Vec3) -> f64 {
        let mut least = f64::INFINITY;
        for (_, wall) in region.walls() {
            match wall {
                Surface::Plane { point: on, normal } => {
                    least = least.min(normal.dot(&(point - on)));
                }
                Surface::Mesh(mesh) => {
                    for [a, b, c] in mesh.facets() {
                        let normal = (b - a).cross(&(c - a)).normalize();
                        least = least.min(-normal.dot(&(point - a)));
                    }
                }
            }
        }
        least
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn no_ball_inside_a_cylinder_overlaps_a_facet(
            axis in 0_usize..3, segments in 6_u32..200, seed in 0_u64..1000,
        ) {
            let region = Region::Cylinder(cylinder(axis, segments));
            let point = region.sample(&mut stream(seed, "region", 0)).expect("most draws hit");
            let clearance = region.wall_clearance(&point);
            prop_assert!((clearance - distance_to_walls(&region, &point)).abs() < 1e-12);
            prop_assert!(region.clearance(&point) > 0.0 && region.clearance(&point) <= clearance);
            prop_assert!(region.bounds().contains(&point));
        }
    }

    #[test]
    fn volumes_agree_with_sampling_and_closed_forms() {
        let prism = Region::Cylinder(cylinder(0, 64));
        let exact = std::f64::consts::PI * 0.09 * 0.8;
        let excess = prism.volume() / exact - 1.0;
        assert!(excess > 0.0 && excess < 1e-3, "{excess}");
        let mut source = stream(1, "region", 1);
        let (bounds, mut inside) = (prism.bounds(), 0);
        for _ in 0..20_000 {
            let size = bounds.size();
            let point = bounds.low + Vec3::from_fn(|a, _| uniform(&mut source, 0.0, size[a]));
            inside += usize::from(prism.clearance(&point) > 0.0);
        }
        let size = bounds.size();
        let sampled = f64::from(inside as u32) / 20_000.0 * size.x * size.y * size.z;
        assert!((sampled / prism.volume() - 1.0).abs() < 0.015);
    }

    #[test]
    fn open_sides_have_no_wall() {
        let bounds = Bounds { low: Vec3::new(0.0, 0.0, -0.5), high: Vec3::new(1.0, 2.0, 0.5) };
        let mut open = [[false; 2]; 3];
        open[1][1] = true;
        let region = Region::Box(Rectangle { bounds, dimension: 2, open, periodic: [false; 3] });
        let names: Vec<String> = region.walls().into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["x_low", "x_high", "y_low"]);
        let high = Vec3::new(0.5, 5.0, 0.0);
        assert_eq!(region.wall_clearance(&high), 0.5);
        assert_eq!(region.clearance(&high), -3.0);
        assert_eq!(region.volume(), 2.0);
        assert_eq!(Region::Cylinder(cylinder(2, 12)).walls().len(), 2);
    }

    #[test]
    fn a_mesh_box_is_the_box() {
        let room = MeshRegion::new(box_mesh(Vec3::new(1.0, 2.0, 3.0))).expect("closed");
        let region = Region::Mesh(Box::new(room));
        assert!((region.volume() - 6.0).abs() < 1e-12);
        assert!((region.clearance(&Vec3::new(0.4, 0.0, 0.0)) - 0.1).abs() < 1e-12);
        assert!(region.clearance(&Vec3::new(0.6, 0.0, 0.0)) < 0.0);
        let solid = Collider::new(&box_mesh(Vec3::repeat(0.5)), 0.5).expect("a box");
        let room = region.for_solids(0.5);
        let at = |x: f64| (Vec3::new(x, 0.0, 0.0), Rotation::identity());
        assert!(room.holds(&solid, &at(0.2), 0.01));
        assert!(!room.holds(&solid, &at(0.2), 0.1), "too near to the wall");
        assert!(!room.holds(&solid, &at(0.3), 0.0), "through the wall");
        assert!(!room.holds(&solid, &at(2.0), 0.0), "outside");
        // A room with a block in its middle: a shell around the block is outside, and so is a solid around it.
        let (outer, block) = (box_mesh(Vec3::repeat(3.0)), box_mesh(Vec3::repeat(0.1)));
        let shift = outer.vertices.len() as u32;
        let inner = block.triangles.iter().map(|&[a, b, c]| [a + shift, c + shift, b + shift]);
        let hollow = Mesh {
            vertices: outer.vertices.iter().chain(&block.vertices).copied().collect(),
            triangles: outer.triangles.iter().copied().chain(inner).collect(),
        };
        let region = Region::Mesh(Box::new(MeshRegion::new(hollow).expect("closed")));
        assert!((region.volume() - 26.999).abs() < 1e-9);
        assert!(!region.for_solids(0.5).holds(&solid, &at(0.0), 0.0), "around the block");
        assert!(region.for_solids(0.5).holds(&solid, &at(1.0), 0.0));
        let mut open = l_mesh();
        open.triangles.pop();
        assert_eq!(MeshRegion::new(open).expect_err("has a hole").key, "file");
    }
}
