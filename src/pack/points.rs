//! Control points: a form as points of its surface, and whether points of another body come near them.
//!
//! Points are chosen farthest first (Gonzalez 1985) among many random ones, so that they are spread evenly and their
//! covering radius c is known: no point of the surface is farther than c from a control
//! point. Two surfaces that meet have control points nearer than 2c: a distance of 2c or
//! more lets no body into another unseen.
//!
//! A query goes through cells of the body frame that list the points within the distance of any of their
//! places; a group of points is passed over when its ball stays clear of all points by a coarse distance
//! field. O(points of the group that is near) instead of O(points · points).

use super::forms::{Form, Shaped};
use crate::geometry::distance::sample_surface;
use crate::geometry::{Bounds, SignedDistance};
use crate::num::random::{Stream, direction, uniform};
use crate::num::{Rotation, Vec3};

/// Random points a control point is chosen from.
const CHOICE: usize = 6;
/// Points of a group.
const GROUP: usize = 16;

/// Control points of one form, in the body frame.
pub struct Points {
    /// m.
    pub points: Vec<Vec3>,
    /// Largest distance of a point of the surface from the nearest control point, m, measured at random points.
    pub covering: f64,
    /// Largest distance of a control point from the centre of mass, m.
    pub radius: f64,
    groups: Vec<Group>,
}

/// Points `from..to` lie in a ball.
struct Group {
    centre: Vec3,
    radius: f64,
    from: u32,
    to: u32,
}

/// Cells about the points of one form.
pub struct Near {
    points: Vec<Vec3>,
    distance: f64,
    low: Vec3,
    edge: f64,
    size: [usize; 3],
    starts: Vec<u32>,
    listed: Vec<u32>,
    /// Of each coarse cell, a distance that no point is nearer than from any place in it, m.
    coarse: Vec<f32>,
    coarse_edge: f64,
    coarse_size: [usize; 3],
    bounds: Bounds,
}

impl Points {
    /// `count` points on the surface of a form (a circle of discs in two dimensions), moved in by `inset` m.
    /// `None` if none remain, as for a form thinner than the inset.
    pub fn new(
        shaped: &Shaped,
        count: usize,
        inset: f64,
        dimension: usize,
        source: &mut Stream,
    ) -> Option<Self> {
        let choice = candidates(shaped, count * CHOICE, inset, dimension, source);
        if choice.is_empty() {
            return None;
        }
        let points = farthest_first(&choice, count);
        let probes = candidates(shaped, count * CHOICE, inset, dimension, source);
        let mut sorted = grouped(points);
        let nearest = |p: &Vec3, all: &[Vec3]| {
            all.iter().map(|q| (p - q).norm_squared()).fold(f64::INFINITY, f64::min)
        };
        let covering = probes.iter().map(|p| nearest(p, &sorted.0)).fold(0.0, f64::max).sqrt();
        let radius = sorted.0.iter().map(|p| p.norm()).fold(0.0, f64::max);
        let groups = std::mem::take(&mut sorted.1);
        Some(Self { points: sorted.0, covering, radius, groups })
    }

    /// True if a point of this form at `at` is nearer than the distance of `near` to a point of the
    /// form behind it, which is at `there`.
    pub fn meet(&self, at: &(Vec3, Rotation), near: &Near, there: &(Vec3, Rotation)) -> bool {
        let back = there.1.inverse();
        let turn = (back * at.1).to_rotation_matrix();
        let shift = back * (at.0 - there.0);
        self.groups.iter().any(|group| {
            let centre = turn * group.centre + shift;
            near.may_meet(&centre, group.radius)
                && self.points[group.from as usize..group.to as usize]
                    .iter()
                    .any(|point| near.meets(&(turn * point + shift)))
        })
    }
}

