//! Oriented boxes: one box, one separating-axis test. The variant chooses the axes and the centre ([`crate::volume::fit`]).

pub mod exit;

use crate::geometry::separating_axes::{box_contains, gap_mm, separated, widened_abs};
use crate::geometry::{Isometry, Point, Triangle, Vector, rigid};
use crate::volume::{Segment, Shape, Solid, axes_by_extent, box_area, box_outline};
use nalgebra::{Matrix3, Unit};

/// Axes, centre and half-lengths, mm, mesh frame.
#[derive(Clone, Debug)]
pub struct Obb {
    /// The box's axes as columns of a rotation.
    pub axes: Matrix3<f64>,
    /// Its centre.
    pub centre: Point,
    /// Half-lengths of the box along the axes, mm.
    pub half: Vector,
}

/// Rotation and translation, mm, from the second mesh to the first.
#[derive(Clone, Debug)]
pub struct ObbPose {
    /// Maps axes of the second mesh to axes of the first.
    pub rotation: Matrix3<f64>,
    /// The second mesh's origin in the first.
    pub translation: Vector,
}

impl ObbPose {
    /// The constants of a relative pose.
    #[inline]
    pub fn new(a_from_b: &Isometry) -> Self {
        let rotation = rigid::rotation(a_from_b);
        Self { rotation, translation: a_from_b.translation.vector }
    }
}

impl Shape for Obb {
    type Pose = ObbPose;

    #[inline]
    fn pose(a_from_b: &Isometry) -> ObbPose {
        ObbPose::new(a_from_b)
    }

    // So that a traversal with one box in two tests moves it once.
    #[inline(always)]
    fn overlaps(&self, other: &Self, pose: &ObbPose) -> bool {
        let between = pose.rotation * other.centre.coords + pose.translation - self.centre.coords;
        let t = self.axes.tr_mul(&between);
        let r = self.axes.tr_mul(&(pose.rotation * other.axes));
        !separated(&t, &r, &widened_abs(&r), &self.half, &other.half)
    }

    #[inline]
    fn gap_mm(&self, other: &Self, pose: &ObbPose) -> f64 {
        let between = pose.rotation * other.centre.coords + pose.translation - self.centre.coords;
        let t = self.axes.tr_mul(&between);
        let r = self.axes.tr_mul(&(pose.rotation * other.axes));
        gap_mm(&t, &r, &widened_abs(&r), &self.half, &other.half)
    }

    #[inline]
    fn size(&self) -> f64 {
        self.half.norm_squared()
    }

    fn split_axes(&self, _: &[Triangle]) -> [Unit<Vector>; 3] {
        axes_by_extent(&self.axes, &self.half)
    }
}

impl Solid for Obb {
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        box_contains(&self.axes.tr_mul(&(point - self.centre)), &self.half, slack_mm)
    }

    fn centre(&self) -> Point {
        self.centre
    }

    fn volume(&self) -> f64 {
        8.0 * self.half.product()
    }

    fn surface_area(&self) -> f64 {
        box_area(&self.half)
    }

    fn outline(&self) -> Vec<Segment> {
        box_outline(&self.centre, &self.axes, &self.half)
    }

    fn as_box(&self) -> Option<Obb> {
        Some(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{
        BoundingVolume, obb_area::ObbArea, obb_vertex::ObbVertex, obb_vertex_centroid::ObbVertexCentroid,
        obb_vertex_symmetric::ObbVertexSymmetric,
    };

    /// A flat strip from x = 0 to 12 and y = 0 to 2: one half of its length is a single large rectangle, the other half is
    /// cut into ten.
    fn strip() -> Vec<Triangle> {
        let p = |x: f64, y: f64| Point::new(x, y, 0.0);
        let rectangle = |x: f64, w: f64| {
            [Triangle::new(p(x, 0.0), p(x + w, 0.0), p(x + w, 2.0)), Triangle::new(p(x, 0.0), p(x + w, 2.0), p(x, 2.0))]
        };
        let fine = (0..10).map(|i| rectangle(6.0 + 0.6 * f64::from(i), 0.6));
        rectangle(0.0, 6.0).into_iter().chain(fine.flatten()).collect()
    }

    #[test]
    fn the_literal_box_drifts_to_the_fine_side_and_leaves_the_coarse_end_outside() {
        let coarse_end = Point::new(0.0, 1.0, 0.0);
        let tight = ObbVertex::fit(&strip());
        assert!((tight.centre - Point::new(6.0, 1.0, 0.0)).norm() < 1e-6 && tight.contains(&coarse_end, 0.0));
        let literal = ObbVertexCentroid::fit(&strip());
        // Corners: the coarse rectangle's mean x is 3, the ten fine ones' means are 6.3, 6.9 ... 11.7; each weighs the same.
        let mean_x = (3.0 + 10.0 * 9.0) / 11.0;
        assert!((literal.centre.x - mean_x).abs() < 0.01, "{} {mean_x}", literal.centre.x);
        assert!(!literal.contains(&coarse_end, 2.0) && literal.contains(&coarse_end, 3.0));
        let symmetric = ObbVertexSymmetric::fit(&strip());
        assert!(symmetric.contains(&coarse_end, 0.0) && symmetric.volume() > tight.volume());
    }

    #[test]
    fn area_weighting_finds_the_axes_of_a_rectangle_whatever_its_diagonal() {
        let p = |x: f64, y: f64| Point::new(x, y, 0.0);
        let rectangle = [
            Triangle::new(p(0.0, 0.0), p(3.0, 0.0), p(3.0, 2.0)),
            Triangle::new(p(0.0, 0.0), p(3.0, 2.0), p(0.0, 2.0)),
        ];
        assert!((ObbArea::fit(&rectangle).surface_area() - 12.0).abs() < 1e-5); // both sides of 3 x 2
        assert!(ObbVertex::fit(&rectangle).surface_area() > 12.5); // turned toward the diagonal
    }
}
