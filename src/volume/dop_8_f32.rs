//! The 8-DOP, stored in single precision (see [`super::shape::single`]).

use super::dop_8::Dop8;
use super::shape::dop::Dop;
use super::shape::single::Single;
use super::{BoundingVolume, Info};
use crate::geometry::Triangle;

/// The variant `dop-8-f32`.
#[derive(Clone, Copy, Debug)]
pub struct Dop8F32;

impl BoundingVolume for Dop8F32 {
    const INFO: Info = Info {
        id: "dop-8-f32",
        label: "8-DOP, f32",
        reference: "C. Ericson 2005, section 4.6; stored after C. Ericson, Real-Time Collision Detection, 2005, section 6.6, on compact nodes",
        safe: true,
    };

    type Shape = Single<Dop<Dop8, 4>>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        Single::new(&Dop8::fit(triangles))
    }
}
