//! The axis-aligned box tested by its own three axes and the other's three: the nine products of edges are left out, which can
//! only keep boxes together that are apart.
//!
//! G. van den Bergen, "Efficient Collision Detection of Complex Deformable Models using AABB Trees", 1997, section 3.2
//! ("SAT lite"), who finds that it errs in a few percent of the tests.

use super::Info;
use super::aabb::{AabbPose, AabbRule, AlignedBox};
use super::separating_axes::separated_by_faces;
use crate::geometry::Vector;

/// The rule of [`AlignedBox`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct SixAxes;

/// The axis-aligned box tested by six axes.
pub type AabbSat6 = AlignedBox<SixAxes>;

impl AabbRule for SixAxes {
    const INFO: Info = Info {
        id: "aabb-sat6",
        label: "AABB, 6 axes",
        reference: "G. van den Bergen, Efficient Collision Detection of Complex Deformable Models using AABB Trees, 1997, SAT lite",
        safe: true,
    };

    #[inline(always)]
    fn separated(t: &Vector, pose: &AabbPose, a: &Vector, b: &Vector) -> bool {
        separated_by_faces(t, &pose.rotation, &pose.widened, a, b)
    }
}
