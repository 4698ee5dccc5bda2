//! DiTO-14: axes from two tetrahedra over one large triangle of extreme points.
//!
//! T. Larsson, L. Källberg, "Fast Computation of Tight-Fitting Oriented Bounding Boxes", Game Engine Gems 2, 2011, chapter 1.
//! Extreme corners are taken along the three coordinate axes and the four space diagonals, 14 in all. The base triangle consists of the two
//! corners farthest apart and the corner farthest from their line. Together with the corners farthest above and below it, it gives up to
//! seven triangles. Each triangle gives three candidate frames (its normal and one of its edges). The frame in which the box of the 14
//! corners has the least surface area wins, unless the box along the coordinate axes is smaller over all corners. Deviations: areas include
//! the pad of the stored boxes, which distinguishes boxes of flat contents; of equally extreme corners, the first is taken.

use super::frame::{FrameRule, any_frame, reach_mm};
use crate::geometry::separating_axes::pad_mm;
use crate::geometry::{Point, Triangle, Vector, covariance, triangle};
use nalgebra::Matrix3;

/// The seven directions. The diagonals are not normalised, because only the order of corners along each direction matters.
const DIRECTIONS: [[f64; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
];

/// Heights and lengths below this fraction of the contents' size count as zero, because a frame from them would be rounding error.
const DEGENERATE: f64 = 1e-9;

/// Axes by DiTO-14.
#[derive(Clone, Copy, Debug)]
pub struct Dito14;

impl FrameRule for Dito14 {
    /// The mean of this rule is the mean of the corners.
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (mean, _) = covariance::vertex_weighted(triangles);
        (mean, axes(triangles))
    }
}

/// The axes that DiTO-14 chooses, as columns of a rotation.
fn axes(triangles: &[Triangle]) -> Matrix3<f64> {
    let pad = pad_mm(reach_mm(triangles));
    let extreme = extreme_corners(triangles);
    let all: Vec<Point> = triangle::corners(triangles).copied().collect();
    let candidates = frames(&extreme, &all);
    let mut best = (f64::INFINITY, Matrix3::identity());
    for frame in candidates {
        let area = half_area(&frame, &extreme, pad);
        if area < best.0 {
            best = (area, frame);
        }
    }
    if half_area(&Matrix3::identity(), &all, pad) <= half_area(&best.1, &all, pad) {
        return Matrix3::identity();
    }
    best.1
}

/// The corners with the smallest and the largest coordinate along each direction.
fn extreme_corners(triangles: &[Triangle]) -> [Point; 14] {
    let first = triangles[0].corners[0];
    let mut extreme = [first; 14];
    let mut value = [[f64::INFINITY, f64::NEG_INFINITY]; 7];
    for corner in triangle::corners(triangles) {
        for (k, direction) in DIRECTIONS.iter().enumerate() {
            let x = Vector::from(*direction).dot(&corner.coords);
            if x < value[k][0] {
                (value[k][0], extreme[2 * k]) = (x, *corner);
            }
            if x > value[k][1] {
                (value[k][1], extreme[2 * k + 1]) = (x, *corner);
            }
        }
    }
    extreme
}

/// The candidate frames; empty when all corners coincide.
fn frames(extreme: &[Point; 14], all: &[Point]) -> Vec<Matrix3<f64>> {
    let pairs = extreme.chunks_exact(2).map(|pair| (pair[0], pair[1]));
    let Some((p0, p1)) = pairs.max_by(|a, b| (a.1 - a.0).norm_squared().total_cmp(&(b.1 - b.0).norm_squared())) else {
        return Vec::new();
    };
    let size = (p1 - p0).norm();
    let Some(e0) = (p1 - p0).try_normalize(0.0) else { return Vec::new() };
    let off_line = |p: &Point| e0.cross(&(p - p0)).norm();
    let Some(p2) = extreme.iter().copied().max_by(|a, b| off_line(a).total_cmp(&off_line(b))) else {
        return Vec::new();
    };
    if off_line(&p2) <= DEGENERATE * size {
        return vec![any_frame(&e0)];
    }
    let normal = (p1 - p0).cross(&(p2 - p0)).normalize();
    let height = |p: &Point| normal.dot(&(p - p0));
    let mut found = Vec::new();
    push_frames(&mut found, [p0, p1, p2]);
    let top = all.iter().copied().max_by(|a, b| height(a).total_cmp(&height(b)));
    let bottom = all.iter().copied().min_by(|a, b| height(a).total_cmp(&height(b)));
    for apex in [top, bottom].into_iter().flatten().filter(|p| height(p).abs() > DEGENERATE * size) {
        for [a, b] in [[p0, p1], [p1, p2], [p2, p0]] {
            push_frames(&mut found, [a, b, apex]);
        }
    }
    found
}

/// The three frames of a triangle that have its normal and one of its edges for axes.
fn push_frames(found: &mut Vec<Matrix3<f64>>, [a, b, c]: [Point; 3]) {
    let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { return };
    for edge in [b - a, c - b, a - c] {
        if let Some(along) = (edge - normal * edge.dot(&normal)).try_normalize(0.0) {
            found.push(Matrix3::from_columns(&[along, normal.cross(&along), normal]));
        }
    }
}

