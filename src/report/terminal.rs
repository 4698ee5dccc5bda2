//! The closing table of the command line, as data.

use super::tables::interval;
use crate::analysis::claims::ClaimSet;
use crate::record::ClaimRow;

/// One line: a claim under one reading in one scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TerminalRow {
    /// Claim id.
    pub claim: String,
    /// The sentence.
    pub sentence: String,
    /// Reading, or `-`.
    pub reading: String,
    /// Scene, or `-`.
    pub scene: String,
    /// Verdict.
    pub verdict: String,
    /// What was measured.
    pub measure: String,
    /// Value with its interval; empty without one.
    pub value: String,
    /// Misses of the claim's variant and of its baseline, `0 / 12`; `-` where unknown.
    pub misses: String,
    /// What to know beside it.
    pub note: String,
}

/// The verdicts that stand for a claim: over all strata, or of the one kind of pose it is about. Claims that are not judged,
/// and readings whose variants the run does not have, are left out; the report names them with the reason.
#[must_use]
pub fn terminal_rows(verdicts: &[ClaimRow], claims: &ClaimSet) -> Vec<TerminalRow> {
    verdicts
        .iter()
        .filter(|row| stands_for_claim(row, verdicts) && row.scene != "-")
        .map(|row| of(row, claims))
        .collect()
}

/// Whether the row is not merely one stratum of a claim that also has a verdict over all of them.
pub(super) fn stands_for_claim(row: &ClaimRow, verdicts: &[ClaimRow]) -> bool {
    let of_claim = || verdicts.iter().filter(|other| other.claim == row.claim);
    row.role == "primary" || of_claim().all(|other| other.role != "primary")
}

fn of(row: &ClaimRow, claims: &ClaimSet) -> TerminalRow {
    let count = |missed: Option<u64>| missed.map_or_else(|| "-".to_owned(), |n| n.to_string());
    TerminalRow {
        claim: row.claim.clone(),
        sentence: claims.claim(&row.claim).map_or_else(String::new, |claim| claim.sentence.clone()),
        reading: row.reading.clone(),
        scene: row.scene.clone(),
        verdict: row.verdict.clone(),
        measure: row.measure.clone(),
        value: interval(row.value, row.low, row.high),
        misses: format!("{} / {}", count(row.missed), count(row.baseline_missed)),
        note: row.note.clone(),
    }
}
