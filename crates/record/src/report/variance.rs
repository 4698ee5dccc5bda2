//! The report's section on repetition: the sources of the spread of program times, and how often the next run should repeat.

use super::tables::{Table, interval, number};
use super::{Contents, answer};
use crate::analysis::variance;
use crate::analysis::words::listed;
use crate::record::{NULL_VARIANT, VarianceRow};
use std::collections::BTreeSet;

/// The section; empty for a run that was analysed before variance components existed.
pub(super) fn section(contents: &Contents) -> String {
    let is_default = |row: &&VarianceRow| {
        row.variant == NULL_VARIANT || answer::is_default(contents, &row.variant, &row.case().policy())
    };
    let wanted = |row: &&VarianceRow| variance::ranks(&contents.variance, row) && !row.baseline.is_empty();
    let rows: Vec<&VarianceRow> = contents.variance.iter().filter(wanted).filter(is_default).collect();
    let Some(first) = rows.first() else { return String::new() };
    let headings = [
        "scene",
        "variant",
        ">binary, %",
        ">launch, %",
        ">block, %",
        "ratio [over binaries]",
        "[over launches alone]",
        "binaries × launches × blocks for ± 2.5 %",
    ];
    let mut table = Table::new(&headings);
    for row in &rows {
        let percent = |sd: Option<f64>| sd.map_or_else(|| "-".to_owned(), |sd| number(100.0 * sd));
        let within = interval(Some(row.value), row.low_within, row.high_within);
        let planned = [row.planned_binaries, row.planned_launches, row.planned_blocks];
        let planned: Option<Vec<String>> = planned.iter().map(|n| n.map(|n| n.to_string())).collect();
        table.row([
            row.scene.clone(),
            contents.label(&row.variant).to_owned(),
            percent(row.binary_sd),
            percent(row.launch_sd),
            percent(row.block_sd),
            interval(Some(row.value), row.low, row.high),
            row.low_within.map_or_else(|| "-".to_owned(), |_| within),
            planned.map_or_else(|| "-".to_owned(), |planned| planned.join(" × ")),
        ]);
    }
    let VarianceRow { binaries, launches, blocks, baseline, .. } = first;
    let workloads: BTreeSet<String> = rows.iter().map(|row| format!("`{}`", row.workload)).collect();
    let workloads: Vec<String> = workloads.into_iter().collect();
    let of = format!("workload{} {}", if workloads.len() == 1 { "" } else { "s" }, listed(&workloads));
    format!(
        "## Variance components\n\nStandard deviations of the ratio to {baseline} in {of}, by what was repeated: {binaries} \
         binary(ies) of shuffled layout, {launches} launch(es) of each, {blocks} block(s) of each launch. `-` where nothing was repeated. All \
         cases and workloads are in `variance.csv`.\n\n{}{}",
        table.finish(),
        advice(contents)
    )
}

/// How often the next run should repeat.
fn advice(contents: &Contents) -> String {
    let Some(next) = variance::next_run(&contents.variance, &contents.manifest) else {
        return "This run plans nothing: a pilot needs two binaries, two launches of each and two blocks of each launch (`scripts/binaries`, \
                `--binary`).\n\n"
            .to_owned();
    };
    let place = |row: &VarianceRow| format!("{} in {}", contents.label(&row.variant), row.scene);
    let beyond: Vec<String> = next.beyond.iter().map(place).collect();
    let beyond = if beyond.is_empty() {
        String::new()
    } else {
        format!(" Not enough for {}: more than {} binaries.", beyond.join(", "), variance::MOST_BINARIES)
    };
    format!(
        "The next run needs {} binaries, {} launch(es) of each and {} block(s) of each launch, the most of each that a safe volume \
        under its default policy needs: `--plan-from` this folder. {} needs the most binaries.{beyond}\n\n",
        next.binaries,
        next.launches,
        next.blocks,
        place(&next.decisive),
    )
}
