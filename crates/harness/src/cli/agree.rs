//! `agree`: exact engines asked about posed pairs by the million.

use super::options::{DEFAULT_SEED, OutputOptions, use_threads};
use super::progress::Bar;
use super::{CLEAR, FAILED, say, style};
use crate::measure::agreement::{Agreement, AgreementRun, Asked, MOST_CASES, replay};
use crate::measure::shard::Shard;
use crate::measure::{Plan, Profile, Selection};
use crate::method::wide::{ALIGNED, ORIENTED};
use crate::record::{DisagreementRow, Kind, RoundRow, read_rows};
use crate::registry::{Registry, Variant};
use crate::scene::Scene;
use anyhow::{Result, anyhow, ensure};
use clap::Args;
use comfy_table::Table;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Exact engines of different volumes that are quick enough to be asked by the million.
const DEFAULT_VARIANTS: [&str; 2] = [ORIENTED.id, ALIGNED.id];

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench study agree                                           7 million posed pairs\n  bvbench study agree --poses 4000000 --rounds 48               a billion, resumable\n  bvbench study agree --poses 4000000 --rounds 48 --shard 2/8   an eighth of them\n  bvbench study agree --scene my-scene --variant ID --variant ID\n  bvbench study agree --replay results/agreement                the disagreements once more\n\nTo merge shards, put their `units` into one folder and give the command again without --shard. A folder takes rounds of one executable.\n\nExit code 1 when an engine disagrees with a contact that another one found, or with the exact truth."
)]
pub struct Options {
    /// Scene by name or by path; repeatable [default: all that are shipped]
    #[arg(long = "scene", value_name = "NAME|PATH")]
    scenes: Vec<String>,
    /// Exact variant by id (see `list`); repeatable [default: the eight-wide trees of oriented boxes and of boxes along the axes, which share little but the test of triangles]
    #[arg(long = "variant", value_name = "ID")]
    variants: Vec<String>,
    /// Posed pairs of each scene in a round, about
    #[arg(long, default_value_t = 1_000_000, value_name = "N", value_parser = clap::value_parser!(u64).range(100..=10_000_000))]
    poses: u64,
    /// Rounds, each with a seed of its own
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    rounds: u32,
    /// How many posed pairs of each scene and round the exact truth is asked about, too
    #[arg(long, default_value_t = 10_000, value_name = "N", value_parser = clap::value_parser!(u64).range(..=10_000_000))]
    exhaustive: u64,
    /// Seed of the first round
    #[arg(long, default_value_t = DEFAULT_SEED)]
    seed: u64,
    /// Carry out the I-th of N parts of the rounds
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Folder of the rounds
    #[arg(long, default_value = "results/agreement", value_name = "DIR")]
    out: PathBuf,
    /// Ask again about the disagreements that are in a folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["rounds", "shard"])]
    replay: Option<PathBuf>,
    /// Threads [default: all cores]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    #[command(flatten)]
    output: OutputOptions,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    use_threads(options.threads)?;
    let plan = options.plan(registry)?;
    if let Some(folder) = &options.replay {
        return replay_all(&plan, folder);
    }
    let asked = Asked {
        poses: usize::try_from(options.poses)?,
        exhaustive: usize::try_from(options.exhaustive)?,
        first_seed: options.seed,
    };
    let bar = Bar::new(options.output.quiet);
    let run = AgreementRun::open(plan, asked, &options.out)?;
    let agreement = run.run(options.rounds as usize, options.shard, &bar)?;
    bar.finish();
    let total = total(&agreement.rounds);
    if options.output.json {
        say(serde_json::to_string_pretty(&json!({ "total": total, "rounds": agreement.rounds.len() }))?);
    } else {
        say(table(&agreement).trim_fmt());
        say(format!("\n{}", told(&total)));
        say(format!("Rows: {}", options.out.join("agreement.csv").display()));
    }
    Ok(if total.disagreements == 0 { CLEAR } else { FAILED })
}

