//! Packing by control points (P8): bodies of surface points that move along random unit vectors.
//!
//! Source: Sajjadi & Khalili 2015. (1) Every body is its surface points, of the true
//! shape or of its clump. (2) Each sweep a body moves along a random unit vector, in any direction, or turns;
//! (3) its points go with it; (4) two bodies collide when some pair of their points is nearer than the user's
//! distance d, and then the body stays where it was. Gravity: the unit vectors lean
//! down, u = (e + b g)/|e + b g| with e uniform on the sphere, g down, b the bias. Vibration:
//! after a collision, with a probability, some moves that lean up.
//!
//! What points can see: with the covering radius c of the points (measured), surfaces that meet have points
//! nearer than 2c. d = 2c or more (the default is 2.05 c) therefore lets nothing into
//! anything; a smaller d may, and a larger one keeps bodies apart. The gap that stays, about d,
//! costs density by about (1 + d/D)^-3; more points make it smaller. Points moved inside by
//! `inset` give it back, up to touching at d/2, at the price of overlaps up to d. Steps are no
//! longer than d, so that nothing is jumped over. Points keep d/2 from the walls.
//! What came out is measured on the true forms, independently of the points. Sides may repeat, the vertical ones
//! only without gravity.
//!
//! Cost a move: O(near bodies · groups of points), see `points.rs`. Grains without a place are dropped.

use super::forms::{Form, Forms};
use super::occupied::placement;
use super::penetration;
use super::points::{Near, Points};
use super::random::Test;
use super::walk::{Insertion, Schedule, Wanderers, walk};
use super::{Grain, Laid, Turn, tally};
use crate::geometry::{BallGrid, Cell, Region, SignedDistance};
use crate::num::random::{Stream, direction, stream, uniform};
use crate::num::units::Length;
use crate::num::{Fault, Job, Rotation, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of packing by control points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ControlPoints {
    /// Points on each body, 12 to 100 000; default 500.
    pub points: u32,
    /// Distance d between points of two bodies at which they collide, m, greater than 0; default 2.05 times the
    /// largest covering radius, the least that sees every touch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<Length>,
    /// Depth of the points below the surface, m, 0 or more and less than d; half of d makes
    /// surfaces touch where points face each other. Default 0.
    pub inset: Length,
    /// What is packed: `clump` (default) its spheres, `solid` the true shape.
    pub test: Test,
    /// Longest step over d, above 0 to 1; the length of a step is uniform up to it. Default 1.
    pub step: f64,
    /// How far the unit vectors lean down (b), 0 (no gravity) to 100; default 1.
    pub gravity: f64,
    /// Shaking; default 4 moves up after one collision in 20.
    pub vibration: Vibration,
    /// Probability that a body turns in place of a move, 0 to 1; round ones never do. Default 0.3.
    pub turning: f64,
    /// Where grains come in; default `anywhere`.
    pub insertion: Insertion,
    /// Grains that try to come in during a sweep, 1 or more; default 100.
    pub rate: u32,
    /// Sweeps at most, 1 to 100 000 000; default 5000.
    pub sweeps: u32,
    /// Fall of the mean height in 100 sweeps at which the bed counts as settled, over the
    /// smallest equivalent diameter, 0 or more; default 0.005.
    pub settled: f64,
    /// How grains are turned when they come in; default `random`.
    pub orientation: Turn,
}

/// Bursts of moves that lean up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Vibration {
    /// Moves of a burst, 0 to 10 000; default 4.
    pub moves: u32,
    /// Probability that a collision starts one, 0 to 1; default 0.05.
    pub probability: f64,
}

impl Default for Vibration {
    fn default() -> Self {
        Self { moves: 4, probability: 0.05 }
    }
}

impl Default for ControlPoints {
    fn default() -> Self {
        Self {
            points: 500,
            distance: None,
            inset: Length(0.0),
            test: Test::Clump,
            step: 1.0,
            gravity: 1.0,
            vibration: Vibration::default(),
            turning: 0.3,
            insertion: Insertion::Anywhere,
            rate: 100,
            sweeps: 5000,
            settled: 0.005,
            orientation: Turn::Random,
        }
    }
}

