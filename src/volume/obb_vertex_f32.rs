//! The plain box, stored in single precision (see [`super::single`]).

use super::Info;
use super::obb::Obb;
use super::obb_vertex::ObbVertex;
use super::single::SingleRule;

/// The rule of [`super::single::Single`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbVertexF32;

impl SingleRule for ObbVertexF32 {
    const INFO: Info = Info {
        id: "obb-vertex-f32",
        label: "plain OBB, f32",
        reference: "Xu and Zhang 2011, eq. (1); stored after C. Ericson, Real-Time Collision Detection, 2005, section 6.6, on compact nodes",
        safe: true,
    };
    type Volume = Obb<ObbVertex>;
}
