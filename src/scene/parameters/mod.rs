//! What a scene file may say. Parameters of methods live beside the methods;
//! here they are put together.

mod bond;
mod contact;
mod family;
mod insertion;
mod law;
mod mixture;
mod output;
mod plan;
mod walls;

pub use bond::{BeamBond, BondLaw, BondParameters, ContactBond, Hold, SolidBond};
pub use contact::{ContactParameters, MaterialParameters, PairParameters};
pub use family::{Family, Size, UniformSize};
pub use insertion::InsertionParameters;
pub use law::{LawParameters, VariantParameters};
pub use mixture::Mixture;
pub use output::{CompareParameters, MeasureParameters, OutputParameters, Start};
pub use plan::{PlanParameters, StepParameter};
pub use walls::{ContainerParameters, MotionParameters, WallParameters, WallShapeParameters};

use crate::model::Decks;
use crate::num::{Fault, Vec3};
use crate::pack;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A riprap scene: grains, materials, container, packing, plan, outputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Name of the scene, for people.
    pub title: String,
    /// 2 (discs of unit thickness in the x–y plane) or 3 (spheres and clumps). Default 3.
    #[serde(default = "three")]
    pub dimension: u8,
    /// Seed of every random draw. Default 0.
    #[serde(default)]
    pub seed: u64,
    /// Families of grains, at least one.
    pub grains: Vec<Family>,
    /// Number or mass of the grains of all families that have a `fraction` instead of a `count`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mixture: Option<Mixture>,
    /// Materials by name, at least one.
    pub materials: BTreeMap<String, MaterialParameters>,
    /// Contact parameters of every pair of materials that `pairs` does not name.
    pub contact: ContactParameters,
    /// Contact parameters of single pairs of materials.
    #[serde(default)]
    pub pairs: Vec<PairParameters>,
    /// The room that is filled, and its walls. Needed by every packing but `placed`.
    #[serde(default)]
    pub container: Option<ContainerParameters>,
    /// Walls besides those of the container.
    #[serde(default)]
    pub walls: Vec<WallParameters>,
    /// How grains are placed.
    pub packing: pack::Method,
    /// Step, duration, gravity, damping.
    pub plan: PlanParameters,
    /// What is written, and how often.
    #[serde(default)]
    pub output: OutputParameters,
    /// How solvers are compared.
    #[serde(default)]
    pub compare: CompareParameters,
    /// Choices for the decks of outside solvers.
    #[serde(default)]
    pub decks: Decks,
}

fn three() -> u8 {
    3
}

impl Scene {
    /// Acceleration of gravity, m/s²: as given, or 9.81 along −z (−y in two dimensions).
    pub fn gravity(&self) -> Vec3 {
        match self.plan.gravity {
            Some(vector) => Vec3::from(vector.map(|c| c.0)),
            None if self.dimension == 2 => Vec3::new(0.0, -9.81, 0.0),
            None => Vec3::new(0.0, 0.0, -9.81),
        }
    }

