//! What one state is like, from sphere positions and velocities alone, so that
//! every solver is measured in the same way.
//!
//! * Heights are measured from the floor ([`Region`]). The top is the 95 % quantile
//!   of the tops of the spheres, so that a single grain on the heap does not decide it.
//! * Porosity: 1 − V/B, B the room of the container beneath the top, V the volume of
//!   bodies in it. A body's volume is mass over density (not the sum of overlapping
//!   spheres), shared among its spheres by r³, and each sphere is cut by the top
//!   plane exactly (r² and circular segments in 2-D).
//! * Contacts: spheres of different bodies whose surfaces touch or overlap.
//!   Coordination counts touching pairs of bodies: 2 pairs / bodies. The normal
//!   force is kn δ, the elastic part, which is all of it in a bed at rest.
//!
//! Pairs come from a cell grid with cells as wide as the largest sphere: O(n)
//! for like sizes.

use super::region::Region;
use crate::model::{Dimension, Frame, Model};
use crate::num::{Vec3, statistics};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A statistic of a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// 95 % quantile of sphere tops above the floor, m.
    TopHeight,
    /// Mean height of body centres above the floor, mass-weighted, m.
    MeanHeight,
    /// Root mean square horizontal distance of bodies from their common centre of mass, m.
    Spread,
    /// Pore volume over volume beneath the top height.
    Porosity,
    /// Kinetic energy, J.
    Kinetic,
    /// Mean number of bodies each body touches.
    Coordination,
    /// Mean normal force between spheres, N.
    MeanForce,
    /// 95 % quantile of the normal forces between spheres, N.
    HighForce,
}

impl Quantity {
    /// Every quantity, in the order of tables.
    pub const ALL: [Self; 8] = [
        Self::TopHeight,
        Self::MeanHeight,
        Self::Spread,
        Self::Porosity,
        Self::Kinetic,
        Self::Coordination,
        Self::MeanForce,
        Self::HighForce,
    ];

    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::TopHeight => "Top height (95 %)",
            Self::MeanHeight => "Mean height",
            Self::Spread => "Horizontal spread",
            Self::Porosity => "Porosity",
            Self::Kinetic => "Kinetic energy",
            Self::Coordination => "Coordination number",
            Self::MeanForce => "Mean contact force",
            Self::HighForce => "Contact force (95 %)",
        }
    }

    /// For files.
    pub fn key(self) -> &'static str {
        match self {
            Self::TopHeight => "top_height",
            Self::MeanHeight => "mean_height",
            Self::Spread => "spread",
            Self::Porosity => "porosity",
            Self::Kinetic => "kinetic",
            Self::Coordination => "coordination",
            Self::MeanForce => "mean_force",
            Self::HighForce => "high_force",
        }
    }

    /// SI unit; empty for pure numbers.
    pub fn unit(self) -> &'static str {
        match self {
            Self::TopHeight | Self::MeanHeight | Self::Spread => "m",
            Self::Kinetic => "J",
            Self::MeanForce | Self::HighForce => "N",
            Self::Porosity | Self::Coordination => "",
        }
    }
}

/// The statistics of one state.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Snapshot {
    /// [`Quantity::TopHeight`].
    pub top_height: f64,
    /// [`Quantity::MeanHeight`].
    pub mean_height: f64,
    /// [`Quantity::Spread`].
    pub spread: f64,
    /// [`Quantity::Porosity`]; `None` where heights mean nothing (no gravity) or nothing is there.
    pub porosity: Option<f64>,
    /// [`Quantity::Kinetic`].
    pub kinetic: f64,
    /// [`Quantity::Coordination`].
    pub coordination: f64,
    /// Standard error of the coordination number, bodies taken as independent.
    pub coordination_error: f64,
    /// Normal forces of all sphere–sphere contacts, rising, N.
    pub forces: Vec<f64>,
}

