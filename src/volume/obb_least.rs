//! The box with the least surface of three frames: not one of the paper's, but what a fast engine wants. On the generic tree it shows what the
//! choice of the frame alone is worth.

use super::fit::centre::MidExtent;
use super::fit::frame::LeastSurface;
use super::shape::obb::Obb;
use super::{BoundingVolume, Info, fit};
use crate::geometry::Triangle;

/// The variant `obb-least`.
#[derive(Clone, Copy, Debug)]
pub struct ObbLeast;

impl BoundingVolume for ObbLeast {
    const INFO: Info = Info {
        id: "obb-least",
        label: "least-surface OBB",
        reference: "least surface of the principal axes (Gottschalk 2000), the mesh's and the largest triangle's",
        safe: true,
    };

    type Shape = Obb;

    fn fit(triangles: &[Triangle]) -> Obb {
        fit::oriented::<LeastSurface, MidExtent>(triangles)
    }
}
