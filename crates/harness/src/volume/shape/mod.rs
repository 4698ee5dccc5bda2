//! The shapes that several variants share, one file each, and the parts of their tests.

pub mod aligned_box;
pub mod dop;
pub mod obb;
pub mod polytope;
pub mod rectangle_distance;
pub mod single;
pub mod sphere;