/// The default distance over the covering radius: 2 and what the measured radius may miss.
const SEEN: f64 = 2.05;

impl ControlPoints {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("points", f64::from(self.points), 12.0, 1e5)?;
        if let Some(distance) = self.distance
            && !(distance.0.is_finite() && distance.0 > 0.0)
        {
            let allowed = "a length above 0 (points of two bodies never meet exactly), or none for the \
                least that sees every touch; with `inset` = half of it surfaces touch";
            return Err(Fault::new("distance", format!("is {} m", distance.0), allowed));
        }
        Fault::not_negative("inset", self.inset.0)?;
        Fault::positive("step", self.step)?;
        Fault::within("step", self.step, 0.0, 1.0)?;
        Fault::within("gravity", self.gravity, 0.0, 100.0)?;
        Fault::within("vibration.moves", f64::from(self.vibration.moves), 0.0, 1e4)?;
        Fault::within("vibration.probability", self.vibration.probability, 0.0, 1.0)?;
        Fault::within("turning", self.turning, 0.0, 1.0)?;
        Fault::within("rate", f64::from(self.rate), 1.0, f64::from(u32::MAX))?;
        Fault::within("sweeps", f64::from(self.sweeps), 1.0, 1e8)?;
        Fault::not_negative("settled", self.settled)
    }

    /// Points of each form, their largest covering radius, and d.
    fn prepared(
        &self,
        forms: &Forms,
        dimension: usize,
        seed: u64,
    ) -> Result<(Vec<Points>, f64, f64), Fault> {
        let mut all = Vec::with_capacity(forms.distinct.len());
        for (index, shaped) in forms.distinct.iter().enumerate() {
            let mut source = stream(seed, "pack.points", index as u64);
            let points =
                Points::new(shaped, self.points as usize, self.inset.0, dimension, &mut source);
            all.push(points.ok_or_else(|| {
                let problem = format!("is {} m: no point of a grain lies so deep", self.inset.0);
                Fault::new("control_points.inset", problem, "less")
            })?);
        }
        let covering = all.iter().map(|points| points.covering).fold(0.0, f64::max);
        let distance = self.distance.map_or(SEEN * covering, |given| given.0);
        if self.inset.0 >= distance {
            let problem =
                format!("is {} m, not less than the distance {distance:.4e} m", self.inset.0);
            return Err(Fault::new("control_points.inset", problem, "half of `distance` or less"));
        }
        Ok((all, covering, distance))
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let dimension = region.dimension();
        let forms = Forms::fitting(grains, self.test, region, "control_points")?;
        if grains.is_empty() {
            return Ok(Laid::nothing());
        }
        let (points, covering, distance) = self.prepared(&forms, dimension, seed)?;
        let reach = points.iter().map(|points| points.radius).fold(0.0, f64::max);
        super::fits_its_images(region, reach + 0.5 * distance)?;
        let mut bed = Bed::new(self, grains, &forms, region, &points, distance);
        let schedule = Schedule {
            sweeps: u64::from(self.sweeps),
            rate: u64::from(self.rate),
            settled: self.settled * forms.smallest(),
            gravity: self.gravity > 0.0,
        };
        let mut source = stream(seed, "pack.control_points", 0);
        let walked = walk(&mut bed, grains.len(), &schedule, &mut source, job);
        let mut placements = Vec::with_capacity(grains.len());
        let mut grown = 0.0;
        for (grain, place) in bed.places.iter().enumerate() {
            let Some(at) = place else { continue };
            placements.push(placement(grain, *at, Vec3::zeros()));
            let shaped = forms.shaped(grain);
            let gap = (distance - 2.0 * self.inset.0).max(0.0);
            grown += shaped.volume * (1.0 + gap / shaped.diameter).powi(dimension as i32);
        }
        let dropped: Vec<u32> = walked.outside.iter().map(|&grain| grain as u32).collect();
        let report = penetration::check(&placements, grains, self.test, region, seed);
        let seen = match distance >= 2.0 * covering && self.inset.0 == 0.0 {
            true => "nothing enters anything unseen",
            false => "overlaps are possible and measured",
        };
        let outcome = format!(
            "{} after {} sweeps, {:.1} % of the moves collided; {}; sizes as wanted; {} points a body, covering radius {covering:.4e} m, distance {distance:.4e} m ({seen}); grains grown by the distance would fill {:.4} of the container; {report}",
            walked.end,
            walked.sweeps,
            100.0 * bed.collisions as f64 / bed.moves.max(1) as f64,
            tally(grains, &placements, &dropped, "no free place came up"),
            self.points,
            grown / region.volume(),
        );
        Ok(Laid { placements, dropped, outcome })
    }
}

