//! The 14-DOP: the coordinate axes and the four space diagonals.
//!
//! J. T. Klosowski, M. Held, J. S. B. Mitchell, H. Sowizral, K. Zikan, "Efficient Collision Detection Using Bounding Volume
//! Hierarchies of k-DOPs", 1998.

use super::shape::dop::{Cone, Directions, Dop};
use super::{BoundingVolume, Info};
use crate::geometry::{Triangle, Vector};
use std::sync::OnceLock;

/// The polytope of fourteen half-spaces.
#[derive(Clone, Copy, Debug)]
pub struct Dop14;

/// 1/√3.
const D: f64 = 0.577_350_269_189_625_8;

impl BoundingVolume for Dop14 {
    const INFO: Info = Info {
        id: "dop-14",
        label: "14-DOP",
        reference: "J. T. Klosowski et al., Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs, 1998",
        safe: true,
    };

    type Shape = Dop<Dop14, 7>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        Dop::around(triangles)
    }
}

impl Directions<7> for Dop14 {
    const NORMALS: &'static [Vector; 7] = &[
        Vector::new(1.0, 0.0, 0.0),
        Vector::new(0.0, 1.0, 0.0),
        Vector::new(0.0, 0.0, 1.0),
        Vector::new(D, D, D),
        Vector::new(D, D, -D),
        Vector::new(D, -D, D),
        Vector::new(-D, D, D),
    ];

    fn cones() -> &'static OnceLock<Vec<Cone>> {
        static CONES: OnceLock<Vec<Cone>> = OnceLock::new();
        &CONES
    }
}
