//! The box of least volume, to one part in a thousand within the limits of [`super::fit::minimum`]. It is slow to build, because it serves
//! as the reference for the best orientation.

use super::fit::centre::MidExtent;
use super::fit::minimum::MinimumVolume;
use super::shape::obb::Obb;
use super::{BoundingVolume, Info, fit};
use crate::geometry::Triangle;

/// The variant `obb-min`.
#[derive(Clone, Copy, Debug)]
pub struct ObbMin;

impl BoundingVolume for ObbMin {
    const INFO: Info = Info {
        id: "obb-min",
        label: "smallest OBB",
        reference: "J. O'Rourke, Finding Minimal Enclosing Boxes, 1985",
        safe: true,
    };

    type Shape = Obb;

    fn fit(triangles: &[Triangle]) -> Obb {
        fit::oriented::<MinimumVolume, MidExtent>(triangles)
    }
}
