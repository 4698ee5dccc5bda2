//! Finds the axis at which the separating-axis test of two boxes ends. It repeats the test of [`crate::geometry::separating_axes::separated`]
//! axis by axis, for counting and never for timing.

use super::{Obb, ObbPose};
use crate::geometry::separating_axes::widened_abs;

/// Number of axes: three normals of the first box, three of the second, and nine cross products of edges.
pub const AXES: usize = 15;

/// Number of arithmetic operations of one test that ends at the axis `exit` (`None`: no axis separates the boxes). As usual in the
/// literature, a sum, a product, an absolute value and a comparison count one each. Bringing both boxes into one frame beforehand is not
/// counted; it takes 126 more (two products of 3 x 3 matrices, 45 each, and 36 for the centre).
pub const fn operations(exit: Option<usize>) -> u64 {
    /// Operations for |R| + ε: 9 absolute values and 9 sums.
    const WIDENED: u64 = 18;
    /// Operations of an axis of the first box: the absolute value of t's component, three products, three sums and one comparison.
    const OWN: u64 = 8;
    /// Operations of an axis of the second box: those of the first, and three products and two sums that project t onto the axis.
    const OTHERS: u64 = 13;
    /// Operations of a cross product of edges: two products, a difference and an absolute value for t; four products, three sums and one
    /// comparison for the boxes.
    const EDGES: u64 = 12;
    let tried = match exit {
        Some(axis) => axis as u64 + 1,
        None => AXES as u64,
    };
    let (own, others) = (if tried < 3 { tried } else { 3 }, if tried < 6 { tried } else { 6 });
    WIDENED + OWN * own + OTHERS * (others - own) + EDGES * (tried - others)
}

impl Obb {
    /// The first axis, in the order of the test, that separates this box and `other` at the pose. 0 to 2 are this box's normals, 3 to 5 the
    /// other's, and 6 + 3i + j is the cross product of this box's edge i and the other's edge j. `None` when no axis separates them.
    pub fn exit_axis(&self, other: &Self, pose: &ObbPose) -> Option<usize> {
        let between = pose.rotation * other.centre.coords + pose.translation - self.centre.coords;
        let t = self.axes.tr_mul(&between);
        let r = self.axes.tr_mul(&(pose.rotation * other.axes));
        let (q, a, b) = (widened_abs(&r), &self.half, &other.half);
        let separates = |axis: usize| match axis {
            0..=2 => t[axis].abs() > a[axis] + q[(axis, 0)] * b[0] + q[(axis, 1)] * b[1] + q[(axis, 2)] * b[2],
            3..=5 => {
                let j = axis - 3;
                let distance = t[0] * r[(0, j)] + t[1] * r[(1, j)] + t[2] * r[(2, j)];
                distance.abs() > b[j] + q[(0, j)] * a[0] + q[(1, j)] * a[1] + q[(2, j)] * a[2]
            }
            _ => {
                let (i, j) = ((axis - 6) / 3, (axis - 6) % 3);
                let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
                let distance = t[i2] * r[(i1, j)] - t[i1] * r[(i2, j)];
                let reach = a[i1] * q[(i2, j)] + a[i2] * q[(i1, j)] + b[j1] * q[(i, j2)] + b[j2] * q[(i, j1)];
                distance.abs() > reach
            }
        };
        (0..AXES).find(|&axis| separates(axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Isometry;
    use crate::volume::obb_area::ObbArea;
    use crate::volume::{BoundingVolume, Shape};
    use nalgebra::{Translation3, Vector3};
    use obbtree::cases::Draw;
    use obbtree::cases::meshes;

    fn bar(x: f64, y: f64, z: f64) -> Obb {
        ObbArea::fit(&meshes::cuboid(x, y, z).triangles())
    }

    #[test]
    fn the_axes_are_named_in_the_order_of_the_test() {
        let (one, other) = (bar(6.0, 4.0, 2.0), bar(3.0, 2.0, 1.0));
        let exit = |pose: Isometry| one.exit_axis(&other, &Obb::pose(&pose));
        assert_eq!(exit(Isometry::identity()), None);
        // Along x, y and z the boxes end at 3 + 1.5, 2 + 1 and 1 + 0.5; the box's axes are sorted by length.
        assert_eq!(exit(Isometry::translation(5.0, 0.0, 0.0)), Some(0));
        assert_eq!(exit(Isometry::translation(0.0, 3.5, 0.0)), Some(1));
        assert_eq!(exit(Isometry::translation(0.0, 0.0, 2.0)), Some(2));
    }

    #[test]
    fn a_test_takes_26_to_189_operations() {
        assert_eq!(operations(Some(0)), 18 + 8);
        assert_eq!(operations(Some(5)), 18 + 3 * 8 + 3 * 13);
        assert_eq!(operations(Some(6)), operations(Some(5)) + 12);
        assert_eq!(operations(None), 18 + 24 + 39 + 9 * 12); // 189
        assert_eq!(operations(None), operations(Some(14)));
    }

    #[test]
    fn an_axis_is_found_exactly_when_the_boxes_are_apart() {
        let (one, other) = (bar(6.0, 4.0, 2.0), bar(5.0, 1.0, 1.0));
        let mut draw = Draw::new(5, &["exit axes"], 0);
        let mut seen = [0_u32; AXES + 1];
        for _ in 0..40_000 {
            let shift: Vector3<f64> = draw.in_ball() * 6.0;
            let pose = Obb::pose(&Isometry::from_parts(Translation3::from(shift), draw.rotation()));
            let axis = one.exit_axis(&other, &pose);
            assert_eq!(axis.is_none(), one.overlaps(&other, &pose));
            seen[axis.unwrap_or(AXES)] += 1;
        }
        // Random boxes leave by every kind of axis.
        assert!(seen[..6].iter().sum::<u32>() > 1000 && seen[6..AXES].iter().sum::<u32>() > 100 && seen[AXES] > 1000);
    }
}
