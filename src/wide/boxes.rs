//! The separating-axis test of one box against the eight of a node, and its slack.
//!
//! S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996, section 5. A pair is apart when on one of the fifteen axes L (u_i, v_j,
//! u_i x v_j, none longer than 1) the distance |L·d| of the centres exceeds the reach ρ of both boxes by more than rounding can
//! feign. There is no widening of |R| against nearly parallel edges: both sides are then nearly 0, and a slack that is a length covers that
//! as it covers all else.
//!
//! The slack. u = 2⁻²⁴; terms in u² are left to the rounding up of the constants. s is the one box's centre and c a child's, both
//! from the node's origin; D = |s| + |c|; A, B are the sums of the half-lengths. Stored quantities are exact by definition
//! ([`super::code`]), s and u_i are rounded once from `f64`.
//!
//! 1. Axes v_j decoded in `f32` (`axes`). With |turn|² ≤ 0.272: xx, yy, zz are rounded once; their sum, at most 0.55, halved and taken from 1
//!    is wrong by at most 0.84u + 1u, and its root w ≥ 0.85 by at most 1.84u/(2·0.85) + 1u = 2.1u; w·2x by at most 3.2u; 2xy by 0.28u; an
//!    off-diagonal entry, their sum, by 4.5u; a diagonal one by 2.6u. So |Δv_j| ≤ √(2·4.5² + 2.6²) u < 7u; |Δu_i| ≤ 1.01u.
//! 2. R_ij = u_i·v_j: 1.01u + 7u + 3u (three products, two sums) < 11.2u.
//! 3. d = c - s: |Δd| ≤ u|s| + u|d| ≤ 2uD. t_i = u_i·d: (1.01 + 2 + 3) uD < 6.1uD. v_j·d: (7 + 2 + 3) uD = 12uD.
//! 4. t_i2 R_i1j - t_i1 R_i2j: 6.1√2 uD from t, 11.2√2 uD from R (|(t_i1, t_i2)| ≤ D), 2uD rounding: < 26.6uD.
//! 5. Reaches: each half-length is multiplied by at most one wrong R on each axis (11.2u) and takes part in at most four roundings: 15.2u(A + B).
//! 6. The difference of distance and reach is rounded once: u(D + A + B).
//!
//! Together (26.6 + 1) uD + (15.2 + 1) u(A + B). The constants are `PER_DISTANCE` = 29 and `PER_HALF` = 18, the rest pays for the slack's own
//! rounding. To it comes the slack of the pose ([`super::pose`]). Nothing here is an absolute length: scaled data give scaled slacks.

use super::lanes::{Lanes, three};
use super::node::{Node, WIDTH};
use super::pose::{PER_DISTANCE, PER_HALF, Seen, U};

/// What a bound of the distance is multiplied by: the difference with the slack, square, two sums, root and this product are each rounded once,
/// together less than 5·2⁻²⁴. Wrong axes are in the slack already.
const LOWERED: f32 = 1.0 - 8.0 * U;

/// One box against the children of one node.
#[derive(Clone, Copy)]
pub(super) struct Visit<'a> {
    pub node: &'a Node,
    pub one: Seen,
}

/// What a visit found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Found {
    /// For each child the largest difference of distance and reach over the axes, mm: less than 0 by how deep the boxes overlap. Not
    /// found where no child may overlap.
    pub gap: [f32; WIDTH],
    /// A bit for each child that may overlap.
    pub live: u8,
}

/// What the children of a node contribute to the slack, mm: the largest over the children. For [`Node::slack`].
pub(super) fn node_slack(node: &Node) -> f32 {
    let sum = |of: &[[f32; WIDTH]; 3], i: usize| of[0][i].abs() + of[1][i].abs() + of[2][i].abs();
    (0..node.count as usize)
        .map(|i| U * (PER_DISTANCE * sum(&node.centre, i) + PER_HALF * sum(&node.half, i)))
        .fold(0.0, f32::max)
}

/// Makes one or two visits.
#[inline(always)]
pub(super) fn visit<L: Lanes>(visits: &[Visit], found: &mut [Found; 2]) {
    let mut first = 0;
    while first < visits.len() {
        let (mut gap, mut live) = ([[0.0; WIDTH]; 2], 0);
        for part in 0..L::PARTS {
            live |= gaps::<L>(part, |i| &visits[(first + i).min(visits.len() - 1)], &mut gap);
        }
        for i in first..(first + L::VISITS).min(visits.len()) {
            found[i] = Found { gap: gap[i - first], live: (live >> (WIDTH * (i - first))) as u8 };
        }
        first += L::VISITS;
    }
}

