//! Poses around one at which the verdict is known, and the same: a bubble, as S. Quinlan, "Real-Time Modification of Collision-Free Paths", 1994, calls
//! such a neighbourhood of a free pose. Here there are bubbles of touching poses as well.
//!
//! Meshes that are apart by a distance stay so while no point of `b` goes that far, and triangles that cross go on crossing while no point of them goes as
//! far as [`crossing`](crate::engine::geometry::crossing) says. Points of `b` go at most |t₁ - t₀| + 2|q₁ - q₀|r from one pose to another
//! ([`super::path`]), with r their largest distance from the mesh's origin. That is at most √2 times the root of |t₁ - t₀|² + (2|q₁ - q₀|r)², so a pose in the
//! bubble costs seven squares and no root.

use super::node::WideTree;
use super::pose::Pose;
use super::volume::WideVolume;
use crate::engine::geometry::{Isometry, Vector, rigid};
use nalgebra::Vector4;

/// The square of a bubble's size is lowered by this share. That covers the rounding of the ways that are compared with it.
const SIZE_PAD: f64 = 16.0 / 9_007_199_254_740_992.0;

/// Poses at which the verdict is that of one pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bubble {
    translation: Vector,
    turn: Vector4<f64>,
    /// The square of twice the reach of `b`, mm².
    turned_mm2: f64,
    /// Half the square of how far points may go, mm².
    size_mm2: f64,
    /// The verdict.
    pub touching: bool,
    /// Poses that it has settled.
    pub settled: u32,
}

impl Bubble {
    /// The bubble around a pose with a verdict that stays the same while points of `b` go less than `room_mm`. The slack of this pose is off already, that of
    /// the others is taken off here; `None` where nothing is left. The quaternion has length 1.
    #[inline]
    pub fn around<V: WideVolume>(
        (a, b): (&WideTree<V>, &WideTree<V>),
        a_from_b: &Isometry,
        room_mm: f64,
        touching: bool,
    ) -> Option<Self> {
        let room_mm = (room_mm - Pose::slack_within(a_from_b, a.reach_with(b), room_mm)).next_down();
        let (translation, turn) = (a_from_b.translation.vector, a_from_b.rotation.coords);
        let reach_mm = 2.0 * b.reach;
        let size_mm2 = 0.5 * room_mm * room_mm * (1.0 - SIZE_PAD);
        let bubble = Self { translation, turn, turned_mm2: reach_mm * reach_mm, size_mm2, touching, settled: 0 };
        (room_mm > 0.0).then_some(bubble)
    }

    /// Whether the bubble holds a pose. Counts the poses that it holds.
    #[inline(always)]
    pub fn holds(&mut self, a_from_b: &Isometry) -> bool {
        let way = a_from_b.translation.vector - self.translation;
        let turned = a_from_b.rotation.coords - self.turn;
        let way_mm2 = way.norm_squared() + self.turned_mm2 * turned.norm_squared();
        let is_in = way_mm2 < self.size_mm2 && rigid::is_unit(a_from_b);
        self.settled += u32::from(is_in);
        is_in
    }
}

#[cfg(test)]
mod tests {
    use super::super::distance::distance_mm;
    use super::super::lanes::Simd;
    use super::super::oriented::Oriented;
    use super::super::proximity::Proximity;
    use super::super::traverse::{Scratch, contact, first};
    use super::*;
    use crate::cases::meshes;
    use crate::engine::geometry::crossing::crossing_mm;
    use crate::engine::geometry::grid::Placement;
    use nalgebra::UnitQuaternion;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    fn trees() -> (WideTree<Oriented>, WideTree<Oriented>) {
        (WideTree::build(&meshes::torus(12.0, 4.0, 28, 14)), WideTree::build(&meshes::stepped_tool(16, 8)))
    }

