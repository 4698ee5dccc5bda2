//! The area-weighted box, stored in single precision (see [`super::single`]).

use super::Info;
use super::obb::Obb;
use super::obb_area::ObbArea;
use super::single::SingleRule;

/// The rule of [`super::single::Single`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbAreaF32;

impl SingleRule for ObbAreaF32 {
    const INFO: Info = Info {
        id: "obb-area-f32",
        label: "area-weighted OBB, f32",
        reference: "Xu and Zhang 2011, eq. (4), (5); stored after C. Ericson, Real-Time Collision Detection, 2005, section 6.6, on compact nodes",
        safe: true,
    };
    type Volume = Obb<ObbArea>;
}
