//! Force-biased packing: the densest random packing of balls of given proportions.
//!
//! Source: Mościński, Bargieł, Rycerz & Jacobs 1989 (Mol. Simul. 3, 201), in the family
//! of Jodrey & Tory 1985 (Phys. Rev. A 32, 2347). Each ball has an outer radius s_out r_i,
//! so large at first that balls overlap, and an inner one s_in r_i, so small that none do. Every
//! round all balls i move by ρ Σ_j r_j (1 − (d_ij / s_ij)²) away from those nearer than
//! s_ij = s_out (r_i + r_j), and s_out shrinks by the share `rate`/2. It ends when
//! s_in ≥ s_out, or when s_in reaches the wanted sizes.
//!
//! The slower, the denser: equal spheres reach a solid fraction near 0.606, 0.637, 0.646 at rates of 1e-3, 1e-4, 1e-5.
//! Balls end with gaps of about the last step of the shrinking and hardly touch: a
//! packing that shall carry load at once has to be grown by about half a per cent or compressed.
//! Cost O(near pairs) a round, rounds ~ 0.13 / rate. Memory about 200 bytes a ball.

use super::occupied::clump_radius;
use super::pairs::Pairs;
use super::space::Space;
use super::target::{Target, ball_volume};
use super::{Grain, Laid, Turn, dress, scatter};
use crate::geometry::{Ball, Region};
use crate::num::{Fault, Job, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of a force-biased packing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ForceBiased {
    /// What sizes come out; default `wanted`.
    pub sizes: Sizes,
    /// Porosity that sizes are multiplied for, 0.01 to 0.999; only with `sizes = "wanted"`; default: as they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub porosity: Option<f64>,
    /// Share by which the outer radius shrinks in two rounds, 1e-7 to 0.1; default 1e-4.
    pub rate: f64,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
}

/// What sizes come out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sizes {
    /// Those wanted if they fit; all smaller by one factor if they do not.
    #[default]
    Wanted,
    /// The largest that fit, all by one factor: the densest packing of these proportions.
    Densest,
}

impl Default for ForceBiased {
    fn default() -> Self {
        Self { sizes: Sizes::Wanted, porosity: None, rate: 1e-4, orientation: Turn::Random }
    }
}

/// A packing that the method has found.
pub struct Dense {
    /// Centres, m.
    pub centres: Vec<Vec3>,
    /// Radii are these times the ones given.
    pub factor: f64,
    /// Rounds done.
    pub rounds: u64,
    /// True if the method ended by itself.
    pub finished: bool,
}

impl ForceBiased {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("rate", self.rate, 1e-7, 0.1)?;
        if self.sizes == Sizes::Densest && self.porosity.is_some() {
            let allowed = "no `porosity`, or sizes = \"wanted\"";
            return Err(Fault::new("porosity", "is given for the densest packing", allowed));
        }
        super::target::validate_porosity(self.porosity)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let space = Space::of(region);
        // The densest packing has sizes of its own, so the wanted ones cannot be too large.
        let radii: Vec<f64> = match self.sizes {
            Sizes::Wanted => {
                Target::of(grains, region, self.porosity)
                    .map_err(|fault| fault.under("force_biased"))?
                    .radii
            }
            Sizes::Densest => grains.iter().map(clump_radius).collect(),
        };
        let enough = match self.sizes {
            Sizes::Wanted => 1.0,
            Sizes::Densest => f64::INFINITY,
        };
        let Some(dense) = densest(&space, &radii, self.rate, enough, seed, job) else {
            return Err(scatter::no_inside().under("force_biased"));
        };
        let fraction = ball_volume(&radii, space.dimension)
            * dense.factor.powi(space.dimension as i32)
            / space.volume();
        let ended = match (dense.finished, self.sizes) {
            (false, _) => "stopped before the end",
            (true, Sizes::Wanted) if dense.factor >= 1.0 => "target met",
            (true, Sizes::Wanted) => "jammed below the target",
            (true, Sizes::Densest) => "jammed",
        };
        let factor = if dense.factor >= 1.0 && enough == 1.0 { 1.0 } else { dense.factor };
        let why = format!("{ended} after {} rounds at solid fraction {fraction:.4}", dense.rounds);
        // A touch of rounding less, so that a balance of distances is no overlap.
        let shrink = factor * (1.0 - 1e-12);
        let balls: Vec<(usize, Ball)> = dense
            .centres
            .iter()
            .zip(&radii)
            .map(|(centre, radius)| Ball { centre: *centre, radius: radius * shrink })
            .enumerate()
            .collect();
        Ok(dress::laid(grains, &balls, space.dimension, self.orientation, seed, &why))
    }
}

