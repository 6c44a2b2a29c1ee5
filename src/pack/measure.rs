//! Measures of a packing or of a state of a run (P18): porosity, coordination
//! number, worst overlap, least gap.
//!
//! Porosity: exact (1 − sum of the bodies' volumes over the container's) where
//! no two bodies overlap and all lie inside; a clump counts with its `volume`. Otherwise the
//! union of all spheres inside the container by 200 000 random points, with
//! the standard error √(p(1 − p)/N).
//! Contacts: through the cell grid, O(n log n + neighbours) for n spheres.

use super::occupied::placed_balls;
use super::{Grain, Measures, Placement};
use crate::geometry::grid::near_pairs;
use crate::geometry::{BallGrid, Cell, Region};
use crate::num::Vec3;
use crate::num::random::stream;
use std::cell;
use std::f64::consts::PI;

/// Who touches whom.
#[derive(Debug, Clone, PartialEq)]
pub struct Contacts {
    /// Pairs of bodies, smaller number first, rising, with some pair of spheres no further apart than the tolerance.
    pub pairs: Vec<(u32, u32)>,
    /// Largest overlap between spheres of different bodies over the smaller radius; 0 for none.
    pub worst_overlap: f64,
    /// Least gap between spheres of different bodies, m (negative: overlap);
    /// `None` where none are nearer than the tolerance or a mean sphere diameter.
    pub least_gap: Option<f64>,
}

impl Contacts {
    /// Mean number of other bodies that each of `bodies` bodies touches; 0 for none.
    pub fn coordination(&self, bodies: usize) -> f64 {
        coordination(self.pairs.len(), bodies)
    }
}

fn coordination(touching: usize, bodies: usize) -> f64 {
    if bodies == 0 { 0.0 } else { 2.0 * touching as f64 / bodies as f64 }
}

/// Contacts among spheres: `centres` and `radii` in m, `body[i]` the body that
/// sphere i belongs to (arrays of one length), `gap_tolerance` the gap in m up to which bodies touch,
/// `cell` how space repeats itself.
///
/// Works on any set of spheres, so states of a run can be measured too.
pub fn contacts_of(
    centres: &[Vec3],
    radii: &[f64],
    body: &[u32],
    gap_tolerance: f64,
    cell: Option<&Cell>,
) -> Contacts {
    if let Some(cell) = cell {
        let mean = crate::num::statistics::mean(radii).unwrap_or(0.0);
        let reach = gap_tolerance.max(2.0 * mean);
        let (centres, radii, body) = with_images(centres, radii, body, cell, reach);
        return contacts_of(&centres, &radii, &body, gap_tolerance, None);
    }
    let mut pairs = Vec::new();
    let (worst_overlap, least_gap) = each_contact(centres, radii, body, gap_tolerance, |i, j| {
        let (a, b) = (body[i as usize], body[j as usize]);
        pairs.push((a.min(b), a.max(b)));
    });
    pairs.sort_unstable();
    pairs.dedup();
    Contacts { pairs, worst_overlap, least_gap }
}

/// Calls `visit` once for each pair of spheres of different bodies that touch; the worst overlap and the least gap as
/// in [`Contacts`].
fn each_contact(
    centres: &[Vec3],
    radii: &[f64],
    body: &[u32],
    gap_tolerance: f64,
    mut visit: impl FnMut(u32, u32),
) -> (f64, Option<f64>) {
    let mean_diameter = 2.0 * crate::num::statistics::mean(radii).unwrap_or(0.0);
    // The search for the least gap narrows as it finds smaller ones.
    let least = cell::Cell::new(mean_diameter.max(gap_tolerance));
    let (mut found, mut worst_overlap) = (false, 0.0_f64);
    let reach = || least.get().max(gap_tolerance + 1e-12 * mean_diameter);
    near_pairs(centres, radii, body, reach, |i, j, gap| {
        if gap <= gap_tolerance {
            visit(i, j);
        }
        if gap < least.get() || !found {
            found = true;
            least.set(gap);
        }
        worst_overlap = worst_overlap.max(-gap / radii[i as usize].min(radii[j as usize]));
    });
    (worst_overlap, found.then(|| least.get()))
}

