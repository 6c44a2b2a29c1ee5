//! How meshes, clumps and whole states are shown.

use super::camera::View;
use super::colour;
use super::items::{Item, Style};
use super::picture::{Picture, render};
use crate::clump::Clump;
use crate::geometry::{Bounds, Mesh};
use crate::model::{Dimension, Frame, Model, WallShape};
use crate::num::Vec3;
use crate::shape::Solid;
use std::borrow::Cow;

/// A picture of a surface.
pub fn view_mesh(mesh: &Mesh, [width, height]: [usize; 2]) -> Picture {
    let items = [Item::Surface { mesh: Cow::Borrowed(mesh), colour: colour::STONE }];
    render(&items, &grounded(&items, width, height))
}

/// A picture of spheres: `centres` and `radii` in m, one entry each a sphere;
/// spheres with the same entry in `groups` (body, clump) get the same tone.
/// The shortest list counts; without groups every sphere is its own. `room`: what
/// the picture must have room for besides (the same room gives the same scale).
/// More than two spheres at one z are discs, seen from +z.
pub fn view_spheres(
    centres: &[Vec3],
    radii: &[f64],
    groups: &[u32],
    room: Option<Bounds>,
    [width, height]: [usize; 2],
) -> Picture {
    let flat = centres.len() > 2 && centres.iter().all(|centre| centre.z == centres[0].z);
    let tone = |index: usize| colour::body(groups.get(index).map_or(index, |g| *g as usize));
    let items: Vec<Item> = centres
        .iter()
        .zip(radii)
        .enumerate()
        .map(|(index, (centre, radius))| {
            let (centre, radius, colour) = (*centre, *radius, tone(index));
            match flat {
                true => Item::Disc { centre, radius, colour, turn: None },
                false => Item::Ball { centre, radius, colour },
            }
        })
        .collect();
    let mut style = grounded(&items, width, height);
    style.room = room;
    if flat {
        (style.view, style.ground) = (View::flat(), None);
    }
    render(&items, &style)
}

/// A clump beside its solid, both in the frame of the solid and to the same scale.
pub fn solid_beside_clump(solid: &Solid, clump: &Clump, width: usize, height: usize) -> Picture {
    let balls: Vec<(Vec3, f64)> = clump
        .balls
        .iter()
        .map(|ball| (clump.centroid + clump.axes * ball.centre, ball.radius))
        .collect();
    let room = balls.iter().fold(solid.mesh.bounds(), |room, (centre, radius)| {
        let reach = Vec3::repeat(*radius);
        room.with(&(centre - reach)).with(&(centre + reach))
    });
    let middle = room.centre();
    let half = |items: &[Item]| {
        let mut style = Style::new(width / 2, height);
        style.ground = Some(Vec3::new(middle.x, middle.y, room.low.z));
        style.room = Some(room);
        render(items, &style)
    };
    let surface = Item::Surface { mesh: Cow::Borrowed(&solid.mesh), colour: colour::STONE };
    let spheres: Vec<Item> = balls
        .iter()
        .enumerate()
        .map(|(index, (centre, radius))| Item::Ball {
            centre: *centre,
            radius: *radius,
            colour: colour::varied(colour::CLUMP, index),
        })
        .collect();
    Picture::beside(&[half(&[surface]), half(&spheres)])
}

/// An oblique view of things that lie on a ground just beneath them.
fn grounded(items: &[Item], width: usize, height: usize) -> Style {
    let mut bounds = Bounds::EMPTY;
    for item in items {
        bounds = match item {
            Item::Ball { centre, radius, .. } | Item::Disc { centre, radius, .. } => {
                let reach = Vec3::repeat(*radius);
                bounds.with(&(centre - reach)).with(&(centre + reach))
            }
            Item::Surface { mesh, .. } | Item::Veil { mesh } => bounds.union(&mesh.bounds()),
            Item::Line { from, to } => bounds.with(from).with(to),
        };
    }
    let mut style = Style::new(width, height);
    if !bounds.is_empty() {
        let middle = bounds.centre();
        style.ground = Some(Vec3::new(middle.x, middle.y, bounds.low.z));
    }
    style
}

