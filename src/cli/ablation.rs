//! `ablation`: what the parts of the octree method save.

use super::progress::Bar;
use super::{CLEAR, FAILED, say};
use crate::measure::Profile;
use crate::measure::ablation::{AblationBudget, ablation};
use crate::record::{AblationRow, AblationTimeRow, write_rows};
use anyhow::Result;
use clap::Args;
use comfy_table::{CellAlignment, Table, presets};
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench ablation                     parts and sweeps over four free-form surfaces\n  bvbench ablation --profile smoke     the parts alone, fewer poses\n\nExit code 1 when a safe form misses a contact of the meshes."
)]
pub struct Options {
    /// How much: smoke, quick or full
    #[arg(long, default_value_t = Profile::Quick)]
    profile: Profile,
    /// Folder for ablation.csv and ablation_times.csv
    #[arg(long, value_name = "DIR", default_value = "results/ablation")]
    out: PathBuf,
    /// Seed of the order in which forms are timed
    #[arg(long, value_name = "SEED", default_value_t = 2006)]
    seed: u64,
    /// Print the counts as JSON
    #[arg(long)]
    json: bool,
    /// Print no progress
    #[arg(long, short)]
    quiet: bool,
}

const fn budget(profile: Profile) -> AblationBudget {
    match profile {
        Profile::Smoke => AblationBudget { points: 50, rows: 5, rounds: 1, sweeps: false },
        Profile::Quick => AblationBudget { points: 100, rows: 15, rounds: 3, sweeps: true },
        Profile::Full => AblationBudget { points: 400, rows: 65, rounds: 9, sweeps: true },
    }
}

pub fn run(options: &Options) -> Result<u8> {
    let bar = Bar::new(options.quiet);
    let (rows, times) = ablation(&budget(options.profile), options.seed, &bar)?;
    bar.finish();
    write_rows(&options.out, &rows)?;
    write_rows(&options.out, &times)?;
    if options.json {
        say(serde_json::to_string_pretty(&rows)?);
    } else {
        say(table(&rows, &times).trim_fmt());
        say(format!("\nAll forms, surfaces and sweeps: {}", options.out.join("ablation.csv").display()));
    }
    Ok(if rows.iter().any(|row| row.safe == 1 && row.missed > 0) { FAILED } else { CLEAR })
}

/// Of the parts: means per pose over all surfaces.
fn table(rows: &[AblationRow], times: &[AblationTimeRow]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header([
        "SEARCH",
        "LEVEL 2",
        "COHERENCE",
        "MODE",
        "BOX TESTS hit",
        "free",
        "POINT TESTS hit",
        "free",
        "us A POSE",
        "MISSED",
    ]);
    let mut seen: Vec<(&str, &str, u8, u8)> = Vec::new();
    for row in rows.iter().filter(|row| row.sweep == "parts") {
        let form = (row.search.as_str(), row.second_level.as_str(), row.coherence, row.safe);
        if seen.contains(&form) {
            continue;
        }
        seen.push(form);
        let of = |hit: u8| {
            rows.iter().filter(move |row| {
                row.sweep == "parts"
                    && row.hit == hit
                    && (row.search.as_str(), row.second_level.as_str(), row.coherence, row.safe) == form
            })
        };
        let mean = |hit: u8, part: &dyn Fn(&AblationRow) -> u64| {
            let poses: u64 = of(hit).map(|row| row.poses).sum();
            format!("{:.1}", of(hit).map(part).sum::<u64>() as f64 / poses.max(1) as f64)
        };
        let boxes = |row: &AblationRow| row.first_level + row.second_level_tests;
        let of_times = || {
            times.iter().filter(|time| {
                time.sweep == "parts"
                    && (time.search.as_str(), time.second_level.as_str(), time.coherence, time.safe) == form
            })
        };
        let poses: u64 = of_times().map(|time| time.poses).sum();
        let missed: u64 = of(0).map(|row| row.missed).sum();
        let touching: u64 = of(0).chain(of(1)).map(|row| row.touching).sum();
        table.add_row([
            form.0.to_owned(),
            form.1.to_owned(),
            if form.2 == 1 { "yes" } else { "no" }.to_owned(),
            if form.3 == 1 { "safe" } else { "sampling" }.to_owned(),
            mean(1, &boxes),
            mean(0, &boxes),
            mean(1, &|row| row.point_tests),
            mean(0, &|row| row.point_tests),
            format!("{:.2}", of_times().map(|time| time.ns).sum::<u64>() as f64 / 1e3 / poses.max(1) as f64),
            format!("{missed} of {touching}"),
        ]);
    }
    for column in 4..10 {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}
