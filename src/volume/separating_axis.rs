//! The one separating-axis test for two boxes, whoever chose their axes.
//!
//! Equations (2) and (3) of Xu and Zhang 2011, which are those of S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree",
//! SIGGRAPH 1996, section 5: two boxes are apart when one of 15 directions (three face normals of each, nine products of
//! an edge of one with an edge of the other) separates their projections. Deviation: every |R_ij| is enlarged by
//! [`NEAR_PARALLEL`].

use crate::geometry::Vector;
use nalgebra::Matrix3;

/// Added to every |R_ij|, dimensionless: 2⁻⁴⁰.
///
/// When an edge of one box is nearly parallel to an edge of the other, their cross product is nearly zero, both sides
/// of its test are made of rounding errors, and overlapping boxes come out as apart. An entry of R is a sum of three
/// products of sums of three products of numbers of magnitude at most 1, from frames that are orthonormal to a few
/// 2⁻⁵²: it is wrong by less than 2⁻⁴⁸, and the two products on the left of an edge test by less than 2⁻⁴⁷ of the
/// half-lengths on its right. 2⁻⁴⁰ leaves a factor of 128, and widens a box of 1 m by 1 nm.
pub const NEAR_PARALLEL: f64 = 1.0 / 1_099_511_627_776.0;

/// How the axes of two boxes stand to each other.
#[derive(Clone, Debug)]
pub struct Orientation {
    /// Entry (i, j) is axis i of the left box times axis j of the right one.
    r: Matrix3<f64>,
    /// |r|, enlarged by [`NEAR_PARALLEL`].
    q: Matrix3<f64>,
}

impl Orientation {
    /// From the axes of the right box, as columns, in the frame of the left one.
    #[inline(always)]
    #[must_use]
    pub fn new(right_axes_in_left: Matrix3<f64>) -> Self {
        Self { r: right_axes_in_left, q: right_axes_in_left.map(|x| x.abs() + NEAR_PARALLEL) }
    }
}

/// Whether a direction separates a box with half-lengths `a` from one with half-lengths `b` whose centre lies at `t` (mm,
/// all in the frame of the left box). Cheap and likely directions first: the faces of the left box, those of the right
/// one, then the nine edge pairs.
#[inline(always)]
#[must_use]
pub fn separated(a: &Vector, b: &Vector, t: &Vector, orientation: &Orientation) -> bool {
    let Orientation { r, q } = orientation;
    for i in 0..3 {
        let reach = a[i] + (q[(i, 0)] * b.x + q[(i, 1)] * b.y + q[(i, 2)] * b.z);
        if t[i].abs() > reach {
            return true;
        }
    }
    for j in 0..3 {
        let reach = b[j] + (q[(0, j)] * a.x + q[(1, j)] * a.y + q[(2, j)] * a.z);
        if (r[(0, j)] * t.x + r[(1, j)] * t.y + r[(2, j)] * t.z).abs() > reach {
            return true;
        }
    }
    for i in 0..3 {
        let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
        for j in 0..3 {
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            let reach = a[i1] * q[(i2, j)] + a[i2] * q[(i1, j)] + b[j1] * q[(i, j2)] + b[j2] * q[(i, j1)];
            if (t[i2] * r[(i1, j)] - t[i1] * r[(i2, j)]).abs() > reach {
                return true;
            }
        }
    }
    false
}

/// Distance of a point from a box, squared, mm²: 0 inside. `offset` is the point seen from the centre, along the axes.
#[must_use]
pub fn squared_distance(offset: &Vector, half: &Vector) -> f64 {
    (offset.abs() - half).sup(&Vector::zeros()).norm_squared()
}

/// The twelve edges of a box, as pairs of corners whose coordinates are ±1 along the axes.
pub fn edges() -> impl Iterator<Item = [Vector; 2]> {
    (0..3).flat_map(|axis| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(u, v)| {
            [-1.0, 1.0].map(|along| {
                let mut corner = Vector::zeros();
                (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (along, u, v);
                corner
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;
    use std::f64::consts::FRAC_PI_4;

    fn unit_cubes_apart(t: Vector, rotation: Rotation3<f64>) -> bool {
        let half = Vector::repeat(1.0);
        separated(&half, &half, &t, &Orientation::new(rotation.into_inner()))
    }

    #[test]
    fn faces_of_the_left_box_separate() {
        // Turned by 45° about z the right cube reaches √2 along x: contact at 1 + √2 = 2.41421.
        let turned = Rotation3::from_axis_angle(&Vector::z_axis(), FRAC_PI_4);
        assert!(!unit_cubes_apart(Vector::new(2.414, 0.0, 0.0), turned));
        assert!(unit_cubes_apart(Vector::new(2.415, 0.0, 0.0), turned));
    }

    #[test]
    fn faces_of_the_right_box_separate() {
        // Along its own diagonal (1,1,0)/√2 the left cube reaches √2, the right one 1: again 2.41421.
        let turned = Rotation3::from_axis_angle(&Vector::z_axis(), FRAC_PI_4);
        let along = Vector::new(1.0, 1.0, 0.0).normalize();
        assert!(!unit_cubes_apart(along * 2.414, turned));
        assert!(unit_cubes_apart(along * 2.415, turned));
    }

    #[test]
    fn edge_pairs_separate_where_no_face_does() {
        // The left cube shows its edge along z, the right one (turned 45° about z, then 45° about y) another: each
        // reaches √2 along the normal of both edges, so the cubes touch at 2√2 = 2.82843 along it.
        let rotation = Rotation3::from_axis_angle(&Vector::z_axis(), FRAC_PI_4)
            * Rotation3::from_axis_angle(&Vector::x_axis(), FRAC_PI_4);
        let normal = Vector::z().cross(&(rotation * Vector::y())).normalize();
        let reach = |frame: &Rotation3<f64>| (frame.inverse() * normal).abs().sum();
        let contact = reach(&Rotation3::identity()) + reach(&rotation);
        assert!(!unit_cubes_apart(normal * (contact - 1e-3), rotation));
        assert!(unit_cubes_apart(normal * (contact + 1e-3), rotation));
    }

    #[test]
    fn a_box_has_twelve_different_edges_two_long() {
        let all: Vec<_> = edges().collect();
        assert_eq!(all.len(), 12);
        for (i, [p, q]) in all.iter().enumerate() {
            assert_eq!((q - p).norm(), 2.0);
            assert!(all[..i].iter().all(|[r, s]| (p, q) != (r, s) && (p, q) != (s, r)));
        }
    }

    #[test]
    fn distance_is_zero_inside_and_euclidean_outside() {
        let half = Vector::new(1.0, 2.0, 3.0);
        assert_eq!(squared_distance(&Vector::new(-1.0, 2.0, 0.0), &half), 0.0);
        assert_eq!(squared_distance(&Vector::new(4.0, -6.0, 3.0), &half), 25.0); // 3² + 4²
    }
}
