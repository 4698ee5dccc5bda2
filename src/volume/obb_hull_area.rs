//! The box along the principal axes of the convex hull's surface, tight around the contents.

use super::fit::centre::MidExtent;
use super::fit::frame::HullAreaCovariance;
use super::shape::obb::Obb;
use super::{BoundingVolume, Info, fit};
use crate::geometry::Triangle;

/// The variant `obb-hull-area`.
#[derive(Clone, Copy, Debug)]
pub struct ObbHullArea;

impl BoundingVolume for ObbHullArea {
    const INFO: Info = Info {
        id: "obb-hull-area",
        label: "hull-weighted OBB",
        reference: "S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, SIGGRAPH 1996, section 4",
        safe: true,
    };

    type Shape = Obb;

    fn fit(triangles: &[Triangle]) -> Obb {
        fit::oriented::<HullAreaCovariance, MidExtent>(triangles)
    }
}
