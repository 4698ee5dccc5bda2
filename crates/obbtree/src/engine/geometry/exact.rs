//! Whether two closed triangles share a point, decided exactly.
//!
//! Two triangles meet when one of six closed edge-triangle tests succeeds. Two in one plane meet unless the line of an edge of one parts
//! them from the other. For coordinates on the grid of [`super::grid`], all signs come
//! from integer determinants ([`touch_on_grid`]): differences of at most 2⁴¹ steps, products of two of at most 2⁸³, and products of three
//! of at most 3·2¹²⁴, which an `i128` holds. For all other coordinates, they come from Shewchuk's adaptive orientation predicates (1997,
//! through the `robust` crate). [`touch`] always uses these, so it is exact for every finite coordinate whose products neither overflow nor
//! underflow. Touching counts as contact. A triangle with collinear corners is treated as the segment between its extreme corners; one with
//! coincident corners is a point.

use super::grid::STEP_MM;
use super::plane::Plane;
use super::{Point, Triangle};
use robust::{Coord, Coord3D};

/// The sign of a number: -1, 0 or 1.
type Sign = i8;
type Flat<T> = [T; 2];
type Corner<T> = [T; 3];
type Corners<T> = [Corner<T>; 3];

/// Largest coordinate that [`touch_on_grid`] accepts, steps: four times the range of a mesh, because one of the two meshes was moved.
const LIMIT_STEPS: f64 = 1_099_511_627_776.0; // 2^40
/// 1.5·2⁵²: around it `f64` has no fractions, for 2⁵¹ to either side.
const NO_FRACTIONS: f64 = 6_755_399_441_055_744.0;

/// Whether the triangles, mm, share at least one point. Exact; symmetric; independent of the order of the corners.
/// Unspecified when a coordinate is not finite.
#[must_use]
pub fn touch(a: &Triangle, b: &Triangle) -> bool {
    touch_of(&corners(a), &corners(b))
}

/// Like [`touch`], in integers, about ten times as fast for coplanar triangles. `None` when a coordinate is not a multiple of the grid's
/// step or is beyond 16 384 mm.
#[must_use]
pub fn touch_on_grid(a: &Triangle, b: &Triangle) -> Option<bool> {
    Some(touch_of(&in_steps(a)?, &in_steps(b)?))
}

/// The side of the triangle's plane on which the point lies: 1 where the corners appear clockwise, -1 where they appear counter-clockwise,
/// 0 on the plane (for every point when the triangle has zero area). Exact.
#[must_use]
pub fn side(triangle: &Triangle, point: &Point) -> i8 {
    let [a, b, c] = corners(triangle);
    f64::orient(&a, &b, &c, &(*point).into())
}

/// The sign of the area of the triangle (a, b, c) in the plane, positive when counter-clockwise. Exact.
#[must_use]
pub fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> i8 {
    f64::turn(a, b, c)
}

/// Whether the corners are collinear or coincide. Exact.
#[must_use]
pub fn has_no_area(triangle: &Triangle) -> bool {
    collapsed(&corners(triangle)).is_some()
}

/// A coordinate type with exact signs of determinants.
trait Number: Copy + PartialOrd {
    /// The sign of the determinant of the vectors a - d, b - d and c - d.
    fn orient(a: &Corner<Self>, b: &Corner<Self>, c: &Corner<Self>, d: &Corner<Self>) -> Sign;
    /// The sign of the area of (a, b, c), positive when counter-clockwise.
    fn turn(a: Flat<Self>, b: Flat<Self>, c: Flat<Self>) -> Sign;
    /// [`Number::orient`] of a triangle with each corner of another triangle.
    fn sides(triangle: &Corners<Self>, other: &Corners<Self>) -> [Sign; 3];
}

impl Number for f64 {
    fn orient(a: &Corner<Self>, b: &Corner<Self>, c: &Corner<Self>, d: &Corner<Self>) -> Sign {
        let coord = |&[x, y, z]: &Corner<Self>| Coord3D { x, y, z };
        sign(robust::orient3d(coord(a), coord(b), coord(c), coord(d)))
    }

