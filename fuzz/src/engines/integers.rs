//! Whether two triangles share a point, in integers: the judge of all engines.
//!
//! Two triangles, degenerate or not, share a point when an edge of one meets the other: where their common part is not a piece of a plane, its ends
//! lie on an edge; where it is, an edge of one enters the other or lies in it. So there is one question, a segment against a triangle, and one
//! below it, a segment against a segment.
//!
//! Bits: corners are multiples of 2⁻²⁶ mm. Those of a mesh are within ±4096 mm, and a posed mesh reaches no farther than ±24 000 mm, so corners
//! differ by less than 2⁴¹ steps in each coordinate, a component of a cross product is below 2⁸³, and a determinant below 3·2¹²⁴ < 2¹²⁶.

use bvbench::geometry::Point;
use bvbench::geometry::grid::STEP_MM;

/// A point, in steps of the grid.
pub type Steps = [i64; 3];
type Wide = [i128; 3];

/// A triangle, in steps of the grid, and its extent along the axes.
#[derive(Clone, Copy, Debug)]
pub struct Corners {
    corners: [Steps; 3],
    low: Steps,
    high: Steps,
}

impl Corners {
    /// Of corners on the grid, mm.
    pub fn new(corners: [Point; 3]) -> Self {
        // Exact: a power of two.
        let corners = corners.map(|p| [p.x, p.y, p.z].map(|x| (x / STEP_MM) as i64));
        let [p, q, r] = corners;
        let low = std::array::from_fn(|k| p[k].min(q[k]).min(r[k]));
        let high = std::array::from_fn(|k| p[k].max(q[k]).max(r[k]));
        Self { corners, low, high }
    }

    /// Whether the triangles share a point.
    pub fn touch(&self, other: &Self) -> bool {
        let apart = |k: usize| self.high[k] < other.low[k] || other.high[k] < self.low[k];
        if apart(0) || apart(1) || apart(2) {
            return false;
        }
        // One triangle strictly on one side of the other's plane: most pairs end here.
        if self.is_beside(other) || other.is_beside(self) {
            return false;
        }
        let enters = |of: &Self, into: &Self| of.edges().iter().any(|edge| meets_triangle(edge, &into.corners));
        enters(self, other) || enters(other, self)
    }

    /// Whether it is strictly on one side of the plane of `other`.
    fn is_beside(&self, other: &Self) -> bool {
        let normal = normal_of(&other.corners);
        let sides = self.corners.map(|p| dot(&normal, &minus(&p, &other.corners[0])).signum());
        sides == [1; 3] || sides == [-1; 3]
    }

    fn edges(&self) -> [[Steps; 2]; 3] {
        let [p, q, r] = self.corners;
        [[p, q], [q, r], [r, p]]
    }
}

/// Whether a segment, which may be a point, meets a triangle, which may be a segment or a point.
fn meets_triangle(segment: &[Steps; 2], triangle: &[Steps; 3]) -> bool {
    let [p, q] = segment;
    let [a, b, c] = triangle;
    let edges = [[*a, *b], [*b, *c], [*c, *a]];
    let normal = normal_of(triangle);
    if normal == [0; 3] {
        return edges.iter().any(|edge| meet(segment, edge));
    }
    let side = |p: &Steps| dot(&normal, &minus(p, a)).signum();
    match (side(p), side(q)) {
        (0, 0) => {
            let along = largest(&normal);
            let inside = edges.map(|[a, b]| turn(along, &a, &b, p).signum());
            let is_inside = inside.iter().all(|&s| s >= 0) || inside.iter().all(|&s| s <= 0);
            is_inside || edges.iter().any(|edge| meet(segment, edge))
        }
        (one, other) if one == other => false,
        // The line through p and q is not in the plane: it passes the inside when it runs round all edges the same way.
        _ => {
            let along = minus(q, p);
            let round = edges.map(|[a, b]| dot(&cross(&minus(&a, p), &minus(&b, p)), &along).signum());
            round.iter().all(|&s| s >= 0) || round.iter().all(|&s| s <= 0)
        }
    }
}

/// Whether two segments, which may be points, meet.
fn meet(one: &[Steps; 2], other: &[Steps; 2]) -> bool {
    let ([p, q], [r, s]) = (one, other);
    let overlap = |k: usize| p[k].min(q[k]) <= r[k].max(s[k]) && r[k].min(s[k]) <= p[k].max(q[k]);
    if !(overlap(0) && overlap(1) && overlap(2)) {
        return false;
    }
    let (d, e, between) = (minus(q, p), minus(s, r), minus(r, p));
    let normal = cross(&d, &e);
    if normal == [0; 3] {
        // Parallel, or one is a point: on one line, where their extents overlap.
        return cross(&between, &d) == [0; 3] && cross(&between, &e) == [0; 3];
    }
    if dot(&normal, &between) != 0 {
        return false;
    }
    let along = largest(&normal);
    let parted = |a: &Steps, b: &Steps, one: &Steps, other: &Steps| {
        turn(along, a, b, one).signum() * turn(along, a, b, other).signum() <= 0
    };
    parted(p, q, r, s) && parted(r, s, p, q)
}

/// Twice the signed area of a triangle in the projection along a coordinate axis.
fn turn(along: usize, a: &Steps, b: &Steps, c: &Steps) -> i128 {
    cross(&minus(b, a), &minus(c, a))[along]
}

/// The coordinate axis along which the projection keeps a plane with this normal a plane.
fn largest(normal: &Wide) -> usize {
    (0..3).max_by_key(|&k| normal[k].abs()).unwrap_or(0)
}

fn normal_of([a, b, c]: &[Steps; 3]) -> Wide {
    cross(&minus(b, a), &minus(c, a))
}

fn minus(p: &Steps, q: &Steps) -> Steps {
    std::array::from_fn(|k| p[k] - q[k])
}

fn cross(d: &Steps, e: &Steps) -> Wide {
    let product = |j: usize, k: usize| i128::from(d[j]) * i128::from(e[k]) - i128::from(d[k]) * i128::from(e[j]);
    [product(1, 2), product(2, 0), product(0, 1)]
}

fn dot(normal: &Wide, d: &Steps) -> i128 {
    normal[0] * i128::from(d[0]) + normal[1] * i128::from(d[1]) + normal[2] * i128::from(d[2])
}