/// Random points of the surface.
fn candidates(
    shaped: &Shaped,
    count: usize,
    inset: f64,
    dimension: usize,
    source: &mut Stream,
) -> Vec<Vec3> {
    match &shaped.form {
        Form::Balls(balls) => {
            let area: f64 = balls.iter().map(|ball| ball.radius.powi(dimension as i32 - 1)).sum();
            let mut found = Vec::new();
            for (index, ball) in balls.iter().enumerate() {
                let radius = ball.radius - inset;
                let share = ball.radius.powi(dimension as i32 - 1) / area;
                let mine = ((share * count as f64).ceil() as usize).max(8);
                for number in 0..mine {
                    let ray = match dimension {
                        2 => {
                            let turn = (number as f64 + uniform(source, 0.0, 1.0)) / mine as f64;
                            let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
                            Vec3::new(cos, sin, 0.0)
                        }
                        _ => direction(source),
                    };
                    let point = ball.centre + ray * radius;
                    let hidden = balls.iter().enumerate().any(|(other, b)| {
                        other != index
                            && (point - b.centre).norm() < (b.radius - inset) * (1.0 - 1e-9)
                    });
                    if radius > 0.0 && !hidden {
                        found.push(point);
                    }
                }
            }
            found
        }
        Form::Surface(mesh) => {
            let spread = sample_surface(mesh, count, source);
            if inset <= 0.0 {
                let corners = mesh.vertices.iter().take(count).copied();
                return corners.chain(spread.into_iter().map(|p| p.point)).collect();
            }
            let Ok(distance) = SignedDistance::new(mesh) else { return Vec::new() };
            let moved = spread.into_iter().map(|p| p.point - p.normal * inset);
            // Where the form is thinner than twice the inset, the other side is nearer.
            moved.filter(|p| distance.at(p) <= -0.5 * inset).collect()
        }
    }
}

/// `count` of `choice`, each the farthest from those before. O(count · choice).
fn farthest_first(choice: &[Vec3], count: usize) -> Vec<Vec3> {
    let mut gaps = vec![f64::INFINITY; choice.len()];
    let mut next = 0;
    let mut chosen = Vec::with_capacity(count);
    while chosen.len() < count.min(choice.len()) {
        let point = choice[next];
        chosen.push(point);
        let mut farthest = (0.0, next);
        for (index, (gap, other)) in gaps.iter_mut().zip(choice.iter()).enumerate() {
            *gap = gap.min((other - point).norm_squared());
            if *gap > farthest.0 {
                farthest = (*gap, index);
            }
        }
        if farthest.0 == 0.0 {
            break;
        }
        next = farthest.1;
    }
    chosen
}

/// The points in an order in which groups lie close together: halves along the longest side, again and again.
fn grouped(mut points: Vec<Vec3>) -> (Vec<Vec3>, Vec<Group>) {
    fn split(points: &mut [Vec3], from: usize, groups: &mut Vec<Group>) {
        let bounds = Bounds::of(points.iter());
        if points.len() <= GROUP {
            let centre = bounds.centre();
            let radius = points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
            let to = (from + points.len()) as u32;
            groups.push(Group { centre, radius, from: from as u32, to });
            return;
        }
        let axis = bounds.size().imax();
        points.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
        let half = points.len() / 2;
        let (low, high) = points.split_at_mut(half);
        split(low, from, groups);
        split(high, from + half, groups);
    }
    let mut groups = Vec::new();
    split(&mut points, 0, &mut groups);
    (points, groups)
}

/// Cells along the longest side of the fine grid at most.
const MOST_FINE: f64 = 48.0;
const COARSE: f64 = 16.0;

