//! Spheres: one sphere, one test; where the centre lies is a rule, so that the effect of the fit can be measured apart.

use super::separating_axes::pad_mm;
use super::{BoundingVolume, Info, Segment, coordinate_axes_by_extent};
use crate::geometry::rigid::rigid;
use crate::geometry::{Isometry, Point, Triangle, Vector, triangle};
use nalgebra::Unit;
use std::f64::consts::{PI, TAU};
use std::fmt::Debug;
use std::marker::PhantomData;

/// What makes one sphere a variant: its name and how its centre is found.
pub trait SphereRule: Clone + Debug + Send + Sync + 'static {
    /// Name and promise.
    const INFO: Info;
    /// The centre of a sphere around `triangles` (at least one), mm.
    fn centre(triangles: &[Triangle]) -> Point;
}

/// A centre and the distance of the farthest corner from it, mm, mesh frame.
#[derive(Clone, Debug)]
pub struct Sphere<R> {
    pub(super) centre: Point,
    pub(super) radius: f64,
    pub(super) rule: PhantomData<R>,
}

/// The distance of the farthest corner from `centre`, mm.
#[must_use]
pub fn farthest_mm(centre: &Point, triangles: &[Triangle]) -> f64 {
    triangle::corners(triangles).map(|corner| (corner - centre).norm()).fold(0.0, f64::max)
}

impl<R> Sphere<R> {
    /// The sphere with this centre and radius, mm.
    #[must_use]
    pub const fn new(centre: Point, radius: f64) -> Self {
        Self { centre, radius, rule: PhantomData }
    }
}

impl<R: SphereRule> BoundingVolume for Sphere<R> {
    const INFO: Info = R::INFO;

    type Pose = Isometry;

    fn fit(triangles: &[Triangle]) -> Self {
        let centre = R::centre(triangles);
        let farthest = farthest_mm(&centre, triangles);
        Self::new(centre, farthest + pad_mm(centre.coords.amax() + farthest))
    }

    fn pose(a_from_b: &Isometry) -> Isometry {
        rigid(a_from_b)
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

#[cfg(test)]
mod tests {
    use super::super::sphere_mean::SphereMean;
    use super::super::sphere_ritter::SphereRitter;
    use super::super::sphere_welzl::SphereWelzl;
    use super::*;
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
