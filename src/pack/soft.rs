//! Balls that push each other apart: overlaps as springs, no friction, brought to rest.
//!
//! Energy Σ ½ δ² over all overlaps δ (m) among balls and with walls (unit stiffness).
//! [`Soft::relax`] finds its nearest minimum by the fast inertial relaxation engine
//! (FIRE: Bitzek, Koskinen, Gähler, Moseler & Gumbsch 2006, Phys. Rev. Lett. 97,
//! 170201). [`Soft::calm`] is the rule of the packing note: velocities set to zero every few steps, so
//! that nothing flies off. The mass of a ball is its number of near balls
//! over 6, so that one step suits all sizes.
//!
//! This is not the DEM of a run: no friction, no dashpots, no time in seconds. Packings come out at
//! their frictionless state; a run with friction starts from there.
//!
//! Cost O(near pairs) a step; the pairs are found again when balls have moved by
//! half the skin. Memory about 250 bytes a ball.

use super::pairs::Pairs;
use super::space::Space;
use crate::num::{Job, Vec3};

/// How a relaxation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rest {
    /// No overlap is above the tolerance.
    Apart,
    /// Forces balance while overlaps above the tolerance remain: jammed.
    Jammed,
    /// All steps are used up.
    Steps,
    /// The user asked to stop.
    Cancelled,
}

/// State after a relaxation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relaxed {
    /// How it ended.
    pub rest: Rest,
    /// Steps done.
    pub steps: u64,
    /// Largest overlap over the smaller radius.
    pub worst: f64,
    /// Mean force that is left over on a ball over the mean force of a contact; 0 without contacts.
    pub unbalanced: f64,
}

/// Balls in a space.
pub struct Soft<'a> {
    /// Where they are.
    pub space: Space<'a>,
    /// Centres, m.
    pub centres: Vec<Vec3>,
    /// Radii, m.
    pub radii: Vec<f64>,
    pairs: Pairs,
    /// Balls that may touch a wall.
    beside_walls: Vec<u32>,
    masses: Vec<f64>,
    built_at: Vec<Vec3>,
    /// Share of the radii that the pairs were found for.
    built_for: f64,
    skin: f64,
    forces: Vec<Vec3>,
    velocities: Vec<Vec3>,
}

/// Sums over all contacts.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    worst: f64,
    overlap: f64,
    contacts: u64,
}

const STEP: f64 = 0.1;
const LONGEST_STEP: f64 = 0.4;

impl<'a> Soft<'a> {
    /// Balls at rest.
    pub fn new(space: Space<'a>, centres: Vec<Vec3>, radii: Vec<f64>) -> Self {
        let count = radii.len();
        let mean = radii.iter().sum::<f64>() / count.max(1) as f64;
        Self {
            space,
            centres,
            radii,
            pairs: Pairs::default(),
            beside_walls: Vec::new(),
            masses: vec![1.0; count],
            built_at: Vec::new(),
            built_for: 0.0,
            skin: 0.3 * mean,
            forces: vec![Vec3::zeros(); count],
            velocities: vec![Vec3::zeros(); count],
        }
    }

    /// Multiplies all radii.
    pub fn grow(&mut self, factor: f64) {
        self.radii.iter_mut().for_each(|radius| *radius *= factor);
        self.skin *= factor;
        self.built_for /= factor;
    }

    /// Finds the pairs again whatever has moved: after walls have moved.
    pub fn forget_pairs(&mut self) {
        self.built_at.clear();
    }

    /// Finds the pairs again if anything may have come near that is not in the list.
    fn refresh(&mut self) {
        if self.built_at.len() == self.centres.len() && self.built_for >= 1.0 {
            let limit = (0.5 * self.skin).powi(2);
            let moved = |(a, b): (&Vec3, &Vec3)| (a - b).norm_squared() > limit;
            if !self.centres.iter().zip(&self.built_at).any(moved) {
                return;
            }
        }
        // Radii may grow a little before the pairs are out of date.
        const ROOM: f64 = 1.02;
        for centre in &mut self.centres {
            *centre = self.space.wrap(centre);
        }
        self.pairs.find(&self.space, &self.centres, &self.radii, ROOM, self.skin);
        self.built_for = ROOM;
        self.built_at.clone_from(&self.centres);
        self.masses.iter_mut().for_each(|mass| *mass = 0.0);
        for pair in &self.pairs.list {
            self.masses[pair.i as usize] += 1.0 / 12.0;
            self.masses[pair.j as usize] += 1.0 / 12.0;
        }
        self.masses.iter_mut().for_each(|mass| *mass = mass.max(1.0));
        self.beside_walls.clear();
        for (i, centre) in self.centres.iter().enumerate() {
            if self.space.clearance(centre) < ROOM * self.radii[i] + self.skin {
                self.beside_walls.push(i as u32);
            }
        }
    }

