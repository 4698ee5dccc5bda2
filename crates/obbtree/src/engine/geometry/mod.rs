//! Triangles, meshes, the coordinate grid, and the triangle tests on which all other modules depend.
//!
//! Reading order: [`triangle`], [`mesh`], [`rigid`], [`grid`], [`weld`], [`surface`], [`covariance`], the triangle tests ([`certified`] is the one that
//! all methods share, [`exact`] decides where it cannot, [`exact_integer`] checks both, [`cross_check`] compares them), [`triangle_distance`],
//! `crossing`, `witness`.

pub mod certified;
pub mod covariance;
pub(crate) mod crossing;
#[cfg(any(test, feature = "cases"))]
pub mod cross_check;
pub mod eigen;
pub mod exact;
pub mod exact_integer;
pub mod grid;
pub mod mesh;
pub mod plane;
pub mod rigid;
pub mod surface;
pub mod triangle;
pub mod triangle_distance;
pub mod weld;
pub(crate) mod witness;

pub use mesh::{GridMesh, MeshError};
pub use triangle::Triangle;

/// A point, mm; the name of a variable states the frame.
pub type Point = nalgebra::Point3<f64>;
/// A direction, or a displacement in mm.
pub type Vector = nalgebra::Vector3<f64>;
/// A rigid motion; `a_from_b` takes coordinates in frame `b` to coordinates in frame `a`. Translation in mm.
pub type Isometry = nalgebra::Isometry3<f64>;
