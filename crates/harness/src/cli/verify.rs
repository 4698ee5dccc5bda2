//! `verify`: verdicts against the exact truth.

use super::options::RunOptions;
use super::progress::Bar;
use super::{CLEAR, FAILED, merge, say, style};
use crate::measure::Verification;
use crate::record::VerificationRow;
use crate::registry::Registry;
use anyhow::Result;
use clap::Args;
use comfy_table::Table;
use serde_json::json;
use std::collections::BTreeMap;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench stage verify                         100 000 posed pairs per scene, the standard variants\n  bvbench stage verify --profile full          a million of them\n  bvbench stage verify --scene lathe-toolpost --variant ID --json\n  bvbench stage verify --profile smoke --policy sah16/own/4\n\nExit code 1 when a safe variant misses a contact deeper than 1e-6 mm, or a triangle test disagrees with its integer twin."
)]
pub struct Options {
    #[command(flatten)]
    run: RunOptions,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    let mut run = options.run.open(registry)?;
    let bar = Bar::new(options.run.output.quiet);
    let verification = run.verify(&bar)?;
    bar.finish();
    if options.run.output.json {
        say(serde_json::to_string_pretty(&as_json(&verification))?);
    } else {
        say(table(&verification).trim_fmt());
        say(format!("\n{}", verdict(&verification)));
        let rows = || format!("Rows by depth band: {}", run.folder().join("verification.csv").display());
        say(run.plan().shard.map_or_else(rows, |shard| merge::next_step(shard, run.folder())));
    }
    Ok(if verification.holds() { CLEAR } else { FAILED })
}

/// Sums over workloads, pairs and bands of one case in one scene.
#[derive(Clone, Copy, Default)]
struct Sums {
    safe: bool,
    poses: u64,
    colliding: u64,
    missed: u64,
    missed_grazing: u64,
    false_positives: u64,
}

fn sums(rows: &[VerificationRow]) -> BTreeMap<(String, String, String), Sums> {
    let mut sums: BTreeMap<_, Sums> = BTreeMap::new();
    for row in rows {
        let sum = sums.entry((row.scene.clone(), row.variant.clone(), row.case().policy())).or_default();
        sum.safe = row.safe == 1;
        sum.poses += row.poses;
        sum.false_positives += row.false_positives;
        if row.band.is_above_grazing() {
            sum.colliding += row.exact;
            sum.missed += row.missed;
        } else {
            sum.missed_grazing += row.missed;
        }
    }
    sums
}

pub fn table(verification: &Verification) -> Table {
    let mut table =
        style::plain(["SCENE", "VARIANT", "POLICY", "SAFE", ">POSES", ">COLLIDING", ">MISSED", ">GRAZING", ">FALSE+"]);
    for ((scene, variant, policy), sum) in sums(&verification.rows) {
        let safe = if sum.safe { "yes" } else { "no" };
        let counts = [sum.poses, sum.colliding, sum.missed, sum.missed_grazing, sum.false_positives];
        table.add_row([scene, variant, policy, safe.to_owned()].into_iter().chain(counts.map(|n| n.to_string())));
    }
    table
}

/// The verification in a sentence or two.
pub fn verdict(verification: &Verification) -> String {
    let check = &verification.cross_check;
    let twin = format!(
        "The triangle test of the leaves, the exact one and their integer twin agree on {} of {} pairs ({} touching, {} degenerate).",
        check.pairs - check.disagreements,
        check.pairs,
        check.touching,
        check.degenerate
    );
    let broken: Vec<String> = verification
        .broken_promises()
        .map(|row| {
            format!(
                "  {} {} on {} {}: {} missed in band {}",
                row.variant,
                row.case().policy(),
                row.scene,
                row.pair,
                row.missed,
                row.band.id()
            )
        })
        .collect();
    if broken.is_empty() {
        format!("No safe variant misses a contact above grazing.\n{twin}")
    } else {
        format!("SAFE VARIANTS MISS CONTACTS:\n{}\n{twin}", broken.join("\n"))
    }
}

/// The verification as data.
pub fn as_json(verification: &Verification) -> serde_json::Value {
    let cases: Vec<_> = sums(&verification.rows)
        .into_iter()
        .map(|((scene, variant, policy), sum)| {
            json!({
                "scene": scene, "variant": variant, "policy": policy, "safe": sum.safe, "poses": sum.poses,
                "colliding": sum.colliding, "missed": sum.missed, "missed_grazing": sum.missed_grazing,
                "false_positives": sum.false_positives,
            })
        })
        .collect();
    json!({ "holds": verification.holds(), "cross_check": verification.cross_check, "cases": cases })
}
