//! The axis-aligned box around the other box after its motion, as in an engine that keeps all boxes aligned to one frame.
//!
//! J. Arvo, "Transforming Axis-Aligned Bounding Boxes", Graphics Gems, 1990. Deviation: the common frame is that of the first mesh, not
//! that of the world, so one of the two boxes stays tight. Exchanging the meshes may therefore change the answer for disjoint boxes.

use super::shape::aligned_box::{AlignedBox, AlignedPose, BoxTest};
use super::{BoundingVolume, Info};
use crate::geometry::{Triangle, Vector};

/// The axis-aligned box, re-fitted to the other's axes.
#[derive(Clone, Copy, Debug)]
pub struct AabbRefit;

impl BoundingVolume for AabbRefit {
    const INFO: Info = Info {
        id: "aabb-refit",
        label: "AABB, re-fitted",
        reference: "J. Arvo, Transforming Axis-Aligned Bounding Boxes, Graphics Gems, 1990",
        safe: true,
    };

    type Shape = AlignedBox<AabbRefit>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        AlignedBox::around(triangles)
    }
}

impl BoxTest for AabbRefit {
    #[inline(always)]
    fn separated(t: &Vector, pose: &AlignedPose, a: &Vector, b: &Vector) -> bool {
        let q = &pose.widened;
        (0..3).any(|i| t[i].abs() > a[i] + q[(i, 0)] * b[0] + q[(i, 1)] * b[1] + q[(i, 2)] * b[2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Isometry;
    use crate::volume::Shape;

    #[test]
    fn boxes_that_just_touch_are_not_separated() {
        let pose = AlignedBox::<AabbRefit>::pose(&Isometry::identity());
        let (a, b) = (Vector::new(1.0, 2.0, 3.0), Vector::new(4.0, 5.0, 6.0));
        let q = &pose.widened;
        let reach = a[0] + q[(0, 0)] * b[0] + q[(0, 1)] * b[1] + q[(0, 2)] * b[2];
        assert!(!AabbRefit::separated(&Vector::new(reach, 0.0, 0.0), &pose, &a, &b));
        assert!(AabbRefit::separated(&Vector::new(-reach.next_up(), 0.0, 0.0), &pose, &a, &b));
    }
}
