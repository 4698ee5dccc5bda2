//! The axis-aligned box tested by all fifteen separating axes.
//!
//! G. van den Bergen, "Efficient Collision Detection of Complex Deformable Models using AABB Trees", 1997, section 3.2.

use super::shape::aligned_box::{AlignedBox, AlignedPose, BoxTest};
use super::{BoundingVolume, Info};
use crate::geometry::separating_axes::separated;
use crate::geometry::{Triangle, Vector};

/// The axis-aligned box with the full separating-axis test.
#[derive(Clone, Copy, Debug)]
pub struct Aabb;

impl BoundingVolume for Aabb {
    const INFO: Info = Info {
        id: "aabb",
        label: "AABB",
        reference: "G. van den Bergen, Efficient Collision Detection of Complex Deformable Models using AABB Trees, 1997",
        safe: true,
    };

    type Shape = AlignedBox<Aabb>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        AlignedBox::around(triangles)
    }
}

impl BoxTest for Aabb {
    #[inline(always)]
    fn separated(t: &Vector, pose: &AlignedPose, a: &Vector, b: &Vector) -> bool {
        separated(t, &pose.rotation, &pose.widened, a, b)
    }
}
