//! Grains of one kind, and their sizes.

use super::InsertionParameters;
use super::bond::{BondLaw, Hold};
use super::validate_name;
use crate::clump;
use crate::num::Fault;
use crate::num::units::Length;
use crate::pack::grading::{self, Grading};
use crate::shape;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::fmt;

/// Grains of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Family {
    /// Name: letters, digits, `_` and `-`; different for each family.
    pub name: String,
    /// Number of grains, at least 1; left out where `fraction` is given.
    #[serde(default)]
    pub count: u32,
    /// Share of the mass of the scene's `mixture`, instead of `count`; shares of all families are brought to a sum of 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fraction: Option<f64>,
    /// Equivalent-volume diameter (diameter for spheres and discs): a length,
    /// `{ min = …, max = … }` for uniform, or a grading (`gaussian`, `lognormal`, `weibull`,
    /// `fuller`, `rosin_rammler`, `sieve`). Left out: shapes keep their own size.
    #[serde(default)]
    pub size: Option<Size>,
    /// True shape.
    pub shape: shape::Shape,
    /// How the shape is reproduced as spheres; not for `sphere`.
    #[serde(default)]
    pub clump: Option<clump::Method>,
    /// Where mass, centroid and inertia come from: `solid` (default), `union` of the spheres, or
    /// `corrected`: the union, its density corrected so that the mass is that of the solid.
    #[serde(default)]
    pub mass: clump::MassSource,
    /// Each sphere or disc becomes a cluster of two to seven (P15); for `sphere` only.
    #[serde(default)]
    pub cluster: Option<clump::Cluster>,
    /// Whether the spheres of a grain move as one body: `rigid` (default), or `bonded` with bonds that may break.
    #[serde(default)]
    pub body: Hold,
    /// Number of different shapes; grains take them in turn. Default: one for each
    /// grain; one for each file; one for spheres of one size.
    #[serde(default)]
    pub distinct: Option<u32>,
    /// Material by name. May be left out if there is only one material.
    #[serde(default)]
    pub material: Option<String>,
    /// Grains of this family come during the run instead of being packed. Default: they are packed.
    #[serde(default, rename = "insert", skip_serializing_if = "Option::is_none")]
    pub insertion: Option<InsertionParameters>,
}

/// Size of grains.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Size {
    /// All alike.
    Fixed(Length),
    /// Uniform between two limits.
    Uniform(UniformSize),
    /// Another distribution.
    Graded(Grading),
}

/// What a table of sizes may hold; exactly one kind.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct SizeTable {
    min: Option<Length>,
    max: Option<Length>,
    gaussian: Option<grading::Gaussian>,
    lognormal: Option<grading::Lognormal>,
    weibull: Option<grading::Weibull>,
    fuller: Option<grading::Fuller>,
    rosin_rammler: Option<grading::RosinRammler>,
    sieve: Option<grading::Sieve>,
}

impl SizeTable {
    fn size<E: de::Error>(self) -> Result<Size, E> {
        let uniform = match (self.min, self.max) {
            (Some(min), Some(max)) => Some(Size::Uniform(UniformSize { min, max })),
            (Some(_), None) => return Err(E::missing_field("max")),
            (None, Some(_)) => return Err(E::missing_field("min")),
            (None, None) => None,
        };
        let graded = [
            self.gaussian.map(Grading::Gaussian),
            self.lognormal.map(Grading::Lognormal),
            self.weibull.map(Grading::Weibull),
            self.fuller.map(Grading::Fuller),
            self.rosin_rammler.map(Grading::RosinRammler),
            self.sieve.map(Grading::Sieve),
        ];
        let mut found = graded.into_iter().flatten().map(Size::Graded).chain(uniform);
        match (found.next(), found.next()) {
            (Some(size), None) => Ok(size),
            (None, _) => Err(E::missing_field("min")),
            (Some(_), Some(_)) => Err(E::custom("two kinds of sizes in one table")),
        }
    }
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
                f.write_str(
                    "a length such as \"8 mm\", { min = \"6 mm\", max = \"10 mm\" }, or a grading",
                )
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
                SizeTable::deserialize(MapAccessDeserializer::new(map))?.size()
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
        let graded = generator.subschema_for::<Grading>();
        json_schema!({ "anyOf": [length, uniform, graded] })
    }
}

