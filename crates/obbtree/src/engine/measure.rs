//! How far apart four pairs of triangles are, about: which of them have to be measured with care.
//!
//! The fifteen pairs of features of [`triangle_distance`](crate::engine::geometry::triangle_distance), without its care for needles: nearly parallel
//! edges are taken wherever rounding puts them, and a corner counts as over a face where rounding says so. Each of the former is a distance of two
//! points of the triangles, so it is never less than the least but for rounding. What it can be more is derived where [`MEASURED_PAD`] stands: a
//! place misplaced along two edges at an angle φ by x costs φx, and rounding misplaces it by as much as 32·2⁻⁵³ r / φ², or by all of their length r
//! where φ is less than 2⁻²⁴. A corner over a face that is taken to be beside it is beside an edge by as little as that. Roundings of the rest are a
//! few 2⁻⁵³ r. A corner beside a face that is taken to be over it makes the distance too small, which costs time and nothing else.

use super::lanes::{DOUBLES, DoubleLanes, three};

/// How much larger a measured distance of two triangles may be than the true one, relative to the size of everything: 2⁻²². The distance of two
/// edges at an angle φ is taken at a place that rounding misplaces along the edges by at most 32·2⁻⁵³ r / φ² (r: how far the corners are from
/// one another; lemma H of docs/proofs.md), which lengthens it by at most 32·2⁻⁵³ r / φ; at angles below √(32·2⁻⁵³) = 2⁻²⁴ any place on both is within
/// 2⁻²⁴ r of the nearest. A corner over a face with a small angle φ is the same case, its edges taking over. 2⁻²² is four times that.
const MEASURED_PAD: f64 = 1.0 / 4_194_304.0;

/// What divides instead of 0.
const LEAST: f64 = f64::MIN_POSITIVE;
/// What a corner beside a face loses against the distance of edges, for each unit by which it is outside.
const OUTSIDE: f64 = 1e60;

type Vectors<D> = [D; 3];
type Corners<D> = [Vectors<D>; 3];

/// About how far apart four pairs of triangles are, if they do not touch.
pub(super) struct Measured<T> {
    /// The squares of the distances, mm²; infinite or not a number where a coordinate is.
    squared: T,
    /// By how much the distances may be less, mm.
    pads: T,
}

impl<D: DoubleLanes> Measured<D> {
    /// Of pairs of corners in lanes.
    #[inline(always)]
    pub fn of(p: &Corners<D>, q: &Corners<D>) -> Self {
        Self { squared: squared(p, q), pads: D::all(MEASURED_PAD) * reach(p, q) }
    }

    /// A bit for each lane in which the triangles may be nearer than `least_mm`.
    #[inline(always)]
    pub fn nearer(&self, least_mm: f64) -> u8 {
        let limit = self.pads + D::all(least_mm);
        !self.squared.exceeds(limit * limit)
    }

    /// The numbers.
    #[inline(always)]
    pub fn stored(self) -> Measured<[f64; DOUBLES]> {
        Measured { squared: self.squared.stored(), pads: self.pads.stored() }
    }
}

impl Measured<[f64; DOUBLES]> {
    /// False where the triangles in a lane are surely farther apart than `least_mm`.
    pub fn may_be_nearer(&self, lane: usize, least_mm: f64) -> bool {
        let limit = self.pads[lane] + least_mm;
        let is_farther = self.squared[lane] > limit * limit;
        !is_farther
    }

    /// The nearest pair of those that have a bit in `lanes`, of which there is one at least.
    pub fn nearest_of(&self, lanes: u8) -> usize {
        let first = lanes.trailing_zeros() as usize;
        (first + 1..DOUBLES)
            .filter(|lane| lanes >> lane & 1 != 0)
            .fold(first, |nearest, lane| if self.squared[lane] < self.squared[nearest] { lane } else { nearest })
    }
}

/// Lower bounds of the distances of triangles that do not touch, mm.
#[inline(always)]
pub(super) fn at_least_mm<D: DoubleLanes>(p: &Corners<D>, q: &Corners<D>) -> [f64; DOUBLES] {
    let Measured { squared: mut bounds, pads } = Measured::of(p, q).stored();
    for (bound, pad) in bounds.iter_mut().zip(pads) {
        let distance = bound.sqrt() - pad;
        // What is not a number is no bound.
        *bound = if distance > 0.0 { distance } else { 0.0 };
    }
    bounds
}

