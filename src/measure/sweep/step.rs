//! The sweep of the path step: a body runs into contact along each line, sampled at equal distances from a random start.

use super::stage::{Bodies, Line};
use super::{GROUPS, Prepared, empty_row};
use crate::record::{Stratum, SweepRow};
use obbtree::cases::Draw;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Samples before first contact at most: what lies farther back is free for every variant alike.
const SAMPLES_BEFORE: u32 = 4;
/// A contact not reported this far past its beginning counts as missed, mm: deeper than any tool may ever get.
const GIVE_UP_MM: f64 = 20.0;

/// One row for each group of lines.
pub fn rows(sweep: &str, (case, a, b): &Prepared, stage: &Bodies, step_mm: f64, seed: u64) -> Vec<SweepRow> {
    let triangles = (stage.a.faces().len() + stage.b.faces().len()) as u64;
    let run = |line: &Line| {
        let mut row = empty_row(sweep, step_mm, case, triangles, line.number % GROUPS, Stratum::Colliding);
        // Where the samples fall is the same for every variant and, as a share of the step, for every step.
        let phase = Draw::new(seed, &["sweep", "phase"], u64::from(line.number)).unit();
        (row.poses, row.touching) = (1, 1);
        let samples = (0..).map(|i| step_mm * (phase + f64::from(i) - f64::from(SAMPLES_BEFORE)));
        for depth in samples.take_while(|depth| *depth <= GIVE_UP_MM) {
            let (verdict, counts) = a.first_counted(b.as_ref(), &line.at_depth(depth));
            row.queries += 1;
            row.volume_tests += counts.volume_tests;
            row.triangle_tests += counts.triangle_tests;
            if verdict {
                row.delay_mm = depth.max(0.0);
                return row;
            }
        }
        row.missed = 1;
        row
    };
    let runs: Vec<SweepRow> = stage.lines.par_iter().map(run).collect();
    let mut groups: BTreeMap<u32, SweepRow> = BTreeMap::new();
    for run in runs {
        let group = groups
            .entry(run.group)
            .or_insert_with(|| empty_row(sweep, step_mm, case, triangles, run.group, Stratum::Colliding));
        group.poses += run.poses;
        group.queries += run.queries;
        group.volume_tests += run.volume_tests;
        group.triangle_tests += run.triangle_tests;
        group.touching += run.touching;
        group.missed += run.missed;
        group.delay_mm += run.delay_mm;
    }
    groups.into_values().collect()
}