    #[test]
    fn a_bubble_is_as_large_as_the_room_less_the_slack() {
        let (a, b) = trees();
        let around = |room| Bubble::around((&a, &b), &Isometry::translation(40.0, 1.0, 0.0), room, false);
        assert!(
            around(0.0).is_none()
                && around(1e-9).is_none()
                && around(f64::NAN).is_none()
                && around(f64::INFINITY).is_none()
        );
        // Straight on, up to the room over √2; a turn by θ counts for 2 · 2 sin(θ/4) of the reach.
        let mut bubble = around(1.0).unwrap();
        assert_eq!((bubble.touching, bubble.settled), (false, 0));
        // Half the square of what is left, less 16·2⁻⁵³ of it.
        let left_mm =
            (1.0 - Pose::slack_within(&Isometry::translation(40.0, 1.0, 0.0), a.reach_with(&b), 1.0)).next_down();
        let lowered = 1.0 - 2.0 * bubble.size_mm2 / (left_mm * left_mm);
        assert!(lowered > 0.9 * SIZE_PAD && lowered < 1.1 * SIZE_PAD, "{lowered}");
        let least = std::f64::consts::FRAC_1_SQRT_2;
        for (share, is_in) in [(0.0, true), (1.0 - 1e-6, true), (1.0 + 1e-9, false)] {
            let along = Isometry::translation(40.0, 1.0, share * least);
            assert_eq!(bubble.holds(&along), is_in, "{share}");
            let angle = 4.0 * (0.25 * share * least / b.reach).asin();
            let turned = Isometry::new([40.0, 1.0, 0.0].into(), [0.0, angle, 0.0].into());
            assert_eq!(bubble.holds(&turned), is_in, "{share}");
        }
        assert_eq!(bubble.settled, 4);
        // Room that is hardly more than the slack, which is 1.3e-8 mm and what rounding may be.
        let (pose, room_mm) = (Isometry::translation(40.0, 1.0, 0.0), 3e-8);
        let left_mm = room_mm - Pose::slack_within(&pose, a.reach_with(&b), room_mm);
        assert!((1e-8..1.8e-8).contains(&left_mm), "{left_mm}");
        let mut small = around(room_mm).unwrap();
        for (share, is_in) in [(0.99, true), (1.01, false)] {
            assert_eq!(small.holds(&Isometry::translation(40.0, 1.0, share * least * left_mm)), is_in, "{share}");
        }
        // The other quaternion of the same rotation is far, one of another length is no rotation, and NaN is nowhere.
        let same = Isometry::translation(40.0, 1.0, 0.0);
        let by = |quaternion| Isometry::from_parts(same.translation, UnitQuaternion::new_unchecked(quaternion));
        let quaternion = *same.rotation.quaternion();
        assert!(
            bubble.holds(&same) && !bubble.holds(&by(-quaternion)) && !bubble.holds(&by(quaternion * (1.0 + 1e-12)))
        );
        assert!(!bubble.holds(&Isometry::translation(f64::NAN, 1.0, 0.0)) && !bubble.holds(&by(quaternion * f64::NAN)));
    }

    /// Bubbles of free poses as large as the distance, and of touching ones as large as a crossing allows: every pose in them has the verdict, those at
    /// the border in the worst direction too.
    #[test]
    fn poses_in_a_bubble_have_its_verdict() {
        let (a, b) = trees();
        let mut random = Pcg64::seed_from_u64(3);
        let (mut scratch, mut inside) = (Scratch::default(), [0; 2]);
        let mut vector = |length: f64| Vector::from_fn(|_, _| random.random_range(-length..=length));
        for _ in 0..600 {
            let pose = Isometry::new(vector(14.0), vector(3.0));
            let slack_mm = Pose::ball_slack(&pose, a.reach_with(&b));
            let found = contact(&a, &b, &pose, Simd::in_use(), &mut scratch);
            let room_mm = match found {
                None => distance_mm(&a, &b, &pose, Simd::in_use(), f64::INFINITY, &mut Proximity::default()),
                Some((i, j)) => crossing_mm(&a.triangle(i), &Placement::new(&pose).triangle(&b.triangle(j))),
            };
            let Some(mut bubble) = Bubble::around((&a, &b), &pose, room_mm - slack_mm, found.is_some()) else {
                continue;
            };
            for k in 0..24 {
                // Of all lengths up to the border: straight, turned, and both.
                let (way, turn) = (vector(1.0), vector(1.0));
                let [straight, turning] = [[1.0, 0.0], [0.0, 1.0], [0.7, 0.7]][k % 3];
                let length = room_mm * std::f64::consts::FRAC_1_SQRT_2 * if k < 12 { 1.0 - 1e-6 } else { 0.1 };
                let way = way.normalize() * straight * length;
                let turn = UnitQuaternion::new(turn.normalize() * (turning * length / b.reach));
                let near = Isometry::from_parts((pose.translation.vector + way).into(), turn * pose.rotation);
                if bubble.holds(&near) {
                    inside[usize::from(bubble.touching)] += 1;
                    assert_eq!(first(&a, &b, &near, Simd::in_use(), &mut scratch), bubble.touching, "{pose} {near}");
                }
            }
        }
        assert!(inside[0] > 2000 && inside[1] > 2000, "{inside:?}");
    }

    /// A bubble larger by half than it may be is noticed: some pose in it has the other verdict.
    #[test]
    fn a_bubble_that_is_too_large_is_wrong() {
        let ball = WideTree::<Oriented>::build(&meshes::cuboid(2.0, 2.0, 2.0));
        let (pose, mut scratch) = (Isometry::translation(3.0, 0.0, 0.0), Scratch::default());
        let toward = |way: f64| Isometry::translation(3.0 - way, 0.0, 0.0);
        let border = 0.999 * std::f64::consts::FRAC_1_SQRT_2;
        for (room_mm, is_right) in [(1.0, true), (1.5, false)] {
            let mut bubble = Bubble::around((&ball, &ball), &pose, room_mm, false).unwrap();
            assert!(bubble.holds(&toward(border * room_mm)));
            assert_eq!(first(&ball, &ball, &toward(border * room_mm), Simd::in_use(), &mut scratch), !is_right);
        }
    }
}
