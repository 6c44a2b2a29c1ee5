//! Light on pixels.
//!
//! One key light with a shadow map (Williams 1978, nine fixed taps), ambient
//! occlusion in screen space (the "Alchemy" estimator of McGuire et al. 2011 with a
//! fixed sample pattern), a sky that is brighter above. Each pixel is computed for
//! itself. Cost O(pixels × samples).

use super::camera::{Camera, View};
use super::colour::Rgb;
use super::items::{BACKGROUND, FINE, Item, Style, draw_solids, extent};
use super::raster::{Canvas, NOTHING};
use crate::num::Vec3;

/// Depths as the key light sees them, and the way from pixels to there.
pub(super) struct Shadow {
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
    pub(super) fn cast(items: &[Item], camera: &Camera, style: &Style, edge: usize) -> Self {
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
        let (width, height) = (self.canvas.width as i64, self.canvas.height as i64);
        let limit = place[2] as f32 + bias;
        let mut lit = 0_u8;
        for tap in 0..9_i64 {
            let column = (place[0] + (tap % 3 - 1) as f64 * 1.6).floor() as i64;
            let row = (place[1] + (tap / 3 - 1) as f64 * 1.6).floor() as i64;
            let inside = column >= 0 && row >= 0 && column < width && row < height;
            let covered = || self.canvas.samples[(row * width + column) as usize].depth > limit;
            lit += u8::from(!(inside && covered()));
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

/// Ambient occlusion: how far it looks, and at which pixels.
pub(super) struct Occlusion {
    /// Pixels: about the size of the larger balls.
    reach: f32,
    /// A sunflower spiral over the reach, pixels right and down.
    offsets: [(i64, i64); TAPS],
}

/// Samples of ambient occlusion a pixel.
const TAPS: usize = 16;

impl Occlusion {
    pub(super) fn new(items: &[Item], camera: &Camera, edge: usize) -> Self {
        let mut radii: Vec<f64> = items
            .iter()
            .filter_map(|item| match item {
                Item::Ball { radius, .. } => Some(radius * camera.scale),
                _ => None,
            })
            .collect();
        radii.sort_by(f64::total_cmp);
        let typical = radii.get(radii.len() / 2).copied().unwrap_or(edge as f64 * 0.08);
        let reach = (1.1 * typical).min(edge as f64 * 0.1).max(5.0) as f32;
        let offsets = std::array::from_fn(|index| {
            let radius = reach * ((index as f32 + 0.5) / TAPS as f32).sqrt();
            let angle = index as f32 * 2.399_963;
            ((radius * angle.cos()) as i64, (radius * angle.sin()) as i64)
        });
        Self { reach, offsets }
    }

    /// 1 where the surroundings leave the place open, towards 0 where they close in.
    fn openness(&self, canvas: &Canvas, at: usize) -> f32 {
        let (sample, reach) = (&canvas.samples[at], self.reach);
        let (x, y) = ((at % canvas.width) as i64, (at / canvas.width) as i64);
        let (width, height) = (canvas.width as i64, canvas.height as i64);
        let mut closed = 0.0;
        for (dx, dy) in self.offsets {
            let (column, row) = (x + dx, y + dy);
            if column < 0 || row < 0 || column >= width || row >= height {
                continue;
            }
            let other = canvas.samples[row as usize * canvas.width + column as usize].depth;
            if other == NOTHING {
                continue;
            }
            let rise = (other - sample.depth).clamp(-reach, 4.0 * reach);
            let (right, up) = (dx as f32, -dy as f32);
            let [nx, ny, nz] = sample.normal;
            let facing = right * nx + up * ny + rise * nz;
            let distance = (right * right + up * up + rise * rise).max(1.0).sqrt();
            // Far in front is another object, not a neighbour: it closes less.
            let near = (1.0 - rise / (4.0 * reach)).clamp(0.0, 1.0);
            closed += (facing / distance - 0.08).max(0.0) * near;
        }
        (1.0 - closed / TAPS as f32 * 1.9).clamp(0.15, 1.0)
    }
}

/// Final colour of one pixel of the canvas before veils and lines.
pub(super) fn shade(
    canvas: &Canvas,
    at: usize,
    occlusion: &Occlusion,
    shadow: &Shadow,
    style: &Style,
) -> Rgb {
    let sample = &canvas.samples[at];
    let (x, y) = ((at % canvas.width) as f64 + 0.5, (at / canvas.width) as f64 + 0.5);
    if sample.depth == NOTHING {
        let fade = (y / (style.height * FINE) as f64) as f32;
        let plain = BACKGROUND.map(|channel| channel - 0.03 * fade);
        let Some([a, b, c]) = shadow.ground else { return plain };
        let lit = shadow.reached([x, y, a * x + b * y + c], 0.0);
        // Shadows fade out towards the edge of the picture instead of being cut off.
        let (width, height) = (canvas.width as f64, canvas.height as f64);
        let edge = x.min(y).min(width - x).min(height - y) / (0.14 * width.min(height));
        let strength = 0.16 * edge.clamp(0.0, 1.0) as f32;
        return plain.map(|channel| channel * (1.0 - strength * (1.0 - lit)));
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
    let open = occlusion.openness(canvas, at);
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
