//! The pose of a rigid body from where its spheres are.
//!
//! Least squares rotation between two sets of points (Kabsch 1976; Arun,
//! Huang & Blostein 1987): the singular value decomposition of the
//! cross-covariance, with the sign that makes it a proper rotation. Exact to
//! rounding for a body that kept its shape. Spheres on one line do not fix the
//! turn about that line: then the smallest rotation from the earlier pose is taken.

use crate::num::{Mat3, Rotation, Vec3};

/// Second singular value over the first below which centres count as being on one line.
const ON_A_LINE: f64 = 1e-9;

/// Rotation that carries `offsets` (body frame, m) to `centres` (world, m), and
/// the place of the body's origin. `earlier` is the pose before.
pub fn pose(offsets: &[Vec3], centres: &[Vec3], earlier: &Rotation) -> (Rotation, Vec3) {
    let count = offsets.len().max(1) as f64;
    let body_mean = offsets.iter().sum::<Vec3>() / count;
    let world_mean = centres.iter().sum::<Vec3>() / count;
    let covariance: Mat3 = offsets
        .iter()
        .zip(centres)
        .map(|(o, c)| (c - world_mean) * (o - body_mean).transpose())
        .sum();
    let rotation = nearest_rotation(&covariance, earlier);
    (rotation, world_mean - rotation * body_mean)
}

/// True if the turn of spheres at `offsets` can be read from their places.
pub fn is_fixed_by(offsets: &[Vec3]) -> bool {
    let mean = offsets.iter().sum::<Vec3>() / offsets.len().max(1) as f64;
    let spread: Mat3 = offsets.iter().map(|o| (o - mean) * (o - mean).transpose()).sum();
    let values = spread.svd(false, false).singular_values;
    values[1] > ON_A_LINE * values[0]
}

fn nearest_rotation(covariance: &Mat3, earlier: &Rotation) -> Rotation {
    let svd = covariance.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return *earlier };
    let values = svd.singular_values;
    if values[1] <= ON_A_LINE * values[0] {
        let body = v_t.row(0).transpose();
        let world = u.column(0).into_owned();
        let turn = Rotation::rotation_between(&(earlier * body), &world);
        return turn.map_or(*earlier, |turn| turn * earlier);
    }
    let sign = if (u * v_t).determinant() < 0.0 { -1.0 } else { 1.0 };
    let matrix = u * Mat3::from_diagonal(&Vec3::new(1.0, 1.0, sign)) * v_t;
    Rotation::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(matrix))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random;

    #[test]
    fn poses_come_back() {
        let mut stream = random::stream(3, "pose", 0);
        for _ in 0..200 {
            let offsets: Vec<Vec3> =
                (0..4).map(|_| random::direction(&mut stream) * 1e-3).collect();
            let axis = random::direction(&mut stream) * random::uniform(&mut stream, 0.0, 3.0);
            let turn = Rotation::from_scaled_axis(axis);
            let place = random::direction(&mut stream);
            let centres: Vec<Vec3> = offsets.iter().map(|o| place + turn * o).collect();
            let (found, origin) = pose(&offsets, &centres, &Rotation::identity());
            assert!(found.angle_to(&turn) < 1e-11, "{}", found.angle_to(&turn));
            assert!((origin - place).norm() < 1e-14);
        }
    }

    #[test]
    fn flat_clumps_are_not_mirrored() {
        let offsets = [Vec3::x(), Vec3::y(), -Vec3::x() - Vec3::y()];
        let turn = Rotation::from_scaled_axis(Vec3::new(0.3, -2.0, 1.0));
        let centres: Vec<Vec3> = offsets.iter().map(|o| turn * o).collect();
        let (found, _) = pose(&offsets, &centres, &Rotation::identity());
        assert!(found.angle_to(&turn) < 1e-12);
        assert!(is_fixed_by(&offsets));
    }

    #[test]
    fn a_pair_turns_no_further_than_it_must() {
        let offsets = [Vec3::x(), -Vec3::x()];
        let turn = Rotation::from_scaled_axis(Vec3::z() * 0.4);
        let centres: Vec<Vec3> = offsets.iter().map(|o| turn * o).collect();
        let (found, origin) = pose(&offsets, &centres, &Rotation::identity());
        assert!(found.angle_to(&turn) < 1e-12);
        assert!(origin.norm() < 1e-15);
        assert!(!is_fixed_by(&offsets));
    }
}
