//! `completions` and `man`: what shells and manual readers get, made from the command line's own description.

use super::options::make_folder;
use super::{Arguments, CLEAR, say};
use anyhow::{Context, Result};
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench completions bash > ~/.local/share/bash-completion/completions/bvbench\n  bvbench completions zsh > ~/.zfunc/_bvbench\n  bvbench completions fish > ~/.config/fish/completions/bvbench.fish"
)]
pub struct CompletionOptions {
    /// The shell
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

#[derive(Args)]
#[command(after_help = "Example:\n  bvbench man --out ~/.local/share/man/man1 && man bvbench-check")]
pub struct ManOptions {
    /// Folder of the pages
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Prints the completions of a shell.
pub fn completions(options: &CompletionOptions) -> Result<u8> {
    let mut script = Vec::new();
    clap_complete::generate(options.shell, &mut Arguments::command(), "bvbench", &mut script);
    say(String::from_utf8(script)?.trim_end());
    Ok(CLEAR)
}

/// Writes a manual page for the program and one for each verb.
pub fn man(options: &ManOptions) -> Result<u8> {
    let out = &options.out;
    make_folder("--out", out)?;
    // Pages of hidden verbs are not made: they are not for people.
    clap_mangen::generate_to(Arguments::command().disable_help_subcommand(true), out)
        .with_context(|| format!("cannot write to {}", out.display()))?;
    say(out.join("bvbench.1").display());
    Ok(CLEAR)
}
