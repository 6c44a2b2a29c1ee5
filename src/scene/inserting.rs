//! Places and times of grains that come during the run, drawn before it.
//!
//! Grains of a family come one every 1/rate. Each gets a place uniform in its region, its bounding sphere inside;
//! grains that came before are taken to fly freely since (x + v t + g t²/2), packed ones to be where they are at
//! the start, and a place where the new one would overlap another is drawn anew.
//! What lies in the region later cannot be known here: the run ends where a place is taken.
//! O(grains that are still in flight in the region) a grain.

use super::Loaded;
use super::grains::Grain;
use super::parameters::InsertionParameters;
use super::walls;
use crate::clump::Clump;
use crate::geometry::{Bounds, Region};
use crate::num::random::{rotation, stream};
use crate::num::{Fault, Rotation, Vec3};
use crate::pack::Placement;

/// Draws for one grain.
const TRIES: u32 = 10_000;
/// Gap to other grains over the bounding radius.
const GAP: f64 = 1e-3;

/// A grain that comes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// What comes, where and how.
    pub placement: Placement,
    /// When, s.
    pub time: f64,
}

/// Whether single grains of the scene (by family) come during the run.
pub fn comes(loaded: &Loaded, family: u16) -> bool {
    loaded.scene.grains[family as usize].insertion.is_some()
}

/// A grain on its way, or a packed one.
struct Ball {
    place: Vec3,
    radius: f64,
    /// Time at which it was at `place`; `None`: it stays there.
    since: Option<(f64, Vec3)>,
}

impl Ball {
    fn at(&self, time: f64, gravity: &Vec3) -> Vec3 {
        self.since.map_or(self.place, |(since, velocity)| {
            let span = time - since;
            self.place + velocity * span + gravity * (0.5 * span * span)
        })
    }
}

/// All grains that come, in the order of time.
///
/// # Errors
/// A fault at the family whose region cannot be used, has no free place, or whose last grain would come after the end.
pub fn arrivals(
    loaded: &Loaded,
    grains: &[Grain],
    copies: &[u32],
    packed: &[Placement],
) -> Result<Vec<Arrival>, Fault> {
    let scene = &loaded.scene;
    let gravity = scene.gravity();
    let (queue, regions) = queue(loaded, grains, copies)?;
    let mut others: Vec<Ball> =
        if queue.is_empty() { Vec::new() } else { lying(grains, copies, packed) };
    let around =
        regions.iter().flatten().fold(Bounds::EMPTY, |all, region| all.union(&region.bounds()));
    let mut all = Vec::with_capacity(queue.len());
    for Coming { time, copy, index } in queue {
        let number = family_of(grains, copies, copy);
        let family = &scene.grains[number];
        let (Some(insertion), Some(region)) = (&family.insertion, &regions[number]) else {
            continue;
        };
        let radius = grains[copies[copy] as usize].clump.bounding_radius();
        // Who has left all regions is out of the way.
        others.retain(|ball| {
            let reach = 2.0 * (ball.radius + radius);
            let (place, room) = (ball.at(time, &gravity), around.grown(reach));
            ball.since.is_none() || (0..3).all(|k| (room.low[k]..=room.high[k]).contains(&place[k]))
        });
        let mut source = stream(scene.seed, &format!("insert {}", family.name), index as u64);
        let free = |place: &Vec3| {
            region.clearance(place) >= radius
                && others.iter().all(|ball| {
                    (ball.at(time, &gravity) - place).norm() >= (ball.radius + radius) * (1.0 + GAP)
                })
        };
        let place = (0..TRIES).filter_map(|_| region.sample(&mut source)).find(free);
        let Some(position) = place else {
            let problem =
                format!("has no free place for grain {index} of `{}` at {time} s", family.name);
            let allowed = "a larger region, a lower rate, or a faster start away from it";
            return Err(Fault::new("insert", problem, allowed).under(format!("grains[{number}]")));
        };
        let velocity = Vec3::from(insertion.velocity.map(|v| v.0));
        let balls = grains[copies[copy] as usize].clump.balls.len();
        let orientation = if balls > 1 { rotation(&mut source) } else { Rotation::identity() };
        let placement = placed(copy, position, orientation, velocity, insertion);
        others.push(Ball { place: position, radius, since: Some((time, velocity)) });
        all.push(Arrival { placement, time });
    }
    Ok(all)
}

/// A grain whose time is known and whose place is not.
struct Coming {
    time: f64,
    /// Index into `copies`.
    copy: usize,
    /// Number within its family.
    index: usize,
}

