//! The box along the axes that DiTO-14 chooses, tight around the contents.

use super::fit::centre::MidExtent;
use super::fit::dito::Dito14;
use super::shape::obb::Obb;
use super::{BoundingVolume, Info, fit};
use crate::geometry::Triangle;

/// The variant `obb-dito14`.
#[derive(Clone, Copy, Debug)]
pub struct ObbDito14;

impl BoundingVolume for ObbDito14 {
    const INFO: Info = Info {
        id: "obb-dito14",
        label: "DiTO-14 OBB",
        reference: "T. Larsson, L. Källberg, Fast Computation of Tight-Fitting Oriented Bounding Boxes, Game Engine Gems 2, 2011",
        safe: true,
    };

    type Shape = Obb;

    fn fit(triangles: &[Triangle]) -> Obb {
        fit::oriented::<Dito14, MidExtent>(triangles)
    }
}
