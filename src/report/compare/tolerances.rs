//! What counts as agreement.

use crate::num::Fault;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Largest differences at which two solvers still agree. Relative to our run
/// unless said otherwise; all of them 0 or greater.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerances {
    /// Distance of any sphere from where our DEM in the solver's own scheme has it, as a
    /// fraction of the smallest radius, during `contact_durations`; default 1e-3.
    pub trajectory: f64,
    /// How long after the first contact `trajectory` is judged, in durations of the shortest
    /// contact; default 20. Later, chaos parts even equal computations.
    pub contact_durations: f64,
    /// Heights and spread of the final bed, relative to the height of ours; default 0.05.
    pub height: f64,
    /// Porosity of the final bed, relative to ours; default 0.05.
    pub porosity: f64,
    /// Final kinetic energy, relative to the energy that was put in; default 0.01.
    pub kinetic: f64,
    /// Coordination number of the final bed; default 0.1.
    pub coordination: f64,
    /// Mean and 95 % quantile of the normal contact forces of the final bed; default 0.15.
    pub contact_force: f64,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            trajectory: 1e-3,
            contact_durations: 20.0,
            height: 0.05,
            porosity: 0.05,
            kinetic: 0.01,
            coordination: 0.1,
            contact_force: 0.15,
        }
    }
}

impl Tolerances {
    /// A fault for a value that is not finite or less than 0.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::not_negative("trajectory", self.trajectory)?;
        Fault::not_negative("contact_durations", self.contact_durations)?;
        Fault::not_negative("height", self.height)?;
        Fault::not_negative("porosity", self.porosity)?;
        Fault::not_negative("kinetic", self.kinetic)?;
        Fault::not_negative("coordination", self.coordination)?;
        Fault::not_negative("contact_force", self.contact_force)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_parts_and_refuses_nonsense() {
        let some: Tolerances = toml::from_str("height = 0.2").expect("one key is enough");
        assert_eq!(some, Tolerances { height: 0.2, ..Tolerances::default() });
        assert!(some.validate().is_ok());
        assert!(toml::from_str::<Tolerances>("hight = 0.2").is_err());
        let bad = Tolerances { coordination: f64::NAN, ..some };
        assert_eq!(bad.validate().expect_err("NaN is no tolerance").key, "coordination");
    }
}
