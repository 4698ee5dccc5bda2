//! The coordinate grid that makes the ground truth exact.
//!
//! Every vertex that a verdict depends on lies on a grid of 2⁻²⁶ mm (about 15 picometres) inside ±4096 mm. Such a
//! coordinate is an integer of at most 38 bits, so it is exact in `f64`, differences of two of them are exact, and a
//! determinant of them fits an `i128`. Mesh vertices are snapped when a mesh is made; the second mesh of a pair is
//! snapped again after it has been moved into the frame of the first ([`Placement`]).

use super::{Isometry, Point, Triangle, rigid};
use nalgebra::Matrix3;
use std::ops::{Add, Mul, Sub};

/// Spacing of the grid, mm.
pub const STEP_MM: f64 = 1.0 / 67_108_864.0; // 2^-26
/// Largest coordinate magnitude a mesh vertex may have, mm.
pub const LIMIT_MM: f64 = 4096.0;
/// Farthest that snapping moves a point, mm: half the diagonal of a grid cell, 2⁻²⁷·√3.
pub const SNAP_RADIUS_MM: f64 = 0.5 * STEP_MM * 1.732_050_807_568_877_3;

/// Adding and subtracting this number rounds to the grid, because the spacing of `f64` at 1.5·2²⁶ is exactly 2⁻²⁶. Valid for |x| ≤ 2²⁵ mm,
/// ties to even; two additions and no library call.
const ROUNDING: f64 = 1.5 * 67_108_864.0;

/// An `f64`, or several `f64` side by side with the same operations.
pub trait Coordinate: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// The same number in every lane.
    fn all(x: f64) -> Self;
}

impl Coordinate for f64 {
    #[inline(always)]
    fn all(x: f64) -> Self {
        x
    }
}

/// The nearest grid coordinate, mm. Exact for |x| ≤ 2²⁵ mm.
#[inline(always)]
#[must_use]
pub fn snap_coordinate<T: Coordinate>(x: T) -> T {
    (x + T::all(ROUNDING)) - T::all(ROUNDING)
}

/// The nearest grid point, mm.
#[inline(always)]
#[must_use]
pub fn snap(point: &Point) -> Point {
    Point::new(snap_coordinate(point.x), snap_coordinate(point.y), snap_coordinate(point.z))
}

/// A relative pose as the leaves and the ground truth apply it: `snap(fl(R v + t))`. All methods share this function, so that methods never
/// differ in the vertices that they see. R is [`rigid::rotation`] of the pose.
#[derive(Clone, Debug)]
pub struct Placement {
    rotation: Matrix3<f64>,
    translation: nalgebra::Vector3<f64>,
}

impl Placement {
    /// The placement of mesh `b` in the frame of mesh `a`.
    #[inline]
    #[must_use]
    pub fn new(a_from_b: &Isometry) -> Self {
        Self::of(rigid::rotation(a_from_b), a_from_b.translation.vector)
    }

    /// By the matrix of [`rigid::rotation`], and the translation, mm.
    #[inline]
    pub(crate) const fn of(rotation: Matrix3<f64>, translation: nalgebra::Vector3<f64>) -> Self {
        Self { rotation, translation }
    }

    /// The coordinates of a point of `b`, mm, in the frame of `a`, on the grid.
    #[inline(always)]
    #[must_use]
    pub fn coordinates<T: Coordinate>(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        let (r, t) = (&self.rotation, &self.translation);
        [
            snap_coordinate(T::all(r.m11) * x + T::all(r.m12) * y + T::all(r.m13) * z + T::all(t.x)),
            snap_coordinate(T::all(r.m21) * x + T::all(r.m22) * y + T::all(r.m23) * z + T::all(t.y)),
            snap_coordinate(T::all(r.m31) * x + T::all(r.m32) * y + T::all(r.m33) * z + T::all(t.z)),
        ]
    }

    /// A point of `b`, mm, in the frame of `a`, on the grid.
    #[inline(always)]
    #[must_use]
    pub fn point(&self, point_in_b: &Point) -> Point {
        Point::from(self.coordinates([point_in_b.x, point_in_b.y, point_in_b.z]))
    }

    /// A triangle of `b`, mm, in the frame of `a`, on the grid.
    #[inline(always)]
    #[must_use]
    pub fn triangle(&self, triangle_in_b: &Triangle) -> Triangle {
        let [a, b, c] = &triangle_in_b.corners;
        Triangle::new(self.point(a), self.point(b), self.point(c))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snapping_goes_to_the_nearest_multiple_of_the_step() {
        for (x, steps) in [(0.0, 0.0), (STEP_MM * 0.49, 0.0), (STEP_MM * 0.51, 1.0), (-STEP_MM * 2.6, -3.0)] {
            assert_eq!(snap_coordinate(x), steps * STEP_MM, "{x}");
        }
        for x in [4_095.123_456_789, -4_095.999_999_999, 1e-9, 0.1] {
            let snapped = snap_coordinate(x);
            assert!((snapped - x).abs() <= STEP_MM / 2.0);
            assert_eq!((snapped / STEP_MM).fract(), 0.0);
            assert_eq!(snap_coordinate(snapped), snapped);
        }
    }

    #[test]
    fn placement_moves_and_snaps() {
        let quarter_turn_about_z =
            Isometry::new(nalgebra::Vector3::new(1.0, 2.0, 3.0), nalgebra::Vector3::z() * std::f64::consts::FRAC_PI_2);
        let moved = Placement::new(&quarter_turn_about_z).point(&Point::new(10.0, 0.0, 0.0));
        assert_eq!(moved, Point::new(1.0, 12.0, 3.0));
    }
}
