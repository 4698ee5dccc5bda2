//! Poses as rigid motions.
//!
//! A quaternion of length 1 + e makes a matrix that stretches by 2e. The ground truth, the leaves and all volumes take their rotation from
//! this module, so they use the same orthogonal matrix whatever the length.

use super::Isometry;
use nalgebra::{Matrix3, UnitQuaternion};
use std::ops::RangeInclusive;

/// Permitted deviation from 1 of the squared length of a unit quaternion: 2⁻⁴⁶. Products of dozens of unit quaternions stay below it; the
/// relative widening of the trees' volumes is 64 times as large.
pub const UNIT_TOLERANCE: f64 = 1.0 / 70_368_744_177_664.0;

/// Squared lengths from which a root loses no digit. Beyond them the squares of the components may underflow or overflow.
const PLAIN_SQUARES: RangeInclusive<f64> = 1e-200..=1e200;

/// Whether the quaternion's length is 1 within [`UNIT_TOLERANCE`].
#[inline]
#[must_use]
pub fn is_unit(a_from_b: &Isometry) -> bool {
    (a_from_b.rotation.coords.norm_squared() - 1.0).abs() <= UNIT_TOLERANCE
}

/// The pose with its quaternion scaled to length 1. A quaternion whose length is 1 within [`UNIT_TOLERANCE`] is returned unchanged. A
/// quaternion that is zero or has a component that is not finite is returned unchanged too, and is no motion.
#[inline]
#[must_use]
pub fn rigid(a_from_b: &Isometry) -> Isometry {
    if is_unit(a_from_b) { *a_from_b } else { rescaled(a_from_b) }
}

#[cold]
fn rescaled(a_from_b: &Isometry) -> Isometry {
    let mut quaternion = *a_from_b.rotation.quaternion();
    if quaternion.coords.amax() == 0.0 || !quaternion.coords.iter().all(|x| x.is_finite()) {
        return *a_from_b;
    }
    if !PLAIN_SQUARES.contains(&quaternion.norm_squared()) {
        quaternion /= quaternion.coords.amax();
    }
    Isometry::from_parts(a_from_b.translation, UnitQuaternion::from_quaternion(quaternion))
}

/// The inverse of [`rigid`]. The plain inverse of a pose whose quaternion has length 1 + e has an error of 2e of the translation.
#[inline]
#[must_use]
pub fn inverse(a_from_b: &Isometry) -> Isometry {
    rigid(a_from_b).inverse()
}

/// The rotation of [`rigid`] as a matrix, which maps directions of `b` to directions of `a`.
#[inline]
#[must_use]
pub fn rotation(a_from_b: &Isometry) -> Matrix3<f64> {
    rigid(a_from_b).rotation.to_rotation_matrix().into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::geometry::Vector;
    use nalgebra::Quaternion;

    fn scaled(pose: &Isometry, factor: f64) -> Isometry {
        let quaternion: Quaternion<f64> = *pose.rotation.quaternion() * factor;
        Isometry::from_parts(pose.translation, UnitQuaternion::new_unchecked(quaternion))
    }

    #[test]
    fn a_unit_quaternion_keeps_its_bits_and_any_other_becomes_one() {
        for i in 0..200 {
            let turn = Vector::new(0.3 + 0.01 * f64::from(i), -1.1, 0.02 * f64::from(i));
            let pose = Isometry::new(Vector::new(10.0, -300.0, 2.5), turn);
            assert_eq!(rigid(&pose), pose);
            assert_eq!(rigid(&scaled(&pose, 1.0 + 1e-15)), scaled(&pose, 1.0 + 1e-15));
            for factor in [1.0 + 1e-7, 1.0 - 1e-7, 1.0 + 1e-13, 3.0, 1e-3] {
                let mended = rotation(&scaled(&pose, factor));
                assert!((mended.tr_mul(&mended) - Matrix3::identity()).amax() < 1e-15 * 4.0, "{factor}");
                assert!((mended - rotation(&pose)).amax() < 1e-15 * 4.0, "{factor}");
                let back = inverse(&scaled(&pose, factor)) * pose;
                assert!(back.translation.vector.amax() < 1e-12 && back.rotation.angle() < 1e-12, "{factor}");
            }
        }
    }

    /// Squares of such components underflow or overflow, or lose digits.
    #[test]
    fn a_quaternion_of_any_length_becomes_one() {
        let pose = Isometry::rotation(Vector::new(0.4, -1.3, 2.2));
        for factor in [1.7e-162, 1e-170, 1e-300, 1e-101, 1e101, 1e155, 1e200, 1e307] {
            let found = rigid(&scaled(&pose, factor));
            assert!(is_unit(&found) && !is_unit(&scaled(&pose, factor)), "{factor}");
            assert!((rotation(&scaled(&pose, factor)) - rotation(&pose)).amax() < 1e-15 * 4.0, "{factor}");
        }
        let least = UnitQuaternion::new_unchecked(Quaternion::new(0.0, 5e-324, 0.0, -5e-324));
        let found = rigid(&Isometry::from_parts(pose.translation, least));
        let expected = nalgebra::Vector4::new(0.5_f64.sqrt(), 0.0, -0.5_f64.sqrt(), 0.0);
        assert!((found.rotation.coords - expected).amax() < 1e-15, "{found}");
    }

    #[test]
    fn what_is_no_motion_stays_as_it_is() {
        for factor in [0.0, f64::INFINITY, f64::NAN] {
            let pose = scaled(&Isometry::rotation(Vector::new(0.1, 0.2, 0.3)), factor);
            let same = |x: &f64, y: &f64| x.to_bits() == y.to_bits();
            assert!(rigid(&pose).rotation.coords.iter().zip(pose.rotation.coords.iter()).all(|(x, y)| same(x, y)));
        }
    }
}
