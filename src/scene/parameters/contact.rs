//! Materials and the contact between them.

use crate::num::Fault;
use crate::num::units::{Damping, Density, Pressure, Stiffness};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

impl ContactParameters {
    pub(super) fn validate(&self) -> Result<(), Fault> {
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
