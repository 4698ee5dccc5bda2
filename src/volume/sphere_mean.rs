//! The sphere about the mean of the corners: the cheapest fit, with a centre that is drawn toward finely divided regions.
//!
//! C. Ericson, "Real-Time Collision Detection", 2005, section 4.3. The mean is equation (1) of Xu and Zhang 2011: every triangle
//! contributes its three corners.

use super::shape::sphere::Sphere;
use super::{BoundingVolume, Info};
use crate::geometry::{Point, Triangle, Vector, triangle};

/// The sphere about the mean of the corners.
#[derive(Clone, Copy, Debug)]
pub struct SphereMean;

impl BoundingVolume for SphereMean {
    const INFO: Info = Info {
        id: "sphere-mean",
        label: "sphere about the mean",
        reference: "C. Ericson, Real-Time Collision Detection, 2005, section 4.3; Xu and Zhang 2011, eq. (1)",
        safe: true,
    };

    type Shape = Sphere;

    fn fit(triangles: &[Triangle]) -> Sphere {
        Sphere::about(centre(triangles), triangles)
    }
}

/// The centre of the sphere around `triangles` (at least one), mm.
fn centre(triangles: &[Triangle]) -> Point {
    // About the first corner, so that a part far from its origin loses nothing.
    let origin = triangles[0].corners[0];
    let sum: Vector = triangle::corners(triangles).map(|p| p - origin).sum();
    origin + sum / (3.0 * triangles.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::BoundingVolume;

    #[test]
    fn the_centre_is_the_mean_of_all_corners() {
        let p = |x: f64, y: f64| Point::new(x, y, 1.0);
        // Corner (0,0) three times, (3,0) twice, (0,6) once: the mean is (1, 1).
        let triangles = [
            Triangle::new(p(0.0, 0.0), p(3.0, 0.0), p(0.0, 6.0)),
            Triangle::new(p(0.0, 0.0), p(3.0, 0.0), p(0.0, 0.0)),
        ];
        let sphere = SphereMean::fit(&triangles);
        assert!((sphere.centre - p(1.0, 1.0)).norm() < 1e-12);
        assert!((sphere.radius - 26.0_f64.sqrt()).abs() < 1e-7); // from (1,1) to (0,6)
    }
}
