//! Variance components: how much of the spread of a total time comes from binary, launch and block, and how often each must be repeated.
//!
//! - *Components*: a balanced nested analysis of variance by the method of moments (Searle, Casella and McCulloch 1992, Variance
//!   Components, section 3.6), over the logarithm of the total, or of its ratio to the baseline in the same block. A negative component is
//!   set to 0.
//!
//! - *Repetitions*: the number of blocks of a launch is at most the square root of the ratio of costs times the ratio of variances (Kalibera
//!   and Jones 2013, ISMM, Rigorous Benchmarking in Reasonable Time). The numbers of binaries and launches are the smallest that bring the
//!   interval's half-width to [`HALF_WIDTH`] with so many blocks, and of the blocks no more are kept than that needs.

use super::claims::ClaimSet;
use super::ratios::Cases;
use super::stats::{mean, median, student_95};
use super::summary::Cell;
use super::table::{Chunk, Scene};
use super::{AnalysisError, ranking_workload};
use crate::record::rows::CaseKey;
use crate::record::{Kind, Manifest, VarianceRow};
use std::collections::{BTreeMap, BTreeSet};

/// Target half-width of the interval: half of the margin within which two times are called the same.
pub const HALF_WIDTH: f64 = 0.025;
/// Fewest binaries that a plan asks for.
const FEWEST_BINARIES: u32 = 5;
/// Most binaries that a plan asks for; more are not worth building.
pub const MOST_BINARIES: u32 = 64;
/// Most launches of a binary, and most blocks of a launch.
const MOST_LAUNCHES: u32 = 4;
const MOST_BLOCKS: u32 = 16;
/// Shortest duration of a sample, ns.
const SAMPLE_NS: f64 = 1e5;

/// The components of every case in every workload and for whole programs: those of its own time, and those of its ratio to the first
/// baseline.
/// # Errors
/// When the manifest's policy of the baseline is malformed.
pub fn components(
    scenes: &BTreeMap<String, Scene>,
    cases: &Cases,
    claims: &ClaimSet,
) -> Result<Vec<VarianceRow>, AnalysisError> {
    let baseline = claims.comparison.baselines.first().map(|id| cases.default_of(id)).transpose()?.flatten();
    let mut rows = Vec::new();
    for (name, scene) in scenes {
        let cost = Cost::of(scene);
        let workloads: BTreeSet<&str> =
            scene.chunks.values().filter(|chunk| !chunk.is_control()).map(workload).collect();
        for workload in workloads {
            for case in scene.timings.keys() {
                let against = baseline.as_ref().filter(|baseline| *baseline != case);
                for below in [None].into_iter().chain(against.map(Some)) {
                    let logs = log_totals(scene, workload, case, below);
                    rows.extend(logs.map(|logs| row((name, workload), case, below, &logs, &cost)));
                }
            }
        }
    }
    Ok(rows)
}

/// How often the next run repeats: enough for every row that ranks a safe volume under its default policy, if enough is possible.
#[derive(Clone, Debug, PartialEq)]
pub struct NextRun {
    /// Binaries.
    pub binaries: u32,
    /// Launches of each binary.
    pub launches: u32,
    /// Blocks of each launch.
    pub blocks: u32,
    /// The row that needs the most binaries.
    pub decisive: VarianceRow,
    /// Rows whose interval more than [`MOST_BINARIES`] binaries would need: the plan is too small for them.
    pub beyond: Vec<VarianceRow>,
}

/// The repetitions that all rows need that rank the safe volumes under their default policies: the largest number of each kind. `None` when
/// the run has too few binaries, launches or blocks for components, or no row with which so many binaries suffice.
pub fn next_run(rows: &[VarianceRow], manifest: &Manifest) -> Option<NextRun> {
    let is_asked = |row: &&VarianceRow| {
        let entry = manifest.variants.iter().find(|entry| entry.id == row.variant);
        entry.is_some_and(|entry| {
            entry.safe && entry.kind == Kind::Volume && entry.policies.first() == Some(&row.case().policy())
        })
    };
    let asked = rows.iter().filter(|row| ranks(rows, row) && !row.baseline.is_empty()).filter(is_asked);
    let plan = |row: &VarianceRow| Some([row.planned_binaries?, row.planned_launches?, row.planned_blocks?]);
    let (planned, without): (Vec<&VarianceRow>, Vec<&VarianceRow>) = asked.partition(|row| plan(row).is_some());
    let largest = planned.iter().filter_map(|row| plan(row)).reduce(|most, next| {
        let mut most = most;
        most.iter_mut().zip(next).for_each(|(most, next)| *most = (*most).max(next));
        most
    });
    let [binaries, launches, blocks] = largest?;
    let decisive = planned.into_iter().max_by_key(|row| plan(row))?.clone();
    let has_components = |row: &&VarianceRow| row.binary_sd.and(row.launch_sd).and(row.block_sd).is_some();
    let beyond = without.into_iter().filter(has_components).cloned().collect();
    Some(NextRun { binaries, launches, blocks, decisive, beyond })
}

