//! Contact parameters of a scene turned into numbers for each pair of materials.
//!
//! - Stiffness from Young's modulus E: kn = E π r² / L, a rod of the smaller
//!   reference radius r between the centres, L = R₁ + R₂ (L = r to a wall): the
//!   "deformability method" of PFC; kt/kn = 2(1 − ν)/(2 − ν) (Mindlin 1949).
//! - Dashpot from restitution: `model::restitution`, exact for the median
//!   masses of the two materials (a wall has none: m_eff is the grain's mass).
//!   LIGGGHTS with absolute damping and YADE's ViscEl law hold one dashpot a pair
//!   of materials, so all three solvers can use the same numbers.

use super::Scene;
use super::parameters::ContactParameters;
use crate::model::extra::Charges;
use crate::model::restitution::{dashpot, ratio_of, restitution};
use crate::model::{Contact, ContactTable, Extra, Material};
use crate::num::Fault;
use crate::num::statistics::median;

/// One grain as far as contact parameters depend on it.
#[derive(Debug, Clone, Copy)]
pub struct GrainFacts {
    /// Index of the material in the scene.
    pub material: u16,
    /// Mass, kg.
    pub mass: f64,
    /// Median radius of its spheres, m.
    pub radius: f64,
}

/// Materials and contact parameters of a model, and how they came about.
#[derive(Debug, Clone)]
pub struct Contacts {
    /// Materials of the model: those of the scene, then those of walls that needed their own entry.
    pub materials: Vec<Material>,
    /// Model material of walls made of scene material `i`.
    pub of_walls: Vec<u16>,
    /// Contact parameters by pair of model materials.
    pub table: ContactTable,
    /// Forces besides the linear contact, by pair of model materials.
    pub extra: Extra,
    /// One entry for each pair that can touch.
    pub pairs: Vec<PairFacts>,
}

/// Contact parameters of one pair, for people.
#[derive(Debug, Clone, serde::Serialize)]
pub struct PairFacts {
    /// Names of the two materials.
    pub between: [String; 2],
    /// The numbers.
    pub contact: Contact,
    /// Where kn and kt come from.
    pub stiffness: String,
    /// Restitution of the lightest and of the heaviest pair of grains with this dashpot.
    pub restitution: [f64; 2],
}

/// Reference values of one side of a contact.
#[derive(Debug, Clone, Copy)]
struct Side {
    radius: f64,
    mass: f64,
    lightest: f64,
    heaviest: f64,
}

impl Side {
    /// A wall: infinitely heavy and flat.
    const WALL: Self = Self {
        radius: f64::INFINITY,
        mass: f64::INFINITY,
        lightest: f64::INFINITY,
        heaviest: f64::INFINITY,
    };
}

/// Computes the table. `wall_materials` are the scene materials of all walls.
///
/// # Errors
/// A fault if a restitution cannot be reached by the law that was asked for.
pub fn contacts(
    scene: &Scene,
    grains: &[GrainFacts],
    wall_materials: &[u16],
) -> Result<Contacts, Fault> {
    let sorts = Sorts::of(scene, grains, wall_materials);
    let count = sorts.materials.len();
    // Every pair is set below.
    let unset = Contact { kn: 1.0, kt: 0.0, cn: 0.0, ct: 0.0, friction: 0.0 };
    let mut table = ContactTable::uniform(count, unset);
    let mut pairs = Vec::new();
    let mut extra = Extra::default();
    extra.drag = scene.plan.viscous_drag.0;
    if let Some(field) = scene.plan.electrostatics {
        let charge = |of: &usize| scene.materials.values().nth(*of).and_then(|m| m.charge);
        let of_material = sorts.origin.iter().map(|of| charge(of).map_or(0.0, |q| q.0)).collect();
        extra.charges = Some(Charges { of_material, field });
    }
    for a in 0..count {
        for b in a..count {
            let (key, parameters) = parameters_of(scene, sorts.origin[a], sorts.origin[b]);
            let (first, second) = sorts.sides_of(a, b);
            let facts = pair(parameters, first, second, scene.plan.law().tension)
                .map_err(|f| f.under(&key))?;
            table.set(a as u16, b as u16, facts.contact);
            let forces = parameters.forces();
            if !forces.is_empty() {
                extra.set(count, a as u16, b as u16, forces);
            }
            if sorts.can_touch(a, b, wall_materials) {
                let between = [a, b].map(|index| sorts.materials[index].name.clone());
                pairs.push(PairFacts { between, ..facts });
            }
        }
    }
    let Sorts { materials, of_walls, .. } = sorts;
    Ok(Contacts { materials, of_walls, table, extra, pairs })
}

/// Materials of the model: those of the scene, and a second one for walls where dashpots or
/// stiffnesses between two grains and between a grain and a wall differ.
struct Sorts {
    materials: Vec<Material>,
    /// The scene material that each is.
    origin: Vec<usize>,
    /// What grains of it are like; `None` without grains.
    sides: Vec<Option<Side>>,
    /// Model material of walls made of a scene material.
    of_walls: Vec<u16>,
}

