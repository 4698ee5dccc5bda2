//! Timing queries: randomised complete blocks.
//!
//! In every block every chunk is visited in a fresh random order, and for a chunk every case runs in a fresh random order,
//! back to back, each after an untimed run over the same poses that brings the parts of its trees they need into the caches
//! and teaches the branch predictor: without it a short sample mostly measures what ran before it. The first block
//! warms up, finds how often a short chunk must be repeated, and is dropped. Where a chunk takes a case longer than
//! `LONG_SAMPLE_NS`, one timed block of each launch is enough for it: such a sample averages the machine's noise itself. Where it takes ten times
//! that, one launch is: a method that slow is compared with others by factors, not by per cent.

use super::build::Built;
use super::chunk::{Chunk, Participants};
use super::judged::JudgedPair;
use super::plan::{Case, Plan};
use super::{Progress, timer};
use crate::geometry::Isometry;
use crate::method::{Kind, Model};
use crate::record::{CONTROL_WORKLOAD, NULL_VARIANT, TimingRow};
use crate::scene::Scene;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use std::collections::BTreeMap;

/// Poses run untimed before a long sample; before a shorter one all are.
const WARM_UP_POSES: usize = 2;

/// A chunk that takes a case longer than this, ns, is timed once in a launch: five times the shortest sample.
const LONG_SAMPLE_NS: u64 = 5 * timer::SHORTEST_SAMPLE_NS;

/// A chunk that takes a case longer than this, ns, is timed in the first launch alone.
const VERY_LONG_SAMPLE_NS: u64 = 10 * LONG_SAMPLE_NS;

/// How a case runs a chunk, as the warm-up found.
#[derive(Clone, Copy)]
struct Repetition {
    /// Runs over the chunk in one sample.
    passes: u32,
    /// Whether one timed block is enough.
    once: bool,
    /// Whether that of the first launch is.
    first_launch: bool,
}

/// A case with its trees over the parts of a scene.
struct TimedCase {
    case: Case,
    models: BTreeMap<usize, Box<dyn Model>>,
}

/// Times all chunks of a scene with every case of the plan and the null duplicate; what is `built` already is not built again.
pub fn time_scene(
    plan: &Plan,
    scene: &Scene,
    (judged, chunks): (&[JudgedPair], &[Chunk]),
    built: Built,
    launch: u32,
    progress: &dyn Progress,
) -> Vec<TimingRow> {
    let timed_cases = timed_cases(plan, scene, built);
    let chunk_poses: Vec<Vec<Isometry>> = chunks
        .iter()
        .map(|chunk| chunk.poses.iter().map(|&pose| judged[chunk.pair].poses[pose].a_from_b).collect())
        .collect();
    let mut rng = Pcg64Mcg::seed_from_u64(plan.selection.seed ^ (u64::from(launch) << 32));
    // The control needs no warm-up to be known as slow.
    let unknown = |timed: &TimedCase| Repetition {
        passes: 1,
        once: timed.case.variant.kind == Kind::Control,
        first_launch: false,
    };
    let mut repetitions = vec![timed_cases.iter().map(unknown).collect::<Vec<_>>(); chunks.len()];
    let mut verdicts = Vec::new();
    let mut rows = Vec::new();
    let mut chunk_order: Vec<usize> = (0..chunks.len()).collect();
    let mut case_order: Vec<usize> = (0..timed_cases.len()).collect();
    for block in 0..=plan.budget.blocks {
        chunk_order.shuffle(&mut rng);
        for &c in &chunk_order {
            // One launch is enough for the control, whose samples last a second each: nobody compares it by per cent.
            if chunks[c].participants == Participants::Control && launch > 0 {
                progress.advance(1);
                continue;
            }
            let (chunk, poses) = (&chunks[c], &chunk_poses[c]);
            case_order.shuffle(&mut rng);
            for &k in &case_order {
                let repetition = repetitions[c][k];
                let needed = if block == 0 { !repetition.once } else { !repetition.once || block == 1 };
                let done = repetition.first_launch && launch > 0;
                if !needed || done || !takes_part(&timed_cases[k], chunk, plan) {
                    continue;
                }
                let (a, b) = timed_cases[k].pair_of(&judged[chunk.pair]);
                let mut run = |poses: &[Isometry], passes: u32| {
                    for _ in 0..passes {
                        verdicts.clear();
                        a.first(b, poses, &mut verdicts);
                    }
                    verdicts.last().copied()
                };
                if chunk.participants != Participants::Control {
                    let all = block > 0 && !repetition.once;
                    let first = &poses[..poses.len().min(WARM_UP_POSES)];
                    let (ns, _) = timer::time(|| run(if all { poses } else { first }, 1));
                    // What its first poses show to be long need not be run whole to be known as such.
                    let whole = ns * poses.len() as u64 / first.len() as u64;
                    if block == 0 && whole > 2 * LONG_SAMPLE_NS {
                        repetitions[c][k] =
                            Repetition { passes: 1, once: true, first_launch: whole > VERY_LONG_SAMPLE_NS };
                        continue;
                    }
                }
                let (ns, _) = timer::time(|| run(poses, repetition.passes));
                if block == 0 {
                    let (passes, once) = (timer::passes_for(ns), ns > LONG_SAMPLE_NS);
                    repetitions[c][k] = Repetition { passes, once, first_launch: false };
                } else {
                    let (case, pair) = (&timed_cases[k].case, &judged[chunk.pair]);
                    rows.push(row(scene, pair, chunk, case, launch, block - 1, repetition.passes, ns));
                }
            }
            progress.advance(1);
        }
    }
    // Written in one order whatever the order of execution.
    rows.sort_by(|x: &TimingRow, y| (x.block, x.chunk).cmp(&(y.block, y.chunk)).then_with(|| x.case().cmp(&y.case())));
    rows
}

