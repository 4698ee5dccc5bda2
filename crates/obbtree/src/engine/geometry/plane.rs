//! The side of a plane on which a point lies, as far as `f64` can decide it.
//!
//! J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997, section 4.2: a 3 x 3
//! determinant of coordinate differences, expanded as here, has an error of at most (7 + 56u)u times the same sum with every product taken
//! positive (u = 2⁻⁵³). This holds when no product overflows or underflows, which is certain when every difference of two coordinates is 0
//! or from 2⁻³²⁰ to 2³²⁰ mm: every product of three is then from 2⁻⁹⁶⁰ to 2⁹⁶⁰. Vertices of a mesh and their images ([`super::grid`])
//! satisfy it. They are multiples of 2⁻²⁶ mm, and within 2²⁵ mm wherever the bounds of the two meshes overlap, so their differences are
//! exact, and 0 or from 2⁻²⁶ to 2²⁶ mm.

use super::{Point, Triangle, Vector};

/// (7 + 56u)u, rounded up to 8u. The excess covers the rounding of the product with it; see the module's header.
pub const ERROR: f64 = 8.0 / 9_007_199_254_740_992.0;

/// The side of a plane through three points on which a point lies: 1, -1, or 0 when rounding could decide.
pub type Side = i8;

/// A plane through three points, mm.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    point: Point,
    normal: Vector,
    /// The normal, computed with every product taken positive.
    size: Vector,
}

impl Plane {
    /// The plane of a triangle.
    #[inline(always)]
    #[must_use]
    pub fn of(triangle: &Triangle) -> Self {
        let [p, q, r] = &triangle.corners;
        Self::new(p, q, r)
    }

    /// The plane whose upper side sees the points in counter-clockwise order.
    #[inline(always)]
    #[must_use]
    pub fn new(p: &Point, q: &Point, r: &Point) -> Self {
        let (e, f) = (q - p, r - p);
        let (one, other) = (Vector::new(e.y * f.z, e.z * f.x, e.x * f.y), Vector::new(e.z * f.y, e.x * f.z, e.y * f.x));
        Self { point: *p, normal: one - other, size: one.abs() + other.abs() }
    }

    /// The side of a point.
    #[inline(always)]
    #[must_use]
    pub fn side(&self, point: &Point) -> Side {
        let d = point - self.point;
        let (height, error) = (d.dot(&self.normal), ERROR * d.abs().dot(&self.size));
        Side::from(height > error) - Side::from(height < -error)
    }

    /// Whether the plane may pass through the box about `centre` with half-lengths `half` along the axes, mm; true when rounding could
    /// decide.
    #[must_use]
    pub fn may_meet_box(&self, centre: &Point, half: &Vector) -> bool {
        let d = centre - self.point;
        // The error of the normal counts for the half-lengths as well.
        let error = ERROR * (d.abs() + half).dot(&self.size);
        d.dot(&self.normal).abs() <= self.normal.abs().dot(half) + error
    }

    /// The sides of a triangle's corners, written out one by one: the closure of `[T; 3]::map` is not inlined here, which costs an eighth
    /// of a verification.
    #[inline(always)]
    #[must_use]
    pub fn sides(&self, triangle: &Triangle) -> [Side; 3] {
        let [x, y, z] = &triangle.corners;
        [self.side(x), self.side(y), self.side(z)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::exact::side;
    use super::super::exact::tests::{hand_made, orders};
    use super::super::grid::snap_coordinate;
    use super::*;

    #[test]
    fn a_plane_meets_a_box_that_it_touches_and_none_beyond() {
        let p = |x: f64, y: f64, z: f64| Point::new(x, y, z);
        // The plane x + y + z = 3: the cube about the origin with half-lengths h reaches as far as 3h.
        let slanted = Plane::new(&p(3.0, 0.0, 0.0), &p(0.0, 3.0, 0.0), &p(0.0, 0.0, 3.0));
        for (half, meets) in [(1.0, true), (1.0 - 1e-12, false), (2.0, true), (0.5, false)] {
            assert_eq!(slanted.may_meet_box(&Point::origin(), &Vector::repeat(half)), meets, "{half}");
            assert_eq!(slanted.may_meet_box(&p(2.0, 2.0, 2.0), &Vector::repeat(half)), meets, "{half}, from above");
        }
    }

    #[test]
    fn a_needles_plane_meets_what_is_around_any_point_of_the_needle() {
        // A box at the middle of a needle, of which the normal alone says that it passes by.
        let mut excluded = 0;
        for k in 0..200 {
            let k = f64::from(k);
            let along = Vector::new(71.3 + k, -48.7 - 0.3 * k, 45.1 + 0.7 * k).map(snap_coordinate);
            let near = (along * 0.5 + Vector::new(3.0, -2.0, 1.0) * 2e-8).map(snap_coordinate);
            let [a, b, c] = [Vector::zeros(), along, near].map(|v| Point::from(v + Vector::new(700.0, -800.0, 900.0)));
            let (plane, half, middle) = (Plane::new(&a, &c, &b), Vector::repeat(1e-9), a + along * 0.83);
            assert!(plane.may_meet_box(&middle, &half), "{k}");
            excluded += i32::from((middle - a).dot(&plane.normal).abs() > plane.normal.abs().dot(&half));
        }
        assert!(excluded > 0);
    }

    /// Points on, next to, near and far from planes: the quick answer equals the exact one, and is given unless the point is next to the
    /// plane.
    #[test]
    fn a_plane_tells_the_side_or_nothing() {
        let mut told = [0; 4];
        for (_, a, b, _) in hand_made() {
            for t in orders(&a).into_iter().chain(orders(&b)) {
                let third = |t: &Triangle| Point::from(t.corners.iter().map(|p| p.coords).sum::<Vector>() / 3.0);
                let normal = (t.corners[1] - t.corners[0]).cross(&(t.corners[2] - t.corners[0]));
                for (k, height) in [0.0, 1e-17, 1e-9, 1.0].into_iter().enumerate() {
                    let point = third(&t) + normal * height;
                    let quick = Plane::of(&t).side(&point);
                    told[k] += usize::from(quick != 0);
                    assert!(quick == 0 || -quick == side(&t, &point), "{t:?} {point}");
                    assert!(quick != 0 || k < 3 || normal.norm() == 0.0, "{t:?} {point}");
                }
            }
        }
        assert!(told[0] < told[3] && told[2] == told[3], "{told:?}");
    }
}
