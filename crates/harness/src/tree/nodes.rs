//! The nodes of a tree without the type of their volumes. Untimed measurements of a tree use them, so that one copy of the code serves all
//! volumes.

use super::Tree;
use crate::geometry::Triangle;
use crate::volume::{Shape, Solid};

/// One node.
#[derive(Clone, Copy)]
pub(super) struct AnyNode<'a> {
    pub volume: &'a dyn Solid,
    /// Indices of the left and right child.
    pub children: Option<(u32, u32)>,
    /// Depth of the node; the root has depth 0.
    pub depth: u32,
    /// The node's triangles, mm, mesh frame.
    pub triangles: &'a [Triangle],
}

impl<S: Shape> Tree<S> {
    /// All nodes, in the order of [`Tree::nodes`].
    pub(super) fn any_nodes(&self) -> Vec<AnyNode<'_>> {
        let mut nodes = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let (volume, triangles): (&dyn Solid, _) = (&node.volume, self.triangles_of(node));
            nodes.push(AnyNode { volume, children: node.children(), depth: 0, triangles });
        }
        set_depths(&mut nodes);
        nodes
    }
}

/// Sets the depth of every node. Children must come after their parents.
fn set_depths(nodes: &mut [AnyNode]) {
    for index in 0..nodes.len() {
        let depth = nodes[index].depth + 1;
        if let Some((left, right)) = nodes[index].children {
            nodes[left as usize].depth = depth;
            nodes[right as usize].depth = depth;
        }
    }
}

/// The mean depth of a leaf, weighted by its number of triangles.
pub(super) fn mean_leaf_depth(nodes: &[AnyNode]) -> f64 {
    let leaves = nodes.iter().filter(|node| node.children.is_none());
    let weighted: f64 = leaves.map(|leaf| f64::from(leaf.depth) * leaf.triangles.len() as f64).sum();
    weighted / nodes[0].triangles.len() as f64
}

/// The mean of smaller / larger child count over inner nodes, weighted by each node's count; 1 is balanced.
pub(super) fn child_ratio(nodes: &[AnyNode]) -> f64 {
    let (mut sum, mut weight) = (0.0, 0.0);
    let count = |node: u32| nodes[node as usize].triangles.len();
    for node in nodes {
        if let Some((l, r)) = node.children.map(|(left, right)| (count(left), count(right))) {
            let own = node.triangles.len() as f64;
            sum += own * l.min(r) as f64 / l.max(r) as f64;
            weight += own;
        }
    }
    if weight > 0.0 { sum / weight } else { 1.0 }
}
