//! The box of least volume, to one part in a thousand where [`super::obb::minimum`] says so. Slow to build, on purpose: a
//! reference for what orientation can give.

use super::Info;
use super::obb::ObbRule;
use super::obb::centre::MidExtent;
use super::obb::minimum::MinimumVolume;

/// The rule of [`super::obb::Obb`] that makes it this variant.
#[derive(Clone, Copy, Debug)]
pub struct ObbMin;

impl ObbRule for ObbMin {
    const INFO: Info = Info {
        id: "obb-min",
        label: "smallest OBB",
        reference: "J. O'Rourke, Finding Minimal Enclosing Boxes, 1985",
        safe: true,
    };
    type Frame = MinimumVolume;
    type Centre = MidExtent;
}
