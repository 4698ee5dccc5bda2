//! The axis-aligned box, kept in its mesh's axes and tested at any relative pose by the fifteen separating axes.
//!
//! G. van den Bergen, "Efficient Collision Detection of Complex Deformable Models using AABB Trees", 1997. Because all boxes
//! of a mesh share its axes, the rotation between two boxes, and its absolute values, are constants of the pose. The box
//! is not re-fitted in the world frame: that would be another variant.

use super::separating_axes::{box_contains, gap_mm, pad_mm, separated, widened_abs};
use super::{BoundingVolume, Info, Segment, box_outline, coordinate_axes_by_extent};
use crate::geometry::{Isometry, Point, Triangle, Vector, triangle};
use nalgebra::{Matrix3, Unit};

/// Centre and half-lengths, mm, mesh axes.
#[derive(Clone, Debug)]
pub struct Aabb {
    centre: Point,
    half: Vector,
}

/// Rotation, its widened absolute values, and translation, mm, from the second mesh to the first.
#[derive(Clone, Debug)]
pub struct AabbPose {
    rotation: Matrix3<f64>,
    widened: Matrix3<f64>,
    translation: Vector,
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
        let (low, high) = triangle::bounds(triangles).unwrap_or((Point::origin(), Point::origin()));
        let pad = pad_mm(low.coords.amax().max(high.coords.amax()));
        Self { centre: nalgebra::center(&low, &high), half: (high - low) * 0.5 + Vector::repeat(pad) }
    }

    fn pose(a_from_b: &Isometry) -> AabbPose {
        let rotation = a_from_b.rotation.to_rotation_matrix().into_inner();
        AabbPose { rotation, widened: widened_abs(&rotation), translation: a_from_b.translation.vector }
    }

    #[inline]
    fn overlaps(&self, other: &Self, pose: &AabbPose) -> bool {
        let t = pose.rotation * other.centre.coords + pose.translation - self.centre.coords;
        !separated(&t, &pose.rotation, &pose.widened, &self.half, &other.half)
    }

    fn gap_mm(&self, other: &Self, pose: &AabbPose) -> f64 {
        let t = pose.rotation * other.centre.coords + pose.translation - self.centre.coords;
        gap_mm(&t, &pose.rotation, &pose.widened, &self.half, &other.half)
    }

    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        box_contains(&(point - self.centre), &self.half, slack_mm)
    }

    fn centre(&self) -> Point {
        self.centre
    }

    fn size(&self) -> f64 {
        self.half.norm_squared()
    }

    fn volume(&self) -> f64 {
        8.0 * self.half.product()
    }

    fn surface_area(&self) -> f64 {
        8.0 * (self.half.x * self.half.y + self.half.y * self.half.z + self.half.z * self.half.x)
    }

    fn split_axes(&self, _: &[Triangle]) -> [Unit<Vector>; 3] {
        coordinate_axes_by_extent(&self.half)
    }

    fn outline(&self) -> Vec<Segment> {
        box_outline(&self.centre, &Matrix3::identity(), &self.half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_gets_its_bounds() {
        let t = Triangle::new(Point::new(1.0, 2.0, 3.0), Point::new(5.0, 2.0, 3.0), Point::new(1.0, 8.0, 3.0));
        let fitted = Aabb::fit(&[t]);
        assert_eq!(fitted.centre, Point::new(3.0, 5.0, 3.0));
        assert!((fitted.volume() - 0.0).abs() < 1e-5 && (fitted.surface_area() - 2.0 * 4.0 * 6.0).abs() < 1e-5);
        assert!(fitted.contains(&Point::new(5.0, 8.0, 3.0), 0.0) && !fitted.contains(&Point::new(5.1, 8.0, 3.0), 0.05));
    }
}