impl Snapshot {
    /// Measures one state.
    pub(super) fn of(model: &Model, frame: &Frame, region: &Region) -> Self {
        let heights: Vec<f64> =
            frame.centres.iter().map(|c| c.dot(&region.up) - region.base).collect();
        let tops: Vec<f64> =
            heights.iter().zip(&model.spheres).map(|(h, s)| h + s.radius).collect();
        let top_height = statistics::quantile(&tops, 0.95).unwrap_or(0.0);
        let touches = touching(model, &frame.centres);
        let mut forces: Vec<f64> = touches.iter().map(|touch| touch.force).collect();
        forces.sort_by(f64::total_cmp);
        let (coordination, coordination_error) = coordination(model, &touches);
        let (mean_height, spread) = middle_and_spread(model, frame, region);
        Self {
            top_height,
            mean_height,
            spread,
            porosity: porosity(model, &heights, top_height, region),
            kinetic: frame.kinetic_energy(model),
            coordination,
            coordination_error,
            forces,
        }
    }

    /// Value of `quantity`; forces are 0 where nothing touches.
    pub(super) fn value(&self, quantity: Quantity) -> Option<f64> {
        match quantity {
            Quantity::TopHeight => Some(self.top_height),
            Quantity::MeanHeight => Some(self.mean_height),
            Quantity::Spread => Some(self.spread),
            Quantity::Porosity => self.porosity,
            Quantity::Kinetic => Some(self.kinetic),
            Quantity::Coordination => Some(self.coordination),
            Quantity::MeanForce => Some(statistics::mean(&self.forces).unwrap_or(0.0)),
            Quantity::HighForce => Some(statistics::quantile(&self.forces, 0.95).unwrap_or(0.0)),
        }
    }

    /// Standard error of `quantity` from the number of its samples, where chance
    /// is easily estimated: coordination, mean force, force quantile (order statistics).
    pub(super) fn standard_error(&self, quantity: Quantity) -> f64 {
        let count = self.forces.len() as f64;
        match quantity {
            Quantity::Coordination => self.coordination_error,
            Quantity::MeanForce if count > 1.0 => {
                let mean = statistics::mean(&self.forces).unwrap_or(0.0);
                let square: f64 = self.forces.iter().map(|f| (f - mean).powi(2)).sum();
                (square / (count - 1.0) / count).sqrt()
            }
            Quantity::HighForce if count > 1.0 => {
                let reach = (0.95 * 0.05 / count).sqrt();
                let at = |place| statistics::quantile(&self.forces, place).unwrap_or(0.0);
                0.5 * (at(0.95 + reach) - at(0.95 - reach))
            }
            _ => 0.0,
        }
    }
}

fn middle_and_spread(model: &Model, frame: &Frame, region: &Region) -> (f64, f64) {
    let bodies = || frame.bodies.iter().zip(&model.bodies);
    let mass: f64 = bodies().map(|(_, body)| body.mass).sum();
    if mass <= 0.0 {
        return (0.0, 0.0);
    }
    let middle = bodies().map(|(s, b)| s.position * b.mass).sum::<Vec3>() / mass;
    let gravity = model.gravity.norm_squared() > 0.0;
    let square: f64 = bodies()
        .map(|(state, body)| {
            let apart = state.position - middle;
            let flat = if gravity { apart - region.up * apart.dot(&region.up) } else { apart };
            body.mass * flat.norm_squared()
        })
        .sum();
    (middle.dot(&region.up) - region.base, (square / mass).sqrt())
}