/// How far the corners are from one another at most, summed along the axes, mm.
#[inline(always)]
fn reach<D: DoubleLanes>(p: &Corners<D>, q: &Corners<D>) -> D {
    let of_p = three!(k => size(&minus(&p[k], &p[0])));
    let of_q = three!(k => size(&minus(&q[k], &p[0])));
    of_p[1].max(of_p[2]) + of_q[0].max(of_q[1]).max(of_q[2])
}

/// The square of the distance, mm², about; infinite or not a number where a coordinate is.
#[inline(always)]
fn squared<D: DoubleLanes>(p: &Corners<D>, q: &Corners<D>) -> D {
    let [of_p, of_q] = [Edges::of(p), Edges::of(q)];
    let mut least = corners_to_face(q, p, &of_p).min(corners_to_face(p, q, &of_q));
    for (i, from_p) in p.iter().enumerate() {
        for (j, from_q) in q.iter().enumerate() {
            least = least.min(segments(from_p, &of_p, i, from_q, &of_q, j));
        }
    }
    least
}

/// The edges of a triangle: each from its corner to the next, the square of its length, and one over that.
struct Edges<D> {
    ways: Corners<D>,
    squares: Vectors<D>,
    inverses: Vectors<D>,
}

impl<D: DoubleLanes> Edges<D> {
    #[inline(always)]
    fn of(p: &Corners<D>) -> Self {
        let ways = [minus(&p[1], &p[0]), minus(&p[2], &p[1]), minus(&p[0], &p[2])];
        let squares = three!(i => dot(&ways[i], &ways[i]));
        Self { ways, squares, inverses: three!(i => D::all(1.0) / squares[i].max(D::all(LEAST))) }
    }
}

/// The squared distance of two edges, from the corners `p` and `q` on.
#[inline(always)]
fn segments<D: DoubleLanes>(p: &Vectors<D>, of_p: &Edges<D>, i: usize, q: &Vectors<D>, of_q: &Edges<D>, j: usize) -> D {
    let (u, v, r) = (&of_p.ways[i], &of_q.ways[j], minus(p, q));
    let (uu, vv, uv, ur, vr) = (of_p.squares[i], of_q.squares[j], dot(u, v), dot(u, &r), dot(v, &r));
    let s = clamped((uv * vr - ur * vv) / (uu * vv - uv * uv).max(D::all(LEAST)));
    let t = clamped((uv * s + vr) * of_q.inverses[j]);
    let s = clamped((uv * t - ur) * of_p.inverses[i]);
    let gap = three!(k => r[k] + u[k] * s - v[k] * t);
    dot(&gap, &gap)
}

/// The least squared distance of a corner of `from` that is over the face; much where none is.
#[inline(always)]
fn corners_to_face<D: DoubleLanes>(from: &Corners<D>, face: &Corners<D>, edges: &Edges<D>) -> D {
    let normal = cross(&edges.ways[0], &edges.ways[1]);
    let inward = three!(k => cross(&normal, &edges.ways[k]));
    let inverse = D::all(1.0) / dot(&normal, &normal).max(D::all(LEAST));
    let squares = three!(corner => {
        let ways = three!(k => minus(&from[corner], &face[k]));
        let height = dot(&normal, &ways[0]);
        let inside = dot(&inward[0], &ways[0]).min(dot(&inward[1], &ways[1])).min(dot(&inward[2], &ways[2]));
        height * height * inverse + (D::all(0.0) - inside).max(D::all(0.0)) * D::all(OUTSIDE)
    });
    squares[0].min(squares[1]).min(squares[2])
}

/// The nearest number from 0 to 1.
#[inline(always)]
fn clamped<D: DoubleLanes>(x: D) -> D {
    x.max(D::all(0.0)).min(D::all(1.0))
}

#[inline(always)]
pub(super) fn minus<D: DoubleLanes>(x: &Vectors<D>, y: &Vectors<D>) -> Vectors<D> {
    [x[0] - y[0], x[1] - y[1], x[2] - y[2]]
}