/// Whether a row is of the workload by which its scene is ranked.
pub fn ranks(rows: &[VarianceRow], row: &VarianceRow) -> bool {
    let of_scene = rows.iter().filter(|other| other.scene == row.scene).map(|other| other.workload.as_str());
    ranking_workload(of_scene) == Some(row.workload.as_str())
}

fn workload(chunk: &Chunk) -> &str {
    &chunk.workload
}

/// Measuring time of a scene, ns.
struct Cost {
    /// Time of one block of all cases, ns.
    block: f64,
    /// Time of a launch without its blocks, ns.
    launch: f64,
}

impl Cost {
    fn of(scene: &Scene) -> Self {
        let launches = scene.launches.max(1) as f64;
        let passes = scene.timings.values().flatten().map(|sample| (sample, scene.chunks[&sample.item].poses));
        let pass = passes.map(|(sample, poses)| (sample.launch, sample.block, sample.ns * f64::from(poses)));
        let (mut total, mut blocks) = (0.0, BTreeSet::new());
        for (launch, block, ns) in pass {
            // A whole untimed pass, and the sample; further readings of programs are not counted.
            total += ns + ns.max(SAMPLE_NS);
            blocks.insert((launch, block));
        }
        let block = total / blocks.len().max(1) as f64;
        let built: f64 = scene.builds.values().flatten().map(|sample| sample.ns).sum();
        // Every launch drops a block.
        Self { block, launch: built / launches + block }
    }
}

/// Logarithms, by binary, launch and block.
struct Logs {
    values: Vec<Vec<Vec<f64>>>,
    /// Whether some chunk was timed in several blocks of one launch.
    has_blocks: bool,
}

/// Samples of one launch and chunk, by block.
type Blocks = BTreeMap<u32, f64>;

/// The logarithm of a case's total, or of its ratio to another case, in every block. A chunk that was timed in fewer blocks than others
/// counts with its median in the blocks that it lacks. `None` when a launch has no chunk of the workload.
fn log_totals(scene: &Scene, workload: &str, case: &CaseKey, below: Option<&CaseKey>) -> Option<Logs> {
    let mut of_cases = vec![by_chunk(scene, workload, case)?];
    if let Some(below) = below {
        of_cases.push(by_chunk(scene, workload, below)?);
    }
    let chunks: BTreeSet<u32> = of_cases[0].keys().map(|(_, chunk)| *chunk).collect();
    let launches = scene.binaries.launches();
    let everywhere = |chunk: &u32| {
        let mut all = launches.iter().flatten();
        all.all(|&launch| of_cases.iter().all(|of| of.contains_key(&(launch as u32, *chunk))))
    };
    let chunks: Vec<u32> = chunks.into_iter().filter(everywhere).collect();
    let blocks: BTreeSet<u32> = of_cases.iter().flat_map(|of| of.values().flat_map(Blocks::keys).copied()).collect();
    if chunks.is_empty() {
        return None;
    }
    let weights = scene.weights(Cell { workload, stratum: None }, chunks.iter().copied());
    let total = |of: &BTreeMap<(u32, u32), Blocks>, launch: u32, block: u32| -> f64 {
        chunks.iter().map(|chunk| weights[chunk] * in_block(&of[&(launch, *chunk)], block)).sum()
    };
    let log = |launch: u32, block: u32| {
        let totals: Vec<f64> = of_cases.iter().map(|of| total(of, launch, block)).collect();
        totals.get(1).map_or(totals[0], |below| totals[0] / below).ln()
    };
    let of_launch = |&launch: &usize| blocks.iter().map(|&block| log(launch as u32, block)).collect();
    let values = launches.iter().map(|launches| launches.iter().map(of_launch).collect()).collect();
    let has_blocks = of_cases.iter().any(|of| of.values().any(|blocks| blocks.len() > 1));
    Some(Logs { values, has_blocks })
}

