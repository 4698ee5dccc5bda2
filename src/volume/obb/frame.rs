//! Which way a box is turned.

use crate::geometry::{Point, Triangle, covariance};
use nalgebra::Matrix3;
use std::fmt::Debug;

/// A rule that turns a box.
pub trait FrameRule: Debug + Send + Sync + 'static {
    /// A mean of the triangles (mm, mesh frame), and the axes of the box as the columns of a rotation.
    fn frame(triangles: &[Triangle]) -> (Point, Matrix3<f64>);
}

/// The mean and the principal axes of the triangle corners: equation (1) of Xu and Zhang 2011.
#[derive(Clone, Copy, Debug)]
pub enum VertexCovariance {}

/// The mean and the principal axes of the surface: equations (4) and (5) of Xu and Zhang 2011.
#[derive(Clone, Copy, Debug)]
pub enum AreaCovariance {}

impl FrameRule for VertexCovariance {
    fn frame(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (mean, covariance) = covariance::vertex_weighted(triangles);
        (mean, covariance::principal_frame(&covariance))
    }
}

impl FrameRule for AreaCovariance {
    fn frame(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (mean, covariance) = covariance::area_weighted(triangles);
        (mean, covariance::principal_frame(&covariance))
    }
}