#[inline(always)]
fn dot<D: DoubleLanes>(x: &Vectors<D>, y: &Vectors<D>) -> D {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

#[inline(always)]
fn cross<D: DoubleLanes>(x: &Vectors<D>, y: &Vectors<D>) -> Vectors<D> {
    [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
}

/// The sum of the absolute values.
#[inline(always)]
fn size<D: DoubleLanes>(x: &Vectors<D>) -> D {
    x[0].abs() + x[1].abs() + x[2].abs()
}

#[cfg(test)]
mod tests {
    use super::super::lanes::{Machine, Simd, Work};
    use super::*;
    use crate::engine::geometry::cross_check::needles;
    use crate::engine::geometry::{Point, Triangle, exact, triangle_distance};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Two triangles in all lanes: the squared distance, by how much the distance may be less, and whether they may be nearer than a distance.
    struct Measuring<'a>([&'a Triangle; 2], f64);

    impl Work for Measuring<'_> {
        type Output = (f64, f64, bool);

        #[inline(always)]
        fn run<M: Machine>(self) -> Self::Output {
            let lanes = |t: &Triangle| three!(i => three!(k => M::Double::load(&[t.corners[i][k]; DOUBLES])));
            let measured = Measured::of(&lanes(self.0[0]), &lanes(self.0[1]));
            let nearer = measured.nearer(self.1);
            let stored = measured.stored();
            assert_eq!(nearer & 0b1111, if stored.may_be_nearer(3, self.1) { 0b1111 } else { 0 });
            (stored.squared[1], stored.pads[1], nearer & 1 != 0)
        }
    }

    #[test]
    fn of_pairs_that_may_be_nearer_the_nearest_is_first() {
        let measured = Measured { squared: [9.0, 4.0, f64::NAN, 25.0], pads: [0.0, 0.5, 0.0, 2.0] };
        assert_eq!([0b1111, 0b1001, 0b1000, 0b0011].map(|lanes| measured.nearest_of(lanes)), [1, 0, 3, 1]);
        // A pair may be nearer than what it measures by its pad; one that is not a number may be as near as any.
        let nearer = |least_mm: f64| [0, 1, 2, 3].map(|lane| measured.may_be_nearer(lane, least_mm));
        assert_eq!(nearer(3.0), [true, true, true, true]);
        assert_eq!(nearer(2.99), [false, true, true, false]);
        assert_eq!(nearer(1.5), [false, true, true, false]);
        assert_eq!(nearer(1.49), [false, false, true, false]);
    }

    /// Random triangles, and such with an edge nearly along an edge of the other.
    fn pair(random: &mut Pcg64, round: u32) -> [Triangle; 2] {
        let mut coordinate = || 2.0 * random.random::<f64>() - 1.0;
        let mut point = |size: f64| Point::from([(); 3].map(|()| size * coordinate()));
        let a = Triangle { corners: [point(9.0), point(9.0), point(9.0)] };
        let off = point(1.0).coords * 10f64.powi(-((round % 12) as i32));
        let beside = a.corners.map(|p| p + off + point(10f64.powi(-((round % 10) as i32))).coords);
        let b = if round.is_multiple_of(2) { beside } else { [point(9.0), point(9.0), point(9.0)] };
        [a, Triangle { corners: b }]
    }

    /// Of needles, of triangles nearly in one place, and of any others: never more than the true distance by the pad, often by some of it, and about right
    /// for most.
    #[test]
    fn what_is_measured_is_at_most_the_pad_above_the_distance() {
        let mut random = Pcg64::seed_from_u64(41);
        let (mut apart, mut close, mut above) = (0, 0, 0);
        for round in 0..60_000 {
            let [a, b] = if round % 3 == 0 { needles(&mut random) } else { pair(&mut random, round) };
            if exact::touch(&a, &b) {
                continue;
            }
            apart += 1;
            let truth = triangle_distance::squared(&a, &b).sqrt();
            // The pad goes with the ways from corner to corner.
            let ways = a.corners.iter().flat_map(|p| b.corners.iter().chain(&a.corners).map(move |q| (p - q).norm()));
            let across = a.corners.iter().flat_map(|p| b.corners.iter().map(move |q| (p - q).norm()));
            let (longest, longest_across) = (ways.fold(0.0, f64::max), across.fold(0.0, f64::max));
            for simd in Simd::available() {
                let (squared, pad, may_be_nearer) = simd.run(Measuring([&a, &b], truth));
                let found = squared.sqrt();
                assert!(may_be_nearer && found <= truth + pad, "{found} for {truth}, {pad}: {a:?} {b:?}");
                assert!((MEASURED_PAD * longest_across..4.0 * MEASURED_PAD * longest).contains(&pad), "{pad}");
                if found >= truth * (1.0 - 1e-6) && truth > 10.0 * pad {
                    assert!(!simd.run(Measuring([&a, &b], 0.9 * truth - 2.0 * pad)).2);
                }
                close += u32::from(found >= truth * (1.0 - 1e-6));
                above += u32::from(found > truth);
            }
        }
        let sets = Simd::available().len() as u32;
        assert!(apart > 20_000 && close > apart * sets / 10 * 9, "{close} of {apart}, {sets} times");
        // Without a pad some pairs would be passed over.
        assert!(above > 100, "{above}");
    }
}
