//! What pictures show: spheres, discs, surfaces, lines, and how solid ones come onto the canvas.

use super::camera::{Camera, View};
use super::colour::Rgb;
use super::raster::{Canvas, Corner};
use crate::geometry::{Bounds, Mesh};
use crate::num::Vec3;
use std::borrow::Cow;

/// Edge of a pixel of the picture in pixels of the canvas.
pub(super) const FINE: usize = 2;
/// Colour behind everything.
pub(super) const BACKGROUND: Rgb = [0.965, 0.962, 0.953];
/// Faces that meet at a smaller angle than this look round; cosine of 40°.
pub(super) const CREASE: f64 = 0.766;

/// Something to show.
#[derive(Debug, Clone)]
pub enum Item<'a> {
    /// A sphere.
    Ball {
        /// Centre, m.
        centre: Vec3,
        /// Radius, m.
        radius: f64,
        /// Colour.
        colour: Rgb,
    },
    /// A disc in the plane of the picture, for two-dimensional scenes.
    Disc {
        /// Centre, m.
        centre: Vec3,
        /// Radius, m.
        radius: f64,
        /// Colour.
        colour: Rgb,
        /// Rotation to mark, rad.
        turn: Option<f64>,
    },
    /// A solid surface.
    Surface {
        /// The surface, m.
        mesh: Cow<'a, Mesh>,
        /// Colour.
        colour: Rgb,
    },
    /// A surface one can look through, with its sharp edges drawn.
    Veil {
        /// The surface, m.
        mesh: Cow<'a, Mesh>,
    },
    /// A thin line.
    Line {
        /// One end, m.
        from: Vec3,
        /// The other end, m.
        to: Vec3,
    },
}

/// How to show it.
#[derive(Debug, Clone, PartialEq)]
pub struct Style {
    /// Width of the picture, pixels.
    pub width: usize,
    /// Height of the picture, pixels.
    pub height: usize,
    /// Where one looks from.
    pub view: View,
    /// A point of the ground that takes shadows; up is that of the view.
    pub ground: Option<Vec3>,
    /// Room that the picture must have, items or not: the same room gives
    /// pictures of different states the same scale. Veils may run out of it.
    pub room: Option<Bounds>,
}

impl Style {
    /// Oblique view with z up, no ground.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, view: View::oblique(&Vec3::z()), ground: None, room: None }
    }
}

/// Balls around everything that must be in the picture.
pub(super) fn extent<'a>(
    items: impl IntoIterator<Item = &'a Item<'a>>,
) -> impl Iterator<Item = (Vec3, f64)> {
    items
        .into_iter()
        .flat_map(|item| -> Box<dyn Iterator<Item = (Vec3, f64)> + 'a> {
            match item {
                Item::Ball { centre, radius, .. } | Item::Disc { centre, radius, .. } => {
                    Box::new(std::iter::once((*centre, *radius)))
                }
                Item::Surface { mesh, .. } | Item::Veil { mesh } => {
                    Box::new(mesh.vertices.iter().map(|vertex| (*vertex, 0.0)))
                }
                Item::Line { from, to } => Box::new([(*from, 0.0), (*to, 0.0)].into_iter()),
            }
        })
        .filter(|(centre, radius)| radius.is_finite() && centre.iter().all(|v| v.is_finite()))
}

/// Draws all that one cannot look through.
pub(super) fn draw_solids(items: &[Item], camera: &Camera, canvas: &mut Canvas) {
    for item in items {
        match item {
            Item::Ball { centre, radius, colour } => {
                canvas.ball(camera.project(centre), radius * camera.scale, *colour);
            }
            Item::Disc { centre, radius, colour, turn } => {
                canvas.disc(camera.project(centre), radius * camera.scale, *colour, *turn);
            }
            Item::Surface { mesh, colour } => {
                for corners in corners(mesh, camera) {
                    canvas.triangle(&corners, *colour);
                }
            }
            Item::Veil { .. } | Item::Line { .. } => {}
        }
    }
}

/// Unit normal of each triangle; 0 for one without area.
pub(super) fn facet_normals(mesh: &Mesh) -> Vec<Vec3> {
    mesh.facets()
        .map(|[a, b, c]| (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros))
        .collect()
}

/// Every triangle on the canvas, with normals averaged over the faces round
/// each corner that meet at less than the crease angle.
fn corners(mesh: &Mesh, camera: &Camera) -> Vec<[Corner; 3]> {
    let normals = facet_normals(mesh);
    let mut around = vec![Vec::new(); mesh.vertices.len()];
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        for corner in triangle {
            around[*corner as usize].push(index);
        }
    }
    let smooth = |facet: usize, vertex: u32| {
        let own = normals[facet];
        let sum: Vec3 = around[vertex as usize]
            .iter()
            .map(|other| normals[*other])
            .filter(|other| other.dot(&own) > CREASE)
            .sum();
        let n = sum.try_normalize(1e-12).unwrap_or(own);
        [n.dot(&camera.right), n.dot(&camera.up), n.dot(&camera.eye)].map(|v| v as f32)
    };
    let place: Vec<_> = mesh.vertices.iter().map(|vertex| camera.project(vertex)).collect();
    mesh.triangles
        .iter()
        .enumerate()
        .map(|(facet, triangle)| {
            triangle.map(|vertex| Corner {
                place: place[vertex as usize],
                normal: smooth(facet, vertex),
            })
        })
        .collect()
}
