//! The paper's improved box taken literally: centred at the area-weighted centroid, with the half-lengths of the tight box. Not safe,
//! because the centroid is not the middle of the extent.

use super::fit::centre::AtMean;
use super::fit::frame::AreaCovariance;
use super::shape::obb::Obb;
use super::{BoundingVolume, Info, fit};
use crate::geometry::Triangle;

/// The variant `obb-area-centroid`.
#[derive(Clone, Copy, Debug)]
pub struct ObbAreaCentroid;

impl BoundingVolume for ObbAreaCentroid {
    const INFO: Info = Info {
        id: "obb-area-centroid",
        label: "area-weighted OBB, paper-literal",
        reference: "Xu and Zhang 2011, eq. (4), (5), read literally",
        safe: false,
    };

    type Shape = Obb;

    fn fit(triangles: &[Triangle]) -> Obb {
        fit::oriented::<AreaCovariance, AtMean>(triangles)
    }
}
