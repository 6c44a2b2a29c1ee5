//! Measures of a packing or of a state of a run (P18): porosity, coordination
//! number, worst overlap, least gap.
//!
//! Porosity: exact (1 − sum of the bodies' volumes over the container's) where
//! no two bodies overlap and all lie inside; a clump counts with its `volume`. Otherwise the
//! union of all spheres inside the container by 200 000 random points, with
//! the standard error √(p(1 − p)/N).
//! Contacts: through the cell grid, O(n log n + neighbours) for n spheres.

use super::occupied::world_balls;
use super::{Grain, Measures, Placement};
use crate::geometry::grid::near_pairs;
use crate::geometry::{BallGrid, Region};
use crate::num::Vec3;
use crate::num::random::stream;
use std::cell::Cell;
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
        if bodies == 0 { 0.0 } else { 2.0 * self.pairs.len() as f64 / bodies as f64 }
    }
}

/// Contacts among spheres: `centres` and `radii` in m, `body[i]` the body that
/// sphere i belongs to (arrays of one length), `gap_tolerance` the gap in m up to which bodies touch.
///
/// Works on any set of spheres, so states of a run can be measured too.
pub fn contacts_of(centres: &[Vec3], radii: &[f64], body: &[u32], gap_tolerance: f64) -> Contacts {
    let mean_diameter = 2.0 * crate::num::statistics::mean(radii).unwrap_or(0.0);
    // The search for the least gap narrows as it finds smaller ones.
    let least = Cell::new(mean_diameter.max(gap_tolerance));
    let (mut found, mut worst_overlap) = (false, 0.0_f64);
    let mut pairs = Vec::new();
    let reach = || least.get().max(gap_tolerance.next_up());
    near_pairs(centres, radii, body, reach, |i, j, gap| {
        if gap <= gap_tolerance {
            let (a, b) = (body[i as usize], body[j as usize]);
            pairs.push((a.min(b), a.max(b)));
        }
        if gap < least.get() || !found {
            found = true;
            least.set(gap);
        }
        worst_overlap = worst_overlap.max(-gap / radii[i as usize].min(radii[j as usize]));
    });
    pairs.sort_unstable();
    pairs.dedup();
    Contacts { pairs, worst_overlap, least_gap: found.then(|| least.get()) }
}

/// Share of the region that no sphere covers, and its standard error, by `points` random points.
pub fn sampled_porosity(
    centres: &[Vec3],
    radii: &[f64],
    region: &Region,
    points: u32,
) -> Option<(f64, f64)> {
    let mut grid = BallGrid::new(radii.iter().copied().fold(f64::INFINITY, f64::min));
    for (centre, &radius) in centres.iter().zip(radii) {
        grid.insert(*centre, radius);
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
    let (mut centres, mut radii, mut body) = (Vec::new(), Vec::new(), Vec::new());
    let (mut solid, mut diameters, mut inside) = (0.0, 0.0, true);
    for (index, laid) in placements.iter().enumerate() {
        let clump = grains[laid.grain as usize].clump;
        solid += clump.volume;
        diameters += match region.dimension() {
            2 => (4.0 * clump.volume / PI).sqrt(),
            _ => (6.0 * clump.volume / PI).cbrt(),
        };
        for ball in world_balls(&clump.balls, &(laid.position, laid.orientation)) {
            inside = inside && region.clearance(&ball.centre) >= ball.radius * (1.0 - ROUNDING);
            centres.push(ball.centre);
            radii.push(ball.radius);
            body.push(index as u32);
        }
    }
    let bodies = placements.len();
    let gap_tolerance = if bodies == 0 { 0.0 } else { 0.01 * diameters / bodies as f64 };
    let contacts = contacts_of(&centres, &radii, &body, gap_tolerance);
    let container_volume = region.volume();
    let exact = (1.0 - solid / container_volume, 0.0);
    let (porosity, porosity_error) = if inside && contacts.worst_overlap <= ROUNDING {
        exact
    } else {
        sampled_porosity(&centres, &radii, region, 200_000).unwrap_or(exact)
    };
    Measures {
        container_volume,
        porosity,
        porosity_error,
        coordination: contacts.coordination(bodies),
        gap_tolerance,
        worst_overlap: contacts.worst_overlap,
        least_gap: contacts.least_gap,
    }
}
