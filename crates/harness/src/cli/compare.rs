//! `compare`: two runs compared with each other.

use super::options::check_rows;
use super::style::{Tone, is_coloured, painted, table};
use super::{CLEAR, FAILED, say};
use crate::analysis::ALL;
use crate::analysis::compare::{Comparison, Gate, SceneMatch, TimeChange, compare_runs};
use anyhow::Result;
use clap::Args;
use comfy_table::Table;
use serde_json::json;
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench stage compare results/before results/after\n  bvbench stage compare results/before results/after --all\n  bvbench stage compare results/before results/after --allow counts\n  bvbench stage compare results/before results/after --json | jq '.times[] | select(.change == \"slower\")'\n\nScenes are compared where their inputs have the same content in both runs. Times are paired by launch at the same poses; one has changed when its whole 95 % interval lies outside what the runs' null comparisons call equal, and a single launch leaves it undecided. Counts, trees and misses are exact.\nThe later run fails at a gate when a case misses more contacts (misses), when counts or trees differ (counts), when a case's queries over all strata, programs or construction are slower (slower), and when a scene or case of the earlier run is not compared (uncompared). --allow opens a gate, but none for runs that have nothing in common.\nExit codes: 0 no gate fails, 1 one does, 2 a run cannot be read."
)]
pub struct Options {
    /// Folder of the earlier run
    #[arg(value_name = "RUN_A")]
    before: PathBuf,
    /// Folder of the later run
    #[arg(value_name = "RUN_B")]
    after: PathBuf,
    /// Show times that did not change, too, and every stratum
    #[arg(long)]
    all: bool,
    /// Let the later run through this gate: misses, counts, slower, uncompared; repeatable
    #[arg(long, value_name = "GATE")]
    allow: Vec<Gate>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    /// Take raw rows that changed since a run wrote them
    #[arg(long)]
    accept_changed_rows: bool,
}

/// The words of a change.
const TONES: [(&str, Tone); 6] = [
    ("FAILS", Tone::Bad),
    ("slower", Tone::Bad),
    ("faster", Tone::Good),
    ("REGRESSION", Tone::Bad),
    ("undecided", Tone::Doubtful),
    ("noise", Tone::Dim),
];

pub fn run(options: &Options) -> Result<u8> {
    for run in [&options.before, &options.after] {
        check_rows(run, options.accept_changed_rows)?;
    }
    let comparison = compare_runs(&options.before, &options.after)?;
    let mut failed = comparison.failed();
    failed.retain(|gate| comparison.is_of_nothing() || !options.allow.contains(gate));
    if options.json {
        let mut result = serde_json::to_value(&comparison)?;
        result["failed"] = json!(failed);
        say(serde_json::to_string_pretty(&result)?);
    } else {
        say(painted(text(&comparison, options.all).trim_end(), &TONES, is_coloured()));
        say(format!("\n{}", verdict(&failed)));
    }
    Ok(if failed.is_empty() { CLEAR } else { FAILED })
}

/// The gates in a sentence.
fn verdict(failed: &[Gate]) -> String {
    if failed.is_empty() {
        return "The second run may take the place of the first.".to_owned();
    }
    let names: Vec<&str> = failed.iter().map(|gate| gate.id()).collect();
    format!("The second run FAILS: {}", names.join(", "))
}

fn text(comparison: &Comparison, all: bool) -> String {
    let mut text = String::new();
    let mut line = |words: String| text += &format!("{words}\n");
    comparison.notes.iter().for_each(|note| line(format!("Note: {note}")));
    comparison.scenes.iter().for_each(|scene| line(scene_line(scene)));
    for (cases, which) in [(&comparison.only_before, "first"), (&comparison.only_after, "second")] {
        if !cases.is_empty() {
            line(format!("In the {which} run only: {}", cases.join("; ")));
        }
    }
    let is_shown = |row: &&TimeChange| all || (row.change != "noise" && [ALL, "-"].contains(&row.stratum.as_str()));
    let times: Vec<&TimeChange> = comparison.times.iter().filter(is_shown).collect();
    let compared = comparison.compared;
    let of_times = (times.len(), compared.times);
    section(&mut text, "Times, after / before", of_times, "none has changed beyond noise", || times_table(&times));
    let counts = comparison.counts.iter().filter(|row| all || row.stratum == ALL).count();
    let of_counts = (counts, compared.counts);
    section(&mut text, "Counts of a query", of_counts, "the same, query by query", || counts_table(comparison, all));
    section(&mut text, "Trees", (comparison.trees.len(), compared.trees), "the same", || trees_table(comparison));
    let of_misses = (comparison.misses.len(), compared.misses);
    section(&mut text, "Contacts missed", of_misses, "the same", || misses_table(comparison));
    let of_verdicts = (comparison.verdicts.len(), compared.verdicts);
    section(&mut text, "Verdicts", of_verdicts, "the same", || verdicts_table(comparison));
    text
}

