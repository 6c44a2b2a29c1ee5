//! What a scene file may say. Parameters of methods live beside the methods;
//! here they are put together.

use crate::geometry::Container;
use crate::model::Scheme;
use crate::num::Fault;
use crate::num::units::{
    Acceleration, Damping, Density, Length, Pressure, Speed, Spin, Stiffness, Time,
};
use crate::report::compare::Tolerances;
use crate::{clump, pack, shape};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

/// A riprap scene: grains, materials, container, packing, plan, outputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Name of the scene, for people.
    pub title: String,
    /// 2 (discs of unit thickness in the x–y plane) or 3 (spheres and clumps). Default 3.
    #[serde(default = "three")]
    pub dimension: u8,
    /// Seed of every random draw. Default 0.
    #[serde(default)]
    pub seed: u64,
    /// Families of grains, at least one.
    pub grains: Vec<Family>,
    /// Materials by name, at least one.
    pub materials: BTreeMap<String, MaterialParameters>,
    /// Contact parameters of every pair of materials that `pairs` does not name.
    pub contact: ContactParameters,
    /// Contact parameters of single pairs of materials.
    #[serde(default)]
    pub pairs: Vec<PairParameters>,
    /// The room that is filled, and its walls. Needed by every packing but `placed`.
    #[serde(default)]
    pub container: Option<ContainerParameters>,
    /// Walls besides those of the container.
    #[serde(default)]
    pub walls: Vec<WallParameters>,
    /// How grains are placed.
    pub packing: pack::Method,
    /// Step, duration, gravity, damping.
    pub plan: PlanParameters,
    /// What is written, and how often.
    #[serde(default)]
    pub output: OutputParameters,
    /// How solvers are compared.
    #[serde(default)]
    pub compare: CompareParameters,
}

fn three() -> u8 {
    3
}

/// Grains of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Family {
    /// Name: letters, digits, `_` and `-`; different for each family.
    pub name: String,
    /// Number of grains, at least 1.
    pub count: u32,
    /// Equivalent-volume diameter (diameter for spheres and discs): a length, or
    /// `{ min = …, max = … }` for uniform. Left out: shapes keep their own size.
    #[serde(default)]
    pub size: Option<Size>,
    /// True shape.
    pub shape: shape::Shape,
    /// How the shape is reproduced as spheres; not for `sphere`.
    #[serde(default)]
    pub clump: Option<clump::Method>,
    /// Where mass, centroid and inertia come from: `solid` (default) or `union` of the spheres.
    #[serde(default)]
    pub mass: clump::MassSource,
    /// Number of different shapes; grains take them in turn. Default: one for each
    /// grain; one for each file; one for spheres of one size.
    #[serde(default)]
    pub distinct: Option<u32>,
    /// Material by name. May be left out if there is only one material.
    #[serde(default)]
    pub material: Option<String>,
}

/// Size of grains.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Size {
    /// All alike.
    Fixed(Length),
    /// Uniform between two limits.
    Uniform(UniformSize),
}

/// Limits of a uniform size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UniformSize {
    /// Smallest.
    pub min: Length,
    /// Largest.
    pub max: Length,
}

impl<'de> Deserialize<'de> for Size {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct SizeVisitor;
        impl<'de> Visitor<'de> for SizeVisitor {
            type Value = Size;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a length such as \"8 mm\", or { min = \"6 mm\", max = \"10 mm\" }")
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Size, E> {
                Length::parse(text).map(Size::Fixed).map_err(E::custom)
            }
            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Size, E> {
                if value.is_finite() {
                    return Ok(Size::Fixed(Length(value)));
                }
                Err(E::custom(format!("a length must be a finite number, not {value}")))
            }
            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Size, E> {
                Ok(Size::Fixed(Length(value as f64)))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Size, A::Error> {
                UniformSize::deserialize(MapAccessDeserializer::new(map)).map(Size::Uniform)
            }
        }
        deserializer.deserialize_any(SizeVisitor)
    }
}

impl JsonSchema for Size {
    fn schema_name() -> Cow<'static, str> {
        "Size".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let (length, uniform) =
            (generator.subschema_for::<Length>(), generator.subschema_for::<UniformSize>());
        json_schema!({ "anyOf": [length, uniform] })
    }
}

/// A material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialParameters {
    /// Density; needed for materials of grains, not for those of walls only.
    #[serde(default)]
    pub density: Option<Density>,
}

