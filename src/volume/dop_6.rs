//! The 6-DOP: the coordinate axes.
//!
//! J. T. Klosowski, M. Held, J. S. B. Mitchell, H. Sowizral, K. Zikan, "Efficient Collision Detection Using Bounding Volume Hierarchies of
//! k-DOPs", 1998: the axis-aligned box as a k-DOP, tested by the test of k-DOPs instead of separating axes.

use super::shape::dop::{Cone, Directions, Dop};
use super::{BoundingVolume, Info};
use crate::geometry::{Triangle, Vector};
use std::sync::OnceLock;

/// The polytope of six half-spaces.
#[derive(Clone, Copy, Debug)]
pub struct Dop6;

impl BoundingVolume for Dop6 {
    const INFO: Info = Info {
        id: "dop-6",
        label: "6-DOP",
        reference: "J. T. Klosowski et al., Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs, 1998",
        safe: true,
    };

    type Shape = Dop<Dop6, 3>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        Dop::around(triangles)
    }
}

impl Directions<3> for Dop6 {
    const NORMALS: &'static [Vector; 3] =
        &[Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)];

    fn cones() -> &'static OnceLock<Vec<Cone>> {
        static CONES: OnceLock<Vec<Cone>> = OnceLock::new();
        &CONES
    }
}
