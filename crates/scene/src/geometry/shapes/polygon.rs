//! Closed polygons in a plane: exact simplicity tests, containment, mitred insets.

use super::error::{Fault, ShapeError};
use nalgebra::{Point2, Vector2};
use robust::{Coord, orient2d};

/// A point of a plane, mm.
pub(super) type P2 = Point2<f64>;
/// A closed polygon: an edge joins the last point to the first. Counter-clockwise unless stated otherwise.
pub(super) type Polygon = Vec<P2>;

/// Twice the signed area of the triangle abc; the sign is exact (Shewchuk 1997).
fn orient(a: &P2, b: &P2, c: &P2) -> f64 {
    let coord = |p: &P2| Coord { x: p.x, y: p.y };
    orient2d(coord(a), coord(b), coord(c))
}

/// Signed area, mm²; positive when counter-clockwise.
pub(super) fn area(polygon: &[P2]) -> f64 {
    let origin = polygon[0];
    let cross = |a: &P2, b: &P2| (a - origin).perp(&(b - origin));
    edges(polygon).map(|(a, b)| cross(&a, &b)).sum::<f64>() / 2.0
}

/// The edges, from each point to the next.
pub(super) fn edges(polygon: &[P2]) -> impl Iterator<Item = (P2, P2)> + '_ {
    polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(&a, &b)| (a, b))
}

/// Smallest distance of a point from the edges, mm.
pub(super) fn distance(polygon: &[P2], point: &P2) -> f64 {
    let squared = edges(polygon).map(|(a, b)| {
        let (along, to) = (b - a, point - a);
        let t = (along.dot(&to) / along.norm_squared()).clamp(0.0, 1.0);
        (to - along * t).norm_squared()
    });
    squared.fold(f64::INFINITY, f64::min).sqrt()
}

/// Whether a point is inside, by crossing parity; undefined on the edges.
pub(super) fn contains(polygon: &[P2], point: &P2) -> bool {
    let crosses = |(a, b): &(P2, P2)| (a.y > point.y) != (b.y > point.y) && (orient(a, b, point) > 0.0) == (b.y > a.y);
    edges(polygon).filter(crosses).count() % 2 == 1
}

/// Whether two closed segments share a point.
fn segments_meet((a, b): (&P2, &P2), (c, d): (&P2, &P2)) -> bool {
    let (s1, s2) = (orient(a, b, c), orient(a, b, d));
    let (s3, s4) = (orient(c, d, a), orient(c, d, b));
    if s1 == 0.0 && s2 == 0.0 {
        // On one line: they meet when their intervals do.
        let overlap = |i: usize| a[i].max(b[i]) >= c[i].min(d[i]) && c[i].max(d[i]) >= a[i].min(b[i]);
        return overlap(0) && overlap(1);
    }
    let apart = |s: f64, t: f64| (s > 0.0 && t > 0.0) || (s < 0.0 && t < 0.0);
    !apart(s1, s2) && !apart(s3, s4)
}

/// An edge, with the number of its loop and its position in that loop.
struct Edge {
    ends: (P2, P2),
    of: usize,
    index: usize,
    count: usize,
}

impl Edge {
    /// Whether two edges share a point that is not a common corner.
    fn offends(&self, other: &Self) -> bool {
        let (a, b) = (&self.ends, &other.ends);
        if self.of == other.of {
            let next = |e: &Self| (e.index + 1) % e.count;
            // Neighbours share one point, and must share no more.
            if next(self) == other.index {
                return doubles_back(&a.0, &a.1, &b.1);
            }
            if next(other) == self.index {
                return doubles_back(&b.0, &b.1, &a.1);
            }
        }
        segments_meet((&a.0, &a.1), (&b.0, &b.1))
    }
}

/// Whether the path a, b, c reverses direction at b.
fn doubles_back(a: &P2, b: &P2, c: &P2) -> bool {
    orient(a, b, c) == 0.0 && (b - a).dot(&(c - b)) <= 0.0
}