/// The times of one pass over each chunk of a workload, ns, by launch and chunk.
fn by_chunk(scene: &Scene, workload: &str, case: &CaseKey) -> Option<BTreeMap<(u32, u32), Blocks>> {
    let mut chunks: BTreeMap<(u32, u32), Blocks> = BTreeMap::new();
    for sample in scene.timings.get(case)? {
        let chunk = &scene.chunks[&sample.item];
        if chunk.workload == workload {
            let blocks = chunks.entry((sample.launch, sample.item)).or_default();
            blocks.insert(sample.block, sample.ns * f64::from(chunk.poses));
        }
    }
    (!chunks.is_empty()).then_some(chunks)
}

fn in_block(blocks: &Blocks, block: u32) -> f64 {
    blocks.get(&block).copied().unwrap_or_else(|| median(blocks.values().copied().collect()))
}

/// The mean, and the sum of squares about it.
fn spread(values: &[f64]) -> (f64, f64) {
    let mean = mean(values);
    (mean, values.iter().map(|value| (value - mean).powi(2)).sum())
}

/// The variance components, with the ends of the intervals as distances from the mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Components {
    mean: f64,
    binary: Option<f64>,
    launch: Option<f64>,
    block: Option<f64>,
    half: Option<f64>,
    half_within: Option<f64>,
}

impl Components {
    fn of(logs: &Logs) -> Self {
        let binaries = logs.values.len() as f64;
        let launches = logs.values.iter().map(Vec::len).min().unwrap_or(0) as f64;
        let of_launches: Vec<Vec<(f64, f64)>> =
            logs.values.iter().map(|launches| launches.iter().map(|blocks| spread(blocks)).collect()).collect();
        let blocks = logs.values.iter().flatten().map(Vec::len).min().unwrap_or(0) as f64;
        let all = of_launches.iter().map(Vec::len).sum::<usize>() as f64;
        let block = (blocks > 1.0 && logs.has_blocks)
            .then(|| of_launches.iter().flatten().map(|(_, squares)| squares).sum::<f64>() / all / (blocks - 1.0));
        let of_binaries: Vec<(f64, f64)> = of_launches
            .iter()
            .map(|launches| spread(&launches.iter().map(|(mean, _)| *mean).collect::<Vec<_>>()))
            .collect();
        let within = (launches > 1.0)
            .then(|| of_binaries.iter().map(|(_, squares)| squares).sum::<f64>() / binaries / (launches - 1.0));
        let (mean, squares) = spread(&of_binaries.iter().map(|(mean, _)| *mean).collect::<Vec<_>>());
        let between = (binaries > 1.0).then(|| squares / (binaries - 1.0));
        let less = |whole: f64, part: Option<f64>, times: f64| (whole - part.unwrap_or(0.0) / times).max(0.0);
        let half_within =
            within.map(|within| student_95(binaries * (launches - 1.0)) * (within / (binaries * launches)).sqrt());
        let half = between.map(|between| student_95(binaries - 1.0) * (between / binaries).sqrt());
        Self {
            mean,
            binary: between.map(|between| less(between, within, launches).sqrt()),
            launch: within.map(|within| less(within, block, blocks).sqrt()),
            block: block.map(f64::sqrt),
            half: half.or(half_within.filter(|_| binaries < 2.0)),
            half_within,
        }
    }