fn porosity(model: &Model, heights: &[f64], top: f64, region: &Region) -> Option<f64> {
    let power = model.dimension.count() as i32;
    let bulk = region.beneath(top)?;
    if heights.is_empty() {
        return None;
    }
    let mut solid = 0.0;
    for body in &model.bodies {
        let volume = body.mass / model.materials[body.material as usize].density;
        let first = body.first_sphere as usize;
        let spheres = &model.spheres[first..first + body.sphere_count as usize];
        let whole: f64 = spheres.iter().map(|s| s.radius.powi(power)).sum();
        for (at, sphere) in spheres.iter().enumerate() {
            let below = share_below((top - heights[first + at]) / sphere.radius, model.dimension);
            solid += volume * sphere.radius.powi(power) / whole * below;
        }
    }
    // A container that holds less than its content is no container.
    (solid < bulk).then(|| 1.0 - solid / bulk)
}

/// Share of a unit ball (disc) that lies below the height `h` over its centre.
fn share_below(h: f64, dimension: Dimension) -> f64 {
    let h = h.clamp(-1.0, 1.0);
    match dimension {
        Dimension::Three => (2.0 + 3.0 * h - h.powi(3)) / 4.0,
        Dimension::Two => 0.5 + (h.asin() + h * (1.0 - h * h).sqrt()) / std::f64::consts::PI,
    }
}

/// Two spheres of different bodies that touch.
pub(super) struct Touching {
    pub first: u32,
    pub second: u32,
    /// kn δ, N.
    pub force: f64,
}

/// All touching pairs of spheres of different bodies, in rising order.
pub(super) fn touching(model: &Model, centres: &[Vec3]) -> Vec<Touching> {
    let widest = 2.0 * model.largest_radius();
    let cell = |centre: &Vec3| -> [i64; 3] {
        std::array::from_fn(|axis| (centre[axis] / widest).floor().clamp(-1e15, 1e15) as i64)
    };
    let mut cells: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
    for (index, centre) in centres.iter().enumerate() {
        cells.entry(cell(centre)).or_default().push(index as u32);
    }
    let mut found = Vec::new();
    let look = |first: usize, centre: &Vec3, found: &mut Vec<Touching>| {
        let [x, y, z] = cell(centre);
        for near in 0..27 {
            let place = [x + near % 3 - 1, y + near / 3 % 3 - 1, z + near / 9 - 1];
            for &second in cells.get(&place).map_or(&[][..], Vec::as_slice) {
                if second as usize > first {
                    found.extend(touch(model, centres, first, second as usize));
                }
            }
        }
    };
    for (first, centre) in centres.iter().enumerate() {
        look(first, centre, &mut found);
        if let Some(box_) = &model.periodic {
            // Spheres of a clump at home may stick out of the box.
            box_.images(centre, 2.0 * widest, |way| look(first, &(centre + way), &mut found));
        }
    }
    found.sort_unstable_by_key(|touch| (touch.first, touch.second));
    found.dedup_by_key(|touch| (touch.first, touch.second));
    found
}

fn touch(model: &Model, centres: &[Vec3], first: usize, second: usize) -> Option<Touching> {
    let (a, b) = (&model.spheres[first], &model.spheres[second]);
    let overlap = a.radius + b.radius - model.way(centres[first] - centres[second]).norm();
    if a.body == b.body || overlap < 0.0 {
        return None;
    }
    let material = |body: u32| model.bodies[body as usize].material;
    let contact = model.contacts.between(material(a.body), material(b.body));
    Some(Touching { first: first as u32, second: second as u32, force: contact.kn * overlap })
}

