//! A plain box that keeps the paper's centre and is made long enough to contain everything.

use super::fit::centre::SymmetricAboutMean;
use super::fit::frame::VertexCovariance;
use super::shape::obb::Obb;
use super::{BoundingVolume, Info, fit};
use crate::geometry::Triangle;

/// The variant `obb-vertex-symmetric`.
#[derive(Clone, Copy, Debug)]
pub struct ObbVertexSymmetric;

impl BoundingVolume for ObbVertexSymmetric {
    const INFO: Info = Info {
        id: "obb-vertex-symmetric",
        label: "plain OBB, symmetric",
        reference: "Xu and Zhang 2011, eq. (1); half-lengths to the farthest corner",
        safe: true,
    };

    type Shape = Obb;

    fn fit(triangles: &[Triangle]) -> Obb {
        fit::oriented::<VertexCovariance, SymmetricAboutMean>(triangles)
    }
}
