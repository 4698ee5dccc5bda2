//! The separating-axis test of two boxes, shared by everything that is a box.
//!
//! S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996, section 5; equations (2) and (3) of Xu and Zhang 2011.

use crate::geometry::{Vector, grid};
use nalgebra::{Matrix3, RealField, Vector3};

/// Added to every |R_ij|. When two edges are nearly parallel, their cross product is nearly zero, and so are both sides of the inequality;
/// rounding then decides. Entries of R have an error of a few 2⁻⁵³. The value 1e-12 is four thousand times that; it keeps the right side
/// the larger one for overlapping boxes, and widens a box of 1000 mm by 1e-9 mm.
pub const PARALLEL_EPSILON: f64 = 1e-12;

/// Relative widening of a volume: 2⁻⁴⁰, thousands of times the rounding error of the few operations of a fit or a test.
const RELATIVE_PAD: f64 = 1.0 / 1_099_511_627_776.0;

/// How far a volume must be widened, mm, to make up for rounding in its fit, for rounding in a test at any pose of the coordinate range,
/// and for the snapping of moved vertices. `reach` is the largest absolute coordinate of its contents, mm.
pub fn pad_mm(reach: f64) -> f64 {
    RELATIVE_PAD * (reach + grid::LIMIT_MM) + grid::SNAP_RADIUS_MM
}

/// |R| + ε, entry by entry.
#[inline(always)]
pub fn widened_abs(r: &Matrix3<f64>) -> Matrix3<f64> {
    r.map(|x| x.abs() + PARALLEL_EPSILON)
}

/// Whether one of the six face normals separates two boxes. `a` and `b` are their half-lengths, mm; `r` maps axes of the second box to axes
/// of the first, and `q` is [`widened_abs`] of `r`; `t` is the second centre in the frame of the first box, mm. Generic, so that the same
/// test can be tried in single precision.
#[inline(always)]
pub fn separated_by_faces<T: RealField + Copy>(
    t: &Vector3<T>,
    r: &Matrix3<T>,
    q: &Matrix3<T>,
    a: &Vector3<T>,
    b: &Vector3<T>,
) -> bool {
    for i in 0..3 {
        if t[i].abs() > a[i] + q[(i, 0)] * b[0] + q[(i, 1)] * b[1] + q[(i, 2)] * b[2] {
            return true;
        }
    }
    for j in 0..3 {
        let distance = t[0] * r[(0, j)] + t[1] * r[(1, j)] + t[2] * r[(2, j)];
        if distance.abs() > b[j] + q[(0, j)] * a[0] + q[(1, j)] * a[1] + q[(2, j)] * a[2] {
            return true;
        }
    }
    false
}

/// Whether one of the fifteen axes separates two boxes: the six face normals and the nine cross products of edges. The arguments are those
/// of [`separated_by_faces`].
#[inline(always)]
pub fn separated<T: RealField + Copy>(
    t: &Vector3<T>,
    r: &Matrix3<T>,
    q: &Matrix3<T>,
    a: &Vector3<T>,
    b: &Vector3<T>,
) -> bool {
    if separated_by_faces(t, r, q, a, b) {
        return true;
    }
    for i in 0..3 {
        let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
        for j in 0..3 {
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            let distance = t[i2] * r[(i1, j)] - t[i1] * r[(i2, j)];
            let reach = a[i1] * q[(i2, j)] + a[i2] * q[(i1, j)] + b[j1] * q[(i, j2)] + b[j2] * q[(i, j1)];
            if distance.abs() > reach {
                return true;
            }
        }
    }
    false
}

/// A lower bound of the distance between two boxes, mm; the arguments are those of [`separated_by_faces`]. In the axes of either box, the
/// other box is replaced by its axis-aligned bounding box, and the distance of two boxes with parallel edges is computed. The larger of the
/// two distances is returned.
#[inline(always)]
pub fn gap_mm(t: &Vector, r: &Matrix3<f64>, q: &Matrix3<f64>, a: &Vector, b: &Vector) -> f64 {
    let along_a = (t.abs() - a - q * b).sup(&Vector::zeros());
    let along_b = (r.tr_mul(t).abs() - b - q.tr_mul(a)).sup(&Vector::zeros());
    along_a.norm_squared().max(along_b.norm_squared()).sqrt()
}

