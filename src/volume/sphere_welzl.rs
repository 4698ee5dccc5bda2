//! The smallest enclosing sphere.
//!
//! E. Welzl, "Smallest Enclosing Disks (Balls and Ellipsoids)", 1991: the sphere is determined by at most four corners on it, its support.
//! Deviation: instead of Welzl's recursion, the farthest corner outside repeatedly enters the support (the pivot rule of B. Gärtner, "Fast
//! and Robust Smallest Enclosing Balls", 1999), and the new support is found among all subsets of at most five points. The radius grows
//! with every exchange, so no support recurs. The search ends when no corner is outside by more than rounding error.

use super::shape::sphere::Sphere;
use super::{BoundingVolume, Info};
use crate::geometry::{Point, Triangle, Vector, triangle};
use nalgebra::Matrix3;

/// The smallest enclosing sphere.
#[derive(Clone, Copy, Debug)]
pub struct SphereWelzl;

impl BoundingVolume for SphereWelzl {
    const INFO: Info = Info {
        id: "sphere-welzl",
        label: "smallest sphere",
        reference: "E. Welzl, Smallest Enclosing Disks (Balls and Ellipsoids), 1991; pivot rule: B. Gärtner 1999",
        safe: true,
    };

    type Shape = Sphere;

    fn fit(triangles: &[Triangle]) -> Sphere {
        Sphere::about(centre(triangles), triangles)
    }
}

/// The centre of the sphere around `triangles` (at least one), mm.
fn centre(triangles: &[Triangle]) -> Point {
    let origin = triangles[0].corners[0];
    let points: Vec<Vector> = triangle::corners(triangles).map(|p| p - origin).collect();
    origin + smallest_ball(&points).centre
}

/// A sphere and the points that determine it, mm.
#[derive(Clone, Debug)]
struct Ball {
    centre: Vector,
    radius_squared: f64,
    support: Vec<Vector>,
}

/// A point outside by less than this fraction of the squared radius counts as on the sphere. The circumcentre of four points is accurate to
/// about 2⁻⁵⁰ when they are far from coplanar, and the final radius is set to the farthest corner in any case.
const ON_SPHERE: f64 = 1e-12;

fn smallest_ball(points: &[Vector]) -> Ball {
    let mut ball = Ball { centre: points[0], radius_squared: 0.0, support: vec![points[0]] };
    loop {
        let distance = |p: &Vector| (p - ball.centre).norm_squared();
        let farthest = points.iter().copied().max_by(|p, q| distance(p).total_cmp(&distance(q)));
        let Some(entering) = farthest.filter(|p| distance(p) > ball.radius_squared * (1.0 + ON_SPHERE)) else {
            return ball;
        };
        match exchange(&ball.support, entering) {
            Some(larger) if larger.radius_squared > ball.radius_squared => ball = larger,
            // Rounding: the exchange gains nothing.
            _ => return ball,
        }
    }
}

/// The smallest sphere around the points of a support and one entering point, which is on it. Candidates are the spheres through the
/// entering point and some of the others; the smallest that contains all points is returned.
fn exchange(support: &[Vector], entering: Vector) -> Option<Ball> {
    let mut best: Option<Ball> = None;
    for subset in 0..1_u32 << support.len() {
        let mut on: Vec<Vector> = (0..support.len()).filter(|&i| subset >> i & 1 == 1).map(|i| support[i]).collect();
        on.push(entering);
        let Some(ball) = circumscribed(on) else { continue };
        let reach = ball.radius_squared * (1.0 + ON_SPHERE);
        let contains_all = support.iter().all(|p| (p - ball.centre).norm_squared() <= reach);
        if contains_all && best.as_ref().is_none_or(|known| ball.radius_squared < known.radius_squared) {
            best = Some(ball);
        }
    }
    best
}