impl Sorts {
    fn of(scene: &Scene, grains: &[GrainFacts], wall_materials: &[u16]) -> Self {
        let mut materials: Vec<Material> = scene
            .materials
            .iter()
            .map(|(name, m)| Material {
                name: name.clone(),
                density: m.density.map_or(0.0, |d| d.0),
            })
            .collect();
        let count = materials.len();
        let mut sides: Vec<Option<Side>> =
            (0..count).map(|index| grain_side(index as u16, grains)).collect();
        let mut origin: Vec<usize> = (0..count).collect();
        let mut of_walls: Vec<u16> = (0..count as u16).collect();
        for &wall in wall_materials {
            let index = wall as usize;
            if sides[index].is_some()
                && of_walls[index] == wall
                && depends_on_mass_or_radius(scene, index)
            {
                of_walls[index] = materials.len() as u16;
                materials.push(Material {
                    name: format!("{}_wall", materials[index].name),
                    density: materials[index].density,
                });
                sides.push(None);
                origin.push(index);
            }
        }
        Self { materials, origin, sides, of_walls }
    }

    /// The sides of a contact between two materials. Walls never touch each other, but decks hold
    /// the whole table: such pairs get the values that the first grain material would have.
    fn sides_of(&self, a: usize, b: usize) -> (Side, Side) {
        match (self.sides[a], self.sides[b]) {
            (None, None) => {
                (self.sides.iter().flatten().next().copied().unwrap_or(Side::WALL), Side::WALL)
            }
            (first, second) => (first.unwrap_or(Side::WALL), second.unwrap_or(Side::WALL)),
        }
    }

    /// Whether grains of one can touch grains or walls of the other.
    fn can_touch(&self, a: usize, b: usize, wall_materials: &[u16]) -> bool {
        match (self.sides[a], self.sides[b]) {
            (Some(_), Some(_)) => true,
            (None, None) => false,
            _ => wall_materials
                .iter()
                .any(|wall| [a, b].contains(&(self.of_walls[*wall as usize] as usize))),
        }
    }
}

/// True if some contact of this material has a dashpot or stiffness that differs between grains and walls.
fn depends_on_mass_or_radius(scene: &Scene, material: usize) -> bool {
    (0..scene.materials.len()).any(|other| {
        let (_, contact) = parameters_of(scene, material, other);
        contact.restitution.is_some_and(|e| e < 1.0) || contact.young.is_some()
    })
}

/// Parameters between two scene materials, and the key they stand under.
fn parameters_of(scene: &Scene, a: usize, b: usize) -> (String, &ContactParameters) {
    let position = |name: &String| scene.materials.keys().position(|key| key == name);
    let named = scene.pairs.iter().position(|pair| {
        let [first, second] = pair.between.each_ref().map(position);
        [(Some(a), Some(b)), (Some(b), Some(a))].contains(&(first, second))
    });
    match named {
        Some(index) => (format!("pairs[{index}].contact"), &scene.pairs[index].contact),
        None => ("contact".to_owned(), &scene.contact),
    }
}

fn grain_side(material: u16, grains: &[GrainFacts]) -> Option<Side> {
    let mine: Vec<&GrainFacts> = grains.iter().filter(|grain| grain.material == material).collect();
    let masses: Vec<f64> = mine.iter().map(|grain| grain.mass).collect();
    let radii: Vec<f64> = mine.iter().map(|grain| grain.radius).collect();
    Some(Side {
        radius: median(&radii)?,
        mass: median(&masses)?,
        lightest: masses.iter().copied().fold(f64::INFINITY, f64::min),
        heaviest: masses.iter().copied().fold(0.0, f64::max),
    })
}

/// m₁ m₂ / (m₁ + m₂), with infinite masses allowed.
fn effective(a: f64, b: f64) -> f64 {
    1.0 / (1.0 / a + 1.0 / b)
}

fn pair(
    parameters: &ContactParameters,
    a: Side,
    b: Side,
    tension: bool,
) -> Result<PairFacts, Fault> {
    let ratio = parameters.poisson.map_or(2.0 / 7.0, |nu| 2.0 * (1.0 - nu) / (2.0 - nu));
    let smaller = a.radius.min(b.radius);
    let length =
        if b.radius.is_finite() && a.radius.is_finite() { a.radius + b.radius } else { smaller };
    let (kn, source) = match (parameters.kn, parameters.young) {
        (Some(kn), _) => (kn.0, "kn as given".to_owned()),
        (None, Some(young)) => {
            let kn = young.0 * std::f64::consts::PI * smaller * smaller / length;
            let how = format!("kn = E π r²/L with r = {smaller:.4e} m, L = {length:.4e} m");
            (kn, how)
        }
        (None, None) => {
            return Err(Fault::new("kn", "is missing", "`kn`, or `young` and `poisson`"));
        }
    };
    let (kt, tangential) = match (parameters.kt, parameters.poisson) {
        (Some(kt), _) => (kt.0, "kt as given"),
        (None, Some(_)) => (ratio * kn, "kt/kn = 2(1−ν)/(2−ν)"),
        (None, None) => (ratio * kn, "kt = 2/7 kn"),
    };
    let mass = effective(a.mass, b.mass);
    let cn = match (parameters.cn, parameters.restitution) {
        (Some(cn), _) => cn.0,
        (None, Some(e)) => dashpot(e, kn, mass, tension).ok_or_else(|| {
            Fault::new(
                "restitution",
                format!("is {e}"),
                "a value that the dashpot can give, 0 < e ≤ 1",
            )
        })?,
        (None, None) => 0.0,
    };
    let contact = Contact {
        kn,
        kt,
        cn,
        ct: parameters.ct.map_or(0.0, |ct| ct.0),
        friction: parameters.friction,
    };
    let at = |m: f64| restitution(ratio_of(cn, kn, m), tension);
    Ok(PairFacts {
        between: [String::new(), String::new()],
        contact,
        stiffness: format!("{source}, {tangential}"),
        restitution: [at(effective(a.lightest, b.lightest)), at(effective(a.heaviest, b.heaviest))],
    })
}
