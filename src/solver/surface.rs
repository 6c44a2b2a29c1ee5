//! Triangles for walls that a solver cannot take as a plane, and the room that
//! a moving wall sweeps.

use crate::geometry::{Bounds, Mesh};
use crate::model::Motion;
use crate::num::Vec3;

/// The part of the plane through `point` with unit `normal` that lies in
/// `bounds`, as a fan of triangles: a square clipped by the six sides
/// (Sutherland & Hodgman 1974). Empty if they do not meet.
pub fn plane_in(bounds: &Bounds, point: &Vec3, normal: &Vec3) -> Mesh {
    let half = 2.0 * bounds.diagonal();
    let mut polygon = square(&project(&bounds.centre(), point, normal), normal, half).to_vec();
    for axis in 0..3 {
        polygon = clipped(&polygon, |p| p[axis] - bounds.low[axis]);
        polygon = clipped(&polygon, |p| bounds.high[axis] - p[axis]);
    }
    // Corners closer than this would make needle triangles and are one corner.
    let least = 1e-6 * bounds.diagonal();
    let mut corners: Vec<Vec3> = Vec::new();
    for corner in polygon {
        if corners.iter().all(|other| (other - corner).norm() > least) {
            corners.push(corner);
        }
    }
    let triangles = (2..corners.len() as u32).map(|i| [0, i - 1, i]).collect();
    Mesh { vertices: corners, triangles }
}

/// A square of two triangles about `centre`, edges `2 half`.
pub fn square_mesh(centre: &Vec3, normal: &Vec3, half: f64) -> Mesh {
    Mesh { vertices: square(centre, normal, half).to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]] }
}

/// One equilateral triangle in the plane that holds the disc of `radius` about `centre`.
pub fn triangle_around(centre: &Vec3, normal: &Vec3, radius: f64) -> [Vec3; 3] {
    let (u, v) = tangents(normal);
    // The corners of a triangle lie twice as far from its centre as its edges.
    let far = 2.0 * radius;
    let half_height = far * 0.75_f64.sqrt();
    [
        centre + u * far,
        centre - u * (far * 0.5) + v * half_height,
        centre - u * (far * 0.5) - v * half_height,
    ]
}

/// Foot of `from` on the plane.
pub fn project(from: &Vec3, point: &Vec3, normal: &Vec3) -> Vec3 {
    from - normal * normal.dot(&(from - point))
}

fn square(centre: &Vec3, normal: &Vec3, half: f64) -> [Vec3; 4] {
    let (u, v) = tangents(normal);
    let (u, v) = (u * half, v * half);
    [centre - u - v, centre + u - v, centre + u + v, centre - u + v]
}

/// Two unit vectors that make a right-handed frame with `normal`.
fn tangents(normal: &Vec3) -> (Vec3, Vec3) {
    let mut other = Vec3::zeros();
    other[normal.iamin()] = 1.0;
    let u = normal.cross(&other).normalize();
    (u, normal.cross(&u))
}

/// The part of a convex polygon where `side` ≥ 0.
fn clipped(polygon: &[Vec3], side: impl Fn(&Vec3) -> f64) -> Vec<Vec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, here) in polygon.iter().enumerate() {
        let next = &polygon[(index + 1) % polygon.len()];
        let (a, b) = (side(here), side(next));
        if a >= 0.0 {
            kept.push(*here);
        }
        if (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0) {
            kept.push(here + (next - here) * (a / (a - b)));
        }
    }
    kept
}

/// The box around everything that `mesh` sweeps in `time`. For rotations: whole turns.
pub fn swept(mesh: &Mesh, motion: &Motion, time: f64) -> Bounds {
    let start = mesh.bounds();
    match motion {
        Motion::Still | Motion::Servo { .. } => start,
        Motion::Oscillate { amplitude, .. } => {
            let reach = amplitude.abs() * 2.0;
            Bounds { low: start.low - reach, high: start.high + reach }
        }
        Motion::Translate { velocity } => {
            let shift = velocity * time;
            start.union(&Bounds { low: start.low + shift, high: start.high + shift })
        }
        Motion::Rotate { origin, axis, .. } => {
            mesh.vertices.iter().fold(start, |bounds, vertex| {
                let arm = vertex - origin;
                let along = axis.dot(&arm);
                let centre = origin + axis * along;
                let radius = (arm - axis * along).norm();
                // A circle about `axis` reaches r sqrt(1 - aₖ²) along axis k.
                let reach = axis.map(|a| radius * (1.0 - a * a).max(0.0).sqrt());
                bounds.with(&(centre - reach)).with(&(centre + reach))
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box() -> Bounds {
        Bounds { low: Vec3::zeros(), high: Vec3::repeat(1.0) }
    }

    #[test]
    fn clipped_planes_have_the_area_of_the_section() {
        let centre = Vec3::repeat(0.5);
        let level = plane_in(&unit_box(), &centre, &Vec3::z());
        assert!((level.area() - 1.0).abs() < 1e-12);
        let diagonal = plane_in(&unit_box(), &centre, &Vec3::new(1.0, 0.0, 1.0).normalize());
        assert!((diagonal.area() - 2.0_f64.sqrt()).abs() < 1e-9);
        // The hexagon through the middle of a unit cube: 3 sqrt(3) / 4.
        let hexagon = plane_in(&unit_box(), &centre, &Vec3::repeat(1.0).normalize());
        assert_eq!(hexagon.triangles.len(), 4);
        assert!((hexagon.area() - 0.75 * 3.0_f64.sqrt()).abs() < 1e-9);
        let outside = plane_in(&unit_box(), &Vec3::new(0.0, 0.0, 3.0), &Vec3::z());
        assert!(outside.triangles.is_empty());
    }

    #[test]
    fn triangles_hold_their_disc_and_face_the_normal() {
        let normal = Vec3::new(1.0, -2.0, 0.5).normalize();
        let centre = Vec3::new(0.1, 0.2, 0.3);
        let [a, b, c] = triangle_around(&centre, &normal, 2.0);
        assert!(((b - a).cross(&(c - a)).normalize() - normal).norm() < 1e-12);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let edge = (q - p).normalize();
            let foot = p + edge * edge.dot(&(centre - p));
            assert!(((foot - centre).norm() - 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn swept_rooms_hold_every_moment() {
        let mesh = square_mesh(&Vec3::new(0.3, 0.0, 0.1), &Vec3::x(), 0.2);
        let motions = [
            Motion::Translate { velocity: Vec3::new(0.1, -0.3, 0.0) },
            Motion::Rotate {
                origin: Vec3::new(0.0, 0.1, 0.0),
                axis: Vec3::new(1.0, 1.0, 0.0).normalize(),
                rate: 4.0,
            },
        ];
        for motion in motions {
            let room = swept(&mesh, &motion, 2.0).grown(1e-12);
            for step in 0..=100 {
                for vertex in &mesh.vertices {
                    assert!(room.contains(&motion.place(vertex, 0.02 * f64::from(step))));
                }
            }
        }
    }
}