/// Checks that closed polygons neither cross nor touch themselves or one another.
pub(super) fn check_disjoint(field: &str, loops: &[Polygon]) -> Result<(), ShapeError> {
    let mut all = Vec::new();
    for (of, polygon) in loops.iter().enumerate() {
        if polygon.len() < 3 {
            return Err(Fault::TooFewPoints(polygon.len()).at(field));
        }
        let count = polygon.len();
        all.extend(edges(polygon).enumerate().map(|(index, ends)| Edge { ends, of, index, count }));
    }
    let left = |e: &Edge| e.ends.0.x.min(e.ends.1.x);
    let right = |e: &Edge| e.ends.0.x.max(e.ends.1.x);
    all.sort_by(|a, b| left(a).total_cmp(&left(b)));
    for (i, a) in all.iter().enumerate() {
        for b in all[i + 1..].iter().take_while(|b| left(b) <= right(a)) {
            if a.offends(b) {
                return Err(Fault::Crossing { x: a.ends.0.x, y: a.ends.0.y }.at(field));
            }
        }
    }
    Ok(())
}

/// Moves every point inwards (of a counter-clockwise polygon) along its mitre, so that every edge moves by `width` mm; a negative width
/// moves outwards. `None` when an edge would vanish or reverse, or a corner is too sharp to mitre.
pub(super) fn inset(polygon: &[P2], width: f64) -> Option<Polygon> {
    /// Smallest permitted 1 + cos of the turning angle; 0.01 corresponds to a corner of about 8°.
    const SHARPEST: f64 = 0.01;
    let inward = |(from, to): (P2, P2)| {
        let along = (to - from).normalize();
        Vector2::new(-along.y, along.x)
    };
    let after: Vec<Vector2<f64>> = edges(polygon).map(inward).collect();
    let before = after.iter().cycle().skip(after.len() - 1);
    let mut moved = Vec::with_capacity(polygon.len());
    for ((point, after), before) in polygon.iter().zip(&after).zip(before) {
        let scale = 1.0 + before.dot(after);
        if scale < SHARPEST {
            return None;
        }
        moved.push(point + (before + after) * (width / scale));
    }
    let keeps_its_way = |((a, b), (c, d)): ((P2, P2), (P2, P2))| (b - a).dot(&(d - c)) > 0.0;
    let valid = edges(polygon).zip(edges(&moved)).all(keeps_its_way);
    valid.then_some(moved)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(points: &[[f64; 2]]) -> Polygon {
        points.iter().map(|p| P2::new(p[0], p[1])).collect()
    }

    #[test]
    fn a_square_has_its_area_and_its_inset() {
        let square = polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
        assert_eq!(area(&square), 16.0);
        assert_eq!(area(&inset(&square, 1.0).unwrap()), 4.0); // (4 - 2)²
        assert_eq!(area(&inset(&square, -1.0).unwrap()), 36.0);
        assert_eq!(inset(&square, 2.0), None);
        assert!(contains(&square, &P2::new(1.0, 3.0)) && !contains(&square, &P2::new(5.0, 3.0)));
        assert_eq!(distance(&square, &P2::new(7.0, 8.0)), 5.0);
        assert!(check_disjoint("x", &[square]).is_ok());
    }

    #[test]
    fn crossing_touching_and_doubling_back_are_found() {
        let bow = polygon(&[[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]]);
        let pinched = polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 0.0], [0.0, 4.0]]);
        let spike = polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [4.0, 2.0], [0.0, 2.0]]);
        for bad in [bow, pinched, spike] {
            assert!(matches!(check_disjoint("x", &[bad]), Err(ShapeError { fault: Fault::Crossing { .. }, .. })));
        }
        let square = polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
        let inner = polygon(&[[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]);
        assert!(check_disjoint("x", &[square.clone(), inner]).is_ok());
        let touching = polygon(&[[4.0, 1.0], [5.0, 1.0], [5.0, 2.0]]);
        assert!(check_disjoint("x", &[square, touching]).is_err());
    }
}
