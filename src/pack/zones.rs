//! Zones (P13): boxes inside the container that grains of a family are kept to, each with its own sizes.
//!
//! With temporary walls a grain lies wholly inside its zone while it is packed, without them only its centre
//! does, so that zones mix at their borders. The walls are gone when the packing is done: no run sees them.

use super::Grain;
use crate::geometry::Bounds;
use crate::num::units::Length;
use crate::num::{Fault, MethodEntry, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `riprap list packings` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "zones",
    id: "P13",
    summary: "boxes with families and sizes of their own, with or without temporary walls",
    source: "Itasca, PFC",
    example: r#"packing.random = { zones = [{ family = "ball", low = [0, 0, 0], high = ["20 cm", "20 cm", "20 cm"] }] }"#,
};

/// A box for the grains of one family.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Zone {
    /// Name of the family; several zones of one family take its grains in turn.
    pub family: String,
    /// Corner with the smallest coordinates, m: 3 numbers, 2 in two dimensions.
    pub low: Vec<Length>,
    /// Corner with the largest coordinates, m.
    pub high: Vec<Length>,
    /// True: temporary walls, grains lie wholly inside; false (default): their centres do.
    #[serde(default)]
    pub walls: bool,
}

impl Zone {
    /// A fault for values that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        let right = |values: &[Length]| {
            (2..=3).contains(&values.len()) && values.iter().all(|value| value.0.is_finite())
        };
        for (key, values) in [("low", &self.low), ("high", &self.high)] {
            if !right(values) {
                let problem = format!("has {} numbers", values.len());
                return Err(Fault::new(key, problem, "3 finite numbers, 2 in two dimensions"));
            }
        }
        let above = self.low.iter().zip(&self.high).all(|(low, high)| low.0 < high.0);
        if self.low.len() != self.high.len() || !above {
            return Err(Fault::new("high", "is not above `low`", "larger numbers, as many"));
        }
        Ok(())
    }

    fn bounds(&self) -> Bounds {
        let corner = |values: &[Length], missing: f64| {
            Vec3::from_fn(|axis, _| values.get(axis).map_or(missing, |value| value.0))
        };
        Bounds { low: corner(&self.low, -0.5), high: corner(&self.high, 0.5) }
    }
}

/// For each grain the zone that it is kept to, if any: bounds, and whether they are walls.
///
/// Errors: a family that does not exist, numbers that do not suit the dimension.
pub fn of_grains(
    zones: &[Zone],
    grains: &[Grain],
    families: &[&str],
    dimension: usize,
) -> Result<Vec<Option<(Bounds, bool)>>, Fault> {
    let mut of_family: Vec<Vec<(Bounds, bool)>> = vec![Vec::new(); families.len()];
    for (index, zone) in zones.iter().enumerate() {
        let wrong = |key: &str, problem: String, allowed: String| {
            Err(Fault::new(key, problem, allowed).under(format!("zones[{index}]")))
        };
        let Some(family) = families.iter().position(|name| *name == zone.family) else {
            let problem = format!("is \"{}\", which is no family", zone.family);
            return wrong("family", problem, format!("one of {}", families.join(", ")));
        };
        if zone.low.len() != dimension {
            let problem = format!("has {} numbers in {dimension} dimensions", zone.low.len());
            return wrong("low", problem, format!("{dimension} numbers"));
        }
        of_family[family].push((zone.bounds(), zone.walls));
    }
    let mut taken = vec![0_usize; families.len()];
    let zone_of = |grain: &Grain| {
        let family = usize::from(grain.family);
        let mine = of_family.get(family).filter(|mine| !mine.is_empty())?;
        taken[family] += 1;
        Some(mine[(taken[family] - 1) % mine.len()])
    };
    Ok(grains.iter().map(zone_of).collect())
}

#[cfg(test)]
mod tests {
    use super::super::samples::{brute_force, of, room, sphere};
    use super::super::{Method, Random, pack};
    use super::*;
    use crate::num::Job;

    fn zone(low: &[f64], high: &[f64], walls: bool) -> Zone {
        let lengths = |values: &[f64]| values.iter().map(|v| Length(*v)).collect();
        Zone { family: "fine".into(), low: lengths(low), high: lengths(high), walls }
    }

    #[test]
    fn grains_of_a_family_stay_in_their_zones() {
        for dimension in [2, 3] {
            let clumps = vec![sphere(0.03, dimension); 80];
            let mut grains = of(&clumps);
            grains[40..].iter_mut().for_each(|grain| grain.family = 1);
            for walls in [true, false] {
                let (low, mut high) = (vec![0.0; dimension], vec![1.0; dimension]);
                high[0] = 0.4;
                let method = Method::Random(Random {
                    zones: vec![zone(&low, &high, walls)],
                    ..Random::default()
                });
                let region = room(&vec![1.0; dimension]);
                let packing =
                    pack(&grains, &["fine", "coarse"], &region, &method, 1, &Job::quiet())
                        .expect("right");
                assert!(packing.dropped.is_empty(), "{}", packing.outcome);
                let limit = if walls { 0.37 + 1e-12 } else { 0.4 };
                let right = |p: &super::super::Placement| p.position.x > 0.4;
                assert!(packing.placements[..40].iter().all(|p| p.position.x <= limit));
                assert!(packing.placements[40..].iter().any(right));
                let (gap, wall) = brute_force(&packing, &grains, &region);
                assert!(gap >= 0.0 && wall >= 0.0);
            }
        }
    }

    #[test]
    fn wrong_zones_name_their_key() {
        assert_eq!(zone(&[0.0], &[1.0], true).validate().expect_err("one number").key, "low");
        assert_eq!(zone(&[0.0, 1.0], &[1.0, 1.0], true).validate().expect_err("flat").key, "high");
        let clumps = [sphere(0.1, 3)];
        let refused = |zones: &[Zone], names: &[&str]| {
            of_grains(zones, &of(&clumps), names, 3).expect_err("is wrong").key
        };
        assert_eq!(refused(&[zone(&[0.0; 3], &[1.0; 3], true)], &["ball"]), "zones[0].family");
        assert_eq!(refused(&[zone(&[0.0; 2], &[1.0; 2], true)], &["fine"]), "zones[0].low");
    }
}
