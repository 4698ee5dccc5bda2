//! The 8-DOP, stored in single precision (see [`super::single`]).

use super::Info;
use super::dop_8::Dop8;
use super::single::SingleRule;

/// The rule of [`super::single::Single`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct Dop8F32;

impl SingleRule for Dop8F32 {
    const INFO: Info = Info {
        id: "dop-8-f32",
        label: "8-DOP, f32",
        reference: "C. Ericson 2005, section 4.6; stored after C. Ericson, Real-Time Collision Detection, 2005, section 6.6, on compact nodes",
        safe: true,
    };
    type Volume = Dop8;
}
