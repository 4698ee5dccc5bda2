//! Drawings and measurements of a tree of [`obbtree`].

use crate::tree::levels::Drawn;
use crate::tree::tightness::{TreeReport, drift};
use crate::volume::shape::obb::Obb;
use crate::volume::shape::sphere::Sphere;
use crate::volume::{Segment, Solid};
use obbtree::engine::plain::Plain;
use obbtree::engine::{WideTree, WideVolume};

/// The data of a volume that drawings and tightness use.
struct Facts {
    outline: Vec<Segment>,
    volume_mm3: f64,
    area_mm2: f64,
}

impl Facts {
    fn of(plain: &Plain) -> Self {
        fn of(volume: &dyn Solid) -> Facts {
            Facts { outline: volume.outline(), volume_mm3: volume.volume(), area_mm2: volume.surface_area() }
        }
        match *plain {
            Plain::Box { axes, centre, half } => of(&Obb { axes, centre, half }),
            Plain::Ball { centre, radius } => of(&Sphere { centre, radius }),
        }
    }
}

/// Sums over everything below a slot.
#[derive(Clone, Copy, Default)]
struct Below {
    nodes: usize,
    leaves: usize,
    /// Sum of the depths of the leaves; each leaf is one triangle.
    depths: u64,
    depth_max: u32,
    /// Sum of the volumes' surface areas, mm².
    area_mm2: f64,
}

/// The volumes of the first `levels` levels; a node comes before its descendants.
pub fn drawn<V: WideVolume>(tree: &WideTree<V>, levels: u32) -> Vec<Drawn> {
    let (mut drawn, mut waiting) = (Vec::new(), vec![(WideTree::<V>::ROOT, 0)]);
    while let Some((slot, level)) = waiting.pop() {
        if level >= levels {
            continue;
        }
        let (volume, children) = (tree.plain(slot), tree.children(slot));
        let Facts { outline, volume_mm3, .. } = Facts::of(&volume);
        let outside = corners_outside(tree, slot, &volume);
        drawn.push(Drawn { level, leaf: children.is_empty(), outline, volume_mm3, outside });
        waiting.extend(children.rev().map(|child| (child, level + 1)));
    }
    drawn
}

/// Size and depth of the tree. Its volumes contain their contents, and it is not a binary tree.
pub fn report<V: WideVolume>(tree: &WideTree<V>) -> TreeReport {
    let (below, plain) = (below(tree, WideTree::<V>::ROOT, 0), tree.plain(WideTree::<V>::ROOT));
    let root = Facts::of(&plain);
    let triangles: Vec<_> = tree.leaves().collect();
    TreeReport {
        nodes: below.nodes,
        leaves: below.leaves,
        depth_max: below.depth_max,
        depth_mean: below.depths as f64 / below.leaves as f64,
        sah_cost: below.area_mm2 / root.area_mm2,
        drift_mm: drift(&plain.centre(), &triangles),
        root_outline: root.outline,
        ..TreeReport::not_binary()
    }
}

fn below<V: WideVolume>(tree: &WideTree<V>, slot: u32, depth: u32) -> Below {
    let (area_mm2, children) = (Facts::of(&tree.plain(slot)).area_mm2, tree.children(slot));
    if children.is_empty() {
        return Below { nodes: 1, leaves: 1, depths: u64::from(depth), depth_max: depth, area_mm2 };
    }
    let own = Below { nodes: 1, area_mm2, ..Below::default() };
    children.map(|child| below(tree, child, depth + 1)).fold(own, |sum, more| Below {
        nodes: sum.nodes + more.nodes,
        leaves: sum.leaves + more.leaves,
        depths: sum.depths + more.depths,
        depth_max: sum.depth_max.max(more.depth_max),
        area_mm2: sum.area_mm2 + more.area_mm2,
    })
}

fn corners_outside<V: WideVolume>(tree: &WideTree<V>, slot: u32, volume: &Plain) -> u32 {
    let own = tree.leaf(slot).flat_map(|triangle| triangle.corners).filter(|corner| !volume.contains(corner, 0.0));
    let below = tree.children(slot).map(|child| corners_outside(tree, child, volume));
    own.count() as u32 + below.sum::<u32>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use obbtree::cases::meshes;
    use obbtree::engine::oriented::Oriented;

    #[test]
    fn every_triangle_is_below_a_leaf_and_every_corner_inside() {
        let mesh = meshes::stepped_tool(24, 10);
        let tree = WideTree::<Oriented>::build(&mesh);
        let report = report(&tree);
        let faces = mesh.faces().len();
        assert!(tree.leaves().count() == faces && (faces / 2..faces).contains(&report.leaves), "{}", report.leaves);
        assert!(report.nodes > report.leaves && report.nodes < 2 * report.leaves, "{}", report.nodes);
        let depth = (report.leaves as f64).log(8.0);
        assert!(report.depth_mean >= depth && report.depth_mean < 2.0 * depth + 1.0, "{}", report.depth_mean);
        let shown = drawn(&tree, 3);
        let of_level = |level: u32| shown.iter().filter(move |node| node.level == level);
        assert_eq!(of_level(0).count(), 1);
        assert!((2..=8).contains(&of_level(1).count()) && of_level(2).count() > of_level(1).count());
        assert!(shown.iter().all(|node| node.outside == 0 && node.outline.len() == 12), "{shown:?}");
        // Boxes of children overlap little, and are smaller together than the box around them.
        assert!(of_level(2).map(|node| node.volume_mm3).sum::<f64>() < shown[0].volume_mm3);
        // All levels: each leaf is drawn once.
        assert_eq!(drawn(&tree, 99).iter().filter(|node| node.leaf).count(), report.leaves);
    }
}
