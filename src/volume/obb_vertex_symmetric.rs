//! A plain box that keeps the paper's centre and is made long enough to contain everything.

use super::Info;
use super::obb::ObbRule;
use super::obb::centre::SymmetricAboutMean;
use super::obb::frame::VertexCovariance;

/// The rule of [`super::obb::Obb`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbVertexSymmetric;

impl ObbRule for ObbVertexSymmetric {
    const INFO: Info = Info {
        id: "obb-vertex-symmetric",
        label: "plain OBB, symmetric",
        reference: "Xu and Zhang 2011, eq. (1); half-lengths to the farthest corner",
        safe: true,
    };
    type Frame = VertexCovariance;
    type Centre = SymmetricAboutMean;
}
