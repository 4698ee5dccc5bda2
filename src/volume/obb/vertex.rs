//! The plain box: turned by the covariance of the corners, tight around the contents.

use super::centre::MidExtent;
use super::frame::VertexCovariance;
use super::{BoxRule, Info};

/// Axes by [`VertexCovariance`], place by [`MidExtent`].
#[derive(Clone, Debug)]
pub enum ObbVertex {}

impl BoxRule for ObbVertex {
    const INFO: Info = Info {
        id: "obb-vertex",
        label: "plain OBB",
        reference: "Xu and Zhang 2011, equation (1); tight, as S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, SIGGRAPH 1996",
        safe: true,
    };
    type Frame = VertexCovariance;
    type Centre = MidExtent;
}
