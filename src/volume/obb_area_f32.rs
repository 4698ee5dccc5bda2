//! The area-weighted box, stored in single precision (see [`super::shape::single`]).

use super::obb_area::ObbArea;
use super::shape::obb::Obb;
use super::shape::single::Single;
use super::{BoundingVolume, Info};
use crate::geometry::Triangle;

/// The variant `obb-area-f32`.
#[derive(Clone, Copy, Debug)]
pub struct ObbAreaF32;

impl BoundingVolume for ObbAreaF32 {
    const INFO: Info = Info {
        id: "obb-area-f32",
        label: "area-weighted OBB, f32",
        reference: "Xu and Zhang 2011, eq. (4), (5); stored after C. Ericson, Real-Time Collision Detection, 2005, section 6.6, on compact nodes",
        safe: true,
    };

    type Shape = Single<Obb>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        Single::new(&ObbArea::fit(triangles))
    }
}
