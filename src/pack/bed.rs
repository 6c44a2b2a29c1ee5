//! Any set of spheres made ready for measuring (P18): a packing, a frame of a run, a dump of
//! another code. Who touches whom, who carries load, what lies near a place.
//!
//! Bodies may be clumps; their centre is here the mean of their spheres' centres weighted by
//! volume. Contacts between two bodies count once for the coordination number, each for
//! itself in the fabric. Cost O(n + near pairs), memory about 200 bytes a sphere.
//!
//! Rattlers: bodies with fewer than d + 1 contacts are taken out again and again (their contacts no longer count for
//! others); that is right without friction. With friction fewer contacts can hold a grain: the mechanical
//! coordination number (Thornton 2000, Géotechnique 50, 43), (2C − N₁)/(N − N₀ − N₁), leaves out only those
//! with none (N₀) and one (N₁).

use super::pairs::Pairs;
use super::probe::Probe;
use super::space::Space;
use crate::geometry::{BallGrid, Bounds};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};

/// A force at a contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Push {
    /// Sphere that it acts on.
    pub first: u32,
    /// Sphere that it comes from; none for a wall.
    pub second: Option<u32>,
    /// Where it acts, m.
    pub point: Vec3,
    /// On the first sphere, N.
    pub force: Vec3,
}

/// A contact of two spheres of different bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// One sphere.
    pub first: u32,
    /// The other.
    pub second: u32,
    /// Gap, m; negative: overlap.
    pub gap: f64,
    /// Unit vector from the second to the first.
    pub normal: Vec3,
    /// In the middle of gap or overlap, m.
    pub point: Vec3,
}

/// Spheres to be measured, as they come.
#[derive(Debug, Clone, Default)]
pub struct Spheres {
    /// Centres, m.
    pub centres: Vec<Vec3>,
    /// Radii, m.
    pub radii: Vec<f64>,
    /// Number of the body of each, from 0 without holes.
    pub body: Vec<u32>,
    /// 2 for discs, 3 for spheres.
    pub dimension: usize,
    /// The container, where it is a box; else the box around all spheres is measured.
    pub room: Option<Bounds>,
    /// Axes along which the room repeats.
    pub periodic: [bool; 3],
    /// Contact forces, where known.
    pub pushes: Vec<Push>,
}

/// Spheres made ready for measuring.
#[derive(Debug)]
pub struct Bed {
    /// Spheres.
    pub spheres: Spheres,
    /// The container, or the box around all spheres, m.
    pub room: Bounds,
    /// Gap up to which two bodies touch, m.
    pub tolerance: f64,
    /// Contacts between bodies.
    pub contacts: Vec<Contact>,
    /// Centre of each body, m.
    pub bodies: Vec<Vec3>,
    /// Number of other bodies that each body touches.
    pub partners: Vec<u32>,
    /// The same among those that are no rattlers; 0 for rattlers.
    pub held: Vec<u32>,
    /// For each sphere those that it overlaps, of its own body or another, and the way from them to it: rows
    /// `rows[i]..rows[i + 1]`.
    pub overlaps: Vec<(u32, Vec3)>,
    rows: Vec<u32>,
    grid: BallGrid,
    largest: f64,
}

/// Overlap that is rounding only, in radii.
const ROUNDING: f64 = 1e-9;

impl Bed {
    /// Makes `spheres` ready; bodies touch up to a gap of `tolerance` m.
    pub fn new(mut spheres: Spheres, tolerance: f64) -> Self {
        let dimension = spheres.dimension;
        let around = spheres
            .centres
            .iter()
            .zip(&spheres.radii)
            .fold(Bounds::EMPTY, |bounds, (centre, radius)| {
                bounds.union(&Bounds::of([centre]).grown(*radius))
            });
        let mut room = spheres.room.unwrap_or(around);
        if dimension == 2 {
            (room.low.z, room.high.z) = (-0.5, 0.5);
        }
        let largest = spheres.radii.iter().copied().fold(0.0, f64::max);
        // Spheres outside the room are neighbours too.
        let mut seen = room.union(&around);
        for axis in 0..3 {
            if spheres.periodic[axis] {
                (seen.low[axis], seen.high[axis]) = (room.low[axis], room.high[axis]);
            }
        }
        let space = Space::boxed(dimension, seen, spheres.periodic);
        for centre in &mut spheres.centres {
            *centre = space.wrap(centre);
        }
        let smallest = spheres.radii.iter().copied().fold(f64::INFINITY, f64::min);
        let mut grid = BallGrid::new(smallest);
        for (centre, radius) in spheres.centres.iter().zip(&spheres.radii) {
            grid.insert(*centre, *radius);
        }
        let bodies = body_centres(&spheres, &space);
        let mut bed = Self {
            room,
            tolerance,
            contacts: Vec::new(),
            partners: Vec::new(),
            held: Vec::new(),
            overlaps: Vec::new(),
            rows: Vec::new(),
            grid,
            largest,
            bodies,
            spheres,
        };
        bed.find_contacts(&space);
        bed.count_partners();
        bed
    }

