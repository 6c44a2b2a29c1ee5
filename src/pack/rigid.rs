//! Overlapping clumps that push each other apart as rigid bodies, velocities set to zero every few steps.
//!
//! Energy Σ ½ δ² over the overlaps δ (m) of spheres of different bodies and with walls (unit stiffness, no
//! friction). A body weighs as much as it has overlapping spheres, its moment of inertia is
//! that times the square of its radius, so that one step suits all. Every `zero_every` steps
//! velocities and spins are set to zero: nothing flies off, and the motion follows the forces. As in [`super::soft`]
//! this is not the DEM of a run. O(near pairs of spheres) a step; pairs are found again in each round.

use super::occupied::placed_balls;
use super::pairs::{Pair, Pairs};
use super::space::Space;
use super::{Grain, Placement};
use crate::num::{Job, Rotation, Vec3};

const STEP: f64 = 0.5;

/// How a relaxation ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calmed {
    /// "no overlap is above the tolerance", "jammed", …
    pub end: &'static str,
    /// Rounds done.
    pub rounds: u32,
    /// Largest overlap over the smaller radius.
    pub worst: f64,
}

/// Spheres of all bodies.
struct Balls {
    /// Arm from the centre of mass, as laid, in the world frame.
    arms: Vec<Vec3>,
    centres: Vec<Vec3>,
    radii: Vec<f64>,
    body: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Push {
    force: Vec3,
    torque: Vec3,
    contacts: f64,
}

const STILL: Push =
    Push { force: Vec3::new(0.0, 0.0, 0.0), torque: Vec3::new(0.0, 0.0, 0.0), contacts: 0.0 };

/// Moves and turns `placements` until no overlap is above `overlap` (over the smaller radius), forces
/// balance, or all rounds are done.
pub fn calm(
    placements: &mut [Placement],
    grains: &[Grain],
    space: &Space,
    zero_every: u32,
    rounds: u32,
    overlap: f64,
    job: &Job,
) -> Calmed {
    let mut balls = Balls::of(placements, grains);
    let smallest = balls.radii.iter().copied().fold(f64::INFINITY, f64::min);
    let reach: Vec<f64> = reaches(&balls, placements.len());
    // No body moves farther in a round than half of this.
    let skin = 0.2 * smallest;
    let longest = 0.25 * skin / f64::from(zero_every);
    let mut end = Calmed { end: "all rounds are used up", rounds: 0, worst: 0.0 };
    let (mut quiet, mut pairs) = (0, Pairs::default());
    for round in 0..rounds {
        if job.is_cancelled() {
            end.end = "stopped by the user";
            break;
        }
        let home: Vec<Vec3> = balls.centres.iter().map(|centre| space.wrap(centre)).collect();
        pairs.find(space, &home, &balls.radii, 1.0, skin);
        pairs.list.retain(|pair| balls.body[pair.i as usize] != balls.body[pair.j as usize]);
        let mut motion = vec![(Vec3::zeros(), Vec3::zeros()); placements.len()];
        for _ in 0..zero_every {
            let (pushes, worst, unbalanced) = balls.pushes(&pairs.list, space, placements);
            (end.worst, end.rounds) = (worst, round + 1);
            quiet = if unbalanced < 1e-3 { quiet + 1 } else { 0 };
            if worst <= overlap {
                end.end = "no overlap is above the tolerance";
                return end;
            }
            for (body, push) in pushes.iter().enumerate().filter(|(_, push)| push.contacts > 0.0) {
                let (velocity, spin) = &mut motion[body];
                *velocity += push.force * (STEP / push.contacts);
                *spin += push.torque * (STEP / (push.contacts * reach[body].powi(2)));
                let step = |way: Vec3, size: f64| {
                    let far = way.norm() * size;
                    if far > longest { way * (longest / far) } else { way }
                };
                let (way, turn) = (step(*velocity * STEP, 1.0), step(*spin * STEP, reach[body]));
                placements[body].position += way;
                let mut orientation =
                    Rotation::from_scaled_axis(turn) * placements[body].orientation;
                orientation.renormalize();
                placements[body].orientation = orientation;
            }
            balls.follow(placements, grains);
        }
        if quiet >= 20 {
            end.end = "jammed: forces balance while overlaps remain";
            break;
        }
        if round % 50 == 0 {
            job.report("rounds", u64::from(round), u64::from(rounds));
        }
    }
    end
}

fn reaches(balls: &Balls, bodies: usize) -> Vec<f64> {
    let mut reach = vec![0.0_f64; bodies];
    for ((arm, radius), &body) in balls.arms.iter().zip(&balls.radii).zip(&balls.body) {
        let mine = &mut reach[body as usize];
        *mine = mine.max(arm.norm() + radius);
    }
    reach
}

impl Balls {
    fn of(placements: &[Placement], grains: &[Grain]) -> Self {
        let (mut arms, mut centres, mut radii, mut body) = (vec![], vec![], vec![], vec![]);
        for (index, laid) in placements.iter().enumerate() {
            for ball in placed_balls(&grains[laid.grain as usize].clump.balls, laid) {
                arms.push(ball.centre - laid.position);
                centres.push(ball.centre);
                radii.push(ball.radius);
                body.push(index as u32);
            }
        }
        Self { arms, centres, radii, body }
    }

