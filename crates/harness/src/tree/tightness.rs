//! Quality of a tree before any query: size, balance, and how tightly each level encloses its contents.

use super::Tree;
use super::nodes::{self, AnyNode};
use super::spread::{self, Contents};
use super::summary::TreeSummary;
use crate::geometry::{Point, Triangle, covariance, triangle};
use crate::volume::{Segment, Shape, Solid};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Deepest level whose tightness is measured. Below it, nodes hold a few triangles and the tightness no longer changes.
pub const DEEPEST_LEVEL: u32 = 10;

/// Deepest level on which the extent of volumes beyond their contents and into their siblings is measured.
pub const DEEPEST_SPREAD_LEVEL: u32 = 4;

/// Facts about one tree.
#[derive(Clone, Debug)]
pub struct TreeReport {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of leaves.
    pub leaves: usize,
    /// Depth of the deepest leaf; the root has depth 0.
    pub depth_max: u32,
    /// Mean depth of a leaf, weighted by its triangles.
    pub depth_mean: f64,
    /// Mean of smaller / larger child count over inner nodes, weighted by each node's count. 1 is balanced; NaN for a structure whose nodes
    /// do not have two children.
    pub child_ratio: f64,
    /// Sum over nodes of surface area / root surface area.
    pub sah_cost: f64,
    /// Distance of the root volume's centre from the middle of the contents, mm, along the direction from the area centroid to the mean of
    /// the corners; 0 when the two coincide.
    pub drift_mm: f64,
    /// Sums over all volumes, for binary trees with volumes fitted to their contents.
    pub summary: Option<TreeSummary>,
    /// Levels 0 to [`DEEPEST_LEVEL`], as far as the tree has nodes.
    pub levels: Vec<LevelReport>,
    /// The root volume, for drawing; mm, mesh frame.
    pub root_outline: Vec<Segment>,
}

impl TreeReport {
    /// The report of a structure with inner nodes that do not have two children, or with nodes that are not fitted to their contents: no
    /// balance, no levels, no outline.
    pub const fn not_binary() -> Self {
        Self {
            nodes: 0,
            leaves: 0,
            depth_max: 0,
            depth_mean: 0.0,
            child_ratio: f64::NAN,
            sah_cost: f64::NAN,
            drift_mm: f64::NAN,
            summary: None,
            levels: Vec::new(),
            root_outline: Vec::new(),
        }
    }
}

/// Sums over the nodes of one level.
#[derive(Clone, Copy, Debug, Default)]
pub struct LevelReport {
    /// Level; the root is 0.
    pub level: u32,
    /// Number of nodes on the level.
    pub nodes: u64,
    /// Number of triangles in these nodes.
    pub triangles: u64,
    /// Sum of volumes, mm³.
    pub volume_mm3: f64,
    /// Sum of surface areas, mm².
    pub area_mm2: f64,
    /// Sum of the volumes of the convex hulls of the contents, mm³, over the nodes whose hull has a volume.
    pub hull_mm3: f64,
    /// Sum of the volumes of the nodes that `hull_mm3` includes, mm³.
    pub hulled_volume_mm3: f64,
    /// Corners outside their node's volume, percent.
    pub outside_corners_pct: f64,
    /// Area of triangles with a corner outside, percent.
    pub outside_area_pct: f64,
    /// Largest distance of a corner from its node's volume, mm.
    pub overhang_mm: f64,
    /// Largest directed Hausdorff distance from a volume to the convex hull of its contents, mm, over the nodes whose hull has a volume.
    /// Measured down to [`DEEPEST_SPREAD_LEVEL`].
    pub hausdorff_mm: Option<f64>,
    /// Volume of the intersection of two siblings, mm³, summed over the level's pairs of siblings and estimated by sampling. Measured down
    /// to [`DEEPEST_SPREAD_LEVEL`]; `None` at the root, which has no sibling.
    pub sibling_overlap_mm3: Option<f64>,
}

/// The contribution of one node to its level.
#[derive(Clone, Copy, Default)]
struct NodeFacts {
    report: LevelReport,
    corners_outside: u64,
    area_outside: f64,
    area: f64,
}

impl<S: Shape> Tree<S> {
    /// Measures the tree.
    pub fn report(&self) -> TreeReport {
        TreeReport::of(&self.any_nodes())
    }
}

impl TreeReport {
    fn of(nodes: &[AnyNode]) -> Self {
        Self { levels: levels(nodes), root_outline: nodes[0].volume.outline(), ..Self::brief(nodes) }
    }

