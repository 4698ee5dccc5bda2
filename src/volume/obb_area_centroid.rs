//! The paper's improved box to the letter: centred at the area-weighted centroid, half as long as the contents. Not safe either:
//! no mean is the middle of an extent.

use super::Info;
use super::obb::ObbRule;
use super::obb::centre::AtMean;
use super::obb::frame::AreaCovariance;

/// The rule of [`super::obb::Obb`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbAreaCentroid;

impl ObbRule for ObbAreaCentroid {
    const INFO: Info = Info {
        id: "obb-area-centroid",
        label: "area-weighted OBB, paper-literal",
        reference: "Xu and Zhang 2011, eq. (4), (5), read literally",
        safe: false,
    };
    type Frame = AreaCovariance;
    type Centre = AtMean;
}
