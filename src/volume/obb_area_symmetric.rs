//! An area-weighted box that keeps the paper's centre and is made long enough to contain everything.

use super::fit::centre::SymmetricAboutMean;
use super::fit::frame::AreaCovariance;
use super::shape::obb::Obb;
use super::{BoundingVolume, Info, fit};
use crate::geometry::Triangle;

/// The variant `obb-area-symmetric`.
#[derive(Clone, Copy, Debug)]
pub struct ObbAreaSymmetric;

impl BoundingVolume for ObbAreaSymmetric {
    const INFO: Info = Info {
        id: "obb-area-symmetric",
        label: "area-weighted OBB, symmetric",
        reference: "Xu and Zhang 2011, eq. (4), (5); half-lengths to the farthest corner",
        safe: true,
    };

    type Shape = Obb;

    fn fit(triangles: &[Triangle]) -> Obb {
        fit::oriented::<AreaCovariance, SymmetricAboutMean>(triangles)
    }
}
