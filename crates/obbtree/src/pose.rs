//! Poses: what is a rigid motion, and what is not.

use crate::engine::geometry::rigid;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};
use std::fmt;

/// How far from orthogonal the rotation of a 4 × 4 matrix may be, as max|RᵀR - I|. Rounding to single precision leaves about 10⁻⁷.
const ORTHOGONAL: f64 = 1e-6;

/// Why a pose cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PoseError {
    /// A number of the pose is NaN or infinite.
    NotFinite,
    /// The quaternion is zero.
    NoRotation,
    /// The matrix scales, shears or mirrors, or its last row is not (0, 0, 0, 1).
    NotRigid,
    /// The translation between two meshes, or of an object of a manager, is too large for a distance.
    TooFar {
        /// Largest translation along an axis, in the unit of the meshes.
        limit: f64,
    },
}

impl fmt::Display for PoseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => f.write_str("the pose has a number that is not finite"),
            Self::NoRotation => f.write_str("the pose's quaternion is zero; no rotation is (0, 0, 0, 1)"),
            Self::NotRigid => f.write_str(
                "the matrix is not a rotation and a translation: it scales, shears or mirrors, or its last row is not 0 0 0 1",
            ),
            Self::TooFar { limit } => {
                write!(f, "the translation is above {limit:?} on one axis: too far for a distance")
            }
        }
    }
}

impl std::error::Error for PoseError {}

/// The pose with a quaternion of length 1.
pub(crate) fn checked(pose: &Isometry3<f64>) -> Result<Isometry3<f64>, PoseError> {
    let (rotation, translation) = (&pose.rotation.coords, &pose.translation.vector);
    if !rotation.iter().chain(translation).all(|x| x.is_finite()) {
        return Err(PoseError::NotFinite);
    }
    if rotation.amax() == 0.0 {
        return Err(PoseError::NoRotation);
    }
    Ok(rigid::rigid(pose))
}

