//! Distance between two triangles that do not touch: the least over the 15 pairs of features, 9 edge-edge and 6
//! corner-face (Ericson 2005, sections 5.1.9 and 5.1.10). Accurate to rounding, not exact.

use super::{Point, Triangle, Vector};

/// Square of the distance, mm². For triangles that pierce each other it is positive: ask that first.
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

/// Relative margin of [`exceeds`]: far above the rounding of its projections (a few 2⁻⁵³ of the corners' distances, which at
/// machine size are up to a million times the limit), far below what would keep it from excluding.
const MARGIN: f64 = 1e-8;

/// Whether the square of the distance is for sure more than `squared_mm`; much sooner known than [`squared`]. Looks along three
/// directions in which most triangles that are far apart show it: from one's middle to the other's, and the two normals.
#[must_use]
pub fn exceeds(a: &Triangle, b: &Triangle, squared_mm: f64) -> bool {
    let apart = |direction: &Vector| {
        let along = |t: &Triangle| t.corners.each_ref().map(|p| direction.dot(&(p - a.corners[0])));
        let ([p, q, r], [u, v, w]) = (along(a), along(b));
        let (low_a, high_a) = (p.min(q).min(r), p.max(q).max(r));
        let (low_b, high_b) = (u.min(v).min(w), u.max(v).max(w));
        let gap = (low_b - high_a).max(low_a - high_b);
        gap > 0.0 && gap * gap > squared_mm * direction.norm_squared() * (1.0 + MARGIN)
    };
    apart(&(b.centroid() - a.centroid())) || apart(&a.double_area_normal()) || apart(&b.double_area_normal())
}

/// Least squared distance from a corner of `from` that projects into the inside of `face`; infinite when none does (its
/// nearest point is on an edge then, which another pair of features covers).
#[inline]
fn corners_to_face(from: &Triangle, face: &Triangle) -> f64 {
    let [a, b, c] = &face.corners;
    let normal = (b - a).cross(&(c - a));
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
    // Parallel: any s will do.
    let s = if denominator > 0.0 { ((uv * vr - ur * vv) / denominator).clamp(0.0, 1.0) } else { 0.0 };
    let clamped = |numerator: f64, length: f64| if length > 0.0 { (numerator / length).clamp(0.0, 1.0) } else { 0.0 };
    let t = clamped(uv * s + vr, vv);
    let s = clamped(uv * t - ur, uu);
    (r + u * s - v * t).norm_squared()
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
            if !crate::geometry::exact::touch(&a, &b) {
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
            if !crate::geometry::exact::touch(&a, &b) {
                prop_assert!(distance <= sampled + 1e-9, "{distance} {sampled}");
                // Edges are at most 17.4 mm long, so some sample is within 17.4/24 mm of each nearest point.
                prop_assert!(sampled <= distance + 2.0, "{distance} {sampled}");
            }
        }
    }
}
