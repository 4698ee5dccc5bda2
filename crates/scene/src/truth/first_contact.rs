//! First contact: the travel at which `b`, moving in a straight line, touches `a`.
//!
//! In a frame whose z axis is the direction of travel, `b` touches `a` first after the least travel z_a(x, y) - z_b(x, y) over all (x, y)
//! that the projections of both surfaces cover. For two triangles that function is convex and piecewise linear. Its minimum is therefore at
//! a corner of one triangle above the face of the other, or where two edges cross in projection. The search is depth first over pairs of
//! boxes with overlapping projections; of two children, the one that may touch sooner is searched first. A priority queue by lower bound
//! would open fewer pairs, but takes longer.
//!
//! Overlap of projections is decided exactly, for the rotated (rounded) coordinates, so no contact is lost between neighbouring triangles.
//! The travel is accurate to rounding where the surfaces are not nearly parallel to it. Vertices are not snapped here, so the verdict
//! changes within 1e-7 mm of the result.

use super::PairOracle;
use super::boxes::{Bounds, BoxTree, Memo, Mover};
use crate::geometry::{Isometry, Point, Triangle, Vector, rigid};
use nalgebra::{Matrix3, Unit};
use robust::Coord;

impl PairOracle {
    /// The least travel (mm, may be negative) along `direction_in_a`, measured from `a_from_b`, at which the surfaces touch when `b` comes
    /// from infinitely far behind; `None` when `b` passes without contact. A solid of `b` that would enter `a` stops at the surface.
    pub fn first_contact_mm(&self, a_from_b: &Isometry, direction_in_a: &Unit<Vector>) -> Option<f64> {
        let frame = frame_along(direction_in_a);
        let rotation = frame * rigid::rotation(a_from_b);
        let shift = frame * a_from_b.translation.vector;
        let mut a = Moved::new(&self.a.tree, Mover::of(frame, Vector::zeros(), self.a.bounds()));
        let mut b = Moved::new(&self.b.tree, Mover::of(rotation, shift, self.b.bounds()));
        let mut least = f64::INFINITY;
        let mut stack = Vec::new();
        stack.extend(Entry::new(&mut a, 0, &mut b, 0));
        while let Some(Entry { travel, i, j }) = stack.pop() {
            if travel >= least {
                continue;
            }
            let [one, other] = match (a.tree.children(i), b.tree.children(j)) {
                (None, None) => {
                    least = leaves_travel(a.leaf(i), b.leaf(j), least);
                    continue;
                }
                (None, Some([left, right])) => [(i, left), (i, right)],
                (Some(_), Some([left, right])) if a.tree.size(i) <= b.tree.size(j) => [(i, left), (i, right)],
                (Some([left, right]), _) => [(left, j), (right, j)],
            };
            let mut entry = |(i, j)| Entry::new(&mut a, i, &mut b, j).filter(|entry| entry.travel < least);
            let (one, other) = (entry(one), entry(other));
            // The one that may touch sooner is looked at first.
            let sooner = |entry: &Option<Entry>| entry.as_ref().map_or(f64::INFINITY, |entry| entry.travel);
            let ordered = if sooner(&one) < sooner(&other) { [other, one] } else { [one, other] };
            stack.extend(ordered.into_iter().flatten());
        }
        (least < f64::INFINITY).then_some(least)
    }
}

/// A tree in the frame of travel.
struct Moved<'a> {
    tree: &'a BoxTree,
    mover: Mover,
    bounds: Memo<Bounds>,
    /// The triangles of the leaves, each with its box.
    triangles: Memo<(Triangle, Bounds)>,
}

impl<'a> Moved<'a> {
    fn new(tree: &'a BoxTree, mover: Mover) -> Self {
        Self { tree, mover, bounds: Memo::new(tree), triangles: Memo::new(tree) }
    }

    fn bounds(&mut self, node: u32) -> Bounds {
        self.bounds.of(node, 1, |_| self.mover.bounds(&self.tree.nodes[node as usize].bounds))[0]
    }

    fn leaf(&mut self, node: u32) -> &[(Triangle, Bounds)] {
        let range = self.tree.range(node);
        self.triangles.of(node, range.len(), |k| {
            let triangle = self.tree.triangles[range.start + k].map(|point| self.mover.point(point));
            (triangle, Bounds::of(&triangle))
        })
    }
}

