//! How points of the stock go as a body sees them, from one pose of the body to another: each straight and at an even pace.

use crate::geometry::{Isometry, Point, Vector};
use nalgebra::Matrix3;

/// Turns below this are rounding, radians: a point 1 m away goes 1e-6 mm.
const TURN: f64 = 1e-9;

/// Takes a point of the stock to where it is in the body's frame while a number goes from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    /// At 0, and how it changes: matrix and offset.
    start: (Matrix3<f64>, Vector),
    change: (Matrix3<f64>, Vector),
    bend: f64,
}

impl Course {
    /// From where the body's frame sees the stock at first to where it does at last.
    pub fn new(first: &Isometry, last: &Isometry) -> Self {
        let parts = |pose: &Isometry| (pose.rotation.to_rotation_matrix().into_inner(), pose.translation.vector);
        let (start, end) = (parts(first), parts(last));
        let turned = end.0 - start.0;
        let change = if turned.norm() > TURN { turned } else { Matrix3::zeros() };
        Self::of(start, (change, end.1 - start.1))
    }

    fn of(start: (Matrix3<f64>, Vector), change: (Matrix3<f64>, Vector)) -> Self {
        // Of the difference of two rotations two singular values are equal, and the third is 0.
        Self { start, change, bend: 0.5 * change.0.norm() / std::f64::consts::SQRT_2 }
    }

    /// Where a point is at first, and minus its way.
    pub fn at(&self, point: &Point) -> (Vector, Vector) {
        let start = self.start.0 * point.coords + self.start.1;
        if self.turns() { (start, -(self.change.0 * point.coords + self.change.1)) } else { (start, -self.change.1) }
    }

    /// The part from one number to another.
    pub fn part(&self, from: f64, to: f64) -> Self {
        let start = (self.start.0 + self.change.0 * from, self.start.1 + self.change.1 * from);
        Self::of(start, (self.change.0 * (to - from), self.change.1 * (to - from)))
    }

    /// The stock's axes as the body sees them at 1/2; no longer than 1.
    pub fn axes(&self) -> [Vector; 3] {
        let middle = self.start.0 + self.change.0 * 0.5;
        [0, 1, 2].map(|k| middle.column(k).into_owned())
    }

    /// How far what is beside a point by a vector of length 1 may be from where [`Self::axes`] say.
    pub const fn bend(&self) -> f64 {
        self.bend
    }

    pub fn turns(&self) -> bool {
        self.bend > 0.0
    }

    /// Where the stock's origin is at first, and its way.
    pub const fn of_origin(&self) -> (Vector, Vector) {
        (self.start.1, self.change.1)
    }

    /// Whether both begin in one orientation.
    pub fn is_turned_as(&self, other: &Self) -> bool {
        (self.start.0 - other.start.0).norm() < TURN
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn points_are_where_the_poses_say_and_what_is_beside_them_where_the_axes_say(
            turn in prop::array::uniform3(-0.1..0.1f64),
            start in prop::array::uniform3(-3.0..3.0f64),
            way in prop::array::uniform3(-9.0..9.0f64),
            point in prop::array::uniform3(-50.0..50.0f64),
            beside in prop::array::uniform3(-1.0..1.0f64),
            at in 0.0..1.0f64,
        ) {
            let first = Isometry::new(Vector::from(way) * 2.0, Vector::from(start));
            let rotation = UnitQuaternion::from_scaled_axis(Vector::from(turn)) * first.rotation;
            let last = Isometry::from_parts((first.translation.vector + Vector::from(way)).into(), rotation);
            let (course, point, beside) = (Course::new(&first, &last), Point::from(point), Vector::from(beside));
            let place = |course: &Course, point: &Point, at: f64| {
                let (q, travel) = course.at(point);
                q - travel * at
            };
            prop_assert!((place(&course, &point, 0.0) - (first * point).coords).norm() < 1e-9);
            prop_assert!((place(&course, &point, 1.0) - (last * point).coords).norm() < 1e-9);
            let part = course.part(0.25, 0.75);
            prop_assert!((place(&part, &point, at) - place(&course, &point, 0.25 + 0.5 * at)).norm() < 1e-9);
            for course in [course, part] {
                let [x, y, z] = course.axes();
                let said = place(&course, &point, at) + x * beside.x + y * beside.y + z * beside.z;
                let off = (place(&course, &(point + beside), at) - said).norm();
                prop_assert!(off <= course.bend() * beside.norm() + 1e-12, "{off} {}", course.bend());
                prop_assert!(course.axes().iter().all(|axis| axis.norm() <= 1.0 + 1e-12));
            }
        }
    }
}
