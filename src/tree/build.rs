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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance::meshes;
    use crate::tree::SplitRule;
    use crate::volume::aabb::Aabb;
    use crate::volume::sphere_ritter::SphereRitter;

    #[test]
    fn single_triangle_leaves_make_one_node_less_than_twice_the_triangles() {
        let triangles = meshes::cuboid(1.0, 2.0, 3.0).triangles();
        for split in SplitRule::ALL {
            let tree = Tree::<Aabb>::build(&triangles, Policy::own(split));
            assert_eq!(tree.nodes().len(), 23, "{split}"); // 2·12 - 1
            assert_eq!(tree.check_structure(), Ok(()));
        }
    }

    #[test]
    fn leaves_hold_at_most_what_the_policy_says_and_inner_nodes_more() {
        let triangles = meshes::torus(12.0, 4.0, 14, 7).triangles();
        for leaf in Policy::LEAF_RANGE {
            let tree = Tree::<SphereRitter>::build(&triangles, Policy { leaf, ..Policy::own(SplitRule::Midpoint) });
            for node in tree.nodes() {
                assert_eq!(node.children().is_none(), node.range().len() <= leaf as usize);
            }
        }
    }

    #[test]
    fn the_triangles_keep_their_face_numbers() {
        let triangles = meshes::stepped_tool(8, 4).triangles();
        let tree = Tree::<Aabb>::build(&triangles, Policy::own(SplitRule::Sah16));
        for (triangle, &face) in tree.triangles().iter().zip(tree.faces()) {
            assert_eq!(*triangle, triangles[face as usize]);
        }
    }

    #[test]
    fn shared_axes_give_every_volume_the_same_topology() {
        let triangles = meshes::stepped_tool(8, 4).triangles();
        let policy = Policy::shared(SplitRule::AreaMean);
        let (boxes, spheres) =
            (Tree::<Aabb>::build(&triangles, policy), Tree::<SphereRitter>::build(&triangles, policy));
        assert_eq!(boxes.faces(), spheres.faces());
        assert!(boxes.nodes().iter().zip(spheres.nodes()).all(|(a, b)| a.range() == b.range()));
        let own = Tree::<Aabb>::build(&triangles, Policy::own(SplitRule::AreaMean));
        assert_ne!(own.faces(), boxes.faces());
    }
}