    /// The report without levels and outline.
    pub(super) fn brief(nodes: &[AnyNode]) -> Self {
        let root = &nodes[0];
        let summary = TreeSummary::of(nodes);
        Self {
            nodes: nodes.len(),
            leaves: nodes.iter().filter(|node| node.children.is_none()).count(),
            depth_max: nodes.iter().map(|node| node.depth).max().unwrap_or(0),
            depth_mean: nodes::mean_leaf_depth(nodes),
            child_ratio: nodes::child_ratio(nodes),
            sah_cost: summary.area_mm2 / root.volume.surface_area(),
            drift_mm: drift(&root.volume.centre(), root.triangles),
            summary: Some(summary),
            levels: Vec::new(),
            root_outline: Vec::new(),
        }
    }
}

fn levels(nodes: &[AnyNode]) -> Vec<LevelReport> {
    let deepest = nodes.iter().map(|node| node.depth).max().unwrap_or(0).min(DEEPEST_LEVEL);
    let members = |level: u32| (0..nodes.len()).filter(|&node| nodes[node].depth == level).collect();
    let levels: Vec<Vec<usize>> = (0..=deepest).map(members).collect();
    let hulls = hulls(&levels, nodes);
    let level = |(level, members): (u32, &Vec<usize>)| {
        let facts: Vec<NodeFacts> = members.par_iter().map(|&node| facts(nodes, node, &hulls[&node])).collect();
        sum(level, &facts)
    };
    (0..).zip(&levels).map(level).collect()
}

fn facts(nodes: &[AnyNode], index: usize, contents: &Contents) -> NodeFacts {
    let AnyNode { volume: own, triangles, depth, .. } = nodes[index];
    let volume = own.volume();
    let hull = contents.solid.as_ref();
    let is_measured = depth <= DEEPEST_SPREAD_LEVEL;
    let hausdorff = |(faces, _): &(Vec<Triangle>, f64)| spread::hausdorff_mm(own, faces);
    // Siblings stand side by side after the root, a left one at an odd place: its overlap counts once.
    let overlap = || match index {
        0 => None,
        left if left % 2 == 1 => Some(spread::overlap_mm3(own, nodes[left + 1].volume)),
        _ => Some(0.0),
    };
    let outside = |t: &Triangle| t.corners.iter().filter(|corner| !own.contains(corner, 0.0)).count() as u64;
    let corners_outside = triangles.iter().map(outside).sum();
    let overhang = |corner: &Point| if own.contains(corner, 0.0) { 0.0 } else { distance_outside(own, corner) };
    let overhang_mm =
        if corners_outside == 0 { 0.0 } else { triangle::corners(triangles).map(overhang).fold(0.0, f64::max) };
    let report = LevelReport {
        nodes: 1,
        triangles: triangles.len() as u64,
        volume_mm3: volume,
        area_mm2: own.surface_area(),
        hull_mm3: hull.map_or(0.0, |(_, volume)| *volume),
        hulled_volume_mm3: if hull.is_some() { volume } else { 0.0 },
        overhang_mm,
        hausdorff_mm: hull.filter(|_| is_measured).map(hausdorff),
        sibling_overlap_mm3: if is_measured { overlap() } else { None },
        ..LevelReport::default()
    };
    let area_outside = triangles.iter().filter(|t| outside(t) > 0).map(Triangle::area).sum();
    NodeFacts { report, corners_outside, area_outside, area: triangles.iter().map(Triangle::area).sum() }
}

/// The convex hulls of the contents of all nodes of `levels`, the root's first. They are computed bottom-up: a parent's hull needs only the
/// few corners of its children's hulls.
fn hulls(levels: &[Vec<usize>], nodes: &[AnyNode]) -> BTreeMap<usize, Contents> {
    let mut hulls: BTreeMap<usize, Contents> = BTreeMap::new();
    for level in levels.iter().rev() {
        let below = |child: u32| hulls.get(&(child as usize));
        let hull = |&node: &usize| match nodes[node].children.map(|(left, right)| (below(left), below(right))) {
            Some((Some(left), Some(right))) => Contents::of(left.corners.iter().chain(&right.corners)),
            _ => Contents::of(triangle::corners(nodes[node].triangles)),
        };
        let of_level: Vec<(usize, Contents)> = level.par_iter().map(|node| (*node, hull(node))).collect();
        hulls.extend(of_level);
    }
    hulls
}