    fn turn(a: Flat<Self>, b: Flat<Self>, c: Flat<Self>) -> Sign {
        let coord = |[x, y]: Flat<Self>| Coord { x, y };
        sign(robust::orient2d(coord(a), coord(b), coord(c)))
    }

    fn sides(triangle: &Corners<Self>, other: &Corners<Self>) -> [Sign; 3] {
        // Most need no exact arithmetic. Above a plane its corners appear counter-clockwise.
        let [a, b, c] = triangle;
        let plane = Plane::of(&Triangle { corners: triangle.map(Point::from) });
        other.each_ref().map(|corner| match plane.side(&Point::from(*corner)) {
            0 => Self::orient(a, b, c, corner),
            side => -side,
        })
    }
}

impl Number for i64 {
    fn orient(a: &Corner<Self>, b: &Corner<Self>, c: &Corner<Self>, d: &Corner<Self>) -> Sign {
        below(&normal(a, b, c), a, d)
    }

    fn turn(a: Flat<Self>, b: Flat<Self>, c: Flat<Self>) -> Sign {
        let ([x, y], [u, v]) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        (product(x, v) - product(y, u)).signum() as Sign
    }

    fn sides([a, b, c]: &Corners<Self>, other: &Corners<Self>) -> [Sign; 3] {
        let normal = normal(a, b, c);
        let [p, q, r] = other;
        [below(&normal, a, p), below(&normal, a, q), below(&normal, a, r)]
    }
}

fn product(x: i64, y: i64) -> i128 {
    i128::from(x) * i128::from(y)
}