/// Columns and edge of the cells of a gallery of `count` pictures.
fn grid_for(count: usize) -> (usize, usize) {
    match count {
        0..=4 => (count.max(1), 260),
        5..=12 => (4, 240),
        _ => (6, 180),
    }
}

/// Solids in a grid, each filling its cell; at most `limit` of them, spread
/// evenly over the list; `shrink` 1 for full size, more for a quick look.
pub fn solids(solids: &[Solid], limit: usize, shrink: usize) -> Picture {
    let shown = spread(solids.len(), limit);
    let (columns, edge) = grid_for(shown.len());
    let edge = edge / shrink.max(1);
    let cells: Vec<Picture> = shown
        .iter()
        .enumerate()
        .map(|(cell, index)| {
            let mesh = &solids[*index].mesh;
            let tone = colour::mix(colour::STONE, colour::group(cell), 0.45);
            let items = [Item::Surface { mesh: Cow::Borrowed(mesh), colour: tone }];
            render(&items, &grounded(&items, edge, edge))
        })
        .collect();
    Picture::grid(&cells, columns)
}

/// Pairs of solid and clump in a grid, at most `limit` of them; `shrink` as in [`solids`].
pub fn clumps(pairs: &[(&Solid, &Clump)], limit: usize, shrink: usize) -> Picture {
    let (width, height) = (400 / shrink.max(1), 220 / shrink.max(1));
    let cells: Vec<Picture> = spread(pairs.len(), limit)
        .into_iter()
        .map(|index| solid_beside_clump(pairs[index].0, pairs[index].1, width, height))
        .collect();
    Picture::grid(&cells, 2)
}

/// `limit` indices spread evenly over `count`, or all of them.
pub(super) fn spread(count: usize, limit: usize) -> Vec<usize> {
    let shown = count.min(limit);
    (0..shown).map(|place| place * count / shown).collect()
}

/// A picture of a scene in the state `frame`, with its walls. Two-dimensional
/// scenes are drawn flat, seen from +z.
pub fn state(model: &Model, frame: &Frame, width: usize, height: usize) -> Picture {
    state_in(model, frame, container(model, frame), [width, height])
}

/// Pictures of several states of a scene to the same scale.
pub fn states(model: &Model, frames: &[&Frame], width: usize, height: usize) -> Vec<Picture> {
    let rooms = frames.iter().map(|frame| container(model, frame));
    let room = rooms.fold(Bounds::EMPTY, |all, one| all.union(&one));
    let draw = |frame: &&Frame| state_in(model, frame, room, [width, height]);
    frames.iter().map(draw).collect()
}

fn state_in(model: &Model, frame: &Frame, room: Bounds, [width, height]: [usize; 2]) -> Picture {
    let flat = model.dimension == Dimension::Two;
    let turns = model.needs().rotation;
    let shown = frame.centres.iter().zip(&model.spheres);
    let mut items: Vec<Item> = shown
        .map(|(centre, sphere)| {
            let (centre, radius, colour) =
                (*centre, sphere.radius, colour::body(sphere.body as usize));
            if !flat {
                return Item::Ball { centre, radius, colour };
            }
            let body = frame.bodies.get(sphere.body as usize);
            let turn = body.map(|state| state.orientation.euler_angles().2);
            Item::Disc { centre, radius, colour, turn: turn.filter(|_| turns) }
        })
        .collect();
    let up = upwards(model);
    let ground = walls(model, frame, &up, room, &mut items);
    let view = if flat { View::flat() } else { View::oblique(&up) };
    let room = (!room.is_empty()).then_some(room);
    render(&items, &Style { width, height, view, ground: ground.filter(|_| !flat), room })
}

