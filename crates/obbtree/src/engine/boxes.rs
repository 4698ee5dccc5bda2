//! The separating-axis test of one box against others in lanes, and its slack.
//!
//! S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996, section 5. A pair is apart when on one of the fifteen axes L (u_i, v_j,
//! u_i x v_j, none longer than 1) the distance |L·d| of the centres exceeds the reach ρ of both boxes by more than rounding can
//! feign. There is no widening of |R| against nearly parallel edges: both sides are then nearly 0, and a slack that is a length covers that
//! as it covers all else.
//!
//! The children are seen in the one box's frame: the product of its quaternion, backwards, and a child's gives the products R_ij = u_i·v_j of the
//! axes in fewer operations than decoding the axes and multiplying them.
//!
//! The slack. u = 2⁻²⁴; terms in u² are left to the rounding up of the constants. s is the one box's centre and c a child's, both
//! from the node's origin, d = c - s, D = |s| + |c|; A, B are the sums of the half-lengths; q and r the unit quaternions of the one box in the node's frame
//! and of a child. Stored quantities are exact by definition ([`super::oriented`]), s is rounded once from `f64`. Every product is counted as
//! rounded before the sum it goes into; where both are fused ([`Lanes::mul_add`]), one of the two roundings does not take place.
//!
//! A quaternion that is wrong by e belongs to a box that is turned by a little, whose points are off by at most 2e times its half diagonal: to
//! say that boxes are apart any axis will do, also that of boxes a little off. So such an error meets the size of a box and not
//! its distance. The rest of it is that the quaternion is not of length 1, which makes products larger by a common factor; of the sides of
//! "distance > reach" what both have in common does not count, and a factor 1 + f that the distance alone has is less than f times the reach.
//!
//! 1. Scalar parts. With |turn|² ≤ 0.272 the three differences from 1 are rounded by u/2 each, their squares by 0.28u together; the root, at least
//!    0.85, is wrong by 1.78u/(2·0.85) + u/2 < 1.6u.
//! 2. q is x, y, z, w of a stored rotation times four vectors of length 1, square to one another, which are the pose's, rounded, u off. Products:
//!    (|x| + |y| + |z| + w)u < 1.8u; sums, no longer than 0.53, 0.53 and 1: 2.1u; with 1: |Δq| < 6.5u.
//! 3. The product p of q, backwards, and r likewise, from q as it is: 1.8 + 2.1 + 1.6 = 5.5u. So the one box is off by 13uA, the child by 11uB; the
//!    length of q is 1 + ε with |ε| < 6.5u, that of p (1 + ε)(1 + δ) with |δ| < 5.5u.
//! 4. R from p without regard to its length: (1 + 2ε + 2δ) times the products of the axes, and of roundings 3u at most (those of four squares, of two
//!    sums, and of their sum).
//! 5. d: u|s| + u|d| ≤ 2uD. t = d - 2w (v × d) + 2v × (v × d) for q = (v, w): 1 + 2ε times the way along the one box's axes, less 2ε d: 13uD. Roundings: v × d
//!    twice, 6u|v|·|d|, which goes on times w + |v|, together 7.3uD; sums of at most 1.42, 3.42 and 1 times |d|, 5.9uD; their products, 5uD. In all 33.2uD.
//! 6. Distances. t_i: 33.2uD. Σ R_ij t_i: 33.2 + 3√3 (R) + 3 < 41.4uD. t_i2 R_i1j - t_i1 R_i2j: 33.2 + 3√2 + 2 < 39.5uD.
//! 7. Reaches. Each half-length takes part in at most four roundings, 4u, and is multiplied by at most one wrong R, 3u. Factors of the length, over that of the distance:
//!    2ε and 2δ (13uA, 11uB) along u_i; 2ε and 4ε + 2δ (13uA, 37uB, the latter where no R is wrong) along v_j; 2ε for both along edges.
//! 8. The difference of distance and reach is rounded once: u(D + A + B).
//!
//! Together 42.4uD; 4 + 3 + 13 + 1 and 13 of step 3, 34uA; 4 + 37 + 1 and 11, 53uB. The constants of [`super::volume`] are 43 and 54, the rest pays for the
//! slack's own rounding.

use super::lanes::{FOUR, Lanes, three};
use super::volume::{Relation, U};

/// What a bound of the distance is multiplied by: the factor 1 + 4ε + 2δ (steps 3 to 6) that gaps have, less than 1 + 37·2⁻²⁴; the difference with the
/// slack, square, two sums or a quotient, root and this product are each rounded once, together less than 5·2⁻²⁴.
pub(super) const LOWERED: f32 = 1.0 - 48.0 * U;

/// Boxes of the other mesh in the nodes' frames but for their centres: rotations, as quaternions (x, y, z, w), and half-lengths, mm.
#[derive(Clone, Copy)]
pub struct Turned<L> {
    pub(super) turn: [L; FOUR],
    pub(super) half: [L; 3],
}

