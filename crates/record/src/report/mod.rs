//! The report of a run, written for the reader of the paper: the question, the result, and how to reproduce it.
//!
//! All data come from the run's folder, so the report of an old run can be written again. [`Contents`] is rendered as Markdown
//! (`report.md`) and as one page that opens from disk (`report.html`).

mod answer;
mod audit;
mod markdown;
mod noise;
mod page;
mod peers;
mod programs;
mod sentences;
mod tables;
mod terminal;
mod variance;

pub use crate::analysis::words::capital;
pub use answer::{Statement, answer, quantity};
pub use audit::{AUDIT_FILE, write_audit};
pub use noise::in_short as noise_in_short;
pub use page::escaped;
pub use page::{Inset, PAGE_FILE, write_page};
pub use terminal::{RankedRow, SentenceRow, ranked_rows, sentence_rows};

use crate::analysis::claims::{self, ClaimSet};
use crate::analysis::misses::Misses;
use crate::analysis::{AnalysisError, Ranked, noise, ranking};
use crate::plot::{Gallery, read_gallery};
use crate::record::{
    ClaimRow, Manifest, PeerRatioRow, PeerRow, ProgramTimeRow, RatioRow, SummaryRow, VarianceRow, read_rows,
    read_rows_if_there, write_text,
};
use std::path::{Path, PathBuf};

/// The report's file in a run's folder.
pub const FILE: &str = "report.md";

/// The data of a report, independent of its format.
#[derive(Debug)]
pub struct Contents {
    /// What was run, and on which machine.
    pub manifest: Manifest,
    /// What was claimed.
    pub claims: ClaimSet,
    /// The verdicts.
    pub verdicts: Vec<ClaimRow>,
    /// Times and counts.
    pub summary: Vec<SummaryRow>,
    /// `program_times.csv`.
    pub program_times: Vec<ProgramTimeRow>,
    /// Ratios.
    pub ratios: Vec<RatioRow>,
    /// Variance components; empty for a run that was analysed before they existed.
    pub variance: Vec<VarianceRow>,
    /// Misses.
    pub misses: Misses,
    /// The figures.
    pub gallery: Gallery,
    /// What disturbed the timings.
    pub noise: Vec<String>,
    /// Safe volumes by speed.
    pub ranking: Vec<Ranked>,
    /// Rows of whole engines; empty when the folder has no comparison of engines.
    pub peers: Vec<PeerRow>,
    /// Ratios between engines.
    pub peer_ratios: Vec<PeerRatioRow>,
}

impl Contents {
    /// Gathers the contents from an analysed run.
    ///
    /// # Errors
    /// When a record is missing or malformed. `claims.csv`, `summary.csv` and `ratios.csv` are written by the analysis.
    pub fn read(folder: &Path) -> Result<Self, AnalysisError> {
        let manifest = Manifest::read(folder)?;
        let claims = ClaimSet::read(&folder.join(claims::FILE))?;
        let ratios: Vec<RatioRow> = read_rows(folder)?;
        let misses = Misses::read(folder)?;
        Ok(Self {
            verdicts: read_rows(folder)?,
            peers: read_rows_if_there(folder)?,
            peer_ratios: read_rows_if_there(folder)?,
            summary: read_rows(folder)?,
            program_times: read_rows(folder)?,
            variance: read_rows_if_there(folder)?,
            gallery: read_gallery(folder)?,
            noise: noise(&manifest, &ratios),
            ranking: ranking(&manifest, &ratios, &misses, &claims),
            misses,
            ratios,
            claims,
            manifest,
        })
    }

    /// The label of a variant, or its id when the manifest does not list it.
    pub fn label<'a>(&'a self, id: &'a str) -> &'a str {
        self.manifest.variants.iter().find(|entry| entry.id == id).map_or(id, |entry| &entry.label)
    }
}

/// Why the times of a run over a single binary are not the last word.
pub const PREVIEW: &str = "This run is a preview: all its launches are of one binary, and what another order of the same functions would change is in no \
     interval of a time. Profile `full` over the binaries of `scripts/binaries` makes the run that counts.";

/// Whether a run is a preview.
pub const fn is_preview(manifest: &Manifest) -> bool {
    manifest.request.binaries < 2
}

/// One paragraph on the subject of the run.
fn lead(claims: &ClaimSet, manifest: &Manifest) -> String {
    let preview = if is_preview(manifest) { format!(" {PREVIEW}") } else { String::new() };
    format!("{}{preview}", subject(claims, &manifest.request.profile))
}

fn subject(claims: &ClaimSet, profile: &str) -> String {
    if claims.is_empty() {
        return format!(
            "This run (profile `{profile}`) times bounding volumes side by side on the parts and poses of this scene, and compares every \
             verdict of theirs with exact truth."
        );
    }
    format!(
        "The paper says that an oriented bounding box weighted by triangle areas detects machine-tool collisions faster than the plain one \
         and repairs its faults. This run (profile `{profile}`) asks of each of its sentences whether that holds, on machine scenes of our \
         own and against exact truth. It is a conceptual replication of {}: see the limitations at the end.",
        claims.source
    )
}

/// Writes `report.md` of the run in `folder` and returns its path.
///
/// # Errors
/// When the run has not been analysed, a record is malformed, or the file cannot be written.
pub fn write(folder: &Path) -> Result<PathBuf, AnalysisError> {
    let path = folder.join(FILE);
    write_text(&path, &markdown::render(&Contents::read(folder)?))?;
    Ok(path)
}

#[cfg(test)]
mod tests;
