//! Items in, a shaded picture out.
//!
//! Deferred shading over [`super::raster`]: one key light with a shadow map
//! (Williams 1978, nine fixed taps), screen-space ambient occlusion
//! (the "Alchemy" estimator, McGuire et al. 2011, with a fixed sample pattern),
//! twofold supersampling. Every pixel is computed for itself, so the picture is
//! the same at any number of threads. Cost O(pixels covered + pixels × samples).

use super::camera::{Camera, View};
use super::colour::{self, Rgb};
use super::raster::{Canvas, Corner, NOTHING};
use super::{ReportError, lettering, write_whole};
use crate::geometry::{Bounds, Mesh};
use crate::num::Vec3;
use rayon::prelude::*;
use std::borrow::Cow;
use std::path::Path;

/// Edge of a pixel of the picture in pixels of the canvas.
const FINE: usize = 2;
/// Colour behind everything.
const BACKGROUND: Rgb = [0.965, 0.962, 0.953];
/// Faces that meet at a smaller angle than this look round; cosine of 40°.
const CREASE: f64 = 0.766;

/// A finished picture, 8 bits of red, green, blue a pixel, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `3 * width * height` bytes.
    pub pixels: Vec<u8>,
}

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

/// A colour bar beside the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// Text at the dark end.
    pub low: String,
    /// Text at the bright end; digits and the letters of m/s only.
    pub high: String,
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
    /// pictures of different states the same scale.
    pub room: Option<Bounds>,
    /// Colour bar.
    pub key: Option<Key>,
}

impl Style {
    /// Oblique view with z up, no ground, no colour bar.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, view: View::oblique(&Vec3::z()), ground: None, room: None, key: None }
    }
}

/// Draws `items`. Items with numbers that are not finite are left out.
pub fn render(items: &[Item], style: &Style) -> Picture {
    let (width, height) = (style.width.max(1) * FINE, style.height.max(1) * FINE);
    let content = extent(items).chain(style.room.iter().flat_map(corners_of));
    let camera = Camera::fitting(&style.view, content, width as f64, height as f64, 0.045);
    let mut canvas = Canvas::new(width, height);
    draw_solids(items, &camera, &mut canvas);
    let shadow = Shadow::cast(items, &camera, style, width.max(height));
    let reach = occlusion_reach(items, &camera, width.min(height));
    let mut fine: Vec<Rgb> = (0..width * height)
        .into_par_iter()
        .map(|at| shade(&canvas, at, reach, &shadow, style))
        .collect();
    lay_veils(items, &camera, &canvas, &mut fine);
    lay_lines(items, &camera, &canvas, &mut fine);
    if let Some(key) = &style.key {
        lay_key(key, width, height, &mut fine);
    }
    reduce(&fine, style.width.max(1), style.height.max(1))
}

/// Balls around everything that must be in the picture.
fn extent<'a>(items: &'a [Item]) -> impl Iterator<Item = (Vec3, f64)> + 'a {
    items
        .iter()
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

/// The eight corners of a box.
fn corners_of(bounds: &Bounds) -> impl Iterator<Item = (Vec3, f64)> + use<> {
    let [low, high] = [bounds.low, bounds.high];
    (0..8).map(move |corner| {
        let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
        (Vec3::new(pick(0), pick(1), pick(2)), 0.0)
    })
}

