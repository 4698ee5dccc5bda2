//! The ground truth about a pair of meshes at a pose, computed without any of the volumes under test.
//!
//! | file | question |
//! |---|---|
//! | [`judge`] | do the surfaces touch? is one solid inside the other? |
//! | [`clearance`] | how far apart are they? |
//! | [`first_contact`] | how far can the second slide before they touch? |
//! | [`contain`] | is one solid inside the other, asked of solids that have no partner? |
//! | [`path`] | how far past first contact is a pose of a path? |
//! | [`cache`] | keeping the answers |
//!
//! `boxes` holds the tree of axis-aligned boxes, and the proof of its rounding bound.
//!
//! [`Verdict::touches`] and [`Verdict::contained`] are exact, for the first mesh and for the second mesh with its vertices moved and
//! snapped to the grid ([`Placement`]). Lengths in mm are accurate to rounding.

pub(crate) mod boxes;
pub mod cache;
pub mod clearance;
pub mod contain;
pub mod first_contact;
pub mod judge;
pub mod path;

#[cfg(test)]
mod solids;

pub use cache::{CacheError, TruthCache, TruthKey};
pub use clearance::Sought;
pub use contain::{Solid, stray_components};
pub use judge::{Judgement, Verdict, judge_all};
pub use path::path_depths;

use crate::geometry::grid::Placement;
use crate::geometry::plane::Plane;
use crate::geometry::{Isometry, Mesh, Point};
use boxes::{Bounds, BoxTree, Mover};
use std::sync::Arc;

/// The ground truth for one pair of meshes at any pose. Immutable and shared between threads. Building it costs one sort of the triangles
/// of each mesh.
#[derive(Clone, Debug)]
pub struct PairOracle {
    a: Side,
    b: Side,
    /// The planes of the triangles of `a`, in the order of its tree.
    planes: Vec<Plane>,
}

/// The oracle's data for one mesh, in the mesh's own frame.
#[derive(Clone, Debug)]
struct Side {
    mesh: Arc<Mesh>,
    tree: BoxTree,
    /// One vertex of each connected component, mm.
    representatives: Vec<Point>,
    watertight: bool,
}

impl Side {
    fn new(mesh: Arc<Mesh>) -> Self {
        let enclosing = contain::enclosing(&mesh);
        Self {
            watertight: enclosing.is_some(),
            tree: BoxTree::new(&enclosing.unwrap_or_else(|| mesh.triangles())),
            representatives: contain::representatives(&mesh),
            mesh,
        }
    }

    fn bounds(&self) -> &Bounds {
        &self.tree.nodes[0].bounds
    }
}

/// A pose in the form that the oracle uses: the exact placement of vertices, and the conservative placement of boxes.
struct Posed {
    placement: Placement,
    mover: Mover,
}

impl PairOracle {
    /// Prepares two meshes. Poses given to the oracle place `b` in the frame of `a`.
    pub fn new(a: Arc<Mesh>, b: Arc<Mesh>) -> Self {
        let (a, b) = (Side::new(a), Side::new(b));
        Self { planes: a.tree.triangles.iter().map(Plane::of).collect(), a, b }
    }

    /// The mesh in whose frame poses are given.
    pub fn mesh_a(&self) -> &Arc<Mesh> {
        &self.a.mesh
    }

    /// The mesh that poses move.
    pub fn mesh_b(&self) -> &Arc<Mesh> {
        &self.b.mesh
    }

    fn posed(&self, a_from_b: &Isometry) -> Posed {
        Posed { placement: Placement::new(a_from_b), mover: Mover::new(a_from_b, self.b.bounds()) }
    }
}
