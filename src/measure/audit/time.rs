//! The noisy tier of the audit: every cell beside the reference cell.
//!
//! Four hundred cells' trees do not fit into memory together, and a unit must be complete by itself. So each cell is timed
//! against one and the same reference, chunk by chunk, back to back and in random order, and only the ratio of the two
//! is used: what slows the machine down for a while slows both.

use super::Questions;
use super::cell::{BoxTree, Cell};
use super::count::{parts, trees};
use crate::geometry::Isometry;
use crate::measure::blocks::{self, Extent, Participation, Work};
use crate::measure::{Silent, timer};
use crate::record::{AuditBuildRow, AuditTimingRow};
use crate::tree::traverse::{self, NoProbe, Scratch};
use obbtree::cases::Draw;
use std::collections::BTreeMap;

/// The reference cell's trees, and the poses of each chunk.
pub struct Reference {
    trees: BTreeMap<usize, BoxTree>,
    poses: Vec<Vec<Isometry>>,
}

impl Reference {
    /// Prepares the reference for a scene.
    pub fn of(questions: &Questions<'_>) -> Self {
        let poses = |chunk: &crate::measure::chunk::Chunk| {
            chunk.poses.iter().map(|&pose| questions.judged[chunk.pair].poses[pose].a_from_b).collect()
        };
        Self { trees: trees(&Cell::reference(), questions, None), poses: questions.chunks.iter().map(poses).collect() }
    }
}

/// A cell, case 0, beside the reference, case 1.
struct Queries<'a> {
    questions: &'a Questions<'a>,
    reference: &'a Reference,
    own: BTreeMap<usize, BoxTree>,
    scratch: Scratch,
}

impl Work for Queries<'_> {
    fn cases(&self) -> usize {
        2
    }

    fn chunks(&self) -> Vec<usize> {
        self.reference.poses.iter().map(Vec::len).collect()
    }

    fn participation(&self, _: usize, _: usize) -> Participation {
        Participation::Always
    }

    fn run(&mut self, case: usize, chunk: usize, poses: usize, passes: u32) {
        let trees = if case == 0 { &self.own } else { &self.reference.trees };
        let pair = self.questions.judged[self.questions.chunks[chunk].pair].pair;
        let (a, b) = (&trees[&pair.a], &trees[&pair.b]);
        let mut touching = 0_u32;
        for _ in 0..passes {
            for pose in &self.reference.poses[chunk][..poses] {
                touching += u32::from(traverse::first(a, b, pose, &mut self.scratch, &mut NoProbe));
            }
        }
        std::hint::black_box(touching);
    }
}

/// Times a cell's construction and its queries beside the reference's.
pub fn time(
    cell: &Cell,
    reference: &Reference,
    questions: &Questions<'_>,
    blocks: u32,
    seed: u64,
) -> (Vec<AuditTimingRow>, Vec<AuditBuildRow>) {
    let mut draw = Draw::new(seed, &["audit", &questions.scene.name, &cell.name()], 0);
    let (own, builds) = build(cell, questions, &mut draw);
    let mut queries = Queries { questions, reference, own, scratch: Scratch::default() };
    let extent = Extent { blocks, warms_up: true, long_once: false };
    let order = (draw.unit() * 2_f64.powi(53)) as u64;
    let samples = blocks::time(&mut queries, extent, order, &Silent);
    // The two cases of a chunk stand side by side.
    let (pairs, _) = samples.as_chunks::<2>();
    let row = |[sample, of_reference]: &[blocks::Sample; 2]| AuditTimingRow {
        scene: questions.scene.name.clone(),
        chunk: questions.chunks[sample.chunk].number,
        orientation: cell.orientation.to_owned(),
        centre: cell.centre.to_owned(),
        split: cell.split.to_string(),
        leaf: cell.leaf,
        block: sample.block,
        passes: sample.passes,
        ns: sample.ns,
        reference_passes: of_reference.passes,
        reference_ns: of_reference.ns,
    };
    (pairs.iter().map(row).collect(), builds)
}

/// The cell's trees, with the time that each took beside the reference's.
fn build(cell: &Cell, questions: &Questions<'_>, draw: &mut Draw) -> (BTreeMap<usize, BoxTree>, Vec<AuditBuildRow>) {
    let (mut own, mut rows) = (BTreeMap::new(), Vec::new());
    for part in parts(questions) {
        let triangles = questions.scene.parts[part].mesh.triangles();
        let mut ns = [0; 2];
        for who in in_random_order(draw) {
            let builder = if who == 0 { *cell } else { Cell::reference() };
            let (taken, tree) = timer::time(|| builder.tree(&triangles, None));
            ns[who] = taken;
            if who == 0 {
                own.insert(part, tree);
            }
        }
        rows.push(AuditBuildRow {
            scene: questions.scene.name.clone(),
            part: questions.scene.parts[part].name.clone(),
            orientation: cell.orientation.to_owned(),
            centre: cell.centre.to_owned(),
            split: cell.split.to_string(),
            leaf: cell.leaf,
            ns: ns[0],
            reference_ns: ns[1],
        });
    }
    (own, rows)
}

/// The cell (0) and the reference (1), in either order.
fn in_random_order(draw: &mut Draw) -> [usize; 2] {
    if draw.unit() < 0.5 { [0, 1] } else { [1, 0] }
}
