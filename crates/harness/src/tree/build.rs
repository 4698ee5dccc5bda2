//! Top-down construction, on several threads when the caller runs on a thread pool.
//!
//! The result does not depend on the number of threads. Below a node, the nodes of the left side come first, then those of the right side,
//! and each side is built from its own triangles alone. A side is handed to another thread only when it is large enough to be worth it.

use super::policy::{Axes, Policy};
use super::split::{self, Item};
use super::{Node, Tree};
use crate::geometry::Triangle;
use crate::volume::Shape;

/// Smallest node, in triangles, whose two sides are built in parallel: about 10 ms of work, a thousand times the cost of handing it over. Tests share smaller ones.
const SHARED_FROM: usize = if cfg!(test) { 1 << 9 } else { 1 << 14 };

impl<S: Shape> Tree<S> {
    /// Builds the tree over `triangles` (mm, mesh frame; at least one), with volumes from `fit`. The result is the same for the same input
    /// on every machine and for any number of threads. Fits of one shape share all machine code of construction and queries. On a thread of
    /// a rayon pool, construction uses the pool; on any other thread, such as that of a timing, it uses one thread.
    ///
    /// # Panics
    /// When `triangles` is empty or has more than 2³¹ members; a [`crate::geometry::Mesh`] is never either.
    pub fn build(fit: Fit<'_, S>, triangles: &[Triangle], policy: Policy) -> Self {
        assert!(!triangles.is_empty(), "a tree needs at least one triangle");
        assert!(triangles.len() < (1 << 31), "node numbers are 32 bits");
        let mut items: Vec<Item> = triangles.iter().zip(0..).map(|(&triangle, face)| Item { triangle, face }).collect();
        let mut placed = triangles.to_vec();
        let builder = Builder { fit, policy, shared: rayon::current_thread_index().is_some() };
        let mut root = builder.leaf(&placed, 0);
        let pieces = builder.below(&root, Stretch { items: &mut items, placed: &mut placed, first: 0 });
        root.children = u32::from(!pieces.is_empty());
        let mut nodes = Vec::with_capacity(1 + nodes_of(&pieces));
        nodes.push(root);
        for piece in pieces {
            let start = nodes.len() as u32;
            nodes.extend(piece.into_iter().map(|mut node| {
                if node.children > 0 {
                    node.children += start;
                }
                node
            }));
        }
        Self { nodes, triangles: placed, faces: items.iter().map(|item| item.face).collect() }
    }
}

/// How a volume is fitted to at least one triangle (mm, mesh frame).
pub type Fit<'a, S> = &'a (dyn Fn(&[Triangle]) -> S + Sync);

/// The triangles of one node, in their current order.
struct Stretch<'a> {
    items: &'a mut [Item],
    /// The same triangles without face numbers, for fitting volumes.
    placed: &'a mut [Triangle],
    /// Index of the first triangle in tree order.
    first: usize,
}

impl Stretch<'_> {
    /// The part of the stretch that belongs to a node.
    fn of<S>(&mut self, node: &Node<S>) -> Stretch<'_> {
        let range = node.range().start - self.first..node.range().end - self.first;
        Stretch { first: node.range().start, items: &mut self.items[range.clone()], placed: &mut self.placed[range] }
    }

    fn split_at(&mut self, middle: usize) -> (Stretch<'_>, Stretch<'_>) {
        let (items, more_items) = self.items.split_at_mut(middle);
        let (placed, more_placed) = self.placed.split_at_mut(middle);
        let right = Stretch { items: more_items, placed: more_placed, first: self.first + middle };
        (Stretch { items, placed, first: self.first }, right)
    }
}

/// Consecutive nodes. A child's index counts from the first node of its parent's piece.
type Piece<S> = Vec<Node<S>>;

fn nodes_of<S>(pieces: &[Piece<S>]) -> usize {
    pieces.iter().map(Vec::len).sum()
}

/// A child and everything below it.
type Side<S> = (Node<S>, Vec<Piece<S>>);

