//! The constants of one relative pose.

use super::lanes::{FOUR, Row, WideRow};
use super::volume::U;
use crate::engine::geometry::{Isometry, grid, rigid};

/// Rounding in `f64` of a moved point or box, relative to the distances involved: 2⁻⁴⁴, five hundred times 2⁻⁵³; the
/// products and sums of a motion and its inverse are fewer than a hundred.
const MOTION_PAD: f64 = 1.0 / 17_592_186_044_416.0;
/// How much of a rotation matrix's defect counts. A quaternion longer than 1 by e makes a matrix whose defect is 4e; the way between the centres is
/// then wrong by 4e and boxes by 10e of what they are long ([`super::boxes`], steps 4 to 6), the points themselves by three defects.
const DEFECT_FACTOR: f64 = 64.0;

/// A motion from one mesh's frame to the other's.
#[derive(Clone, Debug)]
pub struct Motion {
    /// The columns of the rotation; the last number of each is nothing.
    rotation: [[f64; FOUR]; 3],
    translation: [f64; FOUR],
    /// What the components x, y, z, w of a quaternion are multiplied by in the product of the rotation's own with it.
    product: [[f32; FOUR]; 4],
    /// Where the axes of the mesh's own frame are turned to.
    axes: [[f32; FOUR]; 3],
}

impl Motion {
    /// By a rotation, as the columns of its matrix and as a quaternion (x, y, z, w), and a translation, mm.
    #[inline]
    fn new(columns: &[[f64; 3]; 3], quaternion: [f64; 4], translation: [f64; 3]) -> Self {
        let row = |[x, y, z]: [f64; 3]| [x, y, z, 0.0];
        let [x, y, z, w] = quaternion.map(|x| x as f32);
        Self {
            rotation: columns.map(row),
            translation: row(translation),
            product: [[w, z, -y, -x], [-z, w, x, -y], [y, -x, w, -z], [x, y, z, w]],
            axes: columns.map(|[x, y, z]| [x as f32, y as f32, z as f32, 0.0]),
        }
    }

    /// By a rotation alone.
    #[cfg(test)]
    pub(super) fn of(rotation: nalgebra::UnitQuaternion<f64>) -> Self {
        Self::new(&rotation.to_rotation_matrix().into_inner().into(), rotation.coords.into(), [0.0; 3])
    }

    /// Which way boxes are turned, as quaternions (x, y, z, w), whose rotations are given as in [`super::turn`]. How exact that is, [`super::boxes`]
    /// says.
    #[inline(always)]
    pub(super) fn turned<'a, R: Row>(motion: &impl Fn(usize) -> &'a Self, turn: R) -> R {
        let [x, y, z, _] = turn.each();
        let w = z.neg_mul_add(z, y.neg_mul_add(y, x.neg_mul_add(x, R::all(1.0)))).sqrt();
        let by = |k: usize| R::of(|i| motion(i).product[k]);
        by(3).mul_add(w, by(2).mul_add(z, by(1).mul_add(y, by(0) * x)))
    }

    /// Where the axis `k` of the mesh's own frame is turned to; the last number is nothing.
    #[inline(always)]
    pub(super) fn axis<'a, R: Row>(motion: &impl Fn(usize) -> &'a Self, k: usize) -> R {
        R::of(|i| motion(i).axes[k])
    }

    /// The points `origin` + `centre` moved, relative to `from`, mm; the last number of each is nothing.
    #[inline(always)]
    pub(super) fn points<'a, R: Row>(motion: &impl Fn(usize) -> &'a Self, origin: R, centre: R, from: R) -> R {
        let [x, y, z, _] = (origin.widen() + centre.widen()).each();
        let column = |k: usize| R::Wide::of(|i| &motion(i).rotation[k]);
        let way = R::Wide::of(|i| &motion(i).translation) - from.widen();
        ((column(0) * x + column(1) * y) + (column(2) * z + way)).narrow()
    }
}

