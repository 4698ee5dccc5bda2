//! Which side of a plane a point is on, as far as `f64` can tell.
//!
//! J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997, section 4.2: a 3 x 3 determinant of
//! coordinate differences, expanded as here, is wrong by at most (7 + 56u)u times the same sum with every product taken positive (u = 2⁻⁵³).
//! That holds where no product overflows or underflows: where every difference of two coordinates is 0 or from 2⁻³²⁰ to 2³²⁰ mm, since then every
//! product of three is from 2⁻⁹⁶⁰ to 2⁹⁶⁰. Vertices of a mesh and their images ([`super::grid`]) are multiples of 2⁻²⁶ mm, and within 2²⁵ mm wherever the
//! bounds of the two meshes overlap: their differences are 0 or from 2⁻²⁶ to 2²⁶ mm, and exact.

use super::{Point, Triangle, Vector};

/// (7 + 56u)u, rounded up to 8u; what is left pays for the rounding of the product with it. See the module.
pub const ERROR: f64 = 8.0 / 9_007_199_254_740_992.0;

/// The side that a point is on of a plane through three others: 1, -1, or 0 when rounding could decide.
pub type Side = i8;

/// A plane through three points, mm.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    point: Point,
    normal: Vector,
    /// The normal with every product taken positive.
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

    /// The plane that sees the points in counter-clockwise order from above.
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

    /// The sides of a triangle's corners, one by one: the closure of `[T; 3]::map` is not inlined here, which costs an eighth of a verification.
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
    use super::*;

    /// On, next to, near and far from planes: the quick answer is the exact one, and is given unless the point is next to the plane.
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
