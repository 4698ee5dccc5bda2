//! A triangle, given by its three corners.

use super::{Point, Vector};
use nalgebra::Matrix3;

/// Three corners, mm, in the frame of the mesh they come from. May be degenerate (a segment or a point).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The corners, in the mesh's winding order (counter-clockwise seen from outside a closed solid).
    pub corners: [Point; 3],
}

impl Triangle {
    /// A triangle from its corners.
    #[must_use]
    pub const fn new(a: Point, b: Point, c: Point) -> Self {
        Self { corners: [a, b, c] }
    }

    /// The mean of the corners, mm.
    #[inline]
    #[must_use]
    pub fn centroid(&self) -> Point {
        let [a, b, c] = &self.corners;
        Point::from((a.coords + b.coords + c.coords) / 3.0)
    }

    /// Cross product of two edges: a normal of the triangle with a length of twice its area, mm².
    #[inline]
    #[must_use]
    pub fn double_area_normal(&self) -> Vector {
        let [a, b, c] = &self.corners;
        (b - a).cross(&(c - a))
    }

    /// Area, mm²; 0 for a degenerate triangle.
    #[inline]
    #[must_use]
    pub fn area(&self) -> f64 {
        0.5 * self.double_area_normal().norm()
    }

    /// The triangle's own axes as columns of a rotation: along its longest edge, perpendicular to it in the plane, and normal. `None` when
    /// the corners are collinear up to rounding.
    #[must_use]
    pub fn frame(&self) -> Option<Matrix3<f64>> {
        /// Ratio of length to height above which the axes of a triangle are mostly rounding error.
        const THIN: f64 = 1e12;
        let [a, b, c] = &self.corners;
        let edges = [b - a, c - b, a - c];
        let mut longest = edges[0];
        for edge in &edges[1..] {
            if edge.norm_squared() > longest.norm_squared() {
                longest = *edge;
            }
        }
        let (normal, length) = (edges[0].cross(&edges[1]), longest.norm());
        if normal.norm() * THIN <= length * length {
            return None;
        }
        // The normal of a needle is not at a right angle to its edges: made so twice, since the first time may leave much of little.
        let x = longest / length;
        let upright = |z: Vector| (z - x * x.dot(&z)).normalize();
        let z = upright(upright(normal.normalize()));
        Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
    }

    /// Smallest and largest coordinate of the corners on each axis, mm.
    #[inline]
    #[must_use]
    pub fn bounds(&self) -> (Point, Point) {
        let [a, b, c] = &self.corners;
        (a.inf(b).inf(c), a.sup(b).sup(c))
    }

    /// The same triangle with every corner mapped.
    #[must_use]
    pub fn map(&self, f: impl Fn(&Point) -> Point) -> Self {
        let [a, b, c] = &self.corners;
        Self::new(f(a), f(b), f(c))
    }
}

/// All corners of all triangles in order; a shared vertex appears once for each triangle that uses it.
pub fn corners(triangles: &[Triangle]) -> impl Iterator<Item = &Point> + Clone {
    triangles.iter().flat_map(|triangle| triangle.corners.iter())
}

/// Smallest and largest coordinate over all corners, mm; `None` without triangles.
#[inline]
#[must_use]
pub fn bounds(triangles: &[Triangle]) -> Option<(Point, Point)> {
    triangles.iter().map(Triangle::bounds).reduce(|(low, high), (l, h)| (low.inf(&l), high.sup(&h)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_triangle_has_half_the_product_of_its_legs() {
        let t = Triangle::new(Point::origin(), Point::new(3.0, 0.0, 0.0), Point::new(0.0, 4.0, 0.0));
        assert!((t.area() - 6.0).abs() < 1e-12);
        assert_eq!(t.centroid(), Point::new(1.0, 4.0 / 3.0, 0.0));
        assert_eq!(t.bounds(), (Point::origin(), Point::new(3.0, 4.0, 0.0)));
    }

    #[test]
    fn the_frame_lies_along_the_longest_edge() {
        // The hypotenuse runs from (3, 0) to (0, 4): along (-3, 4)/5; the normal is z.
        let t = Triangle::new(Point::origin(), Point::new(3.0, 0.0, 0.0), Point::new(0.0, 4.0, 0.0));
        let frame = t.frame().unwrap();
        assert!((frame.column(0) - Vector::new(-0.6, 0.8, 0.0)).amax() < 1e-15);
        assert!((frame.column(2) - Vector::z()).amax() < 1e-15 && (frame.determinant() - 1.0).abs() < 1e-15);
        let segment = Triangle::new(Point::origin(), Point::new(1.0, 1.0, 1.0), Point::new(2.0, 2.0, 2.0));
        assert_eq!(segment.frame(), None);
    }

    #[test]
    fn the_frame_of_a_needle_is_a_rotation() {
        // 90 mm long and from 1e-2 down to 1.5e-8 mm wide: the rounding of the normal's products is up to 1e-4 of it.
        let mut skewest: f64 = 0.0;
        for k in 0..20 {
            let (along, width) = (Vector::new(61.3, -48.7, 45.1), 0.01 * 0.5_f64.powi(k));
            let near = along * 0.37 + Vector::new(0.3, 0.6, -0.2) * width;
            let t = Triangle::new(Point::origin(), Point::from(along), Point::from(near));
            let plain = t.double_area_normal().normalize();
            skewest = skewest.max(plain.dot(&along.normalize()).abs());
            let frame = t.frame().unwrap();
            assert!((frame.tr_mul(&frame) - Matrix3::identity()).amax() < 1e-15, "{width}");
            assert!(frame.column(0).dot(&along) > 90.0 && frame.determinant() > 0.0);
        }
        assert!(skewest > 1e-9, "{skewest}");
    }

    #[test]
    fn collinear_corners_have_no_area() {
        let t = Triangle::new(Point::origin(), Point::new(1.0, 1.0, 1.0), Point::new(2.0, 2.0, 2.0));
        assert_eq!(t.area(), 0.0);
    }
}