/// All grains that come, in the order of time, and the region of each family that comes.
fn queue(
    loaded: &Loaded,
    grains: &[Grain],
    copies: &[u32],
) -> Result<(Vec<Coming>, Vec<Option<Region>>), Fault> {
    let scene = &loaded.scene;
    let mut queue: Vec<Coming> = Vec::new();
    let mut regions = Vec::new();
    for (number, family) in scene.grains.iter().enumerate() {
        let Some(insertion) = &family.insertion else {
            regions.push(None);
            continue;
        };
        let here = |fault: Fault| fault.under("insert").under(format!("grains[{number}]"));
        let region = walls::resolve(&insertion.region, loaded)
            .map_err(|fault| here(fault.under("region")))?;
        regions.push(Some(region));
        let own = (0..copies.len()).filter(|copy| family_of(grains, copies, *copy) == number);
        let first = queue.len();
        queue.extend(own.enumerate().map(|(index, copy)| Coming {
            time: insertion.time(index),
            copy,
            index,
        }));
        let last = queue[first..].last().map_or(0.0, |coming| coming.time);
        if last > scene.plan.duration.0 {
            let problem = format!("lets the last grain come at {last} s, after the end");
            let allowed = format!("a higher rate, fewer grains, or a duration above {last} s");
            return Err(here(Fault::new("rate", problem, allowed)));
        }
    }
    queue.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.copy.cmp(&b.copy)));
    Ok((queue, regions))
}

fn family_of(grains: &[Grain], copies: &[u32], copy: usize) -> usize {
    grains[copies[copy] as usize].family as usize
}

fn placed(
    copy: usize,
    position: Vec3,
    orientation: Rotation,
    velocity: Vec3,
    insertion: &InsertionParameters,
) -> Placement {
    let spin = Vec3::from(insertion.spin.map(|w| w.0));
    Placement { grain: copy as u32, position, orientation, velocity, spin, scale: 1.0 }
}

/// Bounding spheres of packed grains.
fn lying(grains: &[Grain], copies: &[u32], packed: &[Placement]) -> Vec<Ball> {
    let reach = |clump: &Clump, scale: f64| scale * clump.bounding_radius();
    packed
        .iter()
        .map(|laid| Ball {
            place: laid.position,
            radius: reach(&grains[copies[laid.grain as usize] as usize].clump, laid.scale),
            since: None,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clump;
    use std::path::Path;

    fn scene(insert: &str) -> Loaded {
        let text = format!(
            "title = \"x\"\nseed = 3\n[[grains]]\nname = \"there\"\ncount = 1\nsize = 0.02\nshape = \"sphere\"\n\
             [[grains]]\nname = \"late\"\ncount = 20\nsize = 0.02\nshape = \"sphere\"\ninsert = {{ {insert} }}\n\
             [materials.glass]\ndensity = 2500.0\n[contact]\nkn = 1e5\n[packing.placed]\nbodies = []\n\
             [plan]\nduration = 1.0\n"
        );
        Loaded::parse(Path::new("scene.toml"), text).expect("a scene")
    }

    const REGION: &str = "region.box = { low = [0, 0, 0.5], high = [0.05, 0.05, 0.55] }";

    fn drawn(insert: &str) -> Result<Vec<Arrival>, Fault> {
        let ball = |family| Grain { family, solid: None, clump: clump::sphere("ball", 0.01) };
        let copies: Vec<u32> = std::iter::once(0).chain([1; 20]).collect();
        let there = Placement {
            grain: 0,
            position: Vec3::new(0.01, 0.01, 0.5),
            orientation: Rotation::identity(),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            scale: 1.0,
        };
        arrivals(&scene(insert), &[ball(0), ball(1)], &copies, &[there])
    }

    #[test]
    fn they_come_in_time_inside_and_clear_of_each_other() {
        let insert = format!("rate = 40.0, start = 0.1, velocity = [0, 0, -1], {REGION}");
        let all = drawn(&insert).expect("drawn");
        assert_eq!(all, drawn(&insert).expect("drawn"));
        assert_eq!(all.len(), 20);
        for (k, one) in all.iter().enumerate() {
            assert!((one.time - (0.1 + k as f64 / 40.0)).abs() < 1e-12);
            let place = one.placement.position;
            assert!((0.01..=0.04).contains(&place.x) && (0.51..=0.54).contains(&place.z));
            assert!((place - Vec3::new(0.01, 0.01, 0.5)).norm() >= 0.02, "clear of what is packed");
            for earlier in &all[..k] {
                let (from, span) = (earlier.placement, one.time - earlier.time);
                let now = from.position
                    + from.velocity * span
                    + Vec3::new(0.0, 0.0, -9.81) * (0.5 * span * span);
                assert!((now - place).norm() >= 0.02, "{k}");
            }
        }
    }

    #[test]
    fn what_cannot_be_is_said() {
        let slow = drawn(&format!("rate = 10.0, {REGION}")).expect_err("after the end");
        assert!(slow.to_string().contains("after the end"), "{slow}");
        let crowded = drawn(&format!("rate = 1e6, {REGION}")).expect_err("no room");
        assert!(crowded.to_string().contains("no free place"), "{crowded}");
    }
}
