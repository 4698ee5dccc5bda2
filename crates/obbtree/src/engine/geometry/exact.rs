//! Whether two closed triangles share a point, decided exactly.
//!
//! Two triangles meet when one of six closed edge-triangle tests succeeds. All signs come from Shewchuk's adaptive
//! orientation predicates (1997, through the `robust` crate), so the answer is exact for every finite coordinate whose
//! products neither overflow nor underflow, the grid of [`super::grid`] included. Touching counts. A triangle whose
//! corners are collinear is the segment between its extreme corners; one whose corners coincide is a point.

use super::plane::Plane;
use super::{Point, Triangle};
use robust::{Coord, Coord3D};

/// The sign of a number: -1, 0 or 1.
type Sign = i8;

/// Whether the triangles, mm, share at least one point. Exact; symmetric; independent of the order of the corners.
/// Unspecified when a coordinate is not finite.
#[must_use]
pub fn touch(a: &Triangle, b: &Triangle) -> bool {
    if !bounds_overlap(a, b) {
        return false;
    }
    let b_sides = sides(a, b);
    if on_one_side(b_sides) {
        return false;
    }
    let a_sides = sides(b, a);
    if on_one_side(a_sides) {
        return false;
    }
    if a_sides == [0; 3] || b_sides == [0; 3] {
        return touch_without_depth(a, b, a_sides, b_sides);
    }
    any_edge_meets(a, b, b_sides) || any_edge_meets(b, a, a_sides)
}

/// The side of the triangle's plane that the point is on: 1 where the corners appear clockwise, -1 where they appear
/// counter-clockwise, 0 on the plane (everywhere when the triangle has no area). Exact.
#[must_use]
pub fn side(triangle: &Triangle, point: &Point) -> i8 {
    let [a, b, c] = &triangle.corners;
    orient(a, b, c, point)
}

/// The sign of the area of the triangle (a, b, c) in the plane, positive when counter-clockwise. Exact.
#[must_use]
pub fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> i8 {
    let coord = |[x, y]: [f64; 2]| Coord { x, y };
    sign(robust::orient2d(coord(a), coord(b), coord(c)))
}

/// Whether the corners are collinear or coincide. Exact.
#[must_use]
pub fn has_no_area(triangle: &Triangle) -> bool {
    collapsed(triangle).is_some()
}

/// Coplanar triangles, or at least one of them degenerate.
fn touch_without_depth(a: &Triangle, b: &Triangle, a_sides: [Sign; 3], b_sides: [Sign; 3]) -> bool {
    match (collapsed(a), collapsed(b)) {
        (None, None) => any_edge_meets(a, b, b_sides) || any_edge_meets(b, a, a_sides),
        (None, Some((p, q))) => edge_meets(a, &p, &q, side(a, &p), side(a, &q)),
        (Some((p, q)), None) => edge_meets(b, &p, &q, side(b, &p), side(b, &q)),
        (Some((p, q)), Some((r, s))) => segments_meet(&p, &q, &r, &s),
    }
}

/// Whether an edge of `other`, whose corners lie on `sides` of `triangle`, meets `triangle`, which has area.
fn any_edge_meets(triangle: &Triangle, other: &Triangle, sides: [Sign; 3]) -> bool {
    (0..3).any(|i| {
        let j = (i + 1) % 3;
        edge_meets(triangle, &other.corners[i], &other.corners[j], sides[i], sides[j])
    })
}

/// Whether the closed segment pq, whose ends lie on the given sides of `triangle`, meets `triangle`, which has area.
fn edge_meets(triangle: &Triangle, p: &Point, q: &Point, side_p: Sign, side_q: Sign) -> bool {
    if side_p * side_q > 0 {
        return false;
    }
    if side_p == 0 && side_q == 0 {
        return coplanar_edge_meets(triangle, p, q);
    }
    let [a, b, c] = &triangle.corners;
    !both_signs([orient(p, q, a, b), orient(p, q, b, c), orient(p, q, c, a)])
}

