//! The distance of two rectangles in space.
//!
//! The problem is that of E. Larsen, S. Gottschalk, M. C. Lin, D. Manocha, "Fast Proximity Queries with Swept Sphere Volumes", TR99-018,
//! 1999, section 3. Deviation: they walk through the pairs of edges by their Voronoi regions. Here all candidates for the nearest points
//! are tried: a corner of one rectangle and any point of the other (8), or inner points of two edges (16). The direction perpendicular to
//! two edges comes from their cross product, never from a difference of squares, which for edges within 1e-8 rad of parallel is nothing but
//! rounding error.

use crate::geometry::Vector;
use nalgebra::Matrix3;

/// Edges whose directions differ by less than this angle, rad, count as parallel, so one of their ends is a nearest point. Over 10 m the
/// error is 1e-10 mm.
const PARALLEL: f64 = 1e-14;

/// Squared distance between two rectangles, mm². The first is centred at the origin, along x and y, with half-lengths `a`; the second is
/// centred at `t`, along the first two columns of the rotation `r`, with half-lengths `b`, all in mm. 0 when they touch.
pub fn squared(t: &Vector, r: &Matrix3<f64>, a: [f64; 2], b: [f64; 2]) -> f64 {
    let from_b = |p: &Vector| r.tr_mul(&(p - t));
    let corners_of_b = corners(b).map(|c| t + r * c);
    let corners_of_a = corners(a).map(|c| from_b(&c));
    if pierces(&corners_of_b, a) || pierces(&corners_of_a, b) {
        return 0.0;
    }
    let to_a = corners_of_b.iter().map(|c| point_squared(c, a));
    let to_b = corners_of_a.iter().map(|c| point_squared(c, b));
    let least = to_a.chain(to_b).fold(f64::INFINITY, f64::min);
    (0..2).flat_map(|i| [(i, 0), (i, 1)]).fold(least, |least, (i, j)| least.min(edges_squared(t, r, (a, i), (b, j))))
}

/// The corners of a rectangle about the origin, in order around it.
fn corners([x, y]: [f64; 2]) -> [Vector; 4] {
    [Vector::new(-x, -y, 0.0), Vector::new(x, -y, 0.0), Vector::new(x, y, 0.0), Vector::new(-x, y, 0.0)]
}

/// Square of the distance of a point from the rectangle about the origin, mm².
pub fn point_squared(p: &Vector, half: [f64; 2]) -> f64 {
    let (x, y) = ((p.x.abs() - half[0]).max(0.0), (p.y.abs() - half[1]).max(0.0));
    x * x + y * y + p.z * p.z
}

/// Whether an edge of the loop passes through the rectangle about the origin.
fn pierces(corners: &[Vector; 4], half: [f64; 2]) -> bool {
    (0..4).any(|i| {
        let (p, q) = (&corners[i], &corners[(i + 1) % 4]);
        if p.z * q.z >= 0.0 {
            return false;
        }
        let at = p + (q - p) * (p.z / (p.z - q.z));
        at.x.abs() <= half[0] && at.y.abs() <= half[1]
    })
}

