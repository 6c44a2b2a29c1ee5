//! Containers as a scene file gives them, and what they become: see [`Region`].

use super::region::{CylinderRegion, MeshRegion, Rectangle, Region};
pub use super::shaped_container::{
    ConeContainer, HollowContainer, PolygonContainer, SphereContainer,
};
use super::{Bounds, Mesh};
use crate::num::units::Length;
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The room that the grains are packed into.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Container {
    /// A box along the axes; in two dimensions a rectangle in the x-y plane, 1 m thick.
    Box(BoxContainer),
    /// A cylinder along an axis, with flat ends; three dimensions only.
    Cylinder(CylinderContainer),
    /// The inside of a closed surface; three dimensions only.
    Mesh(MeshContainer),
    /// A sphere; a disc in two dimensions.
    Sphere(SphereContainer),
    /// A cone or a part of one, such as a hopper; three dimensions only.
    Cone(ConeContainer),
    /// Straight sides at any angles; two dimensions only.
    Polygon(PolygonContainer),
    /// One of the others with holes, such as a ring.
    Hollow(HollowContainer),
}

/// A box: either `size` (and `low`, if not at the origin), or `low` and `high`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxContainer {
    /// Edge lengths, m, each greater than 0: 3 numbers, 2 in two dimensions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<Vec<Length>>,
    /// Corner with the smallest coordinates, m; default the origin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<Vec<Length>>,
    /// Corner with the largest coordinates, m; in place of `size`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<Vec<Length>>,
    /// Sides without a wall. Packing methods keep grains inside all the same;
    /// in the run grains may leave there. Default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<Side>,
    /// Axes along which the box repeats itself: what leaves at one side comes in at the other,
    /// and there is no wall. Edges there must be four bounding radii of the largest grain or more. Default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub periodic: Vec<Axis>,
}

/// A cylinder. Its wall is a regular prism of `segments` flat facets that
/// touches the circle of `radius` from outside, and the prism is also the room that is packed,
/// so that packing, run and decks see one and the same wall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderContainer {
    /// Radius of the circle inscribed in the faceted wall, m, greater than 0.
    pub radius: Length,
    /// Length along the axis, m, greater than 0.
    pub height: Length,
    /// Middle of the low end, m; default the origin.
    #[serde(default)]
    pub base: [Length; 3],
    /// Direction of the axis; default z.
    #[serde(default)]
    pub axis: Axis,
    /// Facets of the wall, 6 to 4096; default 64 (the prism is then 0.08 % larger than the cylinder).
    #[serde(default = "default_segments")]
    pub segments: u32,
    /// Ends without a wall; packing methods keep grains inside all the same. Default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<Side>,
}

/// Facets of a round wall where nothing else is said.
pub(super) fn default_segments() -> u32 {
    64
}

/// A closed surface from a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshContainer {
    /// Surface file (STL, PLY, OBJ, …), relative to the scene file.
    pub file: String,
    /// What one unit of length in the file means, m, greater than 0; default 1 m. Write "1 mm" for a file in millimetres.
    #[serde(default = "one_metre")]
    pub unit: Length,
}

fn one_metre() -> Length {
    Length(1.0)
}

/// A coordinate axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    #[default]
    Z,
}

/// A side of a container.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Side {
    /// The side of smallest x.
    #[serde(rename = "x-")]
    XLow,
    /// The side of largest x.
    #[serde(rename = "x+")]
    XHigh,
    /// The side of smallest y.
    #[serde(rename = "y-")]
    YLow,
    /// The side of largest y.
    #[serde(rename = "y+")]
    YHigh,
    /// The side of smallest z.
    #[serde(rename = "z-")]
    ZLow,
    /// The side of largest z.
    #[serde(rename = "z+")]
    ZHigh,
    /// z+ in three dimensions, y+ in two.
    #[serde(rename = "top")]
    Top,
    /// z- in three dimensions, y- in two.
    #[serde(rename = "bottom")]
    Bottom,
}

