//! A binary tree of bounding volumes over one mesh, generic over the shape of the volumes.
//!
//! There is one file for each operation: [`split`] (the rules), [`build`], [`traverse`], [`distance`], [`witness`], [`validate`],
//! [`tightness`], [`spread`], [`summary`] and [`levels`] (for drawing). The last four read the tree through [`nodes`].

pub mod build;
pub mod distance;
pub mod levels;
pub mod nodes;
pub mod policy;
pub mod split;
pub mod spread;
pub mod summary;
pub mod tightness;
pub mod traverse;
pub mod validate;
pub mod witness;

pub use policy::{Axes, Policy, SplitRule};

use crate::geometry::Triangle;

/// One node: a volume and the range of triangles it was fitted to.
#[derive(Clone, Debug)]
pub struct Node<S> {
    /// The volume around the node's own triangles; it is fitted to them, never merged from the volumes of the children.
    pub volume: S,
    /// [`crate::volume::Shape::size`] of the volume: of two nodes, the traversal opens the larger one.
    pub size: f64,
    /// Index of the left child; the right child follows it. 0 marks a leaf, because the root is never a child.
    children: u32,
    /// Index of the node's first triangle in [`Tree::triangles`].
    first: u32,
    /// Number of the node's triangles.
    count: u32,
}

impl<S> Node<S> {
    /// The left and right child's index, or `None` for a leaf.
    #[inline]
    pub const fn children(&self) -> Option<(u32, u32)> {
        if self.children == 0 { None } else { Some((self.children, self.children + 1)) }
    }

    /// The node's range in [`Tree::triangles`].
    #[inline]
    pub const fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// A tree over one mesh, in the mesh's own frame.
#[derive(Clone, Debug)]
pub struct Tree<S> {
    /// The nodes; the root is node 0. Siblings are adjacent and come after their parent.
    nodes: Vec<Node<S>>,
    /// The triangles in tree order, mm.
    triangles: Vec<Triangle>,
    /// For each triangle in tree order, its face number in the mesh.
    faces: Vec<u32>,
}

impl<S> Tree<S> {
    /// All nodes, the root first.
    pub fn nodes(&self) -> &[Node<S>] {
        &self.nodes
    }

    /// All triangles in tree order, mm, mesh frame.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// The face number in the mesh of each triangle in tree order.
    pub fn faces(&self) -> &[u32] {
        &self.faces
    }

    /// The triangles of one node.
    pub fn triangles_of(&self, node: &Node<S>) -> &[Triangle] {
        &self.triangles[node.range()]
    }

    /// The same tree with each volume replaced by `volume`; `None` when that returns `None` for any of them.
    pub fn with_volumes<W>(&self, volume: impl Fn(&S) -> Option<W>) -> Option<Tree<W>> {
        let node = |node: &Node<S>| {
            let Node { size, children, first, count, .. } = *node;
            Some(Node { volume: volume(&node.volume)?, size, children, first, count })
        };
        let nodes = self.nodes.iter().map(node).collect::<Option<_>>()?;
        Some(Tree { nodes, triangles: self.triangles.clone(), faces: self.faces.clone() })
    }

    /// Memory the tree holds, bytes. A volume that owns memory besides its own size does not compile: it would not be counted.
    pub fn bytes(&self) -> usize {
        const { assert!(!std::mem::needs_drop::<S>(), "a shape must not own memory: `Tree::bytes` would not count it") };
        size_of_val(self.nodes.as_slice()) + size_of_val(self.triangles.as_slice()) + size_of_val(self.faces.as_slice())
    }
}
