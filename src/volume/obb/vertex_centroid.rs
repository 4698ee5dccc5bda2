//! The plain box as the paper describes its defect: it does not hold its contents. Measured, never ranked.

use super::centre::MeanHalfExtent;
use super::frame::VertexCovariance;
use super::{BoxRule, Info};

/// Axes by [`VertexCovariance`], place by [`MeanHalfExtent`].
#[derive(Clone, Debug)]
pub enum ObbVertexCentroid {}

impl BoxRule for ObbVertexCentroid {
    const INFO: Info = Info {
        id: "obb-vertex-centroid",
        label: "plain OBB, paper-literal",
        reference: "Xu and Zhang 2011, equation (1) read literally: centred at the mean of the corners",
        safe: false,
    };
    type Frame = VertexCovariance;
    type Centre = MeanHalfExtent;
}