fn sum(level: u32, facts: &[NodeFacts]) -> LevelReport {
    let mut total = LevelReport { level, ..LevelReport::default() };
    let (mut corners_outside, mut area_outside, mut area) = (0, 0.0, 0.0);
    for fact in facts {
        let one = &fact.report;
        total.nodes += one.nodes;
        total.triangles += one.triangles;
        total.volume_mm3 += one.volume_mm3;
        total.area_mm2 += one.area_mm2;
        total.hull_mm3 += one.hull_mm3;
        total.hulled_volume_mm3 += one.hulled_volume_mm3;
        total.overhang_mm = total.overhang_mm.max(one.overhang_mm);
        total.hausdorff_mm = one.hausdorff_mm.into_iter().chain(total.hausdorff_mm).reduce(f64::max);
        total.sibling_overlap_mm3 =
            one.sibling_overlap_mm3.into_iter().chain(total.sibling_overlap_mm3).reduce(|x, y| x + y);
        corners_outside += fact.corners_outside;
        area_outside += fact.area_outside;
        area += fact.area;
    }
    total.outside_corners_pct = 100.0 * corners_outside as f64 / (3 * total.triangles) as f64;
    total.outside_area_pct = if area > 0.0 { 100.0 * area_outside / area } else { 0.0 };
    total
}

/// Volume of the convex hull of triangles in mm, mm³; `None` for contents that are flat, or nearly so, or that have fewer points than a
/// tetrahedron.
pub fn hull_volume(triangles: &[Triangle]) -> Option<f64> {
    Contents::of(triangle::corners(triangles)).solid.map(|(_, volume)| volume)
}

/// The smallest slack at which a volume contains a point, mm, found by bisection to a relative error of 1e-9.
pub(super) fn distance_outside(volume: &dyn Solid, point: &Point) -> f64 {
    let mut high = (point - volume.centre()).norm();
    let mut low = 0.0;
    while high - low > 1e-9 * high {
        let middle = f64::midpoint(low, high);
        if volume.contains(point, middle) { high = middle } else { low = middle }
    }
    high
}

