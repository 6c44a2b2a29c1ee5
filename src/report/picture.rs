//! Items in, a shaded picture out.
//!
//! Solids go through the depth buffer of [`super::raster`], are lit pixel by pixel
//! (`shade`), overlaid with what one can look through (`overlay`) and reduced
//! twofold against jagged edges. The picture is the same at any number of threads.
//! Cost O(pixels covered + pixels × samples).

use super::camera::Camera;
use super::colour::Rgb;
use super::items::{BACKGROUND, FINE, Item, Style, draw_solids, extent};
use super::overlay::{lay_lines, lay_veils};
use super::raster::Canvas;
use super::shade::{Occlusion, Shadow, shade};
use super::{ReportError, write_whole};
use crate::geometry::Bounds;
use crate::num::Vec3;
use rayon::prelude::*;
use std::path::Path;

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

/// Draws `items`. Items with numbers that are not finite are left out.
pub fn render(items: &[Item], style: &Style) -> Picture {
    let (width, height) = (style.width.max(1) * FINE, style.height.max(1) * FINE);
    let veils = style.room.is_none();
    let shown = items.iter().filter(|item| veils || !matches!(item, Item::Veil { .. }));
    let content = extent(shown).chain(style.room.iter().flat_map(corners_of));
    let camera = Camera::fitting(&style.view, content, width as f64, height as f64, 0.045);
    let mut canvas = Canvas::new(width, height);
    draw_solids(items, &camera, &mut canvas);
    let shadow = Shadow::cast(items, &camera, style, width.max(height) * 3 / 4);
    let occlusion = Occlusion::new(items, &camera, width.min(height));
    let mut fine: Vec<Rgb> = (0..width * height)
        .into_par_iter()
        .map(|at| shade(&canvas, at, &occlusion, &shadow, style))
        .collect();
    lay_veils(items, &camera, &canvas, &mut fine);
    lay_lines(items, &camera, &canvas, &mut fine);
    reduce(&fine, style.width.max(1), style.height.max(1))
}

/// The eight corners of a box.
fn corners_of(bounds: &Bounds) -> impl Iterator<Item = (Vec3, f64)> + use<> {
    let [low, high] = [bounds.low, bounds.high];
    (0..8).map(move |corner| {
        let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
        (Vec3::new(pick(0), pick(1), pick(2)), 0.0)
    })
}

/// Averages squares of fine pixels.
fn reduce(fine: &[Rgb], width: usize, height: usize) -> Picture {
    let mut pixels = Vec::with_capacity(width * height * 3);
    for at in 0..width * height {
        let (column, row) = (at % width * FINE, at / width * FINE);
        let mut sum = [0.0; 3];
        for part in 0..FINE * FINE {
            let place = (row + part / FINE) * width * FINE + column + part % FINE;
            sum = std::array::from_fn(|channel| sum[channel] + fine[place][channel]);
        }
        let byte = |sum: f32| ((sum / (FINE * FINE) as f32).clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        pixels.extend(sum.map(byte));
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
    use crate::report::camera::View;
    use crate::report::overlay::sharp_edges;
    use std::borrow::Cow;

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
    fn threads_do_not_change_a_pixel() {
        let items: Vec<Item> = (0..40)
            .map(|i| ball((i % 7) as f64, (i % 5) as f64, (i % 3) as f64, 0.8, RED))
            .collect();
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("a small pool").install(|| render(&items, &Style::new(60, 50)))
        };
        assert_eq!(with(1), with(3));
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
