//! Verdict and operation counts of every case at every measured pose: the deterministic tier beside the timings.

use super::Progress;
use super::chunk::{Chunk, Participants};
use super::judged::JudgedPair;
use super::plan::{Case, Plan};
use crate::method::{Kind, Model};
use crate::record::QueryRow;
use crate::scene::Scene;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// One row per case and measured pose. The control answers only at the control's poses.
pub fn count_scene(
    plan: &Plan,
    scene: &Scene,
    judged: &[JudgedPair],
    chunks: &[Chunk],
    progress: &dyn Progress,
) -> Vec<QueryRow> {
    let everyone = poses_of(chunks, |who| who != Participants::Control);
    let peers = poses_of(chunks, |who| who == Participants::Everyone);
    let control = poses_of(chunks, |who| who == Participants::Control);
    progress.begin(&format!("{}: operation counts", scene.name), (everyone.len() * plan.cases.len()) as u64);
    let of_case = |case: &Case| {
        let poses = match case.variant.kind {
            Kind::Volume | Kind::Engine | Kind::Sampling => &everyone,
            Kind::Peer => &peers,
            Kind::Control => &control,
        };
        count_case(case, scene, judged, poses, progress)
    };
    let rows: Vec<_> = plan.cases.par_iter().map(of_case).collect();
    rows.concat()
}

/// The chunks' poses as (judged pair, pose), each once, in order.
fn poses_of(chunks: &[Chunk], wanted: impl Fn(Participants) -> bool) -> Vec<(usize, usize)> {
    let chosen = chunks.iter().filter(|chunk| wanted(chunk.participants));
    let poses: BTreeSet<_> = chosen.flat_map(|chunk| chunk.poses.iter().map(|&pose| (chunk.pair, pose))).collect();
    poses.into_iter().collect()
}

fn count_case(
    case: &Case,
    scene: &Scene,
    judged: &[JudgedPair],
    poses: &[(usize, usize)],
    progress: &dyn Progress,
) -> Vec<QueryRow> {
    let mut models: BTreeMap<usize, Box<dyn Model>> = BTreeMap::new();
    for &(pair, _) in poses {
        for part in [judged[pair].pair.a, judged[pair].pair.b] {
            models.entry(part).or_insert_with(|| case.variant.prepare(&scene.parts[part].mesh, case.policy));
        }
    }
    let (split, axes, leaf) = case.policy_columns();
    let row = |&(pair, index): &(usize, usize)| {
        let (pair, pose) = (&judged[pair], &judged[pair].poses[index]);
        let (a, b) = (models[&pair.pair.a].as_ref(), models[&pair.pair.b].as_ref());
        let (verdict, counts) = a.first_counted(b, &pose.a_from_b);
        progress.advance(1);
        QueryRow {
            scene: scene.name.clone(),
            workload: pair.workload.clone(),
            pose: index as u32,
            pair: scene.pair_name(pair.pair),
            variant: case.id.clone(),
            split: split.clone(),
            axes: axes.clone(),
            leaf,
            exact: u8::from(pose.touches()),
            brute: u8::from(pose.touches()),
            tree: u8::from(verdict),
            volume_tests: counts.volume_tests,
            triangle_tests: counts.triangle_tests,
            band: pose.band,
            stratum: pose.stratum,
            contained: u8::from(pose.contained),
        }
    };
    poses.par_iter().map(row).collect()
}