/// Linear spring-dashpot contact with a Coulomb limit.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactParameters {
    /// Normal stiffness; or give `young`.
    pub kn: Option<Stiffness>,
    /// Tangential stiffness. Default: 2(1−ν)/(2−ν) kn with `poisson`, else 2/7 kn.
    pub kt: Option<Stiffness>,
    /// Young's modulus E, from which kn = E π r² / L with r the smaller reference radius and L
    /// the distance between the centres (r to a wall); the reference radius is the median
    /// of the spheres of each material.
    pub young: Option<Pressure>,
    /// Poisson's ratio ν, 0 to 0.5, with `young`: kt/kn = 2(1−ν)/(2−ν).
    pub poisson: Option<f64>,
    /// Restitution of a normal impact, greater than 0, at most 1; or give `cn`. The dashpot is exact
    /// for the median masses of the two materials.
    pub restitution: Option<f64>,
    /// Normal dashpot; default 0 if no restitution is given.
    pub cn: Option<Damping>,
    /// Tangential dashpot; default 0.
    pub ct: Option<Damping>,
    /// Coefficient of friction; default 0.
    #[serde(default)]
    pub friction: f64,
}

/// Contact parameters of one pair of materials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairParameters {
    /// The two materials by name (the same twice for contacts within one).
    pub between: [String; 2],
    /// Their contact parameters.
    pub contact: ContactParameters,
}

/// The room that is filled.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContainerParameters {
    /// Its shape.
    pub shape: Container,
    /// Material of its walls by name. May be left out if there is only one material.
    #[serde(default)]
    pub material: Option<String>,
    /// How all its walls move. Default: they stand still.
    #[serde(default)]
    pub motion: MotionParameters,
}

/// A wall besides those of the container.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallParameters {
    /// Name: letters, digits and `_`; different for each wall.
    pub name: String,
    /// Its surface.
    pub shape: WallShapeParameters,
    /// Material by name. May be left out if there is only one material.
    #[serde(default)]
    pub material: Option<String>,
    /// How it moves. Default: it stands still.
    #[serde(default)]
    pub motion: MotionParameters,
}

/// Surface of a wall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WallShapeParameters {
    /// An infinite plane.
    Plane {
        /// A point on it.
        point: [Length; 3],
        /// Normal towards the grains, any length.
        normal: [f64; 3],
    },
    /// All sides of a container shape (box, cylinder), or a closed mesh.
    Sides(Container),
    /// A triangle mesh, open or closed.
    Mesh {
        /// STL, PLY or OBJ file, relative to the scene file.
        file: String,
        /// Unit of the numbers in the file. Default 1 m.
        #[serde(default = "metre")]
        unit: Length,
    },
}

fn metre() -> Length {
    Length(1.0)
}

/// Motion of a wall.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MotionParameters {
    /// At rest.
    #[default]
    Still,
    /// Constant velocity.
    Translate {
        /// Velocity.
        velocity: [Speed; 3],
    },
    /// Constant rotation about an axis, right-handed.
    Rotate {
        /// A point on the axis.
        origin: [Length; 3],
        /// Direction of the axis, any length.
        axis: [f64; 3],
        /// Rate of rotation.
        rate: Spin,
    },
}

/// Step, duration, gravity, damping, scheme.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanParameters {
    /// Simulated time.
    pub duration: Time,
    /// Time step, or "auto" (default).
    #[serde(default)]
    pub step: StepParameter,
    /// Gravity vector. Default: 9.81 m/s² along −z (−y in two dimensions).
    #[serde(default)]
    pub gravity: Option<[Acceleration; 3]>,
    /// Local (non-viscous) damping coefficient, 0 (default) up to but not including 1.
    #[serde(default)]
    pub local_damping: f64,
    /// Scheme of riprap's own DEM. Default `leapfrog`.
    #[serde(default = "leapfrog")]
    pub scheme: Scheme,
    /// True: the normal force may pull (the law to the letter). Default false: clipped at 0.
    #[serde(default)]
    pub tension: bool,
    /// True: use the given step even if it is above the stability limit. Default false.
    #[serde(default)]
    pub insist: bool,
}

fn leapfrog() -> Scheme {
    Scheme::Leapfrog
}

/// Time step: "auto" or a time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum StepParameter {
    /// Chosen from the scene.
    #[default]
    Auto,
    /// As given.
    Given(Time),
}

