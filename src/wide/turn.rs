//! A rotation in three numbers: the vector part of its unit quaternion, whose scalar part is what is missing to length 1.
//!
//! The axes of a box may be renumbered and turned over. Of the 24 rotations that describe the same box we keep the
//! one nearest to the identity. Its angle is at most 62.8° (the largest disorientation of two cubes: J. K. Mackenzie, Biometrika 45,
//! 1958), so that the vector part is at most sin 31.4° = 0.521 long and the scalar part at least 0.853.

use crate::geometry::Vector;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

/// The three numbers, for the box frame whose axes are the columns of `frame` (a rotation).
pub(super) fn encode(frame: &Matrix3<f64>) -> [f32; 3] {
    let nearest = nearest_to_identity(frame);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(nearest));
    let sign = if turn.w < 0.0 { -1.0 } else { 1.0 };
    [turn.i, turn.j, turn.k].map(|x| (sign * x) as f32)
}

/// The axes, as columns. Each entry is within 16·2⁻⁵³ of the rotation that the three numbers stand for.
#[inline(always)]
pub(super) fn decode(turn: [f32; 3]) -> Matrix3<f64> {
    let [x, y, z] = turn.map(f64::from);
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let (xx, yy, zz) = (x * x2, y * y2, z * z2);
    let w = (1.0 - 0.5 * (xx + yy + zz)).sqrt();
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    Matrix3::new(
        1.0 - yy - zz,
        xy - wz,
        xz + wy, //
        xy + wz,
        1.0 - xx - zz,
        yz - wx, //
        xz - wy,
        yz + wx,
        1.0 - xx - yy,
    )
}

/// The relabelling of a box's axes with the largest trace: the trace of a rotation grows as its angle shrinks.
fn nearest_to_identity(frame: &Matrix3<f64>) -> Matrix3<f64> {
    const EVEN: [[usize; 3]; 3] = [[0, 1, 2], [1, 2, 0], [2, 0, 1]];
    const ODD: [[usize; 3]; 3] = [[0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let mut best = (f64::NEG_INFINITY, *frame);
    for (order, parity) in EVEN.map(|order| (order, 1.0)).into_iter().chain(ODD.map(|order| (order, -1.0))) {
        let diagonal = Vector::from_fn(|k, _| frame[(k, order[k])]);
        let mut sign = diagonal.map(|x| if x < 0.0 { -1.0 } else { 1.0 });
        if sign.product() * parity < 0.0 {
            // One axis must be turned over again: the one that costs least.
            let k = diagonal.iamin();
            sign[k] = -sign[k];
        }
        let trace = diagonal.dot(&sign);
        if trace > best.0 {
            let axes = [0, 1, 2].map(|k| frame.column(order[k]) * sign[k]);
            best = (trace, Matrix3::from_columns(&axes));
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_frame_along_the_axes_is_the_identity_however_they_are_called() {
        let (x, y, z) = (Vector::x(), Vector::y(), Vector::z());
        for frame in [[x, y, z], [y, z, x], [-y, x, z], [z, y, -x], [-x, -y, z]] {
            let frame = Matrix3::from_columns(&frame);
            assert_eq!(frame.determinant(), 1.0);
            assert_eq!(encode(&frame), [0.0; 3]);
        }
        assert_eq!(decode([0.0; 3]), Matrix3::identity());
    }

    proptest! {
        /// The decoded axes are those of the frame up to order and sign, and the vector part keeps its bound.
        #[test]
        fn the_axes_come_back(turn in prop::array::uniform3(-4.0..4.0_f64)) {
            let frame = Rotation3::from_scaled_axis(Vector::from(turn)).into_inner();
            let code = encode(&frame);
            prop_assert!(code.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>() < 0.2717);
            let back = decode(code);
            prop_assert!((back.tr_mul(&back) - Matrix3::identity()).amax() < 4e-15);
            prop_assert!((back.determinant() - 1.0).abs() < 1e-14);
            for column in 0..3 {
                let same = (0..3).any(|k| frame.column(k).dot(&back.column(column)).abs() > 1.0 - 1e-12);
                prop_assert!(same, "{frame} {back}");
            }
        }
    }
}
