//! `analyze`: from raw records to verdicts.

use super::options::FolderOptions;
use super::{CLEAR, say};
use crate::analysis::claims::ClaimSet;
use crate::analysis::{Outcome, analyze};
use crate::record::ClaimRow;
use crate::report::terminal_rows;
use anyhow::Result;
use clap::Args;
use comfy_table::{ContentArrangement, Table, presets};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench analyze --out results/quick\n  bvbench analyze --out results/quick --claims my-claims.toml --json\n\nNothing is measured: any run can be analysed again at any time."
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
    let outcome = analyze(&options.folder.out, &claims)?;
    if options.json {
        say(serde_json::to_string_pretty(&as_json(&outcome))?);
    } else {
        say(table(&outcome.claims, &claims).trim_fmt());
        say(format!("\n{}", tally(&outcome.claims, &claims)));
        for complaint in &outcome.noise {
            say(format!("Noisy: {complaint}"));
        }
    }
    Ok(CLEAR)
}

/// Verdicts, a line each; a claim and a reading are named where they begin.
pub fn table(rows: &[ClaimRow], claims: &ClaimSet) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic).set_header([
        "CLAIM",
        "READING",
        "SCENE",
        "VERDICT",
        "VALUE [95 %]",
        "MISSED",
    ]);
    if table.width().is_none() {
        table.set_width(100);
    }
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
    // A space between columns, so that a row of the longest values still fits 100 columns.
    table.column_iter_mut().for_each(|column| {
        column.set_padding((0, 1));
    });
    table
}

/// How many verdicts of each kind the table has.
pub fn tally(rows: &[ClaimRow], claims: &ClaimSet) -> String {
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
