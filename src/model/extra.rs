//! Forces besides the linear contact: attraction in contact and at a distance,
//! rolling resistance, viscous drag (seeds D5, D7). A scene without them has an empty
//! [`Extra`], and no pass is made for it.
//!
//! Parameters are those of a pair of materials, as in [`super::Contact`]. What each law computes,
//! with its source, stands in `dem::attraction` and `dem::rolling`.

use crate::num::Fault;
use crate::num::units::{Angle, Energy, EnergyDensity, Force, Length, SurfaceTension, Volume};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Forces of a model besides contacts and gravity.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Extra {
    size: usize,
    entries: Vec<PairForces>,
    /// Electrostatic force between bodies, if any carries a charge.
    pub charges: Option<Charges>,
    /// Drag −c v on every sphere, c in N s/m; 0 for none.
    pub drag: f64,
}

/// Charges of bodies and the reach of their force.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Charges {
    /// Charge of a body of each material, C; clumps carry it spread over their spheres by volume.
    pub of_material: Vec<f64>,
    /// Reach and surroundings.
    pub field: Electrostatics,
}

/// Forces between two materials besides the linear contact.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairForces {
    /// Attraction in contact.
    pub cohesion: Option<Cohesion>,
    /// Resistance to rolling.
    pub rolling: Option<Rolling>,
    /// Liquid bridges.
    pub bridge: Option<Bridge>,
    /// Van der Waals attraction.
    pub van_der_waals: Option<VanDerWaals>,
    /// Exponential repulsion at close range.
    pub born_mayer: Option<BornMayer>,
    /// 12-6 potential between centres; not at walls.
    pub lennard_jones: Option<LennardJones>,
}

/// Attraction in contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Cohesion {
    /// Constant pull in contact that falls off linearly to 0 over a range outside it.
    Linear {
        /// Pull in contact, > 0.
        pull: Force,
        /// Gap at which it ends, > 0.
        range: Length,
    },
    /// Pull of a cohesion energy density times the contact circle (LIGGGHTS `cohesion sjkr`).
    Sjkr {
        /// Cohesion energy density, > 0.
        energy_density: EnergyDensity,
    },
    /// The same with the area of LIGGGHTS `cohesion sjkr2`, linear in the overlap.
    Sjkr2 {
        /// Cohesion energy density, > 0.
        energy_density: EnergyDensity,
    },
    /// Constant pull 2 π w R* in contact (Derjaguin, Muller & Toporov 1975).
    Dmt {
        /// Work of adhesion w, > 0.
        work: SurfaceTension,
    },
    /// Constant pull of the size of the pull-off force of Johnson, Kendall & Roberts (1971),
    /// 3/2 π w R*, in contact; their neck outside it is left out.
    Jkr {
        /// Work of adhesion w, > 0.
        work: SurfaceTension,
    },
}

/// Resistance to rolling.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Rolling {
    /// Constant directional torque μr kn δ R* against the relative spin (LIGGGHTS `rolling_friction cdt`).
    Cdt {
        /// Coefficient of rolling friction μr, > 0.
        coefficient: f64,
    },
    /// Elastic-plastic spring-dashpot, kr = 2.25 kn μr² R*², cut at μr |Fn| R* (LIGGGHTS `epsd`).
    Epsd {
        /// Coefficient of rolling friction μr, > 0.
        coefficient: f64,
        /// Damping over the critical one, at least 0, default 0; acts below the cut only.
        #[serde(default)]
        damping: f64,
    },
    /// Elastic-plastic spring, kr = kt R*², cut at μr |Fn| R* (LIGGGHTS `epsd2`).
    Epsd2 {
        /// Coefficient of rolling friction μr, > 0.
        coefficient: f64,
    },
}

/// Liquid bridge of constant volume between two spheres, or a sphere and a wall.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bridge {
    /// Surface tension, > 0.
    pub surface_tension: SurfaceTension,
    /// Volume of liquid in a bridge, > 0.
    pub volume: Volume,
    /// Contact angle, 0 (default) up to but not including 90 degrees.
    #[serde(default)]
    pub angle: Angle,
}