    /// The space it lies in.
    pub fn space(&self) -> Space<'static> {
        Space::boxed(self.spheres.dimension, self.room, self.spheres.periodic)
    }

    /// The room without the sides that repeat: what cuts a probe.
    pub fn walls(&self) -> Bounds {
        let mut walls = self.room;
        for axis in (0..3).filter(|&axis| self.spheres.periodic[axis]) {
            (walls.low[axis], walls.high[axis]) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        walls
    }

    /// The image of `point` to look for inside `probe`.
    pub fn seen_from(&self, probe: &Probe, point: &Vec3) -> Vec3 {
        match probe {
            Probe::Ball { at, .. } => at + self.space().apart(point, at),
            Probe::Box(_) => self.space().wrap(point),
        }
    }

    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        self.spheres.dimension
    }

    fn find_contacts(&mut self, space: &Space) {
        let Spheres { centres, radii, body, .. } = &self.spheres;
        let mut pairs = Pairs::default();
        let mut found: Vec<(u32, u32, Vec3)> = Vec::new();
        pairs.find(space, centres, radii, 1.0, self.tolerance.max(0.0) * (1.0 + 1e-12));
        for pair in &pairs.list {
            let (i, j) = (pair.i as usize, pair.j as usize);
            let way = centres[i] - centres[j] + pairs.shifts[usize::from(pair.shift)];
            let distance = way.norm();
            let gap = distance - radii[i] - radii[j];
            if gap < -ROUNDING * radii[i].min(radii[j]) {
                found.push((pair.i, pair.j, way));
                found.push((pair.j, pair.i, -way));
            }
            if body[i] == body[j] || gap > self.tolerance {
                continue;
            }
            let normal = if distance > 0.0 { way / distance } else { Vec3::x() };
            let point = centres[i] - normal * (radii[i] + 0.5 * gap);
            self.contacts.push(Contact { first: pair.i, second: pair.j, gap, normal, point });
        }
        found.sort_unstable_by_key(|(i, j, _)| (*i, *j));
        self.rows = vec![0; radii.len() + 1];
        for (i, _, _) in &found {
            self.rows[*i as usize + 1] += 1;
        }
        for i in 0..radii.len() {
            self.rows[i + 1] += self.rows[i];
        }
        self.overlaps = found.into_iter().map(|(_, j, way)| (j, way)).collect();
    }

    /// The spheres that sphere `i` overlaps, and the way from them to it, m.
    pub fn overlapping(&self, i: usize) -> &[(u32, Vec3)] {
        &self.overlaps[self.rows[i] as usize..self.rows[i + 1] as usize]
    }

    /// True if some third sphere overlaps both of `i` and `j`.
    pub fn third(&self, i: usize, j: usize) -> bool {
        let others = self.overlapping(j);
        self.overlapping(i).iter().any(|(k, _)| others.iter().any(|(other, _)| other == k))
    }

    fn count_partners(&mut self) {
        let body = &self.spheres.body;
        let mut touching: Vec<(u32, u32)> = self
            .contacts
            .iter()
            .map(|contact| {
                let (a, b) = (body[contact.first as usize], body[contact.second as usize]);
                (a.min(b), a.max(b))
            })
            .collect();
        // Walls hold grains too, where forces tell of them.
        let mut walls = vec![0_u32; self.bodies.len()];
        for push in self.spheres.pushes.iter().filter(|push| push.second.is_none()) {
            walls[body[push.first as usize] as usize] += 1;
        }
        touching.sort_unstable();
        touching.dedup();
        let counts = |alive: &[bool]| {
            let mut counts = vec![0_u32; alive.len()];
            for &(a, b) in &touching {
                if alive[a as usize] && alive[b as usize] {
                    counts[a as usize] += 1;
                    counts[b as usize] += 1;
                }
            }
            counts
        };
        let mut alive = vec![true; self.bodies.len()];
        self.partners = counts(&alive);
        loop {
            let held = counts(&alive);
            let mut changed = false;
            for (body, alive) in alive.iter_mut().enumerate() {
                if *alive && (held[body] + walls[body]) as usize <= self.spheres.dimension {
                    (*alive, changed) = (false, true);
                }
            }
            if !changed {
                self.held = held;
                return;
            }
        }
    }

    /// Calls `visit` with the number of every sphere that reaches into the ball of `radius` about `at`, and
    /// the step by which its image there is shifted.
    pub fn near(&self, at: &Vec3, radius: f64, mut visit: impl FnMut(usize, Vec3)) {
        self.space().images(at, radius + self.largest, |image| {
            self.grid.near(image, radius, |sphere, _| {
                visit(sphere as usize, at - image);
                true
            })
        });
    }
}

fn body_centres(spheres: &Spheres, space: &Space) -> Vec<Vec3> {
    let count = spheres.body.iter().max().map_or(0, |last| *last as usize + 1);
    let mut sums = vec![(Vec3::zeros(), 0.0, None::<Vec3>); count];
    for ((centre, radius), body) in spheres.centres.iter().zip(&spheres.radii).zip(&spheres.body) {
        let weight = radius.powi(spheres.dimension as i32);
        let (sum, total, first) = &mut sums[*body as usize];
        // By the image nearest to the first sphere of the body.
        let anchor = *first.get_or_insert(*centre);
        *sum += space.apart(centre, &anchor) * weight;
        *total += weight;
    }
    sums.into_iter()
        .map(|(sum, total, first)| {
            first.unwrap_or_default() + sum / f64::max(total, f64::MIN_POSITIVE)
        })
        .collect()
}
