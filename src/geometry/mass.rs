//! Volume, centroid and inertia of a body of unit density.

use crate::num::{Mat3, Rotation, Vec3, eigen};
use serde::{Deserialize, Serialize};

/// Volume (m³), centroid (m) and inertia tensor (m⁵, unit density, about the
/// centroid, in the axes the body is given in).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MassProperties {
    /// Volume, m³.
    pub volume: f64,
    /// Centroid, m.
    pub centroid: Vec3,
    /// Inertia tensor about the centroid for density 1, m⁵.
    pub inertia: Mat3,
}

impl MassProperties {
    /// Principal moments in rising order, m⁵, and the rotation whose columns
    /// are the principal axes: it turns principal-frame vectors into the frame
    /// the body is given in.
    pub fn principal(&self) -> (Vec3, Rotation) {
        let (moments, mut axes) = eigen::symmetric(&self.inertia);
        // The largest component of the first two axes is made positive, so that
        // the frame does not flip with rounding; the third completes a right-handed set.
        for column in 0..2 {
            let axis = axes.column(column).into_owned();
            if axis[axis.iamax()] < 0.0 {
                axes.set_column(column, &-axis);
            }
        }
        let third = axes.column(0).cross(&axes.column(1));
        axes.set_column(2, &third);
        // Not `Rotation::from_matrix`: its iteration never ends for some 1 in 200 exact rotations.
        let axes = nalgebra::Rotation3::from_matrix_unchecked(axes);
        (moments, Rotation::from_rotation_matrix(&axes))
    }

    /// Diameter of the sphere of equal volume, m.
    pub fn equivalent_diameter(&self) -> f64 {
        (6.0 * self.volume / std::f64::consts::PI).cbrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::{rotation, stream};

    #[test]
    fn the_principal_frame_is_found_from_any_side() {
        let mut source = stream(41, "mass", 0);
        let half_turns = [Vec3::x(), Vec3::y(), Vec3::z(), Vec3::new(1.0, 1.0, 0.0)]
            .map(|axis| Rotation::new(axis.normalize() * std::f64::consts::PI));
        let turns = (0..200).map(|_| rotation(&mut source)).chain(half_turns);
        for (case, turn) in turns.enumerate() {
            // Three different moments, two nearly equal ones, and a ball.
            let moments =
                [Vec3::new(1.0, 2.0, 2.5), Vec3::new(1.0, 1.0 + 1e-9, 1.9), Vec3::repeat(1.0)];
            for moments in moments {
                let matrix = turn.to_rotation_matrix();
                let inertia = matrix * Mat3::from_diagonal(&moments) * matrix.transpose();
                let mass = MassProperties { volume: 1.0, centroid: Vec3::zeros(), inertia };
                let (found, axes) = mass.principal();
                assert!((found - moments).norm() < 1e-12, "case {case}");
                let matrix = axes.to_rotation_matrix();
                let back = matrix.transpose() * inertia * matrix;
                assert!((back - Mat3::from_diagonal(&found)).norm() < 1e-12, "case {case}");
            }
        }
    }
}
