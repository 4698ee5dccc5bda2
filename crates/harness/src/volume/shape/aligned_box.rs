//! Axis-aligned boxes in the axes of their mesh; the variants differ in the overlap test at a relative pose.
//!
//! G. van den Bergen, "Efficient Collision Detection of Complex Deformable Models using AABB Trees", 1997. All boxes of a mesh share its
//! axes, so the rotation between two boxes, and its absolute values, are constants of the pose.

use super::obb::Obb;
use crate::geometry::separating_axes::{box_contains, gap_mm, pad_mm, widened_abs};
use crate::geometry::{Isometry, Point, Triangle, Vector, rigid, triangle};
use crate::volume::{Segment, Shape, Solid, box_area, box_outline, coordinate_axes_by_extent};
use nalgebra::{Matrix3, Unit};
use std::fmt::Debug;
use std::marker::PhantomData;

/// The overlap test of two axis-aligned boxes at a relative pose.
pub trait BoxTest: Clone + Debug + Send + Sync + 'static {
    /// Whether the test finds two boxes disjoint. `a` and `b` are half-lengths, mm, and `t` is the second centre in the frame of the first
    /// box, mm.
    fn separated(t: &Vector, pose: &AlignedPose, a: &Vector, b: &Vector) -> bool;
}

/// Centre and half-lengths, mm, mesh axes.
#[derive(Clone, Debug)]
pub struct AlignedBox<T> {
    pub(in crate::volume) centre: Point,
    pub(in crate::volume) half: Vector,
    test: PhantomData<T>,
}

/// Rotation, its widened absolute values, and translation, mm, from the second mesh to the first.
#[derive(Clone, Debug)]
pub struct AlignedPose {
    /// Maps axes of the second mesh to axes of the first.
    pub rotation: Matrix3<f64>,
    /// The absolute values of the rotation, widened by [`widened_abs`].
    pub widened: Matrix3<f64>,
    translation: Vector,
}

impl AlignedPose {
    #[inline]
    pub(crate) fn new(a_from_b: &Isometry) -> Self {
        let rotation = rigid::rotation(a_from_b);
        Self { rotation, widened: widened_abs(&rotation), translation: a_from_b.translation.vector }
    }

    #[inline(always)]
    pub(crate) fn point(&self, p: &Point) -> Point {
        Point::from(self.rotation * p.coords + self.translation)
    }
}

impl<T> AlignedBox<T> {
    /// The box with this centre and these half-lengths, mm.
    pub const fn new(centre: Point, half: Vector) -> Self {
        Self { centre, half, test: PhantomData }
    }

    /// The bounding box of `triangles`, with a margin for rounding errors.
    pub fn around(triangles: &[Triangle]) -> Self {
        let (low, high) = triangle::bounds(triangles).unwrap_or((Point::origin(), Point::origin()));
        let pad = pad_mm(low.coords.amax().max(high.coords.amax()));
        Self::new(nalgebra::center(&low, &high), (high - low) * 0.5 + Vector::repeat(pad))
    }
}

impl<T: BoxTest> Shape for AlignedBox<T> {
    type Pose = AlignedPose;

    #[inline]
    fn pose(a_from_b: &Isometry) -> AlignedPose {
        AlignedPose::new(a_from_b)
    }

    #[inline(always)]
    fn overlaps(&self, other: &Self, pose: &AlignedPose) -> bool {
        let t = pose.rotation * other.centre.coords + pose.translation - self.centre.coords;
        !T::separated(&t, pose, &self.half, &other.half)
    }

    #[inline]
    fn gap_mm(&self, other: &Self, pose: &AlignedPose) -> f64 {
        let t = pose.rotation * other.centre.coords + pose.translation - self.centre.coords;
        gap_mm(&t, &pose.rotation, &pose.widened, &self.half, &other.half)
    }

    #[inline]
    fn size(&self) -> f64 {
        self.half.norm_squared()
    }

    fn split_axes(&self, _: &[Triangle]) -> [Unit<Vector>; 3] {
        coordinate_axes_by_extent(&self.half)
    }
}

