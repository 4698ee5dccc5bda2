//! Variance components: how much of the spread of a total time comes from binary, launch and block, and how often each must be repeated.
//!
//! - *Components*: a balanced nested analysis of variance by the method of moments (Searle, Casella and McCulloch 1992, Variance
//!   Components, section 3.6), over the logarithm of the total, or of its ratio to the baseline in the same block. A negative component is
//!   set to 0.
//!
//! - *Repetitions*: the number of blocks of a launch is the square root of the ratio of costs times the ratio of variances (Kalibera and
//!   Jones 2013, ISMM, Rigorous Benchmarking in Reasonable Time). The numbers of binaries and launches are then the smallest that bring the
//!   interval's half-width to [`HALF_WIDTH`].

use super::AnalysisError;
use super::claims::ClaimSet;
use super::ratios::Cases;
use super::stats::{quantile, student_95};
use super::table::{Chunk, Scene};
use crate::record::rows::CaseKey;
use crate::record::{Kind, Manifest, PROGRAM_TIME, VarianceRow};
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

/// The row that asks for the most repetitions, among those that rank the safe volumes under their default policies. `None` when the run has
/// too few binaries, launches or blocks for components.
#[must_use]
pub fn decisive<'a>(rows: &'a [VarianceRow], manifest: &Manifest) -> Option<&'a VarianceRow> {
    let workload = if rows.iter().any(|row| row.workload == PROGRAM_TIME) {
        PROGRAM_TIME
    } else {
        rows.iter().map(|row| row.workload.as_str()).min()?
    };
    let is_asked = |row: &&VarianceRow| {
        let entry = manifest.variants.iter().find(|entry| entry.id == row.variant);
        entry.is_some_and(|entry| {
            entry.safe && entry.kind == Kind::Volume && entry.policies.first() == Some(&row.case().policy())
        })
    };
    let asked = rows.iter().filter(|row| row.workload == workload && !row.baseline.is_empty()).filter(is_asked);
    let amount = |row: &&VarianceRow| Some(row.planned_binaries? * row.planned_launches? * row.planned_blocks?);
    asked.filter(|row| amount(row).is_some()).max_by_key(amount)
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
    let total = |of: &BTreeMap<(u32, u32), Blocks>, launch: u32, block: u32| -> f64 {
        chunks.iter().map(|chunk| in_block(&of[&(launch, *chunk)], block)).sum()
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
    blocks.get(&block).copied().unwrap_or_else(|| {
        let mut all: Vec<f64> = blocks.values().copied().collect();
        all.sort_unstable_by(f64::total_cmp);
        quantile(&all, 0.5)
    })
}

/// The mean, and the sum of squares about it.
fn spread(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
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
        // Without a spread between launches there is no reason for a second one; without any at all, for a second block.
        let blocks = if block == 0.0 { 1 } else { ideal.clamp(1.0, f64::from(MOST_BLOCKS)) as u32 };
        let half = |binaries: u32, launches: u32| {
            let (b, l, k) = (f64::from(binaries), f64::from(launches), f64::from(blocks));
            student_95(b - 1.0) * (binary / b + launch / (b * l) + block / (b * l * k)).sqrt()
        };
        let mut plans = (FEWEST_BINARIES..=MOST_BINARIES).flat_map(|b| (1..=MOST_LAUNCHES).map(move |l| (b, l)));
        let (binaries, launches) = plans.find(|&(b, l)| half(b, l) <= HALF_WIDTH.ln_1p())?;
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
    use crate::analysis::stats::generator;
    use rand::Rng;

    fn close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} is not {b}");
    }

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
        let mut noise = generator(9, "noise");
        let mut normal = || (0..12).map(|_| f64::from(noise.next_u32()) / 4_294_967_296.0).sum::<f64>() - 6.0;
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
    /// three blocks.
    #[test]
    fn repetitions_by_hand() {
        let cost = Cost { block: 1.0, launch: 9.0 };
        let plan = |binary, launch, block| {
            Components { binary: Some(binary), launch: Some(launch), block: Some(block), ..Components::default() }
                .plan(&cost)
        };
        assert_eq!(plan(0.01, 0.0, 0.0), Some((5, 1, 1)));
        assert_eq!(plan(0.03, 0.0, 0.0), Some((9, 1, 1)));
        assert_eq!(plan(0.001, 0.001, 0.001), Some((5, 1, 3)));
        assert_eq!(plan(0.5, 0.0, 0.0), None, "64 binaries are too few");
        assert_eq!(Components::default().plan(&cost), None);
    }
}