/// Packs balls of `radii` (m) and returns the factor on them at which none overlap, or
/// ends as soon as that is `enough`; `None` if the space has no inside.
pub fn densest(
    space: &Space,
    radii: &[f64],
    rate: f64,
    enough: f64,
    seed: u64,
    job: &Job,
) -> Option<Dense> {
    let mut rounds = Rounds::new(space, radii, rate, seed)?;
    let start = rounds.outer;
    loop {
        let inner = rounds.round(enough);
        if rounds.done.is_multiple_of(64) {
            let total = (0.13 * (start / rate)) as u64;
            job.report("rounds", rounds.done, rounds.done.max(total));
        }
        let finished = inner >= rounds.outer || inner >= enough || radii.is_empty();
        if finished || job.is_cancelled() {
            let factor = rounds.closest();
            let mut centres = vec![Vec3::zeros(); radii.len()];
            for (place, &ball) in rounds.order.iter().enumerate() {
                centres[ball as usize] = rounds.centres[place];
            }
            return Some(Dense { centres, factor, rounds: rounds.done, finished });
        }
    }
}

/// The order of centres by cells of `edge` m, so that neighbours lie side by side.
fn side_by_side(space: &Space, centres: &[Vec3], edge: f64) -> Vec<u32> {
    let mut order: Vec<u32> = (0..centres.len() as u32).collect();
    let cell = |&ball: &u32| {
        let p = (centres[ball as usize] - space.bounds.low) / edge;
        [p.z as i64, p.y as i64, p.x as i64]
    };
    order.sort_by_cached_key(cell);
    order
}

struct Rounds<'a> {
    space: &'a Space<'a>,
    /// Number of each ball in the list that was given: neighbours are kept side by side in memory.
    order: Vec<u32>,
    radii: Vec<f64>,
    centres: Vec<Vec3>,
    moves: Vec<Vec3>,
    pairs: Pairs,
    beside_walls: Vec<u32>,
    /// Where the balls were when the pairs were found.
    found_at: Vec<Vec3>,
    stale: bool,
    skin: f64,
    outer: f64,
    step: f64,
    done: u64,
}

impl<'a> Rounds<'a> {
    fn new(space: &'a Space<'a>, radii: &[f64], rate: f64, seed: u64) -> Option<Self> {
        let centres = scatter::anywhere(space, radii, seed)?;
        let mean = radii.iter().sum::<f64>() / radii.len().max(1) as f64;
        let solid = ball_volume(radii, space.dimension).max(f64::MIN_POSITIVE);
        // One fifth denser than any random packing, so that all balls start in each other's way.
        let share = match space.dimension {
            2 => 1.0,
            _ => {
                let diameters: Vec<f64> = radii.iter().map(|radius| 2.0 * radius).collect();
                1.2 * super::rods::closest_of(&diameters).unwrap_or(0.65)
            }
        };
        let outer = (share * space.volume() / solid).powf(1.0 / space.dimension as f64);
        let order = side_by_side(space, &centres, 4.0 * mean * outer);
        let centres: Vec<Vec3> = order.iter().map(|&ball| centres[ball as usize]).collect();
        Some(Self {
            space,
            radii: order.iter().map(|&ball| radii[ball as usize]).collect(),
            order,
            moves: vec![Vec3::zeros(); centres.len()],
            centres,
            pairs: Pairs::default(),
            beside_walls: Vec::new(),
            found_at: Vec::new(),
            stale: true,
            skin: 0.5 * mean * outer,
            outer,
            step: 0.5 * rate * outer,
            done: 0,
        })
    }

    /// Finds pairs about the places `back` of the last move before the present ones. Balls swing to
    /// and fro from round to round, so lists about the middle of the swing (1/2) last several times as long.
    fn find_pairs(&mut self, back: f64) {
        self.found_at.clear();
        for (centre, last) in self.centres.iter_mut().zip(&self.moves) {
            let middle = self.space.wrap(&(*centre - last * back));
            *centre = middle + last * back;
            self.found_at.push(middle);
        }
        self.pairs.find(self.space, &self.found_at, &self.radii, self.outer, self.skin);
        self.beside_walls.clear();
        for (i, middle) in self.found_at.iter().enumerate() {
            if self.space.clearance(middle) < self.outer * self.radii[i] + self.skin {
                self.beside_walls.push(i as u32);
            }
        }
    }

    /// The factor at which no balls overlap.
    fn closest(&mut self) -> f64 {
        self.find_pairs(0.0);
        let largest = self.radii.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        // Pairs beyond the skin are not in the list.
        let mut inner = self.outer + 0.5 * self.skin / largest;
        for pair in &self.pairs.list {
            let (i, j) = (pair.i as usize, pair.j as usize);
            let way =
                self.centres[i] - self.centres[j] + self.pairs.shifts[usize::from(pair.shift)];
            inner = inner.min(way.norm() / (self.radii[i] + self.radii[j]));
        }
        for &i in &self.beside_walls {
            let i = i as usize;
            inner = inner.min(self.wall(i).1 / self.radii[i]);
        }
        inner.max(0.0)
    }

