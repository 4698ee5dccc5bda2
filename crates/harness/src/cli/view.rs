//! `view`: a page that shows a machine in motion.

use super::picture::UpAxis;
use super::progress::Bar;
use super::subject::{SET_UP_EXAMPLES, Subject};
use super::{CLEAR, check, say};
use crate::check::Settings;
use crate::registry::{Registry, Variant};
use crate::view::{self, Choice};
use anyhow::{Context, Result, bail};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

#[derive(Args)]
#[command(
    after_help = format!("Examples:\n  bvbench view mill-vise --open                         a shipped scene with its own program\n  bvbench view path/to/machine part.ngc --out part.html  your machine, your program\n  bvbench view lathe-toolpost --up y --variant ID,ID      two variants' trees side by side\n\nThe page is one file without a network. Space plays, the arrows step by line, E goes to the next event, ? shows all keys.\n\n{SET_UP_EXAMPLES}")
)]
pub struct Options {
    #[command(flatten)]
    subject: Subject,
    /// The file [default: SCENE.html]
    #[arg(long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    /// Variant whose trees are drawn (see `list`); two are shown side by side [default: the reference box, and one that drifts off its contents]
    #[arg(long = "variant", value_name = "ID", value_delimiter = ',')]
    variants: Vec<String>,
    /// Levels of the trees
    #[arg(long, value_name = "N", default_value_t = 8)]
    levels: u32,
    /// Variant whose trees look for contact [default: the fastest safe one]
    #[arg(long, value_name = "ID")]
    method: Option<String>,
    /// The axis that is up: y as on lathes [default: the one that a lathe's or a mill's controller suggests]
    #[arg(long, value_name = "AXIS")]
    up: Option<UpAxis>,
    /// Open the page in the browser
    #[arg(long)]
    open: bool,
    /// Threads [default: all cores]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print no progress
    #[arg(long, short)]
    quiet: bool,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    super::options::use_threads(options.threads)?;
    if options.variants.len() > 2 {
        bail!("--variant names {} variants; a page shows two beside each other at most", options.variants.len());
    }
    let drawn: Result<Vec<&Variant>> = if options.variants.is_empty() {
        Ok(by_default(registry))
    } else {
        options.variants.iter().map(|id| check::method(Some(id), registry)).collect()
    };
    let (scene, program) = options.subject.load()?;
    let out = options.out.clone().unwrap_or_else(|| PathBuf::from(format!("{}.html", scene.name)));
    options.subject.refuse_output("--out", &out, &scene.files)?;
    let choice = Choice {
        method: check::method(options.method.as_deref(), registry)?,
        registry,
        variants: drawn?,
        levels: options.levels,
        up: options.up.map_or_else(|| view::upright(&scene), Into::into),
        settings: Settings::standard(),
        notes: check::not_examined,
    };
    let bar = Bar::new(options.quiet);
    let data = view::gather(&scene, program.as_ref(), &choice, &bar);
    bar.finish();
    let page = view::page(&data?);
    std::fs::write(&out, &page).with_context(|| format!("cannot write {}", out.display()))?;
    say(format!("{} ({:.1} MB)", out.display(), page.len() as f64 * 1e-6));
    if options.open {
        open(&out)?;
    }
    Ok(CLEAR)
}

/// The reference box, and the first volume that is not safe: what the paper's argument is about.
pub fn by_default(registry: &Registry) -> Vec<&Variant> {
    let variants = || registry.variants().iter();
    let safe = variants().find(|variant| variant.is_reference);
    safe.into_iter().chain(variants().find(|variant| !variant.info.safe && variant.policy.is_some())).collect()
}

/// Hands a file to whatever the system shows pages with.
fn open(page: &Path) -> Result<()> {
    let page = std::path::absolute(page).with_context(|| format!("cannot name {}", page.display()))?;
    let mut command = if cfg!(target_os = "macos") {
        Command::new("open")
    } else if cfg!(windows) {
        let mut command = Command::new("rundll32");
        command.arg("url.dll,FileProtocolHandler");
        command
    } else {
        Command::new("xdg-open")
    };
    let started = command.arg(&page).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    started.with_context(|| format!("no browser can be started; open {} by hand", page.display()))?;
    Ok(())
}
