//! The paper's plain box to the letter: centred at the mean of the corners, half as long as the contents. Not safe: that is the
//! defect which the paper describes.

use super::Info;
use super::obb::ObbRule;
use super::obb::centre::AtMean;
use super::obb::frame::VertexCovariance;

/// The rule of [`super::obb::Obb`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbVertexCentroid;

impl ObbRule for ObbVertexCentroid {
    const INFO: Info = Info {
        id: "obb-vertex-centroid",
        label: "plain OBB, paper-literal",
        reference: "Xu and Zhang 2011, eq. (1) and section 2.3, read literally",
        safe: false,
    };
    type Frame = VertexCovariance;
    type Centre = AtMean;
}
