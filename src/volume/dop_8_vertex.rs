//! The 8-DOP with stored corners: at a pose, the corners are moved, and their extent along the other's axes is exact.
//!
//! J. T. Klosowski, M. Held, J. S. B. Mitchell, H. Sowizral, K. Zikan, "Efficient Collision Detection Using Bounding Volume Hierarchies of
//! k-DOPs", 1998, section 4 (the "approximation method": approximate because the k-DOP of the moved polytope is larger than that of the
//! moved contents). Deviation: the extents of both polytopes are taken along each other's axes, not only along common ones. The variant
//! shows how much tightness the bound by duality ([`super::shape::dop`]) loses, and the cost of an exact extent.

use super::dop_8::Dop8;
use super::shape::dop::{Directions, Dop};
use super::{BoundingVolume, Info, Segment, Shape, Solid};
use crate::geometry::{Isometry, Point, Triangle, Vector, rigid};
use nalgebra::{Matrix3, Unit};
use std::sync::OnceLock;

/// Largest number of corners of a solid with eight faces: 2·8 - 4.
const CORNERS: usize = 12;

/// The slabs of the [`Dop8`] polytope.
type Slabs = Dop<Dop8, 4>;

/// The slabs, and the corners of the polytope that they enclose, mm, mesh frame.
#[derive(Clone, Debug)]
pub struct Dop8Vertex {
    slabs: Slabs,
    corners: [Point; CORNERS],
    count: u8,
    /// Margin on the stored corners, mm: no corner of the polytope is farther from all of `corners`.
    slack: f64,
}

/// A direction of the other mesh in this mesh's frame, and the coordinate of this mesh's origin along it, mm.
type Axis = (Vector, f64);

/// The directions of each mesh, seen from the other mesh.
#[derive(Clone, Debug)]
pub struct VertexPose {
    /// The first mesh's directions in the second mesh's frame.
    along_a: [Axis; 4],
    /// The second mesh's directions in the first mesh's frame.
    along_b: [Axis; 4],
}

/// For each three of the four directions, the matrix that maps the offsets of three planes to the point where they meet.
fn meeting_points() -> &'static [([usize; 3], Matrix3<f64>)] {
    static MATRICES: OnceLock<Vec<([usize; 3], Matrix3<f64>)>> = OnceLock::new();
    MATRICES.get_or_init(|| {
        let n = Dop8::NORMALS;
        let matrix = |three: [usize; 3]| {
            let rows = Matrix3::from_rows(&three.map(|k| n[k].transpose()));
            rows.try_inverse().map(|inverse| (three, inverse))
        };
        [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]].into_iter().filter_map(matrix).collect()
    })
}

/// Every point where three planes meet that is outside no slab by more than `tolerance`.
fn meeting(slabs: &Slabs, tolerance: f64) -> Vec<Point> {
    let mut found = Vec::new();
    for (three, inverse) in meeting_points() {
        for signs in 0..8_u8 {
            let offset = |i: usize| {
                let k = three[i];
                if signs >> i & 1 == 0 { slabs.high[k] } else { -slabs.negated_low[k] }
            };
            let point = Point::from(inverse * Vector::new(offset(0), offset(1), offset(2)));
            if slabs.contains(&point, tolerance) {
                found.push(point);
            }
        }
    }
    found
}

impl Dop8Vertex {
    /// The corners' interval along an axis: (-low, high), mm.
    fn interval(&self, (direction, shift): &Axis) -> (f64, f64) {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in &self.corners[..usize::from(self.count)] {
            let x = direction.dot(&corner.coords);
            (low, high) = (low.min(x), high.max(x));
        }
        (self.slack - shift - low, high + shift + self.slack)
    }

    /// The distance between the intervals of the two along direction `k` of this one, mm; negative when they overlap.
    fn apart(&self, k: usize, (negated_low, high): (f64, f64)) -> f64 {
        (-self.slabs.negated_low[k] - high).max(-negated_low - self.slabs.high[k])
    }
}

impl BoundingVolume for Dop8Vertex {
    const INFO: Info = Info {
        id: "dop-8-vertex",
        label: "8-DOP by its corners",
        reference: "J. T. Klosowski et al., Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs, 1998, section 4",
        safe: true,
    };

    type Shape = Self;

    fn fit(triangles: &[Triangle]) -> Self {
        /// Relative error of a meeting point of three planes, as a fraction of the largest offset. The entries of their inverse are below
        /// 1, so the error is a few 2⁻⁵³; 1e-13 is hundreds of times that.
        const ROUNDING: f64 = 1e-13;
        let slabs = Dop8::fit(triangles);
        let reach = slabs.high.iter().chain(&slabs.negated_low).fold(0.0, |reach: f64, x| reach.max(x.abs()));
        let tolerance = ROUNDING * reach;
        let found = meeting(&slabs, tolerance);
        let mut merge = tolerance;
        loop {
            let mut corners: Vec<Point> = Vec::with_capacity(CORNERS);
            for point in &found {
                if corners.iter().all(|corner| (corner - point).norm() > merge) {
                    corners.push(*point);
                }
            }
            // More than twelve only where rounding has divided one corner into several.
            if corners.len() <= CORNERS {
                let count = corners.len() as u8;
                corners.resize(CORNERS, Point::origin());
                let corners = std::array::from_fn(|i| corners[i]);
                return Self { slabs, corners, count, slack: merge + tolerance };
            }
            merge *= 2.0;
        }
    }
}

