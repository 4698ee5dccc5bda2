//! How far the points of two crossing triangles may move before these can part.
//!
//! An edge of one triangle that goes through the inside of the other, once, does so after any continuous motion during which no end of the edge meets the
//! triangle and no point of the edge meets the triangle's border: the number of crossings modulo 2 is the same at its start and end (M. W. Hirsch,
//! *Differential Topology*, 1976, chapter 5, intersection numbers modulo 2). If each point of both goes straight, and together they go less than the ends are
//! from the triangle's plane, and less than the lines through the edge and through each side of the triangle are apart, neither can happen. Triangles
//! may change their shape on the way, as rounding makes them.

use super::{Triangle, Vector};

/// How far points may go, mm, before the triangles can part; if both move, their ways are added. 0 where no edge surely goes through the other triangle.
#[must_use]
pub fn crossing_mm(a: &Triangle, b: &Triangle) -> f64 {
    let extent = extent_mm(a, b);
    edge_through_mm(a, b, extent).max(edge_through_mm(b, a, extent))
}

/// Error of a determinant of coordinate differences, relative to the third power of the largest; of a cross product, to the second power.
const PAD: f64 = 32.0 / 9_007_199_254_740_992.0;

/// No distance of two corners is larger, mm.
fn extent_mm(a: &Triangle, b: &Triangle) -> f64 {
    let corners = || a.corners.iter().chain(&b.corners);
    let of = |k: usize| {
        let (low, high) = corners().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])));
        high - low
    };
    of(0) + of(1) + of(2)
}

