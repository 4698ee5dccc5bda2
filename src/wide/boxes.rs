//! The separating-axis test of one box against others in lanes, and its slack.
//!
//! S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996, section 5. A pair is apart when on one of the fifteen axes L (u_i, v_j,
//! u_i x v_j, none longer than 1) the distance |L·d| of the centres exceeds the reach ρ of both boxes by more than rounding can
//! feign. There is no widening of |R| against nearly parallel edges: both sides are then nearly 0, and a slack that is a length covers that
//! as it covers all else.
//!
//! The slack. u = 2⁻²⁴; terms in u² are left to the rounding up of the constants. s is the one box's centre and c a child's, both
//! from the node's origin; D = |s| + |c|; A, B are the sums of the half-lengths. Stored quantities are exact by definition
//! ([`super::oriented`]), s and u_i are rounded once from `f64`. Every product is counted as rounded before the sum it goes into; where both are
//! fused ([`Lanes::mul_add`]), one of the two roundings does not take place.
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
//! Together (26.6 + 1) uD + (15.2 + 1) u(A + B). The constants of [`super::volume`] are 29 and 18, the rest pays for the
//! slack's own rounding.

use super::lanes::{DOUBLES, Lanes, three};
use super::volume::{Relation, U};

/// What a bound of the distance is multiplied by: the difference with the slack, square, two sums or a quotient, root and this product are each
/// rounded once, together less than 5·2⁻²⁴. Wrong axes are in the slack already.
pub(super) const LOWERED: f32 = 1.0 - 8.0 * U;

/// A box of the other mesh in a node's frame but for its centre: axes and half-lengths, mm.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turned {
    pub(super) axes: Diagonals,
    pub(super) half: [f32; 3],
}

/// A matrix of three rows and columns by what a quaternion gives at a time: the entries (k, k), (k + 1, k) and (k, k + 1), all modulo 3, for k
/// from 0 to 2; the last number of each is nothing.
pub(super) type Diagonals = [[f32; DOUBLES]; 3];

/// The columns of a matrix for each visit.
#[inline(always)]
pub(super) fn columns<'a, L: Lanes>(of: impl Fn(usize) -> &'a Diagonals) -> [[L; 3]; 3] {
    let [own, below, above] = three!(n => three!(k => L::splat(|i| of(i)[n][k])));
    [[own[0], below[0], above[2]], [above[0], own[1], below[1]], [below[2], above[1], own[2]]]
}

/// The axes of the children: their coordinates in the node's frame, by the formulas of [`super::turn::decode`].
#[inline(always)]
pub(super) fn axes<L: Lanes>(turn: [L; 3]) -> [[L; 3]; 3] {
    let [x, y, z] = turn;
    let one = L::splat(|_| 1.0);
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let w = L::splat(|_| 0.5).neg_mul_add(z.mul_add(z2, y.mul_add(y2, x * x2)), one).sqrt();
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    let (less_xx, less_yy) = (x.neg_mul_add(x2, one), y.neg_mul_add(y2, one));
    [
        [z.neg_mul_add(z2, less_yy), w.mul_add(z2, xy), w.neg_mul_add(y2, xz)],
        [w.neg_mul_add(z2, xy), z.neg_mul_add(z2, less_xx), w.mul_add(x2, yz)],
        [w.mul_add(y2, xz), w.neg_mul_add(x2, yz), y.neg_mul_add(y2, less_xx)],
    ]
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

impl<L: Lanes> Relation<L> for BoxRelation<L> {
    /// Along the axes of faces: three maxima of two, so that each need not wait for the one before.
    #[inline(always)]
    fn soon(&self) -> [L; 3] {
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

    /// A box lies on the far side of a slab of each of the other's three axes, which are square to one another, so that the three gaps make a
    /// right angle: a bound is the root of the sum of their squares. Others are the gaps along the products of edges over the products'
    /// lengths, of which 1 - r² is the square: it is wrong by twice the error of r (2 above) and two roundings, less than 25·2⁻²⁴, and the
    /// divisor larger than it by 64·2⁻²⁴. Each gap is lowered by the slack first, and the result by what its own roundings can add
    /// (`LOWERED`). What is not a number becomes 0.
    #[inline(always)]
    fn least_mm(&self, slack: L) -> L {
        let (zero, one) = (L::splat(|_| 0.0), L::splat(|_| 1.0 + 64.0 * U));
        let along_a = three!(i => (self.gap_a(i) - slack).max(zero));
        let along_b = three!(j => (self.gap_b(j) - slack).max(zero));
        let mut most = dot(&along_a, &along_a).max(dot(&along_b, &along_b));
        for i in 0..3 {
            for (j, &r) in self.r[i].iter().enumerate() {
                let gap = (self.gap_of_edges(i, j) - slack).max(zero);
                most = most.max(gap * gap / r.neg_mul_add(r, one));
            }
        }
        most.sqrt() * L::splat(|_| LOWERED)
    }
}