/// What becomes of a force at its cut-off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CutOff {
    /// The force is shifted, so that it is 0 at the cut-off (default).
    #[default]
    ShiftedForce,
    /// Only the potential is shifted; the force ends with a jump.
    ShiftedPotential,
}

/// Van der Waals attraction of solid spheres (Hamaker 1937).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VanDerWaals {
    /// Hamaker constant, > 0.
    pub hamaker: Energy,
    /// Gap below which the force no longer grows, > 0.
    pub least_gap: Length,
    /// Gap at which the force ends, > `least_gap`.
    pub cutoff: Length,
    /// What becomes of the force there.
    #[serde(default)]
    pub cut: CutOff,
}

/// Repulsion B exp(−gap/ρ) (Born & Mayer 1932), as of closed electron shells (Pauli repulsion).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BornMayer {
    /// Energy B at gap 0, > 0.
    pub strength: Energy,
    /// Length ρ over which it falls by e, > 0.
    pub decay: Length,
    /// Gap at which the force ends, > 0.
    pub cutoff: Length,
    /// What becomes of the force there.
    #[serde(default)]
    pub cut: CutOff,
}

/// 4 ε ((σ/r)^12 − (σ/r)^6) between centres (Lennard-Jones 1931).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LennardJones {
    /// Depth ε of the well, > 0.
    pub depth: Energy,
    /// Distance σ of the centres at which the potential is 0, > 0.
    pub size: Length,
    /// Distance of the centres at which the force ends, > `size`.
    pub cutoff: Length,
    /// What becomes of the force there.
    #[serde(default)]
    pub cut: CutOff,
}

/// Coulomb's law between charged bodies, q₁ q₂ / (4 π ε₀ ε r²); walls carry no charge.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Electrostatics {
    /// Distance of the centres at which the force ends, > 0.
    pub cutoff: Length,
    /// Relative permittivity ε of what is between the grains, at least 1, default 1.
    #[serde(default = "one")]
    pub permittivity: f64,
    /// What becomes of the force there.
    #[serde(default)]
    pub cut: CutOff,
}

fn one() -> f64 {
    1.0
}

impl Extra {
    /// The same forces between every pair of `size` materials.
    pub fn uniform(size: usize, forces: PairForces) -> Self {
        Self { size, entries: vec![forces; size * size], ..Self::default() }
    }

    /// Forces between materials `a` and `b`, in either order.
    pub fn between(&self, a: u16, b: u16) -> &PairForces {
        const NONE: &PairForces = &PairForces::NONE;
        self.entries.get(a as usize * self.size + b as usize).unwrap_or(NONE)
    }

    /// Sets the forces between `a` and `b`, both ways, of `size` materials.
    pub fn set(&mut self, size: usize, a: u16, b: u16, forces: PairForces) {
        if self.entries.is_empty() {
            (self.size, self.entries) = (size, vec![PairForces::default(); size * size]);
        }
        let size = self.size;
        self.entries[a as usize * size + b as usize] = forces;
        self.entries[b as usize * size + a as usize] = forces;
    }

    /// True if some pair of materials has what `test` looks for.
    pub fn any(&self, test: impl Fn(&PairForces) -> bool) -> bool {
        self.entries.iter().any(test)
    }

    /// The charge of a body of a material, C.
    pub fn charge(&self, material: u16) -> f64 {
        let charges = self.charges.as_ref();
        charges.and_then(|c| c.of_material.get(material as usize)).copied().unwrap_or(0.0)
    }