/// The same for a segment in the triangle's plane: one coordinate is dropped such that the triangle keeps an area.
fn coplanar_edge_meets(triangle: &Triangle, p: &Point, q: &Point) -> bool {
    let flat = |drop: usize, p: &Point| [p[(drop + 1) % 3], p[(drop + 2) % 3]];
    let Some(drop) = (0..3).find(|&drop| {
        let [a, b, c] = triangle.corners.map(|corner| flat(drop, &corner));
        turn(a, b, c) != 0
    }) else {
        return false; // Not reached: the triangle has area.
    };
    let [a, b, c] = triangle.corners.map(|corner| flat(drop, &corner));
    let (p, q) = (flat(drop, p), flat(drop, q));
    !both_signs([turn(a, b, p), turn(b, c, p), turn(c, a, p)])
        || [(a, b), (b, c), (c, a)].into_iter().any(|(u, v)| flat_segments_meet(p, q, u, v))
}

/// Whether two closed segments meet; either may be a point.
///
/// They meet when they are coplanar and their shadows on all three coordinate planes meet: at least one of the three
/// projections is one-to-one on the plane that holds both.
fn segments_meet(p: &Point, q: &Point, r: &Point, s: &Point) -> bool {
    let flat = |drop: usize, p: &Point| [p[(drop + 1) % 3], p[(drop + 2) % 3]];
    orient(p, q, r, s) == 0
        && (0..3).all(|drop| flat_segments_meet(flat(drop, p), flat(drop, q), flat(drop, r), flat(drop, s)))
}

/// Whether two closed segments of the plane meet; either may be a point: their bounds overlap, and neither lies strictly
/// on one side of the other's line.
fn flat_segments_meet(p: [f64; 2], q: [f64; 2], r: [f64; 2], s: [f64; 2]) -> bool {
    (0..2).all(|i| p[i].min(q[i]) <= r[i].max(s[i]) && r[i].min(s[i]) <= p[i].max(q[i]))
        && turn(p, q, r) * turn(p, q, s) <= 0
        && turn(r, s, p) * turn(r, s, q) <= 0
}

/// The segment that a triangle without area is (twice the same point when it is a point); `None` when it has area.
fn collapsed(triangle: &Triangle) -> Option<(Point, Point)> {
    let [a, b, c] = &triangle.corners;
    let collinear = (0..3).all(|drop| {
        let flat = |p: &Point| [p[(drop + 1) % 3], p[(drop + 2) % 3]];
        turn(flat(a), flat(b), flat(c)) == 0
    });
    if !collinear {
        return None;
    }
    // Collinear points are in the same order on every axis that tells any two of them apart.
    let (low, high) = triangle.bounds();
    let axis = (0..3).find(|&i| low[i] < high[i]).unwrap_or(0);
    let at = |x: f64| triangle.corners.into_iter().find(|corner| corner[axis] == x).unwrap_or(*a);
    Some((at(low[axis]), at(high[axis])))
}

/// Whether the coordinate intervals of the two triangles overlap on every axis. Exact.
#[inline(always)]
#[must_use]
pub fn bounds_overlap(a: &Triangle, b: &Triangle) -> bool {
    overlap_on(0, a, b) && overlap_on(1, a, b) && overlap_on(2, a, b)
}

#[inline(always)]
fn overlap_on(axis: usize, a: &Triangle, b: &Triangle) -> bool {
    // Plain comparisons compile to one instruction; `f64::min` pays for its promise about NaN. `&` saves a branch.
    let less = |x: f64, y: f64| if x < y { x } else { y };
    let more = |x: f64, y: f64| if x > y { x } else { y };
    let [p, q, r] = a.corners.each_ref().map(|corner| corner[axis]);
    let [u, v, w] = b.corners.each_ref().map(|corner| corner[axis]);
    (less(less(p, q), r) <= more(more(u, v), w)) & (less(less(u, v), w) <= more(more(p, q), r))
}

