//! Whether a tree is well formed.

use super::Tree;
use crate::geometry::triangle;
use crate::volume::BoundingVolume;

/// The first thing found wrong with a tree.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TreeFault {
    /// Children do not divide their parent's triangles.
    #[error("node {node}: its children do not divide its triangles")]
    Division {
        /// The parent.
        node: usize,
    },
    /// A face is missing or occurs twice.
    #[error("the tree does not hold every face exactly once")]
    Faces,
    /// A corner is outside its node's volume.
    #[error("node {node}: corner ({x}, {y}, {z}) mm lies outside its volume")]
    Outside {
        /// The node.
        node: usize,
        /// First coordinate of the corner, mm.
        x: f64,
        /// Second coordinate, mm.
        y: f64,
        /// Third coordinate, mm.
        z: f64,
    },
}

impl<V> Tree<V> {
    /// Checks that the nodes form a tree over all faces.
    ///
    /// # Errors
    /// The first [`TreeFault`] found.
    pub fn check_structure(&self) -> Result<(), TreeFault> {
        let mut seen = vec![false; self.triangles.len()];
        for &face in &self.faces {
            match seen.get_mut(face as usize) {
                Some(flag) if !*flag => *flag = true,
                _ => return Err(TreeFault::Faces),
            }
        }
        for (index, node) in self.nodes.iter().enumerate() {
            let Some((left, right)) = node.children() else { continue };
            let (l, r) = (self.nodes[left as usize].range(), self.nodes[right as usize].range());
            let whole = node.range();
            if l.start != whole.start || l.end != r.start || r.end != whole.end || l.is_empty() || r.is_empty() {
                return Err(TreeFault::Division { node: index });
            }
        }
        Ok(())
    }
}

impl<V: BoundingVolume> Tree<V> {
    /// Checks that every node's volume contains every corner of the node's triangles, within `slack_mm`.
    ///
    /// # Errors
    /// The first corner outside.
    pub fn check_containment(&self, slack_mm: f64) -> Result<(), TreeFault> {
        for (index, node) in self.nodes.iter().enumerate() {
            let outside = triangle::corners(self.triangles_of(node)).find(|p| !node.volume.contains(p, slack_mm));
            if let Some(p) = outside {
                return Err(TreeFault::Outside { node: index, x: p.x, y: p.y, z: p.z });
            }
        }
        Ok(())
    }
}