impl Side {
    /// Axis (0, 1, 2) across the side, and true for the high one.
    pub fn face(self, dimension: usize) -> (usize, bool) {
        match self {
            Self::XLow => (0, false),
            Self::XHigh => (0, true),
            Self::YLow => (1, false),
            Self::YHigh => (1, true),
            Self::ZLow => (2, false),
            Self::ZHigh => (2, true),
            Self::Top => (dimension - 1, true),
            Self::Bottom => (dimension - 1, false),
        }
    }
}

impl Container {
    /// A fault for values that are wrong in two and three dimensions alike.
    pub fn validate(&self) -> Result<(), Fault> {
        match self {
            Self::Box(parameters) => parameters.validate().map_err(|fault| fault.under("box")),
            Self::Cylinder(parameters) => {
                parameters.validate().map_err(|fault| fault.under("cylinder"))
            }
            Self::Mesh(parameters) => parameters.validate().map_err(|fault| fault.under("mesh")),
            Self::Sphere(parameters) => parameters.validate().map_err(|f| f.under("sphere")),
            Self::Cone(parameters) => parameters.validate().map_err(|f| f.under("cone")),
            Self::Polygon(parameters) => parameters.validate().map_err(|f| f.under("polygon")),
            Self::Hollow(parameters) => parameters.validate().map_err(|f| f.under("hollow")),
        }
    }

    /// The surface files that have to be read for [`Container::region_of`], in the order in which it takes them.
    pub fn files(&self) -> Vec<&str> {
        match self {
            Self::Mesh(parameters) => vec![&parameters.file],
            Self::Hollow(parameters) => {
                let holes = parameters.holes.iter().flat_map(Self::files);
                parameters.outside.files().into_iter().chain(holes).collect()
            }
            _ => Vec::new(),
        }
    }

    /// As [`Container::region_of`] for containers with one surface or none.
    ///
    /// Errors: as there.
    pub fn region(&self, dimension: usize, surface: Option<&Mesh>) -> Result<Region, Fault> {
        self.region_of(dimension, surface.map_or(&[], std::slice::from_ref))
    }

    /// The room in `dimension` (2 or 3) dimensions. `surfaces` are the meshes read from
    /// [`Container::files`], in the units of the files.
    ///
    /// Errors: values that [`Container::validate`] refuses, numbers that do not
    /// suit the dimension, a surface that is missing, not closed or without volume.
    pub fn region_of(&self, dimension: usize, surfaces: &[Mesh]) -> Result<Region, Fault> {
        self.validate()?;
        if dimension != 2 && dimension != 3 {
            return Err(Fault::new("", format!("in {dimension} dimensions"), "2 or 3 dimensions"));
        }
        match self {
            Self::Box(parameters) => parameters.region(dimension).map_err(|f| f.under("box")),
            Self::Cylinder(_) if dimension == 2 => Err(flat("cylinder")),
            Self::Mesh(_) if dimension == 2 => Err(flat("mesh")),
            Self::Cylinder(parameters) => parameters.region().map_err(|f| f.under("cylinder")),
            Self::Mesh(parameters) => {
                parameters.region(surfaces.first()).map_err(|f| f.under("mesh"))
            }
            Self::Sphere(parameters) => parameters.region(dimension).map_err(|f| f.under("sphere")),
            Self::Cone(_) if dimension == 2 => Err(flat("cone")),
            Self::Cone(parameters) => Ok(parameters.region()),
            Self::Polygon(_) if dimension == 3 => {
                Err(Fault::new("polygon", "is flat, the scene is not", "a scene in two dimensions"))
            }
            Self::Polygon(parameters) => parameters.region().map_err(|f| f.under("polygon")),
            Self::Hollow(parameters) => {
                parameters.region(dimension, surfaces).map_err(|f| f.under("hollow"))
            }
        }
    }
}

fn flat(key: &str) -> Fault {
    Fault::new(
        key,
        "is three-dimensional, the scene is not",
        "a box, polygon, sphere or hollow in two dimensions",
    )
}

pub(super) fn finite(key: &str, values: &[Length]) -> Result<(), Fault> {
    match values.iter().find(|value| !value.0.is_finite()) {
        Some(value) => Err(Fault::new(key, format!("holds {}", value.0), "finite numbers")),
        None => Ok(()),
    }
}

