#![doc = include_str!("../README.md")]
//!
//! # How it works
//!
//! A node holds the volumes of its eight children side by side in `f32`, so that one instruction tests all of them; triangles stay in `f64`, and each
//! leaf is one triangle. What rounding can cost is derived and paid for ([`volume`], [`pose`]). Pairs of triangles that `f64` cannot decide go
//! to exact predicates ([`geometry::exact`]), so that every verdict is exact.
//!
//! Reading order: [`geometry`] (meshes and the exact triangle test), [`node`] (the layout), [`volume`] (the trait), [`turn`] and [`oriented`] (a box in
//! 36 bytes), [`aligned`], [`ball`], [`split`] and [`build`], [`pose`], [`lanes`] (the three instruction sets), [`visit`], [`boxes`] and [`triangles`] (the
//! tests on lanes), [`traverse`], [`proximity`] and [`distance`], `axis`, [`path`], [`plain`], [`validate`].

pub mod aligned;
mod axis;
pub mod ball;
pub mod boxes;
pub mod build;
#[cfg(any(test, feature = "cases"))]
pub mod cases;
pub mod distance;
pub mod geometry;
pub mod lanes;
pub mod node;
pub mod oriented;
pub mod path;
pub mod plain;
pub mod pose;
mod posed;
pub mod proximity;
pub mod split;
#[cfg(test)]
mod pinned;
#[cfg(test)]
mod tests;
pub mod traverse;
pub mod triangles;
pub mod turn;
pub mod validate;
pub mod visit;
pub mod volume;

pub use geometry::{Isometry, Mesh, MeshError, Point, Triangle, Vector};
pub use lanes::Simd;
pub use node::WideTree;
pub use path::{Coherence, Memory};
pub use volume::WideVolume;
