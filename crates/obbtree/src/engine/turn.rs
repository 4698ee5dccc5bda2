//! A rotation in three numbers: the vector part of its unit quaternion, whose scalar part is what is missing to length 1.
//!
//! The axes of a box may be renumbered and turned over. Of the 24 rotations that describe the same box we keep the
//! one nearest to the identity. Its angle is at most 62.8° (the largest disorientation of two cubes: J. K. Mackenzie, Biometrika 45,
//! 1958), so that the vector part is at most sin 31.4° = 0.521 long and the scalar part at least 0.853.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use std::f64::consts::FRAC_1_SQRT_2;

/// Less than this is left of nothing by a few operations on unit vectors: boxes along the mesh's axes stay exactly along them.
const ROUNDING: f64 = 1e-15;

/// The three numbers, for the box frame whose axes are the columns of `frame` (a rotation).
pub(super) fn encode(frame: &Matrix3<f64>) -> [f32; 3] {
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*frame));
    let [x, y, z, w]: [f64; 4] = rotation.coords.into();
    let relabelling = nearest_relabelling([w, x, y, z]);
    let ([e, u @ ..], v) = (relabelling, Vector3::new(x, y, z));
    let u = Vector3::from(u);
    // The vector part of (w + v)(e - u), whose scalar part is positive.
    (v * e - u * w - v.cross(&u)).map(|x| if x.abs() < ROUNDING { 0.0 } else { x as f32 }).into()
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

/// The rotation of a cube onto itself that is nearest to a rotation, as quaternions (scalar part first): the one with the largest inner product. A
/// cube's rotations are the quaternions with one component that is not 0, with two equal ones, and with four, of any signs.
fn nearest_relabelling(rotation: [f64; 4]) -> [f64; 4] {
    let size = rotation.map(f64::abs);
    let larger = |i: usize, j: usize| if size[j] > size[i] { j } else { i };
    let first = larger(larger(0, 1), larger(2, 3));
    let second = (0..4).filter(|&k| k != first).fold((first + 1) % 4, larger);
    let one = size[first];
    let two = FRAC_1_SQRT_2 * (size[first] + size[second]);
    let four = 0.5 * (size[0] + size[1] + size[2] + size[3]);
    let component = |k: usize| {
        if four > two && four > one {
            0.5
        } else if k == first {
            if two > one { FRAC_1_SQRT_2 } else { 1.0 }
        } else if k == second && two > one {
            FRAC_1_SQRT_2
        } else {
            0.0
        }
    };
    [0, 1, 2, 3].map(|k| component(k).copysign(rotation[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::geometry::Vector;
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