    fn follow(&mut self, placements: &[Placement], grains: &[Grain]) {
        let all = placements.iter().flat_map(|laid| {
            placed_balls(&grains[laid.grain as usize].clump.balls, laid)
                .map(move |ball| (ball.centre - laid.position, ball.centre))
        });
        for (index, (arm, centre)) in all.enumerate() {
            (self.arms[index], self.centres[index]) = (arm, centre);
        }
    }

    /// Forces and torques, the largest overlap, and what is left of the forces over their sum.
    fn pushes(
        &self,
        pairs: &[Pair],
        space: &Space,
        placements: &[Placement],
    ) -> (Vec<Push>, f64, f64) {
        let mut pushes = vec![STILL; placements.len()];
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        let planar = space.dimension == 2;
        let mut push = |ball: usize, force: Vec3, radius: f64| {
            let push = &mut pushes[self.body[ball] as usize];
            push.force += force;
            let arm = self.arms[ball] - force.try_normalize(0.0).unwrap_or_default() * radius;
            let torque = arm.cross(&force);
            push.torque += if planar { Vec3::new(0.0, 0.0, torque.z) } else { torque };
            push.contacts += 1.0;
        };
        for pair in pairs {
            let (i, j) = (pair.i as usize, pair.j as usize);
            let apart = space.apart(&self.centres[i], &self.centres[j]);
            let distance = apart.norm();
            let depth = self.radii[i] + self.radii[j] - distance;
            if depth > 0.0 {
                let way = apart.try_normalize(0.0).unwrap_or_else(Vec3::x);
                push(i, way * depth, self.radii[i]);
                push(j, way * -depth, self.radii[j]);
                worst = worst.max(depth / self.radii[i].min(self.radii[j]));
                sum += 2.0 * depth;
            }
        }
        for (ball, centre) in self.centres.iter().enumerate() {
            let radius = self.radii[ball];
            let depth = radius - space.clearance(centre);
            if depth <= 0.0 {
                continue;
            }
            worst = worst.max(depth / radius);
            for (way, depth) in walls(space, centre, radius, depth) {
                push(ball, way * depth, radius);
                sum += depth;
            }
        }
        let left: f64 = pushes.iter().map(|push| push.force.norm()).sum();
        (pushes, worst, if sum > 0.0 { left / sum } else { 0.0 })
    }
}

/// The walls that a ball overlaps: unit vector inwards and depth.
fn walls(space: &Space, centre: &Vec3, radius: f64, depth: f64) -> Vec<(Vec3, f64)> {
    if space.region().is_some() {
        let inward = space.inward(centre, 1e-5 * radius);
        return inward.map(|way| (way, depth)).into_iter().collect();
    }
    let mut found = Vec::new();
    for axis in (0..space.dimension).filter(|&axis| !space.periodic[axis]) {
        let mut way = Vec3::zeros();
        way[axis] = 1.0;
        let low = radius - (centre[axis] - space.bounds.low[axis]);
        let high = radius - (space.bounds.high[axis] - centre[axis]);
        found.extend((low > 0.0).then_some((way, low)));
        found.extend((high > 0.0).then_some((-way, high)));
    }
    found
}
