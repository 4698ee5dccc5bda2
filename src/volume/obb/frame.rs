//! Orientation rules: the axes of a box, and the mean that belongs to them.

use crate::geometry::{Point, Triangle, Vector, covariance, triangle};
use nalgebra::Matrix3;

/// How the axes of a box are found.
pub trait FrameRule {
    /// The mean (mm) that the covariance is about, and the axes as columns of a rotation.
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>);
}

/// Principal axes of the triangle corners, equation (1) of Xu and Zhang 2011.
#[derive(Clone, Copy, Debug)]
pub struct VertexCovariance;

impl FrameRule for VertexCovariance {
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (mean, covariance) = covariance::vertex_weighted(triangles);
        (mean, covariance::principal_frame(&covariance))
    }
}

/// Principal axes of the surface, equations (4) and (5) of Xu and Zhang 2011.
#[derive(Clone, Copy, Debug)]
pub struct AreaCovariance;

impl FrameRule for AreaCovariance {
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (mean, covariance) = covariance::area_weighted(triangles);
        (mean, covariance::principal_frame(&covariance))
    }
}

/// Of three frames the one whose tight box has the least surface: the principal axes of the surface, the mesh's own axes, and
/// those of the largest triangle. Machine parts are mostly prisms and turned bodies along their own axes, which no covariance finds when
/// the body's symmetry leaves its eigenvectors free. The mean is that of the surface.
#[derive(Clone, Copy, Debug)]
pub struct LeastSurface;

impl FrameRule for LeastSurface {
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (mean, principal) = AreaCovariance::mean_and_axes(triangles);
        let mut largest = &triangles[0];
        for triangle in triangles {
            if triangle.area() > largest.area() {
                largest = triangle;
            }
        }
        let mut best = (surface(triangles, &mean, &principal), principal);
        for axes in [Some(Matrix3::identity()), largest.frame()].into_iter().flatten() {
            let surface = surface(triangles, &mean, &axes);
            if surface < best.0 {
                best = (surface, axes);
            }
        }
        (mean, best.1)
    }
}

/// Half the surface of the tight box along `axes`, mm².
fn surface(triangles: &[Triangle], mean: &Point, axes: &Matrix3<f64>) -> f64 {
    let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    for corner in triangle::corners(triangles) {
        let x = axes.tr_mul(&(corner - mean));
        (low, high) = (low.inf(&x), high.sup(&x));
    }
    let d = high - low;
    d.x * d.y + d.y * d.z + d.z * d.x
}
