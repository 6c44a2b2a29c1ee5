//! Containers of other shapes than boxes and cylinders (P14): spheres, cones, outlines, and any of them with holes.

use super::Mesh;
use super::cone::ConeRegion;
use super::container::{Axis, Container, Side, default_segments, finite};
use super::hollow::HollowRegion;
use super::outline::{Loop, OutlineRegion};
use super::primitive::Primitive;
use super::region::{MeshRegion, Region};
use crate::num::units::Length;
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A sphere, faceted; a disc in two dimensions. The facets touch it from outside.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereContainer {
    /// Radius of the sphere inscribed in the facets, m, greater than 0.
    pub radius: Length,
    /// Centre, m; default the origin. The third number has no meaning in two dimensions.
    #[serde(default)]
    pub centre: [Length; 3],
    /// Facets in a turn, 8 to 400; default 60 (3 dimensions: 2880 facets).
    #[serde(default = "default_turn")]
    pub segments: u32,
}

fn default_turn() -> u32 {
    60
}

/// A cone or a part of one, faceted, with flat ends; three dimensions only. The facets touch it from outside.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConeContainer {
    /// Radius at the low end, m, 0 or more.
    pub low_radius: Length,
    /// Radius at the high end, m, 0 or more, not 0 if the other is.
    pub high_radius: Length,
    /// Length along the axis, m, greater than 0.
    pub height: Length,
    /// Middle of the low end, m; default the origin.
    #[serde(default)]
    pub base: [Length; 3],
    /// Direction of the axis; default z.
    #[serde(default)]
    pub axis: Axis,
    /// Facets of the wall, 6 to 4096; default 64.
    #[serde(default = "default_segments")]
    pub segments: u32,
    /// Ends without a wall; packing methods keep grains inside all the same. Default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<Side>,
}

/// Straight sides at any angles; two dimensions only.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolygonContainer {
    /// Corners in their order around the area, m, 3 or more.
    pub corners: Vec<[Length; 2]>,
    /// Numbers of sides without a wall: side 0 runs from the first corner to the second. Default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<u32>,
}

/// A container with holes in it, such as a ring.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HollowContainer {
    /// The container that the holes are cut out of; not itself with holes.
    pub outside: Box<Container>,
    /// Where no grain may be: containers of any kind but with holes, without open sides, apart from each other.
    /// In three dimensions they may reach through the walls.
    pub holes: Vec<Container>,
}

impl SphereContainer {
    /// A fault for values that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::positive("radius", self.radius.0)?;
        finite("centre", &self.centre)?;
        Fault::within("segments", f64::from(self.segments), 8.0, 400.0)
    }

    fn circle(&self) -> Loop {
        Loop::around([self.centre[0].0, self.centre[1].0], self.radius.0, self.segments)
    }

    pub(super) fn region(&self, dimension: usize) -> Result<Region, Fault> {
        if dimension == 2 {
            return OutlineRegion::new(self.circle(), Vec::new()).map(Region::Outline);
        }
        let unit = Primitive::Sphere { diameter: 2.0 }.mesh(self.segments);
        let nearest = unit
            .facets()
            .map(|[a, b, c]| a.dot(&(b - a).cross(&(c - a)).normalize()))
            .fold(f64::INFINITY, f64::min);
        let centre = Vec3::from_fn(|axis, _| self.centre[axis].0);
        // Every facet is at least the radius away from the centre.
        let mesh = unit.mapped(|v| centre + v * (self.radius.0 / nearest));
        MeshRegion::new(mesh).map(Box::new).map(Region::Mesh)
    }
}

impl ConeContainer {
    /// A fault for values that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::not_negative("low_radius", self.low_radius.0)?;
        Fault::not_negative("high_radius", self.high_radius.0)?;
        Fault::positive("high_radius", self.low_radius.0 + self.high_radius.0)?;
        Fault::positive("height", self.height.0)?;
        finite("base", &self.base)?;
        Fault::within("segments", f64::from(self.segments), 6.0, 4096.0)?;
        for (index, side) in self.open.iter().enumerate() {
            if side.face(3).0 != self.axis as usize {
                let key = format!("open[{index}]");
                return Err(Fault::new(key, "is not an end of the cone", "an end along `axis`"));
            }
        }
        Ok(())
    }

    pub(super) fn region(&self) -> Region {
        let mut open = [false; 2];
        for side in &self.open {
            open[usize::from(side.face(3).1)] = true;
        }
        Region::Cone(ConeRegion {
            base: Vec3::from_fn(|axis, _| self.base[axis].0),
            axis: self.axis as usize,
            radii: [self.low_radius.0, self.high_radius.0],
            height: self.height.0,
            segments: self.segments,
            open,
        })
    }
}