fn draw_solids(items: &[Item], camera: &Camera, canvas: &mut Canvas) {
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
fn facet_normals(mesh: &Mesh) -> Vec<Vec3> {
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

/// Depths as the key light sees them, and the way from pixels to there.
struct Shadow {
    canvas: Canvas,
    /// Pixel and depth of the picture to pixel and depth of the light: `m · p + c`.
    matrix: [[f64; 3]; 3],
    shift: [f64; 3],
    /// Light direction in the camera's frame.
    light: [f32; 3],
    /// Depth of the ground at pixel (x, y): `a x + b y + c`.
    ground: Option<[f64; 3]>,
    bias: f32,
}

impl Shadow {
    fn cast(items: &[Item], camera: &Camera, style: &Style, edge: usize) -> Self {
        let light = Vec3::new(-0.36, 0.80, 0.48).normalize();
        let towards = camera.right * light.x + camera.up * light.y + camera.eye * light.z;
        let view = View { towards_eye: towards, up: camera.eye };
        let solids = items.iter().filter(|i| matches!(i, Item::Ball { .. } | Item::Surface { .. }));
        let solids: Vec<Item> = solids.cloned().collect();
        let seen = Camera::fitting(&view, extent(&solids), edge as f64, edge as f64, 0.01);
        let mut canvas = Canvas::new(edge, edge);
        draw_solids(&solids, &seen, &mut canvas);
        let map = |x: f64, y: f64, depth: f64| seen.project(&camera.unproject(x, y, depth));
        let shift = map(0.0, 0.0, 0.0);
        let along = [map(1.0, 0.0, 0.0), map(0.0, 1.0, 0.0), map(0.0, 0.0, 1.0)];
        let matrix = std::array::from_fn(|row| {
            std::array::from_fn(|column| along[column][row] - shift[row])
        });
        let ground = style.ground.and_then(|point| ground_depth(&point, camera, &style.view));
        let bias = (2.5 * seen.scale / camera.scale).max(1.5) as f32;
        let light = [light.x, light.y, light.z].map(|v| v as f32);
        Self { canvas, matrix, shift, light, ground, bias }
    }

    /// Share of the key light that reaches this place, 0 to 1; `slant` is 0
    /// where the surface faces the light and 1 where light grazes it.
    fn reached(&self, [x, y, depth]: [f64; 3], slant: f32) -> f32 {
        let bias = self.bias * (1.0 + 4.0 * slant);
        let place: [f64; 3] = std::array::from_fn(|row| {
            let m = &self.matrix[row];
            self.shift[row] + m[0] * x + m[1] * y + m[2] * depth
        });
        let mut lit = 0;
        for tap in 0..9 {
            let column = place[0] + f64::from(tap % 3 - 1) * 1.6;
            let row = place[1] + f64::from(tap / 3 - 1) * 1.6;
            let inside = column >= 0.0
                && row >= 0.0
                && column < self.canvas.width as f64
                && row < self.canvas.height as f64;
            let at = row as usize * self.canvas.width + column as usize;
            lit += u8::from(!inside || self.canvas.samples[at].depth <= place[2] as f32 + bias);
        }
        f32::from(lit) / 9.0
    }
}

/// Depth of the ground plane through `point` as a linear function of the pixel;
/// `None` when the plane is seen edge on.
fn ground_depth(point: &Vec3, camera: &Camera, view: &View) -> Option<[f64; 3]> {
    let up = view.up.try_normalize(1e-300)?;
    let [right, along, eye] = [&camera.right, &camera.up, &camera.eye].map(|axis| axis.dot(&up));
    if eye.abs() < 1e-6 {
        return None;
    }
    // up · (p − point) = 0 in pixels: right dx − along dy + eye ddepth = 0.
    let [x, y, depth] = camera.project(point);
    let (a, b) = (-right / eye, along / eye);
    Some([a, b, depth - a * x - b * y])
}

/// How far ambient occlusion looks, pixels: about the size of the larger balls.
fn occlusion_reach(items: &[Item], camera: &Camera, edge: usize) -> f32 {
    let mut radii: Vec<f64> = items
        .iter()
        .filter_map(|item| match item {
            Item::Ball { radius, .. } => Some(radius * camera.scale),
            _ => None,
        })
        .collect();
    radii.sort_by(f64::total_cmp);
    let typical = radii.get(radii.len() / 2).copied().unwrap_or(edge as f64 * 0.08);
    (1.1 * typical).min(edge as f64 * 0.1).max(5.0) as f32
}

/// Sample pattern of ambient occlusion: a sunflower spiral, in units of the reach.
fn pattern(index: usize) -> (f32, f32) {
    let radius = ((index as f32 + 0.5) / 16.0).sqrt();
    let angle = index as f32 * 2.399_963;
    (radius * angle.cos(), radius * angle.sin())
}

/// 1 where the surroundings leave the place open, towards 0 where they close in.
fn openness(canvas: &Canvas, at: usize, reach: f32) -> f32 {
    let sample = &canvas.samples[at];
    let (x, y) = ((at % canvas.width) as i64, (at / canvas.width) as i64);
    let mut closed = 0.0;
    for index in 0..16 {
        let (dx, dy) = pattern(index);
        let (dx, dy) = ((dx * reach) as i64, (dy * reach) as i64);
        let (column, row) = (x + dx, y + dy);
        if column < 0 || row < 0 || column >= canvas.width as i64 || row >= canvas.height as i64 {
            continue;
        }
        let other = canvas.samples[row as usize * canvas.width + column as usize].depth;
        if other == NOTHING {
            continue;
        }
        let towards = [dx as f32, -dy as f32, (other - sample.depth).clamp(-reach, 4.0 * reach)];
        let square = towards.iter().map(|v| v * v).sum::<f32>().max(1.0);
        let facing: f32 = towards.iter().zip(sample.normal).map(|(v, n)| v * n).sum();
        // Far in front is another object, not a neighbour: it closes less.
        let near = (1.0 - towards[2] / (4.0 * reach)).clamp(0.0, 1.0);
        closed += (facing / square.sqrt() - 0.08).max(0.0) * near;
    }
    (1.0 - closed / 16.0 * 1.9).clamp(0.15, 1.0)
}

/// Final colour of one pixel of the canvas before veils and lines.
fn shade(canvas: &Canvas, at: usize, reach: f32, shadow: &Shadow, style: &Style) -> Rgb {
    let sample = &canvas.samples[at];
    let (x, y) = ((at % canvas.width) as f64 + 0.5, (at / canvas.width) as f64 + 0.5);
    if sample.depth == NOTHING {
        let fade = (y / (style.height * FINE) as f64) as f32;
        let plain = BACKGROUND.map(|channel| channel - 0.03 * fade);
        let Some([a, b, c]) = shadow.ground else { return plain };
        let lit = shadow.reached([x, y, a * x + b * y + c], 0.0);
        return plain.map(|channel| channel * (0.84 + 0.16 * lit));
    }
    if sample.normal == [0.0; 3] {
        return sample.colour;
    }
    let [nx, ny, nz] = sample.normal;
    let facing = (nx * shadow.light[0] + ny * shadow.light[1] + nz * shadow.light[2]).max(0.0);
    let lit = if facing > 0.0 {
        shadow.reached([x, y, f64::from(sample.depth)], 1.0 - facing)
    } else {
        0.0
    };
    let open = openness(canvas, at, reach);
    let sky = 0.30 + 0.16 * ny + 0.10 * nz;
    let key = 0.92 * facing * lit * (0.55 + 0.45 * open);
    // Highlight of a dull surface: Blinn–Phong with a low exponent.
    let half = [shadow.light[0], shadow.light[1], shadow.light[2] + 1.0];
    let length = half.iter().map(|v| v * v).sum::<f32>().sqrt();
    let gloss = ((nx * half[0] + ny * half[1] + nz * half[2]) / length).max(0.0).powi(24);
    let light = sky * open + key;
    // Colours are stored with gamma ≈ 2: light adds up on their squares.
    sample.colour.map(|c| (c * c * light * 1.12 + 0.05 * gloss * lit).clamp(0.0, 1.0).sqrt())
}

fn lay_veils(items: &[Item], camera: &Camera, canvas: &Canvas, fine: &mut [Rgb]) {
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

fn lay_lines(items: &[Item], camera: &Camera, canvas: &Canvas, fine: &mut [Rgb]) {
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
fn sharp_edges(mesh: &Mesh) -> Vec<[Vec3; 2]> {
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

fn lay_key(key: &Key, width: usize, height: usize, fine: &mut [Rgb]) {
    let letters = 9.0 * FINE as f32;
    let wide = lettering::advance(letters);
    let bar = 150.0 * FINE as f32;
    let thick = 9 * FINE;
    let margin = 14.0 * FINE as f32;
    let text = |text: &str| text.chars().count() as f32 * wide;
    let right = width as f32 - margin - text(&key.high);
    let left = right - bar - wide;
    let top = height as f32 - margin - thick as f32;
    if left < text(&key.low) + margin || top < 0.0 {
        return;
    }
    for row in top as usize..(top as usize + thick).min(height) {
        for column in left as usize..(left + bar) as usize {
            let fraction = (column as f32 - left) / bar;
            fine[row * width + column] = colour::scale(f64::from(fraction));
        }
    }
    let baseline = top + thick as f32;
    for (label, x) in [(&key.low, left - wide - text(&key.low)), (&key.high, right)] {
        for [from, to] in lettering::text(label, x, baseline, letters) {
            let end = |(x, y): (f32, f32)| [f64::from(x), f64::from(y), 0.0];
            stroke([end(from), end(to)], 1.1 * FINE as f64, width, height, |at, _, cover| {
                fine[at] = colour::mix(fine[at], [0.2, 0.22, 0.25], cover as f32);
            });
        }
    }
}

/// Averages squares of fine pixels.
fn reduce(fine: &[Rgb], width: usize, height: usize) -> Picture {
    let mut pixels = Vec::with_capacity(width * height * 3);
    for at in 0..width * height {
        let (column, row) = (at % width * FINE, at / width * FINE);
        for channel in 0..3 {
            let mut sum = 0.0;
            for part in 0..FINE * FINE {
                let place = (row + part / FINE) * width * FINE + column + part % FINE;
                sum += fine[place][channel];
            }
            let mean = sum / (FINE * FINE) as f32;
            pixels.push((mean.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
        }
    }
    Picture { width, height, pixels }
}

impl Picture {
    /// Red, green and blue of a pixel; column from the left, row from the top.
    pub fn pixel(&self, column: usize, row: usize) -> [u8; 3] {
        let at = 3 * (row * self.width + column);
        [self.pixels[at], self.pixels[at + 1], self.pixels[at + 2]]
    }

    /// Pictures of equal height in a row.
    pub fn beside(pictures: &[Self]) -> Self {
        Self::grid(pictures, pictures.len().max(1))
    }

    /// Pictures in rows of `columns`, each in a cell of the size of the largest.
    pub fn grid(pictures: &[Self], columns: usize) -> Self {
        let columns = columns.clamp(1, pictures.len().max(1));
        let cell = |size: fn(&Self) -> usize| pictures.iter().map(size).max().unwrap_or(1);
        let (wide, high) = (cell(|p| p.width), cell(|p| p.height));
        let (width, height) = (wide * columns, high * pictures.len().div_ceil(columns).max(1));
        let blank = BACKGROUND.map(|channel| (channel * 255.0 + 0.5) as u8);
        let mut pixels = blank.repeat(width * height);
        for (index, picture) in pictures.iter().enumerate() {
            let (left, top) = (index % columns * wide, index / columns * high);
            for row in 0..picture.height {
                let from = 3 * row * picture.width;
                let to = 3 * ((top + row) * width + left);
                let length = 3 * picture.width;
                pixels[to..to + length].copy_from_slice(&picture.pixels[from..from + length]);
            }
        }
        Self { width, height, pixels }
    }

    /// The picture as a PNG file.
    pub fn png(&self) -> Result<Vec<u8>, ReportError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        writer.finish()?;
        Ok(bytes)
    }

    /// Writes a PNG file, whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), ReportError> {
        write_whole(path, &self.png()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Rgb = [0.9, 0.1, 0.1];
    const BLUE: Rgb = [0.1, 0.1, 0.9];

    fn ball(x: f64, y: f64, z: f64, radius: f64, colour: Rgb) -> Item<'static> {
        Item::Ball { centre: Vec3::new(x, y, z), radius, colour }
    }

    fn flat(width: usize, height: usize) -> Style {
        Style { view: View::flat(), ..Style::new(width, height) }
    }

    #[test]
    fn a_red_sphere_is_red_in_the_middle_and_nothing_else_is() {
        let picture = render(&[ball(0.0, 0.0, 0.0, 1.0, RED)], &flat(80, 60));
        let [r, g, b] = picture.pixel(40, 30);
        assert!(r > 120 && g < 90 && b < 90, "{r} {g} {b}");
        let [r, g, b] = picture.pixel(2, 2);
        assert!(r > 235 && g > 235 && b > 230, "background {r} {g} {b}");
    }

    #[test]
    fn what_is_nearer_hides_what_is_behind() {
        let style = flat(60, 60);
        let red = ball(0.0, 0.0, 0.0, 1.0, RED);
        for items in [
            [red.clone(), ball(0.0, 0.0, 3.0, 0.5, BLUE)],
            [ball(0.0, 0.0, 3.0, 0.5, BLUE), red.clone()],
        ] {
            let [r, _, b] = render(&items, &style).pixel(30, 30);
            assert!(b > r);
        }
        let behind = render(&[red, ball(0.0, 0.0, -3.0, 0.5, BLUE)], &style).pixel(30, 30);
        assert!(behind[0] > behind[2]);
    }

    #[test]
    fn light_comes_from_the_upper_left_and_shadows_fall() {
        let alone = [ball(0.0, 0.0, 0.0, 1.0, [0.7; 3])];
        let picture = render(&alone, &flat(100, 100));
        assert!(picture.pixel(35, 35)[0] > picture.pixel(70, 75)[0] + 30);
        // A second sphere up the light darkens the first where it was bright.
        let blocked = [alone[0].clone(), ball(-1.26, 2.2, 1.56, 0.8, [0.7; 3])];
        let style = Style { view: View::flat(), ..Style::new(200, 200) };
        let lit = render(&[alone[0].clone(), ball(1.26, -2.2, -1.56, 0.8, [0.7; 3])], &style);
        let dark = render(&blocked, &style);
        let sum = |p: &Picture| p.pixels.iter().map(|v| u64::from(*v)).sum::<u64>();
        assert_ne!(sum(&lit), sum(&dark));
    }

    #[test]
    fn pictures_are_the_same_every_time_and_survive_bad_numbers() {
        let items = [ball(0.0, 0.0, 0.0, 1.0, RED), ball(f64::NAN, 0.0, 0.0, 1.0, BLUE)];
        let style = flat(50, 40);
        let first = render(&items, &style);
        assert_eq!(first, render(&items, &style));
        assert_eq!(first, render(&items[..1], &style));
        assert_eq!(render(&[], &style).pixels.len(), 50 * 40 * 3);
    }

    #[test]
    fn png_reads_back() {
        let picture = render(&[ball(0.0, 0.0, 0.0, 1.0, RED)], &flat(33, 21));
        let bytes = picture.png().expect("a small picture can be encoded");
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("small")];
        reader.next_frame(&mut pixels).expect("one frame");
        assert_eq!(pixels, picture.pixels);
    }

    #[test]
    fn a_grid_holds_every_picture_in_its_cell() {
        let solid = |colour: Rgb| Picture {
            width: 4,
            height: 3,
            pixels: colour.map(|v| (v * 255.0) as u8).repeat(12),
        };
        let grid = Picture::grid(&[solid(RED), solid(BLUE), solid(RED)], 2);
        assert_eq!((grid.width, grid.height), (8, 6));
        assert!(
            grid.pixel(1, 1)[0] > 200 && grid.pixel(5, 1)[2] > 200 && grid.pixel(1, 4)[0] > 200
        );
        assert_eq!(grid.pixel(6, 4), BACKGROUND.map(|v| (v * 255.0 + 0.5) as u8));
    }

    #[test]
    fn veils_tint_and_corners_of_a_box_are_sharp() {
        let mesh = crate::report::fixture::pebble(Vec3::repeat(1.0), 0);
        assert_eq!(sharp_edges(&mesh).len(), 12);
        let round = crate::report::fixture::pebble(Vec3::repeat(1.0), 4);
        assert!(sharp_edges(&round).is_empty());
        let veil = Item::Veil { mesh: Cow::Owned(round) };
        let picture = render(&[veil], &flat(60, 60));
        let (inside, outside) = (picture.pixel(30, 30), picture.pixel(1, 1));
        assert!(inside[0] + 10 < outside[0], "{inside:?} {outside:?}");
    }
}
