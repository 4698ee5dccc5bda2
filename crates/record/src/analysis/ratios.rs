//! Ratios of totals: every case to each baseline, the subject of each reading to its baseline, the null duplicate to its original, and the
//! ranked volumes to the fastest one of a scene.

use super::AnalysisError;
use super::claims::{CaseRef, ClaimSet};
use super::judge::{CLUSTERS_MIN, Effect};
use super::stats::Interval;
use super::summary::{ALL, Cell};
use super::table::{Counter, Scene};
use super::totals::Estimate;
use super::{Ranked, is_noisy, ranked_by, ranked_in, ranking_ratio};
use crate::record::rows::CaseKey;
use crate::record::{Manifest, NULL_VARIANT, PROGRAM_TIME, PROGRAM_TIME_COLD, RatioRow};
use std::collections::{BTreeMap, BTreeSet};

/// The quantity that is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Metric {
    /// Time of whole programs.
    ProgramTime,
    /// Time of queries of whole programs with cold caches.
    ProgramTimeCold,
    /// Query time.
    Time,
    /// Volume tests of a query.
    VolumeTests,
    /// Triangle tests of a query.
    TriangleTests,
    /// Construction time.
    Build,
}

impl Metric {
    /// All metrics.
    pub const ALL: [Self; 6] =
        [Self::ProgramTime, Self::ProgramTimeCold, Self::Time, Self::VolumeTests, Self::TriangleTests, Self::Build];

    /// The name in files.
    pub const fn id(self) -> &'static str {
        match self {
            Self::ProgramTime => PROGRAM_TIME,
            Self::ProgramTimeCold => PROGRAM_TIME_COLD,
            Self::Time => "time",
            Self::VolumeTests => "volume-tests",
            Self::TriangleTests => "triangle-tests",
            Self::Build => "build",
        }
    }

    /// Whether the metric is a time, whose noise the null duplicate shows.
    fn is_timed(id: &str) -> bool {
        [Self::ProgramTime, Self::ProgramTimeCold, Self::Time].iter().any(|metric| metric.id() == id)
    }
}

/// A ratio, with the workload and stratum that it describes.
#[derive(Clone, Debug, PartialEq)]
pub struct Ratio {
    /// Workload as `ratios.csv` names it.
    pub workload: String,
    /// Stratum, program, `all` or `-`.
    pub stratum: String,
    /// The ratio.
    pub estimate: Estimate,
    /// Fewest resampled units that decide: two launches or binaries, because Student's quantile accounts for their number; else
    /// [`CLUSTERS_MIN`].
    pub fewest: usize,
}

impl Ratio {
    /// Whether the ratio covers a whole workload, all programs or all parts.
    pub fn is_whole(&self) -> bool {
        self.stratum == ALL || self.stratum == "-"
    }

    /// Whether there are too few clusters for an interval.
    pub fn has_few_clusters(&self) -> bool {
        self.estimate.clusters < self.fewest as u64
    }
}

/// The ratios of two cases in every workload and stratum; empty when no observations pair.
pub fn compare(scene: &Scene, metric: Metric, above: &CaseKey, below: &CaseKey, seed: u64) -> Vec<Ratio> {
    let is_over_launches = match metric {
        Metric::ProgramTime | Metric::ProgramTimeCold => true,
        Metric::Build => scene.has_built_in_launches(),
        _ => false,
    };
    let fewest = if is_over_launches { 2 } else { CLUSTERS_MIN };
    let ratio = |workload: &str, stratum: &str, estimate: Option<Estimate>| {
        let estimate = estimate.filter(|estimate| estimate.interval.value.is_finite())?;
        Some(Ratio { workload: workload.to_owned(), stratum: stratum.to_owned(), estimate, fewest })
    };
    let in_cells = |of: &dyn Fn(Cell<'_>) -> Option<Estimate>| {
        let cells = scene.cells().into_iter();
        cells.filter_map(|cell| ratio(cell.workload, cell.stratum_name(), of(cell))).collect()
    };
    let of_programs = |of: &dyn Fn(Option<&str>) -> Option<Estimate>| {
        let programs = scene.programs().map(|(file, _)| Some(file));
        let each = [None].into_iter().chain(programs);
        each.filter_map(|program| ratio(metric.id(), program.unwrap_or(ALL), of(program))).collect()
    };
    match metric {
        Metric::ProgramTime => of_programs(&|program| scene.program_ratio(above, below, program)),
        Metric::ProgramTimeCold => of_programs(&|program| scene.cold_ratio(above, below, program)),
        Metric::Time => in_cells(&|cell| scene.time_ratio(above, below, cell, seed)),
        Metric::VolumeTests => in_cells(&|cell| scene.count_ratio(above, below, Counter::Volume, cell, seed)),
        Metric::TriangleTests => in_cells(&|cell| scene.count_ratio(above, below, Counter::Triangle, cell, seed)),
        Metric::Build => ratio("-", "-", scene.build_ratio(above, below, seed)).into_iter().collect(),
    }
}