impl BoxContainer {
    /// A fault for values that are wrong in two and three dimensions alike.
    pub fn validate(&self) -> Result<(), Fault> {
        for (key, values) in [("size", &self.size), ("low", &self.low), ("high", &self.high)] {
            let Some(values) = values else { continue };
            finite(key, values)?;
            if !(2..=3).contains(&values.len()) {
                let problem = format!("has {} numbers", values.len());
                return Err(Fault::new(key, problem, "3 numbers, 2 in two dimensions"));
            }
        }
        match (&self.size, &self.low, &self.high) {
            (Some(size), _, None) => {
                size.iter().try_for_each(|edge| Fault::positive("size", edge.0))
            }
            (None, Some(low), Some(high)) => {
                if low.len() == high.len() && low.iter().zip(high).all(|(l, h)| l.0 < h.0) {
                    return Ok(());
                }
                Err(Fault::new(
                    "high",
                    "is not above `low`",
                    "larger numbers than in `low`, as many",
                ))
            }
            (Some(_), _, Some(_)) => {
                Err(Fault::new("high", "stands beside `size`", "`size`, or `low` and `high`"))
            }
            (None, _, _) => Err(Fault::new("size", "is missing", "`size`, or `low` and `high`")),
        }
    }

    fn region(&self, dimension: usize) -> Result<Region, Fault> {
        for (key, values) in [("size", &self.size), ("low", &self.low), ("high", &self.high)] {
            if let Some(values) = values.as_ref().filter(|values| values.len() != dimension) {
                let problem = format!("has {} numbers in {dimension} dimensions", values.len());
                return Err(Fault::new(key, problem, format!("{dimension} numbers")));
            }
        }
        let corner = |values: &Option<Vec<Length>>| {
            let values = values.as_deref().unwrap_or_default();
            Vec3::from_fn(|axis, _| values.get(axis).map_or(0.0, |value| value.0))
        };
        let mut low = corner(&self.low);
        let mut high =
            if self.high.is_some() { corner(&self.high) } else { low + corner(&self.size) };
        if dimension == 2 {
            (low.z, high.z) = (-0.5, 0.5);
        }
        let mut open = [[false; 2]; 3];
        for (index, side) in self.open.iter().enumerate() {
            let (axis, is_high) = side.face(dimension);
            if axis >= dimension {
                let key = format!("open[{index}]");
                return Err(Fault::new(
                    key,
                    "is a side along z in two dimensions",
                    "x-, x+, y-, y+",
                ));
            }
            open[axis][usize::from(is_high)] = true;
        }
        let mut periodic = [false; 3];
        for (index, axis) in self.periodic.iter().enumerate() {
            let axis = *axis as usize;
            let key = format!("periodic[{index}]");
            if axis >= dimension {
                return Err(Fault::new(key, "is z in two dimensions", "x, y"));
            }
            if open[axis].contains(&true) {
                return Err(Fault::new(key, "has an open side", "an axis without open sides"));
            }
            periodic[axis] = true;
        }
        Ok(Region::Box(Rectangle { bounds: Bounds { low, high }, dimension, open, periodic }))
    }
}

impl CylinderContainer {
    /// A fault for values that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::positive("radius", self.radius.0)?;
        Fault::positive("height", self.height.0)?;
        finite("base", &self.base)?;
        Fault::within("segments", f64::from(self.segments), 6.0, 4096.0)?;
        for (index, side) in self.open.iter().enumerate() {
            if side.face(3).0 != self.axis as usize {
                let key = format!("open[{index}]");
                return Err(Fault::new(
                    key,
                    "is not an end of the cylinder",
                    "an end along `axis`",
                ));
            }
        }
        Ok(())
    }

    fn region(&self) -> Result<Region, Fault> {
        let mut open = [false; 2];
        for side in &self.open {
            open[usize::from(side.face(3).1)] = true;
        }
        Ok(Region::Cylinder(CylinderRegion {
            base: Vec3::from_fn(|axis, _| self.base[axis].0),
            axis: self.axis as usize,
            radius: self.radius.0,
            height: self.height.0,
            segments: self.segments,
            open,
        }))
    }
}

