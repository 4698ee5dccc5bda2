//! The sweep of the path step: a body moves into contact along each line, sampled at equal distances from a random start.

use super::stage::{Bodies, Line};
use super::{GROUPS, chunk_number};
use crate::measure::study::Subject;
use crate::record::{CountRow, Stratum};
use obbtree::cases::Draw;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Largest number of samples before first contact. Earlier samples are free for every variant.
const SAMPLES_BEFORE: u32 = 4;
/// Distance past its beginning, mm, after which an unreported contact counts as missed: deeper than any tool may ever go.
const GIVE_UP_MM: f64 = 20.0;

/// One row for each group of lines.
pub fn rows(scene: &str, subject: &Subject, stage: &Bodies, step_mm: f64, seed: u64) -> Vec<CountRow> {
    let case = subject.case.name();
    let (a, b) = (subject.models[&0].as_ref(), subject.models[&1].as_ref());
    let stratum = Stratum::Colliding;
    let empty = |chunk: u32| CountRow::new(scene, &case, chunk, Some(stratum));
    let run = |line: &Line| {
        let mut row = empty(chunk_number(line.number % GROUPS, stratum));
        // Where the samples fall is the same for every variant and, as a share of the step, for every step.
        let phase = Draw::new(seed, &["sweep", "phase"], u64::from(line.number)).unit();
        (row.poses, row.touching) = (1, 1);
        let samples = (0..).map(|i| step_mm * (phase + f64::from(i) - f64::from(SAMPLES_BEFORE)));
        for depth in samples.take_while(|depth| *depth <= GIVE_UP_MM) {
            let (verdict, counts) = a.first_counted(b, &line.at_depth(depth));
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
    let runs: Vec<CountRow> = stage.lines.par_iter().map(run).collect();
    let mut groups: BTreeMap<u32, CountRow> = BTreeMap::new();
    for run in runs {
        groups.entry(run.chunk).or_insert_with(|| empty(run.chunk)).add(&run);
    }
    groups.into_values().collect()
}
