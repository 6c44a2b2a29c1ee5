//! How deep bodies of a packing lie in each other in truth, found independently of the method that placed them.
//!
//! Spheres against spheres: exact. Spheres against surfaces: exact, by the signed distance of
//! their centres. Surfaces against surfaces: whether they touch or cross, or one
//! holds the other, exactly ([`Collider`]); how far apart or how deep, by the signed distance to the other surface
//! at vertices and [`POINTS`] points more on each, both ways, so that gaps come out a little too large and
//! depths a little too small. O(near pairs · points · log triangles).
//!
//! The core solid fraction is the share of random points inside a body, among those that
//! keep two mean diameters from the walls and lie below three quarters of the centres (anywhere along an axis that repeats).

use super::forms::{Form, Forms, Shaped};
use super::random::Test;
use super::{Grain, Placement};
use crate::geometry::distance::sample_surface;
use crate::geometry::{BallGrid, Cell, Collider, Region, SignedDistance};
use crate::num::random::stream;
use crate::num::{Rotation, Vec3};
use std::fmt;

/// Points on a surface beside its vertices.
pub const POINTS: usize = 400;

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// Least gap between two bodies, m (negative: depth); infinite where none are near each other.
    pub least_gap: f64,
    /// Pairs of bodies that overlap.
    pub overlapping: usize,
    /// Least gap to the boundary, m (negative: depth).
    pub wall_gap: f64,
    /// Smallest equivalent diameter of a body, m.
    pub diameter: f64,
    /// Solid fraction of the core and its standard error; `None` where the container has no core.
    pub core: Option<(f64, f64)>,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = |depth: f64| 100.0 * depth / self.diameter;
        match self.overlapping {
            0 => write!(f, "checked on the true forms, no two bodies overlap")?,
            pairs => write!(
                f,
                "checked on the true forms, {pairs} pairs of bodies overlap, the worst by {:.3e} m ({:.3} % of the smallest diameter)",
                (-self.least_gap).max(0.0),
                share((-self.least_gap).max(0.0)),
            )?,
        }
        if self.overlapping == 0 && self.least_gap.is_finite() {
            write!(f, ", least gap {:.3e} m", self.least_gap)?;
        }
        if let Some((fraction, error)) = self.core {
            write!(f, "; core solid fraction {fraction:.4} ± {error:.4}")?;
        }
        if self.wall_gap < -1e-9 * self.diameter {
            let depth = -self.wall_gap;
            return write!(
                f,
                "; walls are overlapped by up to {depth:.3e} m ({:.3} %)",
                share(depth)
            );
        }
        if self.wall_gap.is_finite() {
            write!(f, "; least gap to walls {:.3e} m", self.wall_gap)
        } else {
            Ok(())
        }
    }
}

/// A surface made ready.
struct Ready {
    distance: SignedDistance,
    collider: Collider,
    points: Vec<Vec3>,
}

type Place = (Vec3, Rotation);

/// A body: its form, made ready where it is a surface, and its place.
type Side<'a> = (&'a Form, Option<&'a Ready>, &'a Place);

/// Checks all near pairs of bodies and all bodies against the boundary.
pub fn check(
    placements: &[Placement],
    grains: &[Grain],
    test: Test,
    region: &Region,
    seed: u64,
) -> Report {
    let forms = Forms::new(grains, test, region.dimension());
    let bodies = Bodies { ready: made_ready(&forms, seed), forms: &forms, placements };
    let radii = placements.iter().map(|p| forms.shaped(p.grain as usize).radius);
    let largest = radii.clone().fold(0.0, f64::max);
    let mut grid = BallGrid::new(radii.fold(f64::INFINITY, f64::min));
    let mut report = Report {
        least_gap: f64::INFINITY,
        overlapping: 0,
        wall_gap: f64::INFINITY,
        diameter: forms.smallest(),
        core: None,
    };
    let cell = region.cell();
    for (index, laid) in placements.iter().enumerate() {
        let at = (laid.position, laid.orientation);
        report.wall_gap = report.wall_gap.min(to_wall(bodies.side(index, &at), region));
        let radius = forms.shaped(laid.grain as usize).radius;
        let reach = radius * 1.001;
        images(cell.as_ref(), &at.0, reach + largest, |image| {
            let at = (*image, at.1);
            grid.near(image, reach, |number, _| {
                let other = &placements[number as usize];
                let there = (other.position, other.orientation);
                let (gap, overlap) =
                    between(bodies.side(index, &at), bodies.side(number as usize, &there));
                report.least_gap = report.least_gap.min(gap);
                report.overlapping += usize::from(overlap);
                true
            });
        });
        let number = grid.insert(at.0, radius);
        debug_assert_eq!(number as usize, index);
    }
    let mut heights: Vec<f64> =
        placements.iter().map(|laid| laid.position[region.dimension() - 1]).collect();
    heights.sort_by(f64::total_cmp);
    let diameters = placements.iter().map(|laid| forms.shaped(laid.grain as usize).diameter);
    let margin = 2.0 * diameters.sum::<f64>() / placements.len().max(1) as f64;
    if let Some(top) = heights.get(heights.len() * 3 / 4) {
        report.core = core(region, margin, *top, seed, |point| {
            let mut solid = false;
            images(cell.as_ref(), point, largest, |image| {
                let hold = |number| bodies.hold(number, image);
                solid = solid || !grid.near(image, 0.0, |number, _| !hold(number as usize));
            });
            solid
        });
    }
    report
}