/// The pose of a 4 × 4 matrix, row by row, which takes column vectors of one frame to another.
///
/// The rotation R may be off by what single precision rounds: e = max|RᵀR - I| is at most 10⁻⁶. The pose has the rotation nearest to R, so that a scale
/// within 5·10⁻⁷ of 1 and a shear below 10⁻⁶ are not seen. It moves a point to within 2e times the point's distance from the origin of where the matrix
/// moves it: to be sure that meshes are apart, add 2e times the largest such distance to the limit of [`distance_below`](crate::Collider::distance_below).
///
/// ```
/// let lifted = obbtree::pose_from_matrix([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 5.0], [0.0, 0.0, 0.0, 1.0]])?;
/// assert_eq!(lifted.translation.z, 5.0);
/// # Ok::<(), obbtree::PoseError>(())
/// ```
///
/// # Errors
/// [`PoseError::NotFinite`], or [`PoseError::NotRigid`] when the matrix is not a rotation and a translation.
pub fn pose_from_matrix(rows: [[f64; 4]; 4]) -> Result<Isometry3<f64>, PoseError> {
    if !rows.as_flattened().iter().all(|x| x.is_finite()) {
        return Err(PoseError::NotFinite);
    }
    let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
    let defect = matrix.tr_mul(&matrix) - Matrix3::identity();
    let is_rotation = defect.amax() <= ORTHOGONAL && matrix.determinant() > 0.0;
    if !is_rotation || rows[3] != [0.0, 0.0, 0.0, 1.0] {
        return Err(PoseError::NotRigid);
    }
    // Singular values are within d = 1.5 e of 1, since |RᵀR - I| is at most 3 e as a norm, and R is that far from the nearest rotation. One step of
    // Newton's leaves 1.5 d² of it, below 4·10⁻⁶ e. Together they are below 2 e.
    let nearest = matrix - matrix * defect * 0.5;
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(nearest));
    let translation = Translation3::new(rows[0][3], rows[1][3], rows[2][3]);
    Ok(Isometry3::from_parts(translation, UnitQuaternion::new_normalize(turn.into_inner())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix4, Quaternion, Vector3};

    fn rows_of(matrix: &Matrix4<f64>) -> [[f64; 4]; 4] {
        [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| matrix[(i, j)]))
    }

    #[test]
    fn a_matrix_and_its_pose_move_points_alike() {
        for i in 0..200 {
            let turn = Vector3::new(0.03, -0.02, 0.01) * f64::from(i);
            let pose = Isometry3::new(Vector3::new(1.0, -2.0, 3.0), turn);
            let matrix = pose.to_homogeneous();
            let rows = rows_of(&matrix);
            let found = pose_from_matrix(rows).unwrap();
            assert!((found.to_homogeneous() - matrix).amax() < 1e-14, "{i}");
            let single = rows.map(|row| row.map(|x| f64::from(x as f32)));
            assert!((pose_from_matrix(single).unwrap().to_homogeneous() - matrix).amax() < 1e-6, "{i}");
        }
    }

    #[test]
    fn the_rotation_is_the_nearest_to_the_matrix() {
        // A rotation times I + S, where S is symmetric and small, has that rotation as its nearest.
        let (s, corner): (f64, Vector3<f64>) = (4.9e-7, Vector3::repeat(1.0));
        let stretches = [
            Matrix3::new(s, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, s),
            Matrix3::new(s, 0.0, 0.0, 0.0, -s, 0.0, 0.0, 0.0, 0.0),
            Matrix3::new(0.0, s, 0.0, s, 0.0, 0.0, 0.0, 0.0, -s),
            Matrix3::new(s, s, s, s, s, s, s, s, s),
        ];
        for (i, stretch) in (0..200).map(|i| (i, stretches[i % 4])) {
            let turn = Rotation3::new(Vector3::new(0.03, -0.05, 0.02) * i as f64).into_inner();
            let matrix: Matrix3<f64> = turn + turn * stretch;
            let found = pose_from_matrix(rows_of(&matrix.to_homogeneous())).unwrap();
            let found = found.rotation.to_rotation_matrix().into_inner();
            assert!((found - turn).amax() < 2e-11, "{i}");
            let off = (matrix.tr_mul(&matrix) - Matrix3::identity()).amax();
            let part = ((found - matrix) * corner).norm() / corner.norm() / off;
            assert!(part < 2.0 && (i % 4 != 3 || part > 1.49), "{i}: {part}");
        }
    }

    #[test]
    fn what_is_not_rigid_is_refused() {
        let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        for (row, column, value) in
            [(0, 0, 2.0), (0, 0, -1.0), (0, 1, 0.1), (0, 1, 5e-5), (1, 1, 1.000001), (3, 0, 1.0), (3, 3, 2.0)]
        {
            let mut rows = identity;
            rows[row][column] = value;
            assert_eq!(pose_from_matrix(rows), Err(PoseError::NotRigid), "{row} {column} {value}");
            rows[row][column] = f64::NAN;
            assert_eq!(pose_from_matrix(rows), Err(PoseError::NotFinite), "{row} {column}");
        }
        for (scale, is_rigid) in [(1.00001, false), (1.00004, false), (0.99999, false), (1.0000002, true)] {
            let rows =
                [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| if i < 3 { scale * identity[i][j] } else { identity[i][j] }));
            assert_eq!(pose_from_matrix(rows).is_ok(), is_rigid, "{scale}");
        }
    }

    #[test]
    fn a_pose_must_be_finite_and_have_a_rotation() {
        let nowhere = Isometry3::translation(0.0, f64::INFINITY, 0.0);
        assert_eq!(checked(&nowhere), Err(PoseError::NotFinite));
        let unturned = |w| {
            Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::new_unchecked(Quaternion::new(w, 0.0, 0.0, 0.0)),
            )
        };
        assert_eq!(checked(&unturned(0.0)), Err(PoseError::NoRotation));
        assert_eq!(checked(&unturned(f64::NAN)), Err(PoseError::NotFinite));
        for w in [3.0, 1.7e-162, 1e-170, 5e-324, 1e200, f64::MAX] {
            assert_eq!(checked(&unturned(w)), Ok(Isometry3::identity()), "{w}");
        }
    }
}
