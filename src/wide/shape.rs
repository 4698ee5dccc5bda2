//! A wide tree for the eye, and facts about it.

use super::node::{Contents, WideTree};
use super::turn;
use crate::geometry::Vector;
use crate::tree::levels::Drawn;
use crate::tree::tightness::{TreeReport, drift};
use crate::volume::{box_area, box_outline};
use nalgebra::Matrix3;

/// A box of the tree as numbers in f64: axes as columns, centre and half-lengths, mm, mesh frame.
pub(super) struct Decoded {
    axes: Matrix3<f64>,
    centre: Vector,
    half: Vector,
}

/// What lies below a slot.
#[derive(Clone, Copy, Default)]
struct Below {
    nodes: usize,
    leaves: usize,
    /// Sum of the depths of the leaves, each a triangle.
    depths: u64,
    depth_max: u32,
    /// Sum of the boxes' surface areas, mm².
    area_mm2: f64,
}

impl Decoded {
    /// How far a place is outside, mm, along the axis on which it is farthest; negative inside.
    pub(super) fn outside_mm(&self, place: &Vector) -> f64 {
        (self.axes.tr_mul(&(place - self.centre)).abs() - self.half).max()
    }
}

impl WideTree {
    /// The box of a slot.
    pub(super) fn decoded(&self, slot: u32) -> Decoded {
        let (node, place) = self.slot(slot);
        let code = node.code(place);
        let vector = |v: [f32; 3]| Vector::from(v.map(f64::from));
        Decoded {
            axes: turn::decode(code.turn),
            centre: vector(node.origin) + vector(code.centre),
            half: vector(code.half),
        }
    }

    /// The boxes of the first `levels` levels, a node before what is below it.
    #[must_use]
    pub fn drawn(&self, levels: u32) -> Vec<Drawn> {
        let (mut drawn, mut waiting) = (Vec::new(), vec![(0, 0)]);
        while let Some((slot, level)) = waiting.pop() {
            if level >= levels {
                continue;
            }
            let volume = self.decoded(slot);
            let children: Vec<u32> = self.children(slot).collect();
            drawn.push(Drawn {
                level,
                leaf: children.is_empty(),
                outline: box_outline(&volume.centre.into(), &volume.axes, &volume.half),
                volume_mm3: 8.0 * volume.half.product(),
                outside: self.corners_outside(slot, &volume),
            });
            waiting.extend(children.into_iter().rev().map(|child| (child, level + 1)));
        }
        drawn
    }

    /// Size and depth of the tree; its boxes hold their contents, and it has no levels of two.
    #[must_use]
    pub fn report(&self) -> TreeReport {
        let (below, root) = (self.below(0, 0), self.decoded(0));
        let triangles: Vec<_> = (0..self.len() as u32).map(|place| self.triangle(place)).collect();
        TreeReport {
            nodes: below.nodes,
            leaves: below.leaves,
            depth_max: below.depth_max,
            depth_mean: below.depths as f64 / below.leaves as f64,
            sah_cost: below.area_mm2 / box_area(&root.half),
            drift_mm: drift(&root.centre.into(), &triangles),
            root_outline: box_outline(&root.centre.into(), &root.axes, &root.half),
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
        let area_mm2 = box_area(&self.decoded(slot).half);
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

    fn corners_outside(&self, slot: u32, volume: &Decoded) -> u32 {
        match self.contents(slot) {
            Contents::Triangle(place) => {
                let corners = self.triangle(place).corners;
                corners.iter().filter(|corner| volume.outside_mm(&corner.coords) > 0.0).count() as u32
            }
            Contents::Node(_) => self.children(slot).map(|child| self.corners_outside(child, volume)).sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance::meshes;

    #[test]
    fn every_triangle_is_a_leaf_and_every_corner_inside() {
        let mesh = meshes::stepped_tool(24, 10);
        let tree = WideTree::build(&mesh);
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