type Place = (Vec3, Rotation);

struct Bed<'a> {
    parameters: &'a ControlPoints,
    grains: &'a [Grain<'a>],
    forms: &'a Forms,
    region: &'a Region,
    /// How space repeats itself.
    cell: Option<Cell>,
    points: &'a [Points],
    near: Vec<Near>,
    /// Of each form, for the question whether one body holds another whole.
    inside: Vec<Option<SignedDistance>>,
    distance: f64,
    places: Vec<Option<Place>>,
    /// Moves up that are left of a burst.
    bursts: Vec<u32>,
    /// Bodies that may come near before lists are found again.
    neighbours: Vec<Vec<u32>>,
    listed_at: Vec<Vec3>,
    stale: bool,
    skin: f64,
    /// Depth of the layer that rain comes in through, m.
    layer: f64,
    moves: u64,
    collisions: u64,
}

impl<'a> Bed<'a> {
    fn new(
        parameters: &'a ControlPoints,
        grains: &'a [Grain<'a>],
        forms: &'a Forms,
        region: &'a Region,
        points: &'a [Points],
        distance: f64,
    ) -> Self {
        let inside = |shaped: &super::forms::Shaped| match &shaped.form {
            Form::Surface(mesh) => SignedDistance::new(mesh).ok(),
            Form::Balls(_) => None,
        };
        let largest = points.iter().map(|points| points.radius).fold(0.0, f64::max);
        let count = grains.len();
        Self {
            parameters,
            grains,
            forms,
            region,
            cell: region.cell(),
            points,
            near: points.iter().map(|points| Near::new(&points.points, distance)).collect(),
            inside: forms.distinct.iter().map(inside).collect(),
            distance,
            places: vec![None; count],
            bursts: vec![0; count],
            neighbours: vec![Vec::new(); count],
            listed_at: vec![Vec3::zeros(); count],
            stale: true,
            skin: 0.5 * largest + 4.0 * distance,
            layer: 4.0 * largest,
            moves: 0,
            collisions: 0,
        }
    }

    fn form(&self, grain: usize) -> usize {
        self.forms.of[grain] as usize
    }

    /// True if all points of `grain` keep half the distance from the walls.
    fn clear_of_walls(&self, grain: usize, at: &Place) -> bool {
        let points = &self.points[self.form(grain)];
        let least = 0.5 * self.distance;
        let room = self.region.clearance(&at.0);
        room >= points.radius + least
            || points.points.iter().all(|p| self.region.clearance(&(at.0 + at.1 * p)) >= least)
    }

    /// The place of `other`, or that of its image nearest to `at`.
    fn seen_from(&self, at: &Place, other: usize) -> Option<Place> {
        let there = self.places[other]?;
        Some(match &self.cell {
            Some(cell) => (at.0 + cell.way(&(there.0 - at.0)), there.1),
            None => there,
        })
    }

    fn collide(&self, grain: usize, at: &Place, other: usize) -> bool {
        let Some(there) = &self.seen_from(at, other) else { return false };
        let (mine, theirs) = (self.form(grain), self.form(other));
        let reach = self.points[mine].radius + self.points[theirs].radius + self.distance;
        (at.0 - there.0).norm_squared() < reach * reach
            && self.points[mine].meet(at, &self.near[theirs], there)
    }

    /// Finds the lists again if a body has moved by half the skin, or came in.
    fn refresh(&mut self, moved: usize) {
        let Some(at) = &self.places[moved] else { return };
        let way = at.0 - self.listed_at[moved];
        let way = self.cell.map_or(way, |cell| cell.way(&way));
        let far = way.norm_squared() > (0.5 * self.skin).powi(2);
        if !far && !self.stale {
            return;
        }
        let smallest = self.points.iter().map(|p| p.radius).fold(f64::INFINITY, f64::min);
        let largest = self.points.iter().map(|p| p.radius).fold(0.0, f64::max);
        let mut grid = BallGrid::new(smallest.max(1e-9 * self.skin));
        let mut order = Vec::new();
        for (grain, place) in self.places.iter().enumerate() {
            let Some(at) = place else { continue };
            grid.insert(at.0, self.points[self.form(grain)].radius);
            order.push(grain);
            self.listed_at[grain] = at.0;
        }
        for &grain in &order {
            let reach = self.points[self.form(grain)].radius + self.distance + self.skin;
            let mut list = std::mem::take(&mut self.neighbours[grain]);
            list.clear();
            let mut look = |place: &Vec3| {
                grid.near(place, reach, |number, _| {
                    let other = order[number as usize];
                    if other != grain {
                        list.push(other as u32);
                    }
                    true
                });
            };
            let place = self.listed_at[grain];
            look(&place);
            if let Some(cell) = &self.cell {
                cell.images(&place, reach + largest, |way| look(&(place + way)));
            }
            list.sort_unstable();
            list.dedup();
            self.neighbours[grain] = list;
        }
        self.stale = false;
    }

    /// Moves `grain` there if nothing is in the way.
    fn try_place(&mut self, grain: usize, at: Place) -> bool {
        self.moves += 1;
        let hit = !self.clear_of_walls(grain, &at)
            || self.neighbours[grain].iter().any(|&other| self.collide(grain, &at, other as usize));
        if hit {
            self.collisions += 1;
            return false;
        }
        let home = self.cell.map_or(at.0, |cell| at.0 + cell.home(&at.0));
        self.places[grain] = Some((home, at.1));
        true
    }

    /// A unit vector, level in two dimensions, that leans along `lean`.
    fn way(&self, lean: f64, source: &mut Stream) -> Vec3 {
        let dimension = self.region.dimension();
        let mut way = match dimension {
            2 => {
                let (sin, cos) = uniform(source, 0.0, std::f64::consts::TAU).sin_cos();
                Vec3::new(cos, sin, 0.0)
            }
            _ => direction(source),
        };
        way[dimension - 1] += lean;
        way.try_normalize(1e-12).unwrap_or_else(Vec3::zeros)
    }

    fn turned(&self, grain: usize, at: &Place, longest: f64, source: &mut Stream) -> Place {
        // No point goes farther than a step.
        let angle = (longest / self.points[self.form(grain)].radius).min(0.5);
        let turn = match self.region.dimension() {
            2 => Vec3::z() * uniform(source, -angle, angle),
            _ => direction(source) * uniform(source, 0.0, angle),
        };
        let mut orientation = Rotation::from_scaled_axis(turn) * at.1;
        orientation.renormalize();
        (at.0, orientation)
    }

    /// True if one body holds the other whole, so that no points are near.
    fn nested(&self, grain: usize, at: &Place, other: usize) -> bool {
        let Some(there) = &self.seen_from(at, other) else { return false };
        let holds = |body: usize, place: &Place, point: Vec3| {
            let local = place.1.inverse_transform_vector(&(point - place.0));
            match (&self.forms.shaped(body).form, &self.inside[self.form(body)]) {
                (Form::Surface(_), Some(distance)) => distance.at(&local) < 0.0,
                (Form::Balls(balls), _) => {
                    balls.iter().any(|ball| (local - ball.centre).norm() < ball.radius)
                }
                _ => false,
            }
        };
        let some =
            |body: usize, place: &Place| place.0 + place.1 * self.points[self.form(body)].points[0];
        holds(other, there, some(grain, at)) || holds(grain, at, some(other, there))
    }
}

