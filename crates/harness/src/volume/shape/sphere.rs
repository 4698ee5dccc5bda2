//! Spheres: one sphere, one test; the variants differ in where the centre lies.

use crate::geometry::rigid::rigid;
use crate::geometry::separating_axes::pad_mm;
use crate::geometry::{Isometry, Point, Triangle, Vector, triangle};
use crate::volume::{Segment, Shape, Solid, coordinate_axes_by_extent};
use nalgebra::Unit;
use std::f64::consts::{PI, TAU};

/// A centre and the distance of the farthest corner from it, mm, mesh frame.
#[derive(Clone, Debug)]
pub struct Sphere {
    /// Its centre.
    pub centre: Point,
    /// Its radius.
    pub radius: f64,
}

/// The distance of the farthest corner from `centre`, mm.
pub fn farthest_mm(centre: &Point, triangles: &[Triangle]) -> f64 {
    triangle::corners(triangles).map(|corner| (corner - centre).norm()).fold(0.0, f64::max)
}

impl Sphere {
    /// The smallest sphere about `centre` (mm) that contains `triangles`, with a margin for rounding errors.
    pub fn about(centre: Point, triangles: &[Triangle]) -> Self {
        let farthest = farthest_mm(&centre, triangles);
        Self { centre, radius: farthest + pad_mm(centre.coords.amax() + farthest) }
    }
}

impl Shape for Sphere {
    type Pose = Isometry;

    #[inline]
    fn pose(a_from_b: &Isometry) -> Isometry {
        rigid(a_from_b)
    }

    #[inline]
    fn overlaps(&self, other: &Self, a_from_b: &Isometry) -> bool {
        let reach = self.radius + other.radius;
        (a_from_b * other.centre - self.centre).norm_squared() <= reach * reach
    }

    #[inline]
    fn gap_mm(&self, other: &Self, a_from_b: &Isometry) -> f64 {
        ((a_from_b * other.centre - self.centre).norm() - self.radius - other.radius).max(0.0)
    }

    #[inline]
    fn size(&self) -> f64 {
        self.radius
    }

    /// A sphere has no axes of its own, so the split axes are the coordinate axes, ordered by the extent of the contents.
    fn split_axes(&self, triangles: &[Triangle]) -> [Unit<Vector>; 3] {
        let extents = triangle::bounds(triangles).map_or_else(Vector::zeros, |(low, high)| high - low);
        coordinate_axes_by_extent(&extents)
    }
}

impl Solid for Sphere {
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        (point - self.centre).norm() <= self.radius + slack_mm
    }

    fn centre(&self) -> Point {
        self.centre
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius.powi(3)
    }

    fn surface_area(&self) -> f64 {
        4.0 * PI * self.radius.powi(2)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::BoundingVolume;
    use crate::volume::sphere_mean::SphereMean;
    use crate::volume::sphere_ritter::SphereRitter;
    use crate::volume::sphere_welzl::SphereWelzl;
    use obbtree::cases::meshes;

    #[test]
    fn spheres_overlap_up_to_the_sum_of_their_radii() {
        let unit = |x: f64| {
            Triangle::new(Point::new(x - 1.0, 0.0, 0.0), Point::new(x + 1.0, 0.0, 0.0), Point::new(x, 1.0, 0.0))
        };
        let (a, b) = (SphereRitter::fit(&[unit(0.0)]), SphereRitter::fit(&[unit(0.0)]));
        assert!(a.overlaps(&b, &Isometry::translation(1.999_999, 0.0, 0.0)));
        assert!(!a.overlaps(&b, &Isometry::translation(2.000_1, 0.0, 0.0)));
    }

    #[test]
    fn a_sphere_has_its_volume_area_size_and_gap() {
        let sphere = |x: f64, radius: f64| Sphere { centre: Point::new(x, 0.0, 0.0), radius };
        assert!((sphere(5.0, 3.0).volume() - 36.0 * PI).abs() < 1e-12);
        assert!((sphere(5.0, 3.0).surface_area() - 36.0 * PI).abs() < 1e-12);
        assert!(sphere(0.0, 3.0).size() > sphere(0.0, 2.0).size() && sphere(0.0, 2.0).size() > 0.0);
        let pose = Sphere::pose(&Isometry::translation(10.0, 0.0, 0.0));
        assert!((sphere(1.0, 3.0).gap_mm(&sphere(2.0, 4.0), &pose) - 4.0).abs() < 1e-12);
        assert_eq!(sphere(1.0, 8.0).gap_mm(&sphere(2.0, 4.0), &pose), 0.0);
    }

    #[test]
    fn the_smallest_sphere_is_the_smallest_and_no_other_is_twice_as_wide() {
        for subject in meshes::subjects() {
            let triangles = subject.mesh.triangles();
            let least = SphereWelzl::fit(&triangles).radius;
            // The mean lies in the convex hull, so no corner is farther from it than the diameter.
            for radius in [SphereRitter::fit(&triangles).radius, SphereMean::fit(&triangles).radius] {
                assert!(
                    radius >= least * (1.0 - 1e-12) && radius <= 2.0 * least + 1e-6,
                    "{} {radius} {least}",
                    subject.name
                );
            }
        }
    }
}
