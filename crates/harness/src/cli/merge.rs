//! `merge`: the shards of a run or a study put together.

use super::{CLEAR, FAILED, say, verify};
use crate::measure::run::Run;
use crate::measure::shard::{Shard, merge};
use crate::record::Manifest;
use crate::record::manifest::Stage;
use crate::registry::Registry;
use anyhow::{Result, ensure};
use clap::Args;
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench repro --shard 1/2 --out shards/1 && bvbench repro --shard 2/2 --out shards/2\n  bvbench stage merge shards/1 shards/2 --out results/quick\n  bvbench repro --out results/quick      analysis, figures and report of the merged run\n\n  bvbench study audit --shard 1/2 --out shards/1 && bvbench study audit --shard 2/2 --out shards/2\n  bvbench stage merge shards/1 shards/2 --out results/audit-quick\n  bvbench study audit                    tables, analysis and figures of the merged audit\n\nDeterministic tables have the bytes of a run without shards. Shards of another plan, version or protocol are refused. So are shards that are unfinished, changed, lacking or named twice, and launches timed on processors of two kinds."
)]
pub struct Options {
    /// Folders of all shards
    #[arg(value_name = "SHARD", required = true)]
    shards: Vec<PathBuf>,
    /// Folder of the run or study
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Write a run's raw rows compressed, as .csv.gz [default: with profile full]
    #[arg(long)]
    gzip: bool,
    /// Replace what another request left in the folder
    #[arg(long)]
    fresh: bool,
    /// Print the manifest as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    let mut folders = BTreeSet::new();
    for folder in options.shards.iter().chain([&options.out]) {
        let is_new = folders.insert(folder.canonicalize().unwrap_or_else(|_| folder.clone()));
        ensure!(is_new, "{} is named twice: each shard is a folder of its own, and so is --out", folder.display());
    }
    if let Some(run) = merge(&options.shards, registry, &options.out, (options.fresh, options.gzip))? {
        return tell_run(&run, options);
    }
    if options.json {
        say(serde_json::to_string_pretty(&json!({ "manifest": Manifest::read(&options.out)? }))?);
    } else {
        say(format!(
            "Merged {} shards: {}. The study's command with this --out and without --shard joins and analyses them.",
            options.shards.len(),
            options.out.display()
        ));
    }
    Ok(CLEAR)
}

fn tell_run(run: &Run, options: &Options) -> Result<u8> {
    if options.json {
        say(serde_json::to_string_pretty(&json!({ "manifest": run.manifest() }))?);
    } else {
        let stages: Vec<&str> = [(Stage::Verify, "verdicts"), (Stage::Measure, "counts and times")]
            .into_iter()
            .filter_map(|(stage, what)| run.has_finished(stage).then_some(what))
            .collect();
        say(format!("Merged {} shards, {}: {}", options.shards.len(), stages.join(", "), options.out.display()));
    }
    let holds = !run.has_finished(Stage::Verify) || {
        let verification = run.verification()?;
        if !options.json {
            say(verify::verdict(&verification));
        }
        verification.holds()
    };
    Ok(if holds { CLEAR } else { FAILED })
}

/// What a finished shard's command says.
pub fn next_step(shard: Shard, folder: &Path) -> String {
    format!("Shard {shard} is whole: {}. `bvbench stage merge` puts all shards together.", folder.display())
}