    /// The first number that is not finite, for messages.
    pub fn odd_number(&self) -> Option<f64> {
        let pair = |forces: &PairForces| {
            let mut all = Vec::new();
            match forces.cohesion {
                Some(Cohesion::Linear { pull, range }) => all.extend([pull.0, range.0]),
                Some(Cohesion::Sjkr { energy_density } | Cohesion::Sjkr2 { energy_density }) => {
                    all.push(energy_density.0);
                }
                Some(Cohesion::Dmt { work } | Cohesion::Jkr { work }) => all.push(work.0),
                None => {}
            }
            all.extend(forces.rolling.map(|rolling| rolling.coefficient()));
            all.extend(
                forces.bridge.iter().flat_map(|b| [b.surface_tension.0, b.volume.0, b.angle.0]),
            );
            all.extend(
                forces.van_der_waals.iter().flat_map(|v| [v.hamaker.0, v.least_gap.0, v.cutoff.0]),
            );
            all.extend(
                forces.born_mayer.iter().flat_map(|b| [b.strength.0, b.decay.0, b.cutoff.0]),
            );
            all.extend(forces.lennard_jones.iter().flat_map(|l| [l.depth.0, l.size.0, l.cutoff.0]));
            all
        };
        let charges = self.charges.iter().flat_map(|c| c.of_material.iter().copied());
        self.entries
            .iter()
            .flat_map(pair)
            .chain(charges)
            .chain([self.drag])
            .find(|x| !x.is_finite())
    }
}

impl PairForces {
    /// None at all.
    pub const NONE: Self = Self {
        cohesion: None,
        rolling: None,
        bridge: None,
        van_der_waals: None,
        born_mayer: None,
        lennard_jones: None,
    };

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// True if some force acts on spheres that do not touch.
    pub fn reaches(&self) -> bool {
        self.bridge.is_some()
            || self.van_der_waals.is_some()
            || self.born_mayer.is_some()
            || self.lennard_jones.is_some()
            || matches!(self.cohesion, Some(Cohesion::Linear { .. }))
    }

    /// Those that act on a sphere and a wall that do not touch: all but Lennard-Jones, which walls do not have.
    pub fn at_a_distance(&self) -> Self {
        let cohesion = self.cohesion.filter(|law| matches!(law, Cohesion::Linear { .. }));
        Self { cohesion, rolling: None, lennard_jones: None, ..*self }
    }

    /// Those that act in contact only.
    pub fn in_contact(&self) -> Self {
        let cohesion = self.cohesion.filter(|law| !matches!(law, Cohesion::Linear { .. }));
        Self { cohesion, rolling: self.rolling, ..Self::default() }
    }

    /// Checks every law that is given.
    ///
    /// # Errors
    /// A fault that names the key.
    pub fn validate(&self) -> Result<(), Fault> {
        if let Some(cohesion) = &self.cohesion {
            cohesion.validate().map_err(|fault| fault.under("cohesion"))?;
        }
        if let Some(rolling) = &self.rolling {
            rolling.validate().map_err(|fault| fault.under("rolling"))?;
        }
        if let Some(bridge) = &self.bridge {
            bridge.validate().map_err(|fault| fault.under("bridge"))?;
        }
        if let Some(law) = &self.van_der_waals {
            law.validate().map_err(|fault| fault.under("van_der_waals"))?;
        }
        if let Some(law) = &self.born_mayer {
            law.validate().map_err(|fault| fault.under("born_mayer"))?;
        }
        if let Some(law) = &self.lennard_jones {
            law.validate().map_err(|fault| fault.under("lennard_jones"))?;
        }
        Ok(())
    }
}

impl Cohesion {
    fn validate(&self) -> Result<(), Fault> {
        match self {
            Self::Linear { pull, range } => {
                Fault::positive("linear.pull", pull.0)?;
                Fault::positive("linear.range", range.0)
            }
            Self::Sjkr { energy_density } => {
                Fault::positive("sjkr.energy_density", energy_density.0)
            }
            Self::Sjkr2 { energy_density } => {
                Fault::positive("sjkr2.energy_density", energy_density.0)
            }
            Self::Dmt { work } => Fault::positive("dmt.work", work.0),
            Self::Jkr { work } => Fault::positive("jkr.work", work.0),
        }
    }
}

impl Rolling {
    /// Coefficient of rolling friction μr.
    pub fn coefficient(&self) -> f64 {
        match self {
            Self::Cdt { coefficient }
            | Self::Epsd { coefficient, .. }
            | Self::Epsd2 { coefficient } => *coefficient,
        }
    }

