//! The box with the least surface of three frames: not one of the paper's, but what a fast engine wants. On the generic tree it shows what the
//! choice of the frame alone is worth.

use super::Info;
use super::obb::ObbRule;
use super::obb::centre::MidExtent;
use super::obb::frame::LeastSurface;

/// The rule of [`super::obb::Obb`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbLeast;

impl ObbRule for ObbLeast {
    const INFO: Info = Info {
        id: "obb-least",
        label: "least-surface OBB",
        reference: "least surface of the principal axes (Gottschalk 2000), the mesh's and the largest triangle's",
        safe: true,
    };
    type Frame = LeastSurface;
    type Centre = MidExtent;
}
