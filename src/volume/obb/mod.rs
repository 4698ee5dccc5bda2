//! The oriented box: one fit, one overlap test, and rules for the axes and the centre.
//!
//! A variant is a [`BoxRule`] in a file of its own that names a [`FrameRule`] (which way the box is turned) and a
//! [`CentreRule`] (where it sits). Xu and Zhang 2011 compare boxes turned by the covariance of the corners with boxes turned
//! by the covariance of the surface; S. Gottschalk, "Collision Queries using Oriented Bounding Boxes", 2000, is the
//! origin of both.

pub mod area;
pub mod area_centroid;
pub mod area_symmetric;
pub mod centre;
pub mod frame;
pub mod vertex;
pub mod vertex_centroid;
pub mod vertex_symmetric;

pub use centre::CentreRule;
pub use frame::FrameRule;

use super::separating_axis::{self, Orientation, separated, squared_distance};
use super::{BoundingVolume, Info, Segment, rounding_pad};
use crate::geometry::{Isometry, Point, Triangle, Vector, triangle};
use nalgebra::{Matrix3, Unit};
use std::fmt::Debug;
use std::marker::PhantomData;

/// What makes one oriented box different from another.
pub trait BoxRule: Clone + Debug + Send + Sync + 'static {
    /// Name, reference and promise of the variant.
    const INFO: Info;
    /// Which way the box is turned.
    type Frame: FrameRule;
    /// Where the box sits and how long it is.
    type Centre: CentreRule;
}

/// A box with its own axes, mm, mesh frame.
#[derive(Clone, Debug)]
pub struct Obb<R> {
    /// The axes as columns: a rotation.
    axes: Matrix3<f64>,
    centre: Point,
    /// Half-lengths along the axes, rounded outward.
    half: Vector,
    rule: PhantomData<R>,
}

/// The relative pose of two meshes, as the box test uses it.
#[derive(Clone, Debug)]
pub struct ObbPose {
    rotation: Matrix3<f64>,
    translation: Vector,
}

impl<R: BoxRule> BoundingVolume for Obb<R> {
    const INFO: Info = R::INFO;

    type Pose = ObbPose;

    fn fit(triangles: &[Triangle]) -> Self {
        let (mean, axes) = R::Frame::frame(triangles);
        let first = axes.tr_mul(&(triangles[0].corners[0] - mean));
        let (low, high) = triangle::corners(triangles).fold((first, first), |(low, high), corner| {
            let along = axes.tr_mul(&(corner - mean));
            (low.inf(&along), high.sup(&along))
        });
        let (offset, half) = R::Centre::place(&low, &high);
        let centre = mean + axes * offset;
        let pad = rounding_pad(centre.coords.amax() + half.sum());
        Self { axes, centre, half: half.add_scalar(pad), rule: PhantomData }
    }

    fn pose(a_from_b: &Isometry) -> ObbPose {
        ObbPose {
            rotation: a_from_b.rotation.to_rotation_matrix().into_inner(),
            translation: a_from_b.translation.vector,
        }
    }

