//! `audit`: what really makes a box good.

use super::options::{OutputOptions, StudyOptions, truth_cache, use_threads};
use super::progress::Bar;
use super::{CLEAR, merge, say, style};
use crate::analysis::audit::{AuditOutcome, SAFE, analyze_audit};
use crate::analysis::{ALL, distinct};
use crate::measure::Profile;
use crate::measure::audit::Audit;
use crate::registry::Registry;
use anyhow::Result;
use clap::Args;
use comfy_table::Table;
use serde_json::json;
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench study audit --profile smoke              every cell, a chunk of poses per stratum\n  bvbench study audit --counts-only                operations and containment only: the same on every machine\n  bvbench study audit --scene trunnion-impeller --out results/audit-impeller\n  bvbench study audit --orientation vertex --orientation area\n                                             without the search for the smallest box, which takes longest\n  bvbench study audit --shard 3/7 --out shards/3   a seventh of it; `bvbench stage merge shards/* --out DIR`, then this without --shard\n\nAn interrupted audit goes on where it stopped when the same command is given again."
)]
pub struct Options {
    /// How much: smoke (minutes), quick (half an hour), full (a day)
    #[arg(long, default_value = "quick", value_name = "PROFILE")]
    profile: Profile,
    /// Folder of the audit [default: results/audit-PROFILE]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Scene by name or by path; repeatable [default: two lathes and a 5-axis mill]
    #[arg(long = "scene", value_name = "NAME|PATH")]
    scenes: Vec<String>,
    /// Orientation by name: vertex, area, hull-area, dito, min; repeatable [default: all]
    #[arg(long = "orientation", value_name = "NAME")]
    orientations: Vec<String>,
    /// Triangles of a leaf: 1, 2, 4, 8; repeatable [default: all]
    #[arg(long = "leaf", value_name = "N")]
    leaves: Vec<u8>,
    #[command(flatten)]
    study: StudyOptions,
    /// Folder in which exact answers are kept for the next run
    #[arg(long, value_name = "DIR", default_value = "results/.truth-cache")]
    cache: PathBuf,
    /// Replace an audit of another request that is in the folder
    #[arg(long)]
    fresh: bool,
    #[command(flatten)]
    output: OutputOptions,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    use_threads(options.study.threads)?;
    let folder = options.out.clone().unwrap_or_else(|| format!("results/audit-{}", options.profile).into());
    let mut plan = Audit::plan(options.profile, options.scenes.clone(), options.study.seed, registry)?;
    plan.shard = options.study.shard;
    let audit = Audit::open(plan, &options.orientations, &options.leaves, &folder, options.fresh)?;
    let mut audit = audit.with_cache(truth_cache(&options.cache)?);
    let bar = Bar::new(options.output.quiet);
    audit.run(!options.study.counts_only, &bar)?;
    bar.finish();
    if let Some(shard) = options.study.shard {
        say(merge::next_step(shard, &folder));
        return Ok(CLEAR);
    }
    let outcome = analyze_audit(&folder)?;
    let gallery = crate::plot::draw_audit(&folder)?;
    let report = crate::report::write_audit(&folder)?;
    if options.output.json {
        say(serde_json::to_string_pretty(&json!({
            "out": folder.to_string_lossy(), "report": report.to_string_lossy(), "shares": outcome.shares, "effects": outcome.effects,
        }))?);
    } else {
        say(table(&outcome).trim_fmt());
        say(format!("\n{} cells, shares of the variance between the safe ones, %", audit.cells()));
        say(format!("Report   {}", report.display()));
        for figure in &gallery.figures {
            say(format!("Figure   {}", folder.join(&figure.png).display()));
        }
    }
    Ok(CLEAR)
}

/// The shares of each term in each response.
fn table(outcome: &AuditOutcome) -> Table {
    let together = outcome.shares.iter().any(|row| row.scene == ALL);
    let rows: Vec<_> =
        outcome.shares.iter().filter(|row| row.cells == SAFE && (!together || row.scene == ALL)).collect();
    let responses = distinct(rows.iter().map(|row| row.response.as_str()));
    let terms = distinct(rows.iter().map(|row| row.term.as_str()));
    let header = std::iter::once("TERM".to_owned()).chain(responses.iter().map(|r| format!(">{}", r.to_uppercase())));
    let mut table = style::plain(header);
    for term in terms {
        let share = |response: &&str| {
            let row = rows.iter().find(|row| row.term == term && row.response == *response);
            row.map_or_else(String::new, |row| format!("{:.1}", 100.0 * row.share))
        };
        table.add_row(std::iter::once(term.to_owned()).chain(responses.iter().map(share)));
    }
    table
}