/// For one or two visits, how far each child is at least from the one box, mm; 0 where they may touch.
#[inline(always)]
pub(super) fn distances<L: Lanes>(visits: &[Visit], least: &mut [[f32; WIDTH]; 2]) {
    let mut first = 0;
    while first < visits.len() {
        let mut bound = [[0.0; WIDTH]; 2];
        for part in 0..L::PARTS {
            least_distances::<L>(part, |i| &visits[(first + i).min(visits.len() - 1)], &mut bound);
        }
        let last = (first + L::VISITS).min(visits.len());
        least[first..last].copy_from_slice(&bound[..last - first]);
        first += L::VISITS;
    }
}

/// The axes of the children: their coordinates in the node's frame. The same operations as [`super::turn::decode`].
#[inline(always)]
fn axes<L: Lanes>(turn: [L; 3]) -> [[L; 3]; 3] {
    let [x, y, z] = turn;
    let one = L::splat(|_| 1.0);
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let (xx, yy, zz) = (x * x2, y * y2, z * z2);
    let w = (one - L::splat(|_| 0.5) * (xx + yy + zz)).sqrt();
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    [[one - yy - zz, xy + wz, xz - wy], [xy - wz, one - xx - zz, yz + wx], [xz + wy, yz - wx, one - xx - yy]]
}

#[inline(always)]
fn dot<L: Lanes>(a: &[L; 3], b: &[L; 3]) -> L {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The one box and the children in lanes: half-lengths `a` and `b`, the axes' products and their absolute values, and the way between the
/// centres along the one box's axes and along the children's.
struct Relation<L> {
    a: [L; 3],
    b: [L; 3],
    r: [[L; 3]; 3],
    q: [[L; 3]; 3],
    along_a: [L; 3],
    along_b: [L; 3],
}

impl<L: Lanes> Relation<L> {
    #[inline(always)]
    fn new<'a>(part: usize, visit: &impl Fn(usize) -> &'a Visit<'a>) -> Self {
        let v = axes::<L>(three!(k => L::load(part, |i| &visit(i).node.turn[k])));
        let b = three!(k => L::load(part, |i| &visit(i).node.half[k]));
        let a = three!(k => L::splat(|i| visit(i).one.half[k]));
        let u = three!(n => three!(k => L::splat(|i| visit(i).one.axes[n][k])));
        let d = three!(k => L::load(part, |i| &visit(i).node.centre[k]) - L::splat(|i| visit(i).one.centre[k]));
        let r = three!(i => three!(j => dot(&u[i], &v[j])));
        let q = three!(i => three!(j => r[i][j].abs()));
        Self { a, b, r, q, along_a: three!(i => dot(&u[i], &d)), along_b: three!(j => dot(&v[j], &d)) }
    }

    /// The gap along the one box's axis `i`.
    #[inline(always)]
    fn gap_a(&self, i: usize) -> L {
        self.along_a[i].abs() - (self.a[i] + dot(&self.b, &self.q[i]))
    }

    /// The gap along the children's axis `j`.
    #[inline(always)]
    fn gap_b(&self, j: usize) -> L {
        self.along_b[j].abs() - (self.b[j] + dot(&self.a, &[self.q[0][j], self.q[1][j], self.q[2][j]]))
    }

    /// The largest gaps along the axes of faces: three maxima of two, so that each need not wait for the one before.
    #[inline(always)]
    fn along_faces(&self) -> [L; 3] {
        three!(k => self.gap_a(k).max(self.gap_b(k)))
    }

    /// The largest gap along any axis, those of faces given.
    #[inline(always)]
    fn along_edges(&self, mut most: [L; 3]) -> L {
        let Self { a, b, r, q, along_a: t, .. } = self;
        for i in 0..3 {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            for j in 0..3 {
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                let distance = (t[i2] * r[i1][j] - t[i1] * r[i2][j]).abs();
                let reach = (a[i1] * q[i2][j] + a[i2] * q[i1][j]) + (b[j1] * q[i][j2] + b[j2] * q[i][j1]);
                most[j] = most[j].max(distance - reach);
            }
        }
        most[0].max(most[1]).max(most[2])
    }
}

