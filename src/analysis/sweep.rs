//! What a sweep found: the mean of every metric at every value of its quantity, with bootstrap intervals over the groups
//! of lines.

use super::AnalysisError;
use super::growth::analyze_growth;
use super::stats::{bootstrap_mean, quantile};
use crate::record::rows::CaseKey;
use crate::record::{
    Manifest, Row, Stratum, SweepBuildRow, SweepRow, SweepSummaryRow, SweepTimingRow, read_rows, read_rows_if_there,
    write_rows,
};
use std::collections::BTreeMap;
use std::path::Path;

/// What identifies a mean, but for the metric: value of the quantity (as bits: all are exact), case, stratum.
type Key = (u64, CaseKey, Stratum);

/// Analyses the sweep in `folder` and writes `sweep_summary.csv`, of the sweep of the size `sweep_growth.csv` too.
///
/// # Errors
/// When a record is missing or malformed.
pub fn analyze_sweep(folder: &Path) -> Result<Vec<SweepSummaryRow>, AnalysisError> {
    let seed = Manifest::read(folder)?.request.seed;
    let rows: Vec<SweepRow> = read_rows(folder)?;
    let timings: Vec<SweepTimingRow> = read_rows_if_there(folder)?;
    let sweep = rows.first().map_or_else(String::new, |row| row.sweep.clone());
    // For each metric and key the value of each group, which is a ratio of two sums.
    let mut values: BTreeMap<(usize, Key), Vec<f64>> = BTreeMap::new();
    let mut order: Vec<Key> = Vec::new();
    for row in &rows {
        let key = (row.x.to_bits(), row.case(), row.stratum);
        if !order.contains(&key) {
            order.push(key.clone());
        }
        let queries = row.queries as f64;
        let mut add = |metric: usize, value: f64| values.entry((metric, key.clone())).or_default().push(value);
        add(0, row.volume_tests as f64 / queries);
        add(1, row.triangle_tests as f64 / queries);
        if row.touching > 0 {
            add(3, row.missed as f64 / row.touching as f64);
        }
        let reported = row.touching - row.missed;
        if row.queries > u64::from(row.poses) && reported > 0 {
            add(4, row.delay_mm / reported as f64);
        }
    }
    for (key, groups) in times(&timings) {
        values.insert((2, key), groups);
    }
    let mut found = Vec::new();
    for key in &order {
        for (metric, name) in METRICS.iter().enumerate() {
            let Some(groups) = values.get(&(metric, key.clone())) else { continue };
            let mean = bootstrap_mean(groups, seed, &format!("sweep {name}"));
            let least = groups.iter().copied().fold(f64::INFINITY, f64::min);
            let (x, case, stratum) = key;
            found.push(SweepSummaryRow {
                sweep: sweep.clone(),
                x: f64::from_bits(*x),
                variant: case.variant.clone(),
                split: case.split.clone(),
                split_axes: case.split_axes.clone(),
                leaf: case.leaf,
                stratum: *stratum,
                metric: (*name).to_owned(),
                value: mean.value,
                // What is counted and timed is positive; expanded to both sides alike, an interval may end below all that was seen.
                low: mean.low.max(least),
                high: mean.high,
            });
        }
    }
    write_rows(folder, &found)?;
    if folder.join(SweepBuildRow::FILE).exists() {
        analyze_growth(folder, seed)?;
    }
    Ok(found)
}

/// The metrics, as records name them.
pub const METRICS: [&str; 5] = ["volume-tests", "triangle-tests", "time", "miss-rate", "delay"];

/// The time of a query, ns, of each group: the median over blocks.
fn times(timings: &[SweepTimingRow]) -> BTreeMap<Key, Vec<f64>> {
    let mut blocks: BTreeMap<(Key, u32), Vec<f64>> = BTreeMap::new();
    for row in timings {
        let ns = row.ns as f64 / (f64::from(row.passes) * f64::from(row.poses));
        blocks.entry(((row.x.to_bits(), row.case(), row.stratum), row.group)).or_default().push(ns);
    }
    let mut times: BTreeMap<Key, Vec<f64>> = BTreeMap::new();
    for ((key, _), mut ns) in blocks {
        ns.sort_unstable_by(f64::total_cmp);
        times.entry(key).or_default().push(quantile(&ns, 0.5));
    }
    times
}

#[cfg(test)]
mod tests;
