//! Spheres and triangles into depth, normal and colour of each pixel.
//!
//! Depth buffer after Catmull (1974). A sphere under parallel projection is a
//! disc whose depth and normal are exact at every pixel, so no sphere is ever
//! broken into triangles. Cost O(pixels covered, hidden ones included).
//! Coordinates are those of [`super::camera::Camera::project`]; normals are in
//! the camera's frame (right, up, towards the eye).

use super::colour::Rgb;

/// Depth of a pixel that nothing covers.
pub const NOTHING: f32 = f32::NEG_INFINITY;

/// What is nearest at one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Depth in pixels, larger is nearer; [`NOTHING`] for background.
    pub depth: f32,
    /// Unit normal in the camera's frame; all 0 for what is drawn flat, without light.
    pub normal: [f32; 3],
    /// Colour of the surface.
    pub colour: Rgb,
}

/// A corner of a triangle on the canvas.
#[derive(Debug, Clone, Copy)]
pub struct Corner {
    /// Pixel coordinates and depth.
    pub place: [f64; 3],
    /// Normal in the camera's frame.
    pub normal: [f32; 3],
}

/// Pixels with depth.
#[derive(Debug, Clone)]
pub struct Canvas {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row from the top.
    pub samples: Vec<Sample>,
}

impl Canvas {
    /// An empty canvas.
    pub fn new(width: usize, height: usize) -> Self {
        let empty = Sample { depth: NOTHING, normal: [0.0; 3], colour: [0.0; 3] };
        Self { width, height, samples: vec![empty; width * height] }
    }

    /// The pixels `first..end` of `low..high` whose middles may be covered, cut to `limit`.
    fn span(low: f64, high: f64, limit: usize) -> std::ops::Range<usize> {
        // `as` saturates: what lies outside the canvas gives an empty range.
        let first = (low - 0.5).ceil().max(0.0) as usize;
        let end = ((high - 0.5).floor() + 1.0).max(0.0) as usize;
        first..end.min(limit)
    }

    /// A sphere of `radius` pixels.
    pub fn ball(&mut self, place: [f64; 3], radius: f64, colour: Rgb) {
        let [x, y, depth] = place;
        for row in Self::span(y - radius, y + radius, self.height) {
            let dy = row as f64 + 0.5 - y;
            let half = (radius * radius - dy * dy).max(0.0).sqrt();
            for column in Self::span(x - half, x + half, self.width) {
                let sample = &mut self.samples[row * self.width + column];
                if (depth + half) as f32 <= sample.depth {
                    continue;
                }
                let dx = column as f64 + 0.5 - x;
                let dz = (half * half - dx * dx).max(0.0).sqrt();
                let here = (depth + dz) as f32;
                if here > sample.depth {
                    let normal = [dx / radius, -dy / radius, dz / radius].map(|v| v as f32);
                    *sample = Sample { depth: here, normal, colour };
                }
            }
        }
    }

    /// A flat disc facing the eye, with a darker rim and, for a `turn` in rad, a
    /// mark that shows its rotation.
    pub fn disc(&mut self, place: [f64; 3], radius: f64, colour: Rgb, turn: Option<f64>) {
        let [x, y, depth] = place;
        let rim = (radius * 0.1).clamp(1.0, 4.0);
        let mark = turn.map(|angle| (angle.cos(), angle.sin()));
        for row in Self::span(y - radius, y + radius, self.height) {
            let dy = row as f64 + 0.5 - y;
            let half = (radius * radius - dy * dy).max(0.0).sqrt();
            for column in Self::span(x - half, x + half, self.width) {
                let dx = column as f64 + 0.5 - x;
                let sample = &mut self.samples[row * self.width + column];
                if depth as f32 <= sample.depth {
                    continue;
                }
                let on_mark = mark.is_some_and(|(c, s)| {
                    let (along, across) = (dx * c - dy * s, dx * s + dy * c);
                    along > 0.0 && across.abs() < rim * 0.5
                });
                let dark = on_mark || dx.hypot(dy) > radius - rim;
                let shade = if dark { 0.62 } else { 1.0 };
                *sample = Sample {
                    depth: depth as f32,
                    normal: [0.0; 3],
                    colour: colour.map(|c| c * shade),
                };
            }
        }
    }

    /// A triangle; both sides are drawn, normals are turned to the eye.
    pub fn triangle(&mut self, corners: &[Corner; 3], colour: Rgb) {
        let width = self.width;
        // The side that is seen is the one the whole facet shows, not one pixel.
        // A facet seen nearly edge on is the rim of a solid and keeps its side.
        let sum: f32 = corners.iter().map(|corner| corner.normal[2]).sum();
        let side = if sum < -0.6 { -1.0 } else { 1.0 };
        let samples = &mut self.samples;
        cover(corners, width, self.height, |at, [a, b, c], depth| {
            let sample = &mut samples[at];
            if depth <= sample.depth {
                return;
            }
            let blend = |axis: usize| {
                side * (a * corners[0].normal[axis]
                    + b * corners[1].normal[axis]
                    + c * corners[2].normal[axis])
            };
            let normal = [blend(0), blend(1), blend(2).max(0.0)];
            let length = normal.iter().map(|v| v * v).sum::<f32>().sqrt().max(1e-12);
            *sample = Sample { depth, normal: normal.map(|v| v / length), colour };
        });
    }