/// Every surface among `forms` made ready; `None` for balls.
fn made_ready(forms: &Forms, seed: u64) -> Vec<Option<Ready>> {
    let unit = forms.distinct.iter().map(|form| form.radius).fold(f64::MIN_POSITIVE, f64::max);
    let make = |(index, shaped): (usize, &Shaped)| {
        let Form::Surface(mesh) = &shaped.form else { return None };
        let mut source = stream(seed, "pack.penetration", index as u64);
        let spread = sample_surface(mesh, POINTS, &mut source).into_iter().map(|p| p.point);
        let points = mesh.vertices.iter().copied().chain(spread).collect();
        let distance = SignedDistance::new(mesh).ok()?;
        Some(Ready { distance, collider: Collider::new(mesh, unit)?, points })
    };
    forms.distinct.iter().enumerate().map(make).collect()
}

/// Placed bodies with their forms.
struct Bodies<'a> {
    placements: &'a [Placement],
    forms: &'a Forms,
    /// By form.
    ready: Vec<Option<Ready>>,
}

impl Bodies<'_> {
    /// Body `index` as if it were at `at`.
    fn side<'b>(&'b self, index: usize, at: &'b Place) -> Side<'b> {
        let form = self.forms.of[self.placements[index].grain as usize] as usize;
        (&self.forms.distinct[form].form, self.ready[form].as_ref(), at)
    }

    /// Whether body `index` holds `point`.
    fn hold(&self, index: usize, point: &Vec3) -> bool {
        let laid = &self.placements[index];
        let local = laid.orientation.inverse_transform_vector(&(point - laid.position));
        match self.side(index, &(laid.position, laid.orientation)) {
            (Form::Balls(balls), ..) => {
                balls.iter().any(|ball| (local - ball.centre).norm() < ball.radius)
            }
            (_, Some(ready), _) => ready.distance.at(&local) < 0.0,
            _ => false,
        }
    }
}

/// Calls `visit` for a place and for its images no farther than `reach` [m] outside a box that repeats.
fn images(cell: Option<&Cell>, place: &Vec3, reach: f64, mut visit: impl FnMut(&Vec3)) {
    visit(place);
    if let Some(cell) = cell {
        cell.images(place, reach, |way| visit(&(place + way)));
    }
}

/// Random points that the core solid fraction is taken from.
const CORE: u32 = 20_000;

fn core(
    region: &Region,
    margin: f64,
    top: f64,
    seed: u64,
    mut solid: impl FnMut(&Vec3) -> bool,
) -> Option<(f64, f64)> {
    let up = region.dimension() - 1;
    let mut bounds = region.bounds().grown(-margin);
    bounds.high[up] = top;
    let walls = region.bounds();
    let repeats = region.cell().map_or([false; 3], |cell| cell.periodic);
    for axis in (0..=up).filter(|&axis| repeats[axis]) {
        (bounds.low[axis], bounds.high[axis]) = (walls.low[axis], walls.high[axis]);
    }
    if (0..=up).any(|axis| bounds.low[axis] >= bounds.high[axis]) {
        return None;
    }
    let mut source = stream(seed, "pack.core", 0);
    let (mut inside, mut found) = (0_u32, 0_u32);
    for _ in 0..CORE {
        let point = region.sample_within(&bounds, &mut source)?;
        if region.clearance(&point) >= margin {
            inside += 1;
            found += u32::from(solid(&point));
        }
    }
    // Too few points, or none, say nothing.
    (inside >= CORE / 100).then(|| {
        let share = f64::from(found) / f64::from(inside);
        (share, (share * (1.0 - share) / f64::from(inside)).sqrt())
    })
}

