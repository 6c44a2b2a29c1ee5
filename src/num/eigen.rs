//! Eigenvalues and eigenvectors of symmetric 3 × 3 matrices, by cyclic Jacobi
//! rotations (Jacobi 1846; Golub & Van Loan, Matrix Computations, 8.5).
//!
//! Used instead of nalgebra's `symmetric_eigen`, which returns the values in no
//! order and has no limit on its iterations. Jacobi's method converges for
//! every finite matrix, quadratically near the end; 5 sweeps are
//! usual and 32 the limit. Eigenvectors are orthonormal to rounding.

use super::{Mat3, Vec3};

/// Eigenvalues in rising order and the matrix whose columns are the unit
/// eigenvectors in the same order (not necessarily right-handed). Only the
/// upper triangle is read.
pub fn symmetric(matrix: &Mat3) -> (Vec3, Mat3) {
    let mut a = *matrix;
    let mut axes = Mat3::identity();
    // Tiny (m⁵ of sand grains) and huge matrices alike: squares must not underflow.
    let scale = a.upper_triangle().amax();
    if scale > 0.0 && scale.is_finite() {
        a /= scale;
        for _ in 0..32 {
            let off = a[(0, 1)].abs() + a[(0, 2)].abs() + a[(1, 2)].abs();
            if off == 0.0 {
                break;
            }
            for (p, q, r) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
                rotate(&mut a, &mut axes, p, q, r);
            }
        }
        a *= scale;
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[(i, i)].total_cmp(&a[(j, j)]));
    let values = Vec3::from_fn(|row, _| a[(order[row], order[row])]);
    (values, Mat3::from_fn(|row, column| axes[(row, order[column])]))
}

/// Makes element (p, q), p < q, of the upper triangle zero; r is the third index.
fn rotate(a: &mut Mat3, axes: &mut Mat3, p: usize, q: usize, r: usize) {
    let off = a[(p, q)];
    // The matrix has norm 1: below this, turning changes nothing that is kept.
    if off.abs() < 1e-30 {
        a[(p, q)] = 0.0;
        return;
    }
    let theta = (a[(q, q)] - a[(p, p)]) / (2.0 * off);
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    a[(p, p)] -= t * off;
    a[(q, q)] += t * off;
    a[(p, q)] = 0.0;
    let (rp, rq) = ((r.min(p), r.max(p)), (r.min(q), r.max(q)));
    let (x, y) = (a[rp], a[rq]);
    a[rp] = c * x - s * y;
    a[rq] = s * x + c * y;
    for row in 0..3 {
        let (x, y) = (axes[(row, p)], axes[(row, q)]);
        axes[(row, p)] = c * x - s * y;
        axes[(row, q)] = s * x + c * y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn eigenpairs_are_eigenpairs(seed in any::<u64>(), exponent in -150i32..150, flat in 0u8..4) {
            let mut source = random::stream(seed, "eigen", 0);
            let turn = random::rotation(&mut source).to_rotation_matrix();
            let mut values = Vec3::from_fn(|_, _| random::uniform(&mut source, -1.0, 1.0));
            if flat & 1 == 1 { values[1] = values[0]; }
            if flat & 2 == 2 { values[2] = values[1] * (1.0 + 1e-13); }
            values *= 10f64.powi(exponent);
            let matrix = turn.matrix() * Mat3::from_diagonal(&values) * turn.matrix().transpose();
            let (found, axes) = symmetric(&matrix);
            let size = matrix.norm();
            prop_assert!((axes.transpose() * axes - Mat3::identity()).norm() < 1e-14);
            prop_assert!((matrix * axes - axes * Mat3::from_diagonal(&found)).norm() <= 4e-15 * size);
            prop_assert!(found[0] <= found[1] && found[1] <= found[2]);
        }
    }

    #[test]
    fn special_matrices() {
        assert_eq!(symmetric(&Mat3::zeros()).0, Vec3::zeros());
        let (values, axes) = symmetric(&Mat3::from_diagonal(&Vec3::new(3.0, 1.0, 2.0)));
        assert_eq!(values, Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(axes.column(0).into_owned(), Vec3::y());
        let (ones, _) = symmetric(&Mat3::repeat(1.0));
        assert!((ones - Vec3::new(0.0, 0.0, 3.0)).norm() < 1e-15);
    }
}