/// In a quiet cell the null duplicate's ratio is within this interval: the two copies are equally fast.
pub const EQUAL: (f64, f64) = (0.99, 1.01);
/// In a quiet cell, the interval of the null duplicate's ratio is within this interval, so the cell can show that two times are the same.
pub const STEADY: (f64, f64) = super::judge::SAME;

/// Cells (scene, workload, and stratum or program) in which the null duplicate is noisy.
#[derive(Clone, Debug, Default)]
pub struct NoisyCells(BTreeMap<(String, String, String), Interval>);

impl NoisyCells {
    /// The noisy cells of a run, from the rows of its null comparison.
    pub fn of(rows: &[RatioRow]) -> Self {
        let is_quiet = |r: &RatioRow| {
            let equal = EQUAL.0 <= r.ratio && r.ratio <= EQUAL.1;
            // Where nothing is known of the spread nothing is decided anyway.
            equal && (r.low.is_nan() || (STEADY.0 <= r.low && r.high <= STEADY.1))
        };
        let is_time = |r: &&RatioRow| Metric::is_timed(&r.metric);
        let loud = rows.iter().filter(|r| r.variant == NULL_VARIANT).filter(is_time).filter(|r| !is_quiet(r));
        Self(
            loud.map(|r| {
                let interval = Interval { value: r.ratio, low: r.low, high: r.high };
                ((r.scene.clone(), r.workload.clone(), r.stratum.clone()), interval)
            })
            .collect(),
        )
    }

    /// The null duplicate's ratio in a noisy cell; `None` in a quiet one.
    pub fn get(&self, scene: &str, workload: &str, stratum: &str) -> Option<Interval> {
        self.0.get(&(scene.to_owned(), workload.to_owned(), stratum.to_owned())).copied()
    }

    /// Workload, and stratum or program, of each cell.
    pub fn names(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.keys().map(|(_, workload, stratum)| (workload.as_str(), stratum.as_str()))
    }

    /// One line for each scene that has noisy cells.
    pub fn complaints(&self) -> Vec<String> {
        let mut scenes: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for ((scene, workload, stratum), null) in &self.0 {
            scenes.entry(scene).or_default().push(format!("{workload} {stratum} {null}"));
        }
        let line = |(scene, cells): (&str, Vec<String>)| {
            format!(
                "{scene}: no speed is judged where the null duplicate over its original is not within [{}, {}], or its interval not within [{}, {}]: {}",
                EQUAL.0,
                EQUAL.1,
                STEADY.0,
                STEADY.1,
                cells.join(", ")
            )
        };
        scenes.into_iter().map(line).collect()
    }
}

/// Finds cases by name.
#[derive(Debug)]
pub struct Cases {
    defaults: BTreeMap<String, String>,
    null_of: String,
}

impl Cases {
    /// Finds cases by the default policies of a manifest.
    pub fn new(manifest: &Manifest) -> Self {
        let default = |policies: &[String]| policies.first().cloned().unwrap_or_else(|| NO_POLICY.to_owned());
        let defaults = manifest.variants.iter().map(|v| (v.id.clone(), default(&v.policies))).collect();
        Self { defaults, null_of: manifest.null_of.clone() }
    }

    /// The case that a reference of the claims file names; `None` when its variant was not measured.
    ///
    /// # Errors
    /// When the policy is not `split/axes/leaf`.
    pub fn find(&self, case: &CaseRef) -> Result<Option<CaseKey>, AnalysisError> {
        let default = self.defaults.get(&case.variant);
        default.map(|default| case_key(&case.variant, case.policy.as_ref().unwrap_or(default))).transpose()
    }

    /// The case of a variant under its default policy.
    ///
    /// # Errors
    /// When the manifest's policy is not `split/axes/leaf`.
    pub fn default_of(&self, variant: &str) -> Result<Option<CaseKey>, AnalysisError> {
        self.find(&CaseRef::default_of(variant))
    }

    /// The case that `null` duplicates.
    pub fn original(&self, null: &CaseKey) -> CaseKey {
        CaseKey { variant: self.null_of.clone(), ..null.clone() }
    }

    /// Whether `policy` is the default policy of the variant.
    pub fn is_default(&self, variant: &str, policy: &str) -> bool {
        self.defaults.get(variant).is_some_and(|default| default == policy)
    }
}

/// The policy in the rows of methods that have no tree of this project.
const NO_POLICY: &str = "none/none/0";

fn case_key(variant: &str, policy: &str) -> Result<CaseKey, AnalysisError> {
    let error = || AnalysisError::Policy { variant: variant.to_owned(), policy: policy.to_owned() };
    let parts: Vec<&str> = policy.split('/').collect();
    let [split, split_axes, leaf] = parts[..] else { return Err(error()) };
    let leaf = leaf.parse().map_err(|_| error())?;
    Ok(CaseKey { variant: variant.to_owned(), split: split.to_owned(), split_axes: split_axes.to_owned(), leaf })
}

