//! `analyze`: from raw records to verdicts.

use super::options::FolderOptions;
use super::style::{self, Tone};
use super::{CLEAR, say};
use crate::analysis::claims::ClaimSet;
use crate::analysis::{Outcome, analyze};
use crate::record::ClaimRow;
use crate::report::terminal_rows;
use anyhow::Result;
use clap::Args;
use comfy_table::Table;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench stage analyze --out results/quick\n  bvbench stage analyze --out results/quick --claims my-claims.toml --json\n\nNothing is measured: any run can be analysed again at any time."
)]
pub struct Options {
    #[command(flatten)]
    folder: FolderOptions,
    /// Judge these claims instead of the paper's
    #[arg(long, value_name = "FILE")]
    claims: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(options: &Options) -> Result<u8> {
    let claims = options.claims.as_deref().map_or_else(|| Ok(ClaimSet::standard()), ClaimSet::read)?;
    let outcome = analyze(options.folder.checked()?, &claims)?;
    if options.json {
        say(serde_json::to_string_pretty(&as_json(&outcome))?);
    } else {
        print(&outcome, &claims);
        for complaint in &outcome.noise {
            say(format!("Noisy: {complaint}"));
        }
    }
    Ok(CLEAR)
}

/// The verdicts and notes of an analysis, as a person reads them.
pub fn print(outcome: &Outcome, claims: &ClaimSet) {
    let coloured = style::is_coloured();
    say(style::painted(&table(&outcome.claims, claims).trim_fmt(), &TONES, coloured));
    say(format!("\n{}", style::painted(&tally(&outcome.claims, claims), &TONES, coloured)));
}

/// The words of verdicts.
const TONES: [(&str, Tone); 4] =
    [("supported", Tone::Good), ("refuted", Tone::Bad), ("undecided", Tone::Doubtful), ("not-judged", Tone::Dim)];

/// Verdicts, a line each; a claim and a reading are named where they begin.
fn table(rows: &[ClaimRow], claims: &ClaimSet) -> Table {
    let mut table = style::table(&["CLAIM", "READING", "SCENE", "VERDICT", "VALUE [95 %]", "MISSED"]);
    let (mut claim, mut reading) = (String::new(), String::new());
    for row in terminal_rows(rows, claims) {
        let new_claim = row.claim != claim;
        let new_reading = new_claim || row.reading != reading;
        (claim, reading) = (row.claim, row.reading);
        let shown = |name: &str, is_new: bool| if is_new { name.to_owned() } else { String::new() };
        table.add_row([
            shown(&claim, new_claim),
            shown(&reading, new_reading),
            row.scene,
            row.verdict,
            row.value,
            row.misses,
        ]);
    }
    table
}

/// How many verdicts of each kind the table has.
fn tally(rows: &[ClaimRow], claims: &ClaimSet) -> String {
    let rows = terminal_rows(rows, claims);
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for row in &rows {
        *counts.entry(&row.verdict).or_default() += 1;
    }
    let counts: Vec<String> = counts.iter().map(|(verdict, count)| format!("{count} {verdict}")).collect();
    format!("{} verdicts (claim, reading, scene): {}", rows.len(), counts.join(", "))
}

/// Verdicts as data.
pub fn as_json(outcome: &Outcome) -> serde_json::Value {
    json!({ "claims": outcome.claims, "noise": outcome.noise, "noisy": !outcome.noise.is_empty() })
}
