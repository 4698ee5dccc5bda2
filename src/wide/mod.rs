//! A tree with eight children per node, traversed eight or sixteen volumes at a time.
//!
//! The tree of [`crate::tree`] is clear and takes any volume; this one is as fast as we can make it, for volumes that have lanes ([`volume`]):
//! oriented boxes, boxes along the axes and balls. A node holds its children's volumes side by side in `f32`, so that one instruction works on all of
//! them; triangles stay in `f64`; each leaf is one triangle. Whatever rounding can cost is derived and paid for ([`volume`], [`pose`]), and pairs
//! of triangles that `f64` cannot decide go to [`crate::geometry::exact`], so that verdicts are the exact truth's.
//!
//! Reading order: [`node`] (the layout), [`volume`] (the trait), [`turn`] and [`oriented`] (a box in 36 bytes), [`aligned`], [`ball`], [`split`] and
//! [`build`], [`pose`], [`lanes`] (the three instruction sets), [`visit`], [`boxes`] and [`triangles`] (the tests on lanes), [`traverse`],
//! [`distance`], `axis`, [`path`], `shape`, [`validate`].

pub mod aligned;
mod axis;
pub mod ball;
pub mod boxes;
pub mod build;
pub mod distance;
pub mod lanes;
pub mod node;
pub mod oriented;
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
pub mod visit;
pub mod volume;

pub use lanes::Simd;
pub use node::WideTree;
pub use path::{Coherence, Memory};
pub use volume::WideVolume;
