//! The 26-DOP: the coordinate axes, the six diagonals of their planes and the four space diagonals.
//!
//! J. T. Klosowski, M. Held, J. S. B. Mitchell, H. Sowizral, K. Zikan, "Efficient Collision Detection Using Bounding Volume
//! Hierarchies of k-DOPs", 1998.

use super::shape::dop::{Cone, Directions, Dop};
use super::{BoundingVolume, Info};
use crate::geometry::{Triangle, Vector};
use std::sync::OnceLock;

/// The polytope of twenty-six half-spaces.
#[derive(Clone, Copy, Debug)]
pub struct Dop26;

/// 1/√3.
const D: f64 = 0.577_350_269_189_625_8;

/// 1/√2.
const E: f64 = std::f64::consts::FRAC_1_SQRT_2;

impl BoundingVolume for Dop26 {
    const INFO: Info = Info {
        id: "dop-26",
        label: "26-DOP",
        reference: "J. T. Klosowski et al., Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs, 1998",
        safe: true,
    };

    type Shape = Dop<Dop26, 13>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        Dop::around(triangles)
    }
}

impl Directions<13> for Dop26 {
    const NORMALS: &'static [Vector; 13] = &[
        Vector::new(1.0, 0.0, 0.0),
        Vector::new(0.0, 1.0, 0.0),
        Vector::new(0.0, 0.0, 1.0),
        Vector::new(E, E, 0.0),
        Vector::new(E, -E, 0.0),
        Vector::new(E, 0.0, E),
        Vector::new(E, 0.0, -E),
        Vector::new(0.0, E, E),
        Vector::new(0.0, E, -E),
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
