//! `ablation`: what the parts of the octree method save.

use super::progress::Bar;
use super::{CLEAR, FAILED, check, merge, say, style};
use crate::analysis::ablation::{Ablation, Counted, Form, PARTS, Timed, analyze_ablation};
use crate::analysis::claims::ClaimSet;
use crate::analysis::distinct;
use crate::measure::Profile;
use crate::measure::ablation::{Asked, ablation};
use crate::measure::shard::Shard;
use crate::record::ClaimRow;
use crate::registry::Registry;
use anyhow::Result;
use clap::Args;
use comfy_table::Table;
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench study ablation                     parts and sweeps over four free-form surfaces, to a million samples\n  bvbench study ablation --profile smoke     the parts alone, fewer poses\n  bvbench study ablation --against ID        compared with the trees of another variant\n  bvbench study ablation --shard 3/7 --out shards/3\n                                             a seventh of it; `bvbench stage merge shards/* --out DIR`, then this without --shard\n\nAn interrupted experiment goes on with the surface where it stopped when the same command is given again.\nExit code 1 when a safe form misses a contact of the meshes."
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
    /// Time nothing
    #[arg(long)]
    counts_only: bool,
    /// Carry out one shard, number I of N; its units stay in DIR for `stage merge`
    #[arg(long, value_name = "I/N", requires = "out")]
    shard: Option<Shard>,
    /// Replace an experiment of another request that is in the folder
    #[arg(long)]
    fresh: bool,
    /// Print the counts as JSON
    #[arg(long)]
    json: bool,
    /// Print no progress
    #[arg(long, short)]
    quiet: bool,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    let claims = options.claims.as_deref().map_or_else(|| Ok(ClaimSet::standard()), ClaimSet::read)?;
    let against = check::method(options.against.as_deref(), registry)?;
    let bar = Bar::new(options.quiet);
    let asked = Asked { profile: options.profile, against, seed: options.seed, shard: options.shard };
    ablation(&asked, &options.out, options.fresh, !options.counts_only, &bar)?;
    bar.finish();
    if let Some(shard) = options.shard {
        say(merge::next_step(shard, &options.out));
        return Ok(CLEAR);
    }
    let Ablation { rows, kinds, times } = Ablation::read(&options.out)?;
    let verdicts = analyze_ablation(&options.out, &claims)?;
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
    Ok(if rows.iter().any(|row| row.form.safe == 1 && row.counts.missed > 0) { FAILED } else { CLEAR })
}

/// The verdicts over all surfaces.
fn verdict_table(verdicts: &[ClaimRow]) -> Table {
    let mut table = style::plain(["CLAIM OF THE THESIS", "POSES", "MEASURE", "RATIO", "INTERVAL", "VERDICT"]);
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
fn size_table(times: &[Timed]) -> Option<Table> {
    let sizes: Vec<&Timed> = times.iter().filter(|row| row.form.sweep == "size").collect();
    let first = sizes.first()?;
    let mut table = style::plain(["SEARCH", "LEVEL 2", "COHERENCE", "SIZE", "BUILD s", "POSES/s"]);
    for row in sizes.iter().filter(|row| row.round == first.round) {
        let same = |other: &&&Timed| {
            (&other.form.search, &other.form.second_level, other.form.coherence, other.form.points)
                == (&row.form.search, &row.form.second_level, row.form.coherence, row.form.points)
        };
        let (poses, ns) = sizes.iter().filter(same).fold((0, 0), |(poses, ns), row| (poses + row.poses, ns + row.ns));
        table.add_row([
            row.form.search.clone(),
            row.form.second_level.clone(),
            if row.form.coherence == 1 { "yes" } else { "no" }.to_owned(),
            row.form.points.to_string(),
            format!("{:.2}", row.build_ns as f64 / 1e9),
            format!("{:.0}", poses as f64 * 1e9 / ns.max(1) as f64),
        ]);
    }
    Some(table)
}

/// What tells the forms of the method apart: search, second level, coherence, and whether it is safe.
fn key(form: &Form) -> (&str, &str, u8, u8) {
    (&form.search, &form.second_level, form.coherence, form.safe)
}

/// Of the parts: means per pose over all surfaces.
fn table(rows: &[Counted], times: &[Timed]) -> Table {
    let mut table = style::plain([
        "SEARCH",
        "LEVEL 2",
        "COHERENCE",
        "MODE",
        ">BOX TESTS hit",
        ">free",
        ">POINT TESTS hit",
        ">free",
        ">us A POSE",
        ">MISSED",
    ]);
    for form in distinct(rows.iter().filter(|row| row.form.sweep == PARTS).map(|row| key(&row.form))) {
        let of = |hit: u8| {
            rows.iter().filter(move |row| row.form.sweep == PARTS && row.hit() == hit && key(&row.form) == form)
        };
        let mean = |hit: u8, part: &dyn Fn(&Counted) -> u64| {
            let poses: u64 = of(hit).map(|row| row.counts.poses).sum();
            format!("{:.1}", of(hit).map(part).sum::<u64>() as f64 / poses.max(1) as f64)
        };
        let of_times = || times.iter().filter(|time| time.form.sweep == PARTS && key(&time.form) == form);
        let poses: u64 = of_times().map(|time| time.poses).sum();
        let missed: u64 = of(0).map(|row| row.counts.missed).sum();
        let touching: u64 = of(0).chain(of(1)).map(|row| row.counts.touching).sum();
        table.add_row([
            form.0.to_owned(),
            form.1.to_owned(),
            if form.2 == 1 { "yes" } else { "no" }.to_owned(),
            if form.3 == 1 { "safe" } else { "sampling" }.to_owned(),
            mean(1, &Counted::box_tests),
            mean(0, &Counted::box_tests),
            mean(1, &|row| row.counts.triangle_tests),
            mean(0, &|row| row.counts.triangle_tests),
            format!("{:.2}", of_times().map(|time| time.ns).sum::<u64>() as f64 / 1e3 / poses.max(1) as f64),
            format!("{missed} of {touching}"),
        ]);
    }
    table
}