/// Mean number of touched bodies a body and its standard error.
fn coordination(model: &Model, touches: &[Touching]) -> (f64, f64) {
    let body = |sphere: u32| model.spheres[sphere as usize].body;
    let mut pairs: Vec<[u32; 2]> = touches
        .iter()
        .map(|touch| (body(touch.first), body(touch.second)))
        .map(|(a, b)| [a.min(b), a.max(b)])
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    let count = model.bodies.len() as f64;
    let mut touched = vec![0.0_f64; model.bodies.len()];
    for body in pairs.iter().flatten() {
        touched[*body as usize] += 1.0;
    }
    let Some(mean) = statistics::mean(&touched) else { return (0.0, 0.0) };
    let square: f64 = touched.iter().map(|n| (n - mean).powi(2)).sum();
    (mean, (square / (count - 1.0).max(1.0) / count).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::fixture;

    #[test]
    fn a_grid_of_spheres_has_its_closed_forms() {
        let side = 4;
        let model = fixture::model(side);
        let frame = fixture::frame(&model, 0, Vec3::zeros());
        let region = Region::of(&model, Some(&frame));
        assert_eq!((region.base, region.up), (0.0, Vec3::z()));
        let found = Snapshot::of(&model, &frame, &region);
        let n = side as f64;
        // 3 n²(n−1) contacts between n³ spheres, each overlapping by 0.02 r.
        assert_eq!(found.forces.len(), 3 * side * side * (side - 1));
        assert!((found.coordination - 6.0 * (n - 1.0) / n).abs() < 1e-12);
        assert!(
            (found.value(Quantity::MeanForce).expect("touch") / (1e5 * 1e-4) - 1.0).abs() < 1e-9
        );
        let (radius, pitch) = (0.005, 0.0099);
        assert!((found.top_height - ((n - 0.5) * pitch + radius)).abs() < 1e-12);
        assert!((found.mean_height - 0.5 * n * pitch).abs() < 1e-12);
        let solid = n.powi(3) * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        let bulk = (n * pitch).powi(2) * found.top_height;
        assert!((found.porosity.expect("a bed") - (1.0 - solid / bulk)).abs() < 1e-12);
        assert_eq!(found.kinetic, 0.0);
    }

    #[test]
    fn shares_below_a_plane() {
        for dimension in [Dimension::Two, Dimension::Three] {
            assert_eq!(share_below(-2.0, dimension), 0.0);
            assert!((share_below(0.0, dimension) - 0.5).abs() < 1e-15);
            assert!((share_below(1.5, dimension) - 1.0).abs() < 1e-15);
        }
        // Cap of height r/2: π h² (3r − h)/3 over 4/3 π r³ = 5/32.
        assert!((share_below(-0.5, Dimension::Three) - 5.0 / 32.0).abs() < 1e-15);
    }

    #[test]
    fn the_cell_grid_finds_what_all_pairs_find() {
        let mut model = fixture::model(5);
        let mut stream = crate::num::random::stream(3, "test", 0);
        for sphere in &mut model.spheres {
            sphere.radius *= crate::num::random::uniform(&mut stream, 0.3, 1.2);
        }
        let centres: Vec<Vec3> = model
            .sphere_centres(&model.initial_states())
            .iter()
            .map(|c| c - Vec3::repeat(0.02) + crate::num::random::direction(&mut stream) * 0.003)
            .collect();
        let quick: Vec<_> =
            touching(&model, &centres).iter().map(|t| (t.first, t.second)).collect();
        let mut plain = Vec::new();
        for a in 0..centres.len() {
            for b in a + 1..centres.len() {
                plain.extend(touch(&model, &centres, a, b).map(|t| (t.first, t.second)));
            }
        }
        assert!(plain.len() > 50);
        assert_eq!(quick, plain);
    }

    #[test]
    fn clumps_count_bodies_not_spheres() {
        let mut model = fixture::model(2);
        // Bodies 0 and 1 become one clump of two spheres.
        model.spheres[1].body = 0;
        model.spheres[1].offset = model.bodies[1].position - model.bodies[0].position;
        model.bodies[0].sphere_count = 2;
        model.bodies.remove(1);
        for sphere in &mut model.spheres[2..] {
            sphere.body -= 1;
        }
        let centres = model.sphere_centres(&model.initial_states());
        let touches = touching(&model, &centres);
        assert_eq!(touches.len(), 11, "one of the 12 contacts is inside the clump");
        let (mean, _) = coordination(&model, &touches);
        assert!((mean - 2.0 * 11.0 / 7.0).abs() < 1e-12);
    }
}