impl Family {
    pub(super) fn validate(&self, dimension: u8) -> Result<(), Fault> {
        validate_name(&self.name)?;
        if self.distinct == Some(0) {
            return Err(Fault::new("distinct", "is 0", "at least 1, or left out"));
        }
        self.validate_size()?;
        self.shape.validate().map_err(|fault| fault.under("shape"))?;
        if dimension == 2 && !self.is_sphere() {
            let allowed = "\"sphere\" (a disc) in two dimensions";
            return Err(Fault::new("shape", "is a solid body", allowed));
        }
        self.validate_cluster(dimension)?;
        if let Some(insertion) = &self.insertion {
            insertion.validate(dimension).map_err(|fault| fault.under("insert"))?;
            if self.body != Hold::Rigid {
                let allowed = "`rigid` (bonds of grains that come later are not made)";
                return Err(Fault::new("body", "is bonded", allowed));
            }
        }
        self.validate_bonds()?;
        self.validate_clump()
    }

    fn is_sphere(&self) -> bool {
        matches!(self.shape, shape::Shape::Sphere)
    }

    fn validate_size(&self) -> Result<(), Fault> {
        match &self.size {
            Some(Size::Graded(grading)) => grading.validate().map_err(|f| f.under("size")),
            Some(Size::Fixed(size)) => Fault::positive("size", size.0),
            Some(Size::Uniform(UniformSize { min, max })) => {
                Fault::positive("size.min", min.0)?;
                Fault::positive("size.max", max.0)?;
                if max.0 < min.0 {
                    let problem = format!("is {} m, less than min", max.0);
                    return Err(Fault::new("size.max", problem, "at least size.min"));
                }
                Ok(())
            }
            None => Ok(()),
        }
    }

    fn validate_cluster(&self, dimension: u8) -> Result<(), Fault> {
        let Some(cluster) = &self.cluster else { return Ok(()) };
        if !self.is_sphere() {
            let allowed = "left out, or `shape = \"sphere\"`";
            return Err(Fault::new("cluster", "is given for a solid", allowed));
        }
        cluster.validate(dimension).map_err(|fault| fault.under("cluster"))?;
        if dimension == 2 && self.body == Hold::Rigid {
            let allowed = "body.bonded, as discs of one rigid body are not made in two dimensions";
            return Err(Fault::new("body", "is `rigid`", allowed));
        }
        Ok(())
    }

    fn validate_bonds(&self) -> Result<(), Fault> {
        let Hold::Bonded(bonds) = &self.body else { return Ok(()) };
        bonds.validate().map_err(|fault| fault.under("bonded").under("body"))?;
        if let BondLaw::Solid(solid) = &bonds.law {
            let Some(clump::Method::Lattice(lattice)) = &self.clump else {
                let allowed = "a `clump.lattice`, for whose geometry the moduli are";
                return Err(Fault::new("body.bonded.law", "is `solid`", allowed));
            };
            lattice
                .stiffness(1.0, solid.young.0, solid.poisson)
                .map_err(|fault| fault.under("solid").under("law").under("bonded").under("body"))?;
        }
        if self.is_sphere() && self.cluster.is_none() {
            let allowed = "`rigid`, a `cluster`, or a shape with a `clump`";
            return Err(Fault::new("body", "bonds the one sphere of a grain", allowed));
        }
        Ok(())
    }

    fn validate_clump(&self) -> Result<(), Fault> {
        match (&self.clump, self.is_sphere()) {
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