impl Shape for Dop8Vertex {
    type Pose = VertexPose;

    fn pose(a_from_b: &Isometry) -> VertexPose {
        let rotation = rigid::rotation(a_from_b);
        let translation = a_from_b.translation.vector;
        let normals = Dop8::NORMALS;
        VertexPose {
            along_a: normals.map(|d| (rotation.tr_mul(&d), d.dot(&translation))),
            along_b: normals.map(|d| (rotation * d, -(rotation * d).dot(&translation))),
        }
    }

    #[inline]
    fn overlaps(&self, other: &Self, pose: &VertexPose) -> bool {
        (0..4).all(|k| self.apart(k, other.interval(&pose.along_a[k])) <= 0.0)
            && (0..4).all(|k| other.apart(k, self.interval(&pose.along_b[k])) <= 0.0)
    }

    /// The widest gap along a face normal of either polytope, mm.
    fn gap_mm(&self, other: &Self, pose: &VertexPose) -> f64 {
        (0..4).fold(0.0, |widest: f64, k| {
            let along_a = self.apart(k, other.interval(&pose.along_a[k]));
            let along_b = other.apart(k, self.interval(&pose.along_b[k]));
            widest.max(along_a).max(along_b)
        })
    }

    fn size(&self) -> f64 {
        self.slabs.size()
    }

    fn split_axes(&self, triangles: &[Triangle]) -> [Unit<Vector>; 3] {
        self.slabs.split_axes(triangles)
    }
}

impl Solid for Dop8Vertex {
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        self.slabs.contains(point, slack_mm)
    }

    fn centre(&self) -> Point {
        self.slabs.centre()
    }

    fn volume(&self) -> f64 {
        self.slabs.volume()
    }

    fn surface_area(&self) -> f64 {
        self.slabs.surface_area()
    }

    fn outline(&self) -> Vec<Segment> {
        self.slabs.outline()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::dop_8::Dop8;
    use obbtree::cases::Draw;
    use obbtree::cases::meshes;

    #[test]
    fn its_figures_are_those_of_its_slabs() {
        let triangles = meshes::cuboid(2.0, 3.0, 4.0).triangles();
        let (fitted, slabs) = (Dop8Vertex::fit(&triangles), Dop8::fit(&triangles));
        assert_eq!(fitted.surface_area().to_bits(), slabs.surface_area().to_bits());
        assert_eq!(fitted.volume().to_bits(), slabs.volume().to_bits());
    }

    #[test]
    fn its_interval_is_that_of_its_corners() {
        let fitted = Dop8Vertex::fit(&meshes::cuboid(2.0, 3.0, 4.0).triangles());
        let corners = || fitted.corners[..usize::from(fitted.count)].iter().map(|corner| corner.x);
        let (low, high) = (corners().fold(f64::INFINITY, f64::min), corners().fold(f64::NEG_INFINITY, f64::max));
        let interval = fitted.interval(&(Vector::x(), 30.0));
        assert!((interval.0 + 30.0 + low).abs() < 1e-6 && (interval.1 - 30.0 - high).abs() < 1e-6, "{interval:?}");
    }

    #[test]
    fn an_octahedron_has_six_corners() {
        let p = |x: f64| Point::new(x, 0.0, 0.0);
        let fitted = Dop8Vertex::fit(&[Triangle::new(p(-1.0), p(1.0), p(0.0))]);
        assert_eq!(fitted.count, 6);
        for corner in &fitted.corners[..6] {
            assert!((corner.coords.amax() - 1.0).abs() < 1e-6 && (corner.coords.norm() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn it_parts_no_later_than_the_bound_by_duality_and_somewhere_earlier() {
        let mut draw = Draw::new(0, &["dop", "vertex"], 0);
        // A rod along x has a regular octahedron for polytope, where duality is exact; along (1, 2, 3) it has not.
        let along = nalgebra::UnitQuaternion::rotation_between(&Vector::x(), &Vector::new(1.0, 2.0, 3.0));
        let turn = Isometry::from_parts(Vector::zeros().into(), along.unwrap());
        let rod = meshes::moved(&meshes::cuboid(100.0, 4.0, 4.0), 1.0, &turn).triangles();
        let (exact, dual) = (Dop8Vertex::fit(&rod), Dop8::fit(&rod));
        let mut earlier = 0;
        for _ in 0..2000 {
            let pose = Isometry::from_parts((draw.in_ball() * 60.0).into(), draw.rotation());
            let by_corners = exact.overlaps(&exact, &Dop8Vertex::pose(&pose));
            let by_duality = dual.overlaps(&dual, &Slabs::pose(&pose));
            assert!(by_duality || !by_corners);
            earlier += u32::from(by_duality && !by_corners);
        }
        assert!(earlier > 0);
    }
}