    /// Everything that is wrong with the parameters and can be said without files or geometry.
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        let mut note = |result: Result<(), Fault>| faults.extend(result.err());
        if !matches!(self.dimension, 2 | 3) {
            note(Err(Fault::new("dimension", format!("is {}", self.dimension), "2 or 3")));
        }
        if self.grains.is_empty() {
            note(Err(Fault::new("grains", "is empty", "at least one [[grains]] family")));
        }
        if self.materials.is_empty() {
            note(Err(Fault::new("materials", "is empty", "at least one [materials.NAME]")));
        }
        for (name, material) in &self.materials {
            let density = material.density.map_or(Ok(()), |d| Fault::positive("density", d.0));
            note(density.map_err(|fault| fault.under(format!("materials.{name}"))));
        }
        let asked: u64 = self.grains.iter().map(|family| u64::from(family.count)).sum();
        if asked > MOST_GRAINS {
            let problem = format!("ask for {asked} grains in all");
            note(Err(Fault::new("grains", problem, format!("at most {MOST_GRAINS}"))));
        }
        for (index, family) in self.grains.iter().enumerate() {
            let here = format!("grains[{index}]");
            note(family.validate(self.dimension).map_err(|fault| fault.under(&here)));
            note(
                self.material_of_grain(family.material.as_deref())
                    .map(drop)
                    .map_err(|f| f.under(&here)),
            );
            if self.grains[..index].iter().any(|other| other.name == family.name) {
                let problem = format!("is \"{}\", as in an earlier family", family.name);
                note(Err(Fault::new("name", problem, "a name of its own").under(&here)));
            }
        }
        note(self.validate_mixture());
        note(self.contact.validate_for(self.dimension).map_err(|fault| fault.under("contact")));
        for (index, pair) in self.pairs.iter().enumerate() {
            let here = format!("pairs[{index}]");
            note(
                pair.contact
                    .validate_for(self.dimension)
                    .map_err(|fault| fault.under("contact").under(&here)),
            );
            for (side, name) in pair.between.iter().enumerate() {
                let key = format!("between[{side}]");
                note(self.known_material(name, &key).map_err(|fault| fault.under(&here)));
            }
        }
        note(self.validate_container());
        for (index, wall) in self.walls.iter().enumerate() {
            let here = format!("walls[{index}]");
            note(wall.validate(self.dimension).map_err(|fault| fault.under(&here)));
            note(self.material(wall.material.as_deref()).map(drop).map_err(|f| f.under(&here)));
            if self.walls[..index].iter().any(|other| other.name == wall.name) {
                let problem = format!("is \"{}\", as in an earlier wall", wall.name);
                note(Err(Fault::new("name", problem, "a name of its own").under(&here)));
            }
        }
        note(self.packing.validate().map_err(|fault| fault.under("packing")));
        note(self.plan.validate(self.dimension).map_err(|fault| fault.under("plan")));
        let charged = self.materials.values().any(|m| m.charge.is_some_and(|q| q.0 != 0.0));
        if charged && self.plan.electrostatics.is_none() {
            let problem = "is missing, though a material has a charge";
            note(Err(Fault::new("plan.electrostatics", problem, "a table with `cutoff`")));
        }
        note(self.output.validate().map_err(|fault| fault.under("output")));
        note(self.compare.validate().map_err(|fault| fault.under("compare")));
        faults
    }

    fn validate_container(&self) -> Result<(), Fault> {
        let Some(container) = &self.container else {
            if matches!(self.packing, pack::Method::Placed(_)) {
                return Ok(());
            }
            return Err(Fault::new(
                "container",
                "is missing",
                "a [container] for this packing method",
            ));
        };
        container.validate(self.dimension).map_err(|fault| fault.under("container"))?;
        self.material(container.material.as_deref()).map(drop).map_err(|f| f.under("container"))
    }

    /// Index of the material called `name`, or of the only one.
    ///
    /// # Errors
    /// A fault at `material` if there is no such material or the name is left out though there are several.
    pub fn material(&self, name: Option<&str>) -> Result<u16, Fault> {
        match name {
            Some(name) => {
                self.known_material(name, "material")?;
                // `known_material` has found the name, so the position exists.
                Ok(self.materials.keys().position(|key| key == name).unwrap_or(0) as u16)
            }
            None if self.materials.len() == 1 => Ok(0),
            None => Err(Fault::new("material", "is missing", self.material_names())),
        }
    }

    fn material_of_grain(&self, name: Option<&str>) -> Result<u16, Fault> {
        let index = self.material(name)?;
        let has_density =
            self.materials.values().nth(index as usize).is_some_and(|m| m.density.is_some());
        if has_density {
            return Ok(index);
        }
        let problem = "names a material without a density";
        Err(Fault::new("material", problem, "a material with `density`, as grains have mass"))
    }

    fn known_material(&self, name: &str, key: &str) -> Result<(), Fault> {
        if self.materials.contains_key(name) {
            return Ok(());
        }
        Err(Fault::new(key, format!("is \"{name}\", which is no material"), self.material_names()))
    }

    fn material_names(&self) -> String {
        let names: Vec<String> = self.materials.keys().map(|name| format!("\"{name}\"")).collect();
        format!("one of {}", names.join(", "))
    }
}

/// Grains of a scene at most: beyond them lists alone take tens of gigabytes.
const MOST_GRAINS: u64 = 100_000_000;
/// File systems take names of 255 bytes; numbers, names of meshes and endings are added.
const LONGEST_NAME: usize = 100;

/// Names that become file names and parts of decks.
fn validate_name(name: &str) -> Result<(), Fault> {
    let good = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(good) && name.len() <= LONGEST_NAME {
        return Ok(());
    }
    let allowed = format!("letters, digits, `_` and `-`, at most {LONGEST_NAME} of them");
    Err(Fault::new("name", format!("is \"{name}\""), allowed))
}
