//! A cost model of queries: T = setup + Nv·Cv + Np·Cp, and the deadlines and repayment that follow from it.
//!
//! S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", 1996, section 3, write the cost of a query as the sum of each number of operations
//! times its cost. Counts are the same on every machine and costs are not, so a reader who knows the three costs of a controller can take
//! the counts from here. Costs are fitted to the timed chunks by least squares over relative errors, none of them below 0 (Lawson and
//! Hanson 1974; here all seven sets of free costs are tried).

use super::stats::{mean, median, quantile, weighted_quantile};
use super::summary::Cell;
use super::table::{Query, Scene};
use super::{AnalysisError, grouped, ranking_workload};
use crate::record::rows::CaseKey;
use crate::record::{
    CASE_COSTS, CONTROL_WORKLOAD, CostChunkRow, DEADLINES, Kind, Manifest, NULL_VARIANT, REPAY, Stratum, write_lines,
    write_rows,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Control cycles, ms.
const CYCLES_MS: [f64; 4] = [1.0, 2.0, 4.0, 8.0];
/// Machines whose deadlines are reported, as factors on the time: the machine of the run, and controllers several times slower.
const SLOWDOWNS: [f64; 3] = [1.0, 4.0, 16.0];
/// A pivot below this fraction of its column's length is rounding error: the column depends on the others.
const SINGULAR: f64 = 1e-12;

/// Costs in ns: of the query itself, of each volume test, and of each triangle test.
type Costs = [f64; 3];

/// A line of [`CASE_COSTS`].
type CostLine = (String, String, Costs, usize, f64, f64);
/// A line of [`DEADLINES`]; the shares are those of [`CYCLES_MS`].
type DeadlineLine = (String, String, String, f64, usize, f64, [f64; 4]);
/// A line of [`REPAY`]: the scene, the case, its baseline, and the numbers.
type RepayLine = (String, [String; 2], [String; 2], f64, f64, Option<f64>);

/// One chunk of one case.
#[derive(Clone, Copy, Debug)]
struct Observed {
    chunk: u32,
    stratum: Stratum,
    volume_tests: f64,
    triangle_tests: f64,
    ns: f64,
}

/// Writes `costs.csv`, `cost_chunks.csv`, `deadlines.csv` and `repay.csv` of a run.
///
/// # Errors
/// When a file cannot be written.
pub fn write(folder: &Path, manifest: &Manifest, scenes: &BTreeMap<String, Scene>) -> Result<(), AnalysisError> {
    let is_volume = |case: &CaseKey| {
        manifest.variants.iter().any(|v| v.id == case.variant && v.kind.has_volumes() && v.id != NULL_VARIANT)
    };
    let cases: BTreeSet<&CaseKey> =
        scenes.values().flat_map(|scene| scene.timings.keys()).filter(|case| is_volume(case)).collect();
    let (mut costs, mut chunks, mut deadlines) = (Vec::new(), Vec::new(), Vec::new());
    for case in cases {
        let observed: BTreeMap<&str, Vec<Observed>> =
            scenes.iter().map(|(name, scene)| (name.as_str(), observe(scene, case))).collect();
        let all: Vec<Observed> = observed.values().flatten().copied().collect();
        let Some(fitted) = fit(&all) else { continue };
        let predictions = predictions(case, &observed, fitted);
        costs.push(cost_line(case, fitted, &predictions));
        chunks.extend(predictions);
        for (name, scene) in scenes {
            let queries = scene.queries.get(case).map_or(&[][..], Vec::as_slice);
            let rows = SLOWDOWNS.iter().filter_map(|&slowdown| deadline(name, case, queries, fitted, slowdown));
            deadlines.extend(rows);
        }
    }
    let repay: Vec<RepayLine> = scenes.iter().flat_map(|(name, scene)| repay(name, scene, manifest)).collect();
    write_lines(folder, CASE_COSTS, &costs)?;
    write_rows(folder, &chunks)?;
    write_lines(folder, DEADLINES, &deadlines)?;
    Ok(write_lines(folder, REPAY, &repay)?)
}

/// Every chunk of a case, with its mean counts and its median time.
fn observe(scene: &Scene, case: &CaseKey) -> Vec<Observed> {
    let (Some(samples), Some(queries)) = (scene.timings.get(case), scene.queries.get(case)) else { return Vec::new() };
    let timed = samples.iter().filter(|sample| !scene.chunks[&sample.item].is_control());
    let mut times = grouped(timed.map(|sample| (sample.item, sample.ns)));
    let mut observed = Vec::new();
    for (chunk, members) in grouped(queries.iter().map(|query| (query.chunk, query))) {
        let (stratum, poses) = (scene.chunks[&chunk].stratum, scene.chunks[&chunk].poses);
        let Some(ns) = times.remove(&chunk).filter(|_| members.len() == poses as usize) else { continue };
        let mean = |count: &dyn Fn(&Query) -> u64| {
            members.iter().map(|query| count(query)).sum::<u64>() as f64 / f64::from(poses)
        };
        observed.push(Observed {
            chunk,
            stratum,
            volume_tests: mean(&|query| query.volume_tests),
            triangle_tests: mean(&|query| query.triangle_tests),
            ns: median(ns),
        });
    }
    observed
}

impl Observed {
    const fn operations(&self) -> Costs {
        [1.0, self.volume_tests, self.triangle_tests]
    }
}

fn time(costs: Costs, operations: Costs) -> f64 {
    costs.iter().zip(operations).map(|(cost, count)| cost * count).sum()
}

/// The costs, none below 0, with the least sum of squared relative errors; `None` without observations.
fn fit(observed: &[Observed]) -> Option<Costs> {
    let rows: Vec<Costs> = observed.iter().map(|o| o.operations().map(|count| count / o.ns)).collect();
    let error = |costs: Costs| rows.iter().map(|row| (time(costs, *row) - 1.0).powi(2)).sum::<f64>();
    let candidates = (1_u8..8).filter_map(|free| least_squares(&rows, [0, 1, 2].map(|i| free >> i & 1 == 1)));
    let feasible = candidates.filter(|costs| costs.iter().all(|cost| *cost >= 0.0));
    feasible.min_by(|a, b| error(*a).total_cmp(&error(*b)))
}

/// The costs that solve `row · costs = 1` best, with those that are not free set to 0; `None` when the rows do not determine them.
fn least_squares(rows: &[Costs], free: [bool; 3]) -> Option<Costs> {
    let columns: Vec<usize> = (0..3).filter(|&i| free[i]).collect();
    let n = columns.len();
    // Normal equations with columns scaled to unit length, so that counts of different sizes do not matter.
    let scale: Vec<f64> = columns.iter().map(|&i| rows.iter().map(|row| row[i].powi(2)).sum::<f64>().sqrt()).collect();
    if scale.iter().any(|length| *length == 0.0 || length.is_nan()) {
        return None;
    }
    let mut matrix: Vec<Vec<f64>> = (0..n)
        .map(|r| {
            let entry = |c: usize| {
                rows.iter().map(|row| row[columns[r]] * row[columns[c]]).sum::<f64>() / (scale[r] * scale[c])
            };
            let right = rows.iter().map(|row| row[columns[r]]).sum::<f64>() / scale[r];
            (0..n).map(entry).chain([right]).collect()
        })
        .collect();
    for pivot in 0..n {
        let best = (pivot..n).max_by(|&a, &b| matrix[a][pivot].abs().total_cmp(&matrix[b][pivot].abs()))?;
        matrix.swap(pivot, best);
        if matrix[pivot][pivot].abs() < SINGULAR {
            return None;
        }
        for r in (0..n).filter(|&r| r != pivot) {
            let factor = matrix[r][pivot] / matrix[pivot][pivot];
            let above = matrix[pivot].clone();
            matrix[r].iter_mut().zip(above).for_each(|(entry, above)| *entry -= factor * above);
        }
    }
    let mut costs = [0.0; 3];
    for (r, &column) in columns.iter().enumerate() {
        costs[column] = matrix[r][n] / matrix[r][r] / scale[r];
    }
    Some(costs)
}

/// Predicts every chunk from the costs of the other scenes, or from its own scene when there is no other.
fn predictions(case: &CaseKey, observed: &BTreeMap<&str, Vec<Observed>>, fitted: Costs) -> Vec<CostChunkRow> {
    let mut rows = Vec::new();
    for (&scene, chunks) in observed {
        let others: Vec<Observed> =
            observed.iter().filter(|(name, _)| **name != scene).flat_map(|(_, chunks)| chunks).copied().collect();
        let costs = fit(&others).unwrap_or(fitted);
        rows.extend(chunks.iter().map(|chunk| CostChunkRow {
            scene: scene.to_owned(),
            variant: case.variant.clone(),
            policy: case.policy(),
            chunk: chunk.chunk,
            stratum: chunk.stratum,
            volume_tests: chunk.volume_tests,
            triangle_tests: chunk.triangle_tests,
            measured_ns: chunk.ns,
            predicted_ns: time(costs, chunk.operations()),
        }));
    }
    rows
}

fn cost_line(case: &CaseKey, costs: Costs, chunks: &[CostChunkRow]) -> CostLine {
    let mut errors: Vec<f64> = chunks.iter().map(|row| (row.predicted_ns / row.measured_ns - 1.0).abs()).collect();
    errors.sort_unstable_by(f64::total_cmp);
    let (median, p95) = (quantile(&errors, 0.5), quantile(&errors, 0.95));
    (case.variant.clone(), case.policy(), costs, chunks.len(), median, p95)
}

fn deadline(scene: &str, case: &CaseKey, queries: &[Query], costs: Costs, slowdown: f64) -> Option<DeadlineLine> {
    let of = |stratum: Stratum| queries.iter().filter(|query| query.stratum == stratum).count();
    let weight = BTreeMap::from(Stratum::ALL.map(|stratum| (stratum, 1.0 / of(stratum).max(1) as f64)));
    let mut times: Vec<(f64, f64)> = queries
        .iter()
        .map(|query| {
            let operations = [1.0, query.volume_tests as f64, query.triangle_tests as f64];
            (slowdown * time(costs, operations), weight[&query.stratum])
        })
        .collect();
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = times.iter().map(|(_, weight)| weight).sum();
    // Begins at 0.0, because the sum of no numbers is -0.0.
    let over =
        |ms: f64| times.iter().filter(|(ns, _)| *ns > ms * 1e6).fold(0.0, |sum, (_, weight)| sum + weight) / total;
    (!times.is_empty()).then(|| {
        let p999_ns = weighted_quantile(&times, 0.999);
        let (scene, variant) = (scene.to_owned(), case.variant.clone());
        (scene, variant, case.policy(), slowdown, times.len(), p999_ns, CYCLES_MS.map(over))
    })
}

/// Compares each safe volume of a scene with the volume whose trees are built fastest. Engines are left out, because they build on all
/// threads.
fn repay(name: &str, scene: &Scene, manifest: &Manifest) -> Vec<RepayLine> {
    let is_safe =
        |case: &CaseKey| manifest.variants.iter().any(|v| v.id == case.variant && v.kind == Kind::Volume && v.safe);
    let facts: Vec<(&CaseKey, f64, f64)> = scene
        .builds
        .iter()
        .filter(|(case, _)| is_safe(case))
        .filter_map(|(case, builds)| {
            let parts = grouped(builds.iter().map(|build| (build.item, build.ns)));
            let build = parts.into_values().map(median).sum::<f64>();
            Some((case, build, mean_query(scene, case)?))
        })
        .collect();
    let Some(&(baseline, least, slowest)) = facts.iter().min_by(|a, b| a.1.total_cmp(&b.1)) else { return Vec::new() };
    let names = |case: &CaseKey| [case.variant.clone(), case.policy()];
    let line = |&(case, build_ns, query_ns): &(&CaseKey, f64, f64)| {
        let queries = (query_ns < slowest).then(|| ((build_ns - least) / (slowest - query_ns)).ceil());
        (name.to_owned(), names(case), names(baseline), build_ns, query_ns, queries)
    };
    facts.iter().map(line).collect()
}

/// Mean time of a query in the scene's programs, ns; without programs, in the workload by which the scene is ranked.
fn mean_query(scene: &Scene, case: &CaseKey) -> Option<f64> {
    let programs = scene.chunks.values().filter(|chunk| chunk.is_program());
    let queries: u32 = programs.map(|chunk| chunk.poses).sum();
    if queries > 0 {
        let totals = scene.program_totals(case, None)?;
        return Some(mean(&totals) / f64::from(queries));
    }
    let workloads = scene.workloads().into_iter().filter(|workload| *workload != CONTROL_WORKLOAD);
    let cell = Cell { workload: ranking_workload(workloads)?, stratum: None };
    Some(scene.mean_time(case, cell, 0)?.interval.value)
}

#[cfg(test)]
mod tests;
