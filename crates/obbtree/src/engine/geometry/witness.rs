//! The nearest points of two triangles, to go with their distance; a common point where they touch.

use super::triangle_distance::normal;
use super::{Point, Triangle, Vector};
use std::array;

/// Two points and the square of their distance.
type Pair = (f64, [Point; 2]);

/// The nearest points, of `a` and of `b`: the same point twice, up to rounding, where the triangles touch. Accurate to about 1e-12 of the largest
/// coordinate.
pub(crate) fn nearest(a: &Triangle, b: &Triangle) -> [Point; 2] {
    for (edges_of, face) in [(a, b), (b, a)] {
        if let Some(point) = edges(edges_of).iter().find_map(|edge| piercing(edge, face)) {
            return [point; 2];
        }
    }
    let swap = |(squared, [p, q]): Pair| (squared, [q, p]);
    let mut best = corners_on(a, b);
    best = nearer(best, swap(corners_on(b, a)));
    for [p, q] in edges(a) {
        for [r, s] in edges(b) {
            best = nearer(best, segments(&[p, q], &[r, s]));
        }
    }
    best.1
}

fn nearer(x: Pair, y: Pair) -> Pair {
    if y.0 < x.0 { y } else { x }
}

fn edges(t: &Triangle) -> [[Point; 2]; 3] {
    array::from_fn(|i| [t.corners[i], t.corners[(i + 1) % 3]])
}

fn pair(p: Point, q: Point) -> Pair {
    ((p - q).norm_squared(), [p, q])
}

/// Normal to a triangle, right to the last digits for a needle, too.
fn normal_of(t: &Triangle) -> Vector {
    let [a, b, c] = &t.corners;
    normal(&(b - a), &(c - a))
}

/// Whether a point of the triangle's plane is inside, edges included.
fn is_inside(p: &Point, face: &Triangle, normal: &Vector) -> bool {
    edges(face).iter().all(|[q, r]| normal.cross(&(r - q)).dot(&(p - q)) >= 0.0)
}

/// The nearest corner of `from` and its foot on `face`, of those that project into it; the first corners where none does.
fn corners_on(from: &Triangle, face: &Triangle) -> Pair {
    let normal = normal_of(face);
    let length = normal.norm_squared();
    let foot = |p: &Point| p - normal * (normal.dot(&(p - face.corners[0])) / length);
    let feet = from.corners.iter().filter(|p| length > 0.0 && is_inside(p, face, &normal)).map(|p| pair(*p, foot(p)));
    feet.fold(pair(from.corners[0], face.corners[0]), nearer)
}

/// The nearest points of two segments, either of which may be a point.
fn segments([p, q]: &[Point; 2], [r, s]: &[Point; 2]) -> Pair {
    let (u, v, w) = (q - p, s - r, p - r);
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let part = |numerator: f64, length: f64| if length > 0.0 { (numerator / length).clamp(0.0, 1.0) } else { 0.0 };
    let on_u = |t: f64| part(uv * t - u.dot(&w), uu);
    let on_v = |s: f64| part(uv * s + v.dot(&w), vv);
    let normal = u.cross(&v);
    // From where the lines are nearest, and from either end, since that place is rounding where they are parallel.
    let crossing = part(v.cross(&w).dot(&normal), normal.norm_squared());
    let candidates = [crossing, 0.0, 1.0].map(|start| {
        let t = on_v(start);
        let s = on_u(t);
        pair(p + u * s, r + v * on_v(s))
    });
    candidates.into_iter().fold(pair(*p, *r), nearer)
}

/// Where an edge goes through a face, if it does as far as `f64` can tell.
fn piercing([p, q]: &[Point; 2], face: &Triangle) -> Option<Point> {
    let normal = normal_of(face);
    let height = |p: &Point| normal.dot(&(p - face.corners[0]));
    let (from, to) = (height(p), height(q));
    if from * to > 0.0 || from == to {
        return None;
    }
    let point = p + (q - p) * (from / (from - to));
    is_inside(&point, face, &normal).then_some(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::geometry::cross_check::needles;
    use crate::engine::geometry::{certified, triangle_distance};
    use rand::SeedableRng;

    /// Barycentric distance of a point from a triangle: how far the triangle is from the point itself.
    fn off(p: &Point, t: &Triangle) -> f64 {
        triangle_distance::point_squared(p, t).sqrt()
    }

    fn check(a: &Triangle, b: &Triangle, tolerance: f64) {
        let [p, q] = nearest(a, b);
        let size = a.corners.iter().chain(&b.corners).map(|c| (c - a.corners[0]).norm()).fold(0.0, f64::max);
        assert!(off(&p, a) <= tolerance * size && off(&q, b) <= tolerance * size, "{a:?} {b:?}");
        let distance = if certified::touch(a, b) { 0.0 } else { triangle_distance::squared(a, b).sqrt() };
        assert!(((p - q).norm() - distance).abs() <= tolerance * size, "{} {distance}: {a:?} {b:?}", (p - q).norm());
    }

    #[test]
    fn points_lie_on_the_triangles_and_are_as_far_apart_as_these() {
        let mut random = crate::cases::Draw::new(0, &["witness"], 0);
        let mut touching = 0;
        for _ in 0..20_000 {
            let size = random.log_uniform(0.01, 10.0);
            let [a, b] =
                [1.0, size].map(|size| Triangle { corners: [(); 3].map(|()| Point::from(random.in_ball() * size)) });
            touching += u32::from(certified::touch(&a, &b));
            check(&a, &b, 1e-12);
        }
        assert!((2_000..18_000).contains(&touching), "{touching}");
    }

    #[test]
    fn needles_have_nearest_points_too() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(5);
        for _ in 0..20_000 {
            let [a, b] = needles(&mut random);
            check(&a, &b, 1e-10);
        }
    }

    #[test]
    fn triangles_without_area_and_coplanar_ones() {
        let t = |corners: [[f64; 3]; 3]| Triangle { corners: corners.map(Point::from) };
        let floor = t([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        for other in [
            t([[1.0, 1.0, 2.0]; 3]),
            t([[1.0, 1.0, 0.0]; 3]),
            t([[-1.0, 0.5, 0.0], [6.0, 0.5, 0.0], [2.0, 0.5, 0.0]]),
            t([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.5]]),
            t([[1.0, 1.0, 0.0], [1.5, 1.0, 0.0], [1.0, 1.5, 0.0]]),
            t([[-9.0, -9.0, 0.0], [90.0, -9.0, 0.0], [-9.0, 90.0, 0.0]]),
            t([[5.0, 5.0, 0.0], [9.0, 5.0, 0.0], [5.0, 9.0, 3.0]]),
        ] {
            check(&floor, &other, 1e-13);
            check(&other, &floor, 1e-13);
            check(&other, &other, 1e-13);
        }
    }
}
