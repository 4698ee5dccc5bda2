//! A rotation in three numbers: the vector part of its unit quaternion, whose scalar part is what is missing to length 1.
//!
//! The axes of a box may be renumbered and turned over. Of the 24 rotations that describe the same box we keep the
//! one nearest to the identity. Its angle is at most 62.8° (the largest disorientation of two cubes: J. K. Mackenzie, Biometrika 45,
//! 1958), so that the vector part is at most sin 31.4° = 0.521 long and the scalar part at least 0.853.

use nalgebra::Matrix3;

/// The three numbers, for the box frame whose axes are the columns of `frame` (a rotation).
pub(super) fn encode(frame: &Matrix3<f64>) -> [f32; 3] {
    let m = nearest_to_identity(frame);
    // Four times the scalar part, which is far from 0.
    let w4 = 2.0 * (1.0 + m.trace()).sqrt();
    [m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]].map(|x| (x / w4) as f32)
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
    /// Which axis becomes the first, second and third; the first three orders are even.
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let (mut largest, mut best) = (f64::NEG_INFINITY, (ORDERS[0], None));
    for (n, order) in ORDERS.into_iter().enumerate() {
        let on = [frame[(0, order[0])], frame[(1, order[1])], frame[(2, order[2])]];
        let [x, y, z] = on.map(f64::abs);
        let turned_over = on.iter().filter(|&&x| x < 0.0).count();
        // An even order of axes needs an even number of them turned over, else one more: the one that costs least.
        let least = if y < x {
            if z < y { 2 } else { 1 }
        } else if z < x {
            2
        } else {
            0
        };
        let one_more = ((turned_over % 2 == 0) != (n < 3)).then_some(least);
        let side = |k, x: f64| if one_more == Some(k) { -x } else { x };
        let trace = side(0, x) + side(1, y) + side(2, z);
        if trace > largest {
            (largest, best) = (trace, (order, one_more));
        }
    }
    let (order, one_more) = best;
    Matrix3::from_columns(&[0, 1, 2].map(|k| {
        let over = (frame[(k, order[k])] < 0.0) != (one_more == Some(k));
        frame.column(order[k]) * if over { -1.0 } else { 1.0 }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use nalgebra::Rotation3;
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