impl Near {
    /// Cells that answer whether a place is nearer than `distance` m to one of `points`.
    pub fn new(points: &[Vec3], distance: f64) -> Self {
        let tight = Bounds::of(points.iter());
        let bounds = tight.grown(distance * (1.0 + 1e-9));
        let extent = bounds.size();
        let edge = distance.max(extent.max() / MOST_FINE);
        let cells = |edge: f64| [0, 1, 2].map(|axis| (extent[axis] / edge).floor() as usize + 1);
        let size = cells(edge);
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); size.iter().product()];
        for (index, point) in points.iter().enumerate() {
            let first = (point - Vec3::repeat(distance) - bounds.low) / edge;
            let last = (point + Vec3::repeat(distance) - bounds.low) / edge;
            let range = |axis: usize| {
                let top = size[axis] - 1;
                (first[axis].max(0.0) as usize).min(top)..=(last[axis].max(0.0) as usize).min(top)
            };
            for z in range(2) {
                for y in range(1) {
                    for x in range(0) {
                        lists[(z * size[1] + y) * size[0] + x].push(index as u32);
                    }
                }
            }
        }
        let mut starts = vec![0];
        let mut listed = Vec::new();
        for list in lists {
            listed.extend(list);
            starts.push(listed.len() as u32);
        }
        let coarse_edge = extent.max() / COARSE;
        let coarse_size = cells(coarse_edge);
        let half = 0.5 * coarse_edge * 3.0_f64.sqrt();
        let mut coarse = Vec::with_capacity(coarse_size.iter().product());
        for z in 0..coarse_size[2] {
            for y in 0..coarse_size[1] {
                for x in 0..coarse_size[0] {
                    let middle = bounds.low
                        + Vec3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5) * coarse_edge;
                    let least = points
                        .iter()
                        .map(|p| (p - middle).norm_squared())
                        .fold(f64::INFINITY, f64::min);
                    coarse.push(((least.sqrt() - half) * (1.0 - 1e-6)) as f32);
                }
            }
        }
        Self {
            distance,
            low: bounds.low,
            edge,
            size,
            starts,
            listed,
            coarse,
            coarse_edge,
            coarse_size,
            bounds,
            points: points.to_vec(),
        }
    }

    /// False if a ball surely stays farther than the distance from all points.
    fn may_meet(&self, centre: &Vec3, radius: f64) -> bool {
        let nearest = centre.sup(&self.bounds.low).inf(&self.bounds.high);
        let off = (centre - nearest).norm_squared();
        if off > radius * radius {
            return false;
        }
        if off > 0.0 {
            return true;
        }
        let cell = (centre - self.low) / self.coarse_edge;
        let at = |axis: usize| (cell[axis] as usize).min(self.coarse_size[axis] - 1);
        let index = (at(2) * self.coarse_size[1] + at(1)) * self.coarse_size[0] + at(0);
        f64::from(self.coarse[index]) <= radius + self.distance
    }

    fn meets(&self, place: &Vec3) -> bool {
        if !self.bounds.contains(place) {
            return false;
        }
        let cell = (place - self.low) / self.edge;
        let at = |axis: usize| (cell[axis] as usize).min(self.size[axis] - 1);
        let index = (at(2) * self.size[1] + at(1)) * self.size[0] + at(0);
        let limit = self.distance * self.distance;
        self.listed[self.starts[index] as usize..self.starts[index + 1] as usize]
            .iter()
            .any(|&i| (self.points[i as usize] - place).norm_squared() < limit)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Grain;
    use super::super::forms::Forms;
    use super::super::random::Test;
    use super::super::samples::{dumbbell, of, solid, sphere};
    use super::*;
    use crate::geometry::samples::l_mesh;
    use crate::num::random::{rotation, stream};

    #[test]
    fn meeting_is_that_of_brute_force() {
        let mut source = stream(1, "points", 0);
        let (clump, solid) = solid(l_mesh());
        let pair = dumbbell(0.7, 1.0);
        let grains = [
            Grain { clump: &clump, solid: Some(&solid), family: 0 },
            Grain { clump: &pair, solid: None, family: 0 },
        ];
        let forms = Forms::new(&grains, Test::Solid, 3);
        let all: Vec<Points> = forms
            .distinct
            .iter()
            .map(|shaped| Points::new(shaped, 150, 0.0, 3, &mut source).expect("points"))
            .collect();
        let mut met = [0, 0];
        for case in 0..300 {
            let (a, b) = (&all[case % 2], &all[case / 2 % 2]);
            let distance = [0.05, 0.15, 0.4][case % 3];
            let near = Near::new(&b.points, distance);
            let at =
                (direction(&mut source) * uniform(&mut source, 0.5, 3.0), rotation(&mut source));
            let there = (Vec3::repeat(0.1), rotation(&mut source));
            let found = a.meet(&at, &near, &there);
            let slow = a.points.iter().any(|p| {
                let p = at.0 + at.1 * p;
                b.points.iter().any(|q| (there.0 + there.1 * q - p).norm() < distance)
            });
            assert_eq!(found, slow, "{case}");
            met[usize::from(found)] += 1;
        }
        assert!(met[0] > 50 && met[1] > 50, "{met:?}");
    }

    #[test]
    fn points_cover_the_surface_evenly() {
        let mut source = stream(2, "points", 0);
        for dimension in [2, 3] {
            let clumps = [sphere(1.0, dimension), dumbbell(0.7, 1.0)];
            let forms = Forms::new(&of(&clumps), Test::Clump, dimension);
            for shaped in &forms.distinct {
                let few = Points::new(shaped, 50, 0.0, dimension, &mut source).expect("points");
                let many = Points::new(shaped, 200, 0.0, dimension, &mut source).expect("points");
                assert_eq!((few.points.len(), many.points.len()), (50, 200));
                // The covering radius falls as N^(-1/(d-1)).
                let ratio = few.covering / many.covering;
                let expected = 4.0_f64.powf(1.0 / (dimension as f64 - 1.0));
                assert!((ratio / expected - 1.0).abs() < 0.4, "{dimension} {ratio}");
                let inset = Points::new(shaped, 200, 0.1, dimension, &mut source).expect("points");
                assert!((many.radius - inset.radius - 0.1).abs() < 0.02);
            }
            // Evenly on a sphere: the hexagonal best is 0.062 of the radius times 2 at 200.
            let ball = Points::new(&forms.distinct[0], 200, 0.0, dimension, &mut source);
            let limit = if dimension == 3 { 0.25 } else { 0.04 };
            assert!(ball.expect("points").covering < limit);
        }
    }
}