impl Serialize for StepParameter {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Given(time) => time.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for StepParameter {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct StepVisitor;
        impl Visitor<'_> for StepVisitor {
            type Value = StepParameter;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"auto\" or a time such as \"10 us\"")
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<StepParameter, E> {
                if text == "auto" {
                    return Ok(StepParameter::Auto);
                }
                Time::parse(text)
                    .map(StepParameter::Given)
                    .map_err(|message| E::custom(format!("{message}, or \"auto\"")))
            }
            fn visit_f64<E: de::Error>(self, value: f64) -> Result<StepParameter, E> {
                if value.is_finite() {
                    return Ok(StepParameter::Given(Time(value)));
                }
                Err(E::custom(format!("a time must be a finite number, not {value}")))
            }
            fn visit_i64<E: de::Error>(self, value: i64) -> Result<StepParameter, E> {
                Ok(StepParameter::Given(Time(value as f64)))
            }
        }
        deserializer.deserialize_any(StepVisitor)
    }
}

impl JsonSchema for StepParameter {
    fn schema_name() -> Cow<'static, str> {
        "Step".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let time = generator.subschema_for::<Time>();
        json_schema!({ "anyOf": [{ "const": "auto" }, time] })
    }
}

/// What is written, and how often.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OutputParameters {
    /// Number of snapshots over the run besides the first. Default 20.
    pub frames: u32,
    /// Number of rows of `run/series.csv` besides the first. Default 200.
    pub rows: u32,
    /// Number of checkpoints over the run. Default 4; 0 for none.
    pub checkpoints: u32,
    /// True: a VTP file for ParaView for each snapshot. Default false.
    pub vtp: bool,
}

impl Default for OutputParameters {
    fn default() -> Self {
        Self { frames: 20, rows: 200, checkpoints: 4, vtp: false }
    }
}

/// How solvers are compared.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CompareParameters {
    /// State that all solvers start from: `packing` (default) or `final`, the last state of riprap's own run, without its contact history.
    pub start: Start,
    /// Number of steps to compare over. Default: as many as the plan has.
    pub steps: Option<u64>,
    /// What counts as agreement.
    pub tolerance: Tolerances,
}

/// Where a comparison starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// The packing.
    #[default]
    Packing,
    /// The last state of riprap's own run.
    Final,
}

impl Scene {
    /// Everything that is wrong with the parameters and can be said without files or geometry.
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        let mut note = |result: Result<(), Fault>| faults.extend(result.err());
        if !matches!(self.dimension, 2 | 3) {
            note(Err(Fault::new("dimension", format!("is {}", self.dimension), "2 or 3")));
        }
        if self.grains.is_empty() {
            note(Err(Fault::new("grains", "is empty", "at least one [[grains]] family")));
        }
        if self.materials.is_empty() {
            note(Err(Fault::new("materials", "is empty", "at least one [materials.NAME]")));
        }
        for (index, family) in self.grains.iter().enumerate() {
            let here = format!("grains[{index}]");
            note(family.validate(self.dimension).map_err(|fault| fault.under(&here)));
            note(
                self.material_of_grain(family.material.as_deref())
                    .map(drop)
                    .map_err(|f| f.under(&here)),
            );
            if self.grains[..index].iter().any(|other| other.name == family.name) {
                let problem = format!("is \"{}\", as in an earlier family", family.name);
                note(Err(Fault::new("name", problem, "a name of its own").under(&here)));
            }
        }
        note(self.contact.validate().map_err(|fault| fault.under("contact")));
        for (index, pair) in self.pairs.iter().enumerate() {
            let here = format!("pairs[{index}]");
            note(pair.contact.validate().map_err(|fault| fault.under("contact").under(&here)));
            for (side, name) in pair.between.iter().enumerate() {
                let key = format!("between[{side}]");
                note(self.known_material(name, &key).map_err(|fault| fault.under(&here)));
            }
        }
        note(self.validate_container());
        for (index, wall) in self.walls.iter().enumerate() {
            let here = format!("walls[{index}]");
            note(wall.validate(self.dimension).map_err(|fault| fault.under(&here)));
            note(self.material(wall.material.as_deref()).map(drop).map_err(|f| f.under(&here)));
            if self.walls[..index].iter().any(|other| other.name == wall.name) {
                let problem = format!("is \"{}\", as in an earlier wall", wall.name);
                note(Err(Fault::new("name", problem, "a name of its own").under(&here)));
            }
        }
        note(self.packing.validate().map_err(|fault| fault.under("packing")));
        note(self.plan.validate(self.dimension).map_err(|fault| fault.under("plan")));
        note(self.output.validate().map_err(|fault| fault.under("output")));
        note(self.compare.validate().map_err(|fault| fault.under("compare")));
        faults
    }

    fn validate_container(&self) -> Result<(), Fault> {
        let Some(container) = &self.container else {
            if matches!(self.packing, pack::Method::Placed(_)) {
                return Ok(());
            }
            return Err(Fault::new(
                "container",
                "is missing",
                "a [container] for this packing method",
            ));
        };
        container.validate(self.dimension).map_err(|fault| fault.under("container"))?;
        self.material(container.material.as_deref()).map(drop).map_err(|f| f.under("container"))
    }

    /// Index of the material called `name`, or of the only one.
    ///
    /// # Errors
    /// A fault at `material` if there is no such material or the name is left out though there are several.
    pub fn material(&self, name: Option<&str>) -> Result<u16, Fault> {
        match name {
            Some(name) => {
                self.known_material(name, "material")?;
                // `known_material` has found the name, so the position exists.
                Ok(self.materials.keys().position(|key| key == name).unwrap_or(0) as u16)
            }
            None if self.materials.len() == 1 => Ok(0),
            None => Err(Fault::new("material", "is missing", self.material_names())),
        }
    }

    fn material_of_grain(&self, name: Option<&str>) -> Result<u16, Fault> {
        let index = self.material(name)?;
        let has_density =
            self.materials.values().nth(index as usize).is_some_and(|m| m.density.is_some());
        if has_density {
            return Ok(index);
        }
        let problem = "names a material without a density";
        Err(Fault::new("material", problem, "a material with `density`, as grains have mass"))
    }

    fn known_material(&self, name: &str, key: &str) -> Result<(), Fault> {
        if self.materials.contains_key(name) {
            return Ok(());
        }
        Err(Fault::new(key, format!("is \"{name}\", which is no material"), self.material_names()))
    }

    fn material_names(&self) -> String {
        let names: Vec<String> = self.materials.keys().map(|name| format!("\"{name}\"")).collect();
        format!("one of {}", names.join(", "))
    }
}

