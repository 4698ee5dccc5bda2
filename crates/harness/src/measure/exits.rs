//! How far the separating-axis test gets: which axis ends it, over all volume tests of a variant's queries.

use super::Progress;
use super::chunk::{Chunk, Participants};
use super::judged::JudgedPair;
use super::plan::{Case, Plan};
use crate::geometry::grid::Placement;
use crate::geometry::{Isometry, certified};
use crate::record::rows::CaseKey;
use crate::record::{ExitRow, Stratum};
use crate::scene::Scene;
use crate::tree::Tree;
use crate::volume::Shape;
use crate::volume::shape::obb::Obb;
use crate::volume::shape::obb::exit::{AXES, operations};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Counts by axis; the last are tests that no axis ends.
pub type Histogram = [u64; AXES + 1];

/// Trees by part.
type Boxes = BTreeMap<usize, Tree<Obb>>;

/// One row for each stratum and axis of every variant whose volumes are boxes, under its default policy.
pub fn count_scene(
    plan: &Plan,
    scene: &Scene,
    judged: &[JudgedPair],
    chunks: &[Chunk],
    progress: &dyn Progress,
) -> Vec<ExitRow> {
    let chunks: Vec<&Chunk> = chunks.iter().filter(|chunk| chunk.participants != Participants::Control).collect();
    let cases: Vec<&Case> = plan.cases.iter().filter(|case| case.policy == case.variant.policy).collect();
    progress.begin(&format!("{}: exit axes", scene.name), cases.len() as u64);
    let of_case = |case: &&Case| {
        let rows = boxes(case, scene, judged, &chunks).map(|trees| rows(case, scene, judged, &chunks, &trees));
        progress.advance(1);
        rows.unwrap_or_default()
    };
    cases.par_iter().map(of_case).collect::<Vec<_>>().into_iter().flatten().collect()
}

/// The case's trees over the parts that the chunks are about, when their volumes are boxes.
fn boxes(case: &Case, scene: &Scene, judged: &[JudgedPair], chunks: &[&Chunk]) -> Option<Boxes> {
    let mut trees = Boxes::new();
    for chunk in chunks {
        for part in [judged[chunk.pair].pair.a, judged[chunk.pair].pair.b] {
            if let Entry::Vacant(place) = trees.entry(part) {
                place.insert(case.variant.prepare(&scene.parts[part].mesh, case.policy).boxes()?);
            }
        }
    }
    Some(trees)
}

fn rows(case: &Case, scene: &Scene, judged: &[JudgedPair], chunks: &[&Chunk], trees: &Boxes) -> Vec<ExitRow> {
    exit_rows(&scene.name, &case.key(), |stratum, histogram| {
        for chunk in chunks.iter().filter(|chunk| chunk.stratum == stratum) {
            let pair = &judged[chunk.pair];
            let (a, b) = (&trees[&pair.pair.a], &trees[&pair.pair.b]);
            chunk.poses.iter().for_each(|&pose| query(a, b, &pair.poses[pose].a_from_b, histogram));
        }
    })
}

/// One row for each stratum and axis, in the order of the test; `count` adds the tests of a stratum.
pub fn exit_rows(scene: &str, case: &CaseKey, count: impl Fn(Stratum, &mut Histogram)) -> Vec<ExitRow> {
    let mut rows = Vec::new();
    for stratum in Stratum::ALL {
        let mut histogram: Histogram = [0; AXES + 1];
        count(stratum, &mut histogram);
        let CaseKey { variant, split, split_axes, leaf } = case;
        rows.extend(by_axis(&histogram).map(|(exit, axis, tests)| ExitRow {
            scene: scene.to_owned(),
            stratum,
            variant: variant.clone(),
            split: split.clone(),
            split_axes: split_axes.clone(),
            leaf: *leaf,
            axis,
            tests,
            operations: operations(exit),
        }));
    }
    rows
}

/// The counts in the order of the test as (exit, its number in records, tests); none when nothing was tested.
fn by_axis(histogram: &Histogram) -> impl Iterator<Item = (Option<usize>, u8, u64)> {
    let total: u64 = histogram.iter().sum();
    let named = |(axis, tests)| if axis < AXES { (Some(axis), axis as u8 + 1, tests) } else { (None, 0, tests) };
    histogram.iter().copied().enumerate().filter(move |_| total > 0).map(named)
}

/// A query of mode `first`, as [`crate::tree::traverse`] makes it, that notes every volume test's end.
pub fn query(a: &Tree<Obb>, b: &Tree<Obb>, a_from_b: &Isometry, histogram: &mut Histogram) {
    let (pose, placement) = (Obb::pose(a_from_b), Placement::new(a_from_b));
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
                if moved.any(|triangle| a.triangles_of(node_a).iter().any(|mine| certified::touch(mine, &triangle))) {
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
    use crate::registry;
    use obbtree::cases::meshes;

    #[test]
    fn every_volume_test_of_a_query_is_noted_once_whatever_the_boxes() {
        let torus = meshes::torus(12.0, 4.0, 14, 7);
        let mut kinds = 0;
        for variant in registry::standard().variants().iter().filter(|variant| variant.is_standard) {
            let model = variant.prepare(&torus, None);
            let Some(tree) = model.boxes() else { continue };
            kinds += 1;
            for step in 0..14 {
                let shift = nalgebra::Vector3::new(2.6 * f64::from(step), 1.0, 0.3);
                let pose = Isometry::new(shift, nalgebra::Vector3::x() * 0.3);
                let mut histogram = [0; AXES + 1];
                query(&tree, &tree, &pose, &mut histogram);
                let (_, counts) = model.first_counted(&*model, &pose);
                assert_eq!(histogram.iter().sum::<u64>(), counts.volume_tests, "{}", variant.info.id);
            }
        }
        assert!(kinds >= 3, "{kinds}");
    }
}
