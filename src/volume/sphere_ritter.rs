//! Ritter's sphere: two passes, a few percent larger than the smallest enclosing sphere.
//!
//! J. Ritter, "An Efficient Bounding Sphere", Graphics Gems, 1990, pp. 301-303. Deviation: a last pass sets the radius to the distance of
//! the farthest corner from the final centre. This never enlarges the sphere, and absorbs the rounding errors of the growing steps.

use super::shape::sphere::Sphere;
use super::{BoundingVolume, Info};
use crate::geometry::{Point, Triangle, triangle};

/// Ritter's sphere.
#[derive(Clone, Copy, Debug)]
pub struct SphereRitter;

impl BoundingVolume for SphereRitter {
    const INFO: Info = Info {
        id: "sphere-ritter",
        label: "sphere",
        reference: "J. Ritter, An Efficient Bounding Sphere, Graphics Gems, 1990",
        safe: true,
    };

    type Shape = Sphere;

    fn fit(triangles: &[Triangle]) -> Sphere {
        Sphere::about(centre(triangles), triangles)
    }
}

/// The centre of the sphere around `triangles` (at least one), mm.
fn centre(triangles: &[Triangle]) -> Point {
    let (mut middle, mut radius) = midpoint_of_widest_extreme_pair(triangles);
    for corner in triangle::corners(triangles) {
        let distance = (corner - middle).norm();
        if distance > radius {
            radius = f64::midpoint(radius, distance);
            middle += (corner - middle) * ((distance - radius) / distance);
        }
    }
    middle
}

/// The midpoint and half the distance of the farthest pair, among the three pairs of extreme corners along x, y and z.
fn midpoint_of_widest_extreme_pair(triangles: &[Triangle]) -> (Point, f64) {
    let first = triangles[0].corners[0];
    let mut lowest = [first; 3];
    let mut highest = [first; 3];
    for corner in triangle::corners(triangles) {
        for axis in 0..3 {
            if corner[axis] < lowest[axis][axis] {
                lowest[axis] = *corner;
            }
            if corner[axis] > highest[axis][axis] {
                highest[axis] = *corner;
            }
        }
    }
    let (mut middle, mut radius) = (first, 0.0);
    for (low, high) in lowest.iter().zip(&highest) {
        let half = 0.5 * (high - low).norm();
        if half > radius {
            (middle, radius) = (nalgebra::center(low, high), half);
        }
    }
    (middle, radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Solid;

    #[test]
    fn a_segment_gets_the_sphere_over_its_length() {
        let (p, q) = (Point::new(1.0, 0.0, 0.0), Point::new(5.0, 0.0, 0.0));
        let triangles = [Triangle::new(p, q, p)];
        assert_eq!(midpoint_of_widest_extreme_pair(&triangles), (Point::new(3.0, 0.0, 0.0), 2.0));
        let sphere = SphereRitter::fit(&triangles);
        assert_eq!(sphere.centre, Point::new(3.0, 0.0, 0.0));
        // Wherever it begins.
        let middle = Point::new(3.0, 0.0, 0.0);
        for [a, b, c] in [[middle, p, q], [middle, q, p], [q, middle, p]] {
            assert_eq!(midpoint_of_widest_extreme_pair(&[Triangle::new(a, b, c)]), (middle, 2.0));
        }
        assert!((sphere.radius - 2.0).abs() < 1e-7); // half of 5 - 1, and the pad
        assert!(sphere.contains(&q, 0.0) && !sphere.contains(&Point::new(5.1, 0.0, 0.0), 0.0));
    }
}