struct Builder<'a, S> {
    fit: Fit<'a, S>,
    policy: Policy,
    /// Whether the sides of large nodes are built in parallel.
    shared: bool,
}

/// Runs both closures in parallel. Not generic, so that the trees of all volumes share one copy of the scheduler's code.
fn both(one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
    rayon::join(one, other);
}

impl<S: Shape> Builder<'_, S> {
    /// A leaf around `triangles`; `first` is the index of the first one in tree order.
    fn leaf(&self, triangles: &[Triangle], first: usize) -> Node<S> {
        let volume = (self.fit)(triangles);
        let size = volume.size();
        Node { volume, size, children: 0, first: first as u32, count: triangles.len() as u32 }
    }

    /// The subtree below the node `parent`, whose triangles are `stretch`; its children come first. Empty when the node becomes a leaf.
    fn below(&self, parent: &Node<S>, mut stretch: Stretch<'_>) -> Vec<Piece<S>> {
        if stretch.items.len() <= self.policy.leaf as usize {
            return Vec::new();
        }
        if !self.shared || stretch.items.len() < SHARED_FROM {
            return vec![self.below_alone(parent, stretch)];
        }
        let middle = self.divide(parent, &mut stretch);
        let (left, right) = stretch.split_at(middle);
        let (mut sides, mut others) = ((Some(left), None), (Some(right), None));
        let side = |(stretch, built): &mut (Option<Stretch<'_>>, Option<Side<S>>)| {
            *built = stretch.take().map(|stretch| {
                let node = self.leaf(stretch.placed, stretch.first);
                let below = self.below(&node, stretch);
                (node, below)
            });
        };
        both(&mut || side(&mut sides), &mut || side(&mut others));
        let (Some((mut left, left_below)), Some((mut right, right_below))) = (sides.1, others.1) else {
            unreachable!("both sides have been built");
        };
        if !left_below.is_empty() {
            left.children = 2;
        }
        if !right_below.is_empty() {
            right.children = 2 + nodes_of(&left_below) as u32;
        }
        let mut pieces = vec![vec![left, right]];
        pieces.extend(left_below);
        pieces.extend(right_below);
        pieces
    }

    /// Like [`Builder::below`] for a node that is divided, on one thread and in one piece.
    fn below_alone(&self, parent: &Node<S>, mut stretch: Stretch<'_>) -> Piece<S> {
        let mut nodes = Vec::with_capacity(2 * stretch.items.len().div_ceil(self.policy.leaf as usize));
        let push_children = |nodes: &mut Piece<S>, mut stretch: Stretch<'_>, middle: usize| {
            let (left, right) = stretch.split_at(middle);
            nodes.push(self.leaf(left.placed, left.first));
            nodes.push(self.leaf(right.placed, right.first));
        };
        let middle = self.divide(parent, &mut stretch);
        push_children(&mut nodes, stretch.of(parent), middle);
        let mut open = vec![1, 0];
        while let Some(index) = open.pop() {
            let mut own = stretch.of(&nodes[index]);
            if own.items.len() <= self.policy.leaf as usize {
                continue;
            }
            let middle = self.divide(&nodes[index], &mut own);
            let left = nodes.len();
            nodes[index].children = left as u32;
            push_children(&mut nodes, own, middle);
            open.push(left + 1);
            open.push(left);
        }
        nodes
    }

    /// Partitions a node's triangles into those of its left and right child, and returns the number on the left.
    fn divide(&self, node: &Node<S>, stretch: &mut Stretch<'_>) -> usize {
        let axes = match self.policy.axes {
            Axes::Own => node.volume.split_axes(stretch.placed),
            Axes::Shared => split::shared_axes(stretch.placed),
        };
        let middle = split::divide(stretch.items, self.policy.split, &axes);
        for (slot, item) in stretch.placed.iter_mut().zip(stretch.items.iter()) {
            *slot = item.triangle;
        }
        middle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::SplitRule;
    use crate::volume::BoundingVolume;
    use crate::volume::aabb::Aabb;
    use crate::volume::sphere_ritter::SphereRitter;
    use obbtree::cases::meshes;

    #[test]
    fn single_triangle_leaves_make_one_node_less_than_twice_the_triangles() {
        let triangles = meshes::cuboid(1.0, 2.0, 3.0).triangles();
        for split in SplitRule::ALL {
            let tree = Tree::build(&Aabb::fit, &triangles, Policy::own(split));
            assert_eq!(tree.nodes().len(), 23, "{split}"); // 2·12 - 1
            assert_eq!(tree.check_structure(), Ok(()));
        }
    }

    #[test]
    fn leaves_hold_at_most_what_the_policy_says_and_inner_nodes_more() {
        let triangles = meshes::torus(12.0, 4.0, 14, 7).triangles();
        for leaf in Policy::LEAF_RANGE {
            let tree = Tree::build(&SphereRitter::fit, &triangles, Policy { leaf, ..Policy::own(SplitRule::Midpoint) });
            for node in tree.nodes() {
                assert_eq!(node.children().is_none(), node.range().len() <= leaf as usize);
            }
        }
    }

    #[test]
    fn the_triangles_keep_their_face_numbers() {
        let triangles = meshes::stepped_tool(8, 4).triangles();
        let tree = Tree::build(&Aabb::fit, &triangles, Policy::own(SplitRule::Sah16));
        for (triangle, &face) in tree.triangles().iter().zip(tree.faces()) {
            assert_eq!(*triangle, triangles[face as usize]);
        }
    }

    #[test]
    fn a_pool_of_threads_builds_the_same_tree() {
        // At least one node is shared out.
        let triangles = meshes::torus(12.0, 4.0, 40, 20).triangles();
        assert!(triangles.len() > 2 * SHARED_FROM);
        for policy in [Policy::own(SplitRule::AreaMean), Policy { leaf: 3, ..Policy::own(SplitRule::Median) }] {
            let alone = Tree::build(&SphereRitter::fit, &triangles, policy);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
            let shared = pool.install(|| Tree::build(&SphereRitter::fit, &triangles, policy));
            assert_eq!(shared.check_structure(), Ok(()));
            assert_eq!(shared.faces(), alone.faces());
            assert_eq!(format!("{:?}", shared.nodes()), format!("{:?}", alone.nodes()));
        }
    }

    #[test]
    fn outside_a_pool_a_tree_is_built_by_the_thread_that_asked() {
        let triangles = meshes::torus(12.0, 4.0, 40, 20).triangles();
        assert!(triangles.len() > 2 * SHARED_FROM);
        let (own, others) = (std::thread::current().id(), std::sync::atomic::AtomicUsize::new(0));
        let fit = |triangles: &[Triangle]| {
            if std::thread::current().id() != own {
                others.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            }
            SphereRitter::fit(triangles)
        };
        let tree = Tree::build(&fit, &triangles, Policy::own(SplitRule::Median));
        assert_eq!(tree.check_structure(), Ok(()));
        assert_eq!(others.into_inner(), 0);
    }

    #[test]
    fn a_tree_holds_its_nodes_triangles_and_face_numbers() {
        let triangles = meshes::cuboid(1.0, 2.0, 3.0).triangles();
        let tree = Tree::build(&Aabb::fit, &triangles, Policy::own(SplitRule::Median));
        let node = size_of_val(&tree.nodes()[0]);
        assert_eq!(tree.bytes(), 23 * node + 12 * (size_of::<Triangle>() + 4));
    }

    #[test]
    fn shared_axes_give_every_volume_the_same_topology() {
        let triangles = meshes::stepped_tool(8, 4).triangles();
        let policy = Policy::shared(SplitRule::AreaMean);
        let (boxes, spheres) =
            (Tree::build(&Aabb::fit, &triangles, policy), Tree::build(&SphereRitter::fit, &triangles, policy));
        assert_eq!(boxes.faces(), spheres.faces());
        assert!(boxes.nodes().iter().zip(spheres.nodes()).all(|(a, b)| a.range() == b.range()));
        let own = Tree::build(&Aabb::fit, &triangles, Policy::own(SplitRule::AreaMean));
        assert_ne!(own.faces(), boxes.faces());
    }
}
