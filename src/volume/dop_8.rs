//! The 8-DOP: the four space diagonals.
//!
//! C. Ericson, "Real-Time Collision Detection", 2005, section 4.6.1. The paper names an 8-DOP without saying which; its
//! figure may show a plane octagon (see the decision record on the 8-DOP's axes).

use super::shape::dop::{Cone, Directions, Dop};
use super::{BoundingVolume, Info};
use crate::geometry::{Triangle, Vector};
use std::sync::OnceLock;

/// The polytope of eight half-spaces.
#[derive(Clone, Copy, Debug)]
pub struct Dop8;

/// 1/√3.
const D: f64 = 0.577_350_269_189_625_8;

impl BoundingVolume for Dop8 {
    const INFO: Info = Info {
        id: "dop-8",
        label: "8-DOP",
        reference: "C. Ericson, Real-Time Collision Detection, 2005, section 4.6; Klosowski et al. 1998",
        safe: true,
    };

    type Shape = Dop<Dop8, 4>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        Dop::around(triangles)
    }
}

impl Directions<4> for Dop8 {
    const NORMALS: &'static [Vector; 4] =
        &[Vector::new(D, D, D), Vector::new(D, D, -D), Vector::new(D, -D, D), Vector::new(-D, D, D)];

    fn cones() -> &'static OnceLock<Vec<Cone>> {
        static CONES: OnceLock<Vec<Cone>> = OnceLock::new();
        &CONES
    }
}
