//! `ablation`: what the parts of the octree method save.

use super::progress::Bar;
use super::{CLEAR, FAILED, check, say};
use crate::analysis::ablation::{PARTS, analyze_ablation};
use crate::analysis::claims::ClaimSet;
use crate::measure::Profile;
use crate::measure::ablation::{Ablation, AblationBudget, ablation};
use crate::record::{AblationRow, AblationTimeRow, ClaimRow};
use crate::registry::Registry;
use anyhow::Result;
use clap::Args;
use comfy_table::{CellAlignment, Table, presets};
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench study ablation                     parts and sweeps over four free-form surfaces, to a million samples\n  bvbench study ablation --profile smoke     the parts alone, fewer poses\n  bvbench study ablation --against ID        compared with the trees of another variant\n\nAn interrupted experiment goes on with the surface where it stopped when the same command is given again.\nExit code 1 when a safe form misses a contact of the meshes."
)]
pub struct Options {
    /// How much: smoke, quick or full
    #[arg(long, default_value_t = Profile::Quick)]
    profile: Profile,
    /// Variant whose trees over the meshes of tool and surface answer the same poses [default: the fastest]
    #[arg(long, value_name = "ID")]
    against: Option<String>,
    /// The thesis's claims [default: those compiled in]
    #[arg(long, value_name = "FILE")]
    claims: Option<PathBuf>,
    /// Folder for the records, the verdicts and the figures
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

pub(super) const fn budget(profile: Profile) -> AblationBudget {
    match profile {
        Profile::Smoke => AblationBudget { rows: 5, step_mm: 3.0, rounds: 1, sweeps: false },
        Profile::Quick => AblationBudget { rows: 15, step_mm: 1.0, rounds: 3, sweeps: true },
        Profile::Full => AblationBudget { rows: 60, step_mm: 0.25, rounds: 9, sweeps: true },
    }
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    let claims = options.claims.as_deref().map_or_else(|| Ok(ClaimSet::standard()), ClaimSet::read)?;
    let against = check::method(options.against.as_deref(), registry)?;
    let bar = Bar::new(options.quiet);
    let Ablation { rows, kinds, times } =
        ablation(&budget(options.profile), against, options.seed, &options.out, &bar)?;
    bar.finish();
    let verdicts = analyze_ablation(&options.out, &claims, options.seed)?;
    let gallery = crate::plot::draw_ablation(&options.out)?;
    if options.json {
        let value = serde_json::json!({ "rows": rows, "kinds": kinds, "times": times, "claims": verdicts });
        say(serde_json::to_string_pretty(&value)?);
    } else {
        say(table(&rows, &times).trim_fmt());
        say(format!("\n{}", verdict_table(&verdicts).trim_fmt()));
        if let Some(sizes) = size_table(&times) {
            say(format!("\n{}", sizes.trim_fmt()));
        }
        say(format!("\nRecords  {}", options.out.join("*.csv").display()));
        gallery.figures.iter().for_each(|figure| say(format!("Figure   {}", options.out.join(&figure.png).display())));
    }
    Ok(if rows.iter().any(|row| row.safe == 1 && row.missed > 0) { FAILED } else { CLEAR })
}

/// The verdicts over all surfaces.
fn verdict_table(verdicts: &[ClaimRow]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header([
        "CLAIM OF THE THESIS",
        "POSES",
        "MEASURE",
        "RATIO",
        "INTERVAL",
        "VERDICT",
    ]);
    for row in verdicts.iter().filter(|row| row.scene == crate::analysis::ALL) {
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"));
        table.add_row([
            row.claim.clone(),
            row.stratum.clone(),
            row.measure.clone(),
            number(row.value),
            format!("{} to {}", number(row.low), number(row.high)),
            row.verdict.clone(),
        ]);
    }
    table
}

/// Rates by size of the surface; `None` when it was not swept.
fn size_table(times: &[AblationTimeRow]) -> Option<Table> {
    let sizes: Vec<&AblationTimeRow> = times.iter().filter(|row| row.sweep == "size").collect();
    let first = sizes.first()?;
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(["SEARCH", "LEVEL 2", "COHERENCE", "SIZE", "BUILD s", "POSES/s"]);
    for row in sizes.iter().filter(|row| row.round == first.round) {
        let same = |other: &&&AblationTimeRow| {
            (&other.search, &other.second_level, other.coherence, other.points)
                == (&row.search, &row.second_level, row.coherence, row.points)
        };
        let (poses, ns) = sizes.iter().filter(same).fold((0, 0), |(poses, ns), row| (poses + row.poses, ns + row.ns));
        table.add_row([
            row.search.clone(),
            row.second_level.clone(),
            if row.coherence == 1 { "yes" } else { "no" }.to_owned(),
            row.points.to_string(),
            format!("{:.2}", row.build_ns as f64 / 1e9),
            format!("{:.0}", poses as f64 * 1e9 / ns.max(1) as f64),
        ]);
    }
    Some(table)
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
    for row in rows.iter().filter(|row| row.sweep == PARTS) {
        let form = (row.search.as_str(), row.second_level.as_str(), row.coherence, row.safe);
        if seen.contains(&form) {
            continue;
        }
        seen.push(form);
        let of = |hit: u8| {
            rows.iter().filter(move |row| {
                row.sweep == PARTS
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
                time.sweep == PARTS
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