/// The spheres, each at home, and after them those images that a sphere of the same size inside the cell may come nearer
/// to than `reach` (m): every near pair is there at least once, and small spheres have few images.
pub fn with_images(
    centres: &[Vec3],
    radii: &[f64],
    body: &[u32],
    cell: &Cell,
    reach: f64,
) -> (Vec<Vec3>, Vec<f64>, Vec<u32>) {
    let home = |centre: &Vec3| centre + cell.home(centre);
    let mut all = (centres.iter().map(home).collect::<Vec<_>>(), radii.to_vec(), body.to_vec());
    for index in 0..centres.len() {
        let centre = all.0[index];
        cell.images(&centre, 2.0 * radii[index] + reach, |way| {
            all.0.push(centre + way);
            all.1.push(radii[index]);
            all.2.push(body[index]);
        });
    }
    all
}

/// Share of the region that no sphere covers, and its standard error, by `points` random points.
pub fn sampled_porosity(
    centres: &[Vec3],
    radii: &[f64],
    region: &Region,
    points: u32,
) -> Option<(f64, f64)> {
    let mut grid = BallGrid::new(radii.iter().copied().fold(f64::INFINITY, f64::min));
    let cell = region.cell();
    for (centre, &radius) in centres.iter().zip(radii) {
        let home = cell.map_or(*centre, |cell| centre + cell.home(centre));
        grid.insert(home, radius);
        if let Some(cell) = &cell {
            cell.images(&home, radius, |way| {
                grid.insert(home + way, radius);
            });
        }
    }
    let mut source = stream(0, "pack.porosity", 0);
    let mut free = 0_u32;
    for _ in 0..points {
        let point = region.sample(&mut source)?;
        free += u32::from(!grid.any_near(&point, 0.0));
    }
    let (free, total) = (f64::from(free), f64::from(points));
    let share = free / total;
    Some((share, (share * (1.0 - share) / total).sqrt()))
}

/// Rounding that still counts as "no overlap", in radii.
const ROUNDING: f64 = 1e-9;