/// What the one box sees of the children: the products of its axes with theirs (a row for each of its own), and the way `d` along its axes. Of
/// the children's quaternions the vector parts are given ([`super::turn`]).
#[inline(always)]
pub(super) fn seen_from<L: Lanes>(turn: &[L; FOUR], children: &[L; 3], d: &[L; 3]) -> ([[L; 3]; 3], [L; 3]) {
    (products(&backwards(turn, children)), along(turn, d))
}

/// The product of a quaternion backwards and others, of which the vector parts are given. Everywhere the terms with x and y are summed first, then
/// those with z and those with w: so the sums are no longer than step 3 says.
#[inline(always)]
pub(super) fn backwards<L: Lanes>(&[qx, qy, qz, qw]: &[L; FOUR], &[x, y, z]: &[L; 3]) -> [L; FOUR] {
    let w = z.neg_mul_add(z, y.neg_mul_add(y, x.neg_mul_add(x, L::all(1.0)))).sqrt();
    [
        w.neg_mul_add(qx, z.neg_mul_add(qy, y.mul_add(qz, x * qw))),
        w.neg_mul_add(qy, z.mul_add(qx, x.neg_mul_add(qz, y * qw))),
        w.neg_mul_add(qz, z.mul_add(qw, y.neg_mul_add(qx, x * qy))),
        w.mul_add(qw, z.mul_add(qz, y.mul_add(qy, x * qx))),
    ]
}

/// The matrix of a rotation, row by row, times the square of the quaternion's length.
#[inline(always)]
fn products<L: Lanes>(&[x, y, z, w]: &[L; FOUR]) -> [[L; 3]; 3] {
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    let (ww, xx) = (w * w, x * x);
    let (ww_less_zz, ww_and_zz) = (z.neg_mul_add(z, ww), z.mul_add(z, ww));
    let (xx_less_yy, xx_and_yy) = (y.neg_mul_add(y, xx), y.mul_add(y, xx));
    [
        [ww_less_zz + xx_less_yy, w.neg_mul_add(z2, xy), w.mul_add(y2, xz)],
        [w.mul_add(z2, xy), ww_less_zz - xx_less_yy, w.neg_mul_add(x2, yz)],
        [w.neg_mul_add(y2, xz), w.mul_add(x2, yz), ww_and_zz - xx_and_yy],
    ]
}

/// Vectors turned back by a quaternion.
#[inline(always)]
pub(super) fn along<L: Lanes>(&[x, y, z, w]: &[L; FOUR], d: &[L; 3]) -> [L; 3] {
    let cross = |j: usize, k: usize, vj: L, vk: L| (vk + vk).neg_mul_add(d[j], (vj + vj) * d[k]);
    let g = [cross(1, 2, y, z), cross(2, 0, z, x), cross(0, 1, x, y)];
    let turned =
        |i: usize, j: usize, k: usize, vj: L, vk: L| vk.neg_mul_add(g[j], vj.mul_add(g[k], w.neg_mul_add(g[i], d[i])));
    [turned(0, 1, 2, y, z), turned(1, 2, 0, z, x), turned(2, 0, 1, x, y)]
}

/// The sum of the products.
#[inline(always)]
pub(super) fn dot<L: Lanes>(a: &[L; 3], b: &[L; 3]) -> L {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// The term and the sum of the products.
#[inline(always)]
fn term_and_dot<L: Lanes>(term: L, a: &[L; 3], b: &[L; 3]) -> L {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0].mul_add(b[0], term)))
}

/// The one box and the children in lanes: half-lengths `a` and `b`, the axes' products and their absolute values, and the way between the
/// centres along the one box's axes and along the children's.
#[derive(Clone, Copy)]
pub struct BoxRelation<L> {
    a: [L; 3],
    b: [L; 3],
    r: [[L; 3]; 3],
    q: [[L; 3]; 3],
    along_a: [L; 3],
    along_b: [L; 3],
}

impl<L: Lanes> BoxRelation<L> {
    #[inline(always)]
    pub(super) fn new(a: [L; 3], b: [L; 3], r: [[L; 3]; 3], along_a: [L; 3], along_b: [L; 3]) -> Self {
        Self { a, b, r, q: three!(i => three!(j => r[i][j].abs())), along_a, along_b }
    }

    /// The gap along the one box's axis `i`.
    #[inline(always)]
    fn gap_a(&self, i: usize) -> L {
        self.along_a[i].abs() - term_and_dot(self.a[i], &self.b, &self.q[i])
    }

    /// The gap along the children's axis `j`.
    #[inline(always)]
    fn gap_b(&self, j: usize) -> L {
        self.along_b[j].abs() - term_and_dot(self.b[j], &self.a, &[self.q[0][j], self.q[1][j], self.q[2][j]])
    }

