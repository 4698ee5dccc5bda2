//! An area-weighted box that keeps the paper's centre and is made long enough to contain everything.

use super::Info;
use super::obb::ObbRule;
use super::obb::centre::SymmetricAboutMean;
use super::obb::frame::AreaCovariance;

/// The rule of [`super::obb::Obb`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbAreaSymmetric;

impl ObbRule for ObbAreaSymmetric {
    const INFO: Info = Info {
        id: "obb-area-symmetric",
        label: "area-weighted OBB, symmetric",
        reference: "Xu and Zhang 2011, eq. (4), (5); half-lengths to the farthest corner",
        safe: true,
    };
    type Frame = AreaCovariance;
    type Centre = SymmetricAboutMean;
}