    /// Binaries, launches of each and blocks of each launch that bring the half-width of the interval to [`HALF_WIDTH`].
    fn plan(&self, cost: &Cost) -> Option<(u32, u32, u32)> {
        let (binary, launch, block) = (self.binary?.powi(2), self.launch?.powi(2), self.block?.powi(2));
        let ideal = (cost.launch / cost.block * block / launch).sqrt().ceil();
        // Without a spread between launches blocks are the cheapest repetition; without any at all, one is enough.
        let most_blocks = if block == 0.0 { 1 } else { ideal.clamp(1.0, f64::from(MOST_BLOCKS)) as u32 };
        let is_enough = |binaries: u32, launches: u32, blocks: u32| {
            let (b, l, k) = (f64::from(binaries), f64::from(launches), f64::from(blocks));
            let error = (binary / b + launch / (b * l) + block / (b * l * k)).sqrt();
            student_95(b - 1.0) * error <= HALF_WIDTH.ln_1p()
        };
        let mut plans = (FEWEST_BINARIES..=MOST_BINARIES).flat_map(|b| (1..=MOST_LAUNCHES).map(move |l| (b, l)));
        let (binaries, launches) = plans.find(|&(b, l)| is_enough(b, l, most_blocks))?;
        // A launch component that was cut off at 0 asks for all the blocks there may be; what suffices is enough.
        let blocks = (1..=most_blocks).find(|&blocks| is_enough(binaries, launches, blocks))?;
        Some((binaries, launches, blocks))
    }
}

