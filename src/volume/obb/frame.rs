//! Orientation rules: the axes of a box, and the mean that belongs to them.

use crate::geometry::{Point, Triangle, covariance};
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
