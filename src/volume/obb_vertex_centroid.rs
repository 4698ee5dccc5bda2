//! The paper's plain box taken literally: centred at the mean of the corners, with the half-lengths of the tight box. Not safe: this is the
//! defect that the paper describes.

use super::fit::centre::AtMean;
use super::fit::frame::VertexCovariance;
use super::shape::obb::Obb;
use super::{BoundingVolume, Info, fit};
use crate::geometry::Triangle;

/// The variant `obb-vertex-centroid`.
#[derive(Clone, Copy, Debug)]
pub struct ObbVertexCentroid;

impl BoundingVolume for ObbVertexCentroid {
    const INFO: Info = Info {
        id: "obb-vertex-centroid",
        label: "plain OBB, paper-literal",
        reference: "Xu and Zhang 2011, eq. (1) and section 2.3, read literally",
        safe: false,
    };

    type Shape = Obb;

    fn fit(triangles: &[Triangle]) -> Obb {
        fit::oriented::<VertexCovariance, AtMean>(triangles)
    }
}
