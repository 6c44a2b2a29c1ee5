//! Materials and the contact between them.

use crate::model::PairForces;
use crate::model::extra::{BornMayer, Bridge, Cohesion, LennardJones, Rolling, VanDerWaals};
use crate::num::Fault;
use crate::num::units::{Charge, Damping, Density, Pressure, Stiffness};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialParameters {
    /// Density; needed for materials of grains, not for those of walls only.
    #[serde(default)]
    pub density: Option<Density>,
    /// Electric charge of each grain of this material; default 0. Needs `plan.electrostatics`.
    #[serde(default)]
    pub charge: Option<Charge>,
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
    /// Attraction in contact: `linear`, `sjkr`, `sjkr2`, `dmt` or `jkr`. Default none.
    pub cohesion: Option<Cohesion>,
    /// Resistance to rolling: `cdt`, `epsd` or `epsd2`; needs friction. Default none.
    pub rolling: Option<Rolling>,
    /// Liquid bridges. Default none.
    pub bridge: Option<Bridge>,
    /// Van der Waals attraction. Default none.
    pub van_der_waals: Option<VanDerWaals>,
    /// Exponential repulsion in the gap. Default none.
    pub born_mayer: Option<BornMayer>,
    /// 12-6 potential between centres. Default none.
    pub lennard_jones: Option<LennardJones>,
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
    /// Forces besides the linear contact.
    pub fn forces(&self) -> PairForces {
        PairForces {
            cohesion: self.cohesion,
            rolling: self.rolling,
            bridge: self.bridge,
            van_der_waals: self.van_der_waals,
            born_mayer: self.born_mayer,
            lennard_jones: self.lennard_jones,
        }
    }

    /// Refuses forces of spheres for discs.
    pub(super) fn validate_for(&self, dimension: u8) -> Result<(), Fault> {
        self.validate()?;
        if dimension == 3 {
            return Ok(());
        }
        let flat = matches!(self.cohesion, None | Some(Cohesion::Linear { .. }));
        let checks = [
            ("cohesion", flat),
            ("bridge", self.bridge.is_none()),
            ("van_der_waals", self.van_der_waals.is_none()),
        ];
        match checks.iter().find(|(_, good)| !good) {
            Some((key, _)) => Err(Fault::new(
                *key,
                "is a force of spheres",
                "three dimensions, or `cohesion.linear`",
            )),
            None => Ok(()),
        }
    }

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
        Fault::not_negative("friction", self.friction)?;
        if self.rolling.is_some() && self.friction == 0.0 {
            let problem = "is given without `friction`, so that nothing could roll";
            return Err(Fault::new("rolling", problem, "`friction` greater than 0"));
        }
        self.forces().validate()
    }
}