/// A pair of nodes and a lower bound on its travel, mm.
struct Entry {
    travel: f64,
    i: u32,
    j: u32,
}

impl Entry {
    /// The entry of a pair of nodes; `None` when the projections of their boxes do not overlap.
    fn new(a: &mut Moved, i: u32, b: &mut Moved, j: u32) -> Option<Self> {
        let (of_a, of_b) = (a.bounds(i), b.bounds(j));
        of_a.overlap_in_xy(&of_b).then(|| Self { travel: of_a.low.z - of_b.high.z, i, j })
    }
}

/// A right-handed rotation whose third row is the direction; for a coordinate axis it only swaps and negates.
fn frame_along(direction: &Unit<Vector>) -> Matrix3<f64> {
    let mut other = Vector::zeros();
    other[direction.iamin()] = 1.0;
    let x = other.cross(direction).normalize();
    Matrix3::from_rows(&[x.transpose(), direction.cross(&x).transpose(), direction.transpose()])
}

/// The least travel over the pairs of triangles of two leaves, mm; `least` when that is smaller.
fn leaves_travel(a: &[(Triangle, Bounds)], b: &[(Triangle, Bounds)], mut least: f64) -> f64 {
    for (moving, of_moving) in b {
        for (still, of_still) in a {
            if of_still.low.z - of_moving.high.z < least && of_still.overlap_in_xy(of_moving) {
                least = least.min(triangles_travel(still, moving));
            }
        }
    }
    least
}

/// The least travel of `moving` along z until it touches `still`, mm; infinite when it passes without contact.
fn triangles_travel(still: &Triangle, moving: &Triangle) -> f64 {
    let Some(of_moving) = areas(still, &moving.corners) else { return f64::INFINITY };
    let Some(of_still) = areas(moving, &still.corners) else { return f64::INFINITY };
    let edge = |t: &Triangle, i: usize| [t.corners[i], t.corners[(i + 1) % 3]];
    let mut least = f64::INFINITY;
    for k in 0..3 {
        if let Some(z) = height_of_face(still, of_moving.map(|of_edge| of_edge[k])) {
            least = least.min(z - moving.corners[k].z);
        }
        if let Some(z) = height_of_face(moving, of_still.map(|of_edge| of_edge[k])) {
            least = least.min(still.corners[k].z - z);
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            let (after_i, after_j) = ((i + 1) % 3, (j + 1) % 3);
            let sides = [of_moving[i][j], of_moving[i][after_j], of_still[j][i], of_still[j][after_i]];
            least = least.min(edges_travel(edge(still, i), edge(moving, j), sides));
        }
    }
    least
}

/// For each edge of the triangle, from corner i to the next, the areas that it spans with three points in projection. `None` when the
/// projections of the points all lie strictly beyond an edge, because then the projections of the triangles are disjoint. Exact.
fn areas(triangle: &Triangle, points: &[Point; 3]) -> Option<[[f64; 3]; 3]> {
    let [a, b, c] = &triangle.corners;
    let [p, q, r] = points;
    let mut areas = [[0.0; 3]; 3];
    for (of_edge, (from, to)) in areas.iter_mut().zip([(a, b), (b, c), (c, a)]) {
        *of_edge = [area(from, to, p), area(from, to, q), area(from, to, r)];
        let all = |sign: f64| of_edge.iter().all(|area| area * sign > 0.0);
        if (all(1.0) && area(a, b, c) <= 0.0) || (all(-1.0) && area(a, b, c) >= 0.0) {
            return None;
        }
    }
    Some(areas)
}