/// The smallest sphere through all of one to four points. `None` when there are more, or when they lie on a line, plane or circle that
/// leaves the sphere undetermined.
fn circumscribed(points: Vec<Vector>) -> Option<Ball> {
    let origin = points[0];
    let edges: Vec<Vector> = points[1..].iter().map(|p| p - origin).collect();
    // The centre c is in the span of the edges with e·c = |e|²/2 for each.
    let offset = match edges.as_slice() {
        [] => Vector::zeros(),
        [e] => e * 0.5,
        [e, f] => {
            let normal = e.cross(f);
            let rows = Matrix3::from_rows(&[e.transpose(), f.transpose(), normal.transpose()]);
            rows.lu().solve(&Vector::new(0.5 * e.norm_squared(), 0.5 * f.norm_squared(), 0.0))?
        }
        [e, f, g] => {
            let rows = Matrix3::from_rows(&[e.transpose(), f.transpose(), g.transpose()]);
            rows.lu().solve(&(Vector::new(e.norm_squared(), f.norm_squared(), g.norm_squared()) * 0.5))?
        }
        _ => return None,
    };
    let radius_squared = offset.norm_squared();
    radius_squared.is_finite().then(|| Ball { centre: origin + offset, radius_squared, support: points })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::shape::sphere::farthest_mm;
    use miniball::Ball as Oracle;
    use miniball::Enclosing;
    use miniball::nalgebra as oracle_algebra;
    use obbtree::cases::meshes;
    use proptest::prelude::*;
    use std::collections::VecDeque;

    fn radius(points: &[Vector]) -> f64 {
        let ball = smallest_ball(points);
        points.iter().map(|p| (p - ball.centre).norm()).fold(0.0, f64::max)
    }

    /// The distance from the oracle's centre to the farthest point, because for some clouds the oracle's own radius leaves a point outside.
    /// Infinite when the oracle panics, which it does on numerical instability.
    fn oracle(points: &[Vector]) -> f64 {
        let mut queue: VecDeque<_> = points.iter().map(|p| oracle_algebra::Point3::new(p.x, p.y, p.z)).collect();
        let ask = || Oracle::enclosing_points(&mut queue).center;
        let Ok(centre) = std::panic::catch_unwind(std::panic::AssertUnwindSafe(ask)) else { return f64::INFINITY };
        let centre = Vector::new(centre.x, centre.y, centre.z);
        points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max)
    }

    #[test]
    fn spheres_known_by_hand() {
        let v = Vector::new;
        for (points, expected) in [
            (vec![v(1.0, 2.0, 3.0)], 0.0),
            (vec![v(0.0, 0.0, 0.0), v(0.0, 6.0, 8.0)], 5.0),
            // An obtuse triangle: its longest side is the diameter.
            (vec![v(0.0, 0.0, 0.0), v(10.0, 0.0, 0.0), v(4.0, 1.0, 0.0)], 5.0),
            // An equilateral one of side √2: the circle through its corners, √2/√3.
            (vec![v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, 0.0, 1.0)], (2.0_f64 / 3.0).sqrt()),
            // Alternate corners of a cube of edge 2.
            (vec![v(1.0, 1.0, 1.0), v(1.0, -1.0, -1.0), v(-1.0, 1.0, -1.0), v(-1.0, -1.0, 1.0)], 3.0_f64.sqrt()),
        ] {
            assert!((radius(&points) - expected).abs() < 1e-12, "{points:?}: {}", radius(&points));
        }
    }

    /// Checks optimality: if the centre is a weighted mean, with weights of at least 0, of points on the sphere, then moving the centre
    /// increases the distance to one of them, so the sphere is the smallest.
    #[test]
    fn on_the_suites_meshes_the_centre_is_a_mean_of_points_on_the_sphere() {
        for subject in meshes::subjects() {
            let triangles = subject.mesh.triangles();
            let origin = triangles[0].corners[0];
            let points: Vec<Vector> = triangle::corners(&triangles).map(|p| p - origin).collect();
            let ball = smallest_ball(&points);
            let radius = ball.radius_squared.sqrt();
            assert!(farthest_mm(&(origin + ball.centre), &triangles) <= radius * (1.0 + 1e-9), "{}", subject.name);
            let columns: Vec<_> = ball.support.iter().map(|p| (p - ball.centre).push(radius)).collect();
            let weights = nalgebra::Matrix4xX::from_columns(&columns)
                .svd(true, true)
                .solve(&nalgebra::Vector4::new(0.0, 0.0, 0.0, radius), 1e-9 * radius)
                .unwrap();
            let mean: Vector = ball.support.iter().zip(weights.iter()).map(|(p, w)| (p - ball.centre) * *w).sum();
            assert!(mean.norm() <= 1e-6 * radius, "{}: {mean}", subject.name);
            assert!(weights.iter().all(|w| *w >= -1e-6), "{}: {weights}", subject.name);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn it_is_no_larger_than_the_oracles(points in prop::collection::vec(prop::array::uniform3(-10.0..10.0_f64), 1..40), flat in 0..9_i32) {
            let points: Vec<Vector> = points.into_iter().map(|[x, y, z]| Vector::new(x, y, z * 10.0_f64.powi(-flat))).collect();
            let (found, expected) = (radius(&points), oracle(&points));
            prop_assert!(found <= expected * (1.0 + 1e-9), "{found} {expected}");
        }

        /// Lattice points: many lie on one sphere, and many on one plane.
        #[test]
        fn it_is_no_larger_than_the_oracles_on_a_lattice(points in prop::collection::vec(prop::array::uniform3(0..4_i32), 1..40)) {
            let points: Vec<Vector> = points.into_iter().map(|p| Vector::from(p.map(f64::from))).collect();
            let (found, expected) = (radius(&points), oracle(&points));
            prop_assert!(found <= expected * (1.0 + 1e-9), "{found} {expected}");
        }
    }
}
