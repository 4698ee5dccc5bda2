//! Parametric shapes, mesh files and hulls, beside the meshes and exact tests of [`obbtree::geometry`].
//!
//! Reading order: [`hull`], [`rectangle`], [`shapes`] and [`import`].

pub mod hull;
pub mod import;
pub mod rectangle;
pub mod shapes;

pub use obbtree::geometry::{
    Isometry, Mesh, MeshError, Point, Triangle, Vector, certified, covariance, cross_check, eigen, exact,
    exact_integer, grid, mesh, plane, rigid, surface, triangle, triangle_distance, weld,
};

/// A hash of the snapped vertices and the faces, as hexadecimal text: equal for equal meshes on every machine.
#[must_use]
pub fn content_hash(mesh: &Mesh) -> String {
    let mut hasher = blake3::Hasher::new();
    for p in mesh.vertices() {
        for x in [p.x, p.y, p.z] {
            hasher.update(&(x + 0.0).to_le_bytes());
        }
    }
    for v in mesh.faces().iter().flatten() {
        hasher.update(&v.to_le_bytes());
    }
    hasher.finalize().to_hex().to_string()
}
