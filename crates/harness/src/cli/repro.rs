//! `repro`: the whole trial, from verdicts to report.

use super::options::RunOptions;
use super::progress::Bar;
use super::{CLEAR, FAILED, analyze, conclusion, launch, merge, say, style, supplements, verify};
use crate::analysis::claims::ClaimSet;
use crate::record::manifest::Stage;
use crate::registry::Registry;
use anyhow::Result;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench repro                              the paper's scenes, and a 5-axis mill, the standard variants, five minutes\n  bvbench repro --profile smoke --out /tmp/look\n  bvbench repro --scene bench-scenes/lathe-toolpost --variant ID --variant ID --out results/two\n\n  bvbench repro --shard 3/7 --out shards/3   a seventh of it; `bvbench stage merge shards/* --out DIR` puts all together\n\nAn interrupted run goes on where it stopped when the same command is given again; a finished one is made again, a finished shard is not."
)]
pub struct Options {
    #[command(flatten)]
    run: RunOptions,
    /// Judge these claims instead of the paper's
    #[arg(long, value_name = "FILE")]
    claims: Option<PathBuf>,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    let claims = options.claims.as_deref().map_or_else(|| Ok(ClaimSet::standard()), ClaimSet::read)?;
    let mut run = options.run.open(registry)?;
    let bar = Bar::new(options.run.output.quiet);
    let finished = run.has_finished(Stage::Report);
    if !finished {
        // Rows of stages that are not made again.
        run.manifest().check_rows(run.folder())?;
    }
    let verification =
        if finished || !run.has_finished(Stage::Verify) { run.verify(&bar)? } else { run.verification()? };
    if finished || !run.has_finished(Stage::Measure) {
        launch::measure(&mut run, &options.run.cache_folder(), &bar)?;
    }
    if let Some(shard) = run.plan().shard {
        bar.finish();
        say(merge::next_step(shard, run.folder()));
        return Ok(if verification.holds() { CLEAR } else { FAILED });
    }
    let folder = run.folder().to_owned();
    let octree =
        supplements::make(&folder, &run.manifest().request, &claims, &options.run.cache_folder(), registry, &bar)?;
    let (outcome, gallery, report, page) = analyze::finish(&mut run, &claims, registry, &bar)?;
    if options.run.output.json {
        let result = json!({
            "out": folder.to_string_lossy(), "report": report.to_string_lossy(), "page": page.to_string_lossy(), "verification": verify::as_json(&verification),
            "octree": verify::as_json(&octree),
            "answer": crate::report::answer(&crate::report::Contents::read(&folder)?),
            "analysis": analyze::as_json(&outcome),
        });
        say(serde_json::to_string_pretty(&result)?);
    } else {
        // What was checked first, the answer last: it is what stays on the screen.
        say(verify::verdict(&verification));
        say(format!("\nThe octree method, compared with the reference:\n{}\n", verify::table(&octree).trim_fmt()));
        say(conclusion::text(&crate::report::Contents::read(&folder)?, style::is_coloured()));
        say(format!("\nLook next at\n  {}   the page: charts, with the CSV row behind every mark", page.display()));
        say(format!("  {}     the same to read, with {} figures", report.display(), gallery.figures.len()));
        say(format!(
            "  {}         the records; results/README.md says what each column means",
            folder.join("*.csv").display()
        ));
    }
    Ok(if verification.holds() && octree.holds() { CLEAR } else { FAILED })
}
