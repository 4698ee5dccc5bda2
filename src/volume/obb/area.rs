//! The area-weighted box: turned by the covariance of the surface, tight around the contents.

use super::centre::MidExtent;
use super::frame::AreaCovariance;
use super::{BoxRule, Info};

/// Axes by [`AreaCovariance`], place by [`MidExtent`].
#[derive(Clone, Debug)]
pub enum ObbArea {}

impl BoxRule for ObbArea {
    const INFO: Info = Info {
        id: "obb-area",
        label: "area-weighted OBB",
        reference: "Xu and Zhang 2011, equation (5); S. Gottschalk, Collision Queries using Oriented Bounding Boxes, 2000",
        safe: true,
    };
    type Frame = AreaCovariance;
    type Centre = MidExtent;
}
