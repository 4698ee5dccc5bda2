//! `plot`: the figures.

use super::options::FolderOptions;
use super::{CLEAR, say};
use crate::plot::draw_all;
use anyhow::Result;
use clap::Args;

#[derive(Args)]
#[command(after_help = "Example:\n  bvbench stage plot --out results/quick")]
pub struct Options {
    #[command(flatten)]
    folder: FolderOptions,
}

pub fn run(options: &Options) -> Result<u8> {
    let gallery = draw_all(options.folder.checked()?)?;
    for figure in &gallery.figures {
        say(format!("{}  {}", options.folder.out.join(&figure.png).display(), figure.title));
    }
    for skipped in &gallery.skipped {
        say(format!("no figure {}: {}", skipped.name, skipped.reason));
    }
    Ok(CLEAR)
}
