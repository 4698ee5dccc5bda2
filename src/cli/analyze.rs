//! `analyze`: from raw records to verdicts.

use super::options::FolderOptions;
use super::{CLEAR, conclusion, say, style};
use crate::analysis::claims::ClaimSet;
use crate::analysis::{Outcome, analyze};
use crate::report::Contents;
use anyhow::Result;
use clap::Args;
use serde_json::json;
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
    let folder = options.folder.checked()?;
    let outcome = analyze(folder, &claims)?;
    if options.json {
        say(serde_json::to_string_pretty(&as_json(&outcome))?);
    } else {
        say(conclusion::text(&Contents::read(folder)?, style::is_coloured()));
    }
    Ok(CLEAR)
}

/// Verdicts as data.
pub fn as_json(outcome: &Outcome) -> serde_json::Value {
    json!({ "claims": outcome.claims, "noise": outcome.noise, "noisy": !outcome.noise.is_empty() })
}