/// Both motions, and the slack that they and the snapping of moved corners need.
#[derive(Clone, Debug)]
pub(super) struct Pose {
    pub a_from_b: Motion,
    pub b_from_a: Motion,
    /// How far, mm, a corner that the leaves see may be from where an exact motion of its box would have it.
    pub slack: f32,
}

impl Pose {
    /// `reach` is the sum of both meshes' largest distances from their origins, mm; `columns` are those of the quaternion's matrix.
    ///
    /// The truth moves a corner of `b` by the matrix of the unit quaternion ([`crate::engine::geometry::rigid`]), adds, rounds and snaps it to the grid, which
    /// moves it by up to [`grid::SNAP_RADIUS_MM`]. The matrix R here is that of the quaternion as it is, orthogonal up to its [`defect`]. It moves
    /// corners by less than a defect of their distance elsewhere; seen from `b`, by Rᵀ, points of `a` are misplaced in proportion to it as well.
    #[inline]
    pub fn of(a_from_b: &Isometry, columns: [[f64; 3]; 3], reach: f64) -> Self {
        // Arrays of their own: copies of parts of a matrix wait for its stores.
        let [x, y, z] = columns;
        let back = [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]];
        let way: [f64; 3] = a_from_b.translation.vector.into();
        let [i, j, k, w]: [f64; 4] = a_from_b.rotation.coords.into();
        let slack = Self::slack(way, reach, defect([x, y, z]));
        Self {
            b_from_a: Motion::new(&back, [-i, -j, -k, w], [-dot(x, way), -dot(y, way), -dot(z, way)]),
            a_from_b: Motion::new(&[x, y, z], [i, j, k, w], way),
            slack: slack as f32 * (1.0 + 4.0 * U),
        }
    }

    /// The same, with the matrix found here.
    #[cfg(test)]
    pub fn new(a_from_b: &Isometry, reach: f64) -> Self {
        Self::of(a_from_b, a_from_b.rotation.to_rotation_matrix().into_inner().into(), reach)
    }

    /// The slack for balls moved by the unit quaternion itself, whose defect is that of its length squared, mm.
    #[inline]
    pub fn ball_slack(a_from_b: &Isometry, reach: f64) -> f64 {
        let defect = (a_from_b.rotation.coords.norm_squared() - 1.0).abs();
        Self::slack(a_from_b.translation.vector.into(), reach, 4.0 * defect)
    }

    /// An upper bound of [`Self::ball_slack`], mm, over all poses with a quaternion of length 1 ([`rigid::is_unit`]) whose translations are within `room_mm` of
    /// this one's.
    #[inline]
    pub fn slack_within(a_from_b: &Isometry, reach: f64, room_mm: f64) -> f64 {
        // Of three components the sum is at most √3 times the length.
        Self::slack(a_from_b.translation.vector.into(), reach + 2.0 * room_mm, 4.0 * rigid::UNIT_TOLERANCE)
    }

    #[inline]
    fn slack([x, y, z]: [f64; 3], reach: f64, defect: f64) -> f64 {
        grid::SNAP_RADIUS_MM + (DEFECT_FACTOR * defect + MOTION_PAD) * (reach + (x.abs() + y.abs() + z.abs()))
    }
}

/// How far a matrix is from orthogonal: the sum of |RᵀR - I| on and above the diagonal, which is no less than the largest of its entries.
#[inline]
fn defect([x, y, z]: [[f64; 3]; 3]) -> f64 {
    let along = (dot(x, x) - 1.0).abs() + (dot(y, y) - 1.0).abs() + (dot(z, z) - 1.0).abs();
    along + (dot(x, y).abs() + dot(y, z).abs() + dot(z, x).abs())
}

