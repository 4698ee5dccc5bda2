//! What the harness runs: a method prepared for a mesh, and asked about poses.
//!
//! A tree of any volume, the octree of samples, the exhaustive control and the peers all answer through [`Model`]. The call through it is made
//! once per chunk of poses; inside, everything is monomorphic.

pub mod brute;
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
use obbtree::engine::{Coherence, Memory};
use std::any::Any;

pub use crate::record::Kind;

/// A method prepared for one mesh.
pub trait Model: Any + Send + Sync {
    /// Mode `first`, for timing: pushes one verdict per pose, whether this mesh and `other` touch. `other` was prepared by
    /// the same variant.
    fn first(&self, other: &dyn Model, a_from_b: &[Isometry], verdicts: &mut Vec<bool>);

    /// The verdicts of [`Model::first`], found by a shorter way where there is one: `witnesses` names for each pose a pair of
    /// faces (of this mesh, of `other`) that touch by the triangle test all trees share, or `None` when no pair does.
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

    /// The verdicts of [`Model::first`] at poses of a path, in order, with what `memory` keeps of those before, as far as `coherence`
    /// allows. Methods that keep nothing answer afresh.
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

    /// Mode `all`: every pair of faces that touch, as (face of this mesh, face of `other`), sorted; with operation counts.
    fn all_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (Vec<(u32, u32)>, Counts);

    /// The distance of the meshes, mm, where it is below `below_mm`, else infinity; 0 when they touch. `proximity` is what the
    /// last query of this pair left behind.
    fn distance_mm(&self, other: &dyn Model, a_from_b: &Isometry, below_mm: f64, proximity: &mut Proximity) -> f64;

    /// Memory held, bytes.
    fn bytes(&self) -> usize;

    /// What there is to say about the tree, for methods that have one of ours.
    fn tree_report(&self) -> Option<crate::tree::tightness::TreeReport>;

    /// The volumes of the first `levels` levels of a tree of ours, as they are drawn; none for methods without one.
    fn drawn(&self, levels: u32) -> Vec<Drawn> {
        let _ = levels;
        Vec::new()
    }

    /// The tree as one of oriented boxes, for methods that have one whose volumes are boxes.
    fn boxes(&self) -> Option<Tree<Obb>> {
        None
    }

    /// Whether the tree, where there is one of ours, divides the triangles properly.
    ///
    /// # Errors
    /// The first fault found.
    fn check_structure(&self) -> Result<(), TreeFault> {
        Ok(())
    }

    /// Whether each node's volume, where there is a tree of ours, contains every corner of its triangles, within
    /// `slack_mm`.
    ///
    /// # Errors
    /// The first corner outside.
    fn check_containment(&self, slack_mm: f64) -> Result<(), TreeFault> {
        let _ = slack_mm;
        Ok(())
    }

    /// Whether what each node's volume says of its size and shape, where there is a tree of ours, is so.
    ///
    /// # Errors
    /// The first volume that says something else.
    fn check_consistency(&self) -> Result<(), TreeFault> {
        Ok(())
    }
}

/// The concrete model behind `other`.
///
/// # Panics
/// When `other` was prepared by another variant, which only a mistake in this program can do.
pub(crate) fn same<M: Model>(other: &dyn Model) -> &M {
    let any: &dyn Any = other;
    any.downcast_ref().expect("both meshes of a pair are prepared by the same variant")
}
