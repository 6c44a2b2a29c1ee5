//! How much of a probe is solid: the volume of united spheres inside it.
//!
//! Exact where spheres overlap in pairs at most: Σ of what each shares with the probe less the lenses of
//! pairs (of lenses that the surface of the probe cuts, half, with half as the error). Elsewhere, as in
//! clumps of many overlapping spheres, by parallel lines: on each the united length is exact; lines
//! stand in a square grid of about 5 000 that is laid 8 times at random offsets, and the scatter
//! of the eight gives the standard error (randomised quasi-Monte Carlo; Cranley & Patterson 1976).
//!
//! Cost O(k) exact, O(k lines a sphere) else, for k spheres in reach.

use super::bed::Bed;
use super::probe::Probe;
use crate::geometry::{Bounds, shared};
use crate::num::Vec3;
use crate::num::random::{stream, uniform};

/// Share of the volume that cut lenses may leave open before lines are used.
const OPEN: f64 = 1e-5;
const LINES: f64 = 70.0;
const OFFSETS: u64 = 8;

/// Volume of the united spheres of `bed` inside `probe`, m³ (m²), and its error (standard error
/// of lines, bound of cut lenses, 0 where exact).
pub fn solid_volume(bed: &Bed, probe: &Probe) -> (f64, f64) {
    let dimension = bed.dimension();
    let (at, reach) = probe.around(dimension);
    let mut balls: Vec<(usize, Vec3)> = Vec::new();
    bed.near(&at, reach, |sphere, shift| balls.push((sphere, shift)));
    balls.retain(|(sphere, shift)| {
        let centre = bed.spheres.centres[*sphere] + shift;
        probe.side(&centre, bed.spheres.radii[*sphere], dimension) >= 0
    });
    let volume = probe.volume(&bed.walls(), dimension);
    if let Some((solid, open)) = by_pairs(bed, probe, &balls)
        && open <= OPEN * volume
    {
        return (solid.min(volume), open);
    }
    let balls: Vec<(Vec3, f64)> = balls
        .iter()
        .map(|(sphere, shift)| (bed.spheres.centres[*sphere] + shift, bed.spheres.radii[*sphere]))
        .collect();
    by_lines(&balls, probe, dimension)
}

/// Exact volume and what cut lenses leave open; `None` where three spheres may overlap.
fn by_pairs(bed: &Bed, probe: &Probe, balls: &[(usize, Vec3)]) -> Option<(f64, f64)> {
    let dimension = bed.dimension();
    let (centres, radii) = (&bed.spheres.centres, &bed.spheres.radii);
    let mut solid = 0.0;
    for (sphere, shift) in balls {
        solid += probe.shares(&(centres[*sphere] + shift), radii[*sphere], dimension);
    }
    if bed.overlaps.is_empty() {
        return Some((solid, 0.0));
    }
    let mut open = 0.0;
    for (first, shift) in balls {
        for &(other, way) in bed.overlapping(*first) {
            let (i, j) = (*first, other as usize);
            if bed.third(i, j) {
                return None;
            }
            // Each pair once: from its sphere of smaller number.
            if j < i {
                continue;
            }
            let distance = way.norm();
            let volume = shared::two_balls(distance, radii[i], radii[j], dimension);
            let (along, size) = shared::lens(distance, radii[i], radii[j]);
            let unit = way.try_normalize(0.0).unwrap_or_else(Vec3::x);
            let middle = centres[i] + shift - unit * along;
            match probe.side(&middle, size, dimension) {
                1 => solid -= volume,
                0 => {
                    solid -= 0.5 * volume;
                    open += 0.5 * volume;
                }
                _ => {}
            }
        }
    }
    Some((solid, open))
}

/// United length on parallel lines, summed.
fn by_lines(balls: &[(Vec3, f64)], probe: &Probe, dimension: usize) -> (f64, f64) {
    let axis = dimension - 1;
    let bounds = match probe {
        Probe::Ball { at, radius } => Bounds::of([at]).grown(*radius),
        Probe::Box(bounds) => *bounds,
    };
    let mut count = [1_usize; 2];
    let mut step = [1.0_f64; 2];
    let across: f64 = (0..axis).map(|a| bounds.size()[a]).product();
    let wanted =
        (across / if axis == 1 { 50.0 * LINES } else { LINES * LINES }).powf(1.0 / axis as f64);
    for a in 0..axis {
        count[a] = (bounds.size()[a] / wanted).ceil().clamp(1.0, 1e5) as usize;
        step[a] = bounds.size()[a] / count[a] as f64;
    }
    let cell: f64 = (0..axis).map(|a| step[a]).product();
    let mut found = Vec::with_capacity(OFFSETS as usize);
    let mut pieces: Vec<(u32, f64, f64)> = Vec::new();
    for offset in 0..OFFSETS {
        let mut source = stream(offset, "pack.lines", 0);
        let start = [uniform(&mut source, 0.0, 1.0), uniform(&mut source, 0.0, 1.0)];
        pieces.clear();
        for (centre, radius) in balls {
            let span = |a: usize| {
                if a >= axis {
                    return 0..1;
                }
                let place = |x: f64| (x - bounds.low[a]) / step[a] - start[a];
                let low = place(centre[a] - radius).ceil().max(0.0) as usize;
                let high = (place(centre[a] + radius).floor() + 1.0).max(0.0) as usize;
                low..high.min(count[a])
            };
            for i in span(0) {
                for j in span(1) {
                    let mut point = Vec3::zeros();
                    for (a, index) in [i, j].into_iter().enumerate().take(axis) {
                        point[a] = bounds.low[a] + (index as f64 + start[a]) * step[a];
                    }
                    let mut off = point - centre;
                    off[axis] = 0.0;
                    if dimension == 2 {
                        off.z = 0.0;
                    }
                    let half = radius * radius - off.norm_squared();
                    let Some((low, high)) = probe.chord(&point, axis, dimension) else { continue };
                    if half <= 0.0 {
                        continue;
                    }
                    let (a, b) = (centre[axis] - half.sqrt(), centre[axis] + half.sqrt());
                    let (a, b) = (a.max(low), b.min(high));
                    if a < b {
                        pieces.push(((i * count[1] + j) as u32, a, b));
                    }
                }
            }
        }
        found.push(united(&mut pieces) * cell);
    }
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    let scatter: f64 = found.iter().map(|v| (v - mean) * (v - mean)).sum();
    (mean, (scatter / (found.len() * (found.len() - 1)) as f64).sqrt())
}

/// Total length of the united pieces of all lines.
fn united(pieces: &mut [(u32, f64, f64)]) -> f64 {
    pieces.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let (mut total, mut line, mut end) = (0.0, u32::MAX, f64::NEG_INFINITY);
    for &(at, low, high) in pieces.iter() {
        if at != line {
            (line, end) = (at, f64::NEG_INFINITY);
        }
        if high > end {
            total += high - low.max(end);
            end = high;
        }
    }
    total
}
