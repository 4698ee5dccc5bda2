//! The axis-aligned box, stored in single precision (see [`super::single`]).

use super::Info;
use super::aabb::Aabb;
use super::single::SingleRule;

/// The rule of [`super::single::Single`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct AabbF32;

impl SingleRule for AabbF32 {
    const INFO: Info = Info {
        id: "aabb-f32",
        label: "AABB, f32",
        reference: "G. van den Bergen 1997; stored after C. Ericson, Real-Time Collision Detection, 2005, section 6.6, on compact nodes",
        safe: true,
    };
    type Volume = Aabb;
}
