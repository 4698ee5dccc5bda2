//! How far the separating-axis test gets: which axis ends it, over all volume tests of the reference cell.

use super::Questions;
use super::cell::Cell;
use super::count::trees;
use crate::measure::exits::{Histogram, by_axis, query};
use crate::record::{AuditAxisRow, Stratum};

/// One row for each stratum and axis, in the order of the test.
pub fn axes(questions: &Questions<'_>) -> Vec<AuditAxisRow> {
    let trees = trees(&Cell::reference(), questions, None);
    let mut rows = Vec::new();
    for stratum in Stratum::ALL {
        let mut histogram = Histogram::default();
        for chunk in questions.chunks.iter().filter(|chunk| chunk.stratum == stratum) {
            let judged = &questions.judged[chunk.pair];
            let (a, b) = (&trees[&judged.pair.a], &trees[&judged.pair.b]);
            chunk.poses.iter().for_each(|&pose| query(a, b, &judged.poses[pose].a_from_b, &mut histogram));
        }
        let scene = &questions.scene.name;
        rows.extend(by_axis(&histogram).map(|(_, axis, tests)| AuditAxisRow {
            scene: scene.clone(),
            stratum,
            axis,
            tests,
        }));
    }
    rows
}