/// The gaps of as many visits as fit a register, or of a part of one's children; a bit for each child that is there and not apart. No gaps are
/// found when there is none.
#[inline(always)]
fn gaps<'a, L: Lanes>(part: usize, visit: impl Fn(usize) -> &'a Visit<'a>, gap: &mut [[f32; WIDTH]; 2]) -> u32 {
    let relation = Relation::<L>::new(part, &visit);
    let slack = L::splat(|i| visit(i).node.slack + visit(i).one.slack);
    let first = part * WIDTH / L::PARTS;
    let lanes = u32::MAX >> (32 - L::VISITS * WIDTH / L::PARTS);
    let occupied = (0..L::VISITS).fold(0, |bits, i| bits | u32::from(visit(i).node.occupied()) << (WIDTH * i));
    let occupied = occupied >> first & lanes;
    // A gap that is not a number parts nothing.
    let together = |most: L| occupied & !most.exceeds(slack);
    let most = relation.along_faces();
    // Axes of faces part nearly all boxes that are apart, and often all of a visit.
    if together(most[0].max(most[1]).max(most[2])) == 0 {
        return 0;
    }
    let most = relation.along_edges(most);
    most.store(part, gap);
    together(most) << first
}

/// Lower bounds of the distance of each child from the one box. A box lies on the far side of a slab of each of the other's three axes, which
/// are square to one another, so that the three gaps make a right angle: the bound is the root of the sum of their squares. Each is lowered by the
/// slack first, and the result by what its own seven roundings can add ([`LOWERED`]). What is not a number becomes 0.
#[inline(always)]
fn least_distances<'a, L: Lanes>(part: usize, visit: impl Fn(usize) -> &'a Visit<'a>, least: &mut [[f32; WIDTH]; 2]) {
    let relation = Relation::<L>::new(part, &visit);
    let zero = L::splat(|_| 0.0);
    let slack = L::splat(|i| visit(i).node.slack + visit(i).one.slack);
    let along_a = three!(i => (relation.gap_a(i) - slack).max(zero));
    let along_b = three!(j => (relation.gap_b(j) - slack).max(zero));
    let squared = dot(&along_a, &along_a).max(dot(&along_b, &along_b));
    (squared.sqrt() * L::splat(|_| LOWERED)).store(part, least);
}

#[cfg(test)]
mod tests {
    use super::super::code::Code;
    use super::super::lanes::{Array, Machine, Simd, Work};
    use super::super::pose::Pose;
    use super::super::turn;
    use super::*;
    use crate::geometry::{Isometry, Point, Vector};
    use nalgebra::{Matrix3, Rotation3};
    use proptest::prelude::*;

    struct Visiting<'a>(&'a [Visit<'a>]);

    impl Work for Visiting<'_> {
        type Output = [Found; 2];

        #[inline(always)]
        fn run<M: Machine>(self) -> [Found; 2] {
            let mut found = [Found::default(); 2];
            visit::<M::Single>(self.0, &mut found);
            found
        }
    }