fn row(
    (scene, workload): (&str, &str),
    case: &CaseKey,
    below: Option<&CaseKey>,
    logs: &Logs,
    cost: &Cost,
) -> VarianceRow {
    let components = Components::of(logs);
    let value = components.mean.exp();
    let end = |half: Option<f64>, sign: f64| half.map(|half| value * (sign * half).exp());
    let plan = components.plan(cost);
    let count = |number: Option<usize>| number.unwrap_or(0) as u32;
    VarianceRow {
        scene: scene.to_owned(),
        workload: workload.to_owned(),
        variant: case.variant.clone(),
        split: case.split.clone(),
        split_axes: case.split_axes.clone(),
        leaf: case.leaf,
        baseline: below.map_or_else(String::new, CaseKey::name),
        binaries: logs.values.len() as u32,
        launches: count(logs.values.iter().map(Vec::len).min()),
        blocks: count(logs.values.iter().flatten().map(Vec::len).min()),
        value,
        binary_sd: components.binary,
        launch_sd: components.launch,
        block_sd: components.block,
        low: end(components.half, -1.0),
        high: end(components.half, 1.0),
        low_within: end(components.half_within, -1.0),
        high_within: end(components.half_within, 1.0),
        planned_binaries: plan.map(|plan| plan.0),
        planned_launches: plan.map(|plan| plan.1),
        planned_blocks: plan.map(|plan| plan.2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::tests::{close, normal};
    use crate::record::PROGRAM_TIME;

    /// Two binaries with two launches of two blocks: (0, 2), (4, 6) and (10, 12), (14, 16). Blocks differ by 2 in each launch: variance 2.
    /// The means of the launches are 1, 5, 11, 15: variance 8 within a binary, minus 2/2 for blocks: 7. The means of the binaries are 3 and
    /// 13: variance 50, minus 8/2 for launches: 46.
    #[test]
    fn components_by_hand() {
        let values = vec![vec![vec![0.0, 2.0], vec![4.0, 6.0]], vec![vec![10.0, 12.0], vec![14.0, 16.0]]];
        let found = Components::of(&Logs { values, has_blocks: true });
        close(found.mean, 8.0, 1e-12);
        close(found.block.unwrap(), 2_f64.sqrt(), 1e-12);
        close(found.launch.unwrap(), 7_f64.sqrt(), 1e-12);
        close(found.binary.unwrap(), 46_f64.sqrt(), 1e-12);
        // Student's t at 1 and at 2 degrees of freedom: √(50/2) = 5 and √(8/4).
        close(found.half.unwrap(), 12.706 * 5.0, 1e-9);
        close(found.half_within.unwrap(), 4.303 * 2_f64.sqrt(), 1e-9);
    }

    /// A level without repetition has no component.
    #[test]
    fn a_single_one_says_nothing() {
        let of = |values| Components::of(&Logs { values, has_blocks: true });
        let one = of(vec![vec![vec![1.0]]]);
        assert_eq!((one.binary, one.launch, one.block, one.half), (None, None, None, None));
        let launches = of(vec![vec![vec![1.0], vec![2.0]]]);
        assert!(launches.binary.is_none() && launches.half == launches.half_within && launches.half.is_some());
        let binaries = of(vec![vec![vec![1.0]], vec![vec![2.0]]]);
        assert!(binaries.launch.is_none() && binaries.half.is_some() && binaries.half_within.is_none());
    }

    /// Planted components of 3, 1 and 2 % are recovered from 400 binaries.
    #[test]
    fn planted_components_are_found() {
        let mut normal = normal(9);
        let mut values = Vec::new();
        for _ in 0..400 {
            let binary = 0.03 * normal();
            let mut launches = Vec::new();
            for _ in 0..3 {
                let launch = binary + 0.01 * normal();
                launches.push((0..4).map(|_| launch + 0.02 * normal()).collect());
            }
            values.push(launches);
        }
        let found = Components::of(&Logs { values, has_blocks: true });
        close(found.binary.unwrap(), 0.03, 0.003);
        close(found.launch.unwrap(), 0.01, 0.002);
        close(found.block.unwrap(), 0.02, 0.001);
    }

    /// With σ = 1 % between binaries alone, five suffice: 2.776 · 0.01/√5 = 1.24 % is below ln 1.025 = 2.47 %. With 3 %, nine are needed:
    /// for nine, 2.306 · 0.03/√9 = 2.31 %; for eight, 2.365 · 0.03/√8 = 2.51 %. A launch that costs nine times a block of equal spread gets
    /// up to three blocks: with σ = 1.4 % each of launches and blocks, one launch of five binaries needs two: 2.776 · 1.4 % · √(1.5/5) = 2.13 %,
    /// with one 2.46 %; with 1.5 %, 2.64 and 2.28 %. Without a spread between launches blocks of 3 % take 2.776 · 3 %/√(5k): three, not sixteen.
    #[test]
    fn repetitions_by_hand() {
        let cost = Cost { block: 1.0, launch: 9.0 };
        let plan = |binary, launch, block| {
            Components { binary: Some(binary), launch: Some(launch), block: Some(block), ..Components::default() }
                .plan(&cost)
        };
        assert_eq!(plan(0.01, 0.0, 0.0), Some((5, 1, 1)));
        assert_eq!(plan(0.03, 0.0, 0.0), Some((9, 1, 1)));
        assert_eq!(plan(0.001, 0.001, 0.001), Some((5, 1, 1)));
        assert_eq!(plan(0.0, 0.015, 0.015), Some((5, 1, 2)));
        assert_eq!(plan(0.0, 0.0, 0.03), Some((5, 1, 3)));
        assert_eq!(plan(0.5, 0.0, 0.0), None, "64 binaries are too few");
        assert_eq!(Components::default().plan(&cost), None);
    }

    /// Two rows need 5 × 1 × 16 and 9 × 2 × 1: 80 and 18 repetitions. Five binaries would be too few for the second. A row that 64 binaries do
    /// not suffice for is named.
    #[test]
    fn the_next_run_is_enough_for_every_row() {
        let manifest = crate::record::synthetic::Run::generate(&crate::record::synthetic::Plan::default()).manifest;
        let volumes = manifest.variants.iter().filter(|v| v.safe && v.kind == Kind::Volume);
        let ids: Vec<(String, String)> = volumes.map(|v| (v.id.clone(), v.policies[0].clone())).take(3).collect();
        let row = |(id, policy): &(String, String), plan: Option<[u32; 3]>| {
            let parts: Vec<&str> = policy.split('/').collect();
            let (split, axes, leaf) = (parts[0].to_owned(), parts[1].to_owned(), parts[2].parse().unwrap());
            let case = CaseKey { variant: id.clone(), split, split_axes: axes, leaf };
            let logs = Logs { values: vec![vec![vec![0.0, 1.0]; 2]; 2], has_blocks: true };
            let row = row(("a", PROGRAM_TIME), &case, Some(&case), &logs, &Cost { block: 1.0, launch: 1.0 });
            let [binaries, launches, blocks] = plan.map_or([None; 3], |plan| plan.map(Some));
            VarianceRow { planned_binaries: binaries, planned_launches: launches, planned_blocks: blocks, ..row }
        };
        let rows = [row(&ids[0], Some([5, 1, 16])), row(&ids[1], Some([9, 2, 1])), row(&ids[2], None)];
        let next = next_run(&rows, &manifest).unwrap();
        assert_eq!((next.binaries, next.launches, next.blocks), (9, 2, 16));
        assert_eq!(next.decisive.variant, ids[1].0);
        assert_eq!(next.beyond.iter().map(|row| &row.variant).collect::<Vec<_>>(), [&ids[2].0]);
        assert_eq!(next_run(&rows[2..], &manifest), None);
    }
}