impl MeshContainer {
    /// A fault for values that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        if self.file.is_empty() {
            return Err(Fault::new("file", "is empty", "the name of a surface file"));
        }
        Fault::positive("unit", self.unit.0)
    }

    fn region(&self, surface: Option<&Mesh>) -> Result<Region, Fault> {
        let Some(surface) = surface else {
            return Err(Fault::new("file", "was not read", "a surface file that can be read"));
        };
        let unit = self.unit.0;
        MeshRegion::new(surface.mapped(|v| v * unit)).map(Box::new).map(Region::Mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Container, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }

    fn region(text: &str, dimension: usize) -> Result<Region, Fault> {
        read(text).expect("well formed").region(dimension, None)
    }

    #[test]
    fn scene_text_becomes_a_region() {
        let room = region(r#"box = { size = ["2 cm", 0.03, 0.04], open = ["top"] }"#, 3);
        let Ok(Region::Box(room)) = room else { panic!("not a box") };
        assert_eq!(room.bounds.high, Vec3::new(0.02, 0.03, 0.04));
        assert_eq!(room.open, [[false, false], [false, false], [false, true]]);
        let text = r#"box = { size = [1, 1, 1], periodic = ["x", "z"], open = ["y+"] }"#;
        let wrapped = region(text, 3).expect("a periodic box");
        assert_eq!(wrapped.cell().map(|cell| cell.periodic), Some([true, false, true]));
        let walls: Vec<String> = wrapped.walls().into_iter().map(|(name, _)| name).collect();
        assert_eq!(walls, ["y_low"]);
        assert_eq!(wrapped.clearance(&Vec3::new(-5.0, 0.25, 7.0)), 0.25);
        for (text, dimension) in [
            (r#"box = { size = [1, 1, 1], periodic = ["x"], open = ["x-"] }"#, 3),
            (r#"box = { size = [1, 1], periodic = ["z"] }"#, 2),
        ] {
            assert_eq!(region(text, dimension).expect_err(text).key, "box.periodic[0]");
        }
        let Ok(Region::Box(flat)) =
            region(r#"box = { low = [-1, 0], high = [1, 3], open = ["top"] }"#, 2)
        else {
            panic!()
        };
        assert_eq!(flat.open[1], [false, true]);
        assert_eq!(flat.bounds.low, Vec3::new(-1.0, 0.0, -0.5));
        assert!(
            region(r#"cylinder = { radius = "1 cm", height = 0.1, axis = "y", open = ["y+"] }"#, 3)
                .is_ok()
        );
    }

    #[test]
    fn wrong_containers_name_their_key() {
        let key = |text: &str, dimension| region(text, dimension).expect_err("is wrong").key;
        assert_eq!(key("box = { size = [1, 1] }", 3), "box.size");
        assert_eq!(key("box = { size = [1, 1, 1] }", 2), "box.size");
        assert_eq!(key("box = { size = [1, -1, 1] }", 3), "box.size");
        assert_eq!(key("box = { low = [1, 1, 1] }", 3), "box.size");
        assert_eq!(key("box = { low = [1, 1, 1], high = [2, 2, 1] }", 3), "box.high");
        assert_eq!(key("box = { size = [1, 1], open = ['z+'] }", 2), "box.open[0]");
        assert_eq!(key("cylinder = { radius = 1, height = 1 }", 2), "cylinder");
        assert_eq!(
            key("cylinder = { radius = 1, height = 1, open = ['x+'] }", 3),
            "cylinder.open[0]"
        );
        assert_eq!(
            key("cylinder = { radius = 1, height = 1, segments = 3 }", 3),
            "cylinder.segments"
        );
        assert_eq!(key("mesh = { file = 'a.stl' }", 3), "mesh.file");
        assert!(read("box = { size = [1, 1, 1], lid = true }").is_err());
        assert!(read("box = { size = [1, 1, 1], open = ['up'] }").is_err());
    }
}