/// The sides of `triangle` that the corners of `other` are on.
fn sides(triangle: &Triangle, other: &Triangle) -> [Sign; 3] {
    // Most need no exact arithmetic. Above a plane its corners appear counter-clockwise.
    let [x, y, z] = Plane::of(triangle).sides(other);
    let sure = |side: Sign, corner: &Point| if side == 0 { self::side(triangle, corner) } else { -side };
    let [p, q, r] = &other.corners;
    [sure(x, p), sure(y, q), sure(z, r)]
}

fn on_one_side([x, y, z]: [Sign; 3]) -> bool {
    x != 0 && x == y && y == z
}

fn both_signs(signs: [Sign; 3]) -> bool {
    signs.contains(&1) && signs.contains(&-1)
}

fn orient(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    let coord = |p: &Point| Coord3D { x: p.x, y: p.y, z: p.z };
    sign(robust::orient3d(coord(a), coord(b), coord(c), coord(d)))
}

fn sign(x: f64) -> Sign {
    Sign::from(x > 0.0) - Sign::from(x < 0.0)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    fn triangle(corners: [[f64; 3]; 3]) -> Triangle {
        Triangle { corners: corners.map(Point::from) }
    }

    /// Pairs with known answers, one or more for every kind of contact and every kind of degeneracy.
    pub(crate) fn hand_made() -> Vec<(&'static str, Triangle, Triangle, bool)> {
        let floor = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let point = |p: [f64; 3]| [p, p, p];
        let segment = |p: [f64; 3], q: [f64; 3]| [p, q, p];
        let middle = |p: [f64; 3], q: [f64; 3]| std::array::from_fn(|i| (p[i] + q[i]) / 2.0);
        let collinear = |p, q| [p, middle(p, q), q];
        // 2^-26 mm: the smallest distance on the grid.
        let h = super::super::grid::STEP_MM;
        let cases = [
            ("pierced", floor, [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 1.0]], true),
            ("beside", floor, [[3.0, 3.0, -1.0], [3.0, 3.0, 1.0], [9.0, 9.0, 1.0]], false),
            ("interlocked", floor, [[-1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 1.0, -1.0]], true),
            ("parallel, one step apart", floor, [[0.0, 0.0, h], [4.0, 0.0, h], [0.0, 4.0, h]], false),
            ("corner on face", floor, [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], true),
            ("corner one step above face", floor, [[1.0, 1.0, h], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], false),
            ("corner on corner", floor, [[4.0, 0.0, 0.0], [5.0, 0.0, 1.0], [5.0, 1.0, 1.0]], true),
            ("corner on slanted edge", floor, [[2.0, 2.0, 0.0], [5.0, 5.0, 1.0], [5.0, 4.0, 1.0]], true),
            ("corner one step off the edge", floor, [[2.0, 2.0 + h, 0.0], [5.0, 5.0, 1.0], [5.0, 4.0, 1.0]], false),
            ("edge across edge", floor, [[1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [1.0, -3.0, 0.0]], true),
            ("edge past edge", floor, [[1.0, -h, -1.0], [1.0, -h, 1.0], [1.0, -3.0, 0.0]], false),
            ("shared edge", floor, [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 4.0]], true),
            ("edge lies in face", floor, [[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 1.0, 3.0]], true),
            ("edge in plane, outside", floor, [[3.0, 3.0, 0.0], [4.0, 3.0, 0.0], [3.0, 3.0, 3.0]], false),
            ("identical", floor, floor, true),
            ("coplanar, inside", floor, [[1.0, 1.0, 0.0], [1.5, 1.0, 0.0], [1.0, 1.5, 0.0]], true),
            ("coplanar, crossing", floor, [[-1.0, 1.0, 0.0], [5.0, 1.0, 0.0], [-1.0, 2.0, 0.0]], true),
            ("coplanar, corner on edge", floor, [[2.0, 0.0, 0.0], [1.0, -1.0, 0.0], [3.0, -1.0, 0.0]], true),
            ("coplanar, one step off", floor, [[2.0, -h, 0.0], [1.0, -1.0, 0.0], [3.0, -1.0, 0.0]], false),
            ("coplanar, bounds overlap only", floor, [[3.0, 3.0, 0.0], [3.0, 2.0, 0.0], [2.0, 3.0, 0.0]], false),
            ("point in face", floor, point([1.0, 1.0, 0.0]), true),
            ("point on edge", floor, point([2.0, 2.0, 0.0]), true),
            ("point off the edge", floor, point([2.0, 2.0 + h, 0.0]), false),
            ("point above face", floor, point([1.0, 1.0, h]), false),
            ("point in plane", floor, point([3.0, 3.0, 0.0]), false),
            ("segment through face", floor, segment([1.0, 1.0, -1.0], [1.0, 1.0, 1.0]), true),
            ("segment stops short", floor, segment([1.0, 1.0, h], [1.0, 1.0, 1.0]), false),
            ("segment in face", floor, segment([1.0, 1.0, 0.0], [1.5, 1.0, 0.0]), true),
            ("segment in plane, across", floor, collinear([-1.0, 2.0, 0.0], [9.0, 2.0, 0.0]), true),
            ("segment in plane, outside", floor, collinear([5.0, 0.0, 0.0], [0.0, 5.0, 0.0]), false),
            ("segment passes by", floor, collinear([3.0, 3.0, -1.0], [3.0, 3.0, 1.0]), false),
            (
                "middle corner of a collinear triangle",
                floor,
                [[0.0, 1.0, 2.0], [0.0, 1.0, 1.0], [0.0, 1.0, -2.0]],
                true,
            ),
            (
                "segments cross",
                segment([0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
                collinear([0.0, 2.0, 1.0], [2.0, 0.0, 1.0]),
                true,
            ),
            (
                "segments pass",
                segment([0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
                collinear([0.0, 2.0, 1.0 + h], [2.0, 0.0, 1.0 + h]),
                false,
            ),
            (
                "segments overlap",
                segment([0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
                segment([1.0, 1.0, 1.0], [3.0, 3.0, 3.0]),
                true,
            ),
            (
                "segments end to end",
                segment([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
                segment([1.0, 1.0, 1.0], [3.0, 3.0, 3.0]),
                true,
            ),
            (
                "segments in line, apart",
                segment([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
                segment([1.0 + h, 1.0 + h, 1.0 + h], [3.0, 3.0, 3.0]),
                false,
            ),
            (
                "segments parallel",
                segment([0.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
                segment([h, 0.0, 0.0], [2.0 + h, 2.0, 2.0]),
                false,
            ),
            (
                "segments along an axis, apart",
                segment([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
                segment([0.0, 0.0, 1.0 + h], [0.0, 0.0, 2.0]),
                false,
            ),
            ("point on segment", segment([0.0, 0.0, 0.0], [2.0, 2.0, 2.0]), point([1.0, 1.0, 1.0]), true),
            ("point off segment", segment([0.0, 0.0, 0.0], [2.0, 2.0, 2.0]), point([1.0, 1.0, 1.0 + h]), false),
            ("point beyond segment", segment([0.0, 0.0, 0.0], [2.0, 2.0, 2.0]), point([3.0, 3.0, 3.0]), false),
            ("point on point", point([1.0, 2.0, 3.0]), point([1.0, 2.0, 3.0]), true),
            ("point beside point", point([1.0, 2.0, 3.0]), point([1.0, 2.0, 3.0 + h]), false),
        ];
        cases.into_iter().map(|(name, a, b, touching)| (name, triangle(a), triangle(b), touching)).collect()
    }

    /// A triangle with its corners in each of the six orders.
    pub(crate) fn orders(t: &Triangle) -> [Triangle; 6] {
        let [a, b, c] = t.corners;
        [[a, b, c], [b, c, a], [c, a, b], [a, c, b], [c, b, a], [b, a, c]].map(|corners| Triangle { corners })
    }

    #[test]
    fn every_hand_made_case_in_every_order_and_both_ways() {
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
