//! Distance between two disjoint triangles: the least over the 15 pairs of features, 9 edge-edge and 6 corner-face (Ericson 2005, sections
//! 5.1.9 and 5.1.10). Not exact, but right within [`ACCURACY`] of the largest distance between two corners, also for needles.
//!
//! Two differences of products lose digits on needles: the normal of a triangle with nearly parallel edges, and the determinant of two
//! nearly parallel edges. When the sine of the angle is below 1e-4 (`NEARLY_PARALLEL`), both are computed in another way; above it, at most
//! four digits are lost.

use super::{Point, Triangle, Vector};

/// Square of the distance, mm². The triangles must be disjoint: for triangles that pierce each other the result is positive.
#[must_use]
pub fn squared(a: &Triangle, b: &Triangle) -> f64 {
    let mut least = corners_to_face(a, b).min(corners_to_face(b, a));
    for i in 0..3 {
        let (p, u) = (&a.corners[i], a.corners[(i + 1) % 3] - a.corners[i]);
        for j in 0..3 {
            least = least.min(segments_squared(p, &u, &b.corners[j], &(b.corners[(j + 1) % 3] - b.corners[j])));
        }
    }
    least
}

/// Square of the sine of the angle below which two edges count as nearly parallel.
const NEARLY_PARALLEL: f64 = 1e-8;

/// Error of [`squared`]'s root, relative to how far the corners are from one another. Rounding misplaces where two edges are nearest by 32·2⁻⁵³ r / φ²
/// along them (φ their angle, r that distance), which lengthens the distance by 32·2⁻⁵³ r / φ, at the smallest angle that does not count as nearly
/// parallel, 10⁻⁴, by 3.6·10⁻¹¹ r; `scripts/prove` has the rest. Needles, the worst there are in the tests, are off by less than 10⁻¹² r.
pub const ACCURACY: f64 = 4e-11;

/// Relative margin of [`exceeds`]: far above the rounding error of the squares it compares (a few 2⁻⁵³), and small enough to exclude nearly
/// all pairs that can be excluded.
const MARGIN: f64 = 1e-8;

/// Rounding error of a gap in [`exceeds`], relative to the direction's largest component times the farthest corner's distance along the
/// axes: 16u, u = 2⁻⁵³. Each term of a projection has a difference, a product and two sums, so the projection has an error below 4.1u of
/// the sum of its terms' magnitudes. A gap is the difference of two projections, rounded once more.
pub(crate) const PROJECTION: f64 = 16.0 / 9_007_199_254_740_992.0;

/// Whether the squared distance certainly exceeds `squared_mm`; much cheaper than [`squared`]. Tests three directions that separate most
/// distant triangles: from one middle to the other, and the two normals.
#[must_use]
pub fn exceeds(a: &Triangle, b: &Triangle, squared_mm: f64) -> bool {
    let from = |t: &Triangle| t.corners.each_ref().map(|p| p - a.corners[0]);
    let (of_a, of_b) = (from(a), from(b));
    // Summed along the axes, which bounds the magnitudes of all terms of a projection together with the direction's largest component.
    let reach = of_a.iter().chain(&of_b).fold(0.0, |reach: f64, v| reach.max(v.x.abs() + v.y.abs() + v.z.abs()));
    let apart = |direction: &Vector| {
        let along = |corners: &[Vector; 3]| corners.each_ref().map(|v| direction.dot(v));
        let ([p, q, r], [u, v, w]) = (along(&of_a), along(&of_b));
        let (low_a, high_a) = (p.min(q).min(r), p.max(q).max(r));
        let (low_b, high_b) = (u.min(v).min(w), u.max(v).max(w));
        let gap = (low_b - high_a).max(low_a - high_b) - PROJECTION * direction.amax() * reach;
        gap > 0.0 && gap * gap > squared_mm * direction.norm_squared() * (1.0 + MARGIN)
    };
    apart(&(b.centroid() - a.centroid())) || apart(&a.double_area_normal()) || apart(&b.double_area_normal())
}

/// Least squared distance from a corner of `from` that projects to the interior of `face`; infinite when none does, because the nearest
/// point of `face` is then on an edge, which another pair of features covers.
#[inline]
fn corners_to_face(from: &Triangle, face: &Triangle) -> f64 {
    let [a, b, c] = &face.corners;
    let normal = normal(&(b - a), &(c - a));
    let inward = [normal.cross(&(b - a)), normal.cross(&(c - b)), normal.cross(&(a - c))];
    let length_squared = normal.norm_squared();
    let mut least = f64::INFINITY;
    for p in &from.corners {
        let height = normal.dot(&(p - a));
        let squared = height * height / length_squared;
        // A face without area has no inside: `squared` is NaN or infinite and loses every comparison.
        if squared < least
            && inward[0].dot(&(p - a)) >= 0.0
            && inward[1].dot(&(p - b)) >= 0.0
            && inward[2].dot(&(p - c)) >= 0.0
        {
            least = squared;
        }
    }
    least
}

