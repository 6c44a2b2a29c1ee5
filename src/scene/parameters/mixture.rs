//! Several families of grains by shares of the mass instead of by numbers.

use super::Scene;
use super::family::{Family, Size, UniformSize};
use crate::num::Fault;
use crate::num::units::Mass;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::path::Path;

/// How much of a mixture there is; families have shares of it by their `fraction`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mixture {
    /// Number of grains of all families with a `fraction`.
    Count(u32),
    /// Their mass.
    Mass(Mass),
}

impl Scene {
    /// A fault for shares without a mixture, a mixture without shares, or a family with both share and count.
    pub(super) fn validate_mixture(&self) -> Result<(), Fault> {
        match self.mixture {
            Some(Mixture::Count(0)) => {
                return Err(Fault::new("mixture.count", "is 0", "at least 1"));
            }
            Some(Mixture::Mass(mass)) => Fault::positive("mixture.mass", mass.0)?,
            _ => {}
        }
        for (index, family) in self.grains.iter().enumerate() {
            let here = format!("grains[{index}]");
            validate_family(family, self.mixture.is_some()).map_err(|fault| fault.under(&here))?;
        }
        if self.mixture.is_some() && self.grains.iter().all(|family| family.fraction.is_none()) {
            let allowed = "a `fraction` in at least one family, or no mixture";
            return Err(Fault::new("mixture", "has no family with a share of it", allowed));
        }
        Ok(())
    }

    /// Gives families with a `fraction` their `count`: n = w M/(ρ v) of a mass M, or of N grains in proportion to
    /// w/(ρ v); w the share, ρ the density, v the mean volume of a grain (π d³/6, in two dimensions π d²/4
    /// of unit thickness, over the distribution of d). `base` is the folder that sieve files start from.
    ///
    /// # Errors
    /// A share that comes to less than half a grain, or to more grains than can be counted; a sieve file that cannot be used.
    pub fn count_mixture(&mut self, base: &Path) -> Result<(), Fault> {
        let Some(mixture) = self.mixture else { return Ok(()) };
        let mut parts = Vec::new();
        for (index, family) in self.grains.iter().enumerate() {
            let Some(fraction) = family.fraction else { continue };
            let mass =
                self.mean_mass(family, base).map_err(|f| f.under(format!("grains[{index}]")))?;
            parts.push((index, fraction, mass));
        }
        let whole: f64 = parts.iter().map(|part| part.1).sum();
        let grains: f64 = parts.iter().map(|(_, fraction, mass)| fraction / whole / mass).sum();
        for (index, fraction, mass) in parts {
            let per_mass = fraction / whole / mass;
            let count = match mixture {
                Mixture::Count(count) => f64::from(count) * per_mass / grains,
                Mixture::Mass(total) => total.0 * per_mass,
            };
            if !(0.5..4e9).contains(&count) {
                let problem =
                    format!("is {fraction}, which comes to {count:.3e} grains of this family");
                let key = format!("grains[{index}].fraction");
                return Err(Fault::new(key, problem, "at least one grain and at most 4e9"));
            }
            self.grains[index].count = count.round() as u32;
        }
        Ok(())
    }

    /// Mean mass of a grain of a family, kg.
    fn mean_mass(&self, family: &Family, base: &Path) -> Result<f64, Fault> {
        let dimension = usize::from(self.dimension);
        let cube = match &family.size {
            Some(Size::Fixed(size)) => size.0.powi(i32::from(self.dimension)),
            Some(Size::Uniform(limits)) => mean_power(limits, i32::from(self.dimension)),
            Some(Size::Graded(grading)) => {
                grading.mean_volume(dimension, base).map_err(|fault| fault.under("size"))?
            }
            None => return Err(sizeless()),
        };
        let unit = if dimension == 2 { PI / 4.0 } else { PI / 6.0 };
        Ok(self.density(family)? * unit * cube)
    }

    /// Density of the material of a family, kg/m³.
    ///
    /// # Errors
    /// No such material, or one without a density.
    pub fn density(&self, family: &Family) -> Result<f64, Fault> {
        let material = self.material_of_grain(family.material.as_deref())?;
        let found = self.materials.values().nth(usize::from(material));
        // `material_of_grain` has seen that there is one.
        Ok(found.and_then(|material| material.density).map_or(0.0, |density| density.0))
    }
}

