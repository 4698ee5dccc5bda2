//! The deterministic tier of the audit: operations, misses, and the trees themselves.

use super::Questions;
use super::cell::{BoxTree, Cell};
use super::memory::Memory;
use crate::geometry::Triangle;
use crate::record::{AuditRow, AuditTreeRow};
use crate::tree::tightness::hull_volume;
use crate::tree::traverse::{self, Counts, Scratch};
use std::collections::{BTreeMap, BTreeSet};

/// Builds a cell's trees over the scene's examined parts, asks them everything, and describes them.
pub fn count(cell: &Cell, questions: &Questions<'_>, memory: &Memory) -> (Vec<AuditRow>, Vec<AuditTreeRow>) {
    let trees = trees(cell, questions, Some(memory));
    let rows = questions.chunks.iter().map(|chunk| {
        let judged = &questions.judged[chunk.pair];
        let (a, b) = (&trees[&judged.pair.a], &trees[&judged.pair.b]);
        let (mut counts, mut scratch) = (Counts::default(), Scratch::default());
        let (mut touching, mut missed) = (0, 0);
        for pose in chunk.poses.iter().map(|&pose| &judged.poses[pose]) {
            let verdict = traverse::first(a, b, &pose.a_from_b, &mut scratch, &mut counts);
            touching += u64::from(pose.touches());
            missed += u64::from(pose.touches() && !verdict);
        }
        AuditRow {
            scene: questions.scene.name.clone(),
            workload: judged.workload.clone(),
            pair: questions.scene.pair_name(judged.pair),
            stratum: chunk.stratum,
            chunk: chunk.number,
            poses: chunk.poses.len() as u32,
            orientation: cell.orientation.to_owned(),
            centre: cell.centre.to_owned(),
            split: cell.split.to_string(),
            leaf: cell.leaf,
            volume_tests: counts.volume_tests,
            triangle_tests: counts.triangle_tests,
            touching,
            missed,
        }
    });
    let rows = rows.collect();
    (rows, trees.iter().map(|(&part, tree)| describe(cell, questions, part, tree)).collect())
}

/// The parts that the chosen chunks are about.
pub fn parts(questions: &Questions<'_>) -> BTreeSet<usize> {
    let pairs = questions.chunks.iter().map(|chunk| questions.judged[chunk.pair].pair);
    pairs.flat_map(|pair| [pair.a, pair.b]).collect()
}

/// A cell's tree over every part in question.
pub fn trees(cell: &Cell, questions: &Questions<'_>, memory: Option<&Memory>) -> BTreeMap<usize, BoxTree> {
    let tree = |part: usize| (part, cell.tree(&questions.scene.parts[part].mesh.triangles(), memory));
    parts(questions).into_iter().map(tree).collect()
}

fn describe(cell: &Cell, questions: &Questions<'_>, part: usize, tree: &BoxTree) -> AuditTreeRow {
    let (part, summary) = (&questions.scene.parts[part], tree.summary());
    // In the mesh's order of triangles, so that the sums are the same for every cell to the last bit.
    let triangles = part.mesh.triangles();
    AuditTreeRow {
        scene: questions.scene.name.clone(),
        part: part.name.clone(),
        orientation: cell.orientation.to_owned(),
        centre: cell.centre.to_owned(),
        split: cell.split.to_string(),
        leaf: cell.leaf,
        triangles: triangles.len() as u64,
        nodes: summary.nodes as u64,
        depth_max: summary.depth_max,
        depth_mean: summary.depth_mean,
        child_ratio: summary.child_ratio,
        root_volume_mm3: summary.root_volume_mm3,
        hull_mm3: hull_volume(&triangles),
        boxes_area_mm2: summary.area_mm2,
        part_area_mm2: triangles.iter().map(Triangle::area).sum(),
        outside_nodes: summary.outside_nodes,
        outside_corners_pct: 100.0 * summary.outside_corners as f64 / summary.corners as f64,
        overhang_mm: summary.overhang_mm,
    }
}