/// Measures of a packing. Bodies touch up to a gap of 1 % of the mean
/// equivalent-volume diameter (equal-area in two dimensions).
pub fn measure(placements: &[Placement], grains: &[Grain], region: &Region) -> Measures {
    let count = placements.iter().map(|laid| grains[laid.grain as usize].clump.balls.len()).sum();
    let mut centres = Vec::with_capacity(count);
    let (mut radii, mut body) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut solid, mut diameters, mut inside) = (0.0, 0.0, true);
    for (index, laid) in placements.iter().enumerate() {
        let clump = grains[laid.grain as usize].clump;
        let volume = clump.volume * laid.scale.powi(region.dimension() as i32);
        solid += volume;
        diameters += match region.dimension() {
            2 => (4.0 * volume / PI).sqrt(),
            _ => (6.0 * volume / PI).cbrt(),
        };
        for ball in placed_balls(&clump.balls, laid) {
            inside = inside && region.clearance(&ball.centre) >= ball.radius * (1.0 - ROUNDING);
            centres.push(ball.centre);
            radii.push(ball.radius);
            body.push(index as u32);
        }
    }
    let bodies = placements.len();
    let gap_tolerance = if bodies == 0 { 0.0 } else { 0.01 * diameters / bodies as f64 };
    let (touching, worst_overlap, least_gap) = match region.cell() {
        // Spheres that are bodies of their own meet once, so that they need only be counted: no list of a million pairs.
        None if centres.len() == bodies => {
            let mut touching = 0_usize;
            let (worst, least) =
                each_contact(&centres, &radii, &body, gap_tolerance, |_, _| touching += 1);
            (touching, worst, least)
        }
        cell => {
            let contacts = contacts_of(&centres, &radii, &body, gap_tolerance, cell.as_ref());
            (contacts.pairs.len(), contacts.worst_overlap, contacts.least_gap)
        }
    };
    let container_volume = region.volume();
    let exact = (1.0 - solid / container_volume, 0.0);
    let (porosity, porosity_error) = if inside && worst_overlap <= ROUNDING {
        exact
    } else {
        sampled_porosity(&centres, &radii, region, 200_000).unwrap_or(exact)
    };
    Measures {
        container_volume,
        porosity,
        porosity_error,
        coordination: coordination(touching, bodies),
        gap_tolerance,
        worst_overlap,
        least_gap,
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::room;
    use super::*;
    use crate::num::random::uniform;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn contacts_are_those_of_brute_force(seed in 0_u64..1000, tolerance in 0.0..0.05_f64) {
            let mut source = stream(seed, "contacts", 0);
            let count = 90;
            let centres: Vec<Vec3> = (0..count)
                .map(|_| Vec3::from_fn(|_, _| uniform(&mut source, 0.0, 1.0)))
                .collect();
            let radii: Vec<f64> =
                (0..count).map(|_| 10.0_f64.powf(uniform(&mut source, -2.5, -1.0))).collect();
            let body: Vec<u32> = (0..count as u32).map(|i| i / 2).collect();
            let found = contacts_of(&centres, &radii, &body, tolerance, None);
            let (mut pairs, mut worst, mut least) = (Vec::new(), 0.0_f64, f64::INFINITY);
            for i in 0..count {
                for j in (0..i).filter(|&j| body[i] != body[j]) {
                    let gap = (centres[i] - centres[j]).norm() - radii[i] - radii[j];
                    least = least.min(gap);
                    worst = worst.max(-gap / radii[i].min(radii[j]));
                    if gap <= tolerance {
                        pairs.push((body[j], body[i]));
                    }
                }
            }
            pairs.sort_unstable();
            pairs.dedup();
            prop_assert_eq!(found.pairs, pairs);
            prop_assert!((found.worst_overlap - worst).abs() < 1e-12);
            prop_assert!((found.least_gap.expect("dense enough") - least).abs() < 1e-14);
        }
    }

    #[test]
    fn contacts_across_sides_that_repeat_are_found_from_the_larger_ball() {
        let mut source = stream(7, "contacts", 1);
        let cell = Cell {
            bounds: crate::geometry::Bounds { low: Vec3::zeros(), high: Vec3::repeat(1.0) },
            periodic: [true, true, false],
        };
        let mut centres: Vec<Vec3> =
            (0..150).map(|_| Vec3::from_fn(|_, _| uniform(&mut source, 0.0, 1.0))).collect();
        let mut radii = vec![0.01; 150];
        // One large ball across an edge, whose small neighbours lie on the other side.
        (centres[0], radii[0]) = (Vec3::new(0.98, 0.02, 0.5), 0.22);
        let body: Vec<u32> = (0..150).collect();
        let tolerance = 0.03;
        let mut pairs = Vec::new();
        for i in 0..150_u32 {
            for j in 0..i {
                let way = cell.way(&(centres[i as usize] - centres[j as usize]));
                if way.norm() - radii[i as usize] - radii[j as usize] <= tolerance {
                    pairs.push((j, i));
                }
            }
        }
        pairs.sort_unstable();
        let found = contacts_of(&centres, &radii, &body, tolerance, Some(&cell));
        assert_eq!(found.pairs, pairs);
        assert!(pairs.iter().filter(|pair| pair.0 == 0).count() > 8);
    }

    #[test]
    fn few_bodies_have_no_gap() {
        let none = contacts_of(&[], &[], &[], 0.0, None);
        assert_eq!((none.pairs.len(), none.worst_overlap, none.least_gap), (0, 0.0, None));
        let far = [Vec3::zeros(), Vec3::new(10.0, 0.0, 0.0)];
        assert_eq!(contacts_of(&far, &[1.0, 1.0], &[0, 1], 0.0, None).least_gap, None);
        let near = contacts_of(&far, &[4.0, 4.5], &[0, 1], 0.0, None);
        assert_eq!(near.least_gap, Some(1.5));
        assert_eq!(near.coordination(2), 0.0);
        let touching = contacts_of(&far, &[5.0, 5.0], &[0, 1], 0.0, None);
        assert_eq!(touching.coordination(2), 1.0);
    }

    #[test]
    fn sampled_porosity_of_two_overlapping_balls_is_that_of_their_union() {
        let centres = [Vec3::new(0.4, 0.5, 0.5), Vec3::new(0.6, 0.5, 0.5)];
        let region = room(&[1.0, 1.0, 1.0]);
        let (porosity, error) =
            sampled_porosity(&centres, &[0.2, 0.2], &region, 50_000).expect("a box has points");
        let lens = PI * (4.0 * 0.2 + 0.2) * (2.0 * 0.2 - 0.2_f64).powi(2) / 12.0;
        let exact = 1.0 - (2.0 * 4.0 / 3.0 * PI * 0.008 - lens);
        assert!((porosity - exact).abs() < 4.0 * error, "{porosity} {exact} {error}");
        assert!((5e-4..2e-3).contains(&error), "{error}");
    }
}