/// Whether a point lies within `slack_mm` of a box with half-lengths `half`; `x` is the point relative to the centre, in the box's axes,
/// mm.
pub fn box_contains(x: &Vector, half: &Vector, slack_mm: f64) -> bool {
    (x.abs() - half).sup(&Vector::zeros()).norm_squared() <= slack_mm * slack_mm
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apart(t: Vector, r: Matrix3<f64>) -> bool {
        let one = Vector::repeat(1.0);
        separated(&t, &r, &widened_abs(&r), &one, &one)
    }

    #[test]
    fn aligned_unit_boxes_part_at_distance_two() {
        assert!(!apart(Vector::new(2.0, 0.0, 0.0), Matrix3::identity()));
        assert!(apart(Vector::new(2.0 + 1e-9, 0.0, 0.0), Matrix3::identity()));
    }

    #[test]
    fn the_gap_of_two_aligned_boxes_is_from_corner_to_corner() {
        let (one, r) = (Vector::repeat(1.0), Matrix3::identity());
        let gap = |t: Vector| gap_mm(&t, &r, &widened_abs(&r), &one, &one);
        assert!((gap(Vector::new(5.0, 6.0, 0.0)) - 5.0).abs() < 1e-9); // 3 along x, 4 along y
        assert_eq!(gap(Vector::new(1.0, 1.9, 0.0)), 0.0);
    }

    #[test]
    fn slack_is_a_distance() {
        let half = Vector::new(1.0, 2.0, 3.0);
        assert!(box_contains(&Vector::new(-1.0, 2.0, 0.0), &half, 0.0));
        let x = Vector::new(4.0, -6.0, 3.0); // 3 beyond one face and 4 beyond another: 5 from the edge
        assert!(box_contains(&x, &half, 5.0) && !box_contains(&x, &half, 4.999));
    }

    #[test]
    fn a_box_on_its_edge_reaches_root_two() {
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector::z_axis(), std::f64::consts::FRAC_PI_4).into_inner();
        assert!(!apart(Vector::new(1.0 + 2.0_f64.sqrt() - 1e-9, 0.0, 0.0), turn));
        assert!(apart(Vector::new(1.0 + 2.0_f64.sqrt() + 1e-9, 0.0, 0.0), turn));
    }

    #[test]
    fn two_crossed_edges_need_an_edge_axis() {
        // A cube on its edge about x, the other on its edge about y, above each other along z: the edges cross at
        // z = 2·√2, and no face axis separates them before.
        let quarter = std::f64::consts::FRAC_PI_4;
        let about_x = nalgebra::Rotation3::from_axis_angle(&Vector::x_axis(), quarter).into_inner();
        let about_y = nalgebra::Rotation3::from_axis_angle(&Vector::y_axis(), quarter).into_inner();
        let (r, reach) = (about_x.transpose() * about_y, 2.0 * 2.0_f64.sqrt());
        let up = |z: f64| about_x.transpose() * Vector::new(0.0, 0.0, z);
        assert!(!apart(up(reach - 1e-9), r));
        assert!(apart(up(reach + 1e-9), r));
    }

    #[test]
    fn rounding_in_nearly_parallel_edges_separates_nothing() {
        // One entry is off by 2⁻⁵³. Along the product of the two first edges the centres are 1.9 · 2⁻⁵³ apart and the boxes reach 2⁻⁵³.
        let mut r = Matrix3::identity();
        r[(1, 0)] = 1.0 / 9_007_199_254_740_992.0;
        assert!(!apart(Vector::new(0.0, 0.0, 1.9), r));
        assert!(!apart(Vector::new(0.0, 0.0, -1.9), r) && !apart(Vector::new(0.0, 0.0, 1.9), r.transpose()));
    }

    #[test]
    fn the_pad_pays_for_snapping_and_rounding() {
        // 2⁻⁴⁰ of the coordinates that meet, of which the other's may be 4096 mm: 2⁻²⁸, or twice that; and the snap radius.
        let unit = 1.0 / 268_435_456.0;
        assert_eq!(pad_mm(0.0), unit + grid::SNAP_RADIUS_MM);
        assert_eq!(pad_mm(4096.0), 2.0 * unit + grid::SNAP_RADIUS_MM);
        // Half the diagonal of a cube of a grid step.
        assert!((grid::SNAP_RADIUS_MM - (0.75_f64).sqrt() * grid::STEP_MM).abs() < 1e-20);
    }

    #[test]
    fn the_gap_is_never_more_than_the_distance_and_turns_with_the_boxes() {
        // A cube on its edge beside one at rest: half a side and half a diagonal leave 5 - 1 - √2 along x.
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector::z_axis(), std::f64::consts::FRAC_PI_4).into_inner();
        let one = Vector::repeat(1.0);
        let gap = |t: Vector, r: &Matrix3<f64>| gap_mm(&t, r, &widened_abs(r), &one, &one);
        let expected = 4.0 - 2f64.sqrt();
        assert!((gap(Vector::new(5.0, 0.0, 0.0), &turn) - expected).abs() < 1e-9);
        // The same with the roles exchanged: the first stands on its edge, the second centre is seen from it.
        let back = turn.transpose();
        assert!((gap(back * Vector::new(-5.0, 0.0, 0.0), &back) - expected).abs() < 1e-9);
    }
}