/// All ratios of a run.
///
/// # Errors
/// When a policy of the manifest or the claims is malformed.
pub fn all_ratios(
    scenes: &BTreeMap<String, Scene>,
    cases: &Cases,
    claims: &ClaimSet,
    seed: u64,
) -> Result<Vec<RatioRow>, AnalysisError> {
    let mut rows = Vec::new();
    for (name, scene) in scenes {
        for (above, below) in comparisons(scene, cases, claims)? {
            for metric in Metric::ALL {
                let ratios = compare(scene, metric, &above, &below, seed);
                rows.extend(ratios.iter().map(|ratio| row(name, metric, &above, &below, ratio)));
            }
        }
    }
    let noisy = NoisyCells::of(&rows);
    for row in rows.iter_mut().filter(|row| Metric::is_timed(&row.metric)) {
        row.noisy = u8::from(noisy.get(&row.scene, &row.workload, &row.stratum).is_some());
    }
    Ok(rows)
}

/// The ratios of the ranked volumes to the fastest one of each scene, in the cell by which it is ranked, as far as `ratios` lacks them.
///
/// # Errors
/// When a policy of the manifest is malformed.
pub fn to_fastest(
    scenes: &BTreeMap<String, Scene>,
    cases: &Cases,
    claims: &ClaimSet,
    ranking: &[Ranked],
    ratios: &[RatioRow],
    seed: u64,
) -> Result<Vec<RatioRow>, AnalysisError> {
    let Some(baseline) = claims.comparison.baselines.first() else { return Ok(Vec::new()) };
    let mut rows = Vec::new();
    for (name, scene) in scenes {
        let timed = ranked_in(name, ranking, ratios, cases, baseline);
        let (Some(((fastest, _), others)), Some(workload)) = (timed.split_first(), ranked_by(ratios, name)) else {
            continue;
        };
        let metric = if workload == PROGRAM_TIME { Metric::ProgramTime } else { Metric::Time };
        let noisy = is_noisy(ratios, name);
        for (other, _) in others {
            let is_there = ranking_ratio(ratios, cases, name, &other.variant, &fastest.variant).is_some();
            let pair = (cases.default_of(&other.variant)?, cases.default_of(&fastest.variant)?);
            let (false, (Some(above), Some(below))) = (is_there, pair) else { continue };
            let of_cell = compare(scene, metric, &above, &below, seed).into_iter();
            let of_cell = of_cell.filter(|ratio| ratio.workload == workload && ratio.stratum == ALL);
            rows.extend(
                of_cell.map(|ratio| RatioRow { noisy: noisy.into(), ..row(name, metric, &above, &below, &ratio) }),
            );
        }
    }
    Ok(rows)
}

/// The pairs of cases that are compared in a scene, each once, in order.
fn comparisons(scene: &Scene, cases: &Cases, claims: &ClaimSet) -> Result<BTreeSet<(CaseKey, CaseKey)>, AnalysisError> {
    let measured: BTreeSet<&CaseKey> =
        scene.timings.keys().chain(scene.queries.keys()).chain(scene.builds.keys()).collect();
    let mut pairs = BTreeSet::new();
    for baseline in &claims.comparison.baselines {
        if let Some(below) = cases.default_of(baseline)? {
            let others = measured.iter().filter(|above| ***above != below && above.variant != NULL_VARIANT);
            pairs.extend(others.map(|above| ((*above).clone(), below.clone())));
        }
    }
    for reading in &claims.readings {
        if let (Some(above), Some(below)) = (cases.find(&reading.subject)?, cases.find(&reading.baseline)?) {
            pairs.insert((above, below));
        }
    }
    for null in measured.into_iter().filter(|case| case.variant == NULL_VARIANT) {
        pairs.insert((null.clone(), cases.original(null)));
    }
    Ok(pairs)
}

fn row(scene: &str, metric: Metric, above: &CaseKey, below: &CaseKey, ratio: &Ratio) -> RatioRow {
    let Interval { value, low, high } = ratio.estimate.interval;
    let effect = if ratio.has_few_clusters() { Effect::Unclear } else { Effect::of(ratio.estimate.interval) };
    RatioRow {
        scene: scene.to_owned(),
        workload: ratio.workload.clone(),
        stratum: ratio.stratum.clone(),
        metric: metric.id().to_owned(),
        variant: above.variant.clone(),
        policy: above.policy(),
        baseline: below.variant.clone(),
        baseline_policy: below.policy(),
        ratio: value,
        low,
        high,
        clusters: ratio.estimate.clusters,
        effect: effect.id().to_owned(),
        noisy: 0,
    }
}