    /// Moves all balls once and shrinks the outer radii, unless balls do not overlap at `enough`
    /// or at the outer radii; returns the factor at which they did not overlap before the move.
    fn round(&mut self, enough: f64) -> f64 {
        if self.stale {
            // Half a move must leave room for further moves.
            let limit = (0.4 * self.skin).powi(2);
            let short = self.moves.iter().all(|last| 0.25 * last.norm_squared() < limit);
            self.find_pairs(if short { 0.5 } else { 0.0 });
        }
        const STRENGTH: f64 = 0.5;
        let mut inner = f64::INFINITY;
        self.moves.iter_mut().for_each(|m| *m = Vec3::zeros());
        for pair in &self.pairs.list {
            let (i, j) = (pair.i as usize, pair.j as usize);
            let way =
                self.centres[i] - self.centres[j] + self.pairs.shifts[usize::from(pair.shift)];
            let sum = self.radii[i] + self.radii[j];
            let (square, reach) = (way.norm_squared(), self.outer * sum);
            if square >= reach * reach {
                continue;
            }
            inner = inner.min(square / (sum * sum));
            let distance = square.sqrt().max(f64::MIN_POSITIVE);
            let push = way * (STRENGTH * self.outer * (1.0 - square / (reach * reach)) / distance);
            self.moves[i] += push * self.radii[j];
            self.moves[j] -= push * self.radii[i];
        }
        let mut inner = inner.sqrt();
        for &i in &self.beside_walls {
            let i = i as usize;
            let (push, clearance) = self.wall(i);
            self.moves[i] += push;
            inner = inner.min(clearance / self.radii[i]);
        }
        let inner = inner.max(0.0);
        if inner >= self.outer || inner >= enough {
            return inner;
        }
        let limit = (0.5 * self.skin).powi(2);
        let mut stale = false;
        for ((centre, step), found) in self.centres.iter_mut().zip(&self.moves).zip(&self.found_at)
        {
            *centre += step;
            stale |= (*centre - found).norm_squared() > limit;
        }
        self.stale = stale;
        self.outer -= self.step;
        self.done += 1;
        inner
    }

    /// Push of the walls on ball `i`, and its clearance.
    fn wall(&self, i: usize) -> (Vec3, f64) {
        let (centre, reach) = (&self.centres[i], self.outer * self.radii[i]);
        if self.space.region().is_none() {
            let (mut push, mut least) = (Vec3::zeros(), f64::INFINITY);
            for axis in (0..self.space.dimension).filter(|&axis| !self.space.periodic[axis]) {
                let low = centre[axis] - self.space.bounds.low[axis];
                let high = self.space.bounds.high[axis] - centre[axis];
                push[axis] += (reach - low).max(0.0) - (reach - high).max(0.0);
                least = least.min(low).min(high);
            }
            return (push, least);
        }
        let clearance = self.space.clearance(centre);
        if clearance >= reach {
            return (Vec3::zeros(), clearance);
        }
        let inward = self.space.inward(centre, 1e-4 * reach).unwrap_or_else(Vec3::zeros);
        (inward * (reach - clearance), clearance)
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{brute_force, cylinder, of, room, sphere};
    use super::super::{Method, pack};
    use super::*;

    #[test]
    fn equal_spheres_come_near_random_close_packing() {
        let space = Space::repeating(3, Vec3::repeat(1.0));
        let radii = vec![1.0; 300];
        let dense = densest(&space, &radii, 1e-3, f64::INFINITY, 1, &Job::quiet()).expect("a box");
        let share = ball_volume(&radii, 3) * dense.factor.powi(3);
        assert!(dense.finished && (0.59..0.63).contains(&share), "{share}");
        let mut least = f64::INFINITY;
        for i in 0..300 {
            for j in 0..i {
                let d = space.apart(&dense.centres[i], &dense.centres[j]).norm();
                least = least.min(d - 2.0 * dense.factor);
            }
        }
        assert!(least.abs() < 1e-9, "{least}");
    }

    #[test]
    fn wanted_sizes_are_kept_in_containers_of_all_kinds() {
        for region in [room(&[1.0; 3]), room(&[1.0; 2]), cylinder()] {
            let clumps = vec![sphere(0.07, region.dimension()); 120];
            let grains = of(&clumps);
            let porosity = if region.dimension() == 2 { 0.35 } else { 0.55 };
            let method = Method::ForceBiased(ForceBiased {
                rate: 1e-3,
                porosity: Some(porosity),
                ..ForceBiased::default()
            });
            let packing = pack(&grains, &[], &region, &method, 1, &Job::quiet()).expect("right");
            assert!(packing.outcome.starts_with("target met"), "{}", packing.outcome);
            let (gap, wall) = brute_force(&packing, &grains, &region);
            assert!(gap > -1e-9 && wall > -1e-9, "{gap} {wall}");
            assert!((packing.measures.porosity - porosity).abs() < 1e-6, "{:?}", packing.measures);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let clumps = vec![sphere(0.07, 3); 120];
        let method =
            Method::ForceBiased(ForceBiased { porosity: Some(0.2), ..ForceBiased::default() });
        let fault = pack(&of(&clumps), &[], &room(&[1.0; 3]), &method, 1, &Job::quiet());
        let text = fault.expect_err("too dense").to_string();
        assert!(text.contains("force_biased.porosity") && text.contains("random close"), "{text}");
    }
}
