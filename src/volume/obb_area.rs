//! The paper's area-weighted box as every library builds it: axes from the surface, tight around the contents.

use super::Info;
use super::obb::ObbRule;
use super::obb::centre::MidExtent;
use super::obb::frame::AreaCovariance;

/// The rule of [`super::obb::Obb`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbArea;

impl ObbRule for ObbArea {
    const INFO: Info = Info {
        id: "obb-area",
        label: "area-weighted OBB",
        reference: "Xu and Zhang 2011, eq. (4), (5); Gottschalk 2000",
        safe: true,
    };
    type Frame = AreaCovariance;
    type Centre = MidExtent;
}
