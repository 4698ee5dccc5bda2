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
        for complaint in &outcome.noise {
            say(format!("Noisy: {complaint}"));
        }
    }
    Ok(CLEAR)
}

/// Verdicts, a line each.
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
    for row in terminal_rows(rows, claims) {
        table.add_row([row.claim, row.reading, row.scene, row.verdict, row.value, row.misses]);
    }
    table
}

/// Verdicts as data.
pub fn as_json(outcome: &Outcome) -> serde_json::Value {
    json!({ "claims": outcome.claims, "noise": outcome.noise, "noisy": !outcome.noise.is_empty() })
}
