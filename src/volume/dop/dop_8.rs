//! The 8-DOP on the diagonals of the cube.
//!
//! C. Ericson, "Real-Time Collision Detection", Morgan Kaufmann 2005, section 4.6. Deviation: posed by cone duality
//! ([`super`]) instead of refitted.

use super::cones::Cones;
use super::{Directions, Dop, Info};
use std::sync::LazyLock;

/// The four diagonals (1,1,1), (1,1,-1), (1,-1,1), (-1,1,1).
#[derive(Clone, Debug)]
pub enum Diagonals {}

/// Four slabs along the diagonals of the cube: an octahedron where all are equally wide.
pub type Dop8 = Dop<Diagonals, 4>;

static CONES: LazyLock<Cones<4>> =
    LazyLock::new(|| Cones::new([[1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0]]));

impl Directions<4> for Diagonals {
    const INFO: Info = Info {
        id: "dop-8",
        label: "8-DOP",
        reference: "C. Ericson, Real-Time Collision Detection, 2005, section 4.6",
        safe: true,
    };

    fn cones() -> &'static Cones<4> {
        &CONES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Isometry, Point, Triangle, Vector};
    use crate::volume::BoundingVolume;

    /// Triangles over the given points, all of them corners.
    fn around(points: &[[f64; 3]]) -> Vec<Triangle> {
        points.iter().map(|&p| Triangle::new(p.into(), p.into(), p.into())).collect()
    }

    /// The octahedron |x| + |y| + |z| ≤ r about `centre`, by its six corners.
    fn octahedron(r: f64, centre: [f64; 3]) -> Dop8 {
        let mut points = Vec::new();
        for axis in 0..3 {
            for side in [-r, r] {
                let mut p = centre;
                p[axis] += side;
                points.push(p);
            }
        }
        Dop8::fit(&around(&points))
    }

    #[test]
    fn an_octahedron_is_its_own_dop() {
        let dop = octahedron(3.0, [10.0, 20.0, -5.0]);
        assert!((dop.volume() - 36.0).abs() < 1e-6); // 4/3 r³
        assert!((dop.surface_area() - 9.0 * 4.0 * 3.0_f64.sqrt()).abs() < 1e-6); // 4√3 r²
        assert!((dop.centre() - Point::new(10.0, 20.0, -5.0)).norm() < 1e-9);
        // Eight triangles; where four facets meet, the rounding pad leaves edges of its own size.
        assert_eq!(dop.outline().iter().filter(|[p, q]| (q - p).norm() > 1e-3).count(), 24);
        assert!(dop.contains(&Point::new(13.0, 20.0, -5.0), 0.0));
        assert!(!dop.contains(&Point::new(12.0, 21.1, -5.0), 0.0)); // 2 + 1.1 > 3
    }

    #[test]
    fn a_cube_gets_an_octahedron_three_times_as_far() {
        // Corners (±1,±1,±1): |x|+|y|+|z| ≤ 3, volume 4/3·27.
        let corners: Vec<_> =
            (0..8).map(|i: u8| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 })).collect();
        assert!((Dop8::fit(&around(&corners)).volume() - 36.0).abs() < 1e-6);
    }

    #[test]
    fn a_diagonal_segment_gets_the_parallelepiped_of_three_slabs() {
        // A segment from -(1,1,1) to (1,1,1): |x + y + z| ≤ 3, and each of the other three ≤ 1. The vectors of those three
        // have the determinant 4, so they enclose 2³/4 = 2 mm³, and x + y + z is their sum, at most 3: it cuts nothing.
        let dop = Dop8::fit(&around(&[[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]));
        assert!((dop.volume() - 2.0).abs() < 1e-6);
    }

    #[test]
    fn octahedra_touch_along_a_diagonal_and_at_their_corners() {
        let (dop, turn) = (octahedron(1.0, [0.0; 3]), Vector::zeros());
        let at = |t: Vector| dop.overlaps(&dop, &Dop8::pose(&Isometry::new(t, turn)));
        let diagonal = Vector::repeat(1.0 / 3.0); // |x|+|y|+|z| = 1, so facets touch at twice that
        assert!(at(diagonal * 1.999) && !at(diagonal * 2.001));
        assert!(at(Vector::x() * 1.999) && !at(Vector::x() * 2.001));
    }

    #[test]
    fn a_quarter_turn_of_an_octahedron_is_the_octahedron() {
        // The directions map onto themselves, so the bound is exact: contact at 2.
        let dop = octahedron(1.0, [0.0; 3]);
        let at = |x: f64| {
            let turn = Vector::z() * std::f64::consts::FRAC_PI_2;
            dop.overlaps(&dop, &Dop8::pose(&Isometry::new(Vector::new(x, 0.0, 0.0), turn)))
        };
        assert!(at(1.999) && !at(2.001));
    }
}
