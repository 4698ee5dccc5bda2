//! The smallest rectangle around points of a plane.
//!
//! H. Freeman, R. Shapira, "Determining the Minimum-Area Encasing Rectangle for an Arbitrary Closed Curve", 1975: one side lies along an
//! edge of the convex hull. Deviation: the extents are computed anew for each edge, without rotating calipers, so a rounding error at one
//! edge does not affect the next.

use super::hull::around;
use robust::{Coord, orient2d};

/// A rectangle, given by the direction of one side and its area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Unit direction of one side; the other is a quarter turn counter-clockwise.
    pub along: [f64; 2],
    /// Area including the margin on all four sides, mm².
    pub area: f64,
}

/// The rectangle of least area around `points` (mm) with `margin` (mm) on each side, among the rectangles with a side along an edge of the
/// convex hull. `None` when all points coincide.
pub fn smallest(points: &[[f64; 2]], margin: f64) -> Option<Rectangle> {
    let corners = hull(points);
    let mut best: Option<Rectangle> = None;
    for (i, p) in corners.iter().enumerate() {
        let q = corners[(i + 1) % corners.len()];
        let edge = [q[0] - p[0], q[1] - p[1]];
        let length = edge[0].hypot(edge[1]);
        if length == 0.0 {
            continue;
        }
        let along = edge.map(|x| x / length);
        let across = [-along[1], along[0]];
        let extent = |d: [f64; 2]| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for c in &corners {
                let x = (c[0] - p[0]) * d[0] + (c[1] - p[1]) * d[1];
                (low, high) = (low.min(x), high.max(x));
            }
            high - low + 2.0 * margin
        };
        let area = extent(along) * extent(across);
        if best.is_none_or(|known| area < known.area) {
            best = Some(Rectangle { along, area });
        }
    }
    best
}

/// The corners of the convex hull, counter-clockwise; one or two points when all points are collinear.
fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let coord = |p: &[f64; 2]| Coord { x: p[0], y: p[1] };
    around(&sorted, |q, r, p| orient2d(coord(q), coord(r), coord(p)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_rectangle_is_its_own() {
        let (c, s) = (0.8, 0.6);
        let turned = |x: f64, y: f64| [c * x - s * y, s * x + c * y];
        let points = [turned(0.0, 0.0), turned(7.0, 0.0), turned(7.0, 2.0), turned(0.0, 2.0), turned(3.0, 1.0)];
        let found = smallest(&points, 0.0).unwrap();
        assert!((found.area - 14.0).abs() < 1e-12);
        let along = (found.along[0] * c + found.along[1] * s).abs();
        assert!(along < 1e-12 || (along - 1.0).abs() < 1e-12);
        assert!((smallest(&points, 0.5).unwrap().area - 8.0 * 3.0).abs() < 1e-12);
    }

    #[test]
    fn an_equilateral_triangle_needs_twice_its_area() {
        let h = 3.0_f64.sqrt() / 2.0;
        let found = smallest(&[[0.0, 0.0], [1.0, 0.0], [0.5, h]], 0.0).unwrap();
        assert!((found.area - h).abs() < 1e-12); // base 1, height √3/2: twice the area √3/4
    }

    #[test]
    fn points_on_a_line_make_a_rectangle_of_the_margin() {
        let found = smallest(&[[0.0, 0.0], [3.0, 4.0], [1.5, 2.0]], 0.1).unwrap();
        assert!((found.area - 5.2 * 0.2).abs() < 1e-12);
        assert_eq!(smallest(&[[1.0, 1.0]; 4], 0.1), None);
    }
}
