//! `program_times.csv`: the time of every case for each program up to its first collision, and its ratio to the first baseline.

use super::AnalysisError;
use super::claims::ClaimSet;
use super::ratios::Cases;
use super::summary::ALL;
use super::table::Scene;
use super::totals::over_launches;
use crate::record::ProgramTimeRow;
use crate::record::rows::CaseKey;
use std::collections::BTreeMap;

/// The rows of all scenes. For each case, the sum over all programs comes first, then each program.
///
/// # Errors
/// When the manifest's policy for the baseline is malformed.
pub fn program_times(
    scenes: &BTreeMap<String, Scene>,
    cases: &Cases,
    claims: &ClaimSet,
) -> Result<Vec<ProgramTimeRow>, AnalysisError> {
    let baseline = claims.comparison.baselines.first().map(|id| cases.default_of(id)).transpose()?.flatten();
    let mut rows = Vec::new();
    for (name, scene) in scenes {
        for case in scene.timings.keys() {
            let programs = scene.programs().map(|(file, _)| Some(file));
            for program in [None].into_iter().chain(programs) {
                let Some(totals) = scene.program_totals(case, program) else { continue };
                let parts: Vec<(f64, f64)> = totals.into_iter().map(|ns| (ns, 1.0)).collect();
                let Some(total) = over_launches(&scene.binaries.repeated(&parts)) else { continue };
                let ratio = baseline.as_ref().and_then(|baseline| scene.program_ratio(case, baseline, program));
                let chunks = || scene.chunks.values().filter(|chunk| chunk.is_program());
                let wanted = || chunks().filter(|chunk| program.is_none_or(|program| chunk.program == program));
                let ends_at = match (program, wanted().all(|chunk| chunk.ends_in_contact)) {
                    (None, _) => "-",
                    (Some(_), true) => "collision",
                    (Some(_), false) => "end",
                };
                rows.push(ProgramTimeRow {
                    scene: name.clone(),
                    program: program.unwrap_or(ALL).to_owned(),
                    ends_at: ends_at.to_owned(),
                    queries: wanted().map(|chunk| u64::from(chunk.poses)).sum(),
                    variant: case.variant.clone(),
                    split: case.split.clone(),
                    split_axes: case.split_axes.clone(),
                    leaf: case.leaf,
                    total_ns: total.interval.value,
                    total_low_ns: total.interval.low,
                    total_high_ns: total.interval.high,
                    baseline: baseline.as_ref().map_or_else(String::new, CaseKey::name),
                    ratio: ratio.map(|ratio| ratio.interval.value),
                    low: ratio.map(|ratio| ratio.interval.low),
                    high: ratio.map(|ratio| ratio.interval.high),
                });
            }
        }
    }
    Ok(rows)
}
