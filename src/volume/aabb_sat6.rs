//! The axis-aligned box tested by its own three axes and the other's three. The nine cross products of edges are left out, so some disjoint
//! boxes are reported as overlapping.
//!
//! G. van den Bergen, "Efficient Collision Detection of Complex Deformable Models using AABB Trees", 1997, section 3.2
//! ("SAT lite"), reports that this test is wrong in a few percent of the cases.

use super::shape::aligned_box::{AlignedBox, AlignedPose, BoxTest};
use super::{BoundingVolume, Info};
use crate::geometry::separating_axes::separated_by_faces;
use crate::geometry::{Triangle, Vector};

/// The axis-aligned box tested by six axes.
#[derive(Clone, Copy, Debug)]
pub struct AabbSat6;

impl BoundingVolume for AabbSat6 {
    const INFO: Info = Info {
        id: "aabb-sat6",
        label: "AABB, 6 axes",
        reference: "G. van den Bergen, Efficient Collision Detection of Complex Deformable Models using AABB Trees, 1997, SAT lite",
        safe: true,
    };

    type Shape = AlignedBox<AabbSat6>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        AlignedBox::around(triangles)
    }
}

impl BoxTest for AabbSat6 {
    #[inline(always)]
    fn separated(t: &Vector, pose: &AlignedPose, a: &Vector, b: &Vector) -> bool {
        separated_by_faces(t, &pose.rotation, &pose.widened, a, b)
    }
}