/// Names that become file names and parts of decks.
fn validate_name(name: &str) -> Result<(), Fault> {
    let good = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(good) {
        return Ok(());
    }
    Err(Fault::new("name", format!("is \"{name}\""), "letters, digits, `_` and `-`"))
}

impl Family {
    fn validate(&self, dimension: u8) -> Result<(), Fault> {
        validate_name(&self.name)?;
        if self.count == 0 {
            return Err(Fault::new("count", "is 0", "at least 1"));
        }
        if self.distinct == Some(0) {
            return Err(Fault::new("distinct", "is 0", "at least 1, or left out"));
        }
        match self.size {
            Some(Size::Fixed(size)) => Fault::positive("size", size.0)?,
            Some(Size::Uniform(UniformSize { min, max })) => {
                Fault::positive("size.min", min.0)?;
                Fault::positive("size.max", max.0)?;
                if max.0 < min.0 {
                    let problem = format!("is {} m, less than min", max.0);
                    return Err(Fault::new("size.max", problem, "at least size.min"));
                }
            }
            None => {}
        }
        self.shape.validate().map_err(|fault| fault.under("shape"))?;
        let sphere = matches!(self.shape, shape::Shape::Sphere);
        if dimension == 2 && !sphere {
            let allowed = "\"sphere\" (a disc) in two dimensions";
            return Err(Fault::new("shape", "is a solid body", allowed));
        }
        match (&self.clump, sphere) {
            (Some(_), true) => Err(Fault::new("clump", "is given for a sphere", "no `clump` key")),
            (None, false) => Err(Fault::new(
                "clump",
                "is missing",
                "a clump method for this shape, see `riprap list clumps`",
            )),
            (None, true) if self.size.is_none() => Err(Fault::new(
                "size",
                "is missing",
                "a diameter, as spheres have no size of their own",
            )),
            (Some(method), false) => method.validate().map_err(|fault| fault.under("clump")),
            (None, true) => Ok(()),
        }
    }
}

impl ContactParameters {
    fn validate(&self) -> Result<(), Fault> {
        match (self.kn, self.young) {
            (Some(kn), None) => Fault::positive("kn", kn.0)?,
            (None, Some(young)) => Fault::positive("young", young.0)?,
            (None, None) => {
                return Err(Fault::new("kn", "is missing", "`kn`, or `young` and `poisson`"));
            }
            (Some(_), Some(_)) => {
                return Err(Fault::new("young", "is given besides `kn`", "one of the two"));
            }
        }
        if let Some(kt) = self.kt {
            Fault::not_negative("kt", kt.0)?;
        }
        if let Some(poisson) = self.poisson {
            Fault::within("poisson", poisson, 0.0, 0.5)?;
            if self.young.is_none() {
                return Err(Fault::new(
                    "poisson",
                    "is given without `young`",
                    "both, or `kn` and `kt`",
                ));
            }
        }
        if let Some(e) = self.restitution {
            if !(e > 0.0 && e <= 1.0) {
                let allowed = "greater than 0, at most 1 (an impact cannot gain energy; 0 needs an infinite dashpot)";
                return Err(Fault::new("restitution", format!("is {e}"), allowed));
            }
            if self.cn.is_some() {
                return Err(Fault::new("cn", "is given besides `restitution`", "one of the two"));
            }
        }
        for (key, value) in [("cn", self.cn), ("ct", self.ct)] {
            if let Some(value) = value {
                Fault::not_negative(key, value.0)?;
            }
        }
        Fault::not_negative("friction", self.friction)
    }
}

