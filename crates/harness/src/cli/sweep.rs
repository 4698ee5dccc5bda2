//! `sweep`: one quantity varied, everything else held.

use super::options::{OutputOptions, StudyOptions, use_threads};
use super::progress::Bar;
use super::{CLEAR, merge, say, style};
use crate::analysis::distinct;
use crate::analysis::growth::COSTS;
use crate::analysis::summary::ALL;
use crate::analysis::sweep::analyze_sweep;
use crate::measure::Profile;
use crate::measure::sweep::{Asked, SWEEPS, Sweep, SweepRun};
use crate::record::{SweepGrowthRow, has_rows, read_rows};
use crate::registry::Registry;
use anyhow::Result;
use clap::Args;
use comfy_table::Table;
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench study sweep                              the names of the sweeps\n  bvbench study sweep rotation --profile smoke     how much the choice of the model's frame matters\n  bvbench study sweep grading --variant ID --variant ID --counts-only\n  bvbench study sweep size --density 10 --variant ID --variant ID\n                                             how builds and queries grow, to a million triangles\n  bvbench study sweep all --profile quick\n  bvbench study sweep size --shard 3/7 --out shards/3\n                                             a seventh of it; `bvbench stage merge shards/*/size --out DIR/size`, then this with --out DIR\n                                             and without --shard\n\nAn interrupted sweep goes on where it stopped when the same command is given again."
)]
pub struct Options {
    /// Which sweep, or `all`; without a name they are listed
    name: Option<String>,
    /// How much: smoke (seconds each), quick (minutes), full (hours)
    #[arg(long, default_value = "quick", value_name = "PROFILE")]
    profile: Profile,
    /// Folder of sweeps; each has a folder of its name in it [default: results/sweeps-PROFILE]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Variant by id (see `list`); repeatable [default: the safe volumes; for the path step all volumes]
    #[arg(long = "variant", value_name = "ID")]
    variants: Vec<String>,
    /// Highest tessellation density in the sweep of the size; 10 makes a million triangles [default: 0.5, 2 or 16, by the profile]
    #[arg(long, value_name = "X")]
    density: Option<f64>,
    #[command(flatten)]
    study: StudyOptions,
    /// Replace a sweep of another request that is in the folder
    #[arg(long)]
    fresh: bool,
    #[command(flatten)]
    output: OutputOptions,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    use_threads(options.study.threads)?;
    let out = options.out.clone().unwrap_or_else(|| format!("results/sweeps-{}", options.profile).into());
    let Some(name) = &options.name else {
        say(list(options.output.json)?);
        return Ok(CLEAR);
    };
    let sweeps = if name == "all" { SWEEPS.to_vec() } else { vec![Sweep::find(name)?] };
    let mut done = Vec::new();
    for sweep in sweeps {
        let folder = out.join(sweep.name);
        let figures = carry_out(sweep, options, registry, &folder)?;
        if let Some(shard) = options.study.shard {
            say(merge::next_step(shard, &folder));
        } else if !options.output.json {
            say(format!("{:9} {}", sweep.name, folder.join("sweep_summary.csv").display()));
            figures.iter().for_each(|figure| say(format!("          {}", figure.display())));
            if has_rows::<SweepGrowthRow>(&folder) {
                say(format!("\n{}\n", growth(&read_rows(&folder)?).trim_fmt()));
            }
        }
        let figures: Vec<_> = figures.iter().map(|figure| figure.to_string_lossy()).collect();
        done.push(json!({ "sweep": sweep.name, "out": folder.to_string_lossy(), "figures": figures }));
    }
    if options.output.json && options.study.shard.is_none() {
        say(serde_json::to_string_pretty(&done)?);
    }
    Ok(CLEAR)
}

fn carry_out(sweep: Sweep, options: &Options, registry: &Registry, folder: &Path) -> Result<Vec<PathBuf>> {
    let bar = Bar::new(options.output.quiet);
    let asked = Asked {
        profile: options.profile,
        variants: options.variants.clone(),
        seed: options.study.seed,
        density: options.density,
        shard: options.study.shard,
    };
    let mut run = SweepRun::open(sweep, &asked, registry, folder, options.fresh)?;
    run.run(!options.study.counts_only, &bar)?;
    bar.finish();
    if options.study.shard.is_some() {
        return Ok(Vec::new());
    }
    analyze_sweep(folder)?;
    let gallery = crate::plot::draw_sweep(folder, sweep.about, sweep.axis)?;
    Ok(gallery.figures.iter().map(|figure| folder.join(&figure.png)).collect())
}

/// What every variant's costs grow with.
fn growth(rows: &[SweepGrowthRow]) -> Table {
    let header = std::iter::once("GROWTH: COST ~ TRIANGLES^X".to_owned()).chain(COSTS.map(str::to_uppercase));
    let mut table = style::plain(header);
    for (variant, stratum) in distinct(rows.iter().map(|row| (&*row.variant, &*row.stratum))) {
        let exponent = |cost: &str| {
            let mut of_it = rows.iter().filter(|row| row.variant == variant && row.stratum == stratum);
            let row = of_it.find(|row| row.metric == cost);
            row.map_or_else(String::new, |SweepGrowthRow { exponent, low, high, .. }| {
                if low.is_finite() { format!("{exponent:.2} [{low:.2}, {high:.2}]") } else { format!("{exponent:.2}") }
            })
        };
        let name = if stratum == ALL { variant.to_owned() } else { format!("{variant}, {stratum}") };
        table.add_row(std::iter::once(name).chain(COSTS.map(exponent)));
    }
    table
}

fn list(as_json: bool) -> Result<String> {
    if as_json {
        let entries: Vec<_> = SWEEPS.iter().map(|s| json!({ "name": s.name, "about": s.about })).collect();
        return Ok(serde_json::to_string_pretty(&entries)?);
    }
    let mut table = style::plain(["SWEEP", "WHAT IS VARIED"]);
    for sweep in SWEEPS {
        table.add_row([sweep.name, sweep.about]);
    }
    Ok(table.trim_fmt())
}
