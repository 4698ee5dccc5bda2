//! The box along the axes that DiTO-14 chooses, tight around the contents.

use super::Info;
use super::obb::ObbRule;
use super::obb::centre::MidExtent;
use super::obb::dito::Dito14;

/// The rule of [`super::obb::Obb`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbDito14;

impl ObbRule for ObbDito14 {
    const INFO: Info = Info {
        id: "obb-dito14",
        label: "DiTO-14 OBB",
        reference: "T. Larsson, L. Källberg, Fast Computation of Tight-Fitting Oriented Bounding Boxes, Game Engine Gems 2, 2011",
        safe: true,
    };
    type Frame = Dito14;
    type Centre = MidExtent;
}
