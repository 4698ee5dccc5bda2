//! Ritter's sphere, stored in single precision (see [`super::single`]).

use super::Info;
use super::single::SingleRule;
use super::sphere_ritter::SphereRitter;

/// The rule of [`super::single::Single`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct SphereRitterF32;

impl SingleRule for SphereRitterF32 {
    const INFO: Info = Info {
        id: "sphere-ritter-f32",
        label: "sphere, f32",
        reference: "J. Ritter 1990; stored after C. Ericson, Real-Time Collision Detection, 2005, section 6.6, on compact nodes",
        safe: true,
    };
    type Volume = SphereRitter;
}