/// See [`TreeReport::drift_mm`].
pub(crate) fn drift(centre: &Point, triangles: &[Triangle]) -> f64 {
    let toward_fine = covariance::vertex_weighted(triangles).0 - covariance::area_weighted(triangles).0;
    let Some(direction) = toward_fine.try_normalize(1e-9) else { return 0.0 };
    let along = |p: &Point| p.coords.dot(&direction);
    let (low, high) = triangle::corners(triangles)
        .map(along)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    along(centre) - f64::midpoint(low, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::{Policy, SplitRule};
    use crate::volume::BoundingVolume;
    use crate::volume::aabb::Aabb;
    use crate::volume::obb_vertex::ObbVertex;
    use crate::volume::obb_vertex_centroid::ObbVertexCentroid;
    use crate::volume::sphere_ritter::SphereRitter;
    use obbtree::cases::meshes;

    fn near(left: f64, right: f64) -> bool {
        (left - right).abs() < 1e-5
    }

    #[test]
    fn a_cuboid_in_its_own_box() {
        let triangles = meshes::cuboid(2.0, 4.0, 6.0).triangles();
        let report = Tree::build(&Aabb::fit, &triangles, Policy::own(SplitRule::Median)).report();
        assert_eq!((report.nodes, report.leaves), (23, 12));
        // Twelve halve to 6, 3, then 1 and 2, then 1: in every three leaves one at depth 3 and two at depth 4.
        assert_eq!(report.depth_max, 4);
        assert!(near(report.depth_mean, 11.0 / 3.0));
        // 12 -> 6:6, two of 6 -> 3:3, four of 3 -> 1:2, four of 2 -> 1:1: (12 + 12 + 12/2 + 8) / (12 + 12 + 12 + 8).
        assert!(near(report.child_ratio, 38.0 / 44.0));
        assert_eq!(report.root_outline.len(), 12);
        assert!(near(report.drift_mm, 0.0));
        let root = report.levels[0];
        assert!(near(root.volume_mm3, 48.0) && near(root.hull_mm3, 48.0) && near(root.hulled_volume_mm3, 48.0));
        assert!(near(root.area_mm2, 88.0)); // 2 (8 + 12 + 24)
        assert_eq!((root.outside_corners_pct, root.outside_area_pct, root.overhang_mm), (0.0, 0.0, 0.0));
        assert!(root.hausdorff_mm.unwrap() < 1e-5 && root.sibling_overlap_mm3.is_none());
        // Halves of six triangles of the twelve; the boxes of both hold faces that they share.
        assert!(report.levels[1].sibling_overlap_mm3.is_some());
        assert_eq!(report.levels.iter().map(|level| level.nodes).collect::<Vec<_>>(), [1, 2, 4, 8, 8]);
        assert!(report.levels[..4].iter().all(|level| level.triangles == 12));
        // Single triangles are flat: no hull, and their boxes' volumes do not count beside it.
        assert_eq!((report.levels[4].hull_mm3, report.levels[4].hulled_volume_mm3), (0.0, 0.0));
    }

    /// Hulls computed bottom-up equal those computed from the node's own triangles.
    #[test]
    fn hulls_from_below_are_the_hulls_of_the_contents() {
        let triangles = meshes::torus(12.0, 4.0, 24, 12).triangles();
        let tree = Tree::build(&Aabb::fit, &triangles, Policy::own(SplitRule::Median));
        let nodes = tree.any_nodes();
        for level in tree.report().levels {
            let of_level = nodes.iter().filter(|node| node.depth == level.level);
            let direct: f64 = of_level.filter_map(|node| hull_volume(node.triangles)).sum();
            assert!((level.hull_mm3 - direct).abs() <= 1e-9 * direct, "{}: {} {direct}", level.level, level.hull_mm3);
        }
    }

    #[test]
    fn a_torus_fills_less_than_its_hull_and_the_hull_less_than_the_box() {
        let torus = meshes::torus(12.0, 4.0, 24, 12);
        let report = Tree::build(&Aabb::fit, &torus.triangles(), Policy::own(SplitRule::VertexMean)).report();
        let root = report.levels[0];
        assert!(torus.signed_volume() < root.hull_mm3 && root.hull_mm3 < root.hulled_volume_mm3);
        assert!(root.hulled_volume_mm3 <= 32.0 * 32.0 * 8.0 + 1e-3);
    }

    #[test]
    fn the_literal_box_of_a_tool_drifts_to_the_fine_tip_and_leaves_the_holder_out() {
        let triangles = meshes::stepped_tool(12, 40).triangles();
        let policy = Policy::own(SplitRule::VertexMean);
        let literal = Tree::build(&ObbVertexCentroid::fit, &triangles, policy).report();
        let tight = Tree::build(&ObbVertex::fit, &triangles, policy).report();
        // The corners' mean lies near the middle of the cutter (z about 15), the middle of the tool at 40; the extent is 80.
        assert!(literal.drift_mm > 15.0 && literal.drift_mm < 40.0, "{}", literal.drift_mm);
        assert!(tight.drift_mm.abs() < 1.0, "{}", tight.drift_mm);
        let root = literal.levels[0];
        assert!((root.overhang_mm - literal.drift_mm).abs() < 2.0, "{} {}", root.overhang_mm, literal.drift_mm);
        assert!(root.outside_corners_pct > 0.0 && root.outside_corners_pct < root.outside_area_pct);
        assert!(tight.levels.iter().all(|level| level.outside_corners_pct == 0.0 && level.overhang_mm == 0.0));
    }

    /// Each pair of siblings counts once.
    #[test]
    fn the_overlap_of_siblings_is_that_of_each_pair() {
        let tree = Tree::build(&SphereRitter::fit, &meshes::soup(60).triangles(), Policy::own(SplitRule::Median));
        let nodes = tree.any_nodes();
        let report = tree.report();
        for level in 1..=3 {
            let parents = nodes.iter().filter(|node| node.depth + 1 == level);
            let overlap_of = |(left, right): (u32, u32)| {
                spread::overlap_mm3(nodes[left as usize].volume, nodes[right as usize].volume)
            };
            let overlap: f64 = parents.filter_map(|node| node.children).map(overlap_of).sum();
            let reported = report.levels[level as usize].sibling_overlap_mm3.unwrap();
            assert!(overlap > 0.0 && (reported - overlap).abs() <= 1e-9 * overlap, "{level}: {reported} {overlap}");
        }
    }

    #[test]
    fn a_report_is_the_same_every_time() {
        let tree = Tree::build(&ObbVertex::fit, &meshes::soup(60).triangles(), Policy::own(SplitRule::Sah16));
        assert_eq!(format!("{:?}", tree.report()), format!("{:?}", tree.report()));
    }

    #[test]
    fn degenerate_contents_have_no_hull() {
        for triangles in
            [meshes::degenerate().triangles()[..3].to_vec(), vec![meshes::cuboid(1.0, 1.0, 1.0).triangles()[0]; 5]]
        {
            let report = Tree::build(&Aabb::fit, &triangles, Policy::own(SplitRule::Median)).report();
            assert_eq!(report.levels[0].hull_mm3, 0.0);
        }
    }
}
