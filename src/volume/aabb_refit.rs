//! The axis-aligned box around the other's moved box: what an engine does that keeps all boxes aligned to one frame.
//!
//! J. Arvo, "Transforming Axis-Aligned Bounding Boxes", Graphics Gems, 1990. Deviation: the common frame is that of the first
//! mesh, not the world's, so that one of the two boxes stays tight, and
//! exchanging the meshes may change the answer for boxes that are apart.

use super::Info;
use super::aabb::{AabbPose, AabbRule, AlignedBox};
use crate::geometry::Vector;

/// The rule of [`AlignedBox`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct Refit;

/// The axis-aligned box, re-fitted to the other's axes.
pub type AabbRefit = AlignedBox<Refit>;

impl AabbRule for Refit {
    const INFO: Info = Info {
        id: "aabb-refit",
        label: "AABB, re-fitted",
        reference: "J. Arvo, Transforming Axis-Aligned Bounding Boxes, Graphics Gems, 1990",
        safe: true,
    };

    #[inline(always)]
    fn separated(t: &Vector, pose: &AabbPose, a: &Vector, b: &Vector) -> bool {
        let q = &pose.widened;
        (0..3).any(|i| t[i].abs() > a[i] + q[(i, 0)] * b[0] + q[(i, 1)] * b[1] + q[(i, 2)] * b[2])
    }
}
