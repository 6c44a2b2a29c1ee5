//! Bonds: what holds two spheres of different bodies together until it breaks.

use super::Dimension;
use serde::{Deserialize, Serialize};

/// An elastic joint between two spheres, without force in the places of time 0 whatever the
/// overlap or gap there. While it is intact it replaces the contact law of the two spheres:
/// it pulls as well as pushes and does not slip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bond {
    /// Index into `Model::spheres`.
    pub first: u32,
    /// Index into `Model::spheres`, of another body, greater than `first`.
    pub second: u32,
    /// Stiffness along the line of centres, N/m; greater than 0.
    pub normal: f64,
    /// Stiffness across it, N/m.
    pub shear: f64,
    /// Stiffness against bending, N m/rad; 0 for a contact bond.
    pub bending: f64,
    /// Stiffness against twisting, N m/rad; 0 for a contact bond. No part in two dimensions.
    pub twisting: f64,
    /// Viscous time β, s: each spring has a dashpot of β times its stiffness beside it.
    pub viscosity: f64,
    /// When it breaks.
    pub strength: Strength,
}

/// When a bond breaks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Strength {
    /// Never.
    Unbreakable,
    /// A contact bond: by force.
    Forces {
        /// Largest pull along the line of centres, N.
        tension: f64,
        /// Largest force across it, N.
        shear: f64,
    },
    /// A beam (parallel bond): by the stress at the rim of its section,
    /// σ = pull/A + M_bending r/I, τ = shear force/A + M_twisting r/J
    /// (Potyondy & Cundall 2004).
    Stresses {
        /// Radius of the section (half width in two dimensions), m.
        radius: f64,
        /// Tensile strength, Pa.
        tension: f64,
        /// Shear strength, Pa.
        shear: f64,
    },
}

/// What broke a bond.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum BreakMode {
    /// The pull along the line of centres.
    Tension,
    /// The force across it.
    Shear,
    /// Mostly the bending moment.
    Bending,
    /// Mostly the twisting moment.
    Twisting,
}

impl BreakMode {
    /// Word in tables.
    pub fn key(self) -> &'static str {
        match self {
            Self::Tension => "tension",
            Self::Shear => "shear",
            Self::Bending => "bending",
            Self::Twisting => "twisting",
        }
    }
}

/// One bond that broke.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Break {
    /// Index into `Model::bonds`.
    pub bond: u32,
    /// Step at which the strength was passed.
    pub step: u64,
    /// Time of that step, s.
    pub time: f64,
    /// What broke it.
    pub mode: BreakMode,
    /// Elastic energy of the bond that was set free, J.
    pub energy: f64,
}

/// Area A and second moments I (bending) and J (twisting) of a bond's section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Half of its width, m.
    pub radius: f64,
    /// Area, m².
    pub area: f64,
    /// Second moment about a diameter, m⁴.
    pub bending: f64,
    /// Polar second moment, m⁴.
    pub twisting: f64,
}

impl Section {
    /// A full circle; in two dimensions a rectangle of unit thickness.
    pub fn new(dimension: Dimension, radius: f64) -> Self {
        match dimension {
            Dimension::Three => {
                let area = std::f64::consts::PI * radius * radius;
                let bending = 0.25 * area * radius * radius;
                Self { radius, area, bending, twisting: 2.0 * bending }
            }
            Dimension::Two => {
                let bending = 2.0 / 3.0 * radius.powi(3);
                Self { radius, area: 2.0 * radius, bending, twisting: bending }
            }
        }
    }
}

impl Bond {
    /// A contact bond: stiffness along and across the line of centres, N/m; no moments.
    pub fn contact(spheres: [u32; 2], normal: f64, shear: f64, strength: Strength) -> Self {
        Self {
            first: spheres[0].min(spheres[1]),
            second: spheres[0].max(spheres[1]),
            normal,
            shear,
            bending: 0.0,
            twisting: 0.0,
            viscosity: 0.0,
            strength,
        }
    }

    /// A short beam of Young's modulus `young` and shear modulus `sliding` (Pa) over `length` (m):
    /// EA/l, GA/l, EI/l, GJ/l (Potyondy & Cundall 2004 with k̄ = E/l).
    pub fn beam(
        spheres: [u32; 2],
        section: Section,
        length: f64,
        [young, sliding]: [f64; 2],
        strength: Strength,
    ) -> Self {
        Self {
            first: spheres[0].min(spheres[1]),
            second: spheres[0].max(spheres[1]),
            normal: young * section.area / length,
            shear: sliding * section.area / length,
            bending: young * section.bending / length,
            twisting: sliding * section.twisting / length,
            viscosity: 0.0,
            strength,
        }
    }

    /// What is wrong with its numbers; `None` if all is well.
    pub fn fault(&self) -> Option<&'static str> {
        let not_negative = |values: &[f64]| values.iter().all(|v| v.is_finite() && *v >= 0.0);
        if !(self.normal.is_finite() && self.normal > 0.0) {
            return Some("needs a normal stiffness greater than 0");
        }
        if !not_negative(&[self.shear, self.bending, self.twisting, self.viscosity]) {
            return Some("needs finite stiffnesses and viscosity of at least 0");
        }
        let strong = match self.strength {
            Strength::Unbreakable => true,
            // Infinite is as good as unbreakable in this mode.
            Strength::Forces { tension, shear } => tension >= 0.0 && shear >= 0.0,
            Strength::Stresses { radius, tension, shear } => {
                radius.is_finite() && radius > 0.0 && tension >= 0.0 && shear >= 0.0
            }
        };
        (!strong).then_some("needs strengths of at least 0 and a section radius greater than 0")
    }

    /// True if it resists turning.
    pub fn has_moments(&self) -> bool {
        self.bending > 0.0 || self.twisting > 0.0
    }
}
