//! Trees of eight-wide nodes, traversals, exact predicates: what [`Collider`](crate::Collider) is made of, for those who measure or extend it. Names
//! here change from release to release.
//!
//! Lengths are millimetres, coordinates lie within 4096 mm of the mesh's origin, and vertices are rounded to a grid of 2⁻²⁶ mm
//! ([`geometry::grid`]); a [`Mesh`](crate::Mesh) of any size is scaled to that.
//!
//! A node holds the volumes of its eight children side by side in `f32`, so that one instruction tests all of them; triangles stay in `f64`, and each
//! leaf is one triangle, or two with an edge in common ([`patches`]). What rounding can cost is derived and paid for ([`volume`], [`pose`]). Pairs of triangles that `f64` cannot decide go
//! to exact predicates ([`geometry::exact`]), so that every verdict is exact.
//!
//! Reading order: [`geometry`] (meshes and the exact triangle test), [`node`] (the layout), [`volume`] (the trait), [`turn`] and [`oriented`] (a box in
//! 36 bytes), [`aligned`], [`ball`], [`patches`], [`split`] and [`build`], [`pose`], [`lanes`] (the three instruction sets), [`visit`], [`boxes`] and [`triangles`] (the
//! tests on lanes), [`traverse`], [`proximity`], `buckets`, `measure`, `slab` and [`distance`], `axis`, `front`, `bubble`, [`path`], [`plain`], [`validate`].

pub mod aligned;
mod axis;
pub mod ball;
pub mod boxes;
mod bubble;
mod buckets;
pub mod build;
pub mod distance;
mod front;
pub mod geometry;
pub mod lanes;
#[cfg(test)]
mod lemmas;
mod measure;
pub mod node;
pub mod oriented;
pub mod patches;
pub mod path;
#[cfg(test)]
mod pinned;
pub mod plain;
pub mod pose;
mod posed;
pub mod proximity;
mod slab;
pub mod split;
#[cfg(test)]
mod tests;
pub mod traverse;
pub mod triangles;
pub mod turn;
pub mod validate;
pub mod visit;
pub mod volume;

pub use geometry::{GridMesh, Isometry, MeshError, Point, Triangle, Vector};
pub use lanes::Simd;
pub use node::WideTree;
pub use path::{Coherence, Memory};
pub use volume::WideVolume;
