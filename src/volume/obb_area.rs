//! The paper's area-weighted box in its usual implementation: axes from the surface, tight around the contents.

use super::fit::centre::MidExtent;
use super::fit::frame::AreaCovariance;
use super::shape::obb::Obb;
use super::{BoundingVolume, Info, fit};
use crate::geometry::Triangle;

/// The variant `obb-area`.
#[derive(Clone, Copy, Debug)]
pub struct ObbArea;

impl BoundingVolume for ObbArea {
    const INFO: Info = Info {
        id: "obb-area",
        label: "area-weighted OBB",
        reference: "Xu and Zhang 2011, eq. (4), (5); Gottschalk 2000",
        safe: true,
    };

    type Shape = Obb;

    fn fit(triangles: &[Triangle]) -> Obb {
        fit::oriented::<AreaCovariance, MidExtent>(triangles)
    }
}