fn sizeless() -> Fault {
    let allowed = "a size, as shares of mass are counted by it";
    Fault::new("size", "is missing beside `fraction`", allowed)
}

fn validate_family(family: &Family, mixed: bool) -> Result<(), Fault> {
    let Some(fraction) = family.fraction else {
        if family.count > 0 {
            return Ok(());
        }
        let allowed = "at least 1, or a `fraction` of a [mixture] instead";
        return Err(Fault::new("count", "is 0 or missing", allowed));
    };
    Fault::positive("fraction", fraction)?;
    if !mixed {
        let allowed = "a `count`, or `mixture.count` or `mixture.mass` at the top of the scene";
        return Err(Fault::new("fraction", "is given without a mixture", allowed));
    }
    if family.count > 0 {
        return Err(Fault::new("count", "is given beside `fraction`", "one of the two"));
    }
    if family.size.is_none() {
        return Err(sizeless());
    }
    Ok(())
}

/// Mean of d^n for d uniform between two limits.
fn mean_power(limits: &UniformSize, n: i32) -> f64 {
    let (min, max) = (limits.min.0, limits.max.0);
    if max - min <= 1e-9 * max {
        return max.powi(n);
    }
    (max.powi(n + 1) - min.powi(n + 1)) / (f64::from(n + 1) * (max - min))
}

#[cfg(test)]
mod tests {
    use crate::scene::Loaded;
    use std::path::Path;

    fn scene(mixture: &str, first: &str, second: &str) -> Result<Loaded, String> {
        let text = format!(
            r#"title = "mix"
{mixture}
packing.random.tries = 10
[[grains]]
name = "sand"
size = "1 mm"
shape = "sphere"
material = "quartz"
{first}
[[grains]]
name = "gravel"
size = {{ min = "2 mm", max = "4 mm" }}
shape = "sphere"
material = "basalt"
{second}
[materials]
quartz = {{ density = 2000 }}
basalt = {{ density = 3000 }}
[contact]
kn = 1e4
restitution = 0.5
friction = 0.3
[container]
shape.box.size = [1, 1, 1]
material = "quartz"
[plan]
duration = 1
"#
        );
        Loaded::parse(Path::new("mix.toml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn counts_come_from_shares_of_the_mass() {
        // Mean of d³ between 2 and 4 mm: (4⁴ − 2⁴)/(4 · 2) = 30 mm³.
        let (sand, gravel) = (2000.0, 3000.0 * 30.0_f64);
        let loaded =
            scene("mixture.count = 10_000", "fraction = 30", "fraction = 70").expect("good");
        let (a, b): (f64, f64) = (0.3 / sand, 0.7 / gravel);
        let counts: Vec<u32> = loaded.scene.grains.iter().map(|family| family.count).collect();
        assert_eq!(
            counts,
            [(1e4 * a / (a + b)).round() as u32, (1e4 * b / (a + b)).round() as u32]
        );
        let loaded =
            scene("mixture.mass = \"1 kg\"", "fraction = 0.5", "fraction = 0.5").expect("good");
        let mass = std::f64::consts::PI / 6.0 * 1e-9 * sand;
        assert_eq!(loaded.scene.grains[0].count, (0.5 / mass).round() as u32);
    }

    #[test]
    fn shares_that_make_no_sense_are_refused() {
        for (mixture, first, second, message) in [
            ("", "fraction = 1", "count = 1", "without a mixture"),
            ("mixture.count = 9", "count = 1", "count = 1", "no family with a share"),
            ("mixture.count = 9", "fraction = 1\ncount = 1", "count = 1", "beside `fraction`"),
            ("mixture.count = 9", "", "fraction = 1", "is 0 or missing"),
            ("mixture.count = 0", "fraction = 1", "count = 1", "`mixture.count` is 0"),
            ("mixture.mass = \"1 kg\"", "fraction = -1", "count = 1", "fraction"),
            ("mixture.count = 9", "fraction = 1", "fraction = 1", "comes to"),
        ] {
            let text = scene(mixture, first, second).expect_err(message);
            assert!(text.contains(message), "{message}: {text}");
        }
    }
}
