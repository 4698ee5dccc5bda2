//! Top-down construction.

use super::policy::{Axes, Policy};
use super::split::{self, Item};
use super::{Node, Tree};
use crate::geometry::Triangle;
use crate::volume::BoundingVolume;

impl<V: BoundingVolume> Tree<V> {
    /// The tree over `triangles` (mm, mesh frame; at least one), the same for the same input on every machine.
    ///
    /// # Panics
    /// When `triangles` is empty or has more than 2³¹ members: a [`crate::geometry::Mesh`] is neither.
    #[must_use]
    pub fn build(triangles: &[Triangle], policy: Policy) -> Self {
        assert!(!triangles.is_empty(), "a tree needs at least one triangle");
        assert!(triangles.len() < (1 << 31), "node numbers are 32 bits");
        let mut items: Vec<Item> = triangles.iter().zip(0..).map(|(&triangle, face)| Item { triangle, face }).collect();
        let mut scratch = triangles.to_vec();
        let mut nodes = Vec::with_capacity(2 * triangles.len().div_ceil(policy.leaf as usize));
        nodes.push(node(&scratch, 0));
        let mut open = vec![0];
        while let Some(index) = open.pop() {
            let parent: &Node<V> = &nodes[index];
            let range = parent.range();
            if range.len() <= policy.leaf as usize {
                continue;
            }
            let axes = match policy.axes {
                Axes::Own => parent.volume.split_axes(&scratch[range.clone()]),
                Axes::Shared => split::shared_axes(&scratch[range.clone()]),
            };
            let middle = range.start + split::divide(&mut items[range.clone()], policy.split, &axes);
            for (slot, item) in scratch[range.clone()].iter_mut().zip(&items[range.clone()]) {
                *slot = item.triangle;
            }
            let left = nodes.len();
            nodes[index].children = left as u32;
            nodes.push(node(&scratch[range.start..middle], range.start));
            nodes.push(node(&scratch[middle..range.end], middle));
            open.push(left + 1);
            open.push(left);
        }
        Self { nodes, triangles: scratch, faces: items.iter().map(|item| item.face).collect() }
    }
}

/// A leaf around `triangles`, which start at `first` in tree order.
fn node<V: BoundingVolume>(triangles: &[Triangle], first: usize) -> Node<V> {
    let volume = V::fit(triangles);
    let size = volume.size();
    Node { volume, size, children: 0, first: first as u32, count: triangles.len() as u32 }
}