/// Half the surface area of the box around the points, widened by `pad` on all sides, mm².
fn half_area(frame: &Matrix3<f64>, points: &[Point], pad: f64) -> f64 {
    let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    for p in points {
        let x = frame.tr_mul(&(p - points[0]));
        (low, high) = (low.inf(&x), high.sup(&x));
    }
    let size = (high - low).add_scalar(2.0 * pad);
    size.x * size.y + size.y * size.z + size.z * size.x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Isometry;
    use obbtree::cases::Draw;
    use obbtree::cases::meshes;

    #[test]
    fn a_turned_cuboid_gets_its_own_axes() {
        let turn = Isometry::rotation(Vector::new(0.4, -0.9, 0.5));
        let triangles = meshes::moved(&meshes::cuboid(20.0, 12.0, 5.0), 1.0, &turn).triangles();
        let axes = axes(&triangles);
        // Half of 2 (20·12 + 12·5 + 5·20).
        let corners: Vec<Point> = triangle::corners(&triangles).copied().collect();
        assert!((half_area(&axes, &corners, 0.0) - 400.0).abs() < 1e-4);
    }

    #[test]
    fn the_extreme_corners_are_those_of_fourteen_directions() {
        let random = (0..30).map(|k| {
            let mut draw = Draw::new(3, &["dito"], k);
            let [a, b, c] = [0; 3].map(|_| Point::from(draw.in_ball() * 9.0));
            Triangle::new(a, b, c)
        });
        let triangles: Vec<Triangle> = random.collect();
        for (k, direction) in DIRECTIONS.iter().enumerate() {
            let height = |p: &Point| Vector::from(*direction).dot(&p.coords);
            let extreme = extreme_corners(&triangles);
            let all = || triangle::corners(&triangles).map(height);
            assert_eq!(height(&extreme[2 * k]), all().fold(f64::INFINITY, f64::min));
            assert_eq!(height(&extreme[2 * k + 1]), all().fold(f64::NEG_INFINITY, f64::max));
        }
    }

    #[test]
    fn frames_are_those_of_the_base_and_of_what_stands_on_it() {
        let p = |x: f64, y: f64, z: f64| Point::new(x, y, z);
        let base = [p(0.0, 0.0, 0.0), p(10.0, 0.0, 0.0), p(3.0, 6.0, 0.0)];
        let [above, below] = [p(4.0, 1.0, 2.0), p(4.0, 2.0, -1.0)];
        // Three for each triangle: the base alone, and three more on it for each side with a corner.
        for (more, count) in [(vec![], 3), (vec![above], 12), (vec![above, below], 21)] {
            let all: Vec<Point> = base.into_iter().chain(more).collect();
            let triangles: Vec<Triangle> = all.iter().map(|&q| Triangle::new(q, q, q)).collect();
            let found = frames(&extreme_corners(&triangles), &all);
            assert_eq!(found.len(), count);
            for frame in &found {
                assert!((frame.tr_mul(frame) - Matrix3::identity()).amax() < 1e-12 && frame.determinant() > 0.0);
            }
            // The first is the base's own: its longest edge, and its normal.
            assert!(found[0].column(0).x.abs() > 1.0 - 1e-12 && found[0].column(2).z.abs() > 1.0 - 1e-12);
            // Every one has an edge between corners along its first axis, and another one square to its last.
            for frame in found {
                let edges = || all.iter().flat_map(|a| all.iter().map(move |b| (b - a).normalize()));
                assert!(edges().any(|e| frame.column(0).dot(&e) > 1.0 - 1e-12));
                assert!(edges().filter(|e| frame.column(2).dot(e).abs() < 1e-12).count() >= 6);
            }
        }
        let cuboid: Vec<Point> = triangle::corners(&meshes::cuboid(1.0, 2.0, 3.0).triangles()).copied().collect();
        assert!((half_area(&Matrix3::identity(), &cuboid, 0.5) - (2.0 * 3.0 + 3.0 * 4.0 + 4.0 * 2.0)).abs() < 1e-12);
    }

    #[test]
    fn the_coordinate_axes_are_kept_where_they_are_better() {
        assert_eq!(axes(&meshes::cuboid(3.0, 4.0, 5.0).triangles()), Matrix3::identity());
    }

    #[test]
    fn points_and_segments_have_frames() {
        let (p, q) = (Point::new(1.0, 2.0, 3.0), Point::new(4.0, 6.0, 3.0));
        for triangles in [[Triangle::new(p, p, p)], [Triangle::new(p, q, p)]] {
            let axes = axes(&triangles);
            assert!((axes.tr_mul(&axes) - Matrix3::identity()).amax() < 1e-12 && axes.determinant() > 0.0);
        }
        assert!((axes(&[Triangle::new(p, q, p)]).tr_mul(&Vector::new(0.6, 0.8, 0.0)).amax() - 1.0).abs() < 1e-12);
    }
}
