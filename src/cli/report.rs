//! `report`: the report of a run.

use super::options::FolderOptions;
use super::{CLEAR, say};
use anyhow::Result;
use clap::Args;

#[derive(Args)]
#[command(after_help = "Example:\n  bvbench report --out results/quick")]
pub struct Options {
    #[command(flatten)]
    folder: FolderOptions,
}

pub fn run(options: &Options) -> Result<u8> {
    say(crate::report::write(&options.folder.out)?.display());
    say(crate::report::write_page(&options.folder.out, &[])?.display());
    Ok(CLEAR)
}