    /// The largest difference of distance and reach over the fifteen axes in `f64`, from the axes of both boxes in one frame.
    fn gap_in_f64(u: &Matrix3<f64>, a: &Vector, v: &Matrix3<f64>, b: &Vector, d: &Vector) -> f64 {
        let edges = (0..9).map(|n| u.column(n / 3).cross(&v.column(n % 3)));
        let faces = (0..3).flat_map(|n| [u.column(n).into_owned(), v.column(n).into_owned()]);
        let reach = |axis: &Vector| u.tr_mul(axis).abs().dot(a) + v.tr_mul(axis).abs().dot(b);
        edges.chain(faces).map(|axis| axis.dot(d).abs() - reach(&axis)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Of one visit the gaps of all children, whether it needs them or not.
    struct AllGaps<'a>(&'a Visit<'a>);

    impl Work for AllGaps<'_> {
        type Output = [f32; WIDTH];

        #[inline(always)]
        fn run<M: Machine>(self) -> [f32; WIDTH] {
            let mut gap = [[0.0; WIDTH]; 2];
            for part in 0..M::Single::PARTS {
                let relation = Relation::<M::Single>::new(part, &|_| self.0);
                relation.along_edges(relation.along_faces()).store(part, &mut gap);
            }
            gap[0]
        }
    }

    fn vector(size: f64) -> impl Strategy<Value = Vector> {
        prop::array::uniform3(-size..size).prop_map(Vector::from)
    }

    fn boxed(turn: Vector, half: Vector, centre: Vector, origin: [f32; 3]) -> Code {
        let frame = Rotation3::from_scaled_axis(turn).into_inner();
        let corners: Vec<Point> = (0..8)
            .map(|n| {
                let sign = Vector::from_fn(|k, _| if n >> k & 1 == 0 { 1.0 } else { -1.0 });
                Point::from(centre + frame * half.component_mul(&sign))
            })
            .collect();
        Code::fit(&frame, origin, std::iter::once(corners.as_slice()))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// At any scale, for flat, long and nearly parallel boxes, the gap is the `f64` gap within the slack, on every instruction set alike:
        /// whatever the slack calls apart is apart.
        #[test]
        fn the_slack_covers_the_rounding(
            turns in (vector(3.0), prop_oneof![vector(3.0), vector(1e-6), Just(Vector::zeros())]),
            halves in (vector(1.0), vector(1.0)),
            flat in prop::array::uniform2(prop_oneof![Just(1.0), Just(1e-4), Just(0.0)]),
            centres in (vector(2.0), vector(2.0)),
            pose in (vector(3.0), vector(1.0)),
            exponent in -6..6_i32,
        ) {
            let scale = 10f64.powi(exponent);
            let half = |half: Vector, flat: f64| half.abs().component_mul(&Vector::new(1.0, 1.0, flat)) * scale;
            let origin = (centres.0 * 0.7 * scale).map(|x| x as f32).into();
            let child = boxed(turns.0, half(halves.0, flat[0]), centres.0 * scale, origin);
            // The other box is turned against the first by the second turn, once it is moved.
            let motion = Isometry::new(pose.1 * scale, pose.0);
            let turn = motion.rotation.inverse() * nalgebra::UnitQuaternion::from_scaled_axis(turns.0)
                * nalgebra::UnitQuaternion::from_scaled_axis(turns.1);
            let other_origin = (centres.1 * scale).map(|x| x as f32).into();
            let one = boxed(turn.scaled_axis(), half(halves.1, flat[1]), centres.1 * scale, other_origin);

            let mut node = Node::empty(origin);
            node.count = 8;
            (0..8).for_each(|place| node.put(place, &child));
            node.slack = node_slack(&node);
            let moved = Pose::new(&motion, 10.0 * scale);
            let seen = Seen::new::<Array<f64>>(&moved.a_from_b, &one, &other_origin, &node, 0.0);
            let visit = Visit { node: &node, one: seen };
            let wide = |x: [f32; 3]| Vector::from(x.map(f64::from));
            let rotation = motion.rotation.to_rotation_matrix().into_inner();
            let centre = rotation * (wide(other_origin) + wide(one.centre)) + motion.translation.vector - wide(origin);
            let exact = gap_in_f64(
                &(rotation * turn::decode(one.turn)),
                &wide(one.half),
                &turn::decode(child.turn),
                &wide(child.half),
                &(wide(child.centre) - centre),
            );
            let slack = f64::from(node.slack + seen.slack);
            let results: Vec<[Found; 2]> = Simd::available().into_iter().map(|simd| simd.run(Visiting(&[visit, visit]))).collect();
            for [first, second] in &results {
                prop_assert_eq!(first, second);
                prop_assert_eq!(first, &results[0][0]);
                prop_assert!(exact > 0.0 || first.live == 255, "{exact} {slack}");
                // And the slack is small against the lengths involved, which are up to 20 times the scale.
                prop_assert!(exact < 1e-4 * scale || first.live == 0, "{exact} {slack}");
            }
            let gaps: Vec<[f32; WIDTH]> = Simd::available().into_iter().map(|simd| simd.run(AllGaps(&visit))).collect();
            for gap in &gaps {
                prop_assert_eq!(gap, &gaps[0]);
                prop_assert!(results[0][0].live == 0 || results[0][0].gap == *gap);
                for &gap in gap {
                    prop_assert!((f64::from(gap) - exact).abs() <= slack, "{gap} {exact} {slack}");
                }
            }
        }
    }
}