    /// The gap along the product of the one box's axis `i` and the children's axis `j`, as long as that is: √(1 - r²) or less than 1.
    #[inline(always)]
    fn gap_of_edges(&self, i: usize, j: usize) -> L {
        let Self { a, b, r, q, along_a: t, .. } = self;
        let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        let distance = t[i1].neg_mul_add(r[i2][j], t[i2] * r[i1][j]).abs();
        let reach_a = a[i2].mul_add(q[i1][j], a[i1] * q[i2][j]);
        distance - b[j2].mul_add(q[i][j1], b[j1].mul_add(q[i][j2], reach_a))
    }
}

impl<L: Lanes> BoxRelation<L> {
    /// A way w from the one box to the child, along the child's axes, mm, and the gap along it times its length, less `slack` times that. It leads from
    /// the point of the one box that is nearest to the child's centre to the point of the child that is nearest to that.
    ///
    /// Any w gives a true gap, however it was found; what is computed of it is wrong by less than twice the slack times |w|, in the terms of the module. The
    /// distance: each component along the child's axes by 41.4uD, so their product with w by √3 times that, and its roundings 3uD, together 75uD.
    /// The reaches: of R w 3√3u (R) + 3u, of the sum 3u, so 12uA, and 3uB; factors of the length 13uA and 37uB, the boxes themselves 13uA and 11uB, the
    /// difference u(D + A + B). In all 76uD + 39uA + 52uB. |w| is at most the sum of its components.
    #[inline(always)]
    fn gap_of_way(&self, slack: L) -> (L, [L; 3]) {
        let Self { a, b, r, along_a: t, along_b, .. } = self;
        let zero = L::all(0.0);
        let clamped = |x: L, limit: L| x.min(limit).max(zero - limit);
        let from_centre = three!(i => clamped(t[i], a[i]) - t[i]);
        let start = three!(j => dot(&[r[0][j], r[1][j], r[2][j]], &from_centre));
        let way = three!(j => clamped(start[j], b[j]) - start[j]);
        let sizes = three!(j => way[j].abs());
        let in_a = three!(i => dot(&r[i], &way).abs());
        let reach = term_and_dot(dot(a, &in_a), b, &sizes);
        let length = sizes[0] + sizes[1] + sizes[2];
        ((dot(&way, along_b) - reach) - slack * length, way)
    }
}

impl<L: Lanes> Relation<L> for BoxRelation<L> {
    /// Along the axes of faces: three maxima of two, so that each need not wait for the one before.
    #[inline(always)]
    fn quick_gaps(&self) -> [L; 3] {
        three!(k => self.gap_a(k).max(self.gap_b(k)))
    }

    #[inline(always)]
    fn gap(&self, mut most: [L; 3]) -> L {
        for i in 0..3 {
            for (j, most) in most.iter_mut().enumerate() {
                *most = most.max(self.gap_of_edges(i, j));
            }
        }
        most[0].max(most[1]).max(most[2])
    }

    #[inline(always)]
    fn larger(&self) -> u32 {
        let size = |[x, y, z]: [L; 3]| x * y * z;
        size(self.b).exceeds(size(self.a))
    }

    /// A box lies on the far side of a slab of each of the other's three axes, which are square to one another, so that the three gaps make a
    /// right angle: a bound is the root of the sum of their squares. Others are the gaps along the products of edges over the products'
    /// lengths, of which 1 - r² is the square: it is wrong by twice the error of r, 2ε + 2δ + 3u in step 4, and two roundings, less than 56·2⁻²⁴, and
    /// the divisor larger than it by 64·2⁻²⁴. Each gap is lowered by the slack first, and the result by what its own roundings and the length of the
    /// quaternions can add (`LOWERED`). The quotient of the way adds the roundings of |w|², half of 3·2⁻²⁴ under the root, to its own two. What is not a
    /// number becomes 0.
    ///
    /// Along the way from the one box's point that is nearest to the child's centre to the child's nearest point to it there is nearly all of the distance
    /// where faces and edges leave some (`BoxRelation::gap_of_way`); edges are asked last.
    #[inline(always)]
    fn least_mm(&self, slack: L, enough: impl Fn(L) -> bool) -> L {
        let (zero, one) = (L::all(0.0), L::all(1.0 + 64.0 * U));
        let along_a = three!(i => (self.gap_a(i) - slack).max(zero));
        let along_b = three!(j => (self.gap_b(j) - slack).max(zero));
        let mut most = dot(&along_a, &along_a).max(dot(&along_b, &along_b));
        let (gap, way) = self.gap_of_way(slack + slack);
        let gap = gap.max(zero);
        // The quotient first: the square of the gap, |w|⁴, could be too large.
        most = most.max(gap / dot(&way, &way).max(L::all(f32::MIN_POSITIVE)) * gap);
        if enough(most) {
            return most.sqrt() * L::all(LOWERED);
        }
        for i in 0..3 {
            for (j, &r) in self.r[i].iter().enumerate() {
                let gap = (self.gap_of_edges(i, j) - slack).max(zero);
                most = most.max(gap * gap / r.neg_mul_add(r, one));
            }
        }
        most.sqrt() * L::all(LOWERED)
    }
}
