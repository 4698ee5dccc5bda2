//! The box along the principal axes of the convex hull's surface, tight around the contents.

use super::Info;
use super::obb::ObbRule;
use super::obb::centre::MidExtent;
use super::obb::frame::HullAreaCovariance;

/// The rule of [`super::obb::Obb`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbHullArea;

impl ObbRule for ObbHullArea {
    const INFO: Info = Info {
        id: "obb-hull-area",
        label: "hull-weighted OBB",
        reference: "S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, SIGGRAPH 1996, section 4",
        safe: true,
    };
    type Frame = HullAreaCovariance;
    type Centre = MidExtent;
}
