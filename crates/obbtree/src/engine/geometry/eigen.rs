//! The eigenvectors of symmetric 3 x 3 matrices by C. G. J. Jacobi's rotations (1846). The method is short, branches only on zeros of the
//! matrix, and is as accurate for small eigenvalues as for large ones. Every oriented box of a tree calls it once; with nalgebra's general
//! iteration a build took a tenth longer.

use nalgebra::{Matrix3, Vector3};

/// Largest number of rounds. Usually three or four find the axes to the last bit; from the second round on, each squares the remaining
/// error.
const ROUNDS: usize = 12;

/// The eigenvalues, and the eigenvectors as columns of a rotation, in no particular order. Rounds continue until no off-diagonal entry is
/// above `left` times the largest diagonal entry. A matrix that is not finite gives the coordinate axes or other finite axes.
#[must_use]
pub fn axes(matrix: &Matrix3<f64>, left: f64) -> (Vector3<f64>, Matrix3<f64>) {
    let (mut m, mut axes) = (*matrix, Matrix3::identity());
    for _ in 0..ROUNDS {
        let outside = m[(0, 1)].abs().max(m[(0, 2)].abs()).max(m[(1, 2)].abs());
        // What is no number ends it too.
        if outside.is_nan() || outside <= left * m.diagonal().amax() {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            turn_out(&mut m, &mut axes, p, q);
        }
    }
    (m.diagonal(), axes)
}

/// Rotates the axes `p` and `q` in their plane so that the entry between them becomes 0.
#[inline(always)]
fn turn_out(m: &mut Matrix3<f64>, axes: &mut Matrix3<f64>, p: usize, q: usize) {
    let between = m[(p, q)];
    // It is 0, or no number to turn by.
    if !between.is_normal() {
        return;
    }
    let cotangent = (m[(q, q)] - m[(p, p)]) / (2.0 * between);
    let tangent = cotangent.signum() / (cotangent.abs() + (cotangent * cotangent + 1.0).sqrt());
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    m[(p, p)] -= tangent * between;
    m[(q, q)] += tangent * between;
    (m[(p, q)], m[(q, p)]) = (0.0, 0.0);
    let r = 3 - p - q;
    let (along_p, along_q) = (cosine * m[(r, p)] - sine * m[(r, q)], sine * m[(r, p)] + cosine * m[(r, q)]);
    (m[(r, p)], m[(p, r)], m[(r, q)], m[(q, r)]) = (along_p, along_p, along_q, along_q);
    for k in 0..3 {
        let (x, y) = (axes[(k, p)], axes[(k, q)]);
        (axes[(k, p)], axes[(k, q)]) = (cosine * x - sine * y, sine * x + cosine * y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::geometry::Vector;
    use nalgebra::Rotation3;
    use proptest::prelude::*;

    /// A matrix with these eigenvalues.
    fn matrix(values: Vector, turn: Vector) -> Matrix3<f64> {
        let rotation = Rotation3::from_scaled_axis(turn).into_inner();
        let m = rotation * Matrix3::from_diagonal(&values) * rotation.transpose();
        (m + m.transpose()) * 0.5
    }

    /// The largest off-diagonal entry of a matrix in the frame of some axes.
    fn outside(m: &Matrix3<f64>, axes: &Matrix3<f64>) -> f64 {
        let along = axes.tr_mul(m) * axes;
        (along - Matrix3::from_diagonal(&along.diagonal())).amax()
    }

    proptest! {
        /// The axes form a rotation, no off-diagonal entry exceeds the permitted one, and the diagonal entries are the eigenvalues that
        /// nalgebra finds.
        #[test]
        fn axes_are_eigenvectors(
            values in prop::array::uniform3(prop_oneof![0.001..1.0_f64, Just(0.25), Just(1e-9)]),
            turn in prop::array::uniform3(-4.0..4.0_f64),
            exponent in -12..12_i32,
        ) {
            let m = matrix(values.into(), turn.into()) * 10f64.powi(exponent);
            let largest = m.symmetric_eigenvalues().amax();
            for left in [1e-6, 1e-16] {
                let (along, axes) = axes(&m, left);
                prop_assert!((axes.tr_mul(&axes) - Matrix3::identity()).amax() < 1e-13 && axes.determinant() > 0.0);
                prop_assert!(outside(&m, &axes) <= (1.001 * left + 1e-14) * largest);
                let (mut found, mut known) = (along, m.symmetric_eigenvalues());
                found.as_mut_slice().sort_by(f64::total_cmp);
                known.as_mut_slice().sort_by(f64::total_cmp);
                prop_assert!((found - known).amax() <= (left + 1e-14) * largest, "{found} {known}");
            }
        }
    }

    /// A matrix that converges slowly: three rounds leave 6e-7 of its off-diagonal entries, and more for other matrices.
    #[test]
    fn axes_found_slowly_are_found() {
        let values = Vector::new(0.34169873747211166, 1e-9, 0.8532916273500528);
        let m = matrix(values, Vector::new(2.2370556892474585, 0.0, 0.05665907309082612));
        assert!(outside(&m, &axes(&m, 1e-6).1) <= 1e-6 * 0.8533);
    }

    #[test]
    fn what_is_not_a_number_or_zero_has_some_axes() {
        for x in [0.0, f64::NAN, f64::INFINITY] {
            let (_, axes) = axes(&Matrix3::repeat(x), 1e-6);
            assert!(axes.iter().all(|x| x.is_finite()), "{axes}");
        }
    }
}
