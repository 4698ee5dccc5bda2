//! The 18-DOP: the coordinate axes and the six diagonals of the coordinate planes.
//!
//! J. T. Klosowski, M. Held, J. S. B. Mitchell, H. Sowizral, K. Zikan, "Efficient Collision Detection Using Bounding Volume
//! Hierarchies of k-DOPs", 1998, who found it the best of 6, 14, 18 and 26.

use super::shape::dop::{Cone, Directions, Dop};
use super::{BoundingVolume, Info};
use crate::geometry::{Triangle, Vector};
use std::sync::OnceLock;

/// The polytope of eighteen half-spaces.
#[derive(Clone, Copy, Debug)]
pub struct Dop18;

/// 1/√2.
const E: f64 = std::f64::consts::FRAC_1_SQRT_2;

impl BoundingVolume for Dop18 {
    const INFO: Info = Info {
        id: "dop-18",
        label: "18-DOP",
        reference: "J. T. Klosowski et al., Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs, 1998",
        safe: true,
    };

    type Shape = Dop<Dop18, 9>;

    fn fit(triangles: &[Triangle]) -> Self::Shape {
        Dop::around(triangles)
    }
}

impl Directions<9> for Dop18 {
    const NORMALS: &'static [Vector; 9] = &[
        Vector::new(1.0, 0.0, 0.0),
        Vector::new(0.0, 1.0, 0.0),
        Vector::new(0.0, 0.0, 1.0),
        Vector::new(E, E, 0.0),
        Vector::new(E, -E, 0.0),
        Vector::new(E, 0.0, E),
        Vector::new(E, 0.0, -E),
        Vector::new(0.0, E, E),
        Vector::new(0.0, E, -E),
    ];

    fn cones() -> &'static OnceLock<Vec<Cone>> {
        static CONES: OnceLock<Vec<Cone>> = OnceLock::new();
        &CONES
    }
}