    #[inline]
    fn overlaps(&self, other: &Self, pose: &ObbPose) -> bool {
        let between = pose.rotation * other.centre.coords + (pose.translation - self.centre.coords);
        let orientation = Orientation::new(self.axes.tr_mul(&(pose.rotation * other.axes)));
        !separated(&self.half, &other.half, &self.axes.tr_mul(&between), &orientation)
    }

    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        squared_distance(&self.axes.tr_mul(&(point - self.centre)), &self.half) <= slack_mm * slack_mm
    }

    fn centre(&self) -> Point {
        self.centre
    }

    fn volume(&self) -> f64 {
        8.0 * self.half.product()
    }

    fn surface_area(&self) -> f64 {
        let h = &self.half;
        8.0 * (h.x * h.y + h.y * h.z + h.z * h.x)
    }

    /// The axes of the box; equal half-lengths keep the order of the eigenvalues.
    fn split_axes(&self, _: &[Triangle]) -> [Unit<Vector>; 3] {
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| self.half[j].total_cmp(&self.half[i]));
        order.map(|i| Unit::new_unchecked(self.axes.column(i).into_owned()))
    }

    /// The twelve edges.
    fn outline(&self) -> Vec<Segment> {
        separating_axis::edges()
            .map(|edge| edge.map(|corner| self.centre + self.axes * corner.component_mul(&self.half)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use super::{
        area::ObbArea, area_symmetric::ObbAreaSymmetric, vertex::ObbVertex, vertex_centroid::ObbVertexCentroid,
    };

    /// A flat strip of 6 x 2 mm along x, from x = 0; the last 2 mm of it cut into ten slivers, so that the corners crowd
    /// there.
    fn strip() -> Vec<Triangle> {
        let mut stations = vec![0.0, 4.0];
        stations.extend((1..=10).map(|i| 4.0 + 0.2 * f64::from(i)));
        let quad = |x: f64, y: f64| {
            let p = |x: f64, side: f64| Point::new(x, side, 0.0);
            [Triangle::new(p(x, -1.0), p(y, -1.0), p(y, 1.0)), Triangle::new(p(x, -1.0), p(y, 1.0), p(x, 1.0))]
        };
        stations.windows(2).flat_map(|x| quad(x[0], x[1])).collect()
    }

    #[test]
    fn the_tight_box_of_a_strip_is_the_strip() {
        let obb = Obb::<ObbArea>::fit(&strip());
        assert!((obb.centre() - Point::new(3.0, 0.0, 0.0)).norm() < 1e-9); // 6/2
        assert!((obb.half - Vector::new(3.0, 1.0, 0.0)).amax() < 1e-7);
        assert!((obb.axes.column(0) - Vector::x()).norm() < 1e-9);
        assert!((obb.surface_area() - 24.0).abs() < 1e-5); // both sides of 6 x 2
        assert_eq!(obb.outline().len(), 12);
    }

    #[test]
    fn the_literal_box_slides_toward_the_dense_side_and_leaves_the_other_out() {
        // Corners per station: 3 at both ends, 6 at each of the ten between. Mean x = (3·0 + 6·(4 + 4.2 + ... + 5.8) + 3·6) / 66
        // = (6·49 + 18)/66 = 4.727; the box is about 3 long either way and so begins more than a millimetre inside the
        // strip: 1.486 with the tilt of 0.206 rad that the diagonals give it.
        let obb = Obb::<ObbVertexCentroid>::fit(&strip());
        assert!((obb.centre() - Point::new(312.0 / 66.0, 0.0, 0.0)).norm() < 1e-9);
        assert!(!obb.contains(&Point::origin(), 1.48) && obb.contains(&Point::origin(), 1.49));
        assert!(Obb::<ObbVertex>::fit(&strip()).contains(&Point::new(0.0, 1.0, 0.0), 0.0));
    }

    #[test]
    fn the_symmetric_box_reaches_as_far_on_both_sides() {
        // The area mean is the middle for equal widths; for a right triangle it is a third of the way.
        let t = Triangle::new(Point::origin(), Point::new(30.0, 0.0, 0.0), Point::new(0.0, 3.0, 0.0));
        let obb = Obb::<ObbAreaSymmetric>::fit(&[t]);
        assert!((obb.centre() - Point::new(10.0, 1.0, 0.0)).norm() < 1e-9);
        assert!(obb.half.x > 19.9 && obb.half.x < 20.1); // the farthest corner is 20 away along nearly x
        assert!(t.corners.iter().all(|corner| obb.contains(corner, 0.0)));
    }

    #[test]
    fn boxes_follow_the_pose() {
        // The strip's tight box spans x 0..6, y -1..1. A quarter turn about z puts the other one at x -1..1, y 0..6.
        let obb = Obb::<ObbArea>::fit(&strip());
        let quarter = Vector::z() * std::f64::consts::FRAC_PI_2;
        let at =
            |x: f64, y: f64| obb.overlaps(&obb, &Obb::<ObbArea>::pose(&Isometry::new(Vector::new(x, y, 0.0), quarter)));
        assert!(at(6.999, 0.0) && !at(7.001, 0.0)); // 6 + 1
        assert!(at(3.0, 0.999) && !at(3.0, 1.001));
        assert!(at(3.0, -6.999) && !at(3.0, -7.001)); // 1 + 6
    }

    #[test]
    fn degenerate_contents_get_a_box() {
        let p = Point::new(1.0, 2.0, 3.0);
        let q = Point::new(4.0, 6.0, 3.0);
        for t in [Triangle::new(p, p, p), Triangle::new(p, q, p)] {
            for obb in [Obb::<ObbArea>::fit(&[t, t])] {
                assert!(t.corners.iter().all(|corner| obb.contains(corner, 0.0)));
                assert!((obb.half.amax() - 0.5 * (t.corners[1] - p).norm()).abs() < 1e-7);
            }
        }
    }
}