    fn push(&mut self) -> Sums {
        let mut sums = Sums::default();
        self.forces.iter_mut().for_each(|force| *force = Vec3::zeros());
        for pair in &self.pairs.list {
            let (i, j) = (pair.i as usize, pair.j as usize);
            let way =
                self.centres[i] - self.centres[j] + self.pairs.shifts[usize::from(pair.shift)];
            let (square, reach) = (way.norm_squared(), self.radii[i] + self.radii[j]);
            if square >= reach * reach {
                continue;
            }
            let distance = square.sqrt();
            let overlap = reach - distance;
            sums.worst = sums.worst.max(overlap / self.radii[i].min(self.radii[j]));
            sums.overlap += overlap;
            sums.contacts += 1;
            // Centres in one place are pushed apart along x.
            let force =
                if distance > 0.0 { way * (overlap / distance) } else { Vec3::x() * overlap };
            self.forces[i] += force;
            self.forces[j] -= force;
        }
        for &i in &self.beside_walls {
            let i = i as usize;
            let (force, worst) = wall_push(&self.space, &self.centres[i], self.radii[i]);
            self.forces[i] += force;
            sums.worst = sums.worst.max(worst / self.radii[i]);
            if worst > 0.0 {
                sums.overlap += worst;
                sums.contacts += 1;
            }
        }
        sums
    }

    fn unbalanced(&self, sums: &Sums) -> f64 {
        if sums.contacts == 0 {
            return 0.0;
        }
        let mean = sums.overlap / sums.contacts as f64;
        let left: f64 = self.forces.iter().map(|force| force.norm()).sum();
        left / self.forces.len() as f64 / mean
    }

    /// Brings the balls to rest: until no overlap is above `tolerance` of the smaller
    /// radius, or forces balance to `balance` of the mean contact force, or after `steps` steps.
    pub fn relax(&mut self, tolerance: f64, balance: f64, steps: u64, job: &Job) -> Relaxed {
        let (mut step, mut mixing, mut downhill) = (STEP, 0.1, 0);
        self.velocities.iter_mut().for_each(|v| *v = Vec3::zeros());
        let mut done = 0;
        loop {
            self.refresh();
            let sums = self.push();
            let unbalanced = if done % 8 == 0 { self.unbalanced(&sums) } else { f64::INFINITY };
            let rest = if sums.worst <= tolerance {
                Some(Rest::Apart)
            } else if unbalanced <= balance {
                Some(Rest::Jammed)
            } else if done >= steps {
                Some(Rest::Steps)
            } else {
                (done % 64 == 0 && job.is_cancelled()).then_some(Rest::Cancelled)
            };
            if let Some(rest) = rest {
                let unbalanced = self.unbalanced(&sums);
                return Relaxed { rest, steps: done, worst: sums.worst, unbalanced };
            }
            let power: f64 = self.forces.iter().zip(&self.velocities).map(|(f, v)| f.dot(v)).sum();
            if power > 0.0 {
                let size = |all: &[Vec3]| all.iter().map(Vec3::norm_squared).sum::<f64>().sqrt();
                let turn =
                    mixing * size(&self.velocities) / size(&self.forces).max(f64::MIN_POSITIVE);
                for (v, f) in self.velocities.iter_mut().zip(&self.forces) {
                    *v = *v * (1.0 - mixing) + f * turn;
                }
                downhill += 1;
                if downhill > 5 {
                    step = (1.1 * step).min(LONGEST_STEP);
                    mixing *= 0.99;
                }
            } else {
                self.velocities.iter_mut().for_each(|v| *v = Vec3::zeros());
                (step, mixing, downhill) = ((0.5 * step).max(0.02), 0.1, 0);
            }
            self.advance(step, f64::INFINITY);
            done += 1;
        }
    }

    /// `rounds` times `every` steps, velocities set to zero before each round; no
    /// ball moves by more than `longest` m a step.
    pub fn calm(&mut self, rounds: u64, every: u64, longest: f64, job: &Job) -> u64 {
        for round in 0..rounds {
            if job.is_cancelled() {
                return round * every;
            }
            self.velocities.iter_mut().for_each(|v| *v = Vec3::zeros());
            for _ in 0..every {
                self.refresh();
                self.push();
                self.advance(LONGEST_STEP, longest);
            }
        }
        rounds * every
    }

