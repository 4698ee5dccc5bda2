//! The plain box, stored in single precision (see [`super::shape::single`]).

use super::obb_vertex::ObbVertex;
use super::shape::obb::Obb;
use super::shape::single::Single;
use super::{BoundingVolume, Info};
use crate::geometry::Triangle;

/// The variant `obb-vertex-f32`.
#[derive(Clone, Copy, Debug)]
pub struct ObbVertexF32;

impl BoundingVolume for ObbVertexF32 {
    const INFO: Info = Info {
        id: "obb-vertex-f32",
        label: "plain OBB, f32",
        reference: "Xu and Zhang 2011, eq. (1); stored after C. Ericson, Real-Time Collision Detection, 2005, section 6.6, on compact nodes",
        safe: true,
    };

    type Shape = Single<Obb>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        Single::new(&ObbVertex::fit(triangles))
    }
}
