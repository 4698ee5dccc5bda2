//! The plain box centred at the mean of the corners, and long enough to hold its contents all the same.

use super::centre::MeanFarthest;
use super::frame::VertexCovariance;
use super::{BoxRule, Info};

/// Axes by [`VertexCovariance`], place by [`MeanFarthest`].
#[derive(Clone, Debug)]
pub enum ObbVertexSymmetric {}

impl BoxRule for ObbVertexSymmetric {
    const INFO: Info = Info {
        id: "obb-vertex-symmetric",
        label: "plain OBB, symmetric",
        reference: "Xu and Zhang 2011, equation (1); centred at the mean of the corners and long enough for the farther side",
        safe: true,
    };
    type Frame = VertexCovariance;
    type Centre = MeanFarthest;
}
