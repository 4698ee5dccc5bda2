//! From records to verdicts: summary, paired ratios, claims. The analysis knows only the records, so any old run can be analysed again
//! without measuring.

pub mod ablation;
pub mod audit;
pub mod claims;
pub mod compare;
pub mod cost;
pub mod factorial;
pub mod growth;
pub mod judge;
pub mod misses;
pub mod peers;
pub mod programs;
pub mod ratios;
pub mod stats;
pub mod summary;
pub mod sweep;
pub mod table;
pub mod totals;
pub mod variance;
pub mod words;

use self::misses::Misses;
use crate::record::manifest::SceneEntry;
use crate::record::{
    self, ClaimRow, Kind, Manifest, NULL_VARIANT, PROGRAM_TIME, ProgramTimeRow, RECORDED, RatioRow, RecordError,
    SummaryRow, VarianceRow, read_rows, read_rows_if_there,
};
use claims::{ClaimSet, ClaimsError};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use thiserror::Error;

pub use summary::ALL;

/// Why a run cannot be analysed, drawn or reported.
#[derive(Debug, Error)]
pub enum AnalysisError {
    /// A record cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The claims cannot be read.
    #[error(transparent)]
    Claims(#[from] ClaimsError),
    /// A pose does not fit its chunk.
    #[error(
        "poses.csv: pose {pose} of scene `{scene}` is there twice, or has another workload, pair or stratum than its chunk"
    )]
    Pose {
        /// Scene.
        scene: String,
        /// Pose.
        pose: u32,
    },
    /// A row refers to a name that no other file defines.
    #[error("{file}: scene `{scene}` has a row of {what}, which cases.csv or poses.csv do not name")]
    Unknown {
        /// The file with the row.
        file: &'static str,
        /// Scene.
        scene: String,
        /// The undefined name.
        what: String,
    },
    /// One observation occurs more than once.
    #[error("scene `{scene}`, {case}: {what} is recorded twice")]
    Twice {
        /// Scene.
        scene: String,
        /// Variant and policy.
        case: String,
        /// The repeated observation.
        what: String,
    },
    /// One launch is recorded with two binaries.
    #[error("scene `{scene}`: the rows of launch {launch} name two binaries")]
    Binary {
        /// Scene.
        scene: String,
        /// Launch.
        launch: u32,
    },
    /// An audit's records do not hold every cell.
    #[error("{file}: scene `{scene}` lacks cells of the audit; let it finish first")]
    Cells {
        /// The file.
        file: &'static str,
        /// Scene.
        scene: String,
    },
    /// The text of a policy is malformed.
    #[error("`{policy}` of variant `{variant}` is not SPLIT/AXES/LEAF")]
    Policy {
        /// Variant.
        variant: String,
        /// The malformed text.
        policy: String,
    },
    /// The drawing library reported an error.
    #[error("cannot draw {figure}: {problem}")]
    Draw {
        /// The figure.
        figure: String,
        /// The message of the library.
        problem: String,
    },
}

/// The rows that the analysis wrote, and the warnings that a reader needs first.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// `summary.csv`.
    pub summary: Vec<SummaryRow>,
    /// `program_times.csv`.
    pub program_times: Vec<ProgramTimeRow>,
    /// `ratios.csv`.
    pub ratios: Vec<RatioRow>,
    /// `variance.csv`.
    pub variance: Vec<VarianceRow>,
    /// `claims.csv`.
    pub claims: Vec<ClaimRow>,
    /// What disturbed the timings: notes of the manifest and of the null comparison; empty for a quiet run.
    pub noise: Vec<String>,
    /// Safe volumes by speed.
    pub ranking: Vec<Ranked>,
}

/// A place in the ranking.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranked {
    /// Variant id.
    pub variant: String,
    /// Its label.
    pub label: String,
    /// Kind of the method, such as volume, engine or peer.
    pub kind: Kind,
    /// Geometric mean over scenes of the ratio to the first baseline; 1 for that baseline itself. It summarises the ratios of the single
    /// scenes.
    pub ratio: f64,
    /// Number of scenes that the mean includes.
    pub scenes: usize,
}

pub use ratios::{EQUAL, STEADY};

