//! The claims in the form for readers: one row for each sentence, with a cell for each reading.

use super::Contents;
use crate::analysis::ALL;
use crate::analysis::claims::{Claim, Reading, TestKind};
use crate::record::{ClaimRow, PROGRAM_TIME};
use std::collections::BTreeSet;

/// The group of a sentence, which decides whether it is shown at once or folded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// A sentence of the paper that was judged.
    Judged,
    /// A sentence of other literature.
    Literature,
    /// A sentence that no measurement here decides.
    NotJudged,
}

/// A sentence with its verdicts.
#[derive(Clone, Debug)]
pub struct Sentence<'a> {
    /// The claim.
    pub claim: &'a Claim,
    /// The group in which the sentence is shown.
    pub group: Group,
    /// The primary row, which answers the sentence.
    pub primary: Option<&'a ClaimRow>,
    /// For each of its readings, the rows that represent it: one for each scene, or of misses one for each scene and workload.
    pub cells: Vec<(&'a str, Vec<&'a ClaimRow>)>,
}

/// The sentences of a run in the order of the claims.
pub fn sentences(contents: &Contents) -> Vec<Sentence<'_>> {
    contents.claims.claims.iter().map(|claim| sentence(claim, &contents.verdicts)).collect()
}

fn sentence<'a>(claim: &'a Claim, verdicts: &'a [ClaimRow]) -> Sentence<'a> {
    let of_claim: Vec<&ClaimRow> = verdicts.iter().filter(|row| row.claim == claim.id()).collect();
    let primary = of_claim.iter().copied().find(|row| row.role == "primary");
    let is_judged = primary.is_some_and(|row| row.verdict != "not-judged");
    let group = match (claim.primary.is_some(), is_judged) {
        (true, true) => Group::Judged,
        (false, _) if claim.test.is_some() => Group::Literature,
        _ => Group::NotJudged,
    };
    let cells = claim.readings.iter().map(|id| {
        let reading = id.get_ref().as_str();
        let rows = of_claim.iter().copied().filter(|row| row.role != "primary" && row.reading == reading);
        let rows: Vec<&ClaimRow> = rows.collect();
        let is_about_misses = claim.test.as_ref().is_some_and(|test| test.kind == TestKind::Misses);
        (reading, if is_about_misses { rows } else { whole(&rows, primary) })
    });
    Sentence { claim, group, primary, cells: cells.collect() }
}

/// Rows of one reading that cover the same queries as the primary row; without a primary row, those that cover all queries.
fn whole<'a>(rows: &[&'a ClaimRow], primary: Option<&ClaimRow>) -> Vec<&'a ClaimRow> {
    let of = |workload: &str, stratum: &str| -> Vec<&'a ClaimRow> {
        rows.iter().copied().filter(|row| row.workload == workload && row.stratum == stratum).collect()
    };
    if let Some(primary) = primary {
        let same = of(&primary.workload, &primary.stratum);
        if !same.is_empty() {
            return same;
        }
    }
    let programs = of(PROGRAM_TIME, ALL);
    if !programs.is_empty() {
        return programs;
    }
    rows.iter().copied().filter(|row| [ALL, "-"].contains(&row.stratum.as_str()) || row.scene == "-").collect()
}

/// One table: the sentences that share readings, and these readings in the order of the claims file, as its columns.
pub type Block<'a> = (Vec<&'a Reading>, Vec<Sentence<'a>>);

/// The sentences of a group as tables.
pub fn blocks(contents: &Contents, group: Group) -> Vec<Block<'_>> {
    let mut blocks: Vec<(Vec<&str>, Vec<Sentence<'_>>)> = Vec::new();
    for sentence in sentences(contents).into_iter().filter(|sentence| sentence.group == group) {
        let own: Vec<&str> = sentence.cells.iter().map(|(id, _)| *id).collect();
        match blocks.iter_mut().find(|(ids, _)| own.iter().any(|id| ids.contains(id))) {
            Some((ids, of)) => {
                ids.extend(own);
                of.push(sentence);
            }
            None => blocks.push((own, vec![sentence])),
        }
    }
    let readings = |ids: &[&str]| {
        contents.claims.readings.iter().filter(|reading| ids.contains(&reading.id.get_ref().as_str())).collect()
    };
    blocks.into_iter().map(|(ids, of)| (readings(&ids), of)).collect()
}

/// A reading in words: its name, and what it assumes.
pub fn words(reading: &Reading) -> (String, &str) {
    match reading.title.split_once(": ") {
        Some((name, rest)) if name != reading.id.get_ref() => (format!("{}, {name}", reading.id.get_ref()), rest),
        Some((_, rest)) => (reading.id.get_ref().clone(), rest),
        None => (reading.id.get_ref().clone(), &reading.title),
    }
}

/// A cell in one line: `refuted`, or `supported (scene-a), undecided (scene-b)` when scenes differ; workloads take the place of scenes when
/// there are several; empty when the sentence is not judged in this reading.
pub fn verdicts_in_words(rows: &[&ClaimRow]) -> String {
    let has_workloads = rows.iter().map(|row| &row.workload).collect::<BTreeSet<_>>().len() > 1;
    let is_alike = |row: &ClaimRow| {
        let mut same = rows.iter().filter(|other| other.workload == row.workload);
        same.all(|other| other.verdict == row.verdict)
    };
    let place = |row: &ClaimRow| match (has_workloads, is_alike(row)) {
        (false, _) => row.scene.clone(),
        (true, true) => row.workload.clone(),
        (true, false) => format!("{} {}", row.scene, row.workload),
    };
    let mut kinds: Vec<(&str, Vec<String>)> = Vec::new();
    for row in rows {
        let place = place(row);
        match kinds.iter_mut().find(|(verdict, _)| *verdict == row.verdict) {
            Some((_, places)) if places.contains(&place) => {}
            Some((_, places)) => places.push(place),
            None => kinds.push((&row.verdict, vec![place])),
        }
    }
    if let [(verdict, _)] = &kinds[..] {
        return (*verdict).to_owned();
    }
    let each = kinds.iter().map(|(verdict, places)| format!("{verdict} ({})", places.join(", ")));
    each.collect::<Vec<_>>().join(", ")
}
