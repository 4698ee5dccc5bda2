//! Ritter's sphere: two passes, at most a few percent larger than the smallest enclosing sphere.
//!
//! J. Ritter, "An Efficient Bounding Sphere", Graphics Gems, 1990, pp. 301-303. Deviation: a last pass sets the radius to
//! the farthest corner from the final centre, which never enlarges the sphere and absorbs the rounding of the growing
//! steps.

use super::separating_axes::pad_mm;
use super::{BoundingVolume, Info, Segment, coordinate_axes_by_extent};
use crate::geometry::{Isometry, Point, Triangle, Vector, triangle};
use nalgebra::Unit;
use std::f64::consts::{PI, TAU};

/// A centre and a radius, mm, mesh frame.
#[derive(Clone, Debug)]
pub struct SphereRitter {
    centre: Point,
    radius: f64,
}

impl BoundingVolume for SphereRitter {
    const INFO: Info = Info {
        id: "sphere-ritter",
        label: "sphere",
        reference: "J. Ritter, An Efficient Bounding Sphere, Graphics Gems, 1990",
        safe: true,
    };

    type Pose = Isometry;

    fn fit(triangles: &[Triangle]) -> Self {
        let (mut middle, mut radius) = midpoint_of_widest_extreme_pair(triangles);
        for corner in triangle::corners(triangles) {
            let distance = (corner - middle).norm();
            if distance > radius {
                radius = f64::midpoint(radius, distance);
                middle += (corner - middle) * ((distance - radius) / distance);
            }
        }
        let farthest = triangle::corners(triangles).map(|corner| (corner - middle).norm()).fold(0.0, f64::max);
        Self { centre: middle, radius: farthest + pad_mm(middle.coords.amax() + farthest) }
    }

    fn pose(a_from_b: &Isometry) -> Isometry {
        *a_from_b
    }

    fn overlaps(&self, other: &Self, a_from_b: &Isometry) -> bool {
        let reach = self.radius + other.radius;
        (a_from_b * other.centre - self.centre).norm_squared() <= reach * reach
    }

    fn gap_mm(&self, other: &Self, a_from_b: &Isometry) -> f64 {
        ((a_from_b * other.centre - self.centre).norm() - self.radius - other.radius).max(0.0)
    }

    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        (point - self.centre).norm() <= self.radius + slack_mm
    }

    fn centre(&self) -> Point {
        self.centre
    }

    fn size(&self) -> f64 {
        self.radius
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius.powi(3)
    }

    fn surface_area(&self) -> f64 {
        4.0 * PI * self.radius.powi(2)
    }

    /// A sphere has no long axis of its own: the coordinate axes, by the extent of the contents.
    fn split_axes(&self, triangles: &[Triangle]) -> [Unit<Vector>; 3] {
        let extents = triangle::bounds(triangles).map_or_else(Vector::zeros, |(low, high)| high - low);
        coordinate_axes_by_extent(&extents)
    }

    /// Three great circles of 48 segments each.
    fn outline(&self) -> Vec<Segment> {
        const STEPS: usize = 48;
        let on_circle = |axis: usize, step: usize| {
            let (sin, cos) = (TAU * step as f64 / STEPS as f64).sin_cos();
            let mut offset = Vector::zeros();
            offset[(axis + 1) % 3] = self.radius * cos;
            offset[(axis + 2) % 3] = self.radius * sin;
            self.centre + offset
        };
        (0..3).flat_map(|axis| (0..STEPS).map(move |step| [on_circle(axis, step), on_circle(axis, step + 1)])).collect()
    }
}

/// Of the three pairs of extreme corners along x, y and z, the pair farthest apart: its midpoint and half its distance.
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

    #[test]
    fn a_segment_gets_the_sphere_over_its_length() {
        let (p, q) = (Point::new(1.0, 0.0, 0.0), Point::new(5.0, 0.0, 0.0));
        let sphere = SphereRitter::fit(&[Triangle::new(p, q, p)]);
        assert_eq!(sphere.centre, Point::new(3.0, 0.0, 0.0));
        assert!((sphere.radius - 2.0).abs() < 1e-7); // half of 5 - 1, and the pad
        assert!(sphere.contains(&q, 0.0) && !sphere.contains(&Point::new(5.1, 0.0, 0.0), 0.0));
    }

    #[test]
    fn spheres_overlap_up_to_the_sum_of_their_radii() {
        let unit = |x: f64| {
            Triangle::new(Point::new(x - 1.0, 0.0, 0.0), Point::new(x + 1.0, 0.0, 0.0), Point::new(x, 1.0, 0.0))
        };
        let (a, b) = (SphereRitter::fit(&[unit(0.0)]), SphereRitter::fit(&[unit(0.0)]));
        assert!(a.overlaps(&b, &Isometry::translation(1.999_999, 0.0, 0.0)));
        assert!(!a.overlaps(&b, &Isometry::translation(2.000_1, 0.0, 0.0)));
    }
}