/// Analyses the run in `folder`: writes `summary.csv`, `program_times.csv`, `ratios.csv`, `variance.csv` and `claims.csv`, and beside them
/// the claims it judged as `claims.toml`.
///
/// # Errors
/// When a record is missing, malformed or contradicts itself, or a result cannot be written.
pub fn analyze(folder: &Path, claims: &ClaimSet) -> Result<Outcome, AnalysisError> {
    let manifest = Manifest::read(folder)?;
    let scenes = table::read(folder)?;
    let cases = ratios::Cases::new(&manifest);
    let seed = manifest.request.seed;
    let misses = Misses::read(folder)?;
    let summary = summary::summarise(&scenes, &misses, seed);
    let program_times = programs::program_times(&scenes, &cases, claims)?;
    let mut ratios = ratios::all_ratios(&scenes, &cases, claims, seed)?;
    let ranking = ranking(&manifest, &ratios, &misses, claims);
    ratios.extend(ratios::to_fastest(&scenes, &cases, claims, &ranking, &ratios, seed)?);
    let variance = variance::components(&scenes, &cases, claims)?;
    let evidence = judge::Evidence {
        scenes: &scenes,
        misses: &misses,
        trees: read_rows(folder)?,
        tightness: read_rows(folder)?,
        exits: read_rows_if_there(folder)?,
        outlines: read_rows(folder)?,
        manifest: &manifest,
        cases: &cases,
        noisy: ratios::NoisyCells::of(&ratios),
    };
    let rows = judge::judge(&evidence, claims)?;
    record::write_rows(folder, &summary)?;
    record::write_rows(folder, &program_times)?;
    record::write_rows(folder, &ratios)?;
    record::write_rows(folder, &variance)?;
    record::write_rows(folder, &rows)?;
    record::write_text(&folder.join(claims::FILE), &claims.text)?;
    cost::write(folder, &manifest, &scenes)?;
    let noise = noise(&manifest, &ratios);
    Ok(Outcome { summary, program_times, ratios, variance, claims: rows, noise, ranking })
}

/// What disturbed the timings: notes of the manifest, and every scene with cells in which the null duplicate is noisy.
pub fn noise(manifest: &Manifest, ratios: &[RatioRow]) -> Vec<String> {
    manifest.noise.iter().cloned().chain(ratios::NoisyCells::of(ratios).complaints()).collect()
}

/// The workloads by which a scene may be ranked, the first that it is timed in: whole programs, then poses of one's own, then generated ones.
const RANKING_WORKLOADS: [&str; 5] = [PROGRAM_TIME, RECORDED, "program", "approach", "random"];

/// The workload by which a scene is ranked, of those that it is timed in.
pub fn ranking_workload<'a>(workloads: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let place = |name: &str| RANKING_WORKLOADS.iter().position(|known| *known == name);
    workloads.min_by_key(|name| (place(name).unwrap_or(RANKING_WORKLOADS.len()), *name))
}

/// Whether a row is a ratio of query times, single or of whole programs.
pub fn is_query_time(row: &RatioRow) -> bool {
    row.metric == PROGRAM_TIME || (row.metric == "time" && row.workload != record::CONTROL_WORKLOAD)
}

/// The workload by which a scene is ranked: whole programs where it has them, otherwise the first workload of single queries. `None` where
/// nothing was timed.
pub fn ranked_by<'a>(ratios: &'a [RatioRow], scene: &str) -> Option<&'a str> {
    let rows = ratios.iter().filter(|row| row.scene == scene && is_query_time(row));
    ranking_workload(rows.map(|row| row.workload.as_str()))
}

/// The ratio of two variants under their default policies in the workload by which a scene is ranked.
pub fn ranking_ratio<'a>(
    ratios: &'a [RatioRow],
    cases: &ratios::Cases,
    scene: &str,
    variant: &str,
    baseline: &str,
) -> Option<&'a RatioRow> {
    let workload = ranked_by(ratios, scene)?;
    ratios.iter().find(|row| {
        row.scene == scene
            && row.workload == workload
            && row.stratum == ALL
            && is_query_time(row)
            && row.variant == variant
            && row.baseline == baseline
            && cases.is_default(variant, &row.policy)
            && cases.is_default(baseline, &row.baseline_policy)
    })
}