    fn validate(&self) -> Result<(), Fault> {
        match self {
            Self::Cdt { coefficient } => Fault::positive("cdt.coefficient", *coefficient),
            Self::Epsd { coefficient, damping } => {
                Fault::positive("epsd.coefficient", *coefficient)?;
                Fault::not_negative("epsd.damping", *damping)
            }
            Self::Epsd2 { coefficient } => Fault::positive("epsd2.coefficient", *coefficient),
        }
    }
}

impl Bridge {
    /// Gap at which a bridge breaks, m: (1 + θ/2) V^(1/3) (Lian, Thornton & Adams 1993).
    pub fn rupture(&self) -> f64 {
        (1.0 + 0.5 * self.angle.0) * self.volume.0.cbrt()
    }

    /// Whether a bridge breaks at this gap, m: [`Bridge::rupture`] without its root.
    pub fn breaks(&self, gap: f64) -> bool {
        (gap / (1.0 + 0.5 * self.angle.0)).powi(3) >= self.volume.0
    }

    fn validate(&self) -> Result<(), Fault> {
        Fault::positive("surface_tension", self.surface_tension.0)?;
        Fault::positive("volume", self.volume.0)?;
        if !(0.0..std::f64::consts::FRAC_PI_2).contains(&self.angle.0) {
            let problem = format!("is {} rad", self.angle.0);
            return Err(Fault::new("angle", problem, "0 up to but not including 90 degrees"));
        }
        Ok(())
    }
}

impl VanDerWaals {
    fn validate(&self) -> Result<(), Fault> {
        Fault::positive("hamaker", self.hamaker.0)?;
        Fault::positive("least_gap", self.least_gap.0)?;
        beyond("cutoff", self.cutoff.0, "least_gap", self.least_gap.0)
    }
}

impl BornMayer {
    fn validate(&self) -> Result<(), Fault> {
        Fault::positive("strength", self.strength.0)?;
        Fault::positive("decay", self.decay.0)?;
        Fault::positive("cutoff", self.cutoff.0)
    }
}

impl LennardJones {
    fn validate(&self) -> Result<(), Fault> {
        Fault::positive("depth", self.depth.0)?;
        Fault::positive("size", self.size.0)?;
        beyond("cutoff", self.cutoff.0, "size", self.size.0)
    }
}

impl Electrostatics {
    /// Checks the values.
    ///
    /// # Errors
    /// A fault that names the key.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::positive("cutoff", self.cutoff.0)?;
        if !(self.permittivity >= 1.0 && self.permittivity.is_finite()) {
            let problem = format!("is {}", self.permittivity);
            return Err(Fault::new("permittivity", problem, "at least 1 (vacuum)"));
        }
        Ok(())
    }
}

fn beyond(key: &str, value: f64, other: &str, least: f64) -> Result<(), Fault> {
    if value > least && value.is_finite() {
        return Ok(());
    }
    Err(Fault::new(key, format!("is {value} m"), format!("more than `{other}` ({least} m)")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_symmetric_and_empty_by_default() {
        let mut extra = Extra::default();
        assert!(extra.between(3, 5).is_empty());
        let forces =
            PairForces { rolling: Some(Rolling::Cdt { coefficient: 0.1 }), ..Default::default() };
        extra.set(3, 0, 2, forces);
        assert_eq!(*extra.between(2, 0), forces);
        assert!(extra.between(1, 2).is_empty());
        assert!(extra.any(|f| f.rolling.is_some()) && !extra.any(PairForces::reaches));
    }

    #[test]
    fn wrong_values_are_named() {
        let forces = PairForces {
            van_der_waals: Some(VanDerWaals {
                hamaker: Energy(1e-19),
                least_gap: Length(1e-9),
                cutoff: Length(1e-10),
                cut: CutOff::ShiftedForce,
            }),
            ..Default::default()
        };
        let fault = forces.validate().expect_err("cut-off below the least gap");
        assert!(fault.to_string().contains("van_der_waals.cutoff"), "{fault}");
        let flat = Bridge {
            surface_tension: SurfaceTension(0.07),
            volume: Volume(1e-12),
            angle: Angle(1.6),
        };
        assert!(flat.validate().is_err());
    }
}