impl Options {
    fn plan(&self, registry: &Registry) -> Result<Plan> {
        let or = |asked: &[String], other: &[&str]| -> Vec<String> {
            if asked.is_empty() { other.iter().map(|&name| name.to_owned()).collect() } else { asked.to_vec() }
        };
        let selection = Selection {
            profile: Profile::Full,
            scenes: or(&self.scenes, Scene::SHIPPED),
            variants: or(&self.variants, &DEFAULT_VARIANTS),
            workloads: Vec::new(),
            policies: Vec::new(),
            seed: self.seed,
        };
        let plan = Plan::new(selection, registry)?;
        ensure!(plan.variants.len() <= MOST_CASES, "at most {MOST_CASES} variants are asked");
        // Samples widened to be safe report contacts that are none; a library's own triangle test proves nothing.
        let is_exact = |variant: &Variant| variant.info.safe && matches!(variant.kind, Kind::Volume | Kind::Engine);
        if let Some(inexact) = plan.variants.iter().find(|variant| !is_exact(variant)) {
            return Err(anyhow!("`{}` is no exact engine: name safe volumes or engines", inexact.info.id));
        }
        Ok(plan)
    }
}

fn total(rounds: &[RoundRow]) -> RoundRow {
    let sum = |count: fn(&RoundRow) -> u64| rounds.iter().map(count).sum();
    RoundRow {
        seed: rounds.first().map_or(0, |round| round.seed),
        poses: sum(|round| round.poses),
        verdicts: sum(|round| round.verdicts),
        contacts: sum(|round| round.contacts),
        exhaustive: sum(|round| round.exhaustive),
        disagreements: sum(|round| round.disagreements),
        seconds: rounds.iter().map(|round| round.seconds).sum(),
    }
}

fn told(total: &RoundRow) -> String {
    let RoundRow { poses, contacts, verdicts, exhaustive, disagreements, seconds, .. } = total;
    let rate = *poses as f64 / seconds.max(1e-9);
    format!(
        "{poses} posed pairs, {contacts} of them in contact; {verdicts} verdicts, {exhaustive} posed pairs also by the exact truth: {disagreements} wrong verdicts.\n{seconds:.0} s, {rate:.0} posed pairs per second, 10^9 in {:.1} hours.",
        1e9 / rate / 3600.0
    )
}

/// Sums over workloads, pairs and bands.
fn table(agreement: &Agreement) -> Table {
    let mut table = style::plain(["SCENE", "CASE", "POSES", "CONTACTS", "MISSED", "EXHAUSTIVE", "FALSE+"]);
    let mut sums = std::collections::BTreeMap::new();
    for row in &agreement.rows {
        let sum: &mut [u64; 5] = sums.entry((&row.scene, &row.case)).or_default();
        let counts = [row.poses, row.contacts, row.missed, row.exhaustive, row.false_positives];
        sum.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
    }
    for ((scene, case), counts) in sums {
        table.add_row([scene, case].map(String::clone).into_iter().chain(counts.map(|count| count.to_string())));
    }
    table
}

fn replay_all(plan: &Plan, folder: &Path) -> Result<u8> {
    let rows: Vec<DisagreementRow> = read_rows(folder)?;
    for row in &rows {
        let (verdicts, touches) = replay(plan, row).map_err(|cause| anyhow!("{}: {cause}", folder.display()))?;
        let verdicts: Vec<String> = verdicts.iter().map(|(case, touching)| format!("{case} {touching}")).collect();
        say(format!(
            "{} {} {} seed {}: exact {touches}, {}",
            row.scene,
            row.workload,
            row.pair,
            row.seed,
            verdicts.join(", ")
        ));
    }
    say(format!("{} disagreements", rows.len()));
    Ok(if rows.is_empty() { CLEAR } else { FAILED })
}