/// The least squared distance between inner points of an edge of the first rectangle along its axis `i` and of an edge of the second along
/// its axis `j`. Infinite when, for all four pairs of edges, an end is nearest.
fn edges_squared(t: &Vector, r: &Matrix3<f64>, (a, i): ([f64; 2], usize), (b, j): ([f64; 2], usize)) -> f64 {
    let (e, f) = (Vector::ith(i, 1.0), r.column(j).into_owned());
    let common = e.cross(&f);
    let length_squared = common.norm_squared();
    if length_squared < PARALLEL * PARALLEL {
        return f64::INFINITY;
    }
    let mut least = f64::INFINITY;
    for side_a in [-a[1 - i], a[1 - i]] {
        for side_b in [-b[1 - j], b[1 - j]] {
            // From the middle of one edge to the middle of the other: s e - u f + λ (e × f).
            let between = t + r.column(1 - j) * side_b - Vector::ith(1 - i, side_a);
            let s = between.cross(&f).dot(&common) / length_squared;
            let u = between.cross(&e).dot(&common) / length_squared;
            if s.abs() <= a[i] && u.abs() <= b[j] {
                least = least.min(between.dot(&common).powi(2) / length_squared);
            }
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Isometry, Triangle, exact, triangle_distance};
    use obbtree::cases::Draw;

    fn distance(t: [f64; 3], turn: [f64; 3], a: [f64; 2], b: [f64; 2]) -> f64 {
        let r = nalgebra::Rotation3::from_scaled_axis(Vector::from(turn)).into_inner();
        squared(&Vector::from(t), &r, a, b).sqrt()
    }

    #[test]
    fn distances_known_by_hand() {
        let quarter = std::f64::consts::FRAC_PI_2;
        for (name, t, turn, expected) in [
            ("one above the other", [0.5, 0.0, 3.0], [0.0; 3], 3.0),
            ("side by side in a plane", [5.0, 0.0, 0.0], [0.0; 3], 3.0),
            ("corner to corner", [5.0, 6.0, 0.0], [0.0; 3], 5.0), // 3 along x, 4 along y
            ("standing on it", [0.0, 0.0, 0.9], [quarter, 0.0, 0.0], 0.0),
            ("standing over it", [0.0, 0.0, 1.5], [quarter, 0.0, 0.0], 0.5),
            ("the same", [0.0; 3], [0.0; 3], 0.0),
        ] {
            let found = distance(t, turn, [1.0, 1.0], [1.0, 1.0]);
            assert!((found - expected).abs() < 1e-12, "{name}: {found}");
        }
        // Crossed edges: a blade along x with its upper edge at z = 0 under one along y with its lower edge at z = 2.
        let found = squared(
            &Vector::new(2.0, 0.0, 0.0),
            &(nalgebra::Rotation3::from_axis_angle(&Vector::x_axis(), quarter)).into_inner(),
            [1.0, 1.0],
            [0.5, 0.5],
        );
        assert!((found.sqrt() - 0.5).abs() < 1e-12, "{found}"); // from x = 1 to x = 1.5
    }

    #[test]
    fn edges_that_cross_at_almost_no_angle_touch() {
        // Two rectangles whose long edges along y cross in the middle at 1e-9 rad, each on its own side, like the roof of a
        // house and the same roof upside down.
        for angle in [1e-6, 1e-8, 1e-10, 1e-12] {
            let roof = nalgebra::Rotation3::from_axis_angle(&Vector::y_axis(), -0.5);
            let tilt = nalgebra::Rotation3::from_axis_angle(&Vector::x_axis(), angle);
            let r = (tilt * roof).into_inner();
            let t = Vector::new(1.0, 0.0, 0.0) + r * Vector::new(1.0, 0.0, 0.0);
            let found = squared(&t, &r, [1.0, 1000.0], [1.0, 1000.0]).sqrt();
            assert!(found < 1e-11, "{angle}: {found}");
        }
    }

    #[test]
    fn it_is_the_distance_of_the_two_pairs_of_triangles() {
        let mut draw = Draw::new(0, &["rectangles"], 0);
        let halves = |half: [f64; 2], place: &Isometry| {
            let [p, q, r, s] = corners(half).map(|c| place * crate::geometry::Point::from(c));
            [Triangle::new(p, q, r), Triangle::new(p, r, s)]
        };
        let mut touching = 0;
        for _ in 0..4000 {
            let half = |draw: &mut Draw| [draw.log_uniform(0.1, 10.0), draw.log_uniform(0.1, 10.0)];
            let (a, b) = (half(&mut draw), half(&mut draw));
            let place = Isometry::from_parts((draw.in_ball() * 5.0).into(), draw.rotation());
            let found =
                squared(&place.translation.vector, &place.rotation.to_rotation_matrix().into_inner(), a, b).sqrt();
            let mut expected = f64::INFINITY;
            for left in halves(a, &Isometry::identity()) {
                for right in halves(b, &place) {
                    let apart = || triangle_distance::squared(&left, &right).sqrt();
                    expected = expected.min(if exact::touch(&left, &right) { 0.0 } else { apart() });
                }
            }
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            touching += u32::from(expected == 0.0);
        }
        assert!((200..3800).contains(&touching), "{touching}");
    }
}
