//! From records to verdicts: summary, paired ratios, claims. Knows only the records, so that any old run can be analysed
//! again without measuring.

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
pub mod ratios;
pub mod stats;
pub mod summary;
pub mod sweep;
pub mod table;

use self::misses::Misses;
use crate::record::{
    self, ClaimRow, Kind, Manifest, NULL_VARIANT, RatioRow, RecordError, SummaryRow, VerificationRow, read_rows,
    read_rows_if_there,
};
use claims::{ClaimSet, ClaimsError};
use serde::Serialize;
use std::path::Path;
use thiserror::Error;

pub use summary::ALL;

/// Why a run cannot be analysed.
#[derive(Debug, Error)]
pub enum AnalysisError {
    /// A record cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The claims cannot be read.
    #[error(transparent)]
    Claims(#[from] ClaimsError),
    /// The rows of one chunk disagree.
    #[error(
        "timings.csv: chunk {chunk} of scene `{scene}` has no poses, or not the same stratum and poses in all rows"
    )]
    Chunk {
        /// Scene.
        scene: String,
        /// Chunk.
        chunk: u32,
    },
    /// One observation is there more than once.
    #[error("scene `{scene}`, {case}: {what} is recorded twice")]
    Twice {
        /// Scene.
        scene: String,
        /// Variant and policy.
        case: String,
        /// Which observation.
        what: String,
    },
    /// An audit's records do not hold every cell.
    #[error("{file}: scene `{scene}` lacks cells of the audit; let it finish first")]
    Cells {
        /// The file.
        file: &'static str,
        /// Scene.
        scene: String,
    },
    /// A policy is not one.
    #[error("`{policy}` of variant `{variant}` is not SPLIT/AXES/LEAF")]
    Policy {
        /// Variant.
        variant: String,
        /// The text.
        policy: String,
    },
}

/// What an analysis found: the rows it wrote, and what a reader must know first.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// `summary.csv`.
    pub summary: Vec<SummaryRow>,
    /// `ratios.csv`.
    pub ratios: Vec<RatioRow>,
    /// `claims.csv`.
    pub claims: Vec<ClaimRow>,
    /// What disturbed the timings: the manifest's notes and those of the null comparison; empty for a quiet run.
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
    /// What kind of thing it is.
    pub kind: Kind,
    /// Geometric mean over scenes of the time ratio to the first baseline; 1 for that baseline itself.
    pub ratio: f64,
    /// Scenes that went into it.
    pub scenes: usize,
}

/// The null comparison's interval has to meet this one in a quiet run: the two copies are equally fast.
pub const EQUAL: (f64, f64) = (0.99, 1.01);
/// And it has to lie within this one: the run was steady enough to tell what verdicts call equal.
pub const STEADY: (f64, f64) = judge::EQUIVALENT;

/// Analyses the run in `folder` and writes `summary.csv`, `ratios.csv` and `claims.csv`, and the claims it judged as
/// `claims.toml` beside them.
///
/// # Errors
/// When a record is missing, malformed or contradicts itself, or a result cannot be written.
pub fn analyze(folder: &Path, claims: &ClaimSet) -> Result<Outcome, AnalysisError> {
    let manifest = Manifest::read(folder)?;
    let scenes = table::read(folder)?;
    let cases = ratios::Cases::new(&manifest);
    let seed = manifest.request.seed;
    let misses = Misses::of_rows(&read_rows::<VerificationRow>(folder)?);
    let summary = summary::summarise(&scenes, &misses, seed);
    let ratios = ratios::all_ratios(&scenes, &cases, claims, seed)?;
    let noise = noise(&manifest, &ratios);
    let evidence = judge::Evidence {
        scenes: &scenes,
        misses: &misses,
        trees: read_rows(folder)?,
        tightness: read_rows(folder)?,
        exits: read_rows_if_there(folder)?,
        outlines: read_rows(folder)?,
        manifest: &manifest,
        cases: &cases,
        noisy: !noise.is_empty(),
    };
    let rows = judge::judge(&evidence, claims)?;
    record::write_rows(folder, &summary)?;
    record::write_rows(folder, &ratios)?;
    record::write_rows(folder, &rows)?;
    record::write_text(&folder.join(claims::FILE), &claims.text)?;
    cost::write(folder, &manifest, &scenes)?;
    let ranking = ranking(&manifest, &ratios, &misses, claims);
    Ok(Outcome { summary, ratios, claims: rows, noise, ranking })
}

/// What disturbed the timings: what the manifest says, and every scene whose null comparison is not quiet.
#[must_use]
pub fn noise(manifest: &Manifest, ratios: &[RatioRow]) -> Vec<String> {
    let is_quiet = |r: &RatioRow| STEADY.0 <= r.low && r.high <= STEADY.1 && r.low <= EQUAL.1 && EQUAL.0 <= r.high;
    let loud =
        ratios.iter().filter(|r| r.variant == NULL_VARIANT && r.metric == "time" && r.stratum == ALL && !is_quiet(r));
    let loud = loud.map(|r| {
        format!(
            "{}: the null method (a second copy of {}) takes {:.3} [{:.3}, {:.3}] times as long as its original; in a quiet run the interval stays within [{}, {}] and meets [{}, {}]",
            r.scene, r.baseline, r.ratio, r.low, r.high, STEADY.0, STEADY.1, EQUAL.0, EQUAL.1
        )
    });
    manifest.noise.iter().cloned().chain(loud).collect()
}

/// The variants by speed: geometric mean over scenes of the time ratio to the first baseline, all strata weighted equally,
/// every variant under its default policy. Safe volumes first, then engines, peers and controls. What is unsafe is left out, and what
/// calls itself safe and missed a contact: a method can look fast because it misses collisions.
#[must_use]
pub fn ranking(manifest: &Manifest, ratios: &[RatioRow], misses: &Misses, claims: &ClaimSet) -> Vec<Ranked> {
    let cases = ratios::Cases::new(manifest);
    let Some(baseline) = claims.comparison.baselines.first() else { return Vec::new() };
    let mut ranking = Vec::new();
    for entry in &manifest.variants {
        if entry.id == NULL_VARIANT || (entry.kind.is_ours() && (!entry.safe || misses.any_of(&entry.id))) {
            continue;
        }
        let logs: Vec<f64> = ratios
            .iter()
            .filter(|r| r.metric == "time" && r.stratum == ALL && r.variant == entry.id && r.baseline == *baseline)
            .filter(|r| cases.is_default(&r.variant, &r.policy) && cases.is_default(&r.baseline, &r.baseline_policy))
            .map(|r| r.ratio.ln())
            .collect();
        let (ratio, scenes) = if entry.id == *baseline {
            (1.0, manifest.scenes.len())
        } else if logs.is_empty() {
            continue;
        } else {
            ((logs.iter().sum::<f64>() / logs.len() as f64).exp(), logs.len())
        };
        let (variant, label) = (entry.id.clone(), entry.label.clone());
        ranking.push(Ranked { variant, label, kind: entry.kind, ratio, scenes });
    }
    ranking.sort_by(|a, b| (a.kind != Kind::Volume).cmp(&(b.kind != Kind::Volume)).then(a.ratio.total_cmp(&b.ratio)));
    ranking
}

#[cfg(test)]
mod tests;
