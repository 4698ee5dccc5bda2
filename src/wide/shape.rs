//! A wide tree for the eye, and facts about it.

use super::node::{Contents, WideTree};
use super::volume::WideVolume;
use crate::tree::levels::Drawn;
use crate::tree::tightness::{TreeReport, drift};
use crate::volume::BoundingVolume;

/// What lies below a slot.
#[derive(Clone, Copy, Default)]
struct Below {
    nodes: usize,
    leaves: usize,
    /// Sum of the depths of the leaves, each a triangle.
    depths: u64,
    depth_max: u32,
    /// Sum of the volumes' surface areas, mm².
    area_mm2: f64,
}

impl<V: WideVolume> WideTree<V> {
    /// The volume of a slot.
    pub(super) fn plain(&self, slot: u32) -> V::Plain {
        let (node, place) = self.slot(slot);
        node.volume(place).plain(node.origin)
    }

    /// The volumes of the first `levels` levels, a node before what is below it.
    #[must_use]
    pub fn drawn(&self, levels: u32) -> Vec<Drawn> {
        let (mut drawn, mut waiting) = (Vec::new(), vec![(0, 0)]);
        while let Some((slot, level)) = waiting.pop() {
            if level >= levels {
                continue;
            }
            let volume = self.plain(slot);
            let children: Vec<u32> = self.children(slot).collect();
            drawn.push(Drawn {
                level,
                leaf: children.is_empty(),
                outline: volume.outline(),
                volume_mm3: volume.volume(),
                outside: self.corners_outside(slot, &volume),
            });
            waiting.extend(children.into_iter().rev().map(|child| (child, level + 1)));
        }
        drawn
    }

    /// Size and depth of the tree; its volumes hold their contents, and it has no levels of two.
    #[must_use]
    pub fn report(&self) -> TreeReport {
        let (below, root) = (self.below(0, 0), self.plain(0));
        let triangles: Vec<_> = (0..self.len() as u32).map(|place| self.triangle(place)).collect();
        TreeReport {
            nodes: below.nodes,
            leaves: below.leaves,
            depth_max: below.depth_max,
            depth_mean: below.depths as f64 / below.leaves as f64,
            sah_cost: below.area_mm2 / root.surface_area(),
            drift_mm: drift(&root.centre(), &triangles),
            root_outline: root.outline(),
            ..TreeReport::not_binary()
        }
    }

    /// The slots below a slot; none below a triangle's.
    fn children(&self, slot: u32) -> impl Iterator<Item = u32> {
        match self.contents(slot) {
            Contents::Node(node) => node * 8..node * 8 + u32::from(self.nodes[node as usize].count),
            Contents::Triangle(_) => 0..0,
        }
    }

    fn below(&self, slot: u32, depth: u32) -> Below {
        let area_mm2 = self.plain(slot).surface_area();
        if let Contents::Triangle(_) = self.contents(slot) {
            return Below { nodes: 1, leaves: 1, depths: u64::from(depth), depth_max: depth, area_mm2 };
        }
        let own = Below { nodes: 1, area_mm2, ..Below::default() };
        self.children(slot).map(|child| self.below(child, depth + 1)).fold(own, |sum, more| Below {
            nodes: sum.nodes + more.nodes,
            leaves: sum.leaves + more.leaves,
            depths: sum.depths + more.depths,
            depth_max: sum.depth_max.max(more.depth_max),
            area_mm2: sum.area_mm2 + more.area_mm2,
        })
    }

    fn corners_outside(&self, slot: u32, volume: &V::Plain) -> u32 {
        match self.contents(slot) {
            Contents::Triangle(place) => {
                let corners = self.triangle(place).corners;
                corners.iter().filter(|corner| !volume.contains(corner, 0.0)).count() as u32
            }
            Contents::Node(_) => self.children(slot).map(|child| self.corners_outside(child, volume)).sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::oriented::Oriented;
    use super::*;
    use crate::conformance::meshes;

    #[test]
    fn every_triangle_is_a_leaf_and_every_corner_inside() {
        let mesh = meshes::stepped_tool(24, 10);
        let tree = WideTree::<Oriented>::build(&mesh);
        let report = tree.report();
        assert_eq!(report.leaves, mesh.faces().len());
        assert!(report.nodes > report.leaves && report.nodes < 2 * report.leaves, "{}", report.nodes);
        let depth = (mesh.faces().len() as f64).log(8.0);
        assert!(report.depth_mean >= depth && report.depth_mean < 2.0 * depth + 1.0, "{}", report.depth_mean);
        let drawn = tree.drawn(3);
        let of_level = |level: u32| drawn.iter().filter(move |node| node.level == level);
        assert_eq!(of_level(0).count(), 1);
        assert!((2..=8).contains(&of_level(1).count()) && of_level(2).count() > of_level(1).count());
        assert!(drawn.iter().all(|node| node.outside == 0 && node.outline.len() == 12), "{drawn:?}");
        // Boxes of children overlap little, and are smaller together than the box around them.
        assert!(of_level(2).map(|node| node.volume_mm3).sum::<f64>() < drawn[0].volume_mm3);
        // All levels: each triangle is drawn once as a leaf.
        assert_eq!(tree.drawn(99).iter().filter(|node| node.leaf).count(), mesh.faces().len());
    }
}
