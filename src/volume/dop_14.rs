//! The 14-DOP: the coordinate axes and the four space diagonals.
//!
//! J. T. Klosowski, M. Held, J. S. B. Mitchell, H. Sowizral, K. Zikan, "Efficient Collision Detection Using Bounding Volume
//! Hierarchies of k-DOPs", 1998.

use super::Info;
use super::dop::{Cone, Directions, Dop};
use crate::geometry::Vector;
use std::sync::OnceLock;

/// The coordinate axes and the four space diagonals.
#[derive(Clone, Copy, Debug)]
pub struct FacesAndCorners;

/// The polytope of fourteen half-spaces.
pub type Dop14 = Dop<FacesAndCorners, 7>;

/// 1/√3.
const D: f64 = 0.577_350_269_189_625_8;

static NORMALS: [Vector; 7] = [
    Vector::new(1.0, 0.0, 0.0),
    Vector::new(0.0, 1.0, 0.0),
    Vector::new(0.0, 0.0, 1.0),
    Vector::new(D, D, D),
    Vector::new(D, D, -D),
    Vector::new(D, -D, D),
    Vector::new(-D, D, D),
];

impl Directions<7> for FacesAndCorners {
    const INFO: Info = Info {
        id: "dop-14",
        label: "14-DOP",
        reference: "J. T. Klosowski et al., Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs, 1998",
        safe: true,
    };

    fn normals() -> &'static [Vector; 7] {
        &NORMALS
    }

    fn cones() -> &'static OnceLock<Vec<Cone>> {
        static CONES: OnceLock<Vec<Cone>> = OnceLock::new();
        &CONES
    }
}
