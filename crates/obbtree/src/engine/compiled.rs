//! What is compiled once for each volume: the build and the searches, most of the machine code. A generic function is compiled anew in each crate that
//! calls it; these are called through a trait whose implementations are not generic.

use super::aligned::Aligned;
use super::ball::Ball;
use super::lanes::Simd;
use super::node::WideTree;
use super::oriented::Oriented;
use super::path::{Coherence, Memory};
use super::proximity::Proximity;
use super::traverse::{self, Scratch};
use super::volume::WideVolume;
use super::{build, distance};
use crate::engine::geometry::{GridMesh, Isometry};
use std::ops::ControlFlow;

/// The build and the searches of trees of one volume. `trees` are `a` and `b`.
pub trait Compiled: Sized {
    /// [`WideTree::build`].
    fn build(mesh: &GridMesh) -> WideTree<Self>
    where
        Self: WideVolume;

    /// Calls `on_contact` with every pair of triangles that touch, by their places in the trees' orders, until it breaks. The balls around the meshes meet.
    fn traverse(
        trees: (&WideTree<Self>, &WideTree<Self>),
        a_from_b: &Isometry,
        simd: Simd,
        scratch: &mut Scratch,
        on_contact: &mut dyn FnMut((u32, u32)) -> ControlFlow<()>,
    ) where
        Self: WideVolume;

    /// [`Memory::first`].
    fn first_along(
        memory: &mut Memory,
        trees: (&WideTree<Self>, &WideTree<Self>),
        a_from_b: &Isometry,
        simd: Simd,
        coherence: Coherence,
    ) -> bool
    where
        Self: WideVolume;

    /// [`distance::distance_mm`].
    fn distance_mm(
        trees: (&WideTree<Self>, &WideTree<Self>),
        a_from_b: &Isometry,
        simd: Simd,
        below_mm: f64,
        proximity: &mut Proximity,
    ) -> f64
    where
        Self: WideVolume;
}

macro_rules! compiled {
    ($($volume:ty),+) => {$(
        impl Compiled for $volume {
            fn build(mesh: &GridMesh) -> WideTree<Self> {
                build::tree(mesh)
            }

            fn traverse(
                trees: (&WideTree<Self>, &WideTree<Self>),
                a_from_b: &Isometry,
                simd: Simd,
                scratch: &mut Scratch,
                on_contact: &mut dyn FnMut((u32, u32)) -> ControlFlow<()>,
            ) {
                traverse::traverse_within(trees, a_from_b, simd, scratch, on_contact);
            }

            fn first_along(
                memory: &mut Memory,
                trees: (&WideTree<Self>, &WideTree<Self>),
                a_from_b: &Isometry,
                simd: Simd,
                coherence: Coherence,
            ) -> bool {
                memory.first_along(trees, a_from_b, simd, coherence)
            }

            fn distance_mm(
                trees: (&WideTree<Self>, &WideTree<Self>),
                a_from_b: &Isometry,
                simd: Simd,
                below_mm: f64,
                proximity: &mut Proximity,
            ) -> f64 {
                distance::search(trees, a_from_b, simd, below_mm, proximity)
            }
        }
    )+};
}

compiled!(Oriented, Aligned, Ball);
