//! What a deck leaves out, and why: the rows of `Needs` that a scene lacks.

use crate::model::Needs;
use serde::Serialize;

/// One thing that a deck does not have.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// What, for people.
    pub what: &'static str,
    /// Why the scene does not need it.
    pub why: &'static str,
}

/// What hardly any deck can have (see the limits of the solvers), so that lacking it says nothing.
const NEVER: &[&str] =
    &["mutual_gravity", "servo_walls", "springs", "restarts", "arrivals", "ledger"];

/// Everything that `needs` lacks and a deck could have.
pub fn left_out(needs: &Needs) -> Vec<LeftOut> {
    needs
        .table()
        .into_iter()
        .filter(|(key, _, needed)| !needed && !NEVER.contains(key))
        .map(|(key, what, _)| LeftOut { what, why: why(key) })
        .collect()
}

/// Why a scene without `key` does not need it.
fn why(key: &str) -> &'static str {
    match key {
        "discs" => "the scene has three dimensions",
        "spheres" => "every body is a clump",
        "clumps" => "every body is one sphere",
        "sizes" => "all radii are equal",
        "materials" => "there is one material",
        "gravity" => "it is zero",
        "friction" => "no pair of materials has mu > 0 together with kt > 0 or ct > 0",
        "normal_damping" => "cn is zero for every pair of materials",
        "tangential_damping" => "no friction, or ct is zero for every pair of materials",
        "local_damping" => "its coefficient is zero",
        "periodic" => "the box has walls or open sides",
        "cohesion" => "no pair of materials has any",
        "bridges" => "no pair of materials has liquid",
        "molecular" => "no pair of materials has such a potential",
        "charges" => "no electrostatics are asked for",
        "rolling" => "no pair of materials has any resistance",
        "drag" => "its coefficient is zero",
        "planes" | "oblique_planes" | "meshes" => "there is no such wall",
        "sliding_walls" | "turning_walls" => "no wall moves like that",
        "bonds" => "no two bodies are bonded",
        "zeroing" => "the plan does not ask for it",
        "bond_damping" => "no bond has a dashpot",
        "rotation" => "no tangential force, no clump, no bond, no spin at the start",
        _ => "the scene has none",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Needs;

    #[test]
    fn every_need_has_a_reason_of_its_own() {
        let none = Needs {
            discs: false,
            spheres: false,
            clumps: false,
            sizes: false,
            materials: false,
            gravity: false,
            mutual_gravity: false,
            friction: false,
            normal_damping: false,
            tangential_damping: false,
            local_damping: false,
            periodic: false,
            cohesion: false,
            bridges: false,
            molecular: false,
            charges: false,
            rolling: false,
            drag: false,
            planes: false,
            oblique_planes: false,
            meshes: false,
            sliding_walls: false,
            servo_walls: false,
            turning_walls: false,
            bonds: false,
            bond_damping: false,
            zeroing: false,
            springs: false,
            restarts: false,
            arrivals: false,
            rotation: false,
            ledger: false,
        };
        let list = left_out(&none);
        assert_eq!(list.len() + NEVER.len(), none.table().len());
        assert!(list.iter().all(|entry| entry.why != "the scene has none"), "{list:?}");
    }
}
