//! Radial distribution function g(r): how much likelier a body is at a distance r of another than anywhere.
//!
//! g = Σ_i n_i(r, r + Δ) / (ρ Σ_i V_i(r, r + Δ)) with n_i the bodies in the shell about body i, ρ their number in
//! the room over its volume, and V_i the volume of the shell inside the room, exact (a
//! ball cut by a box): no margin is lost and none is periodic that is not.
//!
//! At most 4 000 bodies, evenly spaced in number, are taken as centres. O(centres · (neighbours + bins)).

use super::bed::Bed;
use crate::geometry::{BallGrid, shared};

/// Bodies that are taken as centres at most.
const CENTRES: usize = 4000;

/// Middle of each bin (m) and g there, up to `reach` m; empty for fewer than two bodies.
pub fn radial(bed: &Bed, reach: f64, bins: usize) -> Vec<(f64, f64)> {
    let dimension = bed.dimension();
    let (space, walls) = (bed.space(), bed.walls());
    if bed.bodies.len() < 2 || bins == 0 {
        return Vec::new();
    }
    let mut grid = BallGrid::new(0.5 * reach / 3.0);
    bed.bodies.iter().for_each(|centre| {
        grid.insert(space.wrap(centre), 0.0);
    });
    let step = reach / bins as f64;
    let stride = bed.bodies.len().div_ceil(CENTRES);
    let (mut seen, mut shells) = (vec![0_u64; bins], vec![0.0_f64; bins]);
    for (i, centre) in bed.bodies.iter().enumerate().step_by(stride) {
        let centre = space.wrap(centre);
        space.images(&centre, reach, |image| {
            let own = *image == centre;
            grid.near(image, reach, |j, distance| {
                if !(own && j as usize == i) {
                    let bin = ((distance / step) as usize).min(bins - 1);
                    seen[bin] += 1;
                }
                true
            })
        });
        let clearance = space.clearance(&centre);
        let mut inner = 0.0;
        for (bin, shell) in shells.iter_mut().enumerate() {
            let radius = (bin + 1) as f64 * step;
            let ball = if radius <= clearance {
                shared::ball(radius, dimension)
            } else {
                shared::ball_and_box(&centre, radius, &walls, dimension)
            };
            *shell += ball - inner;
            inner = ball;
        }
    }
    let density = bed.bodies.len() as f64 / space.volume();
    seen.iter()
        .zip(&shells)
        .enumerate()
        .map(|(bin, (seen, shell))| {
            let expected = density * shell;
            let g = if expected > 0.0 { *seen as f64 / expected } else { 0.0 };
            ((bin as f64 + 0.5) * step, g)
        })
        .collect()
}