    fn advance(&mut self, step: f64, longest: f64) {
        for (i, centre) in self.centres.iter_mut().enumerate() {
            let velocity = &mut self.velocities[i];
            *velocity += self.forces[i] * (step / self.masses[i]);
            let mut way = *velocity * step;
            let length = way.norm();
            if length > longest {
                way *= longest / length;
            }
            *centre += way;
        }
    }

    /// Mean number of touching balls a ball, gap up to `tolerance` of the smaller radius; balls
    /// with fewer than `dimension + 1` are left out, again and again, and their share is the second number.
    pub fn coordination(&mut self, tolerance: f64) -> (f64, f64) {
        self.forget_pairs();
        self.refresh();
        let touching: Vec<(usize, usize)> = self
            .pairs
            .list
            .iter()
            .filter_map(|pair| {
                let (i, j) = (pair.i as usize, pair.j as usize);
                let shift = self.pairs.shifts[usize::from(pair.shift)];
                let gap = (self.centres[i] - self.centres[j] + shift).norm()
                    - self.radii[i]
                    - self.radii[j];
                (gap <= tolerance * self.radii[i].min(self.radii[j])).then_some((i, j))
            })
            .collect();
        let mut held = vec![true; self.radii.len()];
        loop {
            let mut contacts = vec![0_usize; held.len()];
            for &(i, j) in touching.iter().filter(|(i, j)| held[*i] && held[*j]) {
                contacts[i] += 1;
                contacts[j] += 1;
            }
            let mut changed = false;
            for (held, contacts) in held.iter_mut().zip(&contacts) {
                if *held && *contacts <= self.space.dimension {
                    (*held, changed) = (false, true);
                }
            }
            if !changed {
                let count = held.iter().filter(|held| **held).count();
                let mean = contacts.iter().sum::<usize>() as f64 / count.max(1) as f64;
                return (mean, 1.0 - count as f64 / held.len().max(1) as f64);
            }
        }
    }
}

/// Force of the walls on a ball and the largest overlap with one, m.
fn wall_push(space: &Space, centre: &Vec3, radius: f64) -> (Vec3, f64) {
    let Some(region) = space.region() else {
        let (mut force, mut worst) = (Vec3::zeros(), 0.0_f64);
        for axis in (0..space.dimension).filter(|&axis| !space.periodic[axis]) {
            let low = radius - (centre[axis] - space.bounds.low[axis]);
            let high = radius - (space.bounds.high[axis] - centre[axis]);
            force[axis] += low.max(0.0) - high.max(0.0);
            worst = worst.max(low).max(high);
        }
        return (force, worst);
    };
    let overlap = radius - region.clearance(centre);
    if overlap <= 0.0 {
        return (Vec3::zeros(), 0.0);
    }
    let inward = space.inward(centre, 1e-4 * radius);
    let towards = || (space.bounds.centre() - centre).try_normalize(0.0).unwrap_or_else(Vec3::x);
    (inward.unwrap_or_else(towards) * overlap, overlap)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::stream;

    fn loose(dimension: usize, count: usize, share: f64) -> Soft<'static> {
        let space = Space::repeating(dimension, Vec3::repeat(1.0));
        let mut source = stream(1, "soft", 0);
        let centres = (0..count).map(|_| space.sample(&mut source).expect("a box")).collect();
        let unit = if dimension == 2 { 1.0 } else { 4.0 / 3.0 } * std::f64::consts::PI;
        let radius = (share / unit / count as f64).powf(1.0 / dimension as f64);
        Soft::new(space, centres, vec![radius; count])
    }

    #[test]
    fn balls_that_have_room_come_apart() {
        for (dimension, share) in [(2, 0.6), (3, 0.5)] {
            let mut soft = loose(dimension, 300, share);
            let relaxed = soft.relax(1e-6, 1e-9, 4000, &Job::quiet());
            assert_eq!(relaxed.rest, Rest::Apart, "{relaxed:?}");
        }
    }

    #[test]
    fn balls_without_room_jam() {
        let mut soft = loose(3, 300, 0.72);
        let relaxed = soft.relax(1e-6, 1e-4, 6000, &Job::quiet());
        assert_eq!(relaxed.rest, Rest::Jammed, "{relaxed:?}");
        assert!(relaxed.worst > 0.01 && relaxed.worst < 0.5, "{relaxed:?}");
    }
}
