//! A timing launch: the parent starts this program again, the child times and tells on standard output how far it is. The child ends
//! when its standard input does, so that it does not outlive a parent that was killed, and nothing else is timed beside the run that takes its place.

use super::options::truth_cache;
use super::{CLEAR, FAILED, say};
use crate::measure::binaries::binary_of;
use crate::measure::{Plan, Progress, Run};
use crate::record::Manifest;
use crate::registry::Registry;
use anyhow::{Context, Result};
use clap::Args;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

#[derive(Args)]
pub struct Options {
    /// Folder of the run
    #[arg(long)]
    out: PathBuf,
    /// Folder of exact answers
    #[arg(long)]
    cache: PathBuf,
    /// Number of the launch, from 0
    #[arg(long)]
    number: u32,
}

/// Carries out one launch of the run in the folder.
pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    end_with_parent();
    let plan = Plan::of_request(Manifest::read(&options.out)?.request, registry)?;
    let run = Run::join_parent(plan, &options.out)?.with_cache(truth_cache(&options.cache)?);
    run.check_binary(options.number)?;
    run.time_launch(options.number, &ToParent)?;
    Ok(CLEAR)
}

/// Ends this process when the parent is gone, and its end of the pipe with it.
fn end_with_parent() {
    std::thread::spawn(|| {
        // Nothing is ever written to it.
        let _ = std::io::copy(&mut std::io::stdin(), &mut std::io::sink());
        std::process::exit(FAILED.into());
    });
}

/// Tells the parent.
struct ToParent;

impl Progress for ToParent {
    fn begin(&self, what: &str, total: u64) {
        say(format!("begin {total} {what}"));
    }

    fn advance(&self, steps: u64) {
        say(format!("advance {steps}"));
    }
}

/// Measures a run, each launch in a process of its own.
pub fn measure(run: &mut Run, cache: &Path, progress: &dyn Progress) -> Result<()> {
    let folder = run.folder().to_owned();
    let binaries: Vec<PathBuf> = run.plan().binaries.iter().map(|binary| binary.path.clone()).collect();
    let launcher = |number: u32| {
        let turn = binary_of(number, binaries.len() as u32) as usize;
        start(binaries.get(turn), (&folder, cache), number, progress).map_err(|error| format!("{error:#}"))
    };
    Ok(run.measure(&launcher, progress)?)
}

/// Carries out a launch in a process of its own, of `binary` or of this program.
fn start(
    binary: Option<&PathBuf>,
    (folder, cache): (&Path, &Path),
    number: u32,
    progress: &dyn Progress,
) -> Result<()> {
    let own = || std::env::current_exe().context("this program's own file cannot be found");
    let program = binary.map_or_else(own, |binary| Ok(binary.clone()))?;
    let mut child = Command::new(program)
        .arg("launch")
        .arg("--out")
        .arg(folder)
        .arg("--cache")
        .arg(cache)
        .args(["--number", &number.to_string()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .context("a process for the launch cannot be started")?;
    // Open until the child has ended: `wait` would close it.
    let _pipe = child.stdin.take();
    if let Some(output) = child.stdout.take() {
        for line in BufReader::new(output).lines() {
            let line = line?;
            let mut words = line.splitn(3, ' ');
            match (words.next(), words.next().and_then(|n| n.parse().ok()), words.next()) {
                (Some("begin"), Some(total), Some(what)) => progress.begin(what, total),
                (Some("advance"), Some(steps), None) => progress.advance(steps),
                _ => {}
            }
        }
    }
    let status = child.wait()?;
    anyhow::ensure!(status.success(), "its process ended with {status}");
    Ok(())
}