/// A heading with its table, or with what is to be said when there are no rows: `none` where something was compared.
fn section(
    text: &mut String,
    title: &str,
    (rows, compared): (usize, usize),
    none: &str,
    table: impl FnOnce() -> Table,
) {
    if rows == 0 {
        *text += &format!("\n{title}: {}\n", if compared == 0 { "nothing compared" } else { none });
    } else {
        *text += &format!("\n{title}\n{}\n", table().trim_fmt());
    }
}

fn scene_line(scene: &SceneMatch) -> String {
    let SceneMatch { scene: name, not_compared, same_poses, noise, program_noise, drift } = scene;
    if let Some(reason) = not_compared {
        return format!("{name}: not compared, for {reason}");
    }
    let how = if *same_poses { " and poses" } else { ", other poses, so that only builds, trees and misses compare" };
    let all_alike = drift.map_or_else(String::new, |ratio| format!("; all together {ratio:.3}"));
    let of_programs = program_noise.filter(|_| *same_poses);
    let of_programs = of_programs.map_or_else(String::new, |noise| format!(", of programs {noise:.3}"));
    format!("{name}: same inputs{how}; noise up to {noise:.3}{of_programs}{all_alike}")
}

fn times_table(rows: &[&TimeChange]) -> Table {
    let mut table = table(&["SCENE", "VARIANT", "POLICY", "WHAT", "POSES", ">RATIO [95 %]", "CHANGE"]);
    for row in rows {
        table.add_row([
            row.scene.clone(),
            row.variant.clone(),
            row.policy.clone(),
            row.metric.clone(),
            row.stratum.clone(),
            with_interval(row),
            row.change.clone(),
        ]);
    }
    table
}

/// A ratio, with its interval if it has one.
fn with_interval(row: &TimeChange) -> String {
    let interval = if row.low.is_finite() { format!(" [{:.3}, {:.3}]", row.low, row.high) } else { String::new() };
    format!("{:.3}{interval}", row.ratio)
}

fn counts_table(comparison: &Comparison, all: bool) -> Table {
    let headings = ["SCENE", "VARIANT", "POLICY", "POSES", ">DIFFER", ">VOLUME TESTS", ">TRIANGLE"];
    let mut table = table(&headings);
    for row in comparison.counts.iter().filter(|row| all || row.stratum == ALL) {
        table.add_row([
            row.scene.clone(),
            row.variant.clone(),
            row.policy.clone(),
            row.stratum.clone(),
            format!("{} of {}", row.differing, row.queries),
            change(row.volume_tests),
            change(row.triangle_tests),
        ]);
    }
    table
}

fn trees_table(comparison: &Comparison) -> Table {
    let mut table = table(&["SCENE", "PART", "VARIANT", "POLICY", "WHAT", ">BEFORE", ">AFTER"]);
    for row in &comparison.trees {
        let counts =
            [("nodes", row.nodes), ("bytes", row.bytes)].map(|(what, (old, new))| (what, old as f64, new as f64));
        let floats = [("looseness", row.looseness), ("overhang, mm", row.overhang_mm)];
        let values = counts.into_iter().chain(floats.map(|(what, (old, new))| (what, old, new)));
        // Which of them differ: a tree is named once.
        let mut names = [&*row.scene, &row.part, &row.variant, &row.policy];
        for (what, old, new) in values.filter(|(_, old, new)| old.to_bits() != new.to_bits()) {
            let [scene, part, variant, policy] = std::mem::take(&mut names);
            table.add_row([scene, part, variant, policy, what, &digits(old), &digits(new)]);
        }
    }
    table
}

/// Whole numbers as they are, others with six digits after the point.
fn digits(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.6}") }
}

fn misses_table(comparison: &Comparison) -> Table {
    let mut table = table(&["SCENE", "WORKLOAD", "VARIANT", "POLICY", ">BEFORE", ">AFTER", ""]);
    for row in &comparison.misses {
        table.add_row([
            row.scene.clone(),
            row.workload.clone(),
            row.variant.clone(),
            row.policy.clone(),
            format!("{} of {}", row.missed.0, row.colliding.0),
            format!("{} of {}", row.missed.1, row.colliding.1),
            (if row.is_regression { "REGRESSION" } else { "" }).to_owned(),
        ]);
    }
    table
}

