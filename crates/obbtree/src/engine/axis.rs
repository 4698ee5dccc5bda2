//! A direction along which the boxes around two meshes are apart, kept from one pose to the next.
//!
//! The oldest of coherences: what parted two boxes at one pose mostly parts them at the next (D. Baraff 1990; G. van den Bergen 1997 keeps one
//! for each pair of bodies). Only the roots' boxes are asked, along the six axes of their faces: where these are apart a fresh query is
//! short, and what is to replace it must be shorter still.
//!
//! Why a kept axis tells the truth. The roots' boxes contain all corners as they stand in the meshes ([`super::oriented`]), and a corner that is
//! moved is within the pose's slack of where a rigid motion has it ([`Pose::ball_slack`]), which also pays for the few dozen roundings here, all
//! of numbers no larger than the reaches and the way between the meshes. The direction is longer or shorter than 1 by a few roundings of
//! its own, which are paid for likewise.

use super::node::WideTree;
use super::pose::Pose;
use super::volume::WideVolume;
use crate::engine::geometry::{Isometry, Vector};
use nalgebra::Matrix3;

/// The box around a mesh, in the mesh's own frame, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    centre: Vector,
    axes: Matrix3<f64>,
    half: Vector,
}

impl Around {
    /// That of the root, if it is a box.
    pub fn of<V: WideVolume>(tree: &WideTree<V>) -> Option<Self> {
        let (axes, centre, half) = tree.plain(WideTree::<V>::ROOT).as_box()?;
        Some(Self { centre: centre.coords, axes, half })
    }

    /// How far the box reaches from its centre along a direction, mm.
    #[inline(always)]
    fn reach_mm(&self, along: &Vector) -> f64 {
        self.axes.tr_mul(along).abs().dot(&self.half)
    }
}

/// A direction from mesh `a` to mesh `b`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    /// In the frame of `a`, of length 1.
    along: Vector,
    /// The farthest that `a` reaches along it, mm.
    end_mm: f64,
    /// The box around `b`.
    around_b: Around,
}

impl Axis {
    /// The axis of a face along which the boxes around the meshes are farthest apart, if one surely parts the meshes, and how far it does, mm.
    pub fn of<V: WideVolume>(a: &WideTree<V>, b: &WideTree<V>, a_from_b: &Isometry) -> Option<(Self, f64)> {
        let (around_a, around_b) = (a.around.as_ref()?, b.around.as_ref()?);
        let turned = a_from_b.rotation.to_rotation_matrix().into_inner() * around_b.axes;
        let way = a_from_b.rotation * around_b.centre + a_from_b.translation.vector - around_a.centre;
        // Each box reaches its half-length along its own axes, and along those of the other what `r` makes of all three.
        let r = around_a.axes.tr_mul(&turned).abs();
        let (reach_b, reach_a) = (r * around_b.half, r.tr_mul(&around_a.half));
        let (way_a, way_b) = (around_a.axes.tr_mul(&way), turned.tr_mul(&way));
        let gaps_a = way_a.abs() - around_a.half - reach_b;
        let gaps_b = way_b.abs() - reach_a - around_b.half;
        let (of_a, of_b) = (gaps_a.imax(), gaps_b.imax());
        let (gap, axes, which, way, reach_mm) = if gaps_a[of_a] >= gaps_b[of_b] {
            (gaps_a[of_a], &around_a.axes, of_a, way_a[of_a], around_a.half[of_a])
        } else {
            (gaps_b[of_b], &turned, of_b, way_b[of_b], reach_a[of_b])
        };
        let apart_mm = gap - Pose::ball_slack(a_from_b, a.reach_with(b));
        let along = axes.column(which) * way.signum();
        let axis = Self { along, end_mm: along.dot(&around_a.centre) + reach_mm, around_b: *around_b };
        (apart_mm > 0.0).then_some((axis, apart_mm))
    }

    /// How far the meshes are surely apart along it at this pose, mm; not above 0 where it does not part them.
    #[inline]
    pub fn apart_mm<V: WideVolume>(&self, a: &WideTree<V>, b: &WideTree<V>, a_from_b: &Isometry) -> f64 {
        let along_in_b = a_from_b.rotation.inverse_transform_vector(&self.along);
        let centre = self.along.dot(&a_from_b.translation.vector) + along_in_b.dot(&self.around_b.centre);
        let begin_mm = centre - self.around_b.reach_mm(&along_in_b);
        begin_mm - self.end_mm - Pose::ball_slack(a_from_b, a.reach_with(b))
    }
}

#[cfg(test)]
mod tests {
    use super::super::lanes::Simd;
    use super::super::oriented::Oriented;
    use super::super::traverse::{Scratch, first};
    use super::*;
    use crate::cases::Cases;
    use crate::cases::meshes;

    #[test]
    fn what_an_axis_parts_is_apart() {
        let cases = Cases::new();
        let trees: Vec<WideTree<Oriented>> =
            cases.subjects.iter().map(|subject| WideTree::build(&subject.mesh)).collect();
        let (mut parted, mut kept) = (0, None);
        for case in &cases.cases {
            let (a, b, pose) = (&trees[case.a], &trees[case.b], &case.a_from_b);
            // The axis of this pose, and that of another pose of the same meshes.
            let of_this = Axis::of(a, b, pose).map(|(axis, _)| axis);
            assert!(of_this.is_none() || !first(a, b, pose, Simd::in_use(), &mut Scratch::default()));
            for axis in
                of_this.iter().chain(kept.iter().filter(|(pair, _)| *pair == (case.a, case.b)).map(|(_, axis)| axis))
            {
                if axis.apart_mm(a, b, pose) > 0.0 {
                    parted += 1;
                    assert!(!first(a, b, pose, Simd::in_use(), &mut Scratch::default()));
                }
            }
            kept = of_this.map(|axis| ((case.a, case.b), axis)).or(kept);
        }
        assert!(parted > 5, "{parted}");
    }

    #[test]
    fn boxes_are_apart_up_to_their_faces() {
        let tree = WideTree::<Oriented>::build(&meshes::cuboid(2.0, 2.0, 2.0));
        let at = |x: f64| Isometry::translation(x, 0.0, 0.0);
        let extent = 2.0 * Around::of(&tree).unwrap().reach_mm(&Vector::x());
        let (axis, apart_mm) = Axis::of(&tree, &tree, &at(extent + 1.0)).expect("they are apart along x");
        // 1 mm, less 1.3e-8 mm.
        let expected_mm = 1.0 - Pose::ball_slack(&at(extent + 1.0), tree.reach_with(&tree));
        for apart_mm in [apart_mm, axis.apart_mm(&tree, &tree, &at(extent + 1.0))] {
            assert!((apart_mm - expected_mm).abs() < 1e-12, "{apart_mm} {expected_mm}");
        }
        assert!((axis.along - Vector::x()).norm() < 1e-6);
        assert!(
            axis.apart_mm(&tree, &tree, &at(extent + 1e-6)) > 0.0 && axis.apart_mm(&tree, &tree, &at(extent)) <= 0.0
        );
        assert!(Axis::of(&tree, &tree, &at(extent - 1e-6)).is_none());
    }
}
