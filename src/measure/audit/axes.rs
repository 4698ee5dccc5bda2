//! How far the separating-axis test gets: which axis ends it, over all volume tests of the reference cell.

use super::Questions;
use super::cell::{BoxTree, Cell};
use super::count::trees;
use crate::geometry::grid::Placement;
use crate::geometry::{Isometry, intersect};
use crate::record::{AuditAxisRow, Stratum};
use crate::volume::BoundingVolume;
use crate::volume::obb::exit::AXES;
use crate::volume::obb::{Fitted, Obb};

/// Counts by axis; the last are tests that no axis ends.
type Histogram = [u64; AXES + 1];

/// One row for each stratum and axis, in the order of the test.
pub fn axes(questions: &Questions<'_>) -> Vec<AuditAxisRow> {
    let trees = trees(&Cell::reference(), questions);
    let mut rows = Vec::new();
    for stratum in Stratum::ALL {
        let mut histogram: Histogram = [0; AXES + 1];
        for chunk in questions.chunks.iter().filter(|chunk| chunk.stratum == stratum) {
            let judged = &questions.judged[chunk.pair];
            let (a, b) = (&trees[&judged.pair.a], &trees[&judged.pair.b]);
            chunk.poses.iter().for_each(|&pose| query(a, b, &judged.poses[pose].a_from_b, &mut histogram));
        }
        let total: u64 = histogram.iter().sum();
        rows.extend((1..).zip(histogram).filter(|_| total > 0).map(|(axis, tests)| AuditAxisRow {
            scene: questions.scene.name.clone(),
            stratum,
            axis: if axis > AXES as u8 { 0 } else { axis },
            tests,
        }));
    }
    rows
}

/// A query of mode `first`, as [`crate::tree::traverse`] makes it, that notes every volume test's end.
fn query(a: &BoxTree, b: &BoxTree, a_from_b: &Isometry, histogram: &mut Histogram) {
    let (pose, placement) = (Obb::<Fitted>::pose(a_from_b), Placement::new(a_from_b));
    let mut overlaps = |i: u32, j: u32| {
        let axis = a.nodes()[i as usize].volume.exit_axis(&b.nodes()[j as usize].volume, &pose);
        histogram[axis.unwrap_or(AXES)] += 1;
        axis.is_none()
    };
    let mut stack = Vec::new();
    if overlaps(0, 0) {
        stack.push((0, 0));
    }
    while let Some((i, j)) = stack.pop() {
        let (node_a, node_b) = (&a.nodes()[i as usize], &b.nodes()[j as usize]);
        let first_is_larger = node_a.size >= node_b.size;
        let next = match (node_a.children(), node_b.children()) {
            (Some((l, r)), None) => [(l, j), (r, j)],
            (Some((l, r)), Some(_)) if first_is_larger => [(l, j), (r, j)],
            (_, Some((l, r))) => [(i, l), (i, r)],
            (None, None) => {
                let mut moved = b.triangles_of(node_b).iter().map(|triangle| placement.triangle(triangle));
                if moved.any(|triangle| a.triangles_of(node_a).iter().any(|mine| intersect::touch(mine, &triangle))) {
                    return;
                }
                continue;
            }
        };
        for (i, j) in next {
            if overlaps(i, j) {
                stack.push((i, j));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance::meshes;
    use crate::tree::traverse::{Counts, Scratch, first};

    #[test]
    fn every_volume_test_of_a_query_is_noted_once() {
        let tree = Cell::reference().tree(&meshes::torus(12.0, 4.0, 14, 7).triangles());
        for step in 0..14 {
            let pose =
                Isometry::new(nalgebra::Vector3::new(2.6 * f64::from(step), 1.0, 0.3), nalgebra::Vector3::x() * 0.3);
            let (mut histogram, mut counts) = ([0; AXES + 1], Counts::default());
            query(&tree, &tree, &pose, &mut histogram);
            first(&tree, &tree, &pose, &mut Scratch::default(), &mut counts);
            assert_eq!(histogram.iter().sum::<u64>(), counts.volume_tests);
        }
    }
}
