//! A tree for drawing: the volumes of its upper levels as line segments.

use super::Tree;
use super::nodes::AnyNode;
use crate::geometry::triangle;
use crate::volume::{Segment, Shape};

/// One node in a form for drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Depth of the node; the root has depth 0.
    pub level: u32,
    /// Whether the node has no children; a leaf is also part of all deeper levels.
    pub leaf: bool,
    /// Outline of the node's volume, mm, mesh frame.
    pub outline: Vec<Segment>,
    /// Its volume, mm³.
    pub volume_mm3: f64,
    /// Number of corners of its triangles outside its volume.
    pub outside: u32,
}

impl<S: Shape> Tree<S> {
    /// The nodes of the first `levels` levels, in the order of [`Tree::nodes`].
    pub fn drawn(&self, levels: u32) -> Vec<Drawn> {
        self.any_nodes().iter().filter(|node| node.depth < levels).map(Drawn::of).collect()
    }
}

impl Drawn {
    fn of(node: &AnyNode) -> Self {
        let outside = |corner: &&_| !node.volume.contains(corner, 0.0);
        Self {
            level: node.depth,
            leaf: node.children.is_none(),
            outline: node.volume.outline(),
            volume_mm3: node.volume.volume(),
            outside: triangle::corners(node.triangles).filter(outside).count() as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::{Policy, SplitRule};
    use crate::volume::BoundingVolume;
    use crate::volume::aabb::Aabb;
    use crate::volume::obb_vertex_centroid::ObbVertexCentroid;
    use obbtree::cases::meshes;

    #[test]
    fn the_upper_levels_of_a_balanced_tree() {
        let triangles = meshes::stepped_tool(8, 4).triangles();
        let drawn = Tree::build(&Aabb::fit, &triangles, Policy::own(SplitRule::Median)).drawn(3);
        // Halving at the median gives 1 + 2 + 4 nodes; a box has twelve edges.
        let levels: Vec<u32> = drawn.iter().map(|node| node.level).collect();
        assert_eq!(levels.iter().filter(|&&level| level == 2).count(), 4);
        assert_eq!((drawn.len(), levels[0], drawn[0].outline.len()), (7, 0, 12));
        assert!(drawn.iter().all(|node| node.outside == 0 && !node.leaf));
    }

    #[test]
    fn a_box_that_has_drifted_leaves_corners_outside() {
        let triangles = meshes::stepped_tool(8, 4).triangles();
        let tree = Tree::build(&ObbVertexCentroid::fit, &triangles, Policy::own(SplitRule::VertexMean));
        assert!(tree.drawn(1)[0].outside > 0);
    }
}
