//! Analyses a sweep: the mean of every metric at every value of the swept quantity, with bootstrap intervals over the groups of lines. Rates of
//! misses have the intervals of a run's, with groups of lines as lines.

use super::growth::analyze_growth;
use super::stats::{Interval, bootstrap_mean, clustered_rate, median};
use super::{AnalysisError, grouped};
use crate::record::rows::CaseKey;
use crate::record::{
    BuildRow, CaseRow, CountRow, FactorRow, Manifest, Row, Stratum, SweepSummaryRow, TimingRow, has_rows, read_rows,
    read_rows_if_there, write_rows,
};
use std::collections::BTreeMap;
use std::path::Path;

/// Identifies a mean within one metric: value of the swept quantity (as bits, because all values are exact), case, and stratum.
type Key = (u64, CaseKey, Stratum);

/// Analyses the sweep in `folder` and writes `sweep_summary.csv`; for the sweep of mesh size it writes `sweep_growth.csv` as well.
///
/// # Errors
/// When a record is missing or malformed.
pub fn analyze_sweep(folder: &Path) -> Result<Vec<SweepSummaryRow>, AnalysisError> {
    let seed = Manifest::read(folder)?.request.seed;
    let swept = Swept::read(folder)?;
    // For each metric and key the value of each group, which is a ratio of two sums.
    let mut values: BTreeMap<(usize, Key), Vec<f64>> = BTreeMap::new();
    let mut contacts: BTreeMap<Key, Vec<(u64, u64)>> = BTreeMap::new();
    let mut order: Vec<Key> = Vec::new();
    for row in &swept.counts {
        let key = swept.key(row, &row.case)?;
        if !order.contains(&key) {
            order.push(key.clone());
        }
        let queries = row.queries as f64;
        let mut add = |metric: usize, value: f64| values.entry((metric, key.clone())).or_default().push(value);
        add(0, row.volume_tests as f64 / queries);
        add(1, row.triangle_tests as f64 / queries);
        if row.touching > 0 {
            contacts.entry(key.clone()).or_default().push((row.missed, row.touching));
        }
        let reported = row.touching - row.missed;
        if row.queries > row.poses && reported > 0 {
            add(4, row.delay_mm / reported as f64);
        }
    }
    for (key, groups) in swept.times()? {
        values.insert((2, key), groups);
    }
    let mut found = Vec::new();
    for key in &order {
        for (metric, name) in METRICS.iter().enumerate() {
            let mean = match metric {
                MISS_RATE => contacts.get(key).map(|groups| rate_of(groups)),
                _ => values.get(&(metric, key.clone())).map(|groups| mean_of(groups, seed, name)),
            };
            let Some(Interval { value, low, high }) = mean else { continue };
            let (x, case, stratum) = key;
            found.push(SweepSummaryRow {
                sweep: swept.sweep.clone(),
                x: f64::from_bits(*x),
                variant: case.variant.clone(),
                split: case.split.clone(),
                split_axes: case.split_axes.clone(),
                leaf: case.leaf,
                stratum: *stratum,
                metric: (*name).to_owned(),
                value,
                low,
                high,
            });
        }
    }
    write_rows(folder, &found)?;
    if has_rows::<BuildRow>(folder) {
        analyze_growth(folder, &swept, seed)?;
    }
    Ok(found)
}

/// The metrics, as records name them.
pub const METRICS: [&str; 5] = ["volume-tests", "triangle-tests", "time", "miss-rate", "delay"];
/// Place of the rate of missed contacts among the metrics.
const MISS_RATE: usize = 3;

/// The mean over groups. The lower end is at least the least value that was seen: counts and times are positive, and an interval expanded to both sides alike may go below all of them.
fn mean_of(groups: &[f64], seed: u64, metric: &str) -> Interval {
    let mean = bootstrap_mean(groups, seed, &format!("sweep {metric}"));
    let least = groups.iter().copied().fold(f64::INFINITY, f64::min);
    Interval { low: if mean.low < least { least } else { mean.low }, ..mean }
}

/// The rate of missed contacts over groups, each given as (missed, contacts).
fn rate_of(groups: &[(u64, u64)]) -> Interval {
    let (missed, contacts) = groups.iter().fold((0, 0), |(m, n), (x, y)| (m + x, n + y));
    let (low, high) = clustered_rate(groups);
    Interval { value: missed as f64 / contacts as f64, low, high }
}

/// The raw records of a sweep.
pub(super) struct Swept {
    /// Name of the sweep, which is also the name of its factor.
    pub sweep: String,
    pub counts: Vec<CountRow>,
    timings: Vec<TimingRow>,
    /// Value of the swept quantity, by scene.
    x: BTreeMap<String, f64>,
    cases: BTreeMap<String, CaseKey>,
}

impl Swept {
    fn read(folder: &Path) -> Result<Self, AnalysisError> {
        let factors: Vec<FactorRow> = read_rows(folder)?;
        let sweep = factors.first().map_or_else(String::new, |row| row.factor.clone());
        let of_sweep = factors.into_iter().filter(|row| row.factor == sweep);
        let cases: Vec<CaseRow> = read_rows(folder)?;
        Ok(Self {
            x: of_sweep.map(|row| (row.scene, row.level.parse().unwrap_or(f64::NAN))).collect(),
            sweep,
            counts: read_rows(folder)?,
            timings: read_rows_if_there(folder)?,
            cases: cases.into_iter().map(|row| (row.case.clone(), row.case())).collect(),
        })
    }

    /// Value of the swept quantity in a scene, and the case with the given name.
    pub fn place(&self, file: &'static str, scene: &str, case: &str) -> Result<(f64, CaseKey), AnalysisError> {
        let (x, key) = (self.x.get(scene), self.cases.get(case));
        x.copied().zip(key.cloned()).ok_or_else(|| AnalysisError::Unknown {
            file,
            scene: scene.to_owned(),
            what: format!("case `{case}`"),
        })
    }

    fn key(&self, row: &CountRow, case: &str) -> Result<Key, AnalysisError> {
        let (x, case) = self.place(CountRow::FILE, &row.scene, case)?;
        Ok((x.to_bits(), case, row.stratum.unwrap_or(Stratum::Far)))
    }

    /// The time of one query in each sample, ns, with the counts of its chunk.
    pub fn samples(&self) -> Result<Vec<(&CountRow, &TimingRow, f64)>, AnalysisError> {
        let counts: BTreeMap<(&str, u32), &CountRow> =
            self.counts.iter().map(|row| ((row.scene.as_str(), row.chunk), row)).collect();
        let sample = |timing| {
            let row: &TimingRow = timing;
            let counted = counts.get(&(row.scene.as_str(), row.chunk)).ok_or_else(|| AnalysisError::Unknown {
                file: TimingRow::FILE,
                scene: row.scene.clone(),
                what: format!("chunk {}", row.chunk),
            })?;
            Ok((*counted, row, row.ns as f64 / (f64::from(row.passes) * counted.poses as f64)))
        };
        self.timings.iter().map(sample).collect()
    }

    /// The time of one query in each group, ns: the median over blocks.
    fn times(&self) -> Result<BTreeMap<Key, Vec<f64>>, AnalysisError> {
        let samples = self.samples()?.into_iter();
        let keyed = samples.map(|(counted, timing, ns)| Ok(((self.key(counted, &timing.case)?, timing.chunk), ns)));
        let blocks = grouped(keyed.collect::<Result<Vec<_>, AnalysisError>>()?);
        Ok(grouped(blocks.into_iter().map(|((key, _), ns)| (key, median(ns)))))
    }
}

#[cfg(test)]
mod tests;
