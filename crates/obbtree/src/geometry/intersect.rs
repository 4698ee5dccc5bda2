//! The fast triangle test that all methods share at the leaves.
//!
//! Guigue and Devillers 2003: each triangle's corners are put on a side of the other's plane, which settles most pairs;
//! otherwise both triangles cut the line common to the two planes in an interval, and two more determinants tell whether
//! the intervals overlap. Written out here in plain `f64` and without a tolerance: it is not exact. Within rounding of
//! first contact (about 1e-13 mm at 100 mm) it may say either; [`super::exact`] decides. Closed: touching counts.
//!
//! Deviations: pairs whose coordinate intervals do not overlap are apart, exactly and most cheaply, so that discarding such
//! pairs beforehand changes no answer; and pairs that rounding cannot tell from coplanar, and triangles without area, go to [`super::exact`].

use super::{Point, Triangle, Vector, exact};

/// Whether the triangles, mm, share a point, as far as `f64` determinants can tell. Unspecified when a
/// coordinate is not finite.
#[inline]
#[must_use]
pub fn touch(a: &Triangle, b: &Triangle) -> bool {
    exact::bounds_overlap(a, b) && touch_in_bounds(a, b)
}

/// The same for triangles whose coordinate intervals overlap.
fn touch_in_bounds(a: &Triangle, b: &Triangle) -> bool {
    let b_heights = heights(a, b);
    if on_one_side(b_heights) {
        return false;
    }
    let a_heights = heights(b, a);
    if on_one_side(a_heights) {
        return false;
    }
    intervals_overlap(a, a_heights, b, b_heights)
}

/// How far the corners of `other` are above the plane of `triangle`, each times twice its area. Corner by corner: the closure of
/// `[T; 3]::map` is called, not inlined.
#[inline(always)]
fn heights(triangle: &Triangle, other: &Triangle) -> [f64; 3] {
    let ([a, b, c], [p, q, r]) = (&triangle.corners, &other.corners);
    let normal = (b - a).cross(&(c - a));
    [normal.dot(&(p - a)), normal.dot(&(q - a)), normal.dot(&(r - a))]
}

/// Whether all three are positive or all three negative.
#[inline(always)]
fn on_one_side([x, y, z]: [f64; 3]) -> bool {
    (x > 0.0 && y > 0.0 && z > 0.0) || (x < 0.0 && y < 0.0 && z < 0.0)
}

/// Whether the intervals overlap that the triangles cut from the line common to their planes; neither triangle is
/// strictly on one side of the other.
fn intervals_overlap(a: &Triangle, a_heights: [f64; 3], b: &Triangle, b_heights: [f64; 3]) -> bool {
    let (Some((apex_a, a_above)), Some((apex_b, b_above))) = (apex(a_heights), apex(b_heights)) else {
        return exact::touch(a, b);
    };
    let from = |t: &Triangle, i: usize| [t.corners[i], t.corners[(i + 1) % 3], t.corners[(i + 2) % 3]];
    let [a0, mut a1, mut a2] = from(a, apex_a);
    let [b0, mut b1, mut b2] = from(b, apex_b);
    // Turning a triangle over turns its plane over: afterwards both apexes are above the other's plane, and both
    // intervals run the same way: from the edge (0, 1) to the edge (0, 2) for b, the other way for a.
    if !a_above {
        std::mem::swap(&mut b1, &mut b2);
    }
    if !b_above {
        std::mem::swap(&mut a1, &mut a2);
    }
    volume(&a0, &a1, &b0, &b1) <= 0.0 && volume(&a0, &a2, &b0, &b2) >= 0.0
}

/// The corner that the other plane parts from the other two, and whether it is above that plane. A corner on the plane
/// counts to the side that leaves one corner alone. `None` when all three are on the plane (or not comparable).
#[inline]
fn apex(heights: [f64; 3]) -> Option<(usize, bool)> {
    let only = |holds: fn(f64) -> bool| match heights.map(holds) {
        [true, false, false] => Some(0),
        [false, true, false] => Some(1),
        [false, false, true] => Some(2),
        _ => None,
    };
    only(|h| h > 0.0)
        .map(|i| (i, true))
        .or_else(|| only(|h| h < 0.0).map(|i| (i, false)))
        // Two corners on one side and one on the plane: the latter is the apex, on the side away from the two.
        .or_else(|| only(|h| h == 0.0).map(|i| (i, heights[(i + 1) % 3] < 0.0)))
}

/// Six times the signed volume of a tetrahedron, mm³.
#[inline(always)]
fn volume(p: &Point, q: &Point, r: &Point, s: &Point) -> f64 {
    let (u, v, w): (Vector, Vector, Vector) = (q - p, r - p, s - p);
    u.cross(&v).dot(&w)
}

#[cfg(test)]
mod tests {
    use super::super::exact::tests::{hand_made, orders};
    use super::*;

    #[test]
    fn every_hand_made_case_in_every_order_and_both_ways() {
        // The coordinates are so small that all determinants are exact here.
        for (name, a, b, expected) in hand_made() {
            for a in orders(&a) {
                for b in orders(&b) {
                    assert_eq!(touch(&a, &b), expected, "{name}: {a:?} {b:?}");
                    assert_eq!(touch(&b, &a), expected, "{name}, swapped: {a:?} {b:?}");
                }
            }
        }
    }
}