/// Whether the null duplicate is noisy in the cell by which a scene is ranked, so that nothing is decided about speed there.
pub fn is_noisy(ratios: &[RatioRow], scene: &str) -> bool {
    let Some(workload) = ranked_by(ratios, scene) else { return false };
    let of_cell = |row: &&RatioRow| row.scene == scene && row.stratum == ALL && row.workload == workload;
    ratios.iter().filter(of_cell).any(|row| row.noisy == 1 && is_query_time(row))
}

/// The volumes of a ranking with a time in a scene, fastest first, each with its ratio to the first baseline; that baseline itself has none.
pub fn ranked_in<'a>(
    scene: &str,
    ranking: &'a [Ranked],
    ratios: &'a [RatioRow],
    cases: &ratios::Cases,
    baseline: &str,
) -> Vec<(&'a Ranked, Option<&'a RatioRow>)> {
    let volumes = ranking.iter().filter(|entry| entry.kind == Kind::Volume);
    let timed = volumes.filter_map(|entry| {
        let row = ranking_ratio(ratios, cases, scene, &entry.variant, baseline);
        (row.is_some() || entry.variant == baseline).then_some((entry, row))
    });
    let mut timed: Vec<(&Ranked, Option<&RatioRow>)> = timed.collect();
    let ratio = |row: Option<&RatioRow>| row.map_or(1.0, |row| row.ratio);
    timed.sort_by(|a, b| ratio(a.1).total_cmp(&ratio(b.1)));
    timed
}

/// Ranks the variants by speed, each scene by its own workload (see [`ranked_by`]), each variant under its default policy. Safe volumes come
/// first, then engines, peers and controls. Left out are unsafe variants, and variants declared safe that missed a contact: a method can
/// look fast because it misses collisions. Empty when nothing was timed beside the baseline.
pub fn ranking(manifest: &Manifest, ratios: &[RatioRow], misses: &Misses, claims: &ClaimSet) -> Vec<Ranked> {
    let cases = ratios::Cases::new(manifest);
    let Some(baseline) = claims.comparison.baselines.first() else { return Vec::new() };
    let mut ranking = Vec::new();
    for entry in &manifest.variants {
        if entry.id == NULL_VARIANT || (entry.kind.is_ours() && (!entry.safe || misses.any_of(&entry.id))) {
            continue;
        }
        let in_scene = |scene: &SceneEntry| ranking_ratio(ratios, &cases, &scene.name, &entry.id, baseline);
        let logs: Vec<f64> = manifest.scenes.iter().filter_map(in_scene).map(|row| row.ratio.ln()).collect();
        let (ratio, scenes) = if entry.id == *baseline {
            (1.0, manifest.scenes.len())
        } else if logs.is_empty() {
            continue;
        } else {
            (stats::mean(&logs).exp(), logs.len())
        };
        let (variant, label) = (entry.id.clone(), entry.label.clone());
        ranking.push(Ranked { variant, label, kind: entry.kind, ratio, scenes });
    }
    if ranking.iter().all(|entry| entry.variant == *baseline) {
        return Vec::new();
    }
    ranking.sort_by(|a, b| (a.kind != Kind::Volume).cmp(&(b.kind != Kind::Volume)).then(a.ratio.total_cmp(&b.ratio)));
    ranking
}

/// The values of each key, in the order of the pairs.
pub fn grouped<K: Ord, V>(pairs: impl IntoIterator<Item = (K, V)>) -> BTreeMap<K, Vec<V>> {
    let mut groups: BTreeMap<K, Vec<V>> = BTreeMap::new();
    for (key, value) in pairs {
        groups.entry(key).or_default().push(value);
    }
    groups
}

/// Values, each once, in the order in which they first occur.
pub fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut kept: Vec<T> = Vec::new();
    for value in values {
        if !kept.contains(&value) {
            kept.push(value);
        }
    }
    kept
}

/// A number of things, such as `1 launch` or `3 launches`, by the name of several.
pub fn counted(n: u64, several: &str) -> String {
    let one = several.strip_suffix("es").filter(|one| one.ends_with("ch")).or_else(|| several.strip_suffix('s'));
    format!("{n} {}", if n == 1 { one.unwrap_or(several) } else { several })
}

#[cfg(test)]
mod tests;
