//! The axis-aligned box, stored in single precision (see [`super::shape::single`]).

use super::aabb::Aabb;
use super::shape::aligned_box::AlignedBox;
use super::shape::single::Single;
use super::{BoundingVolume, Info};
use crate::geometry::Triangle;

/// The variant `aabb-f32`.
#[derive(Clone, Copy, Debug)]
pub struct AabbF32;

impl BoundingVolume for AabbF32 {
    const INFO: Info = Info {
        id: "aabb-f32",
        label: "AABB, f32",
        reference: "G. van den Bergen 1997; stored after C. Ericson, Real-Time Collision Detection, 2005, section 6.6, on compact nodes",
        safe: true,
    };

    type Shape = Single<AlignedBox<Aabb>>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        Single::new(&Aabb::fit(triangles))
    }
}
