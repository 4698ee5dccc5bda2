//! One row per scene, stratum and case: times with interval and quantiles, counts, misses.

use super::misses::Misses;
use super::stats::{self, Interval};
use super::table::{Counter, Query, Sample, Scene, chunk_times};
use crate::record::rows::CaseKey;
use crate::record::{Stratum, SummaryRow};
use std::collections::{BTreeMap, BTreeSet};

/// The name of the four strata together.
pub const ALL: &str = "all";

/// The summary of every case of every scene.
#[must_use]
pub fn summarise(scenes: &BTreeMap<String, Scene>, misses: &Misses, seed: u64) -> Vec<SummaryRow> {
    let mut rows = Vec::new();
    for (name, scene) in scenes {
        let cases: BTreeSet<&CaseKey> = scene.timings.keys().chain(scene.queries.keys()).collect();
        for case in cases {
            summarise_case(name, scene, case, misses, seed, &mut rows);
        }
    }
    rows
}

fn summarise_case(name: &str, scene: &Scene, case: &CaseKey, misses: &Misses, seed: u64, rows: &mut Vec<SummaryRow>) {
    let samples = scene.timings.get(case).map_or(&[][..], Vec::as_slice);
    let queries = scene.queries.get(case).map_or(&[][..], Vec::as_slice);
    let strata: Vec<Stratum> = Stratum::ALL
        .into_iter()
        .filter(|s| samples.iter().any(|x| scene.chunks[&x.item].0 == *s) || queries.iter().any(|q| q.stratum == *s))
        .collect();
    let means = scene.times(case).map(|times| {
        let (each, all) = stats::bootstrap(&times.groups, times.launches, seed, &format!("summary {name}"));
        let each: BTreeMap<_, _> = times.names.into_iter().flatten().zip(each).collect();
        (each, all)
    });
    let (colliding, missed) = misses.of(name, case).map_or((0, 0), |m| (m.colliding, m.missed));
    let (miss_rate_low, miss_rate_high) = stats::miss_rate(missed, colliding);
    let unknown = Interval::exact(f64::NAN);
    for stratum in std::iter::once(None).chain(strata.iter().copied().map(Some)) {
        let wanted: &[Stratum] = stratum.as_ref().map_or(&strata, std::slice::from_ref);
        let mean = means.as_ref().map_or(unknown, |(each, all)| match stratum {
            None => *all,
            Some(stratum) => each.get(&stratum).copied().unwrap_or(unknown),
        });
        let times = weighted_times(scene, samples, wanted);
        let chunks: BTreeSet<u32> =
            samples.iter().map(|s| s.item).filter(|chunk| wanted.contains(&scene.chunks[chunk].0)).collect();
        rows.push(SummaryRow {
            scene: name.to_owned(),
            stratum: stratum.map_or(ALL, Stratum::id).to_owned(),
            variant: case.variant.clone(),
            split: case.split.clone(),
            axes: case.axes.clone(),
            leaf: case.leaf,
            poses: chunks.iter().map(|chunk| u64::from(scene.chunks[chunk].1)).sum(),
            mean_ns: mean.value,
            // Expanded to both sides alike, an interval of few and unequal chunks may end below all that was seen, even below nothing.
            mean_low_ns: times.first().map_or(mean.low, |&(least, _)| mean.low.max(least)),
            mean_high_ns: mean.high,
            median_ns: stats::weighted_quantile(&times, 0.5),
            p95_ns: stats::weighted_quantile(&times, 0.95),
            p99_ns: stats::weighted_quantile(&times, 0.99),
            max_ns: times.last().map_or(f64::NAN, |&(ns, _)| ns),
            volume_tests: mean_count(queries, wanted, Counter::Volume),
            triangle_tests: mean_count(queries, wanted, Counter::Triangle),
            colliding,
            missed,
            miss_rate_low,
            miss_rate_high,
        });
    }
}

/// The chunk times of some strata, ns per query, sorted, each with a weight that makes the strata count the same. Of each launch and chunk the
/// median over blocks, as in [`Scene::times`].
fn weighted_times(scene: &Scene, samples: &[Sample], wanted: &[Stratum]) -> Vec<(f64, f64)> {
    let chunk_times = chunk_times(samples);
    let mut times = Vec::new();
    for stratum in wanted {
        let of_it: Vec<f64> =
            chunk_times.iter().filter(|((_, chunk), _)| scene.chunks[chunk].0 == *stratum).map(|(_, ns)| *ns).collect();
        times.extend(of_it.iter().map(|&ns| (ns, 1.0 / of_it.len() as f64)));
    }
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    times
}

/// The mean over strata of the mean count in each; NaN when nothing was counted.
fn mean_count(queries: &[Query], wanted: &[Stratum], counter: Counter) -> f64 {
    let means: Vec<f64> = wanted
        .iter()
        .filter_map(|stratum| {
            let counts = queries.iter().filter(|q| q.stratum == *stratum).map(|q| q.count(counter));
            let (sum, n) = counts.fold((0, 0_u64), |(sum, n), count| (sum + count, n + 1));
            (n > 0).then(|| sum as f64 / n as f64)
        })
        .collect();
    means.iter().sum::<f64>() / means.len() as f64
}
