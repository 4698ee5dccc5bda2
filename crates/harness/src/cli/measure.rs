//! `measure`: counts, tightness and times.

use super::options::RunOptions;
use super::progress::Bar;
use super::{CLEAR, launch, merge, say};
use crate::registry::Registry;
use anyhow::Result;
use clap::Args;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench stage measure --scene lathe-toolpost --variant ID --variant ID --out results/two\n  bvbench stage measure --policy sah16/own/1 --policy sah16/own/4 --out results/leaves\n\nAn interrupted run goes on where it stopped when the same command is given again."
)]
pub struct Options {
    #[command(flatten)]
    run: RunOptions,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    let mut run = options.run.open(registry)?;
    let bar = Bar::new(options.run.output.quiet);
    launch::measure(&mut run, &options.run.cache_folder(), &bar)?;
    bar.finish();
    if options.run.output.json {
        say(serde_json::to_string_pretty(run.manifest())?);
    } else {
        let measured = || format!("Measured: {}", run.folder().display());
        say(run.plan().shard.map_or_else(measured, |shard| merge::next_step(shard, run.folder())));
        for complaint in &run.manifest().noise {
            say(format!("Noisy: {complaint}"));
        }
    }
    Ok(CLEAR)
}
