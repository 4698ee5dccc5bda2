//! The paper's plain box in its usual implementation: axes from the triangle corners, tight around the contents.

use super::fit::centre::MidExtent;
use super::fit::frame::VertexCovariance;
use super::shape::obb::Obb;
use super::{BoundingVolume, Info, fit};
use crate::geometry::Triangle;

/// The variant `obb-vertex`.
#[derive(Clone, Copy, Debug)]
pub struct ObbVertex;

impl BoundingVolume for ObbVertex {
    const INFO: Info = Info {
        id: "obb-vertex",
        label: "plain OBB",
        reference: "Xu and Zhang 2011, eq. (1); Gottschalk, Lin and Manocha 1996",
        safe: true,
    };

    type Shape = Obb;

    fn fit(triangles: &[Triangle]) -> Obb {
        fit::oriented::<VertexCovariance, MidExtent>(triangles)
    }
}