/// The direction that is up: against gravity, or z (y in two dimensions).
pub(super) fn upwards(model: &Model) -> Vec3 {
    (-model.gravity).try_normalize(1e-300).unwrap_or(match model.dimension {
        Dimension::Two => Vec3::y(),
        Dimension::Three => Vec3::z(),
    })
}

/// Adds the walls to `items`: meshes as veils, planes along the axes as
/// rectangles as large as what they enclose. Gives a point of the floor.
fn walls(
    model: &Model,
    frame: &Frame,
    up: &Vec3,
    room: Bounds,
    items: &mut Vec<Item>,
) -> Option<Vec3> {
    let shown = room;
    let mut ground = None;
    for wall in &model.walls {
        match &wall.shape {
            WallShape::Mesh { mesh } => {
                let placed = mesh.mapped(|vertex| wall.motion.place(vertex, frame.time));
                items.push(Item::Veil { mesh: Cow::Owned(placed) });
            }
            WallShape::Plane { point, normal } => {
                let here = wall.motion.place(point, frame.time);
                if normal.dot(up) > 0.99 {
                    ground = Some(here);
                }
                let Some((axis, _, _)) = wall.shape.axis_plane() else { continue };
                let corners = rectangle(&shown, axis, here[axis]);
                for (at, corner) in corners.iter().enumerate() {
                    items.push(Item::Line { from: *corner, to: corners[(at + 1) % 4] });
                }
            }
        }
    }
    ground
}

/// What the picture shows: the spheres, extended to axis-aligned planes that
/// are not much farther away than the spheres reach, and to mesh walls, of these
/// no more upwards than the height of the bed again.
fn container(model: &Model, frame: &Frame) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for (centre, sphere) in frame.centres.iter().zip(&model.spheres) {
        if centre.iter().all(|v| v.is_finite()) {
            let reach = Vec3::repeat(sphere.radius);
            bounds = bounds.with(&(centre - reach)).with(&(centre + reach));
        }
    }
    if bounds.is_empty() {
        bounds = model.domain;
    }
    let (spheres, far) = (bounds, 1.5 * bounds.diagonal());
    bounds = bounds.union(&meshes(model, frame, &bounds));
    for wall in &model.walls {
        let (WallShape::Plane { point, .. }, Some((axis, _, side))) =
            (&wall.shape, wall.shape.axis_plane())
        else {
            continue;
        };
        let place = wall.motion.place(point, frame.time)[axis];
        if side > 0.0 && place > spheres.low[axis] - far {
            bounds.low[axis] = place;
        }
        if side < 0.0 && place < spheres.high[axis] + far {
            bounds.high[axis] = place;
        }
    }
    if model.dimension == Dimension::Two {
        (bounds.low.z, bounds.high.z) = (0.0, 0.0);
    }
    bounds
}

/// What mesh walls reach to, cut off above the spheres by their height again.
fn meshes(model: &Model, frame: &Frame, spheres: &Bounds) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for wall in &model.walls {
        if let WallShape::Mesh { mesh } = &wall.shape {
            for vertex in &mesh.vertices {
                bounds = bounds.with(&wall.motion.place(vertex, frame.time));
            }
        }
    }
    let up = upwards(model);
    let axis = up.iamax();
    let height = 1.2 * spheres.size()[axis];
    if up[axis] > 0.0 {
        bounds.high[axis] = bounds.high[axis].min(spheres.high[axis] + height);
    } else {
        bounds.low[axis] = bounds.low[axis].max(spheres.low[axis] - height);
    }
    bounds
}

