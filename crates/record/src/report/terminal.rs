//! The data that the command line prints at the end of a run.

use super::Contents;
use super::answer::{paired_by_default, places};
use super::sentences::{Group, sentences};
use super::tables::{interval, number};

/// One sentence of the paper that was judged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SentenceRow {
    /// Claim id.
    pub claim: String,
    /// The scenes on which it was judged.
    pub scene: String,
    /// Verdict.
    pub verdict: String,
    /// Value with its interval; empty without one.
    pub value: String,
    /// Misses of the claim's variant and of its baseline, `0 / 12`; `-` where unknown.
    pub misses: String,
}

/// The judged sentences of the run, by the row that answers each, and the number of sentences that are not judged.
pub fn sentence_rows(contents: &Contents) -> (Vec<SentenceRow>, usize) {
    let all = sentences(contents);
    let judged = all.iter().filter(|sentence| sentence.group == Group::Judged).filter_map(|sentence| {
        let row = sentence.primary?;
        let count = |missed: Option<u64>| missed.map_or_else(|| "-".to_owned(), |n| n.to_string());
        Some(SentenceRow {
            claim: row.claim.clone(),
            scene: row.scene.clone(),
            verdict: row.verdict.clone(),
            value: interval(row.value, row.low, row.high),
            misses: format!("{} / {}", count(row.missed), count(row.baseline_missed)),
        })
    });
    let judged: Vec<SentenceRow> = judged.collect();
    let others = all.len() - judged.len();
    (judged, others)
}

/// One place of the ranking.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RankedRow {
    /// Place in the ranking, in brackets when speed is decided in no scene; `-` for a method that is not a volume on the common tree.
    pub place: String,
    /// The variant's label.
    pub label: String,
    /// Geometric mean of the scenes' ratios.
    pub mean: String,
    /// The ratio in each scene of the run; `-` when there is none.
    pub scenes: Vec<String>,
}

/// The ranking with the ratio in each scene.
pub fn ranked_rows(contents: &Contents) -> Vec<RankedRow> {
    let Some(baseline) = contents.claims.comparison.baselines.first() else { return Vec::new() };
    let row = |(place, entry): (String, &crate::analysis::Ranked)| {
        let rows = paired_by_default(contents, &entry.variant, baseline);
        let scenes = contents.manifest.scenes.iter().map(|scene| {
            let row = rows.iter().find(|row| row.scene == scene.name);
            let own = if entry.variant == *baseline { "1" } else { "-" };
            row.map_or_else(|| own.to_owned(), |row| number(row.ratio))
        });
        RankedRow { place, label: entry.label.clone(), mean: number(entry.ratio), scenes: scenes.collect() }
    };
    places(contents).into_iter().zip(&contents.ranking).map(row).collect()
}
