//! The surface as points: a mesh sampled so densely that every point of it is within a given radius of a sample.

use crate::geometry::{Mesh, Point, Triangle};
use foldhash::{HashSet, HashSetExt};

/// Samples of a surface, in its mesh's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// The samples, mm.
    pub points: Vec<Point>,
    /// The triangle of each sample; for a sample on an edge, one of its triangles.
    pub faces: Vec<u32>,
    /// Covering radius, mm: every point of the surface is within this distance of a sample.
    pub covering_mm: f64,
    /// The longest edge between samples, mm.
    pub spacing_mm: f64,
}

/// Relative enlargement of the covering radius. Midpoints are rounded by half a unit in the last place at each of at most 52 halvings, and
/// points on the sides of strips by two units.
const ROUNDING: f64 = 1e-12;

impl Samples {
    /// Divides triangles until no edge is longer than `spacing_mm` (or the mesh's coordinates are too coarse to halve it), and takes all
    /// corners as samples. Thin triangles are divided into strips, others in two at the middle of the longest edge. Every edge is divided
    /// into halves, quarters and so on, so the two triangles at an edge have most samples on it in common.
    pub fn of(mesh: &Mesh, spacing_mm: f64) -> Self {
        let mut samples = Self { points: Vec::new(), faces: Vec::new(), covering_mm: 0.0, spacing_mm: 0.0 };
        let mut seen = HashSet::new();
        let mut stack = Vec::new();
        for (triangle, face) in mesh.triangles().into_iter().zip(0..) {
            stack.push(triangle.corners);
            while let Some([a, b, c]) = stack.pop() {
                let lengths = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
                let longest = lengths.iter().copied().fold(0.0, f64::max);
                // The longest edge first: from a to b.
                let first = (0..3).find(|&edge| lengths[edge] == longest).unwrap_or(0);
                let [a, b, c] = [0, 1, 2].map(|k| [a, b, c][(first + k) % 3]);
                let [_, from_b, from_a] = [0, 1, 2].map(|k| lengths[(first + k) % 3]);
                let middle = nalgebra::center(&a, &b);
                if longest > spacing_mm && middle != a && middle != b {
                    let shortest = from_b.min(from_a);
                    if THIN * shortest < longest {
                        let [apex, p, q] = if from_b < from_a { [a, b, c] } else { [b, c, a] };
                        let count = (longest / shortest.max(spacing_mm)).min(MOST_STRIPS).ceil() as u32;
                        strips(apex, p, q, count, &mut stack);
                        continue;
                    }
                    stack.extend([[a, middle, c], [middle, b, c]]);
                    continue;
                }
                samples.spacing_mm = samples.spacing_mm.max(longest);
                samples.covering_mm = samples.covering_mm.max(farthest_from_corners(&Triangle::new(a, b, c)));
                for corner in [a, b, c] {
                    // Adding zero makes one of the two zeros.
                    let key = [corner.x, corner.y, corner.z].map(|x| (x + 0.0).to_bits());
                    if seen.insert(key) {
                        samples.points.push(corner);
                        samples.faces.push(face);
                    }
                }
            }
        }
        samples.covering_mm *= 1.0 + ROUNDING;
        samples
    }
}

/// A triangle is thin when its longest edge is more than this many times as long as its shortest.
const THIN: f64 = 2.0;
/// Most strips into which a triangle is divided at once; each strip is divided further.
const MOST_STRIPS: f64 = 1024.0;

/// Divides a triangle along lines parallel to its shortest edge pq into at least `count` strips, and the strips into triangles. Halving its
/// longest edge n times would make 3ⁿ triangles, because the other long edge must follow; strips make 2·2ⁿ.
fn strips(apex: Point, p: Point, q: Point, count: u32, parts: &mut Vec<[Point; 3]>) {
    let count = count.next_power_of_two().max(2);
    let at =
        |end: Point, k: u32| if k == count { end } else { apex + (end - apex) * (f64::from(k) / f64::from(count)) };
    parts.push([apex, at(p, 1), at(q, 1)]);
    for k in 1..count {
        let (near, far) = ([at(p, k), at(q, k)], [at(p, k + 1), at(q, k + 1)]);
        parts.extend([[near[0], far[0], far[1]], [near[0], far[1], near[1]]]);
    }
}

