//! `analyze`: from raw records to verdicts.

use super::options::FolderOptions;
use super::progress::Bar;
use super::{CLEAR, conclusion, machines, say, style};
use crate::analysis::claims::ClaimSet;
use crate::analysis::{Outcome, analyze};
use crate::measure::{Progress, Run};
use crate::plot::Gallery;
use crate::record::manifest::Stage;
use crate::registry::Registry;
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
    /// Judge these claims; without the option those of the folder's claims.toml, or the paper's where it has none
    #[arg(long, value_name = "FILE")]
    claims: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(options: &Options) -> Result<u8> {
    let given = options.claims.as_deref().map(ClaimSet::read).transpose()?;
    let folder = options.folder.checked()?;
    let claims = given.map_or_else(|| ClaimSet::of_run(folder), Ok)?;
    let outcome = analyze(folder, &claims)?;
    if options.json {
        say(serde_json::to_string_pretty(&as_json(&outcome))?);
    } else {
        say(conclusion::text(&Contents::read(folder)?, style::is_coloured()));
    }
    Ok(CLEAR)
}

/// Analyses, draws and reports a measured run: what `repro` and `try` end with. The last two are the files of the report and of the page.
pub fn finish(
    run: &mut Run,
    claims: &ClaimSet,
    registry: &Registry,
    bar: &Bar,
) -> Result<(Outcome, Gallery, PathBuf, PathBuf)> {
    let folder = run.folder().to_owned();
    bar.begin("analysing", 1);
    let outcome = analyze(&folder, claims)?;
    run.finish(Stage::Analyze)?;
    bar.begin("drawing", 1);
    let gallery = crate::plot::draw_all(&folder)?;
    run.finish(Stage::Plot)?;
    bar.begin("reporting", 1);
    let report = crate::report::write(&folder)?;
    let page = crate::report::write_page(&folder, &machines::insets(run.manifest(), registry, bar))?;
    run.finish(Stage::Report)?;
    bar.finish();
    Ok((outcome, gallery, report, page))
}

/// Verdicts as data.
pub fn as_json(outcome: &Outcome) -> serde_json::Value {
    json!({ "claims": outcome.claims, "noise": outcome.noise, "noisy": !outcome.noise.is_empty() })
}
