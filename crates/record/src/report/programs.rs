//! The time of whole programs for the proposed case and its baseline, scene by scene; this is the paper's own quantity.

use super::Contents;
use super::answer::{is_case, paired, proposed};
use crate::analysis::ALL;
use crate::analysis::claims::CaseRef;
use crate::record::PROGRAM_TIME;
use serde::Serialize;

/// One scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProgramTotals {
    /// Scene name.
    pub scene: String,
    /// Number of programs, and how many of them end in a collision.
    pub programs: String,
    /// Id of the proposed variant.
    pub subject: String,
    /// Id of the variant with which it is compared.
    pub baseline: String,
    /// Sum over the programs for the proposed variant, ns: value and 95 % interval.
    pub subject_ns: Option<[f64; 3]>,
    /// The same sum for the baseline, ns.
    pub baseline_ns: Option<[f64; 3]>,
    /// Paired ratio, subject over baseline.
    pub ratio: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// `faster`, `slower`, `the same within 5 %` or `undecided`; it mentions noisy timings.
    pub effect: String,
}

/// The scenes on whose programs both cases were timed; empty for a run without programs or without a claim about speed.
pub fn table(contents: &Contents) -> Vec<ProgramTotals> {
    let Some(reading) = proposed(&contents.claims) else { return Vec::new() };
    let rows = paired(contents, &reading.subject, &reading.baseline);
    let rows = rows.into_iter().filter(|row| row.metric == PROGRAM_TIME);
    let row = |row: &crate::record::RatioRow| ProgramTotals {
        scene: row.scene.clone(),
        programs: programs_of(contents, &row.scene),
        subject: reading.subject.variant.clone(),
        baseline: reading.baseline.variant.clone(),
        subject_ns: total(contents, &row.scene, &reading.subject),
        baseline_ns: total(contents, &row.scene, &reading.baseline),
        ratio: row.ratio,
        low: row.low,
        high: row.high,
        effect: super::answer::effect_in_words(row),
    };
    rows.map(row).collect()
}

/// The sum over a scene's programs for a case, ns.
fn total(contents: &Contents, scene: &str, case: &CaseRef) -> Option<[f64; 3]> {
    let mut rows = contents.program_times.iter().filter(|row| row.scene == scene && row.program == ALL);
    let row = rows.find(|row| is_case(contents, case, &row.variant, &row.case().policy()))?;
    let end = |end: f64| if end.is_finite() { end } else { row.total_ns };
    Some([row.total_ns, end(row.total_low_ns), end(row.total_high_ns)])
}

fn programs_of(contents: &Contents, scene: &str) -> String {
    let mut ends: Vec<(&str, &str)> = Vec::new();
    for row in contents.program_times.iter().filter(|row| row.scene == scene && row.program != ALL) {
        if !ends.iter().any(|(program, _)| *program == row.program) {
            ends.push((&row.program, &row.ends_at));
        }
    }
    match (ends.len(), ends.iter().filter(|(_, end)| *end == "collision").count()) {
        (count, 0) => count.to_string(),
        (1, _) => "1, to a collision".to_owned(),
        (count, colliding) => format!("{count}, {colliding} of them to a collision"),
    }
}
