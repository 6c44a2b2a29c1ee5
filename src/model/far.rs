//! Gravity between bodies.

use crate::num::Fault;
use crate::num::units::Length;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Gravity between bodies (D6): every body attracts every other as a point mass at its
/// centre of mass, U = −G m₁ m₂ / √(r² + ε²). Exact for spheres that do not overlap; clumps
/// attract like points, without torque (error of the order of (size / distance)²). In two
/// dimensions the same law acts within the plane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MutualGravity {
    /// Gravitational constant G, m³/(kg s²), greater than 0. Default 6.6743e-11 (CODATA 2018).
    #[serde(default = "newton")]
    pub constant: f64,
    /// How it is summed. Default `tree = { theta = 0.5, quadrupole = true }`.
    #[serde(default)]
    pub method: FarMethod,
    /// Softening length ε (Plummer), at least 0. Default 0: bodies of finite size cannot
    /// come closer than their radii.
    #[serde(default = "no_length")]
    pub softening: Length,
}

/// How the attraction is summed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FarMethod {
    /// Every pair: exact, cost n².
    AllPairs,
    /// Far groups of bodies count as one (Barnes & Hut 1986): cost n log n.
    Tree(TreeParameters),
}

/// When a group of bodies is far, and what it counts as.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TreeParameters {
    /// A cell of edge s whose centre of mass lies δ off its middle is far from a body at
    /// distance d if d > s/θ + δ. Greater than 0, at most 1. Default 0.5.
    #[serde(default = "half")]
    pub theta: f64,
    /// Whether a far group counts as a point with its second moments, or as a point only. Default true.
    #[serde(default = "yes")]
    pub quadrupole: bool,
}

fn newton() -> f64 {
    6.6743e-11
}

fn no_length() -> Length {
    Length(0.0)
}

fn half() -> f64 {
    0.5
}

fn yes() -> bool {
    true
}

impl Default for TreeParameters {
    fn default() -> Self {
        Self { theta: half(), quadrupole: yes() }
    }
}

impl Default for FarMethod {
    fn default() -> Self {
        Self::Tree(TreeParameters::default())
    }
}

impl MutualGravity {
    /// Refuses values outside their range.
    ///
    /// # Errors
    /// A fault at the key that is wrong.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::positive("constant", self.constant)?;
        if !(self.softening.0.is_finite() && self.softening.0 >= 0.0) {
            let problem = format!("is {}", self.softening.0);
            return Err(Fault::new("softening", problem, "at least 0"));
        }
        match self.method {
            FarMethod::Tree(TreeParameters { theta, .. }) if !(theta > 0.0 && theta <= 1.0) => {
                let allowed =
                    "greater than 0, at most 1 (a body must not be far from its own cell)";
                Err(Fault::new("method.tree.theta", format!("is {theta}"), allowed))
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scene_text_and_ranges() {
        let read = |text: &str| toml::from_str::<MutualGravity>(text);
        let all =
            read("method = \"all_pairs\"\nconstant = 1.0\nsoftening = \"2 mm\"").expect("valid");
        assert_eq!((all.method, all.softening.0), (FarMethod::AllPairs, 0.002));
        assert!(all.validate().is_ok());
        let tree = read("method = { tree = { theta = 0.7 } }").expect("valid");
        let expected = TreeParameters { theta: 0.7, quadrupole: true };
        assert_eq!((tree.method, tree.constant), (FarMethod::Tree(expected), 6.6743e-11));
        for (text, key) in [
            ("constant = 0.0", "constant"),
            ("constant = -1.0", "constant"),
            ("softening = -1.0", "softening"),
            ("method = { tree = { theta = 1.1 } }", "method.tree.theta"),
            ("method = { tree = { theta = 0.0 } }", "method.tree.theta"),
        ] {
            let fault = read(text).expect("well formed").validate().expect_err(text);
            assert_eq!(fault.key, key);
        }
        assert!(read("method = { tree = { theta = 0.5, leaf = 3 } }").is_err());
    }
}
