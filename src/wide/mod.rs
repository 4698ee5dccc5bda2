//! A tree with eight children per node, traversed eight or sixteen volumes at a time.
//!
//! The tree of [`crate::tree`] is generic and clear; this one is as fast as we can make it and does one thing, oriented boxes. A node
//! holds its children's boxes side by side in `f32`, so that one instruction works on all of them; triangles stay in
//! `f64`; each leaf is one triangle. Whatever rounding can cost is derived and paid for ([`boxes`], [`code`], [`pose`]), and pairs
//! of triangles that `f64` cannot decide go to [`crate::geometry::exact`], so that verdicts are the exact truth's.
//!
//! Reading order: [`node`] (the layout), [`turn`] and [`code`] (a box in 36 bytes), [`split`] and [`build`], [`pose`], [`lanes`] (the three
//! instruction sets), [`boxes`] and [`triangles`] (the two tests on lanes), [`traverse`], [`distance`], `axis`, [`path`], `shape`, [`validate`].

mod axis;
pub mod boxes;
pub mod build;
pub mod code;
pub mod distance;
pub mod lanes;
pub mod node;
pub mod path;
pub mod pose;
mod posed;
mod shape;
pub mod split;
#[cfg(test)]
mod tests;
pub mod traverse;
pub mod triangles;
pub mod turn;
pub mod validate;

pub use lanes::Simd;
pub use node::WideTree;
pub use path::{Coherence, Memory};