impl ContainerParameters {
    fn validate(&self, dimension: u8) -> Result<(), Fault> {
        self.shape.validate().map_err(|fault| fault.under("shape"))?;
        self.motion.validate(dimension).map_err(|fault| fault.under("motion"))
    }
}

impl WallParameters {
    fn validate(&self, dimension: u8) -> Result<(), Fault> {
        validate_name(&self.name)?;
        match &self.shape {
            WallShapeParameters::Plane { point, normal } => {
                for (axis, value) in point.iter().enumerate() {
                    if !value.0.is_finite() {
                        return Err(Fault::new(
                            format!("shape.plane.point[{axis}]"),
                            "is not finite",
                            "a length",
                        ));
                    }
                }
                validate_direction("shape.plane.normal", normal)?;
                if dimension == 2 && normal[2] != 0.0 {
                    let problem = "leaves the x–y plane";
                    return Err(Fault::new(
                        "shape.plane.normal",
                        problem,
                        "a third component of 0",
                    ));
                }
            }
            WallShapeParameters::Sides(container) => {
                container.validate().map_err(|fault| fault.under("shape.sides"))?;
            }
            WallShapeParameters::Mesh { unit, .. } => {
                Fault::positive("shape.mesh.unit", unit.0)?;
                if dimension == 2 {
                    return Err(Fault::new(
                        "shape.mesh",
                        "is a surface in space",
                        "planes in two dimensions",
                    ));
                }
            }
        }
        self.motion.validate(dimension).map_err(|fault| fault.under("motion"))
    }
}

/// A direction: finite and not zero.
fn validate_direction(key: &str, direction: &[f64; 3]) -> Result<(), Fault> {
    let length = direction.iter().map(|c| c * c).sum::<f64>();
    if length.is_finite() && length > 0.0 {
        return Ok(());
    }
    Err(Fault::new(key, format!("is {direction:?}"), "three finite numbers that are not all 0"))
}

impl MotionParameters {
    fn validate(&self, dimension: u8) -> Result<(), Fault> {
        match self {
            Self::Still => Ok(()),
            Self::Translate { velocity } if dimension == 2 && velocity[2].0 != 0.0 => Err(
                Fault::new("translate.velocity", "leaves the x–y plane", "a third component of 0"),
            ),
            Self::Translate { .. } => Ok(()),
            Self::Rotate { axis, .. } => {
                validate_direction("rotate.axis", axis)?;
                if dimension == 2 && (axis[0] != 0.0 || axis[1] != 0.0) {
                    return Err(Fault::new(
                        "rotate.axis",
                        "leaves the x–y plane",
                        "[0, 0, 1] in two dimensions",
                    ));
                }
                Ok(())
            }
        }
    }
}

impl PlanParameters {
    fn validate(&self, dimension: u8) -> Result<(), Fault> {
        Fault::positive("duration", self.duration.0)?;
        if let StepParameter::Given(step) = self.step {
            Fault::positive("step", step.0)?;
            if step.0 > self.duration.0 {
                let problem = format!("is {} s, longer than the duration", step.0);
                return Err(Fault::new("step", problem, "a fraction of `duration`"));
            }
        }
        if let (Some(gravity), 2) = (self.gravity, dimension)
            && gravity[2].0 != 0.0
        {
            return Err(Fault::new("gravity[2]", "leaves the x–y plane", "0 in two dimensions"));
        }
        if !(0.0..1.0).contains(&self.local_damping) {
            let allowed = "0 up to but not including 1";
            return Err(Fault::new("local_damping", format!("is {}", self.local_damping), allowed));
        }
        Ok(())
    }
}

impl OutputParameters {
    fn validate(&self) -> Result<(), Fault> {
        for (key, value) in [("frames", self.frames), ("rows", self.rows)] {
            if value == 0 {
                return Err(Fault::new(key, "is 0", "at least 1"));
            }
        }
        Ok(())
    }
}

impl CompareParameters {
    fn validate(&self) -> Result<(), Fault> {
        if self.steps == Some(0) {
            return Err(Fault::new("steps", "is 0", "at least 1, or left out"));
        }
        self.tolerance.validate().map_err(|fault| fault.under("tolerance"))
    }
}