impl TimedCase {
    /// With the `models` there are already.
    fn prepare(case: &Case, id: &str, scene: &Scene, mut models: BTreeMap<usize, Box<dyn Model>>) -> Self {
        for part in scene.pairs.iter().flat_map(|pair| [pair.a, pair.b]) {
            models.entry(part).or_insert_with(|| case.variant.prepare(&scene.parts[part].mesh, case.policy));
        }
        Self { case: Case { id: id.to_owned(), ..case.clone() }, models }
    }

    fn pair_of(&self, judged: &JudgedPair) -> (&dyn Model, &dyn Model) {
        (self.models[&judged.pair.a].as_ref(), self.models[&judged.pair.b].as_ref())
    }
}

fn timed_cases(plan: &Plan, scene: &Scene, built: Built) -> Vec<TimedCase> {
    let mut models: Vec<BTreeMap<usize, Box<dyn Model>>> = plan.cases.iter().map(|_| BTreeMap::new()).collect();
    for ((place, part), model) in built {
        models[place].insert(part, model);
    }
    let null = plan.null_reference().map(|case| TimedCase::prepare(case, NULL_VARIANT, scene, BTreeMap::new()));
    let own = plan.cases.iter().zip(models).map(|(case, models)| TimedCase::prepare(case, &case.id, scene, models));
    own.chain(null).collect()
}

/// Whether a case runs a chunk.
fn takes_part(timed: &TimedCase, chunk: &Chunk, plan: &Plan) -> bool {
    let case = &timed.case;
    match (chunk.participants, case.variant.kind) {
        (Participants::Control, Kind::Control) => true,
        (Participants::Control, _) => {
            plan.null_reference().is_some_and(|reference| reference.id == case.id && reference.policy == case.policy)
        }
        (_, Kind::Control) => false,
        (Participants::Volumes, Kind::Peer) => false,
        _ => true,
    }
}

#[expect(clippy::too_many_arguments, reason = "one argument per column of the row")]
fn row(
    scene: &Scene,
    judged: &JudgedPair,
    chunk: &Chunk,
    case: &Case,
    launch: u32,
    block: u32,
    passes: u32,
    ns: u64,
) -> TimingRow {
    let (split, axes, leaf) = case.policy_columns();
    TimingRow {
        scene: scene.name.clone(),
        workload: if chunk.participants == Participants::Control {
            CONTROL_WORKLOAD.to_owned()
        } else {
            judged.workload.clone()
        },
        pair: scene.pair_name(judged.pair),
        stratum: chunk.stratum,
        variant: case.id.clone(),
        split,
        axes,
        leaf,
        launch,
        block,
        chunk: chunk.number,
        poses: chunk.poses.len() as u32,
        passes,
        ns,
    }
}
