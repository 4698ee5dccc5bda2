//! `report`: the report of a run.

use super::options::FolderOptions;
use super::progress::Bar;
use super::{CLEAR, machines, say};
use crate::record::Manifest;
use crate::registry::Registry;
use anyhow::Result;
use clap::Args;

#[derive(Args)]
#[command(after_help = "Example:\n  bvbench stage report --out results/quick")]
pub struct Options {
    #[command(flatten)]
    folder: FolderOptions,
    /// Leave the views of the machines out of report.html
    #[arg(long)]
    no_machines: bool,
    /// Print no progress
    #[arg(long, short)]
    quiet: bool,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    let folder = options.folder.analysed()?;
    say(crate::report::write(folder)?.display());
    let bar = Bar::new(options.quiet);
    let views =
        if options.no_machines { Vec::new() } else { machines::insets(&Manifest::read(folder)?, registry, &bar) };
    bar.finish();
    say(crate::report::write_page(folder, &views)?.display());
    Ok(CLEAR)
}
