//! What the harness runs: a method that is prepared for a mesh and queried at poses.
//!
//! Trees of any volume, the octree of samples, the exhaustive control and the peers all answer through [`Model`]. One call covers a whole
//! chunk of poses; inside it, all code is monomorphic.

pub mod brute;
pub mod motion;
pub mod octree_obb;
pub mod parry;
pub mod space;
pub mod volume_tree;
pub mod wide;
mod wide_shape;

use crate::geometry::Isometry;
use crate::tree::Tree;
use crate::tree::distance::Proximity;
use crate::tree::levels::Drawn;
use crate::tree::traverse::Counts;
use crate::tree::validate::TreeFault;
use crate::volume::shape::obb::Obb;
use motion::Motion;
use obbtree::engine::{Coherence, Memory};
use std::any::Any;

pub use crate::record::Kind;

/// A method prepared for one mesh.
pub trait Model: Any + Send + Sync {
    /// Mode `first`, for timing: pushes one verdict per pose, whether this mesh and `other` touch. `other` must be prepared by the same
    /// variant.
    fn first(&self, other: &dyn Model, a_from_b: &[Isometry], verdicts: &mut Vec<bool>);

    /// The verdicts of [`Model::first`], found by a shorter way if the method has one. For each pose, `witnesses` holds a pair of faces (of
    /// this mesh, of `other`) that touch by the triangle test common to all trees, or `None` when no pair touches.
    fn first_given(
        &self,
        other: &dyn Model,
        a_from_b: &[Isometry],
        witnesses: &[Option<(u32, u32)>],
        verdicts: &mut Vec<bool>,
    ) {
        let _ = witnesses;
        self.first(other, a_from_b, verdicts);
    }

    /// The verdicts of [`Model::first`] at poses of a path, in order. `memory` keeps state between the poses, as far as `coherence`
    /// permits. Methods without such state answer each pose independently.
    fn along(
        &self,
        other: &dyn Model,
        a_from_b: &[Isometry],
        coherence: Coherence,
        memory: &mut Memory,
        verdicts: &mut Vec<bool>,
    ) {
        let _ = (coherence, memory);
        self.first(other, a_from_b, verdicts);
    }

    /// Mode `first` with operation counts (zero for methods that do not count).
    fn first_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (bool, Counts);

    /// Mode `all`: every pair of faces that touch, as (face of this mesh, face of `other`), sorted, and the operation counts.
    fn all_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (Vec<(u32, u32)>, Counts);

    /// The distance between the meshes, mm, if it is below `below_mm`; otherwise infinity. 0 when they touch. `proximity` keeps the state
    /// of this pair's last query; with [`Proximity::keeping`] a method may tell a lower bound instead.
    fn distance_mm(&self, other: &dyn Model, a_from_b: &Isometry, below_mm: f64, proximity: &mut Proximity) -> f64;

    /// The time of first contact along a motion of `other`, which reaches `reach_mm` from its origin; `None` without contact. Methods without a search of their own advance by
    /// their distances.
    fn first_contact(&self, other: &dyn Model, motion: &Motion, reach_mm: f64) -> Option<f64> {
        motion::by_distances(self, other, motion, reach_mm)
    }

    /// Memory held, bytes.
    fn bytes(&self) -> usize;

    /// The report on the tree; `None` for methods without a tree of this project.
    fn tree_report(&self) -> Option<crate::tree::tightness::TreeReport> {
        None
    }

    /// Face numbers in the mesh by the order of the tree, of which each node holds a range; `None` for methods without a binary tree.
    fn order(&self) -> Option<&[u32]> {
        None
    }

    /// The volumes of the first `levels` levels of the tree, for drawing; empty for methods without a tree of this project.
    fn drawn(&self, levels: u32) -> Vec<Drawn> {
        let _ = levels;
        Vec::new()
    }

    /// The tree as a tree of oriented boxes; `None` for methods whose volumes are not boxes.
    fn boxes(&self) -> Option<Tree<Obb>> {
        None
    }

    /// Checks that the tree divides the triangles properly; passes for methods without a tree of this project.
    ///
    /// # Errors
    /// The first fault found.
    fn check_structure(&self) -> Result<(), TreeFault> {
        Ok(())
    }

    /// Checks that each node's volume contains every corner of its triangles within `slack_mm`; passes for methods without a tree of this
    /// project.
    ///
    /// # Errors
    /// The first corner outside.
    fn check_containment(&self, slack_mm: f64) -> Result<(), TreeFault> {
        let _ = slack_mm;
        Ok(())
    }

    /// Checks that each volume's reported figures are consistent; passes for methods without a tree of this project.
    ///
    /// # Errors
    /// The first inconsistent volume.
    fn check_consistency(&self) -> Result<(), TreeFault> {
        Ok(())
    }
}

/// The concrete model behind `other`.
///
/// # Panics
/// When `other` was prepared by another variant, which is a programming error.
pub(crate) fn same<M: Model>(other: &dyn Model) -> &M {
    let any: &dyn Any = other;
    any.downcast_ref().expect("both meshes of a pair are prepared by the same variant")
}
