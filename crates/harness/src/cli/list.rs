//! `list`: the variants.

use super::{CLEAR, say, style};
use crate::registry::{Registry, Variant};
use anyhow::Result;
use clap::Args;
use serde_json::json;

#[derive(Args)]
#[command(
    after_help = "SAFE: misses no contact. STANDARD: measured unless a run names its variants; `--variant all` measures every one.\nPOLICY: how its trees are built unless another policy is asked for.\n\nExamples:\n  bvbench list\n  bvbench list --json | jq -r '.[] | select(.safe) | .id'"
)]
pub struct Options {
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    if options.json {
        let entries: Vec<_> = registry.variants().iter().map(entry).collect();
        say(serde_json::to_string_pretty(&entries)?);
        return Ok(CLEAR);
    }
    let mut table = style::plain(["ID", "LABEL", "SAFE", "STANDARD", "POLICY", "REFERENCE"]);
    for variant in registry.variants() {
        let info = &variant.info;
        let row = [info.id, info.label, yes(info.safe), yes(variant.is_standard), &policy(variant), info.reference];
        table.add_row(row);
    }
    say(table.trim_fmt());
    Ok(CLEAR)
}

const fn yes(answer: bool) -> &'static str {
    if answer { "yes" } else { "no" }
}

fn policy(variant: &Variant) -> String {
    variant.policy.map_or_else(|| "-".to_owned(), |policy| policy.to_string())
}

fn entry(variant: &Variant) -> serde_json::Value {
    json!({
        "id": variant.info.id,
        "label": variant.info.label,
        "reference": variant.info.reference,
        "safe": variant.info.safe,
        "standard": variant.is_standard,
        "kind": variant.kind,
        "policy": variant.policy.map(|policy| policy.to_string()),
    })
}
