//! Ritter's sphere, stored in single precision (see [`super::shape::single`]).

use super::shape::single::Single;
use super::shape::sphere::Sphere;
use super::sphere_ritter::SphereRitter;
use super::{BoundingVolume, Info};
use crate::geometry::Triangle;

/// The variant `sphere-ritter-f32`.
#[derive(Clone, Copy, Debug)]
pub struct SphereRitterF32;

impl BoundingVolume for SphereRitterF32 {
    const INFO: Info = Info {
        id: "sphere-ritter-f32",
        label: "sphere, f32",
        reference: "J. Ritter 1990; stored after C. Ericson, Real-Time Collision Detection, 2005, section 6.6, on compact nodes",
        safe: true,
    };

    type Shape = Single<Sphere>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        Single::new(&SphereRitter::fit(triangles))
    }
}