/// How far points may go, mm, while some edge of one triangle still goes through the other: the largest over its edges.
fn edge_through_mm(edges: &Triangle, other: &Triangle, extent: f64) -> f64 {
    let (pad2, pad3) = (PAD * extent * extent, PAD * extent * extent * extent);
    // A lower bound of |product| / |normal|.
    let apart = |product: f64, normal: &Vector| (product - pad3) / (normal.norm() + pad2);
    let [p, q, r] = &other.corners;
    let sides = [q - p, r - q, p - r];
    let normal = (q - p).cross(&(r - p));
    let heights = edges.corners.map(|corner| (corner - p).dot(&normal));
    let mut best = 0.0_f64;
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        if heights[from] * heights[to] >= 0.0 {
            continue;
        }
        let mut least = apart(heights[from].abs().min(heights[to].abs()), &normal);
        let (start, along) = (&edges.corners[from], edges.corners[to] - edges.corners[from]);
        for (corner, side) in other.corners.iter().zip(&sides) {
            // Of one sign where the line goes through the inside.
            let normal = side.cross(&along);
            let product = (start - corner).dot(&normal) * heights[from].signum();
            least = least.min(apart(product, &normal));
        }
        best = best.max(least);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::super::Point;
    use super::super::certified::touch;
    use super::*;
    use proptest::prelude::*;

    fn triangle(corners: [[f64; 3]; 3]) -> Triangle {
        let [a, b, c] = corners.map(Point::from);
        Triangle::new(a, b, c)
    }

    /// An edge along z through the point (1, 1) of a right triangle in the plane z = 0: 1 from the sides along the axes, and (6 - 1 - 1)/√2 from the third.
    #[test]
    fn an_edge_goes_through_the_middle_of_a_triangle() {
        let flat = triangle([[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]]);
        for (low, high, expected) in
            [(-5.0, 5.0, 1.0), (-0.5, 5.0, 0.5), (-5.0, 0.25, 0.25), (1.0, 5.0, 0.0), (0.0, 5.0, 0.0)]
        {
            let upright = triangle([[1.0, 1.0, low], [1.0, 1.0, high], [1.0, 40.0, high]]);
            for (a, b) in [(&flat, &upright), (&upright, &flat)] {
                assert!((crossing_mm(a, b) - expected).abs() < 1e-9, "{low} {high}: {}", crossing_mm(a, b));
            }
        }
        // Through no side, beside the triangle, and without an inside.
        let beside = triangle([[4.0, 4.0, -5.0], [4.0, 4.0, 5.0], [4.0, 40.0, 5.0]]);
        assert_eq!(crossing_mm(&flat, &beside), 0.0);
        let segment = triangle([[0.0, 0.0, 0.0], [6.0, 6.0, 0.0], [3.0, 3.0, 0.0]]);
        assert_eq!(crossing_mm(&segment, &triangle([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 1.0, 0.0]])), 0.0);
        assert_eq!(crossing_mm(&flat, &flat), 0.0);
    }

    /// A triangle with sides of 1000 and an edge of 2000 mm, which extend over 4000 mm: determinants of 2·10⁶ less 2⁻⁴⁸·4000³ are divided by products of 2·10⁶
    /// and 2⁻⁴⁸·4000² more.
    #[test]
    fn errors_of_products_are_taken_off() {
        let flat = triangle([[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0], [0.0, 1000.0, 0.0]]);
        let edge = triangle([[1.0, 1.0, -1000.0], [1.0, 1.0, 1000.0], [1.0, 1.0, 1000.0]]);
        let u = 0.5_f64.powi(48);
        let expected = (2e6 - u * 4e3 * 4e3 * 4e3) / (2e6 + u * 4e3 * 4e3);
        let found = crossing_mm(&flat, &edge);
        assert!((found - expected).abs() < 3e-15 && found < 1.0 - 1e-10, "{found} {expected}");
    }

    /// Ranges of 6 + 2, 5 and 7 mm.
    #[test]
    fn the_extent_is_the_sum_of_the_ranges() {
        let (a, b) =
            ([[1.0, 2.0, 3.0], [-2.0, 2.0, 3.0], [1.0, 7.0, 3.0]], [[6.0, 4.0, 0.0], [0.0, 4.0, 7.0], [0.0, 4.0, 3.0]]);
        assert_eq!(extent_mm(&triangle(a), &triangle(b)), 8.0 + 5.0 + 7.0);
    }

    /// An edge that goes through a triangle so near to its side that rounding might have put it there gives no room.
    #[test]
    fn what_rounding_could_make_gives_no_room() {
        let flat = triangle([[0.0, 0.0, 0.0], [64.0, 0.0, 0.0], [0.0, 64.0, 0.0]]);
        let at = |y: f64| crossing_mm(&flat, &triangle([[9.0, y, -32.0], [9.0, y, 32.0], [9.0, -64.0, 32.0]]));
        // Half of the pad over the length of the side and of the edge, and twice as much.
        let extent = 64.0 + 128.0 + 64.0;
        let pad = PAD * extent * extent * extent / (64.0 * 64.0);
        assert_eq!((at(0.0), at(0.5 * pad)), (0.0, 0.0));
        assert!(at(2.0 * pad) > 0.9 * pad && at(2.0 * pad) < 1.1 * pad, "{} {pad}", at(2.0 * pad));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        /// Triangles touch after any motion of their corners that is shorter, in the worst direction each; and a bit farther some no longer do.
        #[test]
        fn triangles_touch_as_long_as_is_said(
            corners in prop::array::uniform6(prop::array::uniform3(-8.0..8.0_f64)),
            moves in prop::array::uniform6(prop::array::uniform3(-1.0..1.0_f64)),
            share in 0.0..1.0_f64,
        ) {
            let [a, b, c, d, e, f] = corners;
            let (one, other) = (triangle([a, b, c]), triangle([d, e, f]));
            let room = crossing_mm(&one, &other);
            if room > 0.0 {
                prop_assert!(touch(&one, &other));
                // The corners of one triangle by a share of the room, those of the other by the rest.
                let moved = |triangle: &Triangle, moves: &[[f64; 3]], by: f64| {
                    let mut corners = triangle.corners;
                    for (corner, way) in corners.iter_mut().zip(moves) {
                        *corner += Vector::from(*way).normalize() * by * (1.0 - 1e-12);
                    }
                    let [a, b, c] = corners;
                    Triangle::new(a, b, c)
                };
                prop_assert!(touch(&moved(&one, &moves[..3], room * share), &moved(&other, &moves[3..], room * (1.0 - share))));
            }
        }
    }

    /// The bound is reached: where an edge is moved as a whole towards the nearest side of the triangle, the triangles part just beyond it.
    #[test]
    fn beyond_the_room_triangles_part() {
        let flat = triangle([[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]]);
        let upright = |x: f64| triangle([[x, 1.0, -5.0], [x, 1.0, 5.0], [x - 40.0, 1.0, 5.0]]);
        let room = crossing_mm(&flat, &upright(0.75));
        assert!((room - 0.75).abs() < 1e-9);
        assert!(touch(&flat, &upright(0.75 - room + 1e-9)) && !touch(&flat, &upright(0.75 - room - 1e-6)));
    }
}
