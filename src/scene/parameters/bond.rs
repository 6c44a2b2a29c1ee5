//! Grains of several spheres that are not rigid: the bonds between their spheres.

use crate::num::Fault;
use crate::num::units::{Force, Pressure, Stiffness};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the spheres of one grain hold together.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// They move as one body.
    #[default]
    Rigid,
    /// Each is a body by itself, bonded to its neighbours (D9). Their masses add up to that of the grain.
    Bonded(BondParameters),
}

/// Bonds between the spheres of a grain. At the start they are without force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BondParameters {
    /// What a bond does and when it breaks.
    pub law: BondLaw,
    /// Spheres are bonded if the gap between them is at most this part of the smaller radius; 0 to 1,
    /// default 0.01. Overlapping spheres always are.
    #[serde(default = "hundredth")]
    pub gap: f64,
    /// Dashpots beside the springs, as a part of critical damping of the lightest pair along its line
    /// of centres; 0 (default) to 1.
    #[serde(default)]
    pub damping: f64,
}

fn hundredth() -> f64 {
    0.01
}

/// What a bond does and when it breaks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BondLaw {
    /// Contact bond: springs along and across the line of centres, strengths as forces.
    Contact(ContactBond),
    /// Beam (parallel bond): resists bending and twisting too, strengths as stresses.
    Beam(BeamBond),
    /// Contact bonds whose stiffness gives a `clump.lattice` the moduli asked for (D4).
    Solid(SolidBond),
}

/// Springs along and across the line of centres.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ContactBond {
    /// Stiffness along the line of centres. Default: kn of the contact.
    pub kn: Option<Stiffness>,
    /// Stiffness across it. Default: kt of the contact.
    pub kt: Option<Stiffness>,
    /// Largest pull. Left out: no pull breaks it.
    pub tension: Option<Force>,
    /// Largest force across. Left out: none breaks it.
    pub shear: Option<Force>,
}

/// A short beam of circular section (of unit thickness in two dimensions) between two centres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BeamBond {
    /// Young's modulus of the beam.
    pub young: Pressure,
    /// Poisson's ratio of the beam, 0 to 0.5, default 0.25: shear modulus E/(2(1 + ν)).
    #[serde(default = "quarter")]
    pub poisson: f64,
    /// Radius of the section over that of the smaller sphere, above 0 to 2, default 1.
    #[serde(default = "one")]
    pub radius: f64,
    /// Tensile strength. Left out: no tension or bending breaks it.
    #[serde(default)]
    pub tension: Option<Pressure>,
    /// Shear strength. Left out: no shear or twisting breaks it.
    #[serde(default)]
    pub shear: Option<Pressure>,
}

/// Moduli of a block made of elements on a lattice, for stress along an axis of the lattice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidBond {
    /// Young's modulus of the block.
    pub young: Pressure,
    /// Poisson's ratio of the block: 0 to 1/3 on a `staggered` lattice, 0 on a `cubic` one.
    pub poisson: f64,
    /// Tensile strength: a bond breaks at this stress on the section of a sphere. Left out: never.
    #[serde(default)]
    pub tension: Option<Pressure>,
    /// Shear strength, likewise.
    #[serde(default)]
    pub shear: Option<Pressure>,
}

fn quarter() -> f64 {
    0.25
}

fn one() -> f64 {
    1.0
}

impl BondParameters {
    /// # Errors
    /// A fault for a value out of its range.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("gap", self.gap, 0.0, 1.0)?;
        Fault::within("damping", self.damping, 0.0, 1.0)?;
        let law = match &self.law {
            BondLaw::Contact(bond) => bond.validate().map_err(|fault| fault.under("contact")),
            BondLaw::Beam(bond) => bond.validate().map_err(|fault| fault.under("beam")),
            BondLaw::Solid(bond) => bond.validate().map_err(|fault| fault.under("solid")),
        };
        law.map_err(|fault| fault.under("law"))
    }
}

fn not_negative(key: &str, value: Option<f64>) -> Result<(), Fault> {
    match value {
        Some(value) if value < 0.0 => Err(Fault::new(key, format!("is {value}"), "at least 0")),
        _ => Ok(()),
    }
}

impl ContactBond {
    fn validate(&self) -> Result<(), Fault> {
        if let Some(kn) = self.kn {
            Fault::positive("kn", kn.0)?;
        }
        not_negative("kt", self.kt.map(|kt| kt.0))?;
        not_negative("tension", self.tension.map(|force| force.0))?;
        not_negative("shear", self.shear.map(|force| force.0))
    }
}

impl SolidBond {
    fn validate(&self) -> Result<(), Fault> {
        Fault::positive("young", self.young.0)?;
        not_negative("tension", self.tension.map(|stress| stress.0))?;
        not_negative("shear", self.shear.map(|stress| stress.0))
    }
}

impl BeamBond {
    fn validate(&self) -> Result<(), Fault> {
        Fault::positive("young", self.young.0)?;
        Fault::within("poisson", self.poisson, 0.0, 0.5)?;
        Fault::positive("radius", self.radius)?;
        Fault::within("radius", self.radius, 0.0, 2.0)?;
        not_negative("tension", self.tension.map(|stress| stress.0))?;
        not_negative("shear", self.shear.map(|stress| stress.0))
    }
}