fn minus(p: &Corner<i64>, q: &Corner<i64>) -> Corner<i64> {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

/// The normal of a triangle, pointing to the side from which its corners appear counter-clockwise.
fn normal(a: &Corner<i64>, b: &Corner<i64>, c: &Corner<i64>) -> [i128; 3] {
    let (e, f) = (minus(b, a), minus(c, a));
    let component = |i: usize, j: usize| product(e[i], f[j]) - product(e[j], f[i]);
    [component(1, 2), component(2, 0), component(0, 1)]
}

/// 1 for a point below the plane through `a` with that normal, -1 above it, 0 on it.
fn below(normal: &[i128; 3], a: &Corner<i64>, point: &Corner<i64>) -> Sign {
    let d = minus(a, point);
    (0..3).map(|i| normal[i] * i128::from(d[i])).sum::<i128>().signum() as Sign
}

fn corners(triangle: &Triangle) -> Corners<f64> {
    triangle.corners.map(Into::into)
}

/// The corners in steps of the grid; `None` when a corner is not on the grid or is out of range.
fn in_steps(triangle: &Triangle) -> Option<Corners<i64>> {
    let mut steps = [[0; 3]; 3];
    let mut all = true;
    for (corner, steps) in triangle.corners.iter().zip(&mut steps) {
        for (x, steps) in corner.iter().zip(steps) {
            // Exact: a power of two. The sum has no fractions, and its last bits count the steps.
            let x = x * (1.0 / STEP_MM);
            let whole = x + NO_FRACTIONS;
            all &= (whole - NO_FRACTIONS == x) & (x.abs() <= LIMIT_STEPS);
            *steps = (whole.to_bits() as i64).wrapping_sub(NO_FRACTIONS.to_bits() as i64);
        }
    }
    all.then_some(steps)
}

fn touch_of<T: Number>(a: &Corners<T>, b: &Corners<T>) -> bool {
    if !(0..3).all(|axis| overlap_on(axis, a, b)) {
        return false;
    }
    let b_sides = T::sides(a, b);
    if on_one_side(b_sides) {
        return false;
    }
    if b_sides == [0; 3] {
        return touch_without_depth(a, b);
    }
    let a_sides = T::sides(b, a);
    if on_one_side(a_sides) {
        return false;
    }
    if a_sides == [0; 3] {
        return touch_without_depth(a, b);
    }
    any_edge_meets(a, b, b_sides) || any_edge_meets(b, a, a_sides)
}

/// The test for coplanar triangles, or when at least one triangle is degenerate.
fn touch_without_depth<T: Number>(a: &Corners<T>, b: &Corners<T>) -> bool {
    match (collapsed(a), collapsed(b)) {
        (None, None) => touch_in_plane(a, b),
        (None, Some((p, q))) => edge_meets(a, &p, &q, side_of(a, &p), side_of(a, &q)),
        (Some((p, q)), None) => edge_meets(b, &p, &q, side_of(b, &p), side_of(b, &q)),
        (Some((p, q)), Some((r, s))) => segments_meet(&p, &q, &r, &s),
    }
}

fn side_of<T: Number>([a, b, c]: &Corners<T>, point: &Corner<T>) -> Sign {
    T::orient(a, b, c, point)
}

/// Whether an edge of `other` meets `triangle`, which has nonzero area. `sides` are the sides of the corners of `other`.
fn any_edge_meets<T: Number>(triangle: &Corners<T>, other: &Corners<T>, sides: [Sign; 3]) -> bool {
    (0..3).any(|i| {
        let j = (i + 1) % 3;
        edge_meets(triangle, &other[i], &other[j], sides[i], sides[j])
    })
}

/// Whether the closed segment pq meets `triangle`, which has nonzero area. `side_p` and `side_q` are the sides of its ends.
fn edge_meets<T: Number>(triangle: &Corners<T>, p: &Corner<T>, q: &Corner<T>, side_p: Sign, side_q: Sign) -> bool {
    if side_p * side_q > 0 {
        return false;
    }
    if side_p == 0 && side_q == 0 {
        return coplanar_edge_meets(triangle, p, q);
    }
    let [a, b, c] = triangle;
    !both_signs([T::orient(p, q, a, b), T::orient(p, q, b, c), T::orient(p, q, c, a)])
}

/// A point with one coordinate dropped.
fn flat<T: Number>(drop: usize, p: &Corner<T>) -> Flat<T> {
    [p[(drop + 1) % 3], p[(drop + 2) % 3]]
}

/// A coordinate that may be dropped such that a triangle keeps a nonzero area, and the sign of that area; 0 where there is none.
fn droppable<T: Number>([a, b, c]: &Corners<T>) -> (usize, Sign) {
    let turn = |drop: usize| (drop, T::turn(flat(drop, a), flat(drop, b), flat(drop, c)));
    (0..3).map(turn).find(|(_, turn)| *turn != 0).unwrap_or((2, 0))
}

/// Whether two triangles with nonzero area in one plane touch: no edge of either has the other strictly beyond it.
fn touch_in_plane<T: Number>(a: &Corners<T>, b: &Corners<T>) -> bool {
    let (drop, turn_a) = droppable(a);
    let flat = |[p, q, r]: &Corners<T>| [flat(drop, p), flat(drop, q), flat(drop, r)];
    let ([p, q, r], [u, v, w]) = (flat(a), flat(b));
    let turn_b = T::turn(u, v, w);
    let parts = |from, to, turn: Sign, beyond: [Flat<T>; 3]| beyond.into_iter().all(|p| T::turn(from, to, p) == -turn);
    let of_a = [(p, q), (q, r), (r, p)].into_iter().any(|(from, to)| parts(from, to, turn_a, [u, v, w]));
    !of_a && ![(u, v), (v, w), (w, u)].into_iter().any(|(from, to)| parts(from, to, turn_b, [p, q, r]))
}

/// Like [`edge_meets`] for a segment in the triangle's plane; one coordinate is dropped such that the triangle keeps a nonzero area.
fn coplanar_edge_meets<T: Number>(triangle: &Corners<T>, p: &Corner<T>, q: &Corner<T>) -> bool {
    let (drop, _) = droppable(triangle);
    let [a, b, c] = triangle.map(|corner| flat(drop, &corner));
    let (p, q) = (flat(drop, p), flat(drop, q));
    !both_signs([T::turn(a, b, p), T::turn(b, c, p), T::turn(c, a, p)])
        || [(a, b), (b, c), (c, a)].into_iter().any(|(u, v)| flat_segments_meet(p, q, u, v))
}

/// Whether two closed segments meet; either may be a point.
///
/// They meet when they are coplanar and their projections on all three coordinate planes meet, because at least one of the three
/// projections is one-to-one on their common plane.
fn segments_meet<T: Number>(p: &Corner<T>, q: &Corner<T>, r: &Corner<T>, s: &Corner<T>) -> bool {
    T::orient(p, q, r, s) == 0
        && (0..3).all(|drop| flat_segments_meet(flat(drop, p), flat(drop, q), flat(drop, r), flat(drop, s)))
}

/// Whether two closed segments of the plane meet; either may be a point. They meet when their bounds overlap and neither lies strictly on
/// one side of the other's line.
fn flat_segments_meet<T: Number>(p: Flat<T>, q: Flat<T>, r: Flat<T>, s: Flat<T>) -> bool {
    (0..2).all(|i| less(p[i], q[i]) <= more(r[i], s[i]) && less(r[i], s[i]) <= more(p[i], q[i]))
        && T::turn(p, q, r) * T::turn(p, q, s) <= 0
        && T::turn(r, s, p) * T::turn(r, s, q) <= 0
}

/// The segment that a triangle of zero area covers (the same point twice when it is a point); `None` when it has nonzero area.
fn collapsed<T: Number>(triangle: &Corners<T>) -> Option<(Corner<T>, Corner<T>)> {
    let collinear = (0..3).all(|drop| {
        let [a, b, c] = triangle;
        T::turn(flat(drop, a), flat(drop, b), flat(drop, c)) == 0
    });
    if !collinear {
        return None;
    }
    // Collinear points are in the same order on every axis that tells any two of them apart.
    let [a, b, c] = triangle;
    let low = |axis: usize| less(less(a[axis], b[axis]), c[axis]);
    let high = |axis: usize| more(more(a[axis], b[axis]), c[axis]);
    let axis = (0..3).find(|&i| low(i) < high(i)).unwrap_or(0);
    let at = |x: T| triangle.iter().find(|corner| corner[axis] == x).unwrap_or(a);
    Some((*at(low(axis)), *at(high(axis))))
}

/// Whether the coordinate intervals of the two triangles overlap on every axis. Exact.
#[inline(always)]
#[must_use]
pub fn bounds_overlap(a: &Triangle, b: &Triangle) -> bool {
    overlap_on(0, &a.corners, &b.corners)
        && overlap_on(1, &a.corners, &b.corners)
        && overlap_on(2, &a.corners, &b.corners)
}

/// The smaller number. A plain comparison compiles to one instruction; `f64::min` takes more for its handling of NaN.
#[inline(always)]
fn less<T: PartialOrd>(x: T, y: T) -> T {
    if x < y { x } else { y }
}

#[inline(always)]
fn more<T: PartialOrd>(x: T, y: T) -> T {
    if x > y { x } else { y }
}

#[inline(always)]
fn overlap_on<T: PartialOrd + Copy, P: std::ops::Index<usize, Output = T>>(
    axis: usize,
    a: &[P; 3],
    b: &[P; 3],
) -> bool {
    let [p, q, r] = [a[0][axis], a[1][axis], a[2][axis]];
    let [u, v, w] = [b[0][axis], b[1][axis], b[2][axis]];
    // `&` saves a branch.
    (less(less(p, q), r) <= more(more(u, v), w)) & (less(less(u, v), w) <= more(more(p, q), r))
}

fn on_one_side([x, y, z]: [Sign; 3]) -> bool {
    x != 0 && x == y && y == z
}

fn both_signs(signs: [Sign; 3]) -> bool {
    signs.contains(&1) && signs.contains(&-1)
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

    /// The floor's corners run counter-clockwise for who looks down on it.
    #[test]
    fn sides_turns_and_areas() {
        let floor = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let sides = [-STEP_MM, 0.0, STEP_MM].map(|z| side(&floor, &Point::new(9.0, -3.0, z)));
        assert_eq!(sides, [1, 0, -1]);
        let turns = [STEP_MM, 0.0, -STEP_MM].map(|y| turn([0.0, 0.0], [1.0, 0.0], [2.0, y]));
        assert_eq!(turns, [1, 0, -1]);
        let thin = |y| triangle([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [2.0, y, 1.0]]);
        assert!(has_no_area(&thin(0.0)) && !has_no_area(&thin(STEP_MM)));
    }

    /// Pairs with known answers, one or more for every kind of contact and every kind of degeneracy.
    pub(crate) fn hand_made() -> Vec<(&'static str, Triangle, Triangle, bool)> {
        let floor = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let point = |p: [f64; 3]| [p, p, p];
        let segment = |p: [f64; 3], q: [f64; 3]| [p, q, p];
        let middle = |p: [f64; 3], q: [f64; 3]| std::array::from_fn(|i| (p[i] + q[i]) / 2.0);
        let collinear = |p, q| [p, middle(p, q), q];
        // 2^-26 mm: the smallest distance on the grid.
        let h = STEP_MM;
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
    fn sides_and_turns_have_their_signs_to_the_last_step() {
        // Counter-clockwise seen from above, that is from z > 0.
        let floor = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let side_at = |z: f64| side(&floor, &Point::new(1.0, 1.0, z));
        assert_eq!([STEP_MM, 0.0, -STEP_MM].map(side_at), [-1, 0, 1]);
        let turn_at = |y: f64| turn([0.0, 0.0], [4.0, 0.0], [1.0, y]);
        assert_eq!([STEP_MM, 0.0, -STEP_MM].map(turn_at), [1, 0, -1]);
        let needle = |y: f64| triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [1.0, y, 0.0]]);
        assert!(has_no_area(&needle(0.0)) && !has_no_area(&needle(STEP_MM)));
    }

    #[test]
    fn every_hand_made_case_in_every_order_and_both_ways() {
        for (name, a, b, expected) in hand_made() {
            for a in orders(&a) {
                for b in orders(&b) {
                    assert_eq!(touch(&a, &b), expected, "{name}: {a:?} {b:?}");
                    assert_eq!(touch(&b, &a), expected, "{name}, swapped: {a:?} {b:?}");
                    assert_eq!(touch_on_grid(&a, &b), Some(expected), "{name}, in steps: {a:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_off_the_grid_or_out_of_range_has_no_steps() {
        let at = |x: f64| triangle([[x, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let limit = LIMIT_STEPS * STEP_MM;
        assert_eq!(limit, 16_384.0);
        for (x, is_in) in
            [(limit, true), (-limit, true), (limit + STEP_MM, false), (0.1, false), (1e300, false), (f64::NAN, false)]
        {
            assert_eq!(touch_on_grid(&at(x), &at(0.0)).is_some(), is_in, "{x}");
            assert_eq!(touch_on_grid(&at(0.0), &at(x)).is_some(), is_in, "{x}");
        }
    }

    /// The largest possible determinants: corners at opposite ends of the range.
    #[test]
    fn the_ends_of_the_range_do_not_overflow() {
        let ends = |i: u32| {
            let end = |bit: u32| if i >> bit & 1 == 1 { LIMIT_STEPS as i64 } else { -(LIMIT_STEPS as i64) };
            [end(0), end(1), end(2)]
        };
        let mut signs = [0; 3];
        for i in 0..8_u32.pow(4) {
            let [a, b, c, d] = [i % 8, i / 8 % 8, i / 64 % 8, i / 512].map(ends);
            let point = |steps: [i64; 3]| steps.map(|x| x as f64);
            let expected = f64::orient(&point(a), &point(b), &point(c), &point(d));
            assert_eq!(i64::orient(&a, &b, &c, &d), expected, "{a:?} {b:?} {c:?} {d:?}");
            signs[(expected + 1) as usize] += 1;
        }
        assert!(signs.iter().all(|&count| count > 100), "{signs:?}");
    }
}
