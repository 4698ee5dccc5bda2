//! The queries of a run: every case and the null duplicate on the chunks of a scene, in [`super::blocks`].

use super::Progress;
use super::blocks::{self, Extent, Participation, Work};
use super::build::Built;
use super::chunk::{Chunk, Participants};
use super::judged::JudgedPair;
use super::plan::{Case, Plan};
use crate::geometry::Isometry;
use crate::method::{Kind, Model};
use crate::record::{CONTROL_WORKLOAD, NULL_VARIANT, TimingRow};
use crate::scene::Scene;
use std::collections::BTreeMap;

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
    let poses = |chunk: &Chunk| chunk.poses.iter().map(|&pose| judged[chunk.pair].poses[pose].a_from_b).collect();
    let mut queries = Queries {
        plan,
        cases: timed_cases(plan, scene, built),
        chunks,
        judged,
        launch,
        poses: chunks.iter().map(poses).collect(),
        verdicts: Vec::new(),
    };
    let extent = Extent { blocks: plan.budget.blocks, launch, warms_up: true, long_once: true };
    let samples = blocks::time(&mut queries, extent, plan.selection.seed ^ (u64::from(launch) << 32), progress);
    let row = |sample: blocks::Sample| {
        let (chunk, case) = (&chunks[sample.chunk], &queries.cases[sample.case].case);
        row(scene, &judged[chunk.pair], chunk, case, launch, sample)
    };
    let mut rows: Vec<TimingRow> = samples.into_iter().map(row).collect();
    rows.sort_by(|x, y| (x.block, x.chunk).cmp(&(y.block, y.chunk)).then_with(|| x.case().cmp(&y.case())));
    rows
}

/// The queries of a scene.
struct Queries<'a> {
    plan: &'a Plan,
    cases: Vec<TimedCase>,
    chunks: &'a [Chunk],
    judged: &'a [JudgedPair],
    launch: u32,
    /// Of each chunk.
    poses: Vec<Vec<Isometry>>,
    verdicts: Vec<bool>,
}

impl Work for Queries<'_> {
    fn cases(&self) -> usize {
        self.cases.len()
    }

    fn chunks(&self) -> Vec<usize> {
        self.poses.iter().map(Vec::len).collect()
    }

    fn participation(&self, case: usize, chunk: usize) -> Participation {
        let is_control = self.cases[case].case.variant.kind == Kind::Control;
        // One launch is enough for the control, whose samples last a second each: nobody compares it by per cent.
        let is_over = self.chunks[chunk].participants == Participants::Control && self.launch > 0;
        match takes_part(&self.cases[case], &self.chunks[chunk], self.plan) {
            true if is_control => Participation::Once,
            true if !is_over => Participation::Always,
            _ => Participation::Absent,
        }
    }

    fn run(&mut self, case: usize, chunk: usize, poses: usize, passes: u32) {
        let (a, b) = self.cases[case].pair_of(&self.judged[self.chunks[chunk].pair]);
        for _ in 0..passes {
            self.verdicts.clear();
            a.first(b, &self.poses[chunk][..poses], &mut self.verdicts);
        }
        std::hint::black_box(self.verdicts.last());
    }
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

fn row(
    scene: &Scene,
    judged: &JudgedPair,
    chunk: &Chunk,
    case: &Case,
    launch: u32,
    blocks::Sample { block, passes, ns, .. }: blocks::Sample,
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
