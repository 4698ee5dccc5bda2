//! Every engine and volume against all pairs of triangles in integers, on seeded cases; and the seeds of the fuzz targets, with whatever once
//! made one of them fail.
//!
//! A wrong answer is told with its seed and number. To make that case again:
//!
//! ```text
//! DIFFERENTIAL_SEED=1 DIFFERENTIAL_FIRST=4711 DIFFERENTIAL_CASES=1 cargo test --release --test fuzz -- --ignored --nocapture
//! ```
//!
//! The same command with another number of cases is the long form; `DIFFERENTIAL_FIRST` continues where another run ended.

#![allow(clippy::print_stdout, reason = "the long form tells how far it is, and the corpus which seed is at fault")]

#[path = "../fuzz/src/lib.rs"]
mod targets;

use bvbench::registry;
use rayon::prelude::*;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;
use targets::engines::{Choices, Tally, check};

/// Variants of the registry that each case asks, besides all wide trees.
const VARIANTS: usize = 2;

/// Runs the cases of a seed on all threads; what was asked, and what went wrong, in order.
fn run(seed: u64, cases: Range<u64>) -> (Tally, Vec<String>) {
    let registry = registry::standard();
    let one = |number: u64| match check(&mut Choices::new(&[], seed, number), &registry, VARIANTS) {
        Ok(tally) => (tally, Vec::new()),
        Err(mismatch) => (Tally::default(), vec![format!("seed {seed}, case {number}: {mismatch}")]),
    };
    cases.into_par_iter().map(one).reduce(Default::default, |(tally, mut wrong), (more, others)| {
        wrong.extend(others);
        (tally + more, wrong)
    })
}

fn told(wrong: &[String]) -> String {
    let shown: Vec<&str> = wrong.iter().take(10).map(String::as_str).collect();
    format!("{} wrong, the first of them:\n{}", wrong.len(), shown.join("\n"))
}

#[test]
fn every_engine_says_what_the_integers_say() {
    let (tally, wrong) = run(1, 0..1000);
    assert!(wrong.is_empty(), "{}", told(&wrong));
    assert!(tally.touching > tally.poses / 5 && tally.touching < tally.poses, "{tally:?}");
    assert!(tally.path_touching > tally.path_poses / 10 && tally.path_touching < tally.path_poses, "{tally:?}");
}

/// As many cases as `DIFFERENTIAL_CASES` asks for, from `DIFFERENTIAL_FIRST` on, of `DIFFERENTIAL_SEED`.
#[test]
#[ignore = "the long form: as many cases as are asked for"]
fn as_many_cases_as_asked() {
    /// Cases between two lines of progress.
    const PIECE: u64 = 20_000;
    let asked = |name: &str, default: u64| {
        let text = std::env::var(name).unwrap_or_default();
        if text.is_empty() { default } else { text.parse().unwrap_or_else(|_| panic!("{name}={text} is not a number")) }
    };
    let (seed, first) = (asked("DIFFERENTIAL_SEED", 1), asked("DIFFERENTIAL_FIRST", 0));
    let end = first + asked("DIFFERENTIAL_CASES", 20_000);
    let (start, mut total, mut wrong) = (Instant::now(), Tally::default(), Vec::new());
    for from in (first..end).step_by(PIECE as usize) {
        let to = end.min(from + PIECE);
        let (tally, more) = run(seed, from..to);
        more.iter().for_each(|line| println!("{line}"));
        (total, wrong) = (total + tally, [wrong, more].concat());
        let Tally { cases, poses, touching, path_poses, path_touching, questions } = total;
        println!(
            "seed {seed}, cases {first} to {to}: {:.0} s, {cases} right, {} wrong; {poses} poses ({touching} touching), {path_poses} poses of paths \
             ({path_touching} touching), {questions} questions",
            start.elapsed().as_secs_f64(),
            wrong.len()
        );
    }
    assert!(wrong.is_empty(), "{}", told(&wrong));
}

#[test]
fn every_target_survives_its_corpus() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    for (target, _) in targets::TARGETS {
        let folder = corpus.join(target);
        let mut files: Vec<_> = std::fs::read_dir(&folder)
            .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
            .map(|entry| entry.expect("an entry of the corpus can be read").path())
            .collect();
        files.sort();
        assert!(!files.is_empty(), "{} is empty", folder.display());
        for file in files {
            let bytes = std::fs::read(&file).expect("a seed can be read");
            println!("{}", file.display());
            targets::run(target, &bytes);
        }
    }
}
