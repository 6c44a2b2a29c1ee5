//! Step, duration, gravity, damping, scheme.

use super::LawParameters;
use crate::model::extra::Electrostatics;
use crate::model::{Guard, Law, MutualGravity, Scheme};
use crate::num::Fault;
use crate::num::units::{Acceleration, Damping, Time};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::fmt;

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
    /// Gravity between grains. Default: none.
    #[serde(default)]
    pub mutual_gravity: Option<MutualGravity>,
    /// Local (non-viscous) damping coefficient, 0 (default) up to but not including 1.
    #[serde(default)]
    pub local_damping: f64,
    /// Global viscous damping: force −c v on every sphere. Default 0.
    #[serde(default)]
    pub viscous_drag: Damping,
    /// Electrostatic forces between grains whose material has a `charge`. Default none.
    #[serde(default)]
    pub electrostatics: Option<Electrostatics>,
    /// Scheme of riprap's own DEM. Default `leapfrog`.
    #[serde(default = "leapfrog")]
    pub scheme: Scheme,
    /// Variant of the contact law of riprap's own DEM: "usual" (default), "seed" (to the letter),
    /// "liggghts", "yade", "lammps", or a table `law.variant`.
    #[serde(default)]
    pub law: LawParameters,
    /// True: the normal force may pull, whatever the variant. Default false: as the variant says.
    #[serde(default)]
    pub tension: bool,
    /// All velocities and spins are set to zero every so many steps, to let a crowded packing
    /// relax (P11, P15; the note takes 10). Left out: never.
    #[serde(default)]
    pub zero_velocities_every: Option<u32>,
    /// Time after which they no longer are. Default: the whole duration.
    #[serde(default)]
    pub zero_velocities_until: Option<Time>,
    /// True: use the given step even if it is above the stability limit, and go on where the
    /// guard would stop for the step's sake. Default false.
    #[serde(default)]
    pub insist: bool,
    /// What ends the run early.
    #[serde(default)]
    pub guard: Guard,
    /// Whether riprap's own DEM counts the energies that dashpots and slip of contacts take. False: a tenth less
    /// time; no columns `normal_dashpot`, `tangential_dashpot`, `slip` and `energy_error` in `run/series.csv`, and
    /// the guard does not look at `gain`. Default true.
    #[serde(default = "yes")]
    pub ledger: bool,
}

fn yes() -> bool {
    true
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

impl PlanParameters {
    /// The contact law that riprap's own DEM computes.
    pub fn law(&self) -> Law {
        let law = self.law.law(self.scheme);
        Law { tension: law.tension || self.tension, ..law }
    }

    pub(super) fn validate(&self, dimension: u8) -> Result<(), Fault> {
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
        if self.zero_velocities_every == Some(0) {
            return Err(Fault::new("zero_velocities_every", "is 0", "at least 1, or left out"));
        }
        if let Some(until) = self.zero_velocities_until {
            Fault::positive("zero_velocities_until", until.0)?;
            if self.zero_velocities_every.is_none() {
                let allowed = "given together with `zero_velocities_every`";
                return Err(Fault::new("zero_velocities_until", "stands alone", allowed));
            }
        }
        if let Some(mutual) = &self.mutual_gravity {
            mutual.validate().map_err(|fault| fault.under("mutual_gravity"))?;
            if self.scheme == Scheme::Yade {
                let problem = "is \"yade\", whose velocities lag half a step; YADE has no gravity between bodies that it could be compared with";
                return Err(Fault::new("scheme", problem, "leapfrog, liggghts or path_averaged"));
            }
        }
        if !(0.0..1.0).contains(&self.local_damping) {
            let allowed = "0 up to but not including 1";
            return Err(Fault::new("local_damping", format!("is {}", self.local_damping), allowed));
        }
        let Guard { overlap, travel, gain, shaking, .. } = self.guard;
        let watches =
            [("overlap", overlap), ("travel", travel), ("gain", gain), ("shaking", shaking)];
        for (key, value) in watches {
            if !(value.is_finite() && value >= 0.0) {
                let allowed = "0 (off) or greater, in the unit of the default";
                return Err(Fault::new(format!("guard.{key}"), format!("is {value}"), allowed));
            }
        }
        if !self.ledger && gain != Guard::default().gain && gain > 0.0 {
            let problem = "is to be watched without a ledger";
            return Err(Fault::new("guard.gain", problem, "left out, or `plan.ledger = true`"));
        }
        Fault::not_negative("viscous_drag", self.viscous_drag.0)?;
        if let Some(field) = &self.electrostatics {
            field.validate().map_err(|fault| fault.under("electrostatics"))?;
        }
        self.law.validate(self.scheme)
    }
}