#[inline]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::geometry::Vector;
    use nalgebra::UnitQuaternion;

    /// 2⁻²⁷ · √3 mm of the grid, and 64 defects of 2⁻⁵⁰ and 2⁻⁴⁴, which are 2⁻⁴³, of 4 + 1 + 2 + 3 million mm.
    #[test]
    fn a_slack_is_that_of_the_grid_of_the_defect_and_of_rounding() {
        let slack = Pose::slack([-1e6, 2e6, -3e6], 4e6, 0.5_f64.powi(50));
        let expected = 3.0_f64.sqrt() * 0.5_f64.powi(27) + 1e7 * 0.5_f64.powi(43);
        assert!((slack / expected - 1.0).abs() < 1e-12, "{slack} {expected}");
    }

    /// Squares of 1.21, 1.01 and 0.38 are 0.21, 0.01 and 0.62 from 1, the products 0.11, -0.28 and 0.22 from 0: 1.45.
    #[test]
    fn a_defect_is_the_sum_of_what_lengths_and_angles_lack() {
        let found = defect([[1.1, 0.0, 0.0], [0.1, 1.0, 0.0], [0.2, -0.3, 0.5]]);
        assert!((found - 1.45).abs() < 1e-12, "{found}");
        assert_eq!(defect([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]]), 0.0);
    }

    #[test]
    fn the_slack_in_single_precision_is_no_less() {
        let mut least = f64::INFINITY;
        for k in 0..1000 {
            let x = f64::from(k) * 0.37;
            let pose = Isometry::new([1e5 + x, -x, x * x].into(), [0.1 * x, 1.0, -0.3].into());
            let columns = pose.rotation.to_rotation_matrix().into_inner().into();
            let exact = Pose::slack(pose.translation.vector.into(), 1000.0 + x, defect(columns));
            least = least.min(f64::from(Pose::new(&pose, 1000.0 + x).slack) / exact - 1.0);
        }
        // Between 2u and 6u more than it, u = 2⁻²⁴.
        assert!(least > 2.0 * f64::from(U) && least < 6.0 * f64::from(U), "{least}");
    }

    #[test]
    fn the_slack_of_poses_in_a_room_is_that_of_the_farthest_or_a_little_more() {
        let pose = Isometry::translation(3.0, -4.0, 5.0);
        for room_mm in [1.0, 1e3, 1e6] {
            let way = room_mm / f64::sqrt(3.0);
            // Of a quaternion as long as may be.
            let quaternion = nalgebra::Quaternion::identity() * (1.0 + 0.49 * rigid::UNIT_TOLERANCE);
            let longest = UnitQuaternion::new_unchecked(quaternion);
            let farthest = Isometry::from_parts([3.0 + way, -4.0 - way, 5.0 + way].into(), longest);
            assert!(rigid::is_unit(&farthest));
            let farthest = Pose::ball_slack(&farthest, 20.0);
            let found = Pose::slack_within(&pose, 20.0, room_mm);
            assert!(found >= farthest && found < 1.4 * farthest, "{room_mm}: {found} {farthest}");
        }
    }

    /// A quaternion of length 1 + e makes R a rotation times (1 + e)², so RᵀR - I is about 4e: with e = 1e-7 a point 1000 mm off is 2e · 1000 = 2e-4 mm
    /// too far, and brought back by Rᵀ 4e · 1000 = 4e-4 mm.
    #[test]
    fn the_slack_covers_snapping_and_a_rotation_that_stretches() {
        let still = Pose::new(&Isometry::identity(), 0.0);
        // Half the diagonal of a cell, 2⁻²⁷ · √3 mm = 1.29e-8 mm.
        assert!(f64::from(still.slack) >= 1.29e-8 && still.slack < 1.3e-8, "{}", still.slack);
        assert!(Pose::ball_slack(&Isometry::identity(), 0.0) >= 1.29e-8);
        let turned = UnitQuaternion::from_scaled_axis(Vector::new(0.3, -0.2, 0.9)).into_inner();
        for e in [1e-7, -1e-7, 1e-10] {
            let stretched = UnitQuaternion::new_unchecked(turned * (1.0 + e));
            let pose = Isometry::from_parts(nalgebra::Translation3::identity(), stretched);
            for slack in [f64::from(Pose::new(&pose, 1000.0).slack), Pose::ball_slack(&pose, 1000.0)] {
                assert!(slack >= 4.0 * f64::abs(e) * 1000.0 && slack < 1000.0 * f64::abs(e) * 1000.0, "{slack}");
            }
        }
    }
}
