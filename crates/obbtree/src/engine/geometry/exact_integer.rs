//! A second exact triangle test, in integers and by another theorem; it is used only to check [`super::exact`].
//!
//! Two convex sets are disjoint when the origin lies outside their Minkowski difference M. For two triangles, degenerate
//! or not, M is the hull of nine points, and one of finitely many axes then separates them strictly:
//!
//! - M solid: a facet normal, which is the normal of a triangle or the cross product of one edge of each;
//! - M flat with its plane off the origin: the normal of that plane, which is one of the same vectors;
//! - M in a plane through the origin: the projection of M along some coordinate axis is one-to-one on that plane and misses the origin. In
//!   that projection, the perpendicular of an edge separates (the cross product of the edge with the coordinate axis). When the projection
//!   is itself a segment or a point, a coordinate axis may separate instead.
//!
//! The triangles are therefore disjoint exactly when one of 32 axes separates them: 3 coordinate axes, 2 normals, 9 cross products of
//! edges, and 18 cross products of an edge with a coordinate axis. No case distinction is needed.
//!
//! Range: coordinates of at most 2⁴⁰ steps (16 384 mm) differ by at most 2⁴¹. A component of a cross product is at most 2⁸³, and its
//! product with a difference at most 3·2¹²⁴ < 2¹²⁶, which an `i128` holds.

use super::grid::STEP_MM;
use super::{Point, Triangle};

/// Largest coordinate magnitude that the integer test accepts, mm: four times the range of a mesh, because one of the two meshes was moved.
pub const LIMIT_MM: f64 = 16_384.0;

type Integers = [i128; 3];

/// Whether the triangles share at least one point; exact. `None` when a coordinate is not a multiple of the grid's step
/// or is beyond ±[`LIMIT_MM`].
#[must_use]
pub fn touch(a: &Triangle, b: &Triangle) -> Option<bool> {
    let (a, b) = (to_steps(a)?, to_steps(b)?);
    let (edges_a, edges_b) = (edges(&a), edges(&b));
    let units = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let normals = [cross(edges_a[0], edges_a[1]), cross(edges_b[0], edges_b[1])];
    let between = edges_a.iter().flat_map(|e| edges_b.iter().map(|f| cross(*e, *f)));
    let shadows = edges_a.iter().chain(&edges_b).flat_map(|e| units.iter().map(|u| cross(*e, *u)));
    let mut axes = units.into_iter().chain(normals).chain(between).chain(shadows);
    Some(!axes.any(|axis| separates(axis, &a, &b)))
}

/// Whether the projections on the axis are strictly disjoint. The zero axis separates nothing.
fn separates(axis: Integers, a: &[Integers; 3], b: &[Integers; 3]) -> bool {
    let along = |p: &Integers| dot(axis, minus(*p, a[0]));
    let (a, b) = (a.each_ref().map(along), b.each_ref().map(along));
    let low = |[x, y, z]: [i128; 3]| x.min(y).min(z);
    let high = |[x, y, z]: [i128; 3]| x.max(y).max(z);
    high(a) < low(b) || high(b) < low(a)
}

/// The corners in steps of the grid.
fn to_steps(triangle: &Triangle) -> Option<[Integers; 3]> {
    let steps = |x: f64| {
        let steps = x / STEP_MM; // Exact: a power of two.
        (x.abs() <= LIMIT_MM && steps.fract() == 0.0).then_some(steps as i128)
    };
    let point = |p: &Point| Some([steps(p.x)?, steps(p.y)?, steps(p.z)?]);
    let [p, q, r] = &triangle.corners;
    Some([point(p)?, point(q)?, point(r)?])
}

fn edges(&[p, q, r]: &[Integers; 3]) -> [Integers; 3] {
    [minus(q, p), minus(r, q), minus(p, r)]
}

fn minus(p: Integers, q: Integers) -> Integers {
    std::array::from_fn(|i| p[i] - q[i])
}

fn dot(p: Integers, q: Integers) -> i128 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

fn cross(p: Integers, q: Integers) -> Integers {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        p[j] * q[k] - p[k] * q[j]
    })
}

#[cfg(test)]
mod tests {
    use super::super::exact::tests::{hand_made, orders};
    use super::*;

    #[test]
    fn every_hand_made_case_in_every_order_and_both_ways() {
        for (name, a, b, expected) in hand_made() {
            for a in orders(&a) {
                for b in orders(&b) {
                    assert_eq!(touch(&a, &b), Some(expected), "{name}: {a:?} {b:?}");
                    assert_eq!(touch(&b, &a), Some(expected), "{name}, swapped: {a:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn the_farthest_coordinates_do_not_overflow() {
        // Debug assertions are off in release builds, so the largest magnitudes are computed with checks here: the corners
        // of the cube [-2^40, 2^40]^3 give the largest cross products and dot products there are.
        let limit = 1i128 << 40;
        let corner =
            |bits: usize| -> Integers { std::array::from_fn(|i| if bits >> i & 1 == 1 { limit } else { -limit }) };
        for (p, q) in (0..64).map(|n| (corner(n & 7), corner(n >> 3))) {
            for r in (0..8).map(corner) {
                let (d, e) = (minus(q, p), minus(r, p));
                let axis = cross(d, e);
                assert!(axis.iter().all(|x| x.abs() <= 1 << 83));
                let bound: i128 = axis.iter().zip(d).map(|(x, y)| x.checked_mul(y).map_or(i128::MAX, i128::abs)).sum();
                assert!(bound <= 3 << 124);
            }
        }
    }

    #[test]
    fn coordinates_off_the_grid_or_out_of_range_are_refused() {
        let (_, good, ..) = hand_made()[0];
        for x in [0.1, f64::NAN, f64::INFINITY, LIMIT_MM + 1.0, STEP_MM / 2.0] {
            let mut bad = good;
            bad.corners[2].y = x;
            assert_eq!(touch(&good, &bad), None, "{x}");
        }
    }
}