/// A bound on the distance of a point of the triangle from its nearest corner, mm. For an acute triangle it is the circumradius; otherwise
/// it is half the longest edge, whose middle is nearer to the third corner than to the others.
fn farthest_from_corners(triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.corners;
    let mut squares = [(b - a).norm_squared(), (c - b).norm_squared(), (a - c).norm_squared()];
    squares.sort_by(f64::total_cmp);
    let [short, middle, long] = squares;
    if long >= short + middle {
        return 0.5 * long.sqrt();
    }
    let around = (short * middle * long).sqrt() / (4.0 * triangle.area());
    // No acute triangle has a larger circle than the equilateral one over its longest edge.
    around.min((long / 3.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Triangle;
    use obbtree::cases::meshes;
    use proptest::prelude::*;

    #[test]
    fn a_square_of_two_triangles_has_its_grid_once() {
        let [a, b, c, d] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| Point::new(x, y, 0.0));
        let mesh = Mesh::from_triangles(&[Triangle::new(a, b, c), Triangle::new(a, c, d)]).unwrap();
        // The diagonal of 2.83 is halved, then the sides of 2, then the halves of the diagonal, 1.41: a grid of 3 x 3 and the middles
        // of its 4 squares. What is left are right angles with legs of 0.71 under an edge of 1, whose middle is 0.5 from all corners.
        let samples = Samples::of(&mesh, 1.0);
        assert_eq!(samples.points.len(), 13);
        assert!((samples.spacing_mm - 1.0).abs() < 1e-15 && (samples.covering_mm - 0.5).abs() < 1e-11);
        let mut seen: Vec<_> = samples.points.iter().map(|p| [p.x, p.y].map(|x| (2.0 * x).round() as i32)).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 13);
        assert_eq!(Samples::of(&mesh, 10.0).points.len(), 4);
    }

    #[test]
    fn thin_triangles_do_not_get_a_grid() {
        let thin = Triangle::new(Point::origin(), Point::new(100.0, 0.0, 0.0), Point::new(100.0, 0.01, 0.0));
        let mesh = Mesh::from_triangles(&[thin]).unwrap();
        // 128 strips, so 129 points on each of the long edges, one of them common; a grid of equal triangles would have 129 * 130 / 2.
        let samples = Samples::of(&mesh, 1.0);
        assert_eq!(samples.points.len(), 257);
        assert!(samples.spacing_mm <= 1.0 && samples.covering_mm < 0.4, "{}", samples.covering_mm);
    }

    #[test]
    fn the_equilateral_triangle_is_the_worst() {
        let height = 0.75f64.sqrt();
        let corners = |x: f64, y: f64| Triangle::new(Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(x, y, 0.0));
        assert!((farthest_from_corners(&corners(0.5, height)) - 1.0 / 3f64.sqrt()).abs() < 1e-12);
        // A right angle across an edge of 1; an obtuse one; a line.
        assert!((farthest_from_corners(&corners(0.5, 0.5)) - 0.5).abs() < 1e-12);
        assert!((farthest_from_corners(&corners(0.5, 0.1)) - 0.5).abs() < 1e-12);
        assert!((farthest_from_corners(&corners(0.5, 0.0)) - 0.5).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn no_point_of_the_surface_is_farther_than_the_covering_radius(
            spacing in 0.3..8.0f64, face in 0..10_000usize, u in 0.0..1.0f64, v in 0.0..1.0f64, thin in prop::bool::ANY,
        ) {
            // Of 90 sides the caps are fans of thin triangles.
            let mesh = if thin { meshes::stepped_tool(90, 2) } else { meshes::stepped_tool(12, 3) };
            let samples = Samples::of(&mesh, spacing);
            let triangle = mesh.triangles()[face % mesh.faces().len()];
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let [a, b, c] = triangle.corners;
            let p = a + (b - a) * u + (c - a) * v;
            let nearest = samples.points.iter().map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest <= samples.covering_mm + 1e-12, "{nearest} > {}", samples.covering_mm);
            prop_assert!(samples.spacing_mm <= spacing);
        }
    }
}