fn rectangle(bounds: &Bounds, axis: usize, place: f64) -> [Vec3; 4] {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    [(false, false), (true, false), (true, true), (false, true)].map(|(on_u, on_v)| {
        let mut corner = bounds.low;
        corner[axis] = place;
        corner[u] = if on_u { bounds.high[u] } else { bounds.low[u] };
        corner[v] = if on_v { bounds.high[v] } else { bounds.low[v] };
        corner
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Motion, Sphere, Wall};
    use crate::report::fixture;

    /// Number of pixels whose largest channel stands out from the smallest.
    fn coloured(picture: &Picture) -> usize {
        let stands_out = |pixel: &&[u8]| {
            let (low, high) = pixel.iter().fold((255, 0), |(l, h), v| (l.min(*v), h.max(*v)));
            high - low > 40
        };
        picture.pixels.chunks(3).filter(stands_out).count()
    }

    #[test]
    fn a_state_shows_its_spheres_and_the_same_scale_for_all() {
        let model = fixture::model(3);
        let still = fixture::frame(&model, 0, Vec3::zeros());
        let lifted = fixture::frame(&model, 10, Vec3::z() * 0.03);
        let alone = state(&model, &still, 80, 60);
        assert!(coloured(&alone) > 400);
        let both = states(&model, &[&still, &lifted], 80, 60);
        assert!(coloured(&both[0]) < coloured(&alone), "room for the other state makes it smaller");
        let ratio = coloured(&both[0]) as f64 / coloured(&both[1]) as f64;
        assert!((0.8..1.25).contains(&ratio), "equal scale, {ratio}");
    }

    #[test]
    fn two_dimensions_are_seen_from_above() {
        let mut model = fixture::model(1);
        model.dimension = Dimension::Two;
        model.walls.clear();
        model.spheres.push(Sphere { body: 0, ..model.spheres[0] });
        let mut frame = fixture::frame(&model, 0, Vec3::zeros());
        frame.centres[1].x += 0.03;
        let picture = state(&model, &frame, 200, 60);
        // Two discs side by side, nothing between them.
        let row: Vec<bool> =
            (0..200).map(|x| picture.pixel(x, 30).iter().any(|v| *v < 200)).collect();
        let starts = row.windows(2).filter(|pair| !pair[0] && pair[1]).count();
        assert!(starts >= 2 && !row[100], "{starts}");
        assert!(row[40] && row[160]);
    }

    #[test]
    fn mesh_walls_and_odd_states_are_no_trouble() {
        let mut model = fixture::model(2);
        let mesh = fixture::pebble(Vec3::repeat(0.03), 2);
        let motion = Motion::Rotate { origin: Vec3::zeros(), axis: Vec3::y(), rate: 1.0 };
        let shape = WallShape::Mesh { mesh };
        model.walls.push(Wall { name: "drum".into(), shape, motion, material: 0 });
        let mut frame = fixture::frame(&model, 3, Vec3::zeros());
        frame.velocities.clear();
        frame.centres[3].x = f64::INFINITY;
        assert!(coloured(&state(&model, &frame, 60, 40)) > 20);
        frame.centres.clear();
        assert_eq!(state(&model, &frame, 60, 40).pixels.len(), 7200);
    }

    #[test]
    fn solids_stand_left_of_their_clumps() {
        let picture = solid_beside_clump(&fixture::solid("a"), &fixture::clump("a"), 120, 60);
        let (left, right) = (picture.pixel(30, 30), picture.pixel(90, 30));
        assert!(left[0] > left[2], "stone is warm, {left:?}");
        assert!(right[2] > right[0], "clumps are blue, {right:?}");
        assert_eq!(view_spheres(&[Vec3::zeros()], &[1.0], &[], None, [80, 60]).width, 80);
    }

    #[test]
    fn galleries_spread_over_their_list() {
        assert_eq!(spread(10, 5), [0, 2, 4, 6, 8]);
        assert_eq!(spread(3, 5), [0, 1, 2]);
        let many: Vec<Solid> = (0..7).map(|_| fixture::solid("a")).collect();
        let picture = solids(&many, 5, 10);
        assert_eq!((picture.width, picture.height), (4 * 24, 2 * 24));
        assert_eq!(solids(&[], 5, 10).pixels.len(), 3, "an empty gallery is one blank pixel");
    }
}
