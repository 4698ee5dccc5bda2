//! The queries of a run: every case and the null duplicate on the chunks of a scene, in `super::blocks`.

use super::Progress;
use super::binaries::binary_of;
use super::blocks::{self, Extent, Participation, Work};
use super::build::Built;
use super::chunk::Participants;
use super::measured::TimedChunk;
use super::plan::{Case, Plan};
use super::study::timing_row;
use crate::method::{Kind, Model};
use crate::record::{NULL_VARIANT, TimingRow};
use crate::scene::{Pair, Scene};
use std::collections::BTreeMap;

/// A case with its trees over the parts of a scene.
pub struct TimedCase {
    /// The case.
    pub case: Case,
    models: BTreeMap<usize, Box<dyn Model>>,
}

/// Times all chunks of a scene with the cases.
pub fn time_scene(
    plan: &Plan,
    scene: &Scene,
    cases: &[TimedCase],
    chunks: &[TimedChunk],
    launch: u32,
    progress: &dyn Progress,
) -> Vec<TimingRow> {
    let mut queries = Queries { plan, cases, chunks, verdicts: Vec::new() };
    let extent = extent(plan);
    let samples = blocks::time(&mut queries, extent, plan.selection.seed ^ (u64::from(launch) << 32), progress);
    let names: Vec<String> = cases.iter().map(|timed| timed.case.name()).collect();
    let row = |sample: &blocks::Sample| TimingRow {
        binary: binary_of(launch, plan.budget.binaries),
        ..timing_row((&scene.name, launch), &names, chunks[sample.chunk].number, sample)
    };
    let mut rows: Vec<TimingRow> = samples.iter().map(row).collect();
    rows.sort_by(|x, y| (x.block, x.chunk, &x.case).cmp(&(y.block, y.chunk, &y.case)));
    rows
}

/// How often [`time_scene`] advances.
pub fn visits(plan: &Plan, chunks: &[TimedChunk]) -> u64 {
    blocks::visits(&Queries { plan, cases: &[], chunks, verdicts: Vec::new() }, extent(plan))
}

const fn extent(plan: &Plan) -> Extent {
    Extent { blocks: plan.budget.blocks, warms_up: true, long_once: true }
}

/// The queries of a scene.
struct Queries<'a> {
    plan: &'a Plan,
    cases: &'a [TimedCase],
    chunks: &'a [TimedChunk],
    verdicts: Vec<bool>,
}

impl Work for Queries<'_> {
    fn cases(&self) -> usize {
        self.cases.len()
    }

    fn chunks(&self) -> Vec<usize> {
        self.chunks.iter().map(TimedChunk::len).collect()
    }

    fn participation(&self, case: usize, chunk: usize) -> Participation {
        let timed = &self.cases[case].case;
        let is_control = timed.variant.kind == Kind::Control;
        match self.chunks[chunk].participants {
            // Samples of the control last a second each: nobody asks for more of it than an order of magnitude, at one pose of a scene.
            Participants::Control if self.is_first_of_control(chunk) && is_control => Participation::Once,
            Participants::Control if self.is_first_of_control(chunk) && self.is_reference(timed) => {
                Participation::Always
            }
            Participants::Control => Participation::Absent,
            _ if is_control => Participation::Absent,
            Participants::Volumes if timed.variant.kind == Kind::Peer => Participation::Absent,
            _ => Participation::Always,
        }
    }

    fn readings(&self, chunk: usize) -> u32 {
        if self.chunks[chunk].is_program { self.plan.budget.program_readings } else { 1 }
    }

    fn run(&mut self, case: usize, chunk: usize, poses: usize, passes: u32) {
        let case = &self.cases[case];
        for _ in 0..passes {
            self.verdicts.clear();
            let mut left = poses;
            for (pair, run) in &self.chunks[chunk].runs {
                let count = run.len().min(left);
                left -= count;
                let (a, b) = case.models_of(*pair);
                a.first(b, &run[..count], &mut self.verdicts);
            }
        }
        std::hint::black_box(self.verdicts.last());
    }
}

impl Queries<'_> {
    fn is_first_of_control(&self, chunk: usize) -> bool {
        self.chunks[..chunk].iter().all(|other| other.participants != Participants::Control)
    }

    /// Whether a case is the one that the null duplicate copies.
    fn is_reference(&self, case: &Case) -> bool {
        let is = |reference: &Case| reference.id == case.id && reference.policy == case.policy;
        self.plan.null_reference().is_some_and(is)
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

    /// The trees over both parts of a pair.
    pub fn models_of(&self, pair: Pair) -> (&dyn Model, &dyn Model) {
        (self.models[&pair.a].as_ref(), self.models[&pair.b].as_ref())
    }
}

/// Every case of the plan and the null duplicate, with their trees; what is `built` already is not built again.
pub fn timed_cases(plan: &Plan, scene: &Scene, built: Built) -> Vec<TimedCase> {
    let mut models: Vec<BTreeMap<usize, Box<dyn Model>>> = plan.cases.iter().map(|_| BTreeMap::new()).collect();
    for ((place, part), model) in built {
        models[place].insert(part, model);
    }
    let null = plan.null_reference().map(|case| TimedCase::prepare(case, NULL_VARIANT, scene, BTreeMap::new()));
    let own = plan.cases.iter().zip(models).map(|(case, models)| TimedCase::prepare(case, &case.id, scene, models));
    own.chain(null).collect()
}
