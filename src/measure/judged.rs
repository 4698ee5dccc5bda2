//! Poses with their truth: what every variant's verdict is held against.

use super::Progress;
use super::plan::Plan;
use crate::geometry::Isometry;
use crate::record::{Band, Stratum};
use crate::scene::{Pair, Scene};
use crate::truth::{self, Judgement, PairOracle, TruthCache, TruthError};
use crate::workload::{self, PairPoses, WorkloadError};
use std::sync::Arc;
use thiserror::Error;

/// A pose and its truth.
#[derive(Clone, Debug)]
pub struct JudgedPose {
    /// Part `b` in the frame of part `a`.
    pub a_from_b: Isometry,
    /// Whether the surfaces touch, exactly.
    pub exact: bool,
    /// Whether any pair of triangles touches by the fast test.
    pub brute: bool,
    /// Whether one solid lies wholly inside the other.
    pub contained: bool,
    /// Distance stratum.
    pub stratum: Stratum,
    /// Depth band; [`Band::Clear`] when the surfaces do not touch.
    pub band: Band,
}

/// The judged poses of one pair of one workload.
#[derive(Clone, Debug)]
pub struct JudgedPair {
    /// Workload name.
    pub workload: String,
    /// The pair.
    pub pair: Pair,
    /// Its poses, in the workload's order.
    pub poses: Vec<JudgedPose>,
}

/// Why poses could not be judged.
#[derive(Debug, Error)]
pub enum JudgeError {
    /// The workload cannot be made.
    #[error(transparent)]
    Workload(#[from] WorkloadError),
    /// The truth cannot be found or stored.
    #[error(transparent)]
    Truth(#[from] TruthError),
    /// No workload of the scene has the name asked for.
    #[error("scene `{scene}` has no workload `{asked}`; it has {known}")]
    NoSuchWorkload {
        /// The scene.
        scene: String,
        /// What was asked for.
        asked: String,
        /// What there is.
        known: String,
    },
}

impl JudgedPair {
    /// Indices of the poses of a stratum.
    #[must_use]
    pub fn poses_in(&self, stratum: Stratum) -> Vec<usize> {
        let in_stratum = |(index, pose): (usize, &JudgedPose)| (pose.stratum == stratum).then_some(index);
        self.poses.iter().enumerate().filter_map(in_stratum).collect()
    }
}

/// Generates about `poses` posed pairs of a scene and judges them; truth already in `cache` is not computed again.
///
/// # Errors
/// When a workload cannot be made or the cache cannot be written.
pub fn judge(
    plan: &Plan,
    scene: &Scene,
    poses: usize,
    cache: Option<&TruthCache>,
    progress: &dyn Progress,
) -> Result<Vec<JudgedPair>, JudgeError> {
    let workloads = workload::generate(scene, poses, plan.selection.seed)?;
    let asked = &plan.selection.workloads;
    if let Some(missing) = asked.iter().find(|name| workloads.iter().all(|workload| &workload.name != *name)) {
        let known = workloads.iter().map(|workload| workload.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(JudgeError::NoSuchWorkload { scene: scene.name.clone(), asked: missing.clone(), known });
    }
    let chosen = workloads.iter().filter(|workload| asked.is_empty() || asked.contains(&workload.name));
    let pairs: Vec<(&str, &PairPoses)> =
        chosen.flat_map(|workload| workload.pairs.iter().map(|pair| (workload.name.as_str(), pair))).collect();
    let total = pairs.iter().map(|(_, pair)| pair.poses.len() as u64).sum();
    progress.begin(&format!("{}: exact truth", scene.name), total);
    let judge_pair = |(name, pair_poses): (&str, &PairPoses)| {
        let mesh = |part: usize| Arc::clone(&scene.parts[part].mesh);
        let oracle = PairOracle::new(mesh(pair_poses.pair.a), mesh(pair_poses.pair.b));
        let judgements = truth::judge_path(&oracle, &pair_poses.questions(), cache, &|done| progress.advance(done))?;
        let judged = pair_poses.poses.iter().zip(judgements);
        let poses = judged.map(|(pose, judgement)| judged_pose(pose.a_from_b, &judgement)).collect();
        Ok(JudgedPair { workload: name.to_owned(), pair: pair_poses.pair, poses })
    };
    pairs.into_iter().map(judge_pair).collect()
}

fn judged_pose(a_from_b: Isometry, judgement: &Judgement) -> JudgedPose {
    let touching = judgement.exact;
    JudgedPose {
        a_from_b,
        exact: touching,
        brute: judgement.brute,
        contained: judgement.contained,
        stratum: Stratum::of(touching, judgement.clearance_mm),
        band: if touching { Band::of_depth(judgement.depth_mm) } else { Band::Clear },
    }
}