fn verdicts_table(comparison: &Comparison) -> Table {
    let mut table = table(&["CLAIM", "READING", "SCENE", "WORKLOAD", "POSES", "BEFORE", "AFTER"]);
    for row in &comparison.verdicts {
        table.add_row([&row.claim, &row.reading, &row.scene, &row.workload, &row.stratum, &row.before, &row.after]);
    }
    table
}

/// Two counts, or that they are one.
fn change((before, after): (u64, u64)) -> String {
    if before == after { "same".to_owned() } else { format!("{before} -> {after}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Plan, Run};
    use tempfile::TempDir;

    fn folder(change: impl Fn(&mut Run)) -> TempDir {
        let folder = TempDir::new().unwrap();
        let mut run = Run::generate(&Plan::default());
        change(&mut run);
        run.write(folder.path());
        folder
    }

    fn options(before: &TempDir, after: &TempDir, json: bool) -> Options {
        Options {
            before: before.path().to_owned(),
            after: after.path().to_owned(),
            all: false,
            allow: Vec::new(),
            json,
            accept_changed_rows: false,
        }
    }

    #[test]
    fn a_failed_gate_is_the_exit_code() {
        let before = folder(|_| {});
        assert_eq!(run(&options(&before, &before, false)).unwrap(), CLEAR);
        let deep = folder(|run| {
            let stray = run.misses[0].clone();
            let case = "aabb@vertex-mean/own/1".to_owned();
            run.misses.push(crate::record::MissRow { case, missed: 1, missed_asked: 0, ..stray });
        });
        assert_eq!(run(&options(&before, &deep, false)).unwrap(), FAILED);
        assert_eq!(run(&options(&before, &deep, true)).unwrap(), FAILED);
        assert_eq!(run(&options(&deep, &before, false)).unwrap(), CLEAR, "fewer misses are none");
        let slower = folder(|run| run.timings.iter_mut().for_each(|row| row.ns *= 2));
        assert_eq!(run(&options(&before, &slower, false)).unwrap(), FAILED);
        assert_eq!(run(&Options { allow: vec![Gate::Slower], ..options(&before, &slower, false) }).unwrap(), CLEAR);
        assert_eq!(run(&options(&slower, &before, false)).unwrap(), CLEAR, "faster is none");
        assert!(run(&options(&before, &TempDir::new().unwrap(), false)).is_err());
    }

    /// Two runs without a common scene are not the same, and no gate lets the second through.
    #[test]
    fn nothing_compared_is_no_equality() {
        let [before, other] = [folder(|_| {}), folder(|_| {})];
        for entry in std::fs::read_dir(other.path()).unwrap() {
            let path = entry.unwrap().path();
            let text = std::fs::read_to_string(&path).unwrap();
            std::fs::write(&path, text.replace("lathe-", "mill-")).unwrap();
        }
        let comparison = compare_runs(before.path(), other.path()).unwrap();
        let text = text(&comparison, false);
        assert_eq!(text.matches(": nothing compared").count(), 5, "{text}");
        assert!(text.contains("lathe-tailstock: not compared, for the second run has no such scene\n"), "{text}");
        assert!(text.contains("mill-tailstock: not compared, for the first run has no such scene\n"), "{text}");
        let allowed = Options { allow: Gate::ALL.to_vec(), ..options(&before, &other, false) };
        assert_eq!(run(&allowed).unwrap(), FAILED);
    }

    #[test]
    fn the_text_names_what_changed_in_a_hundred_columns() {
        let before = folder(|_| {});
        let after = folder(|run| {
            run.timings.iter_mut().filter(|row| row.variant() == "dop-8").for_each(|row| row.ns *= 2);
            run.answers.iter_mut().filter(|row| row.case.starts_with("dop-8@")).for_each(|row| row.volume_tests += 1);
            run.trees.iter_mut().filter(|row| row.variant == "obb-vertex-symmetric").for_each(|row| row.bytes += 1);
        });
        let comparison = compare_runs(before.path(), after.path()).unwrap();
        let text = text(&comparison, true);
        assert!(text.contains("slower") && text.contains("3000000 3000001"), "{text}");
        let longest = text.lines().map(|line| line.chars().count()).max().unwrap();
        assert!(longest <= 100, "{longest}: {text}");
    }
}