/// The cross product, accurate to the last digits of each component even for nearly parallel vectors.
#[inline]
pub(crate) fn normal(u: &Vector, v: &Vector) -> Vector {
    let plain = u.cross(v);
    if plain.norm_squared() >= NEARLY_PARALLEL * u.norm_squared() * v.norm_squared() {
        plain
    } else {
        careful_cross(u, v)
    }
}

/// The cross product with every difference of products rounded as if once (W. Kahan's algorithm).
#[cold]
fn careful_cross(u: &Vector, v: &Vector) -> Vector {
    // `rest` is what the rounding of the second product takes away.
    let difference = |a: f64, b: f64, c: f64, d: f64| {
        let product = c * d;
        let rest = (-c).mul_add(d, product);
        a.mul_add(b, -product) + rest
    };
    Vector::new(difference(u.y, v.z, u.z, v.y), difference(u.z, v.x, u.x, v.z), difference(u.x, v.y, u.y, v.x))
}

/// Squared distance of a point from a triangle, mm².
#[must_use]
pub fn point_squared(p: &Point, face: &Triangle) -> f64 {
    let [a, b, c] = &face.corners;
    let edges = [(a, b), (b, c), (c, a)].map(|(q, r)| segments_squared(p, &Vector::zeros(), q, &(r - q)));
    edges.into_iter().fold(corners_to_face(&Triangle::new(*p, *p, *p), face), f64::min)
}

/// Squared distance of the segments p + s u and q + t v, s and t in [0, 1]; either may be a point.
#[inline]
fn segments_squared(p: &Point, u: &Vector, q: &Point, v: &Vector) -> f64 {
    let r = p - q;
    let (uu, uv, vv, ur, vr) = (u.norm_squared(), u.dot(v), v.norm_squared(), u.dot(&r), v.dot(&r));
    let denominator = uu * vv - uv * uv;
    let s = if denominator > NEARLY_PARALLEL * uu * vv {
        ((uv * vr - ur * vv) / denominator).clamp(0.0, 1.0)
    } else if uu * vv > 0.0 {
        nearly_parallel(u, v, &r)
    } else {
        0.0
    };
    let clamped = |numerator: f64, length: f64| if length > 0.0 { (numerator / length).clamp(0.0, 1.0) } else { 0.0 };
    let t = clamped(uv * s + vr, vv);
    let s = clamped(uv * t - ur, uu);
    (r + u * s - v * t).norm_squared()
}