impl Wanderers for Bed<'_> {
    fn enter(&mut self, grain: usize, source: &mut Stream) -> bool {
        let dimension = self.region.dimension();
        let turn = self.parameters.orientation.draw(&self.grains[grain], dimension, source);
        let mut bounds = self.region.bounds();
        if self.parameters.insertion == Insertion::Top {
            let up = dimension - 1;
            bounds.low[up] = bounds.low[up].max(bounds.high[up] - self.layer);
        }
        let Some(centre) = self.region.sample_within(&bounds, source) else { return false };
        let at = (centre, turn);
        let free = self.clear_of_walls(grain, &at)
            && (0..self.places.len()).all(|other| {
                let Some(there) = &self.seen_from(&at, other) else { return true };
                let reach = self.forms.shaped(grain).radius + self.forms.shaped(other).radius;
                let apart = (there.0 - at.0).norm_squared() > (reach + self.distance).powi(2);
                apart || !self.collide(grain, &at, other) && !self.nested(grain, &at, other)
            });
        if free {
            self.places[grain] = Some(at);
            self.stale = true;
        }
        free
    }

    fn stir(&mut self, grain: usize, cold: bool, source: &mut Stream) {
        self.refresh(grain);
        let Some(at) = self.places[grain] else { return };
        let longest = self.parameters.step * self.distance;
        let turns = self.parameters.turning > 0.0
            && !self.forms.shaped(grain).is_round()
            && uniform(source, 0.0, 1.0) < self.parameters.turning;
        let next = if turns {
            self.turned(grain, &at, longest, source)
        } else {
            let burst = !cold && self.bursts[grain] > 0;
            let lean = if burst { 1.0 } else { -self.parameters.gravity };
            self.bursts[grain] = self.bursts[grain].saturating_sub(1);
            let mut way = self.way(lean, source);
            let up = self.region.dimension() - 1;
            if cold {
                way[up] = -way[up].abs();
            }
            (at.0 + way * uniform(source, 0.0, longest), at.1)
        };
        let Vibration { moves, probability } = self.parameters.vibration;
        let moved = self.try_place(grain, next);
        if !moved && !cold && moves > 0 && uniform(source, 0.0, 1.0) < probability {
            self.bursts[grain] = moves;
        }
    }

    fn height(&self, grain: usize) -> f64 {
        self.places[grain].map_or(0.0, |at| at.0[self.region.dimension() - 1])
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{
        brute_force, crossing_solids, dumbbell, of, periodic_room, room, solid, sphere,
    };
    use super::super::{Method, Packing, pack};
    use super::*;
    use crate::clump::Clump;
    use crate::geometry::region::MeshRegion;
    use crate::geometry::samples::{icosphere, l_mesh};

    fn lay(grains: &[Grain], region: &Region, parameters: ControlPoints, seed: u64) -> Packing {
        pack(grains, &[], region, &Method::ControlPoints(parameters), seed, &Job::quiet())
            .expect("right parameters")
    }

    fn quick(sweeps: u32) -> ControlPoints {
        ControlPoints { points: 60, sweeps, ..ControlPoints::default() }
    }

    #[test]
    fn the_default_distance_lets_nothing_into_anything() {
        for (region, size) in [(room(&[1.0; 3]), 0.1), (room(&[1.0, 1.0]), 0.05)] {
            let dimension = region.dimension();
            let mut clumps: Vec<Clump> = vec![sphere(size, dimension); 15];
            clumps.extend(vec![dumbbell(0.7 * size, size); 15]);
            let grains = of(&clumps);
            let packing = lay(&grains, &region, quick(200), 3);
            assert!(packing.placements.len() > 20, "{}", packing.outcome);
            let (gap, wall) = brute_force(&packing, &grains, &region);
            assert!(gap > 0.0 && wall > 0.0, "{gap} {wall} {}", packing.outcome);
            assert!(packing.outcome.contains("no two bodies overlap"), "{}", packing.outcome);
            assert_eq!(packing, lay(&grains, &region, quick(200), 3));
        }
    }

    #[test]
    fn true_shapes_settle_in_a_closed_surface() {
        let (clump, solid) = solid(l_mesh().mapped(|v| v * 0.1));
        let size = solid.mesh.bounds().diagonal();
        let grains = vec![Grain { clump: &clump, solid: Some(&solid), family: 0 }; 8];
        let ball = icosphere(2).mapped(|v| v * (1.2 * size));
        let region = Region::Mesh(Box::new(MeshRegion::new(ball).expect("closed")));
        let packing = lay(&grains, &region, ControlPoints { test: Test::Solid, ..quick(60) }, 2);
        assert!(packing.placements.len() > 2, "{}", packing.outcome);
        assert!(packing.outcome.contains("no two bodies overlap"), "{}", packing.outcome);
    }

    #[test]
    fn true_shapes_lie_across_sides_that_repeat() {
        let (clump, solid) = solid(l_mesh().mapped(|v| v * 0.1));
        let edge = 6.0
            * solid.mesh.vertices.iter().map(|v| (v - clump.centroid).norm()).fold(0.0, f64::max);
        let grains = vec![Grain { clump: &clump, solid: Some(&solid), family: 0 }; 24];
        // Sides of which no whole number of cells fits both.
        let region = periodic_room(&[edge, 1.137 * edge, 2.0 * edge], [true, true, false]);
        let packing = lay(&grains, &region, ControlPoints { test: Test::Solid, ..quick(60) }, 2);
        assert!(packing.placements.len() > 12, "{}", packing.outcome);
        assert!(packing.outcome.contains("no two bodies overlap"), "{}", packing.outcome);
        assert_eq!(crossing_solids(&packing, &solid, &clump, &region), 0, "{}", packing.outcome);
        let high =
            |axis: usize| packing.placements.iter().map(|p| p.position[axis]).fold(0.0, f64::max);
        assert!(high(0) > 0.9 * edge && high(1) > 0.9 * 1.137 * edge && high(2) < 1.9 * edge);
        let tight = periodic_room(&[0.65 * edge, edge, edge], [true, false, false]);
        let method = Method::ControlPoints(ControlPoints { test: Test::Solid, ..quick(60) });
        let refused =
            pack(&grains, &[], &tight, &method, 1, &Job::quiet()).expect_err("meets itself");
        assert!(refused.to_string().contains("too short along x"), "{refused}");
    }

    #[test]
    fn gravity_lowers_the_bed_and_points_inside_bring_bodies_closer() {
        let clumps = vec![sphere(0.1, 3); 16];
        let grains = of(&clumps);
        let region = room(&[0.9, 0.9, 1.8]);
        let mean = |packing: &Packing| {
            let sum: f64 = packing.placements.iter().map(|p| p.position.z).sum();
            sum / packing.placements.len() as f64
        };
        let floating = lay(&grains, &region, ControlPoints { gravity: 0.0, ..quick(400) }, 5);
        assert!(floating.outcome.starts_with("all grains are in"), "{}", floating.outcome);
        let settled = lay(&grains, &region, quick(600), 5);
        assert!(mean(&settled) < 0.75 * mean(&floating), "{}", settled.outcome);
        let closer =
            ControlPoints { distance: Some(Length(0.06)), inset: Length(0.03), ..quick(600) };
        let closer = lay(&grains, &region, closer, 5);
        assert!(mean(&closer) < mean(&settled), "{} {}", closer.outcome, settled.outcome);
    }

    #[test]
    fn wrong_input_is_refused_before_work() {
        let fault =
            |p: ControlPoints| Method::ControlPoints(p).validate().expect_err("is wrong").key;
        let base = ControlPoints::default;
        let key = |name: &str| format!("control_points.{name}");
        assert_eq!(fault(ControlPoints { turning: 1.5, ..base() }), key("turning"));
        let wild = Vibration { probability: 2.0, ..Vibration::default() };
        assert_eq!(
            fault(ControlPoints { vibration: wild, ..base() }),
            key("vibration.probability")
        );
        assert_eq!(fault(ControlPoints { distance: Some(Length(0.0)), ..base() }), key("distance"));
        assert_eq!(fault(ControlPoints { step: 1.5, ..base() }), key("step"));
        let clumps = [sphere(0.6, 3)];
        let method = Method::ControlPoints(base());
        let refused = pack(&of(&clumps), &[], &room(&[1.0; 3]), &method, 1, &Job::quiet());
        assert!(refused.expect_err("too large").to_string().contains("fits in no orientation"));
    }
}
