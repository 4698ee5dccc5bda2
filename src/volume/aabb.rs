//! The axis-aligned box of the mesh's own frame, tested at relative poses.
//!
//! G. van den Bergen, "Efficient Collision Detection of Complex Deformable Models using AABB Trees", Journal of Graphics
//! Tools 2(4), 1997. The boxes are never refitted: the tree stays in its mesh's frame, so under a rotation the test is
//! that of two oriented boxes, all 15 directions of it, except that one rotation serves all nodes. Deviation: none but
//! the rounding pad.

use super::separating_axis::{self, Orientation, separated, squared_distance};
use super::{BoundingVolume, Info, Segment, coordinate_axes_by_extent, rounding_pad};
use crate::geometry::{Isometry, Point, Triangle, Vector, triangle};
use nalgebra::{Matrix3, Unit};

/// Middle and half-lengths, mm, mesh frame.
#[derive(Clone, Debug)]
pub struct Aabb {
    middle: Point,
    half: Vector,
}

/// What one relative pose contributes to the test of two axis-aligned boxes.
#[derive(Clone, Debug)]
pub struct AabbPose {
    rotation: Matrix3<f64>,
    translation: Vector,
    orientation: Orientation,
}

impl BoundingVolume for Aabb {
    const INFO: Info = Info {
        id: "aabb",
        label: "AABB",
        reference: "G. van den Bergen, Efficient Collision Detection of Complex Deformable Models using AABB Trees, 1997",
        safe: true,
    };

    type Pose = AabbPose;

    fn fit(triangles: &[Triangle]) -> Self {
        let first = triangles[0].corners[0];
        let (low, high) = triangle::corners(triangles).fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
        let middle = nalgebra::center(&low, &high);
        let half = (high - low) / 2.0;
        let pad = rounding_pad(middle.coords.amax() + half.sum());
        Self { middle, half: half.add_scalar(pad) }
    }

    fn pose(a_from_b: &Isometry) -> AabbPose {
        let rotation = a_from_b.rotation.to_rotation_matrix().into_inner();
        AabbPose { rotation, translation: a_from_b.translation.vector, orientation: Orientation::new(rotation) }
    }

    #[inline]
    fn overlaps(&self, other: &Self, pose: &AabbPose) -> bool {
        let t = pose.rotation * other.middle.coords + (pose.translation - self.middle.coords);
        !separated(&self.half, &other.half, &t, &pose.orientation)
    }

    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        squared_distance(&(point - self.middle), &self.half) <= slack_mm * slack_mm
    }

    fn centre(&self) -> Point {
        self.middle
    }

    fn volume(&self) -> f64 {
        8.0 * self.half.product()
    }

    fn surface_area(&self) -> f64 {
        let h = &self.half;
        8.0 * (h.x * h.y + h.y * h.z + h.z * h.x)
    }

    fn split_axes(&self, _: &[Triangle]) -> [Unit<Vector>; 3] {
        coordinate_axes_by_extent(&self.half)
    }

    /// The twelve edges.
    fn outline(&self) -> Vec<Segment> {
        separating_axis::edges().map(|edge| edge.map(|corner| self.middle + corner.component_mul(&self.half))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spanning(low: [f64; 3], high: [f64; 3]) -> Aabb {
        let (low, high) = (Point::from(low), Point::from(high));
        Aabb::fit(&[Triangle::new(low, high, low)])
    }

    #[test]
    fn a_segment_gets_the_box_over_its_ends() {
        let aabb = spanning([1.0, 2.0, 3.0], [3.0, 8.0, 3.0]);
        assert_eq!(aabb.middle, Point::new(2.0, 5.0, 3.0));
        assert!((aabb.half - Vector::new(1.0, 3.0, 0.0)).amax() < 1e-7); // the pad
        assert!(aabb.half.z > 0.0);
        assert!((spanning([0.0; 3], [1.0, 2.0, 3.0]).volume() - 6.0).abs() < 1e-6);
        assert!((spanning([0.0; 3], [1.0, 2.0, 3.0]).surface_area() - 22.0).abs() < 1e-6); // 2(2 + 6 + 3)
        assert_eq!(*aabb.split_axes(&[])[0], Vector::y());
    }

    #[test]
    fn a_turned_box_reaches_its_diagonal() {
        // Half-lengths 1; turned 45° about z the right one reaches √2 along x: contact at 2.41421.
        let cube = spanning([-1.0; 3], [1.0; 3]);
        let at = |x: f64| {
            let turn = Vector::z() * std::f64::consts::FRAC_PI_4;
            cube.overlaps(&cube, &Aabb::pose(&Isometry::new(Vector::new(x, 0.0, 0.0), turn)))
        };
        assert!(at(2.414));
        assert!(!at(2.415));
    }

    #[test]
    fn slack_is_a_distance() {
        let cube = spanning([-1.0; 3], [1.0; 3]);
        let outside = Point::new(4.0, 5.0, 0.0); // 3 and 4 beyond two faces: 5 mm away
        assert!(cube.contains(&outside, 5.0) && !cube.contains(&outside, 4.999));
    }
}
