//! A parallel-projection camera that fits itself to what it is shown.

use crate::geometry::Bounds;
use crate::num::Vec3;

/// Where one looks from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// From the scene towards the eye; any length but 0.
    pub towards_eye: Vec3,
    /// What is up in the picture; not parallel to `towards_eye`.
    pub up: Vec3,
}

impl View {
    /// From above, to the right of the front, with `up` upwards.
    pub fn oblique(up: &Vec3) -> Self {
        let up = up.try_normalize(1e-300).unwrap_or_else(Vec3::z);
        // z up looks from (0.45, -0.85, 0.45); other axes turn with it.
        let front = if up.y.abs() < 0.9 { -Vec3::y() } else { Vec3::z() };
        let front = (front - up * front.dot(&up)).normalize();
        let right = up.cross(&front);
        Self { towards_eye: front * 0.82 + right * 0.44 + up * 0.46, up }
    }

    /// Straight down the z axis on the x–y plane.
    pub fn flat() -> Self {
        Self { towards_eye: Vec3::z(), up: Vec3::y() }
    }
}

/// Maps metres to pixels: x to the right, y downwards, depth towards the eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Unit vector to the right in the picture.
    pub right: Vec3,
    /// Unit vector upwards in the picture.
    pub up: Vec3,
    /// Unit vector towards the eye.
    pub eye: Vec3,
    /// Pixels per metre.
    pub scale: f64,
    origin: [f64; 3],
}

impl Camera {
    /// Shows every ball (centre, radius) of `content` on a canvas of `width` ×
    /// `height` pixels, with `margin` of the canvas free on each side.
    pub fn fitting(
        view: &View,
        content: impl IntoIterator<Item = (Vec3, f64)>,
        width: f64,
        height: f64,
        margin: f64,
    ) -> Self {
        let eye = view.towards_eye.try_normalize(1e-300).unwrap_or_else(Vec3::z);
        let right = view.up.cross(&eye).try_normalize(1e-12).unwrap_or_else(|| perpendicular(&eye));
        let up = eye.cross(&right);
        let mut bounds = Bounds::EMPTY;
        for (centre, radius) in content {
            let flat = Vec3::new(centre.dot(&right), centre.dot(&up), centre.dot(&eye));
            let reach = Vec3::repeat(radius);
            bounds = bounds.with(&(flat - reach)).with(&(flat + reach));
        }
        if bounds.is_empty() {
            bounds = Bounds { low: -Vec3::repeat(1.0), high: Vec3::repeat(1.0) };
        }
        let (size, middle) = (bounds.size(), bounds.centre());
        let room = 1.0 - 2.0 * margin;
        let fit = |pixels: f64, metres: f64| {
            if metres > 0.0 { pixels * room / metres } else { f64::INFINITY }
        };
        let scale = fit(width, size.x).min(fit(height, size.y));
        let scale = if scale.is_finite() { scale } else { 1.0 };
        let origin =
            [width / 2.0 - middle.x * scale, height / 2.0 + middle.y * scale, -middle.z * scale];
        Self { right, up, eye, scale, origin }
    }

    /// Pixel coordinates and depth (pixels, 0 at the middle of the content, larger is nearer).
    pub fn project(&self, point: &Vec3) -> [f64; 3] {
        [
            self.origin[0] + point.dot(&self.right) * self.scale,
            self.origin[1] - point.dot(&self.up) * self.scale,
            self.origin[2] + point.dot(&self.eye) * self.scale,
        ]
    }

    /// The point at these pixel coordinates and depth.
    pub fn unproject(&self, x: f64, y: f64, depth: f64) -> Vec3 {
        (self.right * (x - self.origin[0])
            + self.up * (self.origin[1] - y)
            + self.eye * (depth - self.origin[2]))
            / self.scale
    }
}

fn perpendicular(direction: &Vec3) -> Vec3 {
    let helper = if direction.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() };
    direction.cross(&helper).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_fits_and_projection_inverts() {
        let content = [(Vec3::new(3.0, 1.0, -2.0), 0.5), (Vec3::new(-1.0, 0.0, 4.0), 0.1)];
        for view in [View::oblique(&Vec3::z()), View::oblique(&Vec3::y()), View::flat()] {
            let camera = Camera::fitting(&view, content, 200.0, 100.0, 0.05);
            for (centre, radius) in content {
                let [x, y, depth] = camera.project(&centre);
                let reach = radius * camera.scale - 1e-9;
                assert!(x - reach >= 10.0 && x + reach <= 190.0, "{x}");
                assert!(y - reach >= 5.0 && y + reach <= 95.0, "{y}");
                assert!((camera.unproject(x, y, depth) - centre).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn a_point_or_nothing_is_no_trouble() {
        for content in [vec![], vec![(Vec3::zeros(), 0.0)]] {
            let camera = Camera::fitting(&View::flat(), content, 10.0, 10.0, 0.1);
            assert!(camera.project(&Vec3::zeros()).iter().all(|v| v.is_finite()));
        }
    }
}
