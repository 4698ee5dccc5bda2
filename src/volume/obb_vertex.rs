//! The paper's plain box as every library builds it: axes from the triangle corners, tight around the contents.

use super::Info;
use super::obb::ObbRule;
use super::obb::centre::MidExtent;
use super::obb::frame::VertexCovariance;

/// The rule of [`super::obb::Obb`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbVertex;

impl ObbRule for ObbVertex {
    const INFO: Info = Info {
        id: "obb-vertex",
        label: "plain OBB",
        reference: "Xu and Zhang 2011, eq. (1); Gottschalk, Lin and Manocha 1996",
        safe: true,
    };
    type Frame = VertexCovariance;
    type Centre = MidExtent;
}
