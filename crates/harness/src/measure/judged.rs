//! Poses with their truth: what every variant's verdict is held against.

use super::measured::ProgramQuery;
use super::plan::Plan;
use super::{MeasureError, Progress};
use crate::geometry::Isometry;
use crate::record::{Band, Stratum};
use crate::scene::{Pair, ProgramRun, Scene};
use crate::truth::{self, Judgement, PairOracle, Sought, TruthCache, TruthKey, Verdict};
use crate::workload::{self, PairPoses, PairSteps, PosedPair, Source, Workload};
use std::sync::Arc;

/// A pose and its truth.
#[derive(Clone, Debug)]
pub struct JudgedPose {
    /// Part `b` in the frame of part `a`.
    pub a_from_b: Isometry,
    /// A pair of triangles that touches, (face of `a`, face of `b`), where there is one; exact.
    pub witness: Option<(u32, u32)>,
    /// Whether one solid lies wholly inside the other.
    pub contained: bool,
    /// Distance stratum; of a pose without contact the farthest one where [`Strata::NotSought`] was asked for.
    pub stratum: Stratum,
    /// Depth band; [`Band::Clear`] when the surfaces do not touch.
    pub band: Band,
    /// Distance of the surfaces, mm, or more, but on the same side of the strata's borders; 0 when they touch, infinite when not sought.
    pub clearance_mm: f64,
    /// The approach, ray or stretch of a path that the pose lies on.
    pub line: u32,
}

/// Whether the distances of free poses are found: verification does without, and they are most of the truth's cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strata {
    /// They are.
    Sought,
    /// They are not.
    NotSought,
}

impl Strata {
    const fn sought(self) -> Sought<'static> {
        match self {
            Self::Sought => Sought::Borders(&Stratum::BORDERS_MM),
            Self::NotSought => Sought::Nothing,
        }
    }
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

impl JudgedPose {
    /// Whether the surfaces touch; exact.
    pub const fn touches(&self) -> bool {
        self.witness.is_some()
    }
}

impl JudgedPair {
    /// Indices of the poses of a stratum.
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
    strata: Strata,
    cache: Option<&TruthCache>,
    progress: &dyn Progress,
) -> Result<Vec<JudgedPair>, MeasureError> {
    let workloads = workload::generate(scene, poses, plan.selection.seed)?;
    let asked = &plan.selection.workloads;
    let chosen: Vec<&Workload> =
        workloads.iter().filter(|workload| asked.is_empty() || asked.contains(&workload.name)).collect();
    progress.begin(&format!("{}: exact truth", scene.name), chosen.iter().map(|workload| workload.len() as u64).sum());
    let mut judged = Vec::new();
    for workload in chosen {
        for pair in &workload.pairs {
            let judgements = judgements(scene, workload.source, pair, strata, cache, progress)?;
            let poses = pair.poses.iter().zip(&judgements);
            let poses = poses.map(|(pose, judgement)| judged_pose(pose, judgement)).collect();
            judged.push(JudgedPair { workload: workload.name.clone(), pair: pair.pair, poses });
        }
    }
    Ok(judged)
}

/// A program of the scene, judged query by query in the order in which a controller would ask, up to and with the first that touches.
///
/// # Errors
/// When the program leaves the machine's limits or the cache cannot be written.
pub fn judge_program(
    plan: &Plan,
    scene: &Scene,
    run: &ProgramRun,
    cache: Option<&TruthCache>,
    progress: &dyn Progress,
) -> Result<Vec<ProgramQuery>, MeasureError> {
    let pairs = workload::along(scene, run, plan.budget.program_steps)?;
    let total = pairs.iter().map(|pair| pair.steps.len() as u64).sum();
    progress.begin(&format!("{}: exact truth along {}", scene.name, run.file.display()), total);
    let mut queries = Vec::new();
    for PairSteps { poses, steps } in pairs {
        let judgements = judgements(scene, Source::Program, &poses, Strata::Sought, cache, progress)?;
        let judged = poses.poses.iter().zip(&judgements).zip(steps);
        queries.extend(judged.map(|((pose, judgement), step)| ProgramQuery {
            pair: poses.pair,
            step,
            pose: judged_pose(pose, judgement),
        }));
    }
    // Stable: the pairs of a step stay in the scene's order.
    queries.sort_by_key(|query| query.step);
    if let Some(first) = queries.iter().position(|query| query.pose.touches()) {
        queries.truncate(first + 1);
    }
    Ok(queries)
}

/// The truth about every pose of a pair, from the cache or found anew.
fn judgements(
    scene: &Scene,
    source: Source,
    pair: &PairPoses,
    strata: Strata,
    cache: Option<&TruthCache>,
    progress: &dyn Progress,
) -> Result<Vec<Judgement>, MeasureError> {
    let mesh = |part: usize| Arc::clone(&scene.parts[part].mesh);
    let oracle = PairOracle::new(mesh(pair.pair.a), mesh(pair.pair.b));
    let poses: Vec<Isometry> = pair.poses.iter().map(|pose| pose.a_from_b).collect();
    let along_path = matches!(source, Source::Program | Source::Recorded);
    let key =
        TruthKey::new(&oracle, &poses, &format!("clearance: {:?} mm, depth along path: {along_path}", strata.sought()));
    let known = cache.and_then(|cache| cache.load(&key));
    let mut judgements = if let Some(known) = known {
        progress.advance(poses.len() as u64);
        known
    } else {
        let mut found = truth::judge_all(&oracle, &poses, &strata.sought(), &|done| progress.advance(done));
        if along_path {
            let verdicts: Vec<Verdict> = found.iter().map(|judgement| judgement.verdict).collect();
            for (judgement, depth) in found.iter_mut().zip(truth::path_depths(&oracle, &poses, &verdicts)) {
                judgement.depth_mm = depth;
            }
        }
        if let Some(cache) = cache {
            cache.store(&key, &found)?;
        }
        found
    };
    if !along_path {
        for (judgement, pose) in judgements.iter_mut().zip(&pair.poses) {
            judgement.depth_mm = pose.depth_mm;
        }
    }
    Ok(judgements)
}

fn judged_pose(pose: &PosedPair, judgement: &Judgement) -> JudgedPose {
    let touching = judgement.verdict.touches();
    let band = match judgement.depth_mm {
        _ if !touching => Band::Clear,
        Some(depth) => Band::of_depth(depth),
        // A contact whose depth nobody knows counts as deep, so that missing it is never excused.
        None => Band::Deep,
    };
    JudgedPose {
        a_from_b: pose.a_from_b,
        clearance_mm: if touching { 0.0 } else { judgement.clearance_mm },
        line: pose.cluster,
        witness: judgement.verdict.witness,
        contained: judgement.verdict.contained,
        stratum: Stratum::of(touching, judgement.clearance_mm),
        band,
    }
}
