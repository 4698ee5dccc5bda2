//! Sums over all volumes of a tree, and the corners that they do not contain. Computed without convex hulls, so it is cheap enough for
//! hundreds of trees.

use super::Tree;
use super::nodes::AnyNode;
use super::tightness::{TreeReport, distance_outside};
use crate::geometry::triangle;
use crate::volume::Shape;

/// Facts about the volumes of one tree, summed over all its nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeSummary {
    /// Volume of the root, mm³.
    pub root_volume_mm3: f64,
    /// Sum of the surface areas of all volumes, mm².
    pub area_mm2: f64,
    /// Nodes with a corner outside their volume.
    pub outside_nodes: u64,
    /// Corners outside their node's volume; a corner counts once for each node that holds it.
    pub outside_corners: u64,
    /// All corners, counted in the same way.
    pub corners: u64,
    /// Largest distance of a corner from its node's volume, mm.
    pub overhang_mm: f64,
}

impl<S: Shape> Tree<S> {
    /// Measures the tree without its levels: [`TreeReport`] without levels and outline.
    pub fn brief_report(&self) -> TreeReport {
        TreeReport::brief(&self.any_nodes())
    }
}

impl TreeSummary {
    pub(super) fn of(nodes: &[AnyNode]) -> Self {
        let mut summary = Self {
            root_volume_mm3: nodes[0].volume.volume(),
            area_mm2: nodes.iter().map(|node| node.volume.surface_area()).sum(),
            outside_nodes: 0,
            outside_corners: 0,
            corners: 0,
            overhang_mm: 0.0,
        };
        for node in nodes {
            let mut outside = 0;
            for corner in triangle::corners(node.triangles) {
                summary.corners += 1;
                if node.volume.contains(corner, 0.0) {
                    continue;
                }
                outside += 1;
                // Only a corner farther out than all before it has to be measured.
                if !node.volume.contains(corner, summary.overhang_mm) {
                    summary.overhang_mm = distance_outside(node.volume, corner);
                }
            }
            summary.outside_corners += outside;
            summary.outside_nodes += u64::from(outside > 0);
        }
        summary
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::{Policy, SplitRule};
    use crate::volume::BoundingVolume;
    use crate::volume::Solid;
    use crate::volume::obb_vertex::ObbVertex;
    use crate::volume::obb_vertex_centroid::ObbVertexCentroid;
    use obbtree::cases::meshes;

    #[test]
    fn the_summary_agrees_with_the_report() {
        let triangles = meshes::stepped_tool(12, 20).triangles();
        let policy = Policy::own(SplitRule::VertexMean);
        let tree = Tree::build(&ObbVertexCentroid::fit, &triangles, policy);
        let (brief, report) = (tree.brief_report(), tree.report());
        let summary = brief.summary.unwrap();
        assert_eq!((report.summary, brief.levels.len()), (brief.summary, 0));
        assert_eq!((brief.nodes, brief.sah_cost, brief.drift_mm), (report.nodes, report.sah_cost, report.drift_mm));
        assert_eq!(summary.root_volume_mm3, report.levels[0].volume_mm3);
        assert!(
            (summary.area_mm2 / tree.nodes()[0].volume.surface_area() - report.sah_cost).abs() < 1e-9 * report.sah_cost
        );
        // The root is the largest box, so it has the largest overhang.
        let overhang = report.levels[0].overhang_mm;
        assert!(overhang > 1.0 && (summary.overhang_mm - overhang).abs() < 1e-6 * overhang);
        assert!(0 < summary.outside_nodes && summary.outside_nodes <= summary.outside_corners);
    }

    #[test]
    fn a_tight_tree_leaves_nothing_out_and_counts_a_corner_on_every_level() {
        // A cuboid's 12 triangles halve to leaves of mean depth 11/3: 3 · 12 corners on each of 11/3 + 1 levels.
        let triangles = meshes::cuboid(2.0, 4.0, 6.0).triangles();
        let summary = Tree::build(&ObbVertex::fit, &triangles, Policy::own(SplitRule::Median)).brief_report();
        let summary = summary.summary.unwrap();
        assert_eq!((summary.outside_nodes, summary.outside_corners, summary.overhang_mm), (0, 0, 0.0));
        assert_eq!(summary.corners, 36 * 14 / 3);
    }
}