impl PolygonContainer {
    /// A fault for values that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        for (index, side) in self.open.iter().enumerate() {
            if *side as usize >= self.corners.len() {
                let problem = format!("is {side}, with {} sides", self.corners.len());
                return Err(Fault::new(format!("open[{index}]"), problem, "the number of a side"));
            }
        }
        OutlineRegion::new(self.outline(), Vec::new())
            .map(|_| ())
            .map_err(|fault| fault.under("corners"))
    }

    fn outline(&self) -> Loop {
        let corners: Vec<[f64; 2]> = self.corners.iter().map(|c| [c[0].0, c[1].0]).collect();
        let mut outline = Loop::closed(corners);
        for &side in &self.open {
            if let Some(open) = outline.open.get_mut(side as usize) {
                *open = true;
            }
        }
        outline
    }

    pub(super) fn region(&self) -> Result<Region, Fault> {
        OutlineRegion::new(self.outline(), Vec::new()).map(Region::Outline)
    }
}

impl HollowContainer {
    /// A fault for values that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        let nested = |container: &Container| matches!(container, Container::Hollow(_));
        self.outside.validate().map_err(|fault| fault.under("outside"))?;
        if nested(&self.outside) {
            return Err(Fault::new("outside", "has holes itself", "a container without holes"));
        }
        if self.holes.is_empty() {
            return Err(Fault::new("holes", "is empty", "one or more containers"));
        }
        for (index, hole) in self.holes.iter().enumerate() {
            let key = format!("holes[{index}]");
            hole.validate().map_err(|fault| fault.under(&key))?;
            if nested(hole) {
                return Err(Fault::new(key, "has holes itself", "a container without holes"));
            }
        }
        Ok(())
    }

    /// `surfaces` are those of [`Container::files`], in their order.
    pub(super) fn region(&self, dimension: usize, surfaces: &[Mesh]) -> Result<Region, Fault> {
        let mut taken = 0;
        let mut made = |container: &Container| {
            let count = container.files().len();
            let mine = surfaces.get(taken..taken + count).unwrap_or_default();
            taken += count;
            container.region_of(dimension, mine)
        };
        let outside = made(&self.outside).map_err(|fault| fault.under("outside"))?;
        if outside.cell().is_some() {
            let problem = "repeats itself, which containers with holes do not";
            return Err(Fault::new("outside", problem, "a box without `periodic`"));
        }
        let mut holes = Vec::with_capacity(self.holes.len());
        for (index, hole) in self.holes.iter().enumerate() {
            let key = format!("holes[{index}]");
            let hole = made(hole).map_err(|fault| fault.under(&key))?;
            if hole.is_open() || hole.cell().is_some() {
                return Err(Fault::new(key, "has open or periodic sides", "closed sides"));
            }
            holes.push(hole);
        }
        if dimension == 2 {
            let outlines = holes.iter().map(outline).collect();
            return OutlineRegion::new(outline(&outside), outlines).map(Region::Outline);
        }
        let surfaces = holes.iter().map(Region::surface).collect();
        HollowRegion::new(outside, surfaces).map(Box::new).map(Region::Hollow)
    }
}

