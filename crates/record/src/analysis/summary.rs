//! One row per scene, workload, stratum and case: times with interval and quantiles, counts, misses.

use super::misses::Misses;
use super::table::{Chunk, Counter, Query, Sample, Scene, Single, chunk_times};
use super::{grouped, stats};
use crate::record::rows::CaseKey;
use crate::record::{Cache, Stratum, SummaryRow};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Name of all strata of a workload together, and of all programs of a scene together.
pub const ALL: &str = "all";

/// The poses of one workload: all of them, or those of one stratum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cell<'a> {
    /// The workload.
    pub workload: &'a str,
    /// The stratum; `None` for all.
    pub stratum: Option<Stratum>,
}

impl Cell<'_> {
    /// Whether a chunk belongs to the cell.
    pub fn has(&self, chunk: &Chunk) -> bool {
        chunk.workload == self.workload && self.stratum.is_none_or(|stratum| stratum == chunk.stratum)
    }

    /// Name of the cell's stratum in files.
    pub fn stratum_name(&self) -> &'static str {
        self.stratum.map_or(ALL, Stratum::id)
    }
}

impl fmt::Display for Cell<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.workload, self.stratum_name())
    }
}

impl Scene {
    /// The cells of the scene: each workload as a whole, then its strata from nearest to farthest.
    pub fn cells(&self) -> Vec<Cell<'_>> {
        let mut cells = Vec::new();
        for workload in self.workloads() {
            let strata = [None].into_iter().chain(Stratum::ALL.map(Some));
            let cell = |stratum| Cell { workload, stratum };
            cells.extend(strata.map(cell).filter(|cell| self.chunks.values().any(|chunk| cell.has(chunk))));
        }
        cells
    }
}

/// The summary of every case of every scene.
pub fn summarise(scenes: &BTreeMap<String, Scene>, misses: &Misses, seed: u64) -> Vec<SummaryRow> {
    let mut rows = Vec::new();
    for (name, scene) in scenes {
        let cases: BTreeSet<&CaseKey> = scene.timings.keys().chain(scene.queries.keys()).collect();
        for cell in scene.cells() {
            rows.extend(cases.iter().filter_map(|case| summarise_case(name, scene, case, cell, misses, seed)));
        }
    }
    rows
}

/// The row of a case in a cell; `None` when the case was neither timed nor counted there.
fn summarise_case(
    name: &str,
    scene: &Scene,
    case: &CaseKey,
    cell: Cell<'_>,
    misses: &Misses,
    seed: u64,
) -> Option<SummaryRow> {
    let is_in = |chunk: u32| scene.chunks.get(&chunk).is_some_and(|chunk| cell.has(chunk));
    let samples = scene.timings.get(case).map_or(&[][..], Vec::as_slice);
    let samples: Vec<Sample> = samples.iter().filter(|sample| is_in(sample.item)).copied().collect();
    let queries = scene.queries.get(case).map_or(&[][..], Vec::as_slice);
    let queries: Vec<Query> = queries.iter().filter(|query| is_in(query.chunk)).copied().collect();
    if samples.is_empty() && queries.is_empty() {
        return None;
    }
    let estimate = scene.mean_time(case, cell, seed);
    let (mean, low, high) =
        estimate.map_or((f64::NAN, f64::NAN, f64::NAN), |e| (e.interval.value, e.interval.low, e.interval.high));
    let times = weighted_times(scene, cell, &samples);
    let chunks: BTreeSet<u32> = samples.iter().map(|sample| sample.item).collect();
    let single = single_times(scene.singles.get(case).map_or(&[][..], Vec::as_slice), is_in);
    let percentile = |q: f64| (!single.is_empty()).then(|| stats::quantile(&single, q));
    let weights = scene.weights(cell, queries.iter().map(|query| query.chunk));
    let tally = misses.in_workload(name, case, cell.workload);
    let (miss_rate_low, miss_rate_high) = tally.interval();
    Some(SummaryRow {
        scene: name.to_owned(),
        workload: cell.workload.to_owned(),
        stratum: cell.stratum_name().to_owned(),
        variant: case.variant.clone(),
        split: case.split.clone(),
        split_axes: case.split_axes.clone(),
        leaf: case.leaf,
        poses: chunks.iter().map(|chunk| u64::from(scene.chunks[chunk].poses)).sum(),
        clusters: estimate.map_or(0, |estimate| estimate.clusters),
        mean_ns: mean,
        // Expanded to both sides alike, an interval of few and unequal chunks may end below all that was seen.
        mean_low_ns: times.first().map_or(low, |&(least, _)| low.max(least.min(mean))),
        mean_high_ns: high,
        single_poses: single.len() as u64,
        query_p50_ns: percentile(0.5),
        query_p95_ns: percentile(0.95),
        query_p99_ns: percentile(0.99),
        query_max_ns: percentile(1.0),
        chunk_median_ns: stats::weighted_quantile(&times, 0.5),
        chunk_p95_ns: stats::weighted_quantile(&times, 0.95),
        chunk_max_ns: times.last().map_or(f64::NAN, |&(ns, _)| ns),
        volume_tests: mean_count(&weights, &queries, Counter::Volume),
        triangle_tests: mean_count(&weights, &queries, Counter::Triangle),
        contacts: tally.contacts(),
        missed: tally.missed(),
        miss_rate_low,
        miss_rate_high,
    })
}

/// Sorted chunk times, ns per query, each with the number of poses of its chunk, weighted as in sums. The time of a chunk is the mean over launches of the
/// median over blocks.
fn weighted_times(scene: &Scene, cell: Cell<'_>, samples: &[Sample]) -> Vec<(f64, f64)> {
    let of_chunk = grouped(chunk_times(samples).into_iter().map(|((_, chunk), ns)| (chunk, ns)));
    let weights = scene.weights(cell, of_chunk.keys().copied());
    let poses = |chunk: &u32| weights[chunk] * f64::from(scene.chunks[chunk].poses);
    let mut times: Vec<(f64, f64)> = of_chunk.iter().map(|(chunk, ns)| (stats::mean(ns), poses(chunk))).collect();
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    times
}

/// The median reading of each pose over a single warm query, ns, sorted.
fn single_times(singles: &[Single], is_in: impl Fn(u32) -> bool) -> Vec<f64> {
    let wanted = |single: &&Single| single.cache == Cache::Warm && is_in(single.chunk);
    let of_pose = grouped(singles.iter().filter(wanted).map(|single| (single.pose, single.ns)));
    let mut times: Vec<f64> = of_pose.into_values().map(stats::median).collect();
    times.sort_unstable_by(f64::total_cmp);
    times
}

/// The mean count, by the weights of the chunks; NaN when nothing was counted.
fn mean_count(weights: &BTreeMap<u32, f64>, queries: &[Query], counter: Counter) -> f64 {
    let (sum, total) = queries.iter().fold((0.0, 0.0), |(sum, total), query| {
        let weight = weights[&query.chunk];
        (sum + weight * query.count(counter) as f64, total + weight)
    });
    sum / total
}
