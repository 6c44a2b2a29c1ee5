//! What lies over the shaded picture: surfaces to look through and lines.

use super::camera::Camera;
use super::colour::{self, Rgb};
use super::items::{CREASE, FINE, Item, facet_normals};
use super::raster::{Canvas, Corner};
use crate::geometry::Mesh;
use crate::num::Vec3;

pub(super) fn lay_veils(items: &[Item], camera: &Camera, canvas: &Canvas, fine: &mut [Rgb]) {
    for item in items {
        let Item::Veil { mesh } = item else { continue };
        let mut clear = vec![1.0_f32; fine.len()];
        for (triangle, normal) in mesh.triangles.iter().zip(facet_normals(mesh)) {
            let corners = triangle.map(|vertex| Corner {
                place: camera.project(&mesh.vertices[vertex as usize]),
                normal: [0.0; 3],
            });
            let slant = 1.0 - normal.dot(&camera.eye).abs() as f32;
            canvas.veil(&corners, 1.0 - (0.07 + 0.16 * slant * slant), &mut clear);
        }
        for (pixel, clear) in fine.iter_mut().zip(clear) {
            *pixel = colour::mix([0.52, 0.58, 0.64], *pixel, clear);
        }
    }
}

pub(super) fn lay_lines(items: &[Item], camera: &Camera, canvas: &Canvas, fine: &mut [Rgb]) {
    for item in items {
        match item {
            Item::Line { from, to } => line(camera, canvas, fine, from, to, 0.75),
            Item::Veil { mesh } => {
                for [from, to] in sharp_edges(mesh) {
                    line(camera, canvas, fine, &from, &to, 0.5);
                }
            }
            _ => {}
        }
    }
}

/// Edges at which the surface ends or turns by more than the crease angle.
pub(super) fn sharp_edges(mesh: &Mesh) -> Vec<[Vec3; 2]> {
    let normals = facet_normals(mesh);
    let mut edges: Vec<([u32; 2], usize)> = mesh
        .triangles
        .iter()
        .enumerate()
        .flat_map(|(facet, [a, b, c])| {
            [[*a, *b], [*b, *c], [*c, *a]].map(|[p, q]| ([p.min(q), p.max(q)], facet))
        })
        .collect();
    edges.sort_unstable();
    edges
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|group| {
            group.len() != 2 || normals[group[0].1].dot(&normals[group[1].1]).abs() < CREASE
        })
        .map(|group| group[0].0.map(|vertex| mesh.vertices[vertex as usize]))
        .collect()
}

/// A line of fixed thickness, hidden where something lies in front of it.
fn line(camera: &Camera, canvas: &Canvas, fine: &mut [Rgb], from: &Vec3, to: &Vec3, strength: f32) {
    let (a, b) = (camera.project(from), camera.project(to));
    if a.iter().chain(&b).any(|v| !v.is_finite()) {
        return;
    }
    let ink = [0.30, 0.33, 0.37];
    stroke([a, b], 1.1 * FINE as f64, canvas.width, canvas.height, |at, depth, cover| {
        if depth as f32 >= canvas.samples[at].depth {
            fine[at] = colour::mix(fine[at], ink, cover as f32 * strength);
        }
    });
}

/// Calls `paint(pixel, depth, cover)` along a line of `thickness` pixels.
fn stroke(
    ends: [[f64; 3]; 2],
    thickness: f64,
    width: usize,
    height: usize,
    mut paint: impl FnMut(usize, f64, f64),
) {
    let [a, b] = ends;
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let steep = dy.abs() > dx.abs();
    let (major, minor) = if steep { (1, 0) } else { (0, 1) };
    let (limit, side) = if steep { (height, width) } else { (width, height) };
    let (start, end) = if a[major] <= b[major] { (a, b) } else { (b, a) };
    let run = (end[major] - start[major]).max(1e-9);
    let half = 0.5 * thickness * dx.hypot(dy) / run.max(1e-6);
    let half = half.min(thickness);
    let first = (start[major] - 0.5).max(0.0) as usize;
    let last = ((end[major] + 0.5).max(0.0) as usize).min(limit);
    for step in first..last {
        let fraction = ((step as f64 + 0.5 - start[major]) / run).clamp(0.0, 1.0);
        let middle = start[minor] + (end[minor] - start[minor]) * fraction;
        let depth = start[2] + (end[2] - start[2]) * fraction;
        let low = (middle - half - 1.0).max(0.0) as usize;
        let high = ((middle + half + 2.0).max(0.0) as usize).min(side);
        for across in low..high {
            let cover = (half + 0.5 - (across as f64 + 0.5 - middle).abs()).clamp(0.0, 1.0);
            let at = if steep { step * width + across } else { across * width + step };
            paint(at, depth, cover);
        }
    }
}