/// Twice the signed area of the projection of the triangle (a, b, c), mm²; its sign is exact.
fn area(a: &Point, b: &Point, c: &Point) -> f64 {
    let coord = |p: &Point| Coord { x: p.x, y: p.y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// The height of the triangle above the projection of a point that spans `areas` with its edges. `None` when the projection is outside, or
/// when the triangle is upright (its edges then give the result).
fn height_of_face(triangle: &Triangle, areas: [f64; 3]) -> Option<f64> {
    let [a, b, c] = &triangle.corners;
    let weights = [areas[1], areas[2], areas[0]];
    let inside = weights.iter().all(|&w| w >= 0.0) || weights.iter().all(|&w| w <= 0.0);
    let total: f64 = weights.iter().sum();
    if !inside || total == 0.0 {
        return None;
    }
    Some((weights[0] * a.z + weights[1] * b.z + weights[2] * c.z) / total)
}

/// The least travel of the edge rs until it touches the edge pq, mm; infinite when it passes without contact. `areas` are those that pq
/// spans with r and s, and rs with p and q.
fn edges_travel([p, q]: [Point; 2], [r, s]: [Point; 2], areas: [f64; 4]) -> f64 {
    let [r_side, s_side, p_side, q_side] = areas;
    let apart = |u: f64, v: f64| (u > 0.0 && v > 0.0) || (u < 0.0 && v < 0.0);
    if apart(r_side, s_side) || apart(p_side, q_side) {
        return f64::INFINITY;
    }
    let parts = |u: f64, v: f64| u != 0.0 || v != 0.0;
    if parts(r_side, s_side) && parts(p_side, q_side) {
        let along = |from: &Point, to: &Point, u: f64, v: f64| from.z + (to.z - from.z) * (u / (u - v));
        return along(&p, &q, p_side, q_side) - along(&r, &s, r_side, s_side);
    }
    // In line in projection, or an upright edge: the least travel is at an end of one of them.
    let ends_of_moving = [r, s].into_iter().filter_map(|end| Some(heights_of_edge(&p, &q, &end)?.0 - end.z));
    let ends_of_still = [p, q].into_iter().filter_map(|end| Some(end.z - heights_of_edge(&r, &s, &end)?.1));
    ends_of_moving.chain(ends_of_still).fold(f64::INFINITY, f64::min)
}

/// The lowest and the highest point of the edge pq above the projection of `end`; `None` when the edge is not above it.
fn heights_of_edge(p: &Point, q: &Point, end: &Point) -> Option<(f64, f64)> {
    let axis = if (q.x - p.x).abs() >= (q.y - p.y).abs() { 0 } else { 1 };
    let between = |i: usize| p[i].min(q[i]) <= end[i] && end[i] <= p[i].max(q[i]);
    if area(p, q, end) != 0.0 || !between(0) || !between(1) {
        return None;
    }
    if p[axis] == q[axis] {
        return Some((p.z.min(q.z), p.z.max(q.z)));
    }
    let z = p.z + (q.z - p.z) * ((end[axis] - p[axis]) / (q[axis] - p[axis]));
    Some((z, z))
}

#[cfg(test)]
mod tests {
    use super::super::solids;
    use super::*;
    use crate::geometry::Mesh;
    use proptest::prelude::*;
    use std::sync::Arc;

    fn oracle(a: Mesh, b: Mesh) -> PairOracle {
        PairOracle::new(Arc::new(a), Arc::new(b))
    }

    fn at(x: f64, y: f64, z: f64) -> Isometry {
        Isometry::translation(x, y, z)
    }

    #[test]
    fn boxes_meet_after_the_gap_between_them() {
        let pair = oracle(solids::block(4.0, 6.0, 8.0), solids::block(2.0, 2.0, 2.0));
        for (from, direction, travel) in [
            (at(-10.0, 0.5, 0.25), Vector::x(), Some(10.0 - 2.0 - 1.0)),
            (at(10.0, 0.5, 0.25), Vector::x(), Some(-10.0 - 2.0 - 1.0)), // comes from behind: already past
            (at(0.0, 10.0, 0.0), -Vector::y(), Some(10.0 - 3.0 - 1.0)),
            (at(0.0, 0.0, 20.0), -Vector::z(), Some(20.0 - 4.0 - 1.0)),
            (at(-10.0, 4.0, 0.0), Vector::x(), Some(7.0)), // side faces slide along each other: touching counts
            (at(-10.0, 4.0, 5.0), Vector::x(), Some(7.0)), // only two edges are in line
            (at(-10.0, 4.0001, 0.0), Vector::x(), None),
            (at(-10.0, 0.0, 0.0), Vector::z(), None),
        ] {
            let found = pair.first_contact_mm(&from, &Unit::new_normalize(direction));
            assert_eq!(found, travel, "{from} {direction}");
        }
    }

    #[test]
    fn an_edge_meets_an_edge_across() {
        // Two bars with square section, turned to stand on an edge, crossing at right angles: the edges meet when the
        // axes are √2·1 + √2·1 apart.
        let bar = solids::block(20.0, 2.0, 2.0);
        let stand = nalgebra::UnitQuaternion::from_axis_angle(&Vector::x_axis(), std::f64::consts::FRAC_PI_4);
        let turned = bar.vertices().iter().map(|p| stand * p).collect();
        let bar = Mesh::new(turned, bar.faces().to_vec()).unwrap();
        let pair = oracle(bar.clone(), bar);
        let pose = Isometry::new(Vector::new(0.3, 0.2, 10.0), Vector::z() * std::f64::consts::FRAC_PI_2);
        let travel = pair.first_contact_mm(&pose, &-Vector::z_axis()).unwrap();
        assert!((travel - (10.0 - 2.0 * 2f64.sqrt())).abs() < 1e-7, "{travel}"); // vertices were snapped
    }

    #[test]
    fn balls_meet_pole_to_pole() {
        let pair = oracle(solids::ball(3.0, 16), solids::ball(2.0, 12));
        let travel = pair.first_contact_mm(&at(0.0, 0.0, -50.0), &Vector::z_axis()).unwrap();
        assert!((travel - 45.0).abs() < 1e-9, "{travel}");
    }

    #[test]
    fn a_slanted_edge_is_met_where_it_is_crossed() {
        let still = Triangle::new(Point::new(0.0, 0.0, 0.0), Point::new(4.0, 0.0, 8.0), Point::new(0.0, -1.0, 50.0));
        let moving = Triangle::new(Point::new(1.0, -1.0, 0.0), Point::new(1.0, 1.0, -4.0), Point::new(1.0, 9.0, -90.0));
        // Over (1, 0) the edge of the still one is at 8/4 and that of the moving one at -2.
        assert!((triangles_travel(&still, &moving) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn upright_triangles_in_line_meet_at_a_corner() {
        let still = Triangle::new(Point::new(1.0, 0.0, 5.0), Point::new(2.0, 0.0, 7.0), Point::new(2.0, 0.0, 9.0));
        let moving = Triangle::new(Point::new(0.0, 0.0, 0.0), Point::new(3.0, 0.0, 3.0), Point::new(3.0, 0.0, -3.0));
        assert_eq!(triangles_travel(&still, &moving), 4.0); // at x = 1: 5 - 1
        assert_eq!(triangles_travel(&still, &moving.map(|p| p + Vector::y())), f64::INFINITY);
    }

    #[test]
    fn frames_are_rotations_along_the_direction() {
        for v in [Vector::x(), -Vector::y(), Vector::z(), Vector::new(1.0, -2.0, 0.5), Vector::new(1.0, 1.0, 1.0)] {
            let direction = Unit::new_normalize(v);
            let frame = frame_along(&direction);
            assert!((frame * *direction - Vector::z()).amax() < 1e-15);
            assert!((frame.determinant() - 1.0).abs() < 1e-15);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn free_before_and_touching_just_after(
            turn in prop::array::uniform3(-3.0..3.0f64),
            start in prop::array::uniform3(-6.0..6.0f64),
            toward in prop::array::uniform3(-1.0..1.0f64),
            which in 0..3usize,
        ) {
            let torus = || solids::torus(8.0, 2.0, 24, 12);
            let pair = match which {
                0 => oracle(torus(), solids::ball(3.0, 8)),
                1 => oracle(solids::block(9.0, 5.0, 3.0), torus()),
                _ => oracle(solids::block(9.0, 5.0, 3.0), solids::block(2.0, 4.0, 7.0)),
            };
            let direction = Unit::try_new(Vector::from(toward), 0.1).unwrap_or(Vector::x_axis());
            let pose = Isometry::new(Vector::from(start), Vector::from(turn));
            let travelled = |t: f64| Isometry::translation(direction.x * t, direction.y * t, direction.z * t) * pose;
            match pair.first_contact_mm(&pose, &direction) {
                Some(travel) => {
                    prop_assert!(!pair.touches(&travelled(travel - 1e-6)));
                    prop_assert!(pair.touches(&travelled(travel + 1e-6)));
                    for k in 1..100 {
                        prop_assert!(!pair.touches(&travelled(travel - f64::from(k) * 0.3)));
                    }
                }
                None => {
                    for k in -100..100 {
                        prop_assert!(!pair.touches(&travelled(f64::from(k) * 0.3)));
                    }
                }
            }
        }
    }
}
