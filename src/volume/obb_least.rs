//! The box with the least surface among three frames. It is not one of the paper's volumes; fast engines use such a box. On the generic
//! tree it shows the effect of choosing the frame alone.

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