impl<T: BoxTest> Solid for AlignedBox<T> {
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        box_contains(&(point - self.centre), &self.half, slack_mm)
    }

    fn centre(&self) -> Point {
        self.centre
    }

    fn volume(&self) -> f64 {
        8.0 * self.half.product()
    }

    fn surface_area(&self) -> f64 {
        box_area(&self.half)
    }

    fn outline(&self) -> Vec<Segment> {
        box_outline(&self.centre, &Matrix3::identity(), &self.half)
    }

    fn as_box(&self) -> Option<Obb> {
        Some(Obb { axes: Matrix3::identity(), centre: self.centre, half: self.half })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::BoundingVolume;
    use crate::volume::aabb::Aabb;
    use crate::volume::aabb_refit::AabbRefit;
    use crate::volume::aabb_sat6::AabbSat6;

    #[test]
    fn a_triangle_gets_its_bounds() {
        let t = Triangle::new(Point::new(1.0, 2.0, 3.0), Point::new(5.0, 2.0, 3.0), Point::new(1.0, 8.0, 3.0));
        let fitted = Aabb::fit(&[t]);
        assert_eq!(fitted.centre, Point::new(3.0, 5.0, 3.0));
        assert!((fitted.volume() - 0.0).abs() < 1e-5 && (fitted.surface_area() - 2.0 * 4.0 * 6.0).abs() < 1e-5);
        assert!(fitted.contains(&Point::new(5.0, 8.0, 3.0), 0.0) && !fitted.contains(&Point::new(5.1, 8.0, 3.0), 0.05));
    }

    /// Boxes of edge 2 about the origin of their meshes.
    fn overlap<T: BoxTest>(pose: &Isometry) -> bool {
        let corner = |x: f64| Point::new(x, x, x);
        let cube = AlignedBox::<T>::around(&[Triangle::new(corner(-1.0), corner(1.0), corner(0.0))]);
        cube.overlaps(&cube, &AlignedBox::<T>::pose(pose))
    }

    #[test]
    fn a_box_has_its_size_and_its_gap() {
        let cuboid = AlignedBox::<Aabb>::new(Point::new(1.0, 2.0, 3.0), Vector::new(1.0, 2.0, 2.0));
        assert_eq!((cuboid.size(), cuboid.volume(), cuboid.centre()), (9.0, 32.0, Point::new(1.0, 2.0, 3.0)));
        let pose = |y: f64| AlignedBox::<Aabb>::pose(&Isometry::translation(0.0, y, 0.0));
        assert!((cuboid.gap_mm(&cuboid, &pose(9.0)) - 5.0).abs() < 1e-6);
        assert_eq!(cuboid.gap_mm(&cuboid, &pose(3.0)), 0.0);
    }

    #[test]
    fn each_rule_sees_what_its_axes_show() {
        let quarter = std::f64::consts::FRAC_PI_4;
        // On its edge about z at x: its width along x is 2√2, which all see.
        let on_edge = |x: f64| Isometry::new(Vector::new(x, 0.0, 0.0), Vector::z() * quarter);
        let reach = 1.0 + 2.0_f64.sqrt();
        for overlap in [overlap::<Aabb>, overlap::<AabbSat6>, overlap::<AabbRefit>] {
            assert!(overlap(&on_edge(reach - 1e-6)) && !overlap(&on_edge(reach + 1e-6)));
        }
        // Along the diagonal the first box's corner meets the second box's face: at distance √2 + 1, but the re-fitted box
        // reaches 1 + √2 along x and along y, so that it parts at √2 (1 + √2).
        let diagonal = |d: f64| Isometry::new(Vector::new(1.0, 1.0, 0.0).normalize() * d, Vector::z() * quarter);
        assert!(!overlap::<Aabb>(&diagonal(reach + 1e-6)) && !overlap::<AabbSat6>(&diagonal(reach + 1e-6)));
        assert!(overlap::<AabbRefit>(&diagonal(2.0_f64.sqrt() * reach - 1e-6)));
        assert!(!overlap::<AabbRefit>(&diagonal(2.0_f64.sqrt() * reach + 1e-6)));
        // Two edges crossed along z part at 2√2; no face shows that.
        let x = nalgebra::UnitQuaternion::from_axis_angle(&Vector::x_axis(), quarter);
        let y = nalgebra::UnitQuaternion::from_axis_angle(&Vector::y_axis(), quarter);
        let crossed = |z: f64| Isometry::from_parts((x.inverse() * Vector::new(0.0, 0.0, z)).into(), x.inverse() * y);
        let touch = 2.0 * 2.0_f64.sqrt();
        assert!(!overlap::<Aabb>(&crossed(touch + 1e-6)) && overlap::<Aabb>(&crossed(touch - 1e-6)));
        assert!(overlap::<AabbSat6>(&crossed(touch + 1e-6)));
        assert_eq!((AabbSat6::INFO.safe, AabbRefit::INFO.safe), (true, true));
    }
}
