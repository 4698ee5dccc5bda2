//! Verification: every variant's verdict against the exact truth, over many poses, counted by depth band.

use super::Progress;
use super::judged::{JudgedPair, JudgedPose};
use super::plan::{Case, Plan};
use crate::geometry::Isometry;
use crate::method::{Kind, Model};
use crate::record::{Band, VerificationRow};
use crate::scene::Scene;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Poses that one thread takes at a time.
const BATCH: usize = 256;

/// Poses per pair and workload on which a peer is verified, evenly spread: its queries can be a hundred times slower.
const PEER_POSES: usize = 1000;

/// Verdicts of every case over all judged poses. The control is not run: its verdict is the `brute` column of the others.
pub fn verify_scene(
    plan: &Plan,
    scene: &Scene,
    judged: &[JudgedPair],
    progress: &dyn Progress,
) -> Vec<VerificationRow> {
    let cases: Vec<&Case> = plan.cases.iter().filter(|case| case.variant.kind != Kind::Control).collect();
    let poses: usize = judged.iter().map(|pair| pair.poses.len()).sum();
    progress.begin(&format!("{}: verdicts", scene.name), (poses * cases.len()) as u64);
    cases.into_iter().flat_map(|case| verify_case(case, scene, judged, progress)).collect()
}

fn verify_case(case: &Case, scene: &Scene, judged: &[JudgedPair], progress: &dyn Progress) -> Vec<VerificationRow> {
    let mut models: BTreeMap<usize, Box<dyn Model>> = BTreeMap::new();
    for part in judged.iter().flat_map(|pair| [pair.pair.a, pair.pair.b]) {
        models.entry(part).or_insert_with(|| case.variant.prepare(&scene.parts[part].mesh, case.policy));
    }
    let limit = if case.variant.kind == Kind::Peer { PEER_POSES } else { usize::MAX };
    let mut rows = Vec::new();
    for pair in judged {
        let (a, b) = (models[&pair.pair.a].as_ref(), models[&pair.pair.b].as_ref());
        let stride = pair.poses.len().div_ceil(limit).max(1);
        let poses: Vec<&JudgedPose> = pair.poses.iter().step_by(stride).collect();
        let verdicts: Vec<bool> = poses
            .par_chunks(BATCH)
            .flat_map_iter(|batch| {
                let posed: Vec<Isometry> = batch.iter().map(|pose| pose.a_from_b).collect();
                let mut verdicts = Vec::with_capacity(batch.len());
                a.first(b, &posed, &mut verdicts);
                progress.advance((batch.len() * stride) as u64);
                verdicts
            })
            .collect();
        rows.extend(tally(case, scene, pair, &poses, &verdicts));
    }
    rows
}

/// One row per band that has poses.
fn tally(
    case: &Case,
    scene: &Scene,
    pair: &JudgedPair,
    poses: &[&JudgedPose],
    verdicts: &[bool],
) -> Vec<VerificationRow> {
    let (split, axes, leaf) = case.policy_columns();
    let row = |band| {
        let members: Vec<(&JudgedPose, bool)> =
            poses.iter().copied().zip(verdicts.iter().copied()).filter(|(pose, _)| pose.band == band).collect();
        let count = |condition: fn(&JudgedPose, bool) -> bool| {
            members.iter().filter(|(pose, verdict)| condition(pose, *verdict)).count() as u64
        };
        VerificationRow {
            scene: scene.name.clone(),
            workload: pair.workload.clone(),
            pair: scene.pair_name(pair.pair),
            variant: case.id.clone(),
            split: split.clone(),
            axes: axes.clone(),
            leaf,
            safe: u8::from(case.variant.info.safe),
            band,
            poses: members.len() as u64,
            exact: count(|pose, _| pose.exact),
            brute: count(|pose, _| pose.brute),
            tree: count(|_, verdict| verdict),
            missed_by_volume: count(|pose, verdict| pose.brute && !verdict),
            missed_by_leaf: count(|pose, _| pose.exact && !pose.brute),
            missed: count(|pose, verdict| pose.exact && !verdict),
            false_positives: count(|pose, verdict| !pose.exact && verdict),
        }
    };
    Band::ALL.into_iter().map(row).filter(|row| row.poses > 0).collect()
}

/// The rows that break a promise: a safe variant that misses a contact above grazing.
pub fn broken_promises(rows: &[VerificationRow]) -> impl Iterator<Item = &VerificationRow> {
    rows.iter().filter(|row| row.safe == 1 && row.band.is_above_grazing() && row.missed > 0)
}