/// The loop around a region of two dimensions.
fn outline(region: &Region) -> Loop {
    match region {
        Region::Outline(outline) => outline.outer().clone(),
        _ => {
            let bounds = region.bounds();
            let ([a, b], [c, d]) = ([bounds.low.x, bounds.low.y], [bounds.high.x, bounds.high.y]);
            let mut outline = Loop::closed(vec![[a, b], [c, b], [c, d], [a, d]]);
            if let Region::Box(room) = region {
                let open = room.open;
                outline.open = vec![open[1][0], open[0][1], open[1][1], open[0][0]];
            }
            outline
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::surface::Surface;
    use super::*;
    use crate::num::random::{stream, uniform};

    fn region(text: &str, dimension: usize) -> Region {
        let container: Container = toml::from_str(text).expect("well formed");
        container.region(dimension, None).expect("a region")
    }

    #[test]
    fn volumes_and_distances_are_those_of_their_walls() {
        let shapes = [
            ("cone = { low_radius = 0.2, high_radius = 0.6, height = 1, open = ['top'] }", 0.5445),
            ("cone = { low_radius = 0.5, high_radius = 0, height = 1, axis = 'x' }", 0.2618),
            ("sphere = { radius = 0.5, centre = [1, 2, 3] }", std::f64::consts::FRAC_PI_6),
            (
                "hollow = { outside = { box = { size = [1, 1, 1], open = ['top'] } }, holes = [
                    { cylinder = { radius = 0.25, height = 2, base = [0.5, 0.5, -0.5] } } ] }",
                1.0 - 0.19635,
            ),
        ];
        for (text, volume) in shapes {
            let region = region(text, 3);
            assert!((region.volume() / volume - 1.0).abs() < 0.02, "{text} {}", region.volume());
            let (bounds, mut inside) = (region.bounds(), 0);
            let mut source = stream(1, "shaped", 0);
            for _ in 0..4000 {
                let size = bounds.size();
                let point = bounds.low + Vec3::from_fn(|a, _| uniform(&mut source, 0.0, size[a]));
                let clearance = region.clearance(&point);
                inside += usize::from(clearance > 0.0);
                if clearance <= 0.0 {
                    continue;
                }
                // No wall is nearer than the clearance says.
                let mut nearest = f64::INFINITY;
                for (_, wall) in region.walls() {
                    match wall {
                        Surface::Plane { point: on, normal } => {
                            nearest = nearest.min(normal.dot(&(point - on)));
                        }
                        Surface::Mesh(mesh) => {
                            let v = mesh.vertices.iter().map(|v| (v - point).norm());
                            nearest = nearest.min(v.fold(f64::INFINITY, f64::min));
                        }
                    }
                }
                assert!(clearance <= nearest + 1e-9, "{text} {point} {clearance} {nearest}");
                assert!(region.wall_clearance(&point) >= clearance - 1e-12);
            }
            let share = inside as f64 / 4000.0 * bounds.size().product();
            assert!((share / region.volume() - 1.0).abs() < 0.1, "{text} {share}");
            assert!(
                (region.surface().mass_properties().volume
                    / match &region {
                        Region::Hollow(room) => room.outside().volume(),
                        room => room.volume(),
                    }
                    - 1.0)
                    .abs()
                    < 1e-6,
                "{text}"
            );
        }
    }

    #[test]
    fn rings_in_two_dimensions() {
        let ring = region(
            "hollow = { outside = { sphere = { radius = 1 } }, holes = [{ sphere = { radius = 0.5 } }] }",
            2,
        );
        assert_eq!(ring.dimension(), 2);
        assert!((ring.volume() / (std::f64::consts::PI * 0.75) - 1.0).abs() < 2e-3);
        assert!((ring.clearance(&Vec3::new(0.75, 0.0, 0.0)) - 0.25).abs() < 2e-3);
        assert!(ring.clearance(&Vec3::zeros()) < -0.49);
        assert_eq!(ring.walls().len(), 2);
        let frame = region(
            "hollow = { outside = { box = { size = [3, 3], open = ['top'] } }, holes = [{ box = { low = [1, 1], high = [2, 2] } }] }",
            2,
        );
        assert_eq!((frame.volume(), frame.is_open()), (8.0, true));
    }

    #[test]
    fn wrong_shapes_name_their_key() {
        let key = |text: &str, dimension: usize| {
            let container: Container = toml::from_str(text).expect("well formed");
            container.region(dimension, None).expect_err("is wrong").key
        };
        assert_eq!(key("sphere = { radius = -1 }", 3), "sphere.radius");
        assert_eq!(
            key("cone = { low_radius = 0, high_radius = 0, height = 1 }", 3),
            "cone.high_radius"
        );
        assert_eq!(key("cone = { low_radius = 0, high_radius = 1, height = 1 }", 2), "cone");
        assert_eq!(key("polygon = { corners = [[0, 0], [1, 1], [2, 2]] }", 2), "polygon.corners");
        assert_eq!(key("polygon = { corners = [[0, 0], [1, 0], [0, 1]] }", 3), "polygon");
        assert_eq!(
            key("polygon = { corners = [[0, 0], [1, 0], [0, 1]], open = [3] }", 2),
            "polygon.open[0]"
        );
        let far = "hollow = { outside = { box = { size = [1, 1, 1] } }, holes = [{ sphere = { radius = 0.1, centre = [3, 3, 3] } }] }";
        assert_eq!(key(far, 3), "hollow.holes");
        let none = "hollow = { outside = { box = { size = [1, 1, 1] } }, holes = [] }";
        assert_eq!(key(none, 3), "hollow.holes");
        let out = "hollow = { outside = { box = { size = [1, 1] } }, holes = [{ sphere = { radius = 0.1, centre = [3, 3, 3] } }] }";
        assert_eq!(key(out, 2), "hollow.holes[0]");
    }
}
