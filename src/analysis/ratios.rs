//! Paired ratios: every case against each baseline, the two cases of each reading, and the null against its original.

use super::AnalysisError;
use super::claims::{CaseRef, ClaimSet};
use super::stats::{self, Interval};
use super::summary::ALL;
use super::table::{Counter, Scene, Strata};
use crate::record::rows::CaseKey;
use crate::record::{Manifest, NULL_VARIANT, RatioRow, Stratum};
use std::collections::{BTreeMap, BTreeSet};

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Metric {
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
    pub const ALL: [Self; 4] = [Self::Time, Self::VolumeTests, Self::TriangleTests, Self::Build];

    /// The name in files.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::VolumeTests => "volume-tests",
            Self::TriangleTests => "triangle-tests",
            Self::Build => "build",
        }
    }

    fn observe(self, scene: &Scene, above: &CaseKey, below: &CaseKey) -> Option<Strata> {
        match self {
            Self::Time => scene.time_ratios(above, below),
            Self::VolumeTests => scene.count_ratios(above, below, Counter::Volume),
            Self::TriangleTests => scene.count_ratios(above, below, Counter::Triangle),
            Self::Build => scene.build_ratios(above, below),
        }
    }
}

/// A ratio in one stratum, with what stands behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// The stratum; `None` for all together, or where there are none.
    pub stratum: Option<Stratum>,
    /// Geometric mean with its interval.
    pub interval: Interval,
    /// Pairs.
    pub pairs: u64,
    /// Clusters that were resampled.
    pub clusters: usize,
}

/// The ratio of two cases over all strata and in each; empty when nothing pairs.
#[must_use]
pub fn compare(name: &str, scene: &Scene, metric: Metric, above: &CaseKey, below: &CaseKey, seed: u64) -> Vec<Ratio> {
    let Some(strata) = metric.observe(scene, above, below) else { return Vec::new() };
    let purpose = format!("ratio {} {name}", metric.id());
    let (each, all) = stats::bootstrap(&strata.groups, strata.launches, seed, &purpose);
    let sum = |f: &dyn Fn(&stats::Group) -> u64| strata.groups.iter().map(f).sum::<u64>();
    let all = Ratio {
        stratum: None,
        interval: all.map(f64::exp),
        pairs: sum(&stats::Group::observations),
        clusters: sum(&|group| group.clusters() as u64) as usize,
    };
    let each = strata.names.iter().zip(&strata.groups).zip(each).filter_map(|((name, group), interval)| {
        name.map(|stratum| Ratio {
            stratum: Some(stratum),
            interval: interval.map(f64::exp),
            pairs: group.observations(),
            clusters: group.clusters(),
        })
    });
    std::iter::once(all).chain(each).collect()
}

/// Finds cases by name.
#[derive(Debug)]
pub struct Cases {
    defaults: BTreeMap<String, String>,
    null_of: String,
}

impl Cases {
    /// From the manifest's default policies.
    #[must_use]
    pub fn new(manifest: &Manifest) -> Self {
        let default = |policies: &[String]| policies.first().cloned().unwrap_or_else(|| NO_POLICY.to_owned());
        let defaults = manifest.variants.iter().map(|v| (v.id.clone(), default(&v.policies))).collect();
        Self { defaults, null_of: manifest.null_of.clone() }
    }

    /// The case that a reference names; `None` when its variant was not measured.
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
        self.find(&CaseRef { variant: variant.to_owned(), policy: None })
    }

    /// The case that `null` duplicates.
    #[must_use]
    pub fn original(&self, null: &CaseKey) -> CaseKey {
        CaseKey { variant: self.null_of.clone(), ..null.clone() }
    }

    /// Whether the case is its variant under the default policy.
    #[must_use]
    pub fn is_default(&self, variant: &str, policy: &str) -> bool {
        self.defaults.get(variant).is_some_and(|default| default == policy)
    }
}

/// The policy of methods without a tree of ours.
const NO_POLICY: &str = "none/none/0";

fn case_key(variant: &str, policy: &str) -> Result<CaseKey, AnalysisError> {
    let error = || AnalysisError::Policy { variant: variant.to_owned(), policy: policy.to_owned() };
    let parts: Vec<&str> = policy.split('/').collect();
    let [split, axes, leaf] = parts[..] else { return Err(error()) };
    let leaf = leaf.parse().map_err(|_| error())?;
    Ok(CaseKey { variant: variant.to_owned(), split: split.to_owned(), axes: axes.to_owned(), leaf })
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
                for ratio in compare(name, scene, metric, &above, &below, seed) {
                    rows.push(row(name, metric, &above, &below, &ratio));
                }
            }
        }
    }
    Ok(rows)
}

/// The pairs of cases compared in a scene, each once, in order.
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
    let together = if metric == Metric::Build { "-" } else { ALL };
    RatioRow {
        scene: scene.to_owned(),
        stratum: ratio.stratum.map_or(together, Stratum::id).to_owned(),
        metric: metric.id().to_owned(),
        variant: above.variant.clone(),
        policy: above.policy(),
        baseline: below.variant.clone(),
        baseline_policy: below.policy(),
        ratio: ratio.interval.value,
        low: ratio.interval.low,
        high: ratio.interval.high,
        pairs: ratio.pairs,
    }
}