/// The position on the first of two nearly parallel segments that is nearest to the line of the second, as in [`segments_squared`].
///
/// With u the rounding unit, L a length and θ the angle, the cross products have an error of uL², so the position has an error of uL / sin
/// θ along the segment. The distance changes by that times sin θ, which is uL again.
fn nearly_parallel(u: &Vector, v: &Vector, r: &Vector) -> f64 {
    let normal = u.cross(v);
    let denominator = normal.norm_squared();
    // Parallel: any s will do.
    if denominator > 0.0 { (v.cross(r).dot(&normal) / denominator).clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn triangle(corners: [[f64; 3]; 3]) -> Triangle {
        Triangle { corners: corners.map(Point::from) }
    }

    #[test]
    fn distances_known_by_hand() {
        let floor = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        for (name, other, distance) in [
            ("corner above face", [[1.0, 1.0, 3.0], [1.0, 1.0, 9.0], [2.0, 2.0, 9.0]], 3.0),
            ("corner beside edge", [[3.0, 3.0, 0.0], [9.0, 9.0, 0.0], [9.0, 9.0, 1.0]], 2f64.sqrt()),
            ("corner from corner", [[7.0, -4.0, 0.0], [9.0, -9.0, 0.0], [9.0, -9.0, 1.0]], 5.0),
            ("edge across edge", [[2.0, -5.0, 5.0], [2.0, 0.0, 2.0], [2.0, 5.0, 5.0]], 2.0),
            ("edge over edge", [[-1.0, -1.0, 1.0], [-1.0, 5.0, 1.0], [-3.0, 1.0, 9.0]], 2f64.sqrt()),
            ("parallel faces", [[1.0, 1.0, 2.0], [2.0, 1.0, 2.0], [1.0, 2.0, 2.0]], 2.0),
            ("a point", [[1.0, 1.0, -2.0]; 3], 2.0),
            ("a point beside", [[7.0, -4.0, 0.0]; 3], 5.0),
            ("a segment", [[-3.0, 0.0, 4.0], [-3.0, 1.0, 4.0], [-3.0, 2.0, 4.0]], 5.0),
        ] {
            let (a, b) = (triangle(floor), triangle(other));
            assert!((squared(&a, &b).sqrt() - distance).abs() < 1e-12, "{name}");
            assert!((squared(&b, &a).sqrt() - distance).abs() < 1e-12, "{name}, swapped");
            if other[0] == other[1] {
                assert!((point_squared(&b.corners[0], &a).sqrt() - distance).abs() < 1e-12, "{name}, as a point");
            }
        }
    }

    #[test]
    fn parallel_faces_exceed_all_that_is_less_than_their_distance() {
        let floor = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let above = triangle([[3.0, 1.0, 2.0], [5.0, 1.0, 2.0], [3.0, 2.0, 2.0]]);
        assert!(exceeds(&floor, &above, 3.999) && exceeds(&above, &floor, 3.999));
        assert!(!exceeds(&floor, &above, 4.0) && !exceeds(&above, &floor, 4.0));
        // Degenerate ones have no normal; what is left is the line between the middles.
        let point = triangle([[0.0, 0.0, 9.0]; 3]);
        assert!(exceeds(&floor, &point, 20.0) && !exceeds(&floor, &point, 81.0) && !exceeds(&point, &point, 0.0));
    }

    /// A number with twice the digits of `f64`: the sum of two `f64`, the second at most half a unit in the last place of the first.
    #[derive(Clone, Copy)]
    struct Double(f64, f64);

    impl Double {
        fn sum(a: f64, b: f64) -> Self {
            let s = a + b;
            let t = s - a;
            Self(s, (a - (s - t)) + (b - t))
        }
        fn plus(self, other: Self) -> Self {
            let (s, t) = (Self::sum(self.0, other.0), Self::sum(self.1, other.1));
            let u = Self::sum(s.0, s.1 + t.0);
            Self::sum(u.0, u.1 + t.1)
        }
        fn minus(self, other: Self) -> Self {
            self.plus(Self(-other.0, -other.1))
        }
        fn times(self, other: Self) -> Self {
            let p = self.0 * other.0;
            let e = self.0.mul_add(other.0, -p);
            Self::sum(p, e + (self.0 * other.1 + self.1 * other.0))
        }
        fn over(self, other: Self) -> Self {
            let one = self.0 / other.0;
            let rest = self.minus(other.times(Self(one, 0.0)));
            let two = rest.0 / other.0;
            let rest = rest.minus(other.times(Self(two, 0.0)));
            Self::sum(one, two).plus(Self(rest.0 / other.0, 0.0))
        }
        fn clamped(self) -> Self {
            if self.0 < 0.0 || self.0.is_nan() {
                Self(0.0, 0.0)
            } else if self.0 >= 1.0 {
                Self(1.0, 0.0)
            } else {
                self
            }
        }
    }

    type Doubles = [Double; 3];

    fn difference(p: &Point, q: &Point) -> Doubles {
        std::array::from_fn(|i| Double::sum(p[i], -q[i]))
    }

    fn dot(p: &Doubles, q: &Doubles) -> Double {
        p[0].times(q[0]).plus(p[1].times(q[1])).plus(p[2].times(q[2]))
    }

    fn cross(p: &Doubles, q: &Doubles) -> Doubles {
        std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            p[j].times(q[k]).minus(p[k].times(q[j]))
        })
    }

    /// The distance between two disjoint triangles, mm, in twice the digits: over corner-face and edge-edge pairs.
    fn reference_mm(a: &Triangle, b: &Triangle) -> f64 {
        let mut least = f64::INFINITY;
        for (face, from) in [(a, b), (b, a)] {
            let [p, q, r] = &face.corners;
            let normal = cross(&difference(q, p), &difference(r, p));
            let length = dot(&normal, &normal);
            for corner in &from.corners {
                let inside = [(p, q), (q, r), (r, p)]
                    .into_iter()
                    .all(|(u, v)| dot(&cross(&normal, &difference(v, u)), &difference(corner, u)).0 >= 0.0);
                let height = dot(&normal, &difference(corner, p));
                if inside && length.0 > 0.0 {
                    least = least.min(height.times(height).over(length).0);
                }
            }
        }
        for i in 0..3 {
            for j in 0..3 {
                let (p, q) = (&a.corners[i], &b.corners[j]);
                let (u, v) = (difference(&a.corners[(i + 1) % 3], p), difference(&b.corners[(j + 1) % 3], q));
                let (w, n) = (difference(q, p), cross(&u, &v));
                let (uu, vv, uv, area) = (dot(&u, &u), dot(&v, &v), dot(&u, &v), dot(&n, &n));
                let (uw, vw) = (dot(&u, &w), dot(&v, &w));
                // The nearest points of the lines, and of each segment to either end of the other.
                let s = dot(&cross(&w, &v), &n).over(area).clamped();
                let t = uv.times(s).minus(vw).over(vv).clamped();
                let (zero, one) = (Double(0.0, 0.0), Double(1.0, 0.0));
                let of_t = |t: Double| uv.times(t).plus(uw).over(uu).clamped();
                let of_s = |s: Double| uv.times(s).minus(vw).over(vv).clamped();
                for (s, t) in [(of_t(t), t), (of_t(zero), zero), (of_t(one), one), (zero, of_s(zero)), (one, of_s(one))]
                {
                    let gap: Doubles = std::array::from_fn(|k| w[k].plus(v[k].times(t)).minus(u[k].times(s)));
                    least = least.min(dot(&gap, &gap).0);
                }
            }
        }
        least.sqrt()
    }

    /// Needles and their neighbours: the distance is accurate to the rounding of the corners' distances, and [`exceeds`] is never true for
    /// a larger value.
    #[test]
    fn needles_are_measured_as_well_as_any_triangle() {
        use crate::engine::geometry::cross_check::needles;
        use rand::SeedableRng;
        let mut random = rand_pcg::Pcg64::seed_from_u64(31);
        let (mut apart, mut claims) = (0, 0);
        for _ in 0..30_000 {
            let [a, b] = needles(&mut random);
            let touching = crate::engine::geometry::exact::touch(&a, &b);
            let truth = if touching { 0.0 } else { reference_mm(&a, &b) };
            let reach = b.corners.iter().chain(&a.corners).map(|p| (p - a.corners[0]).norm()).fold(0.0, f64::max);
            if !touching {
                apart += 1;
                let found = squared(&a, &b).sqrt();
                // A fortieth of `ACCURACY`, for which the least distances would have to meet the smallest angles.
                assert!(
                    (found - truth).abs() <= ACCURACY / 40.0 * reach,
                    "{found} for {truth} at {reach}: {a:?} {b:?}"
                );
                claims += u32::from(exceeds(&a, &b, (0.5 * truth).powi(2)));
            }
            for limit in [0.0, 1e-12, 1e-9, truth, truth * (1.0 + 1e-9)] {
                assert!(limit < truth || !exceeds(&a, &b, limit * limit), "more than {limit}, is {truth}: {a:?} {b:?}");
            }
        }
        assert!(apart > 5_000 && claims > 2_000, "{claims} of {apart}");
    }

    proptest! {
        #[test]
        fn no_two_points_of_the_triangles_are_nearer(
            a in prop::array::uniform3(prop::array::uniform3(-5.0..5.0f64)),
            b in prop::array::uniform3(prop::array::uniform3(-5.0..5.0f64)),
            shift in 0.0..20.0f64,
        ) {
            let a = triangle(a);
            let b = triangle(b).map(|p| p + Vector::x() * shift);
            let distance = squared(&a, &b).sqrt();
            if !crate::engine::geometry::exact::touch(&a, &b) {
                for part in [0.5, 0.9, 1.0, 1.1] {
                    prop_assert!(part < 1.0 || !exceeds(&a, &b, (part * distance).powi(2)), "{part} of {distance}");
                }
            }
            let n = 24;
            let points = |t: &Triangle| -> Vec<Point> {
                let [p, q, r] = t.corners;
                (0..=n).flat_map(|i| (0..=n - i).map(move |j| (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n))))
                    .map(|(u, v)| p + (q - p) * u + (r - p) * v)
                    .collect()
            };
            let (in_a, in_b) = (points(&a), points(&b));
            let sampled = in_a.iter().flat_map(|p| in_b.iter().map(move |q| (p - q).norm())).fold(f64::INFINITY, f64::min);
            if !crate::engine::geometry::exact::touch(&a, &b) {
                prop_assert!(distance <= sampled + 1e-9, "{distance} {sampled}");
                // Edges are at most 17.4 mm long, so some sample is within 17.4/24 mm of each nearest point.
                prop_assert!(sampled <= distance + 2.0, "{distance} {sampled}");
            }
        }
    }
}