fn to_wall((form, ready, at): Side, region: &Region) -> f64 {
    match (form, ready) {
        (Form::Surface(_), Some(ready)) => ready
            .points
            .iter()
            .map(|p| region.clearance(&(at.0 + at.1 * p)))
            .fold(f64::INFINITY, f64::min),
        (Form::Balls(balls), _) => balls
            .iter()
            .map(|ball| region.clearance(&(at.0 + at.1 * ball.centre)) - ball.radius)
            .fold(f64::INFINITY, f64::min),
        _ => f64::INFINITY,
    }
}

/// The gap between two bodies, and whether they overlap.
fn between(a: Side, b: Side) -> (f64, bool) {
    match (a, b) {
        ((Form::Balls(first), _, at), (Form::Balls(second), _, there)) => {
            let mut gap = f64::INFINITY;
            for p in first {
                let centre = at.0 + at.1 * p.centre;
                for q in second {
                    let apart = centre - there.0 - there.1 * q.centre;
                    gap = gap.min(apart.norm() - p.radius - q.radius);
                }
            }
            let rounding = 1e-9 * first.iter().chain(second).map(|b| b.radius).fold(0.0, f64::max);
            (gap, gap < -rounding)
        }
        ((Form::Balls(balls), _, at), (Form::Surface(_), Some(ready), there))
        | ((Form::Surface(_), Some(ready), there), (Form::Balls(balls), _, at)) => {
            let gap = balls
                .iter()
                .map(|ball| {
                    let centre = at.0 + at.1 * ball.centre - there.0;
                    ready.distance.at(&there.1.inverse_transform_vector(&centre)) - ball.radius
                })
                .fold(f64::INFINITY, f64::min);
            (gap, gap < -1e-9 * ready.collider.radius())
        }
        ((_, Some(first), at), (_, Some(second), there)) => {
            let gap = one_way(first, at, second, there).min(one_way(second, there, first, at));
            (gap, gap < 0.0 || first.collider.nearer_than(at, &second.collider, there, 0.0))
        }
        _ => (f64::INFINITY, false),
    }
}

/// Least signed distance of the points of `first` from the surface of `second`.
fn one_way(first: &Ready, at: &Place, second: &Ready, there: &Place) -> f64 {
    let reach = second.collider.radius();
    let mut least = f64::INFINITY;
    for point in &first.points {
        let local = there.1.inverse_transform_vector(&(at.0 + at.1 * point - there.0));
        // Farther from the ball around it than from the nearest point so far.
        if local.norm() - reach < least {
            least = least.min(second.distance.at(&local));
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::super::occupied::placement;
    use super::super::samples::{of, room, solid, sphere};
    use super::*;
    use crate::geometry::samples::box_mesh;

    #[test]
    fn depths_of_boxes_and_balls_are_found() {
        let (clump, cube) = solid(box_mesh(Vec3::repeat(0.2)));
        let ball = sphere(0.1, 3);
        let grains = [
            Grain { clump: &clump, solid: Some(&cube), family: 0 },
            Grain { clump: &clump, solid: Some(&cube), family: 0 },
            Grain { clump: &ball, solid: None, family: 0 },
        ];
        let turn = clump.axes;
        let lay = |a: f64, b: f64| {
            let at = |x: f64| (Vec3::new(x, 0.5, 0.5), turn);
            let placements: Vec<Placement> = [0.3, a, b]
                .iter()
                .enumerate()
                .map(|(grain, &x)| placement(grain, at(x), Vec3::zeros()))
                .collect();
            check(&placements, &grains, Test::Solid, &room(&[1.0; 3]), 1)
        };
        let apart = lay(0.51, 0.73);
        assert_eq!(apart.overlapping, 0, "{apart}");
        assert!((apart.least_gap - 0.01).abs() < 1e-9, "{apart}");
        assert!((apart.wall_gap - 0.17).abs() < 1e-6, "{apart}");
        let deep = lay(0.47, 0.73);
        assert_eq!(deep.overlapping, 1, "{deep}");
        assert!((deep.least_gap + 0.03).abs() < 1e-6, "{deep}");
        let sunk = lay(0.51, 0.69);
        assert_eq!(sunk.overlapping, 1, "{sunk}");
        assert!((sunk.least_gap + 0.02).abs() < 1e-9, "{sunk}");
        let out = lay(0.51, 0.95);
        assert!((out.wall_gap + 0.05).abs() < 1e-9, "{out}");
        // As clumps the cubes are balls of the same volume.
        let balls = check(&[], &of(&[]), Test::Clump, &room(&[1.0; 3]), 1);
        assert_eq!((balls.overlapping, balls.least_gap), (0, f64::INFINITY));
    }
}