    /// Multiplies `veil` (one value a pixel, 1 = clear) by `clear` wherever the
    /// triangle lies in front of what has been drawn.
    pub fn veil(&self, corners: &[Corner; 3], clear: f32, veil: &mut [f32]) {
        cover(corners, self.width, self.height, |at, _, depth| {
            if depth > self.samples[at].depth {
                veil[at] *= clear;
            }
        });
    }
}

/// Calls `paint(pixel, barycentric weights, depth)` for every pixel middle inside the triangle.
fn cover(
    corners: &[Corner; 3],
    width: usize,
    height: usize,
    mut paint: impl FnMut(usize, [f32; 3], f32),
) {
    let [a, b, c] = corners.map(|corner| corner.place);
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if area.abs() < 1e-12 || !area.is_finite() {
        return;
    }
    let least = |axis: usize| a[axis].min(b[axis]).min(c[axis]);
    let most = |axis: usize| a[axis].max(b[axis]).max(c[axis]);
    for row in Canvas::span(least(1), most(1), height) {
        let y = row as f64 + 0.5;
        for column in Canvas::span(least(0), most(0), width) {
            let x = column as f64 + 0.5;
            let wb = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area;
            let wc = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
            let wa = 1.0 - wb - wc;
            // A hair outside still counts, so that no crack opens between neighbours.
            if wa >= -1e-9 && wb >= -1e-9 && wc >= -1e-9 {
                let depth = (wa * a[2] + wb * b[2] + wc * c[2]) as f32;
                paint(row * width + column, [wa as f32, wb as f32, wc as f32], depth);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Rgb = [1.0, 0.0, 0.0];
    const BLUE: Rgb = [0.0, 0.0, 1.0];

    fn corner(x: f64, y: f64, depth: f64) -> Corner {
        Corner { place: [x, y, depth], normal: [0.0, 0.0, -1.0] }
    }

    #[test]
    fn the_nearer_sphere_wins_in_either_order() {
        for flip in [false, true] {
            let mut canvas = Canvas::new(40, 40);
            let mut both = [(0.0, RED), (15.0, BLUE)];
            if flip {
                both.reverse();
            }
            for (depth, colour) in both {
                canvas.ball([20.0, 20.0, depth], 10.0, colour);
            }
            assert_eq!(canvas.samples[20 * 40 + 20].colour, BLUE);
        }
    }

    #[test]
    fn a_sphere_covers_its_disc_and_has_its_normal() {
        let mut canvas = Canvas::new(100, 100);
        canvas.ball([50.0, 50.0, 0.0], 40.0, RED);
        let covered = canvas.samples.iter().filter(|s| s.depth > NOTHING).count() as f64;
        let disc = std::f64::consts::PI * 1600.0;
        assert!((covered / disc - 1.0).abs() < 0.01, "{covered} of {disc}");
        let left = canvas.samples[50 * 100 + 12].normal;
        assert!(left[0] < -0.9 && left[1].abs() < 0.05);
        let top = canvas.samples[12 * 100 + 50].normal;
        assert!(top[1] > 0.9);
    }

    #[test]
    fn what_is_outside_the_canvas_is_cut() {
        let mut canvas = Canvas::new(10, 10);
        canvas.ball([-50.0, 5.0, 0.0], 10.0, RED);
        canvas.ball([1e18, 1e18, 0.0], 10.0, RED);
        canvas.ball([f64::NAN, 5.0, 0.0], 10.0, RED);
        assert!(canvas.samples.iter().all(|s| s.depth == NOTHING));
        canvas.ball([5.0, 5.0, 0.0], 1e4, RED);
        assert!(canvas.samples.iter().all(|s| s.colour == RED));
    }

    #[test]
    fn two_triangles_tile_a_square_without_cracks() {
        let mut canvas = Canvas::new(30, 30);
        let [a, b, c, d] = [
            corner(3.2, 4.1, 0.0),
            corner(25.7, 4.1, 2.0),
            corner(25.7, 27.3, 4.0),
            corner(3.2, 27.3, 2.0),
        ];
        canvas.triangle(&[a, b, c], RED);
        canvas.triangle(&[a, c, d], RED);
        for row in 4..27 {
            for column in 3..25 {
                let sample = canvas.samples[row * 30 + column];
                assert_eq!(sample.colour, RED);
                assert!(sample.normal[2] > 0.99, "normals look at the eye");
            }
        }
    }
}
